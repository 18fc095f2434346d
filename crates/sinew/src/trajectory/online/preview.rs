use crate::error::{Error, positive};
use crate::trajectory::Reference;
use alloc::vec;
use alloc::vec::Vec;

/// A delay by the preview horizon: what was put in last is the previewed reference, what was put in a horizon
/// before is the current one. So reversals of a reference that is not known ahead are previewed exactly.
#[derive(Debug, Clone)]
pub struct Preview {
    held: Vec<Reference>,
    next: usize,
}

impl Preview {
    /// At rest in a pose; `horizon` and the period `h` are in s.
    ///
    /// # Errors
    /// [`Error::OutOfDomain`] for a horizon or period that is not positive.
    pub fn new(horizon: f64, h: f64, pose: &[f64]) -> Result<Self, Error> {
        let steps = libm::round(positive("horizon", horizon)? / positive("period", h)?).max(1.0);
        let resting = Reference { q: pose.to_vec(), ..Reference::new(pose.len()) };
        Ok(Self { held: vec![resting; steps as usize], next: 0 })
    }

    /// At rest in a pose, all along the horizon: `[joints]`.
    pub fn rest_at(&mut self, pose: &[f64]) {
        for held in &mut self.held {
            held.q.copy_from_slice(pose);
            held.v.fill(0.0);
            held.a.fill(0.0);
        }
    }

    /// Takes the newest reference and writes the one a horizon before it. Nothing is allocated.
    pub fn step(&mut self, newest: &Reference, current: &mut Reference) {
        let slot = &mut self.held[self.next];
        copy(slot, current);
        copy(newest, slot);
        self.next = (self.next + 1) % self.held.len();
    }
}

/// Without allocation.
pub(super) fn copy(from: &Reference, to: &mut Reference) {
    to.q.copy_from_slice(&from.q);
    to.v.copy_from_slice(&from.v);
    to.a.copy_from_slice(&from.a);
}

#[cfg(test)]
mod tests {
    use super::*;

    #[test]
    fn the_current_reference_is_the_one_a_horizon_before() {
        let mut preview = Preview::new(0.12, 1e-3, &[5.0]).unwrap();
        let (mut newest, mut current) = (Reference::new(1), Reference::new(1));
        for k in 0..500 {
            newest.q[0] = f64::from(k);
            preview.step(&newest, &mut current);
            let expected = if k < 120 { 5.0 } else { f64::from(k - 120) };
            assert_eq!(current.q[0].to_bits(), expected.to_bits());
        }
    }
}
