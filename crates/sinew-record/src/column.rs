//! A column of integers as a first one and the residuals of a prediction from those before.
//!
//! | predictor | prediction of `x_i` |
//! |---|---|
//! | 0 | 0 |
//! | 1 | `x_(i-1)` |
//! | 2 | `2 x_(i-1) - x_(i-2)`; `x_0` for `x_1` |
//! | 3 | `(s_(i-1) + 8) >> 4` with `s_0 = 16 x_0`, `s_i = s_(i-1) + ((16 x_i - s_(i-1)) >> 3)` |
//!
//! Sums wrap around. The predictor and the Rice parameter with the shortest code are chosen for every block.

use crate::bits::{BitReader, BitWriter, MAX_PARAMETER, length, zigzag};
use crate::messages::Column;

const PREDICTORS: u32 = 4;

/// Prediction from the values so far.
#[derive(Debug, Clone, Copy)]
struct Predictor {
    kind: u32,
    last: i64,
    before: i64,
    smooth: i64,
}

impl Predictor {
    fn new(kind: u32, first: i64) -> Self {
        Self { kind, last: first, before: first, smooth: first.wrapping_mul(16) }
    }

    #[inline]
    fn predict(&self) -> i64 {
        match self.kind {
            0 => 0,
            1 => self.last,
            2 => self.last.wrapping_mul(2).wrapping_sub(self.before),
            _ => self.smooth.wrapping_add(8) >> 4,
        }
    }

    #[inline]
    fn observe(&mut self, x: i64) {
        self.before = self.last;
        self.last = x;
        self.smooth = self.smooth.wrapping_add(x.wrapping_mul(16).wrapping_sub(self.smooth) >> 3);
    }
}

fn residuals(values: &[i64], kind: u32) -> impl Iterator<Item = i64> {
    let mut predictor = Predictor::new(kind, values.first().copied().unwrap_or(0));
    values.iter().skip(1).map(move |x| {
        let residual = x.wrapping_sub(predictor.predict());
        predictor.observe(*x);
        residual
    })
}

/// Codes a column; `grid` is kept beside it.
pub(crate) fn encode(values: &[i64], grid: u32) -> Column {
    let Some(first) = values.first().copied() else { return Column::default() };
    let with_grid = |mode: u32| mode | (grid << 8);
    if values.iter().all(|x| *x == first) {
        return Column { first, mode: with_grid(1), residuals: Vec::new() };
    }
    let mut best = (u64::MAX, 0, 0);
    for kind in 0..PREDICTORS {
        let sum: u128 = residuals(values, kind).map(|x| u128::from(zigzag(x))).sum();
        let mean = sum / (values.len() as u128 - 1);
        let about = (u128::BITS - mean.leading_zeros()).min(MAX_PARAMETER);
        for parameter in about.saturating_sub(2)..=about.min(MAX_PARAMETER) {
            let bits = residuals(values, kind).map(|x| length(zigzag(x), parameter)).sum();
            if bits < best.0 {
                best = (bits, kind, parameter);
            }
        }
    }
    let (_, kind, parameter) = best;
    let mut writer = BitWriter::default();
    residuals(values, kind).for_each(|x| writer.write(x, parameter));
    Column { first, mode: with_grid(kind | (parameter << 2)), residuals: writer.finish() }
}

/// The values of a column, and its grid; none for a damaged one.
pub(crate) fn decode(column: &Column, count: usize) -> Option<(Vec<i64>, u32)> {
    let (kind, parameter, grid) = (column.mode & 3, (column.mode >> 2) & 63, column.mode >> 8);
    if parameter > MAX_PARAMETER {
        return None;
    }
    if column.residuals.is_empty() {
        return Some((vec![column.first; count], grid));
    }
    // Every residual has at least one bit.
    if count == 0 || (count - 1) / 8 > column.residuals.len() {
        return None;
    }
    let mut values = Vec::with_capacity(count);
    values.push(column.first);
    let (mut reader, mut predictor) = (BitReader::new(&column.residuals), Predictor::new(kind, column.first));
    for _ in 1..count {
        let x = predictor.predict().wrapping_add(reader.read(parameter)?);
        predictor.observe(x);
        values.push(x);
    }
    Some((values, grid))
}

#[cfg(test)]
mod tests {
    use super::*;
    use proptest::prelude::*;

    proptest! {
        #[test]
        fn every_column_is_decoded_as_it_was(
            values in prop::collection::vec(prop_oneof![any::<i64>(), -100_i64..100, Just(i64::MIN)], 0..300),
            grid in 0_u32..4,
        ) {
            let column = encode(&values, grid);
            let (decoded, _) = decode(&column, values.len()).expect("a column just coded");
            prop_assert_eq!(decoded, values);
        }

        #[test]
        fn damaged_columns_are_refused_or_decoded_without_a_panic(
            first in any::<i64>(), mode in any::<u32>(), residuals in prop::collection::vec(any::<u8>(), 0..64),
            count in 0_usize..600,
        ) {
            if let Some((values, _)) = decode(&Column { first, mode, residuals }, count) {
                prop_assert_eq!(values.len(), count);
            }
        }
    }

    #[test]
    fn noise_of_few_counts_takes_little_more_than_its_entropy() {
        // Uniform in 0..16: 4 bits.
        let mut state = 1_u64;
        let values: Vec<i64> = (0..1000)
            .map(|_| {
                state = state.wrapping_mul(6_364_136_223_846_793_005).wrapping_add(1);
                (state >> 60).cast_signed() + 10_000
            })
            .collect();
        let bits = 8.0 * encode(&values, 0).residuals.len() as f64 / 1000.0;
        assert!(bits > 4.0 && bits < 5.2, "{bits}");
        let ramp: Vec<i64> = (0..1000).map(|k| 7 * k).collect();
        assert!(encode(&ramp, 0).residuals.len() < 140, "a ramp is predicted");
    }
}
