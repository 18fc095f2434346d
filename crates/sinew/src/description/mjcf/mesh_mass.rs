//! Mass of a mesh: volume, centre of mass and inertia of what its triangles enclose or are.

use super::hull::convex_hull;
use alloc::format;
use alloc::string::{String, ToString};
use alloc::vec::Vec;

/// How the triangles of a mesh make its mass.
#[derive(Debug, Clone, Copy, PartialEq, Eq)]
pub(super) enum MeshLaw {
    /// That of its convex hull.
    Convex,
    /// Of the space that they enclose.
    Exact,
    /// As before MuJoCo had others: every pyramid over a triangle counts with its magnitude.
    Legacy,
    /// Of the surface.
    Shell,
}

/// The words of MJCF, in the order of the laws.
pub(super) const WORDS: [&str; 4] = ["convex", "exact", "legacy", "shell"];
pub(super) const LAWS: [MeshLaw; 4] = [MeshLaw::Convex, MeshLaw::Exact, MeshLaw::Legacy, MeshLaw::Shell];

/// Triangles: corners, m, and indices of three corners each, anticlockwise seen from outside.
#[derive(Debug, Clone, Default)]
pub(super) struct Triangles {
    pub(super) corners: Vec<[f64; 3]>,
    pub(super) faces: Vec<[usize; 3]>,
}

/// Volume, m^3, or of a shell surface, m^2; centre, m, and inertia about it `[xx, yy, zz, xy, xz, yz]` of
/// unit density.
#[derive(Debug, Clone, Copy, PartialEq)]
pub(super) struct MeshMass {
    pub(super) volume: f64,
    pub(super) center: [f64; 3],
    pub(super) tensor: [f64; 6],
}

/// Least volume or surface, as MuJoCo has it.
const LEAST: f64 = 1e-15;

impl Triangles {
    /// From lines `v x y z` and `f i j k` with indices from 1, as in OBJ.
    pub(super) fn parse(text: &str) -> Result<Self, String> {
        let mut triangles = Self::default();
        for line in text.lines() {
            let mut words = line.split_ascii_whitespace();
            let wrong = || format!("line `{line}`: expected `v x y z` or `f i j k`");
            match words.next() {
                Some("v") => {
                    let corner = three(words, |x: &f32| x.is_finite()).ok_or_else(wrong)?;
                    triangles.corners.push(corner.map(f64::from));
                }
                Some("f") => {
                    let face: [usize; 3] = three(words, |k| *k > 0).ok_or_else(wrong)?;
                    triangles.faces.push(face.map(|k| k - 1));
                }
                _ => {}
            }
        }
        triangles.check()?;
        Ok(triangles)
    }

    /// Refuses triangles of corners that do not exist.
    pub(super) fn check(&self) -> Result<(), String> {
        if self.faces.is_empty() {
            return Err("holds no triangle".to_string());
        }
        match self.faces.iter().flatten().find(|k| **k >= self.corners.len()) {
            Some(k) => Err(format!("has a triangle with corner {k}, but there are {}", self.corners.len())),
            None => Ok(()),
        }
    }

    /// The convex hull of the corners.
    pub(super) fn hull(self) -> Result<Self, String> {
        let faces = convex_hull(&self.corners).ok_or("has corners in one plane, which enclose no space")?;
        Ok(Self { faces, ..self })
    }

    /// The mass by a law; the algorithm of MuJoCo, so that its numbers come out where triangles do not
    /// enclose a space, too.
    pub(super) fn mass(&self, law: MeshLaw) -> Result<MeshMass, String> {
        if law == MeshLaw::Convex {
            return self.clone().hull()?.mass(MeshLaw::Exact);
        }
        let middle = self.middle()?;
        let (mut volume, mut center) = (0.0, [0.0; 3]);
        for face in &self.faces {
            let (area, centre, normal) = triangle(face.map(|k| self.corners[k]));
            let over = core::array::from_fn(|i| centre[i] - middle[i]);
            let part = weight(law, area, dot(over, normal));
            volume += part;
            (0..3).for_each(|i| center[i] += part * (centre[i] * 3.0 / 4.0 + middle[i] / 4.0));
        }
        if volume < LEAST {
            let problem =
                if volume < 0.0 { "negative: its triangles are turned inside out" } else { "too small" };
            return Err(format!("encloses a volume that is {problem}"));
        }
        let center = center.map(|x| x / volume);
        Ok(self.about(law, center))
    }

    /// Centre of the surface, weighted by area.
    fn middle(&self) -> Result<[f64; 3], String> {
        let (mut surface, mut middle) = (0.0, [0.0; 3]);
        for face in &self.faces {
            let (area, centre, _) = triangle(face.map(|k| self.corners[k]));
            surface += area;
            (0..3).for_each(|i| middle[i] += area * centre[i]);
        }
        if surface < LEAST {
            return Err("has a surface that is too small".to_string());
        }
        Ok(middle.map(|x| x / surface))
    }

    /// Inertia and volume by the pyramids over the triangles from a centre.
    fn about(&self, law: MeshLaw, center: [f64; 3]) -> MeshMass {
        const PAIRS: [(usize, usize); 6] = [(0, 0), (1, 1), (2, 2), (0, 1), (0, 2), (1, 2)];
        let (mut volume, mut products) = (0.0, [0.0; 6]);
        let divisor = if law == MeshLaw::Shell { 12.0 } else { 20.0 };
        for face in &self.faces {
            let corners = face.map(|k| core::array::from_fn(|i| self.corners[k][i] - center[i]));
            let [d, e, f]: [[f64; 3]; 3] = corners;
            let (area, centre, normal) = triangle(corners);
            let part = weight(law, area, dot(centre, normal));
            volume += part;
            for (product, (i, j)) in products.iter_mut().zip(PAIRS) {
                *product += part / divisor
                    * (2.0 * (d[i] * d[j] + e[i] * e[j] + f[i] * f[j])
                        + d[i] * e[j]
                        + d[j] * e[i]
                        + d[i] * f[j]
                        + d[j] * f[i]
                        + e[i] * f[j]
                        + e[j] * f[i]);
            }
        }
        let [xx, yy, zz, xy, xz, yz] = products;
        MeshMass { volume, center, tensor: [yy + zz, xx + zz, xx + yy, -xy, -xz, -yz] }
    }
}

