//! The arm under control: tracking, rest, bounds of commands and tensions, and reactions to faults.

#![allow(clippy::unwrap_used, reason = "a failing test may panic")]

use crate::common;

use common::{gains, lm_arm, lm_machine};
use sinew::body::Robot;
use sinew::control::arm::resting_tensions;
use sinew::control::arm::{
    ActuationMode, ArmController, ArmGains, ArmMeasurement, ArmStatus, CableStateSource, Fault,
    PreviewedReference,
};
use sinew::control::compensation::Compensation;
use sinew::drive::DriveCommand;
use sinew::predictor::CableModel;
use sinew::trajectory::{JointPath, MinimumJerk, Reference, TimeLaw, Trajectory};
use sinew::twin::arm::{ArmSpecimen, ArmTwin, Failure, InjectedFault, Sensor, SensorFailure};
use sinew_lab::experiment::arm::{TrackRun, track};
use sinew_lab::experiment::{TrackRow, TrackSummary};

const H: f64 = 1e-3;

fn trajectory(robot: &Robot, turns: f64, duration: f64) -> Trajectory {
    let site = robot.site("endpoint").unwrap();
    let machine = lm_machine();
    let path = &machine.paths[0].path;
    let joints = JointPath::resolve(robot, site, path, &machine.redundancy, 720).unwrap();
    Trajectory::AlongPath { joints, law: TimeLaw::new(2.0 * std::f64::consts::PI * turns, duration).unwrap() }
}

fn start(robot: &Robot) -> Vec<f64> {
    robot.key("start").unwrap().to_vec()
}

/// Cable models with errors of 2 to 10 % in friction, drag, pretension and compliance; path and weakening are
/// the plant's.
fn estimated(specimen: &ArmSpecimen) -> Vec<CableModel> {
    let model = |(k, cable): (usize, &sinew::twin::cable::Specimen)| {
        let sign = if k % 2 == 0 { 1.0 } else { -1.0 };
        let mut parameters = cable.parameters;
        parameters.friction *= 1.0 + 0.02 * sign;
        parameters.drag *= 1.0 - 0.1 * sign;
        parameters.pretension *= 1.0 + 0.02 * sign;
        parameters.compliance *= 1.1;
        parameters.weakening = cable.effects.slow.map(|slow| slow.weakening);
        CableModel { path: cable.path.clone(), parameters, start: 1.0, ..CableModel::bench() }
    };
    specimen.cables.iter().enumerate().map(model).collect()
}

/// One turn of the circle in `seconds` by an arm of this seed, with these faults.
struct Case<'a> {
    seed: u64,
    way: ActuationMode,
    change: fn(ArmGains) -> ArmGains,
    faults: &'a [InjectedFault],
    seconds: f64,
    after: f64,
}

impl Default for Case<'_> {
    fn default() -> Self {
        Self {
            seed: 1,
            way: ActuationMode::WinchSpeed(CableStateSource::Observer),
            change: |gains| gains,
            faults: &[],
            seconds: 5.75,
            after: 0.0,
        }
    }
}

fn run(case: Case<'_>, see: impl FnMut(&TrackRow<'_>)) -> TrackSummary {
    let robot = lm_arm();
    let specimen = ArmSpecimen::draw(&lm_machine(), case.seed).unwrap();
    let way = trajectory(&robot, 1.0, case.seconds);
    let models = estimated(&specimen);
    let gains = (case.change)(gains(&models));
    let limits = gains.tension_limits();
    let controller = ArmController::new(&robot, &models, gains, case.way).unwrap();
    let run = TrackRun {
        specimen: &specimen,
        robot: &robot,
        site: robot.site("endpoint"),
        tension_limits: &limits,
        standing: None,
        trajectory: &way,
        repeats: 1,
        before: 1.0,
        after: case.after,
        faults: case.faults,
        seed: case.seed,
    };
    track(&run, controller, see).unwrap()
}

