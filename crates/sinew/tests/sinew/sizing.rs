//! From a requirement to a drive: what the envelope promises, the simulated drive keeps.
#![allow(clippy::unwrap_used, reason = "a failing test may panic")]

use proptest::prelude::*;
use sinew::drive::sizing::{Choice, Design, Limit, Requirement, choose};
use sinew::drive::{Catalogue, Drive, DriveCommand, DriveParameters};

const H: f64 = 1e-3;

fn catalogue() -> Catalogue {
    Catalogue::built_in().unwrap().for_drives(None)
}

fn mc_am() -> Design {
    let parts = catalogue();
    let winch = parts.winch("drum_15mm").unwrap().parameters;
    Design::new(parts.motor("class_35mm_120w").unwrap(), parts.reducer("class_53").unwrap(), 53.0, winch)
}

fn reaches(design: &Design, speed: f64, tension: f64) -> bool {
    let parameters = DriveParameters { max_tension: 2000.0, ..design.drive() };
    let mut drive = Drive::new(parameters, 1).unwrap();
    drive.settle(tension);
    let run = (0..2000).map(|_| drive.step(DriveCommand::Velocity(speed), tension, H).speed);
    run.skip(1500).all(|v| v > 0.95 * speed)
}

#[test]
fn the_papers_drive_meets_its_continuous_tension_and_accelerates_by_three_metres_per_second_squared() {
    let design = mc_am();
    assert!((design.mass_at_cable() - DriveParameters::mc_am().mass_at_cable()).abs() < 1e-9);
    let desired = Requirement { tension: 250.0, speed: 0.14, acceleration: 3.0, stroke: 0.3 };
    assert!(design.demand(&desired).is_met(), "{:?}", design.demand(&desired));
    assert!(design.acceleration(250.0, 0.14) > 3.0);
    let point = design.envelope_at(0.14, 0.0);
    assert!((250.0..350.0).contains(&point.continuous.tension) && point.continuous.limit == Limit::Heat);
    assert!(point.peak.tension > 600.0, "{point:?}");
    // What the motor cannot hold at rest indefinitely is 445 N with 53 : 1.
    assert!(!design.demand(&Requirement { tension: 445.0, ..desired }).is_met());
    assert!(design.envelope_at(0.3, 0.0).peak.limit == Limit::Speed);
}

#[test]
fn a_simulated_drive_reaches_the_envelope_and_not_more() {
    let mut design = mc_am();
    design.motor.peak_current = 6.0;
    // The envelope is for the mean of the losses' ripple.
    design.reducer.ripple = 0.0;
    for speed in [0.02, 0.05, 0.1] {
        let most = design.envelope_at(speed, 0.0).peak;
        assert_eq!(most.limit, Limit::Current);
        assert!(reaches(&design, speed, 0.98 * most.tension), "{speed}: {most:?}");
        assert!(!reaches(&design, speed, 1.02 * most.tension), "{speed}: {most:?}");
    }
    // A winding that is as warm as it may be has less voltage to spare than the cold one that is simulated
    // here.
    design.motor.voltage = 8.0;
    let most = design.envelope_at(0.06, 0.0).peak;
    assert_eq!(most.limit, Limit::Voltage);
    assert!(reaches(&design, 0.06, 0.95 * most.tension) && !reaches(&design, 0.06, 2.0 * most.tension));
}

#[test]
fn the_continuous_current_leaves_every_motor_of_the_catalogue_as_cool_as_it_must_be() {
    let parts = catalogue();
    for motor in &parts.motors {
        let reducer = &parts.reducers[0];
        let mut design = Design::new(motor, reducer, reducer.ratios[0], parts.winches[0].parameters);
        let warm = |design: &Design| design.motor.steady_temperature(design.continuous_current());
        assert!(warm(&design) <= design.motor.hottest * (1.0 + 1e-12), "{}: {}", motor.name, warm(&design));
        // Where the sheet allows more than heat does, heat decides: as hot as it may be, no cooler.
        design.motor.continuous_current = design.motor.peak_current;
        assert!((warm(&design) - design.motor.hottest).abs() < 1e-6 * design.motor.hottest, "{}", motor.name);
    }
}

#[test]
fn feasible_designs_come_first_in_the_order_of_mass() {
    let parts = catalogue();
    let desired = Requirement { tension: 250.0, speed: 0.14, acceleration: 3.0, stroke: 0.3 };
    let choices = choose(&parts, &desired).unwrap();
    let free = parts.reducers.iter().filter(|reducer| !reducer.built_in).count();
    assert_eq!(choices.len(), parts.motors.len() * free);
    let able: Vec<_> = choices.iter().take_while(|choice| choice.demand.is_met()).collect();
    assert!(able.len() >= 3 && able.len() < choices.len(), "{}", able.len());
    assert!(able.windows(2).all(|pair| pair[0].design.mass <= pair[1].design.mass));
    let lack: Vec<f64> = choices[able.len()..].iter().map(|choice| choice.demand.worst().1).collect();
    assert!(lack.iter().all(|fraction| *fraction > 1.0) && lack.windows(2).all(|pair| pair[0] <= pair[1]));
    for choice in able {
        let [low, high] = choice.ratios.unwrap();
        assert!((low..=high).contains(&choice.design.reducer.ratio), "{low} {high}");
    }
    // No design of the catalogue reaches ten kilonewtons.
    let hopeless = choose(&parts, &Requirement { tension: 1e4, ..desired }).unwrap();
    assert!(hopeless.iter().all(|choice| !choice.demand.is_met() && choice.ratios.is_none()));
}

