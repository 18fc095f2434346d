use super::sensor_monitor::{SensorLimits, SensorMonitor};
use super::signals::ArmMeasurement;
use super::status::{ArmStatus, Fault};
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
    /// Estimated speed of every joint, rad/s.
    pub(super) joint_speed: &'a [f64],
    /// Reference of the joints.
    pub(super) reference: &'a Reference,
}

/// Time for which a fault has to persist before it stops the arm, s.
const PERSISTENCE_TIME: f64 = 0.03;
/// Error of a joint that stops the arm, rad; also the largest deviation of its first measurement from the
/// reference.
const MAX_TRACKING_ERROR: f64 = 0.5;

/// Joint encoder, rad: 10 rad/s; unchanged over 0.012 rad of expected motion (5e-3 occur where cables stick).
const JOINT: SensorLimits =
    SensorLimits { initial_deviation: MAX_TRACKING_ERROR, max_rate: 10.0, max_unchanged: 0.012 };
/// Motor encoder, m of cable: any origin; 2 m/s; unchanged over 0.8 mm of commanded travel (0.3 mm occur).
const MOTOR: SensorLimits = SensorLimits { initial_deviation: 1e3, max_rate: 2.0, max_unchanged: 8e-4 };
/// Load cell, N: 40 kN/s, exceeded only by a cable that breaks (8 kN/s occur); noise changes every sample, so
/// that the expected change counts samples, of which eight may be equal.
const LOAD_CELL: SensorLimits = SensorLimits { initial_deviation: 1e4, max_rate: 4e4, max_unchanged: 8.0 };

/// Time constant with which the expected speed of a joint decays while its encoder's output is unchanged, s.
const EXPECTED_SPEED_DECAY: f64 = 0.15;
/// Travel of a joint's reference while its encoder's output is unchanged that is a fault, rad; 0.024 occur at
/// reversals.
const MAX_REFERENCE_TRAVEL: f64 = 0.1;
/// Change of the tension residual that proves motion of a winch whose encoder's output is unchanged, N.
const MOTION_RESIDUAL: f64 = 1.5;
/// Residual between commanded and measured travel of a winch that is a fault, m; 3 mm occur.
const MAX_WINCH_RESIDUAL: f64 = 0.006;
/// Time constant with which that residual is forgotten, s.
const WINCH_RESIDUAL_DECAY: f64 = 0.2;
/// Tension below its estimate that is a fault: in N, and as a share of the estimate. Both must be exceeded.
const MISSING_TENSION: (f64, f64) = (8.0, 0.8);
/// Tension below which a drive does not pay out cable, N.
const SLACK_TENSION: f64 = 4.0;

/// Detects faults from residuals between measurements and predictions; replaces or withholds what it rejects.
///
/// ```text
/// sensors       accepted as in SensorMonitor
///                 joint encoder   e = h min(|q'^_0|, |q'_r|) exp(-t_u/t_d) while both have one sign, else 0
///                 motor encoder   e = h v_c
/// drive         r_v = (r_v + h v_c - dx)(1 - h/t_f);                    fault at |r_v| > r_v,max
/// load          r_T <- r_T + (h/t_p)(T - T^ - r_T)
///                 encoder unchanged over e_max: fault of the drive where r_T has changed by less than
///                 r_T,min in the commanded direction, else of the encoder
/// cable         T < T^ - max(dT, c T^) for longer than t_p
/// tracking      |q_r - q^| >= e_q
/// ```
///
/// | symbol        | meaning                                                               | unit      |
/// |---------------|-----------------------------------------------------------------------|-----------|
/// | q'^_0, t_u    | estimated speed when the output last changed, time since then           | rad/s, s  |
/// | v_c, dx       | commanded speed and measured displacement of a winch                    | m/s, m    |
/// | T, T^         | measured and estimated tension at the drive's outlet                    | N         |
/// | t_d, t_f, t_p | decay of the expected speed and of `r_v`, persistence time               | s         |
///
/// A fault of a vital sensor degrades the arm at once and stops it after the persistence time; a fault of a
/// load cell only degrades. A rejected motor position is continued by `h v_c`; a rejected joint angle or
/// tension becomes NaN. Stopping is final.
///
/// # Source
/// Residual evaluation with thresholds and persistence times, as usual; thresholds from fault-free runs of
/// the twin.
#[derive(Debug, Clone)]
pub(super) struct FaultDetector {
    motors: Vec<SensorMonitor>,
    load_cells: Vec<SensorMonitor>,
    encoders: Vec<SensorMonitor>,
    /// `r_v` of every winch, m.
    winch_residual: Vec<f64>,
    /// `q'^_0` of every joint, rad/s.
    speed_at_change: Vec<f64>,
    /// Travel of every joint's reference since the encoder's output last changed, rad.
    reference_travel: Vec<f64>,
    /// Whether an unchanged motor encoder is attributed to its drive.
    drive_standing: Vec<bool>,
    /// `r_T` of every load cell, N.
    tension_residual: Vec<f64>,
    /// `r_T` when the motor encoder's output last changed, N.
    residual_at_change: Vec<f64>,
    /// Time for which every cable has lacked its tension, s.
    missing_for: Vec<f64>,
    /// Accepted or continued motor positions, m: `[muscles]`.
    pub(super) motor: Vec<f64>,
    /// Accepted tensions, N, NaN where rejected: `[muscles]`.
    pub(super) tension: Vec<f64>,
    /// Accepted joint angles, rad, NaN where rejected: `[joints]`.
    pub(super) joint: Vec<f64>,
    pub(super) status: ArmStatus,
    started: bool,
}

