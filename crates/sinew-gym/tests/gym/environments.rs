//! Environments of every machine of this repository: what they tell, what ends them, and that nothing but
//! seed and actions decides what they do.

use sinew::Error;
use sinew::drive::DriveFault;
use sinew::machine::Machine;
use sinew::random::Random;
use sinew::trajectory::{JointWaypoint, through_joint_waypoints};
use sinew::twin::cable::Resolution;
use sinew_gym::{
    Actuation, Environment, EnvironmentBatch, EnvironmentDesign, Outcomes, Randomisation, ResetMode,
    Settings, Task,
};
use sinew_models::MACHINES;
use std::sync::Arc;

fn machine(name: &str) -> Machine {
    let (_, text) = MACHINES.into_iter().find(|(built_in, _)| *built_in == name).unwrap();
    sinew::description::machine_from_toml(name, text, &mut |_| Err("no other file".into())).unwrap().machine
}

/// Names of all files of machines.
fn machines() -> Vec<String> {
    MACHINES.map(|(name, _)| name.to_owned()).to_vec()
}

fn design(machine: &Machine, task: Task, mut settings: Settings) -> Arc<EnvironmentDesign> {
    // An action lasts a whole number of the machine's periods.
    settings.interval_ms = settings.interval_ms.next_multiple_of((1e3 * machine.period).ceil() as u32);
    Arc::new(EnvironmentDesign::new(machine, task, settings, Randomisation::default()).unwrap())
}

fn short() -> Settings {
    Settings { interval_ms: 5, steps: 7, ..Settings::default() }
}

/// A motion from the start over the middle of the ranges and back.
fn there_and_back(machine: &Machine) -> Task {
    let way = machine.start.iter().zip(machine.ranges().unwrap());
    let middle: Vec<f64> = way.map(|(start, [low, high])| 0.9 * start + 0.05 * (low + high)).collect();
    let poses = [machine.start.clone(), middle, machine.start.clone()];
    let point = |(k, q): (usize, Vec<f64>)| JointWaypoint { time: 1.5 * k as f64, q };
    let points: Vec<JointWaypoint> = poses.into_iter().enumerate().map(point).collect();
    Task::Track(Arc::new(through_joint_waypoints(&points).unwrap()))
}

/// What many steps write, as bits.
#[derive(Debug, PartialEq)]
struct Run {
    observations: Vec<u32>,
    rewards: Vec<u64>,
    ends: Vec<bool>,
}

/// Environments with these seeds under actions that depend on the seed alone.
fn run(design: &Arc<EnvironmentDesign>, seeds: &[u64], threads: usize, steps: usize) -> Vec<Run> {
    let mut batch = EnvironmentBatch::new(design, seeds, ResetMode::SameStep, threads).unwrap();
    let (n, width, acts) = (seeds.len(), design.observations(), design.actions());
    let mut random: Vec<Random> = seeds.iter().map(|seed| Random::new(!seed)).collect();
    let (mut observations, mut last) = (vec![0.0; n * width], vec![0.0; n * width]);
    let (mut rewards, mut errors, mut last_errors) = (vec![0.0; n], vec![0.0; n], vec![0.0; n]);
    let (mut terminated, mut truncated) = (vec![false; n], vec![false; n]);
    batch.reset(None, None, &mut observations, &mut errors).unwrap();
    let mut runs: Vec<Run> =
        (0..n).map(|_| Run { observations: vec![], rewards: vec![], ends: vec![] }).collect();
    for _ in 0..steps {
        let actions: Vec<f32> = random
            .iter_mut()
            .flat_map(|r| (0..acts).map(|_| (0.4 * r.unit() - 0.2) as f32).collect::<Vec<_>>())
            .collect();
        let mut out = Outcomes {
            observations: &mut observations,
            rewards: &mut rewards,
            terminated: &mut terminated,
            truncated: &mut truncated,
            errors: &mut errors,
            last_observations: &mut last,
            last_errors: &mut last_errors,
        };
        batch.step(&actions, &mut out).unwrap();
        for (k, run) in runs.iter_mut().enumerate() {
            run.observations.extend(observations[k * width..(k + 1) * width].iter().map(|x| x.to_bits()));
            run.rewards.extend([rewards[k].to_bits(), errors[k].to_bits()]);
            run.ends.extend([terminated[k], truncated[k]]);
        }
    }
    runs
}

#[test]
fn every_machine_runs_every_task_with_every_command_within_its_bounds() {
    for name in machines() {
        let machine = machine(&name);
        let tasks = [Task::Reach, Task::Hold { push: 0.1 }, there_and_back(&machine)];
        for (task, actuation) in
            tasks.into_iter().zip([Actuation::Speed, Actuation::Tension, Actuation::Torque])
        {
            let design = design(&machine, task, Settings { actuation, ..short() });
            let mut environment = Environment::new(design.clone(), 3).unwrap();
            let mut told = vec![f32::NAN; design.observations()];
            for k in 0..30 {
                if environment.ended() {
                    environment.reset(None).unwrap();
                }
                let action = vec![if k % 2 == 0 { 0.3 } else { -5.0 }; design.actions()];
                let outcome = environment.step(&action).unwrap();
                assert!(
                    (-0.01..=1.0).contains(&outcome.reward) && outcome.error >= 0.0,
                    "{name}: {outcome:?}"
                );
                environment.observe(&mut told);
                let within = |(x, [low, high]): (&f32, &[f32; 2])| (*low..=*high).contains(x);
                assert!(told.iter().zip(design.observation_bounds()).all(within), "{name}: {told:?}");
            }
        }
    }
}

