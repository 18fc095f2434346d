use super::super::open_loop::{Corrected, OpenLoopCables};
use super::*;
use crate::muscle::tests::robots::lever;
use crate::predictor::{CableModel, CableObservers, CableSample};

/// s: control cycle, and time between two evaluations.
const H: f64 = 1e-3;
const DT: f64 = 8e-3;
/// N/m, N, N: stiffness of the cables, tensions at their drives and at their anchors.
const STIFFNESS: f64 = 25e3;
const NEAR: f64 = 50.0;
const FAR: f64 = 30.0;

/// N, by which a reading changes in a cycle: what a winch can do.
const RAMP: f64 = 5.0;

/// [`lever`], evaluated.
fn body() -> MuscleDynamics {
    let mut body = MuscleDynamics::new(&lever()).unwrap();
    body.evaluate(&[0.2]).unwrap();
    body
}

/// A copy of the observers of two cables, whose tensions are [`NEAR`] and [`FAR`].
fn copy() -> Copied {
    let models = vec![CableModel::bench(); 2];
    let observers = CableObservers::new(&models).unwrap();
    let mut cables = OpenLoopCables::new(&models, 1).unwrap();
    let corrected =
        Corrected { observers: &observers, unexplained: &[0.0; 2], pose: &[0.2], disturbance_torque: &[0.0] };
    for _ in 0..2100 {
        cables.step(H, &[CableSample::default(); 2], &corrected, true).unwrap();
    }
    let mut copy = cables.used().unwrap().clone();
    copy.tension_in.fill(NEAR);
    copy.tension_out.fill(FAR);
    copy
}

/// A lever at rest. Estimates follow load cells as long as these are used.
struct Rig {
    isolation: Isolation,
    body: MuscleDynamics,
    copy: Copied,
    /// N, by which the load cells come to read more than the copy estimates, at [`RAMP`], and by which that
    /// raises the far estimates.
    offset: [f64; 2],
    reading: [f64; 2],
    far_offset: [f64; 2],
    /// Torque that the joint has beside that of the estimates, Nm.
    torque: f64,
}

impl Rig {
    fn new() -> Self {
        let isolation = Isolation::new(&[STIFFNESS; 2], &ArmGains::for_tests(2, 1));
        let (body, copy) = (body(), copy());
        let none = [0.0; 2];
        let mut rig =
            Self { isolation, body, copy, offset: none, reading: none, far_offset: none, torque: 0.0 };
        assert_eq!(rig.finding(2.0), None);
        rig
    }

    fn arm(&self, muscle: usize) -> f64 {
        self.body.crossings(muscle).next().unwrap().1
    }

    /// The cycles until the next evaluation, and that.
    fn evaluate(&mut self) -> Finding {
        let used = |rig: &Self, of: [f64; 2]| {
            [0, 1].map(|k| if rig.isolation.bridged(k).is_none() { of[k] } else { 0.0 })
        };
        for _ in 0..8 {
            for k in 0..2 {
                self.reading[k] += (self.offset[k] - self.reading[k]).clamp(-RAMP, RAMP);
                let estimate = NEAR + used(self, self.reading)[k];
                self.isolation.check(k, H, NEAR + self.reading[k], estimate, &[0.2]);
            }
        }
        let followed = used(self, self.reading);
        self.isolation.evaluate(
            DT,
            &Seen {
                body: &self.body,
                tension: &self.reading.map(|offset| NEAR + offset),
                tension_in: &followed.map(|offset| NEAR + offset),
                tension_out: &used(self, self.far_offset).map(|offset| FAR + offset),
                unexplained: &followed.map(|offset| offset / STIFFNESS),
                known: &[true; 2],
                pose: &[0.2],
                joint_innovation: &[0.0],
                disturbance_torque: &[self.torque],
                copy: Some(&self.copy),
            },
        )
    }

    /// The first finding within some seconds, and when, s.
    fn finding(&mut self, seconds: f64) -> Option<(f64, Finding)> {
        let mut time = 0.0;
        while time < seconds {
            time += DT;
            let found = self.evaluate();
            if found != Finding::Nothing {
                return Some((time, found));
            }
        }
        None
    }
}

/// Whether a reading that steps by `step` N and stays there is used in its first cycle, and the rig.
fn stepped(step: f64) -> (bool, Rig) {
    let mut rig = Rig::new();
    let used = rig.isolation.check(1, H, NEAR + step, NEAR, &[0.2]);
    (used, rig)
}

#[test]
fn a_reading_that_steps_further_than_a_winch_can_pull_is_not_used_until_it_agrees_again() {
    for step in [40.0, -40.0] {
        let (used, mut rig) = stepped(step);
        assert!(!used);
        assert_eq!(rig.isolation.bridged(1), Some((Fault::TensionSensor(1), Symptom::Jumped)));
        assert_eq!(rig.isolation.bridged(0), None);
        let mut check = |tension: f64| rig.isolation.check(1, H, tension, NEAR, &[0.2]);
        assert!((0..500).all(|_| !check(NEAR + step)));
        let cycles = (0..500).take_while(|_| !check(NEAR)).count();
        assert!((59..=62).contains(&cycles), "{cycles}");
        // The next time it has to agree for twice as long.
        assert!(!check(NEAR + step));
        let cycles = (0..500).take_while(|_| !check(NEAR)).count();
        assert!((118..=123).contains(&cycles), "{cycles}");
    }
    // 8 s + 0.3 F + K 0.1 mm are 20.7 N.
    assert!(stepped(18.0).0 && stepped(-18.0).0);
}

