use super::*;

const H: f64 = 1e-3;

/// One muscle and one joint, seen for a second; the sensors of cycle `k` are `[motor, tension, joint]`,
/// the tension of the observer is 40 N. Returns the time at which the arm stops, s, and the fault.
fn stops(winch_speed: f64, sensors: impl Fn(u32) -> [f64; 3]) -> Option<(f64, Fault)> {
    let mut detector = FaultDetector::new(&[25e3], &ArmGains::for_tests(1, 1), 1.0);
    let reference = Reference { q: vec![0.2], ..Reference::new(1) };
    let prediction = Prediction {
        winch_speed: &[winch_speed],
        tension_in: &[40.0],
        tension_out: &[30.0],
        unexplained_speed: &[0.0],
        joint: [&[0.2], &[0.0], &[0.0]],
        disturbance_torque: &[0.0],
        joint_stiffness: &[200.0],
        reference: &reference,
        unmeasured: &UnmeasuredJoints::all_measured(1),
    };
    (0..1000).find_map(|k| {
        let [motor, tension, joint] = sensors(k);
        let measurement = ArmMeasurement { motor: &[motor], tension: &[tension], joint: &[joint] };
        detector.update(H, &measurement, &prediction);
        match detector.status {
            ArmStatus::Stopped(fault) => Some((H * f64::from(k), fault)),
            _ => None,
        }
    })
}

/// A changing output around a value.
fn noisy(value: f64, k: u32) -> f64 {
    value + 1e-4 * f64::from(k % 2)
}

#[test]
fn a_cable_that_lacks_its_tension_stops_the_arm_after_the_persistence_time() {
    let lacking = |tension: f64, until: u32| {
        stops(0.0, |k| [0.5, noisy(if k > 100 && k <= until { tension } else { 40.0 }, k), 0.2])
    };
    let (time, fault) = lacking(5.0, 1000).unwrap();
    assert!(fault == Fault::Cable(0) && (0.130..0.133).contains(&time), "{time} {fault:?}");
    assert_eq!(lacking(5.0, 127), None);
    // A fifth of the estimate is the limit.
    assert_eq!(lacking(9.0, 1000), None);
}

#[test]
fn a_tension_that_was_missing_before_the_encoder_stood_is_missing_from_the_cable() {
    for (stands_from, fault) in [(102, Fault::Cable(0)), (80, Fault::MotorSensor(0))] {
        // 50 mm/s paid out at 25 N/mm from cycle 80 on, seen until the encoder stands.
        let motor = |k: u32| 0.5 - 5e-5 * f64::from(k.min(stands_from));
        let tension = |k: u32| (40.0 - 1.5 * f64::from(k.saturating_sub(80))).max(0.0);
        let found = stops(-0.05, |k| [motor(k), noisy(tension(k), k), 0.2]);
        assert_eq!(found.map(|(_, found)| found), Some(fault));
    }
}

#[test]
fn a_tension_that_is_missing_while_a_joints_encoder_is_replaced_is_the_encoders_fault() {
    for (lost_from, fault) in [(80, Fault::JointSensor(0)), (103, Fault::Cable(0))] {
        let joint = |k: u32| if k >= lost_from { f64::NAN } else { 0.2 };
        let found = stops(0.0, |k| [noisy(0.5, k), noisy(if k >= 100 { 3.0 } else { 40.0 }, k), joint(k)]);
        assert_eq!(found.map(|(_, found)| found), Some(fault));
    }
}

