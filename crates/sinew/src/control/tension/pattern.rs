//! Which muscles cross which joints, and the groups of joints that share no muscle.

use super::problem::is_nonzero;
use alloc::vec::Vec;
use core::ops::Range;

/// Joints coupled by common muscles and by no others, and these muscles, as ranges of [`Pattern`]'s order.
#[derive(Debug, Clone, Default)]
pub(super) struct Group {
    pub(super) muscles: Range<usize>,
    pub(super) joints: Range<usize>,
    /// Whether every arm is stored, zero or not.
    pub(super) dense: bool,
    /// Multiplications in a Newton step, about: Newton matrix, its factors, line search.
    pub(super) operations: u64,
}

/// A group of at most so many joints, or with at least so large a fraction of arms that are not zero, stores
/// every arm.
const SMALL: usize = 8;
const DENSE: f64 = 0.3;

/// The places of the moment arms that are not zero, group by group.
///
/// A robot arm of seven joints is as a rule several small problems, not one large one.
#[derive(Debug, Clone)]
pub(super) struct Pattern {
    /// Muscle and joint at each place.
    pub(super) muscles: Vec<usize>,
    pub(super) joints: Vec<usize>,
    groups: Vec<Group>,
    group_count: usize,
    /// First entry of each muscle, and the end of the last.
    pub(super) start: Vec<usize>,
    /// Joint of each entry, counted within the group.
    pub(super) column: Vec<usize>,
    /// Place of each entry in the problem's matrix.
    source: Vec<usize>,
    /// First joint of each joint's and of each muscle's group; the number of joints for muscles that cross
    /// none.
    joint_group: Vec<usize>,
    muscle_group: Vec<usize>,
}

impl Pattern {
    /// Room for a pattern; it holds no group yet.
    pub(super) fn new(muscles: usize, joints: usize) -> Self {
        let zeros = |count: usize| alloc::vec![0; count];
        Self {
            muscles: (0..muscles).collect(),
            joints: (0..joints).collect(),
            groups: alloc::vec![Group::default(); joints + 1],
            group_count: 0,
            start: zeros(muscles + 1),
            column: zeros(muscles * joints),
            source: zeros(muscles * joints),
            joint_group: zeros(joints),
            muscle_group: zeros(muscles),
        }
    }

    /// None before [`find`](Self::find).
    pub(super) fn groups(&self) -> &[Group] {
        &self.groups[..self.group_count]
    }

    /// Drops the groups.
    pub(super) fn clear(&mut self) {
        self.group_count = 0;
    }

    /// Place of each entry in the problem's matrix.
    pub(super) fn source(&self) -> &[usize] {
        &self.source[..self.start[self.muscles.len()]]
    }

    /// Finds the groups of `arms`, muscles x joints.
    pub(super) fn find(&mut self, arms: &[f64]) {
        let n = self.joints.len();
        self.join_joints(arms);
        self.muscles.sort_unstable_by_key(|&muscle| (self.muscle_group[muscle], muscle));
        self.joints.sort_unstable_by_key(|&joint| (self.joint_group[joint], joint));
        self.group_count = 0;
        for first in 0..=n {
            let range = |list: &[usize], group: &[usize]| {
                let start = list.partition_point(|&k| group[k] < first);
                start..start + list[start..].partition_point(|&k| group[k] == first)
            };
            let muscles = range(&self.muscles, &self.muscle_group);
            let joints = range(&self.joints, &self.joint_group);
            if !muscles.is_empty() || !joints.is_empty() {
                self.groups[self.group_count] = self.list_entries(muscles, joints, arms);
                self.group_count += 1;
            }
        }
    }

    /// Joints that a muscle crosses together get one group.
    fn join_joints(&mut self, arms: &[f64]) {
        let n = self.joints.len();
        (0..n).for_each(|joint| self.joint_group[joint] = joint);
        for muscle in 0..self.muscles.len() {
            let mut joints = crossed(arms, n, muscle);
            let Some(first) = joints.next() else { continue };
            for joint in joints {
                let [a, b] = [first, joint].map(|joint| self.joint_group[joint]);
                let (joined, other) = (a.min(b), a.max(b));
                for group in self.joint_group.iter_mut().filter(|group| **group == other) {
                    *group = joined;
                }
            }
        }
        for (muscle, group) in self.muscle_group.iter_mut().enumerate() {
            *group = crossed(arms, n, muscle).next().map_or(n, |joint| self.joint_group[joint]);
        }
    }

