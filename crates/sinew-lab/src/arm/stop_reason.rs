//! Why a machine stopped, in words with the number that was exceeded.

use sinew::body::Robot;
use sinew::control::arm::Fault;
use sinew::control::supervisor::Threshold;

/// A fault by the name of its muscle or joint.
#[must_use]
pub fn fault_name(fault: Fault, robot: &Robot) -> String {
    let muscle = |k: usize| robot.parts().tendons.get(k).map_or("?", |tendon| tendon.name.as_str());
    let independent = robot.independent_joints();
    let joint = |k: usize| independent.get(k).map_or("?", |joint| robot.parts().joints[*joint].name.as_str());
    fault.name(muscle, joint)
}

/// A fault with the limit by which it was judged: "tension of biceps above its limit of 400 N".
#[must_use]
pub fn stop_reason(fault: Fault, threshold: Option<Threshold>, robot: &Robot) -> String {
    let name = fault_name(fault, robot);
    let unit = |k: usize| {
        let joints = robot.independent_joints();
        joints.get(k).map_or("rad", |joint| robot.parts().joints[*joint].kind.unit())
    };
    match (threshold, fault) {
        (Some(Threshold::JointError(limit)), Fault::TrackingError(k)) => {
            let joint =
                robot.independent_joints().get(k).map(|joint| robot.parts().joints[*joint].name.as_str());
            format!("{} exceeded {} {} tracking error", joint.unwrap_or("?"), rounded(limit), unit(k))
        }
        (Some(Threshold::JointRange([low, high])), Fault::JointRange(k)) => {
            format!("{name} of {} to {} {} with its margin", rounded(low), rounded(high), unit(k))
        }
        (Some(Threshold::Tension(limit)), Fault::Slack(_)) => {
            format!("{name}: less than {} N at the drive", rounded(limit))
        }
        (Some(Threshold::Tension(limit)), _) => format!("{name} of {} N", rounded(limit)),
        (Some(Threshold::TensionRate(limit)), _) => format!("{name}: more than {} N/s", rounded(limit)),
        (Some(Threshold::CableSpeed(limit)), _) => format!("{name}: more than {} m/s", rounded(limit)),
        (Some(Threshold::Travel([low, high])), _) => {
            format!("{name} of {} to {} m", rounded(low), rounded(high))
        }
        (Some(Threshold::Temperature(limit)), _) => format!("{name}: more than {} °C", rounded(limit)),
        (Some(Threshold::CommandAge(limit)), _) => format!("{name} for {} s", rounded(limit)),
        (Some(Threshold::JointError(_) | Threshold::JointRange(_)) | None, _) => name,
    }
}

/// Three significant digits.
fn rounded(x: f64) -> String {
    let exponent = if x == 0.0 { 0.0 } else { x.abs().log10().floor() };
    let places = (2.0 - exponent).clamp(0.0, 9.0) as usize;
    let text = format!("{x:.places$}");
    if text.contains('.') { text.trim_end_matches('0').trim_end_matches('.').to_owned() } else { text }
}

#[cfg(test)]
mod tests {
    use super::*;

    #[test]
    fn the_number_that_was_exceeded_stands_in_the_reason() {
        let machine = crate::arm::testing::lm_arm();
        let robot = &machine.robot;
        let said = |fault, threshold| stop_reason(fault, threshold, robot);
        let muscle = robot.parts().tendons[2].name.clone();
        let joint = robot.parts().joints[robot.independent_joints()[1]].name.clone();
        assert_eq!(
            said(Fault::Overload(2), Some(Threshold::Tension(400.0))),
            format!("tension of {muscle} above its limit of 400 N")
        );
        assert_eq!(
            said(Fault::TrackingError(1), Some(Threshold::JointError(0.5))),
            format!("{joint} exceeded 0.5 rad tracking error")
        );
        assert_eq!(said(Fault::Cable(2), None), format!("cable of {muscle}"));
        assert_eq!(rounded(1234.56), "1235");
        assert_eq!(rounded(0.012_345), "0.0123");
        assert_eq!(rounded(-2.0), "-2");
    }
}
