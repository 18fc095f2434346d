//! Modes in which the controller commands the winches, with the readings of a twin.

use super::bench::{Bench, FINE, H, LOST, controller};
use sinew::control::arm::{ArmStatus, Fault, Symptom};
use sinew::control::supervisor::{ExchangeStatus, FaultKind, Limits, Mode, MuscleState, Request};
use sinew::drive::DriveCommand;

fn brief(limits: &mut Limits) {
    (limits.safety.holding_time, limits.safety.lowering_time) = (0.01, 0.05);
}

/// A machine that hangs tense and runs at rest.
fn running() -> Bench {
    let mut bench = Bench::live(brief);
    let first = bench.step(Request::Run);
    assert_eq!((first.mode, first.fault), (Mode::Run, None), "from off at once: its cables are tense");
    bench.steps(30, Request::Run);
    bench
}

fn holding() -> Bench {
    let mut bench = Bench::live(brief);
    assert_eq!(bench.step(Request::Hold).mode, Mode::Hold);
    bench.steps(30, Request::Hold);
    bench
}

/// `w e_q`, rad/s^2, and `e_q`, rad.
fn braking() -> (f64, f64) {
    let joint = controller().gains().joints[0];
    (joint.bandwidth * joint.tracking_error, joint.tracking_error)
}

#[test]
fn a_tense_machine_runs_at_once_and_follows_its_reference() {
    let mut bench = running();
    for _ in 0..300 {
        bench.lead(0.4);
        let found = bench.step(Request::Run);
        assert_eq!((found.mode, found.fault, found.status), (Mode::Run, None, ArmStatus::Following));
        assert_eq!(found.muscles, [MuscleState::Tense; 2]);
        assert_eq!(found.reference, bench.reference, "the given one is followed");
    }
    let (moved, error) = (bench.reference.q[0], bench.reference.q[0] - bench.joint);
    assert!(moved > 0.11 && error.abs() < 3e-3, "{moved} {error}");
}

#[test]
fn a_pose_is_held_whatever_the_reference_and_run_waits_until_it_is_near() {
    let (_, largest) = braking();
    let mut bench = holding();
    let pose = bench.joint;
    bench.rest_in(pose + 0.3 * largest);
    for request in [Request::Hold, Request::Run] {
        for _ in 0..50 {
            let found = bench.step(request);
            assert_eq!((found.mode, found.fault), (Mode::Hold, None));
            assert!((found.reference.q[0] - pose).abs() < 1e-9 && (bench.joint - pose).abs() < 1e-3);
        }
    }
    // The request is remembered.
    bench.rest_in(pose + 0.15 * largest);
    assert_eq!(bench.step(Request::None).mode, Mode::Run);
}

#[test]
fn a_motion_that_is_left_for_hold_is_braked_without_a_step() {
    let (deceleration, _) = braking();
    let mut bench = running();
    let mut speed = 0.0;
    while speed < 0.4 {
        speed += 2e-3;
        bench.lead(speed);
        bench.step(Request::Run);
    }
    // Wherever the reference goes then.
    let mut last = bench.reference.q[0];
    bench.rest_in(-0.3);
    for cycle in 1..=200_u32 {
        let found = bench.step(Request::Hold);
        let expected = (speed - deceleration * H * f64::from(cycle)).max(0.0);
        assert_eq!((found.mode, found.fault), (Mode::Hold, None));
        assert!(
            (found.reference.v[0] - expected).abs() < 1e-9,
            "{cycle}: {} {expected}",
            found.reference.v[0]
        );
        assert!((found.reference.q[0] - last - H * expected).abs() < 1e-9);
        last = found.reference.q[0];
    }
    assert!((bench.joint - last).abs() < 0.015, "{} {last}", bench.joint);
}

#[test]
fn a_stale_command_ends_in_hold_and_a_fresh_one_does_not_move_the_machine_without_a_new_request() {
    let age = |age: f64| ExchangeStatus { command_age: Some(age), ..FINE };
    for stale in [0.1001, 3.0, f64::NAN] {
        let mut bench = running();
        assert_eq!(bench.step_with(Request::Run, age(0.1)).mode, Mode::Run, "as old as allowed");
        for exchange in [age(stale), age(0.0), FINE] {
            let found = bench.step_with(Request::Run, exchange);
            assert_eq!((found.mode, found.kind()), (Mode::Hold, Some(FaultKind::StaleCommand)), "{stale}");
            assert_eq!(found.fault.unwrap().symptom, Symptom::Reported);
            assert_eq!(found.muscles, [MuscleState::Tense; 2], "it is no fault of a muscle");
        }
        bench.step(Request::None);
        let found = bench.step(Request::Run);
        assert_eq!((found.mode, found.fault), (Mode::Run, None));
    }
}

