//! Machines controlled through the EtherCAT master and simulated devices, in virtual time.

use crate::common::{Errors, Setup, machine, with_mode};
use sinew::control::arm::ArmStatus;
use sinew::machine::DriveMode;
use sinew_runtime::bus::{Bus, SimulatedBus};
use sinew_runtime::ethercat::FrameStorage;

/// Errors of the joints and a digest of all commands.
fn tracked<B: Bus + SimulatedBus>(setup: &Setup, bus: B) -> (Errors, u64) {
    let (mut errors, mut digest) = (Errors::default(), 0xcbf2_9ce4_8422_2325_u64);
    let cycle = setup.run(bus, |record| {
        assert!(
            matches!(record.command.arm.status, ArmStatus::Following | ArmStatus::Holding),
            "{:?}",
            record.moment
        );
        errors.record(&record.reference.q, record.bus.arm().truth().q);
        for estimate in record.command.arm.q.iter().chain(record.command.arm.estimated_tension) {
            digest = (digest ^ estimate.to_bits()).wrapping_mul(0x0000_0100_0000_01b3);
        }
    });
    assert_eq!(cycle.statistics().first, None, "no fault of the bus");
    (errors, digest)
}

#[test]
fn a_machine_tracks_through_all_layers_as_on_the_bus_without_wires() {
    for name in ["lm_arm", "planar_leg", "finger", "surgical_wrist"] {
        let setup = Setup::new(machine(name), 3, &[]);
        let (direct, _) = tracked(&setup, setup.twin_bus());
        let storage = FrameStorage::new();
        let (wired, _) = tracked(&setup, setup.segment_bus(&storage));
        // A cycle of delay more, and counts instead of numbers.
        assert!(
            wired.mean < 1.2 * direct.mean && wired.max < 1.3 * direct.max,
            "{name}: {direct:?} {wired:?}"
        );
    }
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