#[test]
fn threads_and_the_number_of_environments_change_no_bit() {
    let arm = machine("lm_arm");
    let design = design(&arm, Task::Hold { push: 0.2 }, short());
    let seeds: Vec<u64> = (10..21).collect();
    let all = run(&design, &seeds, 1, 20);
    assert_eq!(all, run(&design, &seeds, 2, 20));
    assert_eq!(all, run(&design, &seeds, 5, 20));
    assert_eq!(all[4..5], run(&design, &seeds[4..5], 1, 20)[..]);
    // Episodes ended meanwhile; other seeds do something else.
    assert!(
        all[0].ends.iter().filter(|end| **end).count() >= 2 && all[0].observations != all[1].observations
    );
}

#[test]
fn episodes_of_one_environment_differ_and_a_seed_repeats_them() {
    let design = design(&machine("shoulder"), Task::Reach, short());
    let mut environment = Environment::new(design.clone(), 5).unwrap();
    let mut beginnings = Vec::new();
    for seed in [None, None, Some(5), None, Some(6)] {
        let mut told = vec![0.0; design.observations()];
        environment.observe(&mut told);
        let friction = environment.twin().specimen().cables[0].parameters.friction;
        beginnings.push((told, friction));
        environment.reset(seed).unwrap();
    }
    assert_eq!(beginnings[0], beginnings[3]);
    assert_eq!(beginnings[1], beginnings[4]);
    for other in [1, 2] {
        assert!(beginnings[0].0 != beginnings[other].0 && beginnings[0].1 != beginnings[other].1);
    }
}

#[test]
fn ended_episodes_begin_again_as_the_mode_says() {
    let design = design(&machine("bench_joint"), Task::Reach, Settings { steps: 2, ..short() });
    let (width, acts) = (design.observations(), design.actions());
    for mode in [ResetMode::NextStep, ResetMode::SameStep, ResetMode::Disabled] {
        let mut batch = EnvironmentBatch::new(&design, &[1, 2], mode, 1).unwrap();
        let mut rows = [vec![0.0_f32; 2 * width], vec![7.0; 2 * width]];
        let (mut numbers, mut flags) = ([[0.0; 2]; 3], [[false; 2]; 2]);
        let mut step = |batch: &mut EnvironmentBatch| {
            let [observations, last_observations] = &mut rows;
            let ([rewards, errors, last_errors], [terminated, truncated]) = (&mut numbers, &mut flags);
            let mut out = Outcomes {
                observations,
                rewards,
                terminated,
                truncated,
                errors,
                last_observations,
                last_errors,
            };
            let done = batch.step(&vec![0.1; 2 * acts], &mut out);
            done.map(|()| (flags[1], numbers[0], rows.clone()))
        };
        assert_eq!(step(&mut batch).unwrap().0, [false; 2]);
        let (truncated, rewards, [told, last]) = step(&mut batch).unwrap();
        assert!(truncated == [true; 2] && rewards.iter().all(|reward| *reward != 0.0));
        match mode {
            ResetMode::NextStep => {
                let (truncated, rewards, [reset, _]) = step(&mut batch).unwrap();
                assert!(truncated == [false; 2] && rewards == [0.0; 2] && reset != told);
            }
            ResetMode::SameStep => {
                assert!(last != told && last.iter().all(|x| *x != 7.0));
                assert_eq!(step(&mut batch).unwrap().0, [false; 2]);
            }
            ResetMode::Disabled => {
                let wrong = step(&mut batch).unwrap_err();
                assert!(
                    matches!(wrong, Error::EntryOutOfDomain { name: "environment", index: 0, .. }),
                    "{wrong}"
                );
                let (mut told, mut errors) = (vec![0.0; 2 * width], [0.0; 2]);
                batch.reset(None, Some(&[true, false]), &mut told, &mut errors).unwrap();
                let wrong = step(&mut batch).unwrap_err();
                assert!(matches!(wrong, Error::EntryOutOfDomain { index: 1, .. }), "{wrong}");
                batch.reset(None, Some(&[false, true]), &mut told, &mut errors).unwrap();
                assert_eq!(step(&mut batch).unwrap().0, [false; 2]);
            }
        }
    }
}

