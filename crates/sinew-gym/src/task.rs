use crate::settings::within;
use sinew::Error;
use sinew::trajectory::Trajectory;
use std::sync::Arc;

/// What an agent is rewarded for.
#[derive(Debug, Clone)]
pub enum Task {
    /// A pose, or the position of the end point in it, that is sampled at every reset.
    Reach,
    /// A motion; where it is closed, from a random time on and again and again.
    Track(Arc<Trajectory>),
    /// The initial pose, while something pushes the joints now and then.
    Hold {
        /// Largest push, as a fraction of the torque or force that the strongest muscle of a joint can exert
        /// on it in the machine's start, 0 to 1.
        push: f64,
    },
}

impl Task {
    /// Checks it for a machine of this many independent joints.
    ///
    /// # Errors
    /// [`Error::WrongLength`] for a trajectory of another machine, [`Error::OutOfDomain`] for a push.
    pub(crate) fn validate(&self, joints: usize) -> Result<(), Error> {
        match self {
            Self::Reach => Ok(()),
            Self::Track(trajectory) if trajectory.joints() != joints => {
                let got = trajectory.joints();
                Err(Error::WrongLength { name: "joints of the trajectory", expected: joints, got })
            }
            Self::Track(_) => Ok(()),
            Self::Hold { push } => {
                within("push", "a fraction from 0 to 1", *push, (0.0..=1.0).contains(push))
            }
        }
    }

    /// Whether the pose that is desired moves.
    pub(crate) fn moves(&self) -> bool {
        matches!(self, Self::Track(_))
    }
}
