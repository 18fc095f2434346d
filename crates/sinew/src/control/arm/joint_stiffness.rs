use super::joint_observer::JointObserver;
use crate::Error;
use crate::muscle::MuscleDynamics;
use crate::predictor::CableModel;
use alloc::vec;
use alloc::vec::Vec;

/// How firmly the muscles hold every joint: the redundancy of motor encoders and joint encoders.
///
/// ```text
/// W_k^2 = (M^-1 R^T K R)_kk,      K_i = 1/sum_j c_j
/// ```
///
/// | symbol | meaning                                                             | unit    |
/// |--------|---------------------------------------------------------------------|---------|
/// | M, R   | mass matrix, moment arms                                             | kg m^2, m |
/// | K, c   | stiffness of a cable, compliance of its cells                          | N/m, m/N |
/// | W_k^2  | acceleration of the model per angle by which joint k is off its muscles | 1/s^2   |
///
/// An angle of joint `k` that is wrong by `x` makes the estimated tensions wrong by `-K R x`, and the model's
/// acceleration by `-W_k^2 x`; the disturbance `d^` of the joint's observer compensates it. Forward dynamics
/// give `W_k^2` as a difference, of one joint every [`INTERVAL`] cycles.
///
/// # Assumes
/// The whole cable slides; where a part of it sticks, the remainder is stiffer, and `x = -d^/W^2` is too large.
///
/// # Source
/// Analytical redundancy as in `chow1984`: a residual of measurements that a model relates.
#[derive(Debug, Clone)]
pub(super) struct JointStiffness {
    /// `K_i`, N/m: `[muscles]`.
    pub(super) cables: Vec<f64>,
    /// `W_k^2`, 1/s^2: `[joints]`.
    pub(super) joints: Vec<f64>,
    tension: Vec<f64>,
    acceleration: Vec<f64>,
    cycle: usize,
}

/// Control cycles between two evaluations of one joint.
const INTERVAL: usize = 16;
/// Displacement of a joint in the difference, rad.
const DISPLACEMENT: f64 = 1e-3;
/// Least `W^2`, 1/s^2: of a joint without muscles.
const LEAST: f64 = 1.0;

impl JointStiffness {
    /// # Errors
    /// As [`CableModel::law`].
    pub(super) fn new(models: &[CableModel], joints: usize) -> Result<Self, Error> {
        let stiffness = |model: &CableModel| Ok(1.0 / model.law()?.compliance().iter().sum::<f64>());
        Ok(Self {
            cables: models.iter().map(stiffness).collect::<Result<_, Error>>()?,
            joints: vec![f64::INFINITY; joints],
            tension: vec![0.0; models.len()],
            acceleration: vec![0.0; joints],
            cycle: 0,
        })
    }

    /// Evaluates all joints in the first cycle, then one now and then, in the evaluated pose of the body under
    /// these tensions, N, which give this `acceleration`, rad/s^2.
    ///
    /// # Errors
    /// As [`MuscleDynamics::forward_dynamics`].
    pub(super) fn update(
        &mut self,
        body: &mut MuscleDynamics,
        observer: &JointObserver,
        tension: &[f64],
        acceleration: &[f64],
    ) -> Result<(), Error> {
        let joints = self.joints.len();
        let due = match self.cycle {
            0 => 0..joints,
            cycle if cycle.is_multiple_of(INTERVAL) => {
                let joint = cycle / INTERVAL - 1;
                joint..joint + 1
            }
            _ => 0..0,
        };
        for joint in due {
            self.evaluate(joint, body, observer, tension, acceleration)?;
        }
        self.cycle = if self.cycle == INTERVAL * joints { 1 } else { self.cycle + 1 };
        Ok(())
    }

    fn evaluate(
        &mut self,
        joint: usize,
        body: &mut MuscleDynamics,
        observer: &JointObserver,
        tension: &[f64],
        acceleration: &[f64],
    ) -> Result<(), Error> {
        let arms = body.moment_arms().chunks_exact(self.joints.len()).map(|row| row[joint]);
        for ((displaced, tension), (stiffness, arm)) in
            self.tension.iter_mut().zip(tension).zip(self.cables.iter().zip(arms))
        {
            *displaced = tension - stiffness * arm * DISPLACEMENT;
        }
        body.forward_dynamics(&observer.v, &self.tension, None, &mut self.acceleration)?;
        self.joints[joint] = ((acceleration[joint] - self.acceleration[joint]) / DISPLACEMENT).max(LEAST);
        Ok(())
    }
}
