//! A run as rows: errors against the truth, and all signals, at sampled times.

use super::stop_reason::fault_name;
use crate::experiment::TrackRow;
use sinew::body::Robot;
use sinew::control::arm::ArmStatus;
use sinew::control::supervisor::Mode;
use sinew_session::signals::{Axis, Frame, Signal};
use std::sync::Arc;

/// One row of a trace.
#[derive(Debug, Clone, PartialEq)]
pub struct TraceRow {
    /// Time since the start of the run, s.
    pub time_s: f64,
    /// Index of the repeat; `None` at rest.
    pub repeat: Option<u32>,
    /// Operating state of the arm, with its fault where there is one.
    pub status: String,
    /// Reference position of the end point, m.
    pub end_point_reference_m: [f64; 3],
    /// True position, m.
    pub end_point_m: [f64; 3],
    /// Reference length of every muscle, m.
    pub length_m: Vec<f64>,
    /// True minus reference length of every muscle, m.
    pub length_error_m: Vec<f64>,
    /// All signals of the cycle.
    pub frame: Frame,
}

/// A run, decimated for figures.
pub type Trace = Vec<TraceRow>;

impl TraceRow {
    /// Of a cycle of a run of a robot.
    #[must_use]
    pub fn new(row: &TrackRow<'_>, robot: &Robot) -> Self {
        let mut frame = Frame::new(Arc::clone(row.layout));
        frame.fill(row.cycle);
        Self {
            time_s: row.time,
            repeat: row.repeat,
            status: status(row, robot),
            end_point_reference_m: row.reference_point,
            end_point_m: row.end_point,
            length_m: row.length.to_vec(),
            length_error_m: row.length_error.to_vec(),
            frame,
        }
    }

    /// Its numbers by their names: errors, and the signals of joints and muscles.
    pub fn columns(&self) -> impl Iterator<Item = (&'static str, &[f64])> {
        let errors = [
            ("end_point_reference_m", &self.end_point_reference_m[..]),
            ("end_point_m", &self.end_point_m),
            ("length_m", &self.length_m),
            ("length_error_m", &self.length_error_m),
        ];
        let signals = Signal::ALL.iter().filter(|signal| signal.row().axis != Axis::Cycle);
        errors.into_iter().chain(signals.map(|signal| (signal.row().name, self.frame.of(*signal))))
    }

    /// The number of a signal of a joint or muscle; NaN where it is missing.
    #[must_use]
    pub fn at(&self, signal: Signal, part: usize) -> f64 {
        self.frame.of(signal).get(part).copied().unwrap_or(f64::NAN)
    }
}

/// Operating state in words.
fn status(row: &TrackRow<'_>, robot: &Robot) -> String {
    if !row.mode.is_controlled() && !matches!(row.mode, Mode::SafeStop | Mode::Fault) {
        return row.mode.name().replace('_', " ");
    }
    match row.command.status {
        ArmStatus::Following => "following".to_owned(),
        ArmStatus::Holding => "holding".to_owned(),
        ArmStatus::Degraded(fault) => format!("degraded: {}", fault_name(fault, robot)),
        ArmStatus::Stopped(fault) => format!("stopped: {}", fault_name(fault, robot)),
    }
}
