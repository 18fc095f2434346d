use super::geometry::{Geometry, Muscles};
use crate::body::WrapKind;
use crate::body::vector::{Vector, add, add_scaled, dot, norm, scale, sub};
use crate::error::{Error, positive};
use alloc::vec;
use alloc::vec::Vec;

impl Muscles {
    /// Polylines along a muscle in the world, for drawing: one per branch, with arcs in steps of at most
    /// `step` rad; none for a fixed tendon or an index out of range.
    ///
    /// # Errors
    /// [`Error::WrongLength`] for a geometry of another robot, [`Error::OutOfDomain`] where `step` is not
    /// above zero.
    pub fn path(&self, geometry: &Geometry, muscle: usize, step: f64) -> Result<Vec<Vec<[f64; 3]>>, Error> {
        self.check(geometry)?;
        // Bounds the number of points.
        let step = positive("step", step)?.max(1e-3);
        let spans = self.topology.cables.get(muscle).map_or(0..0, |cable| cable.spans.clone());
        let mut branches: Vec<Vec<[f64; 3]>> = Vec::new();
        for index in spans {
            let span = &self.topology.spans[index];
            if span.begins || branches.is_empty() {
                branches.push(vec![geometry.points[span.from].at(0)]);
            }
            if let Some(branch) = branches.last_mut() {
                self.arc(index, geometry, step, branch);
                branch.push(geometry.points[span.to].at(0));
            }
        }
        Ok(branches)
    }

    /// Points on the surface of a span, from where the cable arrives to where it leaves.
    fn arc(&self, index: usize, geometry: &Geometry, step: f64, branch: &mut Vec<Vector>) {
        let (span, strand) = (&self.topology.spans[index], &geometry.strands[index]);
        let Some(around) = span.around.as_ref().filter(|_| strand.touches.any()) else { return };
        let (surface, pose) = (&self.topology.surfaces[around.surface], &geometry.surfaces[around.surface]);
        let (out, origin) = (strand.out.at(0), pose.origin.at(0));
        let arrival = add_scaled(geometry.points[span.from].at(0), strand.before.0[0], out);
        if strand.graze.0[0] < core::f64::consts::FRAC_PI_2 {
            branch.push(arrival);
            return;
        }
        let axis = match surface.kind {
            WrapKind::Sphere => [0.0; 3],
            WrapKind::Cylinder => pose.axes.0[2].at(0),
        };
        let from_center = sub(arrival, origin);
        let height = dot(from_center, axis);
        let radius = add_scaled(from_center, -height, axis);
        let climb = dot(out, axis);
        let around = add_scaled(out, -climb, axis);
        let (size, level) = (norm(radius), norm(around));
        let forward = scale(size / level, around);
        let turn = strand.angle.0[0] / level;
        let count = libm::ceil(turn / step).max(1.0) as usize;
        for k in 0..=count {
            let angle = turn * k as f64 / count as f64;
            let (sine, cosine) = libm::sincos(angle);
            let spoke = add(scale(cosine, radius), scale(sine, forward));
            let up = scale(height + size * angle * climb / level, axis);
            branch.push(add(origin, add(spoke, up)));
        }
    }
}
