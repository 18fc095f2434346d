use super::gains::ArmGains;
use crate::body::cholesky;
use crate::muscle::MuscleDynamics;
use alloc::vec;
use alloc::vec::Vec;

/// Tells a cable that has broken from a joint without an encoder that is not where it is estimated, by the
/// load cells of all muscles that cross such joints.
///
/// ```text
/// T_i - T_i^ = a_i.x + e_i,   a_ij = -K_i R_ij,   x ~ N(0, s_x^2),   e_i ~ N(0, s_i^2)
/// s_i = 4 s + 0.2 max(T_i^, dT)
/// A = diag(1/s_x^2) + sum_{i /= k} a_i a_i^T/s_i^2,   x = A^-1 sum_{i /= k} a_i (T_i - T_i^)/s_i^2
/// missing:  T_k < 0.2 T'   and   T' - T_k > max(dT, 3 (a_k^T A^-1 a_k)^1/2),   T' = T_k^ + 4 min(a_k.x, 0)
/// broken:   of the muscles that cross a joint with k, that with T_i < 0.2 T_i^, T_i^ - T_i > 8 s for longest
/// ```
///
/// | symbol | meaning                                                                  | unit     |
/// |--------|--------------------------------------------------------------------------|----------|
/// | T, T^  | measured and estimated tension at the drive's outlet                       | N        |
/// | x      | error of the estimated pose of the joints without encoders                 | rad or m |
/// | K, R   | stiffness of a cable, moment arms                                          | N/m, m   |
/// | s, s_x | noise of the load cell; tracking error at which the joint is lost           | N, rad or m |
/// | dT     | [`MuscleGains::missing_tension`](super::gains::MuscleGains)                 | N        |
///
/// A joint that has given way makes its antagonists tauter, at their drives less than at their anchors by the
/// friction of their sheaths, a factor of 4 at most; a broken cable does not. The joint then goes to
/// the antagonists, and they become slack as well, but later. Where no other muscle holds a joint, `A` is
/// small, and nothing is concluded.
///
/// The observers of these cables are not corrected by the cells: that would take the difference for travel
/// of the winch, and let go of the joint that only the cables hold.
///
/// # Source
/// Least squares with a prior, as usual; analytical redundancy as in `chow1984`.
#[derive(Debug, Clone)]
pub(super) struct UnmeasuredJoints {
    /// Place of every joint among those without encoders: `[joints]`.
    place: Vec<Option<usize>>,
    /// `1/s_x^2` of the joints without encoders.
    information: Vec<f64>,
    /// Whether a muscle crosses one: `[muscles]`.
    pub(super) crossed: Vec<bool>,
    /// Whether its tension is missing: `[muscles]`.
    pub(super) missing: Vec<bool>,
    /// Time for which it has been below a fifth of its estimate, s: `[muscles]`.
    lacking_for: Vec<f64>,
    /// Whether two muscles cross the same one: `[muscles x muscles]`.
    neighbours: Vec<bool>,
    /// The readings that correct observers, N, NaN for the others: `[muscles]`.
    pub(super) correcting: Vec<f64>,
    /// `s`, N, `K`, N/m, `dT`, N: `[muscles]`.
    muscles: Vec<[f64; 3]>,
    /// `A` and its factor, row by row; `x`; `a` of one muscle.
    matrix: Vec<f64>,
    error: Vec<f64>,
    row: Vec<f64>,
}

/// Fraction of its estimate below which a tension is missing, 1.
const MISSING: f64 = 0.2;
/// Error of an estimated tension, as a fraction of it, 1.
const MODEL_ERROR: f64 = 0.2;
/// Standard deviations of a load cell's noise, and of what the other cells say, 1.
const NOISE: f64 = 4.0;
const LACKING_NOISE: f64 = 8.0;
const UNCERTAINTY: f64 = 3.0;

/// Factor by which friction may hide the motion of a joint from its load cells, 1.
const HIDDEN: f64 = 4.0;

