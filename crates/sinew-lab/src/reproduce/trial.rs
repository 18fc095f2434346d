//! One run with a compensation at one speed: the three comparisons of Table I, and the recovery after
//! reversals.

use crate::Error;
use crate::experiment::bench::{BenchRow, BenchRun, MuscleControl, STEP, run};
use sinew::metrics::Comparison;

/// Three comparisons, each of active strokes (toward the motor of the muscle) and passive ones, in this
/// order.
#[derive(Debug, Clone, Copy, Default)]
pub struct Scores {
    /// (a) Achieved against desired far tension in the steady windows, as in Table I of the paper.
    pub achieved: [Comparison; 2],
    /// (b) Estimated against true far tension over whole cycles, reversals included.
    pub estimated: [Comparison; 2],
    /// (c) Achieved against desired over whole cycles.
    pub cycles: [Comparison; 2],
}

/// Recovery of the far tension after reversals.
#[derive(Debug, Clone, Copy, Default, PartialEq)]
pub struct Recovery {
    /// Mean time from a reversal until the far tension stays within 5 N of the desired one for 0.2 s, s, by
    /// the direction after the reversal. A stroke without recovery counts with its whole duration.
    pub seconds: [f64; 2],
    /// Number of reversals.
    pub reversals: [u32; 2],
}

/// Tolerance of the recovered far tension, N, and the time for which it is kept, s.
const RECOVERED_N: f64 = 5.0;
const RECOVERED_S: f64 = 0.2;
/// Initial part of a run that is not counted, s: the state of the cable is not yet observable.
const SETTLE_S: f64 = 3.0;

/// One sample of a figure.
#[derive(Debug, Clone, Copy, PartialEq)]
pub struct TraceRow {
    /// Time since the start, s.
    pub time: f64,
    /// Desired far tension, N.
    pub desired: f64,
    /// True far and near tension, N.
    pub far: f64,
    /// See [`far`](Self::far).
    pub near: f64,
    /// Far tension estimated by the compensation, N.
    pub estimate: f64,
    /// Speed of the cable, m/s.
    pub velocity: f64,
}

/// Results of a run.
#[derive(Debug, Clone)]
pub struct Trial {
    /// Comparisons of Table I.
    pub scores: Scores,
    /// Recovery after reversals.
    pub recovery: Recovery,
    /// Mean of `|T_in - T_out|` in the steady windows, N.
    pub tension_loss: [f64; 2],
    /// Largest difference between the known and the true displacement of the far end since the start, m.
    pub anchor_error: f64,
    /// Samples for figures, every 20 ms of the traced interval.
    pub trace: Vec<TraceRow>,
}

/// Runs for `seconds`; samples within the interval `traced`, s, are kept for figures.
///
/// # Errors
/// [`Error::Experiment`] where the run ends early; [`Error::Physics`] for an invalid specimen.
pub fn run_trial(
    bench_run: &BenchRun,
    steering: MuscleControl<'_>,
    seconds: f64,
    traced: [f64; 2],
) -> Result<Trial, Error> {
    let mut trial = Trial {
        scores: Scores::default(),
        recovery: Recovery::default(),
        tension_loss: [0.0; 2],
        anchor_error: 0.0,
        trace: Vec::new(),
    };
    let mut watch = ReversalWatch::default();
    let mut count = 0_u64;
    let stop = run(bench_run, steering, seconds, |row| {
        count += 1;
        let traced = row.time >= traced[0] && row.time < traced[1];
        if traced && count % 20 == 1 {
            trial.trace.push(trace_row(row));
        }
        if row.time < SETTLE_S {
            return;
        }
        let side = usize::from(row.velocity < 0.0);
        trial.anchor_error = trial.anchor_error.max((row.sample.anchor - row.anchor).abs());
        let [near, far] = row.truth;
        let scores = &mut trial.scores;
        // Tensions of the plant are finite; an estimate that is not is left out, which the count shows.
        let _ = scores.cycles[side].push(row.desired, far);
        let _ = scores.estimated[side].push(far, row.estimate);
        if row.window != 0.0 {
            let _ = scores.achieved[side].push(row.desired, far);
            trial.tension_loss[side] += (near - far).abs();
        }
        watch.update(row, &mut trial.recovery);
    })?;
    if let Some(stop) = stop {
        return Err(Error::experiment(
            "bench run",
            "no broken cable and no drive fault",
            &format!("{stop:?}"),
        ));
    }
    for side in 0..2 {
        trial.tension_loss[side] /= (trial.scores.achieved[side].count() as f64).max(1.0);
        trial.recovery.seconds[side] /= f64::from(trial.recovery.reversals[side].max(1));
    }
    Ok(trial)
}

fn trace_row(row: &BenchRow) -> TraceRow {
    TraceRow {
        time: row.time,
        desired: row.desired,
        far: row.truth[1],
        near: row.truth[0],
        estimate: row.estimate,
        velocity: row.velocity,
    }
}

/// Measures the recovery of one stroke after the other.
#[derive(Debug, Default)]
struct ReversalWatch {
    direction: f64,
    since: f64,
    /// Time of the last sample outside the tolerance, s since the reversal.
    last_outside: f64,
}

impl ReversalWatch {
    fn update(&mut self, row: &BenchRow, recovery: &mut Recovery) {
        let direction = if row.velocity < 0.0 { -1.0 } else { 1.0 };
        if direction * self.direction < 0.0 {
            // A completed stroke counts if it began with a reversal.
            if self.since > 0.0 {
                let side = usize::from(self.direction < 0.0);
                recovery.seconds[side] += self.last_outside;
                recovery.reversals[side] += 1;
            }
            (self.since, self.last_outside) = (STEP, 0.0);
        } else if self.since > 0.0 {
            self.since += STEP;
        }
        self.direction = direction;
        let recovered = self.since > self.last_outside + RECOVERED_S;
        if self.since > 0.0 && !recovered && (row.truth[1] - row.desired).abs() > RECOVERED_N {
            self.last_outside = self.since;
        }
    }
}
