//! What the muscles do over the whole range of the joints.

use super::model::display_name;
use super::poses::{apply_couplings, velocity_names};
use crate::error::Error;
use sinew::body::{JointKind, Robot};
use sinew::muscle::{Geometry, Muscles};

/// Poses that are looked at.
const POSES: usize = 512;
/// Where a joint without limits is looked at, on both sides of its reference: rad or m.
const UNLIMITED: [f64; 2] = [core::f64::consts::PI, 0.1];

/// One muscle over all poses: smallest and largest.
pub(super) struct MuscleSurvey {
    pub(super) name: String,
    /// At the reference pose.
    pub(super) length_m: f64,
    pub(super) lengths_m: [f64; 2],
    /// The joint about which its arm is largest, and that arm's range.
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

const NOTHING: [f64; 2] = [f64::INFINITY, f64::NEG_INFINITY];

fn include(range: &mut [f64; 2], value: f64) {
    *range = [range[0].min(value), range[1].max(value)];
}

/// The reference pose, couplings obeyed.
pub(super) fn coupled_reference_pose(robot: &Robot) -> Vec<f64> {
    let mut q = robot.reference_pose();
    apply_couplings(robot, &[], &mut q);
    q
}

/// Where a joint of one coordinate may be.
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
    let (mut lengths, mut wraps) = (vec![NOTHING; count], vec![NOTHING; count]);
    let mut arms = vec![NOTHING; count * nv];
    let (mut dense, mut angles) = (vec![0.0; count * nv], vec![0.0; count]);
    let mut q = coupled_reference_pose(robot);
    muscles.evaluate(&q, &mut geometry)?;
    let first = geometry.lengths().to_vec();
    // Additive recurrence by square roots of primes: even, and the same every time.
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
        lengths.iter_mut().zip(geometry.lengths()).for_each(|(range, &value)| include(range, value));
        wraps.iter_mut().zip(&angles).for_each(|(range, &value)| include(range, value));
        arms.iter_mut().zip(&dense).for_each(|(range, &value)| include(range, value));
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
