use super::geometry::{Geometry, Muscles};
use crate::body::vector::{Vector, add, add_scaled, cross, dot, norm, scale, sub};
use crate::body::{JointKind, Poses, Robot, TendonPath};
use crate::error::Error;
use alloc::vec;
use alloc::vec::Vec;

/// Fraction of the way to the next joint, or to the end of the last body, at which a cord over pulleys begins
/// and ends: its file does not say where it is fixed.
const FIXED_AT: f64 = 0.6;
/// Sine of the angle between an axis and a link below which the cord has no side of the link.
const ALONG: f64 = 0.1;
/// m: joints and ends that are nearer are at one place.
const SAME_PLACE: f64 = 1e-6;

impl Muscles {
    /// Polylines along a muscle in the world for drawing: those of [`path`](Self::path), and for a fixed
    /// tendon one over pulleys on its joints, whose radii are its coefficients. Where such a cord is fixed to
    /// the bodies is not known: it is drawn beside the links, from before its first joint to behind its last.
    /// None for a fixed tendon of slides alone or an index out of range.
    ///
    /// # Errors
    /// As [`path`](Self::path).
    pub fn drawn(
        &self,
        robot: &Robot,
        poses: &Poses,
        geometry: &Geometry,
        muscle: usize,
        step: f64,
    ) -> Result<Vec<Vec<[f64; 3]>>, Error> {
        match robot.parts().tendons.get(muscle).map(|tendon| &tendon.path) {
            Some(TendonPath::Fixed(terms)) => {
                let cord = over_pulleys(robot, poses, terms, step.max(1e-3));
                Ok(if cord.is_empty() { Vec::new() } else { vec![cord] })
            }
            _ => self.path(geometry, muscle, step),
        }
    }
}

/// Joints of a cord at one place.
struct Place {
    at: Vector,
    /// Axis of every hinge, and the radius of the pulley, m, on the side to which the cord turns it.
    pulleys: Vec<(Vector, f64)>,
    body: usize,
}

fn over_pulleys(robot: &Robot, poses: &Poses, terms: &[(usize, f64)], step: f64) -> Vec<Vector> {
    let places = places(robot, poses, terms);
    let (Some(first), Some(last)) = (places.first(), places.last()) else { return Vec::new() };
    let end = far_end(robot, poses, last);
    let begin = near_end(robot, poses, first);
    let forward =
        places.get(1).map(|next| sub(next.at, first.at)).or_else(|| end.map(|end| sub(end, last.at)));
    let fallback = forward.unwrap_or([0.0, 0.0, 1.0]);
    let begin = begin.unwrap_or_else(|| sub(first.at, fallback));
    let arrives = places.get(places.len().wrapping_sub(2)).map_or(begin, |before| before.at);
    let end = end.unwrap_or_else(|| add(last.at, sub(last.at, arrives)));
    let mut stops = vec![add_scaled(first.at, FIXED_AT, sub(begin, first.at))];
    stops.extend(places.iter().map(|place| place.at));
    stops.push(add_scaled(last.at, FIXED_AT, sub(end, last.at)));
    let mut cord = Vec::new();
    for (k, place) in places.iter().enumerate() {
        let (into, out) = (sub(place.at, stops[k]), sub(stops[k + 2], place.at));
        let [before, behind] = [into, out].map(|along| beside(place, along));
        if k == 0 {
            cord.push(add(stops[0], before));
        }
        round(&mut cord, place, (into, out), (before, behind), step);
        if k + 1 == places.len() {
            cord.push(add(stops[k + 2], behind));
        }
    }
    cord
}

/// The hinges of a cord in the order of the tree, those at one place together.
fn places(robot: &Robot, poses: &Poses, terms: &[(usize, f64)]) -> Vec<Place> {
    let joints = &robot.parts().joints;
    let mut terms: Vec<(usize, f64)> = terms.to_vec();
    terms.sort_by_key(|(joint, _)| *joint);
    let mut places: Vec<Place> = Vec::new();
    for (joint, coefficient) in terms {
        let Some(part) = joints.get(joint).filter(|part| part.kind == JointKind::Hinge) else { continue };
        let pose = robot.body_pose(poses, part.body);
        let at = pose.point(part.anchor);
        let pulley = (sub(pose.point(add(part.anchor, part.axis)), at), -coefficient);
        match places.last_mut().filter(|place| norm(sub(place.at, at)) < SAME_PLACE) {
            Some(place) => {
                place.pulleys.push(pulley);
                place.body = part.body;
            }
            None => places.push(Place { at, pulleys: vec![pulley], body: part.body }),
        }
    }
    places
}

/// The nearest origin of a body before the first joint.
fn near_end(robot: &Robot, poses: &Poses, first: &Place) -> Option<Vector> {
    let bodies = &robot.parts().bodies;
    let mut body = first.body;
    while body > 0 {
        body = bodies[body].parent;
        let origin = robot.body_pose(poses, body).origin;
        if body > 0 && norm(sub(origin, first.at)) > SAME_PLACE {
            return Some(origin);
        }
    }
    None
}

