use super::circle::turning;
use super::geometry::{Geometry, Muscles, Strand};
use super::topology::{Around, Crossing, Span};
use crate::body::vector::{Vector, add, add_scaled, cross, dot, norm, rotate, scale, sub, unrotate};
use crate::body::{JointKind, MotionAxis, Robot, WrapKind};
use crate::error::{Error, check_entries, check_length};
use alloc::vec;
use alloc::vec::Vec;
use core::ops::Range;

/// Time derivatives of the moment arms, written by [`Muscles::moment_arm_rates`].
///
/// ```text
/// R' = sum_k dR/dq_k v_k;    l'' = -R a - R' v
/// ```
#[derive(Debug, Clone, PartialEq)]
pub struct MomentArmRates {
    /// Spatial velocity of each link.
    links: Vec<MotionAxis>,
    /// Change of each joint's axis.
    motion_axes: Vec<MotionAxis>,
    rates: Vec<f64>,
}

/// A moving straight segment: a point of it, its direction, and their time derivatives.
#[derive(Clone, Copy)]
struct Line {
    point: Vector,
    moving: Vector,
    direction: Vector,
    turning: Vector,
}

impl MomentArmRates {
    /// Memory for the muscles of a robot.
    #[must_use]
    pub fn new(robot: &Robot, muscles: &Muscles) -> MomentArmRates {
        MomentArmRates {
            links: vec![MotionAxis::default(); robot.tree.links.len()],
            motion_axes: vec![MotionAxis::default(); robot.nv()],
            rates: vec![0.0; muscles.topology.columns.len()],
        }
    }

    /// Rates of all moment arms, m/s, in the order of [`Geometry::moment_arms`].
    #[must_use]
    pub fn rates(&self) -> &[f64] {
        &self.rates
    }
}

impl Muscles {
    /// Exact time derivatives of the moment arms at a velocity.
    ///
    /// # Shapes
    /// `geometry` as evaluated in the pose, `v: [nv]`.
    ///
    /// # Assumes
    /// No cable begins or ceases to touch a surface; there moment arms have a kink.
    ///
    /// # Errors
    /// [`Error::WrongLength`], and [`Error::EntryOutOfDomain`] where a velocity is not finite, or where a
    /// cable ends on a surface it wraps, so that its direction turns without bound.
    pub fn moment_arm_rates(
        &self,
        geometry: &Geometry,
        v: &[f64],
        found: &mut MomentArmRates,
    ) -> Result<(), Error> {
        self.check(geometry)?;
        check_entries("v", v, self.nv)?;
        check_length("arm rates", found.motion_axes.len(), self.nv)?;
        check_length("arm rates", found.links.len(), geometry.poses.links.len())?;
        check_length("arm rates", found.rates.len(), self.topology.columns.len())?;
        self.move_links(geometry, v, found);
        found.rates.fill(0.0);
        for (index, span) in self.topology.spans.iter().enumerate() {
            let strand = &geometry.strands[index];
            match (&span.around, strand.contact) {
                (Some(around), Some(_)) => {
                    let [first, second] = self.bent(span, around, strand, geometry, found);
                    self.accumulate_rates(around.before.clone(), span.share, first, geometry, found);
                    self.accumulate_rates(around.after.clone(), span.share, second, geometry, found);
                }
                _ => {
                    let line = self.straight(span, strand, geometry, found);
                    self.accumulate_rates(span.direct.clone(), span.share, line, geometry, found);
                }
            }
        }
        check_entries("moment arm rates", &found.rates, self.topology.columns.len())
    }

    /// Rates of moment arms as a whole matrix.
    ///
    /// # Shapes
    /// `dense: [muscles x nv]`, row by row.
    ///
    /// # Errors
    /// [`Error::WrongLength`] names the slice.
    pub fn dense_rates(&self, found: &MomentArmRates, dense: &mut [f64]) -> Result<(), Error> {
        check_length("arm rates", found.rates.len(), self.topology.columns.len())?;
        self.spread(&found.rates, dense)
    }

