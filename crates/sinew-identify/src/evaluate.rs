//! A model against logs: predictions, and how good they are.

use crate::Error;
use crate::log::{Dataset, ReadOptions, Roles, read_with_roles, unit_of};
use crate::select::folds::numeric_quantities;
use serde::Serialize;
use sinew::metrics::Comparison;
use sinew::predictor::{Beyond, Model, Prediction, Predictor, Sample, SpecimenDeviation};

/// Eqs. 14 to 16 with band and size, over some samples.
#[derive(Debug, Clone, PartialEq, Serialize)]
pub struct Scores {
    /// Samples that counted.
    pub n: u64,
    /// Mean squared error, far unit squared.
    pub mse: Option<f64>,
    /// Root mean squared error, far unit.
    pub rmse: Option<f64>,
    /// Pearson correlation; none where a signal is constant.
    pub pearson: Option<f64>,
    /// RMSE as % of the range of the far side in these samples.
    pub percent_of_range: Option<f64>,
    /// Fraction of samples inside the 95 % band.
    pub coverage95: Option<f64>,
    /// Fraction of samples outside the ranges of the training logs; there neither the expected error nor the
    /// band holds.
    pub out_of_range: Option<f64>,
    /// RMSE to expect of these samples, far unit: on unseen data, and beyond the conditions of the training
    /// logs what is expected there.
    pub expected: Option<f64>,
    /// RMSE of the samples inside those ranges, far unit.
    pub rmse_in_range: Option<f64>,
    /// RMSE of the samples outside of them, far unit.
    pub rmse_out_of_range: Option<f64>,
    /// Whether its trials are of the specimen in training; none where no trial shows it.
    pub specimen: Option<SpecimenScore>,
    /// Fraction of samples at which the hysteresis still depends on its unknown beginning: there the band is
    /// as wide as friction allows.
    pub state_unknown: Option<f64>,
}

/// Trials held against the specimen in training.
#[derive(Debug, Clone, Copy, PartialEq, Serialize)]
pub struct SpecimenScore {
    /// Trials that were judged: those with loops, by a model with a monitor.
    pub judged: u64,
    /// Trials of another specimen.
    pub other: u64,
    /// The trial that deviates most.
    pub most: SpecimenDeviation,
}

impl SpecimenScore {
    /// The score of trials; none where none was judged.
    pub fn of(trials: impl Iterator<Item = Option<SpecimenDeviation>>) -> Option<Self> {
        trials.flatten().fold(None, |score: Option<Self>, most| {
            let new = Self { judged: 1, other: u64::from(most.excess > 1.0), most };
            Some(score.map_or(new, |old| Self {
                judged: old.judged + 1,
                other: old.other + new.other,
                most: if most.excess > old.most.excess { most } else { old.most },
            }))
        })
    }
}

/// Errors inside and outside the ranges of the training logs.
#[derive(Debug, Clone, Copy, Default)]
struct Compared {
    inside: Comparison,
    outside: Comparison,
    /// Samples whose state is unknown.
    unknown: u64,
}

impl Compared {
    fn merge(&mut self, other: &Self) {
        self.inside.merge(&other.inside);
        self.outside.merge(&other.outside);
        self.unknown += other.unknown;
    }

    fn scores(&self) -> Scores {
        let mut all = self.inside;
        all.merge(&self.outside);
        let fraction = |of: u64| Some(of as f64 / all.count() as f64).filter(|fraction| fraction.is_finite());
        Scores {
            n: all.count(),
            mse: all.mse(),
            rmse: all.rmse(),
            pearson: all.pearson(),
            percent_of_range: all.percent_of_range(None),
            coverage95: all.coverage(),
            out_of_range: fraction(self.outside.count()),
            expected: None,
            rmse_in_range: self.inside.rmse(),
            rmse_out_of_range: self.outside.rmse(),
            specimen: None,
            state_unknown: fraction(self.unknown),
        }
    }
}

/// Scores of one log.
#[derive(Debug, Clone, PartialEq, Serialize)]
pub struct LogScores {
    /// Its name.
    pub log: String,
    /// Whether the model was fitted to a log of this name: such an error is no error on unseen data.
    pub in_training: bool,
    /// Its scores.
    #[serde(flatten)]
    pub scores: Scores,
}

/// Scores of a model on logs.
#[derive(Debug, Clone, PartialEq, Serialize)]
pub struct Evaluation {
    /// The column that is predicted.
    pub far: String,
    /// Its unit, in which the errors are; empty where its name states none.
    pub far_unit: String,
    /// All samples together.
    pub overall: Scores,
    /// Log by log.
    pub logs: Vec<LogScores>,
}

/// The columns a model reads, as roles.
#[must_use]
pub fn roles_of(model: &Model) -> Roles {
    Roles {
        far: Some(model.far.clone()),
        inputs: model.inputs.clone(),
        time: model.time.clone(),
        trial: model.trial.clone(),
        group: None,
        units: model.units.clone(),
    }
}

/// The unit of a column of a model, as its logs stated it; empty where they did not.
#[must_use]
pub fn unit_in(model: &Model, column: &str) -> String {
    model.units.get(column).cloned().unwrap_or_else(|| unit_of(column))
}

/// Columns that are conditions of a model's training logs and none of its inputs.
#[must_use]
pub fn conditions_of(model: &Model) -> Vec<String> {
    let sides = model.outside.iter().flat_map(|outside| &outside.sides);
    let mut columns: Vec<String> = sides.map(|side| side.column.clone()).collect();
    columns.dedup();
    columns.retain(|column| model.inputs.iter().all(|input| input.column != *column));
    columns
}

