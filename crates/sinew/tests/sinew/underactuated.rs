//! Fewer motors than joints: what cables control where they leave joints to springs.

use sinew::body::Robot;
use sinew::description::from_toml;
use sinew::trajectory::{ControllableMotion, Equilibrium, Trajectory, UnreachedCause};

/// Links of 40 mm and 10 g under one cable; per joint a moment arm, m, and a spring, Nm/rad, at rest at -0.5.
fn finger(gravity: f64, joints: &[[f64; 2]], range: [f64; 2]) -> Robot {
    let mut text = format!("name = \"finger\"\ngravity_m_per_s2 = [0.0, 0.0, {gravity}]\n");
    let mut terms = Vec::new();
    for (k, [arm, stiffness]) in joints.iter().enumerate() {
        let parent = if k == 0 { "world".to_owned() } else { format!("link{}", k - 1) };
        let offset = if k == 0 { 0.0 } else { 0.04 };
        text += &format!(
            "[[body]]\nname = \"link{k}\"\nparent = \"{parent}\"\nposition_m = [{offset}, 0.0, 0.0]\n\
                mass_kg = 0.01\n\
                center_of_mass_m = [0.02, 0.0, 0.0]\ninertia_kg_m2 = [1e-7, 1e-6, 1e-6]\n\
                [[joint]]\nname = \"j{k}\"\nbody = \"link{k}\"\nkind = \"hinge\"\naxis = [0.0, 1.0, 0.0]\n\
                range_rad = [{}, {}]\nstiffness_nm_per_rad = {stiffness}\nspring_reference_rad = -0.5\n",
            range[0], range[1]
        );
        terms.push(format!("{{ joint = \"j{k}\", coefficient = {} }}", -arm));
    }
    text += &format!("[[muscle]]\nname = \"flexor\"\njoints = [{}]\n", terms.join(", "));
    Robot::new(from_toml("finger.toml", &text).unwrap().parts).unwrap()
}

const STUDY: [[f64; 2]; 2] = [[0.009, 0.020], [0.006, 0.012]];

#[test]
fn without_gravity_joints_share_the_length_of_their_cable_by_arm_over_stiffness() {
    let mut motion = ControllableMotion::new(&finger(0.0, &STUDY, [-1.0, 2.0])).unwrap().unwrap();
    motion.evaluate(&[0.3, 0.6], &[2.0]).unwrap();
    assert_eq!((motion.count(), motion.leading()), (1, &[0][..]));
    let moved = &motion.per_length()[0];
    let compliance: f64 = STUDY.iter().map(|[arm, stiffness]| arm * arm / stiffness).sum();
    for ([arm, stiffness], moved) in STUDY.iter().zip(moved) {
        let expected = arm / stiffness / compliance;
        assert!((moved - expected).abs() < 1e-6 * expected, "{moved} {expected}");
    }
    // N is along (6, -9).
    let (least, _) = motion.least_stiffness().unwrap();
    let expected = (36.0 * 0.020 + 81.0 * 0.012) / 117.0;
    assert!(motion.is_followable() && (least - expected).abs() < 1e-8, "{least} {expected}");
}

#[test]
fn what_a_cable_controls_of_a_displacement_keeps_the_length_and_is_all_there_is_the_second_time() {
    let robot = finger(-9.81, &[[0.009, 0.02], [0.007, 0.015], [0.004, 0.01]], [-1.0, 2.0]);
    let mut motion = ControllableMotion::new(&robot).unwrap().unwrap();
    motion.evaluate(&[0.3, 0.6, 0.2], &[3.0]).unwrap();
    let length = |x: &[f64]| 0.009 * x[0] + 0.007 * x[1] + 0.004 * x[2];
    let given = [0.02, -0.05, 0.03];
    let mut once = given;
    motion.project(&mut once);
    let mut twice = once;
    motion.project(&mut twice);
    assert!((length(&once) - length(&given)).abs() < 1e-12, "{once:?}");
    assert!(once.iter().zip(twice).all(|(a, b)| (a - b).abs() < 1e-11), "{once:?} {twice:?}");
}

