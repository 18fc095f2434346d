//! Demands of a motion on drives, against a joint that can be computed by hand.

use super::{model, read};
use sinew::control::demand::{SizingMotion, drive_demands};
use std::f64::consts::PI;

/// A wheel on a horizontal axis with two cables of constant moment arms, r = 0.03 m, m l = 0.4 kg m.
const WHEEL: &str = r#"
[[body]]
name = "wheel"
mass_kg = 2.0
center_of_mass_m = [0.0, 0.0, -0.2]
inertia_kg_m2 = [0.01, 0.01, 0.01]
[[joint]]
name = "axle"
body = "wheel"
kind = "hinge"
axis = [0.0, -1.0, 0.0]
range_rad = [-1.0, 1.0]
[[muscle]]
name = "front"
joints = [{ joint = "axle", coefficient = -0.03 }]
[[muscle]]
name = "back"
joints = [{ joint = "axle", coefficient = 0.03 }]
[every_transmission]
tension_limits_n = [20.0, 500.0]
"#;

#[test]
fn a_pendulum_demands_its_weight_its_inertia_and_its_speed() {
    let machine = read(WHEEL).unwrap().machine;
    let motion = SizingMotion { period: 2.0, fraction: 0.5 };
    let demands = drive_demands(&machine, &motion).unwrap();
    assert_eq!((demands.unreachable, demands.missing), (0, None));
    let (amplitude, rate) = (0.5, 2.0 * PI / motion.period);
    let inertia = 0.01 + 2.0 * 0.2 * 0.2;
    // The torque is largest at the turning points, where weight and inertia oppose each other.
    let torque = |q: f64| (0.4 * 9.81 * q.sin() - inertia * rate * rate * q).abs();
    let most = (0..=1000).map(|k| torque(amplitude * f64::from(k) / 1000.0)).fold(0.0, f64::max);
    let law = &machine.laws(8).unwrap()[0];
    let tension = (20.0 + most / 0.03 - law.pretension()) * law.friction_angle().exp();
    for demand in &demands.muscles {
        // Four hundred phases come within half a percent of the largest values.
        let close = |got: f64, expected: f64| (0.995..=1.0 + 1e-9).contains(&(got / expected));
        assert!(close(demand.tension, tension), "{} {tension}", demand.tension);
        assert!(close(demand.speed, 0.03 * amplitude * rate), "{}", demand.speed);
        assert!(close(demand.acceleration, 0.03 * amplitude * rate * rate), "{}", demand.acceleration);
        let stretch = demand.tension * law.compliance().iter().sum::<f64>();
        assert!((demand.stroke - 0.03 * 2.0 - stretch).abs() < 1e-4, "{}", demand.stroke);
    }
}

#[test]
fn a_payload_and_a_faster_motion_demand_more() {
    let mut machine = model("planar_leg").machine;
    let demand = |machine: &sinew::machine::Machine, period| {
        drive_demands(machine, &SizingMotion { period, fraction: 0.6 }).unwrap()
    };
    let slow = demand(&machine, 4.0);
    let fast = demand(&machine, 0.5);
    machine.payload = 1.0;
    let loaded = demand(&machine, 4.0);
    let most = |demands: &sinew::control::demand::DriveDemands| {
        demands.muscles.iter().map(|demand| demand.tension).fold(0.0, f64::max)
    };
    assert!(most(&fast) > 1.3 * most(&slow) && most(&loaded) > 1.3 * most(&slow));
    for (slow, fast) in slow.muscles.iter().zip(&fast.muscles) {
        assert!(
            (fast.speed / slow.speed - 8.0).abs() < 1e-9
                && (fast.acceleration / slow.acceleration - 64.0).abs() < 1e-6
        );
    }
}

#[test]
fn a_joint_that_cables_pull_one_way_only_is_told() {
    let one = WHEEL.replace("joint = \"axle\", coefficient = 0.03", "joint = \"axle\", coefficient = -0.02");
    let demands =
        drive_demands(&read(&one).unwrap().machine, &SizingMotion { period: 4.0, fraction: 1.0 }).unwrap();
    assert!(demands.unreachable > demands.samples / 4, "{}", demands.unreachable);
    assert_eq!(demands.missing.map(|missing| missing.joint), Some(0));
    assert!(
        drive_demands(&read(WHEEL).unwrap().machine, &SizingMotion { period: 0.0, fraction: 1.0 }).is_err()
    );
}
