//! Feasibility of a planned motion: the limits of joints, winches and tensions.

use super::heat::{allowed_temperature, drive_heat};
use super::tracking::poses_along;
use crate::Error;
use crate::experiment::oracle_models;
use sinew::body::Robot;
use sinew::control::arm::{ArmGains, least_stable_pose, max_unstable_rate, synthesize};
use sinew::control::tension::{Distribution, Problem, Status};
use sinew::machine::{Machine, NegativeStiffness};
use sinew::predictor::CableModel;
use sinew::trajectory::{
    self, ControllableMotion, Infeasibility, Limits, TorqueDeficit, TorqueDemand, Trajectory, Violation,
};
use sinew::twin::arm::ArmSpecimen;

/// Why a machine cannot carry out a motion.
#[derive(Debug, Clone)]
pub struct InfeasibleMotion {
    /// The payload with which it cannot, kg; 0 where it cannot without any.
    pub payload: f64,
    /// Where and why.
    pub infeasibility: Infeasibility,
}

/// Why a machine cannot carry out a motion without its payload, else with it; none where it can.
///
/// # Errors
/// As [`first_infeasibility`].
pub fn infeasible_motion(
    machine: &Machine,
    trajectory: &Trajectory,
    repeats: u32,
) -> Result<Option<InfeasibleMotion>, Error> {
    let unloaded = Machine { payload: 0.0, ..machine.clone() };
    if let Some(infeasibility) = first_infeasibility(&unloaded, trajectory, repeats)? {
        return Ok(Some(InfeasibleMotion { payload: 0.0, infeasibility }));
    }
    if machine.payload == 0.0 {
        return Ok(None);
    }
    let loaded = first_infeasibility(machine, trajectory, repeats)?;
    Ok(loaded.map(|infeasibility| InfeasibleMotion { payload: machine.payload, infeasibility }))
}

/// The first time at which a machine with its payload violates a limit: of the joints, of speed or
/// acceleration of a winch, of the tensions that the controller may ask for, where they cannot produce the
/// torque, of the rate at which it leaves a pose by itself, or of the heat of a drive over `repeats` of the
/// motion.
///
/// A motion may use a fraction of the limits of drives and tensions alone
/// ([`ControlRules::margin`](sinew::machine::ControlRules::margin)): a machine as built is heavier and has
/// more friction than its design.
///
/// # Errors
/// [`Error::Physics`] where trajectory and machine do not belong together.
pub fn first_infeasibility(
    machine: &Machine,
    trajectory: &Trajectory,
    repeats: u32,
) -> Result<Option<Infeasibility>, Error> {
    let design = ArmSpecimen::nominal(machine)?;
    let models = oracle_models(&design);
    let machine = &machine.loaded()?;
    let unreached = trajectory::first_unreachable(trajectory);
    if unreached.is_some() {
        return Ok(unreached);
    }
    let poses = poses_along(trajectory)?;
    let (gains, found) = synthesize(machine, &models, &poses)?;
    if let Some(violation) = too_little_tension(machine, &gains) {
        return Ok(Some(Infeasibility { time: 0.0, violation }));
    }
    let margin = machine.rules.margin;
    let mut torques = TorqueCheck::new(&machine.robot, tension_limits(&gains, margin))?;
    let limits = Limits {
        cable_speed: gains
            .muscles
            .iter()
            .map(|muscle| margin * ANCHOR_SPEED * muscle.max_winch_speed)
            .collect(),
        cable_acceleration: machine.muscles.iter().map(|muscle| margin * muscle.drive.acceleration).collect(),
        interval: check_interval(trajectory),
        ..Limits::default()
    };
    let check = |demand: TorqueDemand<'_>| torques.deficit(demand);
    let violated = trajectory::first_infeasibility(&machine.robot, trajectory, &limits, check)?;
    if violated.is_some() {
        return Ok(violated);
    }
    let unstable = first_unstable(machine, &models, &poses, trajectory.duration())?;
    if unstable.is_some() {
        return Ok(unstable);
    }
    let pretension: Vec<f64> = models.iter().map(|model| model.parameters.pretension).collect();
    let heat = drive_heat(machine, &gains, &found, &pretension, trajectory, repeats)?;
    Ok(heat.overheated.map(|(time, k)| Infeasibility {
        time,
        violation: Violation::Heat {
            muscle: machine.robot.parts().tendons[k].name.clone(),
            hottest: allowed_temperature(machine, k),
        },
    }))
}

