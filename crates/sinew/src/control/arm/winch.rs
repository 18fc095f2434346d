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
/// The other symbols are those of [`ArmGains`] and [`MuscleGains`]. At a reversal of the reference the winch
/// crosses the dead band while the anchor travels `x_t`; the last fraction `beta` of the crossing is left to
/// feedback, because a cable that is driven across too far breaks away. `e_+` and `e_-` take the friction at
/// the speed of slip. The term `t_d` damps break-away. At rest the growing dead zone `delta` ends limit
/// cycles between stiction and integral; a winch within it stands although others still correct their joints,
/// which stiction may delay by a minute.
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
        let feedback_fraction =
            gains.feedback_fraction + gains.creep_feedback_fraction / (1.0 + creep_ratio * creep_ratio);
        let (velocity, integrated, proportional) = if let Some(estimated) = reference.rest_stretch {
            if !self.at_rest {
                self.tolerance = muscle.rest_tolerance[0];
            }
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
            let proportional = muscle.backlash_gain * reference.error / dead_band;
            (reference.previewed_velocity, reference.error, proportional)
        };
        self.at_rest = reference.rest_stretch.is_some();
        // What feedforward has already crossed is kept when beta grows.
        let most = (1.0 - feedback_fraction).max(self.feedforward.abs().min(1.0 - gains.feedback_fraction));
        self.feedforward = (self.feedforward + h * velocity / muscle.presliding_distance).clamp(-most, most);
        let end = 1.0 + feedback_fraction;
        let known = self.feedforward + reference.learned;
        let integral = self.integral + h * muscle.backlash_integral * integrated / dead_band;
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
        let lacking = gains.min_drive_tension - reference.tension_in;
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

    /// At every cycle of a winch at rest whose anchor has these position errors, m: whether it stands, and
    /// its speed, m/s.
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

    const H: f64 = 1e-3;
    /// `e_+` and `e_-`, m, and `G`, m.
    const STEADY: [f64; 2] = [31e-3, 18e-3];
    const DEAD_BAND: f64 = 13e-3;
    const STILL: MuscleReference = MuscleReference {
        velocity: 0.0,
        previewed_velocity: 0.0,
        estimated_velocity: 0.0,
        error: 0.0,
        learned: 0.0,
        tension_in: 40.0,
        rest_stretch: None,
    };

    /// `s` at a desired stretch, m.
    fn place(desired: f64) -> f64 {
        (2.0 * desired - STEADY[0] - STEADY[1]) / DEAD_BAND
    }

    /// `s` after every cycle of `h` s with one reference.
    fn places(h: f64, cycles: u32, reference: &MuscleReference, winch: &mut WinchController) -> Vec<f64> {
        let gains = ArmGains::for_tests(1, 1);
        let cycle = |_| place(winch.desired_stretch(h, STEADY, reference, &gains, &gains.muscles[0]));
        (0..cycles).map(cycle).collect()
    }

    #[test]
    fn feedforward_crosses_the_dead_band_in_proportion_to_the_travel_up_to_the_share_of_feedback() {
        let gains = ArmGains::for_tests(1, 1);
        for speed in [1e-3, -1e-3, 2e-3, -5e-3, 0.1] {
            let moving = MuscleReference { previewed_velocity: speed, ..STILL };
            // Half of the additional fraction is left at 2 mm/s.
            let creep = speed / 2e-3;
            let most = 1.0 - gains.feedback_fraction - gains.creep_feedback_fraction / (1.0 + creep * creep);
            for (k, s) in places(H, 300, &moving, &mut WinchController::default()).iter().enumerate() {
                let travel = (k + 1) as f64 * H * speed;
                let expected = (travel / gains.muscles[0].presliding_distance).clamp(-most, most);
                assert!((s - expected).abs() < 1e-12, "{speed} m/s, {k}: {s} {expected}");
            }
        }
    }

    #[test]
    fn what_feedforward_has_crossed_fast_is_kept_when_the_reference_slows_down() {
        let mut winch = WinchController::default();
        let fast = MuscleReference { previewed_velocity: 0.1, ..STILL };
        let crossed = *places(H, 10, &fast, &mut winch).last().unwrap();
        let slow = places(H, 10, &STILL, &mut winch);
        assert!(crossed > 0.94 && slow.iter().all(|s| (s - crossed).abs() < 1e-12), "{crossed} {slow:?}");
        // On coming to rest on the far side of the dead band, feedback gets its least fraction back.
        let rest = MuscleReference { rest_stretch: Some(STEADY[0]), ..STILL };
        assert!((places(H, 1, &rest, &mut winch)[0] - 0.95).abs() < 1e-12);
        // No winch goes further across than `1 + beta`.
        let beyond = MuscleReference { rest_stretch: Some(STEADY[0] + 0.3 * DEAD_BAND), ..STILL };
        let place = places(H, 1, &beyond, &mut WinchController::default())[0];
        assert!((place - 1.21).abs() < 1e-12, "{place}");
    }

    #[test]
    fn feedback_is_proportional_and_integral_in_dead_bands_and_crosses_to_one_plus_its_share() {
        for error in [1e-4, -1e-4, 1e-3, -1e-3] {
            let mut winch = WinchController::default();
            let off = MuscleReference { error, ..STILL };
            for (k, s) in places(0.05, 100, &off, &mut winch).iter().enumerate() {
                let time = (k + 1) as f64 * 0.05;
                let expected = (7.3 + 4.4 * time) * error / DEAD_BAND;
                assert!(
                    (s - expected.clamp(-1.21, 1.21)).abs() < 1e-12,
                    "{error} m, {time} s: {s} {expected}"
                );
            }
            // The input of learning is all of it; the integral alone is within the same limit.
            let expected = 7.3 * error / DEAD_BAND + (4.4 * 5.0 * error / DEAD_BAND).clamp(-1.21, 1.21);
            assert!((winch.feedback - expected).abs() < 1e-12, "{} {expected}", winch.feedback);
        }
    }

    #[test]
    fn the_integral_ends_where_it_and_what_is_learned_have_crossed_the_dead_band() {
        // Learned, sign of the error, and where the integral ends; it never turns against its error.
        let cases = [
            (0.0, 1.0, 1.21),
            (0.0, -1.0, -1.21),
            (0.5, 1.0, 0.71),
            (0.5, -1.0, -1.71),
            (-0.5, 1.0, 1.71),
            (1.5, 1.0, 0.0),
            (1.5, -1.0, -2.71),
            (-1.5, -1.0, 0.0),
        ];
        for (learned, side, expected) in cases {
            let mut winch = WinchController::default();
            let off = MuscleReference { error: 1e-3 * side, learned, ..STILL };
            let first = places(0.05, 1, &off, &mut winch)[0];
            let proportional = 7.3e-3 * side / DEAD_BAND;
            let one = if expected == 0.0 { 0.0 } else { 0.05 * 4.4e-3 * side / DEAD_BAND };
            let sum = (learned + proportional + one).clamp(-1.21, 1.21);
            assert!((first - sum).abs() < 1e-12, "{learned} {side}: {first} {sum}");
            places(0.05, 400, &off, &mut winch);
            let integral = winch.feedback - proportional;
            assert!((integral - expected).abs() < 1e-12, "{learned} {side}: {integral}");
        }
    }

    #[test]
    fn a_dead_band_that_vanishes_counts_as_ten_micrometres() {
        let gains = ArmGains::for_tests(1, 1);
        let off = MuscleReference { error: 1e-6, ..STILL };
        let mut winch = WinchController::default();
        winch.desired_stretch(H, [20e-3, 20e-3], &off, &gains, &gains.muscles[0]);
        assert!((winch.feedback - (7.3 + 4.4 * H) * 0.1).abs() < 1e-12, "{}", winch.feedback);
    }

    /// One cycle at rest: what is left of the travel of the winch, `x`, m.
    fn travel_at_rest(winch: &mut WinchController, estimated: f64, error: f64, learned: f64) -> f64 {
        let gains = ArmGains::for_tests(1, 1);
        let reference = MuscleReference { error, learned, rest_stretch: Some(estimated), ..STILL };
        let desired = winch.desired_stretch(H, STEADY, &reference, &gains, &gains.muscles[0]);
        desired - estimated + gains.muscles[0].position_gain * error
    }

    #[test]
    fn a_winch_that_stands_has_nothing_left_to_travel_wherever_its_cable_creeps() {
        let mut winch = WinchController::default();
        places(H, 1, &STILL, &mut winch);
        for (estimated, error, learned) in [
            (24e-3, 5e-5, 0.0),
            (26e-3, -8e-5, 0.2),
            (20e-3, 0.0, -0.3),
            (28e-3, 8e-5, 0.0),
            (23e-3, -2e-5, 0.1),
        ] {
            let travel = travel_at_rest(&mut winch, estimated, error, learned);
            assert!(winch.stands && travel.abs() < 1e-15, "{estimated} {error}: {travel}");
        }
    }

    #[test]
    fn a_winch_that_starts_at_rest_has_its_dead_zone_from_the_first_cycle_on() {
        let mut winch = WinchController::default();
        let travel = travel_at_rest(&mut winch, 24e-3, 8e-5, 0.0);
        assert!(winch.stands && winch.is_within_tolerance(8e-5) && travel.abs() < 1e-15, "{travel}");
    }

    #[test]
    fn an_error_beyond_the_dead_zone_is_corrected_at_rest_over_the_time_constant_of_rest() {
        let gains = ArmGains::for_tests(1, 1);
        for (side, learned) in [(1.0, 0.0), (-1.0, 0.2)] {
            let mut winch = WinchController::default();
            places(H, 1, &STILL, &mut winch);
            let excess = side * 1.1e-4;
            let rate = excess / (gains.rest_time_constant * gains.muscles[0].presliding_distance)
                + gains.muscles[0].backlash_integral * excess / DEAD_BAND;
            for k in 1..=100 {
                // From the first cycle on, although the arm comes to rest with this error.
                let travel = travel_at_rest(&mut winch, 24e-3, excess + side * 9e-5, learned);
                let expected = 0.5 * DEAD_BAND * rate * H * f64::from(k);
                assert!((travel - expected).abs() < 1e-14 && !winch.stands, "{k}: {travel} {expected}");
            }
        }
    }

    #[test]
    fn the_dead_zone_at_rest_grows_when_the_error_crosses_it_up_to_its_limit_and_anew_after_a_motion() {
        let mut winch = WinchController::default();
        let zone_is = |winch: &WinchController, zone: f64| {
            [-1.0, 1.0].into_iter().all(|side| {
                winch.is_within_tolerance(0.99 * side * zone)
                    && !winch.is_within_tolerance(1.01 * side * zone)
            })
        };
        for _ in 0..2 {
            places(H, 1, &STILL, &mut winch);
            assert!(zone_is(&winch, 9e-5));
            winch.last_excess = 0.0;
            // To the same side it does not grow, nor within it.
            for error in [1e-4, 1e-4, 0.0, 1e-4, 0.0] {
                travel_at_rest(&mut winch, 24e-3, error, 0.0);
                assert!(zone_is(&winch, 9e-5), "{error}");
            }
            travel_at_rest(&mut winch, 24e-3, -1e-4, 0.0);
            assert!(zone_is(&winch, 1.35e-4));
            travel_at_rest(&mut winch, 24e-3, 1.36e-4, 0.0);
            assert!(zone_is(&winch, 1.4e-4));
            travel_at_rest(&mut winch, 24e-3, -2e-4, 0.0);
            assert!(zone_is(&winch, 1.4e-4));
        }
    }

    /// `v`, m/s, at a desired stretch that exceeds the estimated one, m.
    fn speed(reference: &MuscleReference, lacking_stretch: f64) -> f64 {
        let gains = ArmGains::for_tests(1, 1);
        WinchController::default().speed(reference, 20e-3 + lacking_stretch, 20e-3, 4e-5, &gains.muscles[0])
    }

    #[test]
    fn a_winch_takes_the_speed_of_its_reference_and_travels_what_its_cable_and_anchor_lack_in_its_time_constant()
     {
        let muscle = ArmGains::for_tests(1, 1).muscles[0];
        let at = |velocity: f64, estimated: f64, error: f64| MuscleReference {
            velocity,
            estimated_velocity: estimated,
            error,
            ..STILL
        };
        let near = |speed: f64, expected: f64| (speed - expected).abs() < 1e-12;
        for side in [-1.0, 1.0] {
            assert!(near(speed(&at(0.05 * side, 0.05 * side, 0.0), 0.0), 0.05 * side));
            let stretch = 1e-5 * side;
            assert!(near(speed(&at(0.05, 0.05, 0.0), stretch), 0.05 + stretch / 0.0056));
            assert!(near(speed(&at(0.05, 0.05, stretch), 0.0), 0.05 + 0.94 * stretch / 0.0056));
            // A tenth of a millimetre per second of speed error.
            assert!(near(speed(&at(0.05, 0.05 - 1e-4 * side, 0.0), 0.0), 0.05 + 0.15 * 1e-4 * side / 0.0056));
            // Together.
            let travel = side * (1e-5 + 0.94 * 2e-5 - 0.15 * 1e-4);
            let all = at(0.05, 0.05 + 1e-4 * side, 2e-5 * side);
            assert!(near(speed(&all, stretch), 0.05 + travel / 0.0056));
            // A longer travel at the speed from which the winch can still stop.
            let far = speed(&at(0.05, 0.05, 0.0), 1e-3 * side) - 0.05;
            assert!(near(far * far, 2.0 * muscle.winch_deceleration * 1e-3) && far * side > 0.0);
            assert!(near(speed(&at(0.0, 0.0, 0.0), side), side * muscle.max_winch_speed));
        }
    }

    #[test]
    fn a_winch_whose_cable_is_about_to_fall_slack_takes_up_what_it_lacks_on_top_of_its_anchors_motion() {
        let paying = |tension_in: f64| MuscleReference {
            velocity: -0.05,
            estimated_velocity: -0.05,
            tension_in,
            ..STILL
        };
        let (muscle, c) = (ArmGains::for_tests(1, 1).muscles[0], 4e-5);
        // At the minimum tension and above it the winch pays out as it is told.
        for tension in [muscle.min_drive_tension, 2.0, 40.0] {
            assert!(speed(&paying(tension), -1e-4) < -0.06);
        }
        for tension in [0.9, 0.4, 0.0] {
            // The stretch that the tension lacks, in twice the time constant.
            let expected = -0.05 + c * (1.0 - tension) / (2.0 * 0.0056);
            assert!((speed(&paying(tension), -1e-4) - expected).abs() < 1e-12, "{tension}");
            // A winch that is faster by itself is not slowed down.
            assert!((speed(&paying(tension), 1e-3) - speed(&paying(40.0), 1e-3)).abs() < 1e-15);
        }
    }
}
