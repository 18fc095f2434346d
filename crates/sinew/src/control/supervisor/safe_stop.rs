use super::limits::Limits;
use super::signals::MuscleState;
use crate::control::arm::ArmGains;
use crate::drive::DriveCommand;
use alloc::vec;
use alloc::vec::Vec;

/// Brakes the winches, holds the pose, and releases all tension.
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
/// It needs no joint encoder, no model and no observer. Standing winches hold the limb by the stiffness and
/// the friction of the cables; then all anchors give way in proportion to their moment arms, so that the
/// joint that a cable carries sinks at most at the lowering speed, while the antagonists give way alike. A
/// drive that cannot be trusted is braked and stays so: its cable holds. A cable without a load cell is paid
/// out until all others are slack.
///
/// # Source
/// Our own.
#[derive(Debug, Clone)]
pub(super) struct SafeStop {
    speed: Vec<f64>,
    /// Whether a drive is to be braked: `[muscles]`.
    braked: Vec<bool>,
    /// Last readings of the load cells, N, and whether they are accepted: `[muscles]`.
    previous: Vec<f64>,
    measured: Vec<bool>,
    time: f64,
    /// Whether every cable that can be released is.
    pub(super) is_down: bool,
}

/// s: time in which a winch comes to its speed of lowering.
const EASING: f64 = 0.5;
/// s: time for which the tensions have to be low.
const SETTLED: f64 = 0.1;

impl SafeStop {
    pub(super) fn new(muscles: usize) -> Self {
        Self {
            speed: vec![0.0; muscles],
            braked: vec![false; muscles],
            previous: vec![f64::NAN; muscles],
            measured: vec![true; muscles],
            time: 0.0,
            is_down: false,
        }
    }