#[test]
fn a_specimen_that_differs_from_the_design_tracks_a_circle_within_millimetres() {
    for seed in [1, 2] {
        let (mut inside, mut last) = (true, [0.0; 15]);
        let found = run(Case { seed, ..Case::default() }, |row| {
            for (last, told) in last.iter_mut().zip(row.command.drives) {
                let DriveCommand::Velocity(speed) = *told else { panic!("{told:?}") };
                // A drive accelerates its winch by at most 5 m/s^2.
                assert!((speed - *last).abs() <= 5e-3 + 1e-12, "{last} m/s -> {speed} m/s");
                *last = speed;
            }
            inside &= row.command.desired_tension.iter().all(|f| (16.0..=445.0).contains(f));
        });
        let error = found.end_point_error;
        assert!(error.mean < 4e-3 && error.max < 12e-3, "{error:?}");
        assert!(found.mean_length_error() < 0.1e-3 && inside);
        assert!(found.min_anchor_tension.0 > 10.0 && found.max_drive_tension.0 < 450.0);
        assert!(found.stopped.is_none() && found.plant_failed.is_none());
    }
}

#[test]
fn the_error_by_encoder_zeros_is_proportional_to_them_and_an_open_trajectory_is_not_repeated() {
    let robot = lm_arm();
    let q = start(&robot);
    let mut specimen = ArmSpecimen::draw(&lm_machine(), 1).unwrap();
    let zeros: Vec<f64> = specimen.encoders.iter().flatten().map(|encoder| encoder.zero).collect();
    let mut there = q.clone();
    there[3] += 0.2;
    let away = Trajectory::PointToPoint(MinimumJerk::new(&q, &there, 1.5).unwrap());
    let mut hidden = |fraction: f64, repeats: u32| {
        for (encoder, zero) in specimen.encoders.iter_mut().flatten().zip(&zeros) {
            encoder.zero = fraction * zero;
        }
        let way = ActuationMode::WinchSpeed(CableStateSource::Observer);
        let models = estimated(&specimen);
        let limits = gains(&models).tension_limits();
        let controller = ArmController::new(&robot, &models, gains(&models), way).unwrap();
        let run = TrackRun {
            specimen: &specimen,
            robot: &robot,
            site: robot.site("endpoint"),
            tension_limits: &limits,
            standing: None,
            trajectory: &away,
            repeats,
            before: 0.5,
            after: 2.5,
            faults: &[],
            seed: 1,
        };
        track(&run, controller, |_| {})
            .map(|found| (found.encoder_zero_error.mean, found.hold_encoder_zero_error.mean))
    };
    let (once, twice) = (hidden(1.0, 1).unwrap(), hidden(2.0, 1).unwrap());
    assert_eq!(hidden(0.0, 1).unwrap(), (0.0, 0.0));
    assert!((0.1e-3..3e-3).contains(&once.0), "{once:?}");
    for (one, two) in [(once.0, twice.0), (once.1, twice.1)] {
        assert!((two / one - 2.0).abs() < 0.01, "{one} {two}");
    }
    let refused = hidden(1.0, 2).unwrap_err().to_string();
    assert!(refused.contains("repeats") && refused.contains("does not come back"), "{refused}");
}

#[test]
fn an_arm_at_rest_has_no_limit_cycle() {
    // Of five arms one or two creep, and their elbow breaks away once after seconds; the others rest.
    let mut ripple: Vec<f64> = (1..6)
        .map(|seed| {
            let found = run(Case { seed, after: 20.0, ..Case::default() }, |_| {});
            assert!(found.hold_error.max < 6e-3, "seed {seed}: {:?}", found.hold_error);
            found.max_hold_tension_std()
        })
        .collect();
    ripple.sort_by(f64::total_cmp);
    assert!(ripple[2] < 0.3 && ripple[4] < 1.5, "{ripple:?} N");
}

