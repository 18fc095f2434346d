//! A finger of three joints on one cable, opened by springs.

use sinew::description::machine_from_toml;
use sinew::machine::Machine;
use sinew::trajectory::Violation;
use sinew_lab::CompensationVariant;
use sinew_lab::arm::{
    CalibratedArm, DesiredMotion, TrackOutcome, TrackingTask, first_infeasibility, plan, track_arm,
};

/// Links, masses and drive are those of `models/finger.toml`; springs are chosen for 3 to 8 N at its cable.
fn finger(least_n: f64) -> Machine {
    let mut text =
        "name = \"finger\"\ngravity_m_per_s2 = [0.0, 0.0, -9.81]\ntask = { space = \"joints\" }\n".to_owned();
    let links = [("base", 0.0, 0.018, 3.6e-6), ("middle", 0.045, 0.009, 7e-7), ("end", 0.0265, 0.005, 2e-7)];
    let joints = [(0.009, 0.04, 2e-6, 1e-3), (0.007, 0.03, 1e-6, 5e-4), (0.004, 0.02, 5e-7, 3e-4)];
    let (mut parent, mut terms) = ("world", Vec::new());
    for ((name, offset, mass, inertia), (arm, spring, armature, damping)) in links.into_iter().zip(joints) {
        text += &format!(
            "[[body]]\nname = \"{name}\"\nparent = \"{parent}\"\nposition_m = [{offset}, 0.0, 0.0]\n\
                mass_kg = {mass}\n\
                center_of_mass_m = [0.012, 0.0, 0.0]\ninertia_kg_m2 = [1e-7, {inertia:e}, {inertia:e}]\n\
                [[joint]]\nname = \"{name}\"\nbody = \"{name}\"\nkind = \"hinge\"\naxis = [0.0, 1.0, 0.0]\n\
                range_rad = [-0.4, 1.6]\narmature_kg_m2 = {armature:e}\ndamping_nm_s_per_rad = {damping:e}\n\
                stiffness_nm_per_rad = {spring}\nspring_reference_rad = -0.8\n"
        );
        terms.push(format!("{{ joint = \"{name}\", coefficient = {} }}", -arm));
        parent = name;
    }
    text += &format!(
        "[[muscle]]\nname = \"flexor\"\njoints = [{}]\n\
            sheath = {{ length_m = 0.4, bend_rad = 1.5, end_axis = [1.0, 0.0, 0.0] }}\n\
            [every_transmission]\ndrive = \"small\"\nnear_length_m = 0.04\n\
            tension_limits_n = [{least_n}, 40.0]\n\
            motor_encoder_counts = 2048\n\
            load_cell = {{ noise_n = 0.03, resolution_n = 0.005, range_n = 100.0 }}\n\
            cable = {{ friction = 0.1, efficiency = 0.98, drag_n_s_per_m = 4.0, \
            drag_fade_n = 0.5, pretension_n = 0.3, \
            compliance_per_n = 1.33e-4 }}\n\
            [[drive]]\nname = \"small\"\nmotor = \"class_22mm_20w\"\nreducer = \"class_22mm\"\nratio = 29\n\
            winch = {{ radius_m = 0.006, lead_m = 6e-4, cable_diameter_m = 5e-4, \
            turns_per_layer = 10.0, layers = 1 }}\n\
            max_tension_n = 60.0\nmin_tension_n = 0.3\n",
        terms.join(", ")
    );
    machine_from_toml("finger.toml", &text, &mut |_| Err("no other file".into())).unwrap().machine
}

fn to_closed() -> DesiredMotion {
    DesiredMotion::ToPose(vec![1.0, 0.9, 0.6])
}

#[test]
fn one_motor_closes_a_finger_of_three_joints_by_the_length_of_its_cable() {
    let machine = finger(1.2);
    let motion = plan(&machine, &to_closed(), Some(4.0)).unwrap();
    assert_eq!(first_infeasibility(&machine, &motion, 1).unwrap().map(|found| found.to_string()), None);
    let arm = CalibratedArm::new(&machine, 3).unwrap();
    let task = TrackingTask {
        trajectory: &motion,
        repeats: 1,
        learning: false,
        final_rest: 1.0,
        faults: &[],
        gains: None,
        trace_interval: 1.0,
    };
    let numbers = track_arm(&arm, CompensationVariant::Observer, &task).unwrap().numbers;
    let (closure, off) = (numbers.closure_error_m.unwrap(), numbers.off_manifold_rad.unwrap());
    assert_eq!(
        (numbers.ended, numbers.incidents.len()),
        (TrackOutcome::Completed, 0),
        "{:?}",
        numbers.reason
    );
    assert!(closure.mean < 3e-5, "{closure:?}");
    assert!(off.max > 0.0 && off.mean < 0.05, "{off:?}");
}

#[test]
fn a_cable_that_the_springs_do_not_keep_taut_is_refused_by_name() {
    let machine = finger(8.0);
    let motion = plan(&machine, &to_closed(), Some(4.0)).unwrap();
    let found = first_infeasibility(&machine, &motion, 1).unwrap().unwrap();
    let Violation::Slack { muscle, tension, least } = &found.violation else { panic!("{found}") };
    assert!(muscle == "flexor" && tension < least && (least - 8.0).abs() < 1e-9, "{found}");
}
