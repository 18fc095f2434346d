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

    /// Compares the measurements of one cycle, `h` s after the one before, with the limits; `tension_in` is that of the
    /// observers, N, where the controller runs.
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
            if tension.is_finite() {
                let over = tension > limit.tension;
                find(Fault::Overload(k), persist(&mut watched.overloaded_for, h, over, PERSISTENCE));
                if let Some(estimated) = tension_in {
                    let slack = watched.tension < limit.slack_tension
                        && estimated[k] < SLACK_ESTIMATE * limit.slack_tension;
                    find(Fault::Slack(k), persist(&mut watched.slack_for, h, slack, SLACK_PERSISTENCE));
                }
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
            let share = (h / FILTER).min(1.0);
            self.tension =
                if self.tension.is_nan() { tension } else { self.tension + share * (tension - self.tension) };
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
