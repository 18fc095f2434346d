//! Error indices by the direction of the strokes.

use sinew_lab::reproduce::{Indices, Sides};

/// Directions of the strokes, seen from the muscle.
pub(super) const MUSCLES: [&str; 2] = ["active", "passive"];

pub(super) fn largest(row: &[f64; 6]) -> f64 {
    row.iter().copied().fold(f64::NAN, f64::max)
}

pub(super) fn sides(indices: &Sides<Indices>) -> [&Indices; 2] {
    [&indices.active, &indices.passive]
}
