use super::gains::ArmGains;
use crate::Error;
use crate::body::cholesky;
use crate::muscle::MuscleDynamics;
use crate::predictor::CableModel;
use alloc::vec;
use alloc::vec::Vec;

/// Coordinate, velocity and disturbance of every joint: one extended state observer per joint, integrated
/// implicitly where cables and springs hold the joints, or where dampers stop them within a step.
///
/// ```text
/// e = q_m - q^,   w = w_o clip(|e|/e_0, 1, r)
/// (M + h D + h^2 K) dv = h f + M h (d^ + 3 w^2 e)
/// K = R^T diag(1/c_b) R + R_s^T diag(k) R_s + diag(k_j),   D = diag(b_j)
/// k_j = b_j = 0 where no joint has  h b_j + h^2 k_j > M_jj
/// q'^ += dv,   q^ += h (q'^ + 3 w e),   d^ += h w^3 e
/// ```
///
/// | symbol | meaning                                                                     | unit    |
/// |--------|-----------------------------------------------------------------------------|---------|
/// | q_m    | measured coordinate                                                         | rad or m |
/// | f      | force of the model under the estimated tensions, (23) with `d = 0`: `M a`     | Nm or N |
/// | d^     | disturbance: errors of masses, friction and tensions, `M^-1 (-d)` of (23)      | rad/s^2 |
/// | w_o    | bandwidth                                                                   | rad/s   |
/// | e_0, r | threshold of the innovation above which the bandwidth grows, largest growth   | rad, 1  |
/// | M, R   | mass matrix and moment arms                                                  | kg m^2, m |
/// | c_b    | compliance of a cable whose far end sticks, its last cell                      | m/N     |
/// | R_s, k | moment arms and stiffnesses of the springs of tendons that are not slack        | m, N/m  |
/// | k_j, b_j | stiffness and damping of the joints                                           | Nm/rad, Nm s/rad, or N/m, N s/m |
///
/// The estimated tensions follow `q^`: a far end that sticks is a spring, whose mode an explicit step of `h`
/// cannot integrate above `sqrt(3 w_o/h)`, 417 rad/s at a millisecond; nor can it a finger's link of a gram
/// in a joint with friction, `b_j/M` above `2/h`. Without a measurement, `e = 0`: the joint moves on its
/// model. The low bandwidth filters the encoder's quantisation; the high one follows a joint that breaks
/// away from stiction.
///
/// # Departs
/// The implicit step has no term `-h^2 K q'^` on the right: the winch moves along, so that it would only be a
/// drag.
///
/// # Source
/// Textbook: Luenberger's observer with the disturbance as third state, all poles at `-w`; linearly implicit
/// integration.
#[derive(Debug, Clone)]
pub(super) struct JointObserver {
    bandwidth: f64,
    innovation_threshold: Vec<f64>,
    max_bandwidth_ratio: f64,
    /// `1/c_b`, N/m: `[muscles]`.
    stiffness: Vec<f64>,
    /// `M` of the last step, row by row: `[joints x joints]`.
    pub(super) mass: Vec<f64>,
    augmented: Vec<f64>,
    impulse: Vec<f64>,
    /// `e`, rad or m, 0 without a measurement: `[joints]`.
    pub(super) innovation: Vec<f64>,
    change: Vec<f64>,
    /// `q^`, rad or m: `[joints]`.
    pub(super) q: Vec<f64>,
    /// `q'^`, per s: `[joints]`.
    pub(super) v: Vec<f64>,
    /// `d^`, per s^2: `[joints]`.
    pub(super) disturbance: Vec<f64>,
}

impl JointObserver {
    /// # Errors
    /// As [`CableModel::law`].
    pub(super) fn new(models: &[CableModel], gains: &ArmGains) -> Result<Self, Error> {
        let joints = gains.joints.len();
        let stiffness = |model: &CableModel| Ok(model.law()?.compliance().last().map_or(0.0, |c| 1.0 / c));
        Ok(Self {
            bandwidth: gains.observer_bandwidth,
            innovation_threshold: gains.joints.iter().map(|joint| joint.innovation_threshold).collect(),
            max_bandwidth_ratio: gains.max_bandwidth_ratio,
            stiffness: models.iter().map(stiffness).collect::<Result<_, Error>>()?,
            mass: vec![0.0; joints * joints],
            augmented: vec![0.0; joints * joints],
            impulse: vec![0.0; joints],
            innovation: vec![0.0; joints],
            change: vec![0.0; joints],
            q: vec![0.0; joints],
            v: vec![0.0; joints],
            disturbance: vec![0.0; joints],
        })
    }

