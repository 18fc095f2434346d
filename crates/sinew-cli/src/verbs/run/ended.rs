//! What a run has shown: JSON, text, and the files that were asked for.

use super::door::{Door, Pace};
use super::gears;
use super::stopping::{By, Stopped};
use super::watch::Seen;
use super::{bus, link, ros, timing};
use crate::answer::{Answer, Content, Outcome};
use crate::error::Error;
use crate::output::write_all;
use crate::table::{number, table, thousandths};
use crate::verbs::recording::Ended as Recorded;
use crate::verbs::track::setup::Setup;
use crate::verbs::track::{files, summary_text};
use serde_json::{Value, json};
use sinew::control::supervisor::{CableHealth, Threshold};
use sinew::machine::Machine;
use sinew_lab::arm::{TraceRow, TrackHealth, TrackMode, TrackOutcome, TrackingNumbers, stop_reason};
use sinew_report::tracking::Gear;
use sinew_runtime::cycle::{RealTime, Timing};
use sinew_runtime::link::LinkCounts;
use sinew_session::{BusStatistics, ClockReport};
use std::collections::BTreeMap;

/// Result of a run.
pub(super) struct Ended {
    pub(super) seen: Seen,
    /// A stop from the page or the terminal; errors are those until then.
    pub(super) stopped: Option<Stopped>,
    pub(super) threshold: Option<Threshold>,
    pub(super) health: Vec<CableHealth>,
    /// Errors against the true state of a simulated machine.
    pub(super) tracking: Option<TrackingNumbers>,
    /// Of muscles without a load cell.
    pub(super) gears: Vec<Gear>,
    pub(super) trace: Vec<TraceRow>,
    pub(super) timing: Timing,
    pub(super) real_time: RealTime,
    pub(super) statistics: BusStatistics,
    pub(super) clocks: Option<ClockReport>,
    /// Of a run that a client commanded.
    pub(super) counts: Option<LinkCounts>,
    /// Of a run that was a node of ROS 2.
    pub(super) node: Option<sinew_ros::Counts>,
    pub(super) recording: Option<Recorded>,
}

impl Ended {
    /// Writes the files and says how the run went.
    pub(super) fn answer(self, door: &Door<'_>, setup: &Setup, json: bool) -> Result<Answer, Error> {
        for shortcoming in &self.real_time.shortcomings {
            tell!("warning: {shortcoming}");
        }
        let files = match &self.tracking {
            Some(numbers) => files(door, setup, (numbers, &self.trace), &self.gears)?,
            None => Vec::new(),
        };
        let bytes: Vec<_> = files.iter().map(|(path, text)| (path.clone(), text.as_bytes())).collect();
        let mut written = write_all(&bytes)?;
        let content = if json {
            Content::json(&self.json(door, setup))?
        } else {
            Content::Text(self.text(door, setup))
        };
        let completed = match &self.tracking {
            Some(numbers) => numbers.ended == TrackOutcome::Completed,
            None => self.seen.stopped.is_none(),
        };
        let whole = self.recording.as_ref().is_none_or(|recording| recording.whole);
        let outcome = Outcome::new(completed && self.stopped.is_none() && whole);
        written.extend(self.recording.map(|recording| recording.written));
        Ok(Answer { outcome, content, written })
    }

