use super::health::{CableHealth, HealthMonitor};
use super::held::HeldReference;
use super::limits::Limits;
use super::mode::{Mode, Request};
use super::monitor::LimitMonitor;
use super::pretension::{Pretension, Readings};
use super::safe_stop::SafeStop;
use super::signals::{ExchangeStatus, MuscleState, NamedFault, SupervisorCommand};
use super::threshold::Threshold;
use super::transitions::{Condition, TRANSITIONS, Transition, next};
use crate::Error;
use crate::control::arm::{ArmController, ArmMeasurement, ArmStatus, Fault, PreviewedReference, Symptom};
use crate::drive::DriveCommand;
use crate::error::check_length;
use alloc::vec;
use alloc::vec::Vec;

/// Operates a machine: takes it from standing without tension to following a reference and back, and answers
/// its faults.
///
/// ```text
/// exchange, measurement -> limits, faults -> mode (TRANSITIONS) -> winches:
///   off: amplifiers off   ready, fault: stand   pretension: wind in   hold, run: ArmController
///   safe stop: brake, release
/// ```
///
/// The controller's own detection of faults is part of it; limits, slack, lost and late cycles, stale
/// commands and reports of drives are added. Within one control cycle it passes any number of modes: a
/// machine whose cables are tense follows its reference from the first cycle of [`Request::Run`] on, with the
/// same commands bit for bit as its controller alone.
///
/// # Assumes
/// One fault at a time; a brake at every drive.
///
/// # Source
/// Our own.
#[derive(Debug, Clone)]
pub struct Supervisor {
    controller: ArmController,
    limits: Limits,
    mode: Mode,
    goal: Request,
    last_request: Request,
    fault: Option<NamedFault>,
    monitor: LimitMonitor,
    health: HealthMonitor,
    pretension: Pretension,
    safe_stop: SafeStop,
    held: HeldReference,
    drives: Vec<DriveCommand>,
    muscles: Vec<MuscleState>,
    /// Of every muscle without a load cell the tension that its motor's current tells, of others the measured
    /// one, N: `[muscles]`.
    tension: Vec<f64>,
    /// Currents of the motors as read last, and smoothed, A, NaN where they are not known: `[muscles]`.
    current: Vec<[f64; 2]>,
    /// Time for which no readings have come, s.
    lost_for: f64,
    /// Lateness of the cycles of about the last second, of each a period at most, s.
    late_by: f64,
    /// Lateness of this cycle, s.
    late: f64,
}

/// Fraction of a period up to which a cycle begins in time.
const LATE_FRACTION: f64 = 0.25;
/// s: time in which late cycles are forgotten.
const LATENESS_MEMORY: f64 = 1.0;

/// s: time constant with which currents are smoothed, since most of a single one may be that of a rotor's
/// acceleration.
const CURRENT_SMOOTHING: f64 = 0.05;

/// What the conditions of the transitions are at present.
struct Conditions {
    tense: bool,
    near: bool,
    down: bool,
    /// Whether a fault led to the present safe stop.
    stopped: bool,
    fault: bool,
    stale: bool,
}

impl Conditions {
    fn hold(&self, condition: Condition) -> bool {
        match condition {
            Condition::Always => true,
            Condition::Tense => self.tense,
            Condition::ReferenceNear => self.near,
            Condition::Released => self.down && !self.stopped,
            Condition::ReleasedAfterFault => self.down && self.stopped,
            Condition::Fault => self.fault,
            Condition::StaleCommand => self.stale,
        }
    }
}

impl Supervisor {
    /// A machine that is off.
    ///
    /// # Errors
    /// [`Error::WrongLength`] for limits of another machine; as
    /// [`MuscleDynamics::new`](crate::muscle::MuscleDynamics::new).
    pub fn new(controller: ArmController, limits: Limits) -> Result<Self, Error> {
        let [muscles, joints] = controller.dimensions();
        check_length("limits of muscles", limits.muscles.len(), muscles)?;
        check_length("limits of joints", limits.ranges.len(), joints)?;
        limits.safety.validate()?;
        Ok(Self {
            mode: Mode::Off,
            goal: Request::None,
            last_request: Request::None,
            fault: None,
            monitor: LimitMonitor::new(&limits),
            health: HealthMonitor::new(muscles, joints),
            pretension: Pretension::new(&controller)?,
            safe_stop: SafeStop::new(muscles),
            held: HeldReference::new(joints),
            drives: vec![DriveCommand::Off; muscles],
            muscles: vec![MuscleState::Relaxed; muscles],
            tension: vec![f64::NAN; muscles],
            current: vec![[f64::NAN; 2]; muscles],
            lost_for: 0.0,
            late_by: 0.0,
            late: 0.0,
            controller,
            limits,
        })
    }

