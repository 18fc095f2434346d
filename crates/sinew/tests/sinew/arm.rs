//! The arm's twin: what a body on fifteen cables may and may not do.

#![allow(clippy::unwrap_used, reason = "a failing test may panic")]

use crate::common;

use common::{lm_arm, lm_machine};
use sinew::body::{Robot, Scratch};
use sinew::drive::{Drive, DriveCommand, DriveParameters};
use sinew::muscle::{Geometry, Muscles};
use sinew::random::Random;
use sinew::twin::arm::{ArmSpecimen, ArmTwin, Failure, InjectedFault, Sensor, SensorFailure, Worn};
use sinew::twin::bench::Bench;
use sinew::twin::cable::{Effects, Resolution, Specimen};

const H: f64 = 1e-3;
const STAND: [DriveCommand; 15] = [DriveCommand::Velocity(0.0); 15];

fn start(robot: &Robot) -> Vec<f64> {
    robot.key("start").unwrap().to_vec()
}

/// Tensions of at least `least` that hold gravity, by projected gradient: slow, and independent of any
/// solver.
fn holding(robot: &Robot, q: &[f64], least: f64) -> Vec<f64> {
    let muscles = Muscles::new(robot);
    let (mut geometry, mut arms) = (Geometry::new(robot, &muscles), vec![0.0; 15 * 7]);
    muscles.evaluate(q, &mut geometry).unwrap();
    muscles.dense(&geometry, &mut arms).unwrap();
    let mut gravity = vec![0.0; 7];
    robot.gravity_force(q, &mut Scratch::new(robot), &mut gravity).unwrap();
    let mut tensions = vec![least; 15];
    for _ in 0..400_000 {
        let mut missing = gravity.clone();
        for (row, f) in arms.chunks(7).zip(&tensions) {
            row.iter().zip(&mut missing).for_each(|(r, m)| *m -= r * f);
        }
        for (row, f) in arms.chunks(7).zip(&mut tensions) {
            let along: f64 = row.iter().zip(&missing).map(|(r, m)| r * m).sum();
            *f = (*f + 60.0 * along).max(least);
        }
    }
    let mut torque = vec![0.0; 7];
    muscles.torque(&geometry, &tensions, &mut torque).unwrap();
    assert!(torque.iter().zip(&gravity).all(|(a, b)| (a - b).abs() < 1e-3), "{torque:?} {gravity:?}");
    tensions
}

fn nominal() -> ArmSpecimen {
    ArmSpecimen::nominal(&lm_machine()).unwrap()
}

/// Without slow effects: the laws alone.
fn bare() -> ArmSpecimen {
    let mut specimen = nominal();
    for cable in &mut specimen.cables {
        *cable = Specimen { effects: Effects::none(), ..cable.clone() };
    }
    specimen
}

fn worst(a: &[f64], b: &[f64]) -> f64 {
    a.iter().zip(b).fold(0.0, |worst: f64, (a, b)| worst.max((a - b).abs()))
}

#[test]
fn an_arm_whose_tensions_balance_gravity_stays_at_rest() {
    let specimen = nominal();
    let q = start(&specimen.robot);
    let tensions = holding(&specimen.robot, &q, 30.0);
    let mut arm = ArmTwin::new(&specimen, &q, &tensions, 1).unwrap();
    for _ in 0..2000 {
        arm.step(&STAND, H).unwrap();
    }
    let truth = arm.truth();
    assert!(worst(truth.q, &q) < 1e-3, "{:?} {q:?}", truth.q);
    assert!(truth.v.iter().all(|v| v.abs() < 1e-3), "{:?}", truth.v);
    // Without tensions the same arm falls.
    let weak = vec![16.0; 15];
    let mut arm = ArmTwin::new(&specimen, &q, &weak, 1).unwrap();
    for _ in 0..2000 {
        arm.step(&STAND, H).unwrap();
    }
    assert!(worst(arm.truth().q, &q) > 0.05);
}