#[test]
fn a_winch_that_lags_its_command_stops_the_arm_in_either_direction_but_not_where_its_cable_is_slack() {
    for speed in [0.05, -0.05] {
        let lagging = |fraction: f64, tension: f64| {
            let motor = |k: u32| 0.5 + fraction * speed * H * f64::from(k);
            stops(speed, |k| [motor(k), noisy(tension, k), 0.2])
        };
        // r_v tends to 0.8 v_c t_f = 8 mm and passes 6 mm at t_f ln 4.
        let (time, fault) = lagging(0.2, 40.0).unwrap();
        assert!(fault == Fault::Drive(0) && (0.26..0.29).contains(&time), "{time} {fault:?}");
        assert_eq!(lagging(0.5, 40.0), None);
    }
    // A load cell that stands at 40 N does not say whether the cable is slack.
    for (speed, judged) in [(0.05, true), (-0.05, false)] {
        let found = stops(speed, |k| [0.5 + 0.2 * speed * H * f64::from(k), 40.0, 0.2]);
        assert_eq!(found.map(|(_, fault)| fault), judged.then_some(Fault::Drive(0)));
    }
    let slack = stops(-0.05, |k| [noisy(0.5, k), if k == 0 { 40.0 } else { noisy(3.0, k) }, 0.2]);
    assert_eq!(slack.map(|(_, fault)| fault), Some(Fault::Cable(0)));
}

#[test]
fn the_muscles_replace_a_joint_encoder_for_its_persistence_time_and_nothing_replaces_a_motor_encoder() {
    let (time, fault) = stops(0.0, |k| [0.5, noisy(40.0, k), if k > 100 { f64::NAN } else { 0.2 }]).unwrap();
    assert!(fault == Fault::JointSensor(0) && (0.350..0.353).contains(&time), "{time} {fault:?}");
    let (time, fault) = stops(0.0, |k| [if k > 100 { f64::NAN } else { 0.5 }, noisy(40.0, k), 0.2]).unwrap();
    assert!(fault == Fault::MotorSensor(0) && (0.130..0.133).contains(&time), "{time} {fault:?}");
}

#[test]
fn an_unchanged_motor_encoder_is_its_own_fault_where_the_load_cell_confirms_the_commanded_travel() {
    let unchanged = |tension: fn(u32) -> f64| stops(0.02, |k| [0.5, noisy(tension(k), k), 0.2]).unwrap().1;
    assert_eq!(unchanged(|_| 40.0), Fault::Drive(0));
    // 25 N/mm at 20 mm/s.
    assert_eq!(unchanged(|k| 40.0 + 0.5 * f64::from(k)), Fault::MotorSensor(0));
}

/// What the second of two muscles and the second of two joints show in one cycle, and what is predicted for
/// them. The first ones are without a fault.
#[derive(Clone, Copy)]
struct Cycle {
    speed: f64,
    estimated: f64,
    unexplained: f64,
    motor: f64,
    tension: f64,
    joint: f64,
    predicted: f64,
    joint_speed: f64,
}

/// At rest.
fn quiet(k: u32) -> Cycle {
    Cycle {
        speed: 0.0,
        estimated: 40.0,
        unexplained: 0.0,
        motor: 0.5,
        tension: noisy(40.0, k),
        joint: 0.2,
        predicted: 0.2,
        joint_speed: 0.0,
    }
}

/// In motion: the winch follows its command, the joint its reference.
fn moving(k: u32) -> Cycle {
    let t = H * f64::from(k);
    let angle = 0.2 + 0.3 * t;
    let joint = 3.8e-4 * libm::round(angle / 3.8e-4);
    Cycle { speed: 0.05, motor: 0.5 + 0.05 * t, joint, predicted: angle, joint_speed: 0.3, ..quiet(k) }
}

fn detector() -> FaultDetector {
    FaultDetector::new(&[25e3; 2], &ArmGains::for_tests(2, 2), 1.0)
}

fn see(detector: &mut FaultDetector, k: u32, cycle: &Cycle) {
    see_after(detector, H, &moving(k), cycle);
}

