use super::geometry::{Geometry, Muscles};
use super::topology::{Numbers, Topology};
use crate::error::{Error, check_length};
use crate::lanes::{Row, Vector};

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
            *angle = geometry.strands[cable.spans.clone()].iter().map(|strand| strand.angle.0[0]).sum();
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
        if muscle < self.count() { self.topology.bend(&self.numbers, geometry, muscle).0[0] } else { 0.0 }
    }
}

impl Topology {
    /// Bend of one muscle in every world.
    #[inline(always)]
    pub(super) fn bend<const N: usize>(
        &self,
        numbers: &Numbers<N>,
        geometry: &Geometry<N>,
        muscle: usize,
    ) -> Row<N> {
        let cable = &self.cables[muscle];
        // No closures: in a kernel they would be compiled for the baseline.
        let mut before = None;
        if let Some(end) = cable.sheath_end {
            before = Some(geometry.links[end.link].axes.rotate(numbers.sheath_ends[muscle]));
        }
        let mut bend = Row::default();
        for (index, span) in cable.spans.clone().zip(&self.spans[cable.spans.clone()]) {
            let strand = &geometry.strands[index];
            if span.begins && index != cable.spans.start {
                before = None;
            }
            let mut turn = Row::default();
            if let Some(before) = before {
                turn = between(before, strand.out);
            }
            bend += turn + strand.angle;
            before = Some(strand.into);
        }
        bend
    }
}

/// Angle between two unit vectors.
#[inline(always)]
fn between<const N: usize>(a: Vector<N>, b: Vector<N>) -> Row<N> {
    a.cross(b).norm().atan2(a.dot(b))
}