    fn move_links(&self, geometry: &Geometry, v: &[f64], found: &mut MomentArmRates) {
        for (index, link) in &self.topology.links {
            let mut motion = if link.parent == 0 { MotionAxis::default() } else { found.links[link.parent] };
            let own = link.v..link.v + link.kind.velocities();
            for k in own.clone() {
                let axis = &geometry.poses.motion_axes[k];
                motion.angular = add_scaled(motion.angular, v[k], axis.angular);
                motion.linear = add_scaled(motion.linear, v[k], axis.linear);
            }
            found.links[*index] = motion;
            for k in own {
                let axis = &geometry.poses.motion_axes[k];
                // The translations of a free joint are along the world's axes.
                let fixed = link.kind == JointKind::Free && k < link.v + 3;
                found.motion_axes[k] = if fixed { MotionAxis::default() } else { carried(&motion, axis) };
            }
        }
    }

    fn straight(&self, span: &Span, strand: &Strand, geometry: &Geometry, found: &MomentArmRates) -> Line {
        let (point, moving) = self.end(span.from, geometry, found);
        let (_, far) = self.end(span.to, geometry, found);
        let way = sub(far, moving);
        let across = add_scaled(way, -dot(way, strand.out), strand.out);
        let turning = if strand.length > 1e-15 { scale(1.0 / strand.length, across) } else { [0.0; 3] };
        Line { point, moving, direction: strand.out, turning }
    }

    /// The two straight segments on both sides of a surface.
    fn bent(
        &self,
        span: &Span,
        around: &Around,
        strand: &Strand,
        geometry: &Geometry,
        found: &MomentArmRates,
    ) -> [Line; 2] {
        let (surface, pose) = (&self.topology.surfaces[around.surface], &geometry.surfaces[around.surface]);
        let carrier = match surface.place.link {
            0 => MotionAxis::default(),
            link => found.links[link],
        };
        let sites = [span.from, span.to].map(|anchor| self.end(anchor, geometry, found));
        // Positions and velocities of the ends relative to the surface.
        let ends = sites.map(|(point, _)| sub(point, pose.origin));
        let moving = sites.map(|(point, moving)| sub(moving, carrier.at(point)));
        let touch = strand.contact.map_or((1.0, 0.0), |contact| contact.touch);
        let directions = [strand.out, strand.into];
        let turned = match surface.kind {
            WrapKind::Sphere => on_sphere(ends, moving, directions, touch, surface.radius),
            WrapKind::Cylinder => {
                let inner = |vectors: [Vector; 2]| vectors.map(|vector| unrotate(&pose.axes, vector));
                on_cylinder(
                    inner(ends),
                    inner(moving),
                    inner(directions),
                    touch,
                    (surface.radius, strand.length),
                )
                .map(|turning| rotate(&pose.axes, turning))
            }
        };
        [0, 1].map(|i| Line {
            point: sites[i].0,
            moving: sites[i].1,
            direction: directions[i],
            turning: add(turned[i], cross(carrier.angular, directions[i])),
        })
    }

    /// Position and velocity of a site.
    fn end(&self, anchor: usize, geometry: &Geometry, found: &MomentArmRates) -> (Vector, Vector) {
        let point = geometry.points[anchor];
        let moving = match self.topology.anchors[anchor].link {
            0 => [0.0; 3],
            link => found.links[link].at(point),
        };
        (point, moving)
    }

    /// Adds the time derivative of the moment arms of a straight segment.
    fn accumulate_rates(
        &self,
        crossings: Range<usize>,
        share: f64,
        line: Line,
        geometry: &Geometry,
        found: &mut MomentArmRates,
    ) {
        let moment = cross(line.point, line.direction);
        let change = add(cross(line.moving, line.direction), cross(line.point, line.turning));
        for &Crossing { velocity, slot, sign } in &self.topology.crossings[crossings] {
            let (axis, rate) = (&geometry.poses.motion_axes[velocity], &found.motion_axes[velocity]);
            let along = dot(rate.angular, moment)
                + dot(axis.angular, change)
                + dot(rate.linear, line.direction)
                + dot(axis.linear, line.turning);
            found.rates[slot] -= share * sign * along;
        }
    }
}

