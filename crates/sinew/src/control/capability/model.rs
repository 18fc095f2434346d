use super::directions::directions;
use super::limits::{CableMotion, SlidingState, anchor_limits};
use super::load::{LargestLoad, LoadSearch};
use super::torque_set::TorqueSet;
use crate::body::{Poses, Reduction};
use crate::error::Error;
use crate::machine::{Machine, Task};
use crate::muscle::MuscleDynamics;
use crate::transmission::{SheathBend, Sliding};
use alloc::vec;
use alloc::vec::Vec;

/// The end point of a machine in a pose.
#[derive(Debug, Clone, PartialEq)]
pub struct EndPointJacobian {
    /// Position in the world, m.
    pub position: [f64; 3],
    /// Its Jacobian in the task's axes, `[3 x joints]`, row by row; rows of axes outside the task are zero.
    pub rows: Vec<f64>,
}

/// A machine's muscles through their transmissions, pose by pose.
///
/// # Assumes
/// Cables slide slowly ([`anchor_limits`]). Tensions of the drives up to
/// [`working_tension`](crate::drive::DriveParameters::working_tension): heat is considered by
/// [`holding_for`](Self::holding_for) alone. Stiffness is that of the cables alone, all
/// of each cable sliding; the change of the moment arms with the pose is left out.
#[derive(Debug, Clone)]
pub struct CapabilityModel {
    pub(super) machine: Machine,
    pub(super) model: MuscleDynamics,
    /// Bend of every sheath by the pose, and in the pose, rad.
    bends: Vec<SheathBend>,
    bend: Vec<f64>,
    search: LoadSearch,
    poses: Poses,
    reduction: Reduction,
    /// Compliance of every cable, m/N.
    pub(super) compliance: Vec<f64>,
    /// Largest tension of every drive, N.
    pub(super) max_tension: Vec<f64>,
    /// Largest speed of every winch at three quarters of its drive's largest tension, m/s.
    pub(super) speeds: Vec<f64>,
}

/// Fraction of a drive's largest tension at which its speed counts.
const SPEED_FRACTION: f64 = 0.75;
/// Cells of a cable whose compliance is needed.
const CELLS: usize = 8;

impl CapabilityModel {
    /// Of a machine as designed, without its payload.
    ///
    /// # Errors
    /// [`Error::OutOfDomain`] for a robot with ball or free joints, and a cable that cannot be discretised.
    pub fn new(machine: &Machine) -> Result<Self, Error> {
        let mut model = MuscleDynamics::new(&machine.robot)?;
        model.evaluate(&machine.start)?;
        let laws = machine.laws(CELLS)?;
        Ok(Self {
            compliance: laws.iter().map(|law| law.compliance().iter().sum()).collect(),
            max_tension: machine.muscles.iter().map(|design| design.drive.working_tension()).collect(),
            speeds: machine
                .muscles
                .iter()
                .map(|design| design.drive.speed_at(SPEED_FRACTION * design.drive.max_tension))
                .collect(),
            bends: machine.sheath_bends()?,
            bend: machine.muscles.iter().map(|design| design.bend).collect(),
            search: LoadSearch::new(model.muscles(), model.joints()),
            poses: Poses::new(&machine.robot),
            reduction: Reduction::new(&machine.robot),
            machine: machine.clone(),
            model,
        })
    }

    /// Sets the pose of the next questions.
    ///
    /// # Errors
    /// As [`MuscleDynamics::evaluate`].
    pub fn evaluate(&mut self, pose: &[f64]) -> Result<(), Error> {
        self.model.evaluate(pose)?;
        self.bend.iter_mut().zip(&self.bends).for_each(|(bend, law)| *bend = law.at(pose));
        self.machine.robot.forward_kinematics(self.model.coordinates(), &mut self.poses)?;
        self.reduction.update(&self.machine.robot, self.model.coordinates())
    }

    /// `R` in the pose, m: `[muscles x joints]`.
    #[must_use]
    pub fn moment_arms(&self) -> &[f64] {
        self.model.moment_arms()
    }

    /// Torque that gravity and springs of the joints need in the pose, Nm or N: `[joints]`.
    ///
    /// # Errors
    /// As [`MuscleDynamics::inverse_dynamics`].
    pub fn needed_torque(&mut self) -> Result<Vec<f64>, Error> {
        let zeros = vec![0.0; self.model.joints()];
        let mut needed = zeros.clone();
        self.model.inverse_dynamics(&zeros, &zeros, &mut needed)?;
        Ok(needed)
    }

    /// Limits of the tensions at the anchors in the pose, N: `[muscles]`; none where a cable has no tension
    /// that both directions allow.
    #[must_use]
    pub fn tension_limits(&self, motion: CableMotion<'_>) -> Option<Vec<[f64; 2]>> {
        let n = self.model.joints();
        let of = |k: usize| {
            let design = &self.machine.muscles[k];
            let row = &self.moment_arms()[k * n..(k + 1) * n];
            let pulled = |v: &[f64]| row.iter().zip(v).map(|(arm, v)| arm * v).sum::<f64>();
            let (state, angle) = match motion {
                CableMotion::Frictionless => (SlidingState::Either, 0.0),
                CableMotion::Either => (SlidingState::Either, self.friction_angle(k)),
                CableMotion::Along(v) => {
                    let state = Sliding::from_velocity(pulled(v)).map(SlidingState::Slides);
                    (state.unwrap_or(SlidingState::Either), self.friction_angle(k))
                }
            };
            let drive = [design.drive.min_tension, self.max_tension[k]];
            let [least, most] = anchor_limits(drive, angle, design.cable.pretension, state)?;
            let [lower, upper] = design.tension;
            let (least, most) = (lower.map_or(least, |x| x.max(least)), upper.map_or(most, |x| x.min(most)));
            (least <= most).then_some([least, most])
        };
        (0..self.machine.muscles.len()).map(of).collect()
    }

