//! A run as rows: reference, truth, sensors and controller at sampled times.

use super::stop_reason::fault_name;
use crate::experiment::TrackRow;
use serde::Serialize;
use sinew::body::Robot;
use sinew::control::arm::ArmStatus;
use sinew::control::supervisor::Mode;
use sinew::drive::DriveCommand;

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

impl TraceRow {
    /// Of a cycle of a run of a robot.
    #[must_use]
    pub fn of(row: &TrackRow<'_>, robot: &Robot) -> Self {
        Self {
            time_s: row.time,
            repeat: row.repeat,
            wanted_m: row.reference_point,
            end_point_m: row.end_point,
            length_m: row.length.to_vec(),
            length_error_m: row.length_error.to_vec(),
            wanted_n: row.command.desired_tension.to_vec(),
            anchor_n: row.truth.cables.iter().map(|cable| cable.tension_out).collect(),
            drive_n: row.truth.cables.iter().map(|cable| cable.tension_in).collect(),
            cycle: CycleSignals {
                status: status(row, robot),
                joint_reference: row.reference.q.clone(),
                joint_true: row.truth.q.to_vec(),
                joint_read: row.reading.joint.clone(),
                joint_believed: row.command.q.to_vec(),
                winch_read_m: row.reading.motor.clone(),
                winch_command_m_per_s: row.command.drives.iter().map(commanded_speed).collect(),
                load_cell_n: row.reading.tension.clone(),
                anchor_believed_n: row.command.estimated_tension.to_vec(),
            },
        }
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

/// Commanded cable speed, m/s; NaN where none is commanded.
fn commanded_speed(command: &DriveCommand) -> f64 {
    match *command {
        DriveCommand::Velocity(speed) => speed,
        DriveCommand::Tension { feed, .. } => feed,
        DriveCommand::Off | DriveCommand::Brake | DriveCommand::Current(_) => f64::NAN,
    }
}
