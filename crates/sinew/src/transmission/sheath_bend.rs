use crate::error::{Error, check_length, finite, non_negative, within};
use alloc::vec::Vec;

/// Bend of a sheath that passes joints.
///
/// ```text
/// phi(q) = clip(phi_0 + sum_j b_j (q_j - q_j0), 0, 4 pi)
/// ```
///
/// | symbol | argument    | unit               | domain    | meaning                                          |
/// |--------|-------------|--------------------|-----------|--------------------------------------------------|
/// | phi_0  | `bend`      | rad                | >= 0      | sum of the magnitudes of the bends at `q_0`        |
/// | b_j    | `slopes`    | rad/rad or rad/m   | finite    | change of the bend with a joint                    |
/// | q_0    | `reference` | rad or m           | finite    | pose in which the bend is `phi_0`                  |
/// | q      | `pose`      | rad or m           | finite    | coordinates of the independent joints              |
///
/// # Shapes
/// `slopes`, `reference`: `[joints]`; both empty for a sheath that passes no joint.
///
/// # Assumes
/// A sheath whose curvature keeps one sign where it passes a joint, so that its bend is linear in the joint's
/// coordinate; the change is spread over the sheath as the bend itself is. A node of a cable bears no more
/// than two turns.
///
/// # Example
/// ```
/// use sinew::transmission::SheathBend;
/// let bend = SheathBend::new(1.6, vec![0.5, 0.0], vec![0.2, 1.0])?;
/// assert!((bend.at(&[0.6, 0.3]) - 1.8).abs() < 1e-12);
/// assert_eq!(bend.at(&[-9.0, 0.3]), 0.0);
/// # Ok::<(), sinew::Error>(())
/// ```
///
/// # Source
/// Our own; first order in the pose.
#[derive(Debug, Clone, PartialEq)]
pub struct SheathBend {
    bend: f64,
    slopes: Vec<f64>,
    reference: Vec<f64>,
}

impl SheathBend {
    /// Largest bend that depends on the pose, rad.
    pub const LARGEST: f64 = 4.0 * core::f64::consts::PI;

    /// A sheath of checked numbers.
    ///
    /// # Errors
    /// [`Error::OutOfDomain`] names the argument, [`Error::WrongLength`] for slopes and reference of
    /// different lengths.
    pub fn new(bend: f64, slopes: Vec<f64>, reference: Vec<f64>) -> Result<Self, Error> {
        non_negative("sheath bend", bend)?;
        check_length("reference", reference.len(), slopes.len())?;
        for slope in &slopes {
            finite("bend by joint", *slope)?;
        }
        for coordinate in &reference {
            finite("reference", *coordinate)?;
        }
        let sheath = Self { bend, slopes, reference };
        let expected = "at most 4 pi where the bend depends on the pose";
        within("sheath bend", expected, bend, sheath.is_constant() || bend <= Self::LARGEST)?;
        Ok(sheath)
    }

    /// Whether the bend is the same in every pose.
    #[must_use]
    pub fn is_constant(&self) -> bool {
        self.slopes.iter().all(|slope| *slope == 0.0)
    }

    /// The bend in a pose, rad; coordinates that the pose does not have count as those of the reference.
    #[must_use]
    pub fn at(&self, pose: &[f64]) -> f64 {
        if self.is_constant() { self.bend } else { self.unclipped(pose).clamp(0.0, Self::LARGEST) }
    }

    /// The largest bend over these ranges of the joints, rad, before it is clipped.
    #[must_use]
    pub fn largest(&self, ranges: &[[f64; 2]]) -> f64 {
        let corners = self.slopes.iter().zip(ranges);
        let corner: Vec<f64> =
            corners.map(|(slope, [low, high])| if *slope < 0.0 { *low } else { *high }).collect();
        self.unclipped(&corner)
    }

