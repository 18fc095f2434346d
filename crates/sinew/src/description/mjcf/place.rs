//! Frames in MJCF: a position and one of five forms of orientation.

use super::compiler::Compiler;
use crate::description::attributes::Attributes;
use crate::description::error::DescriptionError;
use crate::description::orientation as turn;

/// A frame relative to another.
#[derive(Debug, Clone, Copy)]
pub(in crate::description) struct Place {
    pub(in crate::description) position: [f64; 3],
    pub(in crate::description) orientation: [f64; 4],
}

pub(in crate::description) const HERE: Place = Place { position: [0.0; 3], orientation: turn::IDENTITY };

impl Place {
    /// A point of this frame in the outer one.
    pub(in crate::description) fn point(&self, local: [f64; 3]) -> [f64; 3] {
        let turned = turn::rotate(self.orientation, local);
        core::array::from_fn(|i| self.position[i] + turned[i])
    }

    /// A frame within this one, in the outer one.
    pub(in crate::description) fn of(&self, inner: Place) -> Place {
        let orientation = if turn::is_identity(self.orientation) {
            inner.orientation
        } else {
            turn::product(self.orientation, inner.orientation)
        };
        Place { position: self.point(inner.position), orientation }
    }
}

/// `pos` and the orientation in any form.
pub(super) fn place(at: Attributes<'_>, compiler: &Compiler) -> Result<Place, DescriptionError> {
    Ok(Place { position: at.array_or("pos", [0.0; 3])?, orientation: orientation(at, compiler)? })
}

const FORMS: [&str; 5] = ["quat", "axisangle", "xyaxes", "zaxis", "euler"];

fn orientation(at: Attributes<'_>, compiler: &Compiler) -> Result<[f64; 4], DescriptionError> {
    let own = Attributes::own(at.tree, at.element);
    let count = FORMS.iter().filter(|form| own.text(form).is_some()).count();
    if count > 1 {
        return Err(at.error(
            "",
            "gives its orientation more than once: expected one of quat, axisangle, xyaxes, zaxis, euler",
        ));
    }
    // A form in the element replaces the form of the class.
    let at = if count == 1 { own } else { at };
    let short = |form: &str| at.error(form, "has no direction: expected a vector that is not zero");
    if let Some(quat) = at.array::<4>("quat")? {
        return turn::unit(quat).ok_or_else(|| short("quat"));
    }
    if let Some([x, y, z, angle]) = at.array::<4>("axisangle")? {
        let axis = turn::unit([x, y, z]).ok_or_else(|| short("axisangle"))?;
        return Ok(turn::about(axis, angle * compiler.radians));
    }
    if let Some([a, b, c, d, e, f]) = at.array::<6>("xyaxes")? {
        let x = turn::unit([a, b, c]).ok_or_else(|| short("xyaxes"))?;
        let along = turn::dot(x, [d, e, f]);
        let y = core::array::from_fn(|i| [d, e, f][i] - along * x[i]);
        let y = turn::unit(y).ok_or_else(|| short("xyaxes"))?;
        let z = turn::unit(turn::cross(x, y)).ok_or_else(|| short("xyaxes"))?;
        return Ok(turn::from_axes(x, y, z));
    }
    if let Some(axis) = at.array::<3>("zaxis")? {
        return turn::unit(axis).map(turn::z_to).ok_or_else(|| short("zaxis"));
    }
    if let Some(angles) = at.array::<3>("euler")? {
        return Ok(turn::euler(angles.map(|a| a * compiler.radians), compiler.sequence));
    }
    Ok(turn::IDENTITY)
}
