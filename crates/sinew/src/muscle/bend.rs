use super::geometry::{Geometry, Muscles};
use crate::body::vector::{Vector, cross, dot, norm, rotate};
use crate::error::{Error, check_length};

impl Muscles {
    /// Wrap angle of each muscle: the sum over its surfaces, rad.
    ///
    /// # Shapes
    /// `angles: [muscles]`; 0 for fixed tendons.
    ///
    /// # Errors
    /// [`Error::WrongLength`] names the slice.
    pub fn wrap_angles(&self, geometry: &Geometry, angles: &mut [f64]) -> Result<(), Error> {
        self.check(geometry)?;
        check_length("angles", angles.len(), self.count())?;
        for (cable, angle) in self.topology.cables.iter().zip(angles.iter_mut()) {
            *angle = geometry.strands[cable.spans.clone()].iter().map(|strand| strand.angle).sum();
        }
        Ok(())
    }

    /// Bend of each muscle between the end of its sheath and its anchor.
    ///
    /// ```text
    /// phi(q) = turn at the end of the sheath + turns at the guides + wraps
    /// ```
    ///
    /// A guide is a site that the cable passes; the angle at the end of the sheath is between the sheath's
    /// axis and the cable. The bend of the sheath itself is not included.
    ///
    /// # Shapes
    /// `bends: [muscles]`, rad; 0 for fixed tendons.
    ///
    /// # Errors
    /// [`Error::WrongLength`] names the slice.
    ///
    /// # Source
    /// `yuan2023`, eq. 6.
    pub fn bends(&self, geometry: &Geometry, bends: &mut [f64]) -> Result<(), Error> {
        self.check(geometry)?;
        check_length("bends", bends.len(), self.count())?;
        bends.iter_mut().enumerate().for_each(|(muscle, bend)| *bend = self.bend(geometry, muscle));
        Ok(())
    }

    /// The same of one muscle, 0 for an index out of range, with a geometry of these muscles.
    pub(super) fn bend(&self, geometry: &Geometry, muscle: usize) -> f64 {
        let Some(cable) = self.topology.cables.get(muscle) else { return 0.0 };
        let mut before =
            cable.sheath_end.map(|end| rotate(&geometry.poses.links[end.link].axes, end.position));
        let mut bend = 0.0;
        for (index, span) in cable.spans.clone().zip(&self.topology.spans[cable.spans.clone()]) {
            let strand = &geometry.strands[index];
            if span.begins && index != cable.spans.start {
                before = None;
            }
            bend += before.map_or(0.0, |before| between(before, strand.out)) + strand.angle;
            before = Some(strand.into);
        }
        bend
    }
}

/// Angle between two unit vectors.
fn between(a: Vector, b: Vector) -> f64 {
    libm::atan2(norm(cross(a, b)), dot(a, b))
}
