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

/// Fractions of `F_max` and `F` in the tension error at which a cable is on its whole side of the dead band.
const BAND: [f64; 2] = [0.05, 0.1];
/// Rate of `i`, 1/s, and the relative error within which it rests.
const INTEGRAL: f64 = 4.0;
const CLOSE: f64 = 0.02;
/// Fraction of the rate of a faulty load cell at which `F` changes.
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
    let fraction = (tension - estimate.tension_out) / band(gains, tension);
    let s = (fraction + estimate.integral).clamp(-1.0, 1.0);
    let travel = 0.5 * ((1.0 + s) * toward + (1.0 - s) * away) - estimate.stretch;
    let most = libm::sqrt(2.0 * gains.winch_deceleration * travel.abs());
    let speed = estimate.velocity + (travel / gains.stretch_time_constant).clamp(-most, most);
    speed.clamp(-gains.max_winch_speed, gains.max_winch_speed)
}

#[cfg(test)]
mod tests {
    use super::super::gains::ArmGains;
    use super::*;

    const H: f64 = 1e-3;

    /// Desired tensions of 21 to 200 N, and a load cell whose fault is a rate of 40 kN/s.
    fn gains(muscles: usize) -> Vec<MuscleGains> {
        ArmGains::for_tests(muscles, 1).muscles
    }

    fn near(a: f64, b: f64) -> bool {
        (a - b).abs() < 1e-12 * (1.0 + b.abs())
    }

    #[test]
    fn the_followed_tension_leads_from_the_estimated_to_the_given_one_at_a_tenth_of_a_faulty_cells_rate() {
        let gains = gains(5);
        let mut following = TensionFollowing::new(5);
        let (estimated, given) = ([60.0, 60.0, 5.0, 300.0, 60.0], [100.0, 30.0, 50.0, 100.0, 62.0]);
        following.set(Some(&given)).unwrap();
        let mut tension = [f64::NAN; 5];
        for k in 1..=100 {
            following.advance(H, &gains, &estimated, &mut tension);
            for ((tension, from), to) in tension.iter().zip(estimated).zip(given) {
                let from = from.clamp(21.0, 200.0);
                let way = (4.0 * f64::from(k)).min((to - from).abs());
                assert!(near(*tension, from + way * (to - from).signum()), "{k}: {tension}");
            }
        }
        // Other tensions are followed from where it is, and beyond the limits to the limits.
        following.set(Some(&[500.0, 500.0, 1.0, 1.0, -5.0])).unwrap();
        following.advance(H, &gains, &estimated, &mut tension);
        assert!(tension.iter().zip([104.0, 34.0, 46.0, 96.0, 58.0]).all(|(a, b)| near(*a, b)), "{tension:?}");
        for _ in 0..100 {
            following.advance(H, &gains, &estimated, &mut tension);
        }
        assert!(
            tension.iter().zip([200.0, 200.0, 21.0, 21.0, 21.0]).all(|(a, b)| near(*a, b)),
            "{tension:?}"
        );
    }

    #[test]
    fn following_begins_with_tensions_ends_without_them_and_begins_anew_with_the_estimate() {
        let gains = gains(1);
        let mut following = TensionFollowing::new(1);
        assert!(!following.is_active() && following.integral().is_none());
        let wrong = [&[50.0, 50.0][..], &[][..], &[f64::NAN][..], &[f64::INFINITY][..]];
        assert!(wrong.into_iter().all(|given| following.set(Some(given)).is_err()));
        assert!(!following.is_active());
        following.set(Some(&[50.0])).unwrap();
        assert!(following.is_active());
        let mut tension = [0.0];
        for _ in 0..10 {
            following.advance(H, &gains, &[40.0], &mut tension);
        }
        assert!(near(tension[0], 50.0) && following.integral().is_some_and(|integral| integral[0] > 0.0));
        following.set(None).unwrap();
        assert!(!following.is_active() && following.integral().is_none());
        following.set(Some(&[50.0])).unwrap();
        following.advance(H, &gains, &[49.9], &mut tension);
        assert!(
            near(tension[0], 50.0) && following.integral().is_some_and(|integral| near(integral[0], 0.0))
        );
    }

    #[test]
    fn the_integral_takes_a_lasting_error_four_times_a_second_in_widths_of_the_band_and_rests_close_to_it() {
        let gains = gains(4);
        let mut following = TensionFollowing::new(4);
        following.set(Some(&[50.0; 4])).unwrap();
        let mut tension = [0.0; 4];
        following.advance(H, &gains, &[50.0; 4], &mut tension);
        // At 50 N the band is 5 % of 200 N and 10 % of 50 N; 1 N is close.
        let errors = [3.0, -6.0, 0.9, -0.9];
        let estimated = errors.map(|error| 50.0 - error);
        for k in 1..=1500 {
            following.advance(H, &gains, &estimated, &mut tension);
            let time = H * f64::from(k);
            let integral = following.integral().unwrap();
            for (integral, error) in integral.iter().zip([3.0, -6.0, 0.0, 0.0]) {
                let expected = (4.0 * time * error / 15.0_f64).clamp(-1.0, 1.0);
                assert!((integral - expected).abs() < 1e-12, "{time} s, {error} N: {integral}");
            }
        }
    }

    #[test]
    fn the_winch_takes_its_cable_across_the_dead_band_as_far_as_the_tension_asks() {
        let muscle = gains(1)[0];
        let at = |error: f64, integral: f64, stretch: f64| {
            let estimate = CableEstimate { tension_out: 50.0 - error, stretch, velocity: 0.02, integral };
            winch_speed(50.0, [31e-3, 19e-3], &estimate, &muscle) - 0.02
        };
        // Band of 15 N: error, integral and the stretch at which the winch only follows its anchor.
        let cases = [
            (0.0, 0.0, 25e-3),
            (7.5, 0.0, 28e-3),
            (-7.5, 0.0, 22e-3),
            (0.0, 0.25, 26.5e-3),
            (3.75, 0.25, 28e-3),
            (30.0, 0.0, 31e-3),
            (-3.0, -0.9, 19e-3),
        ];
        for (error, integral, stretch) in cases {
            assert!(at(error, integral, stretch).abs() < 1e-12, "{error} {integral} {stretch}");
            for side in [-1.0, 1.0] {
                // Little is travelled in the time constant, more at the speed from which the winch can stop.
                let little = at(error, integral, stretch - 1e-5 * side);
                assert!((little - 1e-5 * side / 0.0056).abs() < 1e-12, "{error} {integral}: {little}");
                let more = at(error, integral, stretch - 1e-3 * side);
                assert!((more * more - 2.0 * 1.75 * 1e-3).abs() < 1e-12 && more * side > 0.0, "{more}");
                let most = at(error, integral, stretch - side) + 0.02;
                assert!((most - side * muscle.max_winch_speed).abs() < 1e-12, "{most}");
            }
        }
    }
}
