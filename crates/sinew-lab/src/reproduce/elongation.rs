//! Equations 10 and 18: the elongation of the cable predicted in three ways, with and without the joint
//! sensor.

use crate::Error;
use crate::experiment::bench::{BenchRow, STEP};
use crate::experiment::bench::{BenchRun, MuscleControl, Programme, run};
use rayon::prelude::*;
use sinew::control::compensation::{Compensation, ObserverCompensation};
use sinew::predictor::CableModel;
use sinew::transmission::{Elongation, Perceptron, Sliding};
use sinew::twin::cable::Specimen;
use sinew_identify::fit::perceptron::{TrainOptions, train};

/// Measurements available to a prediction beside the near tension.
#[derive(Debug, Clone, Copy, PartialEq, Eq)]
pub enum AvailableSensors {
    /// Position of the winch.
    NearOnly,
    /// Positions of winch and joint.
    JointSensor,
}

/// Root mean square errors over whole cycles, mm: `[eq. 10, network of the paper, network with memory or
/// observer]`.
#[derive(Debug, Clone, Copy, PartialEq, Default)]
pub struct ElongationTable {
    /// From signals of the motor side alone.
    pub near_only: [f64; 3],
    /// With the joint sensor.
    pub joint_sensor: [f64; 3],
    /// Range of the true elongation, mm.
    pub range: f64,
}

/// Decimation of training and test samples.
const DECIMATION: usize = 40;
/// Time constants of the low-pass filters that are inputs of the network with memory, s.
const FILTER_TIMES_S: [f64; 4] = [0.05, 0.2, 0.8, 3.0];
/// Saturation of the winch travel since the last reversal, m.
const MAX_TRAVEL_M: f64 = 0.15;
/// Speeds of the test runs, m/s: none of the calibration's.
const TEST_SPEEDS: [f64; 3] = [0.03, 0.07, 0.11];

/// Trains on the calibration runs and tests on runs with other speeds, strokes and periods.
///
/// # Errors
/// As [`run`] and [`train`].
pub(super) fn table(
    specimen: &Specimen,
    logs: &[Vec<BenchRow>],
    model: &CableModel,
    cycles: f64,
    seed: u64,
) -> Result<ElongationTable, Error> {
    let test_runs = TEST_SPEEDS
        .par_iter()
        .map(|speed| test_run(specimen, *speed, model, cycles, seed))
        .collect::<Result<Vec<_>, Error>>()?;
    let law = model.law()?;
    let whole: f64 = law.compliance().iter().sum();
    let eq10 = Elongation::new(whole, 1.0, law.friction_angle(), 1.0, 1.0, 0.0)?;
    let by_law = |row: &Features<'_>, sensors| {
        let away = row.velocity(sensors) < 0.0;
        let sliding = if away { Sliding::AwayFromMotor } else { Sliding::TowardMotor };
        1e3 * eq10.stretch(row.row.sample.tension_in.max(0.0), sliding).unwrap_or(f64::NAN)
    };
    let present = |view: &Features<'_>, sensors| vec![view.row.sample.tension_in, view.velocity(sensors)];
    let with_memory = |view: &Features<'_>, sensors| {
        let mut row = vec![view.row.sample.tension_in, view.velocity(sensors), view.travel];
        row.extend(view.filtered.iter().flatten());
        row
    };
    let near = |features: &(dyn Fn(&Features<'_>, AvailableSensors) -> Vec<f64> + Sync)| {
        trained(logs, AvailableSensors::NearOnly, features, seed)
    };
    let ((paper, memory), joint) = rayon::join(
        || rayon::join(|| near(&present), || near(&with_memory)),
        || trained(logs, AvailableSensors::JointSensor, &present, seed),
    );
    let (paper, memory, joint) = (paper?, memory?, joint?);
    let error = |predict: &dyn Fn(&Features<'_>) -> f64| {
        let (mut squares, mut count) = (0.0, 0.0);
        for rows in &test_runs {
            for_each_sample(rows, |view| {
                let error = predict(view) - 1e3 * view.row.stretch;
                squares += error * error;
                count += 1.0;
            });
        }
        f64::sqrt(squares / count)
    };
    let output = |network: &Perceptron, features: &[f64]| network.evaluate(features).unwrap_or(f64::NAN);
    let stretches = || test_runs.iter().flatten().map(|row| 1e3 * row.stretch);
    Ok(ElongationTable {
        near_only: [
            error(&|view| by_law(view, AvailableSensors::NearOnly)),
            error(&|view| output(&paper, &present(view, AvailableSensors::NearOnly))),
            error(&|view| output(&memory, &with_memory(view, AvailableSensors::NearOnly))),
        ],
        joint_sensor: [
            error(&|view| by_law(view, AvailableSensors::JointSensor)),
            error(&|view| output(&joint, &present(view, AvailableSensors::JointSensor))),
            error(&|view| 1e3 * view.row.estimated_stretch),
        ],
        range: stretches().fold(f64::MIN, f64::max) - stretches().fold(f64::MAX, f64::min),
    })
}

