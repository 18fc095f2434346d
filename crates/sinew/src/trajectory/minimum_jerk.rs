use super::reference::Reference;
use super::time_law::{curvature, quintic, slope};
use crate::error::{Error, finite, positive};
use alloc::vec::Vec;

/// Minimum-jerk motion between two poses along a straight line in joint space.
///
/// ```text
/// q = q_0 + (q_1 - q_0) u(t/T),     u(x) = 10 x^3 - 15 x^4 + 6 x^5
/// ```
///
/// # Source
/// `flash1985`: the motion of least mean square jerk in that time.
#[derive(Debug, Clone, PartialEq)]
pub struct MinimumJerk {
    pub(super) from: Vec<f64>,
    pub(super) to: Vec<f64>,
    pub(super) duration: f64,
}

impl MinimumJerk {
    /// From a pose to a pose in `duration` seconds.
    ///
    /// # Errors
    /// [`Error::WrongLength`] for poses of different robots, [`Error::OutOfDomain`] for a pose that is not
    /// finite or a duration that is not positive.
    pub fn new(from: &[f64], to: &[f64], duration: f64) -> Result<Self, Error> {
        if from.len() != to.len() {
            return Err(Error::WrongLength { name: "to", expected: from.len(), got: to.len() });
        }
        from.iter().chain(to).try_for_each(|&q| finite("pose", q).map(drop))?;
        positive("duration", duration)?;
        Ok(Self { from: from.to_vec(), to: to.to_vec(), duration })
    }

    pub(super) fn sample(&self, time: f64, out: &mut Reference) {
        let x = if time > 0.0 { (time / self.duration).min(1.0) } else { 0.0 };
        let t = self.duration;
        let [p, v, a] = [quintic(x), slope(x) / t, curvature(x) / (t * t)];
        for (k, (from, to)) in self.from.iter().zip(&self.to).enumerate().take(out.q.len()) {
            let span = to - from;
            (out.q[k], out.v[k], out.a[k]) = (from + span * p, span * v, span * a);
        }
    }
}