/// Change of a axis that moves with a body.
fn carried(motion: &MotionAxis, axis: &MotionAxis) -> MotionAxis {
    MotionAxis {
        angular: cross(motion.angular, axis.angular),
        linear: add(cross(motion.linear, axis.angular), cross(motion.angular, axis.linear)),
    }
}

/// Time derivative of both directions on a sphere at the origin: in the plane they turn as on a circle, and
/// the plane itself turns.
fn on_sphere(
    ends: [Vector; 2],
    moving: [Vector; 2],
    directions: [Vector; 2],
    touch: (f64, f64),
    radius: f64,
) -> [Vector; 2] {
    let product = cross(ends[0], ends[1]);
    let size = norm(product);
    if size < 1e-15 {
        return [[0.0; 3]; 2];
    }
    let normal = scale(1.0 / size, product);
    let change = add(cross(moving[0], ends[1]), cross(ends[0], moving[1]));
    // With a part along the normal, which no direction in the plane meets.
    let tilt = scale(1.0 / size, change);
    let x = scale(1.0 / norm(ends[0]), ends[0]);
    let y = cross(normal, x);
    let planar = |vectors: [Vector; 2]| vectors.map(|vector| [dot(vector, x), dot(vector, y)]);
    let rates = turning(planar(ends), planar(moving), touch, radius);
    [0, 1].map(|i| {
        let in_plane = scale(rates[i], cross(normal, directions[i]));
        add_scaled(in_plane, -dot(directions[i], tilt), normal)
    })
}

/// Time derivative of both directions on a cylinder about z, all in its frame: around they turn as on a
/// circle, and the slope of the helix changes.
fn on_cylinder(
    ends: [Vector; 2],
    moving: [Vector; 2],
    directions: [Vector; 2],
    touch: (f64, f64),
    (radius, length): (f64, f64),
) -> [Vector; 2] {
    let planar = |vectors: [Vector; 2]| vectors.map(|[x, y, _]| [x, y]);
    let rates = turning(planar(ends), planar(moving), touch, radius);
    let slope = directions[0][2];
    let along = libm::sqrt((1.0 - slope * slope).max(0.0));
    let climbing = moving[1][2] - moving[0][2];
    let level = |direction: Vector, motion: Vector| direction[0] * motion[0] + direction[1] * motion[1];
    if along < 1e-12 {
        return [[0.0; 3]; 2];
    }
    // Rate of the length around the cylinder, from the tangents.
    let widening = (level(directions[1], moving[1]) - level(directions[0], moving[0])) / along;
    let tilt = (along * climbing - slope * widening) / length;
    [0, 1].map(|i| {
        let [x, y, _] = directions[i];
        let lean = -slope * tilt / along;
        [lean * x - rates[i] * y, lean * y + rates[i] * x, along * tilt]
    })
}

#[cfg(test)]
mod tests {
    use super::*;

    #[test]
    fn directions_do_not_turn_where_the_plane_or_the_slope_of_a_cable_is_undetermined() {
        let (along, moving) = ([1.0, 2.0, -0.5], [[0.1, -0.2, 0.3], [0.4, 0.0, -0.1]]);
        // Both ends and the centre on one line.
        let ends = [scale(-1.0, along), scale(1.5, along)];
        let directions = [[0.0, 0.0, 1.0], [0.0, 1.0, 0.0]];
        assert_eq!(on_sphere(ends, moving, directions, (1.0, 1.5), 0.3), [[0.0; 3]; 2]);
        // A cable parallel to the axis.
        let ends = [[0.5, 0.0, 0.0], [0.5, 0.0, 4.0]];
        let up = [[0.0, 0.0, 1.0]; 2];
        assert_eq!(on_cylinder(ends, moving, up, (1.0, 1.5), (0.3, 4.0)), [[0.0; 3]; 2]);
    }
}
