use crate::Error;
use crate::predictor::{CableEstimate, CableModel, CableObservers, CableSample};
use alloc::vec;
use alloc::vec::Vec;

/// Observers of all cables that get no load cells: copies of the corrected ones, made one to two seconds ago.
///
/// A corrected observer follows its load cell, true or false. What a copy says since it was made depends on
/// the encoders and the law alone, so that the difference is the error of a sensor or of the law. Two copies
/// are made anew alternately, and the older one is compared: it always remembers at least [`RENEWAL`].
///
/// # Source
/// A bank of observers, each without one of the sensors: `clark1978`.
#[derive(Debug, Clone)]
pub(super) struct OpenLoopCables {
    copies: [Copied; 2],
    /// The copy that is compared.
    used: usize,
    /// Time since the last renewal, s.
    since_renewal: f64,
    samples: Vec<CableSample>,
    estimates: Vec<CableEstimate>,
    profile: Vec<f64>,
}

/// A copy with what was estimated beside it when it was made.
#[derive(Debug, Clone)]
pub(super) struct Copied {
    observers: CableObservers,
    /// Whether it has been made at all.
    made: bool,
    /// Time since its last step, s.
    unstepped: f64,
    /// Travel by which the load cells had corrected the winches, m: `[muscles]`.
    pub(super) unexplained: Vec<f64>,
    /// Estimated coordinates, rad or m: `[joints]`.
    pub(super) pose: Vec<f64>,
    /// Torque of the disturbances, Nm or N: `[joints]`.
    pub(super) disturbance_torque: Vec<f64>,
    /// Tension at every drive's outlet, N, without the load cells: `[muscles]`.
    pub(super) tension_in: Vec<f64>,
    /// Tension at every anchor, N, without them.
    pub(super) tension_out: Vec<f64>,
}

/// s: time after which the older copy is made anew.
const RENEWAL: f64 = 1.0;
/// s: longest interval between two steps of a copy where cycles are shorter; an observer bridges 20 ms. A
/// second copy may have to wait for one short cycle.
const LONGEST_INTERVAL: f64 = 0.0165;
/// s: control cycles from which on both copies may step in the same one.
const SHORT_CYCLE: f64 = 0.003;

/// State of the corrected observers from which a copy is made.
#[derive(Debug, Clone, Copy)]
pub(super) struct Corrected<'a> {
    pub(super) observers: &'a CableObservers,
    pub(super) unexplained: &'a [f64],
    pub(super) pose: &'a [f64],
    pub(super) disturbance_torque: &'a [f64],
}

impl OpenLoopCables {
    /// # Errors
    /// As [`CableObservers::new`].
    pub(super) fn new(models: &[CableModel], joints: usize) -> Result<Self, Error> {
        let observers = CableObservers::new(models)?;
        let m = models.len();
        let copied = Copied {
            made: false,
            unstepped: 0.0,
            unexplained: vec![0.0; m],
            pose: vec![0.0; joints],
            disturbance_torque: vec![0.0; joints],
            tension_in: vec![0.0; m],
            tension_out: vec![0.0; m],
            observers,
        };
        Ok(Self {
            profile: vec![0.0; copied.observers.cables().state_len()],
            copies: [copied.clone(), copied],
            used: 0,
            since_renewal: 0.0,
            samples: vec![CableSample::default(); m],
            estimates: vec![CableEstimate::default(); m],
        })
    }

    /// There are no copies any more.
    pub(super) fn restart(&mut self) {
        self.copies.iter_mut().for_each(|copy| copy.made = false);
        self.since_renewal = 0.0;
    }

    /// The copy that is compared, once there is one that is old enough.
    pub(super) fn used(&self) -> Option<&Copied> {
        Some(&self.copies[self.used]).filter(|copy| copy.made)
    }

    /// Sets the wrap angle at a pulley of a cable, as [`CableObservers::set_wrap`].
    pub(super) fn set_wrap(&mut self, cable: usize, pulley: usize, wrap: f64) -> Result<(), Error> {
        self.copies.iter_mut().try_for_each(|copy| copy.observers.set_wrap(cable, pulley, wrap))
    }

    /// Sets the bend of a cable's sheath, as [`CableObservers::set_sheath_bend`].
    pub(super) fn set_sheath_bend(&mut self, cable: usize, bend: f64) -> Result<(), Error> {
        self.copies.iter_mut().try_for_each(|copy| copy.observers.set_sheath_bend(cable, bend))
    }

    /// One cycle of `h` s with the positions of `samples`, whose tensions are not looked at. Returns whether
    /// the copy that is compared has stepped to them. While `renewing`, the older copy is made anew from the
    /// corrected observers every [`RENEWAL`].
    pub(super) fn step(
        &mut self,
        h: f64,
        samples: &[CableSample],
        corrected: &Corrected<'_>,
        renewing: bool,
    ) -> Result<bool, Error> {
        self.since_renewal += h;
        if renewing && self.since_renewal >= RENEWAL {
            self.since_renewal = 0.0;
            self.copies[self.used].renew(corrected, &mut self.profile)?;
            self.used = 1 - self.used;
        }
        self.copies.iter_mut().for_each(|copy| copy.unstepped += h);
        let mut used_stepped = false;
        // One in a cycle, unless cycles are long.
        let at_most = if h < SHORT_CYCLE { 1 } else { 2 };
        for _ in 0..at_most {
            let older = usize::from(self.copies[1].unstepped > self.copies[0].unstepped);
            if self.copies[older].unstepped + h < LONGEST_INTERVAL {
                break;
            }
            used_stepped |= older == self.used;
            self.step_copy(older, samples)?;
        }
        Ok(used_stepped)
    }

    fn step_copy(&mut self, number: usize, samples: &[CableSample]) -> Result<(), Error> {
        let copy = &mut self.copies[number];
        let interval = core::mem::take(&mut copy.unstepped);
        if !copy.made {
            return Ok(());
        }
        for (own, sample) in self.samples.iter_mut().zip(samples) {
            *own = CableSample { tension_in: f64::NAN, ..*sample };
        }
        copy.observers.step(interval, &self.samples, &mut self.estimates)?;
        let tensions = copy.tension_in.iter_mut().zip(&mut copy.tension_out);
        for (estimate, (near, far)) in self.estimates.iter().zip(tensions) {
            (*near, *far) = (estimate.tension_in, estimate.tension_out);
        }
        Ok(())
    }

    /// Gives a corrected observer the state that it would have without its load cell since the copy was made.
    pub(super) fn correct(&mut self, cable: usize, observers: &mut CableObservers) -> Result<(), Error> {
        observers.copy_cable(cable, &self.copies[self.used].observers, &mut self.profile)
    }
}

impl Copied {
    fn renew(&mut self, from: &Corrected<'_>, profile: &mut [f64]) -> Result<(), Error> {
        for cable in 0..self.unexplained.len() {
            self.observers.copy_cable(cable, from.observers, profile)?;
        }
        self.unexplained.copy_from_slice(from.unexplained);
        self.pose.copy_from_slice(from.pose);
        self.disturbance_torque.copy_from_slice(from.disturbance_torque);
        (self.made, self.unstepped) = (true, 0.0);
        Ok(())
    }
}

#[cfg(test)]
mod tests;
