use crate::body::vector::{cross, dot, norm, product};
use crate::body::{Poses, Robot};
use crate::error::{Error, finite, positive, within};
use alloc::vec;
use alloc::vec::Vec;

/// Redundancy resolution: the pose on the path that is closest to a preferred one.
///
/// ```text
/// q(th) = argmin 1/2 (q - r)^T W (q - r)   so that   p(q) = p(th),      r(th) = rest + swing sin th
/// dq = (r - q) + W^-1 J^T (J W^-1 J^T)^-1 [p - p(q) - J (r - q)],   q <- q + min(1, 0.3/max|dq|) dq
/// ```
///
/// | symbol | field     | unit     | domain | meaning                                         |
/// |--------|-----------|----------|--------|-------------------------------------------------|
/// | r      | `rest`, `swing` | rad or m | finite | preferred pose, and how it swings once per turn |
/// | W      | `weight`  | 1        | > 0    | weight of each joint's deviation from it         |
/// | p, J   |           |          |        | end point and its Jacobian                         |
///
/// The pose is a function of the phase alone: it does not drift, and is periodic where the path is closed.
///
/// # Assumes
/// Hinges and slides only. Convergence is linear: about 25 iterations from the neighbouring solution.
///
/// # Source
/// `whitney1969` for the weighted pseudo-inverse; solving for a pose instead of integrating velocities is
/// ours.
#[derive(Debug, Clone, PartialEq)]
pub struct Redundancy {
    /// `rest` of every joint, rad or m.
    pub rest: Vec<f64>,
    /// `swing` of every joint, rad or m.
    pub swing: Vec<f64>,
    /// `W` of every joint.
    pub weight: Vec<f64>,
}

/// Largest joint step at convergence, rad or m.
const STEP_TOLERANCE: f64 = 1e-12;
const MAX_ITERATIONS: usize = 500;

impl Redundancy {
    /// For the LM-Arm: elbow bent, pronation swinging by 25 degrees, so that all muscles move.
    #[must_use]
    pub fn lm_arm() -> Self {
        let degrees = |of: [f64; 7]| of.iter().map(|angle| angle.to_radians()).collect();
        Self {
            rest: degrees([15.0, 20.0, 10.0, 85.0, 0.0, 0.0, 0.0]),
            swing: degrees([0.0, 0.0, 0.0, 0.0, 25.0, 0.0, 0.0]),
            weight: vec![1.0, 1.0, 0.8, 1.0, 1.0, 0.5, 3.0],
        }
    }

    /// Closest to a pose, all joints weighted alike.
    #[must_use]
    pub fn near(rest: &[f64]) -> Self {
        Self { rest: rest.to_vec(), swing: vec![0.0; rest.len()], weight: vec![1.0; rest.len()] }
    }

    /// Checks the numbers for a robot.
    ///
    /// # Errors
    /// [`Error::WrongLength`] or [`Error::OutOfDomain`] names the field; robots with ball, free or coupled
    /// joints are not supported.
    pub fn validate(&self, robot: &Robot) -> Result<(), Error> {
        let plain = robot.nq() == robot.nv() && robot.parts().couplings.is_empty();
        let coordinates = robot.nq() as f64;
        within("joints", "hinges and slides, none of them coupled", coordinates, plain && robot.nq() > 0)?;
        for (name, part) in [("rest", &self.rest), ("swing", &self.swing), ("weight", &self.weight)] {
            if part.len() != robot.nq() {
                return Err(Error::WrongLength { name, expected: robot.nq(), got: part.len() });
            }
        }
        self.rest.iter().try_for_each(|&r| finite("rest", r).map(drop))?;
        self.swing.iter().try_for_each(|&r| finite("swing", r).map(drop))?;
        self.weight.iter().try_for_each(|&w| positive("weight", w).map(drop))
    }

    /// `r` of a joint at a phase.
    fn preferred(&self, joint: usize, sine: f64) -> f64 {
        self.rest[joint] + self.swing[joint] * sine
    }
}

