use super::directions::directions;
use super::limits::CableMotion;
use super::load::LargestLoad;
use super::model::{CapabilityModel, EndPointJacobian, transposed};
use super::stiffness::{end_point_stiffness, joint_stiffness};
use crate::error::Error;
use alloc::vec;
use alloc::vec::Vec;

/// A largest or smallest value, and the muscle whose limit determines it.
#[derive(Debug, Clone, Copy, PartialEq)]
pub struct Extreme {
    /// In the unit of what it belongs to; infinite where no muscle limits it.
    pub value: f64,
    /// The muscle whose limit changes it most.
    pub muscle: Option<usize>,
    /// Whether that muscle is at its largest tension or speed; at its minimum tension otherwise.
    pub largest: bool,
}

/// What a machine can do in one pose.
#[derive(Debug, Clone, PartialEq)]
pub struct PoseCapability {
    /// Independent joints, rad or m: `[joints]`.
    pub pose: Vec<f64>,
    /// `[joints]`.
    pub joints: Vec<JointCapability>,
    /// None for a machine without an end point.
    pub end_point: Option<EndPointCapability>,
}

/// What one joint can do while the others are held.
#[derive(Debug, Clone, Copy, PartialEq)]
pub struct JointCapability {
    /// Torque that gravity and springs of the joints need, Nm or N.
    pub needed: f64,
    /// Largest additional torque against and along the joint's axis, Nm or N, whichever way the cables slid
    /// before; none where the muscles do not hold the pose.
    pub torque: Option<[Extreme; 2]>,
    /// Largest speed, rad/s or m/s.
    pub speed: Extreme,
    /// Stiffness while the winches stand and the other joints are free, Nm/rad or N/m; none where a joint has
    /// no muscle.
    pub stiffness: Option<f64>,
}

/// What the end point can do, in the coordinates of the task in which it can move.
#[derive(Debug, Clone, PartialEq)]
pub struct EndPointCapability {
    /// Its position, m.
    pub position: [f64; 3],
    /// Largest mass that is lifted, held whichever way the cables slid before, and lowered slowly, kg; none
    /// without gravity, and where the muscles do not hold the machine itself in that state.
    pub payload: [Option<Extreme>; 3],
    /// Largest force in the direction in which it is least, N, with that direction.
    pub force: Option<(Extreme, [f64; 3])>,
    /// Largest speed in the direction in which it is least, m/s, with that direction; of the joints'
    /// velocities with least squares.
    pub speed: Option<(Extreme, [f64; 3])>,
    /// Smallest and largest stiffness over all directions while the winches stand, N/m.
    pub stiffness: Option<[f64; 2]>,
}

impl CapabilityModel {
    /// Everything in one pose.
    ///
    /// # Errors
    /// As the functions above.
    pub fn at(&mut self, pose: &[f64]) -> Result<PoseCapability, Error> {
        self.evaluate(pose)?;
        let needed = self.needed_torque()?;
        let stiffness = joint_stiffness(self.model.moment_arms(), &self.compliance, pose.len());
        let mut joints = Vec::new();
        for (j, needed) in needed.iter().enumerate() {
            let mut unit = vec![0.0; pose.len()];
            unit[j] = 1.0;
            let along = self.largest_load(CableMotion::Either, &unit)?;
            unit[j] = -1.0;
            let against = self.largest_load(CableMotion::Either, &unit)?;
            joints.push(JointCapability {
                needed: *needed,
                torque: against.zip(along).map(|(against, along)| [extreme(&against), extreme(&along)]),
                speed: self.speed(&unit),
                stiffness: stiffness.as_ref().map(|stiffness| stiffness.of_joint(j)),
            });
        }
        let end_point = match self.end_point()? {
            None => None,
            Some(EndPointJacobian { position, rows }) => Some(EndPointCapability {
                position,
                payload: self.payload()?,
                force: self.weakest_force(&rows)?,
                speed: self.slowest_speed(&rows),
                stiffness: stiffness.and_then(|stiffness| end_point_stiffness(&stiffness, &rows)),
            }),
        };
        Ok(PoseCapability { pose: pose.to_vec(), joints, end_point })
    }

    /// Mass that is lifted, held and lowered, kg.
    fn payload(&mut self) -> Result<[Option<Extreme>; 3], Error> {
        let (Some(weight), Some(up)) = (self.weight()?, self.upward()?) else { return Ok([None; 3]) };
        let down: Vec<f64> = up.iter().map(|x| -x).collect();
        let motions = [CableMotion::Along(&up), CableMotion::Either, CableMotion::Along(&down)];
        let mut payload = [None; 3];
        for (payload, motion) in payload.iter_mut().zip(motions) {
            *payload = self.largest_load(motion, &weight)?.map(|found| extreme(&found));
        }
        Ok(payload)
    }

    fn weakest_force(&mut self, rows: &[f64]) -> Result<Option<(Extreme, [f64; 3])>, Error> {
        let mut weakest: Option<(Extreme, [f64; 3])> = None;
        for direction in directions(rows).all() {
            let Some(found) = self.largest_load(CableMotion::Either, &transposed(rows, direction))? else {
                return Ok(None);
            };
            let found = extreme(&found);
            if weakest.is_none_or(|(weakest, _)| found.value < weakest.value) {
                weakest = Some((found, direction));
            }
        }
        Ok(weakest)
    }

    fn slowest_speed(&self, rows: &[f64]) -> Option<(Extreme, [f64; 3])> {
        let within = directions(rows);
        let each = within.all().into_iter().map(|d| (self.speed(&within.velocity(d)), d));
        each.min_by(|a, b| a.0.value.total_cmp(&b.0.value))
    }

    /// Largest multiple of a velocity of the joints that the winches follow.
    fn speed(&self, velocity: &[f64]) -> Extreme {
        let mut slowest = Extreme { value: f64::INFINITY, muscle: None, largest: true };
        let rows = self.moment_arms().chunks_exact(velocity.len());
        for (k, (row, most)) in rows.zip(&self.speeds).enumerate() {
            let pulled: f64 = row.iter().zip(velocity).map(|(arm, v)| arm * v).sum();
            let value = most / pulled.abs();
            if value < slowest.value {
                slowest = Extreme { value, muscle: Some(k), largest: true };
            }
        }
        slowest
    }
}

fn extreme(load: &LargestLoad) -> Extreme {
    let first = load.binding.first();
    Extreme {
        value: load.factor,
        muscle: first.map(|binding| binding.muscle),
        largest: first.is_none_or(|binding| binding.largest),
    }
}
