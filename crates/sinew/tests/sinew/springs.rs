//! Springs of tendons: against MuJoCo (values of `benches/peers/spring_golden.py`), and in the twin.

use serde::Deserialize;
use sinew::body::{Poses, Robot, Tendon};
use sinew::description::{Description, from_mjcf, machine_from_toml, to_mjcf, to_toml};
use sinew::drive::DriveCommand;
use sinew::machine::Machine;
use sinew::muscle::MuscleDynamics;
use sinew::twin::arm::{ArmSpecimen, ArmTwin, Failure, InjectedFault};

#[derive(Deserialize)]
struct Hand {
    mjcf: String,
    cases: Vec<Case>,
    rests: Vec<Vec<f64>>,
}

#[derive(Deserialize)]
struct Case {
    q: Vec<f64>,
    v: Vec<f64>,
    torque: Vec<f64>,
    energy: f64,
}

fn hands() -> Vec<Hand> {
    serde_json::from_str(include_str!("../golden/springs/hands.json")).unwrap()
}

fn machine(toml: &str, body: &str) -> Result<Machine, String> {
    let read = machine_from_toml("hand.toml", toml, &mut |_| Ok(body.to_string()));
    read.map(|read| read.machine).map_err(|error| error.to_string())
}

fn body(mjcf: &str) -> Description {
    from_mjcf("hand.xml", mjcf, &mut |_| Err("no other file".into())).unwrap()
}

/// Largest differences of torques, relative to the largest, of energies, relative, and torques at rest.
fn errors(robot: &Robot, hand: &Hand) -> [f64; 3] {
    let mut model = MuscleDynamics::new(robot).unwrap();
    let (mut poses, n) = (Poses::new(robot), robot.nv());
    let (mut torque, mut worst) = (vec![0.0; n], [0.0_f64; 3]);
    let zero = vec![0.0; n];
    for case in &hand.cases {
        model.evaluate(&case.q).unwrap();
        model.inverse_dynamics(&case.v, &zero, &mut torque).unwrap();
        let most = case.torque.iter().fold(0.0_f64, |most, x| most.max(x.abs()));
        let error = torque.iter().zip(&case.torque).map(|(a, b)| (a - b).abs()).fold(0.0, f64::max);
        robot.forward_kinematics(&case.q, &mut poses).unwrap();
        let energy = robot.potential_energy(&case.q, &poses).unwrap() + model.spring_energy();
        worst[0] = worst[0].max(error / most);
        worst[1] = worst[1].max((energy - case.energy).abs() / case.energy.abs());
    }
    for q in &hand.rests {
        model.evaluate(q).unwrap();
        model.inverse_dynamics(&zero, &zero, &mut torque).unwrap();
        worst[2] = torque.iter().fold(worst[2], |most, x| most.max(x.abs()));
    }
    worst
}

#[test]
fn torques_energies_and_equilibria_of_springs_are_mujocos_in_a_body_a_machine_and_its_copies() {
    let (hands, mut rests) = (hands(), 0);
    for (k, hand) in hands.iter().enumerate() {
        let own = machine("body = \"hand.xml\"\n", &hand.mjcf).unwrap();
        let parts = own.robot.parts();
        assert_eq!(parts.tendons.len(), parts.joints.len());
        assert_eq!(parts.springs.len(), parts.joints.len() + 1, "the cord is left out");
        let again = machine("body = \"hand.xml\"\n", &to_mjcf(parts)).unwrap();
        let copy = machine(&to_toml(parts), "").unwrap();
        assert!(again.robot == own.robot && copy.robot == own.robot);
        for robot in [&body(&hand.mjcf).robot().unwrap().0, &own.robot] {
            let [torque, energy, rest] = errors(robot, hand);
            assert!(torque < 2e-13 && energy < 2e-13 && rest < 2e-12, "{k}: {torque:e} {energy:e} {rest:e}");
        }
        rests += hand.rests.len();
    }
    assert!(hands.len() >= 12 && rests > 50);
}

#[test]
fn a_tendon_with_a_transmission_is_a_muscle_and_its_spring_acts_beside_it() {
    let hand = &hands()[0];
    let text = "body = \"hand.xml\"\n[[transmission]]\nmuscle = \"s0\"\n";
    let own = machine(text, &hand.mjcf).unwrap();
    assert!(own.robot.parts().tendons.iter().any(|tendon| tendon.name == "s0"));
    assert!(errors(&own.robot, hand)[0] < 2e-13);
}

