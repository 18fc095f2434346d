use super::torque_set::TorqueSet;
use crate::control::tension::{Distribution, Problem, Status};
use crate::error::{Error, check_entries, check_length};
use alloc::vec;
use alloc::vec::Vec;

/// The largest multiple of a load that muscles hold beside a torque that is always needed.
///
/// ```text
/// max s   so that   tau + s w = R^T F,   F_min <= F <= F_max
/// s_0 = (h(w) - w^T tau)/w^T w;    a = residual of the closest torque to tau + s w;    s <- (h(a) - a^T tau)/a^T w
/// ```
///
/// | symbol | argument  | unit    | shape      | meaning                                     |
/// |--------|-----------|---------|------------|---------------------------------------------|
/// | tau    | `needed`  | Nm or N | `[joints]` | torque without the load                      |
/// | w      | `load`    | Nm or N | `[joints]` | torque that one unit of the load needs        |
/// | h      |           |         |            | support function of [`TorqueSet`]             |
///
/// Every step cuts off multiples that the half space `a^T tau <= h(a)` excludes. The last one touches the set at
/// the torque of the largest load: muscles on either side of it are at their limits and bind.
///
/// # Source
/// Textbook: cutting planes (Kelley), with the normals of the projection.
#[derive(Debug, Clone)]
pub struct LoadSearch {
    distribution: Distribution,
    zeros: Vec<f64>,
    ones: Vec<f64>,
    minimum: Vec<f64>,
    maximum: Vec<f64>,
    torque: Vec<f64>,
}

/// A largest load.
#[derive(Debug, Clone, PartialEq)]
pub struct LargestLoad {
    /// Its multiple, 1.
    pub factor: f64,
    /// The muscles that bind there, the one that would raise the load most first.
    pub binding: Vec<Binding>,
}

/// A muscle at a limit of its tension.
#[derive(Debug, Clone, Copy, PartialEq)]
pub struct Binding {
    /// Its index.
    pub muscle: usize,
    /// Whether at the largest tension; at the least one otherwise.
    pub largest: bool,
    /// Increase of the multiple per N by which the limit is relaxed, 1/N.
    pub gain: f64,
}

/// Cuts after which a search ends.
const MOST_CUTS: usize = 200;
/// Relative change of the multiple at convergence.
const CONVERGED: f64 = 1e-11;
/// Least gain of a muscle that binds, relative to the largest one.
const LEAST_GAIN: f64 = 1e-7;

impl LoadSearch {
    /// For a number of muscles and joints.
    #[must_use]
    pub fn new(muscles: usize, joints: usize) -> Self {
        Self {
            distribution: Distribution::new(muscles, joints),
            zeros: vec![0.0; muscles],
            ones: vec![1.0; muscles],
            minimum: vec![0.0; muscles],
            maximum: vec![0.0; muscles],
            torque: vec![0.0; joints],
        }
    }

    /// The largest load; none where the muscles do not give the torque that is needed without it. A load that
    /// needs no torque has an infinite multiple.
    ///
    /// # Shapes
    /// `moment_arms: [muscles x joints]`, `limits: [muscles]`, `needed` and `load: [joints]`.
    ///
    /// # Errors
    /// As [`TorqueSet::new`] and [`Distribution::solve`].
    pub fn largest(
        &mut self,
        moment_arms: &[f64],
        limits: &[[f64; 2]],
        needed: &[f64],
        load: &[f64],
    ) -> Result<Option<LargestLoad>, Error> {
        let joints = self.torque.len();
        check_length("limits", limits.len(), self.zeros.len())?;
        check_entries("needed", needed, joints)?;
        check_entries("load", load, joints)?;
        let set = TorqueSet::new(moment_arms, joints, limits)?;
        for (k, [least, most]) in limits.iter().enumerate() {
            (self.minimum[k], self.maximum[k]) = (*least, *most);
        }
        if !self.reached(moment_arms, needed, load, 0.0)? {
            return Ok(None);
        }
        if load.iter().all(|x| *x == 0.0) {
            return Ok(Some(LargestLoad { factor: f64::INFINITY, binding: Vec::new() }));
        }
        let mut normal = load.to_vec();
        let mut factor = f64::INFINITY;
        for _ in 0..MOST_CUTS {
            let slope = dot(&normal, load);
            let cut = (set.support(&normal)? - dot(&normal, needed)) / slope;
            if !cut.is_finite() || slope <= 0.0 || cut >= factor * (1.0 - CONVERGED) {
                break;
            }
            factor = cut.max(0.0);
            if self.reached(moment_arms, needed, load, factor)? || factor == 0.0 {
                break;
            }
            normal.copy_from_slice(&self.torque);
        }
        let slope = dot(&normal, load);
        Ok(Some(LargestLoad { factor, binding: binding(moment_arms, &normal, slope) }))
    }

    /// Whether `needed + factor load` is a torque of the muscles; otherwise `torque` is the residual of the
    /// closest one.
    fn reached(
        &mut self,
        moment_arms: &[f64],
        needed: &[f64],
        load: &[f64],
        factor: f64,
    ) -> Result<bool, Error> {
        let Self { distribution, zeros, ones, minimum, maximum, torque } = self;
        for ((torque, needed), load) in torque.iter_mut().zip(needed).zip(load) {
            *torque = needed + factor * load;
        }
        let problem = Problem { moment_arms, torque, minimum, maximum, reference: zeros, weight: ones };
        let solution = distribution.solve(&problem)?;
        let reached = solution.status == Status::Optimal;
        torque.copy_from_slice(solution.residual);
        Ok(reached)
    }
}

fn dot(a: &[f64], b: &[f64]) -> f64 {
    a.iter().zip(b).map(|(a, b)| a * b).sum()
}

/// The muscles on either side of the half space that limits the load.
fn binding(moment_arms: &[f64], normal: &[f64], slope: f64) -> Vec<Binding> {
    let gain = |row: &[f64]| dot(row, normal) / slope;
    let rows = moment_arms.chunks_exact(normal.len());
    let most = rows.clone().map(|row| gain(row).abs()).fold(0.0, f64::max);
    let of = |(muscle, row): (usize, &[f64])| {
        let gain = gain(row);
        (gain.abs() > LEAST_GAIN * most).then_some(Binding { muscle, largest: gain > 0.0, gain: gain.abs() })
    };
    let mut binding: Vec<Binding> = rows.enumerate().filter_map(of).collect();
    binding.sort_by(|a, b| b.gain.total_cmp(&a.gain));
    binding
}
