//! Heat of the drives along a planned motion.

use crate::Error;
use sinew::control::arm::ArmGains;
use sinew::control::tension::{Distribution, Problem};
use sinew::drive::{MotorTemperatures, ROOM};
use sinew::machine::{Characteristics, Machine};
use sinew::muscle::MuscleDynamics;
use sinew::trajectory::{Reference, Trajectory};

/// Temperatures of the windings of a machine that repeats a motion.
#[derive(Debug, Clone, PartialEq)]
pub struct DriveHeat {
    /// The first winding beyond its limit: time since the start, s, and its muscle; none where all stay
    /// below.
    pub overheated: Option<(f64, usize)>,
    /// Hottest temperature of every winding, degrees Celsius: `[muscles]`.
    pub windings: Vec<f64>,
}

/// Longest step of the integration, s: an eighth of the time constant of a small winding.
const LONGEST_STEP: f64 = 1.0;
/// Steps at one instant's currents, at most: in a motion of days, where they are longer than
/// [`LONGEST_STEP`], every winding is at its steady temperature, to which the implicit integration leads with
/// any step.
const MAX_STEPS: f64 = 1000.0;
/// Mean change of temperature over a repeat below which the repeats no longer differ, K/s.
const STEADY: f64 = 1e-9;
/// Instants of one repeat at which the currents are computed.
const INSTANTS: usize = 400;

/// Integrates the heat of every drive over repeats of a motion from room temperature, for the tensions that
/// the controller asks for on cables as designed.
///
/// ```text
/// T_in = (F - T_0) e^(s A),   s the direction of sliding;    i from the losses of the reducer
/// ```
///
/// and the heat of [`Motor`](sinew::drive::Motor).
///
/// # Errors
/// [`Error::Physics`] where trajectory and machine do not belong together.
pub fn drive_heat(
    machine: &Machine,
    gains: &ArmGains,
    found: &Characteristics,
    pretension: &[f64],
    trajectory: &Trajectory,
    repeats: u32,
) -> Result<DriveHeat, Error> {
    let currents = currents(machine, gains, found, pretension, trajectory)?;
    let interval = trajectory.duration() / INSTANTS as f64;
    let steps = (interval / LONGEST_STEP).ceil().clamp(1.0, MAX_STEPS);
    let mut heat = DriveHeat { overheated: None, windings: vec![ROOM; machine.muscles.len()] };
    for (k, muscle) in machine.muscles.iter().enumerate() {
        let mut motor = MotorTemperatures::room();
        let limit = allowed_temperature(machine, k);
        'repeats: for repeat in 0..repeats {
            let before = motor;
            for (n, currents) in currents.iter().enumerate() {
                for _ in 0..steps as usize {
                    motor.advance(&muscle.drive.motor, currents[k], interval / steps);
                }
                heat.windings[k] = heat.windings[k].max(motor.winding);
                if motor.winding > limit {
                    let time = f64::from(repeat) * trajectory.duration() + n as f64 * interval;
                    if heat.overheated.is_none_or(|(first, _)| time < first) {
                        heat.overheated = Some((time, k));
                    }
                    break 'repeats;
                }
            }
            // Every further repeat is like this one.
            let change = (motor.winding - before.winding).abs().max((motor.housing - before.housing).abs());
            if change < STEADY * trajectory.duration() {
                break;
            }
        }
    }
    Ok(heat)
}

/// Temperature that a planned motion may heat a winding to, degrees Celsius: the machine's margin is a
/// fraction of the rise.
pub(super) fn allowed_temperature(machine: &Machine, muscle: usize) -> f64 {
    ROOM + machine.rules.margin * (machine.muscles[muscle].drive.motor.hottest - ROOM)
}

/// Current of every drive at every instant, A: `[instants][muscles]`.
fn currents(
    machine: &Machine,
    gains: &ArmGains,
    found: &Characteristics,
    pretension: &[f64],
    trajectory: &Trajectory,
) -> Result<Vec<Vec<f64>>, Error> {
    let mut model = MuscleDynamics::new(&machine.robot)?;
    let (muscles, joints) = (model.muscles(), model.joints());
    let mut distribution = Distribution::new(muscles, joints);
    let mut reference = Reference::new(joints);
    let (mut torque, mut speed) = (vec![0.0; joints], vec![0.0; muscles]);
    let limit = |k: usize| gains.muscles.iter().map(move |muscle| muscle.tension[k]).collect::<Vec<_>>();
    let (minimum, maximum) = (limit(0), limit(1));
    let (zeros, ones) = (vec![0.0; muscles], vec![1.0; muscles]);
    let mut instants = Vec::with_capacity(INSTANTS);
    for n in 0..INSTANTS {
        trajectory.sample(trajectory.duration() * n as f64 / INSTANTS as f64, &mut reference)?;
        model.evaluate(&reference.q)?;
        model.inverse_dynamics(&reference.v, &reference.a, &mut torque)?;
        model.anchor_motion(&reference.v, &mut speed);
        let solution = distribution.solve(&Problem {
            moment_arms: model.moment_arms(),
            torque: &torque,
            minimum: &minimum,
            maximum: &maximum,
            reference: &zeros,
            weight: &ones,
        })?;
        let each = solution.tension.iter().zip(&speed).enumerate().map(|(k, (force, speed))| {
            let drive = &machine.muscles[k].drive;
            let near =
                (force - pretension[k]).max(0.0) * (speed.signum() * found.muscles[k].friction_angle).exp();
            if *speed >= 0.0 {
                drive.pulling_current(near, *speed)
            } else {
                drive.yielding_current(near, -speed)
            }
        });
        instants.push(each.collect());
    }
    Ok(instants)
}

#[cfg(test)]
mod tests {
    #![allow(clippy::unwrap_used, reason = "a failing test may panic")]
    use super::super::testing::bench_joint;
    use super::super::{first_infeasibility, plan_tour};

    #[test]
    fn any_number_of_repeats_is_checked_in_finite_time() {
        let machine = bench_joint();
        let tour = plan_tour(&machine, Some(20.0), |_| Ok(None)).unwrap();
        assert!(first_infeasibility(&machine, &tour, u32::MAX).unwrap().is_none());
    }

    #[test]
    fn a_motion_of_any_duration_is_checked_in_finite_time() {
        let machine = bench_joint();
        let tour = plan_tour(&machine, Some(1e12), |trajectory| first_infeasibility(&machine, trajectory, 1));
        assert!(tour.unwrap().duration() > 9e11);
    }
}
