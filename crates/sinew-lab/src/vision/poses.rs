use crate::Error;
use crate::arm::{InfeasibleMotion, infeasible_motion};
use sinew::body::JointKind;
use sinew::control::capability::CapabilityModel;
use sinew::machine::{Machine, Marker};
use sinew::random::{EvenPoints, Random};
use sinew::trajectory::{JointWaypoint, Trajectory, through_joint_waypoints};
use sinew_identify::geometry::{GeometryModel, plan};

/// Poses of a calibration, in the order of the motion.
#[derive(Debug, Clone)]
pub struct CalibrationPoses {
    /// rad or m: `[poses][joints]`.
    pub poses: Vec<Vec<f64>>,
    /// Which of them only judge.
    pub held: Vec<bool>,
    /// Root mean square of the end point's expected error after as many of the others, m.
    pub expected_m: Vec<f64>,
}

/// Candidates of a plan, poses of the task, and the part of the way from the start to either end of
/// a joint's range within which they are: near the ends cables of an arm become slack on the way.
const CANDIDATES: usize = 400;
const TASK_POSES: usize = 40;
const REACH: f64 = 0.55;
/// Standard deviation of a place that a plan assumes, m.
const PLANNED_NOISE_M: f64 = 3e-4;
/// Mean speed between poses, rad/s and m/s; the shortest time of a motion and the rest, s.
const SPEED: [f64; 2] = [0.3, 0.03];
const SHORTEST_S: f64 = 1.5;
const REST_S: f64 = 1.2;
/// Poses that are left out, one after the other, because the way there is not feasible.
const MOST_LEFT_OUT: usize = 40;

/// Chooses poses that tell most about the end point, and others that judge, and orders them by travel; poses
/// that the muscles do not hold, or that are not reached within the limits of the drives, are left out, and
/// those before which `fails` on the motion says when, s.
///
/// # Errors
/// [`Error::Experiment`] where too few poses are left; as [`plan`](fn@plan) and [`infeasible_motion`]; those
/// of `fails`.
pub fn choose_poses(
    machine: &Machine,
    markers: &[Marker],
    (count, check): (usize, usize),
    seed: u64,
    mut fails: impl FnMut(&Trajectory) -> Result<Option<f64>, Error>,
) -> Result<CalibrationPoses, Error> {
    let model = GeometryModel::new(&machine.loaded()?, markers, 1)?;
    let mut held = CapabilityModel::new(machine)?;
    let ranges = machine.ranges()?;
    let inside = |point: Vec<f64>| -> Vec<f64> {
        let places = ranges.iter().zip(point).zip(&machine.start);
        places.map(|(([low, high], x), start)| start + REACH * (low + (high - low) * x - start)).collect()
    };
    let mut candidates = Vec::new();
    for pose in EvenPoints::new(ranges.len()).take(CANDIDATES).map(inside) {
        if held.held_payloads(std::slice::from_ref(&pose))?.first().is_none_or(Option::is_some) {
            candidates.push(pose);
        }
    }
    let task: Vec<Vec<f64>> = candidates.iter().take(TASK_POSES).cloned().collect();
    let tip = markers.iter().find(|marker| machine.moves(marker.body));
    let (body, place) = tip.map_or((0, [0.0; 3]), |tip| (tip.body, tip.position));
    let mut random = Random::new(seed);
    for _ in 0..MOST_LEFT_OUT {
        if candidates.len() < count + check || task.is_empty() {
            break;
        }
        let found = plan(&model, &candidates, &task, ((body, place), PLANNED_NOISE_M, count))?;
        let mut free: Vec<usize> = (0..candidates.len()).filter(|k| !found.chosen.contains(k)).collect();
        let judged = (0..check).map(|_| free.swap_remove((random.unit() * free.len() as f64) as usize));
        let judged: Vec<usize> = judged.collect();
        let order = by_travel(machine, &candidates, found.chosen.iter().chain(&judged).copied().collect());
        let poses: Vec<Vec<f64>> = order.iter().map(|k| candidates[*k].clone()).collect();
        let motion = motion_through(machine, &poses)?;
        let failed_at = match infeasible_motion(machine, &motion.0, 1)? {
            Some(InfeasibleMotion { infeasibility, .. }) => Some(infeasibility.time),
            None => fails(&motion.0)?,
        };
        let Some(failed_at) = failed_at else {
            let held = order.iter().map(|k| judged.contains(k)).collect();
            return Ok(CalibrationPoses { poses, held, expected_m: found.expected_m });
        };
        let at = motion.1.iter().position(|arrival| *arrival >= failed_at - REST_S);
        candidates.remove(order[at.unwrap_or(order.len()).min(order.len() - 1)]);
    }
    let got = candidates.len();
    let expected = "more that the machine reaches within its limits";
    Err(Error::experiment("poses of the calibration", expected, &got))
}

/// Each after the one before that is nearest to it, from the start on.
fn by_travel(machine: &Machine, candidates: &[Vec<f64>], mut left: Vec<usize>) -> Vec<usize> {
    let mut at = &machine.start;
    let mut order = Vec::new();
    while !left.is_empty() {
        let way = |k: usize| duration(machine, at, &candidates[k]);
        let next = (0..left.len()).min_by(|a, b| way(left[*a]).total_cmp(&way(left[*b]))).unwrap_or(0);
        let chosen = left.swap_remove(next);
        at = &candidates[chosen];
        order.push(chosen);
    }
    order
}

/// Time of a motion between two poses, s.
fn duration(machine: &Machine, from: &[f64], to: &[f64]) -> f64 {
    let joints = machine.robot.independent_joints().into_iter();
    let slides = joints.map(|joint| machine.robot.parts().joints[joint].kind == JointKind::Slide);
    let ways =
        from.iter().zip(to).zip(slides).map(|((a, b), slide)| (a - b).abs() / SPEED[usize::from(slide)]);
    ways.fold(SHORTEST_S, f64::max)
}

/// From the start through poses, with a rest in each, and back; and when each is reached, s.
///
/// # Errors
/// As [`through_joint_waypoints`].
pub fn motion_through(machine: &Machine, poses: &[Vec<f64>]) -> Result<(Trajectory, Vec<f64>), Error> {
    let mut points = vec![JointWaypoint { time: 0.0, q: machine.start.clone() }];
    let mut arrivals = Vec::new();
    let (mut time, mut at) = (0.0, &machine.start);
    for pose in poses.iter().chain([&machine.start]) {
        time += duration(machine, at, pose);
        points.push(JointWaypoint { time, q: pose.clone() });
        arrivals.push(time);
        time += REST_S;
        points.push(JointWaypoint { time, q: pose.clone() });
        at = pose;
    }
    arrivals.pop();
    Ok((through_joint_waypoints(&points)?, arrivals))
}
