//! Laws of a design whose parts all differ from those of the paper's drive.

use super::{Design, Limit, Requirement};
use crate::drive::{Catalogue, MotorState};

fn design() -> Design {
    let parts = Catalogue::built_in().unwrap();
    let (motor, reducer) = (parts.motor("maxon_re35_24v").unwrap(), parts.reducer("maxon_gp42c_3").unwrap());
    Design::new(motor, reducer, 66.0, parts.winch("drum_20mm").unwrap().parameters)
}

const DESIRED: Requirement = Requirement { tension: 120.0, speed: 0.08, acceleration: 1.0, stroke: 0.3 };

#[test]
fn the_drive_of_a_design_needs_its_torques_and_has_its_inertia_and_top_speed() {
    let design = design();
    let drive = design.drive();
    let k = design.motor.torque_constant;
    for (tension, speed) in [(50.0, 0.02), (120.0, 0.08), (300.0, 0.15)] {
        let up = k * drive.pulling_current(tension, speed) / design.motor_torque(tension, speed, 0.0);
        assert!((up - 1.0).abs() < 1e-14, "{up}");
        let out = k * drive.yielding_current(tension, speed);
        let expected = design.motor_torque(tension, -speed, 0.0);
        assert!((out - expected).abs() < 1e-14 * tension / design.turns(), "{out} {expected}");
    }
    assert!((drive.mass_at_cable() / design.mass_at_cable() - 1.0).abs() < 1e-14);
    assert_eq!(drive.motor.top_speed.to_bits(), design.top_speed.to_bits());
    assert!(design.top_speed < design.motor.top_speed, "the reducer's");
}

#[test]
fn a_stroke_up_to_the_capacity_of_the_drum_is_feasible() {
    let design = design();
    let capacity = design.winch.capacity();
    let drum = |stroke: f64| {
        let desired = Requirement { stroke, ..DESIRED };
        let fractions = design.demand(&desired).fractions;
        let fraction = fractions.iter().find(|(limit, _)| *limit == Limit::Drum).unwrap().1;
        assert!((fraction * capacity - stroke).abs() < 1e-14, "{fraction}");
        assert_eq!(design.demand(&desired).is_met(), design.ratios(&desired).is_some());
        design.ratios(&desired).is_some()
    };
    assert!(drum(0.4 * capacity) && drum(capacity) && !drum(1.001 * capacity));
}

#[test]
fn the_copper_loss_is_the_heat_of_the_simulated_winding_at_its_limit() {
    let design = design();
    let (motor, h) = (&design.motor, 1e-3);
    let current = design.drive().pulling_current(DESIRED.tension, DESIRED.speed);
    let mut state = MotorState::cold(motor);
    (state.winding, state.current) = (motor.hottest, current);
    state.prepare(motor, h);
    let heat = state.drive(current * motor.resistance_at(motor.hottest), h).heat;
    let loss = design.copper_loss(&DESIRED);
    assert!((loss * h / heat - 1.0).abs() < 1e-14, "{loss} W, {heat} J");
}

#[test]
fn the_largest_acceleration_takes_all_of_the_current_or_all_of_the_voltage() {
    let design = design();
    let motor = &design.motor;
    let mut limited = [false; 2];
    for (tension, speed) in [(100.0, 0.0), (100.0, 0.05), (100.0, 0.18), (400.0, 0.15), (5000.0, 0.05)] {
        let acceleration = design.acceleration(tension, speed);
        let current = design.motor_torque(tension, speed, acceleration) / motor.torque_constant;
        let back = motor.torque_constant * speed * design.turns();
        let voltage = motor.resistance_at(motor.hottest) * current + back;
        let fractions = [current / motor.peak_current, voltage / motor.voltage];
        assert!((fractions[0].max(fractions[1]) - 1.0).abs() < 1e-12, "{tension} {speed}: {fractions:?}");
        limited = [limited[0] || fractions[0] > fractions[1], limited[1] || fractions[1] > fractions[0]];
        assert_eq!(acceleration < 0.0, tension > 2000.0, "{acceleration}");
    }
    assert_eq!(limited, [true; 2], "both limits are tested");
}

#[test]
fn an_envelope_has_even_speeds_from_the_fastest_paid_out_to_the_fastest_taken_up() {
    let design = design();
    let most = design.top_speed / design.turns();
    for (points, expected) in [(0, 2), (2, 2), (7, 7)] {
        let envelope = design.envelope(points);
        assert_eq!(envelope.len(), expected);
        let step = 2.0 * most / (expected - 1) as f64;
        for (k, point) in envelope.iter().enumerate() {
            assert!((point.speed + most - k as f64 * step).abs() < 1e-14, "{k}: {}", point.speed);
            assert_eq!(*point, design.envelope_at(point.speed, 0.0));
        }
    }
}

#[test]
fn the_top_speed_is_part_of_the_envelope_and_a_speed_above_it_is_not() {
    let mut design = design();
    // Enough for the top speed.
    design.motor.voltage = 60.0;
    let most = design.top_speed / design.turns();
    for speed in [most, -most] {
        let within = design.envelope_at(speed, 0.0).peak;
        assert!(within.limit != Limit::Speed && within.tension > 100.0, "{within:?}");
        let beyond = design.envelope_at(1.0005 * speed, 0.0).peak;
        assert!(beyond.limit == Limit::Speed && beyond.tension.abs() < 1e-15, "{beyond:?}");
    }
}

#[test]
fn every_limit_has_a_name_of_its_own() {
    let names = design().demand(&DESIRED).fractions.map(|(limit, _)| limit.name());
    for (k, name) in names.iter().enumerate() {
        assert!(!name.is_empty() && !names[..k].contains(name), "{names:?}");
    }
}
