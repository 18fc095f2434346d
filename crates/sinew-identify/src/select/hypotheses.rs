//! What a wrong channel would explain: its gain, its offset or its clock.

use crate::conditioning::ConditionedLogs;
use crate::estimation::{estimate_sequence, rmse};
use crate::fit::recipe::Recipe;
use crate::fit::run::Run;
use crate::fit::statistics::quantiles;
use crate::log::{Dataset, Defect, DefectKind, Role};
use crate::training::fit;
use rayon::prelude::*;
use sinew::predictor::Estimator;

/// Samples of a log on which hypotheses are compared.
const SAMPLES: usize = 2000;

/// Shifts that are tried, samples; those between the best and its neighbours follow.
const SHIFTS: [isize; 10] = [-48, -24, -12, -6, -3, 3, 6, 12, 24, 48];

/// Gains between units and of a sensor that is connected the other way round.
const UNIT_GAINS: [(f64, &str); 17] = [
    (1e3, "as between a unit and its thousandth"),
    (1e-3, "as between a unit and its thousandth"),
    (100.0, "as between m and cm"),
    (0.01, "as between m and cm"),
    (10.0, "as between cm and mm"),
    (0.1, "as between cm and mm"),
    (4.448_22, "as between lbf and N"),
    (0.224_809, "as between lbf and N"),
    (9.806_65, "as between kg and N"),
    (0.101_972, "as between kg and N"),
    (25.4, "as between inch and mm"),
    (0.039_370_1, "as between inch and mm"),
    (57.295_8, "as between deg and rad"),
    (0.017_453_3, "as between deg and rad"),
    (2.0, "as of half a bridge"),
    (0.5, "as of half a bridge"),
    (-1.0, "as with the sign reversed"),
];

/// Fraction of the error that an explanation leaves at most.
const LEAVES: f64 = 0.4;

/// What may be wrong with a channel.
#[derive(Debug, Clone, Copy, PartialEq)]
enum Fault {
    /// It reads so many times what it should.
    Gain(f64),
    /// It reads so much more.
    Offset(f64),
    /// It comes so many samples late.
    Shift(isize),
}

/// The fault of one channel of a log that explains most of its error.
#[derive(Debug, Clone)]
pub(crate) struct Explanation {
    place: Place,
    column: String,
    fault: Fault,
    /// Range of the channel, its unit.
    range: f64,
    interval_s: f64,
    /// RMSE of the log as it is, and with the channel corrected; far unit.
    error_before: f64,
    error_after: f64,
    /// Other faults that explain as much.
    others: Vec<(String, Fault)>,
}

/// A channel: an input, or the far side.
#[derive(Debug, Clone, Copy, PartialEq, Eq)]
enum Place {
    Input(usize),
    Far,
}

/// The best explanation of the error of an estimator on the runs of one log.
pub(super) fn explain(
    estimator: &Estimator,
    data: &Dataset,
    runs: &[&Run],
    interval_s: f64,
) -> Option<Explanation> {
    let runs = beginning(runs, SAMPLES);
    let before = error(estimator, &runs, Place::Far, Fault::Shift(0))?;
    let mut tried: Vec<(Place, Fault, f64)> = places(data)
        .into_par_iter()
        .flat_map_iter(|place| hypotheses(estimator, &runs, place))
        .filter(|(.., error)| error.is_finite())
        .collect();
    tried.sort_by(|a, b| a.2.total_cmp(&b.2));
    let &(place, fault, after) = tried.first()?;
    let name = |place: Place| match place {
        Place::Input(k) => data.roles.inputs[k].column.clone(),
        Place::Far => data.roles.far.clone().unwrap_or_default(),
    };
    let as_good = tried.iter().skip(1).filter(|(other, _, error)| *other != place && *error < 1.3 * after);
    let mut others: Vec<(String, Fault)> = Vec::new();
    for (other, fault, _) in as_good {
        if others.iter().all(|(known, _)| *known != name(*other)) {
            others.push((name(*other), *fault));
        }
    }
    Some(Explanation {
        place,
        column: name(place),
        fault,
        range: range(&runs, place),
        interval_s,
        error_before: before,
        error_after: after,
        others,
    })
}

/// Channels that can be wrong: the far side and all inputs but the given ones.
fn places(data: &Dataset) -> Vec<Place> {
    let inputs = data.roles.inputs.iter().enumerate().filter(|(_, input)| input.role != Role::Given);
    inputs.map(|(k, _)| Place::Input(k)).chain([Place::Far]).collect()
}

