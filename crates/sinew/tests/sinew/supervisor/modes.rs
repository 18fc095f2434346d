//! Requests, modes and what the drives do in them.

use super::bench::{Bench, FINE, LOST, STANDING, carrying, controller};
use sinew::control::arm::{ArmStatus, Fault};
use sinew::control::supervisor::{ExchangeStatus, FaultKind, Limits, Mode, MuscleState, Request};
use sinew::drive::DriveCommand;

/// Let down within a quarter of a second.
fn brief(limits: &mut Limits) {
    (limits.safety.holding_time, limits.safety.lowering_time) = (0.05, 0.2);
    limits.muscles.iter_mut().for_each(|muscle| muscle.largest_slack = 1e3);
}

/// Tensions with which pretension goes on indefinitely.
fn half_tense() -> [f64; 2] {
    carrying(0.0).map(|goal| 0.5 * goal)
}

#[test]
fn amplifiers_are_off_until_power_is_asked_for_and_then_the_winches_stand() {
    let slack = controller().gains().muscles[0].slack_tension;
    let mut bench = Bench::new([slack, 1.01 * slack], brief);
    let off = bench.steps(3, Request::None);
    assert_eq!((off.mode, off.drives), (Mode::Off, [DriveCommand::Off; 2]));
    assert_eq!((off.status, off.fault), (ArmStatus::Holding, None));
    assert_eq!(off.muscles, [MuscleState::Relaxed; 2]);
    let ready = bench.step(Request::GetReady);
    assert_eq!((ready.mode, ready.drives), (Mode::Ready, [STANDING; 2]));
    assert_eq!(ready.muscles, [MuscleState::Relaxed, MuscleState::Tense], "tense above the limit of slack");
    let off = bench.step(Request::TurnOff);
    assert_eq!((off.mode, off.drives), (Mode::Off, [DriveCommand::Off; 2]));
}

#[test]
fn what_is_shown_while_nothing_is_controlled_is_the_measured_pose() {
    let mut bench = Bench::new(half_tense(), brief);
    bench.rest_in(0.4);
    for request in [Request::None, Request::GetReady, Request::Pretension, Request::SafeStop] {
        bench.joint += 0.01;
        assert_eq!(bench.step(request).reference.q, [bench.joint]);
    }
    bench.joint = f64::NAN;
    assert_eq!(bench.step(Request::None).reference.q, [0.4], "where it is not measured the given one");
}

#[test]
fn a_machine_under_tension_is_let_down_before_it_is_ready_or_off() {
    for (request, end) in
        [(Request::SafeStop, Mode::Ready), (Request::GetReady, Mode::Ready), (Request::TurnOff, Mode::Off)]
    {
        let mut bench = Bench::new([100.0; 2], |limits| {
            brief(limits);
            limits.muscles.iter_mut().for_each(|muscle| muscle.lowering_speed = 0.01);
        });
        bench.tension = half_tense();
        assert_eq!(bench.steps(20, Request::Pretension).mode, Mode::Pretension);
        // What was tightened comes to rest, and then stands for 50 ms.
        for cycle in 1..=49 {
            let stopped = bench.step(request);
            assert_eq!((stopped.mode, stopped.fault), (Mode::SafeStop, None), "{cycle}");
            assert_eq!(stopped.muscles, [MuscleState::Tense; 2]);
            assert!(cycle < 10 || stopped.drives == [STANDING; 2], "{cycle}: {stopped:?}");
        }
        let lowered = bench.steps(10, request);
        assert!(lowered.speeds().iter().all(|speed| *speed < 0.0), "{lowered:?}");
        assert_eq!(lowered.muscles, [MuscleState::LettingDown; 2]);
        bench.tension = [0.0; 2];
        let (_, down) = bench.until_left(request, FINE, 200).unwrap();
        assert_eq!((down.mode, down.fault), (end, None));
        assert_eq!(down.muscles, [MuscleState::Relaxed; 2]);
    }
}

