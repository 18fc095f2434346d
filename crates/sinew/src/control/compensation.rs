//! From the desired tension at the anchor to the command of the drive.

use super::inverse::InverseCompensation;
use super::stretch::{FarEndReference, StretchController, direction};
use crate::Error;
use crate::drive::DriveCommand;
use crate::predictor::{CableModel, CableObserver, CableSample};
use crate::transmission::{Perceptron, SheathLaw};
use alloc::boxed::Box;

/// A method of compensation: from a [`FarEndReference`] to the drive's command, and from the near end's
/// measurements to an estimate of the far end.
#[derive(Debug, Clone)]
pub enum Compensation {
    /// No compensation: the drive's tension is the tension desired at the anchor.
    None,
    /// The sheath's law (7) and its inverse (8), in the direction of the reference.
    Capstan(CapstanCompensation),
    /// The networks of (17).
    Network(Box<NetworkCompensation>),
    /// The cable's observer with the stretch controller of its law.
    Observer(Box<ObserverCompensation>),
    /// The inverse of an identified model.
    Inverse(Box<InverseCompensation>),
}

/// Command and estimates of a compensation after a sample.
#[derive(Debug, Clone, Copy, PartialEq)]
pub struct CompensationOutput {
    /// Command for the drive.
    pub command: DriveCommand,
    /// Estimated tension at the anchor as a sensor there reads it, N; NaN where it needs a tension that was
    /// not measured.
    pub tension_out: f64,
    /// Estimated elongation, m; NaN where the method has no estimate.
    pub stretch: f64,
}

impl Compensation {
    /// One control cycle with a sample `interval` seconds after the one before.
    ///
    /// # Errors
    /// [`Error::OutOfDomain`] for references that are not finite.
    pub fn step(
        &mut self,
        interval: f64,
        reference: &FarEndReference,
        sample: &CableSample,
    ) -> Result<CompensationOutput, Error> {
        let near = sample.tension_in;
        let (tension, tension_out) = match self {
            Self::Observer(observer) => return observer.step(interval, reference, sample),
            Self::Inverse(inverse) => {
                let (command, tension_out) = inverse.step(interval, reference, sample);
                return Ok(CompensationOutput { command, tension_out, stretch: f64::NAN });
            }
            Self::None => (reference.tension_out, near),
            Self::Capstan(capstan) => (
                capstan.drive_tension(reference)?,
                measured(near, |near| capstan.far_tension(near, reference.velocity))?,
            ),
            Self::Network(networks) => (
                networks.drive_tension(reference)?,
                measured(near, |near| networks.far_tension(near, reference.velocity))?,
            ),
        };
        let command = DriveCommand::Tension { tension, feed: reference.velocity };
        Ok(CompensationOutput { command, tension_out, stretch: f64::NAN })
    }
}

/// An estimate from the near tension, N; NaN where it was not measured.
fn measured(near: f64, estimate: impl FnOnce(f64) -> Result<f64, Error>) -> Result<f64, Error> {
    if near.is_finite() { estimate(near) } else { Ok(f64::NAN) }
}

/// Compensation by a [`SheathLaw`] of constant wrap angle.
#[derive(Debug, Clone, Copy, PartialEq)]
pub struct CapstanCompensation {
    sheath: SheathLaw,
    wrap_angle: f64,
    pretension: f64,
}

impl CapstanCompensation {
    /// From the identified friction angle `mu phi - ln(eta)`, 1, and pretension `T_0`, N.
    ///
    /// # Errors
    /// [`Error::OutOfDomain`] unless both are finite and >= 0.
    pub fn new(friction_angle: f64, pretension: f64) -> Result<Self, Error> {
        // Only the sum of friction and efficiency is identified: mu = 1 and eta = 1 over an angle of its
        // value.
        let sheath = SheathLaw::new(1.0, 1.0, pretension)?;
        let capstan = Self { sheath, wrap_angle: friction_angle, pretension };
        capstan.far_tension(0.0, 0.0)?;
        Ok(capstan)
    }

    /// (8); below `T_0` the drive's tension is zero.
    fn drive_tension(&self, reference: &FarEndReference) -> Result<f64, Error> {
        let reachable = reference.tension_out.max(self.pretension);
        self.sheath.tension_in(reachable, self.wrap_angle, direction(reference.velocity))
    }

    /// (7); noise below zero tension counts as zero.
    fn far_tension(&self, near: f64, velocity: f64) -> Result<f64, Error> {
        self.sheath.tension_out(near.max(0.0), self.wrap_angle, direction(velocity))
    }
}

/// The network of (17), once for the command and once for the estimate; bend and length of the sheath are
/// constant.
#[derive(Debug, Clone)]
pub struct NetworkCompensation {
    friction_from_far: Perceptron,
    friction_from_near: Perceptron,
}

impl NetworkCompensation {
    /// Inputs of both networks: tension, N, and speed of the cable, m/s, + toward the motor.
    pub const INPUTS: usize = 2;

    /// Two networks of the friction force `T_in - T_out`, N: from the far tension and from the near tension.
    ///
    /// # Errors
    /// [`Error::WrongLength`] unless both have [`INPUTS`](Self::INPUTS).
    pub fn new(friction_from_far: Perceptron, friction_from_near: Perceptron) -> Result<Self, Error> {
        for network in [&friction_from_far, &friction_from_near] {
            let (expected, got) = (Self::INPUTS, network.inputs());
            if got != expected {
                return Err(Error::WrongLength { name: "inputs of a friction network", expected, got });
            }
        }
        Ok(Self { friction_from_far, friction_from_near })
    }

