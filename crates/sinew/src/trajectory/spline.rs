use crate::error::{Error, finite, within};
use alloc::vec;
use alloc::vec::Vec;

/// Cubic spline through points of any dimension.
///
/// ```text
/// y(x) = A y_i + B y_(i+1) + ((A^3 - A) m_i + (B^3 - B) m_(i+1)) h^2/6,   A = (x_(i+1) - x)/h,  B = 1 - A
/// h_(i-1)/6 m_(i-1) + (h_(i-1) + h_i)/3 m_i + h_i/6 m_(i+1) = (y_(i+1) - y_i)/h_i - (y_i - y_(i-1))/h_(i-1)
/// ```
///
/// | symbol | unit     | meaning                                         |
/// |--------|----------|-------------------------------------------------|
/// | x_i    | s or rad | knots, increasing                                |
/// | y_i    | any      | values at the knots                              |
/// | m_i    |          | second derivatives at the knots, continuous      |
///
/// # Source
/// Textbook.
#[derive(Debug, Clone, PartialEq)]
pub struct Spline {
    knots: Vec<f64>,
    /// `[knots x width]`.
    values: Vec<f64>,
    curvatures: Vec<f64>,
    width: usize,
    closed: bool,
}

impl Spline {
    /// Natural spline: the second derivatives at both ends are zero.
    ///
    /// # Shapes
    /// `knots: [n >= 2]`, from 0; `values: [n x width]`, point after point.
    ///
    /// # Errors
    /// [`Error::WrongLength`], and [`Error::OutOfDomain`] for values that are not finite or knots that do not
    /// increase.
    pub fn natural(knots: &[f64], values: &[f64]) -> Result<Self, Error> {
        Self::new(knots, values, false)
    }

    /// Periodic spline: the first point is repeated at `period`, one knot beyond those given.
    ///
    /// # Shapes
    /// `knots: [n >= 4]`, from 0 and below `period`; `values: [n x width]`.
    ///
    /// # Errors
    /// As [`natural`](Self::natural).
    pub fn periodic(knots: &[f64], values: &[f64], period: f64) -> Result<Self, Error> {
        if knots.len() < 4 {
            return Err(Error::WrongLength { name: "knots", expected: 4, got: knots.len() });
        }
        let width = values.len() / knots.len();
        let knots: Vec<f64> = knots.iter().copied().chain([period]).collect();
        let values: Vec<f64> = values.iter().chain(values.iter().take(width)).copied().collect();
        Self::new(&knots, &values, true)
    }

    fn new(knots: &[f64], values: &[f64], closed: bool) -> Result<Self, Error> {
        let n = knots.len();
        if n < 2 {
            return Err(Error::WrongLength { name: "knots", expected: 2, got: n });
        }
        let width = values.len() / n;
        if width == 0 || values.len() != n * width {
            return Err(Error::WrongLength { name: "values", expected: n * width.max(1), got: values.len() });
        }
        values.iter().try_for_each(|&value| finite("values of a spline", value).map(drop))?;
        within("first knot", "0", knots[0], knots[0].abs() < 1e-12)?;
        for pair in knots.windows(2) {
            let rises = pair[1].is_finite() && pair[1] - pair[0] > 1e-9;
            within("knots", "rising by more than 1e-9", pair[1], rises)?;
        }
        let mut spline = Self {
            knots: knots.to_vec(),
            values: values.to_vec(),
            curvatures: vec![0.0; values.len()],
            width,
            closed,
        };
        for column in 0..width {
            spline.solve_curvatures(column);
        }
        spline.curvatures.iter().try_for_each(|&m| finite("curvature of a spline", m).map(drop))?;
        Ok(spline)
    }

    /// Dimension of a point.
    #[must_use]
    pub fn width(&self) -> usize {
        self.width
    }

    /// Whether it is periodic.
    pub(super) fn is_closed(&self) -> bool {
        self.closed
    }

    /// The last knot.
    #[must_use]
    pub fn end(&self) -> f64 {
        self.knots.last().copied().unwrap_or(0.0)
    }

    /// Value, first and second derivative at `x`: periodic, or held constant beyond both ends.
    ///
    /// # Shapes
    /// `value`, `slope`, `curvature: [width]`; entries beyond are left alone.
    pub fn at(&self, x: f64, value: &mut [f64], slope: &mut [f64], curvature: &mut [f64]) {
        let end = self.end();
        let x = if !x.is_finite() {
            0.0
        } else if self.closed {
            x - end * libm::floor(x / end)
        } else {
            x.max(0.0).min(end)
        };
        let last = self.knots.len() - 2;
        let i = self.knots.partition_point(|&knot| knot <= x).saturating_sub(1).min(last);
        let h = self.knots[i + 1] - self.knots[i];
        let (a, b) = ((self.knots[i + 1] - x) / h, (x - self.knots[i]) / h);
        let row = |of: &'_ [f64], k: usize| [of[i * self.width + k], of[(i + 1) * self.width + k]];
        let outputs = value.iter_mut().zip(slope.iter_mut()).zip(curvature.iter_mut());
        for (k, ((value, slope), curvature)) in outputs.enumerate().take(self.width) {
            let ([y, z], [m, n]) = (row(&self.values, k), row(&self.curvatures, k));
            *value = a * y + b * z + ((a * a * a - a) * m + (b * b * b - b) * n) * h * h / 6.0;
            *slope = (z - y) / h + ((1.0 - 3.0 * a * a) * m + (3.0 * b * b - 1.0) * n) * h / 6.0;
            *curvature = a * m + b * n;
        }
    }

