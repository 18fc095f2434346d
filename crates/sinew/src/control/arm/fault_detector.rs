use super::gains::{ArmGains, JointGains, MuscleGains};
use super::isolation::{Finding, Isolation, Seen};
use super::joint_monitor::{EncoderCheck, JointMonitor, JointPrediction};
use super::sensor_monitor::{SensorLimits, SensorMonitor};
use super::signals::ArmMeasurement;
use super::silence::Silence;
use super::status::{ArmStatus, Fault, Symptom};
use super::unmeasured_joints::UnmeasuredJoints;
use crate::trajectory::Reference;
use alloc::vec;
use alloc::vec::Vec;

/// Estimates and commands from before a measurement, with which it is compared.
#[derive(Debug)]
pub(super) struct Prediction<'a> {
    /// Commanded speed of every winch, m/s; NaN where the drive was given a tension.
    pub(super) winch_speed: &'a [f64],
    /// Estimated tension at every drive's outlet, N.
    pub(super) tension_in: &'a [f64],
    /// Estimated tension at every anchor, N.
    pub(super) tension_out: &'a [f64],
    /// Speed of every winch in addition to its encoder's that its load cell asks for, m/s.
    pub(super) unexplained_speed: &'a [f64],
    /// Estimated angle, rad, speed, rad/s, and disturbance, rad/s^2, of every joint.
    pub(super) joint: [&'a [f64]; 3],
    /// Torque of the disturbances at every joint, Nm.
    pub(super) disturbance_torque: &'a [f64],
    /// Stiffness with which the muscles hold every joint, Nm/rad.
    pub(super) joint_stiffness: &'a [f64],
    /// Reference of the joints.
    pub(super) reference: &'a Reference,
    /// Load cells that correct no observer.
    pub(super) unmeasured: &'a UnmeasuredJoints,
}

/// Time for which a fault has to persist before it stops the arm, s; of a motor encoder cycles, at least:
/// what is lost with the whole exchange is named by the supervisor before.
const PERSISTENCE_TIME: f64 = 0.03;
const PERSISTENT_CYCLES: f64 = 3.0;
/// The same for a joint encoder, which the muscles replace.
const JOINT_PERSISTENCE_TIME: f64 = 0.25;
/// Fraction of a missing tension that the commanded travel of an unchanged motor encoder explains where it is
/// at fault.
const UNSEEN_FRACTION: f64 = 0.5;
/// Time of equal readings of a motor encoder, two at least, with which a winch that lags its command is one
/// that stands, s.
const STANDING_TIME: f64 = 0.005;
/// Any origin of a motor encoder, m, and of a load cell, N.
const ANY_ORIGIN: f64 = 1e4;

/// Fraction of the commanded travel that a load cell has to confirm for the fault of an unchanged motor
/// encoder to be its own and not its drive's, 1.
const CONFIRMED_FRACTION: f64 = 0.5;
/// Time constant with which the residual of a winch's travel is forgotten, s.
const WINCH_RESIDUAL_DECAY: f64 = 0.2;
/// Time in which commanded travel without a change of the motor encoder is forgotten, s.
const TRAVEL_FORGETTING_TIME: f64 = 1.0;
/// Time in which a winch at full speed travels as far as what it does beside its command may change in one
/// cycle, s; what it may do meanwhile, as a fraction of full speed, 1.
const MOTOR_STEP_TIME: f64 = 1.3e-3;
const MOTOR_UNCERTAINTY: f64 = 0.01;
/// `t_m`, s: time for which a tension has to be missing before it is rejected; a light limb that vibrates at
/// the mode of its cables lets the drives' ends go slack for some milliseconds.
const MISSING_TIME: f64 = 0.005;
/// `c`, fraction of its estimate by which a tension has to be below it, beside `dT`, to be missing.
const MISSING_FRACTION: f64 = 0.8;

