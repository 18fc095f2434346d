//! The machines of this repository: their cables can do what their bodies need.

use super::model;
use sinew::control::arm::tension_limits;
use sinew::control::tension::{Distribution, Problem, Status};
use sinew::machine::{Characteristics, Machine};
use sinew::muscle::MuscleDynamics;
use sinew::random::Random;

/// Every machine, its independent joints and its muscles.
const MODELS: [(&str, usize, usize); 9] = [
    ("bench_joint", 1, 2),
    ("planar_leg", 2, 4),
    ("finger", 3, 5),
    ("spring_finger", 3, 1),
    ("exosuit_elbow", 1, 2),
    ("surgical_wrist", 3, 6),
    ("lm_arm", 7, 15),
    ("shoulder", 3, 8),
    ("chain10", 10, 24),
];

/// Poses within the ranges of the independent joints.
fn poses(machine: &Machine, count: usize) -> Vec<Vec<f64>> {
    let mut random = Random::new(7);
    let joints = machine.robot.independent_joints();
    let ranges: Vec<[f64; 2]> =
        joints.iter().map(|&joint| machine.robot.parts().joints[joint].range.unwrap()).collect();
    let mut pose = || ranges.iter().map(|[low, high]| low + (high - low) * random.unit()).collect();
    (0..count).map(|_| pose()).collect()
}

/// Sampled poses.
const POSES: usize = 500;

#[test]
fn every_machine_has_the_joints_and_muscles_it_is_described_with() {
    for (name, joints, muscles) in MODELS {
        let read = model(name);
        assert!(read.warnings.is_empty(), "{name}: {:?}", read.warnings);
        let machine = read.machine;
        assert_eq!((machine.encoders.len(), machine.muscles.len()), (joints, muscles), "{name}");
        let parts = machine.robot.parts();
        assert!(machine.robot.key("start").is_some() && machine.robot.site("endpoint").is_some(), "{name}");
        for (joint, start) in machine.robot.independent_joints().iter().zip(&machine.start) {
            let [low, high] = parts.joints[*joint].range.unwrap();
            assert!((low..=high).contains(start), "{name}: {}", parts.joints[*joint].name);
        }
    }
}

#[test]
fn the_weight_of_every_machine_is_held_with_a_fifth_to_spare_all_over_its_range() {
    for (name, joints, muscles) in MODELS {
        let machine = model(name).machine;
        // One cable holds only the poses to which its springs take it.
        if muscles < joints {
            continue;
        }
        let mut dynamics = MuscleDynamics::new(&machine.robot).unwrap();
        let limits = tension_limits(&machine, &machine.laws(12).unwrap());
        let minimum: Vec<f64> = limits.iter().map(|[least, _]| *least).collect();
        let maximum: Vec<f64> = limits.iter().map(|[least, most]| (0.8 * most).max(*least)).collect();
        let mut distribution = Distribution::new(muscles, joints);
        let (zeros, ones, still) = (vec![0.0; muscles], vec![1.0; muscles], vec![0.0; joints]);
        let (mut torque, mut held) = (vec![0.0; joints], 0);
        for pose in &poses(&machine, POSES) {
            dynamics.evaluate(pose).unwrap();
            dynamics.inverse_dynamics(&still, &still, &mut torque).unwrap();
            let problem = Problem {
                moment_arms: dynamics.moment_arms(),
                torque: &torque,
                minimum: &minimum,
                maximum: &maximum,
                reference: &zeros,
                weight: &ones,
            };
            let solution = distribution.solve(&problem).unwrap();
            held += usize::from(solution.status == Status::Optimal);
        }
        // The LM-Arm is older than this demand; it misses it in the corners of its range.
        let required = if name == "lm_arm" { POSES * 97 / 100 } else { POSES };
        assert!(held >= required, "{name}: {held} of {POSES}");
    }
}

#[test]
fn the_dead_bands_of_every_machine_are_small_angles() {
    for (name, _, _) in MODELS {
        let machine = model(name).machine;
        let mut dynamics = MuscleDynamics::new(&machine.robot).unwrap();
        let laws = machine.laws(12).unwrap();
        let tensions: Vec<f64> = tension_limits(&machine, &laws)
            .iter()
            .zip(&laws)
            .map(|([l, _], law)| law.pretension() + 1.2 * l)
            .collect();
        let found = Characteristics::new(&mut dynamics, &laws, &tensions, &poses(&machine, 60), 0.0).unwrap();
        let bands: Vec<f64> = found.joints.iter().map(|joint| joint.dead_band).collect();
        // Its distal cables are long and their moment arms short.
        let limit = if name == "lm_arm" { 1.5 } else { 0.5 };
        assert!(bands.iter().all(|band| *band < limit), "{name}: {bands:?}");
    }
}

#[test]
fn the_default_devices_of_every_machine_drive_and_measure_everything() {
    for (name, _, muscles) in MODELS {
        let machine = model(name).machine;
        machine.validate().unwrap();
        let encoders = machine.encoders.iter().flatten().count();
        let signals: usize = machine.devices.iter().map(|device| device.channels().len()).sum();
        let drives = machine.devices.iter().filter(|device| device.driven_muscle().is_some()).count();
        assert_eq!((signals, drives), (muscles + encoders, muscles), "{name}");
    }
}