#[test]
fn friction_of_a_sheath_that_passes_a_joint_follows_the_pose() {
    let plain = lm_machine();
    let mut machine = plain.clone();
    machine.muscles[3].bend_by_joint = vec![0.5, 0.0, 0.0, -0.3, 0.0, 0.0, 0.0];
    let bare = |machine: &sinew::machine::Machine| {
        let mut specimen = ArmSpecimen::nominal(machine).unwrap();
        specimen.cables.iter_mut().for_each(|cable| cable.effects = Effects::none());
        specimen
    };
    let (with, without) = (bare(&machine), bare(&plain));
    assert_eq!(with.cables, without.cables);
    for turn in [[0.0, 0.0], [0.4, 0.2], [-0.5, 0.6]] {
        let mut q = machine.start.clone();
        q[0] += turn[0];
        q[3] += turn[1];
        // Steady sliding toward the motor, the profile with which a twin starts.
        let near = |specimen: &ArmSpecimen| {
            let twin = ArmTwin::new(specimen, &q, &[60.0; 15], 1).unwrap();
            twin.truth().cables.iter().map(|cable| cable.tension_in).collect::<Vec<f64>>()
        };
        let (near_with, near_without) = (near(&with), near(&without));
        let change = with.cables[3].parameters.friction * (0.5 * turn[0] - 0.3 * turn[1]);
        for (k, (a, b)) in near_with.iter().zip(&near_without).enumerate() {
            let expected = if k == 3 { change } else { 0.0 };
            assert!(((a / b).ln() - expected).abs() < 2e-3, "{k}: {a} {b} {expected}");
        }
    }
    // Stepped, it follows the pose in motion; of a specimen the coefficients are its own.
    let drawn = ArmSpecimen::draw(&machine, 5).unwrap();
    assert!(drawn.bends[3] != with.bends[3] && drawn.bends[2] == with.bends[2]);
    assert_eq!(drawn.cables, ArmSpecimen::draw(&plain, 5).unwrap().cables);
    let q = &machine.start;
    let [mut moved, mut same] =
        [&with, &without].map(|specimen| ArmTwin::new(specimen, q, &[16.0; 15], 1).unwrap());
    for _ in 0..400 {
        moved.step(&STAND, H).unwrap();
        same.step(&STAND, H).unwrap();
    }
    assert!(worst(moved.truth().q, q) > 0.02 && worst(moved.truth().q, same.truth().q) > 1e-9);
}

#[test]
fn with_all_winches_jammed_no_energy_is_ever_created() {
    let specimen = bare();
    let q = start(&specimen.robot);
    let jammed: Vec<InjectedFault> = (0..15)
        .map(|k| InjectedFault { start: 0.0, duration: f64::INFINITY, failure: Failure::Winch(k) })
        .collect();
    for tension in [30.0, 120.0, 250.0] {
        let mut arm = ArmTwin::new(&specimen, &q, &[tension; 15], 1).unwrap().with_faults(&jammed).unwrap();
        let begin = arm.energy().unwrap();
        let (mut before, mut fastest) = (begin, 0.0_f64);
        for k in 0..3000 {
            arm.step(&STAND, H).unwrap();
            let now = arm.energy().unwrap();
            assert!(now < before + 1e-6, "{tension} N, {k} ms: {before} -> {now}");
            before = now;
            fastest = arm.truth().v.iter().fold(fastest, |most, v| most.max(v.abs()));
        }
        assert!(fastest > 0.2, "nothing moved");
        assert!(before < begin - 1e-3, "friction took nothing: {begin} {before}");
        assert!(arm.truth().v.iter().all(|v| v.abs() < 0.5 * fastest), "{:?} {fastest}", arm.truth().v);
    }
}

#[test]
fn broken_strands_lower_the_tension_once_and_leave_it_steady() {
    let specimen = bare();
    let q = start(&specimen.robot);
    let tensions = holding(&specimen.robot, &q, 60.0);
    for muscle in [0, 4, 9, 14] {
        let failure = Failure::Wear { muscle, what: Worn::Stiffness, fraction: 1.0 / 6.0 };
        let fault = InjectedFault { start: 0.5, duration: f64::INFINITY, failure };
        let mut arm = ArmTwin::new(&specimen, &q, &tensions, 1).unwrap().with_faults(&[fault]).unwrap();
        let at_drive: Vec<f64> = (0..2000)
            .map(|_| {
                arm.step(&STAND, H).unwrap();
                arm.truth().cables[muscle].tension_in
            })
            .collect();
        let (before, after) = (at_drive[498], at_drive[501]);
        assert!((0.8..0.95).contains(&(after / before)), "muscle {muscle}: {before} -> {after} N");
        let most = at_drive[1000..].windows(2).map(|pair| (pair[1] - pair[0]).abs()).fold(0.0, f64::max);
        assert!(most < 0.05, "muscle {muscle}: {most} N from one step to the next");
    }
}

