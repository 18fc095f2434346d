//! Readings as short numbers that compress well, without loss: what a sensor with whole counts can read is
//! known.

use serde::{Deserialize, Serialize};

/// The values that a sensor with whole counts can have.
///
/// ```text
/// x_k = scale k factor/divisor arm + offset              without an inner grid; the factors in this order
/// x_k = inner round(scale k/inner) + offset              with one: a sensor read by a finer converter
/// ```
#[derive(Debug, Clone, Copy, PartialEq, Serialize, Deserialize)]
#[serde(deny_unknown_fields)]
pub struct Grid {
    /// Per count, not 0.
    pub scale: f64,
    /// Factor after the scale, 1 for none: factors are apart so that products are rounded as in the reading.
    #[serde(default = "one", skip_serializing_if = "is_one")]
    pub factor: f64,
    /// Divisor after the factor, 1 for none.
    #[serde(default = "one", skip_serializing_if = "is_one")]
    pub divisor: f64,
    /// Factor after the divisor, 1 for none.
    #[serde(default = "one", skip_serializing_if = "is_one")]
    pub arm: f64,
    /// Of count 0.
    #[serde(default)]
    pub offset: f64,
    /// Per count of the converter; 0 for none.
    #[serde(default)]
    pub inner: f64,
}

fn one() -> f64 {
    1.0
}

#[expect(clippy::float_cmp, reason = "the neutral factor exactly")]
fn is_one(x: &f64) -> bool {
    *x == 1.0
}

impl Grid {
    /// A grid through 0.
    #[must_use]
    pub fn new(scale: f64) -> Self {
        Self { scale, factor: 1.0, divisor: 1.0, arm: 1.0, offset: 0.0, inner: 0.0 }
    }

    /// Whether every number has a count.
    #[must_use]
    pub fn is_usable(&self) -> bool {
        let pitch = self.pitch();
        pitch.is_normal() && self.offset.is_finite() && self.inner.is_finite()
    }

    /// Between two counts.
    fn pitch(&self) -> f64 {
        self.scale * self.factor / self.divisor * self.arm
    }

    pub(crate) fn value(&self, count: i64) -> f64 {
        let x = count as f64 * self.scale * self.factor / self.divisor * self.arm;
        let on_inner = if self.inner == 0.0 { x } else { (x / self.inner).round() * self.inner };
        on_inner + self.offset
    }

    fn count(&self, x: f64) -> i64 {
        // Casts saturate, and NaN becomes 0.
        ((x - self.offset) / self.pitch()).round() as i64
    }
}

impl Grid {
    /// The value of the nearest count.
    pub(crate) fn snap(&self, x: f64) -> f64 {
        let value = self.value(self.count(x));
        if value == 0.0 { value.copysign(x) } else { value }
    }

    /// A number with few digits, nearer to the value of a count than half of the distance to the next one.
    pub(crate) fn shorten(&self, x: f64) -> f64 {
        let step = (self.pitch().abs().log2().ceil() - 1.0).exp2();
        (self.snap(x) / step).round() * step
    }
}

/// Short numbers for readings, and the number of the first grid that gives all of them back bit for bit; 0 is
/// none, and the readings as they are.
pub(crate) fn shorten(values: &[f64], grids: &[Grid]) -> (Vec<f64>, u32) {
    for (number, grid) in (1..).zip(grids) {
        let short: Vec<f64> =
            values.iter().map(|x| if x.is_nan() { f64::NAN } else { grid.shorten(*x) }).collect();
        let back = short.iter().map(|x| snapped(*x, grid).to_bits());
        if back.eq(values.iter().map(|x| x.to_bits())) {
            return (short, number);
        }
    }
    (values.to_vec(), 0)
}

/// The reading of a short number.
pub(crate) fn snapped(short: f64, grid: &Grid) -> f64 {
    if short.is_nan() { f64::NAN } else { grid.snap(short) }
}

/// Short numbers for multiples of a resolution; what is not finite becomes NaN.
pub(crate) fn round(values: &[f64], resolution: f64) -> Vec<f64> {
    let grid = Grid::new(resolution);
    values.iter().map(|x| if x.is_finite() { grid.shorten(*x) + 0.0 } else { f64::NAN }).collect()
}

#[cfg(test)]
mod tests {
    use super::*;
    use proptest::prelude::*;

    proptest! {
        #[test]
        fn every_number_comes_back_to_the_bit(
            values in prop::collection::vec(prop_oneof![
                any::<u64>().prop_map(f64::from_bits),
                (-100_000_i32..100_000).prop_map(|k| f64::from(k) * 3.83e-4),
            ], 0..200),
            scale in prop_oneof![Just(3.83e-4), 1e-9..1.0_f64],
            inner in prop_oneof![Just(0.0), 1e-9..1e-3_f64],
        ) {
            let grids = [Grid { offset: 0.1, inner, ..Grid::new(scale) }, Grid::new(scale)];
            let (short, number) = shorten(&values, &grids);
            let back = |x: &f64| if number == 0 { *x } else { snapped(*x, &grids[number as usize - 1]) };
            prop_assert!(values.iter().zip(&short).all(|(a, b)| a.to_bits() == back(b).to_bits()));
            let multiples = round(&values, scale);
            for (x, short) in values.iter().zip(&multiples).filter(|(x, _)| x.abs() < 1e6 * scale) {
                prop_assert!((x - short).abs() <= 1.001 * scale);
                let multiple = (x / scale).round() as i64 as f64 * scale;
                prop_assert_eq!((snapped(*short, &Grid::new(scale)) + 0.0).to_bits(), multiple.to_bits());
            }
        }
    }

    #[test]
    fn readings_on_a_grid_have_short_numbers() {
        let grid = Grid { inner: 1000.0 / 8_388_608.0, ..Grid::new(0.05) };
        let values: Vec<f64> = (0..500).map(|k| grid.value(k * 7 % 300)).chain([-0.0, f64::NAN]).collect();
        let (short, number) = shorten(&values, &[Grid::new(0.3), grid]);
        assert_eq!(number, 2);
        assert!(short.iter().all(|x| x.to_bits().trailing_zeros() > 32), "mantissas end in zeros");
    }
}