/// Reads logs with the columns of a model.
///
/// # Errors
/// As [`read_with_roles`].
pub fn read_for(model: &Model, options: &ReadOptions) -> Result<Dataset, Error> {
    let options = ReadOptions { conditions: conditions_of(model), ..options.clone() };
    read_with_roles(&roles_of(model), &options)
}

/// Predictions of a dataset.
#[derive(Debug, Clone)]
pub struct Predictions {
    /// `[sequence][row]`.
    pub rows: Vec<Vec<Prediction>>,
    /// `[sequence]`: how unlike the specimen in training it is at its end; none where that was not judged.
    pub specimen: Vec<Option<SpecimenDeviation>>,
}

/// Predicts every sample of a dataset exactly as a stream would: states are reset where the trial changes,
/// and gaps are the model's to find. With `reading_s`, seconds since the start of a trial, the far end is
/// read once in every trial, at the first sample from then on that has it ([`Predictor::read_far_end`]).
///
/// # Errors
/// As [`Model::validate`].
pub fn predict(model: &Model, data: &Dataset, reading_s: Option<f64>) -> Result<Predictions, Error> {
    let mut predictor = Predictor::new(model.clone())?;
    let width = model.inputs.len();
    let (mut trial, mut due): (Option<(usize, &str)>, Option<f64>) = (None, None);
    let mut all = Predictions { rows: Vec::new(), specimen: Vec::new() };
    for sequence in &data.sequences {
        let this = (sequence.log, sequence.trial.as_str());
        if trial != Some(this) {
            predictor.reset();
            trial = Some(this);
            let start = sequence.time_s.first().copied().unwrap_or_default();
            due = reading_s.map(|seconds| start + seconds);
        }
        let rows = sequence.time_s.iter().zip(sequence.inputs.chunks_exact(width)).zip(&sequence.far);
        let step = |((&time_s, inputs), &far): ((&f64, &[f64]), &f64)| {
            let prediction = predictor.step(&Sample { time_s, inputs });
            if due.is_some_and(|due| time_s >= due) && far.is_finite() {
                let _ = predictor.read_far_end(far);
                due = None;
            }
            prediction
        };
        all.rows.push(rows.map(step).collect());
        all.specimen.push(predictor.specimen());
    }
    Ok(all)
}

/// RMSE to expect of every sequence, far unit; beyond several conditions the largest.
fn expected(model: &Model, data: &Dataset) -> Vec<f64> {
    let quantities = numeric_quantities(data);
    let sides = || model.outside.iter().flat_map(|outside| &outside.sides);
    let of_sequence = |k: usize| {
        let at = |side: &Beyond| {
            let value = quantities.iter().find(|(column, _)| *column == side.column)?.1[k];
            side.includes(value).then(|| side.expected(value))
        };
        sides().filter_map(at).fold(model.provenance.rmse_unseen, f64::max)
    };
    (0..data.sequences.len()).map(of_sequence).collect()
}

/// Scores a model on a dataset that has the far side; `reading_s` as of [`predict`].
///
/// # Errors
/// As [`predict`].
pub fn evaluate(model: &Model, data: &Dataset, reading_s: Option<f64>) -> Result<Evaluation, Error> {
    let predictions = predict(model, data, reading_s)?;
    let mut logs = vec![Compared::default(); data.logs.len()];
    for (sequence, predictions) in data.sequences.iter().zip(&predictions.rows) {
        for (row, prediction) in predictions.iter().enumerate() {
            if sequence.scored[row] {
                let log = &mut logs[sequence.log];
                log.unknown += u64::from(prediction.flags.state_unknown);
                let side = if prediction.flags.out_of_range { &mut log.outside } else { &mut log.inside };
                side.push_with_band(sequence.far[row], prediction.mean, prediction.half_width())?;
            }
        }
    }
    let mut overall = Compared::default();
    logs.iter().for_each(|log| overall.merge(log));
    let specimen = |of: &dyn Fn(usize) -> bool| {
        let trials = data.sequences.iter().zip(&predictions.specimen);
        SpecimenScore::of(trials.filter(|(sequence, _)| of(sequence.log)).map(|(_, found)| *found))
    };
    let expected = expected(model, data);
    let scored = |k: usize| data.sequences[k].scored.iter().filter(|scored| **scored).count() as f64;
    let expected = |of: &dyn Fn(usize) -> bool| {
        let kept = || (0..expected.len()).filter(|k| of(data.sequences[*k].log));
        let squares: f64 = kept().map(|k| scored(k) * expected[k].powi(2)).sum();
        let mean = squares / kept().map(scored).sum::<f64>();
        mean.is_finite().then(|| mean.sqrt())
    };
    let logs = data
        .logs
        .iter()
        .zip(&logs)
        .enumerate()
        .map(|(k, (info, compared))| LogScores {
            log: info.name.clone(),
            in_training: model.provenance.logs.contains(&info.name),
            scores: Scores {
                specimen: specimen(&|log| log == k),
                expected: expected(&|log| log == k),
                ..compared.scores()
            },
        })
        .collect();
    let overall = Scores { specimen: specimen(&|_| true), expected: expected(&|_| true), ..overall.scores() };
    Ok(Evaluation { far: model.far.clone(), far_unit: unit_in(model, &model.far), overall, logs })
}