const LEG: &str = r#"<mujoco><option gravity="0 0 -9.81"/><worldbody><site name="hip" pos="0.05 0 0"/>
  <body name="thigh"><joint name="a" axis="0 1 0" range="-170 170"/><inertial pos="0 0 -0.15" mass="2" diaginertia=".02 .02 .002"/>
    <site name="front" pos="0.04 0 -0.2"/>
    <body name="shank" pos="0 0 -0.3"><joint name="b" axis="0 1 0" range="-170 170"/>
      <inertial pos="0 0 -0.15" mass="1" diaginertia=".01 .01 .001"/><site name="toe" pos="0.02 0 -0.1"/></body></body></worldbody>
  <tendon><fixed name="m"><joint joint="a" coef="0.03"/></fixed><fixed name="n"><joint joint="b" coef="0.03"/></fixed></tendon></mujoco>"#;
const SPRINGS: &str = r#"body = "leg.xml"
[[spring]]
name = "elastic"
path = [{ site = "hip" }, { site = "front" }, { site = "toe" }]
stiffness_n_per_m = 900.0
slack_lengths_m = [0.0, 0.32]
[[spring]]
name = "joint"
joints = [{ joint = "a", coefficient = 0.04 }, { joint = "b", coefficient = -0.02 }]
stiffness_n_per_m = 4000.0
"#;

#[test]
fn the_twin_conserves_the_energy_of_body_and_springs_and_dampers_take_it() {
    let swing = |toml: &str| {
        let machine = machine(toml, LEG).unwrap();
        let torn = |k| InjectedFault { start: 0.0, duration: f64::INFINITY, failure: Failure::Cable(k) };
        let specimen = ArmSpecimen::nominal(&machine).unwrap();
        let mut arm = ArmTwin::new(&specimen, &[0.3, -0.2], &[20.0; 2], 1)
            .unwrap()
            .with_faults(&[torn(0), torn(1)])
            .unwrap();
        let hold = [DriveCommand::Velocity(0.0); 2];
        arm.step(&hold, machine.period).unwrap();
        let begin = arm.energy().unwrap();
        let (mut least, mut most, mut fastest) = (begin, begin, 0.0_f64);
        for _ in 0..4000 {
            arm.step(&hold, machine.period).unwrap();
            let now = arm.energy().unwrap();
            (least, most) = (least.min(now), most.max(now));
            fastest = arm.truth().v.iter().fold(fastest, |fast, v| fast.max(v.abs()));
        }
        assert!(fastest > 0.5, "{fastest}");
        [begin, least, most, arm.energy().unwrap()]
    };
    let [begin, least, most, _] = swing(SPRINGS);
    assert!(most - begin < 0.03 && begin - least < 0.03, "{begin} {least} {most}");
    let [begin, _, most, end] = swing(&SPRINGS.replace("4000.0", "4000.0\ndamping_n_s_per_m = 60.0"));
    assert!(most - begin < 0.03 && begin - end > 0.1, "{begin} {most} {end}");
}

#[test]
fn one_sided_springs_never_push_and_what_is_no_spring_is_refused_by_name() {
    let robot = |toml: &str| machine(toml, LEG).map(|machine| machine.robot);
    let slack = "slack_lengths_m = [0.001, 0.002]\n";
    let [both, one] = ["", "one_sided = true\n"].map(|one| {
        let mut model = MuscleDynamics::new(&robot(&format!("{SPRINGS}{slack}{one}")).unwrap()).unwrap();
        model.evaluate(&[-0.3, 0.0]).unwrap();
        model.spring_energy()
    });
    assert!(both > one + 0.1);
    for (was, is, told) in [
        (
            "joints =",
            "path = [{ site = \"hip\" }, { site = \"toe\" }]\njoints =",
            "either `path` or `joints`",
        ),
        ("stiffness_n_per_m = 4000.0", "one_sided = true\nstiffness_n_per_m = 4000.0", "slack_lengths_m"),
        ("\"elastic\"\npath", "\"m\"\npath", "name of a tendon"),
        ("stiffness_n_per_m = 4000.0", "stiffness_n_per_m = -1.0", "stiffness_n_per_m"),
        ("stiffness_n_per_m = 4000.0", "stiffness = 4000.0", "stiffness_n_per_m"),
        ("[0.0, 0.32]", "[0.4, 0.32]", "slack_lengths_m"),
        (
            "\"joint\"\njoints = [{ joint = \"a\", coefficient = 0.04 }, { joint = \"b\", coefficient = -0.02 }]",
            "\"x\"",
            "tendon of the body",
        ),
    ] {
        let text = SPRINGS.replace(was, is);
        assert!(text != SPRINGS, "{was}");
        let error = robot(&text).unwrap_err();
        assert!(error.contains(told), "{told}: {error}");
    }
    let own = robot(&format!("{SPRINGS}[[spring]]\nname = \"n\"\nstiffness_n_per_m = 100.0\n")).unwrap();
    let names = |tendons: &[Tendon]| tendons.iter().map(|tendon| tendon.name.clone()).collect::<Vec<_>>();
    assert_eq!(
        (names(&own.parts().tendons), names(&own.parts().springs)),
        (vec!["m".into()], vec!["elastic".to_string(), "joint".into(), "n".into()])
    );
}
