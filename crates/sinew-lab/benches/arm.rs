//! Cost of a millisecond of the arm's twin: 15 muscles, 7 joints, all effects; of its controller and of those
//! of other machines; and of a sample of its trajectory.
//!
//! `SINEW_MYOARM` may name the file of the MyoSuite arm (`myoarm.xml`), whose controller is then measured,
//! too.

#![allow(clippy::unwrap_used, reason = "a bench that cannot start may panic")]
#![allow(clippy::print_stdout, reason = "a bench prints")]

use divan::{Bencher, black_box, counter::ItemsCount};
use sinew::body::Robot;
use sinew::control::arm::resting_tensions;
use sinew::control::arm::{
    ActuationMode, ArmController, ArmMeasurement, ArmStatus, CableStateSource, PreviewedReference, synthesize,
};
use sinew::control::stretch::PREVIEW_HORIZON;
use sinew::drive::DriveCommand;
use sinew::machine::Machine;
use sinew::trajectory::{JointPath, Loop, Reference, TimeLaw, Trajectory};
use sinew::twin::arm::{ArmReading, ArmSpecimen, ArmTwin};
use sinew::twin::cable::Resolution;
use sinew_lab::arm::plan_tour;
use sinew_lab::experiment::oracle_models;
use std::time::Instant;

fn main() {
    divan::main();
    tail();
}

/// Distribution of the time of single control cycles of every machine, the clock's overhead included.
fn tail() {
    println!("a control cycle, us  muscles  joints  median   p99  p99.9");
    for name in machine_names() {
        let (start, told) = controller_in_motion(name);
        let mut times: Vec<u128> = Vec::new();
        for _ in 0..200 {
            let mut controller = start.clone();
            for moment in &told {
                let begin = Instant::now();
                black_box(moment.control(&mut controller));
                times.push(begin.elapsed().as_nanos());
            }
        }
        times.sort_unstable();
        let at = |part: usize| times[times.len() * part / 10_000] as f64 / 1000.0;
        let (muscles, joints) = (told[0].reading.motor.len(), told[0].now.q.len());
        let (median, p99, p999) = (at(5000), at(9900), at(9990));
        println!("{name:<19}  {muscles:>7}  {joints:>6}  {median:>6.1}  {p99:>4.1}  {p999:>5.1}");
    }
}

/// Milliseconds per measured call.
const STEPS: u32 = 200;

fn lm_arm() -> Robot {
    let text = sinew_models::LM_ARM;
    Robot::new(sinew::description::from_toml("lm_arm.toml", text).unwrap().parts).unwrap()
}

fn along(robot: &Robot, shape: Loop) -> JointPath {
    let machine = machine("lm_arm");
    let site = robot.site("endpoint").unwrap();
    let path = &machine.paths[usize::from(shape == Loop::Saddle)].path;
    JointPath::resolve(robot, site, path, &machine.redundancy, 720).unwrap()
}

/// Items are steps of a millisecond. Arguments: cells per cable, substeps.
#[divan::bench(args = [(12, 2), (24, 1), (24, 2), (24, 4)])]
fn step(bencher: Bencher, (cells, substeps): (usize, usize)) {
    let robot = lm_arm();
    let pose = robot.key("start").unwrap();
    let mut specimen = ArmSpecimen::draw(&machine("lm_arm"), 1).unwrap();
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

/// Machines whose files are at hand.
fn machine_names() -> impl Iterator<Item = &'static str> {
    let myoarm = std::env::var_os("SINEW_MYOARM").map(|_| MYOARM);
    ["bench_joint", "finger", "shoulder", "lm_arm", "chain10"].into_iter().chain(myoarm)
}

const MYOARM: &str = "myoarm";