/// Time after which a tension that is missing while the joint has its force is a fault of the load cell, s.
const JUDGEMENT_TIME: f64 = 0.1;
/// Time within which it may still show that the cable has broken, s.
const BREAK_MEMORY: f64 = 1.0;
/// Fraction of its force at the anchor that a joint lacks where a cable has broken: until [`JUDGEMENT_TIME`],
/// and later.
const BROKEN_FRACTION: [f64; 2] = [0.12, 0.3];

/// Detects faults from residuals between measurements and predictions; replaces or withholds what it rejects.
///
/// ```text
/// joint encoder   JointMonitor: against the muscles, the reference and itself
/// motor encoder   SensorMonitor with e = h v_c; jumped where dx - h v_c changes by more than v_max t_x, until it is back; unchanged over e_max: fault of the encoder where
///                   x_T + (T - T^)/K > c_x x_c, x_T = int v_T dt since the output changed; else of the drive
/// load cell       SensorMonitor with e = 1
/// drive           r_v = (r_v + h v_c - dx)(1 - h/t_f);                    fault at |r_v| > r_v,max
/// load cell, cable   T < T^ - max(dT, c T^) for longer than t_m: rejected; t_p: the cable has broken
/// tracking        |q_r - q^| >= e_q
/// ```
///
/// | symbol   | meaning                                                                    | unit   |
/// |----------|----------------------------------------------------------------------------|--------|
/// | v_c, dx  | commanded speed and measured displacement of a winch                         | m/s, m |
/// | T, T^    | measured and estimated tension at the drive's outlet                         | N      |
/// | v_T, x_c | correction of the observer by its load cell; commanded travel                | m/s, m |
/// | K        | stiffness of the cable                                                       | N/m    |
/// | t_f, t_m, t_p | decay of `r_v`, [`MISSING_TIME`], persistence time                     | s      |
/// | r_v,max, dT, e_q, e_max | [`MuscleGains`], [`JointGains`]                                |        |
///
/// A winch that moves while its encoder stands changes the tension; a winch that stands does not. A fault
/// degrades the arm at once; it stops it after the persistence time, but for that of a load cell. A rejected
/// motor position is continued by `h v_c`; a rejected joint angle or tension becomes NaN. A tracking error
/// while a tension is missing has the same cause as that. Stopping is final.
///
/// # Source
/// Residual evaluation with thresholds and persistence times, as usual; analytical redundancy as in
/// `chow1984`; thresholds from fault-free runs of the twin.
#[derive(Debug, Clone)]
pub(super) struct FaultDetector {
    silence: Silence,
    motors: Vec<SensorMonitor>,
    load_cells: Vec<SensorMonitor>,
    encoders: Vec<JointMonitor>,
    /// Load cells against encoders.
    pub(super) isolation: Isolation,
    joint_gains: Vec<JointGains>,
    muscle_gains: Vec<MuscleGains>,
    /// `K`, N/m: `[muscles]`.
    cable_stiffness: Vec<f64>,
    /// `r_v` of every winch, m.
    winch_residual: Vec<f64>,
    /// Time for which a motor encoder has been away from where its winch was commanded to, s.
    jumped_for: Vec<f64>,
    /// Travel of every winch beside its command in the last cycle, m.
    motor_off: Vec<f64>,
    /// Last change of every motor encoder, m, and the commanded travel against it since then, m, up to which
    /// a drive that reverses stands.
    reversal: Vec<[f64; 2]>,
    /// Whether an unchanged motor encoder is attributed to its drive.
    drive_standing: Vec<bool>,
    /// `x_T` and `x_c` of every winch, m.
    unchanged_travel: Vec<[f64; 2]>,
    /// Time for which every cable has lacked its tension, s.
    missing_for: Vec<f64>,
    /// Fault by which it lacks its tension, judged in the first cycle: [`Self::cause_of_missing_tension`].
    missing_by: Vec<(Fault, Symptom)>,
    /// Accepted or continued motor positions, m: `[muscles]`.
    pub(super) motor: Vec<f64>,
    /// Accepted tensions, N, NaN where rejected: `[muscles]`.
    pub(super) tension: Vec<f64>,
    /// Accepted joint angles, rad, NaN where rejected: `[joints]`.
    pub(super) joint: Vec<f64>,
    /// Outcome for every joint encoder: `[joints]`.
    pub(super) checks: Vec<EncoderCheck>,
    pub(super) status: ArmStatus,
    /// How the part of the present fault behaves.
    pub(super) symptom: Symptom,
    started: bool,
}

