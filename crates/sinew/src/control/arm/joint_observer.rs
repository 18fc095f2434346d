use super::gains::ArmGains;
use crate::Error;
use crate::body::cholesky;
use crate::muscle::MuscleDynamics;
use crate::predictor::CableModel;
use alloc::vec;
use alloc::vec::Vec;

/// Coordinate, velocity and disturbance of every joint: one extended state observer per joint, integrated
/// implicitly where the cables hold the joints.
///
/// ```text
/// e = q_m - q^,   w = w_o clip(|e|/e_0, 1, r)
/// (M + h^2 R^T diag(1/c_b) R) dv = h f + M h (d^ + 3 w^2 e)
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
///
/// The estimated tensions follow `q^`: a far end that sticks is a spring, whose mode an explicit step of `h`
/// cannot integrate above `sqrt(3 w_o/h)`, 417 rad/s at a millisecond. Without a measurement, `e = 0`: the joint
/// moves on its model. The low bandwidth filters the encoder's quantisation; the high one follows a joint that
/// breaks away from stiction.
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

    /// `M + h^2 R^T diag(1/c_b) R`; the lower triangle suffices.
    fn augment_mass(&mut self, h: f64, body: &mut MuscleDynamics) -> Result<(), Error> {
        let n = self.q.len();
        body.mass_matrix(&mut self.mass)?;
        self.augmented.copy_from_slice(&self.mass);
        for (muscle, stiffness) in self.stiffness.iter().enumerate() {
            for (i, arm) in body.crossings(muscle) {
                let weighted = h * h * stiffness * arm;
                for (j, other) in body.crossings(muscle).filter(|(j, _)| *j <= i) {
                    self.augmented[i * n + j] += weighted * other;
                }
            }
        }
        Ok(())
    }
}
