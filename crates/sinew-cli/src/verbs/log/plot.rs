//! `sinew log plot`.

use super::command_kinds::CommandKinds;
use super::info::intervals;
use super::rows::{Rows, joint_column};
use super::table;
use crate::answer::{Answer, Content};
use crate::arguments::{General, LogPlotArguments};
use crate::error::Error;
use crate::output::{refuse_overwrite, write_all};
use crate::table::thousandths;
use crate::verbs::recording::{RunSetup, is_recording, read_bytes, recording};
use sinew::body::Poses;
use sinew::machine::Machine;
use sinew::muscle::MuscleDynamics;
use sinew_lab::arm::WrittenFault;
use sinew_record::Head;
use sinew_report::signals::{Group, SignalPage, Signals, page};

/// Rows of the report.
const ROWS: u64 = 3000;

pub(super) fn run(arguments: &LogPlotArguments, general: &General) -> Result<Answer, Error> {
    let LogPlotArguments { file, report } = arguments;
    refuse_overwrite([file], std::slice::from_ref(report), general.no_clobber)?;
    // What is no file on disk is refused as a recording.
    if std::fs::metadata(file).is_ok_and(|about| about.is_file()) && !is_recording(file) {
        return table::run(arguments, general);
    }
    let bytes = read_bytes(file)?;
    let recording = recording(file, &bytes)?;
    let setup = RunSetup::from_recording(file, &recording)?;
    let machine = setup.machine(file, &recording)?;
    let head = &recording.head;
    let mut cycles = 0;
    for block in recording.blocks() {
        cycles += block.map_err(Error::recording(file))?.count as u64;
    }
    let every = (cycles / ROWS).div_ceil(head.stride).max(1) * head.stride;
    let rows = Rows::all(&recording, every);
    let mut table =
        Table { names: rows.columns.iter().map(|c| c.name.clone()).collect(), columns: Vec::new() };
    table.columns = vec![Vec::new(); table.names.len()];
    rows.each(file, |_, row| {
        table.columns.iter_mut().zip(row).for_each(|(column, value)| column.push(*value));
        Ok(())
    })?;
    let (groups, error) = groups(&table, head, &machine)?;
    // Between following and holding a machine changes all the time.
    let plain =
        |status: &str| status.trim_end_matches(", following").trim_end_matches(", holding").to_owned();
    let states = intervals(file, &recording)?.into_iter().map(|state| (state.from_s, plain(&state.status)));
    let mut states: Vec<(f64, String)> = states.collect();
    states.dedup_by(|later, first| later.1 == first.1);
    let faults = faults(&states);
    let injected = match setup.faults.as_slice() {
        [] => String::new(),
        faults => {
            let words = faults.iter().map(|text| match text.parse::<WrittenFault>() {
                Ok(fault) => format!("{} from {} s on", fault.words(), fault.start_s()),
                Err(_) => text.clone(),
            });
            format!(" Injected faults: {}.", words.collect::<Vec<_>>().join("; "))
        }
    };
    let page = page(&SignalPage {
        title: format!("{} {}", head.machine, setup.motion()),
        kind: "recording",
        amount: format!(
            "{:.3} s, compensation {}, seed {}, recorded by sinew {}.{}{injected}",
            cycles as f64 * head.period_s(),
            setup.compensation,
            setup.seed,
            head.program,
            if recording.complete { "" } else { " The end of the recording is missing." }
        ),
        verdict: error.text(),
        simulated: head.simulated,
        groups,
        states: states.into_iter().map(|(from, words)| (from, once(&words))).collect(),
        faults,
    })?;
    let written = write_all(&[(report.clone(), page.as_bytes())])?;
    let content = if general.json {
        Content::json(&serde_json::json!({
            "machine": head.machine, "simulated": head.simulated, "cycles": cycles,
            "end_point_error_m": error.end_point, "joint_error": error.joint,
        }))?
    } else {
        Content::Text(format!("{}\n", error.text()))
    };
    Ok(Answer::done(content, written))
}

/// Times at which a state with another fault begins, s.
fn faults(states: &[(f64, String)]) -> Vec<f64> {
    let fault = |words: &str| {
        let place = words.find(['(', ':'])?;
        Some(words[place + 1..].split([')', ',']).next().unwrap_or_default().trim().to_owned())
    };
    let mut last = None;
    let mut times = Vec::new();
    for (from, words) in states {
        let now = fault(words);
        if now.is_some() && now != last {
            times.push(*from);
        }
        last = now;
    }
    times
}