/// The farthest of the sites of the last body, the bodies that it carries, and twice its centre of mass, the
/// end of a uniform link.
fn far_end(robot: &Robot, poses: &Poses, last: &Place) -> Option<Vector> {
    let parts = robot.parts();
    let pose = robot.body_pose(poses, last.body);
    let carried = parts.bodies.iter().skip(1).filter(|body| body.parent == last.body);
    let sites = parts.sites.iter().filter(|site| site.body == last.body);
    let uniform = core::iter::once(scale(2.0, parts.bodies[last.body].center_of_mass));
    let points = carried.map(|body| body.position).chain(sites.map(|site| site.position)).chain(uniform);
    let far = points.map(|point| pose.point(point)).max_by(|a, b| {
        let away = |point: &Vector| norm(sub(*point, last.at));
        away(a).total_cmp(&away(b))
    });
    far.filter(|far| norm(sub(*far, last.at)) > SAME_PLACE)
}

/// From the middle of a link to the cord beside it, m.
fn beside(place: &Place, along: Vector) -> Vector {
    let length = norm(along).max(SAME_PLACE);
    place.pulleys.iter().fold([0.0; 3], |sum, (axis, radius)| {
        let side = cross(*axis, scale(1.0 / length, along));
        if norm(side) > ALONG { add_scaled(sum, radius / norm(side), side) } else { sum }
    })
}

/// The cord at a joint: on the outer side of the bend an arc around the pulley, on the inner one the corner
/// of the lines beside both links.
fn round(
    cord: &mut Vec<Vector>,
    place: &Place,
    (into, out): (Vector, Vector),
    (before, behind): (Vector, Vector),
    step: f64,
) {
    let [from, to] = [before, behind].map(norm);
    if from.min(to) < SAME_PLACE {
        cord.push(place.at);
        return;
    }
    let angle = libm::acos((dot(before, behind) / (from * to)).clamp(-1.0, 1.0));
    let middle = add(scale(1.0 / from, before), scale(1.0 / to, behind));
    if dot(out, before) > 0.0 || dot(into, behind) < 0.0 || norm(middle) < ALONG {
        let corner = 0.5 * (from + to) / libm::cos(0.5 * angle).max(0.5);
        cord.push(add_scaled(place.at, corner / norm(middle).max(ALONG), middle));
        return;
    }
    let count = libm::ceil(angle / step).max(1.0) as usize;
    for k in 0..=count {
        let part = k as f64 / count as f64;
        let radius = from + part * (to - from);
        // Between the two directions along the arc.
        let (a, b) = if angle < 1e-6 {
            (1.0, 0.0)
        } else {
            (libm::sin((1.0 - part) * angle) / libm::sin(angle), libm::sin(part * angle) / libm::sin(angle))
        };
        let spoke = add(scale(a / from, before), scale(b / to, behind));
        cord.push(add_scaled(place.at, radius, spoke));
    }
}

#[cfg(test)]
mod tests {
    #![allow(clippy::unwrap_used, reason = "a failing test may panic")]
    use super::super::tests::robots::chain;
    use super::*;

    #[test]
    fn a_cord_over_pulleys_passes_every_joint_at_its_radius_and_pulls_it_to_its_own_side() {
        let mut parts = chain(false).parts().clone();
        for (tendon, sign) in parts.tendons.iter_mut().zip([1.0, -1.0, 1.0]) {
            tendon.path = TendonPath::Fixed(vec![(2, -8e-3 * sign), (0, 0.01 * sign), (1, 0.012 * sign)]);
        }
        parts.tendons[2].path = TendonPath::Fixed(vec![(1, 0.01)]);
        let robot = Robot::new(parts).unwrap();
        let muscles = Muscles::new(&robot);
        let (mut poses, mut geometry) = (Poses::new(&robot), Geometry::new(&robot, &muscles));
        for q in [-0.7, 0.0, 0.4, 1.1] {
            let q = vec![q; robot.nq()];
            robot.forward_kinematics(&q, &mut poses).unwrap();
            muscles.evaluate(&q, &mut geometry).unwrap();
            for (index, tendon) in robot.parts().tendons.iter().enumerate() {
                let TendonPath::Fixed(terms) = &tendon.path else { panic!("a path through space") };
                let drawn = muscles.drawn(&robot, &poses, &geometry, index, 0.1).unwrap();
                let cord = &drawn[0];
                for place in places(&robot, &poses, terms) {
                    let [(axis, radius)] = place.pulleys[..] else {
                        panic!("{} hinges", place.pulleys.len())
                    };
                    // The line nearest to the joint has the pulley's radius as its moment arm.
                    let arms = cord.windows(2).filter_map(|pair| {
                        let along = sub(pair[0], pair[1]);
                        let length = norm(along);
                        (length > 1e-9).then(|| {
                            let arm = dot(cross(sub(pair[1], place.at), along), axis) / length;
                            let middle = scale(0.5, add(pair[0], pair[1]));
                            (norm(sub(middle, place.at)), arm)
                        })
                    });
                    let nearest = arms.min_by(|a, b| a.0.total_cmp(&b.0)).unwrap().1;
                    assert!((nearest / radius - 1.0).abs() < 0.1, "{q:?} {nearest} for {radius}");
                }
            }
        }
    }
}
