//! The path of a cable, and its discretisation into cells and nodes.

use crate::error::{Error, non_negative, positive, within};
use alloc::vec;
use alloc::vec::Vec;
use serde::{Deserialize, Serialize};

/// Most cells a cable may be cut into.
pub(super) const MAX_CELLS: usize = 1024;

/// One segment of the path from the drive's outlet to the anchor.
#[derive(Debug, Clone, PartialEq, Serialize, Deserialize)]
#[serde(rename_all = "snake_case", deny_unknown_fields)]
pub enum Segment {
    /// Free cable.
    Free {
        /// Length, m, > 0.
        #[serde(rename = "length_m")]
        length: f64,
    },
    /// Cable inside a bent sheath.
    Sheath {
        /// Length, m, > 0.
        #[serde(rename = "length_m")]
        length: f64,
        /// Sum of the magnitudes of its bends, rad, >= 0.
        #[serde(rename = "bend_rad")]
        bend: f64,
        /// Relative curvature of equal parts of its length, each >= 0, not all zero; empty for an even bend.
        #[serde(default, skip_serializing_if = "Vec::is_empty")]
        curvature: Vec<f64>,
    },
    /// A fixed surface or a pulley without length, over which the cable slides.
    Pulley {
        /// Wrap angle, rad, >= 0; it may change with a joint from step to step.
        #[serde(rename = "wrap_rad")]
        wrap: f64,
    },
}

/// The path of a cable from the drive's outlet to the anchor: any number of sheaths and pulleys in series.
///
/// ```text
/// winch --[free]--(node)--[sheath cell]--(node)-- ... --(node: pulley)--[free]-- anchor
/// ```
///
/// Friction sits at the nodes, elasticity in the cells between them. A free length is one cell. A sheath
/// of `n` cells has its bend at `n + 1` nodes, that of half a cell at each end of it (midpoint rule: the
/// stretch is exact to `(mu phi/n)^2/24`). Segments that meet share a node.
///
/// # Example
/// ```
/// use sinew::transmission::cable::{CablePath, Segment};
/// let path = CablePath::new(vec![
///     Segment::Free { length: 0.2 },
///     Segment::Sheath { length: 0.8, bend: 4.7, curvature: vec![] },
///     Segment::Pulley { wrap: 1.5 },
///     Segment::Free { length: 0.7 },
/// ])?;
/// assert_eq!(path.fewest_cells(), 3);
/// assert!((path.length() - 1.7).abs() < 1e-12 && (path.angle() - 6.2).abs() < 1e-12);
/// # Ok::<(), sinew::Error>(())
/// ```
#[derive(Debug, Clone, PartialEq, Serialize, Deserialize)]
#[serde(try_from = "Vec<Segment>", into = "Vec<Segment>")]
pub struct CablePath {
    segments: Vec<Segment>,
}

impl CablePath {
    /// A path of checked segments.
    ///
    /// # Errors
    /// [`Error::OutOfDomain`] names the quantity outside its domain: a length not above zero, a negative
    /// angle, a first or last segment that is not free cable, a path without anything to slide over.
    pub fn new(segments: Vec<Segment>) -> Result<Self, Error> {
        for segment in &segments {
            check(segment)?;
        }
        let free = |segment: Option<&Segment>| matches!(segment, Some(Segment::Free { .. }));
        let ends = free(segments.first()) && free(segments.last());
        let count = segments.len() as f64;
        within("segments", "a list that begins and ends with free cable", count, ends)?;
        let path = Self { segments };
        let nodes = path.fewest_cells() - 1;
        within("nodes", "at least one sheath or pulley between free lengths", nodes as f64, nodes > 0)?;
        Ok(path)
    }

    /// The bench of `yuan2023`: 1.667 m in all, 0.806 m of it sheath; angles and free lengths as calibrated.
    ///
    /// Only `mu phi` in sum and the near fraction of the free length (0.19 +- 0.05) are identified by the
    /// tables; three quarters of a turn in the sheath and a quarter over the pulley are a choice.
    #[must_use]
    pub fn bench() -> Self {
        use core::f64::consts::{FRAC_PI_2, PI};
        let sheath = Segment::Sheath { length: 0.806, bend: 1.5 * PI, curvature: vec![] };
        let (near, far) = (Segment::Free { length: 0.166 }, Segment::Free { length: 0.695 });
        Self { segments: vec![near, sheath, Segment::Pulley { wrap: FRAC_PI_2 }, far] }
    }

