//! The arm's part of the paper: one trajectory tracked with every compensation variant, on a sampled
//! specimen.

use crate::arm::{CalibratedArm, DesiredMotion, Trace, TrackingNumbers, TrackingTask, plan, track_arm};
use crate::{CompensationVariant, Error};
use rayon::prelude::*;
use sinew::machine::Machine;
use std::collections::BTreeMap;
use std::sync::atomic::{AtomicUsize, Ordering};

/// Extent of the programme.
#[derive(Debug, Clone, Copy, PartialEq)]
pub struct ArmOptions {
    /// Seed of the specimen and of the sensor noise.
    pub seed: u64,
    /// Duration of two periods of the path, s.
    pub duration: f64,
    /// Repeats of the default variant; the others run once.
    pub repeats: u32,
    /// All variants, or the default and no compensation only.
    pub all: bool,
}

impl ArmOptions {
    /// As in the paper: 115 s, six repeats.
    #[must_use]
    pub fn full(seed: u64) -> Self {
        Self { seed, duration: 115.0, repeats: 6, all: true }
    }

    /// A quick run: ten times as fast, one repeat.
    #[must_use]
    pub fn quick(seed: u64) -> Self {
        Self { seed, duration: 11.5, repeats: 1, all: false }
    }
}

/// Results of the arm.
#[derive(Debug, Clone)]
pub struct ArmPart {
    /// Extent of the programme.
    pub options: ArmOptions,
    /// Numbers of every variant.
    pub tracking: BTreeMap<CompensationVariant, TrackingNumbers>,
    /// Trace of the default variant.
    pub trace: Trace,
    /// Names of the muscles.
    pub muscles: Vec<String>,
    /// Names of the independent joints.
    pub joints: Vec<String>,
    /// Their units, rad or m.
    pub joint_units: Vec<String>,
}

/// Rows of a trace.
const TRACE_ROWS: f64 = 3000.0;
/// Rest after the motion, s.
const FINAL_REST_S: f64 = 3.0;

/// Draws an arm, calibrates each of its cables and tracks the paper's path.
///
/// # Errors
/// [`Error::Experiment`] where the machine has no closed path; as [`track_arm`].
pub fn reproduce_arm(
    machine: &Machine,
    options: &ArmOptions,
    progress: &(dyn Fn(&str, f64) + Sync),
) -> Result<ArmPart, Error> {
    let missing = |what: &'static str| Error::experiment("machine", what, &"none");
    let robot = &machine.robot;
    let path = machine.paths.first().ok_or_else(|| missing("a closed path of its end point"))?;
    let motion = DesiredMotion::ClosedPath(path.path.clone());
    let trajectory = plan(machine, &motion, Some(options.duration))?;
    progress("calibrating the arm's cables", 0.0);
    let arm = CalibratedArm::new(machine, options.seed)?;
    let variants: Vec<CompensationVariant> = CompensationVariant::ARM
        .into_iter()
        .filter(|variant| {
            options.all || matches!(variant, CompensationVariant::None | CompensationVariant::Observer)
        })
        .collect();
    let done = AtomicUsize::new(0);
    let runs = variants
        .par_iter()
        .map(|variant| {
            let repeats = if *variant == CompensationVariant::Observer { options.repeats } else { 1 };
            let trace_interval = options.duration * f64::from(repeats) / TRACE_ROWS;
            let task = TrackingTask {
                trajectory: &trajectory,
                repeats,
                learning: true,
                final_rest: FINAL_REST_S,
                faults: &[],
                gains: None,
                trace_interval,
            };
            let tracked = track_arm(&arm, *variant, &task)?;
            let done = done.fetch_add(1, Ordering::Relaxed) + 1;
            progress("tracking", 0.3 + 0.7 * done as f64 / variants.len() as f64);
            Ok((*variant, tracked))
        })
        .collect::<Result<Vec<_>, Error>>()?;
    let joints = robot.independent_joints().into_iter().map(|joint| &robot.parts().joints[joint]);
    let mut part = ArmPart {
        options: *options,
        tracking: BTreeMap::new(),
        trace: Trace::new(),
        joints: joints.clone().map(|joint| joint.name.clone()).collect(),
        joint_units: joints.map(|joint| joint.kind.unit().to_owned()).collect(),
        muscles: robot.parts().tendons.iter().map(|tendon| tendon.name.clone()).collect(),
    };
    for (variant, tracked) in runs {
        part.tracking.insert(variant, tracked.numbers);
        if variant == CompensationVariant::Observer {
            part.trace = tracked.trace;
        }
    }
    Ok(part)
}
