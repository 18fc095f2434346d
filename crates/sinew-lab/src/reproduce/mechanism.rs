//! Tables II and III, figures 9 and 10: efficiency and elongation in the calibration runs.

use crate::experiment::bench::BenchRow;
use crate::paper::{self, LENGTH_M, SPEEDS};

/// One sample of figures 9 and 10.
#[derive(Debug, Clone, Copy, PartialEq)]
pub struct Point {
    /// Tension at the drive, N.
    pub near: f64,
    /// Tension at the anchor, N.
    pub far: f64,
    /// mm.
    pub stretch: f64,
}

/// Statistics of the cable in the steady windows of the calibration runs: `[active, passive][speed]`.
#[derive(Debug, Clone, Default)]
pub struct Mechanism {
    /// Mean and standard deviation of `T_out/T_in`, 1.
    pub efficiency: [[[f64; 2]; 6]; 2],
    /// Mean and standard deviation of elongation over near tension and length, 1e-3 m/(N m).
    pub elongation: [[[f64; 2]; 6]; 2],
    /// Points of figures 9 and 10.
    pub points: [[Vec<Point>; 6]; 2],
    /// Mean of `|T_in - T_out|`, N, over all speeds.
    pub tension_loss: [f64; 2],
}

/// Decimation of the points.
const DECIMATION: usize = 150;

impl Mechanism {
    /// Statistics of one run per speed of [`SPEEDS`], in this order.
    ///
    /// Ratios use the true tensions: the noise of load cells averages out in a mean.
    #[must_use]
    pub fn new(runs: &[Vec<BenchRow>]) -> Self {
        let mut found = Self::default();
        let mut loss = [Moments::default(), Moments::default()];
        for (speed, rows) in runs.iter().enumerate().take(SPEEDS.len()) {
            let mut ratio = [Moments::default(), Moments::default()];
            let mut stretch = [Moments::default(), Moments::default()];
            for (k, row) in rows.iter().enumerate().filter(|(_, row)| row.window != 0.0) {
                let side = usize::from(row.window < 0.0);
                let [near, far] = row.truth;
                ratio[side].push(far / near);
                stretch[side].push(1e3 * row.stretch / (near * LENGTH_M));
                loss[side].push((near - far).abs());
                if k % DECIMATION == 0 {
                    found.points[side][speed].push(Point { near, far, stretch: 1e3 * row.stretch });
                }
            }
            for side in 0..2 {
                found.efficiency[side][speed] = ratio[side].mean_and_deviation();
                found.elongation[side][speed] = stretch[side].mean_and_deviation();
            }
        }
        found.tension_loss = loss.map(|loss| loss.mean_and_deviation()[0]);
        found
    }

    /// Relative differences of the 24 means from the paper's, as root mean square and as the largest.
    #[must_use]
    pub fn differences(&self) -> [f64; 2] {
        let (mut squares, mut largest) = (0.0, 0.0_f64);
        for (found, reported) in
            [(&self.efficiency, &paper::EFFICIENCY), (&self.elongation, &paper::ELONGATION)]
        {
            for (found, reported) in found.iter().flatten().zip(reported.iter().flatten()) {
                let difference = found[0] / reported - 1.0;
                squares += difference * difference / 24.0;
                largest = largest.max(difference.abs());
            }
        }
        [squares.sqrt(), largest]
    }
}

/// Mean and standard deviation of a stream, by Welford's method.
#[derive(Debug, Clone, Copy, Default)]
struct Moments {
    count: f64,
    mean: f64,
    squares: f64,
}

impl Moments {
    fn push(&mut self, value: f64) {
        if value.is_finite() {
            self.count += 1.0;
            let deviation = value - self.mean;
            self.mean += deviation / self.count;
            self.squares += deviation * (value - self.mean);
        }
    }

    fn mean_and_deviation(self) -> [f64; 2] {
        [self.mean, (self.squares / (self.count - 1.0).max(1.0)).sqrt()]
    }
}