#[test]
fn a_cell_whose_noise_has_grown_five_times_is_noisy_one_with_its_own_noise_and_a_ramp_are_not() {
    let found = |h: f64, factor: f64, slope: f64| {
        let mut rig = Rig::new();
        let mut random = crate::random::Random::new(7);
        (0..3000).find_map(|k| {
            let estimated = NEAR + slope * h * f64::from(k);
            let tension = estimated + factor * 0.4 * random.normal();
            rig.isolation.check(0, h, tension, estimated, &[0.2]);
            rig.isolation.bridged(0).map(|(_, symptom)| symptom)
        })
    };
    let noisy = |factor, slope| found(H, factor, slope) == Some(Symptom::Noisy);
    assert!(noisy(10.0, 0.0) && noisy(20.0, 100.0));
    assert!(!noisy(1.0, 0.0) && !noisy(2.5, 0.0) && !noisy(1.0, 2e3));
    // Four times as much in four milliseconds.
    assert_eq!(found(4.0 * H, 10.0, 0.0), None);
    assert!(found(4.0 * H, 40.0, 0.0).is_some());
}

#[test]
fn a_correction_that_the_joint_does_not_feel_is_that_of_a_load_cell_one_that_it_feels_of_a_motor_encoder() {
    for (muscle, side) in [(0, 1.0), (1, -1.0)] {
        let deviating = |felt: f64| {
            let mut rig = Rig::new();
            rig.offset[muscle] = side * 60.0;
            rig.far_offset[muscle] = side * 25.0;
            while rig.isolation.is_quiet() {
                assert_eq!(rig.evaluate(), Finding::Nothing);
            }
            // The anchor lacks what is estimated by a false cell.
            rig.torque = -rig.arm(muscle) * (1.0 - felt) * side * 25.0;
            rig.finding(3.0)
        };
        let (time, found) = deviating(0.0).unwrap();
        assert_eq!(found, Finding::Bridge(muscle));
        assert!((0.08..0.2).contains(&time), "{time}");
        let (time, found) = deviating(1.0).unwrap();
        assert!(
            matches!(found, Finding::Stop(Fault::MotorSensor(k) | Fault::MotorOrJointSensor(k)) if k == muscle),
            "{found:?}"
        );
        assert!((0.15..0.4).contains(&time), "{time}");
    }
}

#[test]
fn corrections_of_all_muscles_in_proportion_to_their_moment_arms_are_those_of_the_joints_encoder() {
    let mut rig = Rig::new();
    let angle = 60.0 / (STIFFNESS * rig.arm(0));
    rig.offset = [0, 1].map(|k| STIFFNESS * rig.arm(k) * angle);
    let (time, found) = rig.finding(3.0).unwrap();
    assert_eq!(found, Finding::Stop(Fault::JointSensor(0)));
    assert!((0.1..0.3).contains(&time), "{time}");
}

#[test]
fn a_correction_without_a_change_at_the_anchor_is_of_a_group_until_the_joint_tells() {
    for cell_is_right in [false, true] {
        let mut rig = Rig::new();
        rig.offset[1] = 60.0;
        let (time, found) = rig.finding(3.0).unwrap();
        assert!(found == Finding::Bridge(1) && (0.3..0.4).contains(&time), "{found:?} {time}");
        let group = Some((Fault::TensionOrMotorSensor(1), Symptom::Deviating));
        assert_eq!(rig.isolation.bridged(1), group);
        // What the cell reads arrives at the anchor once it moves.
        rig.torque = if cell_is_right { rig.arm(1) * 40.0 } else { 0.0 };
        let found = rig.finding(2.0).map(|(_, found)| found);
        if cell_is_right {
            assert_eq!(found, Some(Finding::Stop(Fault::MotorSensor(1))));
        } else {
            assert_eq!(found, None);
            assert_eq!(rig.isolation.bridged(1), group);
            // It agrees again, and is used again.
            rig.offset[1] = 0.0;
            assert_eq!(rig.finding(0.6), None);
            assert_eq!(rig.isolation.bridged(1), group);
            assert_eq!(rig.finding(0.1), None);
            assert_eq!(rig.isolation.bridged(1), None);
        }
    }
}

#[test]
fn what_stays_below_its_bound_is_no_finding() {
    // h_s = 1.6 (6 s + 0.12 F + K 0.06 mm) = 15.8 N.
    let found = |offset: f64| {
        let mut rig = Rig::new();
        rig.offset[0] = offset;
        rig.far_offset[0] = 0.4 * offset;
        rig.finding(4.0).map(|(_, found)| found)
    };
    assert_eq!(found(14.0), None);
    assert_eq!(found(-14.0), None);
    assert_ne!(found(18.0), None);
}

#[test]
fn the_force_that_a_broken_cable_had_is_lacking_at_the_joint_that_of_a_missing_reading_is_not() {
    for lost in [0.0, 20.0] {
        let mut rig = Rig::new();
        rig.isolation.begin_missing(0);
        rig.torque = -rig.arm(0) * lost;
        rig.evaluate();
        assert_eq!(rig.isolation.force_is_lacking(0, 0.3, FAR), lost > 0.0);
    }
}
