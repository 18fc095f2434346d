use super::gains::{ArmGains, MuscleGains};

/// Reference of one muscle for the next control cycle, with the estimates that its winch feeds back.
#[derive(Debug, Clone, Copy, PartialEq)]
pub(super) struct MuscleReference {
    /// `v_r(t)`, reference speed of the anchor, m/s, + toward the motor.
    pub(super) velocity: f64,
    /// `v_r(t + t_p)`, m/s.
    pub(super) previewed_velocity: f64,
    /// `v^`, estimated speed of the anchor, m/s.
    pub(super) estimated_velocity: f64,
    /// `d = R (q_r - q^)`, position error of the anchor, m.
    pub(super) error: f64,
    /// `s_k`, contribution of iterative learning, 1.
    pub(super) learned: f64,
    /// `T_in^`, estimated tension at the drive, N.
    pub(super) tension_in: f64,
    /// `e^` while the reference is at rest, m; none while it moves.
    pub(super) rest_stretch: Option<f64>,
}

/// Speed of a winch from the desired far tension of its cable and the position error of its anchor.
///
/// While the reference moves:
///
/// ```text
/// s_r' = v_r(t + t_p)/x_t                       |s_r| <= 1 - beta
/// s_i' = lambda_i d/G                           |s_r + s_k + s_i| <= 1 + beta
/// s  = s_r + s_k + s_i + lambda d/G             |s| <= 1 + beta
/// e* = (1 + s)/2 e_+ + (1 - s)/2 e_-,           G = e_+ - e_-
/// x  = e* - e^ + kappa d + t_d (v_r - v^)
/// v  = v_r + clip(x/t_v, +-sqrt(2 a |x|))       |v| <= v_max
/// beta = beta_0 + beta_c/(1 + (v_r(t + t_p)/v_c)^2)
/// ```
///
/// and where `T_in^ < T_f`, so that the cable stays on its winch, `v >= v^ + c (T_f - T_in^)/t_f`.
///
/// At rest `d` is passed through a dead zone, `d_0 = d - clip(d, +-delta)`, and
///
/// ```text
/// s_r' = d_0/(t_r x_t),   s_i' = lambda_i d_0/G,   s = s_r + s_k + s_i
/// v = 0,   s_r + s_k + s_i = (2 (e^ - kappa d) - e_+ - e_-)/G      at the beginning of rest and while d_0 = 0
/// delta <- min(3/2 delta, delta_max)            whenever d_0 changes sign, from delta_min
/// ```
///
/// | symbol    | meaning                                                                      | unit   |
/// |-----------|------------------------------------------------------------------------------|--------|
/// | v_r, v^, d | reference and estimated speed of the anchor, its position error (24), (25)    | m/s, m |
/// | e_+, e_-  | stretch at the desired far tension `F_d`, sliding toward the motor or away (7), (10) | m |
/// | e^        | estimated stretch                                                            | m      |
/// | T_in^, T_f | estimated tension at the drive, and that below which the drive itself pays out no more | N |
/// | c, t_f    | compliance of the whole cable; two of `t_v`                                    | m/N, s |
/// | G         | dead band: travel of the winch that reverses the sliding of the whole cable    | m      |
/// | s         | place in the dead band, -1 to 1: feedforward `s_r`, learned `s_k`, integral `s_i` | 1    |
/// | t_p       | [`PREVIEW_HORIZON`](crate::control::stretch::PREVIEW_HORIZON)                  | s      |
/// | v_c       | [`CREEP_SPEED`]                                                              | m/s    |
///
/// The other symbols are those of [`ArmGains`] and [`MuscleGains`]. At a reversal of the reference the winch crosses the dead band
/// while the anchor travels `x_t`; the last share `beta` of the crossing is left to feedback, because a cable
/// that is driven across too far breaks away. `e_+` and `e_-` take the friction at the speed of slip. The
/// term `t_d` damps break-away. At rest the growing dead zone `delta` ends limit cycles between stiction and
/// integral; a winch within it stands although others still correct their joints, which stiction may delay by a minute.
///
/// # Departs
/// `yuan2023` commands the tension of the drive (8); this law commands the speed of its winch.
///
/// # Source
/// Our own.
#[derive(Debug, Clone, Copy, Default)]
pub(super) struct WinchController {
    /// `s_r`, 1.
    feedforward: f64,
    /// `s_i`, 1.
    integral: f64,
    /// `s_i + lambda d/G`, contribution of feedback to `s`, 1: input of iterative learning.
    pub(super) feedback: f64,
    at_rest: bool,
    /// Whether `d_0 = 0`, so that the winch stands at rest.
    pub(super) stands: bool,
    /// `delta`, m.
    tolerance: f64,
    /// Last `d_0` other than zero, m.
    last_excess: f64,
}

/// Growth of the dead zone at rest with every change of sign.
const TOLERANCE_GROWTH: f64 = 1.5;

/// `v_c`, m/s: below it static friction exceeds sliding friction.
const CREEP_SPEED: f64 = 2e-3;

/// `t_f/t_v`.
const TAUT_TIME: f64 = 2.0;

/// Least dead band, m: bounds `1/G`.
const MIN_DEAD_BAND: f64 = 1e-5;