/// The best gain, offset and shift of one channel, with the errors that they leave.
fn hypotheses(estimator: &Estimator, runs: &[Run], place: Place) -> Vec<(Place, Fault, f64)> {
    let of = |fault: Fault| error(estimator, runs, place, fault).unwrap_or(f64::INFINITY);
    let best = |faults: Vec<Fault>| -> (Fault, f64) {
        let errors = faults.into_iter().map(|fault| (fault, of(fault)));
        errors.min_by(|a, b| a.1.total_cmp(&b.1)).unwrap_or((Fault::Shift(0), f64::INFINITY))
    };
    let mut gains: Vec<f64> = (-8..=8).filter(|k| *k != 0).map(|k| 1.12_f64.powi(k)).collect();
    gains.extend(UNIT_GAINS.iter().map(|(gain, _)| *gain));
    let mut gain = best(gains.into_iter().map(Fault::Gain).collect());
    let range = range(runs, place);
    let mut offset =
        best((-10..=10).filter(|k| *k != 0).map(|k| Fault::Offset(0.1 * f64::from(k) * range)).collect());
    // Between the points of the grids.
    for step in [0.5, 0.25, 0.125_f64] {
        let (Fault::Gain(g), Fault::Offset(o)) = (gain.0, offset.0) else { break };
        let near = [1.12_f64.powf(step), 1.12_f64.powf(-step)].map(|factor| Fault::Gain(g * factor));
        gain = if best(near.to_vec()).1 < gain.1 { best(near.to_vec()) } else { gain };
        let near = [o + 0.1 * step * range, o - 0.1 * step * range].map(Fault::Offset).to_vec();
        offset = if best(near.clone()).1 < offset.1 { best(near) } else { offset };
    }
    let mut shift = best(SHIFTS.map(Fault::Shift).to_vec());
    for step in [8, 4, 2, 1] {
        let Fault::Shift(d) = shift.0 else { break };
        let near = best(vec![Fault::Shift(d - step), Fault::Shift(d + step)]);
        shift = if near.1 < shift.1 { near } else { shift };
    }
    [gain, offset, shift].map(|(fault, error)| (place, fault, error)).to_vec()
}

/// RMSE with a channel corrected by a fault; the far side as it should have been logged stays the scale: a
/// gain of it divides its error, too, so that a small gain is no explanation of everything.
fn error(estimator: &Estimator, runs: &[Run], place: Place, fault: Fault) -> Option<f64> {
    let (mut sum, mut count) = (0.0, 0.0);
    for run in runs {
        let corrected;
        let run = match (place, fault) {
            (_, Fault::Shift(0)) => run,
            _ => {
                corrected = corrected_run(run, place, fault);
                &corrected
            }
        };
        for ((output, far), weight) in estimate_sequence(estimator, run).iter().zip(&run.far).zip(&run.weight)
        {
            sum += weight * (output.mean - far) * (output.mean - far);
            count += weight;
        }
    }
    let rmse = (sum / count).sqrt();
    rmse.is_finite().then_some(rmse)
}

/// A run as it would be without the fault.
fn corrected_run(run: &Run, place: Place, fault: Fault) -> Run {
    let mut corrected = run.clone();
    let n = run.len();
    let right = |value: f64| match fault {
        Fault::Gain(gain) => value / gain,
        Fault::Offset(offset) => value - offset,
        Fault::Shift(_) => value,
    };
    let source = |i: usize| match fault {
        Fault::Shift(late) => i.saturating_add_signed(late),
        _ => i,
    };
    for i in 0..n {
        let from = source(i);
        match place {
            Place::Input(k) => {
                corrected.inputs[i * run.width + k] = right(run.inputs[from.min(n - 1) * run.width + k]);
            }
            Place::Far => corrected.far[i] = right(run.far[from.min(n - 1)]),
        }
        let outside = from >= n || matches!(fault, Fault::Shift(late) if late < 0 && i < late.unsigned_abs());
        if outside {
            corrected.weight[i] = 0.0;
        }
    }
    corrected
}

/// The first samples of runs, `most` in all.
fn beginning(runs: &[&Run], most: usize) -> Vec<Run> {
    let mut left = most;
    let mut parts = Vec::new();
    for run in runs {
        let n = run.len().min(left);
        if n > 0 {
            parts.push(Run {
                log: run.log,
                dt_s: run.dt_s[..n].to_vec(),
                inputs: run.inputs[..n * run.width].to_vec(),
                far: run.far[..n].to_vec(),
                weight: run.weight[..n].to_vec(),
                width: run.width,
            });
        }
        left -= n;
    }
    parts
}

/// Range of a channel between its 1 % and 99 % quantiles.
fn range(runs: &[Run], place: Place) -> f64 {
    let values: Vec<f64> = runs
        .iter()
        .flat_map(|run| match place {
            Place::Input(k) => run.inputs.iter().skip(k).step_by(run.width).copied().collect::<Vec<_>>(),
            Place::Far => run.far.clone(),
        })
        .collect();
    let edge = quantiles(values, &[0.01, 0.99]);
    edge[1] - edge[0]
}

impl Explanation {
    /// RMSE of the log as it is, far unit.
    pub(crate) fn error_before(&self) -> f64 {
        self.error_before
    }

    /// RMSE of the log with the channel corrected, far unit.
    pub(crate) fn error_after(&self) -> f64 {
        self.error_after
    }

