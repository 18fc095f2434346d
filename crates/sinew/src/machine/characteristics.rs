use crate::Error;
use crate::body::{PathElement, Robot, Tendon, TendonPath, cholesky};
use crate::error::check_length;
use crate::muscle::MuscleDynamics;
use crate::transmission::cable::CableLaw;
use alloc::vec;
use alloc::vec::Vec;

/// What decides how a machine on cables moves and can be controlled: its modes, levers and dead bands.
///
/// ```text
/// Om_k^2  = max_q R_k M^-1 R_k^T / C_k             C_k = sum_j c_kj: the winch stands, the whole cable slides
/// zeta_k  = min_q sum_i b_i (M^-1 R_k^T)_i^2 / (2 Om_k R_k M^-1 R_k^T)
/// B_kj    = max_q (|R_k M^-1 R_j^T| + dR sum_i |(M^-1 R_k^T)_i|)^2 / (R_k M^-1 R_k^T C_j)
///           what muscle j does to the motion of muscle k; i: the joints that muscle j crosses
/// Om_b^2  = max_q lambda_max( M^-1 (R^T diag(1/c_b) R + R_s^T diag(k) R_s) )   c_b: the last cell; the far ends stick
/// G_k     = e_+(F) - e_-(F)                        travel of the winch that reverses the sliding of the cable
/// theta_G = mean_q sum_k |R_kj| G_k/C_k / sum_k R_kj^2/C_k   the dead bands as a displacement of joint j
/// ```
///
/// | symbol   | field                                  | unit      | meaning                                |
/// |----------|----------------------------------------|-----------|----------------------------------------|
/// | Om_k     | [`MuscleCharacteristics::mode`]          | rad/s     | natural frequency of a muscle, all joints free |
/// | B        | [`interaction`](Self::interaction)      | 1/s^2     | `B_kk = Om_k^2` for `dR = 0`             |
/// | dR       |                                        | m         | error of the moment arms of a machine as built |
/// | zeta_k   | [`MuscleCharacteristics::damping_ratio`] | 1         | damping ratio of the same motion by the joints' dampers `b`, the smallest |
/// | Om_b     | [`stuck_mode`](Self::stuck_mode)         | rad/s     | highest natural frequency               |
/// | R, M, c  |                                        | m, kg m^2, m/N | moment arms, mass matrix, compliance of a cell |
/// | R_s, k   |                                        | m, N/m    | moment arms and stiffnesses of springs of tendons |
/// | G_k      | [`MuscleCharacteristics::dead_band`]     | m         | at a working tension `F`                 |
/// | theta_G  | [`JointCharacteristics::dead_band`]      | rad or m  |                                        |
///
/// # Source
/// Our own; `Om_k` is the antiresonance of a motor behind an elastic transmission.
#[derive(Debug, Clone, PartialEq)]
pub struct Characteristics {
    /// `[muscles]`.
    pub muscles: Vec<MuscleCharacteristics>,
    /// `[joints]`.
    pub joints: Vec<JointCharacteristics>,
    /// Largest magnitudes of the moment arms, m per unit of the joint, row by row: `[muscles x joints]`.
    pub arms: Vec<f64>,
    /// `B`, 1/s^2, row by row: `[muscles x muscles]`.
    pub interaction: Vec<f64>,
    /// `Om_b`, rad/s.
    pub stuck_mode: f64,
    /// Largest rate at which the dampers of joints and springs take their speed, 1/s.
    pub damping_rate: f64,
}

/// Of one muscle, over all poses.
#[derive(Debug, Clone, Copy, PartialEq, Default)]
pub struct MuscleCharacteristics {
    /// `Om_k`, rad/s.
    pub mode: f64,
    /// `zeta_k`, 1; infinite for a muscle that moves nothing.
    pub damping_ratio: f64,
    /// Largest magnitude of its moment arms, m.
    pub arm: f64,
    /// `A`, friction angle of its cable, 1.
    pub friction_angle: f64,
    /// `C_k`, compliance of its cable, m/N.
    pub compliance: f64,
    /// `F`, tension at which the dead band is given, N.
    pub tension: f64,
    /// `G_k`, m.
    pub dead_band: f64,
}

