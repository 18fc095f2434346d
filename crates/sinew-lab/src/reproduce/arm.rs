//! The arm's part of the paper: a trajectory tracked by every variant, on an arm that was built with errors.

use crate::arm::{CalibratedArm, EndPointMotion, Trace, TrackingNumbers, TrackingTask, plan, track_arm};
use crate::{CompensationVariant, Error};
use rayon::prelude::*;
use sinew::body::Robot;
use sinew::trajectory::{EndPointPath, Loop};
use std::collections::BTreeMap;
use std::sync::atomic::{AtomicUsize, Ordering};

/// How much of it.
#[derive(Debug, Clone, Copy, PartialEq)]
pub struct ArmOptions {
    /// Of the arm as built and of its sensors' noise.
    pub seed: u64,
    /// Two periods of the path, s.
    pub duration: f64,
    /// Of the default; every other variant goes once.
    pub repeats: u32,
    /// Every variant, or the default beside none.
    pub all: bool,
}

impl ArmOptions {
    /// The paper's: 115 s, six times.
    #[must_use]
    pub fn full(seed: u64) -> Self {
        Self { seed, duration: 115.0, repeats: 6, all: true }
    }

    /// A look in seconds: ten times as fast, once.
    #[must_use]
    pub fn quick(seed: u64) -> Self {
        Self { seed, duration: 11.5, repeats: 1, all: false }
    }
}

/// What the arm did.
#[derive(Debug, Clone)]
pub struct ArmPart {
    /// What was asked for.
    pub options: ArmOptions,
    /// By variant.
    pub tracking: BTreeMap<CompensationVariant, TrackingNumbers>,
    /// The default's run, thinned.
    pub trace: Trace,
    /// Names of the muscles.
    pub muscles: Vec<String>,
}

/// Rows of a trace over one run.
const ROWS: f64 = 3000.0;
/// Rest after the motion, s.
const FINAL_REST_S: f64 = 3.0;

/// Draws an arm, calibrates each of its cables and tracks the paper's path.
///
/// # Errors
/// [`Error::Physics`] where the robot has no key `start` or no site `endpoint`; as [`track_arm`].
pub fn reproduce_arm(
    robot: &Robot,
    options: &ArmOptions,
    progress: &(dyn Fn(&str, f64) + Sync),
) -> Result<ArmPart, Error> {
    let nothing = |what: &'static str| Error::experiment("robot", what, &"none");
    let pose = robot.key("start").ok_or_else(|| nothing("a key pose `start`"))?;
    let site = robot.site("endpoint").ok_or_else(|| nothing("a site `endpoint`"))?;
    let motion = EndPointMotion::ClosedPath(EndPointPath::lm_arm(Loop::Sine));
    let trajectory = plan(robot, site, &motion, pose, options.duration)?;
    progress("calibrating the arm's cables", 0.0);
    let arm = CalibratedArm::new(robot, pose, options.seed)?;
    let variants: Vec<CompensationVariant> = CompensationVariant::ALL
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
            let trace_interval = options.duration * f64::from(repeats) / ROWS;
            let task = TrackingTask {
                trajectory: &trajectory,
                site,
                repeats,
                learning: true,
                final_rest: FINAL_REST_S,
                faults: &[],
                trace_interval,
            };
            let tracked = track_arm(&arm, *variant, &task)?;
            let done = done.fetch_add(1, Ordering::Relaxed) + 1;
            progress("tracking", 0.3 + 0.7 * done as f64 / variants.len() as f64);
            Ok((*variant, tracked))
        })
        .collect::<Result<Vec<_>, Error>>()?;
    let mut part = ArmPart {
        options: *options,
        tracking: BTreeMap::new(),
        trace: Trace::new(),
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
