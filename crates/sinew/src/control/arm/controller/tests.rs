use super::*;
use crate::muscle::tests::robots::lever;

const H: f64 = 1e-3;
const REST: f64 = 0.2;

/// A lever as it is modelled: winches follow their commands, and load cells and encoder read what is
/// predicted, the former with noise.
struct Rig {
    controller: ArmController,
    motor: [f64; 2],
    tension: [f64; 2],
    joint: f64,
    cycles: u32,
}

#[derive(Clone, Copy)]
struct Readings {
    motor: [f64; 2],
    tension: [f64; 2],
    joint: [f64; 1],
}

impl Rig {
    fn new(source: CableStateSource) -> Self {
        let models = vec![CableModel::bench(); 2];
        let mode = ActuationMode::WinchSpeed(source);
        // Those of an arm; a lever needs less.
        let gains = ArmGains::for_tests(2, 1).without_tension_estimates();
        let controller = ArmController::new(&lever(), &models, gains, mode).unwrap();
        Self { controller, motor: [0.3, -0.1], tension: [45.0, 55.0], joint: REST, cycles: 0 }
    }

    /// After some cycles at rest.
    fn at_rest(source: CableStateSource) -> Self {
        let mut rig = Self::new(source);
        (0..300).for_each(|_| {
            rig.cycle(&at(REST));
        });
        rig
    }

    /// One cycle.
    fn cycle(&mut self, reference: &Reference) -> ArmStatus {
        self.cycle_with(reference, |readings| readings)
    }

    /// The same with other readings.
    fn cycle_with(&mut self, reference: &Reference, change: impl Fn(Readings) -> Readings) -> ArmStatus {
        let noise = 1e-3 * f64::from(self.cycles % 2);
        let readings = change(Readings {
            motor: self.motor,
            tension: self.tension.map(|tension| tension + noise),
            joint: [self.joint],
        });
        let status = give(&mut self.controller, &readings, reference);
        for (motor, drive) in self.motor.iter_mut().zip(&self.controller.actuation.drives) {
            let DriveCommand::Velocity(speed) = drive else { panic!("{drive:?}") };
            *motor += H * speed;
        }
        self.tension.copy_from_slice(&self.controller.cables.tension_in);
        self.joint = self.controller.joints.q[0];
        self.cycles += 1;
        status
    }

    fn speeds(&self) -> [f64; 2] {
        [0, 1].map(|k| self.controller.actuation.winch_speed[k])
    }
}

fn give(controller: &mut ArmController, readings: &Readings, reference: &Reference) -> ArmStatus {
    let measurement =
        ArmMeasurement { motor: &readings.motor, tension: &readings.tension, joint: &readings.joint };
    controller.step(H, &measurement, &both(reference)).unwrap().status
}

fn both(reference: &Reference) -> PreviewedReference<'_> {
    PreviewedReference { current: reference, previewed: reference, repeat_time: None }
}

/// A reference at rest.
fn at(q: f64) -> Reference {
    Reference { q: vec![q], ..Reference::new(1) }
}

/// A reference that swings about the pose of rest, from it, with at most 0.3 rad/s.
fn swing(cycle: u32) -> Reference {
    let (size, rate) = (0.1, 3.0);
    let phase = rate * H * f64::from(cycle);
    Reference {
        q: vec![REST + size * (1.0 - libm::cos(phase))],
        v: vec![size * rate * libm::sin(phase)],
        a: vec![size * rate * rate * libm::cos(phase)],
    }
}

/// `R^T F`.
fn torque_of(controller: &ArmController, tension: &[f64]) -> f64 {
    controller.body.moment_arms().iter().zip(tension).map(|(arm, tension)| arm * tension).sum()
}

