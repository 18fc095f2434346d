use super::joint_observer::JointObserver;
use crate::Error;
use crate::muscle::MuscleDynamics;
use crate::predictor::CableModel;
use alloc::vec;
use alloc::vec::Vec;

/// How firmly the muscles hold every joint, and the torque that the observers attribute to disturbances: the
/// redundancy of motor encoders and joint encoders.
///
/// ```text
/// k_j = sum_i K_i R_ij^2,   K_i = 1/sum_c c_c,     tau_d = M d^
/// ```
///
/// | symbol | meaning                                                             | unit    |
/// |--------|---------------------------------------------------------------------|---------|
/// | M, R   | mass matrix, moment arms                                             | kg m^2, m |
/// | K, c   | stiffness of a cable, compliance of its cells                          | N/m, m/N |
/// | d^     | disturbances of the joints' observers                                  | rad/s^2 |
/// | k_j    | torque of the model per angle by which joint j is off its muscles        | Nm/rad  |
///
/// An angle of joint `j` that is wrong by `x` makes the estimated tensions wrong by `-K R x` and the torque
/// at that joint by `-k_j x`. The disturbances of all joints compensate the accelerations that follow from
/// it; their torque at joint `j`, unlike its own acceleration, does not depend on how light its neighbours
/// are.
///
/// # Assumes
/// The whole cable slides; where a part of it sticks, the remainder is stiffer, and `x = -tau_d/k` is too
/// large.
///
/// # Source
/// Analytical redundancy as in `chow1984`: a residual of measurements that a model relates.
#[derive(Debug, Clone)]
pub(super) struct JointStiffness {
    /// `K_i`, N/m: `[muscles]`.
    pub(super) cables: Vec<f64>,
    /// `k_j`, Nm/rad or N/m: `[joints]`.
    pub(super) joints: Vec<f64>,
    /// `tau_d`, Nm or N: `[joints]`.
    pub(super) disturbance_torque: Vec<f64>,
}

/// Least `k_j`, Nm/rad: of a joint without muscles.
const LEAST: f64 = 1e-9;

impl JointStiffness {
    /// # Errors
    /// As [`CableModel::law`].
    pub(super) fn new(models: &[CableModel], joints: usize) -> Result<Self, Error> {
        let stiffness = |model: &CableModel| Ok(1.0 / model.law()?.compliance().iter().sum::<f64>());
        Ok(Self {
            cables: models.iter().map(stiffness).collect::<Result<_, Error>>()?,
            joints: vec![f64::INFINITY; joints],
            disturbance_torque: vec![0.0; joints],
        })
    }

    /// In the evaluated pose of the body, with the observers' disturbances and mass matrix.
    pub(super) fn update(&mut self, body: &MuscleDynamics, observer: &JointObserver) {
        let joints = self.joints.len();
        self.joints.fill(LEAST);
        for (muscle, stiffness) in self.cables.iter().enumerate() {
            body.crossings(muscle).for_each(|(joint, arm)| self.joints[joint] += stiffness * arm * arm);
        }
        for (torque, row) in self.disturbance_torque.iter_mut().zip(observer.mass.chunks_exact(joints)) {
            *torque = row.iter().zip(&observer.disturbance).map(|(mass, d)| mass * d).sum();
        }
    }
}

#[cfg(test)]
mod tests {
    use super::*;
    use crate::body::{PathElement, Robot, TendonPath, cholesky};
    use crate::control::arm::gains::ArmGains;

    /// A chain whose second muscle crosses its last two joints, the last of them with a light body.
    fn light_chain() -> Robot {
        let mut parts = crate::muscle::tests::robots::chain(false).parts().clone();
        parts.tendons[1].path = TendonPath::Spatial([PathElement::Site(2), PathElement::Site(5)].to_vec());
        parts.bodies[3].mass = 3e-3;
        parts.bodies[3].inertia = [1e-6, 1e-6, 1e-6, 0.0, 0.0, 0.0];
        Robot::new(parts).unwrap()
    }

    #[test]
    fn the_torque_of_the_disturbances_tells_by_how_much_a_joint_is_off_beside_a_light_neighbour() {
        let (n, x) = (3, 0.01);
        let models = vec![CableModel::bench(); 3];
        let mut body = MuscleDynamics::new(&light_chain()).unwrap();
        body.evaluate(&[0.1, 0.2, -0.3]).unwrap();
        let mut stiffness = JointStiffness::new(&models, n).unwrap();
        let mut observer = JointObserver::new(&models, &ArmGains::for_tests(3, n)).unwrap();
        body.mass_matrix(&mut observer.mass).unwrap();
        let mut factor = observer.mass.clone();
        cholesky::factor(&mut factor, n).unwrap();
        for joint in 0..n {
            // Tensions by -K R x; the disturbances are the accelerations that they take away.
            let mut change = vec![0.0; n];
            for (row, k) in body.moment_arms().chunks_exact(n).zip(&stiffness.cables) {
                change.iter_mut().zip(row).for_each(|(sum, arm)| *sum -= arm * k * row[joint] * x);
            }
            cholesky::solve(&factor, &mut change);
            observer.disturbance.copy_from_slice(&change);
            stiffness.update(&body, &observer);
            let told = -stiffness.disturbance_torque[joint] / stiffness.joints[joint];
            assert!((told - x).abs() < 1e-9, "{joint}: {told}");
            // The joint's own acceleration has the wrong sign where its neighbour is light.
            assert_eq!(change[joint] > 0.0, joint == 1, "{joint}: {change:?}");
        }
    }
}
