use super::gains::ArmGains;
use crate::control::stretch::BARELY;
use crate::transmission::cable::CableLaw;

/// What is wanted of one muscle in the next millisecond.
#[derive(Debug, Clone, Copy, PartialEq)]
pub(super) struct MuscleReference {
    /// `F`, N, at the anchor.
    pub(super) tension: f64,
    /// Speed of the anchor in the reference, now and a little later, m/s, + toward the motor.
    pub(super) velocity: f64,
    pub(super) coming: f64,
    /// Speed at which it truly slides, m/s.
    pub(super) slip: f64,
    /// Speed of the anchor as believed, m/s.
    pub(super) moving: f64,
    /// `R (q_r - q^)`: how far the anchor is behind, m.
    pub(super) behind: f64,
    /// What earlier repeats have shown to be needed beside the reference, in halves of the dead band.
    pub(super) known: f64,
    /// At rest, stretch of the cable as believed, m.
    pub(super) resting: Option<f64>,
}

/// Where a winch should be and how fast it is told to go there.
///
/// ```text
/// s_r' = v_r(t + t_p)/x_t up to +-(1 - beta),   s_i' = lambda_i d/G,   s = s_r + s_i + s_k + lambda d/G within +-(1 + beta)
/// e* = (1 + s)/2 e_+(F) + (1 - s)/2 e_-(F),       G = e_+ - e_-,          d = R (q_r - q^)
/// x = e* - e^ + kappa d + t_d d',     v = v_r + clip(x/t_v, +-sqrt(2 a |x|))
/// ```
///
/// | symbol   | meaning                                                                        | unit   |
/// |----------|--------------------------------------------------------------------------------|--------|
/// | e_+, e_- | stretch at the wanted far tension F of the cable that slides toward the motor, or away | m      |
/// | G        | dead band: what the winch travels to turn the cable round                        | m      |
/// | s        | where in the dead band the cable is to be: -1 to 1                                | 1      |
/// | s_k      | what earlier repeats of the motion have shown to be missing                         | 1      |
/// | d, d'    | how far the anchor is behind, and how fast it falls behind                        | m, m/s |
/// | t_p      | [`PREVIEW_HORIZON`](crate::control::stretch::PREVIEW_HORIZON)                                | s      |
///
/// ```text
/// beta = beta_0 + beta_c/(1 + (v_r(t + t_p)/v_c)^2)
/// ```
///
/// At a reversal of the reference the winch crosses the dead band while the anchor goes `x_t`. The last `beta` of the way
/// is left to the joints' errors: sent too far, a cable breaks away. One that slides already is not taken back. Friction weakens
/// with the speed at which the anchor truly slips, and `t_d d'` stands against it, so that a winch lets go of an arm that
/// breaks away. While the winch stands, `s` is that of the stretch it stands for: nothing jumps when it goes on.
///
/// # Departs
/// `yuan2023` commands the tension of the drive (8); here it is the speed of its winch.
///
/// # Source
/// Our own.
#[derive(Debug, Clone, Copy, Default)]
pub(super) struct Winch {
    /// Which way the cable slides, or is about to: -1 to 1.
    pub(super) sliding: f64,
    /// What the joints' errors add to it.
    pub(super) correction: f64,
    /// What feedback adds now.
    pub(super) feedback: f64,
    resting: bool,
    /// Error with which it is content at rest, m, and the last that was left.
    content: f64,
    turned: f64,
}

/// At rest a muscle is content with so many times more after every turn.
const LENIENCE: f64 = 1.5;

/// `v_c`, m/s: a slower anchor creeps.
const CREEPING: f64 = 2e-3;

impl Winch {
    /// Wanted stretch, m.
    pub(super) fn stretch(
        &mut self,
        h: f64,
        law: &CableLaw,
        pull: &MuscleReference,
        drag: f64,
        gains: &ArmGains,
    ) -> f64 {
        let of = |s: f64| {
            let speed = if s * pull.velocity > 0.0 { pull.velocity } else { s * BARELY };
            law.sliding(pull.tension, speed, pull.slip, drag).map_or(0.0, |steady| steady.stretch)
        };
        let (high, low) = (of(1.0), of(-1.0));
        let gap = (high - low).max(1e-3);
        let pace = pull.coming / CREEPING;
        let doubt = gains.feedback_share + gains.creep_feedback_share / (1.0 + pace * pace);
        let (mut coming, mut behind, mut lead) =
            (pull.coming, pull.behind, gains.pre_travel_gain * pull.behind / gap);
        if let Some(stretch) = pull.resting {
            behind = self.left(pull.behind, gains);
            (coming, lead) = (behind / gains.rest_time_constant, 0.0);
            if !self.resting || behind == 0.0 {
                // It goes on from where it stands.
                let s = (2.0 * (stretch - pull.behind) - high - low) / gap;
                self.sliding = s.clamp(-1.0, 1.0);
                self.correction = s - self.sliding - pull.known;
            }
        } else {
            self.content = gains.rest_tolerance[0];
        }
        self.resting = pull.resting.is_some();
        let most = (1.0 - doubt).max(self.sliding.abs().min(1.0 - gains.feedback_share));
        self.sliding = (self.sliding + h * coming / gains.presliding_distance).clamp(-most, most);
        let end = 1.0 + doubt;
        let ahead = self.sliding + pull.known;
        let correction = self.correction + h * gains.pre_travel_integral * behind / gap;
        self.correction = correction.clamp((-end - ahead).min(0.0), (end - ahead).max(0.0));
        self.feedback = self.correction + lead;
        let s = (ahead + self.feedback).clamp(-end, end);
        0.5 * ((1.0 + s) * high + (1.0 - s) * low)
    }

    /// What a muscle at rest is off beyond what it is content with: more at every turn, so that it comes to rest.
    fn left(&mut self, behind: f64, gains: &ArmGains) -> f64 {
        let left = behind - behind.clamp(-self.content, self.content);
        if left * self.turned < 0.0 {
            self.content = (LENIENCE * self.content).min(gains.rest_tolerance[1]);
        }
        if left != 0.0 {
            self.turned = left;
        }
        left
    }

    /// Whether it need not move at rest.
    pub(super) fn is_content(&self, behind: f64) -> bool {
        behind.abs() <= self.content
    }

    /// Speed of the winch, m/s, with the stretch as wanted and as believed.
    pub(super) fn speed(&self, pull: &MuscleReference, wanted: f64, believed: f64, gains: &ArmGains) -> f64 {
        let missing = wanted - believed
            + gains.position_gain * pull.behind
            + gains.rate_gain * (pull.velocity - pull.moving);
        let most = libm::sqrt(2.0 * gains.winch_deceleration * missing.abs());
        let speed = pull.velocity + (missing / gains.stretch_time_constant).clamp(-most, most);
        speed.clamp(-gains.max_winch_speed, gains.max_winch_speed)
    }
}