#[test]
fn an_arm_at_rest_on_its_reference_is_found_at_rest_and_holds_with_the_least_tensions_that_bear_it() {
    for source in [CableStateSource::Observer, CableStateSource::Encoders] {
        let mut rig = Rig::new(source);
        rig.cycle(&at(REST));
        // The disturbance balances the tensions of the start, whatever they are.
        assert!(rig.controller.joints.v[0].abs() < 1e-12, "{:?}", rig.controller.joints.v);
        assert!(rig.controller.joints.disturbance[0].abs() > 1.0, "{:?}", rig.controller.joints.disturbance);
        assert!(rig.controller.cables.tension_out.iter().all(|tension| *tension > 30.0));
        let mut rig = Rig::at_rest(source);
        for _ in 0..500 {
            let status = rig.cycle(&at(REST));
            assert!(matches!(status, ArmStatus::Following | ArmStatus::Holding), "{status:?}");
        }
        assert_eq!(rig.controller.status(), ArmStatus::Holding, "{source:?}");
        let controller = &mut rig.controller;
        assert!((controller.joints.q[0] - REST).abs() < 1e-4 && controller.joints.v[0].abs() < 1e-3);
        // (23) for the acceleration that the law asks for, and (22): the muscle that does not help is at its
        // least.
        let mut needed = [0.0];
        let (v, desired) = (controller.joints.v.clone(), controller.law.output.clone());
        controller.body.inverse_dynamics(&v, &desired, &mut needed).unwrap();
        let desired = controller.desired_tension.clone();
        assert!((torque_of(controller, &desired) - needed[0]).abs() < 1e-9 && needed[0].abs() > 0.05);
        let [least, most] = controller.gains.muscles[0].tension;
        assert!((desired[0].min(desired[1]) - least).abs() < 1e-9 && desired[0].max(desired[1]) < most);
        assert_eq!(controller.reached, Status::Optimal);
    }
}

#[test]
fn a_moving_reference_is_followed_and_not_held() {
    for source in [CableStateSource::Observer, CableStateSource::Encoders] {
        let mut rig = Rig::at_rest(source);
        assert_eq!(rig.controller.status(), ArmStatus::Holding);
        let mut most = 0.0_f64;
        for k in 1..400 {
            assert_eq!(rig.cycle(&swing(k)), ArmStatus::Following, "{k}");
            most = most.max((rig.joint - swing(k + 1).q[0]).abs());
        }
        // Without a preview the dead band is crossed late; by the encoders alone there is none.
        assert!(
            most < if source == CableStateSource::Observer { 0.06 } else { 2.5e-3 },
            "{source:?}: {most}"
        );
    }
}

#[test]
fn rest_begins_near_a_reference_that_stands_and_ends_farther_from_it() {
    let gains = ArmGains::for_tests(2, 1);
    let [begins, ends] = gains.muscles[0].rest_error;
    let fast = gains.muscles[0].rest_speed;
    let standing = at(REST);
    let slow = Reference { v: vec![1e-6], ..at(REST) };
    let rests = |before: bool, error: f64, speed: f64, current: &Reference, previewed: &Reference| {
        let mut controller = Rig::new(CableStateSource::Observer).controller;
        controller.at_rest = before;
        controller.anchors.error.copy_from_slice(&[0.0, error]);
        controller.anchors.estimated.copy_from_slice(&[speed, 0.0]);
        controller.detect_rest(&PreviewedReference { current, previewed, repeat_time: None });
        // No winch has a dead zone yet.
        assert_eq!(controller.holding, controller.at_rest && error.abs() < 1e-12);
        controller.at_rest
    };
    for side in [1.0, -1.0] {
        assert!(rests(false, 0.9 * side * begins, 0.9 * side * fast, &standing, &standing));
        assert!(!rests(false, 1.1 * side * begins, 0.0, &standing, &standing));
        assert!(!rests(false, 0.0, 1.1 * side * fast, &standing, &standing));
        assert!(rests(true, 0.9 * side * ends, 9.0 * side * fast, &standing, &standing));
        assert!(!rests(true, 1.1 * side * ends, 0.0, &standing, &standing));
    }
    for before in [true, false] {
        assert!(rests(before, 0.0, 0.0, &standing, &standing));
        assert!(!rests(before, 0.0, 0.0, &slow, &standing) && !rests(before, 0.0, 0.0, &standing, &slow));
        // Tensions that are followed are not rest.
        let mut controller = Rig::new(CableStateSource::Observer).controller;
        controller.at_rest = before;
        controller.set_tensions(Some(&[50.0, 50.0])).unwrap();
        controller.detect_rest(&both(&standing));
        assert!(!controller.at_rest && !controller.holding);
    }
}

