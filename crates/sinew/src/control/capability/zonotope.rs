//! Facets and vertices of a zonotope `{ sum_k x_k g_k, -1 <= x_k <= 1 }` by enumeration of its generators.

use super::linear::{determinant, null_vector, plane_basis};
use alloc::vec;
use alloc::vec::Vec;

/// Generators on one side of a plane through the origin: bits of those with a positive and of those with a negative
/// component along its normal; those with neither lie in the plane.
#[derive(Debug, Clone, Copy, PartialEq, Eq, PartialOrd, Ord)]
pub(super) struct Sides {
    pub(super) plus: u128,
    pub(super) minus: u128,
}

impl Sides {
    fn opposite(self) -> Self {
        Self { plus: self.minus, minus: self.plus }
    }
}

/// Largest component of a generator's direction along a unit normal in whose plane it lies.
const IN_PLANE: f64 = 1e-10;

/// A set of generators in a space of some dimension, with the bits by which they are known.
#[derive(Debug, Clone)]
pub(super) struct Generators {
    dimension: usize,
    /// One after the other.
    vectors: Vec<f64>,
    /// The same of unit length.
    directions: Vec<f64>,
    bits: Vec<u32>,
}

/// Unit normals of planes, and what lies on either side of them.
#[derive(Debug, Clone, Default)]
pub(super) struct Planes {
    dimension: usize,
    normals: Vec<f64>,
    sides: Vec<Sides>,
}

impl Planes {
    /// Every plane once.
    fn once(self) -> Self {
        let mut order: Vec<usize> = (0..self.sides.len()).collect();
        order.sort_unstable_by_key(|&k| (self.sides[k], k));
        order.dedup_by_key(|k| self.sides[*k]);
        if order.len() == self.sides.len() {
            return self;
        }
        let n = self.dimension;
        Self {
            dimension: n,
            normals: order.iter().flat_map(|&k| &self.normals[k * n..(k + 1) * n]).copied().collect(),
            sides: order.iter().map(|&k| self.sides[k]).collect(),
        }
    }

    /// Whether one of them holds all generators, or too few generators span none.
    pub(super) fn are_of_flat_set(&self) -> bool {
        self.sides.iter().all(|sides| sides.plus == 0 && sides.minus == 0)
    }

    pub(super) fn iter(&self) -> impl Iterator<Item = (&[f64], Sides)> {
        self.normals.chunks_exact(self.dimension.max(1)).zip(self.sides.iter().copied())
    }
}

impl Generators {
    /// Generators of length zero are left out.
    pub(super) fn new(vectors: &[f64], dimension: usize) -> Self {
        let bits = 0..vectors.len() as u32;
        Self::with_bits(vectors.chunks_exact(dimension.max(1)).zip(bits), dimension)
    }