impl WinchController {
    /// `e*`, m, `h` s after the one before, from `e_+` and `e_-`.
    pub(super) fn desired_stretch(
        &mut self,
        h: f64,
        [toward, away]: [f64; 2],
        reference: &MuscleReference,
        gains: &ArmGains,
        muscle: &MuscleGains,
    ) -> f64 {
        let dead_band = (toward - away).max(MIN_DEAD_BAND);
        let creep_ratio = reference.previewed_velocity / CREEP_SPEED;
        let feedback_share =
            gains.feedback_share + gains.creep_feedback_share / (1.0 + creep_ratio * creep_ratio);
        let (velocity, integrated, proportional) = if let Some(estimated) = reference.rest_stretch {
            let excess = self.excess_at_rest(reference.error, muscle);
            self.stands = excess == 0.0;
            if !self.at_rest || self.stands {
                // From this `s` the winch starts from rest when `d` leaves the dead zone: `x = 0`.
                let standing = estimated - muscle.position_gain * reference.error;
                let s = (2.0 * standing - toward - away) / dead_band;
                self.feedforward = s.clamp(-1.0, 1.0);
                self.integral = s - self.feedforward - reference.learned;
            }
            (excess / gains.rest_time_constant, excess, 0.0)
        } else {
            self.stands = false;
            self.tolerance = muscle.rest_tolerance[0];
            let proportional = muscle.pre_travel_gain * reference.error / dead_band;
            (reference.previewed_velocity, reference.error, proportional)
        };
        self.at_rest = reference.rest_stretch.is_some();
        // What feedforward has already crossed is kept when beta grows.
        let most = (1.0 - feedback_share).max(self.feedforward.abs().min(1.0 - gains.feedback_share));
        self.feedforward = (self.feedforward + h * velocity / muscle.presliding_distance).clamp(-most, most);
        let end = 1.0 + feedback_share;
        let known = self.feedforward + reference.learned;
        let integral = self.integral + h * muscle.pre_travel_integral * integrated / dead_band;
        self.integral = integral.clamp((-end - known).min(0.0), (end - known).max(0.0));
        self.feedback = self.integral + proportional;
        let s = (known + self.feedback).clamp(-end, end);
        0.5 * ((1.0 + s) * toward + (1.0 - s) * away)
    }

    /// `d_0`, m; a change of its sign widens the dead zone.
    fn excess_at_rest(&mut self, error: f64, gains: &MuscleGains) -> f64 {
        let excess = error - error.clamp(-self.tolerance, self.tolerance);
        if excess * self.last_excess < 0.0 {
            self.tolerance = (TOLERANCE_GROWTH * self.tolerance).min(gains.rest_tolerance[1]);
        }
        if excess != 0.0 {
            self.last_excess = excess;
        }
        excess
    }

    /// Whether the position error of the anchor, m, is within the dead zone at rest.
    pub(super) fn is_within_tolerance(&self, error: f64) -> bool {
        error.abs() <= self.tolerance
    }

    /// `v`, m/s, from the desired and the estimated stretch, m, and the compliance, m/N.
    pub(super) fn speed(
        &self,
        reference: &MuscleReference,
        desired_stretch: f64,
        estimated_stretch: f64,
        compliance: f64,
        gains: &MuscleGains,
    ) -> f64 {
        let travel = desired_stretch - estimated_stretch
            + gains.position_gain * reference.error
            + gains.rate_gain * (reference.velocity - reference.estimated_velocity);
        let most = libm::sqrt(2.0 * gains.winch_deceleration * travel.abs());
        let speed = reference.velocity + (travel / gains.stretch_time_constant).clamp(-most, most);
        let lacking = gains.least_drive_tension - reference.tension_in;
        let speed = if lacking > 0.0 {
            let taut = compliance * lacking / (TAUT_TIME * gains.stretch_time_constant);
            speed.max(reference.estimated_velocity + taut)
        } else {
            speed
        };
        speed.clamp(-gains.max_winch_speed, gains.max_winch_speed)
    }
}

#[cfg(test)]
mod tests {
    use super::*;
    use alloc::vec::Vec;

    /// At every cycle of a winch at rest whose anchor has these position errors, m: whether it stands, and its speed, m/s.
    fn at_rest(errors: &[f64]) -> Vec<(bool, f64)> {
        let gains = ArmGains::for_tests(1, 1);
        let muscle = &gains.muscles[0];
        let steady = [31e-3, 18e-3];
        let estimated = 0.5 * (steady[0] + steady[1]);
        let moving = MuscleReference {
            velocity: 0.0,
            previewed_velocity: 0.0,
            estimated_velocity: 0.0,
            error: 0.0,
            learned: 0.0,
            tension_in: 40.0,
            rest_stretch: None,
        };
        let mut winch = WinchController::default();
        // The dead zone begins with the first motion.
        winch.desired_stretch(1e-3, steady, &moving, &gains, muscle);
        let cycle = |error: &f64| {
            let reference = MuscleReference { error: *error, rest_stretch: Some(estimated), ..moving };
            let desired = winch.desired_stretch(1e-3, steady, &reference, &gains, muscle);
            (winch.stands, winch.speed(&reference, desired, estimated, 0.0, muscle))
        };
        errors.iter().map(cycle).collect()
    }

    #[test]
    fn at_rest_a_winch_stands_within_its_dead_zone_and_leaves_it_toward_its_reference() {
        let [least, _] = ArmGains::for_tests(1, 1).muscles[0].rest_tolerance;
        for side in [-1.0, 1.0] {
            assert!(at_rest(&[0.9 * side * least; 1000]).iter().all(|(stands, _)| *stands));
            let beyond = at_rest(&[1.5 * side * least; 1000]);
            assert!(beyond.iter().all(|(stands, speed)| !stands && side * speed > 0.0), "{beyond:?}");
        }
    }
}
