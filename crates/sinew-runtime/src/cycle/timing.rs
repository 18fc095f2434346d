use hdrhistogram::Histogram;
use sinew_session::CycleTimes;

/// How well the deadlines of a cycle are kept: histograms that record without allocation or lock.
#[derive(Debug, Clone)]
pub struct Timing {
    histograms: [Histogram<u64>; QUANTITIES.len()],
    woken: Option<u64>,
    read: Option<u64>,
    skipped: u64,
}

/// Quantities, in the order of their recording.
const QUANTITIES: [&str; 6] = ["period", "wake-up", "read", "control", "write", "frame to frame"];
/// Longest time that is told apart, ns; longer ones count as this.
const LONGEST: u64 = 1_000_000_000;
/// Significant decimal digits.
const DIGITS: u8 = 3;

/// Quantiles of one quantity, us.
#[derive(Debug, Clone, Copy, PartialEq)]
pub struct TimingRow {
    /// `period`: from wake-up to wake-up. `wake-up`: after the deadline. `read` and `write`: of the bus.
    /// `control`: of the controller. `frame to frame`: from the end of one reading to that of the next.
    pub quantity: &'static str,
    /// us.
    pub median: f64,
    /// us.
    pub p99: f64,
    /// us.
    pub p999: f64,
    /// us.
    pub max: f64,
}

impl Default for Timing {
    fn default() -> Self {
        Self::new()
    }
}

impl Timing {
    /// Before the first cycle.
    #[must_use]
    #[expect(clippy::expect_used, reason = "the bounds are constants within the histogram's domain")]
    pub fn new() -> Self {
        let empty = || Histogram::new_with_bounds(1, LONGEST, DIGITS).expect("constant bounds");
        Self { histograms: std::array::from_fn(|_| empty()), woken: None, read: None, skipped: 0 }
    }

    /// Records one cycle and its deadline, ns.
    pub fn record(&mut self, deadline: u64, times: &CycleTimes) {
        let CycleTimes { woken, read, controlled, written, .. } = *times;
        let since = |earlier: Option<u64>, now: u64| earlier.map(|earlier| now.saturating_sub(earlier));
        let times = [
            since(self.woken, woken),
            Some(woken.saturating_sub(deadline)),
            Some(read.saturating_sub(woken)),
            Some(controlled.saturating_sub(read)),
            Some(written.saturating_sub(controlled)),
            since(self.read, read),
        ];
        for (histogram, time) in self.histograms.iter_mut().zip(times) {
            if let Some(time) = time {
                histogram.saturating_record(time);
            }
        }
        (self.woken, self.read) = (Some(woken), Some(read));
    }

    /// Counts deadlines that passed during a late cycle.
    pub fn skip(&mut self, deadlines: u64) {
        self.skipped += deadlines;
    }

    /// Deadlines that passed during late cycles.
    #[must_use]
    pub fn skipped(&self) -> u64 {
        self.skipped
    }

    /// Number of cycles.
    #[must_use]
    pub fn cycles(&self) -> u64 {
        self.histograms[1].len()
    }

    /// Quantiles of every quantity.
    #[must_use]
    pub fn rows(&self) -> [TimingRow; QUANTITIES.len()] {
        std::array::from_fn(|k| {
            let at = |quantile: f64| self.histograms[k].value_at_quantile(quantile) as f64 * 1e-3;
            TimingRow {
                quantity: QUANTITIES[k],
                median: at(0.5),
                p99: at(0.99),
                p999: at(0.999),
                max: self.histograms[k].max() as f64 * 1e-3,
            }
        })
    }

    /// Fraction of the cycles of every quantity between these times, us, with their last bin open:
    /// `[quantities][bins]`.
    #[must_use]
    pub fn fractions(&self, edges: &[f64]) -> Vec<(&'static str, Vec<f64>)> {
        QUANTITIES
            .iter()
            .zip(&self.histograms)
            .map(|(quantity, histogram)| {
                let all = histogram.len().max(1) as f64;
                let fraction = |k: usize| {
                    let from = (edges[k] * 1e3) as u64;
                    let to = edges.get(k + 1).map_or(u64::MAX, |edge| (edge * 1e3) as u64 - 1);
                    histogram.count_between(from, to) as f64 / all
                };
                (*quantity, (0..edges.len()).map(fraction).collect())
            })
            .collect()
    }
}

#[cfg(test)]
mod tests {
    use super::*;

    #[test]
    fn the_quantiles_are_those_of_the_recorded_times() {
        let mut timing = Timing::new();
        for k in 0..1000_u64 {
            let deadline = 1_000_000 * (k + 1);
            let woken = deadline + 30_000 + if k == 500 { 400_000 } else { 0 };
            let times = CycleTimes {
                deadline,
                woken,
                read: woken + 10_000,
                controlled: woken + 30_000,
                written: woken + 37_000,
            };
            timing.record(deadline, &times);
        }
        let rows = timing.rows();
        assert_eq!(timing.cycles(), 1000);
        let [period, wake, read, control, write, frame] = rows;
        let near = |a: f64, b: f64| (a - b).abs() <= 0.01 * b;
        assert!(near(period.median, 1000.0) && near(period.max, 1400.0), "{period:?}");
        assert!(near(wake.median, 30.0) && near(wake.p99, 30.0) && near(wake.max, 430.0), "{wake:?}");
        assert!(near(read.median, 10.0) && near(control.max, 20.0) && near(write.p99, 7.0));
        assert!(near(frame.median, 1000.0));
        let fractions = timing.fractions(&[0.0, 50.0]);
        assert!((fractions[1].1[1] - 1e-3).abs() < 1e-9, "one late wake-up in a thousand: {fractions:?}");
    }
}
