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
/// Every step cuts off multiples that the half space `a^T tau <= h(a)` excludes. The last one touches the set
/// at the torque of the largest load: muscles on either side of it are at their limits and bind.
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
const MAX_CUTS: usize = 200;
/// Relative change of the multiple at convergence.
const CONVERGED: f64 = 1e-11;
/// Smallest gain of a muscle that binds, relative to the largest one.
const MIN_GAIN: f64 = 1e-7;

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
        for _ in 0..MAX_CUTS {
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
        (gain.abs() > MIN_GAIN * most).then_some(Binding { muscle, largest: gain > 0.0, gain: gain.abs() })
    };
    let mut binding: Vec<Binding> = rows.enumerate().filter_map(of).collect();
    binding.sort_by(|a, b| b.gain.total_cmp(&a.gain));
    binding
}

#[cfg(test)]
mod tests {
    use super::*;

    fn largest(arms: &[f64], limits: &[[f64; 2]], needed: &[f64], load: &[f64]) -> Option<LargestLoad> {
        LoadSearch::new(limits.len(), needed.len()).largest(arms, limits, needed, load).unwrap()
    }

    #[test]
    fn one_joint_holds_what_its_muscles_have_beyond_the_needed_torque() {
        let (arms, limits) = ([0.03, -0.02], [[10.0, 100.0], [5.0, 80.0]]);
        // Within -1.3 to 2.9 Nm.
        for (needed, load, expected, largest_first) in [
            (0.0, 2.0, 1.45, true),
            (0.9, 0.25, 8.0, true),
            (-0.5, 1e6, 3.4e-6, true),
            (0.0, -0.5, 2.6, false),
            (0.9, -4.0, 0.55, false),
        ] {
            let found = largest(&arms, &limits, &[needed], &[load]).unwrap();
            assert!((found.factor / expected - 1.0).abs() < 4e-16, "{} {expected}", found.factor);
            let [first, second] = found.binding[..] else { panic!("{:?}", found.binding) };
            assert_eq!((first.muscle, first.largest), (0, largest_first));
            assert_eq!((second.muscle, second.largest), (1, !largest_first));
            // A newton more is an arm's length more of torque.
            assert!((first.gain * load.abs() / 0.03 - 1.0).abs() < 1e-15);
            assert!((second.gain * load.abs() / 0.02 - 1.0).abs() < 1e-15);
        }
    }

    #[test]
    fn of_two_joints_the_one_that_gives_way_first_limits_the_load() {
        // Torques of 0 to 3 and 0 to 1 Nm.
        let (arms, limits) = ([0.03, 0.0, 0.0, 0.05], [[0.0, 100.0], [0.0, 20.0]]);
        for (needed, load, expected, muscle) in [
            ([0.0, 0.0], [1.0, 1.0], 1.0, 1),
            ([0.5, 0.25], [2.0, 0.5], 1.25, 0),
            ([0.5, 0.25], [0.5, 2.0], 0.375, 1),
            ([2.0, 0.5], [-4.0, 0.25], 0.5, 0),
        ] {
            let found = largest(&arms, &limits, &needed, &load).unwrap();
            assert!((found.factor - expected).abs() < 2e-15, "{} {expected}", found.factor);
            assert_eq!(found.binding.len(), 1, "{:?}", found.binding);
            let one = found.binding[0];
            assert_eq!((one.muscle, one.largest), (muscle, load[muscle] > 0.0));
            let gain = arms[3 * muscle] / load[muscle].abs();
            assert!((one.gain - gain).abs() < 1e-15, "{} {gain}", one.gain);
        }
    }

    #[test]
    fn nothing_more_is_held_where_the_needed_torque_is_the_largest_already() {
        let found = largest(&[0.03], &[[0.0, 100.0]], &[3.0], &[1.0]).unwrap();
        assert!(found.factor.abs() < 1e-15 && found.binding[0].muscle == 0, "{found:?}");
        // A joint that no muscle moves holds no load, and no muscle would help.
        let found = largest(&[0.03, 0.0], &[[0.0, 100.0]], &[1.0, 0.0], &[0.0, 1.0]).unwrap();
        assert_eq!(found, LargestLoad { factor: 0.0, binding: Vec::new() });
    }
}