impl FaultDetector {
    pub(super) fn new(muscles: usize, joints: usize) -> Self {
        Self {
            motors: vec![SensorMonitor::new(MOTOR); muscles],
            load_cells: vec![SensorMonitor::new(LOAD_CELL); muscles],
            encoders: vec![SensorMonitor::new(JOINT); joints],
            winch_residual: vec![0.0; muscles],
            speed_at_change: vec![0.0; joints],
            reference_travel: vec![0.0; joints],
            drive_standing: vec![false; muscles],
            tension_residual: vec![0.0; muscles],
            residual_at_change: vec![0.0; muscles],
            missing_for: vec![0.0; muscles],
            motor: vec![0.0; muscles],
            tension: vec![0.0; muscles],
            joint: vec![0.0; joints],
            status: ArmStatus::Following,
            started: false,
        }
    }

    /// Compares a measurement, `h` s after the one before, with what was predicted for it.
    pub(super) fn update(&mut self, h: f64, measurement: &ArmMeasurement<'_>, prediction: &Prediction<'_>) {
        if !self.is_stopped() {
            self.status = ArmStatus::Following;
        }
        self.check_joints(h, measurement.joint, prediction);
        self.check_motors(h, measurement, prediction.winch_speed);
        self.check_tensions(h, measurement.tension, prediction.tension_in);
        self.started = true;
    }

    /// Stops the arm where the error of a joint, rad, is beyond its threshold or no number.
    pub(super) fn check_tracking(&mut self, error: &[f64]) {
        if let Some(joint) = error.iter().position(|e| e.is_nan() || e.abs() >= MAX_TRACKING_ERROR) {
            self.stop(Fault::TrackingError(joint));
        }
    }

    pub(super) fn is_stopped(&self) -> bool {
        matches!(self.status, ArmStatus::Stopped(_))
    }

    fn check_joints(&mut self, h: f64, measured: &[f64], prediction: &Prediction<'_>) {
        let winches_move = prediction.winch_speed.iter().all(|speed| speed.is_finite());
        for (k, &measured) in measured.iter().enumerate() {
            let encoder = &mut self.encoders[k];
            let reference_speed = prediction.reference.v[k];
            if !self.started {
                encoder.accepted = prediction.reference.q[k];
            }
            if encoder.has_changed(h) {
                self.speed_at_change[k] = prediction.joint_speed[k];
                self.reference_travel[k] = 0.0;
            } else {
                self.reference_travel[k] += h * reference_speed;
            }
            let speed = self.speed_at_change[k];
            let speed =
                if speed * reference_speed > 0.0 { speed.abs().min(reference_speed.abs()) } else { 0.0 };
            let mut expected = h * speed * libm::exp(-encoder.unchanged_for() / EXPECTED_SPEED_DECAY);
            if winches_move && self.reference_travel[k].abs() > MAX_REFERENCE_TRAVEL {
                expected = encoder.max_unchanged();
            }
            let accepted = encoder.update(h, measured, expected);
            let rejected_for = encoder.rejected_for;
            self.joint[k] = if accepted { measured } else { f64::NAN };
            self.report_vital(accepted, rejected_for, Fault::JointSensor(k));
        }
    }

