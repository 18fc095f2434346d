use super::current_tension::CurrentTension;
use super::limits::{Limits, MuscleLimits};
use super::signals::NamedFault;
use crate::Error;
use crate::control::arm::{ArmController, ArmMeasurement, Fault, Symptom};
use crate::control::tension::{Distribution, Problem};
use crate::drive::DriveCommand;
use crate::muscle::MuscleDynamics;
use alloc::vec;
use alloc::vec::Vec;

/// Takes up the slack of all cables and gives them their tensions.
///
/// ```text
/// F_d   = argmin |F|^2   subject to   R^T F = g(q),  F_min <= F <= F_max              (21, 22) at rest
/// T*    = s T_in(F_d),   s' = 1/t_r  while  T >= s T*/2 - T_s of every cable           T_in: (7), toward the motor
/// v     = clip((T* - T) C/t_v, 0, v_u),   v_u while T < T_s and T < T*
/// ```
///
/// | symbol | meaning                                                          | unit  |
/// |--------|------------------------------------------------------------------|-------|
/// | q, g, R | measured pose, gravity and springs in it, moment arms             | rad, Nm, m |
/// | T, T*  | tension at the drive's outlet, its target                          | N     |
/// | s      | fraction of the tensions, 0 to 1: all rise together                   | 1     |
/// | C, t_v | compliance of the cable, [`TIME_CONSTANT`]                          | m/N, s |
/// | t_r, v_u, T_s | [`SafetyLimits::pretension_time`](crate::machine::SafetyLimits), [`MuscleLimits`](super::MuscleLimits) | s, m/s, N |
///
/// Where a tension is not measured, `T` is that of the motor's current, and in the end the winch turns by a
/// fraction of a millimetre, which tells it: [`CurrentTension`]. The limb is carried where it is: the
/// tensions balance it in its measured pose. It ends once every tension is [`REACHED`] of its target, at
/// once where all cables are tense already and measured.
///
/// # Source
/// Our own.
#[derive(Debug, Clone)]
pub(super) struct Pretension {
    body: MuscleDynamics,
    distribution: Distribution,
    minimum: Vec<f64>,
    maximum: Vec<f64>,
    zeros: Vec<f64>,
    ones: Vec<f64>,
    torque: Vec<f64>,
    still: Vec<f64>,
    pose: Vec<f64>,
    /// `T_in(F_d)`, N: `[muscles]`.
    goal: Vec<f64>,
    /// Of the whole cable and of its free length at the drive, m/N: `[muscles]`.
    compliance: Vec<[f64; 2]>,
    /// Commanded speed, m/s: `[muscles]`.
    speed: Vec<f64>,
    /// Cable wound in, m: `[muscles]`.
    taken: Vec<f64>,
    /// Since when its load cell has been silent, s: `[muscles]`.
    silent_for: Vec<f64>,
    /// Its last reading, N; NaN before the first.
    previous: Vec<f64>,
    fraction: f64,
    /// Of every muscle without a load cell, once every tension has been at its target: `[muscles]`.
    by_current: Vec<Option<CurrentTension>>,
    wound_in: bool,
    /// Whether every tension has been at its target and is known.
    pub(super) tense: bool,
}

/// Time constant with which a tension follows its target, s.
const TIME_CONSTANT: f64 = 0.1;
/// How long a load cell may be silent, s: without it the tension of its cable is unknown.
const SILENCE: f64 = 0.1;
/// Fraction of a tension's target from which on a cable is tense: friction and load cell are not known
/// better.
const REACHED: f64 = 0.6;
/// Fraction of the present target that every cable has before all rise further.
const TOGETHER: f64 = 0.5;

