//! Dense signals: what would fill its plot as a solid block is drawn by its extremes and its mean.

use super::plot::Plot;
use super::scale::Axis;
use super::svg_path::{line, ribbon};

/// Pieces of time in which such a signal is drawn by its extremes, about two pixels wide.
const PIECES: usize = 150;
/// Fraction of the axis that a signal crosses in a piece on average, from which on that is so.
const DENSE: f64 = 0.1;
/// The same of a single piece in which the signal goes to and fro.
const SWUNG: f64 = 0.05;
/// Way of a signal in a piece, in multiples of its swing there, from which on it goes to and fro.
const TO_AND_FRO: f64 = 2.5;
/// Fraction of the pieces to and fro from which on all pieces are drawn by their extremes.
const MANY: f64 = 0.1;
/// Class and name of the area between the extremes.
pub(super) const ENVELOPE: (&str, &str) = ("envelope", "from smallest to largest, the line is the mean");

/// A piece of a signal.
#[derive(Debug)]
struct Piece {
    time: f64,
    mean: f64,
    low: f64,
    high: f64,
    /// Way from point to point.
    way: f64,
}

impl Piece {
    fn new(points: &[(f64, f64)]) -> Self {
        let count = points.len() as f64;
        let mean = |of: fn(&(f64, f64)) -> f64| points.iter().map(of).sum::<f64>() / count;
        Self {
            time: mean(|point| point.0),
            mean: mean(|point| point.1),
            low: points.iter().fold(f64::INFINITY, |low, point| low.min(point.1)),
            high: points.iter().fold(f64::NEG_INFINITY, |high, point| high.max(point.1)),
            way: points.windows(2).map(|pair| (pair[1].1 - pair[0].1).abs()).sum(),
        }
    }

    fn swing(&self) -> f64 {
        self.high - self.low
    }
}

/// Pieces of a signal that crosses its axis in most of them, or goes to and fro in many.
fn dense(points: &[(f64, f64)], span: f64) -> Option<Vec<Piece>> {
    let pieces: Vec<Piece> = points.chunks(points.len().div_ceil(PIECES).max(4)).map(Piece::new).collect();
    let known: Vec<&Piece> = pieces.iter().filter(|piece| piece.swing().is_finite()).collect();
    let count = known.len() as f64;
    let crosses = known.iter().map(|piece| piece.swing()).sum::<f64>() > DENSE * span * count;
    let swung = |piece: &&&Piece| piece.swing() > SWUNG * span && piece.way > TO_AND_FRO * piece.swing();
    let swings = known.iter().filter(swung).count() as f64 > MANY * count;
    (crosses || swings).then_some(pieces)
}

/// Draws a signal over time as a line, a dense one as its mean above the area between its extremes.
pub(super) fn draw(
    plot: &mut Plot,
    (class, name): (&'static str, &str),
    points: Vec<(f64, f64)>,
    (x, y): (&Axis, &Axis),
) {
    let Some(pieces) = dense(&points, y.high - y.low) else {
        plot.draw(class, name, line(points.into_iter(), x, y));
        return;
    };
    plot.draw(ENVELOPE.0, ENVELOPE.1, ribbon(pieces.iter().map(|p| (p.time, p.low, p.high)), x, y));
    plot.draw(class, name, line(pieces.iter().map(|p| (p.time, p.mean)), x, y));
}

#[cfg(test)]
mod tests {
    use super::*;

    fn signal(of: impl Fn(f64) -> f64) -> Vec<(f64, f64)> {
        (0..6000).map(|k| f64::from(k) * 0.01).map(|t| (t, of(t))).collect()
    }

    #[test]
    fn a_signal_that_swings_across_its_axis_is_drawn_by_its_extremes_and_a_slow_one_as_it_is() {
        let pieces = dense(&signal(|t| (40.0 * t).sin()), 2.0).unwrap();
        assert!(pieces.len() <= PIECES);
        let whole = pieces.iter().filter(|p| p.low < -0.9 && p.high > 0.9 && p.mean.abs() < 0.5);
        assert_eq!(whole.count(), pieces.len());
        assert!(dense(&signal(|t| (0.5 * t).sin()), 2.0).is_none());
        assert!(dense(&[], 2.0).is_none() && dense(&signal(|_| f64::NAN), 2.0).is_none());
    }

    #[test]
    fn a_band_that_is_low_beside_its_axis_or_shorter_than_the_run_is_drawn_by_its_extremes() {
        assert!(dense(&signal(|t| 0.04 * (40.0 * t).sin()), 1.0).is_some());
        assert!(dense(&signal(|t| if t < 9.0 { 0.05 * (40.0 * t).sin() } else { 0.0 }), 1.0).is_some());
        // Steps and ramps pass through a piece once.
        assert!(dense(&signal(|t| if (t / 6.0) as i64 % 2 == 0 { 0.0 } else { 1.0 }), 1.0).is_none());
    }
}