    /// The same with the limits that the controller's gains alone tell.
    ///
    /// # Errors
    /// As [`new`](Self::new).
    pub fn from_controller(controller: ArmController) -> Result<Self, Error> {
        let limits = Limits::of_gains(controller.gains());
        Self::new(controller, limits)
    }

    /// Number of muscles and of independent joints.
    #[must_use]
    pub fn dimensions(&self) -> [usize; 2] {
        self.controller.dimensions()
    }

    /// The present mode.
    #[must_use]
    pub fn mode(&self) -> Mode {
        self.mode
    }

    /// Its limits.
    #[must_use]
    pub fn limits(&self) -> &Limits {
        &self.limits
    }

    /// Other limits from the next cycle on: those of another task.
    ///
    /// # Errors
    /// [`Error::WrongLength`] for limits of another machine; as
    /// [`SafetyLimits::validate`](crate::machine::SafetyLimits::validate).
    pub fn set_limits(&mut self, limits: Limits) -> Result<(), Error> {
        let [muscles, joints] = self.dimensions();
        check_length("limits of muscles", limits.muscles.len(), muscles)?;
        check_length("limits of joints", limits.ranges.len(), joints)?;
        limits.safety.validate()?;
        self.limits = limits;
        Ok(())
    }

    /// The number by which a fault is judged; none where it is judged by a prediction.
    #[must_use]
    pub fn threshold(&self, fault: Fault) -> Option<Threshold> {
        Threshold::new(fault, &self.limits, self.controller.gains())
    }

    /// Its controller.
    #[must_use]
    pub fn controller(&self) -> &ArmController {
        &self.controller
    }

    /// Slow changes of the cables: `[muscles]`.
    #[must_use]
    pub fn health(&self) -> &[CableHealth] {
        self.health.health()
    }

    /// Temperature of a motor's winding by its thermal model, degrees Celsius; 25 where the drive is not
    /// known.
    #[must_use]
    pub fn winding(&self, muscle: usize) -> f64 {
        self.monitor.winding(muscle)
    }

    /// Tensions to be followed in [`Mode::Run`] from the next cycle on; see [`ArmController::set_tensions`].
    ///
    /// # Errors
    /// As [`ArmController::set_tensions`].
    pub fn set_tensions(&mut self, tensions: Option<&[f64]>) -> Result<(), Error> {
        self.controller.set_tensions(tensions.filter(|_| self.mode == Mode::Run))
    }

    /// Takes the currents of the motors, A, for the next cycle, NaN where they are not known: without a load
    /// cell they tell when a cable is tense. They are rounded to 1 mA, as they are recorded.
    ///
    /// # Errors
    /// [`Error::WrongLength`] for another number of muscles.
    pub fn set_currents(&mut self, current: &[f64]) -> Result<(), Error> {
        check_length("currents", current.len(), self.current.len())?;
        for ([read, _], current) in self.current.iter_mut().zip(current) {
            *read = libm::round(1e3 * current) / 1e3;
        }
        Ok(())
    }

