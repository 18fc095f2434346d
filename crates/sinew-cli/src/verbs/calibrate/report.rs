//! A calibration in words.

use crate::table::{number, table};
use sinew::machine::{Machine, Marker};
use sinew_lab::vision::{
    CableJudgement, CalibratedBody, CalibratedJoint, CalibratedParameter, CalibratedSite, CalibratedWrap,
    Calibration, CalibrationPoses, ErrorRange, HeldOut, HeldOutCables, Judgement,
};

fn milli(x: f64) -> String {
    number(Some(1e3 * x))
}

/// What every pose of a plan gains.
pub(super) fn plan(poses: &CalibrationPoses, duration: f64) -> String {
    let mut text = format!("{} poses, {duration:.0} s of motion\n", poses.poses.len());
    let rows: Vec<Vec<String>> = poses
        .expected_m
        .iter()
        .enumerate()
        .filter(|(k, _)| k % 5 == 0 || k + 1 == poses.expected_m.len())
        .map(|(k, expected)| vec![k.to_string(), milli(*expected)])
        .collect();
    text += &table(&["poses", "expected error of the end point, mm rms"], &rows, 0);
    text
}

/// The calibration as a file. Written by hand: the crate that reads TOML here does not write it.
pub(super) fn toml(calibration: &Calibration) -> String {
    let Calibration { version, machine, machine_hash, simulated, parameter, .. } = calibration;
    let mut text = format!(
        "# Geometry of a machine as `sinew calibrate` found it; `sinew track --calibration` uses it.\n\
         version = {version}\nmachine = {machine:?}\nmachine_hash = {machine_hash:?}\n\
         simulated = {simulated}\n"
    );
    if let Some(recommendation) = &calibration.recommendation {
        text += &format!("recommendation = {recommendation:?}\n");
    }
    let range =
        |name: &str, x: ErrorRange| format!("{name} = {{ mean = {:?}, max = {:?} }}\n", x.mean, x.max);
    if let Some(HeldOut { before, after, reported }) = calibration.held_out_error_m {
        text += &format!(
            "\n[held_out_error_m]\n{}{}reported = {{ mean = {:?} }}\n",
            range("before", before),
            range("after", after),
            reported.mean
        );
    }
    if let Some(HeldOutCables { length_m, torque_nm }) = calibration.held_out {
        for (name, missed) in [("length_m", length_m), ("torque_nm", torque_nm)] {
            let (before, after) = (range("before", missed.before), range("after", missed.after));
            text += &format!("\n[held_out.{name}]\n{before}{after}");
        }
    }
    for CalibratedJoint { name, offset_m, tilt_rad, zero, flex_rad_per_nm } in &calibration.joint {
        text += &format!(
            "\n[[joint]]\nname = {name:?}\noffset_m = {offset_m:?}\ntilt_rad = {tilt_rad:?}\nzero = {zero:?}\n\
             flex_rad_per_nm = {flex_rad_per_nm:?}\n"
        );
    }
    for CalibratedSite { index, name, position_m } in &calibration.site {
        text += &format!("\n[[site]]\nindex = {index}\nname = {name:?}\nposition_m = {position_m:?}\n");
    }
    for CalibratedWrap { index, name, radius_m } in &calibration.wrap {
        text += &format!("\n[[wrap]]\nindex = {index}\nname = {name:?}\nradius_m = {radius_m:?}\n");
    }
    for CalibratedBody { index, name, mass_kg, center_of_mass_m } in &calibration.body {
        text += &format!(
            "\n[[body]]\nindex = {index}\nname = {name:?}\nmass_kg = {mass_kg:?}\n\
             center_of_mass_m = {center_of_mass_m:?}\n"
        );
    }
    for CalibratedParameter { name, value, sd, tolerance, determined } in parameter {
        text += &format!("\n[[parameter]]\nname = {name:?}\nvalue = {value:?}\nsd = {sd:?}\n");
        text += &tolerance.map_or_else(String::new, |x| format!("tolerance = {x:?}\n"));
        text += &format!("determined = {determined}\n");
    }
    text
}

