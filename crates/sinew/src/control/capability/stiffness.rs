//! Stiffness of joints and end point that cables behind standing winches give.

use super::directions::directions;
use crate::body::{cholesky, symmetric};
use alloc::vec;
use alloc::vec::Vec;

/// `K = R^T diag(1/C) R` as its Cholesky factor.
#[derive(Debug, Clone)]
pub(super) struct JointStiffness {
    factor: Vec<f64>,
    joints: usize,
}

/// Of moment arms, `[muscles x joints]`, and compliances of the whole cables, m/N; none where a joint is not
/// held.
pub(super) fn joint_stiffness(
    moment_arms: &[f64],
    compliance: &[f64],
    joints: usize,
) -> Option<JointStiffness> {
    let mut factor = vec![0.0; joints * joints];
    for (row, compliance) in moment_arms.chunks_exact(joints).zip(compliance) {
        for i in 0..joints {
            for j in 0..joints {
                factor[i * joints + j] += row[i] * row[j] / compliance;
            }
        }
    }
    cholesky::factor(&mut factor, joints).is_ok().then_some(JointStiffness { factor, joints })
}

impl JointStiffness {
    /// `1/(K^-1)_jj`: of one joint, the others free.
    pub(super) fn of_joint(&self, joint: usize) -> f64 {
        let mut unit = vec![0.0; self.joints];
        unit[joint] = 1.0;
        1.0 / self.compliance(&unit, &unit)
    }

    /// `a^T K^-1 b`.
    fn compliance(&self, a: &[f64], b: &[f64]) -> f64 {
        let scaled = |x: &[f64]| {
            let mut x = x.to_vec();
            cholesky::solve_lower(&self.factor, &mut x);
            x
        };
        scaled(a).iter().zip(scaled(b)).map(|(a, b)| a * b).sum()
    }
}

/// Smallest and largest eigenvalue of `(J K^-1 J^T)^-1`, N/m, over the directions in which the end point can
/// move.
pub(super) fn end_point_stiffness(stiffness: &JointStiffness, rows: &[f64]) -> Option<[f64; 2]> {
    let n = stiffness.joints;
    let levers: Vec<Vec<f64>> = directions(rows)
        .basis()
        .map(|axis| (0..n).map(|j| (0..3).map(|k| rows[k * n + j] * axis[k]).sum()).collect())
        .collect();
    let entry = |a: usize, b: usize| match (levers.get(a), levers.get(b)) {
        (Some(a), Some(b)) => stiffness.compliance(a, b),
        _ => 0.0,
    };
    let mut compliance: [f64; 9] = core::array::from_fn(|k| entry(k / 3, k % 3));
    symmetric::eigen(&mut compliance, &mut [0.0; 9], 3);
    let mut values: Vec<f64> = (0..3).map(|k| compliance[4 * k]).filter(|value| *value > 0.0).collect();
    values.sort_by(f64::total_cmp);
    Some([1.0 / values.last()?, 1.0 / values.first()?])
}

#[cfg(test)]
mod tests {
    use super::*;

    #[test]
    fn one_joint_and_its_lever_give_the_stiffness_of_the_end_point() {
        // K = 0.03^2/1e-4 + 0.02^2/2e-4 = 11 Nm/rad; at a lever of 0.5 m 44 N/m.
        let stiffness = joint_stiffness(&[0.03, -0.02], &[1e-4, 2e-4], 1).unwrap();
        assert!((stiffness.of_joint(0) - 11.0).abs() < 1e-12);
        let [least, most] = end_point_stiffness(&stiffness, &[0.0, 0.5, 0.0]).unwrap();
        assert!((least - 44.0).abs() < 1e-9 && (most - 44.0).abs() < 1e-9);
        assert!(joint_stiffness(&[0.03, 0.0], &[1e-4], 2).is_none());
    }

    #[test]
    fn the_least_stiffness_is_that_of_the_softest_direction() {
        // Two joints with levers along x and z: compliances 0.4^2/9 and 0.3^2/2 m/N.
        let stiffness = joint_stiffness(&[0.03, 0.0, 0.0, 0.01], &[1e-4, 5e-5], 2).unwrap();
        let rows = [0.4, 0.0, 0.0, 0.0, 0.0, 0.3];
        let [least, most] = end_point_stiffness(&stiffness, &rows).unwrap();
        assert!((least - 2.0 / 0.09).abs() < 1e-9 && (most - 9.0 / 0.16).abs() < 1e-9, "{least} {most}");
    }
}
