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
    /// Coordinate of every independent joint by its encoder, rad or m: `[joints]`; not read where a joint has none.
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
    /// Checks the lengths of all slices of a control cycle, and that the references are finite; readings need not be.
    ///
    /// # Errors
    /// [`Error::WrongLength`] names the first slice of another length, [`Error::EntryOutOfDomain`] the first entry of a reference that is not
    /// finite.
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
