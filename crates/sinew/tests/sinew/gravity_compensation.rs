//! What holds the weight of bodies: against MuJoCo (values of `benches/peers/gravcomp_golden.py`), and in
//! the twin.

use serde::Deserialize;
use sinew::body::{JointKind, Poses, Robot};
use sinew::description::{from_mjcf, from_toml, to_mjcf, to_toml};
use sinew::muscle::MuscleDynamics;

#[derive(Deserialize)]
struct Case {
    mjcf: String,
    q: Vec<f64>,
    v: Vec<f64>,
    held: Vec<f64>,
    needed: Vec<f64>,
}

fn robot(mjcf: &str) -> Robot {
    let read = from_mjcf("b.xml", mjcf, &mut |_| Err("no other file".into())).unwrap();
    assert!(read.warnings.is_empty(), "{:?}", read.warnings);
    read.robot().unwrap().0
}

fn held(robot: &Robot, q: &[f64]) -> Vec<f64> {
    let (mut poses, mut tau) = (Poses::new(robot), vec![0.0; robot.nv()]);
    robot.forward_kinematics(q, &mut poses).unwrap();
    robot.gravity_compensation(&poses, &mut tau).unwrap();
    tau
}

fn difference(a: &[f64], b: &[f64]) -> f64 {
    assert_eq!(a.len(), b.len());
    a.iter().zip(b).map(|(a, b)| (a - b).abs()).fold(0.0, f64::max)
}

#[test]
fn forces_that_hold_weight_are_mujocos_in_a_body_its_copies_and_its_dynamics() {
    let cases: Vec<Case> = serde_json::from_str(include_str!("../golden/gravcomp/bodies.json")).unwrap();
    let (mut most, mut machines) = (0.0_f64, 0);
    for case in &cases {
        let own = robot(&case.mjcf);
        let copy = from_toml("b.toml", &to_toml(own.parts())).unwrap().robot().unwrap().0;
        for robot in [&own, &robot(&to_mjcf(own.parts())), &copy] {
            assert!(difference(&held(robot, &case.q), &case.held) < 1e-12);
        }
        most = case.held.iter().fold(most, |most, x| most.max(x.abs()));
        let single = |kind| matches!(kind, JointKind::Hinge | JointKind::Slide);
        if own.nv() > 0 && own.parts().joints.iter().all(|joint| single(joint.kind)) {
            let mut model = MuscleDynamics::new(&own).unwrap();
            let (rest, mut tau) = (vec![0.0; own.nv()], vec![0.0; own.nv()]);
            model.evaluate(&case.q).unwrap();
            model.inverse_dynamics(&case.v, &rest, &mut tau).unwrap();
            assert!(difference(&tau, &case.needed) < 1e-12);
            let mut a = rest.clone();
            model.forward_dynamics(&case.v, &[], Some(&case.needed), &mut a).unwrap();
            assert!(difference(&a, &rest) < 1e-9);
            machines += 1;
        }
    }
    assert!(cases.len() == 100 && machines > 30 && most > 50.0, "{machines} {most}");
}

#[test]
fn a_body_that_is_held_wholly_hangs_still_and_what_it_carries_does_not() {
    let body = "<mujoco><worldbody><body gravcomp=\"1\" name=\"b\"><joint name=\"j\" axis=\"0 1 0\"/>\
        <inertial pos=\"0.3 0 0\" mass=\"2\" diaginertia=\".1 .1 .1\"/></body></worldbody></mujoco>";
    let robot = robot(body);
    let torque = |robot: &Robot| {
        let mut model = MuscleDynamics::new(robot).unwrap();
        let mut tau = [0.0];
        model.evaluate(&[0.4]).unwrap();
        model.inverse_dynamics(&[0.0], &[0.0], &mut tau).unwrap();
        tau[0]
    };
    let energy = |robot: &Robot, q: f64| {
        let mut poses = Poses::new(robot);
        robot.forward_kinematics(&[q], &mut poses).unwrap();
        robot.potential_energy(&[q], &poses).unwrap()
    };
    assert!(torque(&robot).abs() < 1e-12 && energy(&robot, 0.4).abs() < 1e-12);
    let loaded = robot.with_payload(1, [0.5, 0.0, 0.1], 0.2).unwrap();
    let slope = (energy(&loaded, 0.4 + 1e-6) - energy(&loaded, 0.4 - 1e-6)) / 2e-6;
    assert!((torque(&loaded) - slope).abs() < 1e-8 && slope.abs() > 0.5, "{slope}");
}
