//! Machines as workshops build them: what differs, and by how much.

use sinew::body::{Poses, Robot};
use sinew::machine::{Machine, Tolerances, Workshop};
use sinew::twin::arm::ArmSpecimen;

fn arm() -> Machine {
    let text = sinew_models::LM_ARM;
    let parts = sinew::description::from_toml("lm_arm.toml", text).unwrap().parts;
    Machine::from_robot(&Robot::new(parts).unwrap()).unwrap()
}

fn drawn(tolerances: Tolerances, seed: u64) -> ArmSpecimen {
    ArmSpecimen::draw(&Machine { tolerances, ..arm() }, seed).unwrap()
}

#[test]
fn each_kind_of_deviation_leaves_all_others_as_they_are() {
    let default = Tolerances::default();
    let all = default.of(Workshop::Careful, 1.0);
    let (plain, careful) = (drawn(default, 5), drawn(Tolerances { payload: 0.1, ..all }, 5));
    let axis = drawn(Tolerances { axis: all.axis, ..default }, 5);
    let flex = drawn(Tolerances { flex: all.flex, ..default }, 5);
    let winch = drawn(Tolerances { winch: all.winch, ..default }, 5);
    let kappa = |s: &ArmSpecimen| s.robot.parts().joints.iter().map(|j| j.flex).collect::<Vec<_>>();
    assert!(kappa(&flex) == kappa(&careful) && flex.robot.parts().bodies == plain.robot.parts().bodies);
    assert_eq!((&winch.robot, &winch.winches), (&plain.robot, &careful.winches));
    assert!(axis.robot != plain.robot && axis.cables == plain.cables && axis.encoders == plain.encoders);
    assert!(careful.cables == plain.cables && careful.drives == plain.drives);
    let zeros = |s: &ArmSpecimen| s.encoders.iter().flatten().map(|e| e.zero).collect::<Vec<_>>();
    assert_eq!(zeros(&careful), zeros(&plain));
    let mass = |s: &ArmSpecimen| s.robot.moving_mass();
    assert!((1e-6..0.1).contains(&(mass(&careful) - mass(&plain))));
}

#[test]
fn the_end_point_of_a_rough_arm_is_off_by_a_centimetre_and_of_a_careful_one_by_one_or_two_millimetres() {
    let machine = arm();
    let site = machine.task.site().unwrap();
    for (workshop, expected) in [(Workshop::Careful, 0.6e-3..4e-3), (Workshop::Rough, 5e-3..25e-3)] {
        let built = machine.clone().built_by(workshop);
        let (mut sum, mut count) = (0.0, 0.0);
        for seed in 0..10 {
            let specimen = ArmSpecimen::draw(&built, seed).unwrap();
            let mut poses = Poses::new(&machine.robot);
            for reading in machine.poses(10).unwrap() {
                machine.robot.forward_kinematics(&reading, &mut poses).unwrap();
                let design = machine.robot.site_pose(&poses, site).origin;
                let encoders = specimen.encoders.iter().flatten();
                let q: Vec<f64> = reading.iter().zip(encoders).map(|(r, e)| r - e.error(*r)).collect();
                specimen.robot.bent_kinematics(&q, &mut poses).unwrap();
                let real = specimen.robot.site_pose(&poses, site).origin;
                sum += (0..3).map(|k| (real[k] - design[k]).powi(2)).sum::<f64>().sqrt();
                count += 1.0;
            }
        }
        assert!(expected.contains(&(sum / count)), "{workshop:?}: {} m", sum / count);
    }
}
