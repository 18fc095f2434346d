use super::gains::ArmGains;
use crate::transmission::cable::CableLaw;

/// What is wanted of one muscle in the next millisecond.
#[derive(Debug, Clone, Copy, PartialEq)]
pub(super) struct Pull {
    /// `F`, N, at the anchor.
    pub(super) tension: f64,
    /// Speed of the anchor in the reference, now and a little later, m/s, + toward the motor.
    pub(super) velocity: f64,
    pub(super) coming: f64,
    /// Speed at which it truly slides, m/s.
    pub(super) slip: f64,
    /// `R (q_r - q^)`: how far the anchor is behind, m.
    pub(super) behind: f64,
}

/// Where a winch should be and how fast it is told to go there.
///
/// ```text
/// e* = (1 + s)/2 e_+(F) + (1 - s)/2 e_-(F),    s = clip(v_r(t + t_p)/v_t, -1, 1)
/// x = e* - e^ + kappa R (q_r - q^),    v = v_r + clip(x/t_v, +- sqrt(2 a |x|))
/// ```
///
/// `e_+-` is the stretch of the cable that slides steadily toward the motor or away from it: at a reversal the winch crosses from one
/// to the other while the anchor slows down, so that the front is through when it turns.
#[derive(Debug, Clone, Copy, Default)]
pub(super) struct Winch {
    /// Which way the cable slides, or is about to: -1 to 1.
    pub(super) sliding: f64,
    /// What the joints' errors add to it.
    pub(super) correction: f64,
}

impl Winch {
    /// Wanted stretch, m.
    pub(super) fn stretch(
        &mut self,
        h: f64,
        law: &CableLaw,
        pull: &Pull,
        drag: f64,
        gains: &ArmGains,
    ) -> f64 {
        let of = |s: f64| {
            let speed = if s * pull.velocity > 0.0 { pull.velocity } else { s * f64::MIN_POSITIVE };
            law.sliding(pull.tension, speed, pull.slip, drag).map_or(0.0, |steady| steady.stretch)
        };
        let (high, low) = (of(1.0), of(-1.0));
        let gap = (high - low).max(1e-3);
        let most = 1.0 - gains.doubt;
        self.sliding = (self.sliding + h * pull.coming / gains.turning).clamp(-most, most);
        let end = 1.0 + gains.doubt;
        let rate = gains.integral * pull.behind / gap;
        self.correction = (self.correction + h * rate).clamp(-end - self.sliding, end - self.sliding);
        let s = (self.sliding + self.correction + gains.lead * pull.behind / gap).clamp(-end, end);
        0.5 * ((1.0 + s) * high + (1.0 - s) * low)
    }

    /// Speed of the winch, m/s, with the stretch as wanted and as believed.
    pub(super) fn speed(&self, pull: &Pull, wanted: f64, believed: f64, gains: &ArmGains) -> f64 {
        let missing = wanted - believed + gains.position * pull.behind;
        let most = libm::sqrt(2.0 * gains.braking * missing.abs());
        let speed = pull.velocity + (missing / gains.settling).clamp(-most, most);
        speed.clamp(-gains.most_speed, gains.most_speed)
    }
}
