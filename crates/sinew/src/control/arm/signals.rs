//! Inputs and outputs of the arm's controller.

use super::status::ArmStatus;
use crate::Error;
use crate::control::tension::Status;
use crate::drive::DriveCommand;
use crate::error::{check_entries, check_length};
use crate::trajectory::Reference;

/// Measurements of an arm's sensors in one control cycle.
#[derive(Debug, Clone, Copy, PartialEq)]
pub struct ArmMeasurement<'a> {
    /// Position of every cable by its motor's encoder, m, + toward the motor: `[muscles]`.
    pub motor: &'a [f64],
    /// Tension at every drive's outlet by its load cell, N: `[muscles]`.
    pub tension: &'a [f64],
    /// Coordinate of every independent joint by its encoder, rad or m: `[joints]`; not read where a joint has
    /// none.
    pub joint: &'a [f64],
}

/// Reference of the joints at the present time and at the end of the
/// [`PREVIEW_HORIZON`](crate::control::stretch::PREVIEW_HORIZON).
#[derive(Debug, Clone, Copy, PartialEq)]
pub struct PreviewedReference<'a> {
    /// Reference at the present time, `t`.
    pub current: &'a Reference,
    /// Reference at `t + t_p`.
    pub previewed: &'a Reference,
    /// Time since the present repeat of a periodic motion began, s, for iterative learning; none outside of
    /// repeats.
    pub repeat_time: Option<f64>,
}

/// Commands for the drives with the intermediate results that led to them; valid until the next control
/// cycle.
#[derive(Debug, Clone, Copy)]
pub struct ArmCommand<'a> {
    /// Commands for the drives: `[muscles]`.
    pub drives: &'a [DriveCommand],
    /// Desired tension at every anchor, `F_d` of (22), N: `[muscles]`.
    pub desired_tension: &'a [f64],
    /// Estimated tension at every anchor, N: `[muscles]`.
    pub estimated_tension: &'a [f64],
    /// Estimated joint angles, rad: `[joints]`.
    pub q: &'a [f64],
    /// Whether the desired tensions give the desired torque.
    pub distribution: Status,
    /// Operating state of the arm, and its fault where there is one.
    pub status: ArmStatus,
}

/// Number of muscles and joints: what all inputs of a controller have to agree with.
#[derive(Debug, Clone, Copy)]
pub(super) struct Dimensions {
    pub(super) muscles: usize,
    pub(super) joints: usize,
}

impl Dimensions {
    /// Checks the lengths of all slices of a control cycle, and that the references are finite; readings need
    /// not be.
    ///
    /// # Errors
    /// [`Error::WrongLength`] names the first slice of another length, [`Error::EntryOutOfDomain`] the first
    /// entry of a reference that is not finite.
    pub(super) fn check(
        self,
        measurement: &ArmMeasurement<'_>,
        reference: &PreviewedReference<'_>,
    ) -> Result<(), Error> {
        let ArmMeasurement { motor, tension, joint } = measurement;
        check_length("motor", motor.len(), self.muscles)?;
        check_length("tension", tension.len(), self.muscles)?;
        check_length("joint", joint.len(), self.joints)?;
        let PreviewedReference { current, previewed, .. } = reference;
        for (name, values) in [
            ("current q", &current.q),
            ("current v", &current.v),
            ("current a", &current.a),
            ("previewed q", &previewed.q),
            ("previewed v", &previewed.v),
            ("previewed a", &previewed.a),
        ] {
            check_entries(name, values, self.joints)?;
        }
        Ok(())
    }
}

#[cfg(test)]
mod tests {
    use super::*;
    use alloc::vec::Vec;

    const DIMENSIONS: Dimensions = Dimensions { muscles: 3, joints: 2 };

    #[test]
    fn a_slice_of_another_robot_is_refused_by_its_name_and_readings_need_not_be_finite() {
        let (three, two) = ([f64::NAN; 3], [f64::INFINITY; 2]);
        let whole = ArmMeasurement { motor: &three, tension: &three, joint: &two };
        let rest = Reference::new(2);
        let reference = PreviewedReference { current: &rest, previewed: &rest, repeat_time: None };
        assert!(DIMENSIONS.check(&whole, &reference).is_ok());
        for (name, wrong) in [
            ("motor", ArmMeasurement { motor: &two, ..whole }),
            ("tension", ArmMeasurement { tension: &two, ..whole }),
            ("joint", ArmMeasurement { joint: &three, ..whole }),
        ] {
            let error = DIMENSIONS.check(&wrong, &reference).unwrap_err();
            assert!(matches!(error, Error::WrongLength { name: found, .. } if found == name), "{error:?}");
        }
    }

    #[test]
    fn a_reference_that_is_not_finite_or_of_another_robot_is_refused_by_its_name_and_entry() {
        let measurement = ArmMeasurement { motor: &[0.0; 3], tension: &[0.0; 3], joint: &[0.0; 2] };
        let rest = Reference::new(2);
        let wrong: [fn(&mut Reference) -> &mut Vec<f64>; 3] = [|r| &mut r.q, |r| &mut r.v, |r| &mut r.a];
        for (field, of) in ["q", "v", "a"].into_iter().zip(wrong) {
            for (when, present) in [("current", true), ("previewed", false)] {
                let check = |wrong: &Reference| {
                    let (current, previewed) = if present { (wrong, &rest) } else { (&rest, wrong) };
                    let reference = PreviewedReference { current, previewed, repeat_time: None };
                    DIMENSIONS.check(&measurement, &reference).unwrap_err()
                };
                let expected = alloc::format!("{when} {field}");
                let (mut infinite, mut longer) = (rest.clone(), rest.clone());
                of(&mut infinite)[1] = f64::NEG_INFINITY;
                of(&mut longer).push(0.0);
                let error = check(&infinite);
                assert!(
                    matches!(error, Error::EntryOutOfDomain { name, index: 1, .. } if name == expected),
                    "{expected}: {error:?}"
                );
                let error = check(&longer);
                assert!(
                    matches!(error, Error::WrongLength { name, got: 3, expected: 2 } if name == expected),
                    "{expected}: {error:?}"
                );
            }
        }
    }
}