/// A state without its fault in brackets where the words behind it name the same one.
fn once(words: &str) -> String {
    let twice = words.split_once(" (").and_then(|(mode, rest)| Some((mode, rest.split_once("), ")?)));
    match twice {
        Some((mode, (fault, status))) if status.ends_with(&format!(": {fault}")) => {
            format!("{mode}, {status}")
        }
        _ => words.to_owned(),
    }
}

/// A time of the cycle in words, with its unit.
fn cycle_time(name: &str) -> String {
    format!("{} (µs)", name.trim_end_matches("_us").replace('_', " "))
}

/// Columns by name.
struct Table {
    names: Vec<String>,
    columns: Vec<Vec<f64>>,
}

impl Table {
    /// A column; empty where there is none.
    fn get(&self, name: &str) -> Vec<f64> {
        let place = self.names.iter().position(|known| known == name);
        place.map_or_else(Vec::new, |place| self.columns[place].clone())
    }
}

/// Errors during the motion, of a run without one those of all cycles: mean and largest.
struct Errors {
    end_point: Option<[f64; 2]>,
    /// None where no joint is measured.
    joint: Option<[f64; 2]>,
    /// Unit of a thousandth of a joint's position.
    unit: &'static str,
    by: &'static str,
    when: &'static str,
}

impl Errors {
    fn text(&self) -> String {
        let Some(joint) = self.joint else { return "No errors: no joint is measured.".to_owned() };
        let joint = joint.map(|x| 1e3 * x);
        let mut text = format!(
            "Errors {} {}: joints {:.3} {} mean, {:.2} max",
            self.when, self.by, joint[0], self.unit, joint[1]
        );
        if let Some(end_point) = self.end_point {
            let [mean, max] = end_point.map(|x| 1e3 * x);
            text += &format!("; end point {mean:.3} mm mean, {max:.2} max");
        }
        text + "."
    }
}

/// Mean and largest of numbers that are there, if any is.
fn spread(values: impl Iterator<Item = f64>) -> Option<[f64; 2]> {
    let (mut sum, mut count, mut max) = (0.0, 0.0, 0.0_f64);
    for x in values.filter(|x| x.is_finite()) {
        (sum, count, max) = (sum + x, count + 1.0, max.max(x));
    }
    (count > 0.0).then_some([sum / count, max])
}