#[test]
fn in_equilibrium_every_neighbour_with_the_same_length_has_more_energy_and_stops_take_what_is_left() {
    let springs = [[0.009, 0.05], [0.007, 0.03], [0.004, 0.01]];
    // Within wide ranges, and with the end joint at its stop.
    for (high, stopped) in [(3.0, false), (0.9, true)] {
        let robot = finger(-9.81, &springs, [-0.6, high]);
        let mut equilibrium = Equilibrium::new(&robot).unwrap().unwrap();
        let given = [0.7, 0.7, 0.7];
        let mut q = given;
        assert_eq!(equilibrium.settle(&mut q).unwrap(), None);
        let length = |q: &[f64]| -> f64 { q.iter().zip(&springs).map(|(q, [arm, _])| -arm * q).sum() };
        assert!((length(&q) - length(&given)).abs() < 1e-9);
        assert_eq!((q[2] - high).abs() < 1e-12, stopped, "{q:?}");
        // Springs, and the links' centres of mass 20 mm and their ends 40 mm behind their joints.
        let energy = |q: &[f64]| {
            let (mut angle, mut height, mut sum) = (0.0, 0.0, 0.0);
            for (q, [_, stiffness]) in q.iter().zip(&springs) {
                angle += q;
                sum += 0.5 * stiffness * (q + 0.5) * (q + 0.5);
                sum += 0.01 * 9.81 * (height - 0.02 * f64::sin(angle));
                height -= 0.04 * f64::sin(angle);
            }
            sum
        };
        for (a, b) in [(0, 1), (1, 2), (0, 2)] {
            for side in [1e-3, -1e-3] {
                let mut near = q;
                near[a] += side / springs[a][0] * 0.004;
                near[b] -= side / springs[b][0] * 0.004;
                if near[2] <= high {
                    assert!(energy(&near) > energy(&q), "{stopped} {a} {b} {side}");
                }
            }
        }
    }
}

#[test]
fn a_finger_that_snaps_is_refused_with_the_joint_that_does_not_follow() {
    // Links that stand upright: gravity outweighs the springs.
    let upside_down = finger(-9.81, &[[0.009, 1e-4], [0.006, 1e-4]], [-3.0, 3.0]);
    let mut motion = ControllableMotion::new(&upside_down).unwrap().unwrap();
    motion.evaluate(&[-1.5, 0.0], &[0.0]).unwrap();
    let (least, joint) = motion.least_stiffness().unwrap();
    assert!(!motion.is_followable() && least < 0.0 && joint == 1, "{least} {joint}");
    let mut equilibrium = Equilibrium::new(&upside_down).unwrap().unwrap();
    let found = equilibrium.settle(&mut [-1.5, 0.0]).unwrap();
    let Some(UnreachedCause::Snaps { joint, stiffness }) = found else { panic!("{found:?}") };
    assert!(joint == "j1" && stiffness < 0.0, "{joint} {stiffness}");
}

#[test]
fn machines_with_a_motor_for_every_joint_have_nothing_to_follow() {
    for name in ["bench_joint", "chain10", "finger", "lm_arm", "planar_leg", "shoulder", "two_finger_hand"] {
        let path = format!("{}/../../models/{name}.toml", env!("CARGO_MANIFEST_DIR"));
        let text = std::fs::read_to_string(path).unwrap();
        let robot = Robot::new(from_toml(name, &text).unwrap().parts).unwrap();
        assert!(ControllableMotion::new(&robot).unwrap().is_none(), "{name}");
    }
}

#[test]
fn a_motion_keeps_the_lengths_of_the_one_that_it_is_asked_for() {
    let robot = finger(-9.81, &STUDY, [-1.0, 2.0]);
    let asked = sinew::trajectory::MinimumJerk::new(&[0.1, 0.1], &[1.2, 0.5], 2.0).unwrap();
    let asked = Trajectory::PointToPoint(asked);
    let found = Equilibrium::new(&robot).unwrap().unwrap().along(&asked).unwrap();
    let mut references = [sinew::trajectory::Reference::new(2), sinew::trajectory::Reference::new(2)];
    let length = |q: &[f64]| 0.009 * q[0] + 0.006 * q[1];
    for time in [0.0, 0.3, 0.77, 1.4, 2.0] {
        asked.sample(time, &mut references[0]).unwrap();
        found.sample(time, &mut references[1]).unwrap();
        let [asked, found] = &references;
        assert!((length(&asked.q) - length(&found.q)).abs() < 1e-8, "{time}");
        assert!((length(&asked.v) - length(&found.v)).abs() < 1e-5, "{time}");
    }
}

#[test]
fn a_cause_names_the_joint_and_what_the_springs_leave() {
    let cause = UnreachedCause::Snaps { joint: "middle".into(), stiffness: -0.02 };
    let point = sinew::trajectory::UnreachedPoint { phase: 1.5, distance: 0.0, cause };
    assert!(point.to_string().contains("`middle` does not follow the lengths of its cables but snaps"));
}