/// Of one joint; its unit is the radian or the metre.
#[derive(Debug, Clone, Copy, PartialEq, Default)]
pub struct JointCharacteristics {
    /// `theta_G`, rad or m: mean of all poses.
    pub dead_band: f64,
    /// Root mean square of the moment arms of the muscles that cross it, m per unit; the smallest of all
    /// poses.
    pub arm: f64,
    /// `tau = sum_k |R_kj| F_k/2`: torque of the working tensions of one side, Nm or N; the greatest of all
    /// poses.
    pub torque: f64,
    /// `I = 1/(M^-1)_jj`: inertia seen at the joint with all others free, kg m^2 or kg; the smallest of all
    /// poses.
    pub inertia: f64,
}

impl Characteristics {
    /// Over some poses, with the law of every cable, the working tension at its anchor, N, and the error of
    /// the moment arms, m: a muscle that is designed not to move a light joint does so a little when it is
    /// built.
    ///
    /// # Shapes
    /// `laws` and `tensions: [muscles]`, `poses: [places][joints]`, at least one place.
    ///
    /// # Errors
    /// [`Error::WrongLength`], and [`Error::OutOfDomain`] where the mass matrix is not positive definite.
    pub fn new(
        model: &mut MuscleDynamics,
        laws: &[CableLaw],
        tensions: &[f64],
        poses: &[Vec<f64>],
        arm_error: f64,
    ) -> Result<Self, Error> {
        let (m, n) = (model.muscles(), model.joints());
        check_length("laws", laws.len(), m)?;
        check_length("tensions", tensions.len(), m)?;
        check_length("poses", poses.len(), poses.len().max(1))?;
        let muscles = laws.iter().zip(tensions).map(|(law, tension)| of_cable(law, *tension));
        let unseen =
            JointCharacteristics { dead_band: 0.0, arm: f64::INFINITY, torque: 0.0, inertia: f64::INFINITY };
        let mut found = Self {
            muscles: muscles.collect::<Result<_, _>>()?,
            joints: vec![unseen; n],
            arms: vec![0.0; m * n],
            interaction: vec![0.0; m * m],
            stuck_mode: 0.0,
            damping_rate: 0.0,
        };
        let last: Vec<f64> =
            laws.iter().map(|law| law.compliance().last().copied().unwrap_or(f64::INFINITY)).collect();
        let mut mass = vec![0.0; n * n];
        let mut spring_damping = 0.0_f64;
        let crosses = crossed_joints(model.robot());
        let errors: Vec<f64> = crosses.iter().map(|crosses| if *crosses { arm_error } else { 0.0 }).collect();
        for pose in poses {
            model.evaluate(pose)?;
            model.mass_matrix(&mut mass)?;
            cholesky::factor(&mut mass, n)?;
            found.include_muscles(model, &errors, &mass);
            found.include_joints(model, &mass);
            // A spring is a cable with the compliance `1/k`, taken as taut in every pose.
            let (mut arms, mut compliance, mut damping) =
                (model.moment_arms().to_vec(), last.clone(), Vec::new());
            let first = arms.len();
            for spring in model.springs() {
                let from = arms.len();
                arms.resize(from + n, 0.0);
                model.crossings(spring.cable).for_each(|(joint, arm)| arms[from + joint] = arm);
                compliance.push(1.0 / spring.stiffness);
                damping.push(1.0 / spring.damping);
            }
            let mode = libm::sqrt(largest_eigenvalue(&mass, &arms, &compliance));
            found.stuck_mode = found.stuck_mode.max(mode);
            if !damping.is_empty() {
                spring_damping = spring_damping.max(largest_eigenvalue(&mass, &arms[first..], &damping));
            }
        }
        found.damping_rate += spring_damping;
        found.joints.iter_mut().for_each(|joint| joint.dead_band /= poses.len() as f64);
        Ok(found)
    }