/// A run that is not part of the calibration, with the observer in parallel.
fn test_run(
    specimen: &Specimen,
    speed: f64,
    model: &CableModel,
    cycles: f64,
    seed: u64,
) -> Result<Vec<BenchRow>, Error> {
    let paper = BenchRun::paper(specimen.clone(), Programme::Calibrate, speed, seed.wrapping_add(7001));
    let bench_run = BenchRun { stroke: 0.53, period: 0.83 * 0.53 / speed, ..paper };
    let mut observer = Compensation::Observer(Box::new(ObserverCompensation::new(model)?));
    let mut rows = Vec::new();
    let seconds = 3.0 + cycles * 2.0 * bench_run.stroke / speed;
    run(&bench_run, MuscleControl::Compensation(&mut observer), seconds, |row| rows.push(*row))?;
    Ok(rows)
}

/// One sample with filtered signals of the near side.
struct Features<'a> {
    row: &'a BenchRow,
    /// Filtered speeds of winch and anchor, m/s.
    speeds: [f64; 2],
    /// Winch travel since its last reversal, m, held at [`MAX_TRAVEL_M`].
    travel: f64,
    /// Near tension and winch speed by every filter.
    filtered: [[f64; 2]; FILTER_TIMES_S.len()],
}

impl Features<'_> {
    fn velocity(&self, sensors: AvailableSensors) -> f64 {
        match sensors {
            AvailableSensors::NearOnly => self.speeds[0],
            AvailableSensors::JointSensor => self.speeds[1],
        }
    }
}

/// Every [`DECIMATION`]th sample of a run after its first three seconds.
fn for_each_sample(rows: &[BenchRow], mut visit: impl FnMut(&Features<'_>)) {
    let mut state: Option<(f64, f64, Features<'_>)> = None;
    for (k, row) in rows.iter().enumerate() {
        let (motor, anchor, near) = (row.sample.motor, row.sample.anchor, row.sample.tension_in);
        let (last_motor, last_anchor, mut view) = state.take().unwrap_or((
            motor,
            anchor,
            Features { row, speeds: [0.0; 2], travel: 0.0, filtered: [[near, 0.0]; FILTER_TIMES_S.len()] },
        ));
        view.row = row;
        let moved = [motor - last_motor, anchor - last_anchor];
        for (speed, moved) in view.speeds.iter_mut().zip(moved) {
            *speed += STEP / 0.02 * (moved / STEP - *speed);
        }
        let turned = moved[0] * view.travel < 0.0 && moved[0].abs() > 1e-6;
        let travel = if turned { moved[0] } else { view.travel + moved[0] };
        view.travel = travel.clamp(-MAX_TRAVEL_M, MAX_TRAVEL_M);
        for (past, time) in view.filtered.iter_mut().zip(FILTER_TIMES_S) {
            past[0] += STEP / time * (near - past[0]);
            past[1] += STEP / time * (view.speeds[0] - past[1]);
        }
        if k % DECIMATION == 0 && row.time > 3.0 {
            visit(&view);
        }
        state = Some((motor, anchor, view));
    }
}

/// Trains a network from these inputs to the elongation, mm.
fn trained(
    logs: &[Vec<BenchRow>],
    sensors: AvailableSensors,
    features: &(dyn Fn(&Features<'_>, AvailableSensors) -> Vec<f64> + Sync),
    seed: u64,
) -> Result<Perceptron, Error> {
    let (mut inputs, mut targets) = (Vec::new(), Vec::new());
    for rows in logs {
        for_each_sample(rows, |view| {
            inputs.extend(features(view, sensors));
            targets.push(1e3 * view.row.stretch);
        });
    }
    let options = TrainOptions { hidden: 30, steps: 60, seed, tolerance: 1e-4, ..TrainOptions::default() };
    let trained = train(&inputs, &targets, &options)?;
    trained
        .network
        .to_perceptron()
        .ok_or_else(|| Error::experiment("network", "finite weights", &"NaN or infinity"))
}
