//! Machines controlled through the EtherCAT master and simulated devices, in virtual time.

use crate::common::{Errors, Setup, machine, with_mode};
use sinew::control::arm::ArmStatus;
use sinew::machine::{DriveMode, Signal};
use sinew_runtime::ethercat::{EthercatDevice, FrameStorage, Master, SegmentLink, SimulatedMachine};
use sinew_segment::builtin;
use sinew_session::Plant;

/// Errors of the joints and a digest of all commands.
fn tracked<B: Plant>(setup: &Setup, bus: B) -> (Errors, u64) {
    let (mut errors, mut digest) = (Errors::default(), 0xcbf2_9ce4_8422_2325_u64);
    let cycle = setup.run(bus, |record| {
        assert!(
            matches!(record.command.arm.status, ArmStatus::Following | ArmStatus::Holding),
            "{} at {} s: {:?} at {:?}",
            setup.machine.robot.parts().name,
            setup.machine.period,
            record.command.arm.status,
            record.moment
        );
        errors.record(&record.reference.q, record.plant.simulated().unwrap().truth().q);
        for estimate in record.command.arm.q.iter().chain(record.command.arm.estimated_tension) {
            digest = (digest ^ estimate.to_bits()).wrapping_mul(0x0000_0100_0000_01b3);
        }
    });
    assert_eq!(cycle.statistics().first, None, "no fault of the bus");
    (errors, digest)
}

#[test]
fn a_machine_tracks_through_all_layers_as_on_the_bus_without_wires() {
    for name in [
        "bench_joint",
        "planar_leg",
        "finger",
        "exosuit_elbow",
        "surgical_wrist",
        "shoulder",
        "lm_arm",
        "chain10",
    ] {
        let setup = Setup::new(machine(name), 3, &[]);
        let (direct, _) = tracked(&setup, setup.twin_bus());
        let storage = FrameStorage::new();
        let (wired, _) = tracked(&setup, setup.segment_bus(&storage));
        // Counts instead of numbers, and other noise from the start on.
        assert!(
            wired.mean < 1.1 * direct.mean && wired.max < 1.2 * direct.max,
            "{name}: {direct:?} {wired:?}"
        );
    }
}

#[test]
fn a_machine_with_a_slower_or_faster_cycle_tracks_through_all_layers() {
    for (name, period) in
        [("planar_leg", 2e-3), ("finger", 4e-3), ("bench_joint", 1e-2), ("planar_leg", 5e-4)]
    {
        let machine = sinew::machine::Machine { period, ..machine(name) };
        let setup = Setup::new(machine, 3, &[]);
        let (direct, _) = tracked(&setup, setup.twin_bus());
        let storage = FrameStorage::new();
        let (wired, _) = tracked(&setup, setup.segment_bus(&storage));
        assert!(
            wired.mean < 1.2 * direct.mean && wired.max < 1.3 * direct.max,
            "{name} at {period} s: {direct:?} {wired:?}"
        );
    }
}

#[test]
fn process_data_of_several_frames_is_exchanged_whole() {
    let setup = Setup::new(machine("chain10"), 3, &[]);
    let simulated = SimulatedMachine::new(setup.plant.clone(), &setup.machine, setup.devices.clone());
    // Terminals of 12 channels instead of one: 2.1 kB of inputs.
    let mut wide = builtin::encoder(12);
    let of_cells = |device: &&EthercatDevice| {
        let channels = device.device.channels();
        matches!(channels, [one] if matches!(one.signal, Signal::Tension(_)))
    };
    let cell = setup.devices.iter().find(of_cells).unwrap().identity;
    wide.identity.product = cell.product;
    wide.identity.revision = cell.revision;
    let segment = simulated.segment(&[wide.into()]).unwrap();
    let storage = FrameStorage::new();
    let master = Master::new(&storage, SegmentLink::new(segment, simulated)).unwrap();
    let bus = master.match_devices(&setup.devices).unwrap().operate(&setup.machine).unwrap();
    let (direct, _) = tracked(&setup, setup.twin_bus());
    let (wired, _) = tracked(&setup, bus);
    assert!(wired.mean < 1.1 * direct.mean, "{direct:?} {wired:?}");
}

#[test]
fn torque_commands_track_as_well_as_speeds() {
    for name in ["planar_leg", "finger"] {
        let setup = Setup::new(machine(name), 3, &[]);
        let (speeds, _) = tracked(&setup, setup.twin_bus());
        let setup = Setup::new(with_mode(machine(name), DriveMode::Torque), 3, &[]);
        let storage = FrameStorage::new();
        let (torques, _) = tracked(&setup, setup.segment_bus(&storage));
        assert!(torques.mean < 1.5 * speeds.mean, "{name}: {speeds:?} {torques:?}");
    }
}

#[test]
fn a_run_is_repeated_to_the_bit() {
    let digest = || {
        let setup = Setup::new(machine("planar_leg"), 5, &[]);
        let storage = FrameStorage::new();
        tracked(&setup, setup.segment_bus(&storage)).1
    };
    assert_eq!(digest(), digest());
}
