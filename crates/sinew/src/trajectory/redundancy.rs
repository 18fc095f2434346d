use crate::body::Robot;
use crate::error::{Error, finite, positive, within};
use alloc::vec;
use alloc::vec::Vec;

/// Redundancy resolution: the pose on the path that is closest to a preferred one.
///
/// ```text
/// q(th) = argmin 1/2 (q - r)^T W (q - r)   so that   p(q) = p(th),  low <= q <= high,    r(th) = rest + swing sin th
/// ```
///
/// `q` are the coordinates of the independent joints, `p` those of the end point that the task contains.
///
/// | symbol | field     | unit     | domain | meaning                                         |
/// |--------|-----------|----------|--------|-------------------------------------------------|
/// | r      | `rest`, `swing` | rad or m | finite | preferred pose, and how it swings once per turn |
/// | W      | `weight`  | 1        | > 0    | weight of each joint's deviation from it         |
/// | low, high |        | rad or m |        | ranges of the joints, also of those that follow them |
///
/// The pose is a function of the phase alone: it does not drift, and is periodic where the path is closed.
///
/// # Assumes
/// Hinges and slides only.
///
/// # Source
/// `whitney1969` for the weighted pseudo-inverse; solving for a pose instead of integrating velocities is
/// ours.
#[derive(Debug, Clone, PartialEq)]
pub struct Redundancy {
    /// `rest` of every joint, rad or m.
    pub rest: Vec<f64>,
    /// `swing` of every joint, rad or m.
    pub swing: Vec<f64>,
    /// `W` of every joint.
    pub weight: Vec<f64>,
}

impl Redundancy {
    /// Closest to a pose, all joints weighted alike.
    #[must_use]
    pub fn near(rest: &[f64]) -> Self {
        Self { rest: rest.to_vec(), swing: vec![0.0; rest.len()], weight: vec![1.0; rest.len()] }
    }

    /// Checks the numbers for a robot.
    ///
    /// # Errors
    /// [`Error::WrongLength`] or [`Error::OutOfDomain`] names the field; robots with ball or free joints
    /// are not supported.
    pub fn validate(&self, robot: &Robot) -> Result<(), Error> {
        let joints = robot.independent_joints().len();
        let plain = robot.nq() == robot.nv();
        within("joints", "hinges and slides", robot.nq() as f64, plain && joints > 0)?;
        for (name, part) in [("rest", &self.rest), ("swing", &self.swing), ("weight", &self.weight)] {
            if part.len() != joints {
                return Err(Error::WrongLength { name, expected: joints, got: part.len() });
            }
        }
        self.rest.iter().try_for_each(|&r| finite("rest", r).map(drop))?;
        self.swing.iter().try_for_each(|&r| finite("swing", r).map(drop))?;
        self.weight.iter().try_for_each(|&w| positive("weight", w).map(drop))
    }

    /// `r` of a joint at a phase.
    pub(super) fn preferred(&self, joint: usize, sine: f64) -> f64 {
        self.rest[joint] + self.swing[joint] * sine
    }
}