impl FaultDetector {
    /// With the stiffness of every cable, N/m, and a factor of the tolerances of the joint encoders.
    pub(super) fn new(cable_stiffness: &[f64], gains: &ArmGains, joint_tolerance: f64) -> Self {
        let (muscles, joints) = (gains.muscles.len(), gains.joints.len());
        let monitor = |max_rate: f64, max_unchanged: f64, forgetting_time: f64| {
            let initial_deviation = ANY_ORIGIN;
            SensorMonitor::new(SensorLimits { initial_deviation, max_rate, max_unchanged, forgetting_time })
        };
        let motor = |gains: &MuscleGains| {
            monitor(gains.max_motor_rate, gains.max_unchanged_travel, TRAVEL_FORGETTING_TIME)
        };
        let load_cell =
            |gains: &MuscleGains| monitor(gains.max_tension_rate, gains.max_equal_tensions, f64::INFINITY);
        Self {
            silence: Silence::NONE,
            motors: gains.muscles.iter().map(motor).collect(),
            load_cells: gains.muscles.iter().map(load_cell).collect(),
            joint_gains: gains.joints.clone(),
            muscle_gains: gains.muscles.clone(),
            encoders: vec![JointMonitor::new(joint_tolerance, 1.0 / gains.observer_bandwidth); joints],
            isolation: Isolation::new(cable_stiffness, gains),
            cable_stiffness: cable_stiffness.to_vec(),
            winch_residual: vec![0.0; muscles],
            jumped_for: vec![0.0; muscles],
            motor_off: vec![0.0; muscles],
            reversal: vec![[0.0; 2]; muscles],
            drive_standing: vec![false; muscles],
            unchanged_travel: vec![[0.0; 2]; muscles],
            missing_for: vec![0.0; muscles],
            missing_by: (0..muscles).map(|k| (Fault::Cable(k), Symptom::Unknown)).collect(),
            motor: vec![0.0; muscles],
            tension: vec![0.0; muscles],
            joint: vec![0.0; joints],
            checks: vec![EncoderCheck::Rejected; joints],
            status: ArmStatus::Following,
            symptom: Symptom::Unknown,
            started: false,
        }
    }

    /// The next measurement is the first, and no fault has been found.
    pub(super) fn restart(&mut self) {
        self.motors.iter_mut().chain(&mut self.load_cells).for_each(SensorMonitor::restart);
        self.encoders.iter_mut().for_each(JointMonitor::restart);
        self.isolation.restart();
        self.winch_residual.fill(0.0);
        self.jumped_for.fill(0.0);
        self.motor_off.fill(0.0);
        self.reversal.fill([0.0; 2]);
        self.drive_standing.fill(false);
        self.unchanged_travel.fill([0.0; 2]);
        self.missing_for.fill(0.0);
        self.checks.fill(EncoderCheck::Rejected);
        self.silence = Silence::NONE;
        (self.status, self.symptom, self.started) = (ArmStatus::Following, Symptom::Unknown, false);
    }

    /// Compares a measurement, `h` s after the one before, with what was predicted for it.
    pub(super) fn update(&mut self, h: f64, measurement: &ArmMeasurement<'_>, prediction: &Prediction<'_>) {
        if !self.is_stopped() {
            (self.status, self.symptom) = (ArmStatus::Following, Symptom::Unknown);
        }
        self.silence.follow(h, measurement);
        self.check_joints(h, measurement.joint, prediction);
        self.check_motors(h, measurement, prediction);
        self.check_tensions(h, measurement.tension, prediction);
        self.started = true;
    }

