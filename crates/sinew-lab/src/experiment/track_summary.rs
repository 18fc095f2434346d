//! Errors, extreme tensions and faults of a tracking run.

use super::error_peaks::{ErrorPeak, ErrorPeaks};
use super::statistics::Statistics;
use super::track_row::TrackRow;
use sinew::control::arm::{ArmStatus, Fault, Symptom};
use sinew::control::supervisor::{CableHealth, FaultKind, Mode, NamedFault, Threshold};
use sinew::control::tension::Status;

/// Rest after a motion that is not part of the errors at rest, s.
pub const SETTLING: f64 = 2.0;

/// Time over which the controller reported one fault.
#[derive(Debug, Clone, Copy, PartialEq)]
pub struct FaultInterval {
    /// First report, s.
    pub from: f64,
    /// Last report, s.
    pub until: f64,
    /// The fault.
    pub fault: Fault,
    /// Its kind, by its last report.
    pub kind: FaultKind,
    /// Whether it stopped the arm; else operation was degraded.
    pub stopped: bool,
}

/// A mode and when it began.
#[derive(Debug, Clone, Copy, PartialEq)]
pub struct ModeChange {
    /// Time of the cycle, s.
    pub time: f64,
    /// The mode.
    pub mode: Mode,
    /// The fault that led there.
    pub fault: Option<NamedFault>,
}

/// Far tension above the pretension below which a cable is slack, N, at most; of a small machine the fraction
/// [`SLACK_FRACTION`] of what its minimum tension leaves.
const SLACK_TENSION: f64 = 1.0;
/// See [`SLACK_TENSION`], 1.
const SLACK_FRACTION: f64 = 0.2;

/// Far tension below which a cable is slack, N, from its least desired tension and its pretension, N.
pub(super) fn slack_below(least: f64, pretension: f64) -> f64 {
    pretension + (SLACK_FRACTION * (least - pretension)).clamp(0.0, SLACK_TENSION)
}

/// Longest time between two reports of one interval, s.
const MAX_GAP: f64 = 0.1;

/// Errors, extreme tensions and faults of a run.
#[derive(Debug, Clone, PartialEq)]
pub struct TrackSummary {
    /// Distance of the end point from its reference during motion, m.
    pub end_point_error: Statistics,
    /// The same of every repeat.
    pub repeat_error: Vec<Statistics>,
    /// Magnitude of the error of every muscle's length during motion, m: `[muscles]`.
    pub length_error: Vec<Statistics>,
    /// The same as [`end_point_error`](Self::end_point_error) at rest after the motion, from [`SETTLING`] s
    /// on.
    pub hold_error: Statistics,
    /// Fraction of the encoders' zero errors in the end point's error during motion, m: no controller without
    /// a sensor at the end point can compensate it.
    pub encoder_zero_error: Statistics,
    /// And at rest.
    pub hold_encoder_zero_error: Statistics,
    /// Tension at every anchor at rest, N: `[muscles]`.
    pub hold_tension: Vec<Statistics>,
    /// Magnitude of the error of every joint during motion, without the zero errors of the encoders, rad or
    /// m: `[joints]`.
    pub joint_error: Vec<Statistics>,
    /// Magnitude of [`TrackRow::closure_error`] during motion, m: `[muscles]`; empty where motors hold every
    /// joint.
    pub closure_error: Vec<Statistics>,
    /// The same of [`TrackRow::off_manifold`], rad or m: `[joints]`, or empty.
    pub off_manifold: Vec<Statistics>,
    /// The longest that every cable was slack: its far tension less than 1 N above its pretension, of a small
    /// machine less than a fifth of what its minimum tension leaves. `[muscles]`.
    pub slack: Vec<Slack>,
    /// Of the control cycle, s.
    period: f64,
    slack_below: Vec<f64>,
    slack_for: Vec<f64>,
    /// Minimum tension at an anchor, N, and its muscle.
    pub min_anchor_tension: (f64, usize),
    /// Largest tension at a drive's outlet, N, and its muscle.
    pub max_drive_tension: (f64, usize),
    /// Control cycles without tensions within limits that give the torque.
    pub infeasible_cycles: u64,
    /// When the controller stopped the arm, s, and the fault.
    pub stopped: Option<(f64, Fault)>,
    /// The number by which that fault is judged.
    pub threshold: Option<Threshold>,
    /// Control cycles of degraded operation, and its first fault.
    pub degraded: (u64, Option<Fault>),
    /// All faults, in the order in which the controller reported them.
    pub faults: Vec<FaultInterval>,
    /// Modes of the supervisor in their order.
    pub modes: Vec<ModeChange>,
    peaks: ErrorPeaks,
    /// Slow changes of the cables at the end: `[muscles]`, or empty.
    pub health: Vec<CableHealth>,
    /// When the integration of the plant failed, s: the arm was faster than the laws of the cables allow.
    pub plant_failed: Option<f64>,
}

/// When a cable was slack.
#[derive(Debug, Clone, Copy, PartialEq, Default)]
pub struct Slack {
    /// How long, s.
    pub duration: f64,
    /// Index of its muscle.
    pub muscle: usize,
    /// When it was last slack, s.
    pub until: f64,
}

