//! Cost of a millisecond of the arm's twin: 15 muscles, 7 joints, all effects; of its controller; and of a
//! sample of its trajectory.

#![allow(clippy::unwrap_used, reason = "a bench that cannot start may panic")]
#![allow(clippy::print_stdout, reason = "a bench prints")]

use divan::{Bencher, black_box, counter::ItemsCount};
use sinew::body::Robot;
use sinew::control::arm::{
    ActuationMode, ArmController, ArmMeasurement, ArmStatus, CableStateSource, PreviewedReference, synthesize,
};
use sinew::control::stretch::PREVIEW_HORIZON;
use sinew::drive::DriveCommand;
use sinew::machine::Machine;
use sinew::trajectory::{JointPath, Loop, Reference, TimeLaw, Trajectory};
use sinew::twin::arm::{ArmReading, ArmSpecimen, ArmTwin};
use sinew::twin::cable::Resolution;
use sinew_lab::experiment::arm::resting_tensions;
use sinew_lab::experiment::oracle_models;
use std::time::Instant;

fn main() {
    divan::main();
    tail();
}

/// Distribution of the time of single control cycles, the clock's overhead included.
fn tail() {
    let (start, told) = controller_in_motion();
    let mut times: Vec<u128> = Vec::new();
    for _ in 0..200 {
        let mut controller = start.clone();
        for (said, now, coming) in &told {
            let sample = ArmMeasurement { motor: &said.motor, tension: &said.tension, joint: &said.joint };
            let begin = Instant::now();
            black_box(
                controller
                    .step(
                        1e-3,
                        &sample,
                        &PreviewedReference { current: now, previewed: coming, repeat_time: None },
                    )
                    .unwrap()
                    .drives,
            );
            times.push(begin.elapsed().as_nanos());
        }
    }
    times.sort_unstable();
    let at = |part: usize| times[times.len() * part / 10_000] as f64 / 1000.0;
    println!("a tick: median {:.1} us, p99 {:.1} us, p99.9 {:.1} us", at(5000), at(9900), at(9990));
}

/// Milliseconds per measured call.
const STEPS: u32 = 200;

fn lm_arm() -> Robot {
    let text = include_str!("../../../models/lm_arm.toml");
    Robot::new(sinew::description::from_toml("lm_arm.toml", text).unwrap().parts).unwrap()
}

fn lm_machine() -> Machine {
    let text = include_str!("../../../models/lm_arm.toml");
    sinew::description::machine_from_toml("lm_arm.toml", text, &mut |_| Err("no other file".into()))
        .unwrap()
        .machine
}

fn along(robot: &Robot, shape: Loop) -> JointPath {
    let site = robot.site("endpoint").unwrap();
    let machine = lm_machine();
    let path = &machine.paths[usize::from(shape == Loop::Saddle)].path;
    JointPath::resolve(robot, site, path, &machine.redundancy, 720).unwrap()
}

/// Items are steps of a millisecond. Arguments: cells per cable, substeps.
#[divan::bench(args = [(12, 2), (24, 1), (24, 2), (24, 4)])]
fn step(bencher: Bencher, (cells, substeps): (usize, usize)) {
    let robot = lm_arm();
    let pose = robot.key("start").unwrap();
    let mut specimen = ArmSpecimen::draw(&lm_machine(), 1).unwrap();
    specimen.resolution = Resolution { cells, substeps };
    let start = ArmTwin::new(&specimen, pose, &[60.0; 15], 1).unwrap();
    let bencher = bencher.counter(ItemsCount::new(STEPS));
    bencher.with_inputs(|| start.clone()).bench_local_refs(|arm| {
        for k in 0..STEPS {
            let velocity = 0.03 * (0.1 * f64::from(k)).sin();
            let told: [DriveCommand; 15] = core::array::from_fn(|m| {
                DriveCommand::Velocity(if m % 2 == 0 { velocity } else { -velocity })
            });
            arm.step(black_box(&told), 1e-3).unwrap();
        }
    });
}

/// A controller in the middle of a motion, with the inputs of the next milliseconds.
fn controller_in_motion() -> (ArmController, Vec<(ArmReading, Reference, Reference)>) {
    let robot = lm_arm();
    let law = TimeLaw::new(4.0 * std::f64::consts::PI, 11.5).unwrap();
    let trajectory = Trajectory::AlongPath { joints: along(&robot, Loop::Sine), law };
    let mut now = Reference::new(7);
    trajectory.sample(0.0, &mut now).unwrap();
    let machine = lm_machine();
    let specimen = ArmSpecimen::draw(&machine, 1).unwrap();
    let models = oracle_models(&specimen);
    let (gains, _) = synthesize(&machine, &models, &machine.poses(40).unwrap()).unwrap();
    let limits = gains.tension_limits();
    let tensions = resting_tensions(&robot, &now.q, &limits).unwrap();
    let mut arm = ArmTwin::new(&specimen, &now.q, &tensions, 1).unwrap();
    let way = ActuationMode::WinchSpeed(CableStateSource::Observer);
    let mut controller = ArmController::new(&robot, &models, gains, way).unwrap();
    let (mut coming, mut told, mut start) = (now.clone(), Vec::new(), None);
    for k in 0..3000 + STEPS {
        let time = f64::from(k) * 1e-3;
        trajectory.sample(time, &mut now).unwrap();
        trajectory.sample(time + PREVIEW_HORIZON, &mut coming).unwrap();
        if k >= 3000 {
            start.get_or_insert_with(|| controller.clone());
            told.push((arm.reading().clone(), now.clone(), coming.clone()));
        }
        let said = arm.reading();
        let sample = ArmMeasurement { motor: &said.motor, tension: &said.tension, joint: &said.joint };
        let answer = controller
            .step(1e-3, &sample, &PreviewedReference { current: &now, previewed: &coming, repeat_time: None })
            .unwrap();
        arm.step(answer.drives, 1e-3).unwrap();
    }
    assert!(!matches!(controller.status(), ArmStatus::Stopped(_)), "{:?}", controller.status());
    (start.unwrap(), told)
}

/// The whole control cycle, from measurements to commands. Items are cycles.
#[divan::bench]
fn control(bencher: Bencher) {
    let (start, told) = controller_in_motion();
    let bencher = bencher.counter(ItemsCount::new(STEPS));
    bencher.with_inputs(|| start.clone()).bench_local_refs(|controller| {
        for (said, now, coming) in &told {
            let sample = ArmMeasurement { motor: &said.motor, tension: &said.tension, joint: &said.joint };
            let answer = controller
                .step(
                    1e-3,
                    black_box(&sample),
                    &PreviewedReference { current: now, previewed: coming, repeat_time: None },
                )
                .unwrap();
            black_box(answer.drives);
        }
    });
}

#[divan::bench(args = [Loop::Sine, Loop::Saddle], sample_count = 10)]
fn resolve(bencher: Bencher, shape: Loop) {
    let robot = lm_arm();
    bencher.bench_local(|| along(&robot, black_box(shape)));
}

#[divan::bench(sample_size = 1000)]
fn sample(bencher: Bencher) {
    let law = TimeLaw::new(4.0 * std::f64::consts::PI, 115.0).unwrap();
    let trajectory = Trajectory::AlongPath { joints: along(&lm_arm(), Loop::Sine), law };
    let (mut now, mut time) = (Reference::new(7), 0.0);
    bencher.bench_local(|| {
        time += 0.37;
        trajectory.sample(black_box(time % 115.0), &mut now).unwrap();
    });
}
