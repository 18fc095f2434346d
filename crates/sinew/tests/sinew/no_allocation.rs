//! A control tick never allocates: an allocator that counts watches a predictor at work.

use crate::common;
use sinew::predictor::{Model, Predictor, Sample};
use sinew::transmission::cable::{
    Cable, CableBatch, CableLaw, CableParameters, CablePath, EndMotion, EndTensions,
};

/// Allocations during `work`, and what it releases of those before.
fn calls(work: impl FnOnce()) -> u64 {
    let counted = allocation_counter::measure(work);
    counted.count_total + counted.count_current.unsigned_abs()
}

/// Steady motion with everything a bench has seen: spikes, steps, losses, gaps, repeated rows, time running
/// back.
fn work_through(predictor: &mut Predictor, width: usize) -> f64 {
    let mut sum = 0.0;
    let mut inputs = [0.0; 3];
    for k in 0..2000_u32 {
        let t = f64::from(k) * 1e-3;
        inputs[0] = 60.0 + 40.0 * (9.0 * t).sin();
        inputs[1] = 60.0 - 40.0 * (9.0 * t).sin();
        inputs[2] = 0.02 * (9.0 * t).cos();
        let (mut time_s, mut given) = (t, width);
        match k % 100 {
            10 => inputs[0] = 1e5,
            20..=25 => inputs[0] = 500.0,
            30 => inputs[0] = f64::NAN,
            40 => inputs.fill(f64::INFINITY),
            50 => time_s = t - 1e-3,
            60 => time_s = f64::NAN,
            70 => time_s = t - 1.0,
            80 => time_s = t + 1e9,
            90 => predictor.reset(),
            95 => given = 0,
            _ => {}
        }
        sum += predictor.step(&Sample { time_s, inputs: &inputs[..given] }).mean;
    }
    sum
}

fn never_allocates(model: Model) {
    let width = model.inputs.len();
    let mut predictor = Predictor::new(model).unwrap();
    let mut sum = 0.0;
    assert_eq!(calls(|| sum = work_through(&mut predictor, width)), 0);
    assert!(sum.is_finite() && sum > 0.0, "the predictor was at work: {sum}");
}

#[test]
fn the_counter_sees_an_allocation_and_a_release() {
    assert_eq!(calls(|| drop(std::hint::black_box(vec![1_u8; 100]))), 1);
    let held = std::hint::black_box(vec![1_u8; 100]);
    assert_eq!(calls(|| drop(held)), 1);
}

#[test]
fn a_step_of_the_cell_alone_never_allocates() {
    never_allocates(common::capstan());
}

#[test]
fn a_step_with_an_ensemble_never_allocates() {
    never_allocates(common::complete());
}

#[test]
fn a_command_of_the_inverse_never_allocates_whatever_the_model() {
    use sinew::compensator::{Compensator, CompensatorSettings};
    for seed in 0..64 {
        let model = common::random_models::model(seed);
        let width = model.inputs.len();
        let mut compensator = Compensator::new(model, &CompensatorSettings::default()).unwrap();
        let mut sum = 0.0;
        let counted = calls(|| {
            for k in 0..120_u32 {
                let t = f64::from(k) * 5e-3;
                let desired = if k % 40 == 9 { f64::NAN } else { 40.0 + 20.0 * (3.0 * t).sin() };
                let inputs = if k % 30 == 7 { [60.0, 0.0, 0.0] } else { [f64::NAN, f64::NAN, 0.0] };
                let time_s = if k > 80 { t + 2.0 } else { t };
                let sample = Sample { time_s, inputs: &inputs[..width] };
                sum += compensator.command(&sample, desired).value;
                sum += compensator.step(&sample, desired).value;
                if k % 50 == 49 {
                    compensator.reset();
                }
            }
        });
        assert_eq!(counted, 0, "{seed}");
        assert!(sum.is_finite());
    }
}

#[test]
fn a_step_of_cables_never_allocates_in_whatever_state_they_are() {
    let law = CableLaw::new(&CablePath::bench(), &CableParameters::bench(), 12).unwrap();
    let mut cables = CableBatch::new(&vec![law.clone(); 15]).unwrap();
    let mut alone = Cable::new(law);
    let mut ends = [EndTensions::default(); 15];
    let mut sum = 0.0;
    let counted = calls(|| {
        for k in 0..3000_u32 {
            // Pulls, yields into slack, jumps that need repair, and a step that is refused.
            let t = f64::from(k) * 1e-3;
            let jump = if k % 500 == 7 { 0.03 } else { 0.0 };
            let motor = if k % 700 == 9 { f64::NAN } else { 4e-5 * (4.0 * t).cos() + jump * (9.0 * t).cos() };
            let motions = [EndMotion { motor, anchor: 1e-5 }; 15];
            let refused = cables.step(1e-3, &motions, &mut ends).is_err();
            assert_eq!(refused, alone.step(1e-3, motions[0]).is_err());
            cables.set_wrap(k as usize % 15, 0, 1.5 + 0.1 * t.sin()).unwrap();
            sum += ends[3].tension_in;
        }
    });
    assert_eq!(counted, 0);
    assert!(sum > 100.0, "{sum}");
}

