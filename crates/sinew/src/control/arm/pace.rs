use crate::machine::{ControlRules, DEFAULT_PERIOD, Machine, dead_time};

/// The rules' constants at the period of a machine: what the rules ask for, as far as samples a period apart
/// and commands that come late allow.
///
/// ```text
/// D   = min(T, 1 ms) + T/2 + t_d,   s = max(D/D_0, 1)
/// c_T = c/s,   k_T = k w_T/w,   w_T = min(w, w_o,T/3) where w_o,T < w_o,   t_v = s 5.6 ms,   w_o,T = min(w_o, 0.29/T),   r = clip(0.3132/(w_o,T T), 1, 5.4) for T > 1 ms
/// ```
///
/// | symbol | meaning                                                                     | unit  |
/// |--------|-----------------------------------------------------------------------------|-------|
/// | T, t_d | period of the control cycle, longest transport delay of the drives' readings    | s     |
/// | D, D_0 | [`dead_time`]; that of a millisecond without transport, with which the rules were found | s |
/// | s      | how much slower the loops of the winches are, so that their phases stay           | 1     |
/// | c, k, w, w_o | [`ControlRules`]                                                           | rad/s |
/// | t_v    | time constant of a winch's travel                                             | s     |
/// | r      | largest growth of the bandwidth of the joints' observers                      | 1     |
///
/// # Source
/// An observer of three equal poles with explicit innovations is unstable above `w T = 0.53`. The rest:
/// random machines at 1 to 10 ms.
#[derive(Debug, Clone, Copy, PartialEq)]
pub(super) struct Pace {
    pub(super) rules: ControlRules,
    /// `T`, s.
    pub(super) period: f64,
    /// `t_v`, s.
    pub(super) stretch_time_constant: f64,
    /// `r`, 1.
    pub(super) max_bandwidth_ratio: f64,
}

/// `t_v` of a millisecond, s.
const STRETCH_TIME: f64 = 0.0056;
/// `w_o T`, and that of the fastest observer.
pub(super) const OBSERVER_STEP: f64 = 0.29;
const FASTEST_STEP: f64 = 0.3132;
/// Least `w_o,T/w` where the period lowers the former.
pub(super) const MIN_OBSERVER_RATIO: f64 = 3.0;
/// `r`.
const MAX_BANDWIDTH_RATIO: f64 = 5.4;

impl Pace {
    pub(super) fn from_machine(machine: &Machine) -> Self {
        Self::new(&machine.rules, machine.period, machine.transport_delay())
    }

    /// At a period and with a transport delay, s.
    pub(super) fn new(rules: &ControlRules, period: f64, transport: f64) -> Self {
        let slower = (dead_time(period, transport) / dead_time(DEFAULT_PERIOD, 0.0)).max(1.0);
        let observer_bandwidth = rules.observer_bandwidth.min(OBSERVER_STEP / period);
        let bandwidth = match observer_bandwidth < rules.observer_bandwidth {
            true => rules.bandwidth.min(observer_bandwidth / MIN_OBSERVER_RATIO),
            false => rules.bandwidth,
        };
        let ratio = if period > DEFAULT_PERIOD {
            (FASTEST_STEP / (observer_bandwidth * period)).clamp(1.0, MAX_BANDWIDTH_RATIO)
        } else {
            MAX_BANDWIDTH_RATIO
        };
        Self {
            rules: ControlRules {
                bandwidth,
                observer_bandwidth,
                damping_crossover: rules.damping_crossover / slower,
                end_point_integral: rules.end_point_integral * bandwidth / rules.bandwidth,
                ..*rules
            },
            period,
            stretch_time_constant: STRETCH_TIME * slower,
            max_bandwidth_ratio: ratio,
        }
    }
}