#[test]
fn a_posture_that_turns_a_cable_more_costs_it_more_tension() {
    let specimen = bare();
    let robot = &specimen.robot;
    let muscles = Muscles::new(robot);
    let at = |elbow: f64| {
        let mut q = start(robot);
        q[3] = elbow;
        let arm = ArmTwin::new(&specimen, &q, &[60.0; 15], 1).unwrap();
        let (mut geometry, mut bends) = (Geometry::new(robot, &muscles), [0.0; 15]);
        muscles.evaluate(&q, &mut geometry).unwrap();
        muscles.bends(&geometry, &mut bends).unwrap();
        let triceps = arm.truth().cables[8];
        ((triceps.tension_in / (triceps.tension_out - 15.5)).ln(), bends[8])
    };
    let ((straight, little), (bent, much)) = (at(0.1), at(2.0));
    assert!(much > little + 1.0, "{little} {much}");
    assert!((bent - straight - 0.156 * (much - little)).abs() < 2e-3, "{straight} {bent}");
}

#[test]
fn every_transmission_of_an_arm_can_be_put_on_the_bench_alone() {
    let specimen = ArmSpecimen::draw(&lm_machine(), 2).unwrap();
    for (cable, drive) in specimen.cables.iter().zip(&specimen.drives) {
        let mut bench = Bench::new(cable, specimen.resolution, *drive, 1).unwrap();
        bench.settle(60.0).unwrap();
        for _ in 0..300 {
            let load = DriveCommand::Tension { tension: 60.0, feed: -0.05 };
            bench.step(DriveCommand::Velocity(0.05), load, H).unwrap();
        }
        let truth = bench.truth();
        assert!(bench.fault().is_none() && truth.broken.is_none());
        assert!((truth.tension_out - 60.0).abs() < 10.0 && truth.tension_in > truth.tension_out - 15.5);
    }
}

/// Random commands, invalid ones included.
fn random_commands(random: &mut Random) -> [DriveCommand; 15] {
    core::array::from_fn(|_| match random.bits() % 4 {
        0 => DriveCommand::Velocity(0.3 * (random.unit() - 0.5)),
        1 => DriveCommand::Tension { tension: 300.0 * random.unit(), feed: 0.0 },
        2 => DriveCommand::Current(f64::NAN),
        _ => DriveCommand::Off,
    })
}

#[test]
fn for_any_commands_the_state_stays_finite_and_tensions_non_negative() {
    for seed in 0..4 {
        let robot = lm_arm();
        let q = start(&robot);
        let specimen = ArmSpecimen::draw(&lm_machine(), seed).unwrap();
        let mut arm = ArmTwin::new(&specimen, &q, &[60.0; 15], seed).unwrap();
        let mut random = Random::new(seed);
        for k in 0..4000 {
            let told = if k % 50 == 0 { random_commands(&mut random) } else { STAND };
            let truth = arm.step(&told, H).unwrap();
            assert!(truth.q.iter().chain(truth.v).all(|x| x.is_finite()));
            assert!(truth.cables.iter().all(|cable| cable.tension_out >= 0.0 && cable.tension_in >= 0.0));
        }
    }
}

#[test]
fn equal_seeds_give_equal_bits_and_different_seeds_different_arms() {
    let run = |seed| {
        let robot = lm_arm();
        let q = start(&robot);
        let specimen = ArmSpecimen::draw(&lm_machine(), seed).unwrap();
        let mut arm = ArmTwin::new(&specimen, &q, &[60.0; 15], seed).unwrap();
        let mut random = Random::new(9);
        let mut bits = Vec::new();
        for _ in 0..500 {
            arm.step(&random_commands(&mut random), H).unwrap();
            let (truth, reading) = (arm.truth(), arm.reading());
            bits.extend(truth.q.iter().chain(&reading.tension).chain(&reading.joint).map(|x| x.to_bits()));
        }
        bits
    };
    assert!(run(3) == run(3));
    assert!(run(3) != run(4));
}

