//! Calibration of every transmission of an arm, one at a time on the bench: only measurements of the plant
//! are used.

use super::by_current::calibrate_by_current;
use crate::Error;
use crate::calibrate::{cable_log, ended_early, networks};
use crate::experiment::bench::{BenchRow, BenchRun, CalibrationRun, Programme, run_all};
use rayon::prelude::*;
use sinew::control::arm::MuscleGains;
use sinew::control::compensation::NetworkCompensation;
use sinew::machine::{Machine, MuscleCharacteristics};
use sinew::predictor::CableModel;
use sinew::transmission::cable::CableParameters;
use sinew::twin::arm::ArmSpecimen;
use sinew::twin::cable::Resolution;
use sinew_identify::cable::{CableLog, FitOptions, INITIAL_WEAKENING, Quantity, fit_cable_model};
use sinew_identify::gear::GearFit;

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

/// The calibration programme of one transmission.
#[derive(Debug, Clone, Copy, PartialEq)]
pub struct CalibrationProgramme {
    /// From the creeping speeds at which a machine works to its largest.
    pub strokes: [CalibrationStroke; 3],
    /// Range of the far tension, N.
    pub tension: [f64; 2],
}

/// Speeds of the strokes over the largest commanded speed of the winch, the durations, s, and decimations.
const STROKES: [(f64, f64, usize); 3] = [(0.016, 50.0, 12), (0.105, 20.0, 4), (0.53, 15.0, 4)];
/// Smallest length of a stroke over the dead band: the whole cable slides for most of it.
const DEAD_BANDS: f64 = 4.0;
/// Number of strokes in a run.
const STROKES_PER_RUN: [f64; 3] = [2.5, 2.0, 4.3];
/// Bounds of the working range: over the least desired tension, and as a fraction of the largest.
const WORKING_RANGE: (f64, f64) = (1.2, 0.4);

impl CalibrationProgramme {
    /// For a muscle with these limits of its desired tension, N, and its winch's largest speed, m/s.
    ///
    /// ```text
    /// T from 1.2 F_min to 0.4 F_max,     v = (0.016, 0.105, 0.53) v_max,     L = max(4 G, v t/n)
    /// ```
    ///
    /// The dead band `G` is at the working tension of [`MuscleCharacteristics`]. The stroke is that of the
    /// bench, not of the joint: it may be longer than the muscle's travel, up to what the drum holds.
    #[must_use]
    pub fn new(muscle: &MuscleCharacteristics, gains: &MuscleGains, drum: f64) -> Self {
        let [least, most] = gains.tension;
        let low = WORKING_RANGE.0 * least;
        let high = (WORKING_RANGE.1 * most).max(1.5 * low);
        let stroke = |k: usize| {
            let (fraction, duration, decimation) = STROKES[k];
            let speed = fraction * gains.max_winch_speed;
            let desired = (speed * duration / STROKES_PER_RUN[k]).max(DEAD_BANDS * muscle.dead_band);
            // Half of the drum is left to the stretch of the cable.
            CalibrationStroke { speed, length: desired.min(0.5 * drum), duration, decimation }
        };
        Self { strokes: [0, 1, 2].map(stroke), tension: [low, high] }
    }
}

/// What the bench tells of a muscle.
#[derive(Debug, Clone)]
pub struct CalibratedMuscle {
    /// Of its cable.
    pub cable: CableModel,
    /// Losses of its gear, where the current stands for a load cell.
    pub gear: Option<GearFit>,
}

