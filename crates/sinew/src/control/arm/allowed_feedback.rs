use super::margins::WinchLag;
use crate::machine::{Characteristics, ControlRules};
use alloc::vec::Vec;

/// Feedback of one muscle that the damping of its joints and the control cycle allow.
///
/// ```text
/// eta_k = (zeta_c + zeta_k)/(|W(i Om_k)| sin phi(Om_k))
/// f_k   = min(1, min_j eta_j/eta_0)            j: k, and the muscles that share a joint with it
/// l_k   = min(f_k^2 lambda, 2 (g_0 t_v/(T rho_k) - kappa)),   rho_k = min(1, (Om_k T/pi)^2)
/// K_k   = f_k max(K_0, 0.17 min_j Om_j)
/// ```
///
/// | symbol | meaning                                                                     | unit |
/// |--------|-----------------------------------------------------------------------------|------|
/// | zeta_k, Om_k | [`MuscleCharacteristics`](crate::machine::MuscleCharacteristics)        | 1, rad/s |
/// | W, phi | response of a winch to its command, [`WinchLag`], and its lag              | 1, rad |
/// | zeta_c | damping that a sliding cable itself has, [`CABLE_DAMPING`]                  | 1    |
/// | eta_0, K_0, g_0 | [`ENOUGH`], [`SLOW_CORRECTION`], [`STEP`]                          | 1, rad/s, 1 |
/// | kappa, lambda, T, t_v | position gain, compensation of the dead band, period, time constant of a winch | 1, s |
///
/// A winch that answers a displacement of its anchor with the lag `phi` does work on the motion: the
/// compensation of the dead band, which is up to `lambda/2` beyond the position gain, and the correction by
/// the load cell, where the model's compliance is off. What is lost in the joints has to exceed it. A cable
/// that sticks dissipates more, one that slides does not. Where an anchor follows its winch within a cycle,
/// feedback corrects `g = (kappa + lambda/2) T/t_v` of a displacement per cycle, and near `g = 1` anchor and
/// winch oscillate at half the sampling frequency. `rho_k` tells how far the anchor follows there.
///
/// # Source
/// Our own: hands drawn at random with and without friction in their joints, on pulleys of 5 to 12 mm, and
/// machines of `models/` at 0.5 to 10 ms.
#[derive(Debug, Clone, Copy)]
pub(super) struct AllowedFeedback {
    /// `l_k`, 1: compensation of the dead band; `lambda` for all but lightly damped joints and long cycles.
    pub(super) backlash_gain: f64,
    /// `K_k`, 1/s: largest rate at which the load cell corrects the stretch of the cable.
    pub(super) correction: f64,
}

/// Of every muscle, for these rules at a period, s: `[muscles]`.
pub(super) fn allowed_feedback(
    found: &Characteristics,
    winch: &WinchLag,
    rules: &ControlRules,
    period: f64,
) -> Vec<AllowedFeedback> {
    let (m, n) = (found.muscles.len(), found.joints.len());
    let reserve = |k: usize| {
        let muscle = &found.muscles[k];
        let work = winch.magnitude(muscle.mode) * libm::sin(winch.lag(muscle.mode));
        (CABLE_DAMPING + muscle.damping_ratio) / work.max(LEAST_WORK)
    };
    let crosses = |k: usize, joint: usize| found.arms[k * n + joint] > 0.0;
    let share = |k: usize, j: usize| (0..n).any(|joint| crosses(k, joint) && crosses(j, joint));
    let least = |k: usize, of: &dyn Fn(usize) -> f64| {
        (0..m).filter(|&j| share(k, j)).map(of).fold(f64::INFINITY, f64::min)
    };
    let in_a_cycle = |k: usize| {
        let turns = found.muscles[k].mode * period / core::f64::consts::PI;
        let step = STEP * winch.time_constant / (period * (turns * turns).min(1.0));
        (2.0 * (step - rules.position_gain)).max(0.0)
    };
    let allowed = |k: usize| {
        let fraction = (least(k, &reserve) / ENOUGH).min(1.0);
        let slowest = least(k, &|j| found.muscles[j].mode);
        AllowedFeedback {
            backlash_gain: (fraction * fraction * rules.backlash_gain).min(in_a_cycle(k)),
            correction: fraction * SLOW_CORRECTION.max(OF_MODE * slowest),
        }
    };
    (0..m).map(allowed).collect()
}

