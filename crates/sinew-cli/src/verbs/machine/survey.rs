//! Ranges of muscle lengths, moment arms and wrap angles over the joint limits.

use super::names::display_name;
use super::poses::{apply_couplings, velocity_names};
use crate::error::Error;
use sinew::body::{JointKind, Robot};
use sinew::muscle::{Geometry, Muscles};

/// Sampled poses.
const POSES: usize = 512;
/// Sampled range of a joint without limits, to both sides of its reference: rad or m.
const UNLIMITED: [f64; 2] = [std::f64::consts::PI, 0.1];

/// One muscle over all poses: minima and maxima.
pub(super) struct MuscleSurvey {
    pub(super) name: String,
    /// At the reference pose.
    pub(super) length_m: f64,
    pub(super) lengths_m: [f64; 2],
    /// The joint about which its moment arm is largest, and that arm's range.
    pub(super) strongest: String,
    pub(super) arm_m: [f64; 2],
    pub(super) wrap_rad: [f64; 2],
}

impl MuscleSurvey {
    pub(super) fn travel_m(&self) -> f64 {
        self.lengths_m[1] - self.lengths_m[0]
    }
}

pub(super) struct Survey {
    pub(super) muscles: Vec<MuscleSurvey>,
    pub(super) poses: usize,
}

const EMPTY_RANGE: [f64; 2] = [f64::INFINITY, f64::NEG_INFINITY];

fn extend(range: &mut [f64; 2], value: f64) {
    *range = [range[0].min(value), range[1].max(value)];
}

/// The reference pose with the couplings satisfied.
pub(super) fn coupled_reference_pose(robot: &Robot) -> Vec<f64> {
    let mut q = robot.reference_pose();
    apply_couplings(robot, &[], &mut q);
    q
}

/// Range of a joint of one coordinate; none for the others.
pub(super) fn joint_range(robot: &Robot, joint: usize) -> Option<[f64; 2]> {
    let joint = &robot.parts().joints[joint];
    let wide = match joint.kind {
        JointKind::Hinge => UNLIMITED[0],
        JointKind::Slide => UNLIMITED[1],
        JointKind::Ball | JointKind::Free => return None,
    };
    Some(joint.range.unwrap_or([joint.reference - wide, joint.reference + wide]))
}

pub(super) fn survey(robot: &Robot) -> Result<Survey, Error> {
    let muscles = Muscles::new(robot);
    let mut geometry = Geometry::new(robot, &muscles);
    let (count, nv) = (muscles.count(), robot.nv());
    let (mut lengths, mut wraps) = (vec![EMPTY_RANGE; count], vec![EMPTY_RANGE; count]);
    let mut arms = vec![EMPTY_RANGE; count * nv];
    let (mut dense, mut angles) = (vec![0.0; count * nv], vec![0.0; count]);
    let mut q = coupled_reference_pose(robot);
    muscles.evaluate(&q, &mut geometry)?;
    let first = geometry.lengths().to_vec();
    // Additive recurrence with the square roots of primes: low discrepancy, deterministic.
    let steps: Vec<f64> = primes(robot.parts().joints.len()).map(|p| f64::from(p).sqrt().fract()).collect();
    for pose in 0..POSES {
        #[expect(clippy::cast_precision_loss, reason = "a few hundred poses")]
        let turn = pose as f64 + 0.5;
        for (joint, step) in steps.iter().enumerate() {
            if let Some([low, high]) = joint_range(robot, joint) {
                q[robot.coordinates_of(joint).start] = low + (turn * step).fract() * (high - low);
            }
        }
        apply_couplings(robot, &[], &mut q);
        muscles.evaluate(&q, &mut geometry)?;
        muscles.dense(&geometry, &mut dense)?;
        muscles.wrap_angles(&geometry, &mut angles)?;
        lengths.iter_mut().zip(geometry.lengths()).for_each(|(range, &value)| extend(range, value));
        wraps.iter_mut().zip(&angles).for_each(|(range, &value)| extend(range, value));
        arms.iter_mut().zip(&dense).for_each(|(range, &value)| extend(range, value));
    }
    let joints = velocity_names(robot);
    let muscles = robot.parts().tendons.iter().enumerate().map(|(i, tendon)| {
        let row = &arms[i * nv..(i + 1) * nv];
        let size = |range: &[f64; 2]| range[0].abs().max(range[1].abs());
        let most = (0..nv).max_by(|&a, &b| size(&row[a]).total_cmp(&size(&row[b])));
        MuscleSurvey {
            name: display_name("tendon", &tendon.name, i),
            length_m: first[i],
            lengths_m: lengths[i],
            strongest: most.map_or(String::new(), |joint| joints[joint].clone()),
            arm_m: most.map_or([0.0; 2], |joint| row[joint]),
            wrap_rad: wraps[i],
        }
    });
    Ok(Survey { muscles: muscles.collect(), poses: POSES })
}

fn primes(count: usize) -> impl Iterator<Item = u32> {
    (2_u32..).filter(|n| (2..*n).take_while(|d| d * d <= *n).all(|d| n % d != 0)).take(count)
}