/// The same `h` s after the cycle before, with what the first muscle and joint show.
fn see_after(detector: &mut FaultDetector, h: f64, clean: &Cycle, cycle: &Cycle) {
    let angle = [clean.predicted, cycle.predicted];
    let speed = [clean.joint_speed, cycle.joint_speed];
    let reference = Reference { q: angle.to_vec(), v: speed.to_vec(), ..Reference::new(2) };
    let prediction = Prediction {
        winch_speed: &[clean.speed, cycle.speed],
        tension_in: &[clean.estimated, cycle.estimated],
        tension_out: &[clean.estimated, cycle.estimated],
        unexplained_speed: &[clean.unexplained, cycle.unexplained],
        joint: [&angle, &speed, &[0.0; 2]],
        disturbance_torque: &[0.0; 2],
        joint_stiffness: &[200.0; 2],
        reference: &reference,
        unmeasured: &UnmeasuredJoints::all_measured(2),
    };
    let measurement = ArmMeasurement {
        motor: &[clean.motor, cycle.motor],
        tension: &[clean.tension, cycle.tension],
        joint: &[clean.joint, cycle.joint],
    };
    detector.update(h, &measurement, &prediction);
}

/// The detector after some cycles.
fn after(cycles: u32, cycle: impl Fn(u32) -> Cycle) -> FaultDetector {
    let mut detector = detector();
    (0..cycles).for_each(|k| see(&mut detector, k, &cycle(k)));
    detector
}

/// Cycle in which the arm stops, of 1000, with fault and symptom.
fn stopped(cycle: impl Fn(u32) -> Cycle) -> Option<(u32, Fault, Symptom)> {
    let mut detector = detector();
    (0..1000).find_map(|k| {
        see(&mut detector, k, &cycle(k));
        match detector.status {
            ArmStatus::Stopped(fault) => Some((k, fault, detector.symptom)),
            _ => None,
        }
    })
}

/// Whether a cycle is the expected one or that before: times are sums of cycles, and rounded.
fn is_at(cycle: u32, expected: u32) -> bool {
    cycle == expected || cycle + 1 == expected
}

#[test]
fn a_clean_signal_is_handed_on_as_it_is_and_no_fault_is_found_in_it() {
    for clean in [quiet, moving] {
        let mut detector = detector();
        for k in 0..1500 {
            let cycle = clean(k);
            see(&mut detector, k, &cycle);
            assert_eq!((detector.status, detector.symptom), (ArmStatus::Following, Symptom::Unknown), "{k}");
            let handed = [detector.motor[1], detector.tension[1], detector.joint[1]];
            let given = [cycle.motor, cycle.tension, cycle.joint];
            assert!(handed.iter().zip(given).all(|(a, b)| (a - b).abs() < 1e-18), "{k} {handed:?}");
            assert_eq!(detector.checks, [EncoderCheck::Accepted; 2]);
        }
    }
}

#[test]
fn a_sensor_at_fault_degrades_the_arm_at_once_and_is_named_with_its_symptom_until_it_recovers() {
    type Change = fn(Cycle) -> Cycle;
    let faults: [(Change, Fault, Symptom); 6] = [
        (|c| Cycle { joint: f64::NAN, ..c }, Fault::JointSensor(1), Symptom::Lost),
        (|c| Cycle { joint: 0.0, ..c }, Fault::JointSensor(1), Symptom::Lost),
        (|c| Cycle { joint: c.joint + 0.2, ..c }, Fault::JointSensor(1), Symptom::Jumped),
        (|c| Cycle { motor: f64::NAN, ..c }, Fault::MotorSensor(1), Symptom::Lost),
        (|c| Cycle { motor: c.motor + 0.5, ..c }, Fault::MotorSensor(1), Symptom::Jumped),
        (|c| Cycle { tension: f64::NAN, ..c }, Fault::TensionSensor(1), Symptom::Lost),
    ];
    for (change, fault, symptom) in faults {
        let mut detector = detector();
        for k in 0..200 {
            let wrong = (100..120).contains(&k);
            see(&mut detector, k, &if wrong { change(moving(k)) } else { moving(k) });
            let found = (detector.status, detector.symptom);
            match k {
                100..120 => assert_eq!(found, (ArmStatus::Degraded(fault), symptom), "{k}"),
                // A joint encoder returns after four samples that agree.
                120..126 => {}
                _ => assert_eq!(found, (ArmStatus::Following, Symptom::Unknown), "{k}: {fault:?}"),
            }
        }
    }
}