    /// The same sheath where its bend at the reference was found to be `bend`, rad: every bend is scaled
    /// alike, and with it the friction angle that was identified at the reference. A sheath that is straight
    /// there stays as it is.
    ///
    /// # Errors
    /// As [`new`](Self::new).
    pub fn scaled_to(&self, bend: f64) -> Result<Self, Error> {
        if self.bend == 0.0 {
            return Ok(self.clone());
        }
        let factor = non_negative("sheath bend", bend)? / self.bend;
        Self::new(bend, self.slopes.iter().map(|slope| factor * slope).collect(), self.reference.clone())
    }

    /// The same with every slope multiplied by a factor, for specimens: `[joints]` factors from `draw`.
    ///
    /// # Errors
    /// As [`new`](Self::new).
    pub fn with_slopes(&self, mut draw: impl FnMut() -> f64) -> Result<Self, Error> {
        let slopes = self.slopes.iter().map(|slope| slope * draw()).collect();
        Self::new(self.bend, slopes, self.reference.clone())
    }

    fn unclipped(&self, pose: &[f64]) -> f64 {
        let joints = self.slopes.iter().zip(&self.reference).zip(pose);
        joints.fold(self.bend, |bend, ((slope, reference), q)| bend + slope * (q - reference))
    }
}

#[cfg(test)]
mod tests {
    use super::*;
    use alloc::vec;

    #[test]
    fn the_bend_is_linear_in_the_pose_between_straight_and_two_turns() {
        let bend = SheathBend::new(1.0, vec![0.5, -2.0], vec![0.1, 0.2]).unwrap();
        assert!((bend.at(&[0.1, 0.2]) - 1.0).abs() < 1e-15 && (bend.at(&[0.5, 0.1]) - 1.4).abs() < 1e-12);
        assert!(bend.at(&[0.1, 9.0]) == 0.0 && bend.at(&[0.1, -99.0]) == SheathBend::LARGEST);
        assert!((bend.largest(&[[-1.0, 1.1], [0.0, 1.0]]) - 1.9).abs() < 1e-12);
        let constant = SheathBend::new(20.0, vec![], vec![]).unwrap();
        assert!(constant.is_constant() && (constant.at(&[3.0]) - 20.0).abs() < 1e-15);
    }

    #[test]
    fn an_identified_bend_scales_every_pose_alike() {
        let bend = SheathBend::new(2.0, vec![0.5], vec![0.0]).unwrap();
        let identified = bend.scaled_to(3.0).unwrap();
        for q in [-1.0, 0.0, 0.7] {
            assert!((identified.at(&[q]) / bend.at(&[q]) - 1.5).abs() < 1e-12);
        }
        let straight = SheathBend::new(0.0, vec![0.5], vec![0.0]).unwrap();
        assert_eq!(straight.scaled_to(1.0).unwrap(), straight);
    }

    #[test]
    fn numbers_out_of_their_domain_are_refused() {
        for (bend, slope, reference) in [
            (-1.0, 0.1, 0.0),
            (f64::NAN, 0.1, 0.0),
            (1.0, f64::INFINITY, 0.0),
            (1.0, 0.1, f64::NAN),
            (13.0, 0.1, 0.0),
        ] {
            assert!(SheathBend::new(bend, vec![slope], vec![reference]).is_err());
        }
        assert!(SheathBend::new(1.0, vec![0.1], vec![]).is_err());
    }

    #[test]
    fn slopes_of_a_specimen_are_multiples_of_the_designed_ones() {
        let bend = SheathBend::new(1.0, vec![0.5, -0.2], vec![0.1, 0.2]).unwrap();
        let mut factors = [1.5, 3.0].into_iter();
        let specimen = bend.with_slopes(|| factors.next().unwrap()).unwrap();
        assert!((specimen.at(&[1.1, 1.2]) - (1.0 + 0.75 - 0.6)).abs() < 1e-15);
        assert!((specimen.at(&[0.1, 0.2]) - 1.0).abs() < 1e-15);
    }
}