/// The first muscle whose largest tension does not keep its cable taut.
fn too_little_tension(machine: &Machine, gains: &ArmGains) -> Option<Violation> {
    let tendons = &machine.robot.parts().tendons;
    machine.muscles.iter().zip(&gains.muscles).zip(tendons).find_map(|((design, gains), tendon)| {
        let most = design.tension[1]?;
        let needed = gains.tension[0];
        (needed >= most).then(|| Violation::TensionLimit { muscle: tendon.name.clone(), needed, most })
    })
}

/// The pose of some, spread evenly over `duration` s, that the machine leaves fastest with locked winches, if
/// its controller cannot hold it.
fn first_unstable(
    machine: &Machine,
    models: &[CableModel],
    poses: &[Vec<f64>],
    duration: f64,
) -> Result<Option<Infeasibility>, Error> {
    let laws = models.iter().map(CableModel::law).collect::<Result<Vec<_>, _>>()?;
    let least = least_stable_pose(machine, &laws, poses, 0.0)?;
    let most = max_unstable_rate(machine.dead_time());
    let Some(least) = least.filter(|least| least.stability.rate() > most) else {
        return Ok(None);
    };
    let parts = machine.robot.parts();
    let joint = machine.robot.independent_joints()[least.stability.joint];
    Ok(Some(Infeasibility {
        time: duration * least.index as f64 / (poses.len() - 1).max(1) as f64,
        violation: Violation::Unstable {
            joint: parts.joints[joint].name.clone(),
            muscle: match least.stability.cause {
                NegativeStiffness::Muscle(muscle) => Some(parts.tendons[muscle].name.clone()),
                NegativeStiffness::Gravity => None,
            },
            rate: least.stability.rate(),
            most,
            period: machine.period,
        },
    }))
}

/// Fraction of a winch's largest speed that an anchor may have: the rest moves the stretch of the cable and
/// its dead band.
const ANCHOR_SPEED: f64 = 0.55;

/// Lower and upper tension limit of every muscle, N, of which the upper is lowered to a fraction of its
/// range.
fn tension_limits(gains: &ArmGains, margin: f64) -> Vec<[f64; 2]> {
    let limits = gains.muscles.iter().map(|muscle| {
        let [least, most] = muscle.tension;
        [least, least + margin * (most - least)]
    });
    limits.collect()
}

/// Largest tension that is considered, N: none.
const MAX_TENSION: f64 = 1e6;

/// Tension distribution within the limits of the muscles.
struct TorqueCheck {
    /// Of a machine whose cables leave joints to springs.
    controllable: Option<ControllableMotion>,
    /// Tensions found last, N: `[muscles]`.
    tension: Vec<f64>,
    distribution: Distribution,
    joints: usize,
    minimum: Vec<f64>,
    maximum: Vec<f64>,
    zeros: Vec<f64>,
    ones: Vec<f64>,
}

impl TorqueCheck {
    fn new(robot: &Robot, limits: Vec<[f64; 2]>) -> Result<Self, sinew::Error> {
        let muscles = limits.len();
        let (minimum, maximum): (Vec<f64>, _) =
            limits.into_iter().map(|[lower, upper]| (lower, upper)).unzip();
        let controllable = ControllableMotion::new(robot)?;
        let joints = robot.independent_joints().len();
        let joints = controllable.as_ref().map_or(joints, ControllableMotion::count);
        Ok(Self {
            controllable,
            tension: minimum.clone(),
            distribution: Distribution::new(muscles, joints),
            joints,
            minimum,
            maximum,
            zeros: vec![0.0; muscles],
            ones: vec![1.0; muscles],
        })
    }

