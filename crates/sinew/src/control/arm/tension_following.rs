use super::gains::MuscleGains;
use crate::Error;
use crate::error::{check_length, finite};
use alloc::vec;
use alloc::vec::Vec;

/// Tensions at the anchors that are given, in place of those that give the joints a motion.
///
/// ```text
/// F <- F + clip(clip(F_given, F_min, F_max) - F, +- r h)
/// b  = (F - T_out^)/(0.05 F_max + 0.1 F),   i' = 4/s b   while |F - T_out^| > 0.02 F
/// s  = clip(b + i, +-1)
/// e* = (1 + s)/2 e_+ + (1 - s)/2 e_-
/// v  = v^ + clip((e* - e^)/t_v, +- sqrt(2 a |e* - e^|))       |v| <= v_max
/// ```
///
/// | symbol   | meaning                                                                 | unit |
/// |----------|-------------------------------------------------------------------------|------|
/// | F        | tension that is followed; `r` is a tenth of the rate that counts as a fault of the load cell | N |
/// | T_out^, e^, v^ | estimated tension at the anchor, stretch, speed of the anchor       | N, m, m/s |
/// | e_+, e_- | stretch at `F`, sliding toward the motor or away                         | m    |
///
/// The joints move as they will; their ranges and the speeds of the winches are watched elsewhere.
///
/// # Source
/// Our own.
#[derive(Debug, Clone)]
pub(super) struct TensionFollowing {
    /// `F_given`, N; not read while inactive.
    given: Vec<f64>,
    active: bool,
    /// Whether `F` begins with the estimated tension.
    fresh: bool,
    /// `i`, 1: `[muscles]`.
    integral: Vec<f64>,
}

/// Estimates of a cable.
#[derive(Debug, Clone, Copy)]
pub(super) struct CableEstimate {
    /// `T_out^`, N.
    pub(super) tension_out: f64,
    /// `e^`, m.
    pub(super) stretch: f64,
    /// `v^`, m/s.
    pub(super) velocity: f64,
    /// `i`, 1.
    pub(super) integral: f64,
}

/// Shares of `F_max` and `F` in the tension error at which a cable is on its whole side of the dead band.
const BAND: [f64; 2] = [0.05, 0.1];
/// Rate of `i`, 1/s, and the relative error within which it rests.
const INTEGRAL: f64 = 4.0;
const CLOSE: f64 = 0.02;
/// Share of the rate of a faulty load cell at which `F` changes.
const RATE: f64 = 0.1;

impl TensionFollowing {
    pub(super) fn new(muscles: usize) -> Self {
        Self { given: vec![0.0; muscles], active: false, fresh: true, integral: vec![0.0; muscles] }
    }

    pub(super) fn is_active(&self) -> bool {
        self.active
    }

    /// `i` of every muscle; none while inactive.
    pub(super) fn integral(&self) -> Option<&[f64]> {
        self.active.then_some(&self.integral[..])
    }

    /// Given tensions, N: `[muscles]`; none ends it.
    pub(super) fn set(&mut self, given: Option<&[f64]>) -> Result<(), Error> {
        let Some(given) = given else {
            (self.active, self.fresh) = (false, true);
            return Ok(());
        };
        check_length("tension set-points", given.len(), self.given.len())?;
        given.iter().try_for_each(|tension| finite("tension set-point", *tension).map(drop))?;
        self.given.copy_from_slice(given);
        self.active = true;
        Ok(())
    }

    /// `F` of every muscle, `h` s on; `estimated` are the tensions with which it begins.
    pub(super) fn advance(&mut self, h: f64, gains: &[MuscleGains], estimated: &[f64], tension: &mut [f64]) {
        if self.fresh {
            self.integral.fill(0.0);
        }
        let cables = tension.iter_mut().zip(&self.given).zip(gains).zip(estimated).zip(&mut self.integral);
        for ((((tension, given), gains), estimated), integral) in cables {
            let [least, most] = gains.tension;
            let from = if self.fresh { estimated.max(least).min(most) } else { *tension };
            let step = h * RATE * gains.max_tension_rate;
            *tension = from + (given.max(least).min(most) - from).max(-step).min(step);
            let error = *tension - estimated;
            if error.abs() > CLOSE * *tension {
                *integral = (*integral + h * INTEGRAL * error / band(gains, *tension)).clamp(-1.0, 1.0);
            }
        }
        self.fresh = false;
    }
}

/// Tension error at which a cable is on its whole side of the dead band, N.
fn band(gains: &MuscleGains, tension: f64) -> f64 {
    BAND[0] * gains.tension[1] + BAND[1] * tension
}

/// `v` of one winch, m/s, from `e_+` and `e_-`.
pub(super) fn winch_speed(
    tension: f64,
    [toward, away]: [f64; 2],
    estimate: &CableEstimate,
    gains: &MuscleGains,
) -> f64 {
    let share = (tension - estimate.tension_out) / band(gains, tension);
    let s = (share + estimate.integral).clamp(-1.0, 1.0);
    let travel = 0.5 * ((1.0 + s) * toward + (1.0 - s) * away) - estimate.stretch;
    let most = libm::sqrt(2.0 * gains.winch_deceleration * travel.abs());
    let speed = estimate.velocity + (travel / gains.stretch_time_constant).clamp(-most, most);
    speed.clamp(-gains.max_winch_speed, gains.max_winch_speed)
}