    /// Stops the arm where the error of a joint, rad, is beyond its threshold or no number.
    pub(super) fn check_tracking(&mut self, error: &[f64]) {
        let mut joints = error.iter().zip(&self.joint_gains);
        let lost = joints.position(|(e, gains)| e.is_nan() || e.abs() >= gains.tracking_error);
        if let Some(joint) = lost {
            let slackest = self.missing_for.iter().enumerate().max_by(|a, b| a.1.total_cmp(b.1));
            let broken = slackest.filter(|(_, missing_for)| **missing_for > MISSING_TIME);
            let lost = (Fault::TrackingError(joint), Symptom::Unknown);
            let (fault, symptom) = broken.map_or(lost, |(cable, _)| self.missing_by[cable]);
            self.stop(fault, symptom);
        }
    }

    pub(super) fn is_stopped(&self) -> bool {
        matches!(self.status, ArmStatus::Stopped(_))
    }

    fn check_joints(&mut self, h: f64, measured: &[f64], prediction: &Prediction<'_>) {
        let [angle, speed, disturbance] = prediction.joint;
        let winches_move = prediction.winch_speed.iter().all(|speed| speed.is_finite());
        for (k, &measured) in measured.iter().enumerate() {
            if !self.joint_gains[k].encoder {
                (self.joint[k], self.checks[k]) = (f64::NAN, EncoderCheck::Absent);
                continue;
            }
            let predicted = JointPrediction {
                angle: angle[k],
                speed: speed[k],
                disturbance: disturbance[k],
                torque: prediction.disturbance_torque[k],
                reference: prediction.reference.q[k],
                reference_speed: prediction.reference.v[k],
                gains: &self.joint_gains[k],
                stiffness: prediction.joint_stiffness[k],
                winches_move,
            };
            let check = self.encoders[k].update(h, measured, &predicted);
            let usable = matches!(check, EncoderCheck::Accepted | EncoderCheck::Returned);
            self.joint[k] = if usable { measured } else { f64::NAN };
            self.checks[k] = check;
            if check != EncoderCheck::Accepted && !self.silence.explains(h, self.encoders[k].rejected_for) {
                let symptom = self.encoders[k].symptom();
                self.report(Fault::JointSensor(k), symptom);
                if self.encoders[k].rejected_for > JOINT_PERSISTENCE_TIME {
                    self.stop(Fault::JointSensor(k), symptom);
                }
            }
        }
    }