#[test]
fn each_fault_stops_the_arm_after_its_persistence_time_and_a_load_cell_never() {
    let from = |start: u32, change: fn(Cycle) -> Cycle| {
        stopped(move |k| if k >= start { change(moving(k)) } else { moving(k) })
    };
    let stops = |change, expected, part| {
        let (k, fault, symptom) = from(100, change).unwrap();
        assert!(is_at(k, expected) && (fault, symptom) == part, "{k} {fault:?} {symptom:?} {part:?}");
    };
    stops(|c| Cycle { joint: f64::NAN, ..c }, 350, (Fault::JointSensor(1), Symptom::Lost));
    stops(|c| Cycle { joint: c.joint + 0.2, ..c }, 350, (Fault::JointSensor(1), Symptom::Jumped));
    stops(|c| Cycle { motor: f64::NAN, ..c }, 130, (Fault::MotorSensor(1), Symptom::Lost));
    stops(|c| Cycle { motor: c.motor + 0.5, ..c }, 130, (Fault::MotorSensor(1), Symptom::Jumped));
    assert_eq!(from(100, |c| Cycle { tension: f64::NAN, ..c }), None);
    assert_eq!(from(100, |c| Cycle { tension: 100.0, ..c }), None);
    assert_eq!(from(100, |c| Cycle { tension: 40.0, ..c }), None);
    // Stuck: seen when the muscles have moved by 16 mrad at 0.3 rad/s, 54 cycles later at the latest, for 17
    // cycles.
    let (k, fault, symptom) = from(100, |c| Cycle { joint: 0.23, ..c }).unwrap();
    assert!((fault, symptom) == (Fault::JointSensor(1), Symptom::Stuck) && (417..424).contains(&k), "{k}");
}

#[test]
fn a_tension_that_is_rejected_is_withheld() {
    let frozen = |k: u32| Cycle { tension: if k >= 100 { 40.0 } else { noisy(40.0, k) }, ..quiet(k) };
    // Cycle 100 equals the one two before; eight equal samples are one too few.
    let detector = after(108, frozen);
    assert!((detector.tension[1] - 40.0).abs() < 1e-12 && detector.status == ArmStatus::Following);
    let detector = after(115, frozen);
    assert!(detector.tension[1].is_nan() && !detector.tension[0].is_nan());
    let expected = (ArmStatus::Degraded(Fault::TensionSensor(1)), Symptom::Stuck);
    assert_eq!((detector.status, detector.symptom), expected);
}

#[test]
fn a_load_cell_that_stands_at_less_than_is_estimated_is_its_own_fault_and_not_its_cables() {
    let low = |k: u32| Cycle { tension: if k >= 100 { 3.0 } else { noisy(40.0, k) }, ..quiet(k) };
    assert_eq!(stopped(low), None);
    assert_eq!(after(200, low).status, ArmStatus::Degraded(Fault::TensionSensor(1)));
}

#[test]
fn a_tension_is_missing_below_a_fifth_of_its_estimate_and_by_more_than_its_threshold() {
    let missing = |estimated: f64, tension: f64| {
        let found = stopped(|k| {
            let tension = noisy(if k >= 100 { tension } else { estimated }, k);
            Cycle { estimated, tension, ..quiet(k) }
        });
        let as_documented =
            |(k, fault, symptom)| is_at(k, 130) && (fault, symptom) == (Fault::Cable(1), Symptom::Unknown);
        assert!(found.is_none_or(as_documented), "{found:?}");
        found.is_some()
    };
    assert!(missing(40.0, 7.8) && !missing(40.0, 8.1));
    // 8 N is the threshold.
    assert!(missing(9.0, 0.5) && !missing(7.5, 1.2) && !missing(7.9, 0.1));
}

