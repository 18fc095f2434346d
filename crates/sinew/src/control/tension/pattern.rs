//! Which muscles cross which joints, and the groups of joints that share no muscle.

use super::problem::is_nonzero;
use alloc::vec::Vec;
use core::ops::Range;

/// Joints coupled by common muscles and by no others, and these muscles, as ranges of [`Pattern`]'s order.
#[derive(Debug, Clone)]
pub(super) struct Group {
    pub(super) muscles: Range<usize>,
    pub(super) joints: Range<usize>,
    /// Whether every arm is stored, zero or not.
    pub(super) dense: bool,
    /// Multiplications in a Newton step, about: Newton matrix, its factors, line search.
    pub(super) operations: u64,
}

/// A group of at most so many joints, or with at least so large a share of arms that are not zero, stores
/// every arm.
const SMALL: usize = 8;
const DENSE: f64 = 0.3;

/// The places of the moment arms that are not zero, group by group.
///
/// A robot arm of seven joints is as a rule several small problems, not one large one.
#[derive(Debug)]
pub(super) struct Pattern {
    joint_count: usize,
    /// Muscle and joint at each place.
    pub(super) muscles: Vec<usize>,
    pub(super) joints: Vec<usize>,
    pub(super) groups: Vec<Group>,
    /// First entry of each muscle, and the end of the last.
    pub(super) start: Vec<usize>,
    /// Joint of each entry, counted within the group.
    pub(super) column: Vec<usize>,
    /// Place of each entry in the problem's matrix.
    pub(super) source: Vec<usize>,
    /// First joint of each joint's group.
    parent: Vec<usize>,
    /// Whether groups were found.
    pub(super) found: bool,
}

/// A clone has the same room: it allocates as little as the original.
impl Clone for Pattern {
    fn clone(&self) -> Self {
        Self {
            joint_count: self.joint_count,
            muscles: with_room(&self.muscles),
            joints: with_room(&self.joints),
            groups: with_room(&self.groups),
            start: with_room(&self.start),
            column: with_room(&self.column),
            source: with_room(&self.source),
            parent: self.parent.clone(),
            found: self.found,
        }
    }
}

fn with_room<T: Clone>(list: &Vec<T>) -> Vec<T> {
    let mut clone = Vec::with_capacity(list.capacity());
    clone.extend_from_slice(list);
    clone
}

impl Pattern {
    /// Room for a pattern; it holds none yet.
    pub(super) fn new(muscles: usize, joints: usize) -> Self {
        let mut start = Vec::with_capacity(muscles + 1);
        start.push(0);
        Self {
            joint_count: joints,
            muscles: Vec::with_capacity(muscles),
            joints: Vec::with_capacity(joints),
            groups: Vec::with_capacity(joints + 1),
            start,
            column: Vec::with_capacity(muscles * joints),
            source: Vec::with_capacity(muscles * joints),
            parent: alloc::vec![0; joints],
            found: false,
        }
    }

    /// Finds the groups of `arms`, muscles x joints.
    pub(super) fn find(&mut self, muscles: usize, arms: &[f64]) {
        let n = self.joint_count;
        let crosses = |muscle: usize, joint: usize| is_nonzero(arms[muscle * n + joint]);
        self.join_joints(muscles, &crosses);
        for list in [&mut self.muscles, &mut self.joints, &mut self.start, &mut self.column, &mut self.source]
        {
            list.clear();
        }
        self.groups.clear();
        self.start.push(0);
        self.found = true;
        for first in 0..n {
            if self.parent[first] == first {
                self.gather(muscles, first, &crosses);
            }
        }
        self.gather_idle(muscles, &crosses);
    }

