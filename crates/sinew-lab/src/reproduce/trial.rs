//! A compensation on trial: Table I in its three readings, from one run at one speed.

use crate::Error;
use crate::experiment::bench::{BenchRow, BenchRun, MuscleControl, STEP, run};
use sinew::metrics::Comparison;

/// Active strokes (toward the muscle's motor) and passive ones, in this order, compared in three ways.
#[derive(Debug, Clone, Copy, Default)]
pub struct Scores {
    /// (a) Achieved against wanted far tension in the steady windows: what the paper's Table I compares.
    pub achieved: [Comparison; 2],
    /// (b) Estimated against true far tension over whole cycles, reversals included.
    pub estimated: [Comparison; 2],
    /// (c) Achieved against wanted over whole cycles.
    pub cycles: [Comparison; 2],
}

/// How long the far end takes after reversals.
#[derive(Debug, Clone, Copy, Default, PartialEq)]
pub struct Recovery {
    /// Mean time from a reversal until the far tension is within 5 N of what is wanted for 0.2 s, s; by the direction
    /// after the reversal. A stroke that never gets there counts whole.
    pub seconds: [f64; 2],
    /// Reversals seen.
    pub reversals: [u32; 2],
}

/// Within which the far end has recovered, N, and for how long, s.
const NEAR_N: f64 = 5.0;
const STAYED_S: f64 = 0.2;
/// Time at the start of a run that does not count, s: nobody knows the state of the cable yet.
const SETTLE_S: f64 = 3.0;

/// A sample for a picture.
#[derive(Debug, Clone, Copy, PartialEq)]
pub struct TraceRow {
    /// s.
    pub time: f64,
    /// Wanted far tension, N.
    pub wanted: f64,
    /// True far and near tension, N.
    pub far: f64,
    /// See [`far`](Self::far).
    pub near: f64,
    /// What the compensation believes, N.
    pub estimate: f64,
    /// Speed of the cable, m/s.
    pub velocity: f64,
}

/// What a run showed.
#[derive(Debug, Clone)]
pub struct Trial {
    /// Its comparisons.
    pub scores: Scores,
    /// Its reversals.
    pub recovery: Recovery,
    /// Mean of `|T_in - T_out|` in the steady windows, N.
    pub lost: [f64; 2],
    /// Samples for a picture, every 20 ms of the seconds asked for.
    pub trace: Vec<TraceRow>,
}

/// Runs for `seconds`; samples between the two times of `drawn`, s, are kept for a picture.
///
/// # Errors
/// [`Error::Experiment`] where the run ends early; [`Error::Physics`] for a specimen that is none.
pub fn on_trial(
    wanted: &BenchRun,
    steering: MuscleControl<'_>,
    seconds: f64,
    drawn: [f64; 2],
) -> Result<Trial, Error> {
    let mut trial =
        Trial { scores: Scores::default(), recovery: Recovery::default(), lost: [0.0; 2], trace: Vec::new() };
    let mut watch = ReversalWatch::default();
    let mut count = 0_u64;
    let stop = run(wanted, steering, seconds, |row| {
        count += 1;
        let drawn = row.time >= drawn[0] && row.time < drawn[1];
        if drawn && count % 20 == 1 {
            trial.trace.push(trace_row(row));
        }
        if row.time < SETTLE_S {
            return;
        }
        let side = usize::from(row.velocity < 0.0);
        let [near, far] = row.truth;
        let scores = &mut trial.scores;
        // The plant's tensions are finite; a belief that is not is not counted, and shows in the count.
        let _ = scores.cycles[side].push(row.wanted, far);
        let _ = scores.estimated[side].push(far, row.estimate);
        if row.window != 0.0 {
            let _ = scores.achieved[side].push(row.wanted, far);
            trial.lost[side] += (near - far).abs();
        }
        watch.see(row, &mut trial.recovery);
    })?;
    if let Some(stop) = stop {
        return Err(Error::experiment("bench run", "no cable or drive that gives up", &format!("{stop:?}")));
    }
    for side in 0..2 {
        trial.lost[side] /= (trial.scores.achieved[side].count() as f64).max(1.0);
        trial.recovery.seconds[side] /= f64::from(trial.recovery.reversals[side].max(1));
    }
    Ok(trial)
}

fn trace_row(row: &BenchRow) -> TraceRow {
    TraceRow {
        time: row.time,
        wanted: row.wanted,
        far: row.truth[1],
        near: row.truth[0],
        estimate: row.estimate,
        velocity: row.velocity,
    }
}

/// Follows one stroke after the other.
#[derive(Debug, Default)]
struct ReversalWatch {
    direction: f64,
    since: f64,
    /// When it was last too far off, s since the reversal.
    off: f64,
}

impl ReversalWatch {
    fn see(&mut self, row: &BenchRow, recovery: &mut Recovery) {
        let direction = if row.velocity < 0.0 { -1.0 } else { 1.0 };
        if direction * self.direction < 0.0 {
            // The stroke that ends was recorded if it began with a reversal.
            if self.since > 0.0 {
                let side = usize::from(self.direction < 0.0);
                recovery.seconds[side] += self.off;
                recovery.reversals[side] += 1;
            }
            (self.since, self.off) = (STEP, 0.0);
        } else if self.since > 0.0 {
            self.since += STEP;
        }
        self.direction = direction;
        let back = self.since > self.off + STAYED_S;
        if self.since > 0.0 && !back && (row.truth[1] - row.wanted).abs() > NEAR_N {
            self.off = self.since;
        }
    }
}
