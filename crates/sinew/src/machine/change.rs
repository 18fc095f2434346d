use super::design::Machine;
use crate::Error;
use crate::body::Robot;
use crate::predictor::CableModel;
use crate::transmission::cable::{CableParameters, CablePath, Segment};

/// One number of a design changed for the better, to see by evaluating it again whether that number limits
/// the machine.
///
/// Each change is by a factor of 1.5 or 2, for all muscles or joints at once.
#[derive(Debug, Clone, Copy, PartialEq, Eq)]
pub enum DesignChange {
    /// Half more voltage and speed of the motors.
    FasterWinch,
    /// Half the compliance of cables and sheath walls.
    StifferCable,
    /// Half the bend of the sheaths.
    LessBend,
    /// Half the count of the joints' encoders.
    FinerEncoder,
    /// Half more continuous torque: motors that carry half more current at the same temperatures.
    CoolerMotor,
    /// Half more current and voltage of the amplifiers.
    StrongerAmplifier,
    /// Winches of two thirds of their radius, and so half more tension at the same torque.
    SmallerWinch,
    /// Half more tension that cable and reducer are allowed.
    HigherTension,
    /// Two thirds of the masses of all bodies.
    LighterBody,
}

impl DesignChange {
    /// What it is, for tables and sentences.
    #[must_use]
    pub fn name(self) -> &'static str {
        match self {
            Self::FasterWinch => "faster winch",
            Self::StifferCable => "stiffer cable",
            Self::LessBend => "straighter sheath",
            Self::FinerEncoder => "finer encoder",
            Self::CoolerMotor => "more continuous torque",
            Self::StrongerAmplifier => "stronger amplifier",
            Self::SmallerWinch => "smaller winch",
            Self::HigherTension => "higher tension limit",
            Self::LighterBody => "lighter body",
        }
    }

    /// By how much it changes what.
    #[must_use]
    pub fn amount(self) -> &'static str {
        match self {
            Self::FasterWinch => "half more voltage and speed of the motors",
            Self::StifferCable => "half the compliance",
            Self::LessBend => "half the bend",
            Self::FinerEncoder => "half the count",
            Self::CoolerMotor => "half more current at the same temperatures",
            Self::StrongerAmplifier => "half more current and voltage",
            Self::SmallerWinch => "two thirds of the radius",
            Self::HigherTension => "half more that cable and reducer are allowed",
            Self::LighterBody => "two thirds of the masses",
        }
    }
}

impl DesignChange {
    /// The model of a cable after the change.
    ///
    /// # Errors
    /// As [`CablePath::new`].
    pub fn of_cable(self, model: &CableModel) -> Result<CableModel, Error> {
        let mut model = model.clone();
        if self == Self::StifferCable {
            stiffen(&mut model.parameters);
        }
        if self == Self::LessBend {
            let mut segments = model.path.segments().to_vec();
            for segment in &mut segments {
                if let Segment::Sheath { bend, .. } = segment {
                    straighten(bend);
                }
            }
            model.path = CablePath::new(segments)?;
        }
        Ok(model)
    }
}

fn stiffen(cable: &mut CableParameters) {
    cable.compliance *= 0.5;
    cable.sheath_compliance *= 0.5;
}

fn straighten(bend: &mut f64) {
    *bend *= 0.5;
}

impl Machine {
    /// The same with one number changed.
    ///
    /// # Errors
    /// As [`Robot::new`].
    pub fn with(&self, change: DesignChange) -> Result<Self, Error> {
        let mut machine = self.clone();
        for muscle in &mut machine.muscles {
            let (motor, winch) = (&mut muscle.drive.motor, &mut muscle.drive.winch);
            match change {
                DesignChange::FasterWinch => {
                    motor.voltage *= 1.5;
                    motor.top_speed *= 1.5;
                }
                DesignChange::StifferCable => stiffen(&mut muscle.cable),
                DesignChange::LessBend => straighten(&mut muscle.bend),
                DesignChange::CoolerMotor => {
                    // Losses grow with the square of the current; so do heat capacities, which keeps all
                    // times.
                    let square = 1.5 * 1.5;
                    motor.continuous_current *= 1.5;
                    motor.peak_current = motor.peak_current.max(motor.continuous_current);
                    motor.winding_to_housing /= square;
                    motor.housing_to_air /= square;
                    motor.winding_capacity *= square;
                    motor.housing_capacity *= square;
                }
                DesignChange::StrongerAmplifier => {
                    motor.peak_current *= 1.5;
                    motor.voltage *= 1.5;
                }
                DesignChange::SmallerWinch => {
                    winch.radius /= 1.5;
                    winch.lead /= 1.5;
                }
                DesignChange::HigherTension => {
                    muscle.drive.max_tension *= 1.5;
                    muscle.tension[1] = muscle.tension[1].map(|limit| 1.5 * limit);
                }
                DesignChange::FinerEncoder | DesignChange::LighterBody => {}
            }
        }
        if change == DesignChange::FinerEncoder {
            machine.encoders.iter_mut().flatten().for_each(|encoder| encoder.resolution *= 0.5);
        }
        if change == DesignChange::LighterBody {
            let mut parts = machine.robot.parts().clone();
            for body in &mut parts.bodies {
                body.mass /= 1.5;
                body.inertia.iter_mut().for_each(|entry| *entry /= 1.5);
            }
            machine.robot = Robot::new(parts)?;
        }
        Ok(machine)
    }
}
