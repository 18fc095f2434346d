//! Calibration of every transmission of an arm, one at a time on the bench: only measurements of the plant
//! are used.

use crate::Error;
use crate::calibrate::{cable_log, networks};
use crate::experiment::bench::{BenchRow, BenchRun, MuscleControl, Programme, run};
use rayon::prelude::*;
use sinew::control::compensation::{Compensation, NetworkCompensation};
use sinew::predictor::CableModel;
use sinew::transmission::cable::CableParameters;
use sinew::twin::arm::ArmSpecimen;
use sinew_identify::cable::{CableFit, CableLog, FitOptions, INITIAL_WEAKENING, Quantity, fit_cable};

/// One calibration run.
#[derive(Debug, Clone, Copy, PartialEq)]
pub struct CalibrationStroke {
    /// Speed of the winch, m/s.
    pub speed: f64,
    /// Length of a stroke, m.
    pub length: f64,
    /// Duration, s.
    pub duration: f64,
    /// Decimation: milliseconds between the samples of the fit, at most 20, beyond which an observer
    /// restarts.
    pub decimation: usize,
}

/// The calibration of a transmission, from the creeping speeds at which an arm works to its largest.
pub const CALIBRATION_STROKES: [CalibrationStroke; 3] = [
    CalibrationStroke { speed: 0.003, length: 0.06, duration: 50.0, decimation: 12 },
    CalibrationStroke { speed: 0.02, length: 0.2, duration: 20.0, decimation: 4 },
    CalibrationStroke { speed: 0.1, length: 0.35, duration: 15.0, decimation: 4 },
];

/// Range of the far tension, N: the working range of the arm.
const TENSION: [f64; 2] = [25.0, 150.0];

/// Rate of drag adaptation during tracking, 1/(N m).
const DRAG_ADAPTATION: f64 = 3.0;

/// Identifies the observer model of every transmission of an arm from its own runs on the bench.
///
/// Every fit starts from the parameters of `design`.
///
/// # Errors
/// [`Error::Experiment`] where a run ends early or the arms have different numbers of muscles;
/// [`Error::Identification`] where the runs do not determine a model; [`Error::Physics`] for an invalid
/// specimen.
pub fn calibrate_arm(
    specimen: &ArmSpecimen,
    design: &ArmSpecimen,
    seed: u64,
) -> Result<Vec<CableFit>, Error> {
    if specimen.cables.len() != design.cables.len() || specimen.drives.len() != design.cables.len() {
        return Err(Error::experiment("muscles", "as many as in the design", &specimen.cables.len()));
    }
    design
        .cables
        .par_iter()
        .enumerate()
        .map(|(muscle, designed)| {
            let logs = runs(specimen, muscle, seed)?;
            let logs: Vec<CableLog> = logs
                .iter()
                .zip(&CALIBRATION_STROKES)
                .map(|(rows, strokes)| cable_log(rows, strokes.decimation))
                .collect();
            let parameters = CableParameters { weakening: Some(INITIAL_WEAKENING), ..designed.parameters };
            // An arm starts with its cables pulled taut.
            let start =
                CableModel { path: designed.path.clone(), parameters, start: 1.0, ..CableModel::bench() };
            let mut fit = fit_cable(&logs, &start, &options())?;
            fit.model.learning = DRAG_ADAPTATION;
            // The zeros of the arm's encoders differ from those of the bench.
            fit.model.zero_stretch = None;
            Ok(fit)
        })
        .collect()
}

/// The networks of (17) for every muscle, trained on the same runs.
///
/// # Errors
/// As [`calibrate_arm`].
pub fn calibrate_networks(specimen: &ArmSpecimen, seed: u64) -> Result<Vec<NetworkCompensation>, Error> {
    (0..specimen.cables.len().min(specimen.drives.len()))
        .into_par_iter()
        .map(|muscle| {
            let mut logs = runs(specimen, muscle, seed)?;
            for rows in &mut logs {
                *rows = rows.iter().step_by(NETWORK_DECIMATION).copied().collect();
            }
            networks(&logs, seed.wrapping_add(muscle as u64))
        })
        .collect()
}

/// Decimation of the training rows of a network.
const NETWORK_DECIMATION: usize = 30;

fn options() -> FitOptions {
    FitOptions {
        free: Quantity::USUAL.to_vec(),
        samples: 16_000,
        residuals: 1200,
        steps: 8,
        multistart: false,
        near_weight: 0.5,
    }
}

/// The calibration runs of one transmission, one for each of [`CALIBRATION_STROKES`].
pub(super) fn runs(specimen: &ArmSpecimen, muscle: usize, seed: u64) -> Result<Vec<Vec<BenchRow>>, Error> {
    let each = CALIBRATION_STROKES.iter().enumerate().map(|(n, strokes)| {
        let seed = seed.wrapping_mul(1009).wrapping_add((16 * muscle + n) as u64);
        let bench_run = BenchRun {
            resolution: specimen.resolution,
            drives: specimen.drives[muscle],
            stroke: strokes.length,
            tension: TENSION,
            period: strokes.length / strokes.speed,
            ..BenchRun::paper(specimen.cables[muscle].clone(), Programme::Calibrate, strokes.speed, seed)
        };
        let mut rows: Vec<BenchRow> = Vec::new();
        let uncompensated = &mut Compensation::None;
        match run(&bench_run, MuscleControl::Compensation(uncompensated), strokes.duration, |row| {
            rows.push(*row);
        })? {
            None => Ok(rows),
            Some(stop) => {
                let expected = "no broken cable and no drive fault";
                Err(Error::experiment("calibration run", expected, &format!("{stop:?}")))
            }
        }
    });
    each.collect()
}