#[test]
fn errors_are_those_of_the_estimates_and_slip_follows_the_anchors_within_its_filter_time() {
    // 9 ms; a longer cycle takes the speed as it is.
    for (h, fraction) in [(1e-3, 1.0 / 9.0), (3e-3, 1.0 / 3.0), (0.02, 1.0)] {
        let mut controller = Rig::new(CableStateSource::Observer).controller;
        controller.body.evaluate(&[REST]).unwrap();
        controller.joints.q[0] = 0.15;
        controller.joints.v[0] = 0.4;
        controller.evaluate_errors(h, &both(&at(REST))).unwrap();
        assert!((controller.law.error[0] - 0.05).abs() < 1e-12);
        for k in 0..2 {
            let arm = controller.body.moment_arms()[k];
            assert!((controller.anchors.error[k] - 0.05 * arm).abs() < 1e-15 && arm.abs() > 0.01);
            assert!((controller.anchors.slip[k] - fraction * 0.4 * arm).abs() < 1e-15, "{h}");
        }
        assert_eq!(controller.status(), ArmStatus::Following);
    }
}

#[test]
fn a_reference_out_of_reach_of_the_joint_is_a_tracking_error_and_brakes_the_winches() {
    let mut rig = Rig::at_rest(CableStateSource::Observer);
    assert_eq!(rig.cycle(&at(REST + 0.45)), ArmStatus::Following);
    let status = rig.cycle(&at(REST + 0.55));
    assert_eq!(status, ArmStatus::Stopped(Fault::TrackingError(0)));
    (0..5).for_each(|_| {
        rig.cycle(&at(REST));
    });
    assert!(rig.speeds().iter().all(|speed| speed.abs() < 1e-12), "{:?}", rig.speeds());
    assert_eq!(rig.controller.status(), status);
}

#[test]
fn every_sensor_at_fault_degrades_the_arm_by_its_name_and_is_bridged_as_if_it_were_there() {
    type Change = fn(Readings) -> Readings;
    let faults: [(Change, Fault); 5] = [
        (|r| Readings { joint: [f64::NAN], ..r }, Fault::JointSensor(0)),
        (|r| Readings { motor: [f64::NAN, r.motor[1]], ..r }, Fault::MotorSensor(0)),
        (|r| Readings { motor: [r.motor[0], f64::NAN], ..r }, Fault::MotorSensor(1)),
        (|r| Readings { tension: [f64::NAN, r.tension[1]], ..r }, Fault::TensionSensor(0)),
        (|r| Readings { tension: [r.tension[0], f64::NAN], ..r }, Fault::TensionSensor(1)),
    ];
    for source in [CableStateSource::Observer, CableStateSource::Encoders] {
        for (change, fault) in faults {
            let (mut whole, mut rig) = (Rig::at_rest(source), Rig::at_rest(source));
            let mut most = 0.0_f64;
            for k in 1..150 {
                let lost = (100..120).contains(&k);
                whole.cycle(&swing(k));
                let status =
                    rig.cycle_with(&swing(k), |readings| if lost { change(readings) } else { readings });
                most = most.max((rig.joint - whole.joint).abs());
                match k {
                    100..120 => assert_eq!(status, ArmStatus::Degraded(fault), "{k}"),
                    // A joint encoder returns after four samples that agree.
                    120..126 => {}
                    _ => assert_eq!(status, ArmStatus::Following, "{source:?} {fault:?} {k}"),
                }
            }
            // Without estimated tensions the joint goes on at its reference's speed.
            let (follows, reads) = (source == CableStateSource::Encoders, fault == Fault::JointSensor(0));
            assert!(most < if follows && reads { 2e-3 } else { 3e-5 }, "{source:?} {fault:?}: {most}");
        }
    }
}