    fn with_bits<'a>(vectors: impl Iterator<Item = (&'a [f64], u32)>, dimension: usize) -> Self {
        let mut kept = Self { dimension, vectors: Vec::new(), directions: Vec::new(), bits: Vec::new() };
        for (vector, bit) in vectors {
            let length = libm::sqrt(vector.iter().map(|x| x * x).sum());
            if length > 0.0 {
                kept.vectors.extend_from_slice(vector);
                kept.directions.extend(vector.iter().map(|x| x / length));
                kept.bits.push(bit);
            }
        }
        kept
    }

    fn vector(&self, k: usize) -> &[f64] {
        &self.vectors[k * self.dimension..(k + 1) * self.dimension]
    }

    fn direction(&self, k: usize) -> &[f64] {
        &self.directions[k * self.dimension..(k + 1) * self.dimension]
    }

    /// All planes that are spanned by generators, once each; opposite facets of the zonotope share one.
    pub(super) fn planes(&self) -> Planes {
        let (count, n) = (self.bits.len(), self.dimension);
        let needed = n.saturating_sub(1);
        let mut found = Planes { dimension: n, ..Planes::default() };
        let mut chosen: Vec<usize> = (0..needed).collect();
        let (mut space, mut columns, mut normal) = (vec![0.0; needed * n], vec![0; n], vec![0.0; n]);
        while chosen.last().is_none_or(|last| *last < count) {
            for (row, &k) in space.chunks_exact_mut(n).zip(&chosen) {
                row.copy_from_slice(self.direction(k));
            }
            if null_vector(&mut space, &mut columns, &mut normal) {
                let sides = self.sides(&normal);
                let flip = sides.opposite() < sides;
                found.sides.push(if flip { sides.opposite() } else { sides });
                found.normals.extend(normal.iter().map(|x| if flip { -x } else { *x }));
            }
            if !next_combination(&mut chosen, count) {
                break;
            }
        }
        found.once()
    }

    fn sides(&self, normal: &[f64]) -> Sides {
        let mut sides = Sides { plus: 0, minus: 0 };
        for (direction, bit) in self.directions.chunks_exact(self.dimension).zip(&self.bits) {
            let along: f64 = direction.iter().zip(normal).map(|(a, b)| a * b).sum();
            if along > IN_PLANE {
                sides.plus |= 1 << bit;
            } else if along < -IN_PLANE {
                sides.minus |= 1 << bit;
            }
        }
        sides
    }

    /// The vertices, each by the bits of the generators that enter it with `+1`; `planes` are the set's own.
    pub(super) fn vertices(&self, planes: &Planes) -> Vec<u128> {
        let all = self.bits.iter().fold(0, |all, bit| all | 1_u128 << bit);
        let mut found = Vec::new();
        self.half_of_vertices(planes, &mut found);
        // With a vertex its opposite is one.
        found.iter_mut().for_each(|vertex| *vertex = (*vertex).min(all ^ *vertex));
        found.sort_unstable();
        found.dedup();
        let opposite: Vec<u128> = found.iter().map(|vertex| all ^ vertex).collect();
        found.extend(opposite);
        found
    }

    /// Adds at least one of each pair of opposite vertices: those of one facet per plane.
    fn half_of_vertices(&self, planes: &Planes, found: &mut Vec<u128>) {
        for (normal, sides) in planes.iter() {
            let outside = sides.plus | sides.minus;
            let within = self.bits.iter().fold(0, |all, bit| all | 1_u128 << bit) & !outside;
            if within.count_ones() as usize + 1 == self.dimension {
                // Independent generators: every combination of signs is a vertex.
                let mut subset = within;
                loop {
                    found.push(sides.plus | subset);
                    if subset == 0 {
                        break;
                    }
                    subset = (subset - 1) & within;
                }
            } else if within != 0 {
                let facet = self.within_plane(normal, outside);
                let vertices = facet.vertices(&facet.planes());
                found.extend(vertices.into_iter().map(|vertex| sides.plus | vertex));
            }
        }
    }

    /// The generators within a plane, in coordinates of the plane.
    fn within_plane(&self, normal: &[f64], outside: u128) -> Self {
        let basis = plane_basis(normal);
        let rows: Vec<usize> = (0..self.bits.len()).filter(|&k| outside & (1 << self.bits[k]) == 0).collect();
        let coordinates: Vec<f64> = rows
            .iter()
            .flat_map(|&k| {
                let along =
                    move |axis: &[f64]| axis.iter().zip(self.vector(k)).map(|(a, b)| a * b).sum::<f64>();
                basis.chunks_exact(self.dimension).map(along)
            })
            .collect();
        let dimension = self.dimension - 1;
        let bits = rows.iter().map(|&k| self.bits[k]);
        Self::with_bits(coordinates.chunks_exact(dimension.max(1)).zip(bits), dimension)
    }

    /// `sum |det|` over all sets of as many generators as dimensions.
    pub(super) fn determinants(&self) -> f64 {
        let count = self.bits.len();
        let mut chosen: Vec<usize> = (0..self.dimension).collect();
        let (mut sum, mut matrix) = (0.0, Vec::new());
        while chosen.last().is_none_or(|last| *last < count) {
            matrix.clear();
            chosen.iter().for_each(|&k| matrix.extend_from_slice(self.vector(k)));
            sum += determinant(&mut matrix, self.dimension).abs();
            if !next_combination(&mut chosen, count) {
                break;
            }
        }
        sum
    }
}

/// The next set of indices below `count` in lexicographic order; `false` after the last one.
fn next_combination(chosen: &mut [usize], count: usize) -> bool {
    let k = chosen.len();
    for i in (0..k).rev() {
        if chosen[i] + k - i < count {
            chosen[i] += 1;
            for j in i + 1..k {
                chosen[j] = chosen[j - 1] + 1;
            }
            return true;
        }
    }
    false
}

#[cfg(test)]
mod tests {
    use super::*;

    #[test]
    fn every_set_of_indices_comes_once() {
        for count in 1..8 {
            let mut binomial = 1;
            for k in 1..=count {
                binomial = binomial * (count + 1 - k) / k;
                let mut chosen: Vec<usize> = (0..k).collect();
                let mut sets = vec![chosen.clone()];
                while next_combination(&mut chosen, count) {
                    sets.push(chosen.clone());
                }
                assert_eq!(sets.len(), binomial, "{k} of {count}");
                assert!(sets.iter().all(|set| set.is_sorted_by(|a, b| a < b) && set[k - 1] < count));
                assert!(sets.is_sorted_by(|a, b| a < b));
            }
        }
    }
}