    /// The part of a torque that no admissible tensions produce.
    ///
    /// # Errors
    /// As [`Distribution::solve`]: an invalid problem is not a feasible one.
    fn deficit(&mut self, demand: TorqueDemand<'_>) -> Result<Option<TorqueDeficit>, sinew::Error> {
        let Self { controllable, tension, distribution, joints, minimum, maximum, zeros, ones } = self;
        let (mut moment_arms, mut needed) = (demand.moment_arms, demand.torque);
        let mut along = vec![0.0; *joints];
        if let Some(motion) = controllable.as_mut() {
            motion.evaluate(demand.pose, tension)?;
        }
        if let Some(motion) = controllable.as_ref() {
            motion.torque(needed, &mut along);
            (moment_arms, needed) = (motion.arms(), &along);
        }
        let solution = distribution.solve(&Problem {
            moment_arms,
            torque: needed,
            minimum,
            maximum,
            reference: zeros,
            weight: ones,
        })?;
        tension.copy_from_slice(solution.tension);
        if solution.status == Status::Optimal {
            return Ok(None);
        }
        let residual = solution.residual.iter().copied().enumerate();
        let (velocity, torque) =
            residual.max_by(|a, b| a.1.abs().total_cmp(&b.1.abs())).unwrap_or((0, f64::NAN));
        // The saturated muscle with the largest moment arm in the direction of the torque.
        let leverage = |muscle: usize| moment_arms[muscle * *joints + velocity] * needed[velocity];
        let muscle = (0..maximum.len())
            .filter(|&m| leverage(m) > 0.0 && solution.tension[m] >= maximum[m])
            .max_by(|&a, &b| leverage(a).total_cmp(&leverage(b)))
            .map(|m| (m, solution.tension[m]));
        let Some(motion) = controllable.as_ref() else {
            return Ok(Some(TorqueDeficit { velocity, torque, muscle, slack: None }));
        };
        // The joint that moves most, and the muscle whose joints need less than its minimum tension.
        let moved = demand.torque.len();
        let along = &motion.motion()[velocity * moved..(velocity + 1) * moved];
        let joint = (0..moved).max_by(|&a, &b| along[a].abs().total_cmp(&along[b].abs())).unwrap_or(0);
        let any = vec![MAX_TENSION; minimum.len()];
        let solution = distribution.solve(&Problem {
            moment_arms,
            torque: needed,
            minimum: &any.iter().map(|most| -most).collect::<Vec<_>>(),
            maximum: &any,
            reference: zeros,
            weight: ones,
        })?;
        let below = |m: &usize| minimum[*m] - solution.tension[*m];
        let slack =
            (0..minimum.len()).filter(|m| below(m) > 0.0).max_by(|a, b| below(a).total_cmp(&below(b)));
        let slack = slack.map(|m| (m, solution.tension[m], minimum[m]));
        Ok(Some(TorqueDeficit { velocity: joint, torque, muscle, slack }))
    }
}

/// Time between checked instants, s: at least fifty within each motion.
fn check_interval(trajectory: &Trajectory) -> f64 {
    let default = Limits::default().interval;
    match trajectory {
        Trajectory::Sequence(sequence) => {
            sequence.motions().map(|(_, motion)| check_interval(motion)).fold(default, f64::min)
        }
        _ => default.min(0.02 * trajectory.duration()).max(1e-3),
    }
}

#[cfg(test)]
mod tests {
    use super::*;
    use crate::arm::{DesiredMotion, plan, testing::lm_arm};

    fn sine(machine: &Machine) -> Trajectory {
        let path = machine.paths[0].path.clone();
        plan(machine, &DesiredMotion::ClosedPath(path), Some(11.5)).unwrap()
    }

    #[test]
    fn a_distribution_problem_that_is_invalid_is_an_error_and_not_feasible() {
        let mut check = TorqueCheck::new(&lm_arm().robot, vec![[25.0, 150.0]; 15]).unwrap();
        let mut torque = vec![0.0; 7];
        let arms = vec![0.01; 15 * 7];
        torque[2] = f64::NAN;
        assert!(check.deficit(TorqueDemand { pose: &[], moment_arms: &arms, torque: &torque }).is_err());
        assert!(
            check.deficit(TorqueDemand { pose: &[], moment_arms: &arms[1..], torque: &[0.0; 7] }).is_err()
        );
    }

    #[test]
    fn a_payload_beyond_the_tension_limits_or_the_heat_of_a_drive_is_reported() {
        let machine = lm_arm();
        let trajectory = sine(&machine);
        assert_eq!(first_infeasibility(&machine, &trajectory, 1).unwrap(), None);
        let loaded = Machine { payload: 5.0, ..machine.clone() };
        let found = first_infeasibility(&loaded, &trajectory, 1).unwrap().unwrap();
        assert!(matches!(found.violation, Violation::Torque { .. }), "{found}");
        // Windings that hardly give off heat hold for a while only.
        let mut warm = machine;
        for muscle in &mut warm.muscles {
            muscle.drive.motor.winding_to_housing *= 3000.0;
            muscle.drive.motor.winding_capacity *= 0.1;
        }
        let found = first_infeasibility(&warm, &trajectory, 2000).unwrap().unwrap();
        assert!(matches!(found.violation, Violation::Heat { .. }) && found.time > 20.0, "{found}");
    }