    /// `errors` of the moment arms: `[muscles x joints]`.
    fn include_muscles(&mut self, model: &MuscleDynamics, errors: &[f64], factor: &[f64]) {
        let (m, n) = (self.muscles.len(), self.joints.len());
        let arms = model.moment_arms();
        for (muscle, row) in self.muscles.iter_mut().zip(arms.chunks_exact(n)) {
            muscle.arm = row.iter().fold(muscle.arm, |most, arm| most.max(arm.abs()));
        }
        self.arms.iter_mut().zip(arms).for_each(|(most, arm)| *most = most.max(arm.abs()));
        for k in 0..m {
            let row = &arms[k * n..(k + 1) * n];
            // Motion of the joints by a force of muscle k.
            let mut motion = row.to_vec();
            cholesky::solve(factor, &mut motion);
            let along = |arms: &[f64]| arms.iter().zip(&motion).map(|(arm, x)| arm * x).sum::<f64>();
            let own = along(row);
            if own <= 0.0 {
                continue;
            }
            for j in 0..m {
                let error: f64 =
                    errors[j * n..(j + 1) * n].iter().zip(&motion).map(|(dr, x)| dr * x.abs()).sum();
                let other = along(&arms[j * n..(j + 1) * n]).abs() + error;
                let entry = &mut self.interaction[k * m + j];
                *entry = entry.max(other * other / (own * self.muscles[j].compliance));
            }
            let lost: f64 =
                model.joint_springs().map(|(joint, _, b)| b * motion[joint] * motion[joint]).sum();
            let muscle = &mut self.muscles[k];
            let mode = libm::sqrt(own / muscle.compliance);
            muscle.mode = muscle.mode.max(mode);
            muscle.damping_ratio = muscle.damping_ratio.min(lost / (2.0 * mode * own));
        }
    }

    fn include_joints(&mut self, model: &MuscleDynamics, factor: &[f64]) {
        let n = self.joints.len();
        let parts = model.robot().parts();
        for (j, joint) in self.joints.iter_mut().enumerate() {
            let (mut band, mut stiffness, mut squares, mut count, mut torque) = (0.0, 0.0, 0.0, 0.0, 0.0);
            for (muscle, row) in self.muscles.iter().zip(model.moment_arms().chunks_exact(n)) {
                let arm = row[j].abs();
                band += arm * muscle.dead_band / muscle.compliance;
                stiffness += arm * arm / muscle.compliance;
                squares += arm * arm;
                torque += 0.5 * arm * muscle.tension;
                count += if arm > 0.0 { 1.0 } else { 0.0 };
            }
            if stiffness > 0.0 {
                joint.dead_band += band / stiffness;
            }
            joint.torque = joint.torque.max(torque);
            joint.arm = joint.arm.min(libm::sqrt(squares / f64::max(count, 1.0)));
            let mut unit = vec![0.0; n];
            unit[j] = 1.0;
            cholesky::solve_lower(factor, &mut unit);
            let mobility: f64 = unit.iter().map(|x| x * x).sum();
            joint.inertia = joint.inertia.min(1.0 / mobility);
            let damping = model.robot().joint_of_velocity(model.independent()[j]);
            let damping = damping.map_or(0.0, |joint| parts.joints[joint].damping);
            self.damping_rate = self.damping_rate.max(damping * mobility);
        }
    }
}

fn of_cable(law: &CableLaw, tension: f64) -> Result<MuscleCharacteristics, Error> {
    let [toward, away] = [SLOW, -SLOW].map(|speed| law.steady(tension, speed, 1.0));
    Ok(MuscleCharacteristics {
        friction_angle: law.friction_angle(),
        compliance: law.compliance().iter().sum(),
        tension,
        dead_band: toward?.stretch - away?.stretch,
        damping_ratio: f64::INFINITY,
        ..MuscleCharacteristics::default()
    })
}

/// Speed at which dead bands are given, m/s: without drag.
const SLOW: f64 = 1e-6;

/// Iterations of the power method: its result is too small by less than some percent.
const POWER_ITERATIONS: usize = 40;

/// `lambda_max( M^-1 R^T diag(1/c) R )`, 1/s^2, with the factor of `M`, by the power method on
/// `L^-1 R^T diag(1/c) R L^-T`.
fn largest_eigenvalue(factor: &[f64], arms: &[f64], compliance: &[f64]) -> f64 {
    let n = arms.len() / compliance.len().max(1);
    let rows = arms.chunks_exact(n).zip(compliance).map(|(row, c)| {
        let mut scaled: Vec<f64> = row.iter().map(|arm| arm / libm::sqrt(*c)).collect();
        cholesky::solve_lower(factor, &mut scaled);
        scaled
    });
    let rows: Vec<Vec<f64>> = rows.collect();
    // The sum of all rows is not orthogonal to the largest eigenvector but by accident.
    let mut x: Vec<f64> = (0..n).map(|j| 1.0 + rows.iter().map(|row| row[j].abs()).sum::<f64>()).collect();
    let mut eigenvalue = 0.0;
    for _ in 0..POWER_ITERATIONS {
        let norm = libm::sqrt(x.iter().map(|x| x * x).sum());
        x.iter_mut().for_each(|x| *x /= norm);
        let mut y = vec![0.0; n];
        for row in &rows {
            let along: f64 = row.iter().zip(&x).map(|(a, b)| a * b).sum();
            y.iter_mut().zip(row).for_each(|(y, row)| *y += along * row);
        }
        eigenvalue = libm::sqrt(y.iter().map(|y| y * y).sum());
        if eigenvalue == 0.0 {
            break;
        }
        x = y;
    }
    eigenvalue
}

