use crate::Error;
use crate::body::Robot;
use crate::control::tension::{Distribution, Problem};
use crate::muscle::MuscleDynamics;
use alloc::vec;
use alloc::vec::Vec;

/// Tensions that balance gravity in a pose, N: `[muscles]`, between these limits, a fifth of the least
/// ones above them.
///
/// # Errors
/// [`Error::WrongLength`] where the pose is another robot's.
pub fn resting_tensions(robot: &Robot, q: &[f64], limits: &[[f64; 2]]) -> Result<Vec<f64>, Error> {
    let mut model = MuscleDynamics::new(robot)?;
    let (n, joints) = (model.muscles(), model.joints());
    let (zero, mut torque) = (vec![0.0; joints], vec![0.0; joints]);
    model.evaluate(q)?;
    model.inverse_dynamics(&zero, &zero, &mut torque)?;
    let (minimum, maximum): (Vec<f64>, Vec<f64>) =
        limits.iter().map(|[least, most]| ((1.0 + RESTING_SHARE) * least, *most)).unzip();
    let maximum: Vec<f64> = maximum.iter().zip(&minimum).map(|(most, least)| most.max(*least)).collect();
    let problem = Problem {
        moment_arms: model.moment_arms(),
        torque: &torque,
        minimum: &minimum,
        maximum: &maximum,
        reference: &vec![0.0; n],
        weight: &vec![1.0; n],
    };
    Ok(Distribution::new(n, joints).solve(&problem)?.tension.to_vec())
}

/// Share by which the tensions of a machine at rest before a run exceed the least desired ones.
const RESTING_SHARE: f64 = 0.2;