/// `zeta_c`.
const CABLE_DAMPING: f64 = 0.01;
/// `eta_0`.
const ENOUGH: f64 = 0.2;
/// `g_0`.
const STEP: f64 = 0.4;
/// `K_0`, rad/s: that of arms and legs on soft cables.
const SLOW_CORRECTION: f64 = 18.0;
/// `K/Om`.
const OF_MODE: f64 = 0.17;
/// A winch that lags by half a turn or more does no work on the motion.
const LEAST_WORK: f64 = 1e-3;

#[cfg(test)]
mod tests {
    use super::*;
    use crate::machine::{JointCharacteristics, MuscleCharacteristics};
    use alloc::vec;

    /// Three muscles: the first two share a joint, the third has one of its own.
    fn of(damping: [f64; 3], mode: f64, period: f64) -> [AllowedFeedback; 3] {
        let muscle =
            |damping_ratio| MuscleCharacteristics { mode, damping_ratio, ..MuscleCharacteristics::default() };
        let found = Characteristics {
            muscles: damping.map(muscle).to_vec(),
            joints: vec![JointCharacteristics::default(); 2],
            arms: vec![0.01, 0.0, 0.01, 0.0, 0.0, 0.01],
            interaction: Vec::new(),
            stuck_mode: 0.0,
            damping_rate: 0.0,
        };
        let winch = WinchLag { time_constant: 5.6e-3, dead_time: 1.5e-3 };
        allowed_feedback(&found, &winch, &ControlRules::default(), period).try_into().unwrap()
    }

    /// Fraction of the compensation of the dead band that is allowed.
    fn fraction(allowed: AllowedFeedback) -> f64 {
        libm::sqrt(allowed.backlash_gain / ControlRules::default().backlash_gain)
    }

    #[test]
    fn muscles_of_lightly_damped_joints_get_less_in_proportion_and_others_all() {
        let fractions = |damping: [f64; 3]| of(damping, 100.0, 1e-3).map(fraction);
        assert!(fractions([0.3; 3]).iter().all(|f| (f - 1.0).abs() < 1e-12));
        let [first, second, third] = fractions([0.0, 0.3, 0.3]);
        assert!(first < 0.1 && (first - second).abs() < 1e-12 && (third - 1.0).abs() < 1e-12);
        let twice = fractions([0.01, 0.3, 0.3])[0];
        assert!((twice / first - 2.0).abs() < 1e-9, "{twice} {first}");
    }

    #[test]
    fn motions_that_winches_follow_or_cannot_follow_need_less_damping() {
        let at = |mode| fraction(of([0.02; 3], mode, 1e-3)[0]);
        assert!(at(100.0) < at(20.0) && at(100.0) < at(400.0), "{} {} {}", at(20.0), at(100.0), at(400.0));
        assert!((at(2000.0) - 1.0).abs() < 1e-12);
    }

    #[test]
    fn the_load_cell_corrects_more_slowly_than_the_softest_motion_and_less_with_little_damping() {
        let rate = |damping, mode| of([damping; 3], mode, 1e-3)[0].correction;
        assert!((rate(1.0, 30.0) - 18.0).abs() < 1e-12 && (rate(1.0, 400.0) - 68.0).abs() < 1e-12);
        assert!(rate(0.01, 100.0) < 3.0);
    }

    #[test]
    fn an_anchor_that_follows_within_a_cycle_gets_less_compensation_a_slow_one_all() {
        let at = |mode, period| fraction(of([1.0; 3], mode, period)[0]);
        assert!((at(100.0, 4e-3) - 1.0).abs() < 1e-12 && (at(700.0, 1e-3) - 1.0).abs() < 1e-12);
        assert!(at(700.0, 3e-3) < 0.7 && at(700.0, 20e-3) < at(700.0, 3e-3));
    }
}