#[test]
fn finer_steps_change_the_motion_little_and_less_and_less() {
    let end = |substeps| {
        let mut specimen = bare();
        specimen.resolution = Resolution { substeps, ..specimen.resolution };
        let q = start(&specimen.robot);
        let mut arm = ArmTwin::new(&specimen, &q, &[80.0; 15], 1).unwrap();
        let mut told = STAND;
        told[7] = DriveCommand::Velocity(0.04);
        told[8] = DriveCommand::Velocity(-0.04);
        for _ in 0..500 {
            arm.step(&told, H).unwrap();
        }
        arm.truth().q.to_vec()
    };
    let finest = end(16);
    let (one, two, four) = (worst(&end(1), &finest), worst(&end(2), &finest), worst(&end(4), &finest));
    assert!(worst(&finest, &start(&lm_arm())) > 0.1, "the elbow has not moved");
    assert!(two < 5e-4 && four < two && two < one, "{one} {two} {four}");
}

#[test]
fn after_a_cable_breaks_the_arm_falls_to_a_stop() {
    let specimen = nominal();
    let q = start(&specimen.robot);
    let tensions = holding(&specimen.robot, &q, 30.0);
    let fault = InjectedFault { start: 0.5, duration: H, failure: Failure::Cable(7) };
    let mut arm = ArmTwin::new(&specimen, &q, &tensions, 1).unwrap().with_faults(&[fault]).unwrap();
    for k in 0..3000 {
        let truth = arm.step(&STAND, H).unwrap();
        let broken = truth.cables[7].broken;
        assert_eq!(broken.is_some(), k >= 500, "{k}");
        if k > 500 {
            assert!(truth.cables[7].tension_out.abs() < 1e-12 && truth.cables[7].tension_in.abs() < 1e-12);
        }
    }
    let elbow = arm.truth().q[3];
    assert!(elbow < q[3] - 0.3 && elbow > -0.2, "{elbow}");
}

#[test]
fn a_jammed_winch_does_not_move_and_an_amplifier_that_is_off_ignores_commands() {
    let specimen = nominal();
    let q = start(&specimen.robot);
    let wound = |what| {
        let fault = InjectedFault { start: 0.1, duration: f64::INFINITY, failure: what };
        let mut arm = ArmTwin::new(&specimen, &q, &[60.0; 15], 1).unwrap().with_faults(&[fault]).unwrap();
        let mut told = STAND;
        told[8] = DriveCommand::Velocity(0.05);
        let mut moved = [0.0; 2];
        for k in 0..400 {
            moved[usize::from(k >= 110)] += arm.step(&told, H).unwrap().drives[8].moved;
        }
        moved
    };
    let [before, after] = wound(Failure::Winch(8));
    assert!(before > 2e-3 && after.abs() < 1e-12);
    let [before, after] = wound(Failure::Amplifier(8));
    assert!(before > 2e-3 && after < -1e-3, "the cable turns a drive without power back: {after}");
    let [before, after] = wound(Failure::Amplifier(3));
    assert!(before > 2e-3 && after > 0.9 * 0.05 * 0.29);
}