/// Three numbers that hold a condition.
fn three<'a, T: core::str::FromStr + Copy + Default>(
    mut words: impl Iterator<Item = &'a str>,
    holds: impl Fn(&T) -> bool,
) -> Option<[T; 3]> {
    let mut numbers = [T::default(); 3];
    for number in &mut numbers {
        *number = words.next()?.parse().ok().filter(&holds)?;
    }
    words.next().is_none().then_some(numbers)
}

/// What a triangle adds: its area, or the pyramid over it with this height.
fn weight(law: MeshLaw, area: f64, height: f64) -> f64 {
    match law {
        MeshLaw::Shell => area,
        MeshLaw::Legacy => (height * area / 3.0).abs(),
        MeshLaw::Exact | MeshLaw::Convex => height * area / 3.0,
    }
}

/// Area, centre and unit normal.
fn triangle([a, b, c]: [[f64; 3]; 3]) -> (f64, [f64; 3], [f64; 3]) {
    let to = |p: [f64; 3]| -> [f64; 3] { core::array::from_fn(|i| p[i] - a[i]) };
    let (u, v) = (to(b), to(c));
    let normal = [u[1] * v[2] - u[2] * v[1], u[2] * v[0] - u[0] * v[2], u[0] * v[1] - u[1] * v[0]];
    let length = libm::sqrt(dot(normal, normal));
    let centre = core::array::from_fn(|i| (a[i] + b[i] + c[i]) / 3.0);
    if length < LEAST {
        return (0.0, centre, [1.0, 0.0, 0.0]);
    }
    (0.5 * length, centre, normal.map(|x| x / length))
}

fn dot(a: [f64; 3], b: [f64; 3]) -> f64 {
    a[0] * b[0] + a[1] * b[1] + a[2] * b[2]
}

#[cfg(test)]
mod tests {
    #![allow(clippy::unwrap_used, reason = "a failing test may panic")]
    use super::*;

    /// A box with a corner at the origin.
    fn cuboid(size: [f64; 3]) -> Triangles {
        let corner = |k: usize| core::array::from_fn(|i| if k >> i & 1 == 1 { size[i] } else { 0.0 });
        let sides = [[0, 2, 3, 1], [4, 5, 7, 6], [0, 1, 5, 4], [2, 6, 7, 3], [0, 4, 6, 2], [1, 3, 7, 5]];
        let faces = sides.iter().flat_map(|[a, b, c, d]| [[*a, *b, *c], [*a, *c, *d]]).collect();
        Triangles { corners: (0..8).map(corner).collect(), faces }
    }

    #[test]
    fn a_box_has_the_volume_centre_and_inertia_of_a_box() {
        let [a, b, c] = [0.2, 0.3, 0.5];
        for law in [MeshLaw::Exact, MeshLaw::Legacy] {
            let mass = cuboid([a, b, c]).mass(law).unwrap();
            let volume = a * b * c;
            assert!((mass.volume - volume).abs() < 1e-15);
            let expected = [b * b + c * c, a * a + c * c, a * a + b * b].map(|x| volume * x / 12.0);
            for i in 0..3 {
                assert!((mass.center[i] - 0.5 * [a, b, c][i]).abs() < 1e-14);
                assert!((mass.tensor[i] - expected[i]).abs() < 1e-15 && mass.tensor[3 + i].abs() < 1e-15);
            }
        }
        let shell = cuboid([a, b, c]).mass(MeshLaw::Shell).unwrap();
        assert!((shell.volume - 2.0 * (a * b + b * c + a * c)).abs() < 1e-14);
    }

    #[test]
    fn what_encloses_nothing_is_refused_and_a_hull_needs_no_faces() {
        let mut flat = cuboid([1.0, 1.0, 1.0]);
        flat.corners.iter_mut().for_each(|corner| corner[2] = 0.0);
        assert!(flat.mass(MeshLaw::Exact).unwrap_err().contains("too small"));
        let mut turned = cuboid([1.0, 1.0, 1.0]);
        turned.faces.iter_mut().for_each(|face| face.swap(0, 1));
        assert!(turned.mass(MeshLaw::Exact).unwrap_err().contains("inside out"));
        assert!(turned.mass(MeshLaw::Legacy).is_ok());
        assert!((turned.mass(MeshLaw::Convex).unwrap().volume - 1.0).abs() < 1e-12);
        assert!(flat.mass(MeshLaw::Convex).unwrap_err().contains("one plane"));
    }

    #[test]
    fn text_of_triangles_is_read_and_wrong_lines_are_named() {
        let text = "v 0 0 0\nv 1 0 0\nv 0 1 0\nf 1 2 3\n";
        assert_eq!(Triangles::parse(text).unwrap().faces, [[0, 1, 2]]);
        for (wrong, word) in [
            ("v 0 0\n", "v 0 0"),
            ("v 0 0 0\nf 0 1 1\n", "f 0 1 1"),
            ("f 1 1 1\n", "corner 0"),
            ("", "no triangle"),
        ] {
            assert!(Triangles::parse(wrong).unwrap_err().contains(word), "{wrong}");
        }
    }
}
