//! Calibration of a muscle without a load cell: its cable by the bench's own load cell at the far end, its
//! gear by the currents of both directions.

use crate::Error;
use crate::experiment::bench::BenchRow;
use sinew::drive::DriveParameters;
use sinew::machine::Machine;
use sinew::predictor::{CableModel, CableSample};
use sinew_identify::cable::{
    CableFit, CableLog, FitOptions, Quantity, fit_cable, fit_cable_model, observe_log,
};
use sinew_identify::gear::{GearFit, GearSample, LoadError, fit_gear};

/// Cable and gear of a muscle from its runs on the bench, `[run][row]`, beginning with a model as designed,
/// and with a relative tolerance of the gear's losses; of the options those of the search count.
///
/// # Errors
/// [`Error::Identification`] where the runs do not determine them.
pub(super) fn calibrate_by_current(
    runs: &[Vec<BenchRow>],
    start: &CableModel,
    drive: &DriveParameters,
    tolerance: f64,
    options: &FitOptions,
) -> Result<(CableModel, GearFit), Error> {
    // The near tension alone would show the other numbers; creep looks like friction from the far end.
    let free = vec![Quantity::Drag, Quantity::Compliance, Quantity::FarLength, Quantity::BendTilt];
    let options = FitOptions { free, near_weight: 0.0, ..options.clone() };
    // Where a log begins, the near tension is that of the model: once more with the model that was found.
    let first = fit_cable_model(&logs(runs, start)?, start, &options)?;
    let logs = logs(runs, &first)?;
    let fit = fit_cable(&logs, &first, &options)?;
    let gear = gear(runs, &logs, &fit, (drive, tolerance))?;
    Ok((fit.model, gear))
}

/// What the pretension of a cable is off by, over that of its design: twice its standard deviation
/// ([`Specimen::draw`](sinew::twin::cable::Specimen::draw)).
const PRETENSION_ERROR: f64 = 0.24;

/// What the near tension of the model is off by, up in one direction and down in the other, 95 %: the
/// friction of the cable, which the far end does not tell apart from the creep of the cable.
const NEAR_ERROR: f64 = 0.12;

/// The rows of a run from where the whole cable slides toward the motor.
fn sliding(rows: &[BenchRow]) -> &[BenchRow] {
    let begin = rows.iter().position(|row| row.window > 0.0).unwrap_or(rows.len());
    &rows[begin..]
}

/// Runs without near tensions; the first one of each is that of a model, from the far one.
fn logs(runs: &[Vec<BenchRow>], model: &CableModel) -> Result<Vec<CableLog>, Error> {
    let law = model.law()?;
    let log = |rows: &Vec<BenchRow>| {
        let mut log = CableLog::default();
        let mut last = f64::NAN;
        for row in sliding(rows) {
            let far = (row.far / model.far_gain).max(law.pretension());
            let tension_in =
                if last.is_nan() { law.steady(far, row.velocity, 1.0)?.tension_in } else { f64::NAN };
            let interval = if last.is_nan() { 0.0 } else { row.time - last };
            log.push(interval, CableSample { tension_in, ..row.sample }, row.far);
            last = row.time;
        }
        Ok(log)
    };
    runs.iter().map(log).collect()
}

/// Losses of the gear from the currents while the cable slides at full speed.
fn gear(
    runs: &[Vec<BenchRow>],
    logs: &[CableLog],
    fit: &CableFit,
    (drive, tolerance): (&DriveParameters, f64),
) -> Result<GearFit, Error> {
    let DriveParameters { motor, reducer, winch, .. } = drive;
    let turns = reducer.ratio / winch.arm(0);
    let mut strokes = Vec::new();
    for (rows, log) in runs.iter().zip(logs) {
        let mut window = 0.0;
        for (row, estimate) in sliding(rows).iter().zip(observe_log(&fit.model, log)?) {
            if row.window != 0.0 && row.window * window <= 0.0 {
                strokes.push(Vec::new());
            }
            window = row.window;
            if let Some(stroke) = strokes.last_mut().filter(|_| row.window != 0.0) {
                stroke.push(GearSample {
                    torque: motor.torque_constant * row.current - reducer.viscous * turns * row.velocity,
                    load: estimate.tension_in / turns,
                    driving: row.window > 0.0,
                });
            }
        }
    }
    let load_error = LoadError {
        relative: NEAR_ERROR,
        absolute: PRETENSION_ERROR * fit.model.parameters.pretension / turns,
    };
    let found = fit_gear(&strokes, load_error)?;
    let lost = tolerance * (1.0 - reducer.efficiency);
    Ok(GearFit {
        efficiency: found.efficiency.weighed(reducer.efficiency, lost),
        friction: found.friction.weighed(reducer.friction, tolerance * reducer.friction),
    })
}

/// The machine with the losses of gears that were identified; none, and those beyond the list, are as
/// designed.
#[must_use]
pub fn with_gears(mut machine: Machine, gears: &[Option<GearFit>]) -> Machine {
    for (muscle, gear) in machine.muscles.iter_mut().zip(gears) {
        if let Some(gear) = gear {
            let reducer = &mut muscle.drive.reducer;
            (reducer.efficiency, reducer.friction) = (gear.efficiency.value, gear.friction.value);
        }
    }
    machine
}