    /// Sets the state to the measured coordinates at rest, without disturbance.
    pub(super) fn initialize(&mut self, measured: &[f64]) {
        self.q.copy_from_slice(measured);
        self.v.fill(0.0);
        self.disturbance.fill(0.0);
        self.innovation.fill(0.0);
    }

    /// One step of `h` s with the measured coordinates, NaN where there is none, and the model's force in the
    /// evaluated pose of the body.
    ///
    /// # Errors
    /// [`Error::OutOfDomain`] where the mass matrix is not positive definite.
    pub(super) fn update(
        &mut self,
        h: f64,
        measured: &[f64],
        force: &[f64],
        body: &mut MuscleDynamics,
    ) -> Result<(), Error> {
        let n = self.q.len();
        for (k, measured) in measured.iter().enumerate() {
            let e = if measured.is_finite() { measured - self.q[k] } else { 0.0 };
            self.innovation[k] = e;
            let ratio = (e.abs() / self.innovation_threshold[k]).clamp(1.0, self.max_bandwidth_ratio);
            let w = self.bandwidth * ratio;
            self.impulse[k] = h * (self.disturbance[k] + 3.0 * w * w * e);
            self.q[k] += h * 3.0 * w * e;
            self.disturbance[k] += h * w * w * w * e;
        }
        self.augment_mass(h, body)?;
        for ((change, row), force) in self.change.iter_mut().zip(self.mass.chunks_exact(n)).zip(force) {
            let momentum: f64 = row.iter().zip(&self.impulse).map(|(mass, impulse)| mass * impulse).sum();
            *change = h * force + momentum;
        }
        cholesky::factor(&mut self.augmented, n)?;
        cholesky::solve(&self.augmented, &mut self.change);
        for k in 0..n {
            self.v[k] += self.change[k];
            self.q[k] += h * self.v[k];
        }
        Ok(())
    }

    /// `M + h D + h^2 K`; the lower triangle suffices.
    fn augment_mass(&mut self, h: f64, body: &mut MuscleDynamics) -> Result<(), Error> {
        let n = self.q.len();
        body.mass_matrix(&mut self.mass)?;
        self.augmented.copy_from_slice(&self.mass);
        let resistances = || body.joint_springs().map(|(joint, k, b)| (joint * (n + 1), h * b + h * h * k));
        // Otherwise an explicit step is as good. A link that is stopped makes those before it lighter.
        if resistances().any(|(own, resistance)| resistance > self.mass[own]) {
            resistances().for_each(|(own, resistance)| self.augmented[own] += resistance);
        }
        let stretched = body.springs().filter(|spring| spring.stretch != 0.0);
        let springs = stretched.map(|spring| (spring.cable, spring.stiffness));
        for (cable, stiffness) in self.stiffness.iter().copied().enumerate().chain(springs) {
            for (i, arm) in body.crossings(cable) {
                let weighted = h * h * stiffness * arm;
                for (j, other) in body.crossings(cable).filter(|(j, _)| *j <= i) {
                    self.augmented[i * n + j] += weighted * other;
                }
            }
        }
        Ok(())
    }
}

#[cfg(test)]
mod tests {
    use super::*;
    use crate::body::{PathElement, Robot, TendonPath};

    const H: f64 = 2e-3;

    /// A chain whose second muscle crosses its last two joints, so that the cables couple them.
    fn coupled_by_a_cable() -> Robot {
        let mut parts = crate::muscle::tests::robots::chain(false).parts().clone();
        parts.tendons[1].path = TendonPath::Spatial([PathElement::Site(2), PathElement::Site(5)].to_vec());
        Robot::new(parts).unwrap()
    }

    fn models() -> Vec<CableModel> {
        let of = |k: usize| {
            let mut model = CableModel::bench();
            model.parameters.compliance *= [1.0, 0.3, 2.0][k];
            model
        };
        (0..3).map(of).collect()
    }

