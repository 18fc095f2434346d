//! The arm controller of a compensation variant: its gains, its actuation mode and what it is calibrated by.

use super::calibrate::calibrate_networks;
use super::residual_network::calibrate_residuals;
use crate::experiment::oracle_models;
use crate::{CompensationVariant, Error};
use sinew::body::Robot;
use sinew::control::arm::{ActuationMode, ArmController, ArmGains, CableStateSource};
use sinew::control::compensation::{CapstanCompensation, Compensation};
use sinew::predictor::CableModel;
use sinew::twin::arm::ArmSpecimen;

/// Payload that halves the bandwidth, kg: tuned on three arms, both paths in 11.5 s, 0.1 to 0.45 kg.
const HALF_BANDWIDTH_KG: f64 = 0.45;

/// The controller of a variant for an arm whose cables were identified as `models`, carrying `payload` kg.
///
/// # Errors
/// As [`ArmController::new`], and as [`calibrate_networks`] and [`calibrate_residuals`] where networks are
/// trained.
pub(super) fn controller(
    variant: CompensationVariant,
    robot: &Robot,
    specimen: &ArmSpecimen,
    models: &[CableModel],
    payload: f64,
    seed: u64,
) -> Result<ArmController, Error> {
    let perfect;
    let models = if variant == CompensationVariant::Perfect {
        perfect = oracle_models(specimen);
        &perfect
    } else {
        models
    };
    let actuation = actuation_mode(variant, specimen, models, seed)?;
    let controller = ArmController::new(robot, models, gains(variant, payload), actuation)?;
    if variant != CompensationVariant::ObserverNetwork {
        return Ok(controller);
    }
    let residuals = calibrate_residuals(specimen, models, seed)?;
    Ok(controller.with_residuals(residuals.into_iter().map(|fit| fit.network).collect())?)
}

/// A payload lowers the bandwidth: friction grows with the tensions that carry it, and a stiff loop starts a
/// limit cycle between the two directions of sliding.
fn gains(variant: CompensationVariant, payload: f64) -> ArmGains {
    let mut gains = ArmGains::lm_arm();
    let share = payload / HALF_BANDWIDTH_KG;
    gains.bandwidth.iter_mut().for_each(|bandwidth| *bandwidth /= 1.0 + share * share);
    if variant == CompensationVariant::NoObserver {
        gains = gains.without_tension_estimates();
    }
    if variant == CompensationVariant::NoDisturbanceObserver {
        gains.disturbance_bandwidth.fill(0.0);
        // Without any other integral action either.
        gains.pre_travel_integral = 0.0;
    }
    gains
}

fn actuation_mode(
    variant: CompensationVariant,
    specimen: &ArmSpecimen,
    models: &[CableModel],
    seed: u64,
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
            let networks = calibrate_networks(specimen, seed)?.into_iter();
            ActuationMode::DriveTension(
                networks.map(|network| Compensation::Network(Box::new(network))).collect(),
            )
        }
        CompensationVariant::NoObserver => ActuationMode::WinchSpeed(CableStateSource::Encoders),
        CompensationVariant::NoDisturbanceObserver
        | CompensationVariant::Observer
        | CompensationVariant::ObserverNetwork => ActuationMode::WinchSpeed(CableStateSource::Observer),
        CompensationVariant::Perfect => ActuationMode::WinchSpeed(CableStateSource::Oracle),
    })
}