#[test]
fn a_motor_encoder_that_jumps_is_bridged_for_its_persistence_time_and_then_stops_the_arm() {
    let jumped_by = |distance: f64, cycles: u32| {
        stopped(move |k| {
            let jumped = (100..100 + cycles).contains(&k);
            Cycle { motor: if jumped { 0.5 + distance } else { 0.5 }, ..quiet(k) }
        })
    };
    for side in [1.0, -1.0] {
        // 0.19 m/s for 1.3 ms are 0.247 mm.
        for distance in [3.2e-4, 5e-4, 5.9e-3, 0.0299] {
            let (k, fault, symptom) = jumped_by(distance * side, 1000).unwrap();
            assert!(is_at(k, 130) && (fault, symptom) == (Fault::MotorSensor(1), Symptom::Jumped), "{k}");
            assert_eq!(jumped_by(distance * side, 25), None);
        }
        assert_eq!(jumped_by(2.4e-4 * side, 1000), None);
    }
    // After a loss the place is the winch's own.
    let lost = |k: u32| match k {
        0..100 => 0.5,
        100..110 => f64::NAN,
        _ => 0.507,
    };
    let found = stopped(|k| Cycle { motor: lost(k), ..quiet(k) });
    assert_eq!(found, Some((110, Fault::Drive(1), Symptom::Unknown)));
}

#[test]
fn a_lost_motor_position_is_continued_at_the_commanded_speed() {
    let lost = |k: u32| Cycle { motor: if k >= 100 { f64::NAN } else { moving(k).motor }, ..moving(k) };
    for k in 100..130 {
        let detector = after(k + 1, lost);
        assert!((detector.motor[1] - moving(k).motor).abs() < 1e-12, "{k} {}", detector.motor[1]);
    }
}

#[test]
fn the_travel_that_a_load_cell_explains_tells_a_stuck_encoder_from_a_drive_that_stands() {
    let cause = |speed: f64, unexplained: f64, tension: f64| {
        let cycle = |k: u32| Cycle { speed, unexplained, tension: noisy(tension, k), ..quiet(k) };
        let (k, fault, symptom) = stopped(cycle).unwrap();
        // 0.8 mm at 20 mm/s, less what is forgotten, and the persistence time.
        assert!((69..73).contains(&k), "{k}");
        (fault, symptom)
    };
    let (drive, encoder) = ((Fault::Drive(1), Symptom::Standing), (Fault::MotorSensor(1), Symptom::Stuck));
    for side in [1.0, -1.0] {
        assert_eq!(cause(0.02 * side, 0.02 * side, 40.0), encoder);
        // Half of the commanded travel is the limit.
        assert_eq!(cause(0.02 * side, 0.011 * side, 40.0), encoder);
        assert_eq!(cause(0.02 * side, 0.009 * side, 40.0), drive);
        assert_eq!(cause(0.02 * side, -0.02 * side, 40.0), drive);
        // An innovation of 1 N is 0.04 mm of 25 N/mm, one of 20 N the whole travel.
        assert_eq!(cause(0.02 * side, 0.0, 40.0 + side), drive);
        assert_eq!(cause(0.02 * side, 0.0, 40.0 + 20.0 * side), encoder);
    }
}

#[test]
fn a_drive_that_reverses_may_stand_until_its_speed_control_has_taken_back_the_friction_of_its_reducer() {
    let stands_at = |before: f64, tension: f64| {
        let found = stopped(|k| Cycle {
            speed: if k < 100 { 0.02 * before } else { -0.02 },
            motor: 0.5 + 0.02 * before * H * f64::from(k.min(99)),
            tension: noisy(tension, k),
            estimated: tension,
            ..quiet(k)
        });
        let (k, fault, _) = found.unwrap();
        assert_eq!(fault, Fault::Drive(1));
        k
    };
    let at_once = stands_at(-1.0, 400.0);
    assert_eq!(stands_at(-1.0, 100.0), at_once);
    // 1.8 um/N at 20 um a cycle.
    for (tension, later) in [(100.0, 9), (400.0, 36)] {
        assert!(is_at(stands_at(1.0, tension), at_once + later), "{tension}");
    }
}

