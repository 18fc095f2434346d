//! Tables II and III, figures 9 and 10: the mechanism itself, from the calibration runs.

use crate::experiment::bench::BenchRow;
use crate::paper::{self, LENGTH_M, SPEEDS};

/// One sample of figures 9 and 10.
#[derive(Debug, Clone, Copy, PartialEq)]
pub struct Point {
    /// N.
    pub near: f64,
    /// N.
    pub far: f64,
    /// mm.
    pub stretch: f64,
}

/// What the calibration runs show of the cable in its steady windows: `[active, passive][speed]`.
#[derive(Debug, Clone, Default)]
pub struct Mechanism {
    /// Mean and standard deviation of `T_out/T_in`, 1.
    pub efficiency: [[[f64; 2]; 6]; 2],
    /// Mean and standard deviation of elongation over near tension and length, 1e-3 m/(N m).
    pub elongation: [[[f64; 2]; 6]; 2],
    /// Points for pictures.
    pub points: [[Vec<Point>; 6]; 2],
    /// Mean of `|T_in - T_out|`, N, over all speeds.
    pub lost: [f64; 2],
}

/// Samples between points of a picture.
const EVERY: usize = 150;

impl Mechanism {
    /// From one run per speed of [`SPEEDS`], in this order.
    ///
    /// The ratio is of the true tensions, as both of the paper's load cells have none of the noise left in a mean.
    #[must_use]
    pub fn of(runs: &[Vec<BenchRow>]) -> Self {
        let mut found = Self::default();
        let mut lost = [Moments::default(), Moments::default()];
        for (speed, rows) in runs.iter().enumerate().take(SPEEDS.len()) {
            let mut ratio = [Moments::default(), Moments::default()];
            let mut stretch = [Moments::default(), Moments::default()];
            for (k, row) in rows.iter().enumerate().filter(|(_, row)| row.window != 0.0) {
                let side = usize::from(row.window < 0.0);
                let [near, far] = row.truth;
                ratio[side].push(far / near);
                stretch[side].push(1e3 * row.stretch / (near * LENGTH_M));
                lost[side].push((near - far).abs());
                if k % EVERY == 0 {
                    found.points[side][speed].push(Point { near, far, stretch: 1e3 * row.stretch });
                }
            }
            for side in 0..2 {
                found.efficiency[side][speed] = ratio[side].account();
                found.elongation[side][speed] = stretch[side].account();
            }
        }
        found.lost = lost.map(|lost| lost.account()[0]);
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

/// Mean and spread of a stream.
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
            let off = value - self.mean;
            self.mean += off / self.count;
            self.squares += off * (value - self.mean);
        }
    }

    fn account(self) -> [f64; 2] {
        [self.mean, (self.squares / (self.count - 1.0).max(1.0)).sqrt()]
    }
}