    /// By a fault, by a stop from elsewhere, at its time, or because the client turned the machine off.
    fn ended(&self, door: &Door<'_>) -> &'static str {
        match (self.seen.stopped, self.stopped.map(|stopped| stopped.by)) {
            (Some(_), _) => "stopped",
            (None, Some(By::Page)) => "stopped_from_page",
            (None, Some(By::Terminal)) => "interrupted",
            (None, None) if door.is_linked() && door.arguments.link.until.is_none() => "turned_off",
            (None, None) => "as_planned",
        }
    }

    fn reason(&self, machine: &Machine) -> Option<String> {
        let (time, fault) = self.seen.stopped?;
        Some(format!("{} at {time:.3} s", stop_reason(fault, self.threshold, &machine.robot)))
    }

    fn json(&self, door: &Door<'_>, setup: &Setup) -> Value {
        let mut all = json!({"simulated": door.is_simulated()});
        if door.is_simulated() {
            all["seed"] = setup.seed.into();
        }
        match &self.tracking {
            Some(numbers) => all["tracking"] = json!(BTreeMap::from([(setup.variant, numbers)])),
            None => all["run"] = self.run_json(door, &setup.machine),
        }
        if !self.gears.is_empty() {
            all["gears"] = json!(self.gears);
        }
        if let Some(counts) = &self.counts {
            all["link"] = link::json(counts);
        }
        if let Some(counts) = &self.node {
            all["ros"] = ros::json(counts);
        }
        all["bus"] = bus::json(&self.statistics, self.clocks);
        if door.pace == Pace::RealTime {
            all["timing_us"] = timing::json(&self.timing);
        }
        if let Some(recording) = &self.recording {
            all["recording"] = recording.json.clone();
        }
        if let Some(stopped) = self.stopped {
            all[stopped.key()] = stopped.time.into();
        }
        all
    }

    /// Of a run without a true state to compare with, or without a motion.
    fn run_json(&self, door: &Door<'_>, machine: &Machine) -> Value {
        let mut run = json!({
            "ended": self.ended(door),
            "reason": self.reason(machine),
            "cycles": self.seen.cycles,
            "degraded_cycles": self.seen.degraded,
            "modes": self.seen.modes.iter().map(TrackMode::new).collect::<Vec<_>>(),
            "health": TrackHealth::new(&self.health, &machine.robot),
        });
        match &self.seen.digest {
            Some(digest) => run["digest"] = format!("{:016x}", digest.0).into(),
            None => {
                let errors = self.seen.joint_error.iter();
                run["joint_error"] = errors
                    .map(|error| match error.is_empty() {
                        true => Value::Null,
                        false => json!({"mean": error.mean, "max": error.max}),
                    })
                    .collect();
            }
        }
        run
    }

    fn text(&self, door: &Door<'_>, setup: &Setup) -> String {
        let mut text = match &self.tracking {
            Some(numbers) => summary_text(&BTreeMap::from([(setup.variant, numbers.clone())])),
            None => self.run_text(door, &setup.machine),
        };
        text += &gears::text(&self.gears);
        text += &self.counts.as_ref().map_or(String::new(), link::text);
        text += &self.node.as_ref().map_or(String::new(), ros::text);
        text += &bus::text(&self.statistics, door.bus, &setup.machine);
        text += &bus::clocks_text(self.clocks);
        if door.pace == Pace::RealTime {
            text += &timing::text(&self.timing);
        }
        text += self.recording.as_ref().map_or("", |recording| &recording.text);
        text + &self.stopped.filter(|_| self.tracking.is_some()).map_or(String::new(), Stopped::text)
    }

    /// Table of the joints, and how the run ended.
    fn run_text(&self, door: &Door<'_>, machine: &Machine) -> String {
        let joints = &machine.robot.parts().joints;
        let independent = machine.robot.independent_joints();
        let mut text = String::new();
        if !door.is_linked() {
            let rows = independent.iter().zip(&self.seen.joint_error).map(|(joint, error)| {
                let of = |x: f64| number((!error.is_empty()).then_some(1e3 * x));
                let errors = [error.mean, error.max].map(of);
                [joints[*joint].name.clone()].into_iter().chain(errors).collect()
            });
            let unit = thousandths(independent.iter().map(|joint| joints[*joint].kind.unit()));
            let mean = format!("error, {unit}: mean");
            text = table(&["joint, by its encoder", &mean, "max"], &rows.collect::<Vec<_>>(), 1);
        }
        let reason = self.reason(machine).map(|reason| format!(": {reason}")).unwrap_or_default();
        let (ended, seconds) = (self.ended(door).replace('_', " "), self.seen.cycles as f64 * machine.period);
        text + &format!("Ended {ended}{reason} after {seconds:.3} s\n")
    }
}
