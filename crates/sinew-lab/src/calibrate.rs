//! Compensation of one cable, identified from calibration runs on the bench: only measurements of the plant
//! are used.

use crate::experiment::bench::{BenchRow, BenchRun, MuscleControl, Programme, Stop, run};
use crate::paper::SPEEDS;
use crate::{CompensationVariant, Error};
use rayon::prelude::*;
use sinew::compensator::CompensatorError;
use sinew::control::compensation::{
    CapstanCompensation, Compensation, NetworkCompensation, ObserverCompensation,
};
use sinew::control::inverse::InverseCompensation;
use sinew::predictor::{CableModel, CableSample};
use sinew::twin::cable::Specimen;
use sinew_identify::cable::{CableFit, CableLog, FitOptions, fit_cable};
use sinew_identify::fit::perceptron::{TrainOptions, train};
use sinew_identify::identify::{Keep, Options, identify};
use sinew_identify::log::{ReadOptions, RequestedRoles, read_bytes};

/// Gain of the observer's drag adaptation in operation, 1/(N m): the lab's choice, near the time constant
/// of the grease's temperature.
const DRAG_ADAPTATION: f64 = 1.0;

/// Decimation of the samples for the fit of the cable.
const DECIMATION: usize = 6;

/// Simulated calibration runs on a specimen, one at each of [`SPEEDS`] with this number of strokes, as
/// measured by the bench's sensors.
///
/// # Errors
/// [`Error::Experiment`] where a run ends early; [`Error::Physics`] for an invalid specimen.
pub fn calibration_runs(specimen: &Specimen, strokes: f64, seed: u64) -> Result<Vec<Vec<BenchRow>>, Error> {
    let run_at = |(k, speed): (usize, &f64)| {
        rows(specimen, *speed, strokes, seed.wrapping_mul(31).wrapping_add(k as u64))
    };
    SPEEDS.par_iter().enumerate().map(run_at).collect()
}

/// The compensation of a variant of [`CompensationVariant::BENCH`], identified from [`calibration_runs`].
///
/// # Errors
/// [`Error::Experiment`] for another variant, and where the runs do not determine it.
pub fn calibrate(
    variant: CompensationVariant,
    logs: &[Vec<BenchRow>],
    seed: u64,
) -> Result<Compensation, Error> {
    match variant {
        CompensationVariant::None => Ok(Compensation::None),
        CompensationVariant::Paper => Ok(Compensation::Network(Box::new(networks(logs, seed)?))),
        CompensationVariant::Inverted => inverted(logs, seed),
        CompensationVariant::Capstan => capstan(&calibrated_cable(logs)?),
        CompensationVariant::Observer => observer(&calibrated_cable(logs)?),
        other => Err(Error::experiment("compensation variant", "one that a bench supports", &other)),
    }
}

/// Static capstan compensation (7, 8) with the parameters of an identified cable.
///
/// # Errors
/// [`Error::Physics`] for invalid parameters.
pub fn capstan(fit: &CableFit) -> Result<Compensation, Error> {
    let pretension = fit.model.parameters.pretension;
    Ok(Compensation::Capstan(CapstanCompensation::new(fit.model.law()?.friction_angle(), pretension)?))
}

/// Observer compensation with an identified cable.
///
/// # Errors
/// As [`capstan`].
pub fn observer(fit: &CableFit) -> Result<Compensation, Error> {
    Ok(Compensation::Observer(Box::new(ObserverCompensation::new(&fit.model)?)))
}

/// The inverse of a model that [`identify()`] makes of the runs as a log: no parameter of the bench is known.
/// Its candidate is the cable's observer, which reads both displacements.
///
/// # Errors
/// As [`identify()`].
pub fn inverted(logs: &[Vec<BenchRow>], seed: u64) -> Result<Compensation, Error> {
    let text: Vec<(String, String)> =
        logs.iter().enumerate().map(|(k, rows)| (format!("speed{}.csv", k + 1), log_text(rows))).collect();
    let files: Vec<(&str, &[u8])> =
        text.iter().map(|(name, text)| (name.as_str(), text.as_bytes())).collect();
    let roles = RequestedRoles { far: Some("tension_out_n".to_owned()), ..RequestedRoles::default() };
    let read = ReadOptions { far_required: true, ..ReadOptions::default() };
    let data = read_bytes(&files, &roles, &read)?;
    let options =
        Options { seed, models: vec!["observer".to_owned()], keep: Keep::All, ..Options::default() };
    let model = identify(&data, &options, &|_, _| {})?.model;
    Ok(Compensation::Inverse(Box::new(InverseCompensation::new(model).map_err(refused)?)))
}

