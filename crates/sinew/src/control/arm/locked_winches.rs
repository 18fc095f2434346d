use super::synthesis::tension_limits;
use crate::Error;
use crate::control::tension::{Distribution, Problem, Solution, Status, cocontract};
use crate::machine::{HeldStability, Machine};
use crate::muscle::MuscleDynamics;
use crate::transmission::cable::CableLaw;
use alloc::vec;
use alloc::vec::Vec;

/// The pose of some that a machine leaves fastest, or to which it returns most slowly, while its winches are
/// held.
#[derive(Debug, Clone, PartialEq)]
pub struct LeastStable {
    /// Its index among the poses.
    pub index: usize,
    /// Tensions at the anchors, N: `[muscles]`.
    pub tension: Vec<f64>,
    /// There.
    pub stability: HeldStability,
}

/// Rate at which a machine may leave a pose by itself and still be tracked at a cycle of a millisecond, 1/s.
///
/// Of random machines whose largest rate on their tour was above it, 3 of 90 were tracked in simulation; of
/// those between half of it and itself 6 of 34, of those without an unstable pose 22 of 25
/// (`docs/campaigns.md`). A controller stabilises rates well below the crossover of its damping alone
/// ([`ControlRules::damping_crossover`](crate::machine::ControlRules::damping_crossover), 60 rad/s); friction
/// of the cables, which sticks, holds the rest.
pub const MAX_UNSTABLE_RATE: f64 = 100.0;

/// The least stable of some poses, under the tensions with which the controller holds the machine in each.
///
/// ```text
/// F = argmin |F - F_ref|^2   subject to   R^T F = g - tau_p,  F_min <= F <= F_max
/// F_ref = F_min + c (F_max - F_min);   F_ref = 0 for c = 0, which is the controller's
/// ```
///
/// Poses that no tensions within the limits hold ([`unheld_poses`]) are passed over; none where that is all
/// of them. `level` is `c`, in `[0, 1]`; machine with its payload in the body.
///
/// # Shapes
/// `laws: [muscles]`, `poses: [places][joints]`.
///
/// # Errors
/// As [`HeldStability::new`] and [`cocontract`].
pub fn least_stable_pose(
    machine: &Machine,
    laws: &[CableLaw],
    poses: &[Vec<f64>],
    level: f64,
) -> Result<Option<LeastStable>, Error> {
    let mut holding = Holding::new(machine, laws, level)?;
    let compliance: Vec<f64> = laws.iter().map(|law| law.compliance().iter().sum()).collect();
    let mut least: Option<LeastStable> = None;
    for (index, pose) in poses.iter().enumerate() {
        let solution = holding.tensions(pose)?;
        if solution.status != Status::Optimal {
            continue;
        }
        let tension = solution.tension.to_vec();
        let stability = HeldStability::new(&mut holding.model, &compliance, &tension, pose)?;
        if least.as_ref().is_none_or(|least| stability.eigenvalue < least.stability.eigenvalue) {
            least = Some(LeastStable { index, tension, stability });
        }
    }
    Ok(least)
}

/// The largest rate at which a machine leaves any of some poses by itself, mostly by a motion of each joint,
/// under the tensions with which the controller holds it, 1/s; 0 where it stays: `[joints]`.
///
/// # Shapes
/// `laws: [muscles]`, `poses: [places][joints]`.
///
/// # Errors
/// As [`least_stable_pose`].
pub(super) fn unstable_rates(
    machine: &Machine,
    laws: &[CableLaw],
    poses: &[Vec<f64>],
) -> Result<Vec<f64>, Error> {
    let mut holding = Holding::new(machine, laws, 0.0)?;
    let compliance: Vec<f64> = laws.iter().map(|law| law.compliance().iter().sum()).collect();
    let mut rates = vec![0.0; machine.start.len()];
    for pose in poses {
        let solution = holding.tensions(pose)?;
        if solution.status != Status::Optimal {
            continue;
        }
        let tension = solution.tension.to_vec();
        let stability = HeldStability::new(&mut holding.model, &compliance, &tension, pose)?;
        let rate: &mut f64 = &mut rates[stability.joint];
        *rate = rate.max(stability.rate());
    }
    Ok(rates)
}

