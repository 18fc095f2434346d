use crate::Error;
use crate::body::{cholesky, symmetric};
use crate::error::{check_entries, check_length};
use crate::muscle::MuscleDynamics;
use alloc::vec;
use alloc::vec::Vec;

/// Whether a machine stays in a pose while its winches are held and its cables slide freely in their sheaths.
///
/// ```text
/// M x'' = -K x,     K = R^T diag(1/C) R - sum_k F_k dR_k/dq + d(g - tau_p)/dq
/// lambda = least eigenvalue of M^-1 K
/// ```
///
/// | symbol   | field or argument                  | shape               | unit      | meaning                       |
/// |----------|------------------------------------|---------------------|-----------|-------------------------------|
/// | lambda   | [`eigenvalue`](Self::eigenvalue)   |                     | 1/s^2     | below zero the machine leaves the pose as `e^(sqrt(-lambda) t)` |
/// | R        |                                    | `[muscles x joints]`| m         | moment arms `-dl/dq`          |
/// | C        | `compliance`                       | `[muscles]`         | m/N, > 0  | of the whole cable            |
/// | F        | `tension`                          | `[muscles]`         | N, >= 0   | tensions at the anchors       |
/// | g, tau_p |                                    | `[joints]`          | Nm or N   | torque that gravity needs, torque of the joints' springs |
///
/// A muscle whose moment arm grows as it shortens (bowstringing) has a negative geometric stiffness
/// `-F_k dR_k/dq`, which grows with its tension; the elastic stiffness does not.
///
/// # Assumes
/// Tensions and gravity are in equilibrium. Friction, which only slows the motion down and holds it within
/// the dead bands, is left out.
///
/// # Source
/// Stiffness of cable-driven mechanisms, elastic and geometric.
#[derive(Debug, Clone, Copy, PartialEq)]
pub struct HeldStability {
    /// `lambda`, 1/s^2.
    pub eigenvalue: f64,
    /// The independent joint that moves most in the motion of `lambda`, by its own kinetic energy.
    pub joint: usize,
    /// What has the most negative stiffness in the motion of `lambda`.
    pub cause: NegativeStiffness,
}

/// What pushes a machine out of a pose.
#[derive(Debug, Clone, Copy, PartialEq, Eq)]
pub enum NegativeStiffness {
    /// The changing moment arms of this muscle, under its tension.
    Muscle(usize),
    /// Gravity, less the springs of the joints.
    Gravity,
}

/// Step of the differences, rad or m.
const STEP: f64 = 1e-5;

impl HeldStability {
    /// In a pose under tensions that balance gravity.
    ///
    /// # Shapes
    /// `compliance`, `tension: [muscles]`, `pose: [joints]`.
    ///
    /// # Errors
    /// [`Error::WrongLength`], [`Error::EntryOutOfDomain`] where an entry is not finite, and
    /// [`Error::OutOfDomain`] where the mass matrix is not positive definite.
    pub fn new(
        model: &mut MuscleDynamics,
        compliance: &[f64],
        tension: &[f64],
        pose: &[f64],
    ) -> Result<Self, Error> {
        let (m, n) = (model.muscles(), model.joints());
        check_length("compliance", compliance.len(), m)?;
        check_entries("tensions", tension, m)?;
        check_entries("pose", pose, n)?;
        let slopes = Slopes::new(model, pose)?;
        model.evaluate(pose)?;
        let mut mass = vec![0.0; n * n];
        model.mass_matrix(&mut mass)?;
        let own: Vec<f64> = (0..n).map(|j| mass[j * n + j]).collect();
        cholesky::factor(&mut mass, n)?;
        // K, then L^-1 K L^-T: its rows and, because it is symmetric, its columns.
        let mut stiffness = slopes.stiffness(model.moment_arms(), compliance, tension);
        for _ in 0..2 {
            stiffness.chunks_exact_mut(n).for_each(|row| cholesky::solve_lower(&mass, row));
            transpose(&mut stiffness, n);
        }
        let mut vectors = vec![0.0; n * n];
        symmetric::eigen(&mut stiffness, &mut vectors, n);
        let least =
            (0..n).min_by(|&a, &b| stiffness[a * n + a].total_cmp(&stiffness[b * n + b])).unwrap_or(0);
        let mut motion = vectors[least * n..(least + 1) * n].to_vec();
        cholesky::solve_upper(&mass, &mut motion);
        let energy = |j: &usize| own[*j] * motion[*j] * motion[*j];
        let joint = (0..n).max_by(|a, b| energy(a).total_cmp(&energy(b))).unwrap_or(0);
        let found =
            Self { eigenvalue: stiffness[least * n + least], joint, cause: slopes.cause(tension, &motion) };
        crate::error::finite("eigenvalue of the stiffness of the joints", found.eigenvalue)?;
        Ok(found)
    }

