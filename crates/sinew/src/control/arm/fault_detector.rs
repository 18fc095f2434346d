use super::channel::{Bounds, Channel};
use super::controller::ArmMeasurement;
use alloc::vec;
use alloc::vec::Vec;

/// What is wrong with an arm.
#[derive(Debug, Clone, Copy, PartialEq, Eq)]
pub enum Fault {
    /// The encoder of a joint says nothing that can be believed.
    JointSensor(usize),
    /// The motor's encoder of a muscle.
    MotorSensor(usize),
    /// The load cell of a muscle: its cable's observer goes on without.
    TensionSensor(usize),
    /// The drive of a muscle does not do what it is told.
    Drive(usize),
    /// The cable of a muscle has no tension where it should have some.
    Cable(usize),
    /// A joint is far from where it is to be.
    TrackingError(usize),
}

/// Whether the arm does what it is told.
#[derive(Debug, Clone, Copy, PartialEq, Eq, Default)]
pub enum ArmStatus {
    /// It follows its reference.
    #[default]
    Following,
    /// It is at rest where it is to be, winches stand.
    Holding,
    /// Something is missing, and it follows by what it believes meanwhile.
    Degraded(Fault),
    /// Winches were brought to a stop, for good.
    Stopped(Fault),
}

/// How long something may be missing, s.
const PATIENCE: f64 = 0.03;
/// A joint does not turn this far in a millisecond, rad.
const LARGEST_TURN: f64 = 0.01;
/// Nor a winch, m.
const LARGEST_PULL: f64 = 0.002;
/// A load cell does not change so much in a millisecond, N, unless its cable breaks; 8 are seen.
const LARGEST_STEP: f64 = 40.0;
/// What sensors can say. A joint's encoder may repeat itself until the joint is due to be this far, rad (5e-3 are seen where cables
/// stick), a motor's until its winch is, m (3e-4 are seen); a load cell has noise, and is due with every sample.
const JOINT: Bounds = Bounds { step: LARGEST_TURN, stuck: 0.012 };
const MOTOR: Bounds = Bounds { step: LARGEST_PULL, stuck: 8e-4 };
const TENSION: Bounds = Bounds { step: LARGEST_STEP, stuck: 8.0 };
/// A joint goes on for this long after its encoder was last heard to move, s.
const COASTING: f64 = 0.15;
/// How far a reference may go while a joint says the same, rad, and winches go with it; 0.024 are seen where cables turn round.
const LEFT_BEHIND: f64 = 0.1;
/// What a load cell says beyond what is expected, N, smoothed over [`PATIENCE`], where a winch moves and its encoder does not.
const FELT: f64 = 1.5;
/// How far a winch may be from what it was told, m, within [`FORGETTING`] s; 3 mm are seen.
const LARGEST_LAG: f64 = 0.006;
const FORGETTING: f64 = 0.2;
/// Near tension that is missing from a cable that is whole, N and share of what is believed.
const MISSING: (f64, f64) = (8.0, 0.8);
/// At the start a motor's encoder may say anything, m, and a load cell always, N.
const ANYWHERE: f64 = 1e3;
const AT_FIRST: Bounds = Bounds { step: 1e4, ..TENSION };
/// rad.
const ASTRAY: f64 = 0.5;
/// Below this a drive does not pay out, N.
const SLACK: f64 = 4.0;

/// What was known before a sample.
#[derive(Debug)]
pub(super) struct Known<'a> {
    /// What every winch was told, m/s; not a number where it was told a tension.
    pub(super) told: &'a [f64],
    /// Tension at every drive, N.
    pub(super) near: &'a [f64],
    /// Speed of every joint, rad/s.
    pub(super) speed: &'a [f64],
    /// What it was to be.
    pub(super) wanted: &'a [f64],
}

/// Keeps what cannot be true from the controller, and says when to stop.
#[derive(Debug, Clone)]
pub(super) struct FaultDetector {
    motors: Vec<Channel>,
    tensions: Vec<Channel>,
    joints: Vec<Channel>,
    /// How far every winch is from what it was told, m.
    lag: Vec<f64>,
    /// Speed of every joint when its encoder was last heard to move, rad/s.
    pace: Vec<f64>,
    /// How far the reference of every joint has gone since then, rad.
    meant: Vec<f64>,
    /// Of every winch: whether it is the winch that stands, where its encoder does.
    jammed: Vec<bool>,
    /// By how much every load cell says more than was known before, N, smoothed.
    surprise: Vec<f64>,
    /// The same when its motor's encoder was last heard to move.
    usual: Vec<f64>,
    /// Since when the tension of every cable is missing, s.
    untaut: Vec<f64>,
    /// What may be believed; a missing tension is not a number, a missing joint neither.
    pub(super) motor: Vec<f64>,
    pub(super) tension: Vec<f64>,
    pub(super) joint: Vec<f64>,
    pub(super) status: ArmStatus,
    started: bool,
}

impl FaultDetector {
    pub(super) fn new(muscles: usize, joints: usize) -> Self {
        Self {
            motors: vec![Channel::default(); muscles],
            tensions: vec![Channel::default(); muscles],
            joints: vec![Channel::default(); joints],
            lag: vec![0.0; muscles],
            pace: vec![0.0; joints],
            meant: vec![0.0; joints],
            jammed: vec![false; muscles],
            surprise: vec![0.0; muscles],
            usual: vec![0.0; muscles],
            untaut: vec![0.0; muscles],
            motor: vec![0.0; muscles],
            tension: vec![0.0; muscles],
            joint: vec![0.0; joints],
            status: ArmStatus::Following,
            started: false,
        }
    }