/// A pose in which no tensions within their limits balance gravity and the passive torques.
#[derive(Debug, Clone, Copy, PartialEq)]
pub struct UnheldPose {
    /// Its index among the poses.
    pub index: usize,
    /// The independent joint whose torque is missed by most.
    pub joint: usize,
    /// What it needs beyond the closest that the muscles give, N m or N.
    pub missing: f64,
    /// What it needs, N m or N.
    pub needed: f64,
}

/// The poses of some in which no tensions within their limits hold a machine; with its payload in the body.
///
/// # Shapes
/// `laws: [muscles]`, `poses: [places][joints]`.
///
/// # Errors
/// [`Error::WrongLength`] for poses of another robot.
pub fn unheld_poses(
    machine: &Machine,
    laws: &[CableLaw],
    poses: &[Vec<f64>],
) -> Result<Vec<UnheldPose>, Error> {
    let mut holding = Holding::new(machine, laws, 0.0)?;
    let mut unheld = Vec::new();
    for (index, pose) in poses.iter().enumerate() {
        let solution = holding.tensions(pose)?;
        if solution.status == Status::Optimal {
            continue;
        }
        let residual = solution.residual.iter().copied().enumerate();
        let Some((joint, missing)) = residual.max_by(|a, b| a.1.abs().total_cmp(&b.1.abs())) else {
            continue;
        };
        unheld.push(UnheldPose { index, joint, missing, needed: holding.torque[joint] });
    }
    Ok(unheld)
}

/// Tensions at rest with a co-contraction.
struct Holding {
    model: MuscleDynamics,
    distribution: Distribution,
    minimum: Vec<f64>,
    maximum: Vec<f64>,
    reference: Vec<f64>,
    weight: Vec<f64>,
    zero: Vec<f64>,
    torque: Vec<f64>,
}

impl Holding {
    fn new(machine: &Machine, laws: &[CableLaw], level: f64) -> Result<Self, Error> {
        let model = MuscleDynamics::new(&machine.robot)?;
        let (m, n) = (model.muscles(), model.joints());
        let limits = tension_limits(machine, laws);
        let (minimum, maximum): (Vec<f64>, Vec<f64>) =
            limits.iter().map(|[least, most]| (*least, *most)).unzip();
        let mut reference = vec![0.0; m];
        if level != 0.0 {
            cocontract(level, &minimum, &maximum, &mut reference)?;
        }
        let distribution = Distribution::new(m, n);
        let (weight, zero, torque) = (vec![1.0; m], vec![0.0; n], vec![0.0; n]);
        Ok(Self { model, distribution, minimum, maximum, reference, weight, zero, torque })
    }

    /// In a pose: `[muscles]`.
    fn tensions(&mut self, pose: &[f64]) -> Result<Solution<'_>, Error> {
        let Self { model, distribution, minimum, maximum, reference, weight, zero, torque } = self;
        model.evaluate(pose)?;
        model.inverse_dynamics(zero, zero, torque)?;
        distribution.solve(&Problem {
            moment_arms: model.moment_arms(),
            torque,
            minimum,
            maximum,
            reference,
            weight,
        })
    }
}

#[cfg(test)]
mod tests {
    use super::*;
    use crate::body::Robot;

    /// Three joints, each lifted by a muscle of its own, of 1 N to 140 N.
    fn crane() -> (Machine, Vec<CableLaw>, Vec<Vec<f64>>) {
        let mut parts = crate::muscle::tests::robots::chain(false).parts().clone();
        parts.sites[0].position[0] = -0.05;
        let mut machine = Machine::from_robot(&Robot::new(parts).unwrap()).unwrap();
        machine.muscles.iter_mut().for_each(|muscle| muscle.tension = [Some(1.0), Some(140.0)]);
        let (laws, poses) = (machine.laws(8).unwrap(), machine.poses(40).unwrap());
        (machine, laws, poses)
    }