    /// Appends the entries of a group's muscles.
    fn list_entries(&mut self, muscles: Range<usize>, joints: Range<usize>, arms: &[f64]) -> Group {
        let n = self.joints.len();
        let (rows, columns) = (muscles.len(), joints.len());
        let arm_count = |&muscle: &usize| crossed(arms, n, muscle).count();
        let count: usize = self.muscles[muscles.clone()].iter().map(arm_count).sum();
        let dense = columns <= SMALL || count as f64 >= DENSE * (rows * columns) as f64;
        let squares = |count: usize| (count * count) as u64;
        let mut operations = squares(rows) + squares(columns) * columns as u64 / 6;
        for k in muscles.clone() {
            let mut end = self.start[k];
            for (column, &joint) in self.joints[joints.clone()].iter().enumerate() {
                let source = self.muscles[k] * n + joint;
                if dense || is_nonzero(arms[source]) {
                    (self.column[end], self.source[end]) = (column, source);
                    end += 1;
                }
            }
            operations += squares(end - self.start[k]) / 2;
            self.start[k + 1] = end;
        }
        Group { muscles, joints, dense, operations }
    }
}

/// The joints that a muscle crosses, of `n`.
fn crossed(arms: &[f64], n: usize, muscle: usize) -> impl Iterator<Item = usize> {
    (0..n).filter(move |joint| is_nonzero(arms[muscle * n + joint]))
}

#[cfg(test)]
mod tests {
    use super::Pattern;

    #[test]
    fn joints_without_a_common_muscle_are_groups_of_their_own() {
        let arms = [
            0.0, 1.0, 0.0, 2.0, //
            3.0, 0.0, 0.0, 0.0, //
            0.0, 0.0, 0.0, 0.0, //
            0.0, 0.0, 0.0, 4.0,
        ];
        let mut pattern = Pattern::new(4, 4);
        pattern.find(&arms);
        assert_eq!(pattern.muscles, [1, 0, 3, 2]);
        assert_eq!(pattern.joints, [0, 1, 3, 2]);
        let sizes: alloc::vec::Vec<_> =
            pattern.groups().iter().map(|g| (g.muscles.len(), g.joints.len())).collect();
        assert_eq!(sizes, [(1, 1), (2, 2), (0, 1), (1, 0)]);
        // Small groups store every arm.
        assert_eq!(pattern.column[..pattern.source().len()], [0, 0, 1, 0, 1]);
    }

    #[test]
    fn operations_are_those_of_a_newton_step_with_dense_rows() {
        // Every joint by every muscle: n^2/2 per muscle, n^3/6 of the factors, m^2 of the line search.
        for (muscles, joints) in [(4, 2), (15, 7), (9, 6)] {
            let mut pattern = Pattern::new(muscles, joints);
            pattern.find(&alloc::vec![1.0; muscles * joints]);
            let expected = muscles * (joints * joints / 2) + joints.pow(3) / 6 + muscles * muscles;
            assert_eq!(pattern.groups()[0].operations, expected as u64);
        }
    }

    #[test]
    fn a_large_group_stores_every_arm_where_three_in_ten_are_not_zero() {
        let joints = 10;
        // Every muscle crosses some neighbouring joints: 2 of 10, and 4 of 10.
        for (crossed, dense) in [(2, false), (4, true)] {
            let muscles = joints + 1 - crossed;
            let mut arms = alloc::vec![0.0; muscles * joints];
            (0..muscles).for_each(|k| arms[k * joints + k..][..crossed].fill(0.03));
            let mut pattern = Pattern::new(muscles, joints);
            pattern.find(&arms);
            assert_eq!((pattern.groups().len(), pattern.groups()[0].dense), (1, dense));
            assert_eq!(pattern.source().len(), muscles * if dense { joints } else { crossed });
        }
    }
}
