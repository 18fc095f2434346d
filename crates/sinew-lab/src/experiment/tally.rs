//! What is counted of a run: errors of the end point and of every muscle, tensions at their extremes.

use super::arm::{NOTHING, TrackRow, distance};
use sinew::control::arm::{ArmStatus, Fault};
use sinew::control::tension::Status;

/// Mean, standard deviation and largest of a magnitude.
#[derive(Debug, Clone, Copy, PartialEq)]
pub struct Spread {
    /// Mean.
    pub mean: f64,
    /// Standard deviation.
    pub std: f64,
    /// Largest.
    pub max: f64,
    pub(super) count: f64,
    pub(super) squares: f64,
}

impl Spread {
    /// Whether anything was counted.
    #[must_use]
    pub fn any(&self) -> bool {
        self.count > 0.0
    }

    fn count(&mut self, value: f64) {
        // Welford's: the sum of squares about the mean so far.
        self.count += 1.0;
        let off = value - self.mean;
        self.mean += off / self.count;
        self.squares += off * (value - self.mean);
        self.max = self.max.max(value);
        self.std = libm::sqrt(self.squares / self.count);
    }
}

/// Rest after a motion that does not count as held yet, s.
pub const SETTLING: f64 = 2.0;

/// Something that was wrong for a while.
#[derive(Debug, Clone, Copy, PartialEq)]
pub struct Incident {
    /// When the controller first said so, s.
    pub from: f64,
    /// And last.
    pub until: f64,
    /// What.
    pub fault: Fault,
    /// Whether it stopped the arm; else it was degraded.
    pub stopped: bool,
}

/// What is said again within this time is said of the same incident, s.
const SAME_INCIDENT: f64 = 0.1;

/// What became of a run.
#[derive(Debug, Clone, PartialEq)]
pub struct TrackSummary {
    /// Distance of the end point from where it was to be while it moved, m.
    pub end_point_error: Spread,
    /// The same of every repeat by itself: what was learned in one shows in the next.
    pub repeat_error: Vec<Spread>,
    /// Magnitude of the error of every muscle's length while it moved, m: `[muscles]`.
    pub length_error: Vec<Spread>,
    /// The same as [`end_point_error`](Self::end_point_error) at rest after the motion, from [`SETTLING`] s on.
    pub hold_error: Spread,
    /// The same where every joint's encoder reads what is wanted: the share of the encoders' zeros, which no controller
    /// without a sensor at the end point can take away.
    pub unseen_error: Spread,
    /// And at rest.
    pub hold_unseen: Spread,
    /// Tension at every anchor in that time, N: `[muscles]`.
    pub hold_tension: Vec<Spread>,
    /// Least tension at an anchor, N, and of which muscle.
    pub least_anchor: (f64, usize),
    /// Greatest tension at a drive's outlet, N, and of which muscle.
    pub most_drive: (f64, usize),
    /// Milliseconds in which no tensions within limits gave the torque.
    pub infeasible: u64,
    /// When the controller stopped the arm, s, and why.
    pub stopped: Option<(f64, Fault)>,
    /// Milliseconds in which something was missing and degraded, and what it was first.
    pub degraded: (u64, Option<Fault>),
    /// All of what was wrong, in the order in which the controller said so.
    pub incidents: Vec<Incident>,
    /// When the plant itself gave up, s: the arm moved faster than any cable could follow.
    pub lost: Option<f64>,
}

impl TrackSummary {
    pub(super) fn new(muscles: usize) -> Self {
        Self {
            end_point_error: NOTHING,
            repeat_error: Vec::new(),
            length_error: vec![NOTHING; muscles],
            hold_error: NOTHING,
            unseen_error: NOTHING,
            hold_unseen: NOTHING,
            hold_tension: vec![NOTHING; muscles],
            least_anchor: (f64::INFINITY, 0),
            most_drive: (0.0, 0),
            infeasible: 0,
            stopped: None,
            degraded: (0, None),
            incidents: Vec::new(),
            lost: None,
        }
    }

    pub(super) fn count(&mut self, row: &TrackRow<'_>) {
        for (k, cable) in row.truth.cables.iter().enumerate() {
            if cable.tension_out < self.least_anchor.0 {
                self.least_anchor = (cable.tension_out, k);
            }
            if cable.tension_in > self.most_drive.0 {
                self.most_drive = (cable.tension_in, k);
            }
        }
        self.note(row.time, row.command.status);
        match row.command.status {
            ArmStatus::Stopped(fault) if self.stopped.is_none() => self.stopped = Some((row.time, fault)),
            ArmStatus::Degraded(fault) => {
                self.degraded = (self.degraded.0 + 1, self.degraded.1.or(Some(fault)));
            }
            _ => {}
        }
        if row.command.distribution == Status::Infeasible {
            self.infeasible += 1;
        }
        if row.rested > SETTLING {
            self.hold_error.count(distance(row.wanted, row.end_point));
            self.hold_unseen.count(distance(row.wanted, row.read_as_wanted));
            for (spread, cable) in self.hold_tension.iter_mut().zip(row.truth.cables) {
                spread.count(cable.tension_out);
            }
        }
        if let Some(repeat) = row.repeat {
            let off = distance(row.wanted, row.end_point);
            self.end_point_error.count(off);
            self.unseen_error.count(distance(row.wanted, row.read_as_wanted));
            let repeat = repeat as usize;
            if self.repeat_error.len() <= repeat {
                self.repeat_error.resize(repeat + 1, NOTHING);
            }
            self.repeat_error[repeat].count(off);
            for (spread, error) in self.length_error.iter_mut().zip(row.length_error) {
                spread.count(error.abs());
            }
        }
    }

    fn note(&mut self, time: f64, status: ArmStatus) {
        let (fault, stopped) = match status {
            ArmStatus::Degraded(fault) => (fault, false),
            ArmStatus::Stopped(fault) => (fault, true),
            ArmStatus::Following | ArmStatus::Holding => return,
        };
        match self.incidents.iter_mut().rev().find(|one| one.fault == fault && one.stopped == stopped) {
            Some(one) if time - one.until < SAME_INCIDENT => one.until = time,
            _ => self.incidents.push(Incident { from: time, until: time, fault, stopped }),
        }
    }

    /// Largest standard deviation of a tension at rest, N.
    #[must_use]
    pub fn hold_unrest(&self) -> f64 {
        self.hold_tension.iter().fold(0.0, |most, spread| most.max(spread.std))
    }

    /// Mean over muscles and time of the magnitude of the length errors, m.
    #[must_use]
    pub fn mean_length_error(&self) -> f64 {
        self.length_error.iter().map(|spread| spread.mean).sum::<f64>() / self.length_error.len() as f64
    }
}