    fn check_motors(&mut self, h: f64, measurement: &ArmMeasurement<'_>, prediction: &Prediction<'_>) {
        for (k, &measured) in measurement.motor.iter().enumerate() {
            let speed = prediction.winch_speed[k];
            let gains = &self.muscle_gains[k];
            // A load cell that is rejected does not say whether its cable is slack.
            let rejected = self.load_cells[k].rejected_for > 0.0 || self.isolation.is_bridged(k);
            let alone = prediction.unmeasured.crossed[k];
            let tension = match (rejected, alone) {
                (true, _) => f64::NAN,
                (false, true) => measurement.tension[k],
                (false, false) => self.isolation.min_tension(k, measurement.tension[k]),
            };
            let reading = if alone { measurement.tension[k] } else { self.tension[k] };
            let innovation = reading - prediction.tension_in[k];
            let innovation = if innovation.is_finite() { innovation } else { 0.0 };
            let by_innovation = innovation / self.cable_stiffness[k];
            let blocked = may_ignore_command(speed, tension, gains.slack_tension);
            let (most, max_residual) = (gains.max_winch_speed, gains.max_winch_residual);
            let commanded = if speed.is_finite() { h * speed } else { 0.0 };
            let expected = if blocked { 0.0 } else { self.travel_beyond_reversal(k, commanded, tension) };
            let motor = &mut self.motors[k];
            let previous = motor.previous();
            // After a loss the winch may be elsewhere than it was commanded to.
            let lost = motor.rejected_for > 0.0 && self.jumped_for[k] == 0.0;
            let plausible = motor.update(h, measured, expected);
            // A winch that moves by itself gathers speed; a reading that jumps does not.
            let off = measured - self.motor[k] - commanded;
            // A reading that stood and goes on has the travel of that time to make up.
            let stood = 1.5 * self.unchanged_travel[k][1].abs();
            let freely = stood + if blocked { h * most } else { 0.0 };
            let allowed = freely + most * (MOTOR_STEP_TIME.max(h) + MOTOR_UNCERTAINTY * self.jumped_for[k]);
            let before = if self.jumped_for[k] > 0.0 { 0.0 } else { self.motor_off[k] };
            let jumped = self.started && !lost && (off - before).abs() > allowed;
            if !jumped {
                self.motor_off[k] = if self.started && off.is_finite() && stood <= 0.0 { off } else { 0.0 };
            }
            self.jumped_for[k] = if jumped { self.jumped_for[k] + h } else { 0.0 };
            let accepted = plausible && !jumped;
            let moved = if accepted && self.started { measured - self.motor[k] } else { commanded };
            self.motor[k] = if accepted { measured } else { self.motor[k] + commanded };
            let rejected_for = motor.rejected_for.max(self.jumped_for[k]);
            let symptom = if plausible && jumped { Symptom::Jumped } else { motor.symptom() };
            let changed = motor.has_changed();
            let [by_tension, by_command] = &mut self.unchanged_travel[k];
            if changed {
                let last = measured - previous;
                self.reversal[k] = [if self.started && last.is_finite() { last } else { 0.0 }, 0.0];
                // An observer that its cell does not correct is off already.
                (*by_tension, *by_command) = (if alone { -by_innovation } else { 0.0 }, 0.0);
            } else if accepted {
                *by_tension += h * prediction.unexplained_speed[k];
                *by_command += commanded;
            }
            if changed {
                self.drive_standing[k] = false;
            } else if accepted {
                self.drive_standing[k] = !self.is_travel_confirmed(k, by_innovation);
            }
            if !accepted {
                let (fault, symptom) = match self.drive_standing[k] {
                    true => (Fault::Drive(k), Symptom::Standing),
                    false => (Fault::MotorSensor(k), symptom),
                };
                self.report_vital(h, rejected_for, fault, symptom);
            }
            let residual = if blocked { 0.0 } else { h * speed - moved };
            self.winch_residual[k] = (self.winch_residual[k] + residual) * (1.0 - h / WINCH_RESIDUAL_DECAY);
            if self.winch_residual[k].abs() > max_residual {
                // The travel since the output last changed is what a standing winch lacks.
                let stood = !changed && self.motors[k].has_stood_for(STANDING_TIME.max(2.0 * h));
                self.stop(Fault::Drive(k), if stood { Symptom::Standing } else { Symptom::Unknown });
            }
        }
    }

    /// The part of a commanded travel, m, that a drive takes at once: where it reverses under a tension, N,
    /// its speed control first takes back the friction of the reducer.
    fn travel_beyond_reversal(&mut self, k: usize, commanded: f64, tension: f64) -> f64 {
        let [last, taken] = &mut self.reversal[k];
        if commanded * *last >= 0.0 {
            return commanded;
        }
        let left = self.muscle_gains[k].reversal_travel * tension.max(0.0) - *taken;
        let standing = left.max(0.0).min(commanded.abs());
        *taken += standing;
        commanded - standing.copysign(commanded)
    }

    /// Whether the load cell of a winch confirms its commanded travel while the encoder's output is
    /// unchanged; `by_innovation` is the travel that makes up for its difference, m.
    fn is_travel_confirmed(&self, k: usize, by_innovation: f64) -> bool {
        let [by_tension, by_command] = self.unchanged_travel[k];
        let confirmed = (by_tension + by_innovation) * by_command.signum();
        confirmed > CONFIRMED_FRACTION * by_command.abs()
    }