    /// Joints that a muscle crosses together get one parent: the first of them.
    fn join_joints(&mut self, muscles: usize, crosses: &impl Fn(usize, usize) -> bool) {
        let n = self.joint_count;
        for (joint, parent) in self.parent.iter_mut().enumerate() {
            *parent = joint;
        }
        for muscle in 0..muscles {
            let mut crossed = (0..n).filter(|&joint| crosses(muscle, joint));
            let Some(first) = crossed.next() else { continue };
            for joint in crossed {
                let (a, b) = (self.parent[first], self.parent[joint]);
                if a != b {
                    let (first, other) = (a.min(b), a.max(b));
                    for parent in self.parent.iter_mut().filter(|p| **p == other) {
                        *parent = first;
                    }
                }
            }
        }
    }

    /// Lists the group whose first joint is `first`.
    fn gather(&mut self, muscles: usize, first: usize, crosses: &impl Fn(usize, usize) -> bool) {
        let n = self.joint_count;
        let (from_muscle, from_joint) = (self.muscles.len(), self.joints.len());
        self.joints.extend((first..n).filter(|&joint| self.parent[joint] == first));
        let joints = &self.joints[from_joint..];
        let arms = |&muscle: &usize| joints.iter().filter(|&&joint| crosses(muscle, joint)).count();
        self.muscles.extend((0..muscles).filter(|muscle| arms(muscle) > 0));
        let count = self.muscles[from_muscle..].iter().map(arms).sum::<usize>();
        let all = (self.muscles.len() - from_muscle) * joints.len();
        let dense = joints.len() <= SMALL || count as f64 >= DENSE * all as f64;
        let squares = |count: usize| (count * count) as u64;
        let mut operations = squares(all / joints.len()) + squares(joints.len()) * joints.len() as u64 / 6;
        for &muscle in &self.muscles[from_muscle..] {
            let before = self.column.len();
            for (column, &joint) in self.joints[from_joint..].iter().enumerate() {
                if dense || crosses(muscle, joint) {
                    self.column.push(column);
                    self.source.push(muscle * n + joint);
                }
            }
            self.start.push(self.column.len());
            operations += squares(self.column.len() - before) / 2;
        }
        let (muscles, joints) = (from_muscle..self.muscles.len(), from_joint..self.joints.len());
        self.groups.push(Group { muscles, joints, dense, operations });
    }

    /// Muscles that cross no joint are a group without joints.
    fn gather_idle(&mut self, muscles: usize, crosses: &impl Fn(usize, usize) -> bool) {
        let from = self.muscles.len();
        for muscle in 0..muscles {
            if !(0..self.joint_count).any(|joint| crosses(muscle, joint)) {
                self.muscles.push(muscle);
                self.start.push(self.column.len());
            }
        }
        if self.muscles.len() > from {
            let end = self.joints.len();
            self.groups.push(Group {
                muscles: from..self.muscles.len(),
                joints: end..end,
                dense: false,
                operations: 0,
            });
        }
    }
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
        pattern.find(4, &arms);
        assert_eq!(pattern.muscles, [1, 0, 3, 2]);
        assert_eq!(pattern.joints, [0, 1, 3, 2]);
        let sizes: alloc::vec::Vec<_> =
            pattern.groups.iter().map(|g| (g.muscles.len(), g.joints.len())).collect();
        assert_eq!(sizes, [(1, 1), (2, 2), (0, 1), (1, 0)]);
        // Small groups store every arm.
        assert_eq!(pattern.column, [0, 0, 1, 0, 1]);
    }

    #[test]
    fn operations_are_those_of_a_newton_step_with_dense_rows() {
        // Every joint by every muscle: n^2/2 per muscle, n^3/6 of the factors, m^2 of the line search.
        for (muscles, joints) in [(4, 2), (15, 7), (9, 6)] {
            let mut pattern = Pattern::new(muscles, joints);
            pattern.find(muscles, &alloc::vec![1.0; muscles * joints]);
            let expected = muscles * (joints * joints / 2) + joints.pow(3) / 6 + muscles * muscles;
            assert_eq!(pattern.groups[0].operations, expected as u64);
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
            pattern.find(muscles, &arms);
            assert_eq!((pattern.groups.len(), pattern.groups[0].dense), (1, dense));
            assert_eq!(pattern.column.len(), muscles * if dense { joints } else { crossed });
        }
    }
}