    /// Finds the second derivatives of one column.
    fn solve_curvatures(&mut self, column: usize) {
        let (n, width) = (self.knots.len(), self.width);
        let h = |i: usize| self.knots[i + 1] - self.knots[i];
        let rise =
            |i: usize| (self.values[(i + 1) * width + column] - self.values[i * width + column]) / h(i);
        let m = if self.closed {
            let n = n - 1;
            let before = |i: usize| (i + n - 1) % n;
            let diagonal: Vec<f64> = (0..n).map(|i| (h(before(i)) + h(i)) / 3.0).collect();
            let beside: Vec<f64> = (0..n).map(|i| h(i) / 6.0).collect();
            let desired = (0..n).map(|i| rise(i) - rise(before(i))).collect();
            let mut m = cyclic(diagonal, &beside, desired);
            m.push(m[0]);
            m
        } else {
            // Nothing bends at the ends: the unknowns are those between.
            let diagonal: Vec<f64> = (1..n - 1).map(|i| (h(i - 1) + h(i)) / 3.0).collect();
            let beside: Vec<f64> = (1..n - 1).map(|i| h(i) / 6.0).collect();
            let desired = (1..n - 1).map(|i| rise(i) - rise(i - 1)).collect();
            let within = tridiagonal(&diagonal, &beside, desired);
            [0.0].into_iter().chain(within).chain([0.0]).collect()
        };
        for (i, m) in m.into_iter().enumerate() {
            self.curvatures[i * width + column] = m;
        }
    }
}

/// Thomas algorithm for a symmetric, diagonally dominant tridiagonal system; `beside[i]` stands between `i`
/// and `i + 1`.
fn tridiagonal(diagonal: &[f64], beside: &[f64], mut x: Vec<f64>) -> Vec<f64> {
    let mut pivots = diagonal.to_vec();
    for i in 1..x.len() {
        let fraction = beside[i - 1] / pivots[i - 1];
        pivots[i] -= fraction * beside[i - 1];
        x[i] -= fraction * x[i - 1];
    }
    for i in (0..x.len()).rev() {
        let next = if i + 1 < x.len() { beside[i] * x[i + 1] } else { 0.0 };
        x[i] = (x[i] - next) / pivots[i];
    }
    x
}

/// The same with `beside[n - 1]` between last and first: a rank-one change, by the Sherman-Morrison formula.
fn cyclic(mut diagonal: Vec<f64>, beside: &[f64], desired: Vec<f64>) -> Vec<f64> {
    let n = diagonal.len();
    let corner = beside[n - 1];
    let gamma = -diagonal[0];
    diagonal[0] -= gamma;
    diagonal[n - 1] -= corner * corner / gamma;
    let mut unit = vec![0.0; n];
    (unit[0], unit[n - 1]) = (gamma, corner);
    let mut x = tridiagonal(&diagonal, beside, desired);
    let z = tridiagonal(&diagonal, beside, unit);
    let along = |y: &[f64]| y[0] + corner * y[n - 1] / gamma;
    let factor = along(&x) / (1.0 + along(&z));
    x.iter_mut().zip(&z).for_each(|(x, z)| *x -= factor * z);
    x
}

#[cfg(test)]
mod tests {
    use super::*;

    fn sine(count: u32) -> Spline {
        let period = 2.0 * core::f64::consts::PI;
        let knots: Vec<f64> = (0..count).map(|k| period * f64::from(k) / f64::from(count)).collect();
        let values: Vec<f64> = knots.iter().flat_map(|x| [libm::sin(*x), libm::cos(2.0 * x)]).collect();
        Spline::periodic(&knots, &values, period).unwrap()
    }

    fn error(count: u32) -> f64 {
        let spline = sine(count);
        let (mut p, mut v, mut a) = ([0.0; 2], [0.0; 2], [0.0; 2]);
        (0..1000).fold(0.0, |worst: f64, k| {
            let x = 0.013 * f64::from(k) - 3.0;
            spline.at(x, &mut p, &mut v, &mut a);
            worst.max((p[0] - libm::sin(x)).abs()).max((p[1] - libm::cos(2.0 * x)).abs())
        })
    }

    #[test]
    fn a_periodic_spline_converges_with_the_fourth_order() {
        let order = libm::log2(error(40) / error(80));
        assert!((3.7..4.3).contains(&order), "{order}");
    }

    #[test]
    fn derivatives_are_those_of_the_value_and_continuous_where_the_spline_closes() {
        let spline = sine(24);
        let at = |x| {
            let mut out = [[0.0; 2]; 3];
            let [p, v, a] = &mut out;
            spline.at(x, p, v, a);
            out
        };
        let h = 1e-5;
        for k in 0..200 {
            let x = 0.0314 * f64::from(k);
            let [before, now, after] = [at(x - h), at(x), at(x + h)];
            for i in 0..2 {
                assert!(((after[0][i] - before[0][i]) / (2.0 * h) - now[1][i]).abs() < 1e-8);
                assert!(((after[1][i] - before[1][i]) / (2.0 * h) - now[2][i]).abs() < 1e-4);
            }
        }
    }

    #[test]
    fn a_natural_spline_interpolates_and_has_no_curvature_at_its_ends() {
        let spline = Spline::natural(&[0.0, 0.5, 2.0, 2.2], &[1.0, 3.0, -1.0, 0.0]).unwrap();
        let at = |x| {
            let (mut p, mut v, mut a) = ([0.0], [0.0], [0.0]);
            spline.at(x, &mut p, &mut v, &mut a);
            (p[0], a[0])
        };
        for (x, y) in [(0.0, 1.0), (0.5, 3.0), (2.0, -1.0), (2.2, 0.0), (7.0, 0.0), (-7.0, 1.0)] {
            assert!((at(x).0 - y).abs() < 1e-12, "{x}");
        }
        assert!(at(0.0).1.abs() < 1e-12 && at(2.2).1.abs() < 1e-12);
    }
}
