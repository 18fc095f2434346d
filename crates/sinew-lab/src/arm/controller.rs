//! The controller of a compensation variant: its gains, its actuation mode and what it is calibrated by.

use super::calibrate::{CalibrationProgramme, calibrate_networks};
use crate::experiment::oracle_models;
use crate::{CompensationVariant, Error};
use sinew::control::arm::{ActuationMode, ArmController, ArmGains, CableStateSource};
use sinew::control::compensation::{CapstanCompensation, Compensation};
use sinew::machine::Machine;
use sinew::predictor::CableModel;
use sinew::twin::arm::ArmSpecimen;

/// What a controller is made of.
pub(super) struct Parts<'a> {
    /// As designed, with its payload.
    pub(super) machine: &'a Machine,
    /// As built; only its bench is used.
    pub(super) specimen: &'a ArmSpecimen,
    /// Identified model of every cable.
    pub(super) models: &'a [CableModel],
    pub(super) programmes: &'a [CalibrationProgramme],
    pub(super) gains: ArmGains,
    pub(super) seed: u64,
}

/// The controller of a variant.
///
/// # Errors
/// As [`ArmController::new`], and as [`calibrate_networks`] where networks are trained.
pub(super) fn controller(variant: CompensationVariant, parts: &Parts<'_>) -> Result<ArmController, Error> {
    let true_models;
    let models = if variant == CompensationVariant::Perfect {
        true_models = oracle_models(parts.specimen);
        // Only the parameters differ: the gains of the observers are those of the identified models.
        &true_models
            .into_iter()
            .zip(parts.models)
            .map(|(model, identified)| CableModel {
                correction: identified.correction,
                learning: identified.learning,
                ..model
            })
            .collect::<Vec<_>>()
    } else {
        parts.models
    };
    let actuation = actuation_mode(variant, parts, models)?;
    let robot = &parts.machine.robot;
    let bends = match variant {
        CompensationVariant::Perfect => parts.specimen.bends.clone(),
        _ => parts.machine.sheath_bends()?,
    };
    let controller = ArmController::new(robot, models, gains(variant, parts.gains.clone()), actuation)?;
    Ok(controller.with_sheath_bends(&bends)?)
}

fn gains(variant: CompensationVariant, gains: ArmGains) -> ArmGains {
    match variant {
        CompensationVariant::NoObserver => gains.without_tension_estimates(),
        CompensationVariant::NoDisturbanceObserver => gains.without_integral_action(),
        _ => gains,
    }
}

fn actuation_mode(
    variant: CompensationVariant,
    parts: &Parts<'_>,
    models: &[CableModel],
) -> Result<ActuationMode, Error> {
    Ok(match variant {
        CompensationVariant::None => ActuationMode::DriveTension(vec![Compensation::None; models.len()]),
        CompensationVariant::Capstan => {
            let capstan = |model: &CableModel| {
                let friction_angle = model.law()?.friction_angle();
                Ok(Compensation::Capstan(CapstanCompensation::new(
                    friction_angle,
                    model.parameters.pretension,
                )?))
            };
            ActuationMode::DriveTension(models.iter().map(capstan).collect::<Result<_, Error>>()?)
        }
        CompensationVariant::Paper => {
            let Machine { robot, muscles, .. } = parts.machine;
            let mut muscles = robot.parts().tendons.iter().zip(muscles);
            if let Some((without, _)) = muscles.find(|(_, muscle)| !muscle.drive.has_load_cell) {
                return Err(Error::experiment(
                    "compensation `paper`",
                    "a load cell at every drive, whose tension its networks are trained with",
                    &format!("none of `{}`", without.name),
                ));
            }
            let networks = calibrate_networks(parts.specimen, parts.programmes, parts.seed)?.into_iter();
            ActuationMode::DriveTension(
                networks.map(|network| Compensation::Network(Box::new(network))).collect(),
            )
        }
        CompensationVariant::Inverted => {
            return Err(Error::experiment("compensation variant", "one that an arm supports", &variant));
        }
        CompensationVariant::NoObserver => ActuationMode::WinchSpeed(CableStateSource::Encoders),
        CompensationVariant::NoDisturbanceObserver
        | CompensationVariant::Observer
        | CompensationVariant::Perfect => ActuationMode::WinchSpeed(CableStateSource::Observer),
    })
}
