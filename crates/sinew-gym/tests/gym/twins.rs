//! Batches of simulated machines: every world has the bits of the same machine alone.

use sinew::Error;
use sinew::drive::DriveCommand;
use sinew::machine::Machine;
use sinew::random::Random;
use sinew::twin::arm::{ArmSpecimen, ArmTwin, Failure, InjectedFault};
use sinew_gym::TwinBatch;

/// All machines of this repository, with their names.
fn machines() -> Vec<(String, Machine)> {
    let read = sinew_models::MACHINES.map(|(name, text)| {
        let read = sinew::description::machine_from_toml(name, text, &mut |_| Err("no other file".into()));
        (name.to_owned(), read.unwrap().machine)
    });
    read.to_vec()
}

/// A specimen of a seed with a fault of that seed: among ten one that it does not survive.
fn arm(machine: &Machine, seed: u64) -> Result<ArmTwin, Error> {
    let specimen = ArmSpecimen::draw(machine, seed)?;
    let tension = |cable: &sinew::twin::cable::Specimen| cable.parameters.pretension + (seed % 7) as f64;
    let tensions: Vec<f64> = specimen.cables.iter().map(tension).collect();
    let failure = match seed % 10 {
        0 => Failure::Push { joint: 0, torque: 1e30 },
        1..4 => Failure::Cable(seed as usize % machine.muscles.len()),
        4..7 => Failure::Winch(seed as usize % machine.muscles.len()),
        _ => Failure::Amplifier(seed as usize % machine.muscles.len()),
    };
    let fault = InjectedFault { start: 1e-3 * (seed % 50) as f64, duration: f64::INFINITY, failure };
    ArmTwin::new(&specimen, &machine.start, &tensions, seed)?.with_faults(&[fault])
}

fn command(random: &mut Random) -> DriveCommand {
    match (4.0 * random.unit()) as u32 {
        0 => DriveCommand::Tension { tension: 100.0 * random.unit(), feed: 0.0 },
        1 => DriveCommand::Current(random.normal()),
        2 => DriveCommand::Off,
        _ => DriveCommand::Velocity(0.1 * random.normal()),
    }
}

/// All that a machine tells, with all digits.
fn told(arm: &ArmTwin) -> String {
    format!("{:?} {:?}", arm.truth(), arm.reading())
}

#[test]
fn every_world_of_any_machine_has_the_bits_of_that_machine_alone() {
    for (case, (name, machine)) in machines().into_iter().enumerate() {
        let mut random = Random::new(case as u64);
        let (worlds, threads) = (1 + (30.0 * random.unit()) as usize, 1 + (3.0 * random.unit()) as usize);
        let worlds = worlds.max(if case % 2 == 0 { 11 } else { 1 });
        let mut batch = TwinBatch::new(worlds, threads, |k| arm(&machine, k as u64)).unwrap();
        let mut alone: Vec<ArmTwin> = (0..worlds).map(|k| arm(&machine, k as u64).unwrap()).collect();
        let mut failures: Vec<Option<Error>> = vec![None; worlds];
        let mut failed = 0;
        for round in 0..8 {
            let commands: Vec<DriveCommand> =
                (0..worlds * machine.muscles.len()).map(|_| command(&mut random)).collect();
            let h = machine.period.max(0.02 * random.unit());
            batch.step(&commands, h).unwrap();
            for (k, commands) in commands.chunks(machine.muscles.len()).enumerate() {
                if failures[k].is_none() {
                    failures[k] = alone[k].step(commands, h).err();
                }
                assert_eq!(told(&batch.twins()[k]), told(&alone[k]), "{name}, round {round}, world {k}");
            }
            assert_eq!(format!("{:?}", batch.failures()), format!("{failures:?}"), "{name}, round {round}");
            failed += failures.iter().flatten().count();
            if round % 3 == 2 {
                let mask: Vec<bool> = (0..worlds).map(|_| random.unit() < 0.6).collect();
                let seed = |k: usize| 100 * round + k as u64;
                batch.reset(&mask, |k| arm(&machine, seed(k))).unwrap();
                for k in (0..worlds).filter(|k| mask[*k]) {
                    (alone[k], failures[k]) = (arm(&machine, seed(k)).unwrap(), None);
                }
            }
        }
        assert!(worlds < 11 || failed > 0, "{name}: no world failed");
    }
}

#[test]
fn what_is_refused_changes_nothing() {
    let (_, machine) = machines().into_iter().find(|(name, _)| name == "bench_joint").unwrap();
    let mut batch = TwinBatch::new(5, 1, |k| arm(&machine, k as u64)).unwrap();
    let before: Vec<String> = batch.twins().iter().map(told).collect();
    let hold = [DriveCommand::Velocity(0.1); 10];
    for (commands, h) in [(&hold[..9], 1e-3), (&hold[..], 0.0), (&hold[..], f64::NAN), (&hold[..], 0.03)] {
        assert!(batch.step(commands, h).is_err());
    }
    assert!(batch.reset(&[true; 4], |k| arm(&machine, k as u64)).is_err());
    // The last of all cannot be made.
    let broken = |k: usize| {
        if k < 4 { arm(&machine, 9) } else { ArmTwin::new(&ArmSpecimen::draw(&machine, 1)?, &[], &[], 1) }
    };
    assert!(batch.reset(&[true; 5], broken).is_err());
    assert_eq!(batch.twins().iter().map(told).collect::<Vec<_>>(), before);
    for worlds in [0, 1_000_001] {
        assert!(matches!(
            TwinBatch::new(worlds, 1, |k| arm(&machine, k as u64)),
            Err(Error::OutOfDomain { .. })
        ));
    }
}