#[test]
fn mechanics_and_muscles_never_allocate_once_built() {
    #[derive(serde::Deserialize)]
    struct Golden {
        parts: sinew::body::Parts,
    }
    let file = std::path::Path::new(env!("CARGO_MANIFEST_DIR")).join("tests/golden/finger.json");
    let golden: Golden = serde_json::from_slice(&std::fs::read(file).unwrap()).unwrap();
    let robot = sinew::body::Robot::new(golden.parts).unwrap();
    let muscles = sinew::muscle::Muscles::new(&robot);
    let mut poses = sinew::body::Poses::new(&robot);
    let mut scratch = sinew::body::Scratch::new(&robot);
    let mut reduction = sinew::body::Reduction::new(&robot);
    let mut geometry = sinew::muscle::Geometry::new(&robot, &muscles);
    let (nv, count, n) = (robot.nv(), muscles.count(), reduction.independent().len());
    let (mut q, v) = (robot.reference_pose(), vec![0.3; nv]);
    let (mut tau, mut a, mut mass) = (vec![0.0; nv], vec![0.0; nv], vec![0.0; nv * nv]);
    let (mut dense, mut of_each, mut du) = (vec![0.0; count * nv], vec![0.0; count], vec![0.0; n]);
    let (u, mut linear, mut angular) = (vec![0.2; n], vec![0.0; 3 * nv], vec![0.0; 3 * nv]);
    let mut work = || -> Result<(), sinew::Error> {
        for _ in 0..100 {
            robot.integrate(&mut q, &v, 1e-3)?;
            robot.apply_couplings(&mut q)?;
            robot.forward_kinematics(&q, &mut poses)?;
            robot.jacobian(&poses, 1, [0.1; 3], &mut linear, &mut angular)?;
            robot.gravity_force(&q, &mut scratch, &mut tau)?;
            robot.inverse_dynamics(&q, &v, &a, &mut scratch, &mut tau)?;
            robot.mass_matrix(&q, &mut scratch, &mut mass)?;
            robot.forward_dynamics(&q, &v, &tau, &mut scratch, &mut a)?;
            reduction.forward_dynamics(&robot, &q, &u, &tau, &mut scratch, &mut du)?;
            muscles.evaluate(&q, &mut geometry)?;
            muscles.dense(&geometry, &mut dense)?;
            muscles.velocities(&geometry, &v, &mut of_each)?;
            muscles.bends(&geometry, &mut of_each)?;
            muscles.torque(&geometry, &of_each, &mut tau)?;
        }
        Ok(())
    };
    assert_eq!(calls(|| work().unwrap()), 0);
}

#[test]
fn the_arm_and_its_trajectory_never_allocate_not_even_in_failing() {
    use sinew::drive::DriveCommand;
    use sinew::trajectory::{JointPath, Loop, Reference, TimeLaw, Trajectory};
    use sinew::twin::arm::{ArmSpecimen, ArmTwin, Failure, InjectedFault, Sensor, SensorFailure};
    let robot = common::lm_arm();
    let pose = robot.key("start").unwrap();
    let joints = JointPath::resolve(
        &robot,
        robot.site("endpoint").unwrap(),
        &common::lm_path(Loop::Sine),
        &common::lm_machine().redundancy,
        720,
    )
    .unwrap();
    let trajectory = Trajectory::AlongPath { joints, law: TimeLaw::new(12.0, 2.0).unwrap() };
    let specimen = ArmSpecimen::draw(&common::lm_machine(), 1).unwrap();
    let fault = |from, what| InjectedFault { start: from, duration: 0.1, failure: what };
    let faults = [
        fault(0.2, Failure::Cable(4)),
        fault(0.3, Failure::Amplifier(5)),
        fault(0.4, Failure::Winch(6)),
        fault(0.5, Failure::Sensor(Sensor::Joint(1), SensorFailure::NotANumber)),
    ];
    let mut arm = ArmTwin::new(&specimen, pose, &[60.0; 15], 1).unwrap().with_faults(&faults).unwrap();
    let (mut now, mut moved) = (Reference::new(7), 0.0);
    let mut work = || {
        for k in 0..1000_u32 {
            let time = f64::from(k) * 1e-3;
            trajectory.sample(time, &mut now).unwrap();
            let velocity = 0.02 * (9.0 * time).sin() + 1e-3 * now.v[0];
            let truth = arm.step(&[DriveCommand::Velocity(velocity); 15], 1e-3).unwrap();
            moved += truth.v[3].abs() * 1e-3;
        }
    };
    assert_eq!(calls(&mut work), 0);
    assert!(moved > 0.01, "{moved}");
    let mut arms = vec![arm; 3];
    let mut group: Vec<&mut ArmTwin> = arms.iter_mut().collect();
    let mut twins = sinew::twin::arm::ArmTwins::new(group[0]);
    let commands = [DriveCommand::Velocity(0.01); 15];
    let mut together = || {
        let mut together = twins.gather(&mut group).unwrap();
        (0..100).for_each(|_| together.step(&[&commands[..]; 3], 1e-3).into_iter().for_each(Result::unwrap));
    };
    assert_eq!(calls(&mut together), 0);
}

