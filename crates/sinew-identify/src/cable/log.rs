//! Sequences for the observer, and the observer run along them.

use crate::Error;
use sinew::predictor::{CableEstimate, CableModel, CableObserver, CableSample};

/// One uninterrupted sequence of a bench or an arm.
#[derive(Debug, Clone, Default)]
pub struct CableLog {
    /// Seconds since the sample before; not above zero, or beyond 1 s, resets the observer: `[n]`.
    pub interval_s: Vec<f64>,
    /// Inputs of the observer: `[n]`.
    pub samples: Vec<CableSample>,
    /// Measured far tension, N: `[n]`.
    pub far: Vec<f64>,
    /// 1 where the far sensor counts, 0 where it does not: `[n]`.
    pub weight: Vec<f64>,
}

impl CableLog {
    /// Number of samples.
    #[must_use]
    pub fn len(&self) -> usize {
        self.samples.len()
    }

    /// Whether there is no sample.
    #[must_use]
    pub fn is_empty(&self) -> bool {
        self.samples.is_empty()
    }

    /// How long it lasts, s.
    pub(super) fn seconds(&self) -> f64 {
        self.interval_s.iter().sum()
    }

    /// Appends a sample.
    pub fn push(&mut self, interval_s: f64, sample: CableSample, far: f64) {
        self.interval_s.push(interval_s);
        self.samples.push(sample);
        self.far.push(if far.is_finite() { far } else { 0.0 });
        self.weight.push(f64::from(u8::from(far.is_finite())));
    }

    /// The same with intervals of up to `longest` seconds, where the log has shorter ones.
    fn thinned(&self, longest: f64) -> Self {
        let (mut thinned, mut since) = (Self::default(), 0.0);
        for (row, interval) in self.interval_s.iter().enumerate() {
            let resets = row == 0 || *interval <= 0.0 || interval.is_nan();
            since = if resets { *interval } else { since + interval };
            let next = self.interval_s.get(row + 1).copied().unwrap_or(f64::INFINITY);
            if resets || next <= 0.0 || since + next > longest || next.is_nan() {
                thinned.interval_s.push(since);
                thinned.samples.push(self.samples[row]);
                thinned.far.push(self.far[row]);
                thinned.weight.push(self.weight[row]);
                since = 0.0;
            }
        }
        thinned
    }

    /// A part of it, which resets the observer.
    fn part(&self, rows: std::ops::Range<usize>) -> Self {
        Self {
            interval_s: self.interval_s[rows.clone()].to_vec(),
            samples: self.samples[rows.clone()].to_vec(),
            far: self.far[rows.clone()].to_vec(),
            weight: self.weight[rows].to_vec(),
        }
    }

    /// Refuses lists of different lengths.
    pub(super) fn check(&self, place: usize) -> Result<(), Error> {
        let n = self.samples.len();
        for (name, got) in
            [("interval_s", self.interval_s.len()), ("far", self.far.len()), ("weight", self.weight.len())]
        {
            if got != n {
                return Err(Error::samples(format!("log {place}, {name}"), format!("{n} entries"), &got));
            }
        }
        let bad = self.far.iter().zip(&self.weight).position(|(y, w)| *w > 0.0 && !y.is_finite());
        match bad {
            Some(row) => Err(Error::samples(
                format!("log {place}, far, sample {row}"),
                "a finite number where the weight is above zero",
                &self.far[row],
            )),
            None => Ok(()),
        }
    }
}

/// The observer's estimates along a log, started anew at its first sample.
///
/// # Errors
/// [`Error::Physics`] where the model is none.
pub fn observe_log(model: &CableModel, log: &CableLog) -> Result<Vec<CableEstimate>, Error> {
    let mut observer = CableObserver::new(model)?;
    Ok(log
        .interval_s
        .iter()
        .zip(&log.samples)
        .map(|(interval, sample)| observer.step(*interval, sample))
        .collect())
}