    /// Velocities of the joints with least squares that raise the end point against gravity; none without a
    /// gravity or an end point.
    ///
    /// # Errors
    /// As [`end_point`](Self::end_point).
    pub fn upward(&self) -> Result<Option<Vec<f64>>, Error> {
        let up = self.machine.robot.parts().gravity.map(|g| -g);
        let Some(rows) = self.payload_jacobian()? else { return Ok(None) };
        let velocity = directions(&rows).velocity(up);
        Ok(Some(velocity).filter(|velocity| velocity.iter().any(|v| *v != 0.0)))
    }

    /// Friction angle of a muscle's cable in the pose, 1.
    #[must_use]
    pub fn friction_angle(&self, muscle: usize) -> f64 {
        let design = &self.machine.muscles[muscle];
        let bend = self.bend[muscle] + self.model.wrap_angle(muscle);
        design.cable.friction * bend - libm::log(design.cable.efficiency)
    }

    /// The end point in the pose; none for a machine without one.
    ///
    /// # Errors
    /// As [`Robot::jacobian`](crate::body::Robot::jacobian).
    pub fn end_point(&self) -> Result<Option<EndPointJacobian>, Error> {
        let Task::EndPoint { site, axes } = self.machine.task else { return Ok(None) };
        let mut found = self.jacobian(site)?;
        for (row, used) in found.rows.chunks_exact_mut(self.model.joints()).zip(axes) {
            if !used {
                row.fill(0.0);
            }
        }
        Ok(Some(found))
    }

    /// Joint torques that hold 1 kg at the end point in the pose, Nm or N: `[joints]`; none without gravity
    /// or end point.
    pub(super) fn weight(&self) -> Result<Option<Vec<f64>>, Error> {
        let up = self.machine.robot.parts().gravity.map(|g| -g);
        let rows = self.payload_jacobian()?.filter(|_| up.iter().any(|x| *x != 0.0));
        Ok(rows.map(|rows| transposed(&rows, up)))
    }

    /// Jacobian of the end point that carries a payload, in all axes: its weight acts along axes that the
    /// task does not track, too.
    pub(super) fn payload_jacobian(&self) -> Result<Option<Vec<f64>>, Error> {
        self.machine.payload_site().map(|site| Ok(self.jacobian(site)?.rows)).transpose()
    }

    fn jacobian(&self, site: usize) -> Result<EndPointJacobian, Error> {
        let robot = &self.machine.robot;
        let (n, nv) = (self.model.joints(), robot.nv());
        let point = robot.site_pose(&self.poses, site).origin;
        let (mut linear, mut angular) = (vec![0.0; 3 * nv], vec![0.0; 3 * nv]);
        robot.jacobian(&self.poses, robot.parts().sites[site].body, point, &mut linear, &mut angular)?;
        let mut rows = vec![0.0; 3 * n];
        self.reduction.rows(&linear, &mut rows)?;
        Ok(EndPointJacobian { position: point, rows })
    }

    /// Outline of the forces that the end point can exert within a plane of the world's axes, N: the largest
    /// force in `count` directions about the origin, with no force across the plane; not finite where the
    /// pose blocks the force. Empty where the pose itself is not held, or without an end point.
    ///
    /// # Errors
    /// As [`largest_load`](Self::largest_load).
    pub fn force_outline(
        &mut self,
        motion: CableMotion<'_>,
        plane: [usize; 2],
        count: usize,
    ) -> Result<Vec<[f64; 2]>, Error> {
        let mut outline = Vec::new();
        let Some(EndPointJacobian { rows, .. }) = self.end_point()? else { return Ok(outline) };
        let [first, second] = plane.map(|axis| axis.min(2));
        for k in 0..count {
            let (sine, cosine) = libm::sincos(core::f64::consts::TAU * k as f64 / count as f64);
            let mut direction = [0.0; 3];
            (direction[first], direction[second]) = (cosine, sine);
            let Some(found) = self.largest_load(motion, &transposed(&rows, direction))? else { break };
            outline.push([found.factor * cosine, found.factor * sine]);
        }
        Ok(outline)
    }

    /// Set of the joint torques that the muscles give in the pose; none where a cable has no tension that
    /// both directions allow.
    ///
    /// # Errors
    /// As [`TorqueSet::new`].
    pub fn torque_set(&self, motion: CableMotion<'_>) -> Result<Option<TorqueSet>, Error> {
        let limits = self.tension_limits(motion);
        limits.map(|limits| TorqueSet::new(self.moment_arms(), self.model.joints(), &limits)).transpose()
    }

    /// The largest multiple of a load, a torque of the joints, that the muscles hold in the pose beside what
    /// the pose needs; with the limits of [`tension_limits`](Self::tension_limits).
    ///
    /// # Errors
    /// As [`LoadSearch::largest`].
    pub fn largest_load(
        &mut self,
        motion: CableMotion<'_>,
        load: &[f64],
    ) -> Result<Option<LargestLoad>, Error> {
        let needed = self.needed_torque()?;
        let Some(limits) = self.tension_limits(motion) else { return Ok(None) };
        self.search.largest(self.model.moment_arms(), &limits, &needed, load)
    }
}

/// `J^T d`.
pub(super) fn transposed(rows: &[f64], direction: [f64; 3]) -> Vec<f64> {
    let n = rows.len() / 3;
    (0..n).map(|j| (0..3).map(|k| rows[k * n + j] * direction[k]).sum()).collect()
}