#[test]
fn a_stop_that_is_asked_for_after_a_stale_command_is_not_one_of_a_fault() {
    let mut bench = running();
    let stale = ExchangeStatus { command_age: Some(1.0), ..FINE };
    assert_eq!(bench.step_with(Request::Run, stale).mode, Mode::Hold);
    let stopped = bench.step(Request::SafeStop);
    assert_eq!((stopped.mode, stopped.fault), (Mode::SafeStop, None));
    let (_, down) = bench.until_left(Request::SafeStop, FINE, 300).unwrap();
    assert_eq!((down.mode, down.fault), (Mode::Ready, None));
}

#[test]
fn a_lost_cycle_is_bridged_and_reported_and_the_fifth_stops_the_machine() {
    for mut bench in [running(), holding()] {
        let before = bench.supervisor.mode();
        for cycle in 1..=4 {
            let found = bench.step_with(Request::None, LOST);
            assert_eq!((found.mode, found.kind()), (before, Some(FaultKind::LostCycles)), "{cycle}");
            assert_eq!(found.fault.unwrap().symptom, Symptom::Reported);
            assert_eq!(found.status, ArmStatus::Degraded(Fault::Bus));
            assert_eq!(found.muscles, [MuscleState::Estimated; 2]);
        }
        let mut back = bench.clone();
        let found = back.steps(10, Request::None);
        assert_eq!((found.mode, found.fault, found.muscles), (before, None, [MuscleState::Tense; 2]));
        let found = bench.step_with(Request::None, LOST);
        assert_eq!((found.mode, found.kind()), (Mode::SafeStop, Some(FaultKind::LostCycles)));
        assert_eq!(found.status, ArmStatus::Stopped(Fault::Bus));
        assert!(found.speeds().iter().all(|speed| speed.is_finite()), "no drive is braked: {found:?}");
    }
}

#[test]
fn a_cycle_later_than_a_period_is_reported() {
    for mut bench in [running(), holding()] {
        let before = bench.supervisor.mode();
        for (lateness, reported) in [(0.9 * H, None), (H, None), (1.1 * H, Some(FaultKind::LateCycles))] {
            let found = bench.step_with(Request::None, ExchangeStatus { lateness, ..FINE });
            assert_eq!((found.mode, found.kind()), (before, reported), "{lateness}");
            assert_eq!(matches!(found.status, ArmStatus::Degraded(Fault::LateCycles)), reported.is_some());
            assert!(found.fault.is_none_or(|fault| fault.symptom == Symptom::Reported));
        }
    }
}

#[test]
fn a_lost_load_cell_is_replaced_by_its_estimate_and_named_by_its_symptom() {
    let mut bench = running();
    for muscle in [1, 0] {
        for _ in 0..100 {
            bench.tension[muscle] = f64::NAN;
            let found = bench.step(Request::Run);
            let mut states = [MuscleState::Tense; 2];
            states[muscle] = MuscleState::Estimated;
            assert_eq!((found.mode, found.muscles), (Mode::Run, states));
            assert_eq!(found.status, ArmStatus::Degraded(Fault::TensionSensor(muscle)));
            assert_eq!(found.kind(), Some(FaultKind::SensorLost));
            assert_eq!(found.fault.unwrap().symptom, Symptom::Lost);
        }
        assert_eq!(bench.steps(10, Request::Run).fault, None);
    }
}

#[test]
fn a_drive_at_fault_is_braked_in_the_same_cycle_and_after_a_reset_the_machine_holds_again() {
    for muscle in [0, 1] {
        let mut bench = running();
        let stopped = bench.step_with(Request::Run, ExchangeStatus { drive: Some(muscle), ..FINE });
        assert_eq!((stopped.mode, stopped.muscles[muscle]), (Mode::SafeStop, MuscleState::Braked));
        assert_ne!(stopped.muscles[1 - muscle], MuscleState::Braked);
        assert_eq!(stopped.drives[muscle], DriveCommand::Brake);
        assert!(stopped.speeds()[1 - muscle].is_finite(), "{stopped:?}");
        assert_eq!(stopped.status, ArmStatus::Stopped(Fault::Drive(muscle)));
        assert_eq!(stopped.fault.map(|fault| fault.symptom), Some(Symptom::Reported));
        let (_, ended) = bench.until_left(Request::Run, FINE, 300).unwrap();
        assert_eq!((ended.mode, ended.drives[muscle]), (Mode::Fault, DriveCommand::Brake));
        bench.hang();
        assert_eq!(bench.step(Request::Run).mode, Mode::Fault, "latched");
        assert_eq!(bench.step(Request::Reset).mode, Mode::Ready);
        assert_eq!(bench.step(Request::Hold).mode, Mode::Hold);
        let held = bench.steps(50, Request::Hold);
        assert_eq!((held.mode, held.fault, held.muscles), (Mode::Hold, None, [MuscleState::Tense; 2]));
        assert_eq!(bench.step(Request::Run).mode, Mode::Run);
    }
}

