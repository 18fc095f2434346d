use crate::Error;
use crate::error::{non_negative, positive, within};
use alloc::vec;
use alloc::vec::Vec;

/// How hard the controller of an arm tries.
///
/// # Source
/// A random search on two arms of the twin, drawn and calibrated; others of the same kind follow as well.
#[derive(Debug, Clone, PartialEq)]
pub struct ArmGains {
    /// `w` of every joint, rad/s: bandwidth of the wanted acceleration. `[joints]`
    pub bandwidth: Vec<f64>,
    /// `zeta`, 1.
    pub damping: f64,
    /// `w_d` of every joint, rad/s: how fast the disturbance that it shows is believed; 0 for never. `[joints]`
    pub disturbance: Vec<f64>,
    /// `w_o`, rad/s: bandwidth of the joints' observers.
    pub observer: f64,
    /// `e_0`, rad: error of an observer from which on it hurries. More than counts of the encoders.
    pub sudden: f64,
    /// Most times faster that it then is.
    pub hurry: f64,
    /// `kappa`, 1: share of the joints' errors that the winches make good as positions. Beyond 2 it swings.
    pub position: f64,
    /// `t_d`, s: beside it, of the speeds at which the anchors fall behind. It damps what the dead bands make swing.
    pub velocity: f64,
    /// `t_v`, s: how fast a winch makes good what it is away from where it should be.
    pub settling: f64,
    /// `a`, m/s^2: with which a winch is expected to be braked.
    pub braking: f64,
    /// Fastest that a winch is told to turn, m/s.
    pub most_speed: f64,
    /// `x_t`, m: how far an anchor goes while its cable changes the direction of sliding.
    pub turning: f64,
    /// `lambda`, 1: how far across its dead band a cable is sent by the joints' errors.
    pub lead: f64,
    /// `lambda_i`, 1/s: the same over time.
    pub integral: f64,
    /// `beta`, 1: share of the way across the dead band that is left to the joints' errors, because friction is not known
    /// better.
    pub doubt: f64,
    /// `beta_c`, 1: the same beside it where an anchor only creeps, because a cable at rest holds more than it then pulls.
    pub creeping: f64,
    /// s: smoothing of the speed at which a cable is believed to slip.
    pub slip: f64,
    /// `F_min`, N: least tension wanted at an anchor.
    pub least_tension: f64,
    /// N: but at least so much above its `T_0`, below which no wish can be met.
    pub above_pretension: f64,
    /// What a drive can hold for ever, N: bounds the tension at its anchor.
    pub drive_tension: f64,
    /// Errors of the muscles' lengths, m, below which the arm at rest is held, and above which it is held no more.
    pub hold: [f64; 2],
    /// s: at rest, what a muscle is off beyond the first of these is to be made good within this time.
    pub resting: f64,
}

impl ArmGains {
    /// For the LM-Arm with the drives of the bench.
    #[must_use]
    pub fn lm_arm() -> Self {
        Self {
            bandwidth: vec![11.5, 11.5, 11.5, 10.4, 8.8, 8.8, 8.8],
            damping: 0.53,
            disturbance: vec![14.9, 14.9, 14.9, 11.5, 12.4, 12.4, 12.4],
            observer: 58.0,
            sudden: 3.8e-3,
            hurry: 5.4,
            position: 0.94,
            settling: 0.0056,
            velocity: 0.15,
            braking: 1.77,
            most_speed: 0.13,
            turning: 1.14e-4,
            lead: 7.3,
            integral: 4.4,
            doubt: 0.05,
            creeping: 0.16,
            slip: 0.009,
            least_tension: 21.0,
            above_pretension: 4.0,
            drive_tension: 445.0,
            hold: [9e-5, 1.4e-4],
            resting: 0.38,
        }
    }

    /// The same for who knows no tension at the anchors: what is known less must be tried less hard.
    #[must_use]
    pub fn without_tensions(self) -> Self {
        Self {
            bandwidth: self.bandwidth.iter().map(|w| 0.7 * w).collect(),
            position: 0.5,
            velocity: 0.06,
            lead: 3.3,
            ..self
        }
    }

    /// Checks them for a robot of so many joints.
    ///
    /// # Errors
    /// [`Error::WrongLength`] and [`Error::OutOfDomain`] name the field.
    pub fn validate(&self, joints: usize) -> Result<(), Error> {
        for (name, list) in [("bandwidth", &self.bandwidth), ("disturbance", &self.disturbance)] {
            if list.len() != joints {
                return Err(Error::WrongLength { name, expected: joints, got: list.len() });
            }
            list.iter().try_for_each(|w| non_negative(name, *w).map(drop))?;
        }
        for (name, value) in [
            ("observer", self.observer),
            ("sudden", self.sudden),
            ("resting", self.resting),
            ("settling", self.settling),
            ("braking", self.braking),
            ("most_speed", self.most_speed),
            ("turning", self.turning),
            ("slip", self.slip),
            ("drive_tension", self.drive_tension),
        ] {
            positive(name, value)?;
        }
        for (name, value) in [
            ("damping", self.damping),
            ("position", self.position),
            ("velocity", self.velocity),
            ("lead", self.lead),
            ("doubt", self.doubt),
            ("creeping", self.creeping),
            ("integral", self.integral),
            ("least_tension", self.least_tension),
            ("above_pretension", self.above_pretension),
            ("hold", self.hold[0]),
        ] {
            non_negative(name, value)?;
        }
        within("hurry", "a number >= 1", self.hurry, self.hurry.is_finite() && self.hurry >= 1.0)?;
        within("hold", "two numbers that rise", self.hold[1], self.hold[1] >= self.hold[0])?;
        Ok(())
    }
}