impl TrackSummary {
    /// `slack_below: [muscles]`, N; `ranges: [joints]`, rad or m; `period` of the control cycle, s.
    pub(crate) fn new(slack_below: Vec<f64>, ranges: Vec<f64>, period: f64) -> Self {
        let (muscles, joints) = (slack_below.len(), ranges.len());
        Self {
            period,
            slack_below,
            joint_error: vec![Statistics::default(); joints],
            closure_error: Vec::new(),
            off_manifold: Vec::new(),
            slack: (0..muscles).map(|muscle| Slack { muscle, ..Slack::default() }).collect(),
            slack_for: vec![0.0; muscles],
            end_point_error: Statistics::default(),
            repeat_error: Vec::new(),
            length_error: vec![Statistics::default(); muscles],
            hold_error: Statistics::default(),
            encoder_zero_error: Statistics::default(),
            hold_encoder_zero_error: Statistics::default(),
            hold_tension: vec![Statistics::default(); muscles],
            min_anchor_tension: (f64::INFINITY, 0),
            max_drive_tension: (0.0, 0),
            infeasible_cycles: 0,
            stopped: None,
            threshold: None,
            degraded: (0, None),
            faults: Vec::new(),
            modes: Vec::new(),
            peaks: ErrorPeaks::new(ranges),
            health: Vec::new(),
            plant_failed: None,
        }
    }

    /// The longest slack of some of the muscles.
    #[must_use]
    pub fn longest_slack(&self, of: impl Fn(usize) -> bool) -> Slack {
        let some = self.slack.iter().filter(|slack| of(slack.muscle));
        some.copied().max_by(|a, b| a.duration.total_cmp(&b.duration)).unwrap_or_default()
    }

    pub(super) fn record(&mut self, row: &TrackRow<'_>) {
        for (k, cable) in row.truth.cables.iter().enumerate() {
            let slack = cable.tension_out < self.slack_below[k];
            self.slack_for[k] = if slack { self.slack_for[k] + self.period } else { 0.0 };
            if self.slack_for[k] > self.slack[k].duration {
                self.slack[k] = Slack { duration: self.slack_for[k], muscle: k, until: row.time };
            }
            if cable.tension_out < self.min_anchor_tension.0 {
                self.min_anchor_tension = (cable.tension_out, k);
            }
            if cable.tension_in > self.max_drive_tension.0 {
                self.max_drive_tension = (cable.tension_in, k);
            }
        }
        if self.modes.last().is_none_or(|last| last.mode != row.mode) {
            self.modes.push(ModeChange { time: row.time, mode: row.mode, fault: row.fault });
        }
        self.record_status(row);
        if row.command.distribution != Status::Optimal {
            self.infeasible_cycles += 1;
        }
        let error = distance(row.reference_point, row.end_point);
        let encoder_zero_error = distance(row.reference_point, row.encoder_point);
        if row.rested > SETTLING {
            if error.is_finite() {
                self.hold_error.record(error);
                self.hold_encoder_zero_error.record(encoder_zero_error);
            }
            for (tension, cable) in self.hold_tension.iter_mut().zip(row.truth.cables) {
                tension.record(cable.tension_out);
            }
        }
        if let Some(repeat) = row.repeat {
            self.peaks.record(row, error);
            for (statistics, error) in self.joint_error.iter_mut().zip(row.joint_error) {
                statistics.record(error.abs());
            }
            for (all, errors) in
                [(&mut self.closure_error, row.closure_error), (&mut self.off_manifold, row.off_manifold)]
            {
                all.resize(errors.len(), Statistics::default());
                all.iter_mut().zip(errors).for_each(|(statistics, error)| statistics.record(error.abs()));
            }
            if error.is_finite() {
                self.end_point_error.record(error);
                self.encoder_zero_error.record(encoder_zero_error);
            }
            let repeat = repeat as usize;
            if self.repeat_error.len() <= repeat {
                self.repeat_error.resize(repeat + 1, Statistics::default());
            }
            if error.is_finite() {
                self.repeat_error[repeat].record(error);
            }
            for (statistics, error) in self.length_error.iter_mut().zip(row.length_error) {
                statistics.record(error.abs());
            }
        }
    }

    fn record_status(&mut self, row: &TrackRow<'_>) {
        let time = row.time;
        let (fault, stopped) = match row.command.status {
            ArmStatus::Degraded(fault) => {
                self.degraded = (self.degraded.0 + 1, self.degraded.1.or(Some(fault)));
                (fault, false)
            }
            ArmStatus::Stopped(fault) => {
                self.stopped = self.stopped.or(Some((time, fault)));
                (fault, true)
            }
            ArmStatus::Following | ArmStatus::Holding => match row.fault {
                // Its motion has ended for want of a command.
                Some(NamedFault { fault: Fault::StaleCommand, .. }) if row.mode == Mode::Hold => {
                    (Fault::StaleCommand, false)
                }
                _ => return,
            },
        };
        let named = row.fault.filter(|named| named.fault == fault);
        let kind = named.unwrap_or(NamedFault { fault, symptom: Symptom::Unknown }).kind();
        match self.faults.iter_mut().rev().find(|one| one.fault == fault && one.stopped == stopped) {
            Some(one) if time - one.until < MAX_GAP => (one.until, one.kind) = (time, kind),
            _ => self.faults.push(FaultInterval { from: time, until: time, fault, kind, stopped }),
        }
    }

    /// The largest errors during motion, largest first, at least a second apart.
    #[must_use]
    pub fn peaks(&self) -> Vec<ErrorPeak> {
        self.peaks.sorted()
    }

    /// Largest standard deviation of an anchor's tension at rest, N.
    #[must_use]
    pub fn max_hold_tension_std(&self) -> f64 {
        self.hold_tension.iter().fold(0.0, |most, tension| most.max(tension.std))
    }

    /// Mean over muscles and time of the magnitude of the length errors, m.
    #[must_use]
    pub fn mean_length_error(&self) -> f64 {
        let sum: f64 = self.length_error.iter().map(|statistics| statistics.mean).sum();
        sum / self.length_error.len() as f64
    }
}

/// Distance of two points, m.
fn distance(a: [f64; 3], b: [f64; 3]) -> f64 {
    libm::sqrt((0..3).map(|i| (a[i] - b[i]) * (a[i] - b[i])).sum())
}