    fn check_tensions(&mut self, h: f64, measured: &[f64], prediction: &Prediction<'_>) {
        let [pose, ..] = prediction.joint;
        for (k, &measured) in measured.iter().enumerate() {
            let estimated = prediction.tension_in[k];
            let before = self.load_cells[k].previous();
            let plausible = self.load_cells[k].update(h, measured, 1.0);
            if prediction.unmeasured.crossed[k] {
                self.check_lone_cell(k, h, (before, plausible.then_some(measured)), prediction);
                continue;
            }
            // What is missing or stuck has no step; what comes after it has to agree with its estimate.
            let present = if plausible { measured } else { f64::NAN };
            let trusted = !self.started || self.isolation.check(k, h, present, estimated, pose);
            let missing = plausible
                && self.started
                && measured < (1.0 - MISSING_FRACTION) * estimated
                && estimated - measured > self.muscle_gains[k].missing_tension;
            if missing && self.missing_for[k] == 0.0 {
                let fell = [self.tension[k], measured];
                self.missing_by[k] = self.cause_of_missing_tension(k, fell, estimated);
                self.isolation.begin_missing(k);
            }
            self.missing_for[k] = if missing { self.missing_for[k] + h } else { 0.0 };
            // One reading alone is that of a limb that vibrates.
            let accepted = plausible && trusted && self.missing_for[k] <= MISSING_TIME.max(h);
            self.tension[k] = if accepted { measured } else { f64::NAN };
            // A tension that is missing has no name before it is known whether the joint lacks its force.
            let unnamed = missing && self.missing_for[k] <= JUDGEMENT_TIME;
            if !accepted && !unnamed && self.muscle_gains[k].load_cell {
                let bridged = self.isolation.bridged(k).filter(|_| plausible);
                let rejected = (Fault::TensionSensor(k), self.load_cells[k].symptom());
                let (fault, symptom) = bridged.unwrap_or(rejected);
                self.report(fault, symptom);
            }
            self.judge_missing_tension(k, prediction);
        }
    }

    /// A cell that corrects no observer: its first reading alone is used. Whether a tension is missing is
    /// known from the other cells.
    fn check_lone_cell(
        &mut self,
        k: usize,
        h: f64,
        (before, plausible): (f64, Option<f64>),
        prediction: &Prediction<'_>,
    ) {
        self.tension[k] = plausible.filter(|_| !self.started).unwrap_or(f64::NAN);
        if !self.muscle_gains[k].load_cell {
            return;
        }
        let Some(measured) = plausible.filter(|_| prediction.unmeasured.missing[k]) else {
            self.missing_for[k] = 0.0;
            if plausible.is_none() {
                self.report(Fault::TensionSensor(k), self.load_cells[k].symptom());
            }
            return;
        };
        if self.missing_for[k] == 0.0 {
            // A drive does not pay out a cable that is slack.
            self.missing_by[k] = match measured > self.muscle_gains[k].slack_tension {
                true => self.cause_of_missing_tension(k, [before, measured], prediction.tension_in[k]),
                false => (Fault::Cable(k), Symptom::Unknown),
            };
        }
        self.missing_for[k] += h;
        if self.missing_for[k] > PERSISTENCE_TIME {
            let (fault, symptom) = self.missing_by[k];
            let broken = Fault::Cable(prediction.unmeasured.broken(k));
            self.stop(if fault == Fault::Cable(k) { broken } else { fault }, symptom);
        }
    }

    /// A tension that is missing with its force at the joint is that of a cable that has broken, or of
    /// another part that makes its estimate false; one that is missing alone is that of a load cell.
    fn judge_missing_tension(&mut self, k: usize, prediction: &Prediction<'_>) {
        let missing_for = self.missing_for[k];
        if missing_for <= PERSISTENCE_TIME || missing_for > BREAK_MEMORY {
            return;
        }
        // Where a cell is bridged that had deviated, its estimate has just changed, and the force with it.
        let deviating = matches!(self.isolation.bridged(k), Some((_, Symptom::Deviating | Symptom::Noisy)));
        // A cell that was bridged before does not tell that its cable breaks.
        if deviating || self.isolation.is_bridged_since(k, missing_for + JUDGEMENT_TIME) {
            return;
        }
        let [early, late] = BROKEN_FRACTION;
        let fraction = if missing_for <= JUDGEMENT_TIME { early } else { late };
        let (fault, symptom) = self.missing_by[k];
        if self.isolation.force_is_lacking(k, fraction, prediction.tension_out[k]) || fault != Fault::Cable(k)
        {
            self.stop(fault, symptom);
        } else if missing_for > JUDGEMENT_TIME && !self.isolation.is_bridged(k) {
            let [pose, ..] = prediction.joint;
            self.isolation.begin_bridge(k, Symptom::Deviating, pose);
        }
    }

