//! Lost and late cycles, and what drives report.

use super::bench::{Bench, FINE, H, LOST, carrying};
use sinew::control::arm::{Fault, Symptom};
use sinew::control::supervisor::{ExchangeStatus, FaultKind, Limits, Mode, Request};

/// Let down in a fifth of a second at most.
fn brief(limits: &mut Limits) {
    (limits.safety.holding_time, limits.safety.lowering_time) = (0.0, 0.05);
    limits.muscles.iter_mut().for_each(|muscle| muscle.largest_slack = 1e3);
}

/// A machine whose tensions rise indefinitely.
fn rising() -> Bench {
    let mut bench = Bench::new(carrying(0.0).map(|goal| 0.5 * goal), brief);
    assert_eq!(bench.step(Request::Pretension).mode, Mode::Pretension);
    bench
}

fn ready() -> Bench {
    let mut bench = Bench::new([0.0; 2], brief);
    assert_eq!(bench.step(Request::GetReady).mode, Mode::Ready);
    bench
}

/// A cycle that begins late by this time, s.
fn late(lateness: f64) -> ExchangeStatus {
    ExchangeStatus { lateness, ..FINE }
}

#[test]
fn readings_may_be_lost_for_four_milliseconds_and_not_for_five() {
    for mut bench in [ready(), rising()] {
        let before = bench.supervisor.mode();
        for _ in 0..20 {
            for _ in 0..4 {
                assert_eq!(bench.step_with(Request::None, LOST).mode, before);
            }
            assert_eq!(bench.step(Request::None).mode, before, "they begin anew");
        }
        let (cycles, found) = bench.until_left(Request::None, LOST, 20).unwrap();
        let expected = if before == Mode::Ready { Mode::Fault } else { Mode::SafeStop };
        assert_eq!((cycles, found.mode, found.kind()), (5, expected, Some(FaultKind::LostCycles)));
        assert_eq!(found.fault.unwrap().symptom, Symptom::Reported);
    }
}

#[test]
fn a_report_of_a_drive_that_there_is_not_is_no_fault() {
    for drive in [2, 7] {
        for mut bench in [ready(), rising()] {
            let before = bench.supervisor.mode();
            assert_eq!(
                bench.step_with(Request::None, ExchangeStatus { drive: Some(drive), ..FINE }).mode,
                before
            );
        }
    }
    let found = ready().step_with(Request::None, ExchangeStatus { drive: Some(1), ..FINE });
    assert_eq!(found.fault.map(|fault| fault.fault), Some(Fault::Drive(1)));
}

#[test]
fn cycles_that_are_late_by_less_than_a_quarter_of_a_period_are_in_time() {
    let mut bench = rising();
    assert_eq!(bench.until_left(Request::None, late(0.24 * H), 600).map(|(_, found)| found.mode), None);
    for lateness in [f64::NAN, f64::INFINITY] {
        assert_eq!(bench.step_with(Request::None, late(lateness)).mode, Mode::Pretension, "not known");
    }
    assert!(bench.until_left(Request::None, late(0.26 * H), 600).is_some());
}

#[test]
fn lateness_of_twenty_milliseconds_in_about_a_second_is_a_fault() {
    for lateness in [0.3e-3, 0.5e-3, 1e-3, 5e-3] {
        let (cycles, found) = rising().until_left(Request::None, late(lateness), 600).unwrap();
        assert_eq!((found.mode, found.kind()), (Mode::SafeStop, Some(FaultKind::LateCycles)));
        // A sum that is forgotten with a second; a cycle counts as a period at most.
        let (mut sum, mut expected) = (0.0, 0);
        while sum <= 0.02 {
            sum += lateness.min(H) - H * sum;
            expected += 1;
        }
        assert_eq!(cycles, expected, "{lateness}");
    }
}

#[test]
fn lateness_is_forgotten_in_seconds() {
    let mut bench = rising();
    let mut burst = |cycles: usize, then: usize| {
        let left = bench.until_left(Request::None, late(H), cycles);
        left.or_else(|| bench.until_left(Request::None, FINE, then)).map(|(_, found)| found.mode)
    };
    // 18 ms three times with seconds between them, then twice in a tenth of one.
    for _ in 0..3 {
        assert_eq!(burst(18, 2500), None);
    }
    assert_eq!(burst(18, 100), None);
    assert_eq!(burst(18, 100), Some(Mode::SafeStop));
}

#[test]
fn a_single_cycle_late_by_twelve_milliseconds_is_bridged_and_by_thirteen_is_not() {
    for (lateness, mode) in [(0.0122, Mode::Pretension), (0.0128, Mode::SafeStop), (0.5, Mode::SafeStop)] {
        assert_eq!(rising().step_with(Request::None, late(lateness)).mode, mode, "{lateness}");
    }
}

#[test]
fn lateness_is_no_fault_of_a_machine_without_tension() {
    let mut bench = ready();
    for lateness in [H, 0.1] {
        assert_eq!(bench.until_left(Request::None, late(lateness), 100).map(|(_, found)| found.mode), None);
    }
}

#[test]
fn a_reset_forgets_the_lateness_that_stopped_the_machine() {
    let mut bench = rising();
    bench.until_left(Request::None, late(H), 600).unwrap();
    bench.tension = [0.0; 2];
    let (_, down) = bench.until_left(Request::None, FINE, 300).unwrap();
    assert_eq!((down.mode, down.kind()), (Mode::Fault, Some(FaultKind::LateCycles)));
    assert_eq!(bench.step(Request::Reset).mode, Mode::Ready);
    assert_eq!(bench.step(Request::Pretension).mode, Mode::Pretension);
    // As many as at first.
    let (cycles, _) = bench.until_left(Request::None, late(H), 600).unwrap();
    assert_eq!(cycles, 21);
}

#[test]
fn limits_are_kept_where_there_is_tension_and_not_where_there_is_none() {
    let outside = |limits: &mut Limits| {
        brief(limits);
        limits.ranges[0] = Some([0.5, 0.6]);
    };
    let mut bench = Bench::new([0.0; 2], outside);
    assert_eq!(bench.steps(50, Request::GetReady).mode, Mode::Ready, "it may lie anywhere");
    let (cycles, found) = {
        assert_eq!(bench.step(Request::Pretension).mode, Mode::Pretension, "it begins anew");
        bench.until_left(Request::Pretension, FINE, 100).unwrap()
    };
    assert_eq!((found.mode, found.kind()), (Mode::SafeStop, Some(FaultKind::JointRange)));
    assert!((9..=11).contains(&cycles), "{cycles}");
}
