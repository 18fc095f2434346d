//! Triangular factors of a positive semidefinite matrix, with a floor under its pivots.

use super::rows::LANES;
use core::ops::Range;

/// Factors `h = U^T D^-1 U` in place: rows of `U` right of the diagonal, `1 / D` on it.
///
/// `h` is `n x n`, row-major; only its upper triangle is read. A pivot below its `floor` becomes the floor, so that the
/// factors are those of a positive definite matrix which differs from `h` only where `h` is singular: [`solve`] then
/// gives Newton's step where there is one and a long way along the null space where there is none.
#[inline(always)]
pub(super) fn factor(h: &mut [f64], floor: &[f64]) {
    let n = floor.len();
    let h = &mut h[..n * n];
    for k in 0..n {
        let (above, below) = h.split_at_mut((k + 1) * n);
        let row = &mut above[k * n + k..];
        if row[0] < floor[k] {
            // What stands beside a pivot that is rounding is rounding, too.
            row.fill(0.0);
            row[0] = 1.0 / floor[k];
            continue;
        }
        let inverse = 1.0 / row[0];
        row[0] = inverse;
        for (i, lower) in (k + 1..n).zip(below.chunks_exact_mut(n)) {
            let entry = row[i - k];
            // Sparse arms leave most of the triangle empty.
            if entry != 0.0 {
                let f = entry * inverse;
                for (to, from) in lower[i..].iter_mut().zip(&row[i - k..]) {
                    *to -= f * from;
                }
            }
        }
    }
}

/// `x := h^-1 x` with the factors that [`factor`] left in `h`.
#[inline(always)]
pub(super) fn solve(h: &[f64], x: &mut [f64]) {
    let n = x.len();
    let h = &h[..n * n];
    for (k, row) in h.chunks_exact(n).enumerate().take(n) {
        let f = x[k] * row[k];
        for (to, from) in x[k + 1..].iter_mut().zip(&row[k + 1..]) {
            *to -= f * from;
        }
    }
    for (k, row) in h.chunks_exact(n).enumerate().take(n).rev() {
        let sum: f64 = x[k + 1..].iter().zip(&row[k + 1..]).map(|(x, u)| x * u).sum();
        x[k] = (x[k] - sum) * row[k];
    }
}

/// The same for a known number of joints: `h = L D L^T` in registers, in whole rows where there are lanes for them. What
/// such a row holds on the wrong side of the diagonal is never read.
#[derive(Debug, Clone, Copy)]
pub(super) struct Factors<const N: usize> {
    /// `L` and its transpose, without their diagonals, and `1 / D`.
    lower: [[f64; N]; N],
    upper: [[f64; N]; N],
    inverse: [f64; N],
}

/// Places left of the diagonal, and right of it, or whole rows.
#[inline(always)]
fn sides<const N: usize>(k: usize) -> (Range<usize>, Range<usize>) {
    if N < LANES { (0..k, k + 1..N) } else { (0..N, 0..N) }
}

impl<const N: usize> Factors<N> {
    #[inline(always)]
    pub(super) fn new(mut h: [[f64; N]; N], floor: &[f64; N]) -> Self {
        let (mut lower, mut upper, mut inverse) = ([[0.0; N]; N], [[0.0; N]; N], [0.0; N]);
        for k in 0..N {
            // What stands beside a pivot that is rounding is rounding, too.
            if h[k][k] < floor[k] {
                inverse[k] = 1.0 / floor[k];
                continue;
            }
            inverse[k] = 1.0 / h[k][k];
            let (row, (_, right)) = (h[k], sides::<N>(k));
            for j in right.clone() {
                upper[k][j] = row[j] * inverse[k];
            }
            // As many turns for every `k`: the compiler unrolls them.
            for i in 0..N {
                if i > k {
                    lower[i][k] = upper[k][i];
                    for j in right.clone() {
                        // The product need not wait for the division.
                        h[i][j] -= (row[i] * row[j]) * inverse[k];
                    }
                }
            }
        }
        Self { lower, upper, inverse }
    }

    /// `h^-1 x`.
    #[inline(always)]
    pub(super) fn solve(&self, mut x: [f64; N]) -> [f64; N] {
        let mut kept = [0.0; N];
        for k in 0..N {
            kept[k] = x[k];
            for j in sides::<N>(k).1 {
                x[j] -= kept[k] * self.upper[k][j];
            }
        }
        for k in 0..N {
            x[k] = kept[k] * self.inverse[k];
        }
        for k in (0..N).rev() {
            kept[k] = x[k];
            for j in sides::<N>(k).0 {
                x[j] -= kept[k] * self.lower[k][j];
            }
        }
        kept
    }
}

#[cfg(test)]
mod tests {
    use super::{Factors, factor, solve};

    #[test]
    fn a_positive_definite_system_is_solved() {
        let h = [4.0, 1.0, -1.0, 1.0, 3.0, 0.5, -1.0, 0.5, 2.0];
        let exact = [1.0, -2.0, 0.5];
        let mut x = [0.0; 3];
        for (x, row) in x.iter_mut().zip(h.chunks_exact(3)) {
            *x = row.iter().zip(&exact).map(|(h, e)| h * e).sum();
        }
        let mut factors = h;
        factor(&mut factors, &[1e-13; 3]);
        solve(&factors, &mut x);
        for (x, exact) in x.iter().zip(&exact) {
            assert!((x - exact).abs() < 1e-14, "{x} {exact}");
        }
    }

    #[test]
    fn a_singular_system_is_solved_along_its_null_space() {
        let mut h = [1.0, 1.0, 1.0, 1.0];
        factor(&mut h, &[1e-13; 2]);
        let mut x = [1.0, -1.0];
        solve(&h, &mut x);
        assert!((x[0] + x[1]).abs() < 1e-3 * x[0].abs() && x[0] > 1e12, "{x:?}");
    }

    #[test]
    fn whole_rows_give_what_rows_give() {
        // The third joint only repeats the first.
        let h = [[4.0, 1.0, 4.0, 0.5], [1.0, 3.0, 1.0, -1.0], [4.0, 1.0, 4.0, 0.5], [0.5, -1.0, 0.5, 2.0]];
        let (floor, x) = ([1e-12; 4], [1.0, -2.0, 1.0, 0.5]);
        let (mut factors, mut exact) = (h, x);
        factor(factors.as_flattened_mut(), &floor);
        solve(factors.as_flattened(), &mut exact);
        for (x, exact) in Factors::new(h, &floor).solve(x).iter().zip(&exact) {
            assert!((x - exact).abs() < 1e-14, "{x} {exact}");
        }
    }
}