#[test]
fn a_winch_that_lags_and_then_stands_is_said_to_stand_one_that_creeps_is_not() {
    // r_v = 8 mm (1 - e^(-t/t_f)) is 5.7 mm after 253 cycles.
    let symptom = |motor: &dyn Fn(u32) -> f64, speed: f64| {
        let (_, fault, symptom) = stopped(|k| Cycle { speed, motor: 0.5 + motor(k), ..quiet(k) }).unwrap();
        assert_eq!(fault, Fault::Drive(1));
        symptom
    };
    let travelled = |k: u32| 0.2 * 0.05 * H * f64::from(k);
    assert_eq!(symptom(&|k| travelled(k.min(253)), 0.05), Symptom::Standing);
    assert_eq!(symptom(&travelled, 0.05), Symptom::Unknown);
    // A coarse encoder that changes in every other cycle.
    let coarse = |k: u32| 0.6 * 0.12 * H * f64::from(2 * (k / 2));
    assert_eq!(symptom(&coarse, 0.12), Symptom::Unknown);
}

#[test]
fn a_winch_that_runs_away_under_a_slack_cable_is_a_fault_unless_it_was_to_pay_out() {
    let found = |speed: f64, drift: f64| {
        let found = stopped(|k| {
            let motor = 0.5 + drift * H * f64::from(k);
            Cycle { speed, motor, estimated: 3.0, tension: noisy(3.0, k), ..quiet(k) }
        });
        found.map(|(_, fault, _)| fault)
    };
    assert_eq!(found(0.0, -0.05), Some(Fault::Drive(1)));
    assert_eq!(found(-0.05, -0.001), None);
    assert_eq!(found(0.05, 0.001), Some(Fault::Drive(1)));
}

#[test]
fn a_stopped_arm_keeps_its_first_fault_until_it_is_restarted_and_then_judges_as_a_new_one() {
    let lost = |k: u32| Cycle { motor: if k >= 100 { f64::NAN } else { 0.5 }, ..quiet(k) };
    let mut used = after(200, lost);
    let stopped = (ArmStatus::Stopped(Fault::MotorSensor(1)), Symptom::Lost);
    for k in 200..400 {
        see(&mut used, k, &if k < 300 { quiet(k) } else { Cycle { joint: f64::NAN, ..quiet(k) } });
        used.check_tracking(&[0.0, 9.0]);
        used.stop(Fault::Bus, Symptom::Reported);
        assert_eq!((used.status, used.symptom), stopped);
    }
    used.restart();
    assert_eq!((used.status, used.symptom), (ArmStatus::Following, Symptom::Unknown));
    let mut new = detector();
    for k in 0..400 {
        // Far from where the sensors were left.
        let cycle = Cycle { motor: lost(k).motor + 0.8, joint: 0.6, predicted: 0.6, ..quiet(k) };
        see(&mut used, k, &cycle);
        see(&mut new, k, &cycle);
        assert_eq!((used.status, used.symptom, &used.checks), (new.status, new.symptom, &new.checks));
    }
    assert_eq!((used.status, used.symptom), stopped);
}

#[test]
fn a_restart_forgets_lags_losses_and_missing_tensions() {
    // Each just before it would stop the arm.
    let lagging = after(170, |k| Cycle { speed: 0.05, motor: 0.5 + 0.002 * H * f64::from(k), ..quiet(k) });
    let missing = after(125, |k| Cycle { tension: noisy(if k >= 100 { 2.0 } else { 40.0 }, k), ..quiet(k) });
    for mut used in [lagging, missing] {
        assert!(!used.is_stopped());
        used.restart();
        for k in 0..20 {
            let cycle = Cycle { tension: noisy(if k > 5 { 2.0 } else { 40.0 }, k), ..quiet(k) };
            see(&mut used, k, &Cycle { speed: 0.05, motor: 0.5 + 0.002 * H * f64::from(k), ..cycle });
            assert!(!used.is_stopped(), "{k}");
        }
    }
}