impl UnmeasuredJoints {
    /// With the stiffness of every cable, N/m.
    pub(super) fn new(body: &MuscleDynamics, gains: &ArmGains, stiffness: &[f64]) -> Self {
        let without = gains.joints.iter().filter(|joint| !joint.encoder);
        let information: Vec<f64> = without.map(|joint| inverse_square(joint.tracking_error)).collect();
        let count = stiffness.len();
        let mut next = 0..;
        let place = gains.joints.iter().map(|joint| if joint.encoder { None } else { next.next() }).collect();
        let muscles = gains.muscles.iter().zip(stiffness);
        let n = information.len();
        let share = |(a, b): (usize, usize)| {
            let other = || body.crossings(b).map(|(joint, _)| joint);
            body.crossings(a).any(|(joint, _)| !gains.joints[joint].encoder && other().any(|j| j == joint))
        };
        Self {
            crossed: (0..count)
                .map(|k| body.crossings(k).any(|(joint, _)| !gains.joints[joint].encoder))
                .collect(),
            muscles: muscles.map(|(m, k)| [m.load_cell_noise, *k, m.missing_tension]).collect(),
            missing: vec![false; count],
            lacking_for: vec![0.0; count],
            neighbours: (0..count).flat_map(|a| (0..count).map(move |b| (a, b))).map(share).collect(),
            correcting: vec![f64::NAN; count],
            place,
            information,
            matrix: vec![0.0; n * n],
            error: vec![0.0; n],
            row: vec![0.0; n],
        }
    }

    /// The next readings are the first.
    pub(super) fn restart(&mut self) {
        self.missing.fill(false);
        self.lacking_for.fill(0.0);
    }

    /// Compares the load cells with their estimates, in the evaluated pose of the body.
    pub(super) fn update(&mut self, h: f64, measured: &[f64], estimated: &[f64], body: &MuscleDynamics) {
        for (k, (measured, estimated)) in measured.iter().zip(estimated).enumerate() {
            self.correcting[k] = if self.crossed[k] { f64::NAN } else { *measured };
            let [noise, ..] = self.muscles[k];
            let lacks = self.crossed[k]
                && *measured < MISSING * estimated
                && estimated - measured > LACKING_NOISE * noise;
            self.lacking_for[k] = if lacks { self.lacking_for[k] + h } else { 0.0 };
        }
        for k in 0..measured.len() {
            self.missing[k] = self.crossed[k] && self.is_missing(k, measured, estimated, body);
        }
    }

    /// The muscle whose cable has broken, where the tension of `muscle` is missing.
    pub(super) fn broken(&self, muscle: usize) -> usize {
        let count = self.crossed.len();
        let neighbours = (0..count).filter(|other| self.neighbours[muscle * count + other]);
        let longest = neighbours.max_by(|a, b| self.lacking_for[*a].total_cmp(&self.lacking_for[*b]));
        longest.unwrap_or(muscle)
    }

    /// Whether a tension is missing that no pose of the joints explains.
    fn is_missing(
        &mut self,
        muscle: usize,
        measured: &[f64],
        estimated: &[f64],
        body: &MuscleDynamics,
    ) -> bool {
        let [_, _, missing] = self.muscles[muscle];
        let lacks = |expected: f64, least: f64| {
            measured[muscle] < MISSING * expected && expected - measured[muscle] > least
        };
        if !lacks(estimated[muscle], missing) {
            return false;
        }
        let n = self.information.len();
        self.matrix.fill(0.0);
        self.error.fill(0.0);
        self.matrix.iter_mut().step_by(n + 1).zip(&self.information).for_each(|(a, s)| *a = *s);
        for other in (0..measured.len()).filter(|other| *other != muscle) {
            let difference = measured[other] - estimated[other];
            if !self.crossed[other] || !difference.is_finite() {
                continue;
            }
            self.take_row(other, body);
            let [noise, ..] = self.muscles[other];
            let weight = inverse_square(NOISE * noise + MODEL_ERROR * estimated[other].max(missing));
            for (i, a) in self.row.iter().enumerate() {
                self.error[i] += weight * a * difference;
                let row = &mut self.matrix[i * n..(i + 1) * n];
                row.iter_mut().zip(&self.row).for_each(|(entry, b)| *entry += weight * a * b);
            }
        }
        if cholesky::factor(&mut self.matrix, n).is_err() {
            return false;
        }
        cholesky::solve(&self.matrix, &mut self.error);
        self.take_row(muscle, body);
        let shift: f64 = self.row.iter().zip(&self.error).map(|(a, x)| a * x).sum();
        cholesky::solve_lower(&self.matrix, &mut self.row);
        let variance: f64 = self.row.iter().map(|a| a * a).sum();
        let expected = estimated[muscle] + HIDDEN * shift.min(0.0);
        lacks(expected, missing.max(UNCERTAINTY * libm::sqrt(variance)))
    }