#[test]
fn the_muscles_replace_a_joint_encoder_for_a_quarter_of_a_second() {
    for source in [CableStateSource::Observer, CableStateSource::Encoders] {
        let (mut whole, mut rig) = (Rig::at_rest(source), Rig::at_rest(source));
        let lost = |k: u32, r: Readings| if k >= 100 { Readings { joint: [f64::NAN], ..r } } else { r };
        let mut most = 0.0_f64;
        for k in 1..349 {
            let status = rig.cycle_with(&swing(k), |readings| lost(k, readings));
            assert!(!matches!(status, ArmStatus::Stopped(_)), "{source:?} {k}: {status:?}");
            whole.cycle(&swing(k));
            most = most.max((rig.joint - whole.joint).abs());
        }
        assert!(most < if source == CableStateSource::Encoders { 0.1 } else { 1e-12 }, "{source:?}: {most}");
        let last: Vec<ArmStatus> =
            (349..351).map(|k| rig.cycle_with(&swing(k), |readings| lost(k, readings))).collect();
        assert_eq!(last[1], ArmStatus::Stopped(Fault::JointSensor(0)), "{last:?}");
    }
}

/// A controller that has started, with these estimates of its joint: `q^`, `q'^`, `d^`.
fn estimating(source: CableStateSource, [q, v, disturbance]: [f64; 3]) -> ArmController {
    let mut controller = Rig::new(source).controller;
    controller.started = true;
    controller.joints.q[0] = q;
    controller.joints.v[0] = v;
    controller.joints.disturbance[0] = disturbance;
    controller
}

#[test]
fn the_estimate_goes_on_from_where_a_withdrawn_or_returned_encoder_puts_it() {
    let reference = swing(300);
    let withdrawn = |shift: f64| EncoderCheck::Withdrawn { shift, disturbance: -7.0 };
    for (check, measured, expected) in [
        (EncoderCheck::Accepted, 0.35, [0.3, 0.5, 2.0]),
        (EncoderCheck::Rejected, f64::NAN, [0.3, 0.5, 2.0]),
        (EncoderCheck::Absent, f64::NAN, [0.3, 0.5, 2.0]),
        (EncoderCheck::Returned, 0.35, [0.35, 0.5, 2.0]),
        (withdrawn(0.0), f64::NAN, [0.3, 0.5, -7.0]),
        // It stood while the joint went on with its reference.
        (withdrawn(0.02), f64::NAN, [0.32, reference.v[0], -7.0]),
        (withdrawn(-0.02), f64::NAN, [0.28, reference.v[0], -7.0]),
    ] {
        for source in [CableStateSource::Observer, CableStateSource::Encoders] {
            let mut controller = estimating(source, [0.3, 0.5, 2.0]);
            controller.faults.joint[0] = measured;
            controller.faults.checks[0] = check;
            controller.bridge_joints(H, &reference);
            let found = [controller.joints.q[0], controller.joints.v[0], controller.joints.disturbance[0]];
            assert!(found.iter().zip(expected).all(|(a, b)| (a - b).abs() < 1e-15), "{check:?}: {found:?}");
            // Without estimated tensions the joint goes on at its reference's speed.
            let used = controller.faults.joint[0];
            if measured.is_finite() {
                assert!((used - measured).abs() < 1e-18);
            } else if source == CableStateSource::Encoders {
                assert!((used - (expected[0] + H * reference.v[0])).abs() < 1e-15, "{check:?}: {used}");
            } else {
                assert!(used.is_nan(), "{check:?}: {used}");
            }
        }
    }
}

#[test]
fn the_first_cycle_starts_from_the_measurement_and_where_there_is_none_from_the_reference() {
    for (measured, expected) in [(0.37, 0.37), (f64::NAN, REST)] {
        let mut controller = estimating(CableStateSource::Observer, [0.9, 0.5, 2.0]);
        controller.started = false;
        controller.faults.joint[0] = measured;
        controller.bridge_joints(H, &at(REST));
        assert!((controller.joints.q[0] - expected).abs() < 1e-18 && controller.started);
        assert!(controller.joints.v[0].abs() < 1e-18 && controller.joints.disturbance[0].abs() < 1e-18);
        // Only the first.
        controller.faults.joint[0] = 0.5;
        controller.bridge_joints(H, &at(REST));
        assert!((controller.joints.q[0] - expected).abs() < 1e-18);
    }
}

