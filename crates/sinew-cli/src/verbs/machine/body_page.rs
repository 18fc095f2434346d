//! The page of a robot: its view, its moment arms over the range of each joint with their jumps, its muscles.

use super::poses::{apply_couplings, velocity_names};
use super::survey::{Survey, coupled_reference_pose, joint_range};
use super::view::scene;
use crate::error::Error;
use sinew::body::{JointKind, Robot};
use sinew::muscle::{Geometry, Muscles};
use sinew_report::robot::{ArmCurves, ArmJump, MuscleRow, RobotView, page as robot_page};

/// Points of a curve.
const CURVE_POINTS: usize = 61;
/// Curves with smaller moment arms everywhere are not drawn, m.
const MIN_ARM_M: f64 = 1e-6;
/// Bisections of an interval in which a moment arm may jump: to 1e-12 of it.
const BISECTIONS: usize = 40;
/// Smallest jump, as a fraction of the largest moment arm about the joint.
const MIN_JUMP: f64 = 0.01;

pub(super) fn page(robot: &Robot, survey: &Survey) -> Result<String, Error> {
    let rows = survey.muscles.iter().map(|m| MuscleRow {
        name: m.name.clone(),
        length_m: m.length_m,
        travel_m: m.travel_m(),
        strongest: m.strongest.clone(),
        arm_m: m.arm_m,
        wrap_rad: m.wrap_rad,
    });
    let parts = robot.parts();
    let scene = scene(robot)?;
    let view = RobotView {
        name: parts.name.clone(),
        mass_kg: [parts.bodies.iter().map(|body| body.mass).sum(), robot.moving_mass()],
        bodies: parts.bodies.len() - 1,
        joints: parts.joints.len(),
        muscles: rows.collect(),
        poses: survey.poses,
        curves: Curves::new(robot).all()?,
        start: scene.poses.len() - 1,
        scene,
    };
    Ok(robot_page(&view)?)
}

/// Evaluates moment arms with one joint moved.
struct Curves<'a> {
    robot: &'a Robot,
    muscles: Muscles,
    geometry: Geometry,
    rest: Vec<f64>,
    q: Vec<f64>,
    dense: Vec<f64>,
}

impl<'a> Curves<'a> {
    fn new(robot: &'a Robot) -> Self {
        let muscles = Muscles::new(robot);
        let geometry = Geometry::new(robot, &muscles);
        let (rest, dense) = (coupled_reference_pose(robot), vec![0.0; muscles.count() * robot.nv()]);
        Self { robot, muscles, geometry, q: rest.clone(), rest, dense }
    }

    /// For every joint of one coordinate: its values, and the moment arms about it of the muscles that cross
    /// it.
    fn all(&mut self) -> Result<Vec<ArmCurves>, Error> {
        let parts = self.robot.parts();
        let names = velocity_names(self.robot);
        let mut curves = Vec::new();
        for joint in 0..parts.joints.len() {
            let follows = parts.couplings.iter().any(|coupling| coupling.follower == joint);
            let Some([low, high]) = joint_range(self.robot, joint).filter(|_| !follows) else { continue };
            let count = self.muscles.count();
            let (mut at, mut arms) = (Vec::new(), vec![Vec::new(); count]);
            for k in 0..CURVE_POINTS {
                #[expect(clippy::cast_precision_loss, reason = "a few dozen points")]
                let part = k as f64 / (CURVE_POINTS - 1) as f64;
                at.push(low + part * (high - low));
                self.evaluate(joint, low + part * (high - low))?;
                (0..count).for_each(|m| arms[m].push(self.arm(joint, m)));
            }
            let seen = arms.into_iter().enumerate();
            let arms: Vec<(usize, Vec<f64>)> =
                seen.filter(|(_, arm)| arm.iter().any(|x| x.abs() > MIN_ARM_M)).collect();
            if arms.is_empty() {
                continue;
            }
            let jumps = self.jumps(joint, &at, &arms)?;
            let slides = parts.joints[joint].kind == JointKind::Slide;
            let joint = names[self.robot.velocities_of(joint).start].clone();
            curves.push(ArmCurves { joint, slides, at, arms, jumps });
        }
        Ok(curves)
    }

    fn evaluate(&mut self, joint: usize, value: f64) -> Result<(), Error> {
        self.q.copy_from_slice(&self.rest);
        self.q[self.robot.coordinates_of(joint).start] = value;
        apply_couplings(self.robot, &[], &mut self.q);
        self.muscles.evaluate(&self.q, &mut self.geometry)?;
        self.muscles.dense(&self.geometry, &mut self.dense)?;
        Ok(())
    }

    fn arm(&self, joint: usize, muscle: usize) -> f64 {
        self.dense[muscle * self.robot.nv() + self.robot.velocities_of(joint).start]
    }

    /// Discontinuities between the points of the curves: differences that bisection does not make smaller.
    fn jumps(&mut self, joint: usize, at: &[f64], arms: &[(usize, Vec<f64>)]) -> Result<Vec<ArmJump>, Error> {
        let largest = arms.iter().flat_map(|(_, arm)| arm).fold(0.0_f64, |most, x| most.max(x.abs()));
        let least = MIN_JUMP * largest;
        let mut jumps = Vec::new();
        for (muscle, arm) in arms {
            for k in 1..at.len() {
                if (arm[k] - arm[k - 1]).abs() < least {
                    continue;
                }
                let (mut low, mut high) = ((at[k - 1], arm[k - 1]), (at[k], arm[k]));
                for _ in 0..BISECTIONS {
                    let middle = 0.5 * (low.0 + high.0);
                    self.evaluate(joint, middle)?;
                    let value = self.arm(joint, *muscle);
                    if (value - low.1).abs() > (high.1 - value).abs() {
                        high = (middle, value);
                    } else {
                        low = (middle, value);
                    }
                    if (high.1 - low.1).abs() < least {
                        break;
                    }
                }
                if (high.1 - low.1).abs() >= least {
                    jumps.push(ArmJump { muscle: *muscle, at: high.0, arm: [low.1, high.1] });
                }
            }
        }
        Ok(jumps)
    }
}