    /// A bar of 50 mm and 20 g between straight cables whose ends are far from its joint.
    const BOWSTRINGING: &str = r#"
        name = "bar"
        gravity_m_per_s2 = [0.0, 0.0, -9.81]
        body = [{ name = "bar", parent = "world", position_m = [0.0, 0.0, 0.0], mass_kg = 0.02,
                  center_of_mass_m = [0.0, 0.0, -0.025], inertia_kg_m2 = [5e-6, 5e-6, 1e-7] }]
        joint = [{ name = "hinge", body = "bar", kind = "hinge", axis = [0.0, 1.0, 0.0], range_rad = [-0.5, 0.5] }]
        site = [{ name = "front_o", body = "world", position_m = [0.005, 0.0, 0.03] },
                { name = "front_i", body = "bar", position_m = [0.005, 0.0, -0.03] },
                { name = "back_o", body = "world", position_m = [-0.005, 0.0, 0.03] },
                { name = "back_i", body = "bar", position_m = [-0.005, 0.0, -0.03] }]
        muscle = [{ name = "front", path = [{ site = "front_o" }, { site = "front_i" }] },
                  { name = "back", path = [{ site = "back_o" }, { site = "back_i" }] }]
    "#;

    #[test]
    fn a_machine_that_bowstrings_faster_than_its_controller_is_refused_by_name() {
        let machine =
            sinew::description::machine_from_toml("bar.toml", BOWSTRINGING, &mut |_| Err(String::new()));
        let machine = machine.unwrap().machine;
        let motion = plan(&machine, &DesiredMotion::ToPose(vec![0.02]), Some(5.0)).unwrap();
        let found = first_infeasibility(&machine, &motion, 1).unwrap().unwrap();
        let Violation::Unstable { joint, muscle: Some(muscle), rate, most, .. } = &found.violation else {
            panic!("{found}")
        };
        assert!(joint == "hinge" && ["front", "back"].contains(&muscle.as_str()) && rate > most, "{found}");
        assert!(found.to_string().contains("grows as it shortens"), "{found}");
        // Ten times heavier, it falls out of the pose slowly enough.
        let parts = machine.robot.parts().clone();
        let heavier = sinew::body::Body {
            mass: 0.2,
            inertia: [2e-3, 2e-3, 1e-6, 0.0, 0.0, 0.0],
            ..parts.bodies[1].clone()
        };
        let bodies = vec![parts.bodies[0].clone(), heavier];
        let robot = Robot::new(sinew::body::Parts { bodies, ..parts }).unwrap();
        let found = first_infeasibility(&Machine { robot, ..machine }, &motion, 1).unwrap();
        assert_eq!(found, None);
    }

    #[test]
    fn a_machine_that_is_held_at_a_millisecond_but_not_at_its_period_is_refused_with_the_period() {
        let of = |period: f64, mass: f64| {
            let read =
                sinew::description::machine_from_toml("bar.toml", BOWSTRINGING, &mut |_| Err(String::new()));
            let machine = read.unwrap().machine;
            let parts = machine.robot.parts().clone();
            let inertia = [0.01 * mass, 0.01 * mass, 1e-6, 0.0, 0.0, 0.0];
            let heavier = sinew::body::Body { mass, inertia, ..parts.bodies[1].clone() };
            let bodies = vec![parts.bodies[0].clone(), heavier];
            let robot = Robot::new(sinew::body::Parts { bodies, ..parts }).unwrap();
            let machine = Machine { robot, period, ..machine };
            let motion = plan(&machine, &DesiredMotion::ToPose(vec![0.02]), Some(5.0)).unwrap();
            first_infeasibility(&machine, &motion, 1).unwrap()
        };
        assert_eq!(of(1e-3, 0.05), None);
        let found = of(0.02, 0.05).unwrap();
        let Violation::Unstable { joint, rate, most, .. } = &found.violation else { panic!("{found}") };
        assert!(joint == "hinge" && rate > most && *most < 15.0, "{found}");
        assert!(found.to_string().contains("at a period of 20 ms"), "{found}");
    }
}