/// The report: errors first, then what is known of each parameter.
pub(super) fn text(
    calibration: &Calibration,
    judgement: &Judgement,
    (machine, markers): (&Machine, &[Marker]),
    poses: Option<&CalibrationPoses>,
) -> String {
    let held = judgement.held_out;
    let judged = judgement.held.iter().filter(|held| **held).count();
    let mut text = if calibration.simulated { "SIMULATED. ".to_owned() } else { String::new() };
    text += &format!(
        "{}: error in {judged} poses that the estimate has not seen, camera's noise included: {} mm (max {}) before, \
         {} mm (max {}) after; {} mm expected. Recommendation: {}.\n",
        calibration.machine,
        milli(held.before.mean),
        milli(held.before.max),
        milli(held.after.mean),
        milli(held.after.max),
        milli(held.reported.mean),
        judgement.verdict(),
    );
    let [x, y, z] = judgement.estimate.noise.map(milli);
    text += &format!(
        "{} places, {} points, {} of them far off; scatter of a place {x}, {y}, {z} mm along the camera's axes; its \
         stamps are {} ms late.\n",
        judgement.places.len(),
        judgement.estimate.points,
        judgement.estimate.outliers.len(),
        milli(judgement.delay.0),
    );
    text += "This is the error of the geometry, at rest; what the cables and the controller add while the machine moves \
             `sinew track --calibration` measures.\n";
    for finding in &judgement.findings {
        text += &format!("Warning: {finding}.\n");
    }
    let places = markers.iter().map(|Marker { name, body, position: [x, y, z], .. }| {
        format!("{name} on {} at {x:.4}, {y:.4}, {z:.4} m", machine.robot.parts().bodies[*body].name)
    });
    text += &format!("Markers: {}.\n", places.collect::<Vec<_>>().join("; "));
    if let Some([.., before, last]) = poses.map(|poses| poses.expected_m.as_slice()) {
        let gain = 100.0 * (1.0 - last / before);
        text += &format!("The last pose was to lower the expected error by {gain:.1} %.\n");
    }
    let confounders = judgement.estimate.findings.iter().map(|finding| {
        let most = finding.confounder.as_ref().filter(|_| !finding.determined);
        most.map_or_else(String::new, |(name, correlation)| format!("{name} ({correlation:.2})"))
    });
    text + &parameters(calibration, confounders.chain([String::new()]))
}

/// Without a camera: what is missed of lengths and torques, then what is known of each parameter.
pub(super) fn of_cables(calibration: &Calibration, judgement: &CableJudgement) -> String {
    let mut text = if calibration.simulated { "SIMULATED. ".to_owned() } else { String::new() };
    let HeldOutCables { length_m, torque_nm } = judgement.held_out;
    let [fitted, judged] = judgement.places;
    text += &format!(
        "{}: missed in {judged} places that the estimate from {fitted} has not seen, mean (max): of the lengths of \
         muscles {} ({}) mm before, {} ({}) mm after; of the torques of the joints {} ({}) Nm before, {} ({}) Nm \
         after. Recommendation: {}.\n",
        calibration.machine,
        milli(length_m.before.mean),
        milli(length_m.before.max),
        milli(length_m.after.mean),
        milli(length_m.after.max),
        number(Some(torque_nm.before.mean)),
        number(Some(torque_nm.before.max)),
        number(Some(torque_nm.after.mean)),
        number(Some(torque_nm.after.max)),
        judgement.verdict(),
    );
    text += "Routes are equivalent, not true: they take what zeros and frames of joints do to lengths. Where the end \
             point is they do not tell.\n";
    for finding in &judgement.findings {
        text += &format!("Warning: {finding}.\n");
    }
    text + &parameters(calibration, std::iter::repeat(String::new()))
}

/// What is known of each parameter, and what it is confounded with.
fn parameters(calibration: &Calibration, confounders: impl Iterator<Item = String>) -> String {
    let rows: Vec<Vec<String>> = calibration
        .parameter
        .iter()
        .zip(confounders)
        .map(|(parameter, confounder)| {
            let known = if parameter.determined { "determined" } else { "not determined" };
            let tolerance = parameter.tolerance.map_or_else(String::new, |x| format!("{x:.2e}"));
            let [value, sd] = [parameter.value, parameter.sd].map(|x| format!("{x:.3e}"));
            vec![parameter.name.clone(), value, sd, tolerance, known.to_owned(), confounder]
        })
        .collect();
    table(&["parameter", "value", "sd", "sd before", "", "confounded with"], &rows, 1)
}