#[test]
fn a_request_counts_once_so_that_a_fault_that_remains_is_not_reset_again_and_again() {
    let mut bench = Bench::new([0.0; 2], brief);
    let failed = ExchangeStatus { drive: Some(1), ..FINE };
    assert_eq!(bench.step(Request::GetReady).mode, Mode::Ready);
    assert_eq!(bench.step_with(Request::GetReady, failed).mode, Mode::Fault);
    assert_eq!(bench.step_with(Request::GetReady, FINE).mode, Mode::Fault, "latched");
    assert_eq!(bench.step_with(Request::Reset, FINE).mode, Mode::Ready);
    assert_eq!(bench.step_with(Request::Reset, failed).mode, Mode::Fault);
    for _ in 0..5 {
        assert_eq!(bench.step_with(Request::Reset, FINE).mode, Mode::Fault);
    }
    assert_eq!(bench.step(Request::None).mode, Mode::Fault);
    assert_eq!(bench.step(Request::Reset).mode, Mode::Ready);
}

#[test]
fn a_fault_is_latched_with_its_drive_braked_until_it_is_reset() {
    for muscle in [0, 1] {
        let mut bench = Bench::new([0.0; 2], brief);
        bench.step(Request::GetReady);
        let failed = bench.step_with(Request::GetReady, ExchangeStatus { drive: Some(muscle), ..FINE });
        let mut expected = [STANDING; 2];
        expected[muscle] = DriveCommand::Brake;
        let mut states = [MuscleState::Relaxed; 2];
        states[muscle] = MuscleState::Braked;
        for found in [failed, bench.step(Request::GetReady), bench.step(Request::Run)] {
            assert_eq!((found.mode, found.drives, found.muscles), (Mode::Fault, expected, states));
            assert_eq!(found.kind(), Some(FaultKind::DriveFault));
            assert_eq!(found.status, ArmStatus::Stopped(Fault::Drive(muscle)));
        }
        let ready = bench.step(Request::Reset);
        assert_eq!((ready.mode, ready.drives, ready.fault), (Mode::Ready, [STANDING; 2], None));
        assert_eq!((ready.muscles, ready.status), ([MuscleState::Relaxed; 2], ArmStatus::Holding));
        // Without power nothing is braked any more, either.
        bench.step_with(Request::None, ExchangeStatus { drive: Some(muscle), ..FINE });
        let off = bench.step(Request::TurnOff);
        assert_eq!((off.mode, off.drives, off.fault), (Mode::Off, [DriveCommand::Off; 2], None));
        assert_eq!(bench.step(Request::GetReady).drives, [STANDING; 2]);
    }
}

#[test]
fn what_a_machine_without_power_reports_is_no_fault_until_it_has_been_on_for_a_cycle() {
    for exchange in [ExchangeStatus { drive: Some(0), ..FINE }, LOST] {
        let mut bench = Bench::new([0.0; 2], brief);
        (0..20).for_each(|_| assert_eq!(bench.step_with(Request::None, exchange).mode, Mode::Off));
        let on = bench.step_with(Request::GetReady, exchange);
        assert_eq!((on.mode, on.fault), (Mode::Ready, None));
        assert_eq!(bench.step_with(Request::GetReady, exchange).mode, Mode::Fault);
    }
}

#[test]
fn a_fault_while_tensions_rise_ends_in_a_safe_stop_then_in_the_mode_of_faults() {
    let mut bench = Bench::new(half_tense(), brief);
    bench.steps(20, Request::Pretension);
    let failed = ExchangeStatus { drive: Some(0), ..FINE };
    let stopped = bench.step_with(Request::Pretension, failed);
    assert_eq!((stopped.mode, stopped.drives[0]), (Mode::SafeStop, DriveCommand::Brake));
    assert_eq!(stopped.muscles, [MuscleState::Braked, MuscleState::Tense]);
    for _ in 0..50 {
        // A goal that is asked for meanwhile does not end it.
        let stopped = bench.step(Request::Run);
        assert_eq!((stopped.mode, stopped.kind()), (Mode::SafeStop, Some(FaultKind::DriveFault)));
    }
    let (_, ended) = bench.until_left(Request::Run, FINE, 300).unwrap();
    assert_eq!((ended.mode, ended.kind()), (Mode::Fault, Some(FaultKind::DriveFault)));
    assert_eq!(ended.drives[0], DriveCommand::Brake);
    assert_eq!(ended.muscles, [MuscleState::Braked, MuscleState::Tense]);
}

