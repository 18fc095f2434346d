//! Payload that is held for a time: heat, gravity and what would raise it.

use super::model;
use sinew::control::capability::{CapabilityModel, HeldPayload, TensionLimit};
use sinew::machine::{DesignChange, Machine};

fn held(machine: &Machine, seconds: f64) -> Vec<Option<HeldPayload>> {
    let model = CapabilityModel::new(machine).unwrap();
    model.holding_for(seconds).held_payloads(&machine.poses(20).unwrap()).unwrap()
}

fn mass(machine: &Machine, seconds: f64) -> f64 {
    held(machine, seconds)[0].unwrap().mass
}

#[test]
fn for_an_instant_it_is_the_payload_without_heat_and_for_longer_it_is_less() {
    let machine = model("planar_leg").machine;
    let mut without = CapabilityModel::new(&machine).unwrap();
    let short = held(&machine, 0.1);
    for (pose, short) in machine.poses(20).unwrap().iter().zip(&short) {
        let expected = without.at(pose).unwrap().end_point.unwrap().payload[1].unwrap().value;
        assert!((short.unwrap().mass - expected).abs() < 1e-9 * expected);
    }
    let (hour, ever) = (held(&machine, 3600.0), held(&machine, f64::INFINITY));
    for ((short, hour), ever) in short.iter().zip(&hour).zip(&ever) {
        let [short, hour, ever] = [short, hour, ever].map(|held| held.unwrap().mass);
        assert!(0.0 < ever && ever < hour && hour < short, "{ever} {hour} {short}");
    }
    assert!(ever.iter().all(|held| held.unwrap().limited_by.unwrap().1 == TensionLimit::Heat));
}

#[test]
fn it_is_limited_by_what_raises_it() {
    let machine = model("exosuit_elbow").machine;
    for (seconds, limit, raising) in [
        (10.0, TensionLimit::Drive, DesignChange::HigherTension),
        (f64::INFINITY, TensionLimit::Heat, DesignChange::CoolerMotor),
    ] {
        assert_eq!(held(&machine, seconds)[0].unwrap().limited_by.unwrap().1, limit);
        let gain = |change| mass(&machine.with(change).unwrap(), seconds) / mass(&machine, seconds);
        assert!(gain(raising) > 1.4, "{}", gain(raising));
        for other in [DesignChange::HigherTension, DesignChange::CoolerMotor, DesignChange::StrongerAmplifier]
        {
            assert!(other == raising || (gain(other) - 1.0).abs() < 1e-9, "{other:?}");
        }
        assert!(gain(DesignChange::LessBend) > 1.05 && gain(DesignChange::LighterBody) > 1.0);
    }
}

#[test]
fn weight_counts_along_axes_that_the_task_does_not_track_and_for_a_machine_whose_task_are_its_joints() {
    // Its task is x and y.
    let mut machine = model("shoulder").machine;
    let tracked = held(&machine, 10.0);
    machine.task = sinew::machine::Task::Joints;
    assert_eq!(held(&machine, 10.0), tracked);
    assert!(tracked.iter().flatten().any(|held| held.mass.is_finite()));
    let mut parts = machine.robot.parts().clone();
    parts.gravity = [0.0; 3];
    machine.robot = sinew::body::Robot::new(parts).unwrap();
    assert!(held(&machine, 10.0).is_empty());
}