    /// Runs of the log as they would be without the fault.
    pub(crate) fn corrected(&self, runs: &[&Run]) -> Vec<Run> {
        runs.iter().map(|run| corrected_run(run, self.place, self.fault)).collect()
    }

    /// The error of the log over that which is left.
    pub(crate) fn improvement(&self) -> f64 {
        self.error_before / self.error_after.max(1e-300)
    }

    /// Whether it leaves little of the error, and no sensor of a sound log is off by as much.
    pub(crate) fn is_convincing(&self) -> bool {
        let large = match self.fault {
            Fault::Gain(gain) => gain < 0.0 || gain.ln().abs() > 0.14,
            Fault::Offset(offset) => offset.abs() > 0.12 * self.range,
            Fault::Shift(samples) => samples.unsigned_abs() >= 2,
        };
        large && self.error_after < LEAVES * self.error_before
    }

    /// The fault in words.
    pub(crate) fn words(&self) -> String {
        let mut words = self.of(&self.column, self.fault);
        for (column, fault) in &self.others {
            words += &format!(", or {}", self.of(column, *fault));
        }
        words
    }

    fn of(&self, column: &str, fault: Fault) -> String {
        match fault {
            Fault::Gain(gain) => {
                let close = |known: f64| (gain / known - 1.0).abs() < 0.03;
                let unit = UNIT_GAINS.iter().find(|(known, _)| close(*known));
                let unit = unit.map_or_else(String::new, |(_, words)| format!(", {words}"));
                format!("`{column}` reads {gain:.3} times what the other logs imply{unit}")
            }
            Fault::Offset(offset) => {
                format!("`{column}` reads {offset:+.3} beside what the other logs imply")
            }
            Fault::Shift(samples) => {
                let ms = 1e3 * self.interval_s * samples.unsigned_abs() as f64;
                let way = if samples > 0 { "late" } else { "early" };
                format!("`{column}` comes {ms:.0} ms too {way} beside the other channels")
            }
        }
    }

    /// As a defect of its log.
    pub(crate) fn defect(&self) -> Defect {
        let kind = if matches!(self.fault, Fault::Shift(_)) { DefectKind::Shifted } else { DefectKind::Gain };
        let sentence = format!(
            "{}, in the whole log: corrected, its error by a model of the others falls to {:.0} %; as it is, \
                the model is a mean of two transmissions",
            self.words(),
            100.0 * self.error_after / self.error_before
        );
        Defect::of_log(kind, &self.column, sentence)
    }
}

/// The channel and the delay, samples, that leaves little of the error in all logs together.
pub(super) fn common_shift(recipe: &Recipe, logs: &ConditionedLogs) -> Option<(String, isize)> {
    let count = logs.data.logs.len().max(1);
    let runs: Vec<Run> = (0..count)
        .flat_map(|log| {
            let of_log: Vec<&Run> = logs.runs.iter().filter(|run| run.log == log).collect();
            beginning(&of_log, 2 * SAMPLES / count)
        })
        .collect();
    let plain = error_in_sample(recipe, &runs)?;
    let far = range(&runs, Place::Far);
    if plain < SMALL * far {
        return None;
    }
    let mut places = places(&logs.data);
    if places.len() == 2 {
        // A near side that is late is a far side that is early.
        places.retain(|place| *place == Place::Far);
    }
    let tried: Vec<(Place, isize)> =
        places.iter().flat_map(|place| SHIFTS.iter().map(move |shift| (*place, *shift))).collect();
    let of = |(place, shift): (Place, isize)| -> f64 {
        let shifted: Vec<Run> =
            runs.iter().map(|run| corrected_run(run, place, Fault::Shift(shift))).collect();
        error_in_sample(recipe, &shifted).unwrap_or(f64::INFINITY)
    };
    let errors: Vec<f64> = tried.par_iter().map(|&t| of(t)).collect();
    let (mut best, mut least) = tried.into_iter().zip(errors).min_by(|a, b| a.1.total_cmp(&b.1))?;
    for step in [6, 3, 1] {
        for near in [best.1 - step, best.1 + step] {
            let error = of((best.0, near));
            if error < least {
                (best, least) = ((best.0, near), error);
            }
        }
    }
    let (place, shift) = best;
    let column = match place {
        Place::Input(k) => logs.data.roles.inputs[k].column.clone(),
        Place::Far => logs.data.roles.far.clone()?,
    };
    (least < LEAVES * plain && shift.unsigned_abs() >= 2).then_some((column, shift))
}

/// Error over the range of the far side below which no shift is looked for.
const SMALL: f64 = 0.015;

/// A recipe's fit on runs, and its error there.
fn error_in_sample(recipe: &Recipe, runs: &[Run]) -> Option<f64> {
    let runs: Vec<&Run> = runs.iter().collect();
    Some(rmse(&fit(recipe, &runs, 0)?, &runs))
}