    /// Begins with the commands of the cycle before and the tensions that were accepted in it, N, NaN where a
    /// load cell was rejected: it is not used in the stop either. Where there is none, the tension that the
    /// motor's current tells is used.
    pub(super) fn begin(&mut self, gains: &ArmGains, drives: &[DriveCommand], accepted: &[f64]) {
        (self.time, self.is_down) = (0.0, false);
        self.braked.fill(false);
        self.previous.fill(f64::NAN);
        for ((measured, accepted), gains) in self.measured.iter_mut().zip(accepted).zip(&gains.muscles) {
            *measured = accepted.is_finite() || !gains.load_cell;
        }
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
        for (k, (previous, measured)) in self.previous.iter_mut().zip(&mut self.measured).enumerate() {
            let change = (tension[k] - core::mem::replace(previous, tension[k])).abs();
            let gains = &gains.muscles[k];
            *measured &= change.is_nan() || change <= gains.implausible_step(tension[k]) || !gains.load_cell;
        }
        let unknown = |k: usize| !self.measured[k] || tension[k].is_nan();
        let low = |k: usize| !unknown(k) && tension[k] <= gains.muscles[k].slack_tension;
        let all_low = (0..drives.len()).all(|k| self.braked[k] || low(k) || unknown(k));
        for (k, drive) in drives.iter_mut().enumerate() {
            if self.braked[k] {
                self.speed[k] = 0.0;
                *drive = DriveCommand::Brake;
                continue;
            }
            let (gains, limit) = (&gains.muscles[k], &limits.muscles[k]);
            let pays_out = lowering && !low(k) && !(unknown(k) && all_low);
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

#[cfg(test)]
mod tests {
    use super::*;

    /// s; a power of two, so that the times of cycles are exact.
    const H: f64 = 1.0 / 256.0;
    /// Tension of a cable that is tense, N.
    const TENSE: f64 = 100.0;

    /// Two muscles: deceleration 2 m/s^2, slack at 4 N; held for 0.5 s, let down at 10 mm/s for 2 s at most.
    struct Machine {
        stop: SafeStop,
        gains: ArmGains,
        limits: Limits,
    }

    impl Machine {
        fn stopped(drives: [DriveCommand; 2]) -> Self {
            let gains = ArmGains::for_tests(2, 1);
            let mut limits = Limits::of_gains(&gains);
            limits.muscles.iter_mut().for_each(|muscle| muscle.lowering_speed = 0.01);
            (limits.safety.holding_time, limits.safety.lowering_time) = (0.5, 2.0);
            let mut stop = SafeStop::new(2);
            stop.begin(&gains, &drives, &[0.0; 2]);
            Self { stop, gains, limits }
        }

        fn standing() -> Self {
            Self::stopped([DriveCommand::Velocity(0.0); 2])
        }

        /// Commands of a cycle.
        fn step(&mut self, tension: [f64; 2], received: bool) -> [DriveCommand; 2] {
            let mut drives = [DriveCommand::Off; 2];
            self.stop.step(H, (&self.gains, &self.limits), &tension, received, &mut drives);
            drives
        }

        /// Speeds of a cycle.
        fn speeds(&mut self, tension: [f64; 2]) -> [f64; 2] {
            self.step(tension, true).map(|drive| match drive {
                DriveCommand::Velocity(speed) => speed,
                other => panic!("{other:?}"),
            })
        }

        /// After some cycles.
        fn after(mut self, cycles: usize, tension: [f64; 2]) -> Self {
            for _ in 0..cycles {
                self.step(tension, true);
            }
            self
        }
    }

    /// Cycles until the pose is released.
    const HELD: usize = 128;

    #[test]
    fn winches_brake_at_their_deceleration_and_then_stand() {
        let mut machine = Machine::stopped([DriveCommand::Velocity(0.1), DriveCommand::Velocity(-0.05)]);
        for cycle in 1..=HELD {
            let braked = 2.0 * H * cycle as f64;
            let speeds = machine.speeds([TENSE; 2]);
            let expected = [(0.1 - braked).max(0.0), (braked - 0.05).min(0.0)];
            for (speed, expected) in speeds.iter().zip(expected) {
                assert!((speed - expected).abs() < 1e-12, "{cycle}: {speeds:?} {expected:?}");
            }
            assert!(!machine.stop.is_down);
        }
        assert_eq!([0, 1].map(|k| machine.stop.state(k)), [MuscleState::Tense; 2]);
    }

    #[test]
    fn a_drive_without_a_speed_or_with_one_that_is_no_number_is_one_that_stands() {
        let mut machine = Machine::stopped([DriveCommand::Velocity(f64::NAN), DriveCommand::Off]);
        assert_eq!(machine.step([TENSE; 2], true), [DriveCommand::Velocity(0.0); 2]);
    }

    #[test]
    fn after_the_holding_time_cables_are_paid_out_on_a_ramp_of_half_a_second() {
        let mut machine = Machine::standing().after(HELD, [TENSE; 2]);
        for cycle in 1..=256 {
            let expected = -0.01 * (H * f64::from(cycle) / 0.5).min(1.0);
            for speed in machine.speeds([TENSE; 2]) {
                assert!((speed - expected).abs() < 1e-12, "{cycle}: {speed} {expected}");
            }
            assert_eq!(machine.stop.state(0), MuscleState::LettingDown);
        }
    }

    #[test]
    fn a_load_cell_that_jumps_or_was_not_believed_counts_as_missing() {
        // It reads slack from one cycle to the next: its cable is paid out until the other is slack.
        let mut machine = Machine::standing().after(HELD + 200, [TENSE; 2]);
        let [jumped, _] = machine.speeds([2.0, TENSE]);
        assert!((jumped + 0.01).abs() < 1e-12, "{jumped}");
        let mut machine = Machine::standing();
        machine.stop.begin(&machine.gains, &[DriveCommand::Velocity(0.0); 2], &[f64::NAN, TENSE]);
        let mut machine = machine.after(HELD + 200, [2.0, TENSE]);
        let [unknown, _] = machine.speeds([2.0, TENSE]);
        assert!((unknown + 0.01).abs() < 1e-12 && !machine.stop.is_down, "{unknown}");
    }

    #[test]
    fn a_slack_cable_stops_at_once_while_the_others_are_let_down_until_all_are_slack() {
        let mut machine = Machine::standing().after(HELD + 200, [TENSE; 2]);
        for tension in (1..=9).map(|k| TENSE - 10.0 * f64::from(k)) {
            machine.speeds([tension, TENSE]);
        }
        // At the limit of a slack cable: 2 m/s^2 brake 10 mm/s within two cycles.
        machine.speeds([4.0, TENSE]);
        let [slack, tense] = machine.speeds([4.0, TENSE]);
        assert!(slack.abs() < 1e-12 && (tense + 0.01).abs() < 1e-12, "{slack} {tense}");
        assert_eq!(
            [0, 1].map(|k| machine.stop.state(k)),
            [MuscleState::Tense, MuscleState::LettingDown],
            "a winch that stands lets nothing down"
        );
        let [again, _] = machine.speeds([4.1, TENSE]);
        assert!(again < 0.0 && !machine.stop.is_down, "{again}");
        machine.speeds([3.0, 4.0]);
        assert!(machine.stop.is_down);
        assert_eq!([0, 1].map(|k| machine.stop.state(k)), [MuscleState::Relaxed; 2]);
        // What is released stays so: a load that pulls is not paid out for.
        let machine = &mut machine.after(100, [TENSE; 2]);
        assert!(machine.stop.is_down && machine.speeds([TENSE; 2]).iter().all(|speed| speed.abs() < 1e-12));
    }

    #[test]
    fn tensions_that_are_low_from_the_start_have_to_stay_so_for_a_tenth_of_a_second() {
        let mut machine = Machine::standing();
        let down = (1..400).find(|_| {
            assert!(machine.speeds([0.0; 2]).iter().all(|speed| speed.abs() < 1e-12));
            machine.stop.is_down
        });
        // The first cycle after 0.6 s.
        assert_eq!(down, Some(154));
    }

    #[test]
    fn without_readings_the_winches_stand_until_the_time_is_over() {
        for tension in [TENSE, 0.0, f64::NAN] {
            let mut machine = Machine::standing();
            let down = (1..1000).find(|_| {
                assert_eq!(machine.step([tension; 2], false), [DriveCommand::Velocity(0.0); 2]);
                machine.stop.is_down
            });
            // The first cycle after 2.5 s.
            assert_eq!(down, Some(641));
        }
        let mut machine = Machine::standing().after(HELD + 10, [TENSE; 2]);
        machine.step([TENSE; 2], false);
        assert_eq!(machine.step([TENSE; 2], false), [DriveCommand::Velocity(0.0); 2], "lost while let down");
    }

    #[test]
    fn a_cable_without_a_load_cell_is_paid_out_until_all_others_are_slack() {
        let mut machine = Machine::standing().after(HELD + 200, [f64::NAN, TENSE]);
        assert!(machine.speeds([f64::NAN, TENSE]).iter().all(|speed| (speed + 0.01).abs() < 1e-12));
        assert!(!machine.stop.is_down);
        machine.speeds([f64::NAN, 1.0]);
        let last = machine.speeds([f64::NAN, 1.0]);
        assert!(last.iter().all(|speed| speed.abs() < 1e-12) && machine.stop.is_down, "{last:?}");
        // The others are slack when lowering begins: it is not paid out at all.
        let mut machine = Machine::standing().after(HELD, [f64::NAN, 1.0]);
        assert!(machine.speeds([f64::NAN, 1.0]).iter().all(|speed| speed.abs() < 1e-12));
    }

    #[test]
    fn a_braked_drive_stays_braked_whatever_its_tension_and_the_others_are_let_down() {
        let mut machine = Machine::stopped([DriveCommand::Velocity(0.1), DriveCommand::Velocity(0.1)]);
        machine.stop.brake(0);
        // Of a muscle that there is not.
        machine.stop.brake(2);
        for _ in 0..HELD + 20 {
            assert_eq!(machine.step([TENSE; 2], true)[0], DriveCommand::Brake);
        }
        assert_eq!([0, 1].map(|k| machine.stop.state(k)), [MuscleState::Braked, MuscleState::LettingDown]);
        let mut machine = machine.after(60, [TENSE, 1.0]);
        assert!(machine.stop.is_down, "a braked drive is not waited for");
        assert_eq!(machine.stop.state(0), MuscleState::Braked);
        let mut drives = [DriveCommand::Off; 2];
        machine.stop.stand(&mut drives);
        assert_eq!(drives, [DriveCommand::Brake, DriveCommand::Velocity(0.0)]);
        machine.stop.release();
        machine.stop.stand(&mut drives);
        assert_eq!(drives, [DriveCommand::Velocity(0.0); 2]);
        // The brake has taken its speed.
        assert_eq!(machine.step([TENSE; 2], true)[0], DriveCommand::Velocity(0.0));
    }

    #[test]
    fn a_second_stop_begins_like_the_first() {
        let mut machine = Machine::standing();
        machine.stop.brake(1);
        let mut machine = machine.after(HELD + 100, [1.0; 2]);
        assert!(machine.stop.is_down);
        machine.stop.begin(
            &machine.gains,
            &[DriveCommand::Velocity(0.02), DriveCommand::Velocity(0.0)],
            &[0.0; 2],
        );
        assert!(!machine.stop.is_down);
        for cycle in 1..=HELD {
            let expected = (0.02 - 2.0 * H * cycle as f64).max(0.0);
            let [first, second] = machine.speeds([TENSE; 2]);
            assert!((first - expected).abs() < 1e-12 && second.abs() < 1e-12, "{cycle}: {first} {second}");
        }
        assert!(machine.speeds([TENSE; 2]).iter().all(|speed| *speed < 0.0), "released anew");
    }
}