impl Pretension {
    pub(super) fn new(controller: &ArmController) -> Result<Self, Error> {
        let body = MuscleDynamics::new(controller.robot())?;
        let (m, n) = (body.muscles(), body.joints());
        let limits = controller.gains().tension_limits();
        let compliance = |k| {
            let cells = controller.cable_law(k)?.compliance();
            Ok([cells.iter().sum(), cells.first().copied().unwrap_or(0.0)])
        };
        Ok(Self {
            distribution: Distribution::new(m, n),
            minimum: limits.iter().map(|[least, _]| *least).collect(),
            maximum: limits.iter().map(|[_, most]| *most).collect(),
            zeros: vec![0.0; m],
            ones: vec![1.0; m],
            torque: vec![0.0; n],
            still: vec![0.0; n],
            pose: vec![0.0; n],
            goal: vec![0.0; m],
            compliance: (0..m).map(compliance).collect::<Result<_, Error>>()?,
            speed: vec![0.0; m],
            taken: vec![0.0; m],
            silent_for: vec![0.0; m],
            previous: vec![f64::NAN; m],
            fraction: 0.0,
            by_current: vec![None; m],
            wound_in: false,
            tense: false,
            body,
        })
    }

    /// Begins in a measured pose; a coordinate that is not measured is that of `other`.
    ///
    /// # Errors
    /// As [`MuscleDynamics::inverse_dynamics`] and [`Distribution::solve`].
    pub(super) fn begin(
        &mut self,
        controller: &ArmController,
        measured: &ArmMeasurement<'_>,
        other: &[f64],
    ) -> Result<(), Error> {
        self.fraction = 0.0;
        self.by_current.fill(None);
        self.wound_in = false;
        self.speed.fill(0.0);
        self.taken.fill(0.0);
        self.silent_for.fill(0.0);
        self.previous.fill(f64::NAN);
        let coordinates = measured.joint.iter().zip(other);
        for (pose, (measured, other)) in self.pose.iter_mut().zip(coordinates) {
            *pose = if measured.is_finite() { *measured } else { *other };
        }
        self.body.evaluate(&self.pose)?;
        self.body.inverse_dynamics(&self.still, &self.still, &mut self.torque)?;
        let solution = self.distribution.solve(&Problem {
            moment_arms: self.body.moment_arms(),
            torque: &self.torque,
            minimum: &self.minimum,
            maximum: &self.maximum,
            reference: &self.zeros,
            weight: &self.ones,
        })?;
        for (k, (goal, tension_out)) in self.goal.iter_mut().zip(solution.tension).enumerate() {
            *goal = controller.cable_law(k)?.steady(*tension_out, 0.0, 1.0)?.tension_in;
        }
        self.tense = self.is_tense(measured.tension);
        Ok(())
    }

    fn is_tense(&self, tension: &[f64]) -> bool {
        tension.iter().zip(&self.goal).all(|(tension, goal)| *tension >= REACHED * goal)
    }

    /// Tension at a drive that its currents in both directions have told, N.
    pub(super) fn told(&self, muscle: usize) -> Option<f64> {
        self.by_current[muscle].as_ref().and_then(CurrentTension::tension)
    }

    /// Commands of `h` s; the fault of a cable whose slack is not wound in, whose load
    /// cell is silent or has jumped, or whose winch does not turn. Such a cable is not tightened.
    pub(super) fn step(
        &mut self,
        h: f64,
        controller: &ArmController,
        limits: &Limits,
        seen: &Readings<'_>,
        drives: &mut [DriveCommand],
    ) -> Option<NamedFault> {
        let mut fault = None;
        let mut together = true;
        for (k, (drive, limit)) in drives.iter_mut().zip(&limits.muscles).enumerate() {
            let (speed, found) = if self.wound_in {
                self.turn(h, k, limit, seen)
            } else {
                together &= seen.tension[k] >= TOGETHER * self.fraction * self.goal[k] - limit.slack_tension;
                self.wind_in(h, k, controller, limit, seen.tension[k])
            };
            fault = fault.or(found).or(self.silence(h, k, seen.tension[k]));
            *drive = DriveCommand::Velocity(speed);
        }
        if self.wound_in {
            self.tense = (0..drives.len()).all(|k| self.by_current[k].is_none() || self.told(k).is_some());
            return fault;
        }
        if together {
            self.fraction = (self.fraction + h / limits.safety.pretension_time).min(1.0);
        }
        self.wound_in = self.fraction >= 1.0 && self.is_tense(seen.tension);
        if self.wound_in {
            for (k, (by_current, limit)) in self.by_current.iter_mut().zip(&limits.muscles).enumerate() {
                let motor = limit.motor.as_ref().filter(|_| !controller.gains().muscles[k].load_cell);
                *by_current = motor.and_then(|(drive, _)| {
                    CurrentTension::new(drive, self.goal[k], self.compliance[k], seen.motor[k])
                });
            }
            self.tense = self.by_current.iter().all(Option::is_none);
        }
        fault
    }

