//! The controller of a machine that is not simulated: what its file says is all that is known.

use super::tracking::poses_along;
use crate::Error;
use crate::experiment::oracle_models;
use sinew::control::arm::{ActuationMode, ArmController, ArmGains, CableStateSource, synthesize};
use sinew::machine::Machine;
use sinew::predictor::CableModel;
use sinew::trajectory::Trajectory;
use sinew::twin::arm::ArmSpecimen;

/// The controller of a machine for a trajectory, with the models of its cables that the machine file names; where it names
/// none, with the cable as designed. `gains` replace those that follow from the rules.
///
/// # Errors
/// As [`synthesize`] and [`ArmController::new`].
pub fn designed_controller(
    machine: &Machine,
    trajectory: &Trajectory,
    gains: Option<&ArmGains>,
) -> Result<ArmController, Error> {
    let machine = machine.loaded()?;
    let models = designed_models(&machine)?;
    let gains = match gains {
        Some(gains) => gains.clone(),
        None => synthesize(&machine, &models, &poses_along(trajectory)?)?.0,
    };
    let mode = ActuationMode::WinchSpeed(CableStateSource::Observer);
    let controller = ArmController::new(&machine.robot, &models, gains, mode)?;
    Ok(controller.with_sheath_bends(&machine.sheath_bends()?)?)
}

/// The identified model of every cable, or that of its design: `[muscles]`.
fn designed_models(machine: &Machine) -> Result<Vec<CableModel>, Error> {
    let designed = oracle_models(&ArmSpecimen::nominal(machine)?);
    let chosen = machine.muscles.iter().zip(designed);
    Ok(chosen.map(|(muscle, designed)| muscle.model.clone().unwrap_or(designed)).collect())
}
