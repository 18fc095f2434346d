//! Recordings of format 1: a block is one message whose columns are integers in Rice codes.
//!
//! | predictor | prediction of `x_i` |
//! |---|---|
//! | 0 | 0 |
//! | 1 | `x_(i-1)` |
//! | 2 | `2 x_(i-1) - x_(i-2)`; `x_0` for `x_1` |
//! | 3 | `(s_(i-1) + 8) >> 4` with `s_0 = 16 x_0`, `s_i = s_(i-1) + ((16 x_i - s_(i-1)) >> 3)` |
//!
//! `mode` is predictor + 4 k + 256 grid. A residual `r` is `u = (2 r) xor (r >> 63)`, written as `u >> k`
//! ones, a zero and the `k` low bits of `u`; 24 ones are followed by all 64 bits. Sums wrap around. An exact
//! column is two: counts, and deviations in units of the last place.

use crate::grid::Grid;
use crate::head::{Coding, ColumnSpec};
use crate::messages::Column;

/// Ones after which a number is written in full.
const ESCAPE: u32 = 24;
/// Largest parameter of a code.
const MAX_PARAMETER: u32 = 48;
/// Stands for a number that is not finite in a rounded column.
const NOT_FINITE: i64 = i64::MIN;

/// Reads bits, the first one from the highest bit of the first byte.
struct Bits<'a>(&'a [u8], usize);

impl Bits<'_> {
    fn take(&mut self, count: u32) -> Option<u64> {
        (0..count).try_fold(0, |value, _| {
            let bit = (self.0.get(self.1 / 8)? >> (7 - self.1 % 8)) & 1;
            self.1 += 1;
            Some((value << 1) | u64::from(bit))
        })
    }

    fn residual(&mut self, parameter: u32) -> Option<i64> {
        let mut ones = 0;
        while ones < ESCAPE && self.take(1)? == 1 {
            ones += 1;
        }
        let u = if ones == ESCAPE {
            self.take(64)?
        } else {
            (u64::from(ones) << parameter) | self.take(parameter)?
        };
        Some((u >> 1).cast_signed() ^ -((u & 1).cast_signed()))
    }
}

/// The integers of a column, and its grid; none for a damaged one.
fn integers(column: &Column, count: usize) -> Option<(Vec<i64>, usize)> {
    let (kind, parameter, grid) = (column.mode & 3, (column.mode >> 2) & 63, (column.mode >> 8) as usize);
    let mut values = vec![column.first; count];
    // Every residual has at least one bit.
    if parameter > MAX_PARAMETER || (!column.residuals.is_empty() && count / 8 > column.residuals.len()) {
        return None;
    }
    let (mut bits, mut smooth) = (Bits(&column.residuals, 0), column.first.wrapping_mul(16));
    for i in 1..if column.residuals.is_empty() { 0 } else { count } {
        let (last, before) = (values[i - 1], values[i.saturating_sub(2)]);
        let predicted = match kind {
            0 => 0,
            1 => last,
            2 => last.wrapping_mul(2).wrapping_sub(before),
            _ => smooth.wrapping_add(8) >> 4,
        };
        values[i] = predicted.wrapping_add(bits.residual(parameter)?);
        smooth = smooth.wrapping_add(values[i].wrapping_mul(16).wrapping_sub(smooth) >> 3);
    }
    Some((values, grid))
}

/// The columns of a block; none where they are damaged or others than those of the head.
pub(crate) fn decode(specs: &[ColumnSpec], columns: &[Column], count: usize) -> Option<Vec<Vec<f64>>> {
    let mut columns = columns.iter();
    let mut values = Vec::with_capacity(specs.len());
    for spec in specs {
        let (counts, number) = integers(columns.next()?, count)?;
        values.push(match &spec.coding {
            Coding::Rounded(resolution) => {
                let value = |k: i64| if k == NOT_FINITE { f64::NAN } else { k as f64 * resolution };
                counts.into_iter().map(value).collect()
            }
            Coding::Exact(grids) => {
                let (deviations, _) = integers(columns.next()?, count)?;
                let grid: Option<&Grid> = match number {
                    0 => None,
                    number => Some(grids.get(number - 1)?),
                };
                let bits = |k| grid.map_or(0, |grid| grid.value(k).to_bits());
                let value = |(k, deviation): (i64, i64)| {
                    f64::from_bits(bits(k).wrapping_add(deviation.cast_unsigned()))
                };
                counts.into_iter().zip(deviations).map(value).collect()
            }
        });
    }
    columns.next().is_none().then_some(values)
}
