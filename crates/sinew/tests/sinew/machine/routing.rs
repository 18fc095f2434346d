//! Another route changes its muscle alone, by the geometry that it states.

use super::model;
use sinew::machine::Routing;
use sinew::muscle::MuscleDynamics;

#[test]
fn another_route_changes_its_muscle_alone() {
    let machine = model("lm_arm").machine;
    let routing = Routing {
        origin: [0.004, 0.0, -0.003],
        anchor: [0.0, 0.002, 0.0],
        sheath: Some(0.5),
        ..Routing::default()
    };
    let other = machine.rerouted(2, &routing).unwrap();
    let lengths = |machine: &sinew::machine::Machine| {
        let mut model = MuscleDynamics::new(&machine.robot).unwrap();
        model.evaluate(&machine.start).unwrap();
        model.lengths().to_vec()
    };
    for (k, (a, b)) in lengths(&machine).iter().zip(lengths(&other)).enumerate() {
        assert_eq!(k == 2, (a - b).abs() > 1e-5, "muscle {k}: {a} and {b} m");
    }
    assert!((other.muscles[2].sheath - 0.5).abs() < 1e-15);
    let drag = |machine: &sinew::machine::Machine| machine.muscles[2].cable.drag / machine.muscles[2].sheath;
    assert!((drag(&machine) - drag(&other)).abs() < 1e-12);
    // The design's route is the design.
    let same = machine.rerouted(2, &Routing::default()).unwrap();
    assert_eq!(lengths(&machine), lengths(&same));
    assert!((same.muscles[2].bend - machine.muscles[2].bend).abs() < 1e-15);
}

#[test]
fn an_s_of_two_arcs_moves_the_end_as_far_as_it_says() {
    let machine = model("bench_joint").machine;
    let design = &machine.muscles[0];
    // The cable of the bench leaves its sheath downward.
    let routing = Routing { origin: [0.1, 0.0, 0.03], ..Routing::default() };
    let bend = machine.rerouted(0, &routing).unwrap().muscles[0].bend;
    let arc = 0.5 * (bend - design.bend);
    let radius = 0.5 * design.sheath / arc;
    assert!((2.0 * radius * (1.0 - arc.cos()) - 0.1).abs() < 1e-12);
}

#[test]
fn wrong_routes_are_refused_with_the_number() {
    let machine = model("bench_joint").machine;
    let design = Routing::default();
    let wrong = [
        (0, Routing { origin: [f64::NAN, 0.0, 0.0], ..design }, "displacement"),
        (0, Routing { origin: [0.7, 0.0, 0.0], ..design }, "at most 0.63"),
        (0, Routing { wrap: 0.0, ..design }, "wrap_factor"),
        (0, Routing { sheath: Some(-1.0), ..design }, "sheath_m"),
        (0, Routing { bend: Some(f64::INFINITY), ..design }, "bend_rad"),
        (9, design, "muscle"),
    ];
    for (muscle, routing, expected) in wrong {
        let message = machine.rerouted(muscle, &routing).unwrap_err().to_string();
        assert!(message.contains(expected), "{message}");
    }
}

#[test]
fn a_larger_surface_gives_a_larger_moment_arm() {
    let machine = model("bench_joint").machine;
    let arm = |machine: &sinew::machine::Machine| {
        let mut model = MuscleDynamics::new(&machine.robot).unwrap();
        model.evaluate(&machine.start).unwrap();
        model.moment_arms()[0]
    };
    let other = machine.rerouted(0, &Routing { wrap: 0.8, ..Routing::default() }).unwrap();
    assert!((arm(&other) / arm(&machine) - 0.8).abs() < 1e-3, "{} and {}", arm(&other), arm(&machine));
}
