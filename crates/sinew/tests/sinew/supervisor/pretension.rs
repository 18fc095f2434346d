//! Slack is wound in, then all tensions rise together.

use super::bench::{Bench, H, carrying, compliance, controller};
use sinew::control::arm::{Fault, Symptom};
use sinew::control::supervisor::{FaultKind, Limits, Mode, MuscleState, Request};

/// Tension below which a cable is slack, N.
const SLACK: f64 = 0.5;
/// s; another time than 1, for which a product and a quotient are the same.
const RISE: f64 = 0.5;

/// Limits of pretension: winches take up at 20 mm/s.
fn slow(limits: &mut Limits) {
    for muscle in &mut limits.muscles {
        (muscle.slack_tension, muscle.wind_in_speed, muscle.largest_slack) = (SLACK, 0.02, 10.0);
    }
    limits.safety.pretension_time = RISE;
}

#[test]
fn cables_are_tense_from_six_tenths_of_the_tensions_that_carry_the_limb_in_its_measured_pose() {
    for (q, measured) in [(0.0, true), (0.6, true), (-0.6, true), (0.6, false)] {
        let goal = carrying(q);
        let mode = |fractions: [f64; 2]| {
            let mut bench = Bench::new([fractions[0] * goal[0], fractions[1] * goal[1]], slow);
            // Where the joint is not measured the reference tells its pose.
            bench.rest_in(if measured { -0.3 } else { q });
            bench.joint = if measured { q } else { f64::NAN };
            bench.step(Request::Pretension).mode
        };
        assert_eq!(mode([0.615, 0.615]), Mode::Hold, "{q}");
        for fractions in [[0.585, 0.7], [0.7, 0.585], [0.0, 0.0]] {
            assert_eq!(mode(fractions), Mode::Pretension, "{q} {fractions:?}");
        }
    }
}

#[test]
fn slack_is_taken_up_at_its_speed_which_a_winch_reaches_with_its_acceleration() {
    let mut bench = Bench::new([0.0; 2], |limits| {
        slow(limits);
        limits.muscles[1].wind_in_speed = 0.013;
    });
    let gain = controller().gains().muscles[0].max_winch_acceleration * H;
    let first = bench.step(Request::Pretension);
    assert!(first.speeds().iter().all(|speed| speed.abs() < 1e-12), "nothing is lacking yet: {first:?}");
    assert_eq!(first.muscles, [MuscleState::TakingUp; 2]);
    for cycle in 1..=20 {
        let most = gain * f64::from(cycle);
        let found = bench.step(Request::Pretension);
        for (speed, expected) in found.speeds().iter().zip([most.min(0.02), most.min(0.013)]) {
            assert!((speed - expected).abs() < 1e-12, "{cycle}: {speed} {expected}");
        }
        assert_eq!((found.mode, found.fault), (Mode::Pretension, None));
    }
    assert!(20.0 * gain > 0.02 && 2.0 * gain < 0.02, "{gain}");
}

#[test]
fn a_taut_cable_is_tightened_by_its_compliance_toward_a_target_that_waits_for_the_slackest_one() {
    let goal = carrying(0.0);
    let tension = [0.2 * goal[0], 0.3 * goal[1]];
    assert!(tension[0] > 2.0 * SLACK);
    let mut bench = Bench::new(tension, |limits| {
        slow(limits);
        limits.muscles.iter_mut().for_each(|muscle| muscle.wind_in_speed = 1.0);
    });
    // While T >= s T*/2 - T_s.
    let last = 2.0 * (tension[0] + SLACK) / goal[0];
    assert!(last < 0.7);
    for cycle in 0..400_u32 {
        let fraction = (f64::from(cycle) * H / RISE).min(last);
        for (k, speed) in bench.step(Request::Pretension).speeds().into_iter().enumerate() {
            let expected = (fraction * goal[k] - tension[k]).max(0.0) * compliance() / 0.1;
            // One step of the fraction.
            let step = H / RISE * goal[k] * compliance() / 0.1;
            assert!((speed - expected).abs() < 1.01 * step, "{cycle}: {speed} {expected} {step}");
        }
    }
}

/// Two cables as springs: the cycle in which pretension is left, the mode then, the tensions of every cycle,
/// N.
fn taken_up(bench: &mut Bench, slack: [f64; 2]) -> (usize, Mode, Vec<[f64; 2]>) {
    let mut wound = slack.map(|slack| -slack);
    let mut tensions = Vec::new();
    for cycle in 1..4000 {
        bench.tension = wound.map(|wound| wound.max(0.0) / compliance());
        tensions.push(bench.tension);
        let found = bench.step(Request::Pretension);
        if found.mode != Mode::Pretension {
            return (cycle, found.mode, tensions);
        }
        for (wound, speed) in wound.iter_mut().zip(found.speeds()) {
            assert!((0.0..=0.0200001).contains(&speed), "no winch pays out: {speed}");
            *wound += H * speed;
        }
    }
    panic!("no end: {:?}", tensions.last());
}

