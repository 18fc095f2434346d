//! Arms that move together: every one has the bits of the same arm alone.

#![allow(clippy::unwrap_used, reason = "a failing test may panic")]

use crate::common::chains::{Chain, chain};
use sinew::body::{Robot, Tendon};
use sinew::drive::DriveCommand;
use sinew::machine::Machine;
use sinew::muscle::{PulleyRouting, with_pulleys};
use sinew::random::Random;
use sinew::twin::arm::{ArmSpecimen, ArmTwin, ArmTwins, Failure, InjectedFault, Sensor, SensorFailure, Worn};

/// Steps from one gathering to the next.
const STEPS: usize = 10;
/// Arms of which each has another fault, the last but one one that it does not survive.
const ARMS: usize = 8;

/// All that an arm tells, with all digits.
fn told(arm: &ArmTwin) -> String {
    format!("{:?} {:?}", arm.truth(), arm.reading())
}

/// Steps arms together and copies of them alone for so many seconds; how many joints pressed on their stops,
/// and how many arms failed.
fn compare(machine: &Machine, seed: u64, seconds: f64) -> Result<[usize; 2], sinew::Error> {
    let (joints, muscles) = (machine.start.len(), machine.muscles.len());
    let h = machine.period;
    let mut random = Random::new(seed);
    let fault =
        |start: f64, failure| InjectedFault { start: start * seconds, duration: f64::INFINITY, failure };
    let push = |joint, torque| Failure::Push { joint, torque };
    let faults = [
        vec![fault(0.1, Failure::Cable(0))],
        vec![fault(0.2, Failure::Amplifier(muscles - 1)), fault(0.5, push(0, 3.0))],
        vec![fault(0.3, Failure::Winch(0)), fault(0.4, push(joints - 1, -3.0))],
        vec![fault(0.1, Failure::Sensor(Sensor::Tension(0), SensorFailure::Noise(2.0)))],
        vec![
            fault(0.1, Failure::Wear { muscle: 0, what: Worn::Friction, fraction: 0.5 }),
            fault(0.1, Failure::Wear { muscle: muscles - 1, what: Worn::Stiffness, fraction: 0.5 }),
        ],
        vec![],
        vec![fault(0.35, push(0, 1e30))],
        vec![fault(0.2, push(joints - 1, 1.0))],
    ];
    let twin = |k: usize| {
        let specimen = ArmSpecimen::draw(machine, seed + k as u64)?;
        let tension = |cable: &sinew::twin::cable::Specimen| cable.parameters.pretension + 5.0 * k as f64;
        let tensions: Vec<f64> = specimen.cables.iter().map(tension).collect();
        ArmTwin::new(&specimen, &machine.start, &tensions, seed)?.with_faults(&faults[k])
    };
    let mut arms = (0..ARMS).map(twin).collect::<Result<Vec<_>, _>>()?;
    let mut alone = arms.clone();
    let mut together = ArmTwins::new(&arms[0]);
    let (mut pressed, mut failures, rounds) = (0, 0, (seconds / (h * STEPS as f64)) as usize);
    for round in 0..rounds {
        // Some rounds are not of all.
        let count = if round % 7 == 3 { 1 + round % ARMS } else { ARMS };
        let mut command = |_| DriveCommand::Velocity(0.1 * random.normal());
        let commands: Vec<Vec<DriveCommand>> =
            (0..ARMS).map(|_| (0..muscles).map(&mut command).collect()).collect();
        let commands: Vec<&[DriveCommand]> = commands.iter().map(Vec::as_slice).collect();
        let mut failed = [false; ARMS];
        {
            let mut group: Vec<&mut ArmTwin> = arms[..count].iter_mut().collect();
            let mut group = together.gather(&mut group)?;
            for _ in 0..STEPS {
                let results = group.step(&commands, h);
                for k in 0..count {
                    if !failed[k] {
                        let one = alone[k].step(commands[k], h).map(|_| ());
                        assert_eq!(format!("{:?}", results[k]), format!("{one:?}"), "arm {k}");
                    }
                    failed[k] = results[k].is_err();
                }
            }
        }
        // The others go alone, as may all.
        for k in count..ARMS {
            for arm in [&mut arms[k], &mut alone[k]] {
                (0..STEPS).for_each(|_| failed[k] |= arm.step(commands[k], h).is_err());
            }
        }
        for k in 0..ARMS {
            assert_eq!(told(&arms[k]), told(&alone[k]), "arm {k}, round {round}");
            let ranges = machine.ranges().unwrap_or_default();
            let beyond = |(q, [low, high]): (&f64, &[f64; 2])| q < low || q > high;
            pressed += arms[k].truth().q.iter().zip(&ranges).filter(|pair| beyond(*pair)).count();
            if failed[k] {
                failures += 1;
                arms[k] = twin((k + 1) % ARMS)?;
                alone[k] = arms[k].clone();
            }
        }
    }
    Ok([pressed, failures])
}

#[test]
fn eight_arms_of_any_machine_move_together_as_each_of_them_alone() {
    let mut counts = [0; 2];
    for (name, text) in sinew_models::MACHINES {
        let read = sinew::description::machine_from_toml(name, text, &mut |_| Err("no other file".into()));
        let found = compare(&read.unwrap().machine, 3, 2.0).unwrap();
        assert!(found[1] > 0, "{name}: no arm failed");
        counts[0] += found[0];
    }
    assert!(counts[0] > 100, "no joint pressed on its stops: {counts:?}");
}

#[test]
fn eight_arms_of_random_machines_move_together_as_each_of_them_alone() {
    let count = if std::env::var_os("SINEW_LONG").is_some() { 30 } else { 3 };
    let mut compared = 0;
    let kinds = [Chain::Hinges, Chain::Slides, Chain::Coupled, Chain::Planar, Chain::Free];
    for seed in 0..count {
        let mut random = Random::new(seed);
        let joints = 2 + (random.unit() * 5.0) as usize;
        let robot = chain(&mut random, joints, kinds[seed as usize % kinds.len()]);
        let robot = with_pulleys(&robot, 0.02, PulleyRouting::Two).unwrap();
        let mut parts = robot.parts().clone();
        // Along the first cord there is a spring.
        parts.springs.extend(parts.tendons.first().map(|tendon| Tendon {
            name: "spring".into(),
            stiffness: 500.0,
            damping: 2.0,
            ..tendon.clone()
        }));
        let machine = Machine::from_robot(&Robot::new(parts).unwrap()).unwrap();
        // Some are too light for their cables.
        compared += usize::from(compare(&machine, 100 * seed, 0.5).is_ok());
    }
    assert!(2 * compared > count as usize, "{compared}");
}