    /// One control cycle: the commands for the `h` s to come, from measurements, references, request and
    /// exchange at their beginning. Nothing is allocated.
    ///
    /// # Errors
    /// As [`ArmController::step`].
    pub fn step(
        &mut self,
        h: f64,
        measurement: &ArmMeasurement<'_>,
        reference: &PreviewedReference<'_>,
        request: Request,
        exchange: &ExchangeStatus,
    ) -> Result<SupervisorCommand<'_>, Error> {
        self.controller.check(measurement, reference)?;
        self.take(request);
        let found = self.detect(h, measurement, exchange);
        self.take_tensions(h, measurement.tension);
        let tension = core::mem::take(&mut self.tension);
        // An observer begins with what the current tells, and is not corrected by it.
        let seen = if self.mode.is_controlled() { measurement.tension } else { &tension };
        let measurement = &ArmMeasurement { tension: seen, ..*measurement };
        let done = self.follow(h, (measurement, &tension), reference, exchange, found);
        self.tension = tension;
        let status = done?;
        Ok(SupervisorCommand {
            mode: self.mode,
            fault: self.reported(status, exchange),
            muscles: &self.muscles,
            reference: &self.held.reference,
            arm: self.controller.outputs(&self.drives, status),
        })
    }

    /// The measured tensions, and of muscles without a load cell those of their motors' currents.
    fn take_tensions(&mut self, h: f64, measured: &[f64]) {
        let Self { tension, current, limits, controller, drives, pretension, .. } = self;
        let muscles = limits.muscles.iter().zip(&controller.gains().muscles).zip(drives);
        for (k, ((limit, gains), drive)) in muscles.enumerate() {
            let speed = if let DriveCommand::Velocity(speed) = drive { *speed } else { 0.0 };
            let [read, smooth] = &mut current[k];
            let change = (h / CURRENT_SMOOTHING).min(1.0) * (*read - *smooth);
            *smooth = if change.is_nan() { *read } else { *smooth + change };
            tension[k] = match &limit.motor {
                Some((drive, _)) if !gains.load_cell => {
                    let told = pretension.told(k).filter(|_| self.mode == Mode::Pretension);
                    told.unwrap_or_else(|| drive.tension_by_current(*smooth, speed))
                }
                _ => measured[k],
            };
        }
    }

    /// What follows from the request and the faults that were found.
    fn follow(
        &mut self,
        h: f64,
        (measurement, tension): (&ArmMeasurement<'_>, &[f64]),
        reference: &PreviewedReference<'_>,
        exchange: &ExchangeStatus,
        found: Option<NamedFault>,
    ) -> Result<ArmStatus, Error> {
        self.follow_transitions(measurement, reference, exchange, found)?;
        let status = self.act(h, (measurement, tension), reference, exchange, found)?;
        self.describe_muscles(measurement);
        Ok(status)
    }

    /// A request that differs from that of the cycle before becomes the goal. A reset has a meaning in a
    /// fault alone: asked for earlier it does not take the place of a stop.
    fn take(&mut self, request: Request) {
        let early = request == Request::Reset && self.mode != Mode::Fault && self.goal.is_stop();
        if request != self.last_request && request != Request::None && !early {
            self.goal = request;
        }
        self.last_request = request;
    }

    /// Faults that the controller does not see.
    fn detect(
        &mut self,
        h: f64,
        measurement: &ArmMeasurement<'_>,
        exchange: &ExchangeStatus,
    ) -> Option<NamedFault> {
        self.lost_for = if exchange.received { 0.0 } else { self.lost_for + h };
        // A computer wakes a program some ten microseconds late; that is no fault.
        let late = exchange.lateness.is_finite() && exchange.lateness > LATE_FRACTION * h;
        self.late = if late { exchange.lateness } else { 0.0 };
        // A single stall counts as one late cycle, whatever its length below its limit.
        self.late_by = self.late_by * (1.0 - (h / LATENESS_MEMORY).min(1.0)) + self.late.min(h);
        let safety = &self.limits.safety;
        let reported = |fault| Some(NamedFault::new(fault, Symptom::Reported));
        // Half a cycle of tolerance for times that are sums of cycles.
        let lost = self.lost_for > safety.bridged_loss + 0.5 * h;
        let late = self.late_by > safety.lateness || self.late > safety.bridged_lateness + 0.5 * h;
        // Readings that were rejected do not exceed limits: the controller has its own answer to them.
        let observed = self.mode.is_controlled().then(|| self.controller.observed());
        let accepted = observed.map_or(*measurement, |seen| ArmMeasurement {
            motor: seen.motor,
            tension: seen.tension,
            joint: seen.joint,
        });
        let estimated = observed.map(|seen| seen.tension_in);
        let exceeded = self.monitor.update(h, &self.limits, &accepted, estimated);
        // What a false sensor has led to is named by the sensor.
        let sensors = exceeded.filter(|_| observed.is_some()).and_then(|f| self.controller.cause_of(f.fault));
        let exceeded = sensors.map(|fault| NamedFault::new(fault, Symptom::Deviating)).or(exceeded);
        let powered = !matches!(self.mode, Mode::Off | Mode::Fault);
        let tense = self.mode.is_controlled() || self.mode == Mode::Pretension;
        match exchange.drive {
            Some(muscle) if powered && muscle < self.drives.len() => reported(Fault::Drive(muscle)),
            _ if lost && powered => reported(Fault::Bus),
            _ if late && tense => reported(Fault::LateCycles),
            _ => exceeded.filter(|_| tense),
        }
    }

    fn conditions(
        &self,
        reference: &PreviewedReference<'_>,
        exchange: &ExchangeStatus,
        fault: bool,
    ) -> Conditions {
        let age = exchange.command_age.unwrap_or(0.0);
        Conditions {
            tense: self.pretension.tense,
            near: self.mode == Mode::Hold && self.held.is_near(reference.current, self.controller.gains()),
            down: self.safe_stop.is_down,
            stopped: self.fault.is_some(),
            fault,
            stale: age > self.limits.safety.command_age || age.is_nan(),
        }
    }

    /// Takes every transition that applies; a fault in a controlled mode is answered by its controller first.
    fn follow_transitions(
        &mut self,
        measurement: &ArmMeasurement<'_>,
        reference: &PreviewedReference<'_>,
        exchange: &ExchangeStatus,
        found: Option<NamedFault>,
    ) -> Result<(), Error> {
        for _ in 0..TRANSITIONS.len() {
            let fault = found.is_some() && matches!(self.mode, Mode::Ready | Mode::Pretension);
            let conditions = self.conditions(reference, exchange, fault);
            let Some(row) = next(self.mode, self.goal, |condition| conditions.hold(condition)) else { break };
            if row.condition == Condition::Fault || row.to == Mode::SafeStop {
                self.fault = found;
            }
            self.enter(row, measurement, reference)?;
        }
        Ok(())
    }

    /// What begins with a mode.
    fn enter(
        &mut self,
        row: &Transition,
        measurement: &ArmMeasurement<'_>,
        reference: &PreviewedReference<'_>,
    ) -> Result<(), Error> {
        match row.to {
            Mode::Pretension => {
                self.monitor.restart();
                let other = &reference.current.q;
                self.pretension.begin(&self.controller, measurement, other)?;
            }
            Mode::Hold if row.from == Mode::Pretension => {
                self.controller.restart();
                self.monitor.restart();
                self.health.restart();
                self.held.rest_at(measurement.joint, reference.current);
            }
            // The reference that was followed last is the one to be held.
            Mode::Hold => {}
            Mode::Run => self.fault = None,
            Mode::SafeStop => {
                let accepted = self.controller.observed().tension;
                self.safe_stop.begin(self.controller.gains(), &self.drives, accepted);
                self.brake_untrusted();
            }
            Mode::Ready if row.from == Mode::Fault => {
                (self.fault, self.late_by) = (None, 0.0);
                self.safe_stop.release();
            }
            Mode::Ready => self.safe_stop.release(),
            Mode::Fault => self.brake_untrusted(),
            Mode::Off => self.fault = None,
        }
        let ended = matches!(row.condition, Condition::Fault | Condition::StaleCommand);
        // What was asked for ends with a fault, but for turning off, which a fault does not undo.
        if (ended || row.to == Mode::Fault) && self.goal != Request::TurnOff {
            self.goal = Request::None;
        }
        if row.condition == Condition::StaleCommand {
            self.fault = Some(NamedFault::new(Fault::StaleCommand, Symptom::Reported));
        }
        self.mode = row.to;
        Ok(())
    }

    /// Brakes the drive of a fault that leaves its speed uncertain.
    fn brake_untrusted(&mut self) {
        if let Some(NamedFault {
            fault:
                Fault::Drive(k)
                | Fault::MotorSensor(k)
                | Fault::MotorOrJointSensor(k)
                | Fault::Overspeed(k)
                | Fault::Travel(k)
                | Fault::Overheating(k),
            ..
        }) = self.fault
        {
            self.safe_stop.brake(k);
        }
    }

    /// The commands of the present mode.
    fn act(
        &mut self,
        h: f64,
        (measurement, tension): (&ArmMeasurement<'_>, &[f64]),
        reference: &PreviewedReference<'_>,
        exchange: &ExchangeStatus,
        found: Option<NamedFault>,
    ) -> Result<ArmStatus, Error> {
        if self.mode.is_controlled() {
            return self.control(h, measurement, reference, exchange, found);
        }
        self.controller.observe_pose(measurement.joint);
        self.held.rest_at(measurement.joint, reference.current);
        if let Some(muscle) = exchange.drive {
            self.safe_stop.brake(muscle);
        }
        match self.mode {
            Mode::Off => self.drives.fill(DriveCommand::Off),
            Mode::Pretension => {
                let Self { pretension, controller, limits, drives, current, .. } = self;
                let seen = Readings { tension, motor: measurement.motor, current };
                if let Some(fault) = pretension.step(h, controller, limits, &seen, drives) {
                    self.follow_transitions(measurement, reference, exchange, Some(fault))?;
                }
            }
            Mode::SafeStop => {
                let Self { safe_stop, controller, limits, drives, .. } = self;
                let known = (controller.gains(), &*limits);
                safe_stop.step(h, known, tension, exchange.received, drives);
            }
            _ => self.safe_stop.stand(&mut self.drives),
        }
        let stopped = matches!(self.mode, Mode::SafeStop | Mode::Fault);
        Ok(match self.fault.filter(|_| stopped) {
            Some(named) => ArmStatus::Stopped(named.fault),
            None => ArmStatus::Holding,
        })
    }

    /// One cycle of the controller; where it stops, the safe stop begins.
    fn control(
        &mut self,
        h: f64,
        measurement: &ArmMeasurement<'_>,
        reference: &PreviewedReference<'_>,
        exchange: &ExchangeStatus,
        found: Option<NamedFault>,
    ) -> Result<ArmStatus, Error> {
        if let Some(NamedFault { fault, symptom }) = found {
            self.controller.stop_as(fault, symptom);
        }
        self.held.preview(self.controller.gains());
        let held = PreviewedReference {
            current: &self.held.reference,
            previewed: &self.held.previewed,
            repeat_time: None,
        };
        let followed = if self.mode == Mode::Run { reference } else { &held };
        if self.mode != Mode::Run {
            self.controller.set_tensions(None)?;
        }
        let command = self.controller.step(h, measurement, followed)?;
        self.drives.copy_from_slice(command.drives);
        let status = command.status;
        match self.mode {
            Mode::Hold => self.held.step(h, self.controller.gains()),
            _ => self.held.follow(reference.current),
        }
        if let ArmStatus::Stopped(fault) = status {
            self.fault = Some(NamedFault::new(fault, self.controller.observed().symptom));
            let fault = |condition| condition == Condition::Fault;
            if let Some(row) = next(self.mode, self.goal, fault) {
                self.enter(row, measurement, reference)?;
            }
            if let Some(muscle) = self.braked_muscle() {
                self.drives[muscle] = DriveCommand::Brake;
            }
        }
        if self.mode == Mode::Run && matches!(status, ArmStatus::Following) {
            self.health.update(h, &self.controller);
        }
        Ok(match status {
            ArmStatus::Degraded(_) if !exchange.received => ArmStatus::Degraded(Fault::Bus),
            ArmStatus::Following | ArmStatus::Holding if self.late > h => {
                ArmStatus::Degraded(Fault::LateCycles)
            }
            status => status,
        })
    }

    fn braked_muscle(&self) -> Option<usize> {
        let muscle = self.fault.and_then(NamedFault::muscle)?;
        (self.safe_stop.state(muscle) == MuscleState::Braked).then_some(muscle)
    }

    /// The fault to be reported with a status.
    fn reported(&self, status: ArmStatus, exchange: &ExchangeStatus) -> Option<NamedFault> {
        match status {
            ArmStatus::Degraded(fault) => {
                let symptom = match exchange.received && fault != Fault::LateCycles {
                    true => self.controller.observed().symptom,
                    false => Symptom::Reported,
                };
                Some(NamedFault::new(fault, symptom))
            }
            _ => self.fault,
        }
    }

    fn describe_muscles(&mut self, measurement: &ArmMeasurement<'_>) {
        let accepted = self.controller.observed().tension;
        let faulty = self.fault.and_then(NamedFault::muscle);
        for (k, state) in self.muscles.iter_mut().enumerate() {
            *state = match self.mode {
                Mode::Off => MuscleState::Relaxed,
                Mode::Pretension => MuscleState::TakingUp,
                Mode::Hold | Mode::Run if accepted[k].is_nan() => MuscleState::Estimated,
                Mode::Hold | Mode::Run => MuscleState::Tense,
                Mode::SafeStop | Mode::Fault if self.safe_stop.state(k) == MuscleState::Braked => {
                    MuscleState::Braked
                }
                Mode::SafeStop | Mode::Fault if faulty == Some(k) => MuscleState::Faulty,
                Mode::SafeStop => self.safe_stop.state(k),
                Mode::Ready | Mode::Fault => {
                    let tense = measurement.tension[k] > self.controller.gains().muscles[k].slack_tension;
                    if tense { MuscleState::Tense } else { MuscleState::Relaxed }
                }
            };
        }
    }
}
