//! Equations 10 and 18: how long the cable has become, told in three ways, with and without the joint's sensor.

use crate::Error;
use crate::experiment::bench::{BenchRow, STEP};
use crate::experiment::bench::{BenchRun, MuscleControl, Programme, run};
use rayon::prelude::*;
use sinew::control::compensation::{Compensation, ObserverCompensation};
use sinew::predictor::CableModel;
use sinew::transmission::{Elongation, Perceptron, Sliding};
use sinew::twin::cable::Specimen;
use sinew_identify::fit::perceptron::{TrainOptions, train};

/// Which end's motion a prediction may know beside the near tension.
#[derive(Debug, Clone, Copy, PartialEq, Eq)]
pub enum Reach {
    /// The winch alone.
    NearOnly,
    /// The joint's sensor as well.
    JointSensor,
}

/// Root mean square errors over whole cycles, mm: `[eq. 10, the paper's network, ours]`.
#[derive(Debug, Clone, Copy, PartialEq, Default)]
pub struct ElongationTable {
    /// From the motor's side alone.
    pub near_only: [f64; 3],
    /// With the joint's sensor.
    pub joint_sensor: [f64; 3],
    /// Range of the true elongation, mm.
    pub range: f64,
}

/// Samples between those that a network learns from or is asked at.
const EVERY: usize = 40;
/// Time constants of what the network with memory is told of the past of the near side, s.
const PAST_S: [f64; 4] = [0.05, 0.2, 0.8, 3.0];
/// Winch travel after a reversal that matters, m.
const LONGEST_TRAVEL_M: f64 = 0.15;
/// Speeds of the runs that are asked, m/s.
const ASKED: [f64; 3] = [0.03, 0.07, 0.11];

/// Learns from the calibration runs, asks on runs with other speeds, strokes and swings.
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
    let fresh = ASKED
        .par_iter()
        .map(|speed| other_run(specimen, *speed, model, cycles, seed))
        .collect::<Result<Vec<_>, Error>>()?;
    let law = model.law()?;
    let whole: f64 = law.compliance().iter().sum();
    let eq10 = Elongation::new(whole, 1.0, law.friction_angle(), 1.0, 1.0, 0.0)?;
    let by_law = |row: &View<'_>, reach| {
        let away = row.velocity(reach) < 0.0;
        let sliding = if away { Sliding::AwayFromMotor } else { Sliding::TowardMotor };
        1e3 * eq10.stretch(row.row.sample.tension_in.max(0.0), sliding).unwrap_or(f64::NAN)
    };
    let present = |view: &View<'_>, reach| vec![view.row.sample.tension_in, view.velocity(reach)];
    let past = |view: &View<'_>, reach| {
        let mut row = vec![view.row.sample.tension_in, view.velocity(reach), view.travel];
        row.extend(view.past.iter().flatten());
        row
    };
    let near = |features: &(dyn Fn(&View<'_>, Reach) -> Vec<f64> + Sync)| {
        learned(logs, Reach::NearOnly, features, seed)
    };
    let ((paper, memory), joint) = rayon::join(
        || rayon::join(|| near(&present), || near(&past)),
        || learned(logs, Reach::JointSensor, &present, seed),
    );
    let (paper, memory, joint) = (paper?, memory?, joint?);
    let error = |predict: &dyn Fn(&View<'_>) -> f64| {
        let (mut squares, mut count) = (0.0, 0.0);
        for rows in &fresh {
            views(rows, |view| {
                let error = predict(view) - 1e3 * view.row.stretch;
                squares += error * error;
                count += 1.0;
            });
        }
        f64::sqrt(squares / count)
    };
    let ask = |network: &Perceptron, features: &[f64]| network.evaluate(features).unwrap_or(f64::NAN);
    let stretches = || fresh.iter().flatten().map(|row| 1e3 * row.stretch);
    Ok(ElongationTable {
        near_only: [
            error(&|view| by_law(view, Reach::NearOnly)),
            error(&|view| ask(&paper, &present(view, Reach::NearOnly))),
            error(&|view| ask(&memory, &past(view, Reach::NearOnly))),
        ],
        joint_sensor: [
            error(&|view| by_law(view, Reach::JointSensor)),
            error(&|view| ask(&joint, &present(view, Reach::JointSensor))),
            error(&|view| 1e3 * view.row.estimated_stretch),
        ],
        range: stretches().fold(f64::MIN, f64::max) - stretches().fold(f64::MAX, f64::min),
    })
}

