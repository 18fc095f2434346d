//! Functions of one coordinate.

use crate::description::attributes::{Attributes, shortened};
use crate::description::error::DescriptionError;
use alloc::boxed::Box;
use alloc::format;
use alloc::vec;
use alloc::vec::Vec;
use core::f64::consts::PI;
use libm::cos;

/// A function that a joint, a point or a constraint follows.
#[derive(Debug, Clone, PartialEq)]
pub(super) enum Function {
    /// `c0 + c1 x + .. + c4 x^4`.
    Polynomial([f64; 5]),
    /// Through points: straight between them.
    Linear(Vec<[f64; 2]>),
    /// Through points, each with the coefficients `b`, `c`, `d` of the cubic behind it.
    Spline(Vec<[f64; 2]>, Vec<[f64; 3]>),
    /// Another, times a number.
    Multiple(f64, Box<Function>),
}

/// Names of the functions that are read, for errors.
const READ: &str = "one of Constant, LinearFunction, PolynomialFunction, PiecewiseLinearFunction, SimmSpline, \
    NaturalCubicSpline, MultiplierFunction";
/// Intervals of a range in which the error of a polynomial is looked for.
const TRIED: usize = 400;
/// Points of the range that a polynomial is fitted to.
const FITTED: usize = 64;

impl Function {
    /// The function that an element contains.
    pub(super) fn within(at: Attributes<'_>) -> Result<Function, DescriptionError> {
        let elements = &at.tree.elements;
        let is = |name: &str| name.ends_with("Function") || name.ends_with("Spline") || name == "Constant";
        let inner = elements[at.element].children.iter().copied();
        let mut found = inner.filter(|&child| {
            is(&elements[child].name) || elements[child].name == "function" && !elements[child].children.is_empty()
        });
        let Some(child) = found.next() else {
            return Err(at.error("", format!("has no function that is read: expected {READ}")));
        };
        let child = Attributes::own(at.tree, child);
        if elements[child.element].name == "function" { Self::within(child) } else { Self::read(child) }
    }

    fn read(at: Attributes<'_>) -> Result<Function, DescriptionError> {
        let points = || -> Result<Vec<[f64; 2]>, DescriptionError> {
            let list = |name| Ok::<_, DescriptionError>(at.list(name, 2, 10_000)?.unwrap_or_default());
            let (x, y) = (list("x")?, list("y")?);
            if x.len() != y.len() || x.len() < 2 {
                let problem = format!("has {} numbers, `x` has {}: expected as many, at least 2", y.len(), x.len());
                return Err(at.error("y", problem));
            }
            if let Some(pair) = x.windows(2).find(|pair| pair[0] >= pair[1]) {
                let problem = format!("goes from {} to {}: expected rising numbers", pair[0], pair[1]);
                return Err(at.error("x", problem));
            }
            Ok(x.into_iter().zip(y).map(|(x, y)| [x, y]).collect())
        };
        match at.tree.elements[at.element].name.as_str() {
            "Constant" => Ok(Function::line(at.number_or("value", 0.0)?, 0.0)),
            "LinearFunction" => {
                let [slope, start] = at.array_or("coefficients", [1.0, 0.0])?;
                Ok(Function::line(start, slope))
            }
            "PolynomialFunction" => {
                let mut coefficients = [0.0; 5];
                let given = at.list("coefficients", 1, 5)?.unwrap_or_default();
                coefficients.iter_mut().zip(given.iter().rev()).for_each(|(c, given)| *c = *given);
                Ok(Function::Polynomial(coefficients))
            }
            "PiecewiseLinearFunction" => points().map(Function::Linear),
            "SimmSpline" | "NaturalCubicSpline" => points().map(|points| {
                let cubics = cubics(&points);
                Function::Spline(points, cubics)
            }),
            "MultiplierFunction" => {
                Ok(Function::Multiple(at.number_or("scale", 1.0)?, Box::new(Self::within(at)?)))
            }
            name => Err(at.error("", format!("<{}> is not read: expected {READ}", shortened(name)))),
        }
    }

    /// `start + slope x`.
    pub(super) fn line(start: f64, slope: f64) -> Function {
        Function::Polynomial([start, slope, 0.0, 0.0, 0.0])
    }

    /// Its start and slope, where it is linear.
    pub(super) fn linear(&self) -> Option<[f64; 2]> {
        let [start, slope, higher @ ..] = self.polynomial()?;
        higher.iter().all(|c| *c == 0.0).then_some([start, slope])
    }

    pub(super) fn value(&self, x: f64) -> f64 {
        match self {
            Function::Polynomial([c0, c1, c2, c3, c4]) => c0 + x * (c1 + x * (c2 + x * (c3 + x * c4))),
            Function::Linear(points) => {
                let [[x0, y0], [x1, y1]] = [points[piece(points, x)], points[piece(points, x) + 1]];
                y0 + (x - x0) * (y1 - y0) / (x1 - x0)
            }
            Function::Spline(points, cubics) => {
                let last = points.len() - 1;
                let at = if x > points[last][0] { last } else { piece(points, x) };
                let ([start, y], [b, c, d]) = (points[at], cubics[at]);
                let dx = x - start;
                // Beyond its ends it is straight.
                if dx < 0.0 || at == last { y + dx * b } else { y + dx * (b + dx * (c + dx * d)) }
            }
            Function::Multiple(factor, inner) => factor * inner.value(x),
        }
    }

