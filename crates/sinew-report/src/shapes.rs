//! Shapes of bodies as rounded convex hulls: points with a radius around them. Their outline in any direction
//! of view is the convex hull of the projected points, widened by the radius.

use sinew::body::{Geom, GeomKind, Parts, PathElement, TendonPath};

/// Points of a circle, and of half a meridian of an ellipsoid.
const CIRCLE: usize = 20;
const MERIDIAN: usize = 8;
/// Radius of a body without geoms, as a fraction of the mean length of its parts.
const DRAWN_FRACTION: f64 = 0.06;

/// The convex hull of balls of one radius, in the frame of a body, m.
#[derive(Debug, Clone, PartialEq)]
pub struct RoundedHull {
    /// The body.
    pub body: usize,
    /// Centres of the balls.
    pub points: Vec<[f64; 3]>,
    /// Their radius; zero for a hull with corners.
    pub radius: f64,
}

/// Shapes of all bodies: those of the file; for a body without one the hull of its origin, those of the
/// bodies that it carries and its sites, the world's excepted.
#[must_use]
pub fn shapes(parts: &Parts) -> Vec<RoundedHull> {
    // Of the world what is not larger than the robot: a floor would hide it.
    let length = |x: [f64; 3]| x.iter().map(|x| x * x).sum::<f64>().sqrt();
    let reach: f64 = parts.bodies.iter().map(|body| length(body.position)).sum();
    let small = |geom: &&Geom| geom.body > 0 || geom.size.iter().all(|size| *size <= reach);
    let mut shapes: Vec<RoundedHull> = parts.geoms.iter().filter(small).map(of_geom).collect();
    let described: Vec<bool> =
        (0..parts.bodies.len()).map(|body| parts.geoms.iter().any(|geom| geom.body == body)).collect();
    // Sites of cables, and those of no cable: end points, sensors. A site that only selects the side of a
    // surface may lie outside the body.
    let paths = || {
        parts.tendons.iter().flat_map(|tendon| match &tendon.path {
            TendonPath::Spatial(elements) => elements.as_slice(),
            TendonPath::Fixed(_) => &[],
        })
    };
    let side = |index: usize| {
        paths().any(|element| matches!(element, PathElement::Wrap { side: Some(side), .. } if *side == index))
    };
    let through = |index: usize| paths().any(|element| *element == PathElement::Site(index));
    let mut points: Vec<Vec<[f64; 3]>> = vec![Vec::new(); parts.bodies.len()];
    for (index, body) in parts.bodies.iter().enumerate().skip(1) {
        points[index].push([0.0; 3]);
        if body.parent > 0 {
            points[body.parent].push(body.position);
        }
    }
    for (index, site) in parts.sites.iter().enumerate() {
        if through(index) || !side(index) {
            points[site.body].push(site.position);
        }
    }
    let spans: Vec<f64> = points.iter().map(|points| span(points)).filter(|span| *span > 0.0).collect();
    let radius = DRAWN_FRACTION * spans.iter().sum::<f64>() / (spans.len() as f64).max(1.0);
    for (body, points) in points.into_iter().enumerate() {
        if !described[body] && !points.is_empty() {
            shapes.push(RoundedHull { body, points, radius });
        }
    }
    shapes
}

/// Largest distance of a point from the first.
fn span(points: &[[f64; 3]]) -> f64 {
    let Some(first) = points.first() else { return 0.0 };
    let distance = |p: &[f64; 3]| p.iter().zip(first).map(|(a, b)| (a - b) * (a - b)).sum::<f64>().sqrt();
    points.iter().map(distance).fold(0.0, f64::max)
}