#[test]
fn sensor_faults_last_for_their_duration_and_do_not_affect_the_plant() {
    let specimen = nominal();
    let q = start(&specimen.robot);
    let fault =
        |sensor, how| InjectedFault { start: 0.05, duration: 0.01, failure: Failure::Sensor(sensor, how) };
    let faults = [
        fault(Sensor::Tension(2), SensorFailure::Lost),
        fault(Sensor::Motor(4), SensorFailure::Stuck),
        fault(Sensor::Joint(3), SensorFailure::NotANumber),
    ];
    let mut sound = ArmTwin::new(&specimen, &q, &[60.0; 15], 1).unwrap();
    let mut failing = sound.clone().with_faults(&faults).unwrap();
    let told = [DriveCommand::Velocity(0.02); 15];
    let mut stuck = None;
    for k in 0..100 {
        sound.step(&told, H).unwrap();
        failing.step(&told, H).unwrap();
        let (a, b) = (sound.reading(), failing.reading());
        let failed = (50..60).contains(&k);
        assert_eq!(b.joint[3].is_nan(), failed, "{k}");
        assert_eq!(b.tension[2].abs() < 1e-12, failed, "{k}");
        if failed {
            let first = *stuck.get_or_insert(b.motor[4]);
            assert!((b.motor[4] - first).abs() < 1e-15 && a.motor[4] > first);
        } else {
            assert!((b.motor[4] - a.motor[4]).abs() < 1e-15);
        }
        assert!(worst(sound.truth().q, failing.truth().q) < 1e-15);
    }
    let nobody = InjectedFault { start: 0.0, duration: 1.0, failure: Failure::Winch(15) };
    assert!(sound.clone().with_faults(&[nobody]).is_err());
    assert!(sound.with_faults(&[InjectedFault { start: f64::NAN, ..faults[0] }]).is_err());
}

#[test]
fn measurements_are_delayed_by_a_millisecond_with_quantisation_noise_and_zero_errors_only() {
    let robot = lm_arm();
    let q = start(&robot);
    let specimen = ArmSpecimen::draw(&lm_machine(), 5).unwrap();
    let mut arm = ArmTwin::new(&specimen, &q, &[60.0; 15], 5).unwrap();
    let mut told = STAND;
    told[7] = DriveCommand::Velocity(0.05);
    let count = 2.0 * std::f64::consts::PI / 16384.0;
    let mut moved = 0.0_f64;
    for _ in 0..500 {
        let before = arm.truth().q.to_vec();
        let pull: Vec<f64> = arm.truth().cables.iter().map(|cable| cable.tension_in).collect();
        arm.step(&told, H).unwrap();
        let zeros = specimen.encoders.iter().flatten().map(|encoder| encoder.zero);
        for ((read, was), zero) in arm.reading().joint.iter().zip(&before).zip(zeros) {
            assert!((read - was - zero).abs() <= 0.5 * count + 1e-12);
        }
        for (read, felt) in arm.reading().tension.iter().zip(&pull) {
            assert!((read - felt).abs() < 0.005 * felt + 5.0 * 0.4, "{read} {felt}");
        }
        moved = moved.max(worst(&before, &q));
    }
    assert!(moved > 0.05, "{moved}");
}

#[test]
fn specimens_scatter_within_their_bounds_and_a_payload_adds_its_weight() {
    let robot = lm_arm();
    let q = start(&robot);
    let of = ArmSpecimen::nominal(&lm_machine()).unwrap();
    let mut furthest = [0.0_f64; 4];
    for seed in 0..50 {
        let drawn = ArmSpecimen::sampled_around(&of, &lm_machine(), seed).unwrap();
        for (a, b) in drawn.robot.parts().bodies.iter().zip(&robot.parts().bodies) {
            if b.mass > 0.0 {
                furthest[0] = furthest[0].max((a.mass / b.mass - 1.0).abs());
            }
        }
        for (a, b) in drawn.robot.parts().sites.iter().zip(&robot.parts().sites) {
            furthest[1] = furthest[1].max(worst(&a.position, &b.position));
        }
        for drive in &drawn.drives {
            furthest[2] = furthest[2].max((drive.load_cell.gain - 1.0).abs());
        }
        for encoder in drawn.encoders.iter().flatten() {
            furthest[3] = furthest[3].max(encoder.zero.abs());
        }
        assert!(ArmTwin::new(&drawn, &q, &[60.0; 15], seed).is_ok());
    }
    for (furthest, bound) in furthest.into_iter().zip([0.1, 1e-3, 5e-3, 1e-3]) {
        assert!(furthest <= bound * (1.0 + 1e-9) && furthest > 0.9 * bound, "{furthest} {bound}");
    }
    let hand = robot.body("hand").unwrap();
    let loaded = of.clone().with_payload(hand, [0.0, 0.0, -0.1], 1.0).unwrap();
    let height = |specimen: &ArmSpecimen| {
        let mut arm = ArmTwin::new(specimen, &q, &[60.0; 15], 1).unwrap();
        for _ in 0..300 {
            arm.step(&STAND, H).unwrap();
        }
        arm.truth().q[3]
    };
    assert!(height(&loaded) < height(&of) - 0.01, "{} {}", height(&loaded), height(&of));
}

