//! Fewer triangles for a surface, by clustering its corners in the cells of a grid (Rossignac and Borrel
//! 1993): also for surfaces with holes, doubled faces or loose triangles, as files of robots often are.

use sinew::body::TriangleSurface;
use std::collections::{HashMap, HashSet};

/// Cells along the longest side of a surface, at most.
const FINEST: u32 = 1024;

/// At most `most` triangles of a surface, but at least what two cells along its longest side leave.
pub(crate) fn reduced(surface: TriangleSurface, most: usize) -> TriangleSurface {
    if surface.triangles.len() <= most {
        return surface;
    }
    // The number of triangles grows with that of cells, but for single steps.
    let (mut coarse, mut fine) = (2, FINEST);
    let mut best = clustered(&surface, coarse);
    while fine - coarse > 1 {
        let middle = coarse.midpoint(fine);
        let found = clustered(&surface, middle);
        if found.triangles.len() <= most {
            (coarse, best) = (middle, found);
        } else {
            fine = middle;
        }
    }
    best
}

/// All corners in a cell become their mean; triangles that lose a corner vanish.
fn clustered(surface: &TriangleSurface, cells: u32) -> TriangleSurface {
    let mut low = [f32::INFINITY; 3];
    let mut high = [f32::NEG_INFINITY; 3];
    for corner in &surface.vertices {
        for k in 0..3 {
            (low[k], high[k]) = (low[k].min(corner[k]), high[k].max(corner[k]));
        }
    }
    let longest = (0..3).map(|k| high[k] - low[k]).fold(0.0, f32::max).max(f32::MIN_POSITIVE);
    let (mut places, mut sums) = (HashMap::new(), Vec::<([f64; 3], f64)>::new());
    let mut cell_of = Vec::with_capacity(surface.vertices.len());
    for corner in &surface.vertices {
        let fraction = |k: usize| (corner[k] - low[k]) / longest;
        let cell: [u32; 3] = std::array::from_fn(|k| ((fraction(k) * cells as f32) as u32).min(cells - 1));
        let place = *places.entry(cell).or_insert_with(|| {
            sums.push(([0.0; 3], 0.0));
            sums.len() as u32 - 1
        });
        let (sum, count) = &mut sums[place as usize];
        (0..3).for_each(|k| sum[k] += f64::from(corner[k]));
        *count += 1.0;
        cell_of.push(place);
    }
    let mut seen = HashSet::new();
    let mut triangles = Vec::new();
    for triangle in &surface.triangles {
        let [a, b, c] = triangle.map(|k| cell_of[k as usize]);
        let mut sorted = [a, b, c];
        sorted.sort_unstable();
        if a != b && b != c && c != a && seen.insert(sorted) {
            triangles.push([a, b, c]);
        }
    }
    // Corners that no triangle is left with are left out.
    let mut kept: HashMap<u32, u32> = HashMap::new();
    let mut vertices = Vec::new();
    for corner in triangles.iter_mut().flatten() {
        *corner = *kept.entry(*corner).or_insert_with(|| {
            let (sum, count) = sums[*corner as usize];
            vertices.push(sum.map(|x| (x / count) as f32));
            vertices.len() as u32 - 1
        });
    }
    TriangleSurface { vertices, triangles }
}

#[cfg(test)]
mod tests {
    use super::*;

    /// A sphere of radius 1 with `2 n^2` triangles and some more.
    fn sphere(n: u32) -> TriangleSurface {
        let at = |i: u32, k: u32| {
            let (u, v) = (
                std::f32::consts::PI * i as f32 / n as f32,
                std::f32::consts::TAU * (k % n) as f32 / n as f32,
            );
            [u.sin() * v.cos(), u.sin() * v.sin(), u.cos()]
        };
        let vertices = (0..=n).flat_map(|i| (0..n).map(move |k| at(i, k))).collect();
        let place = |i: u32, k: u32| i * n + k % n;
        let triangles = (0..n).flat_map(|i| {
            (0..n).flat_map(move |k| {
                [
                    [place(i, k), place(i + 1, k), place(i, k + 1)],
                    [place(i + 1, k), place(i + 1, k + 1), place(i, k + 1)],
                ]
            })
        });
        TriangleSurface { vertices, triangles: triangles.collect() }
    }

    #[test]
    fn a_reduced_sphere_is_still_one_and_has_no_more_triangles_than_asked_for() {
        let whole = sphere(90);
        for most in [50, 200, 1000, 5000, 16_000] {
            let found = reduced(whole.clone(), most);
            assert!(found.triangles.len() <= most, "{most}: {}", found.triangles.len());
            assert!(found.triangles.len() * 5 > most * 2, "{most}: {}", found.triangles.len());
            for corner in &found.vertices {
                let radius = corner.iter().map(|x| x * x).sum::<f32>().sqrt();
                assert!((0.75..1.001).contains(&radius), "{most}: {radius}");
            }
            let corners = found.vertices.len() as u32;
            assert!(found.triangles.iter().flatten().all(|k| *k < corners));
        }
        assert_eq!(reduced(whole.clone(), 1_000_000), whole);
    }

    #[test]
    fn surfaces_without_extent_are_reduced_to_little() {
        let flat = TriangleSurface {
            vertices: vec![[1.0; 3]; 30],
            triangles: (0..10).map(|k| [3 * k, 3 * k + 1, 3 * k + 2]).collect(),
        };
        assert!(reduced(flat, 5).triangles.is_empty());
    }
}