    fn take_row(&mut self, muscle: usize, body: &MuscleDynamics) {
        self.row.fill(0.0);
        let [_, stiffness, _] = self.muscles[muscle];
        for (joint, arm) in body.crossings(muscle) {
            if let Some(place) = self.place[joint] {
                self.row[place] = -stiffness * arm;
            }
        }
    }
}

fn inverse_square(deviation: f64) -> f64 {
    1.0 / (deviation * deviation)
}

#[cfg(test)]
mod tests {
    use super::*;
    use crate::muscle::tests::robots::lever;

    const STIFFNESS: f64 = 25e3;

    impl UnmeasuredJoints {
        /// Of a machine all of whose joints have encoders.
        pub(in crate::control::arm) fn all_measured(muscles: usize) -> Self {
            let mut body = MuscleDynamics::new(&lever()).unwrap();
            body.evaluate(&[0.2]).unwrap();
            let none = Self::new(&body, &ArmGains::for_tests(2, 1), &[STIFFNESS; 2]);
            Self {
                crossed: vec![false; muscles],
                missing: vec![false; muscles],
                correcting: vec![f64::NAN; muscles],
                ..none
            }
        }
    }

    /// Two antagonists at a joint without an encoder, in the pose in which their moment arms are equal, whose
    /// tensions are estimated as 60 N.
    fn missing(measured: [f64; 2]) -> Vec<bool> {
        let mut body = MuscleDynamics::new(&lever()).unwrap();
        body.evaluate(&[0.0]).unwrap();
        let mut gains = ArmGains::for_tests(2, 1);
        gains.joints[0].encoder = false;
        let mut joints = UnmeasuredJoints::new(&body, &gains, &[STIFFNESS; 2]);
        joints.update(1e-3, &measured, &[60.0; 2], &body);
        assert_eq!(joints.crossed, [true; 2]);
        assert!(joints.correcting.iter().all(|tension| tension.is_nan()));
        joints.missing
    }

    #[test]
    fn a_tension_that_falls_alone_is_missing_and_one_that_its_antagonist_has_taken_over_is_not() {
        assert_eq!(missing([60.0, 60.0]), [false; 2]);
        assert_eq!(missing([0.0, 60.0]), [true, false]);
        assert_eq!(missing([0.0, 50.0]), [true, false]);
        assert_eq!(missing([60.0, 0.0]), [false, true]);
        // The joint has given way: the other cable has what this one lacks.
        assert_eq!(missing([0.0, 130.0]), [false; 2]);
        assert_eq!(missing([130.0, 0.0]), [false; 2]);
        // A fifth of the estimate is the limit.
        assert_eq!(missing([12.1, 60.0]), [false; 2]);
    }

    #[test]
    fn of_two_cables_without_tension_that_has_broken_which_lost_it_first() {
        let mut body = MuscleDynamics::new(&lever()).unwrap();
        body.evaluate(&[0.2]).unwrap();
        let mut gains = ArmGains::for_tests(2, 1);
        gains.joints[0].encoder = false;
        for first in [0, 1] {
            let mut joints = UnmeasuredJoints::new(&body, &gains, &[STIFFNESS; 2]);
            let mut measured = [40.0; 2];
            for now_slack in [first, 1 - first] {
                measured[now_slack] = 0.0;
                (0..10).for_each(|_| joints.update(1e-3, &measured, &[6.0, 5.0], &body));
            }
            assert_eq!([0, 1].map(|muscle| joints.broken(muscle)), [first; 2]);
        }
    }

    #[test]
    fn a_muscle_that_alone_holds_a_joint_is_not_judged() {
        assert_eq!(missing([0.0, f64::NAN]), [false; 2]);
        assert_eq!(missing([f64::NAN, 0.0]), [false; 2]);
    }

    #[test]
    fn load_cells_correct_the_observers_of_machines_whose_joints_are_measured() {
        let mut body = MuscleDynamics::new(&lever()).unwrap();
        body.evaluate(&[0.2]).unwrap();
        let mut joints = UnmeasuredJoints::all_measured(2);
        joints.update(1e-3, &[0.0, 50.0], &[60.0, 50.0], &body);
        assert_eq!((joints.missing, joints.correcting), (vec![false; 2], vec![0.0, 50.0]));
    }
}
