//! Functions of one coordinate.

use crate::body::curve;
use crate::description::attributes::{Attributes, shortened};
use crate::description::error::DescriptionError;
use alloc::format;
use alloc::vec;
use alloc::vec::Vec;

/// A function that a joint, a point or a constraint follows: a polynomial, or a curve of pieces, as a
/// [`Coupling`](crate::body::Coupling) has them.
#[derive(Debug, Clone, PartialEq)]
pub(super) struct Function {
    pub(super) coefficients: [f64; 5],
    pub(super) pieces: Vec<[f64; 5]>,
}

/// Names of the functions that are read, for errors.
const READ: &str = "one of Constant, LinearFunction, PolynomialFunction, PiecewiseLinearFunction, \
    SimmSpline, NaturalCubicSpline, MultiplierFunction";

impl Function {
    /// The function that an element contains.
    pub(super) fn within(at: Attributes<'_>) -> Result<Function, DescriptionError> {
        let elements = &at.tree.elements;
        let is = |name: &str| name.ends_with("Function") || name.ends_with("Spline") || name == "Constant";
        let inner = elements[at.element].children.iter().copied();
        let mut found = inner.filter(|&child| {
            is(&elements[child].name)
                || elements[child].name == "function" && !elements[child].children.is_empty()
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
                let problem =
                    format!("has {} numbers, `x` has {}: expected as many, at least 2", y.len(), x.len());
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
                Ok(Function { coefficients, pieces: Vec::new() })
            }
            "PiecewiseLinearFunction" => points().map(|points| {
                let slopes: Vec<f64> = points.windows(2).map(slope).collect();
                let last = slopes.last().copied();
                Self::through(&points, slopes.iter().copied().chain(last).map(|slope| [slope, 0.0, 0.0]))
            }),
            "SimmSpline" | "NaturalCubicSpline" => {
                points().map(|points| Self::through(&points, cubics(&points).into_iter()))
            }
            "MultiplierFunction" => {
                let (scale, mut function) = (at.number_or("scale", 1.0)?, Self::within(at)?);
                function.multiply(scale);
                Ok(function)
            }
            name => Err(at.error("", format!("<{}> is not read: expected {READ}", shortened(name)))),
        }
    }

    /// Through points, with what follows each; a line where there are two, or all have the same value.
    fn through(points: &[[f64; 2]], behind: impl Iterator<Item = [f64; 3]>) -> Function {
        let [[x, y], ..] = points else { return Self::line(0.0, 0.0) };
        if points.len() == 2 || points.iter().all(|[_, other]| other.to_bits() == y.to_bits()) {
            let slope = slope(&points[..2]);
            return Self::line(y - slope * x, slope);
        }
        let pieces = points.iter().zip(behind).map(|([x, y], [b, c, d])| [*x, *y, b, c, d]).collect();
        Function { coefficients: [0.0; 5], pieces }
    }

    pub(super) fn multiply(&mut self, factor: f64) {
        let pieces = self.pieces.iter_mut().flat_map(|piece| &mut piece[1..]);
        self.coefficients.iter_mut().chain(pieces).for_each(|c| *c *= factor);
    }

    /// `start + slope x`.
    pub(super) fn line(start: f64, slope: f64) -> Function {
        Function { coefficients: [start, slope, 0.0, 0.0, 0.0], pieces: Vec::new() }
    }

    /// Its start and slope, where it is linear.
    pub(super) fn linear(&self) -> Option<[f64; 2]> {
        let [start, slope, higher @ ..] = self.coefficients;
        (self.pieces.is_empty() && higher.iter().all(|c| *c == 0.0)).then_some([start, slope])
    }

    pub(super) fn value(&self, x: f64) -> f64 {
        curve(&self.coefficients, &self.pieces, x)[0]
    }
}

fn slope(pair: &[[f64; 2]]) -> f64 {
    (pair[1][1] - pair[0][1]) / (pair[1][0] - pair[0][0])
}

/// Coefficients `b`, `c`, `d` behind every point: SIMM's cubic spline, whose third derivatives at the ends
/// are those of the cubics through the four points there.
///
/// # Source
/// `forsythe1977`, chapter 4, as OpenSim's `SimmSpline` has it.
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
