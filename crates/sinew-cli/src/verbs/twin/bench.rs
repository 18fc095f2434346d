//! `sinew twin bench`.

use crate::answer::{Answer, Content, Outcome};
use crate::arguments::{General, MuscleStrokes, TwinBenchArguments};
use crate::error::Error;
use crate::output::{refuse_overwrite, write_all};
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

/// Strokes per speed of a calibration.
const CALIBRATION_STROKES: f64 = 4.0;

/// Result of one speed, as printed with `--json`.
#[derive(Debug, Serialize)]
struct Summary {
    speed_m_per_s: f64,
    rows: usize,
    far_rmse_n: Option<f64>,
    estimate_rmse_n: Option<f64>,
    stopped: Option<String>,
}

pub(super) fn run(arguments: &TwinBenchArguments, general: &General) -> Result<Answer, Error> {
    refuse_overwrite([], std::slice::from_ref(&arguments.out), general.no_clobber)?;
    let progress = Progress::new();
    progress.show("calibration", 0.0);
    let compensation = arguments
        .compensation
        .map(|variant| calibrated(variant, &arguments.specimen.specimen, arguments.seed))
        .transpose()?;
    let mut log = String::from(
        "# SIMULATED by sinew twin bench\n\
         time_s,trial,tension_in_n,position_in_m,anchor_m,tension_out_n,desired_n,estimate_n,direction\n",
    );
    let mut summaries = Vec::new();
    let mut trial = 0;
    for (k, speed) in arguments.speeds.iter().enumerate() {
        #[expect(clippy::cast_precision_loss, reason = "a few speeds")]
        progress.show("running", 0.5 + 0.5 * k as f64 / arguments.speeds.len() as f64);
        summaries.push(run_at_speed(arguments, compensation.as_ref(), *speed, &mut trial, &mut log)?);
    }
    drop(progress);
    let written = write_all(&[(arguments.out.clone(), log.as_bytes())])?;
    let outcome = Outcome::new(summaries.iter().all(|summary| summary.stopped.is_none()));
    let content = if general.json {
        Content::json(&serde_json::json!({"simulated": true, "runs": summaries}))?
    } else {
        Content::Text(summary_text(&summaries) + "\n")
    };
    Ok(Answer { outcome, content, written })
}

fn calibrated(variant: CompensationVariant, specimen: &Specimen, seed: u64) -> Result<Compensation, Error> {
    if variant == CompensationVariant::None {
        return Ok(Compensation::None);
    }
    Ok(calibrate(variant, &calibration_runs(specimen, CALIBRATION_STROKES, seed)?, seed)?)
}

/// One run; every kept stroke, or the whole run, is a trial of the log.
fn run_at_speed(
    arguments: &TwinBenchArguments,
    compensation: Option<&Compensation>,
    speed: f64,
    trial: &mut u32,
    log: &mut String,
) -> Result<Summary, Error> {
    let programme = if compensation.is_some() { Programme::Track } else { Programme::Calibrate };
    let bench = BenchRun::paper(arguments.specimen.specimen.clone(), programme, speed, arguments.seed);
    let mut compensation = compensation.cloned().unwrap_or(Compensation::None);
    let (mut tracking, mut estimation) = (Comparison::new(), Comparison::new());
    let (mut rows, mut last_kept) = (0, false);
    let tracks = programme == Programme::Track;
    let stop =
        run_bench(&bench, MuscleControl::Compensation(&mut compensation), arguments.duration, |row| {
            let kept = match arguments.muscle {
                MuscleStrokes::Both => true,
                MuscleStrokes::Active => row.velocity > 0.0,
                MuscleStrokes::Passive => row.velocity < 0.0,
            };
            *trial += u32::from(kept && !last_kept);
            last_kept = kept;
            if kept {
                rows += 1;
                // Simulated tensions are finite; a non-finite one would be left out of the mean.
                let _ = tracking.push(row.desired, row.truth[1]);
                let _ = estimation.push(row.truth[1], row.estimate);
                write_row(log, row, *trial, tracks);
            }
        })?;
    Ok(Summary {
        speed_m_per_s: speed,
        rows,
        far_rmse_n: tracking.rmse().filter(|_| tracks),
        estimate_rmse_n: estimation.rmse().filter(|_| tracks),
        stopped: stop.map(|stop| match stop {
            Stop::Broken(broken) => format!("the cable broke: {broken:?}"),
            Stop::Drive(fault) => format!("a drive stopped: {fault:?}"),
        }),
    })
}

fn write_row(log: &mut String, row: &BenchRow, trial: u32, tracks: bool) {
    let sample = &row.sample;
    let estimate = if tracks { format!("{:.3}", row.estimate) } else { String::new() };
    // Writing into a string cannot fail.
    let _ = writeln!(
        log,
        "{:.3},{trial},{:.2},{:.7},{:.7},{:.2},{:.3},{estimate},{}",
        row.time, sample.tension_in, sample.motor, sample.anchor, row.far, row.desired, row.window
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
    table(&["SIMULATED, m/s", "rows", "tracking error, N rms", "estimation error, N rms", ""], &rows, 0)
}
