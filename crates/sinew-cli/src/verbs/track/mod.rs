//! The motion of a run, and its results as text, table and report.

mod joints;
pub(crate) mod motion;
pub(crate) mod record;
pub(crate) mod setup;
mod waypoints;

use crate::arguments::SessionArguments;
use crate::error::Error;
use crate::table::{number, table};
use crate::verbs::meshes::read_meshes;
use crate::verbs::run::Door;
use record::RunHead;
use setup::Setup;
use sinew::body::Robot;
use sinew_lab::CompensationVariant;
use sinew_lab::arm::{ErrorRange, INITIAL_REST_S, TraceRow, TrackOutcome, TrackingNumbers};
use sinew_report::tracking::{Gear, Injected, TrackView, page, response};
use std::collections::BTreeMap;
use std::path::PathBuf;

/// Rows of a report's trace.
pub(crate) const REPORT_ROWS: f64 = 3000.0;
/// Interval between the rows of a record, s.
pub(crate) const RECORD_INTERVAL_S: f64 = 0.01;

/// The contents of the report and the record.
pub(crate) fn files(
    door: &Door<'_>,
    setup: &Setup,
    (numbers, trace): (&TrackingNumbers, &[TraceRow]),
    gears: &[Gear],
) -> Result<Vec<(PathBuf, String)>, Error> {
    let parts = setup.machine.robot.parts();
    let joints = setup.machine.robot.independent_joints().into_iter();
    let head = RunHead {
        title: format!("{} along {}", parts.name, setup.path),
        conditions: conditions(door.arguments, setup),
        compensation: setup.variant.to_string(),
        repeats: setup.repeats,
        muscles: parts.tendons.iter().map(|tendon| tendon.name.clone()).collect(),
        joints: joints.clone().map(|joint| parts.joints[joint].name.clone()).collect(),
        joint_units: joints.map(|joint| parts.joints[joint].kind.unit().to_owned()).collect(),
        gears: gears.to_vec(),
        injected: injected(door.arguments),
        numbers: numbers.clone(),
    };
    let mut files = Vec::new();
    if let Some(path) = &door.arguments.report {
        let mut robot = setup.machine.robot.clone();
        read_meshes(&mut robot, &setup.source.path, setup.source.root.as_deref());
        files.push((path.clone(), report(&head, setup.variant, trace, Some(&robot))?));
    }
    if let Some(path) = door.table() {
        files.push((path.clone(), record::csv(&head, trace)?));
    }
    Ok(files)
}

/// The page of a run, from its rows or from its record, which has no robot to draw.
pub(crate) fn report(
    head: &RunHead,
    variant: CompensationVariant,
    trace: &[TraceRow],
    robot: Option<&Robot>,
) -> Result<String, Error> {
    let step = (trace.len() as f64 / REPORT_ROWS).ceil().max(1.0) as usize;
    let trace: Vec<_> = trace.iter().step_by(step).cloned().collect();
    let view = TrackView {
        heading: "Errors".to_owned(),
        lead: "The simulated machine deviates from the controller’s model; each cable was calibrated in a \
             run of its own."
            .to_owned(),
        tracking: &BTreeMap::from([(variant, head.numbers.clone())]),
        trace: &trace,
        drawn: variant,
        names: &head.muscles,
        joints: &head.joints,
        joint_units: &head.joint_units,
        gears: &head.gears,
        robot,
        injected: &head.injected,
        repeats: head.repeats,
        paper: false,
    };
    Ok(page(&view, &head.title, &head.conditions)?)
}

/// The conditions of the run, for the head of its report.
fn conditions(arguments: &SessionArguments, setup: &Setup) -> String {
    let mut text = format!("{} s", (1e3 * setup.trajectory.duration()).round() / 1e3);
    match setup.repeats {
        1 => text += ", once",
        n => text += &format!(", {n} times"),
    }
    if setup.machine.payload > 0.0 {
        text += &format!(", payload {} kg", setup.machine.payload);
    }
    text += &format!(", compensation {}, seed {}.", setup.variant, setup.seed);
    if !arguments.motion.fault.is_empty() {
        text += &format!(" The run starts with {INITIAL_REST_S} s at rest.");
    }
    text + " All results are simulated."
}

/// The injected faults in words.
fn injected(arguments: &SessionArguments) -> Vec<Injected> {
    let each = arguments.motion.fault.iter();
    let mut faults: Vec<Injected> =
        each.map(|fault| Injected { start_s: fault.start_s(), what: fault.words() }).collect();
    faults.sort_by(|a, b| a.start_s.total_cmp(&b.start_s));
    faults
}