    fn drive_tension(&self, reference: &FarEndReference) -> Result<f64, Error> {
        let far = reference.tension_out;
        Ok(far + self.friction_from_far.evaluate(&[far, reference.velocity])?)
    }

    fn far_tension(&self, near: f64, velocity: f64) -> Result<f64, Error> {
        Ok(near - self.friction_from_near.evaluate(&[near, velocity])?)
    }
}

/// The cable's observer estimates the stretch, a [`StretchController`] controls it.
#[derive(Debug, Clone)]
pub struct ObserverCompensation {
    observer: CableObserver,
    controller: StretchController,
}

impl ObserverCompensation {
    /// From an identified model.
    ///
    /// # Errors
    /// As [`CableModel::law`].
    pub fn new(model: &CableModel) -> Result<Self, Error> {
        Ok(Self { observer: CableObserver::new(model)?, controller: StretchController::new(model.law()?) })
    }

    fn step(
        &mut self,
        interval: f64,
        reference: &FarEndReference,
        sample: &CableSample,
    ) -> Result<CompensationOutput, Error> {
        let estimate = self.observer.step(interval, sample);
        let speed =
            self.controller.winch_speed(interval, reference, estimate.stretch, estimate.drag_factor)?;
        let command = DriveCommand::Velocity(speed);
        Ok(CompensationOutput { command, tension_out: estimate.far, stretch: estimate.stretch })
    }
}

#[cfg(test)]
mod tests {
    use super::*;
    use crate::transmission::PerceptronWeights;

    #[test]
    fn the_capstan_command_and_estimate_are_inverse_above_the_pretension_and_zero_below() {
        let capstan = CapstanCompensation::new(1.1, 15.5).unwrap();
        for velocity in [0.05, -0.05] {
            let at = |tension_out| FarEndReference { tension_out, velocity, previewed_velocity: velocity };
            let near = capstan.drive_tension(&at(80.0)).unwrap();
            assert!((capstan.far_tension(near, velocity).unwrap() - 80.0).abs() < 1e-12);
            assert!(if velocity > 0.0 { near > 64.5 } else { near < 64.5 });
            assert!(capstan.drive_tension(&at(3.0)).unwrap().abs() < 1e-300);
        }
        for (angle, pretension) in [(-0.1, 15.5), (f64::NAN, 15.5), (1.1, -1.0), (1.1, f64::INFINITY)] {
            assert!(CapstanCompensation::new(angle, pretension).is_err());
        }
    }

    #[test]
    fn networks_of_other_inputs_are_refused_when_the_compensation_is_built() {
        let network = |inputs: usize| {
            Perceptron::new(PerceptronWeights {
                inputs,
                hidden: 1,
                input_weights: alloc::vec![0.1; inputs],
                hidden_bias: alloc::vec![0.0],
                output_weights: alloc::vec![1.0],
                output_bias: 5.0,
                skip: alloc::vec![],
            })
            .unwrap()
        };
        assert!(NetworkCompensation::new(network(3), network(2)).is_err());
        assert!(NetworkCompensation::new(network(2), network(1)).is_err());
        let networks = NetworkCompensation::new(network(2), network(2)).unwrap();
        let mut compensation = Compensation::Network(Box::new(networks));
        let reference = FarEndReference { tension_out: f64::NAN, velocity: 0.1, previewed_velocity: 0.1 };
        let sample = CableSample { motor: 0.0, anchor: 0.0, tension_in: f64::NAN };
        assert!(compensation.step(1e-3, &reference, &sample).is_err());
        let reference = FarEndReference { tension_out: 50.0, ..reference };
        let output = compensation.step(1e-3, &reference, &sample).unwrap();
        assert!(output.tension_out.is_nan() && matches!(output.command, DriveCommand::Tension { .. }));
    }

    #[test]
    fn the_networks_friction_is_added_toward_the_drive_and_taken_off_toward_the_anchor() {
        // 5 N + 0.1 of the tension + 20 N s/m of the speed, and 3 N + 0.2 of the tension - 10 N s/m of it.
        let network = |bias, [tension, speed]: [f64; 2]| {
            Perceptron::new(PerceptronWeights {
                inputs: 2,
                hidden: 1,
                input_weights: alloc::vec![0.0; 2],
                hidden_bias: alloc::vec![0.0],
                output_weights: alloc::vec![0.0],
                output_bias: bias,
                skip: alloc::vec![tension, speed],
            })
            .unwrap()
        };
        let networks =
            NetworkCompensation::new(network(5.0, [0.1, 20.0]), network(3.0, [0.2, -10.0])).unwrap();
        let mut compensation = Compensation::Network(Box::new(networks));
        let reference = FarEndReference { tension_out: 50.0, velocity: 0.1, previewed_velocity: 0.1 };
        let sample = CableSample { motor: 0.0, anchor: 0.0, tension_in: 70.0 };
        let output = compensation.step(1e-3, &reference, &sample).unwrap();
        let DriveCommand::Tension { tension, feed } = output.command else { panic!("{output:?}") };
        assert!((tension - (50.0 + 5.0 + 5.0 + 2.0)).abs() < 1e-14 && (feed - 0.1).abs() < 1e-15);
        assert!((output.tension_out - (70.0 - (3.0 + 14.0 - 1.0))).abs() < 1e-14, "{}", output.tension_out);
    }
}
