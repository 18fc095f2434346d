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

/// How many arms are some, if all are usual numbers.
#[inline(always)]
pub(super) fn count_arms(arms: &[f64]) -> Option<usize> {
    // Neither asks for an order: the compiler takes as many at once as there is room for.
    let (mut count, mut right) = (0_u64, true);
    for arm in arms {
        count += u64::from(is_arm(*arm));
        right &= arm.abs() <= MOST;
    }
    right.then_some(count as usize)
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

#[inline(always)]
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
        self.count_arms(muscles, joints).map(|_| ())
    }

    /// [`Problem::check`], and how many moment arms are some.
    #[inline(always)]
    pub(super) fn count_arms(&self, muscles: usize, joints: usize) -> Result<usize, Error> {
        length("moment_arms", muscles * joints, self.moment_arms)?;
        length("torque", joints, self.torque)?;
        length("minimum", muscles, self.minimum)?;
        length("maximum", muscles, self.maximum)?;
        length("reference", muscles, self.reference)?;
        length("weight", muscles, self.weight)?;
        match count_arms(self.moment_arms) {
            Some(arms) if self.rest_is_right() => Ok(arms),
            _ => self.find_wrong().map(|()| 0),
        }
    }

    /// Whether all but the arms are in their domains.
    #[inline(always)]
    fn rest_is_right(&self) -> bool {
        let mut right = self.torque.iter().fold(true, |right, torque| right & (torque.abs() <= MOST));
        let limits = self.minimum.iter().zip(self.maximum);
        for (((low, high), reference), weight) in limits.zip(self.reference).zip(self.weight) {
            right &= (low <= high) & (*low >= -MOST) & (*high <= MOST) & (reference.abs() <= MOST);
            right &= (*weight >= 1.0 / MOST) & (*weight <= MOST);
        }
        right
    }

    /// An error for the first number that is wrong.
    #[cold]
    fn find_wrong(&self) -> Result<(), Error> {
        let usual = |x: f64| x.abs() <= MOST;
        let magnitude = "a finite number of magnitude <= 1e30";
        all("moment_arms", magnitude, self.moment_arms, usual)?;
        all("torque", magnitude, self.torque, usual)?;
        all("minimum", magnitude, self.minimum, usual)?;
        all("maximum", magnitude, self.maximum, usual)?;
        all("reference", magnitude, self.reference, usual)?;
        all("weight", "within 1e-30 to 1e30", self.weight, |w| (1.0 / MOST..=MOST).contains(&w))?;
        let mut crossed = self.minimum.iter().zip(self.maximum).filter(|(low, high)| low > high);
        crossed.next().map_or(Ok(()), |(low, _)| within("minimum", "<= maximum", *low, false).map(|_| ()))
    }
}
