//! The distribution problem, its domains and its errors.

use super::scalar::Scalar;
use crate::Error;

/// One distribution of a torque over muscles.
///
/// ```text
/// min_F  1/2 sum_i w_i (F_i - F_ref,i)^2     s.t.   R^T F = tau,   F_min <= F <= F_max
/// ```
///
/// | symbol | field         | unit | domain            | meaning                                           |
/// |--------|---------------|------|-------------------|---------------------------------------------------|
/// | R      | `moment_arms` | m    | magnitude <= 1e30 | `-dl/dq`, muscles x joints, row by row            |
/// | tau    | `torque`      | N m  | magnitude <= 1e30 | desired torque of each joint                      |
/// | F_min  | `minimum`     | N    | <= `maximum`      | smallest tension of each muscle                   |
/// | F_max  | `maximum`     | N    | magnitude <= 1e30 | largest tension of each muscle                    |
/// | F_ref  | `reference`   | N    | magnitude <= 1e30 | tension preferred where the torque leaves a choice |
/// | w      | `weight`      | 1    | 1e-30 to 1e30     | relative cost of leaving the reference            |
///
/// Only ratios of weights matter. Arms below 1e-60 m count as zero. Units other than m and N may be used
/// consistently.
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

/// The limit that determines a muscle's tension.
#[derive(Debug, Clone, Copy, PartialEq, Eq)]
pub enum Limit {
    /// The smallest tension.
    Lower,
    /// None: the tension is between its limits.
    Free,
    /// The largest tension.
    Upper,
}

impl Limit {
    /// The limit that holds where the tension without limits is `unclipped`.
    pub(super) fn new<S: Scalar>(unclipped: S, lower: f64, upper: f64) -> Self {
        // Without a branch, which would be hard to predict.
        let above = u8::from(unclipped > S::from(lower));
        match above + (above & u8::from(unclipped >= S::from(upper))) {
            0 => Self::Lower,
            1 => Self::Free,
            _ => Self::Upper,
        }
    }
}

/// Largest magnitude of an input: products of their kinds stay finite.
const LARGEST: f64 = 1e30;

/// Whether a moment arm counts as different from zero.
pub(super) fn is_nonzero(arm: f64) -> bool {
    arm.abs() >= 1e-60
}

impl Problem<'_> {
    /// Whether lengths fit `muscles` and `joints` and every number is in its domain.
    ///
    /// # Errors
    /// [`Error::WrongLength`] names the field, [`Error::EntryOutOfDomain`] also the index of the first entry
    /// that is wrong.
    pub fn check(&self, muscles: usize, joints: usize) -> Result<(), Error> {
        self.count_arms(muscles, joints).map(|_| ())
    }

    /// [`Problem::check`], and the number of arms that are not zero.
    pub(super) fn count_arms(&self, muscles: usize, joints: usize) -> Result<u64, Error> {
        check_length("moment_arms", muscles * joints, self.moment_arms)?;
        check_length("torque", joints, self.torque)?;
        check_length("minimum", muscles, self.minimum)?;
        check_length("maximum", muscles, self.maximum)?;
        check_length("reference", muscles, self.reference)?;
        check_length("weight", muscles, self.weight)?;
        // Without a branch per entry: as a rule all are right.
        let (mut count, mut valid) = (0, true);
        for arm in self.moment_arms {
            count += u64::from(is_nonzero(*arm));
            valid &= arm.abs() <= LARGEST;
        }
        valid &= self.torque.iter().fold(true, |valid, x| valid & (x.abs() <= LARGEST));
        let limits = self.minimum.iter().zip(self.maximum);
        for (((lower, upper), reference), weight) in limits.zip(self.reference).zip(self.weight) {
            valid &= (lower <= upper) & (*lower >= -LARGEST) & (*upper <= LARGEST);
            valid &= (reference.abs() <= LARGEST) & (*weight >= 1.0 / LARGEST) & (*weight <= LARGEST);
        }
        if valid { Ok(count) } else { self.find_invalid().map(|()| count) }
    }

    /// The error for the first entry that is outside its domain.
    #[cold]
    fn find_invalid(&self) -> Result<(), Error> {
        let usual = |_, x: f64| x.abs() <= LARGEST;
        let magnitude = "a finite number of magnitude <= 1e30";
        check_entries("moment_arms", magnitude, self.moment_arms, usual)?;
        check_entries("torque", magnitude, self.torque, usual)?;
        check_entries("minimum", magnitude, self.minimum, usual)?;
        check_entries("maximum", magnitude, self.maximum, usual)?;
        check_entries("reference", magnitude, self.reference, usual)?;
        let positive = |_, w| (1.0 / LARGEST..=LARGEST).contains(&w);
        check_entries("weight", "within 1e-30 to 1e30", self.weight, positive)?;
        check_entries("minimum", "<= maximum", self.minimum, |i: usize, x| x <= self.maximum[i])
    }
}

fn check_length(name: &'static str, expected: usize, values: &[f64]) -> Result<(), Error> {
    let got = values.len();
    if got == expected { Ok(()) } else { Err(Error::WrongLength { name, expected, got }) }
}

/// An error for the first entry that does not hold what is expected.
fn check_entries(
    name: &'static str,
    expected: &'static str,
    values: &[f64],
    holds: impl Fn(usize, f64) -> bool,
) -> Result<(), Error> {
    match values.iter().enumerate().find(|(index, value)| !holds(*index, **value)) {
        Some((index, &got)) => Err(Error::EntryOutOfDomain { name, index, expected, got }),
        None => Ok(()),
    }
}

#[cfg(test)]
mod tests {
    use super::*;

    #[test]
    fn a_problem_is_checked_without_being_solved() {
        let right = Problem {
            moment_arms: &[0.03, -0.02],
            torque: &[1.0],
            minimum: &[5.0; 2],
            maximum: &[100.0; 2],
            reference: &[0.0; 2],
            weight: &[1.0; 2],
        };
        assert_eq!(right.check(2, 1), Ok(()));
        assert!(matches!(right.check(1, 2), Err(Error::WrongLength { name: "torque", expected: 2, got: 1 })));
        let crossed = Problem { minimum: &[5.0, 100.5], ..right };
        assert!(matches!(
            crossed.check(2, 1),
            Err(Error::EntryOutOfDomain { name: "minimum", index: 1, .. })
        ));
        let slack = Problem { weight: &[1.0, 0.0], ..right };
        assert!(matches!(slack.check(2, 1), Err(Error::EntryOutOfDomain { name: "weight", index: 1, .. })));
    }
}