#[test]
fn an_error_beyond_its_threshold_or_no_number_stops_the_arm_and_names_the_joint() {
    for (error, joint) in [
        ([0.1, 0.49], None),
        ([-0.49, -0.49], None),
        ([0.1, 0.51], Some(1)),
        ([-0.51, 0.1], Some(0)),
        ([0.1, f64::NAN], Some(1)),
        ([0.6, 0.7], Some(0)),
        ([0.1, 0.5], Some(1)),
    ] {
        let mut detector = after(10, quiet);
        detector.check_tracking(&error);
        let expected = joint.map_or(ArmStatus::Following, |k| ArmStatus::Stopped(Fault::TrackingError(k)));
        assert_eq!((detector.status, detector.symptom), (expected, Symptom::Unknown), "{error:?}");
        assert_eq!(detector.is_stopped(), joint.is_some());
    }
}

#[test]
fn a_tracking_error_while_a_tension_is_missing_is_the_fault_of_what_lacks_it() {
    let missing = |k: u32| Cycle { tension: noisy(if k >= 100 { 3.0 } else { 40.0 }, k), ..quiet(k) };
    for (cycles, fault) in [(103, Fault::TrackingError(0)), (110, Fault::Cable(1))] {
        let mut detector = after(cycles, missing);
        detector.check_tracking(&[0.6, 0.0]);
        assert_eq!(detector.status, ArmStatus::Stopped(fault));
    }
}

#[test]
fn what_lacks_a_tension_is_told_by_how_it_fell_and_by_what_an_unchanged_encoder_has_not_shown() {
    // 36 N are missing; half of them are 0.72 mm of 25 N/mm.
    for before in [8.0, 18.0, 21.9, 22.1, 25.0, 40.0] {
        for unseen_mm in [-0.8, -0.73, -0.71, 0.0, 0.8] {
            let mut detector = after(10, quiet);
            detector.unchanged_travel[1] = [0.0, unseen_mm * 1e-3];
            let gradual = before - 4.0 < 18.0;
            let paid_out = unseen_mm < -0.72;
            let expected = match gradual && paid_out {
                true => (Fault::MotorSensor(1), Symptom::Stuck),
                false => (Fault::Cable(1), Symptom::Unknown),
            };
            assert_eq!(
                detector.cause_of_missing_tension(1, [before, 4.0], 40.0),
                expected,
                "{before} {unseen_mm}"
            );
        }
    }
}

#[test]
fn a_joint_encoder_that_jumped_before_is_why_a_cable_lacks_its_tension_one_that_reads_zero_is_not() {
    let cause = |joint: fn(u32) -> f64| {
        let found = stopped(|k| {
            let tension = noisy(if k >= 120 { 3.0 } else { 40.0 }, k);
            Cycle { tension, joint: joint(k), predicted: joint(0), ..quiet(k) }
        });
        found.map(|(_, fault, symptom)| (fault, symptom)).unwrap()
    };
    let cable = (Fault::Cable(1), Symptom::Unknown);
    assert_eq!(cause(|_| 0.0), cable);
    let jumped = cause(|k| if k >= 100 { 0.5 } else { 0.2 });
    assert_eq!(jumped, (Fault::JointSensor(1), Symptom::Jumped));
    let lost = cause(|k| if k >= 100 { f64::NAN } else { 0.2 });
    assert_eq!(lost, (Fault::JointSensor(1), Symptom::Lost));
}

