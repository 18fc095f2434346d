//! Where the largest errors of a run come from: the joints whose errors move the end point, their reversals,
//! the zeros of the encoders.

use crate::experiment::ErrorPeak;
use serde::{Deserialize, Serialize};
use sinew::Error;
use sinew::body::{JointKind, Poses};
use sinew::machine::Machine;
use sinew::muscle::MuscleDynamics;

/// Time after a reversal within which an error is attributed to it, s.
const AFTER_REVERSAL_S: f64 = 0.5;
/// Joints that are named: at most, and from which fraction of the error on.
const NAMED: usize = 3;
const NAMED_FRACTION: f64 = 0.1;

/// One of the largest errors of a run.
#[derive(Debug, Clone, PartialEq, Serialize, Deserialize)]
pub struct LargestError {
    /// Since the start of the run, s.
    pub time_s: f64,
    /// Distance of the end point from its reference, m; none of a machine without end point.
    pub end_point_error_m: Option<f64>,
    /// Its part by the zeros of the joint encoders, m, along the error.
    pub unseen_error_m: Option<f64>,
    /// The joints with the largest parts, largest first.
    pub joints: Vec<JointShare>,
    /// Whether tensions within their limits gave the torque.
    pub feasible: bool,
}

/// The part of one joint in an error.
#[derive(Debug, Clone, PartialEq, Serialize, Deserialize)]
pub struct JointShare {
    /// Its name.
    pub joint: String,
    /// Error of a hinge, true minus reference, rad.
    #[serde(skip_serializing_if = "Option::is_none", default)]
    pub error_rad: Option<f64>,
    /// The same of a slide, m.
    #[serde(skip_serializing_if = "Option::is_none", default)]
    pub error_m: Option<f64>,
    /// Displacement of the end point by it, m, along the error: positive parts add to it.
    #[serde(skip_serializing_if = "Option::is_none", default)]
    pub end_point_m: Option<f64>,
    /// Time since the joint's reference reversed, s, where that is at most half a second.
    #[serde(skip_serializing_if = "Option::is_none", default)]
    pub since_reversal_s: Option<f64>,
}

/// The accounts of the peaks of a run of this machine.
///
/// The part of a joint is the displacement of the end point when that joint alone is put from its true
/// coordinate to its reference, along the error; the parts add up to the error to second order of the joints'
/// errors.
///
/// # Errors
/// As [`MuscleDynamics::new`] and [`MuscleDynamics::evaluate`].
pub(super) fn largest_errors(peaks: &[ErrorPeak], machine: &Machine) -> Result<Vec<LargestError>, Error> {
    let mut model = MuscleDynamics::new(&machine.robot)?;
    peaks.iter().map(|peak| account(peak, machine, &mut model)).collect()
}

fn account(peak: &ErrorPeak, machine: &Machine, model: &mut MuscleDynamics) -> Result<LargestError, Error> {
    let robot = &machine.robot;
    let site = machine.task.site().map(|site| &robot.parts().sites[site]);
    let mut frames = Poses::new(robot);
    let mut point = |q: &[f64]| -> Result<Option<[f64; 3]>, Error> {
        let Some(site) = site else { return Ok(None) };
        model.evaluate(q)?;
        robot.forward_kinematics(model.coordinates(), &mut frames)?;
        Ok(Some(robot.body_pose(&frames, site.body).point(site.position)))
    };
    let [reference, end_point, encoder_point] = peak.points;
    let error: [f64; 3] = std::array::from_fn(|i| end_point[i] - reference[i]);
    let along = |d: [f64; 3]| d.iter().zip(&error).map(|(d, e)| d * e).sum::<f64>() / peak.size;
    let truth: Vec<f64> = peak.joints.iter().map(|joint| joint[1]).collect();
    let at = point(&truth)?;
    let mut joints = Vec::new();
    for (k, joint) in robot.independent_joints().into_iter().enumerate() {
        let part = &robot.parts().joints[joint];
        let mut moved = truth.clone();
        moved[k] = peak.joints[k][0];
        let end_point_m =
            at.zip(point(&moved)?).map(|(at, moved)| along(std::array::from_fn(|i| at[i] - moved[i])));
        let difference = if site.is_some() { truth[k] - peak.joints[k][0] } else { peak.joint_error[k] };
        let slide = part.kind == JointKind::Slide;
        let since = peak.time - peak.reversed[k];
        let range = part.range.map_or(f64::INFINITY, |[low, high]| high - low);
        let fraction = end_point_m.map_or(difference.abs() / range / peak.size, |part| part / peak.size);
        let joint = JointShare {
            joint: part.name.clone(),
            error_rad: (!slide).then_some(difference),
            error_m: slide.then_some(difference),
            end_point_m,
            since_reversal_s: (since <= AFTER_REVERSAL_S).then_some(since),
        };
        joints.push((fraction, joint));
    }
    joints.sort_by(|a, b| b.0.total_cmp(&a.0));
    joints.retain(|(fraction, _)| *fraction >= NAMED_FRACTION);
    joints.truncate(NAMED);
    Ok(LargestError {
        time_s: (1e3 * peak.time).round() / 1e3,
        end_point_error_m: site.map(|_| peak.size),
        unseen_error_m: site.map(|_| along(std::array::from_fn(|i| encoder_point[i] - reference[i]))),
        joints: joints.into_iter().map(|(_, joint)| joint).collect(),
        feasible: peak.feasible,
    })
}
