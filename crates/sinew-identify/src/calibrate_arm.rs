//! What is to be known of an arm before its loop is closed: every transmission by its own calibration run.

use crate::Error;
use crate::calibrate::cable_log;
use crate::observer::{CableFit, CableLog, FitOptions, Quantity, fit_cable};
use rayon::prelude::*;
use sinew::control::compensation::Compensation;
use sinew::experiment::bench::{BenchRow, BenchRun, Programme, Steering, run};
use sinew::predictor::CableModel;
use sinew::transmission::cable::Weakening;
use sinew::twin::arm::ArmSpecimen;

/// Strokes of a calibration: speed, m/s, length, m, and time, s. Creeping, because an arm creeps; and as fast as it gets.
pub const STROKES: [(f64, f64, f64); 3] = [(0.003, 0.06, 50.0), (0.02, 0.2, 20.0), (0.1, 0.35, 15.0)];

/// How fast the drag is learned at work, 1/(N m).
const LEARNING: f64 = 3.0;

/// Runs every transmission of an arm on the bench, alone, and fits the observer's numbers to what the sensors of the bench said.
///
/// The start of every fit is what was designed: `design` is the arm as drawn on paper. Nothing is read from the plant.
///
/// # Errors
/// [`Error::Samples`] where a run ends early or shows too little; [`Error::Physics`] for a specimen that is none.
pub fn calibrate_arm(specimen: &ArmSpecimen, design: &ArmSpecimen, seed: u64) -> Result<Vec<CableFit>, Error> {
    let each = specimen.cables.par_iter().zip(&design.cables).enumerate();
    each.map(|(k, (_, designed))| {
        let logs = STROKES
            .iter()
            .enumerate()
            .map(|(n, strokes)| {
                let seed = seed.wrapping_mul(1009).wrapping_add((16 * k + n) as u64);
                log(specimen, k, strokes, seed)
            })
            .collect::<Result<Vec<CableLog>, Error>>()?;
        let mut parameters = designed.parameters;
        parameters.weakening = Some(Weakening { rise: 0.05, speed: 3e-3, lag: 0.05 });
        let start = CableModel { path: designed.path.clone(), parameters, start: 1.0, ..CableModel::bench() };
        let mut fit = fit_cable(&logs, &start, &options())?;
        fit.model.learning = LEARNING;
        // The arm's encoders have other zeros than the bench's.
        fit.model.zero_stretch = None;
        Ok(fit)
    })
    .collect()
}

fn options() -> FitOptions {
    FitOptions { free: Quantity::USUAL.to_vec(), samples: 24_000, residuals: 1500, steps: 12, near_weight: 0.5 }
}

fn log(specimen: &ArmSpecimen, k: usize, strokes: &(f64, f64, f64), seed: u64) -> Result<CableLog, Error> {
    let &(speed, stroke, seconds) = strokes;
    let wanted = BenchRun {
        resolution: specimen.resolution,
        drives: specimen.drives[k],
        stroke,
        tension: [25.0, 150.0],
        period: stroke / speed,
        ..BenchRun::paper(specimen.cables[k].clone(), Programme::Calibrate, speed, seed)
    };
    let mut rows: Vec<BenchRow> = Vec::new();
    let stop = run(&wanted, Steering::By(&mut Compensation::None), seconds, |row| rows.push(*row))?;
    match stop {
        None => Ok(cable_log(&rows)),
        Some(stop) => {
            Err(Error::samples("calibration run", "no cable or drive that gives up", &format!("{stop:?}")))
        }
    }
}