/// Table, final rest and faults for the terminal.
pub(crate) fn summary_text(tracking: &BTreeMap<CompensationVariant, TrackingNumbers>) -> String {
    let mut text = tracking_table(tracking);
    for hold in tracking.values().filter_map(|numbers| numbers.hold) {
        let e = hold.end_point_error_m;
        let [mean, max, offsets] = [e.mean, e.max, hold.unseen_error_m].map(|m| number(Some(1e3 * m)));
        if e.mean.is_finite() {
            text += &format!(
                "Mean error while holding: {mean} mm (max {max}), by the encoders' zero offsets alone: \
                    {offsets} mm\n"
            );
        }
        // What is below a tenth of a millinewton is rounding.
        let ripple = if hold.tension_ripple_n < 1e-4 { 0.0 } else { hold.tension_ripple_n };
        text += &format!("Tension ripple while holding: {} N rms\n", number(Some(ripple)));
    }
    for incident in tracking.values().flat_map(|numbers| &numbers.incidents) {
        text += &format!(
            "{:.3} to {:.3} s: {}, {}\n",
            incident.from_s,
            incident.until_s,
            incident.what,
            response(incident)
        );
    }
    for found in tracking.values().flat_map(|numbers| &numbers.health) {
        let left =
            found.remaining_s.map_or(String::new(), |s| format!(", at its limit in {:.0} min", s / 60.0));
        let (change, error) = (100.0 * found.drift, 100.0 * found.error);
        text += &format!(
            "{} of {}: {change:.0} +- {error:.0} %{left}\n",
            found.kind.replace('_', " "),
            found.muscle
        );
    }
    text
}

/// How a run ended, by its result as well.
pub(crate) fn ended(numbers: &TrackingNumbers) -> String {
    match numbers.ended {
        TrackOutcome::Completed => "completed".to_owned(),
        TrackOutcome::Inaccurate => numbers.reason.clone().unwrap_or_default(),
        TrackOutcome::Stopped => {
            let reason = numbers.reason.as_deref().or(numbers.stopped_by.as_deref());
            format!("stopped: {}", reason.unwrap_or("fault"))
        }
        TrackOutcome::Diverged => {
            let reason = numbers.reason.as_deref().map(|reason| format!(": {reason}"));
            "diverged".to_owned() + &reason.unwrap_or_default()
        }
    }
}

/// The errors of one kind of joints, where there are such joints.
type RangeOf = fn(&TrackingNumbers) -> Option<ErrorRange>;

/// Errors by compensation variant: of the end point, or of the joints of a machine without one.
pub(crate) fn tracking_table(tracking: &BTreeMap<CompensationVariant, TrackingNumbers>) -> String {
    let milli = |x: f64| number(Some(1e3 * x));
    let has_end_point = tracking.values().any(|n| n.end_point_error_m.mean.is_finite());
    let has = |range: RangeOf| tracking.values().any(|n| range(n).is_some());
    let joints: [(&str, RangeOf); 4] = [
        ("mean joint error, mrad", |n| n.joint_error_rad),
        ("mean joint error, mm", |n| n.joint_error_m),
        ("mean closure error, mm", |n| n.closure_error_m),
        ("mean off the manifold, mrad", |n| n.off_manifold_rad),
    ];
    let mut header = vec!["SIMULATED", "ended"];
    let mut cells: BTreeMap<CompensationVariant, Vec<String>> =
        tracking.iter().map(|(variant, n)| (*variant, vec![variant.to_string(), ended(n)])).collect();
    let mut add = |heads: &[&'static str], values: &dyn Fn(&TrackingNumbers) -> Vec<f64>| {
        header.extend(heads);
        for (variant, n) in tracking {
            cells.entry(*variant).or_default().extend(values(n).into_iter().map(milli));
        }
    };
    if has_end_point {
        add(&["mean tracking error, mm", "std", "max", "last repeat"], &|n| {
            let e = &n.end_point_error_m;
            vec![e.mean, e.std, e.max, n.end_point_error_per_repeat_m.last().map_or(e.mean, |last| last.mean)]
        });
    } else {
        for (head, range) in joints.into_iter().filter(|(_, range)| has(*range)) {
            add(&[head, "max"], &|n| range(n).map_or(vec![f64::NAN; 2], |e| vec![e.mean, e.max]));
        }
    }
    add(&["muscle length, mm"], &|n| vec![n.muscle_length_error_m.mean]);
    let mut text = table(&header, &cells.into_values().collect::<Vec<_>>(), 2);
    if let (true, Some(offsets)) = (has_end_point, tracking.values().map(|n| n.unseen_error_m).next()) {
        let [mean, max] = [offsets.mean, offsets.max].map(milli);
        text += &format!("Mean error by the encoders' zero offsets alone: {mean} mm (max {max})\n");
    }
    if !has_end_point && joints[..2].iter().any(|(_, range)| has(*range)) {
        text += "Joint errors are without the zero offsets of the joints' encoders, which only a calibration \
            finds; `sinew log plot` of a recording shows them.\n";
    }
    text
}
