//! The bench's part of the paper: calibration, Tables I to III, elongation, and other specimens.

use super::elongation::{self, ElongationTable};
use super::mechanism::Mechanism;
use super::results::{
    BenchResults, ByVariant, Efficiency, ElongationMillimetres, Indices, OtherSpecimen, Sides, Stretching,
    WithoutJointEncoder,
};
use super::trial::{TraceRow, Trial, run_trial};
use crate::calibrate::{calibrate, calibrated_cable, calibration_runs, capstan, inverted, observer};
use crate::experiment::bench::{AnchorSource, BenchRun, MuscleControl, Programme};
use crate::paper::SPEEDS;
use crate::{CompensationVariant, Error};
use rayon::prelude::*;
use sinew::control::compensation::Compensation;
use sinew::metrics::Comparison;
use sinew::twin::cable::Specimen;
use std::collections::BTreeMap;
use std::sync::atomic::{AtomicUsize, Ordering};

/// Extent of the programme.
#[derive(Debug, Clone, Copy, PartialEq)]
pub struct BenchOptions {
    /// Seed of all random numbers.
    pub seed: u64,
    /// CalibrationStroke of the calibration at each of the six speeds.
    pub strokes: f64,
    /// Whole cycles of every trial.
    pub cycles: f64,
    /// Number of other specimens.
    pub specimens: u64,
    /// Calibration runs, evenly spaced, from which the inverted model is identified: cross-validation fits it
    /// once without each.
    pub identified: usize,
}

impl BenchOptions {
    /// The whole programme.
    #[must_use]
    pub fn full(seed: u64) -> Self {
        // 500 s of training data as in the paper, with equal numbers of strokes at every speed.
        let stroke_at_each: f64 = SPEEDS
            .map(|v| BenchRun::paper(Specimen::bench(), Programme::Calibrate, v, seed).stroke / v)
            .iter()
            .sum();
        Self { seed, strokes: 500.0 / stroke_at_each, cycles: 3.0, specimens: 5, identified: SPEEDS.len() }
    }

    /// A quick run.
    #[must_use]
    pub fn quick(seed: u64) -> Self {
        Self { seed, strokes: 2.0, cycles: 1.6, specimens: 0, identified: 3 }
    }
}

/// One curve of figures 7 and 8.
#[derive(Debug, Clone)]
pub struct Trace {
    /// Compensation variant.
    pub variant: CompensationVariant,
    /// Index into [`SPEEDS`].
    pub speed: usize,
    /// Two strokes.
    pub rows: Vec<TraceRow>,
}

/// Results of the bench.
#[derive(Debug, Clone)]
pub struct BenchPart {
    /// Extent of the programme.
    pub options: BenchOptions,
    /// Numbers for `results.json`.
    pub results: BenchResults,
    /// Tables II and III with their points.
    pub mechanism: Mechanism,
    /// Curves of figures 7 and 8.
    pub traces: Vec<Trace>,
    /// Root mean square error of the observer's fit, N.
    pub fit_rmse_n: f64,
}

