use crate::experiment::{FaultInterval, Statistics, TrackSummary};
use serde::Serialize;
use sinew::body::Robot;
use sinew::control::arm::Fault;

/// Errors of the end point, m.
#[derive(Debug, Clone, Copy, PartialEq, Serialize)]
pub struct ErrorSpread {
    /// Mean distance.
    pub mean: f64,
    /// Its standard deviation.
    pub std: f64,
    /// Largest.
    pub max: f64,
}

impl From<&Statistics> for ErrorSpread {
    fn from(statistics: &Statistics) -> Self {
        Self { mean: statistics.mean, std: statistics.std, max: statistics.max }
    }
}

/// Rest after the motion, from two seconds on.
#[derive(Debug, Clone, Copy, PartialEq, Serialize)]
pub struct Hold {
    /// Of the end point.
    pub end_point_error_m: ErrorSpread,
    /// What the zeros of the joints' encoders alone put it off, m.
    pub unseen_error_m: f64,
    /// Largest standard deviation of a tension at an anchor, N.
    pub tension_unrest_n: f64,
}

/// Errors of the muscles' lengths, m.
#[derive(Debug, Clone, Copy, PartialEq, Serialize)]
pub struct MuscleSpread {
    /// Mean magnitude, over muscles and time.
    pub mean: f64,
    /// Its standard deviation: root mean square of the muscles'.
    pub std: f64,
}

/// Something that was wrong for a while.
#[derive(Debug, Clone, PartialEq, Serialize)]
pub struct TrackIncident {
    /// When the controller first said so, s since the run began.
    pub from_s: f64,
    /// And last.
    pub until_s: f64,
    /// What, and of which muscle or joint.
    pub what: String,
    /// What was done: `bridged` or `stopped`.
    pub answer: &'static str,
}

impl TrackIncident {
    fn new(interval: &FaultInterval, robot: &Robot) -> Self {
        Self {
            from_s: to_milliseconds(interval.from),
            until_s: to_milliseconds(interval.until),
            what: named(interval.fault, robot),
            answer: if interval.stopped { "stopped" } else { "bridged" },
        }
    }
}

/// A time of whole milliseconds, s, without what a sum of them leaves.
fn to_milliseconds(time: f64) -> f64 {
    (1e3 * time).round() / 1e3
}

/// A fault by the name of its muscle or joint.
fn named(fault: Fault, robot: &Robot) -> String {
    let muscle = |k: usize| robot.parts().tendons.get(k).map_or("?", |tendon| tendon.name.as_str());
    let joint = |k| {
        let joint = robot.joint_of_velocity(k).and_then(|joint| robot.parts().joints.get(joint));
        joint.map_or("?", |joint| joint.name.as_str())
    };
    match fault {
        Fault::JointSensor(k) => format!("joint encoder of {}", joint(k)),
        Fault::MotorSensor(k) => format!("motor encoder of {}", muscle(k)),
        Fault::TensionSensor(k) => format!("load cell of {}", muscle(k)),
        Fault::Drive(k) => format!("drive of {}", muscle(k)),
        Fault::Cable(k) => format!("cable of {}", muscle(k)),
        Fault::TrackingError(k) => format!("tracking error of {}", joint(k)),
    }
}

/// What a run is reported by.
#[derive(Debug, Clone, PartialEq, Serialize)]
pub struct TrackingNumbers {
    /// Of the end point.
    pub end_point_error_m: ErrorSpread,
    /// What the zeros of the joints' encoders alone put it off: no controller without a sensor there can do better.
    pub unseen_error_m: ErrorSpread,
    /// Of every repeat by itself: what one showed helps the next.
    pub end_point_error_per_repeat_m: Vec<ErrorSpread>,
    /// At rest after the last, where the run went on so long.
    pub hold: Option<Hold>,
    /// Of all muscles.
    pub muscle_length_error_m: MuscleSpread,
    /// Mean magnitude of every muscle's error, m.
    pub per_muscle: Vec<f64>,
    /// Least tension at an anchor, N.
    pub least_anchor_tension_n: f64,
    /// Greatest tension at a drive, N.
    pub most_drive_tension_n: f64,
    /// When the arm was stopped, s.
    pub stopped_s: Option<f64>,
    /// And why.
    pub stopped_by: Option<String>,
    /// All that was wrong, in the order in which the controller said so.
    pub incidents: Vec<TrackIncident>,
}

impl TrackingNumbers {
    /// The numbers of a run of this robot.
    #[must_use]
    pub fn new(summary: &TrackSummary, robot: &Robot) -> Self {
        let hold = Hold {
            end_point_error_m: (&summary.hold_error).into(),
            unseen_error_m: summary.hold_encoder_zero_error.mean,
            tension_unrest_n: summary.max_hold_tension_std(),
        };
        let muscles = summary.length_error.len().max(1) as f64;
        let squares: f64 =
            summary.length_error.iter().map(|statistics| statistics.std * statistics.std).sum();
        Self {
            end_point_error_m: (&summary.end_point_error).into(),
            unseen_error_m: (&summary.encoder_zero_error).into(),
            end_point_error_per_repeat_m: summary.repeat_error.iter().map(ErrorSpread::from).collect(),
            hold: (!summary.hold_error.is_empty()).then_some(hold),
            muscle_length_error_m: MuscleSpread {
                mean: summary.mean_length_error(),
                std: (squares / muscles).sqrt(),
            },
            per_muscle: summary.length_error.iter().map(|statistics| statistics.mean).collect(),
            least_anchor_tension_n: summary.min_anchor_tension.0,
            most_drive_tension_n: summary.max_drive_tension.0,
            stopped_s: summary.stopped.map(|(time, _)| time).or(summary.plant_failed).map(to_milliseconds),
            stopped_by: summary.stopped.map(|(_, fault)| named(fault, robot)),
            incidents: summary.faults.iter().map(|one| TrackIncident::new(one, robot)).collect(),
        }
    }
}

/// One row of a trace.
#[derive(Debug, Clone, PartialEq, Serialize)]
pub struct TraceRow {
    /// Since the run began, s.
    pub time_s: f64,
    /// Which repeat; none at rest.
    pub repeat: Option<u32>,
    /// Where the end point was to be, m.
    pub wanted_m: [f64; 3],
    /// Where it was.
    pub end_point_m: [f64; 3],
    /// How long every muscle was to be, m.
    pub length_m: Vec<f64>,
    /// By how much every muscle was too long, m.
    pub length_error_m: Vec<f64>,
    /// Tension wanted at every anchor, N.
    pub wanted_n: Vec<f64>,
    /// What it was.
    pub anchor_n: Vec<f64>,
    /// Tension at every drive, N.
    pub drive_n: Vec<f64>,
}

/// A run, thinned for figures.
pub type Trace = Vec<TraceRow>;