    /// The segments, from the drive's outlet to the anchor.
    #[must_use]
    pub fn segments(&self) -> &[Segment] {
        &self.segments
    }

    /// Length of the cable, m.
    #[must_use]
    pub fn length(&self) -> f64 {
        self.segments.iter().map(|segment| length_and_angle(segment).0).sum()
    }

    /// Sum of all bends and wraps, rad.
    #[must_use]
    pub fn angle(&self) -> f64 {
        self.segments.iter().map(|segment| length_and_angle(segment).1).sum()
    }

    /// Sum of the bends of all sheaths, rad.
    #[must_use]
    pub fn sheath_bend(&self) -> f64 {
        self.sheaths().map(|(_, bend)| bend).sum()
    }

    /// Number of pulleys.
    #[must_use]
    pub fn pulleys(&self) -> usize {
        self.segments.iter().filter(|segment| matches!(segment, Segment::Pulley { .. })).count()
    }

    /// Fewest cells that represent this path: one per free length and per sheath.
    #[must_use]
    pub fn fewest_cells(&self) -> usize {
        Layout::new(self, &vec![1; self.sheaths().count()]).cells.len()
    }

    fn sheaths(&self) -> impl Iterator<Item = (f64, f64)> {
        self.segments.iter().filter_map(|segment| match segment {
            Segment::Sheath { length, bend, .. } => Some((*length, *bend)),
            _ => None,
        })
    }

    /// Cells and nodes, `cells` in all; each further cell goes to the sheath with the largest bend per cell.
    ///
    /// # Errors
    /// [`Error::OutOfDomain`] where there are too few cells for the segments, or more than 1024.
    pub(super) fn layout(&self, cells: usize) -> Result<Layout, Error> {
        let least = self.fewest_cells();
        let expected = "at least one for every free length and sheath of the path, and at most 1024";
        within("cells", expected, cells as f64, (least..=MAX_CELLS).contains(&cells))?;
        let sheaths: Vec<f64> = self.sheaths().map(|(length, bend)| bend.max(1e-6 * length)).collect();
        let exact = "as many as the free lengths of the path, which has no sheath that more would divide";
        within("cells", exact, cells as f64, cells == least || !sheaths.is_empty())?;
        let mut counts = vec![1; sheaths.len()];
        for _ in least..cells {
            let per_cell = |k: &usize| sheaths[*k] / counts[*k] as f64;
            let fullest = (0..sheaths.len()).rev().max_by(|a, b| per_cell(a).total_cmp(&per_cell(b)));
            counts[fullest.unwrap_or(0)] += 1;
        }
        Ok(Layout::new(self, &counts))
    }
}

impl TryFrom<Vec<Segment>> for CablePath {
    type Error = Error;

    fn try_from(segments: Vec<Segment>) -> Result<Self, Error> {
        Self::new(segments)
    }
}

impl From<CablePath> for Vec<Segment> {
    fn from(path: CablePath) -> Self {
        path.segments
    }
}

fn check(segment: &Segment) -> Result<(), Error> {
    match segment {
        Segment::Free { length } => {
            positive("free length", *length)?;
        }
        Segment::Sheath { length, bend, curvature } => {
            positive("sheath length", *length)?;
            non_negative("sheath bend", *bend)?;
            for part in curvature {
                non_negative("sheath curvature", *part)?;
            }
            let sum: f64 = curvature.iter().sum();
            let some = curvature.is_empty() || (sum > 0.0 && sum.is_finite());
            within("sum of sheath curvature", "a finite number > 0", sum, some)?;
        }
        Segment::Pulley { wrap } => {
            non_negative("pulley wrap", *wrap)?;
        }
    }
    Ok(())
}

fn length_and_angle(segment: &Segment) -> (f64, f64) {
    match segment {
        Segment::Free { length } => (*length, 0.0),
        Segment::Sheath { length, bend, .. } => (*length, *bend),
        Segment::Pulley { wrap } => (0.0, *wrap),
    }
}

/// An elastic piece of cable.
#[derive(Debug, Clone, Copy, PartialEq)]
pub(super) struct CellPlace {
    pub(super) length: f64,
    pub(super) sheathed: bool,
}

/// A point at which the cable slides over a sheath or a pulley.
#[derive(Debug, Clone, Copy, PartialEq, Default)]
pub(super) struct NodePlace {
    /// Bend of sheaths, rad.
    pub(super) bend: f64,
    /// Wrap of pulleys as built, rad.
    pub(super) wrap: f64,
    /// Sheathed length that this node stands for, m.
    pub(super) sheathed: f64,
}

