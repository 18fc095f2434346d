//! The controller of a machine whose bench is not at hand: what its file says, or what was recorded of it, is
//! known.

use super::controller::{Parts, controller};
use super::tracking::poses_along;
use crate::experiment::oracle_models;
use crate::{CompensationVariant, Error};
use sinew::control::arm::{ArmController, ArmGains, synthesize};
use sinew::machine::Machine;
use sinew::predictor::CableModel;
use sinew::trajectory::Trajectory;
use sinew::twin::arm::ArmSpecimen;

/// What the controller of a machine is made of where its bench is not at hand.
#[derive(Debug, Clone)]
pub struct IdentifiedMachine {
    /// As designed, with its payload as part of the body.
    pub machine: Machine,
    /// Model of every cable: `[muscles]`.
    pub models: Vec<CableModel>,
    /// Before a variant without observers lowers them.
    pub gains: ArmGains,
}

impl IdentifiedMachine {
    /// With the models of its cables that the machine file names; where it names none, with the cable as
    /// designed. `gains` replace those that follow from the rules for the trajectory.
    ///
    /// # Errors
    /// As [`synthesize`].
    pub fn designed(
        machine: &Machine,
        trajectory: &Trajectory,
        gains: Option<&ArmGains>,
    ) -> Result<Self, Error> {
        let machine = machine.loaded()?;
        let models = designed_models(&machine)?;
        Self::new(machine, models, trajectory, gains)
    }

    /// With these models of its cables; `machine` has its payload as part of the body.
    ///
    /// # Errors
    /// As [`synthesize`].
    pub fn new(
        machine: Machine,
        models: Vec<CableModel>,
        trajectory: &Trajectory,
        gains: Option<&ArmGains>,
    ) -> Result<Self, Error> {
        let gains = match gains {
            Some(gains) => gains.clone(),
            None => synthesize(&machine, &models, &poses_along(trajectory)?)?.0,
        };
        Ok(Self { machine, models, gains })
    }

    /// The controller with an observer of every cable.
    ///
    /// # Errors
    /// As [`ArmController::new`].
    pub fn plain_controller(&self) -> Result<ArmController, Error> {
        self.of_variant(CompensationVariant::Observer)
    }

    /// The controller of a variant; none where the variant is calibrated on the bench.
    ///
    /// # Errors
    /// As [`ArmController::new`].
    pub fn controller(&self, variant: CompensationVariant) -> Result<Option<ArmController>, Error> {
        if matches!(variant, CompensationVariant::Paper | CompensationVariant::Perfect) {
            return Ok(None);
        }
        self.of_variant(variant).map(Some)
    }

    fn of_variant(&self, variant: CompensationVariant) -> Result<ArmController, Error> {
        let parts = Parts {
            machine: &self.machine,
            specimen: &ArmSpecimen::nominal(&self.machine)?,
            models: &self.models,
            programmes: &[],
            gains: self.gains.clone(),
            seed: 0,
        };
        controller(variant, &parts)
    }
}

/// The controller of a machine for a trajectory, as [`IdentifiedMachine::designed`].
///
/// # Errors
/// As [`IdentifiedMachine::designed`] and [`ArmController::new`].
pub fn designed_controller(
    machine: &Machine,
    trajectory: &Trajectory,
    gains: Option<&ArmGains>,
) -> Result<ArmController, Error> {
    IdentifiedMachine::designed(machine, trajectory, gains)?.plain_controller()
}

/// The identified model of every cable, or that of its design: `[muscles]`.
fn designed_models(machine: &Machine) -> Result<Vec<CableModel>, Error> {
    let designed = oracle_models(&ArmSpecimen::nominal(machine)?);
    let chosen = machine.muscles.iter().zip(designed);
    Ok(chosen.map(|(muscle, designed)| muscle.model.clone().unwrap_or(designed)).collect())
}