#[test]
fn a_winch_whose_travel_speed_or_heat_is_at_fault_is_braked_and_one_whose_tension_is_not() {
    let stop = |change: fn(&mut Limits), tension: f64| {
        let mut bench = Bench::new([half_tense()[0], tension], |limits| {
            brief(limits);
            change(limits);
        });
        let (_, stopped) = {
            bench.step(Request::Pretension);
            bench.until_left(Request::Pretension, FINE, 100).unwrap()
        };
        assert_eq!(stopped.mode, Mode::SafeStop);
        (stopped.kind().unwrap(), stopped.drives[1] == DriveCommand::Brake, stopped.muscles[1])
    };
    let half = half_tense()[1];
    let travel = stop(|limits| limits.muscles[1].travel = Some([0.0, 0.1]), half);
    assert_eq!(travel, (FaultKind::Travel, true, MuscleState::Braked));
    let heat = |limits: &mut Limits| {
        limits.muscles[1].motor = Some((sinew::drive::DriveParameters::mc_am(), 20.0));
    };
    assert_eq!(stop(heat, half), (FaultKind::Overheating, true, MuscleState::Braked));
    let overload = stop(|limits| limits.muscles[1].tension = 1.0, half);
    assert_eq!(overload, (FaultKind::Overload, false, MuscleState::Faulty));
    let range = stop(|limits| limits.ranges[0] = Some([0.1, 0.2]), half);
    assert_eq!(range, (FaultKind::JointRange, false, MuscleState::Tense));
}

#[test]
fn a_reset_while_it_is_let_down_takes_the_place_of_no_stop() {
    for (stop, end) in
        [(Request::SafeStop, Mode::Ready), (Request::GetReady, Mode::Ready), (Request::TurnOff, Mode::Off)]
    {
        let mut bench = Bench::new(half_tense(), brief);
        bench.steps(20, Request::Pretension);
        assert_eq!(bench.step(stop).mode, Mode::SafeStop);
        assert_eq!(bench.steps(3, Request::Reset).mode, Mode::SafeStop);
        let (_, down) = bench.until_left(Request::None, FINE, 400).unwrap();
        assert_eq!((down.mode, down.fault), (end, None), "{stop:?}");
        assert_eq!(bench.steps(20, Request::None).mode, end, "nothing moves again");
    }
}

#[test]
fn turning_off_is_undone_by_no_fault_and_by_no_reset_on_the_way() {
    for early in [Request::TurnOff, Request::Reset] {
        let mut bench = Bench::new(half_tense(), brief);
        bench.steps(20, Request::Pretension);
        let failed = ExchangeStatus { drive: Some(0), ..FINE };
        assert_eq!(bench.step_with(Request::Pretension, failed).mode, Mode::SafeStop);
        assert_eq!(bench.steps(3, Request::TurnOff).kind(), Some(FaultKind::DriveFault), "still named");
        bench.step(early);
        let (_, ended) = bench.until_left(early, FINE, 400).unwrap();
        assert_eq!((ended.mode, ended.drives), (Mode::Off, [DriveCommand::Off; 2]), "{early:?}");
    }
    // In one cycle with the fault.
    let mut bench = Bench::new([0.0; 2], brief);
    bench.step(Request::GetReady);
    let failed = ExchangeStatus { drive: Some(0), ..FINE };
    assert_eq!(bench.step_with(Request::TurnOff, failed).mode, Mode::Off);
}