    /// Speed of a winch that takes up its cable, m/s.
    fn wind_in(
        &mut self,
        h: f64,
        k: usize,
        controller: &ArmController,
        limit: &MuscleLimits,
        measured: f64,
    ) -> (f64, Option<NamedFault>) {
        let target = self.fraction * self.goal[k];
        let gains = &controller.gains().muscles[k];
        let lacking = if measured.is_finite() { (target - measured).max(0.0) } else { 0.0 };
        let slack = measured < limit.slack_tension && lacking > 0.0;
        let tighten = (lacking * self.compliance[k][0] / TIME_CONSTANT).min(limit.wind_in_speed);
        let speed = if slack { limit.wind_in_speed } else { tighten };
        // Gently where the current tells the tension, so that little of it accelerates the rotor.
        let gentle = if gains.load_cell { f64::INFINITY } else { limit.wind_in_speed / TIME_CONSTANT };
        let most = h * gains.max_winch_acceleration.min(gentle);
        self.speed[k] += (speed - self.speed[k]).clamp(-most, most);
        self.taken[k] += h * self.speed[k];
        // Beyond the stretch at its target it is slack that was wound in.
        let stretch = self.goal[k] * self.compliance[k][0];
        let mut fault = None;
        if self.taken[k] > limit.largest_slack + stretch {
            fault = Some(NamedFault::new(Fault::Slack(k), Symptom::Unknown));
        }
        let change = (measured - core::mem::replace(&mut self.previous[k], measured)).abs();
        if gains.load_cell && change > gains.implausible_step(measured) {
            fault = fault.or(Some(NamedFault::new(Fault::TensionSensor(k), Symptom::Jumped)));
        }
        (self.speed[k], fault)
    }

    /// Speed of a winch whose currents tell its tension, m/s; others stand meanwhile.
    fn turn(
        &mut self,
        h: f64,
        k: usize,
        limit: &MuscleLimits,
        seen: &Readings<'_>,
    ) -> (f64, Option<NamedFault>) {
        let Some(by_current) = &mut self.by_current[k] else { return (0.0, None) };
        let most = limit.wind_in_speed;
        let speed = by_current.step(h, seen.motor[k], seen.current[k][0]).clamp(-most, most);
        let stands = by_current.stands();
        (speed, stands.then_some(NamedFault::new(Fault::Drive(k), Symptom::Standing)))
    }

    fn silence(&mut self, h: f64, k: usize, measured: f64) -> Option<NamedFault> {
        self.silent_for[k] = if measured.is_finite() { 0.0 } else { self.silent_for[k] + h };
        (self.silent_for[k] > SILENCE).then_some(NamedFault::new(Fault::TensionSensor(k), Symptom::Lost))
    }
}

/// What is read in a cycle: `[muscles]`.
pub(super) struct Readings<'a> {
    /// Measured tensions, and those by the current, N.
    pub(super) tension: &'a [f64],
    /// Positions of the winches, m.
    pub(super) motor: &'a [f64],
    /// Currents, read and smoothed, A.
    pub(super) current: &'a [[f64; 2]],
}