/// The shape of a geom.
fn of_geom(geom: &Geom) -> RoundedHull {
    let [a, b, c] = geom.size;
    let circle = |r: f64, z: f64| {
        (0..CIRCLE).map(move |k| {
            let (sine, cosine) = (std::f64::consts::TAU * k as f64 / CIRCLE as f64).sin_cos();
            [r * cosine, r * sine, z]
        })
    };
    let (own, radius): (Vec<[f64; 3]>, f64) = match geom.kind {
        GeomKind::Sphere => (vec![[0.0; 3]], a),
        GeomKind::Capsule => (vec![[0.0, 0.0, -b], [0.0, 0.0, b]], a),
        GeomKind::Cylinder => (circle(a, -b).chain(circle(a, b)).collect(), 0.0),
        GeomKind::Ellipsoid => {
            let rings = (0..=MERIDIAN).flat_map(|k| {
                let (sine, cosine) = (std::f64::consts::PI * k as f64 / MERIDIAN as f64).sin_cos();
                circle(sine, cosine)
            });
            (rings.map(|[x, y, z]| [a * x, b * y, c * z]).collect(), 0.0)
        }
        GeomKind::Box => {
            let sign = |k: usize, bit: usize| if k >> bit & 1 == 0 { -1.0 } else { 1.0 };
            ((0..8).map(|k| [a * sign(k, 0), b * sign(k, 1), c * sign(k, 2)]).collect(), 0.0)
        }
    };
    let place = |p: [f64; 3]| {
        let turned = rotated(geom.orientation, p);
        std::array::from_fn(|i| geom.position[i] + turned[i])
    };
    RoundedHull { body: geom.body, points: own.into_iter().map(place).collect(), radius }
}

/// A vector turned by a unit quaternion `[w, x, y, z]`.
pub(super) fn rotated([w, x, y, z]: [f64; 4], [a, b, c]: [f64; 3]) -> [f64; 3] {
    let t = [2.0 * (y * c - z * b), 2.0 * (z * a - x * c), 2.0 * (x * b - y * a)];
    [
        a + w * t[0] + y * t[2] - z * t[1],
        b + w * t[1] + z * t[0] - x * t[2],
        c + w * t[2] + x * t[1] - y * t[0],
    ]
}

#[cfg(test)]
mod tests {
    use super::*;

    /// Extent of a shape along a direction.
    fn reach(shape: &RoundedHull, along: [f64; 3]) -> f64 {
        let of = |p: &[f64; 3]| p.iter().zip(along).map(|(a, b)| a * b).sum::<f64>();
        shape.radius + shape.points.iter().map(of).fold(f64::NEG_INFINITY, f64::max)
    }

    #[test]
    fn every_kind_reaches_as_far_as_its_sizes_say() {
        let half = std::f64::consts::FRAC_1_SQRT_2;
        for (kind, reaches) in [
            (GeomKind::Sphere, [0.1, 0.1, 0.1]),
            (GeomKind::Capsule, [0.1, 0.1, 0.1 + 0.2]),
            (GeomKind::Cylinder, [0.1, 0.1, 0.2]),
            (GeomKind::Ellipsoid, [0.1, 0.2, 0.3]),
            (GeomKind::Box, [0.1, 0.2, 0.3]),
        ] {
            let size = [0.1, 0.2, 0.3];
            let geom = Geom { body: 1, kind, size, position: [0.0; 3], orientation: [1.0, 0.0, 0.0, 0.0] };
            let upright = of_geom(&geom);
            // A quarter turn about x takes y to z and z to -y.
            let turned =
                of_geom(&Geom { position: [1.0, 2.0, 3.0], orientation: [half, half, 0.0, 0.0], ..geom });
            let axes = [[1.0, 0.0, 0.0], [0.0, 1.0, 0.0], [0.0, 0.0, 1.0]];
            for (k, axis) in axes.into_iter().enumerate() {
                assert!((reach(&upright, axis) - reaches[k]).abs() < 1e-12, "{kind:?} {k}");
                let expected = [1.0 + reaches[0], 2.0 + reaches[2], 3.0 + reaches[1]][k];
                assert!((reach(&turned, axis) - expected).abs() < 1e-12, "{kind:?} {k}");
            }
        }
    }
}
