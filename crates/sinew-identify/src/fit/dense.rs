//! Small dense systems.

/// Solves `A x = b` for a symmetric positive definite `A` given by its lower triangle, `[p x p]` row-major,
/// which is overwritten; `None` where `A` is not positive definite.
pub(crate) fn solve(a: &mut [f64], b: &[f64], p: usize) -> Option<Vec<f64>> {
    factor(a, p)?;
    let mut x = b.to_vec();
    substitute(a, &mut x, p);
    Some(x)
}

/// Cholesky factor in place: `A = L L^T`.
pub(crate) fn factor(a: &mut [f64], p: usize) -> Option<()> {
    for j in 0..p {
        for k in 0..j {
            let l = a[j * p + k];
            for i in j..p {
                a[i * p + j] -= a[i * p + k] * l;
            }
        }
        let pivot = a[j * p + j];
        if !(pivot > 0.0 && pivot.is_finite()) {
            return None;
        }
        let root = pivot.sqrt();
        for i in j..p {
            a[i * p + j] /= root;
        }
    }
    Some(())
}

/// Solves `L L^T x = b` in place.
pub(crate) fn substitute(l: &[f64], x: &mut [f64], p: usize) {
    for i in 0..p {
        let sum: f64 = (0..i).map(|k| l[i * p + k] * x[k]).sum();
        x[i] = (x[i] - sum) / l[i * p + i];
    }
    for i in (0..p).rev() {
        let sum: f64 = (i + 1..p).map(|k| l[k * p + i] * x[k]).sum();
        x[i] = (x[i] - sum) / l[i * p + i];
    }
}