/// A path cut into cells: `nodes[i]` sits between `cells[i]` and `cells[i + 1]`.
#[derive(Debug, Clone, PartialEq, Default)]
pub(super) struct Layout {
    pub(super) cells: Vec<CellPlace>,
    pub(super) nodes: Vec<NodePlace>,
    /// Node and wrap of every pulley, in the order of the path.
    pub(super) pulleys: Vec<(usize, f64)>,
    /// Friction collected since the last cell.
    pending: Option<NodePlace>,
}

impl Layout {
    fn new(path: &CablePath, counts: &[usize]) -> Self {
        let mut layout = Self::default();
        let mut counts = counts.iter();
        for segment in &path.segments {
            match segment {
                Segment::Free { length } => layout.cell(*length, false),
                Segment::Sheath { length, bend, curvature } => {
                    layout.sheath(*length, *bend, curvature, *counts.next().unwrap_or(&1));
                }
                Segment::Pulley { wrap } => {
                    // The node that is being collected sits after the last cell.
                    layout.pulleys.push((layout.cells.len().saturating_sub(1), *wrap));
                    layout.pending.get_or_insert_default().wrap += wrap;
                }
            }
        }
        layout
    }

    fn cell(&mut self, length: f64, sheathed: bool) {
        match (self.pending.take(), self.cells.last_mut()) {
            // Free cable after free cable is one free cable.
            (None, Some(last)) => last.length += length,
            (node, last) => {
                if last.is_some() {
                    self.nodes.push(node.unwrap_or_default());
                }
                self.cells.push(CellPlace { length, sheathed });
            }
        }
    }

    fn sheath(&mut self, length: f64, bend: f64, curvature: &[f64], cells: usize) {
        let n = cells as f64;
        for node in 0..=cells {
            let low = ((node as f64 - 0.5) / n).max(0.0);
            let high = ((node as f64 + 0.5) / n).min(1.0);
            let place = self.pending.get_or_insert_default();
            place.bend += bend * (bend_fraction(curvature, high) - bend_fraction(curvature, low));
            place.sheathed += length * (high - low);
            if node < cells {
                self.cell(length / n, true);
            }
        }
    }
}

/// Fraction of the whole bend that lies before the fraction `x` of the length.
fn bend_fraction(curvature: &[f64], x: f64) -> f64 {
    if curvature.is_empty() {
        return x;
    }
    let total: f64 = curvature.iter().sum();
    let place = x * curvature.len() as f64;
    let before = |(k, part): (usize, &f64)| part * (place - k as f64).clamp(0.0, 1.0);
    curvature.iter().enumerate().map(before).sum::<f64>() / total
}

#[cfg(test)]
mod tests {
    use super::*;

    fn free(length: f64) -> Segment {
        Segment::Free { length }
    }

    fn sheath(length: f64, bend: f64, curvature: &[f64]) -> Segment {
        Segment::Sheath { length, bend, curvature: curvature.to_vec() }
    }

    #[test]
    fn every_discretisation_preserves_lengths_and_angles() {
        let path = CablePath::new(vec![
            free(0.1),
            sheath(0.5, 2.0, &[1.0, 3.0, 0.0]),
            Segment::Pulley { wrap: 0.4 },
            Segment::Pulley { wrap: 0.3 },
            sheath(0.3, 1.0, &[]),
            free(0.05),
            free(0.05),
            Segment::Pulley { wrap: 0.7 },
            free(0.2),
        ])
        .unwrap();
        assert_eq!((path.fewest_cells(), path.pulleys()), (5, 3));
        for cells in [5, 6, 9, 40, 200] {
            let layout = path.layout(cells).unwrap();
            assert_eq!((layout.cells.len(), layout.nodes.len()), (cells, cells - 1));
            let length: f64 = layout.cells.iter().map(|cell| cell.length).sum();
            let angle: f64 = layout.nodes.iter().map(|node| node.bend + node.wrap).sum();
            let sheathed: f64 = layout.nodes.iter().map(|node| node.sheathed).sum();
            assert!((length - path.length()).abs() < 1e-12 && (angle - path.angle()).abs() < 1e-12);
            assert!((sheathed - 0.8).abs() < 1e-12);
            for (node, wrap) in &layout.pulleys {
                assert!(layout.nodes[*node].wrap >= *wrap);
            }
            assert_eq!(layout.pulleys[0].0, layout.pulleys[1].0);
            assert_eq!(layout.pulleys[2].0, cells - 2);
        }
    }