/// Runs the programme; `progress` receives the stage and the completed fraction, 0 to 1.
///
/// # Errors
/// [`Error::Experiment`] where a run ends early.
pub fn reproduce_bench(
    options: &BenchOptions,
    progress: &(dyn Fn(&str, f64) + Sync),
) -> Result<BenchPart, Error> {
    let specimen = Specimen::bench();
    progress("calibration runs", 0.0);
    let logs = calibration_runs(&specimen, options.strokes, options.seed)?;
    let mechanism = Mechanism::new(&logs);
    progress("identification", 0.05);
    let (fit, paper) = rayon::join(
        || calibrated_cable(&logs),
        || calibrate(CompensationVariant::Paper, &logs, options.seed),
    );
    let fit = fit?;
    progress("identification from the log alone", 0.15);
    let every = logs.len().div_ceil(options.identified.max(1));
    let runs: Vec<_> = logs.iter().skip(every / 2).step_by(every).cloned().collect();
    let compensations = [
        (CompensationVariant::None, Compensation::None),
        (CompensationVariant::Capstan, capstan(&fit)?),
        (CompensationVariant::Paper, paper?),
        (CompensationVariant::Inverted, inverted(&runs, options.seed)?),
        (CompensationVariant::Observer, observer(&fit)?),
    ];
    progress("elongation", 0.25);
    let elongation = elongation::table(&specimen, &logs, &fit.model, options.cycles, options.seed)?;
    drop(logs);
    progress("trials", 0.4);
    let mut steerings: Vec<(CompensationVariant, Option<&Compensation>)> =
        compensations.iter().map(|(variant, compensation)| (*variant, Some(compensation))).collect();
    steerings.push((CompensationVariant::Perfect, None));
    let trials = all_speeds(&specimen, &steerings, AnchorSource::JointEncoder, options)?;
    let without_joint_encoder = without_joint_encoder(&specimen, &compensations[4].1, options)?;
    let done = AtomicUsize::new(0);
    let others = (1..=options.specimens)
        .into_par_iter()
        .map(|k| {
            let other = other_specimen(options.seed.wrapping_mul(1000).wrapping_add(k), options);
            let done = done.fetch_add(1, Ordering::Relaxed) + 1;
            progress("other specimens", 0.5 + 0.5 * done as f64 / options.specimens as f64);
            other
        })
        .collect::<Result<Vec<_>, Error>>()?;
    let traces = trials.iter().flat_map(|(variant, trials)| {
        let traces = trials.iter().enumerate();
        traces.map(|(speed, trial)| Trace { variant: *variant, speed, rows: trial.trace.clone() })
    });
    let table = |of: fn(&Trial) -> &[Comparison; 2], recovery| -> ByVariant {
        trials.iter().map(|(variant, trials)| (*variant, indices(trials, of, recovery))).collect()
    };
    let without =
        trials.iter().find(|(variant, _)| *variant == CompensationVariant::None).map(|(_, trials)| trials);
    let results = BenchResults {
        simulated: true,
        seed: options.seed,
        table1: table(|trial| &trial.scores.achieved, false),
        table1_estimate: table(|trial| &trial.scores.estimated, false),
        table1_cycles: table(|trial| &trial.scores.cycles, true),
        without_joint_encoder,
        table2: Sides::new(|side| Efficiency {
            efficiency: mechanism.efficiency[side].map(|account| account[0]),
            std: mechanism.efficiency[side].map(|account| account[1]),
        }),
        table3: Sides::new(|side| Stretching {
            mean: mechanism.elongation[side].map(|account| account[0]),
            std: mechanism.elongation[side].map(|account| account[1]),
        }),
        elongation_mm: millimetres(&elongation),
        uncompensated_mean_error_n: Sides {
            active: without.map_or(f64::NAN, |trials| mean_of(trials, |trial| trial.tension_loss[0])),
            passive: mechanism.tension_loss[1],
        },
        other_specimens: others,
    };
    let (traces, fit_rmse_n) = (traces.collect(), fit.rmse);
    Ok(BenchPart { options: *options, results, mechanism, traces, fit_rmse_n })
}

/// Every variant at every speed.
fn all_speeds(
    specimen: &Specimen,
    steerings: &[(CompensationVariant, Option<&Compensation>)],
    anchor: AnchorSource,
    options: &BenchOptions,
) -> Result<Vec<(CompensationVariant, Vec<Trial>)>, Error> {
    let jobs: Vec<(usize, f64)> =
        steerings.iter().enumerate().flat_map(|(k, _)| SPEEDS.map(|speed| (k, speed))).collect();
    let trials = jobs
        .into_par_iter()
        .map(|(k, speed)| {
            let seed = options.seed.wrapping_add(100);
            let paper = BenchRun::paper(specimen.clone(), Programme::Track, speed, seed);
            let bench_run = BenchRun { anchor, ..paper };
            let stroke = bench_run.stroke / speed;
            let seconds = 3.0 + 2.0 * stroke * options.cycles;
            // The figure shows a whole cycle.
            let traced = [0.0, 3.0 + 2.0 * stroke];
            match steerings[k].1 {
                Some(compensation) => run_trial(
                    &bench_run,
                    MuscleControl::Compensation(&mut compensation.clone()),
                    seconds,
                    traced,
                ),
                None => run_trial(&bench_run, MuscleControl::Oracle, seconds, traced),
            }
        })
        .collect::<Result<Vec<_>, Error>>()?;
    let mut trials = trials.into_iter();
    Ok(steerings
        .iter()
        .map(|(variant, _)| (*variant, trials.by_ref().take(SPEEDS.len()).collect()))
        .collect())
}

