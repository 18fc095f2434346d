//! Results of a run in words, and where its largest errors come from.

use super::marks::reversals;
use super::view::{Gear, Injected, TrackView};
use crate::format::{fixed, percent, significant};
use sinew_identify::gear::{GearFit, Interval};
use sinew_lab::arm::{JointShare, LargestError, TraceRow, TrackIncident, TrackingNumbers};
use sinew_lab::signals::Signal;

/// Time after a reversal that counts as its consequence, s.
const AFTER_REVERSAL_S: f64 = 0.5;

/// Ripple of tensions that is none, N.
const SILENT_N: f64 = 1e-4;

/// How the run ended, with its error.
pub(super) fn verdict(numbers: Option<&TrackingNumbers>) -> String {
    let Some(n) = numbers else { return String::new() };
    match (&n.stopped_by, n.stopped_s) {
        (Some(why), time) => format!(
            "The controller stopped the machine {} s after the start of the run: {why}.",
            fixed(time.unwrap_or(f64::NAN), 2)
        ),
        (None, Some(time)) => {
            format!("The simulation diverged {} s after the start of the run.", fixed(time, 2))
        }
        (None, None) if n.end_point_error_m.mean.is_finite() => {
            let limit = n.end_point_limit_m.map_or_else(String::new, |limit| {
                format!("; a run counts as accurate up to {} mm", significant(1e3 * limit, 3))
            });
            format!(
                "End point error: {} mm mean, {} mm max{limit}.",
                fixed(1e3 * n.end_point_error_m.mean, 2),
                fixed(1e3 * n.end_point_error_m.max, 2)
            )
        }
        (None, None) => {
            let of = |range: &Option<sinew_lab::arm::ErrorRange>, unit: &str| {
                range.map(|r| {
                    format!("{} {unit} mean, {} {unit} max", fixed(1e3 * r.mean, 2), fixed(1e3 * r.max, 2))
                })
            };
            let parts = [of(&n.joint_error_rad, "mrad"), of(&n.joint_error_m, "mm")];
            format!("Joint error: {}.", parts.into_iter().flatten().collect::<Vec<_>>().join("; "))
        }
    }
}

/// What failed, when and after which delay it was reported, and what the machine did, of every injected
/// fault.
pub(super) fn answers(injected: &[Injected], numbers: Option<&TrackingNumbers>) -> Vec<String> {
    let reports = numbers.map_or(&[][..], |numbers| &numbers.incidents);
    let each = injected.iter().enumerate().map(|(k, fault)| {
        let next = injected.get(k + 1).map_or(f64::INFINITY, |next| next.start_s);
        let found =
            reports.iter().find(|one| (fault.start_s..next.max(fault.start_s + 1e-3)).contains(&one.from_s));
        let mut text = format!("At {} s {}.", fixed(fault.start_s, 2), fault.what);
        text += &match found {
            Some(one) => format!(
                " The controller reported “{}” at {} s, {} s later: {}.",
                one.what,
                fixed(one.from_s, 3),
                fixed(one.from_s - fault.start_s, 3),
                response(one)
            ),
            None => " The controller reported no fault.".to_owned(),
        };
        text
    });
    each.collect()
}

/// Where the largest errors of the plotted run come from.
pub(super) fn sources(view: &TrackView<'_>) -> Vec<String> {
    let Some(numbers) = view.tracking.get(&view.drawn) else { return Vec::new() };
    let mut sentences: Vec<String> = numbers.largest_errors.iter().map(|one| source(one, numbers)).collect();
    sentences.extend(after_reversals(view));
    sentences
}

/// One of the largest errors in a sentence or two.
fn source(one: &LargestError, numbers: &TrackingNumbers) -> String {
    let time = fixed(one.time_s, 2);
    let mut text = match one.end_point_error_m {
        Some(error) => format!("{} mm at {time} s", fixed(1e3 * error, 2)),
        None => format!("At {time} s"),
    };
    let joints: Vec<String> = one.joints.iter().map(joint).collect();
    if !joints.is_empty() {
        text += &format!(": {}", joints.join("; "));
    }
    text.push('.');
    if let Some(unseen) = one.unseen_error_m.filter(|m| m.abs() >= 5e-5) {
        text += &format!(
            " The zero offsets of the encoders account for {} mm along this error.",
            fixed(1e3 * unseen, 2)
        );
    }
    if !one.feasible {
        text += " No tensions within their limits gave the torque that the controller asked for.";
    }
    let during = numbers.incidents.iter().filter(|i| one.time_s >= i.from_s && one.time_s <= i.until_s + 1.0);
    for incident in during {
        text +=
            &format!(" The fault “{}” was reported from {} s on.", incident.what, fixed(incident.from_s, 2));
    }
    text
}

fn joint(fraction: &JointShare) -> String {
    let off = match (fraction.error_rad, fraction.error_m) {
        (Some(rad), _) => format!("{} mrad", significant(1e3 * rad, 3)),
        (None, Some(m)) => format!("{} mm", significant(1e3 * m, 3)),
        (None, None) => "–".to_owned(),
    };
    let mut text = format!("{} is off by {off}", fraction.joint);
    if let Some(part) = fraction.end_point_m {
        text += &format!(", which alone makes {} mm along the error", fixed(1e3 * part, 2));
    }
    if let Some(since) = fraction.since_reversal_s {
        text += &format!(", {} s after it reversed", fixed(since, 2));
    }
    text
}

