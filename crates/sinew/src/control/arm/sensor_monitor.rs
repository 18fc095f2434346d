use super::status::Symptom;

/// Plausibility of one sensor: finite values, bounded rate of change, no frozen output.
///
/// ```text
/// accepted:   |y - y_a| <= v_max (h + t_r)   and   |s| <= e_max,   s = (s + e)(1 - h/t_f) since y last changed
/// ```
///
/// | symbol | meaning                                                              | unit            |
/// |--------|----------------------------------------------------------------------|-----------------|
/// | y, y_a | measurement, last accepted measurement                                | of the sensor   |
/// | v_max  | largest rate of change                                                | per s           |
/// | t_r    | time for which measurements have been rejected                         | s               |
/// | e      | change expected between two samples, from the other side of its loop   | as `e_max`      |
/// | e_max  | largest expected change with unchanged output                        | see [`SensorLimits`] |
/// | t_f    | time in which expected changes are forgotten: friction may hold a creeping drive | s    |
///
/// The first measurement is compared with an initial value, within `y_0`, instead.
#[derive(Debug, Clone, Copy)]
pub(super) struct SensorMonitor {
    limits: SensorLimits,
    /// `y_a`, at first the initial value.
    accepted: f64,
    /// `t_r`, s.
    pub(super) rejected_for: f64,
    /// Whether the output has been bit-identical since the sample before.
    unchanged: bool,
    /// Expected change in that time.
    expected_change: f64,
    previous: f64,
    /// Whether it was rejected because its output was unchanged.
    stood: bool,
    /// Time for which the output has been bit-identical, s.
    same_for: f64,
    started: bool,
}

/// Limits of a [`SensorMonitor`].
#[derive(Debug, Clone, Copy)]
pub(super) struct SensorLimits {
    /// `y_0`, largest deviation of the first measurement from the initial value.
    pub(super) initial_deviation: f64,
    /// `v_max`, per s.
    pub(super) max_rate: f64,
    /// `e_max`.
    pub(super) max_unchanged: f64,
    /// `t_f`, s.
    pub(super) forgetting_time: f64,
}

/// s: tolerance of times that are sums of cycles.
const ROUNDING: f64 = 1e-9;

impl SensorMonitor {
    pub(super) fn new(limits: SensorLimits) -> Self {
        Self {
            limits,
            accepted: 0.0,
            rejected_for: 0.0,
            unchanged: false,
            expected_change: 0.0,
            previous: 0.0,
            stood: false,
            same_for: 0.0,
            started: false,
        }
    }

    /// Whether a measurement, `h` s after the one before, is accepted; `expected` is the change expected
    /// since then.
    pub(super) fn update(&mut self, h: f64, measured: f64, expected: f64) -> bool {
        self.unchanged = measured.to_bits() == self.previous.to_bits();
        self.same_for = if self.unchanged { self.same_for + h } else { 0.0 };
        let kept = 1.0 - h / self.limits.forgetting_time;
        self.expected_change = if self.unchanged { (self.expected_change + expected) * kept } else { 0.0 };
        self.previous = measured;
        let largest = if core::mem::replace(&mut self.started, true) {
            self.limits.max_rate * (h + self.rejected_for)
        } else {
            self.limits.initial_deviation
        };
        let continuous = (measured - self.accepted).abs() <= largest;
        let moving = self.expected_change.abs() <= self.limits.max_unchanged;
        let accepted = continuous && moving;
        if accepted {
            (self.accepted, self.rejected_for) = (measured, 0.0);
        } else {
            if self.rejected_for == 0.0 {
                self.stood = continuous;
            }
            self.rejected_for += h;
        }
        accepted
    }

    /// The next measurement is the first.
    pub(super) fn restart(&mut self) {
        *self = Self::new(self.limits);
    }

    /// How it behaves while it is rejected.
    pub(super) fn symptom(&self) -> Symptom {
        Symptom::of_reading(self.previous, self.stood)
    }

    /// The latest measurement.
    pub(super) fn previous(&self) -> f64 {
        self.previous
    }

    /// Whether the output has been the same for this time, s.
    pub(super) fn has_stood_for(&self, time: f64) -> bool {
        self.same_for >= time - ROUNDING
    }

    /// Whether the output changed with the last sample.
    pub(super) fn has_changed(&self) -> bool {
        !self.unchanged
    }
}

#[cfg(test)]
mod tests {
    use super::*;

    const LIMITS: SensorLimits =
        SensorLimits { initial_deviation: 0.5, max_rate: 10.0, max_unchanged: 0.012, forgetting_time: 1.0 };

    #[test]
    fn the_rate_limit_holds_for_any_control_cycle_and_widens_with_the_time_of_rejection() {
        for h in [1e-4, 1e-3, 1e-2] {
            let mut monitor = SensorMonitor::new(LIMITS);
            assert!(monitor.update(h, 0.4, 0.0) && monitor.update(h, 0.4 + 9.9 * h, 0.0));
            assert!(!monitor.update(h, 0.4 + 20.1 * h, 0.0));
            assert!((monitor.rejected_for - h).abs() < 1e-15);
            // Two cycles after the last accepted value the same value is within the limit.
            assert!(monitor.update(h, 0.4 + 20.2 * h, 0.0) && monitor.rejected_for.abs() < 1e-15);
        }
        let mut monitor = SensorMonitor::new(LIMITS);
        assert!(!monitor.update(1e-3, f64::NAN, 0.0) && !monitor.update(1e-3, 0.6, 0.0));
    }