/// The observer with the reference of the motion in place of the joint's encoder.
fn without_joint_encoder(
    specimen: &Specimen,
    observer: &Compensation,
    options: &BenchOptions,
) -> Result<WithoutJointEncoder, Error> {
    let steering = [(CompensationVariant::Observer, Some(observer))];
    let trials = all_speeds(specimen, &steering, AnchorSource::Reference, options)?;
    let trials = &trials[0].1;
    Ok(WithoutJointEncoder {
        table1: indices(trials, |trial| &trial.scores.achieved, false),
        table1_estimate: indices(trials, |trial| &trial.scores.estimated, false),
        table1_cycles: indices(trials, |trial| &trial.scores.cycles, true),
        largest_anchor_error_m: trials.iter().map(|trial| trial.anchor_error).fold(0.0, f64::max),
    })
}

fn other_specimen(seed: u64, options: &BenchOptions) -> Result<OtherSpecimen, Error> {
    let specimen = Specimen::draw(seed);
    let logs = calibration_runs(&specimen, options.strokes, seed)?;
    let compensation = observer(&calibrated_cable(&logs)?)?;
    drop(logs);
    let steerings =
        [(CompensationVariant::Observer, Some(&compensation)), (CompensationVariant::Perfect, None)];
    let trials = all_speeds(&specimen, &steerings, AnchorSource::JointEncoder, options)?;
    let (observed, perfect) = (&trials[0].1, &trials[1].1);
    Ok(OtherSpecimen {
        seed,
        table1: indices(observed, |trial| &trial.scores.achieved, false),
        table1_estimate: indices(observed, |trial| &trial.scores.estimated, false),
        table1_cycles: indices(observed, |trial| &trial.scores.cycles, true),
        perfect_cycles: indices(perfect, |trial| &trial.scores.cycles, true),
    })
}

fn indices(trials: &[Trial], of: fn(&Trial) -> &[Comparison; 2], recovery: bool) -> Sides<Indices> {
    let row = |value: &dyn Fn(&Trial) -> Option<f64>| {
        let mut row = [f64::NAN; 6];
        for (cell, trial) in row.iter_mut().zip(trials) {
            *cell = value(trial).unwrap_or(f64::NAN);
        }
        row
    };
    Sides::new(|side| Indices {
        mse_n2: row(&|trial| of(trial)[side].mse()),
        rmse_n: row(&|trial| of(trial)[side].rmse()),
        pearson: row(&|trial| of(trial)[side].pearson()),
        recovery_s: recovery.then(|| row(&|trial| Some(trial.recovery.seconds[side]))),
    })
}

fn mean_of(trials: &[Trial], of: impl Fn(&Trial) -> f64) -> f64 {
    trials.iter().map(of).sum::<f64>() / trials.len().max(1) as f64
}

fn millimetres(table: &ElongationTable) -> ElongationMillimetres {
    let named = |[eq10, paper, ours]: [f64; 3]| {
        BTreeMap::from([("equation10", eq10), ("paper", paper), ("observer", ours)])
    };
    let near_only = BTreeMap::from([
        ("equation10", table.near_only[0]),
        ("paper", table.near_only[1]),
        ("memory", table.near_only[2]),
    ]);
    ElongationMillimetres { near_only, joint_sensor: named(table.joint_sensor), range: table.range }
}