/// Fraction of the largest tenth of the errors that follows a reversal, beside the fraction of the time.
fn after_reversals(view: &TrackView<'_>) -> Option<String> {
    let rows: Vec<&TraceRow> = view.trace.iter().filter(|row| row.repeat.is_some()).collect();
    let joints = 0..view.joints.len();
    let mut times: Vec<f64> =
        joints.flat_map(|k| reversals(&rows, move |row| row.at(Signal::JointReference, k))).collect();
    times.sort_by(f64::total_cmp);
    let follows = |t: f64| {
        let next = times.partition_point(|reversal| *reversal <= t);
        next > 0 && t - times[next - 1] <= AFTER_REVERSAL_S
    };
    let size = |row: &TraceRow| {
        let square: f64 =
            row.end_point_reference_m.iter().zip(&row.end_point_m).map(|(a, b)| (a - b) * (a - b)).sum();
        if square.is_finite() {
            return square.sqrt();
        }
        let pairs = row.frame.of(Signal::JointTrue).iter().zip(row.frame.of(Signal::JointReference));
        pairs.map(|(a, b)| (a - b).abs()).fold(0.0, f64::max)
    };
    let mut sorted: Vec<(f64, f64)> = rows.iter().map(|row| (size(row), row.time_s)).collect();
    sorted.sort_by(|a, b| b.0.total_cmp(&a.0));
    let tenth = sorted.len() / 10;
    if tenth < 10 || times.is_empty() {
        return None;
    }
    let fraction =
        |of: &[(f64, f64)]| of.iter().filter(|(_, t)| follows(*t)).count() as f64 / of.len() as f64;
    Some(format!(
        "Of the largest tenth of all errors {} lie within {AFTER_REVERSAL_S} s after the reversal of a \
            joint; of the time of the motion these are {}.",
        percent(fraction(&sorted[..tenth])),
        percent(fraction(&sorted))
    ))
}

/// Further results of the plotted run.
pub(super) fn remarks(view: &TrackView<'_>, end_point: bool) -> Vec<String> {
    let Some(numbers) = view.tracking.get(&view.drawn) else { return Vec::new() };
    let mut remarks = Vec::new();
    let unseen = numbers.unseen_error_m;
    if end_point {
        let [mean, max] = [(unseen.mean, 2), (unseen.max, 2)].map(|(m, digits)| fixed(1e3 * m, digits));
        remarks.push(format!(
            "Mean error by the encoders’ zero offsets alone: {mean} mm (max {max}); it cannot be observed \
                without a sensor at the end point."
        ));
    }
    let repeats = &numbers.end_point_error_per_repeat_m;
    if end_point && repeats.len() > 1 {
        let means: Vec<String> = repeats.iter().map(|repeat| fixed(1e3 * repeat.mean, 2)).collect();
        remarks.push(format!("Mean error by repeat: {} mm.", means.join(", ")));
    }
    if let Some(hold) = numbers.hold {
        let e = hold.end_point_error_m;
        let [mean, max] = [(e.mean, 2), (e.max, 2)].map(|(m, digits)| fixed(1e3 * m, digits));
        let unseen = fixed(1e3 * hold.unseen_error_m, 2);
        if end_point {
            remarks.push(format!(
                "Mean error while holding: {mean} mm (max {max}), by the encoders’ zero offsets alone: {unseen} mm."
            ));
        }
        let ripple = if hold.tension_ripple_n < SILENT_N { 0.0 } else { hold.tension_ripple_n };
        remarks.push(format!("Tension ripple while holding: {} N rms.", significant(ripple, 2)));
    }
    remarks
}

/// Faults of the plotted run with their intervals and the controller's response.
pub(super) fn incidents(view: &TrackView<'_>) -> Vec<String> {
    let Some(numbers) = view.tracking.get(&view.drawn) else { return Vec::new() };
    let each = numbers.incidents.iter();
    each.map(|one| {
        let (from, until) = (fixed(one.from_s, 3), fixed(one.until_s, 3));
        format!("{from} to {until} s: {}, {}", one.what, response(one))
    })
    .collect()
}

/// Muscle, efficiency, and friction in mNm with their intervals.
pub(super) fn gear(gear: &Gear) -> [String; 3] {
    let within = |of: Interval, factor: f64| {
        let [value, low, high] = [of.value, of.low, of.high].map(|x| significant(factor * x, 3));
        format!("{value} ({low} to {high})")
    };
    let GearFit { efficiency, friction } = gear.losses;
    [gear.muscle.clone(), within(efficiency, 1.0), within(friction, 1e3)]
}

/// The controller's response to a fault.
pub fn response(incident: &TrackIncident) -> &'static str {
    match incident.answer.as_str() {
        "stopped" => "arm stopped",
        "held" => "motion ended, pose held",
        _ => "run continued",
    }
}

#[cfg(test)]
mod tests {
    use super::*;

    #[test]
    fn a_fault_that_nobody_reported_is_told_as_such() {
        let fault = |start_s, what: &str| Injected { start_s, what: what.to_owned() };
        let told =
            answers(&[fault(6.0, "the cable of a broke"), fault(7.0, "the winch of b jammed for 1 s")], None);
        assert_eq!(told[0], "At 6.00 s the cable of a broke. The controller reported no fault.");
        assert!(told[1].starts_with("At 7.00 s the winch of b jammed for 1 s. "));
    }
}