/// Inverse kinematics with preallocated matrices.
#[derive(Debug, Clone)]
pub(super) struct Solver<'a> {
    robot: &'a Robot,
    rule: &'a Redundancy,
    site: usize,
    poses: Poses,
    jacobian: Vec<f64>,
    angular: Vec<f64>,
    joint_step: Vec<f64>,
}

impl<'a> Solver<'a> {
    /// For the end point at a site.
    pub(super) fn new(robot: &'a Robot, rule: &'a Redundancy, site: usize) -> Result<Self, Error> {
        rule.validate(robot)?;
        within("site", "an index of a site", site as f64, site < robot.parts().sites.len())?;
        let nv = robot.nv();
        Ok(Self {
            robot,
            rule,
            site,
            poses: Poses::new(robot),
            jacobian: vec![0.0; 3 * nv],
            angular: vec![0.0; 3 * nv],
            joint_step: vec![0.0; nv],
        })
    }

    /// Moves `q` to the pose for `target` at a phase; returns the remaining position error, m.
    pub(super) fn solve(&mut self, phase: f64, target: [f64; 3], q: &mut [f64]) -> Result<f64, Error> {
        let sine = libm::sin(phase);
        for _ in 0..MAX_ITERATIONS {
            let position_error = self.position_error(target, q)?;
            let largest = self.step(sine, position_error, q);
            if largest < STEP_TOLERANCE {
                break;
            }
        }
        let position_error = self.position_error(target, q)?;
        Ok(norm(position_error))
    }

    /// Position error of the end point, m; updates the Jacobian.
    fn position_error(&mut self, target: [f64; 3], q: &[f64]) -> Result<[f64; 3], Error> {
        self.robot.forward_kinematics(q, &mut self.poses)?;
        let point = self.robot.site_pose(&self.poses, self.site).origin;
        let body = self.robot.parts().sites[self.site].body;
        self.robot.jacobian(&self.poses, body, point, &mut self.jacobian, &mut self.angular)?;
        Ok(core::array::from_fn(|k| target[k] - point[k]))
    }

    /// One iteration; returns the largest joint step before it is limited.
    fn step(&mut self, sine: f64, position_error: [f64; 3], q: &mut [f64]) -> f64 {
        let nv = q.len();
        let row = |k: usize| &self.jacobian[k * nv..(k + 1) * nv];
        for (joint, deviation) in self.joint_step.iter_mut().enumerate() {
            *deviation = self.rule.preferred(joint, sine) - q[joint];
        }
        let weight = &self.rule.weight;
        let weighted = |i, j| row(i).iter().zip(row(j)).zip(weight).map(|((a, b), w)| a * b / w).sum::<f64>();
        let normal = core::array::from_fn(|i| core::array::from_fn(|j| weighted(i, j)));
        let right = core::array::from_fn(|i| position_error[i] - product(row(i), &self.joint_step));
        let multipliers = solve(normal, right);
        let mut largest = 0.0_f64;
        for (joint, change) in self.joint_step.iter_mut().enumerate() {
            let projected: f64 = (0..3).map(|k| self.jacobian[k * nv + joint] * multipliers[k]).sum();
            *change += projected / weight[joint];
            largest = largest.max(change.abs());
        }
        let share = if largest > 0.3 { 0.3 / largest } else { 1.0 };
        q.iter_mut().zip(&self.joint_step).for_each(|(q, change)| *q += share * change);
        largest
    }
}

/// Solves a symmetric positive 3 x 3 system by Cramer's rule; near a singularity the solution is large but
/// finite.
fn solve([a, b, c]: [[f64; 3]; 3], right: [f64; 3]) -> [f64; 3] {
    let trace = a[0] + b[1] + c[2];
    let determinant = dot(a, cross(b, c)).max(1e-18 * trace * trace * trace + f64::MIN_POSITIVE);
    [dot(right, cross(b, c)), dot(a, cross(right, c)), dot(a, cross(b, right))].map(|part| part / determinant)
}