#[test]
fn with_a_constant_reference_the_controller_adds_no_energy_to_the_arm() {
    let robot = lm_arm();
    let q = start(&robot);
    let desired = Reference { q: q.clone(), ..Reference::new(7) };
    for seed in [1, 2, 3] {
        let specimen = ArmSpecimen::draw(&lm_machine(), seed).unwrap();
        let way = ActuationMode::WinchSpeed(CableStateSource::Observer);
        let models = estimated(&specimen);
        let limits = gains(&models).tension_limits();
        let mut controller = ArmController::new(&robot, &models, gains(&models), way).unwrap();
        let mut away = q.clone();
        away[3] += 0.03;
        away[0] -= 0.02;
        let mut arm =
            ArmTwin::new(&specimen, &away, &resting_tensions(&robot, &q, &limits).unwrap(), seed).unwrap();
        let begin = arm.energy().unwrap();
        let (mut most, mut given, mut late) = (begin, 0.0, 0.0);
        for k in 0..8000 {
            let reading = arm.reading();
            let sample =
                ArmMeasurement { motor: &reading.motor, tension: &reading.tension, joint: &reading.joint };
            let goal = PreviewedReference { current: &desired, previewed: &desired, repeat_time: None };
            let commands = controller.step(H, &sample, &goal).unwrap().drives.to_vec();
            let truth = arm.step(&commands, H).unwrap();
            let pulls = truth.drives.iter().zip(truth.cables);
            let work: f64 = pulls.map(|(drive, cable)| drive.moved * cable.tension_in).sum();
            given += work;
            late += if k >= 5000 { work } else { 0.0 };
            most = most.max(arm.energy().unwrap());
        }
        let error = arm.truth().q.iter().zip(&q).fold(0.0_f64, |worst, (a, b)| worst.max((a - b).abs()));
        let told = format!("seed {seed}: {begin} J, at most {most}, given {given}, late {late}, {error} rad");
        assert!(most < begin + 1.0 && given < 2.0, "{told}");
        // Noise and quantisation cause about 50 mW.
        assert!(late < 0.5, "{told}");
        assert!(arm.truth().v.iter().all(|v| v.abs() < 0.05) && error < 6e-3, "{told}");
    }
}

#[test]
fn uncompensated_drive_tensions_end_in_a_reported_tracking_error() {
    let way = ActuationMode::DriveTension(vec![Compensation::None; 15]);
    let found = run(Case { way, ..Case::default() }, |_| {});
    assert!(matches!(found.stopped, Some((_, Fault::TrackingError(_)))), "{:?}", found.stopped);
    assert!(found.end_point_error.mean > 20e-3);
}

#[test]
fn winches_track_without_tension_estimates_and_better_with_them() {
    let observed = run(Case::default(), |_| {}).end_point_error.mean;
    let blind = run(
        Case {
            way: ActuationMode::WinchSpeed(CableStateSource::Encoders),
            change: ArmGains::without_tension_estimates,
            ..Case::default()
        },
        |_| {},
    );
    assert!(blind.stopped.is_none() && blind.end_point_error.mean < 30e-3);
    assert!(observed < blind.end_point_error.mean, "{observed} {:?}", blind.end_point_error);
}

#[test]
fn the_same_seed_gives_the_same_bits() {
    let bits = || {
        let mut bits = Vec::new();
        run(Case { seconds: 2.9, ..Case::default() }, |row| {
            bits.extend(row.truth.q.iter().chain(row.command.desired_tension).map(|x| x.to_bits()));
        });
        bits
    };
    assert!(bits() == bits());
}

fn fault(duration: f64, failure: Failure) -> [InjectedFault; 1] {
    [InjectedFault { start: 2.5, duration, failure }]
}

