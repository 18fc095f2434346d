//! From the tension wanted at the anchor to what the drive is told.

use super::stretch::{FarEndReference, StretchController, direction};
use crate::Error;
use crate::drive::DriveCommand;
use crate::predictor::{CableModel, CableObserver, CableSample};
use crate::transmission::Perceptron;
use alloc::boxed::Box;

/// A way from a [`FarEndReference`] to the drive, and from what the drive feels to the far end.
#[derive(Debug, Clone)]
pub enum Compensation {
    /// None: the drive pulls with what is wanted at the anchor.
    None,
    /// Eqs. 7 and 8 with the sign of the reference: one angle and the pretension.
    Capstan {
        /// `mu phi - ln eta`.
        friction_angle: f64,
        /// N.
        pretension: f64,
    },
    /// The paper's networks (17).
    Network(Box<NetworkCompensation>),
    /// The observer, and the stretch of its law.
    Observer(Box<ObserverCompensation>),
}

/// What a compensation says after a sample.
#[derive(Debug, Clone, Copy, PartialEq)]
pub struct Answer {
    /// For the drive.
    pub command: DriveCommand,
    /// What it believes of the tension at the anchor, N.
    pub far: f64,
    /// What it believes of the elongation, m; NaN where it believes nothing.
    pub stretch: f64,
}

impl Compensation {
    /// Takes a sample, `interval` seconds after the one before, and answers.
    pub fn answer(&mut self, interval: f64, wish: &FarEndReference, sample: &CableSample) -> Answer {
        let (near, velocity) = (sample.tension_in, wish.velocity);
        let (tension, far) = match self {
            Self::Observer(observer) => return observer.answer(interval, wish, sample),
            Self::None => (wish.tension_out, near),
            Self::Capstan { friction_angle, pretension } => {
                let factor = libm::exp(direction(velocity) * *friction_angle);
                (((wish.tension_out - *pretension) * factor).max(0.0), near / factor + *pretension)
            }
            Self::Network(networks) => (
                wish.tension_out + networks.friction.evaluate(&[wish.tension_out, velocity]).unwrap_or(0.0),
                near - networks.loss.evaluate(&[near, velocity]).unwrap_or(0.0),
            ),
        };
        Answer { command: DriveCommand::Tension { tension, feed: velocity }, far, stretch: f64::NAN }
    }
}

/// The paper's network (17), once for the command and once for the estimate; bend and length of the sheath are constant.
#[derive(Debug, Clone)]
pub struct NetworkCompensation {
    /// From far tension, N, and speed, m/s, to what friction takes on the way, N.
    pub friction: Perceptron,
    /// From near tension, N, and speed, m/s, to the same.
    pub loss: Perceptron,
}

/// The observer tells the stretch, the winch follows the wanted one: [`StretchController`].
#[derive(Debug, Clone)]
pub struct ObserverCompensation {
    observer: CableObserver,
    follower: StretchController,
}

impl ObserverCompensation {
    /// A compensation by what was identified.
    ///
    /// # Errors
    /// As [`CableModel::law`].
    pub fn new(model: &CableModel) -> Result<Self, Error> {
        Ok(Self { observer: CableObserver::new(model)?, follower: StretchController::new(model.law()?) })
    }

    fn answer(&mut self, interval: f64, wish: &FarEndReference, sample: &CableSample) -> Answer {
        let estimate = self.observer.step(interval, sample);
        let speed = self.follower.speed(interval, wish, estimate.stretch, estimate.drag_factor);
        Answer { command: DriveCommand::Velocity(speed), far: estimate.far, stretch: estimate.stretch }
    }
}