    /// `sqrt(-lambda)`, rate at which the machine leaves the pose, 1/s; 0 where it stays.
    #[must_use]
    pub fn rate(&self) -> f64 {
        libm::sqrt((-self.eigenvalue).max(0.0))
    }
}

/// Derivatives by the joints in one pose, by central differences, which follow coupled joints, too.
struct Slopes {
    /// `dR_kj/dq_i`: `[joints i][muscles k x joints j]`.
    arms: Vec<Vec<f64>>,
    /// `d(g - tau_p)_j/dq_i`: `[joints i][joints j]`.
    needed: Vec<Vec<f64>>,
}

impl Slopes {
    fn new(model: &mut MuscleDynamics, pose: &[f64]) -> Result<Self, Error> {
        let n = pose.len();
        let (zero, mut at) = (vec![0.0; n], pose.to_vec());
        let mut evaluate = |at: &[f64]| -> Result<(Vec<f64>, Vec<f64>), Error> {
            let mut torque = vec![0.0; n];
            model.evaluate(at)?;
            model.inverse_dynamics(&zero, &zero, &mut torque)?;
            Ok((model.moment_arms().to_vec(), torque))
        };
        let slope = |above: Vec<f64>, below: Vec<f64>| -> Vec<f64> {
            above.iter().zip(below).map(|(above, below)| (above - below) / (2.0 * STEP)).collect()
        };
        let mut slopes = Self { arms: Vec::new(), needed: Vec::new() };
        for i in 0..n {
            at[i] = pose[i] + STEP;
            let above = evaluate(&at)?;
            at[i] = pose[i] - STEP;
            let below = evaluate(&at)?;
            at[i] = pose[i];
            slopes.arms.push(slope(above.0, below.0));
            slopes.needed.push(slope(above.1, below.1));
        }
        Ok(slopes)
    }

    /// `K`, symmetric but for the error of the differences, which is removed: `[joints x joints]`.
    fn stiffness(&self, arms: &[f64], compliance: &[f64], tension: &[f64]) -> Vec<f64> {
        let n = self.needed.len();
        let one_sided = |i: usize, j: usize| {
            let muscles = tension.iter().enumerate().map(|(k, force)| force * self.arms[i][k * n + j]);
            self.needed[i][j] - muscles.sum::<f64>()
        };
        let elastic = |i: usize, j: usize| -> f64 {
            arms.chunks_exact(n).zip(compliance).map(|(row, c)| row[i] * row[j] / c).sum()
        };
        let entry = |i: usize, j: usize| elastic(i, j) + 0.5 * (one_sided(i, j) + one_sided(j, i));
        (0..n * n).map(|at| entry(at / n, at % n)).collect()
    }

    /// The smallest of `x^T (-F_k dR_k/dq) x` over the muscles and `x^T d(g - tau_p)/dq x`.
    fn cause(&self, tension: &[f64], motion: &[f64]) -> NegativeStiffness {
        let n = motion.len();
        let along = |slopes: &dyn Fn(usize, usize) -> f64| -> f64 {
            let entries = (0..n * n).map(|at| (at / n, at % n));
            entries.map(|(i, j)| motion[i] * slopes(i, j) * motion[j]).sum()
        };
        let mut least = (along(&|i, j| self.needed[i][j]), NegativeStiffness::Gravity);
        for (k, force) in tension.iter().enumerate() {
            let geometric = along(&|i, j| -force * self.arms[i][k * n + j]);
            if geometric < least.0 {
                least = (geometric, NegativeStiffness::Muscle(k));
            }
        }
        least.1
    }
}

fn transpose(a: &mut [f64], n: usize) {
    for i in 0..n {
        for j in 0..i {
            a.swap(i * n + j, j * n + i);
        }
    }
}
