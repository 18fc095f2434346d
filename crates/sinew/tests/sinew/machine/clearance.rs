//! Clearance between the sites of a tendon and the surface that it wraps, against the attachment tolerance.

use super::model;
use sinew::body::Robot;
use sinew::machine::{Clearance, Machine, Tolerances};

const MODELS: [&str; 8] = [
    "bench_joint",
    "planar_leg",
    "finger",
    "exosuit_elbow",
    "surgical_wrist",
    "lm_arm",
    "shoulder",
    "chain10",
];

#[test]
fn no_machine_of_this_repository_may_lose_a_wrap_within_its_tolerances() {
    for name in MODELS {
        let machine = model(name).machine;
        let found = machine.clearances(&machine.poses(60).unwrap()).unwrap();
        let lost: Vec<&Clearance> = found.iter().filter(|clearance| clearance.is_lost()).collect();
        assert!(lost.is_empty(), "{name}: {lost:?}");
    }
}

#[test]
fn a_clearance_is_the_distance_to_the_surface_and_its_least_pose_is_found() {
    // The lever's anchor turns with the drum's axis: 2 mm in every pose.
    let machine = model("bench_joint").machine;
    let parts = machine.robot.parts();
    let anchor = parts.sites.iter().position(|site| site.name == "front_i").unwrap();
    let poses = machine.poses(20).unwrap();
    let found = |machine: &Machine| {
        let all = machine.clearances(&poses).unwrap();
        all.into_iter().find(|clearance| clearance.site == anchor).unwrap()
    };
    let of_lever = found(&machine);
    assert!((of_lever.least - 2e-3).abs() < 1e-6 && of_lever.pose.is_none(), "{of_lever:?}");
    assert!((of_lever.displacement - 2_f64.sqrt() * machine.attachment_tolerance()).abs() < 1e-12);
    let loose = Tolerances { attachment: Some(1.5e-3), ..machine.tolerances };
    assert!(!of_lever.is_lost() && found(&Machine { tolerances: loose, ..machine.clone() }).is_lost());
    // Off the axis, the drum comes nearest in one pose; large enough, it swallows the anchor.
    for (radius, lost) in [(0.03, true), (0.02, false)] {
        let mut parts = parts.clone();
        parts.wraps[0].position[0] += 0.0025;
        parts.wraps.iter_mut().for_each(|wrap| wrap.radius = radius);
        let moved = Machine { robot: Robot::new(parts).unwrap(), ..machine.clone() };
        let found = found(&moved);
        assert!(found.pose.is_some_and(|pose| pose < 20) && found.is_lost() == lost, "{found:?}");
    }
}

/// What the warning is about: such a site in the surface takes the wrap and most of the moment arm away.
#[test]
fn a_site_within_its_surface_loses_the_wrap() {
    let machine = model("bench_joint").machine;
    let arm = |shift: f64| {
        let mut parts = machine.robot.parts().clone();
        let anchor = parts.sites.iter().position(|site| site.name == "front_i").unwrap();
        parts.sites[anchor].position[2] += shift;
        let robot = Robot::new(parts).unwrap();
        let mut model = sinew::muscle::MuscleDynamics::new(&robot).unwrap();
        model.evaluate(&[-0.9]).unwrap();
        model.moment_arms()[0].abs()
    };
    assert!((arm(0.0) - 0.03).abs() < 1e-4, "{}", arm(0.0));
    assert!((arm(3e-3) - 0.03).abs() > 2e-3, "{}", arm(3e-3));
}