/// A run that no calibration has seen, with the observer looking on.
fn other_run(
    specimen: &Specimen,
    speed: f64,
    model: &CableModel,
    cycles: f64,
    seed: u64,
) -> Result<Vec<BenchRow>, Error> {
    let paper = BenchRun::paper(specimen.clone(), Programme::Calibrate, speed, seed.wrapping_add(7001));
    let wanted = BenchRun { stroke: 0.53, period: 0.83 * 0.53 / speed, ..paper };
    let mut observer = Compensation::Observer(Box::new(ObserverCompensation::new(model)?));
    let mut rows = Vec::new();
    let seconds = 3.0 + cycles * 2.0 * wanted.stroke / speed;
    run(&wanted, MuscleControl::Compensation(&mut observer), seconds, |row| rows.push(*row))?;
    Ok(rows)
}

/// One sample and what is remembered of the near side before it.
struct View<'a> {
    row: &'a BenchRow,
    /// Of the winch and of the anchor, over the last samples, m/s.
    speeds: [f64; 2],
    /// Winch travel since its last reversal, m, held at [`LONGEST_TRAVEL_M`].
    travel: f64,
    /// Near tension and winch speed, smoothed.
    past: [[f64; 2]; PAST_S.len()],
}

impl View<'_> {
    fn velocity(&self, reach: Reach) -> f64 {
        match reach {
            Reach::NearOnly => self.speeds[0],
            Reach::JointSensor => self.speeds[1],
        }
    }
}

/// Every [`EVERY`]th sample of a run from its fourth second on.
fn views(rows: &[BenchRow], mut see: impl FnMut(&View<'_>)) {
    let mut state: Option<(f64, f64, View<'_>)> = None;
    for (k, row) in rows.iter().enumerate() {
        let (motor, anchor, near) = (row.sample.motor, row.sample.anchor, row.sample.tension_in);
        let (last_motor, last_anchor, mut view) = state.take().unwrap_or((
            motor,
            anchor,
            View { row, speeds: [0.0; 2], travel: 0.0, past: [[near, 0.0]; PAST_S.len()] },
        ));
        view.row = row;
        let moved = [motor - last_motor, anchor - last_anchor];
        for (speed, moved) in view.speeds.iter_mut().zip(moved) {
            *speed += STEP / 0.02 * (moved / STEP - *speed);
        }
        let turned = moved[0] * view.travel < 0.0 && moved[0].abs() > 1e-6;
        let travel = if turned { moved[0] } else { view.travel + moved[0] };
        view.travel = travel.clamp(-LONGEST_TRAVEL_M, LONGEST_TRAVEL_M);
        for (past, time) in view.past.iter_mut().zip(PAST_S) {
            past[0] += STEP / time * (near - past[0]);
            past[1] += STEP / time * (view.speeds[0] - past[1]);
        }
        if k % EVERY == 0 && row.time > 3.0 {
            see(&view);
        }
        state = Some((motor, anchor, view));
    }
}

/// A network from these features to the elongation, mm.
fn learned(
    logs: &[Vec<BenchRow>],
    reach: Reach,
    features: &(dyn Fn(&View<'_>, Reach) -> Vec<f64> + Sync),
    seed: u64,
) -> Result<Perceptron, Error> {
    let (mut inputs, mut targets) = (Vec::new(), Vec::new());
    for rows in logs {
        views(rows, |view| {
            inputs.extend(features(view, reach));
            targets.push(1e3 * view.row.stretch);
        });
    }
    let options = TrainOptions { hidden: 30, steps: 60, seed, tolerance: 1e-4, ..TrainOptions::default() };
    let trained = train(&inputs, &targets, &options)?;
    trained
        .network
        .to_perceptron()
        .ok_or_else(|| Error::experiment("network", "weights that are finite", &"others"))
}
