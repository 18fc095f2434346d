//! One control cycle as numbers: what the cycle puts into the ring.
//!
//! ```text
//! index | fast columns | slow columns | reference: velocity, acceleration
//! ```

use crate::codes::{bus_code, fault_code, status_code};
use crate::head::CYCLE_COLUMNS;
use sinew::control::tension::Status;
use sinew::drive::DriveCommand;
use sinew_session::{CycleRecord, Plant};

/// Numbers of muscles and joints, and places in a sample.
#[derive(Debug, Clone, Copy, PartialEq, Eq)]
pub(crate) struct Layout {
    pub(crate) muscles: usize,
    pub(crate) joints: usize,
    pub(crate) simulated: bool,
}

impl Layout {
    pub(crate) fn fast(self) -> usize {
        CYCLE_COLUMNS.len() + 5 * self.muscles + self.joints
    }

    pub(crate) fn slow(self) -> usize {
        let truth = if self.simulated { self.joints + 2 * self.muscles } else { 0 };
        2 * self.joints + 2 * self.muscles + truth
    }

    /// Numbers of a sample.
    pub(crate) fn words(self) -> usize {
        1 + self.fast() + self.slow() + 2 * self.joints
    }

    /// Among the fast columns: status, fault.
    pub(crate) const STATUS: usize = 6;
    pub(crate) const FAULT: usize = 7;
    pub(crate) const MODE: usize = 8;
    pub(crate) const MODE_FAULT: usize = 9;

    /// First number of the commands among the fast columns.
    pub(crate) fn commands(self) -> usize {
        CYCLE_COLUMNS.len() + 2 * self.muscles + self.joints
    }
}

/// Writes numbers one after the other.
struct Cursor<'a> {
    words: &'a mut [f64],
    next: usize,
}

impl Cursor<'_> {
    fn put(&mut self, value: f64) {
        if let Some(word) = self.words.get_mut(self.next) {
            *word = value;
        }
        self.next += 1;
    }

    fn put_all(&mut self, values: impl IntoIterator<Item = f64>) {
        values.into_iter().for_each(|value| self.put(value));
    }
}

/// Fills a sample. Nothing is allocated.
///
/// # Shapes
/// `words: [layout.words()]`.
pub(crate) fn fill<P: Plant>(
    words: &mut [f64],
    layout: Layout,
    (index, deadline_us): (u64, f64),
    record: &CycleRecord<'_, P>,
) {
    let mut out = Cursor { words, next: 0 };
    let truth = record.truth();
    let times = record.times;
    let us = |from: u64, to: u64| to.saturating_sub(from) as f64 * 1e-3;
    out.put(index as f64);
    out.put(deadline_us);
    out.put(us(times.deadline, times.woken));
    out.put(us(times.woken, times.read));
    out.put(us(times.read, times.controlled));
    out.put(us(times.controlled, times.written));
    out.put(record.moment.repeat.map_or(-1.0, f64::from));
    let [status, fault] = status_code(record.command.arm.status, record.command.fault);
    out.put_all([status, fault]);
    out.put(f64::from(record.command.mode as u8));
    out.put(record.command.fault.map_or(0.0, fault_code));
    out.put_all(bus_code(record.exchange.fault));
    out.put(match record.command.arm.distribution {
        Status::Optimal => 0.0,
        Status::Infeasible => 1.0,
        Status::NotConverged => 2.0,
    });
    out.put_all(record.feedback.motor.iter().copied());
    out.put_all(record.feedback.tension.iter().copied());
    out.put_all(record.feedback.joint.iter().copied());
    let drives = record.command.arm.drives;
    out.put_all(drives.iter().map(|command| command_code(command)[0]));
    out.put_all(drives.iter().map(|command| command_code(command)[1]));
    out.put_all(drives.iter().map(|command| command_code(command)[2]));
    out.put_all(record.reference.q.iter().copied());
    out.put_all(record.command.arm.q.iter().copied());
    out.put_all(record.command.arm.desired_tension.iter().copied());
    out.put_all(record.command.arm.estimated_tension.iter().copied());
    if layout.simulated {
        let joints = truth.as_ref().map_or(&[][..], |truth| truth.q);
        let cables = truth.as_ref().map_or(&[][..], |truth| truth.cables);
        let missing =
            |present: usize, count: usize| std::iter::repeat_n(f64::NAN, count - present.min(count));
        out.put_all(joints.iter().copied().chain(missing(joints.len(), layout.joints)));
        let [far, near]: [fn(&_) -> f64; 2] =
            [|cable: &sinew::twin::cable::CableReading| cable.tension_out, |cable| cable.tension_in];
        out.put_all(cables.iter().map(far).chain(missing(cables.len(), layout.muscles)));
        out.put_all(cables.iter().map(near).chain(missing(cables.len(), layout.muscles)));
    }
    out.put_all(record.reference.v.iter().copied());
    out.put_all(record.reference.a.iter().copied());
}

/// Kind and up to two numbers of a command.
///
/// | kind | command | numbers |
/// |---|---|---|
/// | 0 | speed of the cable | m/s |
/// | 1 | tension | N; feed-forward of the cable's speed, m/s |
/// | 2 | current | A |
/// | 3, 4 | off, brake | |
#[must_use]
pub fn command_code(command: &DriveCommand) -> [f64; 3] {
    match *command {
        DriveCommand::Velocity(speed) => [0.0, speed, 0.0],
        DriveCommand::Tension { tension, feed } => [1.0, tension, feed],
        DriveCommand::Current(current) => [2.0, current, 0.0],
        DriveCommand::Off => [3.0, 0.0, 0.0],
        DriveCommand::Brake => [4.0, 0.0, 0.0],
    }
}