    #[test]
    fn an_output_unchanged_over_more_than_the_expected_change_is_rejected() {
        let mut monitor = SensorMonitor::new(LIMITS);
        assert!(monitor.update(1e-3, 0.1, 1.0));
        // Motion back and forth cancels.
        assert!(monitor.update(1e-3, 0.1, 0.011) && monitor.update(1e-3, 0.1, -0.011));
        assert!(monitor.update(1e-3, 0.1, 0.011) && !monitor.update(1e-3, 0.1, 0.011));
        assert!(monitor.update(1e-3, 0.101, 0.011) && monitor.has_changed());
        // So does motion slower than e_max/t_f.
        assert!((0..10_000).all(|_| monitor.update(1e-3, 0.101, 1.1e-5)));
        assert!(!(0..10_000).all(|_| monitor.update(1e-3, 0.101, 1.3e-5)));
    }

    #[test]
    fn slow_motion_is_forgotten_in_the_forgetting_time_whatever_it_is() {
        // With e in every cycle the sum settles at e (t_f/h - 1).
        for (forgetting_time, h) in [(0.25, 1e-3), (2.0, 1e-3), (0.25, 2e-3)] {
            let cycles = forgetting_time / h - 1.0;
            for (fraction, accepted) in [(0.98, true), (1.02, false)] {
                let mut monitor = SensorMonitor::new(SensorLimits { forgetting_time, ..LIMITS });
                let expected = fraction * LIMITS.max_unchanged / cycles;
                let all = (0..20_000).all(|_| monitor.update(h, 0.1, expected));
                assert_eq!(all, accepted, "{forgetting_time} {h} {fraction}");
            }
        }
        // Nothing is forgotten where the time is infinite.
        let mut monitor = SensorMonitor::new(SensorLimits { forgetting_time: f64::INFINITY, ..LIMITS });
        // The first sample, and 13 equal ones.
        assert!((0..14).all(|_| monitor.update(1e-3, 0.1, 0.9e-3)));
        assert!(!monitor.update(1e-3, 0.1, 0.9e-3));
    }

    #[test]
    fn the_symptom_is_that_of_the_first_rejected_sample_until_a_sample_is_accepted() {
        let mut stuck = SensorMonitor::new(LIMITS);
        assert!(stuck.update(1e-3, 0.1, 0.0) && !stuck.update(1e-3, 0.1, 0.02));
        assert_eq!(stuck.symptom(), Symptom::Stuck);
        assert!(!stuck.update(1e-3, 0.1, 0.02));
        assert_eq!(stuck.symptom(), Symptom::Stuck);
        let mut jumped = SensorMonitor::new(LIMITS);
        assert!(jumped.update(1e-3, 0.1, 0.0) && !jumped.update(1e-3, 0.3, 0.0));
        assert_eq!(jumped.symptom(), Symptom::Jumped);
        // It came back, and stands: rejected without a break, still a jump.
        assert!(!jumped.update(1e-3, 0.3, 0.1));
        assert_eq!(jumped.symptom(), Symptom::Jumped);
        let mut returned = jumped;
        assert!(returned.update(1e-3, 0.1, 0.0) && returned.rejected_for.abs() < 1e-18);
        assert!(!returned.update(1e-3, 0.1, 0.02));
        assert_eq!(returned.symptom(), Symptom::Stuck);
        assert!(!jumped.update(1e-3, f64::NAN, 0.0));
        assert_eq!(jumped.symptom(), Symptom::Lost);
    }

    #[test]
    fn the_time_of_equal_samples_counts_from_the_last_change_whatever_their_period() {
        for h in [5e-4, 1e-3, 4e-3] {
            let mut monitor = SensorMonitor::new(LIMITS);
            for (k, y) in [0.1, 0.1, 0.1, 0.1, 0.101, 0.101].into_iter().enumerate() {
                monitor.update(h, y, 0.0);
                let same = [0.0, h, 2.0 * h, 3.0 * h, 0.0, h][k];
                assert!(monitor.has_stood_for(same) && !monitor.has_stood_for(same + 0.5 * h), "{k}");
                assert_eq!(monitor.has_changed(), same == 0.0);
            }
        }
    }

    #[test]
    fn a_restarted_monitor_judges_as_a_new_one() {
        let mut used = SensorMonitor::new(LIMITS);
        for k in 0..20 {
            used.update(1e-3, if k < 5 { 0.45 } else { 0.3 }, 0.003);
        }
        assert!(used.rejected_for > 0.0);
        used.restart();
        let mut new = SensorMonitor::new(LIMITS);
        for y in [0.3, 0.3, 0.302, 0.302, 0.302, 0.302, 0.302, 0.9] {
            assert_eq!(used.update(1e-3, y, 0.003), new.update(1e-3, y, 0.003), "{y}");
            assert_eq!((used.symptom(), used.has_changed()), (new.symptom(), new.has_changed()));
            assert!((used.rejected_for - new.rejected_for).abs() < 1e-18);
        }
    }
}
