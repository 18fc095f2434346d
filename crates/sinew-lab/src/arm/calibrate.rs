//! Every transmission of an arm by its own calibration run: nothing is read from the plant.

use crate::Error;
use crate::calibrate::{cable_log, networks};
use crate::experiment::bench::{BenchRow, BenchRun, MuscleControl, Programme, run};
use rayon::prelude::*;
use sinew::control::compensation::{Compensation, NetworkCompensation};
use sinew::predictor::CableModel;
use sinew::transmission::cable::Weakening;
use sinew::twin::arm::ArmSpecimen;
use sinew_identify::cable::{CableFit, CableLog, FitOptions, Quantity, fit_cable};

/// One part of a calibration.
#[derive(Debug, Clone, Copy, PartialEq)]
pub struct CalibrationStroke {
    /// m/s.
    pub speed: f64,
    /// Length of a stroke, m.
    pub length: f64,
    /// How long, s.
    pub seconds: f64,
    /// Milliseconds between the samples that are kept: at most 20, where an observer starts afresh.
    pub every: usize,
}

/// What a transmission is put through: creeping, because an arm creeps, and as fast as it gets.
pub const CALIBRATION_STROKES: [CalibrationStroke; 3] = [
    CalibrationStroke { speed: 0.003, length: 0.06, seconds: 50.0, every: 12 },
    CalibrationStroke { speed: 0.02, length: 0.2, seconds: 20.0, every: 4 },
    CalibrationStroke { speed: 0.1, length: 0.35, seconds: 15.0, every: 4 },
];

/// Swing of the far tension, N: what the arm works with.
const TENSION: [f64; 2] = [25.0, 150.0];

/// How fast the drag is learned at work, 1/(N m).
const LEARNING: f64 = 3.0;

/// Friction at rest from which the search starts.
const SLOW: Weakening = Weakening { rise: 0.05, speed: 3e-3, lag: 0.05 };

/// Puts every transmission of an arm on the bench, alone, and fits an observer's numbers to what the bench's sensors say.
///
/// The start of every fit is the arm as drawn on paper, `design`.
///
/// # Errors
/// [`Error::Experiment`] where a run ends early or shows too little, or where the arms are not of one kind;
/// [`Error::Physics`] for a specimen that is none.
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
                .map(|(rows, strokes)| cable_log(rows, strokes.every))
                .collect();
            let parameters =
                sinew::transmission::cable::CableParameters { weakening: Some(SLOW), ..designed.parameters };
            // An arm is switched on with its cables pulled taut.
            let start =
                CableModel { path: designed.path.clone(), parameters, start: 1.0, ..CableModel::bench() };
            let mut fit = fit_cable(&logs, &start, &options())?;
            fit.model.learning = LEARNING;
            // The arm's encoders have other zeros than the bench's.
            fit.model.zero_stretch = None;
            Ok(fit)
        })
        .collect()
}

/// The same runs, and the paper's networks for every muscle.
///
/// # Errors
/// As [`calibrate_arm`].
pub fn calibrate_networks(specimen: &ArmSpecimen, seed: u64) -> Result<Vec<NetworkCompensation>, Error> {
    (0..specimen.cables.len().min(specimen.drives.len()))
        .into_par_iter()
        .map(|muscle| {
            let mut logs = runs(specimen, muscle, seed)?;
            for rows in &mut logs {
                *rows = rows.iter().step_by(THINNED).copied().collect();
            }
            networks(&logs, seed.wrapping_add(muscle as u64))
        })
        .collect()
}

/// Rows between those that a network is trained on.
const THINNED: usize = 30;

fn options() -> FitOptions {
    FitOptions {
        free: Quantity::USUAL.to_vec(),
        samples: 16_000,
        residuals: 1200,
        steps: 8,
        around: false,
        near_weight: 0.5,
    }
}

/// The calibration runs of one transmission, one for each of [`CALIBRATION_STROKES`].
pub(super) fn runs(specimen: &ArmSpecimen, muscle: usize, seed: u64) -> Result<Vec<Vec<BenchRow>>, Error> {
    let each = CALIBRATION_STROKES.iter().enumerate().map(|(n, strokes)| {
        let seed = seed.wrapping_mul(1009).wrapping_add((16 * muscle + n) as u64);
        let wanted = BenchRun {
            resolution: specimen.resolution,
            drives: specimen.drives[muscle],
            stroke: strokes.length,
            tension: TENSION,
            period: strokes.length / strokes.speed,
            ..BenchRun::paper(specimen.cables[muscle].clone(), Programme::Calibrate, strokes.speed, seed)
        };
        let mut rows: Vec<BenchRow> = Vec::new();
        let nothing = &mut Compensation::None;
        match run(&wanted, MuscleControl::Compensation(nothing), strokes.seconds, |row| rows.push(*row))? {
            None => Ok(rows),
            Some(stop) => {
                let expected = "no cable or drive that gives up";
                Err(Error::experiment("calibration run", expected, &format!("{stop:?}")))
            }
        }
    });
    each.collect()
}
