//! The controller again, over its recording.

use crate::common::Setup;
use sinew_record::{Recording, Replay};
use sinew_session::Scheduled;

const MACHINES: [&str; 9] = [
    "lm_arm",
    "bench_joint",
    "planar_leg",
    "finger",
    "exosuit_elbow",
    "surgical_wrist",
    "shoulder",
    "chain10",
    // Without load cells: its pretension ends by currents.
    "two_finger_hand",
];

#[test]
fn a_replay_commands_the_same_to_the_bit_on_every_machine() {
    for name in MACHINES {
        let setup = Setup::new(name, 2);
        let (bytes, seen) = setup.recorded();
        let recording = Recording::read(&bytes).unwrap();
        let mut replay = Replay::new(&recording, setup.supervisor(), setup.schedule()).unwrap();
        let (mut cycles, mut blocks, mut moved) = (0, 0, 0.0_f64);
        while let Some(cycle) = replay.step().unwrap() {
            assert!(cycle.same, "{name}: cycle {}", cycle.index);
            let muscles = cycle.commands.len() / 3;
            for (k, command) in cycle.commands.iter().enumerate() {
                assert!((command - cycle.recorded[k]).abs() <= 0.51e-4, "{name}");
                moved = moved.max(if k / muscles == 1 { command.abs() } else { 0.0 });
            }
            if let Some(block) = cycle.block {
                assert!(block.commands.iter().chain(block.references).all(|same| *same), "{name}");
                blocks += 1;
            }
            cycles += 1;
        }
        // A block is half a second long.
        let block = recording.head.cycles_of(500) as usize;
        assert_eq!((cycles, blocks), (seen.len(), seen.len().div_ceil(block)), "{name}");
        assert!(moved > 1e-3, "{name}: the winches moved by at most {moved} m/s");
    }
}

#[test]
fn another_controller_and_another_motion_are_found_where_they_begin_to_differ() {
    let setup = Setup::new("planar_leg", 1);
    let (bytes, _) = setup.recorded();
    let recording = Recording::read(&bytes).unwrap();
    let other = Setup::new("planar_leg", 2);
    let mut replay = Replay::new(&recording, other.supervisor(), setup.schedule()).unwrap();
    let (mut different, mut references) = (0, 0);
    while let Some(cycle) = replay.step().unwrap() {
        different += usize::from(!cycle.same);
        references += cycle.block.map_or(0, |block| block.references.iter().filter(|same| !**same).count());
    }
    // At rest both let the winches stand.
    assert!((1500..2500).contains(&different), "{different}");
    assert_eq!(references, 0, "the motion is the same");

    let slower = sinew::trajectory::Schedule::new(&setup.trajectory, 1, 0.21, 0.8).unwrap();
    let slower = Scheduled::new(slower, &setup.machine.robot, &setup.machine.start).unwrap();
    let mut replay = Replay::new(&recording, setup.supervisor(), slower).unwrap();
    let mut first = None;
    while let Some(cycle) = replay.step().unwrap() {
        first = first.or((!cycle.same).then_some(cycle.index));
    }
    let first = first.unwrap();
    assert!((1..=202).contains(&first), "the first cycle that previews the motion: {first}");
}

#[test]
fn a_controller_of_another_machine_is_refused() {
    let setup = Setup::new("bench_joint", 1);
    let (bytes, _) = setup.recorded();
    let recording = Recording::read(&bytes).unwrap();
    let other = Setup::new("planar_leg", 1);
    for (supervisor, schedule, part) in [
        (other.supervisor(), setup.schedule(), "of the controller"),
        (setup.supervisor(), other.schedule(), "of the motion"),
    ] {
        let refused = Replay::new(&recording, supervisor, schedule).unwrap_err();
        assert!(refused.to_string().contains(part), "{refused}");
    }
}
