use super::heat::WindingHeat;
use super::limits::Limits;
use super::signals::NamedFault;
use crate::control::arm::{ArmMeasurement, Fault, Symptom};
use alloc::vec;
use alloc::vec::Vec;

/// Holds the measurements against the limits of a machine.
///
/// ```text
/// overload     T > T_max           for t_1        slack        T < T_s and T^_in < 2 T_s    for t_2
/// tension rate |T_f'| > T'_max     for t_1        overspeed    |p_m'| > v_max               for t_1
/// travel       p_m outside         for t_1        joint range  q outside                    for t_1
/// overheating  T_w > T_w,max by the thermal model of the motor
/// ```
///
/// | symbol | meaning                                                        | unit |
/// |--------|----------------------------------------------------------------|------|
/// | T, T^_in, T_f | tension at the drive measured, estimated and filtered with `t_f`, 10 ms | N |
/// | p_m, q | motor position, joint coordinate                               | m, rad or m |
/// | t_1, t_2 | [`PERSISTENCE`], [`SLACK_PERSISTENCE`]                         | s    |
///
/// Rates are those over [`WINDOW`]. A reading that is missing ends no persistence and begins none.
#[derive(Debug, Clone)]
pub(super) struct LimitMonitor {
    muscles: Vec<Watched>,
    /// Time for which every joint has been outside of its range, s.
    outside_for: Vec<f64>,
}

/// s: `t_1`.
pub(super) const PERSISTENCE: f64 = 0.01;
/// s: `t_2`.
pub(super) const SLACK_PERSISTENCE: f64 = 0.3;
/// s: time over which speed and rate are taken.
const WINDOW: f64 = 0.02;
/// s: `t_f`.
const FILTER: f64 = 0.01;

/// State of one muscle.
#[derive(Debug, Clone, Copy)]
struct Watched {
    heat: WindingHeat,
    overloaded_for: f64,
    slack_for: f64,
    too_fast_for: f64,
    too_steep_for: f64,
    outside_for: f64,
    /// `T_f`, N; NaN before the first reading.
    tension: f64,
    /// Tension, N, and position, m, at the beginning of the window; NaN before it.
    before: [f64; 2],
    /// Rate, N/s, and speed, m/s, over the last window.
    rates: [f64; 2],
    window: f64,
}

impl Watched {
    const NEW: f64 = f64::NAN;

    fn new() -> Self {
        Self {
            heat: WindingHeat::new(),
            overloaded_for: 0.0,
            slack_for: 0.0,
            too_fast_for: 0.0,
            too_steep_for: 0.0,
            outside_for: 0.0,
            tension: Self::NEW,
            before: [Self::NEW; 2],
            rates: [0.0; 2],
            window: 0.0,
        }
    }
}

/// Time for which something has been true: `h` s longer, or not at all.
fn persist(for_s: &mut f64, h: f64, holds: bool, limit: f64) -> bool {
    *for_s = if holds { *for_s + h } else { 0.0 };
    *for_s > limit
}

impl LimitMonitor {
    pub(super) fn new(limits: &Limits) -> Self {
        Self {
            muscles: vec![Watched::new(); limits.muscles.len()],
            outside_for: vec![0.0; limits.ranges.len()],
        }
    }

    /// Forgets all but the temperatures.
    pub(super) fn restart(&mut self) {
        for muscle in &mut self.muscles {
            *muscle = Watched { heat: muscle.heat, ..Watched::new() };
        }
        self.outside_for.fill(0.0);
    }

    /// Temperature of a winding by its thermal model, degrees Celsius.
    pub(super) fn winding(&self, muscle: usize) -> f64 {
        self.muscles.get(muscle).map_or(f64::NAN, |muscle| muscle.heat.winding())
    }

