use super::controller::ArmSample;
use alloc::vec;
use alloc::vec::Vec;

/// What is wrong with an arm.
#[derive(Debug, Clone, Copy, PartialEq, Eq)]
pub enum Trouble {
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
    Astray(usize),
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
    Bridging(Trouble),
    /// Winches were brought to a stop, for good.
    Stopped(Trouble),
}

/// How long something may be missing, s.
const PATIENCE: f64 = 0.03;
/// A joint does not turn this far in a millisecond, rad.
const LARGEST_TURN: f64 = 0.01;
/// Nor a winch, m.
const LARGEST_PULL: f64 = 0.002;
/// A load cell has noise: what says the same so many times says nothing.
const SAME: u32 = 12;
/// How far a winch may be from what it was told, m, within [`FORGETTING`] s.
const LARGEST_LAG: f64 = 0.012;
const FORGETTING: f64 = 0.2;
/// Near tension that is missing from a cable that is whole, N and share of what is believed.
const MISSING: (f64, f64) = (8.0, 0.8);
/// At the start a motor's encoder may say anything, m, and a load cell always, N.
const ANYWHERE: f64 = 1e3;
const ANYTHING: f64 = 1e4;
/// rad.
const ASTRAY: f64 = 0.5;
/// Below this a drive does not pay out, N.
const SLACK: f64 = 4.0;

/// One channel: what it said last, and since when it is not believed, s.
#[derive(Debug, Clone, Copy, Default)]
struct Channel {
    last: f64,
    missing: f64,
    same: u32,
}

/// Keeps what cannot be true from the controller, and says when to stop.
#[derive(Debug, Clone)]
pub(super) struct Guard {
    motors: Vec<Channel>,
    tensions: Vec<Channel>,
    joints: Vec<Channel>,
    /// How far every winch is from what it was told, m.
    lag: Vec<f64>,
    /// Since when the tension of every cable is missing, s.
    untaut: Vec<f64>,
    /// What may be believed; a missing tension is not a number, a missing joint neither.
    pub(super) motor: Vec<f64>,
    pub(super) tension: Vec<f64>,
    pub(super) joint: Vec<f64>,
    pub(super) status: ArmStatus,
    started: bool,
}

impl Guard {
    pub(super) fn new(muscles: usize, joints: usize) -> Self {
        Self {
            motors: vec![Channel::default(); muscles],
            tensions: vec![Channel::default(); muscles],
            joints: vec![Channel::default(); joints],
            lag: vec![0.0; muscles],
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

    pub(super) fn stop(&mut self, trouble: Trouble) {
        if !self.stopped() {
            self.status = ArmStatus::Stopped(trouble);
        }
    }

    /// Takes a sample; `told` is what every winch was told, m/s, not a number where it was told a tension, `near` what tension is believed at every drive, N, before it.
    pub(super) fn take(&mut self, h: f64, sample: &ArmSample<'_>, told: &[f64], near: &[f64]) {
        let first = !self.started;
        self.started = true;
        if !self.stopped() {
            self.status = ArmStatus::Following;
        }
        for (k, &said) in sample.joint.iter().enumerate() {
            let channel = &mut self.joints[k];
            let good = channel.judge(h, said, if first { ASTRAY } else { LARGEST_TURN });
            self.joint[k] = if good { said } else { f64::NAN };
            self.report(good, self.joints[k].missing, Trouble::JointSensor(k), true);
        }
        for (k, &said) in sample.motor.iter().enumerate() {
            let good = self.motors[k].judge(h, said, if first { ANYWHERE } else { LARGEST_PULL });
            // Bridged by what it was told.
            let meant = if told[k].is_finite() { h * told[k] } else { 0.0 };
            let moved = if good && !first { said - self.motor[k] } else { meant };
            self.motor[k] = if good { said } else { self.motor[k] + meant };
            self.report(good, self.motors[k].missing, Trouble::MotorSensor(k), true);
            self.follow(h, k, told[k], moved, sample.tension[k]);
        }
        for (k, &said) in sample.tension.iter().enumerate() {
            let channel = &mut self.tensions[k];
            channel.same = if said.to_bits() == channel.last.to_bits() { channel.same + 1 } else { 0 };
            let good = channel.judge(h, said, ANYTHING) && channel.same < SAME;
            self.tension[k] = if good { said } else { f64::NAN };
            self.report(good, 0.0, Trouble::TensionSensor(k), false);
            let loose = good && said < (1.0 - MISSING.1) * near[k] && near[k] - said > MISSING.0 && !first;
            self.untaut[k] = if loose { self.untaut[k] + h } else { 0.0 };
            if self.untaut[k] > PATIENCE {
                self.stop(Trouble::Cable(k));
            }
        }
    }

    /// Stops an arm that has gone astray.
    pub(super) fn watch(&mut self, error: &[f64]) {
        if let Some(joint) = error.iter().position(|e| e.is_nan() || e.abs() >= ASTRAY) {
            self.stop(Trouble::Astray(joint));
        }
    }

    fn report(&mut self, good: bool, missing: f64, trouble: Trouble, vital: bool) {
        if !good && self.status == ArmStatus::Following {
            self.status = ArmStatus::Bridging(trouble);
        }
        if vital && missing > PATIENCE {
            self.stop(trouble);
        }
    }

    /// How far a winch is from where it was told to be.
    fn follow(&mut self, h: f64, k: usize, told: f64, moved: f64, tension: f64) {
        let blocked = !told.is_finite() || (told < 0.0 && (tension.is_nan() || tension <= SLACK));
        let off = if blocked { 0.0 } else { h * told - moved };
        self.lag[k] = (self.lag[k] + off) * (1.0 - h / FORGETTING);
        if self.lag[k].abs() > LARGEST_LAG {
            self.stop(Trouble::Drive(k));
        }
    }
}

impl Channel {
    /// Whether what it says can be believed: a number, and not far from what it said last.
    fn judge(&mut self, h: f64, said: f64, largest: f64) -> bool {
        let good = (said - self.last).abs() <= largest * (1.0 + self.missing / h);
        if good {
            (self.last, self.missing) = (said, 0.0);
        } else {
            self.missing += h;
        }
        good
    }
}
