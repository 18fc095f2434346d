//! What is kept of a run that a client commands.

use super::stopping::{By, Stopped};
use sinew::control::arm::{ArmStatus, Fault};
use sinew_lab::experiment::ModeChange;
use sinew_session::CycleRecord;

/// What was seen of a run.
#[derive(Default)]
pub(super) struct Seen {
    pub(super) cycles: u64,
    pub(super) modes: Vec<ModeChange>,
    pub(super) stopped: Option<(f64, Fault)>,
    pub(super) digest: Digest,
}

impl Seen {
    pub(super) fn record<B>(&mut self, record: &CycleRecord<'_, B>) {
        let command = &record.command;
        self.cycles += 1;
        if self.modes.last().is_none_or(|last| last.mode != command.mode) {
            self.modes.push(ModeChange {
                time: record.moment.time,
                mode: command.mode,
                fault: command.fault,
            });
        }
        if let ArmStatus::Stopped(fault) = command.arm.status {
            self.stopped.get_or_insert((record.moment.time, fault));
        }
        record.feedback.motor.iter().chain(&record.feedback.tension).for_each(|x| self.digest.add(*x));
        record.feedback.joint.iter().chain(command.arm.q).for_each(|x| self.digest.add(*x));
    }

    /// How the run ended: by a fault, by a stop from elsewhere, at its time, or because the client turned the machine off.
    pub(super) fn ended(&self, stopped: Option<Stopped>, until: bool) -> &'static str {
        match (self.stopped, stopped.map(|stopped| stopped.by)) {
            (Some(_), _) => "stopped",
            (None, Some(By::Page)) => "stopped_from_page",
            (None, Some(By::Terminal)) => "interrupted",
            (None, None) if until => "as_planned",
            (None, None) => "turned_off",
        }
    }
}

/// FNV-1a over the bits of every reading and estimate: equal for runs that are equal to the bit.
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