    /// Compares the measurements of one cycle, `h` s after the one before, with the limits; `tension_in` is
    /// that of the observers, N, where the controller runs.
    pub(super) fn update(
        &mut self,
        h: f64,
        limits: &Limits,
        measured: &ArmMeasurement<'_>,
        tension_in: Option<&[f64]>,
    ) -> Option<NamedFault> {
        let mut found = None;
        let mut find = |fault: Fault, is: bool| {
            if is && found.is_none() {
                found = Some(NamedFault::new(fault, Symptom::Unknown));
            }
        };
        for (k, (watched, limit)) in self.muscles.iter_mut().zip(&limits.muscles).enumerate() {
            let (tension, motor) = (measured.tension[k], measured.motor[k]);
            watched.follow(h, tension, motor);
            if let Some((drive, hottest)) = &limit.motor {
                watched.heat.update(h, drive, watched.tension, watched.rates[1]);
                find(Fault::Overheating(k), watched.heat.winding() > *hottest);
            }
            // Without a reading, the observer's estimate tells of an overload and ends none.
            let estimated_over = tension_in.is_some_and(|all| tension.is_nan() && all[k] > limit.tension);
            if tension.is_finite() || estimated_over {
                let over = estimated_over || tension > limit.tension;
                find(Fault::Overload(k), persist(&mut watched.overloaded_for, h, over, PERSISTENCE));
            }
            if let (Some(estimated), true) = (tension_in, tension.is_finite()) {
                let slack = watched.tension < limit.slack_tension
                    && estimated[k] < SLACK_ESTIMATE * limit.slack_tension;
                find(Fault::Slack(k), persist(&mut watched.slack_for, h, slack, SLACK_PERSISTENCE));
            }
            let [rate, speed] = watched.rates;
            let steep = rate.abs() > limit.tension_rate;
            find(Fault::TensionRate(k), persist(&mut watched.too_steep_for, h, steep, PERSISTENCE));
            let fast = speed.abs() > limit.speed;
            find(Fault::Overspeed(k), persist(&mut watched.too_fast_for, h, fast, PERSISTENCE));
            if let (Some([low, high]), true) = (limit.travel, motor.is_finite()) {
                let outside = !(low..=high).contains(&motor);
                find(Fault::Travel(k), persist(&mut watched.outside_for, h, outside, PERSISTENCE));
            }
        }
        for (j, (range, outside_for)) in limits.ranges.iter().zip(&mut self.outside_for).enumerate() {
            if let (Some([low, high]), true) = (range, measured.joint[j].is_finite()) {
                let outside = !(*low..=*high).contains(&measured.joint[j]);
                find(Fault::JointRange(j), persist(outside_for, h, outside, PERSISTENCE));
            }
        }
        found
    }
}

/// Estimated tension up to which a cable without a measured one is slack rather than broken, slack tensions.
const SLACK_ESTIMATE: f64 = 2.0;

impl Watched {
    /// Filters the tension and takes speed and rate over the last window.
    fn follow(&mut self, h: f64, tension: f64, motor: f64) {
        if tension.is_finite() {
            let fraction = (h / FILTER).min(1.0);
            self.tension = if self.tension.is_nan() {
                tension
            } else {
                self.tension + fraction * (tension - self.tension)
            };
        }
        self.window += h;
        if self.window < WINDOW - 0.5 * h {
            return;
        }
        let now = [self.tension, motor];
        for ((rate, before), now) in self.rates.iter_mut().zip(self.before).zip(now) {
            let change = now - before;
            *rate = if change.is_finite() { change / self.window } else { 0.0 };
        }
        (self.before, self.window) = (now, 0.0);
    }
}

#[cfg(test)]
mod tests {
    use super::*;
    use crate::control::arm::ArmGains;
    use crate::drive::DriveParameters;
    use core::iter::repeat_n;

    /// Signals of one cycle: of the second muscle and of the joint.
    #[derive(Debug, Clone, Copy)]
    struct Seen {
        motor: f64,
        tension: f64,
        joint: f64,
        estimated: Option<f64>,
    }

    /// Nothing unusual.
    const USUAL: Seen = Seen { motor: 0.2, tension: 100.0, joint: 0.0, estimated: Some(100.0) };

    /// Two muscles at one joint; a tension of 400 N, 0.5 m of travel, a joint of +-1 rad, slack below 10 N.
    fn limits() -> Limits {
        let mut limits = Limits::of_gains(&ArmGains::for_tests(2, 1));
        for muscle in &mut limits.muscles {
            (muscle.tension, muscle.travel, muscle.slack_tension) = (400.0, Some([0.0, 0.5]), 10.0);
        }
        limits.ranges[0] = Some([-1.0, 1.0]);
        limits
    }

    fn step(monitor: &mut LimitMonitor, h: f64, limits: &Limits, seen: Seen) -> Option<NamedFault> {
        let measured = ArmMeasurement {
            motor: &[0.2, seen.motor],
            tension: &[100.0, seen.tension],
            joint: &[seen.joint],
        };
        let estimated = seen.estimated.map(|estimated| [100.0, estimated]);
        monitor.update(h, limits, &measured, estimated.as_ref().map(|both| &both[..]))
    }

    /// The first fault, with the cycle in which it is found, from 1 on.
    fn first(limits: &Limits, h: f64, signal: impl IntoIterator<Item = Seen>) -> Option<(usize, Fault)> {
        let mut monitor = LimitMonitor::new(limits);
        signal.into_iter().enumerate().find_map(|(k, seen)| {
            let found = step(&mut monitor, h, limits, seen)?;
            assert_eq!(found.symptom, Symptom::Unknown);
            Some((k + 1, found.fault))
        })
    }