    /// By hand, because no two muscles share a joint: torque, tension of every muscle, and what it does not
    /// give.
    fn held(machine: &Machine, laws: &[CableLaw], pose: &[f64]) -> [Vec<f64>; 3] {
        let mut model = MuscleDynamics::new(&machine.robot).unwrap();
        let mut torque = vec![0.0; 3];
        model.evaluate(pose).unwrap();
        model.inverse_dynamics(&[0.0; 3], &[0.0; 3], &mut torque).unwrap();
        let limits = tension_limits(machine, laws);
        let arm = |k: usize| model.moment_arms()[4 * k];
        let tension: Vec<f64> =
            (0..3).map(|k| (torque[k] / arm(k)).clamp(limits[k][0], limits[k][1])).collect();
        let missing = (0..3).map(|k| torque[k] - arm(k) * tension[k]).collect();
        [torque, tension, missing]
    }

    #[test]
    fn a_pose_is_unheld_where_a_joint_needs_more_or_less_than_its_muscle_gives() {
        let (machine, laws, poses) = crane();
        let found = unheld_poses(&machine, &laws, &poses).unwrap();
        assert!(found.len() > 3 && found.len() + 3 < poses.len(), "{} of {}", found.len(), poses.len());
        let mut unheld = found.iter();
        for (index, pose) in poses.iter().enumerate() {
            let [torque, _, missing] = held(&machine, &laws, pose);
            let joint = (0..3).max_by(|&a, &b| missing[a].abs().total_cmp(&missing[b].abs())).unwrap();
            if missing[joint].abs() > 1e-6 {
                let found = unheld.next().unwrap();
                assert_eq!((found.index, found.joint), (index, joint));
                assert!((found.missing - missing[joint]).abs() < 1e-9, "{found:?} {missing:?}");
                assert!((found.needed - torque[joint]).abs() < 1e-12, "{found:?} {torque:?}");
            }
        }
        assert_eq!(unheld.next(), None);
    }

    #[test]
    fn the_least_stable_pose_is_the_held_one_with_the_least_eigenvalue() {
        let (machine, laws, poses) = crane();
        let compliance: Vec<f64> = laws.iter().map(|law| law.compliance().iter().sum()).collect();
        let mut model = MuscleDynamics::new(&machine.robot).unwrap();
        // In any order.
        let backward: Vec<Vec<f64>> = poses.iter().rev().cloned().collect();
        for poses in [poses, backward] {
            let mut expected: Option<(usize, f64, Vec<f64>)> = None;
            for (index, pose) in poses.iter().enumerate() {
                let [_, tension, missing] = held(&machine, &laws, pose);
                if missing.iter().any(|missing| missing.abs() > 1e-6) {
                    continue;
                }
                let found = HeldStability::new(&mut model, &compliance, &tension, pose).unwrap().eigenvalue;
                if expected.as_ref().is_none_or(|least| found < least.1) {
                    expected = Some((index, found, tension));
                }
            }
            let (index, eigenvalue, tension) = expected.unwrap();
            let found = least_stable_pose(&machine, &laws, &poses, 0.0).unwrap().unwrap();
            assert_eq!(found.index, index);
            assert!((found.stability.eigenvalue / eigenvalue - 1.0).abs() < 1e-12, "{found:?} {eigenvalue}");
            assert!(found.tension.iter().zip(tension).all(|(a, b)| (a - b).abs() < 1e-9));
        }
    }

    #[test]
    fn of_equal_poses_the_first_is_named_and_none_where_no_pose_is_held() {
        let (machine, laws, poses) = crane();
        let LeastStable { index, .. } = least_stable_pose(&machine, &laws, &poses, 0.0).unwrap().unwrap();
        let twice = [poses[index].clone(), poses[index].clone()];
        assert_eq!(least_stable_pose(&machine, &laws, &twice, 0.0).unwrap().unwrap().index, 0);
        let unheld: Vec<Vec<f64>> = unheld_poses(&machine, &laws, &poses)
            .unwrap()
            .iter()
            .map(|pose| poses[pose.index].clone())
            .collect();
        assert_eq!(least_stable_pose(&machine, &laws, &unheld, 0.0), Ok(None));
    }
}