    /// Expects the joints where they are to be.
    pub(super) fn expect(&mut self, q: &[f64]) {
        if !self.started {
            self.joints.iter_mut().zip(q).for_each(|(channel, q)| channel.last = *q);
        }
    }

    pub(super) fn stopped(&self) -> bool {
        matches!(self.status, ArmStatus::Stopped(_))
    }

    pub(super) fn stop(&mut self, trouble: Fault) {
        if !self.stopped() {
            self.status = ArmStatus::Stopped(trouble);
        }
    }

    /// Takes a sample and what was known before it.
    pub(super) fn take(&mut self, h: f64, sample: &ArmMeasurement<'_>, known: &Known<'_>) {
        let first = !self.started;
        self.started = true;
        if !self.stopped() {
            self.status = ArmStatus::Following;
        }
        self.take_joints(h, sample.joint, known, first);
        self.take_motors(h, sample, known.told, first);
        self.take_tensions(h, sample.tension, known.near, first);
    }

    fn take_joints(&mut self, h: f64, said: &[f64], known: &Known<'_>, first: bool) {
        let bounds = if first { Bounds { step: ASTRAY, ..JOINT } } else { JOINT };
        let winches = known.told.iter().all(|told| told.is_finite());
        for (k, &said) in said.iter().enumerate() {
            let channel = &mut self.joints[k];
            if channel.still < 0.5 * h {
                self.pace[k] = known.speed[k];
            }
            // As it was going, as long as it was to go there, and no faster.
            let (pace, wanted) = (self.pace[k], known.wanted[k]);
            let going = if pace * wanted > 0.0 { pace.abs().min(wanted.abs()) } else { 0.0 };
            let due = h * going * libm::exp(-channel.still / COASTING);
            self.meant[k] = if channel.still < 0.5 * h { 0.0 } else { self.meant[k] + h * wanted };
            let due = if winches && self.meant[k].abs() > LEFT_BEHIND { JOINT.stuck } else { due };
            let good = channel.judge(h, said, due, &bounds);
            self.joint[k] = if good { said } else { f64::NAN };
            self.report(good, self.joints[k].missing, Fault::JointSensor(k), true);
        }
    }

    fn take_motors(&mut self, h: f64, sample: &ArmMeasurement<'_>, told: &[f64], first: bool) {
        let bounds = if first { Bounds { step: ANYWHERE, ..MOTOR } } else { MOTOR };
        for (k, &said) in sample.motor.iter().enumerate() {
            // Bridged by what it was told.
            let meant = if told[k].is_finite() { h * told[k] } else { 0.0 };
            let due = if blocked(told[k], sample.tension[k]) { 0.0 } else { meant };
            let good = self.motors[k].judge(h, said, due, &bounds);
            let moved = if good && !first { said - self.motor[k] } else { meant };
            self.motor[k] = if good { said } else { self.motor[k] + meant };
            // A winch that jams repeats itself as well: but then its load cell feels nothing that was not expected.
            if self.motors[k].still < 0.5 * h {
                (self.jammed[k], self.usual[k]) = (false, self.surprise[k]);
            } else if good {
                let felt = self.surprise[k] - self.usual[k];
                self.jammed[k] = felt * meant < FELT * meant.abs();
            }
            let trouble = if self.jammed[k] { Fault::Drive(k) } else { Fault::MotorSensor(k) };
            self.report(good, self.motors[k].missing, trouble, true);
            self.follow(h, k, told[k], moved, sample.tension[k]);
        }
    }

    fn take_tensions(&mut self, h: f64, said: &[f64], near: &[f64], first: bool) {
        for (k, &said) in said.iter().enumerate() {
            let good = self.tensions[k].judge(h, said, 1.0, if first { &AT_FIRST } else { &TENSION });
            let loose = good && said < (1.0 - MISSING.1) * near[k] && near[k] - said > MISSING.0 && !first;
            self.tension[k] = if good && !loose { said } else { f64::NAN };
            self.report(good && !loose, 0.0, Fault::TensionSensor(k), false);
            let surprise = if self.tension[k].is_finite() { self.tension[k] - near[k] } else { 0.0 };
            self.surprise[k] += (h / PATIENCE).min(1.0) * (surprise - self.surprise[k]);
            self.untaut[k] = if loose { self.untaut[k] + h } else { 0.0 };
            if self.untaut[k] > PATIENCE {
                self.stop(Fault::Cable(k));
            }
        }
    }

    /// Stops an arm that has gone astray.
    pub(super) fn watch(&mut self, error: &[f64]) {
        if let Some(joint) = error.iter().position(|e| e.is_nan() || e.abs() >= ASTRAY) {
            self.stop(Fault::TrackingError(joint));
        }
    }

    fn report(&mut self, good: bool, missing: f64, trouble: Fault, vital: bool) {
        if !good && self.status == ArmStatus::Following {
            self.status = ArmStatus::Degraded(trouble);
        }
        if vital && missing > PATIENCE {
            self.stop(trouble);
        }
    }

    /// How far a winch is from where it was told to be.
    fn follow(&mut self, h: f64, k: usize, told: f64, moved: f64, tension: f64) {
        let off = if blocked(told, tension) { 0.0 } else { h * told - moved };
        self.lag[k] = (self.lag[k] + off) * (1.0 - h / FORGETTING);
        if self.lag[k].abs() > LARGEST_LAG {
            self.stop(Fault::Drive(k));
        }
    }
}

/// Whether a drive need not do what it is told: a tension, or to pay out what is slack.
fn blocked(told: f64, tension: f64) -> bool {
    !told.is_finite() || (told < 0.0 && (tension.is_nan() || tension <= SLACK))
}
