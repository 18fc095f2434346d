//! Axes: ranges robust against outliers, round ticks, quantiles.

use super::format::{fixed, significant};

/// A linear axis from `low` to `high`, `low < high`, both finite.
#[derive(Debug, Clone)]
pub(super) struct Axis {
    /// Value at the start.
    pub(super) low: f64,
    /// Value at the end.
    pub(super) high: f64,
    step: f64,
}

impl Axis {
    /// An axis over a range, with about `count` ticks; an empty or infinite range becomes one around zero.
    pub(super) fn new((low, high): (f64, f64), count: usize) -> Self {
        let (low, high) = if !(low.is_finite() && high.is_finite()) {
            (-1.0, 1.0)
        } else if high - low > 1e-12 * low.abs().max(high.abs()) {
            (low, high)
        } else {
            // A constant is centred on an axis of its own magnitude.
            let half = if low.abs() < f64::MIN_POSITIVE { 1.0 } else { 0.5 * low.abs() };
            (low - half, low + half)
        };
        // Two labels at least: one alone does not determine a scale.
        let step = [1.0, 2.0, 4.0, 8.0].map(|more| round_step((high - low) / (count.max(1) as f64 * more)));
        let labels = |step: &f64| (high / step + 1e-9).floor() - (low / step - 1e-9).ceil() >= 1.0;
        let step = step.into_iter().find(labels).unwrap_or(step[3]);
        Self { low, high, step }
    }

    /// Position of a value, 0 to 1 within the axis; NaN stays NaN.
    pub(super) fn at(&self, value: f64) -> f64 {
        (value - self.low) / (self.high - self.low)
    }

    /// Round values within the axis with their labels.
    pub(super) fn ticks(&self) -> Vec<(f64, String)> {
        let first = (self.low / self.step - 1e-9).ceil();
        let decimals = usize::try_from((-self.step.log10().floor()) as i64).unwrap_or(0);
        let exotic = self.low.abs().max(self.high.abs()) >= 1e5 || decimals > 4;
        // As many digits as tell neighbours apart.
        let largest = self.low.abs().max(self.high.abs());
        let digits = ((largest / self.step).log10().ceil().max(0.0) as usize + 1).clamp(3, 15);
        (0..24)
            .map(|k| (first + f64::from(k)) * self.step)
            .take_while(|value| *value <= self.high + 1e-9 * self.step)
            .map(|value| {
                let value = if value.abs() < 1e-9 * self.step { 0.0 } else { value };
                (value, if exotic { significant(value, digits) } else { fixed(value, decimals) })
            })
            .collect()
    }
}

/// 1, 2 or 5 times a power of ten, near `step`.
pub(super) fn round_step(step: f64) -> f64 {
    let power = 10f64.powf(step.log10().floor());
    [1.0, 2.0, 5.0, 10.0].into_iter().map(|m| m * power).find(|s| *s >= 0.7 * step).unwrap_or(step)
}

/// The range of the finite values, limited to the inner 99.8 % where outliers would make it much longer.
pub(super) fn robust_range(values: impl Iterator<Item = f64>) -> (f64, f64) {
    let mut sorted: Vec<f64> = values.filter(|v| v.is_finite()).collect();
    sorted.sort_by(f64::total_cmp);
    let (Some(&least), Some(&most)) = (sorted.first(), sorted.last()) else { return (f64::NAN, f64::NAN) };
    let inner = (quantile(&sorted, 0.001), quantile(&sorted, 0.999));
    extended(inner, (least, most))
}

/// Length of an axis that takes in all values, in multiples of one of the usual ones.
const ROOM: f64 = 1.6;

/// The inner range, at each end that of the outer one where it does not become much longer by that: 1.6 times
/// as long in all.
pub(super) fn extended((low, high): (f64, f64), outer: (f64, f64)) -> (f64, f64) {
    let (least, most) = (outer.0.min(low), outer.1.max(high));
    let fits = |low: f64, high: f64, inner: f64| high - low <= ROOM * inner;
    let inner = high - low;
    // Nothing to compare with, or all that is there.
    if !(inner > 0.0 && inner.is_finite()) || fits(least, most, inner) {
        (least, most)
    } else if fits(low, most, inner) {
        (low, most)
    } else if fits(least, high, inner) {
        (least, high)
    } else {
        (low, high)
    }
}

