use crate::body::{JointKind, Robot};
use crate::error::Error;
use alloc::vec;
use alloc::vec::Vec;

/// Intervals of the independent joints in which these and all joints that follow them are within their
/// ranges.
///
/// Unlimited joints have infinite bounds. Of several intervals the one with the most points of a grid counts.
///
/// # Shapes
/// `[n]`, rad or m.
///
/// # Assumes
/// Hinges and slides only; where a follower is limited and its leader is not, the leader is searched within
/// 10 rad or m of its reference.
///
/// # Errors
/// [`Error::Part`] for a joint whose followers are out of their ranges wherever it is; as
/// [`Robot::pose_from_independent`].
pub fn independent_ranges(robot: &Robot) -> Result<Vec<[f64; 2]>, Error> {
    let parts = robot.parts();
    let independent = robot.independent_joints();
    let mut ranges: Vec<[f64; 2]> = independent
        .iter()
        .map(|&joint| parts.joints[joint].range.unwrap_or([f64::NEG_INFINITY, f64::INFINITY]))
        .collect();
    if !parts.couplings.iter().any(|coupling| parts.joints[coupling.follower].range.is_some()) {
        return Ok(ranges);
    }
    let reference = robot.reference_pose();
    let mut x: Vec<f64> =
        independent.iter().map(|&joint| reference[robot.coordinates_of(joint).start]).collect();
    for (k, &joint) in independent.iter().enumerate() {
        let followers = followers_of(robot, joint);
        if followers.is_empty() {
            continue;
        }
        let own = x[k];
        let window = [ranges[k][0].max(own - WINDOW), ranges[k][1].min(own + WINDOW)];
        let mut q = vec![0.0; robot.nq()];
        let mut inside = |value: f64| {
            x[k] = value;
            q.copy_from_slice(&robot.pose_from_independent(&x)?);
            Ok::<bool, Error>(followers.iter().all(|&follower| {
                let at = q[robot.coordinates_of(follower).start];
                parts.joints[follower].range.is_none_or(|[low, high]| (low..=high).contains(&at))
            }))
        };
        let (kind, field) = ("joint", "its range");
        let expected = "one in which the joints that follow it can keep theirs";
        let none = Error::Part { kind, index: joint, field, expected };
        ranges[k] = longest_interval(window, &mut inside)?.ok_or(none)?;
        x[k] = own;
    }
    Ok(ranges)
}

/// Distance from the reference within which an unlimited leader is searched, rad or m.
const WINDOW: f64 = 10.0;
/// Points of the search.
const GRID: usize = 1000;

/// The joints with a range that follow a joint, also through others.
fn followers_of(robot: &Robot, joint: usize) -> Vec<usize> {
    let couplings = &robot.parts().couplings;
    let mut all = vec![joint];
    let mut next = 0;
    while let Some(&leader) = all.get(next) {
        all.extend(couplings.iter().filter(|c| c.leader == Some(leader)).map(|c| c.follower));
        next += 1;
    }
    all.into_iter().skip(1).filter(|&follower| robot.parts().joints[follower].range.is_some()).collect()
}

/// The longest run of grid points inside, its ends by bisection; none where no point is inside.
fn longest_interval(
    [low, high]: [f64; 2],
    inside: &mut impl FnMut(f64) -> Result<bool, Error>,
) -> Result<Option<[f64; 2]>, Error> {
    let at = |k: usize| low + (high - low) * k as f64 / GRID as f64;
    let (mut best, mut from): ([usize; 2], Option<usize>) = ([0, 0], None);
    for k in 0..=GRID {
        from = if inside(at(k))? { from.or(Some(k)) } else { None };
        if let Some(from) = from
            && k + 1 - from > best[1] - best[0]
        {
            best = [from, k + 1];
        }
    }
    let [from, to] = best;
    if from == to {
        return Ok(None);
    }
    let mut end = |mut good: f64, mut bad: f64| {
        for _ in 0..60 {
            let middle = 0.5 * (good + bad);
            *(if inside(middle)? { &mut good } else { &mut bad }) = middle;
        }
        Ok::<f64, Error>(good)
    };
    let first = if from == 0 { low } else { end(at(from), at(from - 1))? };
    let last = if to > GRID { high } else { end(at(to - 1), at(to))? };
    Ok(Some([first, last]))
}

/// Half of the travel that is assumed of an unlimited hinge, rad, or slide, m.
const ASSUMED_HINGE: f64 = 1.0;
const ASSUMED_SLIDE: f64 = 0.05;

/// Finite intervals of the independent joints: an infinite bound is replaced by one at an assumed travel (1
/// rad or 50 mm) from `about`, rad or m: `[n]`.
///
/// # Errors
/// As [`independent_ranges`].
pub fn finite_ranges(robot: &Robot, about: &[f64]) -> Result<Vec<[f64; 2]>, Error> {
    let mut ranges = independent_ranges(robot)?;
    for ((range, joint), about) in ranges.iter_mut().zip(robot.independent_joints()).zip(about) {
        let travel = match robot.parts().joints[joint].kind {
            JointKind::Slide => ASSUMED_SLIDE,
            _ => ASSUMED_HINGE,
        };
        *range = match *range {
            [low, high] if low.is_finite() && high.is_finite() => [low, high],
            [low, _] if low.is_finite() => [low, about.max(low) + travel],
            [_, high] if high.is_finite() => [about.min(high) - travel, high],
            _ => [about - travel, about + travel],
        };
    }
    Ok(ranges)
}
