//! Master and simulated devices over raw frames on a pair of virtual interfaces, in network namespaces of
//! their own.
//!
//! Skipped where such namespaces are not permitted. Times are not judged: they are those of the machine's
//! load.

#![allow(clippy::print_stdout, reason = "a skipped test says so")]

use crate::common::{PERIOD, STEP, Setup, machine};
use sinew_runtime::Error;
use sinew_runtime::cycle::{Cycle, CycleRecord, MonotonicClock, Timing, run};
use sinew_runtime::ethercat::{FrameStorage, Master, RawSocketLink, SimulatedMachine, serve};
use sinew_segment::{Drive, RawSocket};
use std::panic::{AssertUnwindSafe, catch_unwind};
use std::process::Command;
use std::sync::atomic::{AtomicBool, Ordering};
use std::time::{Duration, Instant};

/// Set in the process that runs inside of the namespaces.
const INSIDE: &str = "SINEW_VETH_INSIDE";

#[test]
fn fifteen_drives_come_into_operation_over_raw_frames() {
    if let Some(end) = std::env::var_os(INSIDE) {
        inside(end == "panic");
        return;
    }
    let itself = std::env::current_exe().unwrap();
    let script = "ip link add sinew0 type veth peer name sinew1 && ip link set sinew0 up && ip link set \
        sinew1 up && exec \"$0\" --exact veth::fifteen_drives_come_into_operation_over_raw_frames --nocapture";
    let prepared = Command::new("unshare")
        .args(["-Urn", "sh", "-c", "ip link add sinew0 type veth peer name sinew1"])
        .output();
    if !prepared.is_ok_and(|output| output.status.success()) {
        println!("skipped: network namespaces or virtual interfaces are not permitted here");
        return;
    }
    for end in ["error", "panic"] {
        let inside = Command::new("unshare")
            .args(["-Urn", "sh", "-c", script])
            .arg(&itself)
            .env(INSIDE, end)
            .output()
            .unwrap();
        let printed = String::from_utf8_lossy(&inside.stdout);
        println!("{printed}");
        assert!(inside.status.success(), "{end}: {printed}\n{}", String::from_utf8_lossy(&inside.stderr));
    }
}

/// Sets a flag where its scope ends, by a panic as well: a thread that waits for the flag ends, and the test
/// fails instead of hanging.
struct StopOnDrop<'a>(&'a AtomicBool);

impl Drop for StopOnDrop<'_> {
    fn drop(&mut self) {
        self.0.store(true, Ordering::Relaxed);
    }
}

/// A whole run, and one that an error or a panic in a cycle ends.
fn inside(panics: bool) {
    let setup = Setup::new(machine("lm_arm"), 1, &[]);
    let stop = AtomicBool::new(false);
    std::thread::scope(|scope| {
        let stopping = StopOnDrop(&stop);
        let served = scope.spawn(|| {
            let socket = RawSocket::open("sinew1").unwrap();
            let mut simulated =
                SimulatedMachine::new(setup.plant.clone(), &setup.machine, setup.devices.clone());
            let mut segment = simulated.segment(&[]).unwrap();
            let answered =
                serve(&socket, (&mut segment, &mut simulated), PERIOD, &stop, &mut |_| {}).unwrap();
            let drives = segment.devices().iter().filter_map(|device| device.drive());
            // Without commands drives stop by themselves, with a fault: that is not what is meant after an
            // error. To unwind for the first time may take longer than the drives wait.
            let left = |drive: &&Drive| drive.brake_released() || (!panics && drive.error_code() != 0);
            (answered, drives.filter(left).count())
        });
        let begin = Instant::now();
        let storage = FrameStorage::new();
        // The interfaces need a moment to find their carrier.
        let mut master = Master::new(&storage, RawSocketLink::open("sinew0").unwrap()).unwrap();
        while master.scan().map_or(0, |found| found.len()) < setup.machine.devices.len() {
            assert!(begin.elapsed().as_secs() < 30, "the devices do not answer");
        }
        let matched = master.match_devices(&setup.devices).unwrap();
        let bus = matched.operate(&setup.machine).unwrap();
        println!(
            "{} devices in operation after {:.2} s",
            setup.machine.devices.len(),
            begin.elapsed().as_secs_f64()
        );
        let mut cycle = Cycle::new(bus, setup.supervisor(), setup.schedule(), STEP);
        let mut timing = Timing::new();
        let ends = AtomicBool::new(false);
        run(&mut cycle, &mut MonotonicClock, PERIOD, &ends, &mut timing, |_| Ok(())).unwrap();
        let statistics = cycle.statistics();
        println!("{statistics:?}");
        for row in timing.rows() {
            println!(
                "{:<16} median {:>8.1} us, p99 {:>8.1} us, max {:>9.1} us",
                row.quantity, row.median, row.p99, row.max
            );
        }
        let mut bus = cycle.end();
        // Again in operation, and then left by an error in a cycle.
        bus.restart(&setup.machine).unwrap();
        let mut cycle = Cycle::new(bus, setup.supervisor(), setup.schedule(), STEP);
        let mut cycles = 0;
        let fails = |_: &CycleRecord<'_, _>| {
            cycles += 1;
            match cycles {
                ..500 => Ok(()),
                _ if panics => panic!("for the test"),
                _ => Err(Error::Clock(std::io::Error::other("for the test"))),
            }
        };
        let ended = catch_unwind(AssertUnwindSafe(move || {
            run(&mut cycle, &mut MonotonicClock, PERIOD, &ends, &mut timing, fails).is_err()
        }));
        assert!(ended.unwrap_or(panics));
        // The last frames are answered.
        std::thread::sleep(Duration::from_millis(20));
        drop(stopping);
        let (answered, released) = served.join().unwrap();
        assert!(answered > 1000 && released == 0, "{answered} frames, {released} drives not disabled");
        assert_eq!(statistics.missing, 0, "{statistics:?}");
        // Frames are late where other programs have the processors.
        assert!(
            statistics.exchanges > 1000 && statistics.exchanges - statistics.lost > 100,
            "{statistics:?}"
        );
    });
}