    /// Signals beyond a limit, with their faults.
    fn exceeded() -> [(Seen, Fault); 5] {
        [
            (Seen { tension: 401.0, ..USUAL }, Fault::Overload(1)),
            (Seen { motor: 0.501, ..USUAL }, Fault::Travel(1)),
            (Seen { motor: -0.001, ..USUAL }, Fault::Travel(1)),
            (Seen { joint: 1.01, ..USUAL }, Fault::JointRange(0)),
            (Seen { joint: -1.01, ..USUAL }, Fault::JointRange(0)),
        ]
    }

    #[test]
    fn a_limit_that_is_reached_but_not_exceeded_is_no_fault() {
        for seen in [
            USUAL,
            Seen { tension: 400.0, ..USUAL },
            Seen { motor: 0.0, joint: -1.0, ..USUAL },
            Seen { motor: 0.5, joint: 1.0, ..USUAL },
            Seen { motor: f64::NAN, tension: f64::NAN, joint: f64::NAN, estimated: None },
        ] {
            assert_eq!(first(&limits(), 4e-3, repeat_n(seen, 200)), None, "{seen:?}");
        }
    }

    #[test]
    fn an_exceeded_limit_is_a_fault_once_it_has_lasted_for_ten_milliseconds() {
        for (seen, fault) in exceeded() {
            for (h, cycle) in [(4e-3, 3), (3e-3, 4), (0.7e-3, 15), (PERSISTENCE, 2), (0.02, 1)] {
                assert_eq!(first(&limits(), h, repeat_n(seen, 20)), Some((cycle, fault)), "{h}");
            }
        }
    }

    #[test]
    fn what_is_within_its_limits_now_and_then_is_no_fault_and_what_is_missing_ends_none() {
        for (seen, fault) in exceeded() {
            let often = (0..100).map(|k| if k % 3 == 2 { USUAL } else { seen });
            assert_eq!(first(&limits(), 4e-3, often), None, "{fault:?}");
            let lost = Seen { motor: f64::NAN, tension: f64::NAN, joint: f64::NAN, estimated: Some(100.0) };
            let gaps = (0..100).map(|k| if k % 2 == 1 { lost } else { seen });
            assert_eq!(first(&limits(), 4e-3, gaps), Some((5, fault)));
        }
    }

    #[test]
    fn of_several_faults_the_first_is_named() {
        let seen = Seen { tension: 401.0, motor: 0.6, joint: 2.0, ..USUAL };
        assert_eq!(first(&limits(), 4e-3, repeat_n(seen, 9)), Some((3, Fault::Overload(1))));
    }

    #[test]
    fn a_restart_forgets_how_long_a_limit_was_exceeded() {
        let limits = limits();
        for (seen, fault) in exceeded() {
            let mut monitor = LimitMonitor::new(&limits);
            for _ in 0..10 {
                assert_eq!(step(&mut monitor, 4e-3, &limits, seen), None);
                assert_eq!(step(&mut monitor, 4e-3, &limits, seen), None);
                monitor.restart();
            }
            let found = (0..3).filter_map(|_| step(&mut monitor, 4e-3, &limits, seen)).last();
            assert_eq!(found.map(|found| found.fault), Some(fault));
        }
    }

    #[test]
    fn a_cable_is_slack_where_its_tension_is_low_and_none_is_expected_for_three_tenths_of_a_second() {
        let of = |tension: f64, estimated: Option<f64>| {
            first(&limits(), 0.08, repeat_n(Seen { tension, estimated, ..USUAL }, 50))
        };
        assert_eq!(of(5.0, Some(15.0)), Some((4, Fault::Slack(1))));
        assert_eq!(of(9.9, Some(0.0)), Some((4, Fault::Slack(1))));
        // A cable of which tension is expected is broken, which is for others to say.
        assert_eq!((of(5.0, Some(20.0)), of(5.0, Some(30.0))), (None, None));
        assert_eq!((of(10.0, Some(5.0)), of(12.0, Some(5.0)), of(5.0, None)), (None, None, None));
    }

    /// The same without limits but those of rates: N/s and m/s.
    fn rates(rate: f64, speed: f64) -> Limits {
        let mut limits = Limits::of_gains(&ArmGains::for_tests(2, 1));
        limits.muscles.iter_mut().for_each(|muscle| (muscle.tension_rate, muscle.speed) = (rate, speed));
        limits
    }

