//! A run as rows: reference, truth, sensors and controller at sampled times.

use serde::Serialize;

/// One row of a trace.
#[derive(Debug, Clone, PartialEq, Serialize)]
pub struct TraceRow {
    /// Time since the start of the run, s.
    pub time_s: f64,
    /// Index of the repeat; `None` at rest.
    pub repeat: Option<u32>,
    /// Reference position of the end point, m.
    pub wanted_m: [f64; 3],
    /// True position, m.
    pub end_point_m: [f64; 3],
    /// Reference length of every muscle, m.
    pub length_m: Vec<f64>,
    /// True minus reference length of every muscle, m.
    pub length_error_m: Vec<f64>,
    /// Desired tension at every anchor, N.
    pub wanted_n: Vec<f64>,
    /// True tension at every anchor, N.
    pub anchor_n: Vec<f64>,
    /// True tension at every drive, N.
    pub drive_n: Vec<f64>,
    /// What the controller was asked for, read, believed and commanded.
    pub cycle: CycleSignals,
}

/// Signals of one control cycle.
#[derive(Debug, Clone, PartialEq, Default, Serialize)]
pub struct CycleSignals {
    /// Operating state of the arm, with its fault where there is one.
    pub status: String,
    /// Reference of every independent joint, rad or m: `[joints]`.
    pub joint_reference: Vec<f64>,
    /// Its true coordinate.
    pub joint_true: Vec<f64>,
    /// Its encoder's reading; NaN where it has none.
    pub joint_read: Vec<f64>,
    /// The controller's estimate of it.
    pub joint_believed: Vec<f64>,
    /// Reading of every motor's encoder, m of cable, + toward the motor: `[muscles]`.
    pub winch_read_m: Vec<f64>,
    /// Commanded cable speed, m/s, + toward the motor; NaN where the drive is off or braked.
    pub winch_command_m_per_s: Vec<f64>,
    /// Reading of every load cell, N.
    pub load_cell_n: Vec<f64>,
    /// The controller's estimate of the tension at every anchor, N.
    pub anchor_believed_n: Vec<f64>,
}

/// A run, decimated for figures.
pub type Trace = Vec<TraceRow>;