#[test]
fn a_machine_without_friction_passes_all_of_the_tension() {
    let lossless = Randomisation { friction: [0.0, 0.0], ..Randomisation::none() };
    for (randomisation, loses) in [(Randomisation::none(), true), (lossless, false)] {
        let design =
            EnvironmentDesign::new(&machine("bench_joint"), Task::Reach, short(), randomisation).unwrap();
        let environment = Environment::new(Arc::new(design), 1).unwrap();
        let cable = environment.twin().truth().cables[0];
        let parallel = environment.twin().specimen().cables[0].parameters.pretension;
        let lost = cable.tension_in - (cable.tension_out - parallel);
        assert_eq!(lost > 0.1 * cable.tension_in, loses, "{cable:?}");
        assert!(loses || lost.abs() < 1e-9, "{cable:?}");
    }
}

#[test]
fn a_drive_that_winds_until_its_drum_is_full_ends_the_episode() {
    let settings = Settings { actuation: Actuation::Torque, interval_ms: 20, ..Settings::default() };
    let design = design(&machine("bench_joint"), Task::Reach, settings);
    let mut environment = Environment::new(design, 1).unwrap();
    let mut outcome = environment.step(&[1.0, -1.0]).unwrap();
    while !outcome.terminated && !outcome.truncated {
        outcome = environment.step(&[1.0, -1.0]).unwrap();
    }
    let faults: Vec<DriveFault> =
        environment.twin().truth().drives.iter().filter_map(|drive| drive.fault).collect();
    assert!(outcome.terminated && outcome.reward == 0.0 && !faults.is_empty(), "{outcome:?} {faults:?}");
    assert!(environment.step(&[0.0, 0.0]).is_err(), "it has to be reset first");
}

#[test]
fn wrong_input_is_refused_with_its_name_and_changes_nothing() {
    let joint = machine("bench_joint");
    let wrong = |settings: Settings| {
        let refused = EnvironmentDesign::new(&joint, Task::Reach, settings, Randomisation::default());
        refused.map(drop).unwrap_err().to_string()
    };
    assert!(wrong(Settings { interval_ms: 0, ..short() }).starts_with("interval_ms"));
    assert!(wrong(Settings { steps: 0, ..short() }).starts_with("steps"));
    assert!(wrong(Settings { spread: f64::NAN, ..short() }).starts_with("spread"));
    assert!(wrong(Settings { effort: -1.0, ..short() }).starts_with("effort"));
    assert!(
        wrong(Settings { resolution: Resolution { cells: 0, substeps: 1 }, ..short() }).contains("cells")
    );
    let random = |randomisation| {
        let refused = EnvironmentDesign::new(&joint, Task::Reach, short(), randomisation);
        refused.map(drop).unwrap_err().to_string()
    };
    assert!(random(Randomisation { friction: [1.0, 0.5], ..Randomisation::none() }).starts_with("friction"));
    assert!(random(Randomisation { mass: [0.0, 0.5], ..Randomisation::none() }).starts_with("mass"));
    assert!(
        random(Randomisation { delay_ms: [0.0, f64::NAN], ..Randomisation::none() }).starts_with("delay_ms")
    );
    assert!(
        EnvironmentDesign::new(&joint, Task::Hold { push: 2.0 }, short(), Randomisation::none()).is_err()
    );
    let other = there_and_back(&machine("lm_arm"));
    assert!(EnvironmentDesign::new(&joint, other, short(), Randomisation::none()).is_err());

    let design = design(&joint, Task::Reach, short());
    let mut environment = Environment::new(design.clone(), 1).unwrap();
    let mut untouched = environment.clone();
    assert!(matches!(environment.step(&[0.0]), Err(Error::WrongLength { expected: 2, got: 1, .. })));
    assert!(matches!(
        environment.step(&[0.0, f32::NAN]),
        Err(Error::EntryOutOfDomain { name: "action", index: 1, .. })
    ));
    assert_eq!(environment.step(&[0.0, 0.1]), untouched.step(&[0.0, 0.1]));
    assert!(EnvironmentBatch::new(&design, &[], ResetMode::NextStep, 1).is_err());
    assert!(EnvironmentBatch::new(&design, &[1], ResetMode::NextStep, 0).is_err());
}

#[test]
fn an_environment_has_its_machines_period_and_refuses_an_interval_that_is_no_multiple_of_it() {
    let of = |period: f64, interval_ms: u32| {
        let machine = Machine { period, ..machine("finger") };
        let settings = Settings { interval_ms, ..Settings::default() };
        EnvironmentDesign::new(&machine, Task::Reach, settings, Randomisation::none()).map(Arc::new)
    };
    // Drives hold a command for an interval: its cycles change nothing but the reading that is the last one.
    let runs: Vec<Run> =
        [1e-3, 2e-3, 4e-3].map(|period| run(&of(period, 8).unwrap(), &[5], 1, 20).remove(0)).into();
    assert!(runs.iter().all(|run| run == &runs[0]));
    for (period, interval) in [(2e-3, 5), (4e-3, 10), (0.02, 10), (1.5e-3, 10)] {
        let refused = of(period, interval).err().unwrap().to_string();
        assert!(refused.contains("period of the machine"), "{refused}");
    }
    assert!(of(2.5e-3, 10).is_ok() && of(5e-4, 1).is_ok());
}