#[test]
fn the_disturbance_compensated_follows_the_estimate_or_without_tensions_the_error_and_rests_at_rest() {
    for source in [CableStateSource::Observer, CableStateSource::Encoders] {
        for at_rest in [false, true] {
            let mut controller = Rig::at_rest(source).controller;
            controller.at_rest = at_rest;
            controller.law.error[0] = 0.02;
            controller.joints.disturbance[0] += 20.0;
            let mut expected = controller.law.clone();
            controller.estimate_joints(H).unwrap();
            if !at_rest {
                let estimated = Some(&controller.joints.disturbance[..]);
                let estimated = estimated.filter(|_| source == CableStateSource::Observer);
                expected.update_disturbance(H, &controller.gains, estimated);
            }
            let mut found = controller.law.clone();
            for law in [&mut expected, &mut found] {
                law.evaluate(&controller.gains, &at(REST), true);
            }
            assert!((found.output[0] - expected.output[0]).abs() < 1e-12, "{source:?} {at_rest}");
            // By feedback of either kind something changes.
            let before = Rig::at_rest(source).controller.law.output[0];
            assert_eq!((found.output[0] - before).abs() > 1e-3, !at_rest, "{source:?} {before} {found:?}");
        }
    }
}

#[test]
fn given_tensions_are_followed_at_their_rate_until_the_joints_are_followed_again() {
    let mut rig = Rig::at_rest(CableStateSource::Observer);
    assert_eq!(
        rig.controller.set_tensions(Some(&[60.0])).unwrap_err(),
        Error::WrongLength { name: "tension set-points", expected: 2, got: 1 }
    );
    let estimated = rig.controller.cables.tension_out.clone();
    rig.controller.set_tensions(Some(&[60.0, 80.0])).unwrap();
    // A tenth of 40 kN/s, from the estimate on.
    let mut expected = [0, 1].map(|k| estimated[k].max(21.0));
    for cycle in 0..40 {
        assert_eq!(rig.cycle(&at(REST)), ArmStatus::Following, "tensions are not held");
        for (k, given) in [60.0, 80.0].into_iter().enumerate() {
            expected[k] += (given - expected[k]).clamp(-4.0, 4.0);
            let found = rig.controller.desired_tension[k];
            // The first estimate is a cycle younger than that taken here.
            assert!((found - expected[k]).abs() < if cycle < 20 { 0.5 } else { 1e-12 }, "{cycle}: {found}");
        }
    }
    assert!(rig.speeds().iter().all(|speed| *speed > 1e-3), "both cable are wound in: {:?}", rig.speeds());
    rig.controller.set_tensions(None).unwrap();
    (0..3).for_each(|_| {
        rig.cycle(&at(REST));
    });
    let desired = &rig.controller.desired_tension;
    assert!((desired[0].min(desired[1]) - 21.0).abs() < 1e-9, "{desired:?}");
}

#[test]
fn an_arm_that_is_stopped_from_outside_brakes_its_winches_at_their_deceleration() {
    for reported in [true, false] {
        let mut rig = Rig::at_rest(CableStateSource::Observer);
        (1..200).for_each(|k| {
            rig.cycle(&swing(k));
        });
        let mut speeds = rig.speeds();
        assert!(speeds.iter().all(|speed| speed.abs() > 1e-3), "{speeds:?}");
        let symptom = if reported { Symptom::Reported } else { Symptom::Standing };
        if reported {
            rig.controller.stop(Fault::Drive(1));
        } else {
            rig.controller.stop_as(Fault::Drive(1), symptom);
        }
        for k in 200..300 {
            assert_eq!(rig.cycle(&swing(k)), ArmStatus::Stopped(Fault::Drive(1)));
            speeds = speeds.map(|speed| speed - speed.clamp(-2e-3, 2e-3));
            for (found, expected) in rig.speeds().into_iter().zip(speeds) {
                assert!((found - expected).abs() < 1e-15);
            }
            assert_eq!(rig.controller.observed().symptom, symptom);
        }
        assert!(speeds.iter().all(|speed| speed.abs() < 1e-12));
    }
}