fn refused(error: CompensatorError) -> Error {
    match error {
        CompensatorError::Model(error) => sinew_identify::Error::Model(error).into(),
        CompensatorError::Settings(error) => error.into(),
    }
}

/// A run as a table, as a bench would log it.
fn log_text(rows: &[BenchRow]) -> String {
    let mut text = "time_s,tension_in_n,position_in_m,anchor_m,tension_out_n\n".to_owned();
    for row in rows.iter().step_by(DECIMATION) {
        let CableSample { motor, anchor, tension_in } = row.sample;
        text += &format!("{:.3},{tension_in:.4},{motor:.7},{anchor:.7},{:.4}\n", row.time, row.far);
    }
    text
}

/// The cable identified from [`calibration_runs`], starting from the parameters fitted to the paper's tables.
///
/// # Errors
/// As [`fit_cable`].
pub fn calibrated_cable(logs: &[Vec<BenchRow>]) -> Result<CableFit, Error> {
    let logs: Vec<CableLog> = logs.iter().map(|rows| cable_log(rows.iter().step_by(DECIMATION))).collect();
    let options = FitOptions { samples: 40_000, residuals: 2500, multistart: false, ..FitOptions::default() };
    let mut fit = fit_cable(&logs, &CableModel::bench(), &options)?;
    fit.model.learning = DRAG_ADAPTATION;
    Ok(fit)
}

fn rows(specimen: &Specimen, speed: f64, strokes: f64, seed: u64) -> Result<Vec<BenchRow>, Error> {
    let bench_run = BenchRun::paper(specimen.clone(), Programme::Calibrate, speed, seed);
    let seconds = strokes * bench_run.stroke / speed;
    let mut rows = Vec::new();
    let stop: Option<Stop> =
        run(&bench_run, MuscleControl::Compensation(&mut Compensation::None), seconds, |row| {
            rows.push(*row);
        })?;
    stop.map_or(Ok(rows), |stop| Err(ended_early(stop)))
}

/// The error of a calibration run that did not reach its end.
pub(crate) fn ended_early(stop: Stop) -> Error {
    Error::experiment("calibration run", "no broken cable and no drive fault", &format!("{stop:?}"))
}

pub(crate) fn cable_log<'a>(rows: impl IntoIterator<Item = &'a BenchRow>) -> CableLog {
    let mut log = CableLog::default();
    let mut last = f64::NAN;
    for row in rows {
        log.push(if last.is_nan() { 0.0 } else { row.time - last }, row.sample, row.far);
        last = row.time;
    }
    log
}

/// Limit of the training rows of a network with two inputs: neighbouring samples at 1 kHz are redundant.
const MAX_TRAINING_ROWS: usize = 60_000;

/// The networks of (17): from the tension of either end and the velocity to the friction loss, trained on
/// whole runs, reversals included.
pub(crate) fn networks(logs: &[Vec<BenchRow>], seed: u64) -> Result<NetworkCompensation, Error> {
    let every = logs.iter().map(Vec::len).sum::<usize>().div_ceil(MAX_TRAINING_ROWS).max(1);
    let network = |end: fn(&BenchRow) -> f64| {
        let (mut inputs, mut targets) = (Vec::new(), Vec::new());
        for row in logs.iter().flatten().step_by(every) {
            inputs.extend([end(row), row.velocity]);
            targets.push(row.sample.tension_in - row.far);
        }
        let options =
            TrainOptions { hidden: 30, steps: 60, seed, tolerance: 1e-4, ..TrainOptions::default() };
        let trained = train(&inputs, &targets, &options)?;
        trained
            .network
            .to_perceptron()
            .ok_or_else(|| Error::experiment("network", "finite weights", &"NaN or infinity"))
    };
    Ok(NetworkCompensation::new(network(|row| row.far)?, network(|row| row.sample.tension_in)?)?)
}

#[cfg(test)]
mod tests {
    use super::*;

    #[test]
    fn calibration_identifies_the_friction_angle_of_a_drawn_specimen() {
        let specimen = Specimen::draw(3);
        let logs = calibration_runs(&specimen, 2.0, 1).unwrap();
        let fit = calibrated_cable(&logs).unwrap();
        assert!(fit.rmse < 2.5, "{}", fit.rmse);
        let truth =
            specimen.parameters.friction * specimen.path.angle() - specimen.parameters.efficiency.ln();
        let angle = fit.model.law().unwrap().friction_angle();
        assert!((angle - truth).abs() < 0.06 * truth, "{angle} {truth}");
    }
}