#[test]
fn a_lost_motor_encoder_is_bridged_for_thirty_milliseconds_and_then_its_drive_is_braked() {
    for muscle in [0, 1] {
        let mut bench = running();
        let mut cycles = 0;
        let stopped = loop {
            bench.motor[muscle] = f64::NAN;
            let found = bench.step(Request::Run);
            assert_eq!(found.kind(), Some(FaultKind::SensorLost));
            if found.mode != Mode::Run {
                break found;
            }
            assert_eq!(found.status, ArmStatus::Degraded(Fault::MotorSensor(muscle)));
            cycles += 1;
        };
        assert!((29..=31).contains(&cycles), "{cycles}");
        assert_eq!(stopped.status, ArmStatus::Stopped(Fault::MotorSensor(muscle)));
        assert_eq!((stopped.mode, stopped.drives[muscle]), (Mode::SafeStop, DriveCommand::Brake));
        assert!(stopped.speeds()[1 - muscle].is_finite());
    }
}

#[test]
fn an_overload_and_a_joint_out_of_reach_stop_all_winches_and_brake_none() {
    let mut bench = running();
    let mut limits = bench.supervisor.limits().clone();
    limits.muscles[1].tension = 1.0;
    bench.supervisor.set_limits(limits).unwrap();
    let (cycles, stopped) = bench.until_left(Request::Run, FINE, 100).unwrap();
    assert!((9..=12).contains(&cycles), "{cycles}");
    assert_eq!((stopped.mode, stopped.kind()), (Mode::SafeStop, Some(FaultKind::Overload)));
    assert_eq!(stopped.muscles[1], MuscleState::Faulty);
    assert!(stopped.speeds().iter().all(|speed| speed.is_finite()));

    let mut bench = running();
    bench.rest_in(1.01 * braking().1);
    let stopped = bench.step(Request::Run);
    assert_eq!((stopped.mode, stopped.kind()), (Mode::SafeStop, Some(FaultKind::TrackingError)));
    assert!(!stopped.muscles.contains(&MuscleState::Faulty), "a joint is no muscle: {stopped:?}");
    assert!(stopped.speeds().iter().all(|speed| speed.is_finite()));
}

#[test]
fn a_fault_precedes_every_request() {
    for request in [Request::Hold, Request::SafeStop, Request::TurnOff] {
        let mut bench = running();
        let found = bench.step_with(request, ExchangeStatus { drive: Some(0), ..FINE });
        assert_eq!((found.mode, found.kind()), (Mode::SafeStop, Some(FaultKind::DriveFault)), "{request:?}");
    }
}

#[test]
fn tensions_are_followed_while_the_machine_runs_and_forgotten_when_it_holds() {
    let mut bench = running();
    let least = bench.step(Request::Run).desired_tension;
    assert!(least.iter().all(|least| *least < 30.0), "{least:?}");
    assert!(bench.supervisor.set_tensions(Some(&[50.0; 3])).is_err(), "of another machine");
    bench.supervisor.set_tensions(Some(&[60.0; 2])).unwrap();
    let followed = bench.steps(100, Request::Run).desired_tension;
    assert!(followed.iter().all(|followed| (followed - 60.0).abs() < 1e-9), "{followed:?}");
    let held = bench.steps(2, Request::Hold).desired_tension;
    assert!(held.iter().zip(least).all(|(held, least)| (held - least).abs() < 0.1), "{held:?} {least:?}");
    // Where the machine does not run none are taken.
    bench.supervisor.set_tensions(Some(&[60.0; 3])).unwrap();
    bench.supervisor.set_tensions(Some(&[60.0; 2])).unwrap();
    let held = bench.steps(50, Request::Hold).desired_tension;
    assert!(held.iter().zip(least).all(|(held, least)| (held - least).abs() < 0.1), "{held:?} {least:?}");
}
