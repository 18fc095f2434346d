//! A gantry whose forces, speeds and payloads are sums of a few products.

use super::directions::directions;
use super::model::transposed;
use super::*;
use crate::control::tests::{Slide, slides};
use crate::machine::{Machine, MuscleDesign, Task};
use crate::transmission::cable::CableParameters;
use alloc::vec;
use alloc::vec::Vec;
use core::f64::consts::TAU;

/// Arms of tackles, limits of tensions, N, and winch speeds, m/s: two cables pull along x, three along z.
const ARMS: [[f64; 2]; 5] = [[0.8, 0.0], [-1.0, 0.0], [0.0, 1.2], [0.0, -0.6], [0.0, 0.3]];
const LIMITS: [[f64; 2]; 5] = [[5.0, 40.0], [5.0, 25.0], [5.0, 60.0], [4.0, 30.0], [4.0, 150.0]];
const SPEEDS: [f64; 5] = [0.3, 0.5, 0.4, 0.35, 2.0];
/// Weight of the tool, N.
const WEIGHT: f64 = 0.5 * 9.81;
/// Friction angle and pretension of every cable.
const ANGLE: f64 = 0.1;
const PRETENSION: f64 = 2.0;

/// A tool of 0.5 kg that slides along z, on a carriage that slides along x.
fn gantry() -> Machine {
    let slide = |axis, mass| Slide { axis, mass, range: [-0.5, 0.5] };
    let arms: Vec<&[f64]> = ARMS.iter().map(|arms| &arms[..]).collect();
    let along = [slide([1.0, 0.0, 0.0], 1.0), slide([0.0, 0.0, 1.0], 0.5)];
    let mut machine = Machine::from_robot(&slides(9.81, &along, &arms)).unwrap();
    for (design, limits) in machine.muscles.iter_mut().zip(LIMITS) {
        let cable =
            CableParameters { friction: ANGLE, efficiency: 1.0, pretension: PRETENSION, ..design.cable };
        (design.cable, design.bend, design.tension) = (cable, 1.0, limits.map(Some));
    }
    machine
}

fn model() -> CapabilityModel {
    let mut model = CapabilityModel::new(&gantry()).unwrap();
    model.speeds = SPEEDS.to_vec();
    model.evaluate(&[0.1, -0.2]).unwrap();
    model
}

/// Largest force of the cables along or against an axis, N, without the weight.
fn force(axis: usize, sign: f64) -> f64 {
    let each = ARMS.iter().zip(LIMITS).map(|(arms, limits)| {
        let arm = sign * arms[axis];
        arm * limits[usize::from(arm > 0.0)]
    });
    each.sum()
}

fn close(got: f64, expected: f64) -> bool {
    (got / expected - 1.0).abs() < 7e-16
}

#[test]
fn every_joint_of_the_gantry_has_the_torque_and_the_speed_of_its_cables() {
    let found = model().at(&[0.1, -0.2]).unwrap();
    // Joint by joint: torque against and along it with the muscle whose limit changes it most, speed with its
    // muscle.
    for (j, (torques, (speed, muscle))) in [
        ([(force(0, -1.0), 1, true), (force(0, 1.0), 1, false)], (0.3 / 0.8, 0)),
        ([(force(1, -1.0) + WEIGHT, 2, false), (force(1, 1.0) - WEIGHT, 2, true)], (0.4 / 1.2, 2)),
    ]
    .into_iter()
    .enumerate()
    {
        let joint = found.joints[j];
        assert!((joint.needed - [0.0, WEIGHT][j]).abs() < 1e-15);
        for (got, (value, muscle, largest)) in joint.torque.unwrap().iter().zip(torques) {
            assert!(close(got.value, value), "{} {value}", got.value);
            assert_eq!((got.muscle, got.largest), (Some(muscle), largest));
        }
        assert!(close(joint.speed.value, speed));
        assert_eq!((joint.speed.muscle, joint.speed.largest), (Some(muscle), true));
    }
}

