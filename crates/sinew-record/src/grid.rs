//! Readings as whole numbers of counts, without loss: what rounding adds is kept in units of the last place.

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
    pub fn of(scale: f64) -> Self {
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

    fn value(&self, count: i64) -> f64 {
        let x = count as f64 * self.scale * self.factor / self.divisor * self.arm;
        let on_inner = if self.inner == 0.0 { x } else { (x / self.inner).round() * self.inner };
        on_inner + self.offset
    }

    fn count(&self, x: f64) -> i64 {
        // Casts saturate, and NaN becomes 0.
        ((x - self.offset) / self.pitch()).round() as i64
    }
}

/// Distance of two numbers in units of the last place, by their bits.
fn bits_between(x: f64, y: f64) -> i64 {
    x.to_bits().cast_signed().wrapping_sub(y.to_bits().cast_signed())
}

/// Distance up to which a number counts as on a grid.
const NEAR: u64 = 64;

/// Counts and deviations, units of the last place, of values on the first grid that most of them are on, with its
/// number; 0 is none.
pub(crate) fn split(values: &[f64], grids: &[Grid]) -> (Vec<i64>, Vec<i64>, u32) {
    for (number, grid) in (1..).zip(grids) {
        let counts: Vec<i64> = values.iter().map(|x| grid.count(*x)).collect();
        let rest: Vec<i64> =
            values.iter().zip(&counts).map(|(x, count)| bits_between(*x, grid.value(*count))).collect();
        let near = rest.iter().filter(|rest| rest.unsigned_abs() <= NEAR).count();
        if 2 * near > values.len() {
            return (counts, rest, number);
        }
    }
    let bits = values.iter().map(|x| x.to_bits().cast_signed()).collect();
    (vec![0; values.len()], bits, 0)
}

/// The inverse of [`split`]; none for a grid that there is not.
pub(crate) fn join(counts: &[i64], rest: &[i64], number: u32, grids: &[Grid]) -> Option<Vec<f64>> {
    let grid = match number {
        0 => None,
        number => Some(grids.get(number as usize - 1)?),
    };
    let base = |count: i64| grid.map_or(0, |grid| grid.value(count).to_bits().cast_signed());
    let value =
        |(count, rest): (&i64, &i64)| f64::from_bits(base(*count).wrapping_add(*rest).cast_unsigned());
    Some(counts.iter().zip(rest).map(value).collect())
}

/// Multiples of a resolution; what is not finite becomes [`NOT_FINITE`].
pub(crate) fn round(values: &[f64], resolution: f64) -> Vec<i64> {
    let count = |x: &f64| {
        let count = (x / resolution).round();
        if count.is_finite() { count as i64 } else { NOT_FINITE }
    };
    values.iter().map(count).collect()
}

/// The inverse of [`round`].
pub(crate) fn unround(counts: &[i64], resolution: f64) -> Vec<f64> {
    counts
        .iter()
        .map(|count| if *count == NOT_FINITE { f64::NAN } else { *count as f64 * resolution })
        .collect()
}

/// Stands for a number that is not finite.
const NOT_FINITE: i64 = i64::MIN;

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
            let grids = [Grid { offset: 0.1, inner, ..Grid::of(scale) }, Grid::of(scale)];
            let (counts, rest, number) = split(&values, &grids);
            let joined = join(&counts, &rest, number, &grids).expect("a grid of the list");
            prop_assert!(values.iter().zip(&joined).all(|(a, b)| a.to_bits() == b.to_bits()));
        }
    }

    #[test]
    fn readings_on_a_grid_leave_few_units_of_the_last_place() {
        let grid = Grid { inner: 1000.0 / 8_388_608.0, ..Grid::of(0.05) };
        let values: Vec<f64> = (0..500).map(|k| grid.value(k * 7 % 300)).collect();
        let (_, rest, number) = split(&values, &[Grid::of(0.3), grid]);
        assert_eq!(number, 2);
        assert!(rest.iter().all(|rest| *rest == 0));
    }
}