#[test]
fn the_tensions_of_springs_rise_together_in_their_time_and_then_the_pose_is_held() {
    let goal = carrying(0.0);
    let (cycles, mode, tensions) = taken_up(&mut Bench::new([0.0; 2], slow), [0.0; 2]);
    // The fraction is 1 after its time, and the tensions follow by 0.1 s.
    assert_eq!(mode, Mode::Hold);
    assert!((500..=502).contains(&cycles), "{cycles}");
    for (k, goal) in goal.iter().enumerate() {
        let (lag, time) = (0.1, 0.4);
        let expected = goal / RISE * (time - lag * (1.0 - f64::exp(-time / lag)));
        assert!((tensions[400][k] / expected - 1.0).abs() < 2e-3, "{} {expected}", tensions[400][k]);
    }
}

#[test]
fn a_taut_cable_waits_for_one_whose_slack_is_taken_up() {
    let goal = carrying(0.0);
    let slack = 5e-3;
    let (cycles, mode, tensions) = taken_up(&mut Bench::new([0.0; 2], slow), [0.0, slack]);
    let taken = (slack / 0.02 / H) as usize;
    assert_eq!(mode, Mode::Hold);
    assert!((taken + 450..taken + 500).contains(&cycles), "{cycles}");
    // Until then the other has no more than the fraction at which a slack cable still counts.
    let most = 1.05 * 2.0 * SLACK / goal[1] * goal[0];
    assert!(tensions[..taken].iter().all(|tension| tension[0] < most), "{most} {:?}", tensions[taken]);
    assert!(tensions[taken - 1][1] < 1e-9 && tensions[taken - 1][0] > 0.8 * most);
}

#[test]
fn tensions_that_are_there_before_the_ramp_is_over_do_not_end_it() {
    let goal = carrying(0.0);
    let mut bench = Bench::new([0.3 * goal[0], 0.3 * goal[1]], slow);
    assert_eq!(bench.step(Request::Pretension).mode, Mode::Pretension);
    bench.tension = goal;
    let (cycle, held) = bench.until_left(Request::Pretension, super::bench::FINE, 1000).unwrap();
    assert_eq!(held.mode, Mode::Hold);
    assert!((499..=501).contains(&cycle), "{cycle}");
    // And the end of the ramp is none without them.
    let mut bench = Bench::new([0.5 * goal[0], 0.5 * goal[1]], slow);
    assert_eq!(bench.steps(1500, Request::Pretension).mode, Mode::Pretension);
}

#[test]
fn more_slack_than_the_largest_is_a_fault_of_its_cable_that_stops_the_machine() {
    let goal = carrying(0.0);
    for (k, largest) in [(0, 2e-3), (1, 4e-3)] {
        let mut bench = Bench::new([goal[0], goal[1]], |limits| {
            slow(limits);
            limits.muscles[k].largest_slack = largest;
        });
        bench.tension[k] = 0.0;
        // Twice: what was taken up before a new start does not count.
        for _ in 0..2 {
            let (cycles, stopped) = {
                bench.step(Request::Pretension);
                bench.until_left(Request::Pretension, super::bench::FINE, 3000).unwrap()
            };
            // Beyond the stretch at its target it is slack; the winch accelerates for four cycles.
            let expected = (largest + goal[k] * compliance()) / 0.02 / H;
            assert!((cycles as f64 - expected).abs() < 4.0, "{cycles} {expected}");
            assert_eq!(stopped.mode, Mode::SafeStop);
            let fault = stopped.fault.unwrap();
            assert_eq!((fault.fault, fault.symptom), (Fault::Slack(k), Symptom::Unknown));
            let speeds = stopped.speeds();
            assert!(speeds.iter().all(|speed| speed.is_finite()), "no drive is braked: {stopped:?}");
            bench.tension = [0.0; 2];
            let (_, down) = bench.until_left(Request::None, super::bench::FINE, 3000).unwrap();
            assert_eq!(down.mode, Mode::Fault);
            bench.tension[1 - k] = goal[1 - k];
            assert_eq!(bench.step(Request::Reset).mode, Mode::Ready);
        }
    }
}

#[test]
fn a_cable_whose_load_cell_is_silent_is_not_tightened_and_stops_the_machine_after_a_tenth_of_a_second() {
    let goal = carrying(0.0);
    let mut bench = Bench::new([f64::NAN, 0.5 * goal[1]], slow);
    let stopped = (0..1500).find(|_| {
        let found = bench.step(Request::Pretension);
        assert_eq!(found.speeds()[0].to_bits(), 0.0_f64.to_bits());
        if found.mode == Mode::SafeStop {
            let fault = found.fault.map(|named| (named.kind(), named.fault));
            assert_eq!(fault, Some((FaultKind::SensorLost, Fault::TensionSensor(0))));
        }
        found.mode == Mode::SafeStop
    });
    assert!(stopped.is_some_and(|cycle| (99..=101).contains(&cycle)), "{stopped:?}");
}

#[test]
fn a_load_cell_that_is_silent_for_less_than_a_tenth_of_a_second_again_and_again_is_waited_for() {
    let goal = carrying(0.0);
    let mut bench = Bench::new([0.5 * goal[0], 0.5 * goal[1]], slow);
    for cycle in 0..1500 {
        bench.tension[0] = if cycle % 90 < 80 { f64::NAN } else { 0.5 * goal[0] };
        assert_eq!(bench.step(Request::Pretension).mode, Mode::Pretension, "{cycle}");
    }
}