#[test]
fn distributing_a_torque_never_allocates_whether_it_can_be_reached_or_not() {
    let mut random = sinew::random::Random::new(1);
    let mut distribution = sinew::control::tension::Distribution::new(15, 7);
    let (mut arms, mut torque) = ([0.0; 15 * 7], [0.0; 7]);
    let (mut iterations, mut infeasible) = (0, 0);
    let counted = calls(|| {
        for k in 0..300_u32 {
            // Other joints every time, at first reachable, then not.
            arms.iter_mut()
                .for_each(|arm| *arm = if random.unit() < 0.5 { 0.0 } else { 0.03 * random.normal() });
            torque.iter_mut().for_each(|torque| *torque = f64::from(k) * 0.01 * random.normal());
            let problem = sinew::control::tension::Problem {
                moment_arms: &arms,
                torque: &torque,
                minimum: &[20.0; 15],
                maximum: &[400.0; 15],
                reference: &[0.0; 15],
                weight: &[1.0; 15],
            };
            let Ok(solution) = distribution.solve(&problem) else { return };
            iterations += solution.iterations;
            infeasible += u32::from(solution.status == sinew::control::tension::Status::Infeasible);
        }
    });
    assert_eq!(counted, 0);
    assert!(iterations > 900 && (30..=270).contains(&infeasible), "{iterations} {infeasible}");
}

#[test]
fn the_arms_controller_never_allocates_whatever_its_sensors_say() {
    use sinew::control::arm::{
        ActuationMode, ArmController, ArmMeasurement, CableStateSource, PreviewedReference, synthesize,
    };
    use sinew::predictor::CableModel;
    use sinew::trajectory::Reference;
    use sinew::twin::arm::{ArmSpecimen, ArmTwin};
    let robot = common::lm_arm();
    let pose = robot.key("start").unwrap();
    let mut machine = common::lm_machine();
    machine.muscles[4].bend_by_joint = vec![0.3; 7];
    let specimen = ArmSpecimen::nominal(&machine).unwrap();
    let model = |cable: &sinew::twin::cable::Specimen| CableModel {
        path: cable.path.clone(),
        parameters: cable.parameters,
        learning: 3.0,
        ..CableModel::bench()
    };
    let models: Vec<CableModel> = specimen.cables.iter().map(model).collect();
    let way = ActuationMode::WinchSpeed(CableStateSource::Observer);
    let (gains, _) = synthesize(&machine, &models, &machine.poses(40).unwrap()).unwrap();
    let mut controller = ArmController::new(&robot, &models, gains, way)
        .and_then(|controller| controller.with_sheath_bends(&machine.sheath_bends()?))
        .unwrap();
    let mut arm = ArmTwin::new(&specimen, pose, &[60.0; 15], 1).unwrap();
    let (mut goal, mut moved) = (Reference::new(7), 0.0);
    goal.q.copy_from_slice(pose);
    let mut work = || {
        for k in 0..600_u32 {
            goal.v[3] = 0.3 * (0.02 * f64::from(k)).sin();
            goal.q[3] += 1e-3 * goal.v[3];
            let lost = [f64::NAN; 15];
            let said = arm.reading();
            let tension = if k == 300 { &lost[..] } else { &said.tension };
            let sample = ArmMeasurement { motor: &said.motor, tension, joint: &said.joint };
            let answer = controller
                .step(
                    1e-3,
                    &sample,
                    &PreviewedReference { current: &goal, previewed: &goal, repeat_time: None },
                )
                .unwrap();
            moved += arm.step(answer.drives, 1e-3).unwrap().v[3].abs() * 1e-3;
        }
    };
    assert_eq!(calls(&mut work), 0);
    assert!(moved > 0.01, "{moved}");
}