#[test]
fn the_end_point_of_the_gantry_is_weakest_downward_and_slowest_vertically() {
    let end = model().at(&[0.1, -0.2]).unwrap().end_point.unwrap();
    assert!(end.position.iter().zip([0.1, 0.0, -0.2]).all(|(got, expected)| (got - expected).abs() < 1e-15));
    let (weakest, direction) = end.force.unwrap();
    assert!(close(weakest.value, force(1, -1.0) + WEIGHT), "{}", weakest.value);
    assert_eq!((weakest.muscle, weakest.largest), (Some(2), false));
    assert!(direction.iter().zip([0.0, 0.0, -1.0]).all(|(got, expected)| (got - expected).abs() < 1e-15));
    let (slowest, direction) = end.speed.unwrap();
    assert!(close(slowest.value, 0.4 / 1.2) && slowest.muscle == Some(2));
    assert!((direction[2].abs() - 1.0).abs() < 1e-15);
    for payload in end.payload {
        let payload = payload.unwrap();
        assert!(close(payload.value, (force(1, 1.0) - WEIGHT) / 9.81), "{}", payload.value);
        assert_eq!(payload.muscle, Some(2));
    }
}

#[test]
fn the_outline_of_the_forces_is_the_box_of_both_axes_seen_from_the_weight() {
    let most = |axis: usize, sign: f64| match axis {
        0 => force(0, sign),
        2 => force(1, sign) - sign * WEIGHT,
        _ => f64::INFINITY,
    };
    for (plane, count) in [([0, 2], 12), ([2, 0], 5)] {
        let outline = model().force_outline(CableMotion::Either, plane, count).unwrap();
        assert_eq!(outline.len(), count);
        for (k, force) in outline.iter().enumerate() {
            let (sine, cosine) = (TAU * k as f64 / count as f64).sin_cos();
            let reach = [(cosine, plane[0]), (sine, plane[1])]
                .map(|(fraction, axis)| most(axis, fraction.signum()) / fraction.abs());
            let reach = reach[0].min(reach[1]);
            assert!(
                (force[0] - reach * cosine).abs() < 7e-14 && (force[1] - reach * sine).abs() < 7e-14,
                "{k}"
            );
        }
    }
    // Nothing holds the tool where its cables are too weak for it.
    let mut machine = gantry();
    machine.muscles[2].tension[1] = Some(5.5);
    machine.muscles[4].tension[1] = Some(4.5);
    machine.muscles[3].tension[0] = Some(25.0);
    let mut weak = CapabilityModel::new(&machine).unwrap();
    assert!(weak.force_outline(CableMotion::Either, [0, 2], 4).unwrap().is_empty());
}

#[test]
fn the_torques_of_the_gantry_are_the_box_of_its_cables() {
    let set = model().torque_set(CableMotion::Either).unwrap().unwrap();
    for (direction, axis) in [([1.0, 0.0], 0), ([-1.0, 0.0], 0), ([0.0, 1.0], 1), ([0.0, -1.0], 1)] {
        assert!(close(set.support(&direction).unwrap(), force(axis, direction[axis])));
    }
}

#[test]
fn the_least_velocity_upward_is_the_one_that_gravity_opposes() {
    let model = model();
    let up = model.upward().unwrap().unwrap();
    assert!(up[0].abs() < 1e-15 && (up[1] - 9.81).abs() < 1e-15, "{up:?}");
    // Also with the axes of the task: the weight acts along all.
    let mut machine = gantry();
    machine.task = Task::EndPoint { site: 0, axes: [true, false, false] };
    let mut model = CapabilityModel::new(&machine).unwrap();
    model.evaluate(&[0.0, 0.3]).unwrap();
    assert_eq!(model.upward().unwrap().unwrap(), up);
    let rows = model.end_point().unwrap().unwrap().rows;
    assert!(
        rows.iter().enumerate().all(|(k, x)| (x - if k == 0 { 1.0 } else { 0.0 }).abs() < 1e-15),
        "{rows:?}"
    );
}