#[test]
fn inputs_of_another_robot_are_refused() {
    let mut rig = Rig::new(CableStateSource::Observer);
    assert_eq!(rig.controller.dimensions(), [2, 1]);
    let (reference, wrong) = (at(REST), Reference::new(2));
    let good = ArmMeasurement { motor: &[0.0; 2], tension: &[40.0; 2], joint: &[REST] };
    let bad = ArmMeasurement { motor: &[0.0; 3], ..good };
    assert!(rig.controller.check(&good, &both(&reference)).is_ok());
    assert!(rig.controller.check(&bad, &both(&reference)).is_err());
    assert!(rig.controller.check(&good, &both(&wrong)).is_err());
    assert!(rig.controller.step(H, &bad, &both(&reference)).is_err());
}

#[test]
fn a_restarted_controller_does_as_a_new_one() {
    for source in [CableStateSource::Observer, CableStateSource::Encoders] {
        let mut used = Rig::at_rest(source);
        for k in 1..400 {
            used.cycle(&swing(k));
        }
        // It stopped in motion, off its reference.
        assert!(used.controller.anchors.slip[0].abs() > 1e-3 && used.controller.law.error[0].abs() > 1e-6);
        used.controller.stop(Fault::Bus);
        used.cycle(&swing(400));
        used.controller.restart();
        assert_eq!(used.controller.status(), ArmStatus::Following);
        let mut new = Rig::new(source);
        (used.motor, used.tension, used.joint, used.cycles) = (new.motor, new.tension, new.joint, new.cycles);
        for k in 0..100 {
            assert_eq!(used.cycle(&swing(k)), new.cycle(&swing(k)), "{source:?} {k}");
            for (a, b) in [
                (&used.controller.joints.q, &new.controller.joints.q),
                (&used.controller.joints.v, &new.controller.joints.v),
                (&used.controller.anchors.slip, &new.controller.anchors.slip),
                (&used.controller.law.output, &new.controller.law.output),
                (&used.controller.desired_tension, &new.controller.desired_tension),
                (&used.controller.cables.tension_out, &new.controller.cables.tension_out),
                (&used.controller.actuation.winch_speed, &new.controller.actuation.winch_speed),
            ] {
                let close = |(a, b): (&f64, &f64)| (a - b).abs() < 1e-8 * (1.0 + b.abs());
                assert!(a.iter().zip(b).all(close), "{source:?} {k}: {a:?} {b:?}");
            }
        }
    }
}

#[test]
fn a_pose_that_is_only_observed_is_the_measured_one_where_there_is_one_and_no_tension_is_known() {
    let mut rig = Rig::at_rest(CableStateSource::Observer);
    rig.controller.joints.v[0] = 0.3;
    rig.controller.observe_pose(&[0.7]);
    for measured in [0.7, f64::NAN, f64::INFINITY] {
        rig.controller.observe_pose(&[measured]);
        let drives = [DriveCommand::Off; 2];
        let outputs = rig.controller.outputs(&drives, ArmStatus::Following);
        assert!((outputs.q[0] - 0.7).abs() < 1e-18, "{measured}");
        assert!(outputs.estimated_tension.iter().all(|tension| tension.is_nan()));
        assert!(outputs.desired_tension.iter().all(|tension| tension.abs() < 1e-18));
        assert!(rig.controller.joints.v[0].abs() < 1e-18);
    }
}

#[test]
fn a_cable_that_is_pulled_far_slides_and_its_neighbour_does_not() {
    let mut controller = Rig::at_rest(CableStateSource::Observer).controller;
    let ArmController { cables, body, .. } = &mut controller;
    let mut motor = [0.0, 0.0];
    cables.restart();
    for _ in 0..200 {
        cables.update(H, (&motor, &[45.0; 2]), (body, &[REST]), &[45.0; 2]).unwrap();
        motor[1] += 2e-4;
    }
    assert!(!controller.slides(0) && controller.slides(1));
}