fn groups(table: &Table, head: &Head, machine: &Machine) -> Result<(Vec<Group>, Errors), Error> {
    let time = table.get("time_s");
    let mut moving: Vec<bool> = table.get("repeat").iter().map(|repeat| *repeat >= 0.0).collect();
    let when = if moving.contains(&true) { "during the motion" } else { "of the run" };
    if when == "of the run" {
        // A client leads it: no motion was planned.
        moving.fill(true);
    }
    let (reached_by, legend, by) = if head.simulated {
        ("joint_true", "true", "by the simulated truth, with the design's kinematics")
    } else {
        ("joint", "by the encoders", "by the joint encoders")
    };
    let joints = |what: &str| -> Vec<Vec<f64>> {
        (0..head.joints.len()).map(|k| table.get(&joint_column(head, what, k))).collect()
    };
    let (reference, reached) = (joints("joint_reference"), joints(reached_by));
    let joint_errors = reference.iter().zip(&reached).flat_map(|(a, b)| {
        a.iter().zip(b).zip(&moving).filter(|(_, moving)| **moving).map(|((a, b), _)| (a - b).abs())
    });
    let joint = spread(joint_errors);
    let group = |heading: &str, lead: &str, legend: [&str; 2], plots: Vec<Signals>| Group {
        heading: heading.to_owned(),
        lead: lead.to_owned(),
        legend: legend.map(str::to_owned),
        time: time.clone(),
        plots,
    };
    let mut groups = Vec::new();
    let mut end_point = None;
    if let Some(site) = machine.task.site() {
        let [requested, found] = [points(machine, site, &reference)?, points(machine, site, &reached)?];
        let distance = |k: usize| {
            let squares = (0..3).map(|axis| (requested[axis][k] - found[axis][k]).powi(2));
            squares.sum::<f64>().sqrt()
        };
        let moved = (0..time.len()).filter(|k| moving.get(*k).copied().unwrap_or(false));
        end_point = spread(moved.map(distance));
        // A planar machine stays in its plane.
        let moves = |a: &[f64], b: &[f64]| a.iter().chain(b).any(|x| x.abs() > 1e-9);
        let plots: Vec<Signals> = ["x (m)", "y (m)", "z (m)"]
            .iter()
            .zip(requested.iter().zip(&found))
            .filter(|(_, (a, b))| moves(a, b))
            .map(|(title, (a, b))| Signals { title: (*title).to_owned(), lines: [a.clone(), b.clone()] })
            .collect();
        let error = (0..time.len()).map(|k| 1e3 * distance(k)).collect();
        groups.push(group("End point", "", ["reference", legend], plots));
        let plots = vec![Signals { title: "error (mm)".to_owned(), lines: [Vec::new(), error] }];
        groups.push(group("Error of the end point", "", ["", "distance from the reference"], plots));
    }
    let plots = head
        .joints
        .iter()
        .zip(reference.into_iter().zip(reached))
        .map(|(joint, (a, b))| Signals { title: format!("{} ({})", joint.name, joint.unit), lines: [a, b] });
    groups.push(group("Joints", "", ["reference", legend], plots.collect()));
    let of_muscles = |[first, second]: [&str; 2], unit: &str| -> Vec<Signals> {
        let of = |what: &str, name: &str| table.get(&format!("{what}:{name}"));
        let each = head.muscles.iter().map(|name| Signals {
            title: format!("{name} ({unit})"),
            lines: [of(first, name), of(second, name)],
        });
        each.collect()
    };
    let far = if head.simulated { "tension_out_n" } else { "tension_out_estimated_n" };
    let plots = of_muscles(["tension_out_desired_n", far], "N");
    let far = if head.simulated { "true" } else { "estimated" };
    groups.push(group("Tensions at the anchors", "", ["desired", far], plots));
    let plots = of_muscles(["tension_out_estimated_n", "tension_in_n"], "N");
    let legend = ["at the anchor, estimated", "at the drive, by the load cell"];
    groups.push(group("Tensions at both ends", "", legend, plots));
    let mut plots = of_muscles(["command", ""], "1");
    for (name, plot) in head.muscles.iter().zip(&mut plots) {
        let mut kinds = CommandKinds::default();
        table.get(&format!("command_kind:{name}")).into_iter().for_each(|kind| kinds.see(kind));
        plot.title = format!("{name} ({})", kinds.unit());
    }
    groups.push(group("Commands of the drives", "", ["command", ""], plots));
    if !head.virtual_time {
        let plots = ["wake_up_us", "read_us", "control_us", "write_us"]
            .map(|name| Signals { title: cycle_time(name), lines: [table.get(name), Vec::new()] });
        groups.push(group(
            "Times of the cycle",
            "Sampled: not every cycle is shown.",
            ["time", ""],
            plots.into(),
        ));
    }
    let unit = thousandths(head.joints.iter().map(|joint| joint.unit.as_str()));
    Ok((groups, Errors { end_point, joint, unit, by, when }))
}

/// Positions of a site in a series of poses: x, y, z.
fn points(machine: &Machine, site: usize, joints: &[Vec<f64>]) -> Result<[Vec<f64>; 3], Error> {
    let mut model = MuscleDynamics::new(&machine.robot)?;
    let mut poses = Poses::new(&machine.robot);
    let mut points: [Vec<f64>; 3] = Default::default();
    for k in 0..joints.first().map_or(0, Vec::len) {
        let q: Vec<f64> = joints.iter().map(|joint| joint.get(k).copied().unwrap_or(f64::NAN)).collect();
        let mut origin = [f64::NAN; 3];
        if q.iter().all(|q| q.is_finite()) {
            model.evaluate(&q)?;
            machine.robot.forward_kinematics(model.coordinates(), &mut poses)?;
            origin = machine.robot.site_pose(&poses, site).origin;
        }
        points.iter_mut().zip(origin).for_each(|(column, x)| column.push(x));
    }
    Ok(points)
}

#[cfg(test)]
mod tests {
    use super::*;

    #[test]
    fn a_state_names_its_fault_once_and_a_fault_is_marked_where_it_begins() {
        let degraded = "run (load cell of knee), degraded: load cell of knee";
        assert_eq!(once(degraded), "run, degraded: load cell of knee");
        assert_eq!(once("run, following"), "run, following");
        assert_eq!(once("fault (slack of knee), stopped: load cell of knee").matches("knee").count(), 2);
        let state = |from, words: &str| (from, words.to_owned());
        let states = [
            state(0.0, "run"),
            state(2.0, degraded),
            state(2.5, "hold (load cell of knee)"),
            state(3.0, "run"),
        ];
        assert_eq!(faults(&states), [2.0]);
        assert_eq!(cycle_time("wake_up_us"), "wake up (µs)");
    }
}