/// Intervals, s, and samples of all logs together that are enough to find out from where to search.
const COARSE_S: f64 = 0.012;
/// See [`COARSE_S`].
const COARSE_SAMPLES: usize = 12_000;

/// Parts of logs from whose fit that of `logs` can begin, in a fraction of the time.
pub(super) fn coarse(logs: &[CableLog]) -> Vec<CableLog> {
    shortened(&thinned(logs), COARSE_SAMPLES)
}

/// Logs with their lengths and fewer samples.
pub(super) fn thinned(logs: &[CableLog]) -> Vec<CableLog> {
    logs.iter().map(|log| log.thinned(COARSE_S)).collect()
}

/// Samples of one piece of a log that is too long to be used whole: an observer needs some seconds to know
/// its state.
const PIECE: usize = 20_000;

/// About `most` samples of all logs together, in pieces spread evenly over each of them.
pub(super) fn shortened(logs: &[CableLog], most: usize) -> Vec<CableLog> {
    let total: usize = logs.iter().map(CableLog::len).sum();
    if total <= most {
        return logs.to_vec();
    }
    let fraction = most as f64 / total as f64;
    let mut pieces = Vec::new();
    for log in logs {
        let kept = (fraction * log.len() as f64) as usize;
        let count = kept.div_ceil(PIECE).max(1);
        let (length, stride) = (kept / count, log.len() / count);
        pieces.extend((0..count).map(|k| log.part(k * stride..k * stride + length)));
    }
    pieces
}

/// The same part of every log from its beginning, `most` samples of all together.
pub(super) fn beginnings(logs: &[CableLog], most: usize) -> Vec<CableLog> {
    let total: usize = logs.iter().map(CableLog::len).sum();
    let kept = |log: &CableLog| if total <= most { log.len() } else { log.len() * most / total };
    logs.iter().map(|log| log.part(0..kept(log))).collect()
}

#[cfg(test)]
mod tests {
    use super::*;

    #[test]
    fn a_long_log_is_sampled_in_pieces_from_all_of_it() {
        let mut log = CableLog::default();
        for k in 0..500_000 {
            log.push(1e-3, CableSample { motor: f64::from(k), anchor: 0.0, tension_in: 1.0 }, 1.0);
        }
        let pieces = shortened(&[log.clone(), log.part(0..1000)], 80_000);
        let total: usize = pieces.iter().map(CableLog::len).sum();
        assert!((79_000..=80_000).contains(&total), "{total}");
        assert!(pieces[..4].iter().all(|piece| piece.len() > 15_000 && piece.check(0).is_ok()));
        assert!(pieces[3].samples[0].motor > 350_000.0);
        assert_eq!(shortened(std::slice::from_ref(&log), 500_000)[0].len(), 500_000);
        let begun = beginnings(&[log.clone(), log.part(0..1000)], 50_100);
        assert_eq!(begun.iter().map(CableLog::len).collect::<Vec<_>>(), [50_000, 100]);
        assert!(begun[0].samples[0].motor < 1.0 && beginnings(&begun, 50_100)[1].len() == 100);
    }

    #[test]
    fn a_thinned_log_keeps_its_time_and_what_resets_the_observer() {
        let mut log = CableLog::default();
        for k in 0..3000 {
            let interval = if k % 1000 == 0 { 0.0 } else { 1e-3 };
            log.push(interval, CableSample { motor: f64::from(k), anchor: 0.0, tension_in: 1.0 }, 1.0);
        }
        let thinned = log.thinned(0.012);
        assert!((250..280).contains(&thinned.len()) && thinned.check(0).is_ok(), "{}", thinned.len());
        assert!((thinned.seconds() - log.seconds()).abs() < 1e-9, "{}", thinned.seconds());
        assert!(thinned.interval_s.iter().all(|interval| *interval < 0.0121));
        assert_eq!(thinned.interval_s.iter().filter(|interval| **interval <= 0.0).count(), 3);
        // What is too coarse already stays as it is.
        assert_eq!(thinned.thinned(0.012).len(), thinned.len());
    }
}