    #[test]
    fn a_winch_and_a_tension_may_change_at_their_limits_and_not_faster() {
        // One cycle of a 64th of a second is a window: all numbers are exact.
        let h = 1.0 / 64.0;
        let of = |limits: &Limits, speed: f64, rate: f64| {
            first(
                limits,
                h,
                (0..40).map(|k| {
                    let time = h * f64::from(k);
                    Seen { motor: 0.2 + speed * time, tension: 150.0 + rate * time, ..USUAL }
                }),
            )
        };
        let limits = &rates(64.0, 1.0);
        for side in [-1.0, 1.0] {
            assert_eq!(of(limits, side * 0.999, side * 64.0), None);
            assert_eq!(of(&rates(64.0, f64::INFINITY), side * 9.0, side * 64.0), None);
            assert_eq!(of(limits, side * 1.01, side * 64.0), Some((2, Fault::Overspeed(1))));
            assert_eq!(of(limits, side * 0.999, side * 65.0), Some((2, Fault::TensionRate(1))));
        }
        let exact = (0..40).map(|k| Seen { motor: h * f64::from(k), ..USUAL });
        assert_eq!(first(limits, h, exact), None, "a winch at its limit");
    }

    #[test]
    fn a_speed_is_taken_over_twenty_milliseconds_so_that_noise_between_cycles_is_none() {
        let alternating = (0..400).map(|k| Seen { motor: 0.2 + 1e-4 * f64::from(k % 2), ..USUAL });
        // 0.1 m/s between two cycles, nothing between the ends of windows of an even number of cycles.
        assert_eq!(first(&rates(f64::INFINITY, 1e-3), 1e-3, alternating), None);
        let steady = |speed: f64| (0..200).map(move |k| Seen { motor: 1e-3 * speed * f64::from(k), ..USUAL });
        assert_eq!(first(&rates(f64::INFINITY, 0.51), 1e-3, steady(0.5)), None);
        // Two windows and ten milliseconds.
        let found = first(&rates(f64::INFINITY, 0.49), 1e-3, steady(0.5));
        assert!(matches!(found, Some((49..=52, Fault::Overspeed(1)))), "{found:?}");
        // A reading that is missing at the end of a window is no speed of any size.
        let lost = (0..200).map(|k| Seen { motor: if k % 40 == 19 { f64::NAN } else { 0.2 }, ..USUAL });
        assert_eq!(first(&rates(f64::INFINITY, 1e-3), 1e-3, lost), None);
    }

    #[test]
    fn a_step_of_the_tension_counts_by_what_its_filter_of_ten_milliseconds_lets_through() {
        // A step at the beginning of the second window: 1 - (1 - h/t_f)^20 of it by the end.
        let step = |k: u32| Seen { tension: if k < 20 { 100.0 } else { 140.0 }, ..USUAL };
        let rate = 40.0 * (1.0 - 0.9_f64.powi(20)) / 0.02;
        let found = |limit: f64| first(&rates(limit, f64::INFINITY), 1e-3, (0..100).map(step));
        assert_eq!(found(1.001 * rate), None);
        assert!(matches!(found(0.999 * rate), Some((49..=52, Fault::TensionRate(1)))));
    }

    /// The monitor of a winch after days at a tension, N, and a speed, m/s, with its fault in the last cycle.
    fn warm(hottest: f64, tension: f64, speed: f64) -> (LimitMonitor, Option<Fault>) {
        let mut limits = Limits::of_gains(&ArmGains::for_tests(2, 1));
        limits.muscles[1].motor = Some((DriveParameters::mc_am(), hottest));
        let mut monitor = LimitMonitor::new(&limits);
        let h = 1e4;
        let found = (0..200).map(|k| {
            let motor = speed * h * f64::from(k);
            step(&mut monitor, h, &limits, Seen { motor, tension, ..USUAL })
        });
        let found = found.last().flatten().map(|found| found.fault);
        (monitor, found)
    }

    #[test]
    fn a_winding_hotter_than_its_limit_is_a_fault() {
        let drive = DriveParameters::mc_am();
        for speed in [0.05, 0.0, -0.05] {
            let current = match speed {
                0.05 => drive.pulling_current(200.0, 0.05),
                0.0 => 0.5 * (drive.pulling_current(200.0, 0.0) + drive.yielding_current(200.0, 0.0)),
                _ => drive.yielding_current(200.0, 0.05),
            };
            let steady = drive.motor.steady_temperature(current);
            let (monitor, found) = warm(steady + 0.1, 200.0, speed);
            assert_eq!(found, None, "{speed}");
            assert!((monitor.winding(1) - steady).abs() < 0.05, "{} {steady}", monitor.winding(1));
            assert_eq!(warm(steady - 0.1, 200.0, speed).1, Some(Fault::Overheating(1)));
        }
    }

    #[test]
    fn a_restart_does_not_cool_a_winding_and_a_motor_that_is_not_known_stays_cold() {
        let (mut monitor, _) = warm(f64::INFINITY, 300.0, 0.0);
        let hot = monitor.winding(1);
        monitor.restart();
        assert!(hot > 40.0 && (monitor.winding(1) - hot).abs() < 1e-12, "{hot} {}", monitor.winding(1));
        assert!((monitor.winding(0) - 25.0).abs() < 1e-12 && monitor.winding(2).is_nan());
    }
}