    #[test]
    fn an_uneven_bend_follows_its_curvature_profile() {
        let path = CablePath::new(vec![free(0.1), sheath(1.0, 2.0, &[0.0, 1.0]), free(0.1)]).unwrap();
        let layout = path.layout(12).unwrap();
        let (near, far) = layout.nodes.split_at(5);
        assert!(near.iter().all(|node| node.bend.abs() < 1e-12));
        assert!((far[1..5].iter().map(|node| node.bend).sum::<f64>() - 1.6).abs() < 1e-12);
    }

    /// Cells in the sheaths `(length, bend)`, a pulley's free length between any two of them.
    fn cells_of(sheaths: &[(f64, f64)], cells: usize) -> Vec<usize> {
        let mut segments = vec![free(0.1)];
        for (length, bend) in sheaths {
            segments.extend([sheath(*length, *bend, &[]), free(0.1)]);
        }
        let layout = CablePath::new(segments).unwrap().layout(cells).unwrap();
        let parts = layout.cells.split(|cell| !cell.sheathed).map(<[CellPlace]>::len);
        parts.filter(|count| *count > 0).collect()
    }

    #[test]
    fn cells_are_spread_so_that_the_largest_bend_of_one_is_least() {
        // Bends as the number of cells: each bears the same.
        assert_eq!(cells_of(&[(0.3, 2.0), (0.9, 5.0), (0.2, 3.0)], 14), [2, 5, 3]);
        for (bends, cells) in [([2.0, 5.0, 3.1], 17), ([0.4, 0.1, 6.0], 30), ([1.0, 1.0, 1.1], 9)] {
            let counts = cells_of(&bends.map(|bend| (0.3, bend)), cells);
            let most = |counts: [usize; 3]| (0..3).map(|k| bends[k] / counts[k] as f64).fold(0.0, f64::max);
            let all = cells - 4;
            assert_eq!(counts.iter().sum::<usize>(), all);
            let ways = (1..all).flat_map(|a| (1..all - a).map(move |b| [a, b, all - a - b]));
            let least = ways.map(most).fold(f64::INFINITY, f64::min);
            assert!((most([counts[0], counts[1], counts[2]]) - least).abs() < 1e-15, "{counts:?}");
        }
    }

    #[test]
    fn straight_sheaths_share_cells_by_length_and_leave_them_to_a_bent_one() {
        assert_eq!(cells_of(&[(0.1, 0.0), (0.4, 0.0), (0.2, 0.0)], 11), [1, 4, 2]);
        assert_eq!(cells_of(&[(5.0, 0.0), (0.1, 0.5)], 12), [1, 8]);
    }

    #[test]
    fn an_invalid_path_is_refused_by_name() {
        let named = |segments: Vec<Segment>, name: &str| {
            let message = std::string::ToString::to_string(&CablePath::new(segments).unwrap_err());
            assert!(message.contains(name), "{message}");
        };
        named(vec![], "segments");
        named(vec![free(1.0)], "nodes");
        named(vec![free(1.0), free(1.0)], "nodes");
        named(vec![sheath(1.0, 1.0, &[]), free(1.0)], "segments");
        named(vec![free(0.0), sheath(1.0, 1.0, &[]), free(1.0)], "free length");
        named(vec![free(1.0), sheath(f64::NAN, 1.0, &[]), free(1.0)], "sheath length");
        named(vec![free(1.0), sheath(1.0, -1.0, &[]), free(1.0)], "sheath bend");
        named(vec![free(1.0), sheath(1.0, 1.0, &[0.0, 0.0]), free(1.0)], "curvature");
        named(vec![free(1.0), sheath(1.0, 1.0, &[1.0, -1.0]), free(1.0)], "curvature");
        named(vec![free(1.0), Segment::Pulley { wrap: f64::INFINITY }, free(1.0)], "pulley wrap");
        let path = CablePath::bench();
        assert!(path.layout(2).is_err() && path.layout(3).is_ok() && path.layout(2000).is_err());
        let pulley = CablePath::new(vec![free(1.0), Segment::Pulley { wrap: 1.0 }, free(1.0)]).unwrap();
        assert!(pulley.layout(2).is_ok() && pulley.layout(3).is_err());
    }
}
