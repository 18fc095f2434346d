//! Limits from a machine's file.

use super::bench::{Bench, H, controller};
use sinew::control::arm::{ActuationMode, ArmController, ArmGains, CableStateSource, Fault};
use sinew::control::supervisor::{CableHealth, Limits, Mode, Request, Supervisor, Threshold};
use sinew::machine::Machine;
use sinew::predictor::CableModel;

/// Muscles on two hinges and a slide with known moment arms: 30 mm on both hinges, 40 mm on the first, 1 on
/// the slide.
fn fixed_arms() -> Machine {
    let text = include_str!("../machine/every_key.toml");
    sinew::description::machine_from_toml("every_key.toml", text, &mut |_| Err("no other file".into()))
        .unwrap()
        .machine
}

/// Gains of other numbers of muscles and joints.
fn gains(muscles: usize, joints: usize) -> ArmGains {
    let mut gains = controller().gains().clone();
    gains.muscles = vec![gains.muscles[0]; muscles];
    gains.joints = vec![gains.joints[0]; joints];
    gains
}

fn near(a: f64, b: f64) {
    assert!((a - b).abs() < 1e-9 * b.abs().max(1e-3), "{a} {b}");
}

#[test]
fn slow_speeds_and_slack_are_those_of_the_joint_on_which_a_cable_acts_most() {
    let mut machine = fixed_arms();
    machine.safety.wind_in_speed = 0.3;
    machine.safety.lowering_speed = 0.2;
    machine.safety.largest_slack = 4.0;
    let limits = Limits::from_machine(&machine, &gains(3, 3)).unwrap();
    // Of the slide a quarter of the numbers in m/s and m: its moment arm is 1.
    let fastest = gains(3, 3).muscles[0].max_winch_speed;
    for (limit, anchor) in limits.muscles.iter().zip([0.03_f64, 0.04, 0.25]) {
        near(limit.wind_in_speed, (0.3 * anchor).min(fastest));
        near(limit.lowering_speed, (0.2 * anchor).min(fastest));
        near(limit.largest_slack, 4.0 * anchor);
    }
    assert!(0.3 * 0.25 < fastest, "the slide is not limited by its winch: {fastest}");
}

#[test]
fn a_winch_is_never_slower_than_a_tenth_of_a_millimetre_per_second_nor_faster_than_its_own() {
    let mut machine = fixed_arms();
    (machine.safety.wind_in_speed, machine.safety.lowering_speed) = (1e-5, 1e3);
    machine.safety.largest_slack = 1e-5;
    let gains = gains(3, 3);
    for limit in Limits::from_machine(&machine, &gains).unwrap().muscles {
        near(limit.wind_in_speed, 1e-4);
        near(limit.lowering_speed, gains.muscles[0].max_winch_speed);
        near(limit.largest_slack, 1e-3);
    }
}

#[test]
fn a_cable_is_slack_below_half_of_what_its_drive_keeps_or_below_the_noise_of_its_load_cell() {
    let mut machine = fixed_arms();
    for (muscle, [least, noise]) in machine.muscles.iter_mut().zip([[30.0, 0.5], [2.0, 1.25], [8.0, 0.0]]) {
        (muscle.drive.min_tension, muscle.drive.load_cell.noise) = (least, noise);
    }
    let limits = Limits::from_machine(&machine, &gains(3, 3)).unwrap();
    for (limit, slack) in limits.muscles.iter().zip([15.0, 1.25, 4.0]) {
        near(limit.slack_tension, slack);
    }
}

#[test]
fn ranges_have_their_margin_on_both_sides_and_every_drive_its_limits() {
    let mut machine = fixed_arms();
    machine.safety.joint_margin = 0.1;
    let limits = Limits::from_machine(&machine, &gains(3, 3)).unwrap();
    let joints = &machine.robot.parts().joints;
    for (range, joint) in limits.ranges.iter().zip(machine.robot.independent_joints()) {
        let ([low, high], [found_low, found_high]) = (joints[joint].range.unwrap(), range.unwrap());
        near(found_low, low - 0.1 * (high - low));
        near(found_high, high + 0.1 * (high - low));
    }
    for (limit, muscle) in limits.muscles.iter().zip(&machine.muscles) {
        let own = machine.safety.of_drive(&muscle.drive);
        near(limit.tension, own.tension);
        near(limit.tension_rate, own.tension_rate);
        near(limit.speed, own.cable_speed);
        near(limit.motor.unwrap().1, own.winding);
        assert_eq!(limit.travel, Some([0.0, muscle.drive.winch.capacity()]));
    }
    assert_eq!(limits.safety, machine.safety);
}

#[test]
fn gains_and_limits_of_another_machine_are_refused() {
    let machine = fixed_arms();
    assert!(
        Limits::from_machine(&machine, &gains(2, 3)).is_err()
            && Limits::from_machine(&machine, &gains(3, 2)).is_err()
    );
    let mut bench = Bench::new([0.0; 2], |_| {});
    let good = bench.supervisor.limits().clone();
    let wrong = |change: fn(&mut Limits)| {
        let mut limits = good.clone();
        change(&mut limits);
        limits
    };
    for limits in [
        wrong(|limits| limits.muscles.truncate(1)),
        wrong(|limits| limits.ranges.clear()),
        wrong(|limits| limits.safety.lateness = -1.0),
    ] {
        assert!(Supervisor::new(controller(), limits.clone()).is_err());
        assert!(bench.supervisor.set_limits(limits).is_err());
        assert_eq!(*bench.supervisor.limits(), good, "what is refused changes nothing");
    }
}

#[test]
fn other_limits_hold_from_the_next_cycle_on() {
    let mut bench = Bench::new([5.0; 2], |_| {});
    assert_eq!(bench.supervisor.threshold(Fault::Overload(1)), None);
    assert_eq!(bench.steps(50, Request::Pretension).mode, Mode::Pretension);
    let mut limits = bench.supervisor.limits().clone();
    limits.muscles[1].tension = 4.0;
    bench.supervisor.set_limits(limits).unwrap();
    assert_eq!(bench.supervisor.threshold(Fault::Overload(1)), Some(Threshold::Tension(4.0)));
    let cycles = (0.01 / H) as usize + 1;
    assert_eq!(
        bench.steps(cycles, Request::Pretension).fault.map(|fault| fault.fault),
        Some(Fault::Overload(1))
    );
}

#[test]
fn a_supervisor_tells_of_its_machine_at_first_that_it_is_cold_and_sound() {
    let supervisor = Supervisor::from_controller(controller()).unwrap();
    assert_eq!((supervisor.dimensions(), supervisor.mode()), ([2, 1], Mode::Off));
    assert_eq!(supervisor.health(), [CableHealth::default(); 2]);
    for muscle in 0..2 {
        near(supervisor.winding(muscle), 25.0);
    }
    assert!(supervisor.winding(2).is_nan());
    // As many as its controller has.
    let machine = fixed_arms();
    let mode = ActuationMode::WinchSpeed(CableStateSource::Observer);
    let three = ArmController::new(&machine.robot, &vec![CableModel::bench(); 3], gains(3, 3), mode).unwrap();
    assert_eq!(Supervisor::from_controller(three).unwrap().dimensions(), [3, 3]);
}
