//! A replay as a table, as JSON and as a page.

use super::compare::{Compared, Deviation};
use crate::error::Error;
use crate::table::{number, table};
use serde_json::{Value, json};
use sinew_record::{COMMAND, Head};
use sinew_report::signals::{Group, SignalPage, Signals, page as signal_page};
use std::fmt::Write;

/// By whom and with what it was recorded and replayed.
fn builds(head: &Head) -> (String, String) {
    let here = format!("{} ({})", env!("CARGO_PKG_VERSION"), env!("SINEW_COMMIT"));
    (format!("{} ({})", head.program, head.commit), here)
}

pub(super) fn json(all: &Compared, head: &Head) -> Value {
    let period = head.period_s();
    let time = |index: Option<u64>| index.map(|index| index as f64 * period);
    let of = |deviations: &[Deviation], counted: &str| -> Value {
        let rows = head.muscles.iter().zip(deviations).map(|(name, deviation)| {
            json!({
                "muscle": name, "first_s": time(deviation.first), counted: deviation.count,
                "rms": deviation.rms(), "max": deviation.max,
            })
        });
        rows.collect()
    };
    let (recorded_by, replayed_by) = builds(head);
    let references = head.joints.iter().zip(&all.moved_references);
    let references: Value =
        references.map(|(joint, blocks)| json!({"joint": joint.name, "blocks": blocks})).collect();
    json!({
        "machine": head.machine, "simulated": head.simulated,
        "recorded_by": recorded_by, "replayed_by": replayed_by,
        "cycles": all.cycles, "missing_from_s": time(all.gap),
        "reproduced": all.reproduced(), "different_cycles": all.different, "first_difference_s": time(all.first),
        "blocks": all.blocks, "against_recording": of(&all.muscles, "blocks"),
        "moved_references": references,
        "other_controller": all.other.as_ref().map(|other| of(other, "cycles")),
    })
}

pub(super) fn text(all: &Compared, head: &Head) -> String {
    let seconds = |index: u64| format!("{:.3} s", index as f64 * head.period_s());
    let (recorded_by, replayed_by) = builds(head);
    let mut text = format!("Recorded by sinew {recorded_by}, replayed by {replayed_by}\n");
    // Writing to a string does not fail.
    if all.reproduced() {
        let _ = writeln!(text, "{} cycles: every command is the recorded one, bit for bit", all.cycles);
    } else {
        let first = all.first.map_or_else(|| "unknown".to_owned(), seconds);
        let _ = writeln!(
            text,
            "{} cycles: the commands differ in {}, from {first} on; differences within the recording's \
                resolution of {COMMAND} count as 0 below",
            all.cycles, all.different
        );
        let rows: Vec<Vec<String>> = head
            .muscles
            .iter()
            .zip(&all.muscles)
            .filter(|(_, deviation)| deviation.count > 0)
            .map(|(name, deviation)| row(name, deviation, &seconds, &format!("of {} blocks", all.blocks)))
            .collect();
        text += &table(&["muscle", "from", "differs in", "rms, m/s or N", "max"], &rows, 2);
        let moved: Vec<&str> = head
            .joints
            .iter()
            .zip(&all.moved_references)
            .filter(|(_, blocks)| **blocks > 0)
            .map(|(joint, _)| joint.name.as_str())
            .collect();
        let _ = match moved.is_empty() {
            true => {
                writeln!(text, "The references are the recorded ones, bit for bit: the controller differs")
            }
            false => writeln!(text, "The planned motion itself differs for {}", moved.join(", ")),
        };
    }
    if let Some(index) = all.gap {
        let _ =
            writeln!(text, "The recording lacks cycles from {} on; the replay ends there", seconds(index));
    }
    if let Some(other) = &all.other {
        text += "\nThe other controller beside the recorded one, over the same readings:\n";
        let rows = head.muscles.iter().zip(other);
        let rows: Vec<Vec<String>> =
            rows.map(|(name, deviation)| row(name, deviation, &seconds, "cycles")).collect();
        text += &table(&["muscle", "from", "differs in", "rms, m/s or N", "max"], &rows, 2);
    }
    text
}

fn row(name: &str, deviation: &Deviation, seconds: &impl Fn(u64) -> String, unit: &str) -> Vec<String> {
    vec![
        name.to_owned(),
        deviation.first.map_or_else(|| "never".to_owned(), seconds),
        format!("{} {unit}", deviation.count),
        number(Some(deviation.rms())),
        number(Some(deviation.max)),
    ]
}

/// The commands of both, muscle by muscle.
pub(super) fn page(all: &Compared, head: &Head) -> Result<String, Error> {
    let time: Vec<f64> = all.trace.iter().map(|(time, _, _)| *time).collect();
    let of = |k: usize, second: bool| -> Vec<f64> {
        let commands = all.trace.iter().map(|(_, mine, other)| if second { other[k] } else { mine[k] });
        commands.collect()
    };
    let plots = head.muscles.iter().enumerate().map(|(k, name)| Signals {
        title: format!("{name} ({})", all.kinds[k].unit()),
        lines: [of(k, false), of(k, true)],
    });
    let beside = if all.other.is_some() { "other controller" } else { "recorded" };
    let group = Group {
        heading: "Commands".to_owned(),
        lead: "Of every muscle's drive.".to_owned(),
        legend: ["recorded controller, replayed".to_owned(), beside.to_owned()],
        time,
        plots: plots.collect(),
    };
    let verdict = if all.reproduced() {
        format!("{} cycles: every command is the recorded one, bit for bit.", all.cycles)
    } else {
        format!("The commands differ in {} of {} cycles.", all.different, all.cycles)
    };
    Ok(signal_page(&SignalPage {
        title: format!("Replay of {}", head.machine),
        kind: "replay",
        amount: format!("{:.3} s", all.cycles as f64 * head.period_s()),
        verdict,
        simulated: head.simulated,
        groups: vec![group],
        states: Vec::new(),
        faults: Vec::new(),
    })?)
}
