//! A muscle's compensation from its own calibration run on the bench: nothing is read from the plant.

use crate::Error;
use crate::fit::ensemble::unscaled;
use crate::fit::perceptron::{TrainOptions, train};
use crate::observer::{CableFit, CableLog, FitOptions, find_cable};
use rayon::prelude::*;
use sinew::control::compensation::{Compensation, NetworkCompensation, ObserverCompensation};
use sinew::experiment::bench::{BenchRow, BenchRun, Programme, Steering, Stop, run};
use sinew::twin::cable::Specimen;

/// Ways to compensate.
#[derive(Debug, Clone, Copy, PartialEq, Eq)]
pub enum Kind {
    /// None: the drive pulls with what is wanted at the anchor.
    None,
    /// One friction angle and a pretension (7, 8).
    Capstan,
    /// The paper's network (17).
    Paper,
    /// The observer and the inverse of its law.
    Observer,
}

/// A compensation and where it comes from.
#[derive(Debug, Clone)]
pub struct Calibration {
    /// Ready to run.
    pub compensation: Compensation,
    /// The fit of the cable behind it, where there is one.
    pub fit: Option<CableFit>,
}

/// Speeds of the calibration, m/s: those of the paper.
pub const SPEEDS: [f64; 6] = [0.02, 0.04, 0.06, 0.08, 0.10, 0.12];

/// How fast the drag is learned after the calibration, 1/(N m): what half a minute of friction warms is followed in as long.
const LEARNING: f64 = 3.0;

/// Samples between those that are kept for the cable's fit: its law does not care.
const EVERY: usize = 4;

/// Calibrates by a simulated run of `seconds` at each of [`SPEEDS`] on this specimen, seen through the bench's sensors.
///
/// # Errors
/// [`Error::Samples`] where the run ends early or shows too little; [`Error::Physics`] for a specimen that is none.
pub fn calibrate(kind: Kind, specimen: &Specimen, seconds: f64, seed: u64) -> Result<Calibration, Error> {
    let plain = |compensation| Calibration { compensation, fit: None };
    if kind == Kind::None {
        return Ok(plain(Compensation::None));
    }
    let logs = SPEEDS
        .par_iter()
        .enumerate()
        .map(|(k, speed)| rows(specimen, *speed, seconds, seed.wrapping_mul(31).wrapping_add(k as u64)))
        .collect::<Result<Vec<_>, Error>>()?;
    if kind == Kind::Paper {
        return Ok(plain(Compensation::Network(Box::new(networks(&logs, seed)?))));
    }
    let logs: Vec<CableLog> = logs.iter().map(|rows| cable_log(rows, EVERY)).collect();
    let mut fit = find_cable(&logs, &FitOptions::default())?;
    fit.model.learning = LEARNING;
    let compensation = match kind {
        Kind::Observer => Compensation::Observer(Box::new(ObserverCompensation::new(&fit.model)?)),
        _ => Compensation::Capstan {
            friction_angle: fit.model.law()?.friction_angle(),
            pretension: fit.model.parameters.pretension,
        },
    };
    Ok(Calibration { compensation, fit: Some(fit) })
}

fn rows(specimen: &Specimen, speed: f64, seconds: f64, seed: u64) -> Result<Vec<BenchRow>, Error> {
    let wanted = BenchRun::paper(specimen.clone(), Programme::Calibrate, speed, seed);
    let mut rows = Vec::new();
    let stop: Option<Stop> =
        run(&wanted, Steering::By(&mut Compensation::None), seconds, |row| rows.push(*row))?;
    match stop {
        None => Ok(rows),
        Some(stop) => {
            Err(Error::samples("calibration run", "no cable or drive that gives up", &format!("{stop:?}")))
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

/// Eq. 17, from either end's tension and the speed to what friction takes; the whole run, reversals included.
pub(crate) fn networks(logs: &[Vec<BenchRow>], seed: u64) -> Result<NetworkCompensation, Error> {
    let network = |end: fn(&BenchRow) -> f64| {
        let (mut inputs, mut targets) = (Vec::new(), Vec::new());
        for row in logs.iter().flatten() {
            inputs.extend([end(row), row.velocity]);
            targets.push(row.sample.tension_in - row.far);
        }
        let options = TrainOptions { hidden: 30, steps: 100, seed, ..TrainOptions::default() };
        let trained = train(&inputs, &targets, &options)?;
        unscaled(&trained.network)
            .ok_or_else(|| Error::samples("network", "weights that are finite", &"others"))
    };
    Ok(NetworkCompensation { friction: network(|row| row.far)?, loss: network(|row| row.sample.tension_in)? })
}

#[cfg(test)]
mod tests {
    use super::*;

    #[test]
    fn a_calibration_knows_the_friction_of_a_specimen_it_has_never_seen() {
        let specimen = Specimen::draw(3);
        let found = calibrate(Kind::Observer, &specimen, 20.0, 1).unwrap();
        let fit = found.fit.unwrap();
        assert!(fit.rmse < 2.5, "{}", fit.rmse);
        let truth =
            specimen.parameters.friction * specimen.path.angle() - specimen.parameters.efficiency.ln();
        let angle = fit.model.law().unwrap().friction_angle();
        assert!((angle - truth).abs() < 0.06 * truth, "{angle} {truth}");
    }
}
