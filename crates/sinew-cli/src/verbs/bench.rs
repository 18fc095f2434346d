//! `sinew bench run`.

use super::specimen::specimen;
use crate::arguments::{BenchArguments, BenchRunArguments, BenchVerb, CompensationKind, Muscle};
use crate::error::Error;
use crate::output::{print, refuse_overwrite, write_all};
use crate::progress::Progress;
use crate::table::{number, table};
use serde::Serialize;
use sinew::control::compensation::Compensation;
use sinew::metrics::Comparison;
use sinew::twin::cable::Specimen;
use sinew_lab::CompensationVariant;
use sinew_lab::calibrate::{calibrate, calibration_runs};
use sinew_lab::experiment::bench::{BenchRow, BenchRun, MuscleControl, Programme, Stop, run as run_bench};
use std::fmt::Write;

/// Strokes at each speed that a compensation is calibrated by.
const STROKES: f64 = 4.0;

/// What a speed showed.
#[derive(Debug, Serialize)]
struct Summary {
    simulated: bool,
    speed_m_per_s: f64,
    rows: usize,
    far_rmse_n: Option<f64>,
    estimate_rmse_n: Option<f64>,
    stopped: Option<String>,
}

pub(crate) fn run(arguments: &BenchArguments) -> Result<(), Error> {
    let BenchVerb::Run(arguments) = &arguments.verb;
    check(arguments)?;
    refuse_overwrite([], std::slice::from_ref(&arguments.out))?;
    let specimen = specimen(&arguments.specimen)?;
    let progress = Progress::new();
    progress.show("calibration", 0.0);
    let compensation =
        arguments.compensation.map(|kind| prepared(kind, &specimen, arguments.seed)).transpose()?;
    let mut log = String::from(
        "# SIMULATED by sinew bench run\ntime_s,trial,tension_in_n,position_in_m,anchor_m,tension_out_n,wanted_n,estimate_n,stroke\n",
    );
    let mut summaries = Vec::new();
    let mut trial = 0;
    for (k, speed) in arguments.speeds.iter().enumerate() {
        #[expect(clippy::cast_precision_loss, reason = "a few speeds")]
        progress.show("running", 0.5 + 0.5 * k as f64 / arguments.speeds.len() as f64);
        summaries.push(at_speed(arguments, &specimen, compensation.as_ref(), *speed, &mut trial, &mut log)?);
    }
    drop(progress);
    write_all(&[(arguments.out.clone(), log.as_bytes())])?;
    if arguments.json {
        return print(&(serde_json::to_string_pretty(&summaries)? + "\n"));
    }
    print(&format!("{}\nWritten: {}\n", summary_text(&summaries), arguments.out.display()))
}

fn check(arguments: &BenchRunArguments) -> Result<(), Error> {
    let refuse = |flag, value: f64, expected| Error::Argument { flag, value: value.to_string(), expected };
    for speed in &arguments.speeds {
        if !(0.005..=0.15).contains(speed) {
            return Err(refuse("--speeds", *speed, "numbers from 0.005 to 0.15 m/s"));
        }
    }
    if !(1.0..=3600.0).contains(&arguments.duration) {
        return Err(refuse("--duration", arguments.duration, "1 to 3600 s"));
    }
    Ok(())
}

fn prepared(kind: CompensationKind, specimen: &Specimen, seed: u64) -> Result<Compensation, Error> {
    let variant = match kind {
        CompensationKind::None => return Ok(Compensation::None),
        CompensationKind::Capstan => CompensationVariant::Capstan,
        CompensationKind::Paper => CompensationVariant::Paper,
        CompensationKind::Observer => CompensationVariant::Observer,
    };
    Ok(calibrate(variant, &calibration_runs(specimen, STROKES, seed)?, seed)?)
}

/// One run; its rows go to the log, each kept stroke or whole run as a trial of its own.
fn at_speed(
    arguments: &BenchRunArguments,
    specimen: &Specimen,
    compensation: Option<&Compensation>,
    speed: f64,
    trial: &mut u32,
    log: &mut String,
) -> Result<Summary, Error> {
    let programme = if compensation.is_some() { Programme::Track } else { Programme::Calibrate };
    let wanted = BenchRun::paper(specimen.clone(), programme, speed, arguments.seed);
    let mut compensation = compensation.cloned().unwrap_or(Compensation::None);
    let (mut reached, mut believed) = (Comparison::new(), Comparison::new());
    let (mut rows, mut last_kept) = (0, false);
    let known = programme == Programme::Track;
    let stop =
        run_bench(&wanted, MuscleControl::Compensation(&mut compensation), arguments.duration, |row| {
            let kept = match arguments.muscle {
                Muscle::Both => true,
                Muscle::Active => row.velocity > 0.0,
                Muscle::Passive => row.velocity < 0.0,
            };
            *trial += u32::from(kept && !last_kept);
            last_kept = kept;
            if kept {
                rows += 1;
                // A simulated tension is finite; what were not would be left out of the mean, and the count would tell.
                let _ = reached.push(row.wanted, row.truth[1]);
                let _ = believed.push(row.truth[1], row.estimate);
                write_row(log, row, *trial, known);
            }
        })?;
    Ok(Summary {
        simulated: true,
        speed_m_per_s: speed,
        rows,
        far_rmse_n: reached.rmse().filter(|_| known),
        estimate_rmse_n: believed.rmse().filter(|_| known),
        stopped: stop.map(|stop| match stop {
            Stop::Broken(broken) => format!("the cable broke: {broken:?}"),
            Stop::Drive(fault) => format!("a drive stopped: {fault:?}"),
        }),
    })
}

fn write_row(log: &mut String, row: &BenchRow, trial: u32, known: bool) {
    let sample = &row.sample;
    let estimate = if known { format!("{:.3}", row.estimate) } else { String::new() };
    // Writing into a string cannot fail.
    let _ = writeln!(
        log,
        "{:.3},{trial},{:.2},{:.7},{:.7},{:.2},{:.3},{estimate},{}",
        row.time, sample.tension_in, sample.motor, sample.anchor, row.far, row.wanted, row.window
    );
}

fn summary_text(summaries: &[Summary]) -> String {
    let rows: Vec<_> = summaries
        .iter()
        .map(|s| {
            let stopped = s.stopped.clone().unwrap_or_default();
            vec![
                number(Some(s.speed_m_per_s)),
                s.rows.to_string(),
                number(s.far_rmse_n),
                number(s.estimate_rmse_n),
                stopped,
            ]
        })
        .collect();
    table(&["SIMULATED, m/s", "rows", "far tension, N rms off", "estimate, N rms off", ""], &rows, 0)
}