#[test]
fn a_sensor_lost_for_milliseconds_degrades_the_controller_without_stopping_it() {
    use SensorFailure::{Lost, NotANumber};
    for (lasting, sensor, how, named) in [
        (0.001, Sensor::Joint(3), NotANumber, Fault::JointSensor(3)),
        (0.010, Sensor::Joint(3), Lost, Fault::JointSensor(3)),
        (0.010, Sensor::Motor(7), NotANumber, Fault::MotorSensor(7)),
        (0.100, Sensor::Tension(7), Lost, Fault::TensionSensor(7)),
        (0.100, Sensor::Tension(8), NotANumber, Fault::TensionSensor(8)),
    ] {
        let faults = fault(lasting, Failure::Sensor(sensor, how));
        let found = run(Case { faults: &faults, ..Case::default() }, |_| {});
        assert_eq!(found.degraded.1, Some(named));
        // The return of a joint encoder takes four samples.
        assert!(found.degraded.0 as f64 <= 1e3 * lasting + 5.0 && found.stopped.is_none(), "{found:?}");
        assert!(found.end_point_error.max < 12e-3, "{:?}", found.end_point_error);
    }
}

#[test]
fn a_permanent_fault_is_identified_and_stops_the_arm_without_a_jump() {
    use SensorFailure::NotANumber;
    for (what, named) in [
        (Failure::Sensor(Sensor::Joint(3), NotANumber), Fault::JointSensor(3)),
        (Failure::Sensor(Sensor::Motor(7), NotANumber), Fault::MotorSensor(7)),
        (Failure::Amplifier(7), Fault::Drive(7)),
        (Failure::Winch(7), Fault::Drive(7)),
        (Failure::Cable(7), Fault::Cable(7)),
    ] {
        let faults = fault(f64::INFINITY, what);
        let (mut last, mut jump, mut rows) = ([0.0_f64; 15], 0.0_f64, 0);
        let (mut stopped_at, mut standing) = (None, 0.0_f64);
        let found = run(Case { faults: &faults, ..Case::default() }, |row| {
            rows += 1;
            let stopped = matches!(row.command.status, ArmStatus::Stopped(_));
            if stopped {
                stopped_at = stopped_at.or(Some(row.time));
            }
            for (last, command) in last.iter_mut().zip(row.command.drives) {
                // A drive that cannot be trusted is braked.
                let DriveCommand::Velocity(speed) = *command else {
                    assert!(stopped && *command == DriveCommand::Brake, "{command:?}");
                    *last = 0.0;
                    continue;
                };
                if stopped {
                    jump = jump.max((speed - *last).abs());
                }
                if stopped_at.is_some_and(|at| (at + 0.5..at + 0.99).contains(&row.time)) {
                    standing = standing.max(speed.abs());
                }
                *last = speed;
            }
        });
        let (when, fault) = found.stopped.unwrap();
        assert_eq!(fault, named);
        assert!((2.5..3.5).contains(&when), "{named:?} {when}");
        // The winches stand for a second; then cables are paid out, and none is taken up.
        assert!(jump < 0.01 && standing < 1e-9, "{named:?} {jump} {standing}");
        assert!(last.iter().all(|speed| *speed <= 0.0), "{named:?} {last:?}");
        assert_eq!(rows, 6750, "recorded to the end");
        assert!(found.max_drive_tension.0 < 600.0);
    }
}

#[test]
fn a_controller_of_inconsistent_parts_is_refused() {
    let robot = lm_arm();
    let specimen = ArmSpecimen::nominal(&lm_machine()).unwrap();
    let models = estimated(&specimen);
    let way = || ActuationMode::WinchSpeed(CableStateSource::Observer);
    let gains = gains(&models);
    assert!(ArmController::new(&robot, &models, gains.clone(), way()).is_ok());
    assert!(ArmController::new(&robot, &models[..14], gains.clone(), way()).is_err());
    assert!(ArmController::new(&robot, &models, gains.clone(), ActuationMode::DriveTension(vec![])).is_err());
    for change in [
        |g: &mut ArmGains| g.muscles[3].stretch_time_constant = 0.0,
        |g: &mut ArmGains| g.joints[2].bandwidth = f64::NAN,
        |g: &mut ArmGains| g.joints.truncate(3),
        |g: &mut ArmGains| g.muscles[0].rest_tolerance = [1.0, 0.5],
        |g: &mut ArmGains| g.feedback_fraction = 1.5,
    ] {
        let mut bad = gains.clone();
        change(&mut bad);
        assert!(ArmController::new(&robot, &models, bad, way()).is_err());
    }
}