/// Whether a tendon passes over an independent joint, or one that follows it, so that its moment arm may be
/// off: `[muscles x joints]`. Tendons that are sums of joint coordinates have no attachments.
fn crossed_joints(robot: &Robot) -> Vec<bool> {
    let parts = robot.parts();
    let independent = robot.independent_joints();
    let moved_by = |joint: usize, body: usize| {
        let target = parts.joints[joint].body;
        core::iter::successors(Some(body), |&body| (body != 0).then(|| parts.bodies[body].parent))
            .any(|body| body == target)
    };
    let body_of = |element: &PathElement| match element {
        PathElement::Site(site) => Some(parts.sites[*site].body),
        PathElement::Wrap { wrap, .. } => Some(parts.wraps[*wrap].body),
        PathElement::Pulley(_) => None,
    };
    let crosses = |tendon: &Tendon, joint: usize| match &tendon.path {
        TendonPath::Fixed(_) => false,
        TendonPath::Spatial(elements) => {
            let mut moved = elements.iter().filter_map(body_of).map(|body| moved_by(joint, body));
            let first = moved.next();
            moved.any(|other| Some(other) != first)
        }
    };
    let with_followers = |tendon: &Tendon, joint: usize| {
        let mut followers = parts.couplings.iter().filter(|coupling| coupling.leader == Some(joint));
        crosses(tendon, joint) || followers.any(|coupling| crosses(tendon, coupling.follower))
    };
    let row = |tendon| independent.iter().map(move |&joint| with_followers(tendon, joint));
    parts.tendons.iter().flat_map(row).collect()
}

#[cfg(test)]
mod tests {
    use super::*;
    use crate::transmission::cable::{CableParameters, CablePath};

    #[test]
    fn the_modes_of_a_single_joint_are_those_of_springs_on_an_inertia() {
        let robot = crate::muscle::tests::robots::chain(false);
        let mut model = MuscleDynamics::new(&robot).unwrap();
        let law = CableLaw::new(&CablePath::bench(), &CableParameters::bench(), 12).unwrap();
        let laws = vec![law.clone(), law.clone(), law.clone()];
        let pose = [vec![0.1, 0.2, -0.3]];
        let found = Characteristics::new(&mut model, &laws, &[40.0; 3], &pose, 0.0).unwrap();
        assert!((found.interaction[8] - found.muscles[2].mode * found.muscles[2].mode).abs() < 1e-6);
        // The last muscle crosses the last joint alone.
        let (arm, c) = (model.moment_arms()[8].abs(), law.compliance().iter().sum::<f64>());
        let expected = libm::sqrt(arm * arm / c / found.joints[2].inertia);
        assert!((found.muscles[2].mode - expected).abs() < 1e-9 * expected);
        let last = law.compliance().last().unwrap();
        let each = found.muscles.iter().map(|muscle| muscle.mode * libm::sqrt(c / last));
        assert!(each.clone().all(|mode| mode <= 1.001 * found.stuck_mode));
        assert!(libm::sqrt(each.map(|mode| mode * mode).sum::<f64>()) >= found.stuck_mode);
        let built = Characteristics::new(&mut model, &laws, &[40.0; 3], &pose, 1e-3).unwrap();
        assert!(built.interaction.iter().zip(&found.interaction).all(|(built, found)| built > found));
        assert!((found.joints[2].dead_band * arm - found.muscles[2].dead_band).abs() < 1e-12);
    }

    #[test]
    fn a_muscle_crosses_the_joints_between_its_ends_and_those_that_a_crossed_follower_follows() {
        let each = [true, false, false, false, true, false, false, false, true];
        assert_eq!(crossed_joints(&crate::muscle::tests::robots::chain(false)), each);
        // The last joint follows the second.
        assert_eq!(
            crossed_joints(&crate::muscle::tests::robots::chain(true)),
            [true, false, false, true, false, true]
        );
    }
}