/// A machine; the MyoSuite arm without gravity, which default drives do not hold.
fn machine(name: &str) -> Machine {
    if name == MYOARM {
        let path = std::env::var_os("SINEW_MYOARM").unwrap();
        let text = std::fs::read_to_string(path).unwrap();
        let mut parts =
            sinew::description::from_mjcf("myoarm.xml", &text, &mut |_| Err("no other file".into()))
                .unwrap()
                .parts;
        parts.gravity = [0.0; 3];
        return Machine::from_robot(&Robot::new(parts).unwrap()).unwrap();
    }
    let path = concat!(env!("CARGO_MANIFEST_DIR"), "/../../models/");
    let text = std::fs::read_to_string(format!("{path}{name}.toml")).unwrap();
    sinew::description::machine_from_toml(name, &text, &mut |_| Err("no other file".into())).unwrap().machine
}

/// Inputs of a control cycle.
struct Moment {
    reading: ArmReading,
    now: Reference,
    coming: Reference,
}

impl Moment {
    fn control(&self, controller: &mut ArmController) -> DriveCommand {
        let Self { reading, now, coming } = self;
        let sample =
            ArmMeasurement { motor: &reading.motor, tension: &reading.tension, joint: &reading.joint };
        let reference = PreviewedReference { current: now, previewed: coming, repeat_time: None };
        controller.step(1e-3, black_box(&sample), &reference).unwrap().drives[0]
    }
}

/// A controller in the middle of a motion, with the inputs of the next milliseconds: the arm's fast sine, a
/// tour of other machines.
fn controller_in_motion(name: &str) -> (ArmController, Vec<Moment>) {
    let machine = machine(name);
    let trajectory = if name == "lm_arm" {
        let law = TimeLaw::new(4.0 * std::f64::consts::PI, 11.5).unwrap();
        Trajectory::AlongPath { joints: along(&machine.robot, Loop::Sine), law }
    } else {
        plan_tour(&machine, Some(20.0), |_| Ok(None)).unwrap()
    };
    let mut now = Reference::new(trajectory.joints());
    trajectory.sample(0.0, &mut now).unwrap();
    let specimen = ArmSpecimen::draw(&machine, 1).unwrap();
    let models = oracle_models(&specimen);
    let (mut gains, _) = synthesize(&machine, &models, &machine.poses(40).unwrap()).unwrap();
    let mut before = 3000;
    if name == MYOARM {
        // Default drives do not hold its fingers: a fifth of a second from the start, whatever the error.
        before = 0;
        gains.joints.iter_mut().for_each(|joint| joint.tracking_error = 100.0);
    }
    let limits = gains.tension_limits();
    let tensions = resting_tensions(&machine.robot, &now.q, &limits).unwrap();
    let mut arm = ArmTwin::new(&specimen, &now.q, &tensions, 1).unwrap();
    let way = ActuationMode::WinchSpeed(CableStateSource::Observer);
    let mut controller = ArmController::new(&machine.robot, &models, gains, way).unwrap();
    let (mut coming, mut told, mut start) = (now.clone(), Vec::new(), None);
    for k in 0..before + STEPS {
        let time = f64::from(k) * 1e-3;
        trajectory.sample(time, &mut now).unwrap();
        trajectory.sample(time + PREVIEW_HORIZON, &mut coming).unwrap();
        if k >= before {
            start.get_or_insert_with(|| controller.clone());
            let reading = arm.reading().clone();
            told.push(Moment { reading, now: now.clone(), coming: coming.clone() });
        }
        let said = arm.reading();
        let sample = ArmMeasurement { motor: &said.motor, tension: &said.tension, joint: &said.joint };
        let answer = controller
            .step(1e-3, &sample, &PreviewedReference { current: &now, previewed: &coming, repeat_time: None })
            .unwrap();
        arm.step(answer.drives, 1e-3).unwrap();
    }
    assert!(!matches!(controller.status(), ArmStatus::Stopped(_)), "{name}: {:?}", controller.status());
    (start.unwrap(), told)
}

/// The whole control cycle, from measurements to commands. Items are cycles.
#[divan::bench(args = machine_names())]
fn control(bencher: Bencher, name: &str) {
    let (start, told) = controller_in_motion(name);
    let bencher = bencher.counter(ItemsCount::new(STEPS));
    bencher.with_inputs(|| start.clone()).bench_local_refs(|controller| {
        for moment in &told {
            black_box(moment.control(controller));
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