#[test]
fn for_any_measurements_commands_stay_finite_and_within_the_limits_of_a_winch() {
    let robot = lm_arm();
    let specimen = ArmSpecimen::nominal(&lm_machine()).unwrap();
    let mut random = sinew::random::Random::new(3);
    let models = estimated(&specimen);
    let limited = gains(&models);
    for seed in 0..20 {
        let mut controller = ArmController::new(
            &robot,
            &models,
            limited.clone(),
            ActuationMode::WinchSpeed(CableStateSource::Observer),
        )
        .unwrap();
        let goal = Reference { q: start(&robot), ..Reference::new(7) };
        let mut wild = |usual: f64| match random.bits() % (4 + seed) {
            0 => f64::NAN,
            1 => f64::INFINITY,
            2 => -1e300,
            _ => usual + random.normal(),
        };
        for _ in 0..200 {
            let motor: Vec<f64> = (0..15).map(|_| wild(0.5)).collect();
            let tension: Vec<f64> = (0..15).map(|_| wild(60.0)).collect();
            let joint: Vec<f64> = (0..7).map(|_| wild(0.3)).collect();
            let sample = ArmMeasurement { motor: &motor, tension: &tension, joint: &joint };
            let goal = PreviewedReference { current: &goal, previewed: &goal, repeat_time: None };
            let answer = controller.step(H, &sample, &goal).unwrap();
            for (command, gains) in answer.drives.iter().zip(&limited.muscles) {
                let most = gains.max_winch_speed;
                assert!(matches!(command, DriveCommand::Velocity(v) if v.abs() <= most), "{command:?}");
            }
        }
    }
}

#[test]
fn for_any_reference_commands_stay_within_the_limits_of_a_winch_or_the_reference_is_refused() {
    let robot = lm_arm();
    let models = estimated(&ArmSpecimen::nominal(&lm_machine()).unwrap());
    let limited = gains(&models);
    let way = || ActuationMode::WinchSpeed(CableStateSource::Observer);
    let fresh = || ArmController::new(&robot, &models, limited.clone(), way()).unwrap();
    let rest = Reference { q: start(&robot), ..Reference::new(7) };
    let joint = rest.q.clone();
    let sample = ArmMeasurement { motor: &[0.5; 15], tension: &[60.0; 15], joint: &joint };
    for value in [f64::NAN, f64::INFINITY, f64::NEG_INFINITY, 1e300, -1e200, 1e30, -1e9, 1e3] {
        for place in 0..6 {
            let mut controller = fresh();
            let mut goals = [rest.clone(), rest.clone()];
            let Reference { q, v, a } = &mut goals[place / 3];
            [q, v, a][place % 3][3] = value;
            let goal = PreviewedReference { current: &goals[0], previewed: &goals[1], repeat_time: None };
            for _ in 0..50 {
                match controller.step(H, &sample, &goal) {
                    Ok(answer) => {
                        assert!(value.is_finite(), "{value} at {place} is taken");
                        for (command, gains) in answer.drives.iter().zip(&limited.muscles) {
                            let most = gains.max_winch_speed;
                            assert!(
                                matches!(command, DriveCommand::Velocity(v) if v.abs() <= most),
                                "{command:?}"
                            );
                        }
                    }
                    Err(error) => {
                        let named = error.to_string();
                        assert!(value.is_finite() || named.contains("must be finite"), "{named}");
                    }
                }
            }
        }
    }
}
