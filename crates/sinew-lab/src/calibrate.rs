//! A muscle's compensation from its own calibration runs on the bench: nothing is read from the plant.

use crate::experiment::bench::{BenchRow, BenchRun, MuscleControl, Programme, Stop, run};
use crate::paper::SPEEDS;
use crate::{CompensationVariant, Error};
use rayon::prelude::*;
use sinew::control::compensation::{
    CapstanCompensation, Compensation, NetworkCompensation, ObserverCompensation,
};
use sinew::predictor::CableModel;
use sinew::twin::cable::Specimen;
use sinew_identify::cable::{CableFit, CableLog, FitOptions, fit_cable};
use sinew_identify::fit::perceptron::{TrainOptions, train};

/// How fast the drag is learned after the calibration, 1/(N m): what half a minute of friction warms is followed in as long.
const LEARNING: f64 = 1.0;

/// Samples between those that are kept for the cable's fit: its law does not care.
const EVERY: usize = 6;

/// Simulated calibration runs, one of so many strokes at each of [`SPEEDS`], on this specimen, seen through the bench's
/// sensors.
///
/// # Errors
/// [`Error::Experiment`] where a run ends early; [`Error::Physics`] for a specimen that is none.
pub fn calibration_runs(specimen: &Specimen, strokes: f64, seed: u64) -> Result<Vec<Vec<BenchRow>>, Error> {
    let of = |(k, speed): (usize, &f64)| {
        rows(specimen, *speed, strokes, seed.wrapping_mul(31).wrapping_add(k as u64))
    };
    SPEEDS.par_iter().enumerate().map(of).collect()
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
        CompensationVariant::Capstan => capstan(&calibrated_cable(logs)?),
        CompensationVariant::Observer => observer(&calibrated_cable(logs)?),
        other => Err(Error::experiment("compensation variant", "one that a bench supports", &other)),
    }
}

/// Eqs. 7 and 8 with the numbers of a cable.
///
/// # Errors
/// [`Error::Physics`] for numbers of none.
pub fn capstan(fit: &CableFit) -> Result<Compensation, Error> {
    let pretension = fit.model.parameters.pretension;
    Ok(Compensation::Capstan(CapstanCompensation::new(fit.model.law()?.friction_angle(), pretension)?))
}

/// The observer of a cable.
///
/// # Errors
/// As [`capstan`].
pub fn observer(fit: &CableFit) -> Result<Compensation, Error> {
    Ok(Compensation::Observer(Box::new(ObserverCompensation::new(&fit.model)?)))
}

/// The cable that [`calibration_runs`] show, sought from what the paper's tables tell of its construction.
///
/// # Errors
/// As [`fit_cable`].
pub fn calibrated_cable(logs: &[Vec<BenchRow>]) -> Result<CableFit, Error> {
    let logs: Vec<CableLog> = logs.iter().map(|rows| cable_log(rows, EVERY)).collect();
    let options = FitOptions { samples: 40_000, residuals: 2500, around: false, ..FitOptions::default() };
    let mut fit = fit_cable(&logs, &CableModel::bench(), &options)?;
    fit.model.learning = LEARNING;
    Ok(fit)
}

fn rows(specimen: &Specimen, speed: f64, strokes: f64, seed: u64) -> Result<Vec<BenchRow>, Error> {
    let wanted = BenchRun::paper(specimen.clone(), Programme::Calibrate, speed, seed);
    let seconds = strokes * wanted.stroke / speed;
    let mut rows = Vec::new();
    let stop: Option<Stop> =
        run(&wanted, MuscleControl::Compensation(&mut Compensation::None), seconds, |row| rows.push(*row))?;
    match stop {
        None => Ok(rows),
        Some(stop) => {
            Err(Error::experiment("calibration run", "no cable or drive that gives up", &format!("{stop:?}")))
        }
    }
}

pub(crate) fn cable_log(rows: &[BenchRow], every: usize) -> CableLog {
    let mut log = CableLog::default();
    let mut last = f64::NAN;
    for row in rows.iter().step_by(every) {
        log.push(if last.is_nan() { 0.0 } else { row.time - last }, row.sample, row.far);
        last = row.time;
    }
    log
}

/// Rows that a network of two inputs is trained on, at most: of 500 000 at 1 kHz every ninth says all that its neighbours do.
const MOST_ROWS: usize = 60_000;

/// Eq. 17, from either end's tension and the speed to what friction takes; the whole run, reversals included.
pub(crate) fn networks(logs: &[Vec<BenchRow>], seed: u64) -> Result<NetworkCompensation, Error> {
    let every = logs.iter().map(Vec::len).sum::<usize>().div_ceil(MOST_ROWS).max(1);
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
            .ok_or_else(|| Error::experiment("network", "weights that are finite", &"others"))
    };
    Ok(NetworkCompensation::new(network(|row| row.far)?, network(|row| row.sample.tension_in)?)?)
}

#[cfg(test)]
mod tests {
    use super::*;

    #[test]
    fn a_calibration_knows_the_friction_of_a_specimen_it_has_never_seen() {
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
