//! The question: which tensions give a torque.

use crate::Error;
use crate::error::within;

/// One distribution of a torque over muscles.
///
/// ```text
/// min  sum_i w_i (F_i - F_ref,i)^2     s.t.   R^T F = tau,   F_min <= F <= F_max
/// ```
///
/// | symbol | field         | unit    | domain                   | meaning                                   |
/// |--------|---------------|---------|--------------------------|-------------------------------------------|
/// | R      | `moment_arms` | m       | magnitude <= 1e30        | `-dl/dq`, muscles x joints, row by row    |
/// | tau    | `torque`      | N m     | magnitude <= 1e30        | wanted at each joint                      |
/// | F_min  | `minimum`     | N       | <= `maximum`             | least tension of each muscle              |
/// | F_max  | `maximum`     | N       | magnitude <= 1e30        | greatest tension of each muscle           |
/// | F_ref  | `reference`   | N       | magnitude <= 1e30        | tension wanted where the torque leaves a choice |
/// | w      | `weight`      | 1/N^2   | 1e-30 to 1e30            | what leaving the reference costs          |
///
/// An arm below 1e-60 m counts as none. Any length will do in place of m and any force in place of N.
#[derive(Debug, Clone, Copy, PartialEq)]
pub struct Problem<'a> {
    /// `R`, `[muscles x joints]`, row by row.
    pub moment_arms: &'a [f64],
    /// `tau`, `[joints]`.
    pub torque: &'a [f64],
    /// `F_min`, `[muscles]`.
    pub minimum: &'a [f64],
    /// `F_max`, `[muscles]`.
    pub maximum: &'a [f64],
    /// `F_ref`, `[muscles]`.
    pub reference: &'a [f64],
    /// `w`, `[muscles]`.
    pub weight: &'a [f64],
}

/// Largest number whose products with others of its kind stay finite.
const MOST: f64 = 1e30;

/// Whether a moment arm is one.
#[inline(always)]
pub(super) fn is_arm(arm: f64) -> bool {
    const LEAST_ARM: f64 = 1e-60;
    arm.abs() >= LEAST_ARM
}

/// How many numbers `hold` something, several at a time.
#[inline(always)]
pub(super) fn count(values: &[f64], holds: impl Fn(f64) -> bool) -> usize {
    const LANES: usize = 4;
    let mut counts = [0_u64; LANES];
    let mut chunks = values.chunks_exact(LANES);
    for chunk in &mut chunks {
        for (count, value) in counts.iter_mut().zip(chunk) {
            *count += u64::from(holds(*value));
        }
    }
    let rest = chunks.remainder().iter().filter(|value| holds(**value)).count();
    counts.iter().map(|count| *count as usize).sum::<usize>() + rest
}

/// An error that names the first number that does not hold what is `expected` of it.
fn all(
    name: &'static str,
    expected: &'static str,
    values: &[f64],
    holds: impl Fn(f64) -> bool,
) -> Result<(), Error> {
    match values.iter().copied().find(|value| !holds(*value)) {
        Some(bad) => within(name, expected, bad, false).map(|_| ()),
        None => Ok(()),
    }
}

/// [`all`] of the usual magnitude. A sum that is small has no term that is large or no number: one comparison for all.
#[inline(always)]
fn usual(name: &'static str, values: &[f64]) -> Result<(), Error> {
    const LANES: usize = 8;
    let (chunks, rest) = values.as_chunks::<LANES>();
    let mut sum = [0.0; LANES];
    for chunk in chunks {
        for (sum, value) in sum.iter_mut().zip(chunk) {
            *sum += value.abs();
        }
    }
    let rest: f64 = rest.iter().map(|value| value.abs()).sum();
    if sum.iter().sum::<f64>() + rest <= MOST {
        return Ok(());
    }
    all(name, "a finite number of magnitude <= 1e30", values, |x| x.abs() <= MOST)
}

fn length(name: &'static str, expected: usize, values: &[f64]) -> Result<(), Error> {
    let got = values.len();
    if got == expected { Ok(()) } else { Err(Error::WrongLength { name, expected, got }) }
}

impl Problem<'_> {
    /// Whether lengths fit `muscles` and `joints` and every number is in its domain.
    ///
    /// # Errors
    /// [`Error::WrongLength`] and [`Error::OutOfDomain`] name the field; the latter holds the first value that is wrong.
    pub fn check(&self, muscles: usize, joints: usize) -> Result<(), Error> {
        length("moment_arms", muscles * joints, self.moment_arms)?;
        length("torque", joints, self.torque)?;
        length("minimum", muscles, self.minimum)?;
        length("maximum", muscles, self.maximum)?;
        length("reference", muscles, self.reference)?;
        length("weight", muscles, self.weight)?;
        usual("moment_arms", self.moment_arms)?;
        usual("torque", self.torque)?;
        usual("minimum", self.minimum)?;
        usual("maximum", self.maximum)?;
        usual("reference", self.reference)?;
        all("weight", "within 1e-30 to 1e30", self.weight, |w| (1.0 / MOST..=MOST).contains(&w))?;
        let crossed =
            self.minimum.iter().zip(self.maximum).fold(false, |any, (low, high)| any | (low > high));
        if !crossed {
            return Ok(());
        }
        let pairs = self.minimum.iter().zip(self.maximum);
        let low = pairs.filter(|(low, high)| low > high).map(|(low, _)| *low).next().unwrap_or(f64::NAN);
        within("minimum", "<= maximum", low, false).map(|_| ())
    }
}
