//! Who looks at every cycle of a run: what is kept of it, the errors of a simulated machine, recording, page,
//! progress.

use super::ros::RunNode;
use super::stopping::Stopping;
use crate::progress::Progress;
use crate::verbs::page::RunPage;
use crate::verbs::recording::Recording;
use sinew::body::Robot;
use sinew::control::arm::{ArmStatus, Fault};
use sinew::control::supervisor::Mode;
use sinew_lab::arm::TraceRow;
use sinew_lab::experiment::{Evaluation, ModeChange, Statistics};
use sinew_runtime::Error;
use sinew_session::{CycleRecord, Plant};
use std::sync::atomic::Ordering;

/// Everyone who looks.
pub(super) struct Watch<'a> {
    pub(super) seen: Seen,
    pub(super) judged: Option<Judged<'a>>,
    pub(super) recording: Option<Recording>,
    pub(super) page: Option<RunPage>,
    pub(super) node: Option<RunNode>,
    pub(super) stopping: Stopping,
    /// With the duration of the run, s; none where it is not known.
    pub(super) progress: Option<(&'a Progress, f64)>,
    /// Whether the run ends where the machine has been released after a fault.
    pub(super) ends_at_fault: bool,
}

/// Cycles between two updates of the progress.
const PROGRESS_CYCLES: u64 = 500;

impl Watch<'_> {
    pub(super) fn see<P: Plant>(&mut self, record: &CycleRecord<'_, P>) -> Result<(), Error> {
        self.seen.record(record);
        if self.ends_at_fault && self.seen.stopped.is_some() && record.command.mode == Mode::Fault {
            self.stopping.at_once().store(true, Ordering::Relaxed);
        }
        if let Some(recording) = &mut self.recording {
            recording.record(record);
        }
        if let Some(page) = &mut self.page {
            page.show(record);
        }
        if let Some(node) = &mut self.node {
            node.show(record);
        }
        self.stopping.see(record);
        if !self.stopping.is_stopping() {
            self.seen.record_errors(record);
            if let Some(judged) = &mut self.judged {
                judged.see(record)?;
            }
        }
        if let Some((progress, duration)) = self.progress
            && self.seen.cycles % PROGRESS_CYCLES == 1
        {
            progress.show("running", record.moment.time / duration);
        }
        Ok(())
    }
}

/// A simulated machine against its true state, and some of its cycles as rows.
pub(super) struct Judged<'a> {
    pub(super) evaluation: Evaluation<'a>,
    pub(super) robot: &'a Robot,
    /// Cycles from row to row; none where no rows are kept.
    pub(super) stride: Option<u64>,
    pub(super) trace: Vec<TraceRow>,
    /// Cycles so far, and time of the last one, s.
    pub(super) count: u64,
    pub(super) time: f64,
}

impl Judged<'_> {
    fn see<P: Plant>(&mut self, record: &CycleRecord<'_, P>) -> Result<(), Error> {
        if record.plant.has_failed() {
            self.evaluation.plant_failed(self.time);
        } else if let Some(arm) = record.plant.simulated() {
            let seen = record.seen();
            let row = self.evaluation.record(&seen, arm)?;
            if self.stride.is_some_and(|stride| self.count.is_multiple_of(stride)) {
                self.trace.push(TraceRow::new(&row, self.robot));
            }
            (self.count, self.time) = (self.count + 1, record.moment.time);
        }
        Ok(())
    }
}

/// What is kept of a run, whatever moves the machine.
pub(super) struct Seen {
    pub(super) cycles: u64,
    pub(super) modes: Vec<ModeChange>,
    pub(super) stopped: Option<(f64, Fault)>,
    pub(super) degraded: u64,
    /// During motion, by the joint encoders: `[joints]`.
    pub(super) joint_error: Vec<Statistics>,
    /// Of a run without a motion of its own.
    pub(super) digest: Option<Digest>,
}

impl Seen {
    pub(super) fn new(joints: usize, linked: bool) -> Self {
        Self {
            cycles: 0,
            modes: Vec::with_capacity(64),
            stopped: None,
            degraded: 0,
            joint_error: vec![Statistics::default(); joints],
            digest: linked.then(Digest::default),
        }
    }

    fn record<P>(&mut self, record: &CycleRecord<'_, P>) {
        let command = &record.command;
        self.cycles += 1;
        if self.modes.last().is_none_or(|last| last.mode != command.mode) {
            let (mode, fault) = (command.mode, command.fault);
            self.modes.push(ModeChange { time: record.moment.time, mode, fault });
        }
        match command.arm.status {
            ArmStatus::Stopped(fault) => {
                self.stopped.get_or_insert((record.moment.time, fault));
            }
            ArmStatus::Degraded(_) => self.degraded += 1,
            ArmStatus::Following | ArmStatus::Holding => {}
        }
        if let Some(digest) = &mut self.digest {
            let feedback = record.feedback;
            let numbers = [&feedback.motor, &feedback.tension, &feedback.joint].into_iter().flatten();
            numbers.chain(command.arm.q).for_each(|x| digest.add(*x));
        }
    }

    fn record_errors<P>(&mut self, record: &CycleRecord<'_, P>) {
        if record.moment.repeat.is_none() {
            return;
        }
        let measured = record.feedback.joint.iter().zip(&record.reference.q);
        for (statistics, (measured, reference)) in self.joint_error.iter_mut().zip(measured) {
            if measured.is_finite() {
                statistics.record((measured - reference).abs());
            }
        }
    }
}

/// FNV-1a over the bits of every reading and estimate: equal for runs that are bit-identical.
pub(super) struct Digest(pub(super) u64);

impl Default for Digest {
    fn default() -> Self {
        Self(0xcbf2_9ce4_8422_2325)
    }
}

impl Digest {
    fn add(&mut self, number: f64) {
        for byte in number.to_bits().to_le_bytes() {
            self.0 = (self.0 ^ u64::from(byte)).wrapping_mul(0x0000_0100_0000_01b3);
        }
    }
}