#[test]
fn the_drive_has_three_metres_per_second_squared_at_250_newtons() {
    // With the acceleration limit lifted, motor and amplifier are the limit.
    let free = DriveParameters { acceleration: 50.0, ..DriveParameters::mc_am() };
    for tension in [100.0, 250.0, 445.0] {
        for (parameters, least) in [(DriveParameters::mc_am(), 3.0), (free, 3.0)] {
            let mut drive = Drive::new(parameters, 1).unwrap();
            drive.settle(tension);
            for _ in 0..300 {
                drive.step(DriveCommand::Velocity(0.0), tension, H);
            }
            let mut steps = 0;
            while drive.step(DriveCommand::Velocity(0.14), tension, H).speed < 0.126 {
                steps += 1;
                assert!(steps < 1000);
            }
            let acceleration = 0.126 / (f64::from(steps) * H);
            assert!(acceleration > least, "{tension} N: {acceleration}");
        }
    }
}

#[test]
fn a_period_of_four_milliseconds_is_four_steps_of_one_to_the_bit_and_its_energies_are_their_sums() {
    let machine = sinew::machine::Machine { period: 4e-3, ..lm_machine() };
    let slow = ArmSpecimen::nominal(&machine).unwrap();
    assert!((slow.step() - H).abs() < 1e-18);
    assert_eq!(slow.resolution, nominal().resolution);
    let new = |specimen: &ArmSpecimen| ArmTwin::new(specimen, &machine.start, &[40.0; 15], 3).unwrap();
    let (mut whole, mut steps) = (new(&slow), new(&nominal()));
    for k in 0..50 {
        let told: Vec<DriveCommand> = (0..15)
            .map(|muscle| DriveCommand::Velocity(0.02 * (0.1 * f64::from(k + muscle)).sin()))
            .collect();
        let (mut moved, mut heat) = (0.0, 0.0);
        for _ in 0..4 {
            let step = steps.step(&told, H).unwrap().drives[3];
            (moved, heat) = (moved + step.moved, heat + step.heat);
        }
        let found = whole.step(&told, machine.period).unwrap();
        let drive = found.drives[3];
        assert!((drive.moved - moved).abs() < 1e-15 && (drive.heat - heat).abs() < 1e-12 * heat.abs());
        assert!((drive.speed - moved / 4e-3).abs() < 1e-12);
        let bits = |q: &[f64]| q.iter().map(|q| q.to_bits()).collect::<Vec<_>>();
        assert_eq!(bits(found.q), bits(steps.truth().q), "{k}");
        assert_eq!(whole.reading(), steps.reading(), "{k}");
    }
}

#[test]
fn a_sensor_is_late_by_the_same_time_whatever_the_period_of_the_machine() {
    let position = |period: f64| {
        let mut machine = sinew::machine::Machine { period, ..lm_machine() };
        machine.muscles.iter_mut().for_each(|muscle| muscle.drive.delay_ms = 6.0);
        let specimen = ArmSpecimen::nominal(&machine).unwrap();
        let mut arm = ArmTwin::new(&specimen, &machine.start, &[40.0; 15], 1).unwrap();
        let first = arm.reading().motor[0];
        for _ in 0..(0.06 / period).round() as usize {
            arm.step(&[DriveCommand::Velocity(0.05); 15], period).unwrap();
        }
        arm.reading().motor[0] - first
    };
    let at_one = position(1e-3);
    for period in [5e-4, 1.5e-3, 2e-3, 4e-3] {
        // Sensors are sampled at the beginning of a step: half a millisecond of 50 mm/s at most.
        assert!((position(period) - at_one).abs() < 3e-5, "{period}: {} {at_one}", position(period));
    }
}