#[test]
fn servos_come_with_their_gears_and_reach_what_is_published_of_their_horns() {
    let all = Catalogue::built_in().unwrap();
    assert_eq!(all.drives(), ["dynamixel", "feetech", "moteus"]);
    let desired = Requirement { tension: 5.0, speed: 0.05, acceleration: 0.5, stroke: 0.05 };
    for drives in all.drives() {
        let parts = all.clone().for_drives(Some(drives));
        let choices = choose(&parts, &desired).unwrap();
        assert!(choices[0].demand.is_met() && !parts.motors.is_empty(), "{drives}: {:?}", choices[0].demand);
        for Choice { motor, reducer, .. } in &choices {
            assert_eq!(motor.reducer.is_some(), reducer.built_in, "{} {}", motor.name, reducer.name);
            assert!(motor.reducer.as_ref().is_none_or(|own| *own == reducer.name));
        }
        for motor in parts.motors.iter().filter(|motor| motor.reducer.is_some()) {
            let gears = all.reducer(motor.reducer.as_ref().unwrap()).unwrap();
            let (m, n) = (motor.parameters, gears.ratios[0]);
            // Without load the voltage is that of the motor's speed, at stall that of its current and torque.
            let near = |a: f64, b: f64| (a - b).abs() < 2e-3 * b;
            assert!(near(m.torque_constant * m.top_speed, m.voltage), "{}", motor.name);
            assert!(near(m.resistance * m.peak_current, m.voltage), "{}", motor.name);
            let stall = m.torque_constant * m.peak_current * n * gears.parameters.efficiency;
            assert!(near(stall, gears.peak_torque), "{}: {stall} {}", motor.name, gears.peak_torque);
        }
    }
    assert!(all.clone().for_drives(Some("none")).motors.is_empty());
    assert!(catalogue().motors.iter().all(|motor| motor.drives.is_none()));
}

#[test]
fn requirements_outside_their_domain_are_refused_by_name() {
    let desired = Requirement { tension: 250.0, speed: 0.14, acceleration: 3.0, stroke: 0.3 };
    for (wrong, name) in [
        (Requirement { tension: 0.0, ..desired }, "tension"),
        (Requirement { speed: -1.0, ..desired }, "speed"),
        (Requirement { acceleration: f64::NAN, ..desired }, "acceleration"),
        (Requirement { stroke: f64::INFINITY, ..desired }, "stroke"),
    ] {
        assert!(choose(&catalogue(), &wrong).unwrap_err().to_string().contains(name));
    }
}

proptest! {
    #[test]
    fn tension_and_torque_are_inverse_in_every_quadrant(
        tension in 1.0..800.0_f64, speed in -0.3..0.3_f64, acceleration in -5.0..5.0_f64,
    ) {
        let design = mc_am();
        let torque = design.motor_torque(tension, speed, acceleration);
        prop_assert!((design.tension(torque, speed, acceleration) - tension).abs() < 1e-9 * tension);
    }

    #[test]
    fn just_inside_the_range_of_ratios_all_limits_hold_and_just_outside_one_breaks(
        tension in 20.0..500.0_f64, speed in 0.0..0.3_f64, acceleration in 0.0..10.0_f64, which in 0..24_usize,
    ) {
        let parts = catalogue();
        let desired = Requirement { tension, speed, acceleration, stroke: 0.3 };
        let (motor, reducer) = (&parts.motors[which % 6], &parts.reducers[which % 5]);
        let at = |ratio: f64| Design::new(motor, reducer, ratio, parts.winches[which % 4].parameters);
        let fraction = |ratio: f64| at(ratio).demand(&desired).worst().1;
        match at(10.0).ratios(&desired) {
            None => for k in 0..60 {
                prop_assert!(fraction(1.1_f64.powi(k)) > 1.0);
            },
            Some([low, high]) => {
                prop_assert!(fraction(low * (1.0 + 1e-6)) <= 1.0 + 1e-6);
                prop_assert!(low <= 1.0 || fraction(low * (1.0 - 1e-3)) > 1.0);
                prop_assert!(!high.is_finite() || fraction(high * (1.0 + 1e-3)) > 1.0);
                prop_assert!(!high.is_finite() || fraction(high * (1.0 - 1e-6)) <= 1.0 + 1e-6);
            }
        }
    }
}
