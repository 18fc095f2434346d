//! What is shown of a run.

use serde::{Deserialize, Serialize};
use sinew::body::Robot;
use sinew_identify::gear::GearFit;
use sinew_lab::CompensationVariant;
use sinew_lab::arm::{TraceRow, TrackingNumbers};
use std::collections::BTreeMap;

/// Gear of a muscle without a load cell.
#[derive(Debug, Clone, Serialize, Deserialize)]
pub struct Gear {
    /// The muscle.
    pub muscle: String,
    /// As the currents of the calibration have told them.
    #[serde(flatten)]
    pub losses: GearFit,
}

/// A fault that was injected into a run.
#[derive(Debug, Clone, PartialEq, Serialize, Deserialize)]
pub struct Injected {
    /// Start, s since the start of the run.
    pub start_s: f64,
    /// A clause in the past tense: `the cable of brachialis broke`.
    pub what: String,
}

/// Results of tracking, as they are shown.
#[derive(Debug)]
pub struct TrackView<'a> {
    /// Above the table.
    pub heading: String,
    /// Below the heading.
    pub lead: String,
    /// By variant.
    pub tracking: &'a BTreeMap<CompensationVariant, TrackingNumbers>,
    /// Trace of the plotted run.
    pub trace: &'a [TraceRow],
    /// Variant of the plotted run.
    pub drawn: CompensationVariant,
    /// Names of the muscles.
    pub names: &'a [String],
    /// Names of the independent joints.
    pub joints: &'a [String],
    /// Their units, rad or m.
    pub joint_units: &'a [String],
    /// Gears that were calibrated.
    pub gears: &'a [Gear],
    /// Faults that were injected into the plotted run, in the order of their starts.
    pub injected: &'a [Injected],
    /// Repeats of the plotted run.
    pub repeats: u32,
    /// Whether the run is that of the paper, whose results are then a row of the table.
    pub paper: bool,
    /// The machine, to be drawn along its path; none where a run is drawn from its record.
    pub robot: Option<&'a Robot>,
}