    fn check_motors(&mut self, h: f64, measurement: &ArmMeasurement<'_>, winch_speed: &[f64]) {
        for (k, &measured) in measurement.motor.iter().enumerate() {
            let blocked = may_ignore_command(winch_speed[k], measurement.tension[k]);
            let commanded = if winch_speed[k].is_finite() { h * winch_speed[k] } else { 0.0 };
            let motor = &mut self.motors[k];
            let accepted = motor.update(h, measured, if blocked { 0.0 } else { commanded });
            let moved = if accepted && self.started { measured - self.motor[k] } else { commanded };
            self.motor[k] = if accepted { measured } else { self.motor[k] + commanded };
            // A standing winch and a frozen encoder repeat the same output: only moving cable changes the
            // tension.
            if motor.has_changed(h) {
                (self.drive_standing[k], self.residual_at_change[k]) = (false, self.tension_residual[k]);
            } else if accepted {
                let change = self.tension_residual[k] - self.residual_at_change[k];
                self.drive_standing[k] = change * commanded < MOTION_RESIDUAL * commanded.abs();
            }
            let fault = if self.drive_standing[k] { Fault::Drive(k) } else { Fault::MotorSensor(k) };
            let rejected_for = motor.rejected_for;
            self.report_vital(accepted, rejected_for, fault);
            let residual = if blocked { 0.0 } else { h * winch_speed[k] - moved };
            self.winch_residual[k] = (self.winch_residual[k] + residual) * (1.0 - h / WINCH_RESIDUAL_DECAY);
            if self.winch_residual[k].abs() > MAX_WINCH_RESIDUAL {
                self.stop(Fault::Drive(k));
            }
        }
    }

    fn check_tensions(&mut self, h: f64, measured: &[f64], estimated: &[f64]) {
        let (least_difference, share) = MISSING_TENSION;
        for (k, (&measured, &estimated)) in measured.iter().zip(estimated).enumerate() {
            let plausible = self.load_cells[k].update(h, measured, 1.0);
            let missing = plausible
                && self.started
                && measured < (1.0 - share) * estimated
                && estimated - measured > least_difference;
            let accepted = plausible && !missing;
            self.tension[k] = if accepted { measured } else { f64::NAN };
            self.report(accepted, Fault::TensionSensor(k));
            let residual = if accepted { measured - estimated } else { 0.0 };
            self.tension_residual[k] +=
                (h / PERSISTENCE_TIME).min(1.0) * (residual - self.tension_residual[k]);
            self.missing_for[k] = if missing { self.missing_for[k] + h } else { 0.0 };
            if self.missing_for[k] > PERSISTENCE_TIME {
                self.stop(Fault::Cable(k));
            }
        }
    }

    /// Degrades the arm where a measurement was rejected.
    fn report(&mut self, accepted: bool, fault: Fault) {
        if !accepted && self.status == ArmStatus::Following {
            self.status = ArmStatus::Degraded(fault);
        }
    }

    /// The same for a sensor without which the arm stops after the persistence time.
    fn report_vital(&mut self, accepted: bool, rejected_for: f64, fault: Fault) {
        self.report(accepted, fault);
        if rejected_for > PERSISTENCE_TIME {
            self.stop(fault);
        }
    }

    fn stop(&mut self, fault: Fault) {
        if !self.is_stopped() {
            self.status = ArmStatus::Stopped(fault);
        }
    }
}

/// Whether a drive need not follow a speed: it was given a tension, or is to pay out cable that is slack.
fn may_ignore_command(winch_speed: f64, tension: f64) -> bool {
    !winch_speed.is_finite() || (winch_speed < 0.0 && (tension.is_nan() || tension <= SLACK_TENSION))
}