/// Identifies the observer model of every transmission of an arm from its own runs on the bench.
///
/// Every fit starts from the parameters of `design`. A muscle whose design has an identified model
/// ([`MuscleDesign::model`](sinew::machine::MuscleDesign::model)) keeps it. Where a muscle has no load cell,
/// its cable follows from the displacements of both ends and the tension that the bench measures at the far
/// one, and the losses of its gear from the currents of both directions at the tensions of that cable.
///
/// # Errors
/// [`Error::Experiment`] where a run ends early or the arms have different numbers of muscles;
/// [`Error::Identification`] where the runs do not determine a model; [`Error::Physics`] for an invalid
/// specimen.
pub fn calibrate_arm(
    specimen: &ArmSpecimen,
    machine: &Machine,
    design: &ArmSpecimen,
    programmes: &[CalibrationProgramme],
    seed: u64,
) -> Result<Vec<CalibratedMuscle>, Error> {
    let count = design.cables.len();
    if [specimen.cables.len(), specimen.drives.len(), machine.muscles.len(), programmes.len()] != [count; 4] {
        return Err(Error::experiment("muscles", "as many as in the design", &specimen.cables.len()));
    }
    let muscles: Vec<usize> = (0..count).filter(|muscle| machine.muscles[*muscle].model.is_none()).collect();
    let logs = runs(specimen, &muscles, programmes, seed, |stroke| stroke.decimation)?;
    let fits = muscles.par_iter().zip(logs).map(|(muscle, rows)| {
        let designed = &design.cables[*muscle];
        let parameters = CableParameters { weakening: Some(INITIAL_WEAKENING), ..designed.parameters };
        // An arm starts with its cables pulled taut.
        let start = CableModel { path: designed.path.clone(), parameters, start: 1.0, ..CableModel::bench() };
        let drive = &machine.muscles[*muscle].drive;
        let mut fitted = if drive.has_load_cell {
            let logs: Vec<CableLog> = rows.iter().map(cable_log).collect();
            CalibratedMuscle { cable: fit_cable_model(&logs, &start, &options())?, gear: None }
        } else {
            let tolerance = machine.tolerances.gear_losses;
            let (cable, gear) = calibrate_by_current(&rows, &start, drive, tolerance, &options())?;
            CalibratedMuscle { cable, gear: Some(gear) }
        };
        // The anchor's travel comes from the body's geometry here, whose errors would be adapted as drag.
        fitted.cable.learning = 0.0;
        // The zeros of the arm's encoders differ from those of the bench.
        fitted.cable.zero_stretch = None;
        Ok(fitted)
    });
    let mut fits = fits.collect::<Result<Vec<_>, Error>>()?.into_iter();
    let muscles = machine.muscles.iter().map(|muscle| match &muscle.model {
        Some(model) => Some(CalibratedMuscle { cable: model.clone(), gear: None }),
        None => fits.next(),
    });
    Ok(muscles.flatten().collect())
}

/// The networks of (17) for every muscle, trained on the same runs.
///
/// # Errors
/// As [`calibrate_arm`].
pub fn calibrate_networks(
    specimen: &ArmSpecimen,
    programmes: &[CalibrationProgramme],
    seed: u64,
) -> Result<Vec<NetworkCompensation>, Error> {
    let count = specimen.cables.len().min(specimen.drives.len()).min(programmes.len());
    let muscles: Vec<usize> = (0..count).collect();
    let logs = runs(specimen, &muscles, programmes, seed, |_| NETWORK_DECIMATION)?;
    let networks =
        logs.par_iter().enumerate().map(|(muscle, logs)| networks(logs, seed.wrapping_add(muscle as u64)));
    networks.collect()
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

/// The calibration runs of transmissions, one for each stroke of their programmes, with the decimation of
/// each: `[muscle][stroke][row]`.
pub(super) fn runs(
    specimen: &ArmSpecimen,
    muscles: &[usize],
    programmes: &[CalibrationProgramme],
    seed: u64,
    decimation: impl Fn(&CalibrationStroke) -> usize,
) -> Result<Vec<Vec<Vec<BenchRow>>>, Error> {
    let mut all = Vec::new();
    for &muscle in muscles {
        let programme = &programmes[muscle];
        for (n, stroke) in programme.strokes.iter().enumerate() {
            let seed = seed.wrapping_mul(1009).wrapping_add((16 * muscle + n) as u64);
            let cable = specimen.cables[muscle].clone();
            let run = BenchRun {
                // The bench has no light joint that would need more substeps.
                resolution: Resolution { substeps: Resolution::default().substeps, ..specimen.resolution },
                drives: specimen.drives[muscle],
                stroke: stroke.length,
                tension: programme.tension,
                period: stroke.length / stroke.speed,
                ..BenchRun::paper(cable, Programme::Calibrate, stroke.speed, seed)
            };
            all.push(CalibrationRun { run, seconds: stroke.duration, decimation: decimation(stroke) });
        }
    }
    let mut rows = run_all(&all)?.into_iter().map(|rows| rows.map_err(ended_early));
    muscles.iter().map(|&muscle| rows.by_ref().take(programmes[muscle].strokes.len()).collect()).collect()
}
