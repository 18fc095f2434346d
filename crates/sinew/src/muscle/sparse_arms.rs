use super::geometry::Geometry;
use super::topology::Topology;
use alloc::vec;
use alloc::vec::Vec;

/// Moment arms about the independent joints, muscle by muscle, without those that vanish in every pose:
/// compressed sparse rows.
///
/// ```text
/// R_mj = sum_v R_mv dv/du_j      over the velocities v that muscle m crosses
/// ```
#[derive(Debug, Clone)]
pub(super) struct SparseArms {
    /// First entry of every muscle, and the end of the last.
    start: Vec<usize>,
    /// Independent joint and moment arm, m, of every entry.
    joints: Vec<usize>,
    arms: Vec<f64>,
    terms: Vec<Term>,
}

/// A moment arm of the geometry, its velocity, and the entry that it is a term of.
#[derive(Debug, Clone, Copy)]
struct Term {
    slot: usize,
    velocity: usize,
    entry: usize,
}

impl SparseArms {
    /// `leader` is the independent joint that a velocity follows, or is.
    pub(super) fn new(topology: &Topology, leader: impl Fn(usize) -> Option<usize>) -> Self {
        let (mut start, mut joints, mut terms) = (vec![0], Vec::new(), Vec::new());
        for cable in &topology.cables {
            let first = joints.len();
            for slot in cable.slots.clone() {
                let velocity = topology.columns[slot];
                let Some(joint) = leader(velocity) else { continue };
                let known = joints[first..].iter().position(|other| *other == joint);
                let entry = first + known.unwrap_or(joints.len() - first);
                if entry == joints.len() {
                    joints.push(joint);
                }
                terms.push(Term { slot, velocity, entry });
            }
            start.push(joints.len());
        }
        Self { start, arms: vec![0.0; joints.len()], joints, terms }
    }

    /// Takes the moment arms of a pose with the slope `dv/du` of every velocity.
    pub(super) fn gather(&mut self, geometry: &Geometry, slope: impl Fn(usize) -> f64) {
        self.arms.fill(0.0);
        for &Term { slot, velocity, entry } in &self.terms {
            self.arms[entry] += slope(velocity) * geometry.arms[slot][0];
        }
    }

    /// Every joint that a muscle crosses, with its moment arm, m.
    #[inline]
    pub(super) fn row(&self, muscle: usize) -> impl Iterator<Item = (usize, f64)> + Clone {
        let entries = self.start[muscle]..self.start[muscle + 1];
        self.joints[entries.clone()].iter().copied().zip(self.arms[entries].iter().copied())
    }

    /// Writes the entries into a whole matrix, `[muscles x joints]`, whose others are zero already.
    pub(super) fn spread(&self, dense: &mut [f64], joints: usize) {
        for (muscle, row) in dense.chunks_exact_mut(joints.max(1)).enumerate() {
            self.row(muscle).for_each(|(joint, arm)| row[joint] = arm);
        }
    }
}