    /// Holds load cells and encoders against each other, `dt` s after the last time; returns a muscle whose
    /// load cell was wrong before it was rejected: its observer forgets it.
    pub(super) fn isolate(&mut self, dt: f64, seen: &Seen<'_>) -> Option<usize> {
        match self.isolation.evaluate(dt, seen) {
            Finding::Nothing => None,
            Finding::Bridge(muscle) => Some(muscle),
            Finding::Stop(fault) => {
                self.stop(fault, Symptom::Deviating);
                None
            }
        }
    }

    /// Fault by which a cable lacks its tension, under the assumption of a single fault. A joint encoder that
    /// was already rejected: the muscles follow its replacement. The motor encoder: while its output was
    /// unchanged, the winch was commanded to pay out what is missing, and the tension fell in more than one
    /// cycle. Otherwise the cable itself.
    fn cause_of_missing_tension(
        &self,
        k: usize,
        [before, measured]: [f64; 2],
        estimated: f64,
    ) -> (Fault, Symptom) {
        let replaced = self.encoders.iter().position(|encoder| match encoder.symptom() {
            Symptom::Lost | Symptom::Stuck => encoder.rejected_for > MISSING_TIME,
            // A joint that loses a cable gathers speed first.
            Symptom::Jumped => encoder.rejected_for > 0.0,
            _ => false,
        });
        if let Some(joint) = replaced {
            return (Fault::JointSensor(joint), self.encoders[joint].symptom());
        }
        let fraction = UNSEEN_FRACTION * (estimated - measured);
        let fallen = before - measured;
        let unseen = -self.unchanged_travel[k][1] * self.cable_stiffness[k];
        if fallen <= fraction && unseen > fraction {
            (Fault::MotorSensor(k), Symptom::Stuck)
        } else {
            (Fault::Cable(k), Symptom::Unknown)
        }
    }

    /// Degrades the arm: a measurement was rejected.
    fn report(&mut self, fault: Fault, symptom: Symptom) {
        if self.status == ArmStatus::Following {
            (self.status, self.symptom) = (ArmStatus::Degraded(fault), symptom);
        }
    }

    /// The same for a sensor without which the arm stops after the persistence time.
    fn report_vital(&mut self, h: f64, rejected_for: f64, fault: Fault, symptom: Symptom) {
        self.report(fault, symptom);
        if rejected_for > PERSISTENCE_TIME.max(PERSISTENT_CYCLES * h) {
            self.stop(fault, symptom);
        }
    }

    /// Stops the arm, unless it has stopped already. What sensors under trial have led to is named by them.
    pub(super) fn stop(&mut self, fault: Fault, symptom: Symptom) {
        if !self.is_stopped() {
            let sensors = self.isolation.cause_of(fault).map(|sensors| (sensors, Symptom::Deviating));
            let (fault, symptom) = sensors.unwrap_or((fault, symptom));
            (self.status, self.symptom) = (ArmStatus::Stopped(fault), symptom);
        }
    }
}

/// Whether a drive need not follow a speed: it was given a tension, or is to pay out cable that is slack.
fn may_ignore_command(winch_speed: f64, tension: f64, slack: f64) -> bool {
    !winch_speed.is_finite() || (winch_speed < 0.0 && (tension.is_nan() || tension <= slack))
}

#[cfg(test)]
mod tests;