#[test]
fn a_force_of_the_end_point_needs_its_lever_at_every_joint() {
    let rows = [1.0, 2.0, 3.0, 4.0, 5.0, 6.0];
    assert_eq!(transposed(&rows, [0.5, -1.0, 2.0]), [7.5, 9.0]);
    // The power is that of the velocities.
    let velocity = directions(&rows).velocity([0.2, -0.1, 0.4]);
    let moved: f64 = (0..3)
        .map(|k| [0.5, -1.0, 2.0][k] * (rows[2 * k] * velocity[0] + rows[2 * k + 1] * velocity[1]))
        .sum();
    assert!((moved - (7.5 * velocity[0] + 9.0 * velocity[1])).abs() < 1e-16);
}

#[test]
fn every_drive_holds_what_its_own_motor_endures() {
    let mut machine = gantry();
    for k in [1, 3, 4] {
        machine.muscles[k].drive.motor.housing_to_air *= 3.0;
    }
    for seconds in [30.0, f64::INFINITY] {
        let model = CapabilityModel::new(&machine).unwrap().holding_for(seconds);
        for (most, design) in model.max_tension.iter().zip(&machine.muscles) {
            assert!(close(*most, design.drive.holding_tension(seconds)), "{most}");
        }
    }
    let model = CapabilityModel::new(&machine).unwrap().holding_for(f64::INFINITY);
    assert!(model.max_tension[0] > 1.1 * model.max_tension[1]);
}

/// What limits the payload of the gantry after a change of its strongest cable.
fn limit(seconds: Option<f64>, change: impl Fn(&mut MuscleDesign)) -> Option<(usize, TensionLimit)> {
    let mut machine = gantry();
    change(&mut machine.muscles[2]);
    let model = CapabilityModel::new(&machine).unwrap();
    let mut model = match seconds {
        Some(seconds) => model.holding_for(seconds),
        None => model,
    };
    model.held_payloads(&[vec![0.1, 0.2]]).unwrap()[0].unwrap().limited_by
}

#[test]
fn a_payload_is_limited_by_the_muscle_whose_share_is_largest_and_by_what_limits_its_tension() {
    // One per cent of 60 N at an arm of 1.2 is more than one of 150 N at 0.3.
    assert_eq!(limit(None, |_| {}), Some((2, TensionLimit::Prescribed)));
    // A drive of at most 190 N, less at the anchor by the friction.
    let at_anchor = 190.0 * (-ANGLE).exp() + PRETENSION;
    let prescribed = |fraction: f64| {
        limit(None, |design| {
            design.drive.max_tension = 200.0;
            design.tension[1] = Some(fraction * at_anchor);
        })
    };
    assert_eq!(prescribed(0.995), Some((2, TensionLimit::Prescribed)));
    assert_eq!(prescribed(1.005), Some((2, TensionLimit::Drive)));
    let amplifier = limit(None, |design| {
        design.tension[1] = None;
        design.drive.motor.peak_current = design.drive.pulling_current(300.0, 0.0);
    });
    assert_eq!(amplifier, Some((2, TensionLimit::Amplifier)));
    let heat = limit(Some(f64::INFINITY), |design| design.tension[1] = None);
    assert_eq!(heat, Some((2, TensionLimit::Heat)));
}

#[test]
fn every_limit_has_a_name_of_its_own() {
    use TensionLimit::{Amplifier, Drive, Heat, Least, Prescribed};
    let names = [Heat, Amplifier, Drive, Prescribed, Least].map(TensionLimit::name);
    for (k, name) in names.iter().enumerate() {
        assert!(!name.is_empty() && !names[..k].contains(name), "{name}");
    }
}
