//! `springdamper` of a joint: spring and damper by time constant and damping ratio.

use super::import_state::Import;
use crate::body::{Robot, Scratch, cholesky};
use alloc::vec;

/// Sets stiffness and damping of the joints that give them by a time constant `T` and a damping ratio `z`.
///
/// ```text
/// k = I/(T z)^2,   d = 2 I/T,   1/I = mean of (M^-1)_jj over the velocities of the joint, in the reference pose
/// ```
///
/// # Source
/// `mujoco2012`: the rule of its compiler. A body that is no robot yet is left to the validation.
pub(super) fn apply(import: &mut Import<'_>) {
    if import.spring_dampers.is_empty() {
        return;
    }
    let Ok(robot) = Robot::new(import.parts.clone()) else { return };
    let n = robot.nv();
    let mut mass = vec![0.0; n * n];
    let found = robot.mass_matrix(&robot.reference_pose(), &mut Scratch::new(&robot), &mut mass);
    if found.and_then(|()| cholesky::factor(&mut mass, n)).is_err() {
        return;
    }
    for &(joint, [time, ratio]) in &import.spring_dampers {
        let velocities = robot.velocities_of(joint);
        let count = velocities.len() as f64;
        let mobility = velocities.map(|velocity| {
            let mut unit = vec![0.0; n];
            unit[velocity] = 1.0;
            cholesky::solve_lower(&mass, &mut unit);
            unit.iter().map(|x| x * x).sum::<f64>()
        });
        let inertia = count / mobility.sum::<f64>();
        let joint = &mut import.parts.joints[joint];
        joint.stiffness = inertia / (time * time * ratio * ratio);
        joint.damping = 2.0 * inertia / time;
    }
}
