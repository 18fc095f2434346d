use super::end_point::EndPointStep;
use super::limiter::{JointLimiter, Limited};
use super::limits::JointLimits;
use super::muscle_lengths::MuscleLengthStep;
use super::preview::{Preview, copy};
use crate::body::Robot;
use crate::error::{Error, check_length};
use crate::trajectory::{Redundancy, Reference};
use alloc::vec::Vec;

/// A set-point with the rate at which it changes; empty rates are zeros.
#[derive(Debug, Clone, Copy, PartialEq)]
pub enum Setpoint<'a> {
    /// Come to rest and hold.
    Hold,
    /// Coordinates of the joints, rad or m, and rates, per s: `[joints]`.
    Joints(&'a [f64], &'a [f64]),
    /// Position of the end point, m.
    EndPoint([f64; 3]),
    /// Lengths of the muscles, m: `[muscles]`.
    MuscleLengths(&'a [f64]),
}

/// References of the joints for the control cycle from set-points that are not known ahead.
///
/// The reference is that of a horizon before, so that the newest one is its preview: what is commanded takes
/// effect a preview horizon later. A set-point of another kind continues where the one before was followed.
#[derive(Debug, Clone)]
pub struct SetpointFollower {
    h: f64,
    limiter: JointLimiter,
    preview: Preview,
    end_point: Option<EndPointStep>,
    muscle_lengths: MuscleLengthStep,
    /// Pose of the set-point, its rate and the pose before: `[joints]`.
    pose: Vec<f64>,
    rate: Vec<f64>,
    before: Vec<f64>,
    /// Whether `pose` is that of a set-point: false after a hold.
    followed: bool,
}

/// Distances of an end point and of muscle lengths that cannot be reached, m.
const UNREACHED: f64 = 1e-3;

impl SetpointFollower {
    /// At rest in a pose. `horizon` and the period `h` are in s; an end point is a site and its axes.
    ///
    /// # Errors
    /// As [`JointLimiter::new`], [`Preview::new`], [`EndPointStep::new`], [`MuscleLengthStep::new`].
    pub fn new(
        robot: &Robot,
        limits: JointLimits,
        end_point: Option<(usize, [bool; 3], &Redundancy)>,
        pose: &[f64],
        [horizon, h]: [f64; 2],
    ) -> Result<Self, Error> {
        let ranges = limits.range.clone();
        let limiter = JointLimiter::new(limits, pose)?;
        let step = |(site, axes, rule)| EndPointStep::new(robot, rule, site, axes, &ranges);
        Ok(Self {
            h,
            preview: Preview::new(horizon, h, &limiter.reference().q)?,
            end_point: end_point.map(step).transpose()?,
            muscle_lengths: MuscleLengthStep::new(robot, &ranges)?,
            pose: limiter.reference().q.clone(),
            rate: limiter.zeros(),
            before: limiter.zeros(),
            followed: false,
            limiter,
        })
    }

    /// The newest reference, that of a horizon later.
    #[must_use]
    pub fn newest(&self) -> &Reference {
        self.limiter.reference()
    }

    /// The limits.
    #[must_use]
    pub fn limits(&self) -> &JointLimits {
        self.limiter.limits()
    }

    /// Begins anew at rest in a pose: `[joints]`.
    pub fn rest_at(&mut self, pose: &[f64]) {
        self.limiter.rest_at(pose);
        self.preview.rest_at(&self.limiter.reference().q);
        self.followed = false;
    }

    /// One control cycle: the current reference and the previewed one. Nothing is allocated.
    ///
    /// # Errors
    /// [`Error::WrongLength`]; [`Error::OutOfDomain`] for an end point that the machine lacks, and numbers
    /// that are not finite.
    pub fn step(
        &mut self,
        setpoint: Setpoint<'_>,
        current: &mut Reference,
        previewed: &mut Reference,
    ) -> Result<Limited, Error> {
        let limited = self.follow(setpoint)?;
        self.preview.step(self.limiter.reference(), current);
        copy(self.limiter.reference(), previewed);
        Ok(limited)
    }

    fn follow(&mut self, setpoint: Setpoint<'_>) -> Result<Limited, Error> {
        if setpoint == Setpoint::Hold {
            self.followed = false;
            self.limiter.brake(self.h);
            return Ok(Limited::No);
        }
        if !self.followed {
            self.pose.copy_from_slice(&self.limiter.reference().q);
        }
        self.before.copy_from_slice(&self.pose);
        let unreached = match setpoint {
            Setpoint::Hold => false,
            Setpoint::Joints(q, v) => {
                check_length("joint set-point", q.len(), self.pose.len())?;
                for q in q.iter().chain(v) {
                    crate::error::finite("joint set-point", *q)?;
                }
                self.pose.copy_from_slice(q);
                self.rate.fill(0.0);
                self.rate.iter_mut().zip(v).for_each(|(rate, v)| *rate = *v);
                false
            }
            Setpoint::EndPoint(point) => {
                for x in point {
                    crate::error::finite("end-point set-point", x)?;
                }
                let step = self.end_point.as_mut();
                let (name, expected) = ("end-point set-point", "a machine with an end point");
                let step = step.ok_or(Error::OutOfDomain { name, expected, got: point[0] })?;
                let left = step.step(point, &mut self.pose)?;
                self.differentiate();
                left > UNREACHED
            }
            Setpoint::MuscleLengths(lengths) => {
                for x in lengths {
                    crate::error::finite("muscle-length set-point", *x)?;
                }
                let left = self.muscle_lengths.step(lengths, &mut self.pose)?;
                self.differentiate();
                left > UNREACHED
            }
        };
        self.followed = true;
        let limited = self.limiter.step(self.h, &self.pose, &self.rate);
        Ok(if unreached { Limited::Yes } else { limited })
    }

    /// Rates of a pose that was solved for; none where it moves faster than the joints may, because it jumps
    /// then.
    fn differentiate(&mut self) {
        let Self { pose, rate, before, limiter, h, .. } = self;
        let mut jumps = false;
        for (((rate, pose), before), most) in
            rate.iter_mut().zip(pose).zip(before).zip(&limiter.limits().speed)
        {
            *rate = (*pose - *before) / *h;
            jumps |= rate.abs() > *most;
        }
        if jumps {
            rate.fill(0.0);
        }
    }
}
