use super::limits::Limits;
use super::signals::MuscleState;
use crate::control::arm::ArmGains;
use crate::drive::DriveCommand;
use alloc::vec;
use alloc::vec::Vec;

/// Brakes the winches, holds the pose, and lets all cables down.
///
/// ```text
/// braking    v -> 0 at a_s
/// holding    v = 0                                     until t_h after the beginning
/// lowering   v -> -v_l at v_l/t_a while T > T_p, else 0   until every T <= T_p, at most for t_l
/// ```
///
/// | symbol | meaning                                                                       | unit  |
/// |--------|-------------------------------------------------------------------------------|-------|
/// | v, T   | commanded speed of a winch, tension at its outlet                               | m/s, N |
/// | a_s, T_p | [`MuscleGains`](crate::control::arm::MuscleGains): deceleration, tension below which a drive does not pay out | m/s^2, N |
/// | v_l    | speed of the anchor at the lowering speed of the joint on which it acts most    | m/s   |
/// | t_h, t_l | [`SafetyLimits`](crate::machine::SafetyLimits)                                | s     |
/// | t_a    | [`EASING`]                                                                      | s     |
///
/// It needs no joint encoder, no model and no observer. Standing winches hold the limb by the stiffness and the friction
/// of the cables; then all anchors give way in proportion to their moment arms, so that the joint that a cable carries
/// sinks at most at the lowering speed, while the antagonists give way alike. A drive that cannot be trusted is braked and
/// stays so: its cable holds. A cable without a load cell is paid out until all others are slack.
///
/// # Source
/// Our own.
#[derive(Debug, Clone)]
pub(super) struct SafeStop {
    speed: Vec<f64>,
    /// Whether a drive is to be braked: `[muscles]`.
    braked: Vec<bool>,
    time: f64,
    /// Whether every cable that can be let down is.
    pub(super) is_down: bool,
}

/// s: time in which a winch comes to its speed of lowering.
const EASING: f64 = 0.5;
/// s: time for which the tensions have to be low.
const SETTLED: f64 = 0.1;

impl SafeStop {
    pub(super) fn new(muscles: usize) -> Self {
        Self { speed: vec![0.0; muscles], braked: vec![false; muscles], time: 0.0, is_down: false }
    }

    /// Begins with the commands of the cycle before.
    pub(super) fn begin(&mut self, drives: &[DriveCommand]) {
        (self.time, self.is_down) = (0.0, false);
        self.braked.fill(false);
        for (speed, drive) in self.speed.iter_mut().zip(drives) {
            *speed = match drive {
                DriveCommand::Velocity(speed) if speed.is_finite() => *speed,
                _ => 0.0,
            };
        }
    }

    /// A drive that is braked from now on.
    pub(super) fn brake(&mut self, muscle: usize) {
        if let Some(braked) = self.braked.get_mut(muscle) {
            *braked = true;
        }
    }

    /// No drive is braked any more.
    pub(super) fn release(&mut self) {
        self.braked.fill(false);
    }

    /// Commands of a machine that stands; braked drives stay braked.
    pub(super) fn stand(&self, drives: &mut [DriveCommand]) {
        for (drive, braked) in drives.iter_mut().zip(&self.braked) {
            *drive = if *braked { DriveCommand::Brake } else { DriveCommand::Velocity(0.0) };
        }
    }

    /// Commands of `h` s with the tensions at the drives, N, NaN where they are not measured.
    ///
    /// `received` tells whether readings came: without any the winches stand.
    pub(super) fn step(
        &mut self,
        h: f64,
        (gains, limits): (&ArmGains, &Limits),
        tension: &[f64],
        received: bool,
        drives: &mut [DriveCommand],
    ) {
        self.time += h;
        let safety = &limits.safety;
        let lowering = self.time > safety.holding_time && received && !self.is_down;
        let low = |k: usize| tension[k] <= gains.muscles[k].slack_tension;
        let all_low = (0..drives.len()).all(|k| self.braked[k] || low(k) || tension[k].is_nan());
        for (k, drive) in drives.iter_mut().enumerate() {
            if self.braked[k] {
                self.speed[k] = 0.0;
                *drive = DriveCommand::Brake;
                continue;
            }
            let (gains, limit) = (&gains.muscles[k], &limits.muscles[k]);
            let pays_out = lowering && !low(k) && !(tension[k].is_nan() && all_low);
            let target = if pays_out { -limit.lowering_speed } else { 0.0 };
            let rate = if self.time > safety.holding_time {
                limit.lowering_speed / EASING
            } else {
                gains.stop_deceleration
            };
            let most = h * rate.max(if target == 0.0 { gains.stop_deceleration } else { 0.0 });
            self.speed[k] += (target - self.speed[k]).clamp(-most, most);
            *drive = DriveCommand::Velocity(self.speed[k]);
        }
        let settled = self.time > safety.holding_time + SETTLED;
        self.is_down |=
            (settled && received && all_low) || self.time > safety.holding_time + safety.lowering_time;
    }

    /// State of a muscle.
    pub(super) fn state(&self, muscle: usize) -> MuscleState {
        match (self.braked[muscle], self.is_down, self.speed[muscle] < 0.0) {
            (true, ..) => MuscleState::Braked,
            (_, true, _) => MuscleState::Relaxed,
            (.., true) => MuscleState::LettingDown,
            _ => MuscleState::Tense,
        }
    }
}