    fn setup() -> (MuscleDynamics, JointObserver, ArmGains) {
        let mut body = MuscleDynamics::new(&coupled_by_a_cable()).unwrap();
        body.evaluate(&[0.1, 0.2, -0.3]).unwrap();
        let mut gains = ArmGains::for_tests(3, 3);
        gains.joints[1].innovation_threshold = 2e-3;
        let observer = JointObserver::new(&models(), &gains).unwrap();
        (body, observer, gains)
    }

    /// Solves a dense system by Gauss and Jordan.
    fn solved(mut a: Vec<Vec<f64>>, mut b: Vec<f64>) -> Vec<f64> {
        for k in 0..b.len() {
            let pivot = a[k][k];
            a[k].iter_mut().for_each(|x| *x /= pivot);
            b[k] /= pivot;
            for i in (0..b.len()).filter(|i| *i != k) {
                let factor = a[i][k];
                let row = a[k].clone();
                a[i].iter_mut().zip(&row).for_each(|(x, y)| *x -= factor * y);
                b[i] -= factor * b[k];
            }
        }
        b
    }

    /// The equations as they are written, with dense matrices: state `[q, v, d]` after a step.
    fn stepped(
        [q, v, d]: [&[f64]; 3],
        measured: &[f64],
        force: &[f64],
        body: &mut MuscleDynamics,
        gains: &ArmGains,
    ) -> [Vec<f64>; 3] {
        let n = 3;
        let mut mass = vec![0.0; n * n];
        body.mass_matrix(&mut mass).unwrap();
        let arms = body.moment_arms();
        let compliance: Vec<f64> =
            models().iter().map(|model| *model.law().unwrap().compliance().last().unwrap()).collect();
        let error = |j: usize| if measured[j].is_nan() { 0.0 } else { measured[j] - q[j] };
        let bandwidth = |j: usize| {
            let growth = error(j).abs() / gains.joints[j].innovation_threshold;
            gains.observer_bandwidth * growth.max(1.0).min(gains.max_bandwidth_ratio)
        };
        let stiffness = |i: usize, j: usize| -> f64 {
            (0..3).map(|k| arms[k * n + i] * arms[k * n + j] / compliance[k]).sum()
        };
        let of_joint = |i: usize| {
            let joint = &body.robot().parts().joints[i];
            H * joint.damping + H * H * joint.stiffness
        };
        let stops = (0..n).any(|i| of_joint(i) > mass[i * n + i]);
        let own = |i: usize, j: usize| if stops && i == j { of_joint(i) } else { 0.0 };
        let row = |i: usize| {
            (0..n).map(|j| mass[i * n + j] + H * H * stiffness(i, j) + own(i, j)).collect::<Vec<_>>()
        };
        let driven = |j: usize| d[j] + 3.0 * bandwidth(j) * bandwidth(j) * error(j);
        let right = |i: usize| H * force[i] + H * (0..n).map(|j| mass[i * n + j] * driven(j)).sum::<f64>();
        let change = solved((0..n).map(row).collect(), (0..n).map(right).collect());
        let v: Vec<f64> = (0..n).map(|j| v[j] + change[j]).collect();
        let q = (0..n).map(|j| q[j] + H * (v[j] + 3.0 * bandwidth(j) * error(j))).collect();
        let d = (0..n).map(|j| d[j] + H * bandwidth(j) * bandwidth(j) * bandwidth(j) * error(j)).collect();
        [q, v, d]
    }