/// A range, a constant in place of one that is only rounding.
pub(super) fn settled((low, high): (f64, f64)) -> (f64, f64) {
    const ROUNDING: f64 = 1e-9;
    match high - low > ROUNDING {
        true => (low, high),
        false if low.abs().max(high.abs()) <= ROUNDING => (0.0, 0.0),
        false => (0.5 * (low + high), 0.5 * (low + high)),
    }
}

/// Half range of an axis around zero: the largest magnitude, at most twice the 99 % quantile.
pub(super) fn robust_reach(values: impl Iterator<Item = f64>) -> f64 {
    let mut sorted: Vec<f64> = values.map(f64::abs).filter(|v| v.is_finite()).collect();
    sorted.sort_by(f64::total_cmp);
    quantile(&sorted, 1.0).min(2.0 * quantile(&sorted, 0.99))
}

/// The range with `fraction` of its length added at both ends.
pub(super) fn padded((low, high): (f64, f64), fraction: f64) -> (f64, f64) {
    let more = fraction * (high - low);
    (low - more, high + more)
}

/// Quantile by linear interpolation in sorted values; NaN of an empty list.
pub(super) fn quantile(sorted: &[f64], q: f64) -> f64 {
    let Some(last) = sorted.len().checked_sub(1) else { return f64::NAN };
    let place = q.clamp(0.0, 1.0) * last as f64;
    let below = place.floor() as usize;
    let (a, b) = (sorted[below.min(last)], sorted[(below + 1).min(last)]);
    a + (place - place.floor()) * (b - a)
}

#[cfg(test)]
mod tests {
    use super::*;

    #[test]
    fn ticks_are_round_and_within_the_axis() {
        let axis = Axis::new((-3.2, 11.9), 6);
        let labels: Vec<String> = axis.ticks().into_iter().map(|t| t.1).collect();
        assert_eq!(labels, ["\u{2212}2", "0", "2", "4", "6", "8", "10"]);
        assert!(axis.ticks().iter().all(|(v, _)| (0.0..=1.0).contains(&axis.at(*v))));
    }

    #[test]
    fn an_axis_of_no_values_or_of_a_constant_is_valid() {
        for range in [(f64::NAN, f64::NAN), (3.0, 3.0), (0.0, 0.0), (f64::NEG_INFINITY, 1.0), (1e300, 1e300)]
        {
            let axis = Axis::new(range, 5);
            assert!(axis.low < axis.high, "{range:?}");
            assert!(axis.ticks().len() < 25);
        }
    }

    #[test]
    fn every_axis_has_two_labels_at_least() {
        for k in 0..2000 {
            let (low, width) = (f64::from(k % 97) * 0.173 - 8.0, 10f64.powf(f64::from(k % 13) - 6.0) * 1.37);
            for count in 1..7 {
                let axis = Axis::new((low, low + width * (1.0 + f64::from(k % 7))), count);
                let ticks = axis.ticks();
                assert!(ticks.len() > 1, "{low} {width} {count}");
                assert!(ticks.windows(2).all(|pair| pair[0].1 != pair[1].1), "{ticks:?}");
            }
        }
    }

    #[test]
    fn a_range_takes_in_all_values_that_make_it_little_longer() {
        assert_eq!(extended((25.01, 25.6), (25.0, 25.6)), (25.0, 25.6));
        assert_eq!(extended((0.0, 1.0), (-5.0, 1.2)), (0.0, 1.2));
        assert_eq!(extended((0.0, 1.0), (-5.0, 9.0)), (0.0, 1.0));
        assert_eq!(extended((3.0, 3.0), (1.0, 4.0)), (1.0, 4.0));
        assert_eq!(settled((-1e-17, 2e-16)), (0.0, 0.0));
        assert_eq!(settled((1.0, 2.0)), (1.0, 2.0));
    }

    #[test]
    fn a_single_outlier_does_not_determine_the_range() {
        let values = (0..10_000).map(|i| if i == 5000 { 1e6 } else { f64::from(i % 100) });
        let (low, high) = robust_range(values);
        assert!(low.abs() < 1e-9 && (98.0..=99.0).contains(&high), "{low} {high}");
    }
}