    /// Its coefficients, where it is a polynomial.
    pub(super) fn polynomial(&self) -> Option<[f64; 5]> {
        match self {
            Function::Polynomial(coefficients) => Some(*coefficients),
            Function::Multiple(factor, inner) => inner.polynomial().map(|c| c.map(|c| factor * c)),
            // A spline through equal values.
            Function::Linear(points) | Function::Spline(points, _) => {
                let first = points[0][1];
                points.iter().all(|[_, y]| y.to_bits() == first.to_bits()).then_some([first, 0.0, 0.0, 0.0, 0.0])
            }
        }
    }

    /// The polynomial of degree four that is nearest over a range, and its largest error there.
    ///
    /// ```text
    /// f(m + h t) ~ sum_k a_k T_k(t),   a_k = (2 - [k = 0])/N sum_j f(m + h t_j) cos(k w_j),   t_j = cos w_j,   w_j = (j + 1/2) pi/N
    /// ```
    pub(super) fn fitted(&self, [low, high]: [f64; 2]) -> ([f64; 5], f64) {
        if let Some(exact) = self.polynomial() {
            return (exact, 0.0);
        }
        let (middle, half) = ((low + high) / 2.0, ((high - low) / 2.0).max(1e-9));
        let angle = |j: usize| (j as f64 + 0.5) * PI / FITTED as f64;
        let a: [f64; 5] = core::array::from_fn(|k| {
            let terms = (0..FITTED).map(|j| self.value(middle + half * cos(angle(j))) * cos(k as f64 * angle(j)));
            terms.sum::<f64>() * if k == 0 { 1.0 } else { 2.0 } / FITTED as f64
        });
        // In powers of t, then of x = m + h t, by Horner's rule.
        let t = [a[0] - a[2] + a[4], a[1] - 3.0 * a[3], 2.0 * a[2] - 8.0 * a[4], 4.0 * a[3], 8.0 * a[4]];
        let mut powers = [0.0; 5];
        for c in t.into_iter().rev() {
            let shifted: [f64; 5] = core::array::from_fn(|k| {
                ((if k > 0 { powers[k - 1] } else { 0.0 }) - middle * powers[k]) / half
            });
            powers = shifted;
            powers[0] += c;
        }
        let fit = Function::Polynomial(powers);
        let error = (0..=TRIED).map(|k| {
            let x = low + (high - low) * k as f64 / TRIED as f64;
            (fit.value(x) - self.value(x)).abs()
        });
        (powers, error.fold(0.0, f64::max))
    }
}

/// The piece between two points that a place is in, or the nearest.
fn piece(points: &[[f64; 2]], x: f64) -> usize {
    points.partition_point(|[at, _]| *at <= x).clamp(1, points.len() - 1) - 1
}

/// Coefficients `b`, `c`, `d` behind every point: SIMM's cubic spline, whose third derivatives at the ends are
/// those of the cubics through the four points there.
///
/// # Source
/// `forsythe1977`, chapter 4.
fn cubics(points: &[[f64; 2]]) -> Vec<[f64; 3]> {
    let n = points.len();
    let slope = |k: usize| (points[k + 1][1] - points[k][1]) / (points[k + 1][0] - points[k][0]);
    if n == 2 {
        return vec![[slope(0), 0.0, 0.0]; 2];
    }
    let step = |k: usize| points[k + 1][0] - points[k][0];
    let apart = |i: usize, j: usize| points[j][0] - points[i][0];
    // A tridiagonal system for a sixth of the second derivatives.
    let mut diagonal: Vec<f64> = (0..n)
        .map(|k| match k {
            0 => -step(0),
            k if k == n - 1 => -step(n - 2),
            k => 2.0 * (step(k - 1) + step(k)),
        })
        .collect();
    let mut s: Vec<f64> =
        (0..n).map(|k| if k == 0 || k == n - 1 { 0.0 } else { slope(k) - slope(k - 1) }).collect();
    if n > 3 {
        let (first, last) = (
            s[2] / apart(1, 3) - s[1] / apart(0, 2),
            s[n - 2] / apart(n - 3, n - 1) - s[n - 3] / apart(n - 4, n - 2),
        );
        s[0] = first * step(0) * step(0) / apart(0, 3);
        s[n - 1] = -last * step(n - 2) * step(n - 2) / apart(n - 4, n - 1);
    }
    for k in 1..n {
        let factor = step(k - 1) / diagonal[k - 1];
        diagonal[k] -= factor * step(k - 1);
        s[k] -= factor * s[k - 1];
    }
    s[n - 1] /= diagonal[n - 1];
    for k in (0..n - 1).rev() {
        s[k] = (s[k] - step(k) * s[k + 1]) / diagonal[k];
    }
    let mut cubics: Vec<[f64; 3]> = (0..n - 1)
        .map(|k| [slope(k) - step(k) * (s[k + 1] + 2.0 * s[k]), 3.0 * s[k], (s[k + 1] - s[k]) / step(k)])
        .collect();
    cubics.push([slope(n - 2) + step(n - 2) * (s[n - 2] + 2.0 * s[n - 1]), 0.0, 0.0]);
    cubics
}