#[test]
fn a_fault_that_has_lasted_for_exactly_its_persistence_time_does_not_stop_the_arm_yet() {
    type Change = fn(Cycle) -> Cycle;
    // The cycles that are the time: 0.03 and 0.25 s, and three of long ones for a motor encoder.
    let faults: [(f64, u32, Change, Fault); 4] = [
        (0.01, 3, |c| Cycle { motor: f64::NAN, ..c }, Fault::MotorSensor(1)),
        (0.02, 3, |c| Cycle { motor: f64::NAN, ..c }, Fault::MotorSensor(1)),
        (0.015, 2, |c| Cycle { tension: c.tension - 38.0, ..c }, Fault::Cable(1)),
        (0.125, 2, |c| Cycle { joint: f64::NAN, ..c }, Fault::JointSensor(1)),
    ];
    for (h, cycles, change, fault) in faults {
        let mut detector = detector();
        for k in 0..=4 + cycles {
            let cycle = if k >= 4 { change(quiet(k)) } else { quiet(k) };
            see_after(&mut detector, h, &quiet(k), &cycle);
            let stopped = detector.status == ArmStatus::Stopped(fault);
            assert_eq!(stopped, k == 4 + cycles, "{h} {k} {:?}", detector.status);
        }
    }
}

#[test]
fn what_has_been_missing_for_exactly_the_time_of_a_vibration_is_not_missing_yet() {
    let h = MISSING_TIME;
    let mut detector = detector();
    for k in 0..5 {
        let cycle = Cycle { joint: if k == 4 { f64::NAN } else { 0.2 }, ..quiet(k) };
        let tension = if k == 4 { 2.0 } else { noisy(40.0, k) };
        see_after(&mut detector, h, &quiet(k), &Cycle { tension, ..cycle });
    }
    assert!((detector.tension[1] - 2.0).abs() < 1e-15, "{}", detector.tension[1]);
    // The encoder was lost in the same cycle, so that the joint's replacement cannot be why.
    assert_eq!(detector.missing_by[1], (Fault::Cable(1), Symptom::Unknown));
    detector.check_tracking(&[0.6, 0.0]);
    assert_eq!(detector.status, ArmStatus::Stopped(Fault::TrackingError(0)));
}

#[test]
fn residuals_at_their_thresholds_are_not_beyond_them() {
    // In 0.1 s half of a residual is forgotten; it moves by itself.
    for (distance, fault) in [(-0.012, None), (-0.01201, Some(Fault::Drive(1)))] {
        let mut detector = detector();
        for (k, motor) in [(0, 0.0), (1, distance)] {
            see_after(&mut detector, 0.1, &quiet(k), &Cycle { motor, ..quiet(k) });
        }
        let expected = fault.map_or(ArmStatus::Following, ArmStatus::Stopped);
        assert_eq!(detector.status, expected, "{distance}");
    }
    // Tensions at a fifth of the estimate, and at the threshold of 8 N below it.
    for (estimated, tension) in [(40.0, (1.0 - MISSING_FRACTION) * 40.0), (9.0, 1.0)] {
        let mut detector = after(10, quiet);
        see(&mut detector, 10, &Cycle { estimated, tension, ..quiet(10) });
        assert!(detector.missing_for[1].abs() < 1e-18, "{estimated} {tension}");
    }
    // Half of what is missing is what the encoder has not shown.
    let mut detector = after(10, quiet);
    detector.unchanged_travel[1] = [0.0, -5e-4];
    assert_eq!(detector.cause_of_missing_tension(1, [20.0, 15.0], 40.0).0, Fault::Cable(1));
    assert_eq!(detector.cause_of_missing_tension(1, [20.0, 15.1], 40.0).0, Fault::MotorSensor(1));
    // Of no commanded travel none is confirmed.
    detector.unchanged_travel[1] = [0.0, 0.0];
    assert!(!detector.is_travel_confirmed(1, 0.0));
}

#[test]
fn a_winch_that_gathers_speed_by_itself_has_not_jumped() {
    // At 10 m/s^2 the 6 mm of r_v,max are passed after 35 ms.
    let moved = |k: u32| if k < 100 { 0.0 } else { 5.0 * (1e-3 * f64::from(k - 99)).powi(2) };
    let found = stopped(|k| Cycle { motor: 0.5 + moved(k), ..quiet(k) });
    let (k, fault, symptom) = found.unwrap();
    assert_eq!((fault, symptom), (Fault::Drive(1), Symptom::Unknown));
    assert!((134..142).contains(&k), "{k}");
}
