//! The convex hull of points in space.

use crate::description::orientation::{cross, dot};
use alloc::collections::BTreeSet;
use alloc::vec::Vec;

/// Distance from a face, as a fraction of the size of all, within which a point counts as on it.
const FLAT: f64 = 1e-9;

/// Triangles of the hull, anticlockwise seen from outside; `None` where the points lie in a plane.
///
/// Points are added one after the other: the faces that see the next one give way to triangles between it and
/// their border.
pub(super) fn convex_hull(points: &[[f64; 3]]) -> Option<Vec<[usize; 3]>> {
    let size = (0..3).map(|i| spread(points.iter().map(|point| point[i]))).fold(0.0, f64::max);
    let flat = FLAT * size;
    let first = simplex(points, flat)?;
    let [a, b, c, d] = first;
    // The fourth corner lies behind each face of the other three.
    let mut faces: Vec<Face> = [[a, b, c, d], [a, b, d, c], [a, c, d, b], [b, c, d, a]]
        .into_iter()
        .map(|[i, j, k, behind]| {
            let face = Face::new(points, [i, j, k]);
            if face.above(points[behind]) > 0.0 { Face::new(points, [i, k, j]) } else { face }
        })
        .collect();
    for (new, &point) in points.iter().enumerate() {
        let sees = |face: &Face| face.above(point) > flat;
        let edges: BTreeSet<(usize, usize)> =
            faces.iter().filter(|face| sees(face)).flat_map(|face| face.edges()).collect();
        if edges.is_empty() {
            continue;
        }
        faces.retain(|face| !sees(face));
        let border = edges.iter().filter(|&&(from, to)| !edges.contains(&(to, from)));
        faces.extend(border.map(|&(from, to)| Face::new(points, [from, to, new])));
    }
    Some(faces.into_iter().map(|face| face.corners).collect())
}

/// A triangle with its unit normal.
struct Face {
    corners: [usize; 3],
    normal: [f64; 3],
    offset: f64,
}

impl Face {
    fn new(points: &[[f64; 3]], corners: [usize; 3]) -> Self {
        let [a, b, c] = corners.map(|k| points[k]);
        let normal = cross(less(b, a), less(c, a));
        let length = libm::sqrt(dot(normal, normal)).max(f64::MIN_POSITIVE);
        let normal = normal.map(|x| x / length);
        Self { corners, normal, offset: dot(normal, a) }
    }

    /// Distance of a point on the outer side.
    fn above(&self, point: [f64; 3]) -> f64 {
        dot(self.normal, point) - self.offset
    }

    fn edges(&self) -> [(usize, usize); 3] {
        let [a, b, c] = self.corners;
        [(a, b), (b, c), (c, a)]
    }
}

/// Four points that are not in a plane.
fn simplex(points: &[[f64; 3]], flat: f64) -> Option<[usize; 4]> {
    let farthest = |distance: &dyn Fn([f64; 3]) -> f64| -> Option<usize> {
        let far = (0..points.len()).max_by(|&i, &j| distance(points[i]).total_cmp(&distance(points[j])))?;
        (distance(points[far]) > flat).then_some(far)
    };
    let length = |v: [f64; 3]| libm::sqrt(dot(v, v));
    let a = points.first().map(|_| 0)?;
    let b = farthest(&|p| length(less(p, points[a])))?;
    let along = less(points[b], points[a]).map(|x| x / length(less(points[b], points[a])));
    let c = farthest(&|p| length(cross(along, less(p, points[a]))))?;
    let plane = Face::new(points, [a, b, c]);
    let d = farthest(&|p| plane.above(p).abs())?;
    Some([a, b, c, d])
}

fn less(a: [f64; 3], b: [f64; 3]) -> [f64; 3] {
    core::array::from_fn(|i| a[i] - b[i])
}

fn spread(values: impl Iterator<Item = f64>) -> f64 {
    let (low, high) = values.fold((f64::MAX, f64::MIN), |(low, high), x| (low.min(x), high.max(x)));
    high - low
}

#[cfg(test)]
mod tests {
    use super::*;

    /// Numbers in [0, 1), the same in every run.
    struct Draw(u64);

    impl Draw {
        fn unit(&mut self) -> f64 {
            self.0 = self.0.wrapping_mul(6_364_136_223_846_793_005).wrapping_add(1_442_695_040_888_963_407);
            (self.0 >> 11) as f64 / (1_u64 << 53) as f64
        }
    }

    /// Six times the volume.
    fn volume(points: &[[f64; 3]], faces: &[[usize; 3]]) -> f64 {
        faces.iter().map(|face| face.map(|k| points[k])).map(|[a, b, c]| dot(a, cross(b, c))).sum()
    }

    #[test]
    fn the_hull_of_a_box_with_points_within_and_on_its_faces_is_the_box() {
        let mut random = Draw(4);
        for _ in 0..50 {
            let half: [f64; 3] = core::array::from_fn(|_| 0.01 + random.unit());
            let mut points: Vec<[f64; 3]> = Vec::new();
            for _ in 0..60 {
                let mut point = half.map(|x| x * (2.0 * random.unit() - 1.0));
                let on = (random.unit() * 4.0) as usize;
                if on < 3 {
                    point[on] = half[on].copysign(point[on]);
                }
                points.push(point);
            }
            for corner in 0..8 {
                points.push(core::array::from_fn(|i| if corner >> i & 1 == 1 { half[i] } else { -half[i] }));
            }
            let found = volume(&points, &convex_hull(&points).unwrap());
            let exact = 48.0 * half.iter().product::<f64>();
            assert!((found - exact).abs() < 1e-7 * exact, "{found} {exact}");
        }
    }

    #[test]
    fn no_point_lies_outside_of_the_hull_and_every_edge_has_two_faces() {
        let mut random = Draw(5);
        for count in [4, 5, 12, 200] {
            let points: Vec<[f64; 3]> =
                (0..count).map(|_| core::array::from_fn(|_| random.unit() - 0.5)).collect();
            let faces = convex_hull(&points).unwrap();
            let edges: BTreeSet<(usize, usize)> =
                faces.iter().flat_map(|&corners| Face::new(&points, corners).edges()).collect();
            assert_eq!(edges.len(), 3 * faces.len());
            assert!(edges.iter().all(|&(from, to)| edges.contains(&(to, from))));
            for &face in &faces {
                let face = Face::new(&points, face);
                assert!(points.iter().all(|&point| face.above(point) < 1e-8));
            }
        }
    }

    #[test]
    fn points_of_a_plane_or_a_line_have_no_hull() {
        let flat: Vec<[f64; 3]> = (0..20).map(|k| [f64::from(k % 5), f64::from(k / 5), 2.0]).collect();
        assert_eq!(convex_hull(&flat), None);
        assert_eq!(convex_hull(&flat[..5]), None);
        assert_eq!(convex_hull(&[]), None);
        assert_eq!(convex_hull(&[[1.0; 3]; 6]), None);
    }
}