    #[test]
    fn a_step_solves_the_equations_as_they_are_written() {
        let (mut body, mut observer, gains) = setup();
        observer.initialize(&[0.1, 0.2, -0.3]);
        let mut state = [vec![0.1, 0.2, -0.3], vec![0.0; 3], vec![0.0; 3]];
        for k in 0..12 {
            let t = f64::from(k);
            // Within the threshold, above it and beyond its largest growth; one that comes and goes.
            let measured = [
                state[0][0] + 1e-3 * libm::sin(t),
                state[0][1] + 6e-3 * libm::cos(t),
                if k % 3 == 1 { f64::NAN } else { state[0][2] - 0.04 },
            ];
            let force = [0.3, -0.2 * t, 0.1];
            let [q, v, d] = &state;
            let next = stepped([q, v, d], &measured, &force, &mut body, &gains);
            let innovation = [0, 1, 2].map(|j| measured[j] - q[j]);
            observer.update(H, &measured, &force, &mut body).unwrap();
            for (found, expected) in [&observer.q, &observer.v, &observer.disturbance].into_iter().zip(&next)
            {
                for (found, expected) in found.iter().zip(expected) {
                    assert!(
                        (found - expected).abs() < 1e-12 * (1.0 + expected.abs()),
                        "{k}: {found} {expected}"
                    );
                }
            }
            for (found, expected) in observer.innovation.iter().zip(innovation) {
                let expected = if expected.is_nan() { 0.0 } else { expected };
                assert!((found - expected).abs() < 1e-12, "{k}: {found} {expected}");
            }
            state = next;
        }
    }

    #[test]
    fn a_joint_at_rest_under_a_constant_force_is_found_at_rest_with_the_disturbance_that_balances_it() {
        let (mut body, mut observer, _) = setup();
        let (pose, force) = ([0.1, 0.2, -0.3], [0.4, -0.3, 0.2]);
        observer.initialize(&pose);
        for _ in 0..2000 {
            observer.update(H, &pose, &force, &mut body).unwrap();
        }
        // M d = -f.
        for (row, force) in observer.mass.chunks_exact(3).zip(force) {
            let torque: f64 = row.iter().zip(&observer.disturbance).map(|(mass, d)| mass * d).sum();
            assert!((torque + force).abs() < 1e-9, "{torque} {force}");
        }
        assert!(observer.v.iter().all(|v| v.abs() < 1e-9), "{:?}", observer.v);
        assert!(observer.q.iter().zip(pose).all(|(q, pose)| (q - pose).abs() < 1e-9), "{:?}", observer.q);
        // Without any measurement it stays there.
        for _ in 0..500 {
            observer.update(H, &[f64::NAN; 3], &force, &mut body).unwrap();
        }
        assert!(observer.q.iter().zip(pose).all(|(q, pose)| (q - pose).abs() < 1e-7), "{:?}", observer.q);
    }

    #[test]
    fn initialized_it_is_at_the_measured_coordinates_at_rest_and_without_disturbance() {
        let (mut body, mut observer, _) = setup();
        for _ in 0..5 {
            observer.update(H, &[0.2, 0.1, -0.2], &[1.0, 2.0, 3.0], &mut body).unwrap();
        }
        observer.initialize(&[0.5, -0.6, 0.7]);
        for (found, expected) in [
            (&observer.q, [0.5, -0.6, 0.7]),
            (&observer.v, [0.0; 3]),
            (&observer.disturbance, [0.0; 3]),
            (&observer.innovation, [0.0; 3]),
        ] {
            assert!(found.iter().zip(expected).all(|(a, b)| (a - b).abs() < 1e-18), "{found:?}");
        }
    }

    #[test]
    fn a_damper_that_stops_a_link_within_a_step_does_not_throw_the_estimate() {
        let mut parts = coupled_by_a_cable().parts().clone();
        parts.joints.iter_mut().for_each(|joint| joint.damping = 1e4);
        let mut body = MuscleDynamics::new(&Robot::new(parts).unwrap()).unwrap();
        let pose = [0.1, 0.2, -0.3];
        body.evaluate(&pose).unwrap();
        let mut observer = JointObserver::new(&models(), &ArmGains::for_tests(3, 3)).unwrap();
        observer.initialize(&pose);
        observer.v.fill(1.0);
        for _ in 0..100 {
            let mut force = [0.0; 3];
            body.accelerating_force(&observer.v, &[0.0; 3], &mut force).unwrap();
            observer.update(H, &[f64::NAN; 3], &force, &mut body).unwrap();
        }
        assert!(observer.v.iter().all(|v| v.abs() < 1e-3), "{:?}", observer.v);
    }

    #[test]
    fn the_step_is_implicit_in_the_last_cell_of_every_cable() {
        let (_, observer, _) = setup();
        for (stiffness, model) in observer.stiffness.iter().zip(models()) {
            let last = *model.law().unwrap().compliance().last().unwrap();
            assert!((stiffness * last - 1.0).abs() < 1e-12);
        }
    }
}
