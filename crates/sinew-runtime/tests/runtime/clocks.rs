//! Distributed clocks: the drives take their set-points over at SYNC0, and the cycle keeps pace with the
//! devices.

use crate::common::{Setup, machine};
use sinew_runtime::ethercat::FrameStorage;
use sinew_session::{ClockReport, Plant};

fn report(setup: &Setup) -> ClockReport {
    let storage = FrameStorage::new();
    let cycle = setup.run(setup.segment_bus(&storage), |_| {});
    assert_eq!(cycle.statistics().first, None);
    cycle.plant().clocks().unwrap()
}

#[test]
fn drives_are_synchronised_and_the_cycle_follows_the_clock_of_the_bus() {
    for name in ["planar_leg", "lm_arm"] {
        let setup = Setup::new(machine(name), 3, &[]);
        let report = report(&setup);
        assert_eq!(report.synchronized, setup.machine.muscles.len(), "{name}");
        // The clock of the first simulated device is 11 ppm fast, and shows whole nanoseconds.
        assert!((report.drift_ppm - 11.0).abs() < 1.0, "{name}: {report:?}");
        assert!(report.phase_rms_us < 0.3 && report.phase_max_us < 1.0, "{name}: {report:?}");
        assert!(report.device_difference_ns < 250, "{name}: {report:?}");
    }
}

#[test]
fn a_drive_takes_set_points_as_they_arrive_where_the_machine_file_says_so() {
    let mut setup = Setup::new(machine("planar_leg"), 3, &[]);
    setup.devices[0].sync0 = false;
    assert_eq!(report(&setup).synchronized, 3);
}
