//! Triangular factors of a positive semidefinite matrix, with a floor under its pivots.

use super::rows::dot;
use super::scalar::Scalar;

/// Factors `h = U^T D^-1 U` in place: rows of `U` right of the diagonal, `1 / D` on it.
///
/// `h` is `n x n`, row-major; only its upper triangle is read. Where a pivot is below its `floor`, the row is
/// replaced by the floor alone: the factors are those of a positive definite matrix that differs from `h`
/// only where `h` is singular. [`solve`] then gives Newton's step where there is one and a long step along
/// the null space where there is none.
#[inline(always)]
pub(super) fn factor<S: Scalar>(h: &mut [S], floor: &[f64]) {
    let n = floor.len();
    for k in 0..n {
        let (above, below) = h.split_at_mut((k + 1) * n);
        let row = &mut above[k * n + k..];
        if row[0].rounded() < floor[k] {
            // Entries beside a pivot of rounding are rounding, too.
            row.fill(S::ZERO);
            row[0] = S::from(1.0 / floor[k]);
            continue;
        }
        let inverse = S::from(1.0) / row[0];
        row[0] = inverse;
        for (i, lower) in (k + 1..n).zip(below.chunks_exact_mut(n)) {
            let entry = row[i - k];
            // Sparse arms leave most of the triangle empty.
            if entry.rounded() != 0.0 {
                let f = entry * inverse;
                for (to, from) in lower[i..].iter_mut().zip(&row[i - k..]) {
                    *to = *to - f * *from;
                }
            }
        }
    }
}

/// `x := h^-1 x` with the factors that [`factor`] left in `h`.
#[inline(always)]
pub(super) fn solve<S: Scalar>(h: &[S], x: &mut [S]) {
    let n = x.len();
    for (k, row) in h.chunks_exact(n).enumerate() {
        let f = x[k] * row[k];
        for (to, from) in x[k + 1..].iter_mut().zip(&row[k + 1..]) {
            *to = *to - f * *from;
        }
    }
    for (k, row) in h.chunks_exact(n).enumerate().rev() {
        x[k] = (x[k] - dot(&x[k + 1..], &row[k + 1..])) * row[k];
    }
}

#[cfg(test)]
mod tests {
    use super::{factor, solve};

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
}
