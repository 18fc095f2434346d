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
        limits.iter().map(|[least, most]| ((1.0 + RESTING_FRACTION) * least, *most)).unzip();
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

/// Fraction by which the tensions of a machine at rest before a run exceed the least desired ones.
const RESTING_FRACTION: f64 = 0.2;

#[cfg(test)]
mod tests {
    use super::*;

    #[test]
    fn at_rest_every_muscle_holds_its_joint_if_that_takes_a_fifth_above_its_least_tension_or_more() {
        // Each muscle has a joint of its own; the last two lift it.
        let (robot, pose) = (crate::muscle::tests::robots::chain(false), [0.1, 0.2, -0.3]);
        let mut model = MuscleDynamics::new(&robot).unwrap();
        let mut torque = [0.0; 3];
        model.evaluate(&pose).unwrap();
        model.inverse_dynamics(&[0.0; 3], &[0.0; 3], &mut torque).unwrap();
        let needed = [0, 1, 2].map(|k| torque[k] / model.moment_arms()[4 * k]);
        assert!(needed[0] < 0.0 && needed[1] > 20.0 && needed[2] > 5.0, "{needed:?}");
        let at = |limits: [[f64; 2]; 3]| resting_tensions(&robot, &pose, &limits).unwrap();
        let is = |found: &[f64], expected: [f64; 3]| {
            assert!(found.iter().zip(expected).all(|(a, b)| (a - b).abs() < 1e-9), "{found:?} {expected:?}");
        };
        is(&at([[10.0, 500.0], [1.0, 500.0], [1.0, 500.0]]), [12.0, needed[1], needed[2]]);
        // As far as the largest tension allows.
        is(&at([[10.0, 500.0], [1.0, 5.0], [1.0, 500.0]]), [12.0, 5.0, needed[2]]);
        // A fifth above the minimum tension counts where it is above the largest.
        is(&at([[10.0, 11.0], [100.0, 500.0], [20.0, 500.0]]), [12.0, 120.0, 24.0]);
        assert!(resting_tensions(&robot, &pose[..2], &[[1.0, 2.0]; 3]).is_err());
    }
}
