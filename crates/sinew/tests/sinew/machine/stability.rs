//! Stability with locked winches: against the second derivative of the potential energy, and against
//! formulas.

use super::model;
use sinew::body::{Poses, Robot};
use sinew::control::arm::{least_stable_pose, tension_limits};
use sinew::machine::{HeldStability, Machine, NegativeStiffness};
use sinew::muscle::MuscleDynamics;
use sinew::random::Random;

/// A bar of 50 mm and 20 g on a hinge between two straight cables, their ends `along` m from the joint,
/// `across` m off its axis; upright where `up` is 1, hanging where it is -1.
fn bar(along: f64, across: f64, up: f64) -> Machine {
    let site = |name: &str, body: &str, x: f64, z: f64| {
        format!("[[site]]\nname = \"{name}\"\nbody = \"{body}\"\nposition_m = [{x}, 0.0, {z}]\n")
    };
    let muscle = |name: &str| {
        format!(
            "[[muscle]]\nname = \"{name}\"\npath = [{{ site = \"{name}_o\" }}, {{ site = \"{name}_i\" }}]\n"
        )
    };
    let text = [
        "name = \"bar\"\ngravity_m_per_s2 = [0.0, 0.0, -9.81]\n".to_owned(),
        "[[body]]\nname = \"bar\"\nparent = \"world\"\nposition_m = [0.0, 0.0, 0.0]\nmass_kg = 0.02\n"
            .to_owned(),
        format!("center_of_mass_m = [0.0, 0.0, {}]\ninertia_kg_m2 = [5e-6, 5e-6, 1e-7]\n", 0.025 * up),
        "[[joint]]\nname = \"hinge\"\nbody = \"bar\"\nkind = \"hinge\"\naxis = [0.0, 1.0, 0.0]\n".to_owned(),
        "range_rad = [-1.0, 1.0]\n".to_owned(),
        site("front_o", "world", across, -up * along),
        site("front_i", "bar", across, up * along),
        site("back_o", "world", -across, -up * along),
        site("back_i", "bar", -across, up * along),
        muscle("front"),
        muscle("back"),
    ];
    super::read(&text.concat()).unwrap().machine
}

/// `(C, F_min)` of the first muscle.
fn cable(machine: &Machine) -> (f64, f64) {
    let laws = machine.laws(12).unwrap();
    (laws[0].compliance().iter().sum(), tension_limits(machine, &laws)[0][0])
}

#[test]
fn a_bar_between_two_cables_has_the_stiffness_of_its_formula() {
    for (along, across, up) in
        [(0.004, 0.006, -1.0), (0.02, 0.005, -1.0), (0.03, 0.01, 1.0), (1e-4, 1e-4, 1.0)]
    {
        let machine = bar(along, across, up);
        let (compliance, tension) = cable(&machine);
        let laws = machine.laws(12).unwrap();
        let found = least_stable_pose(&machine, &laws, &[vec![0.0]], 0.0).unwrap().unwrap();
        assert!((found.tension[0] - tension).abs() < 1e-6 * tension);
        // l'' = -along/2 where the cables are parallel to the bar; gravity has m g l.
        let weight = -up * 0.02 * 9.81 * 0.025;
        let stiffness = 2.0 * across * across / compliance - tension * along + weight;
        let expected = stiffness / (5e-6 + 0.02 * 0.025 * 0.025);
        let HeldStability { eigenvalue, joint, cause } = found.stability;
        assert!((eigenvalue - expected).abs() < 1e-5 * expected.abs(), "{eigenvalue} {expected}");
        assert_eq!(joint, 0);
        let gravity = weight < -0.5 * tension * along;
        assert_eq!(matches!(cause, NegativeStiffness::Gravity), gravity, "{along} {cause:?}");
        assert_eq!(found.stability.rate() > 0.0, expected < 0.0);
    }
}

/// Potential energy with locked winches, whose cables had these tensions at these lengths.
fn potential(
    model: &mut MuscleDynamics,
    pose: &[f64],
    (tension, compliance, lengths): (&[f64], &[f64], &[f64]),
) -> f64 {
    model.evaluate(pose).unwrap();
    let robot: &Robot = model.robot();
    let mut poses = Poses::new(robot);
    robot.forward_kinematics(model.coordinates(), &mut poses).unwrap();
    let height = robot.potential_energy(model.coordinates(), &poses).unwrap();
    let cables = model.lengths().iter().zip(lengths).zip(tension.iter().zip(compliance));
    height + cables.map(|((l, l0), (f, c))| f * (l - l0) + 0.5 * (l - l0) * (l - l0) / c).sum::<f64>()
}

#[test]
fn no_direction_is_softer_than_the_least_eigenvalue_and_one_is_as_soft() {
    let mut random = Random::new(3);
    for name in ["bench_joint", "planar_leg", "shoulder", "exosuit_elbow"] {
        let machine = model(name).machine;
        let laws = machine.laws(12).unwrap();
        let compliance: Vec<f64> = laws.iter().map(|law| law.compliance().iter().sum()).collect();
        let mut model = MuscleDynamics::new(&machine.robot).unwrap();
        let n = model.joints();
        for pose in &machine.poses(4).unwrap() {
            let found = least_stable_pose(&machine, &laws, std::slice::from_ref(pose), 0.0).unwrap().unwrap();
            model.evaluate(pose).unwrap();
            let lengths = model.lengths().to_vec();
            let mut mass = vec![0.0; n * n];
            model.mass_matrix(&mut mass).unwrap();
            let state = (&found.tension[..], &compliance[..], &lengths[..]);
            let mut softest = f64::INFINITY;
            for _ in 0..3000 {
                let x: Vec<f64> = (0..n).map(|_| 2.0 * random.unit() - 1.0).collect();
                // Of a length at which differences of the energy are not rounding.
                let step = 1e-3 / x.iter().map(|x| x * x).sum::<f64>().sqrt();
                let mut at = |fraction: f64| {
                    let moved: Vec<f64> = pose.iter().zip(&x).map(|(q, x)| q + fraction * step * x).collect();
                    potential(&mut model, &moved, state)
                };
                let curvature = (at(1.0) - 2.0 * at(0.0) + at(-1.0)) / (step * step);
                let energy: f64 = (0..n * n).map(|entry| x[entry / n] * mass[entry] * x[entry % n]).sum();
                softest = softest.min(curvature / energy);
            }
            let least = found.stability.eigenvalue;
            assert!(softest > least - 0.01 * least.abs(), "{name} {pose:?}: {softest} below {least}");
            assert!(softest < least + 0.1 * least.abs(), "{name} {pose:?}: {softest} above {least}");
        }
    }
}
