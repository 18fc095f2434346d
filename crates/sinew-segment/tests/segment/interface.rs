//! Frames through a pair of real interfaces, in a network of the test's own; skipped where that is not
//! permitted.

#![cfg(all(feature = "raw-socket", target_os = "linux"))]
#![allow(clippy::unwrap_used, reason = "a failing test may panic")]

use crate::wire;

use core::sync::atomic::{AtomicBool, Ordering};
use core::time::Duration;
use sinew_segment::{Device, DeviceSettings, RawSocket, RawSocketError, Segment, builtin, serve};
use std::process::{Command, Stdio};
use std::time::Instant;
use wire::{BRD, Datagram};

/// Set where the test runs inside of its network.
const INSIDE: &str = "SINEW_SEGMENT_INSIDE";
const NETWORK: &str = "ip link add one type veth peer name two && ip link set one up && ip link set two up";

#[test]
fn a_segment_on_an_interface_answers_a_master_on_another() {
    if std::env::var_os(INSIDE).is_some() {
        return inside();
    }
    let network = |rest: &str| {
        let mut command = Command::new("unshare");
        command
            .args(["-Urn", "sh", "-ec", &format!("{NETWORK}{rest}")])
            .arg(std::env::current_exe().unwrap());
        command
    };
    let permitted = network("").stdout(Stdio::null()).stderr(Stdio::null()).status();
    if !permitted.is_ok_and(|status| status.success()) {
        println!(
            "skipped: this system does not let the test make interfaces of its own (unshare -Urn, ip link)"
        );
        return;
    }
    let name = "a_segment_on_an_interface_answers_a_master_on_another";
    let status =
        network(&format!("; exec \"$0\" --exact {name} --nocapture")).env(INSIDE, "1").status().unwrap();
    assert!(status.success(), "inside of the network: {status}");
}

/// Sets a flag where its scope ends, by a panic as well: a thread that waits for the flag ends, and the test
/// fails instead of hanging.
struct StopOnDrop<'a>(&'a AtomicBool);

impl Drop for StopOnDrop<'_> {
    fn drop(&mut self) {
        self.0.store(true, Ordering::Relaxed);
    }
}

fn inside() {
    let (master, line) = (RawSocket::open("one").unwrap(), RawSocket::open("two").unwrap());
    let devices = (0..3).map(|_| Device::new(&builtin::coupler(), DeviceSettings::default()).unwrap());
    let mut segment = Segment::new(devices.collect());
    let stop = AtomicBool::new(false);
    let served = std::thread::scope(|scope| {
        let stopping = StopOnDrop(&stop);
        let serving = scope.spawn(|| serve(&line, &mut segment, &stop, |_, _| {}));
        // The links may need a moment.
        let deadline = Instant::now() + Duration::from_secs(10);
        let answer = loop {
            assert!(Instant::now() < deadline, "no answer within 10 s");
            assert!(master.send(&wire::frame(&[Datagram::new(BRD, 0, 0, &[0])])).unwrap());
            let mut frame = [0; 1518];
            if let Some(length) = master.receive(&mut frame, Duration::from_millis(100)).unwrap() {
                break frame[..length].to_vec();
            }
        };
        assert_eq!(answer[6], 0x12, "passed a device");
        assert_eq!(wire::datagrams(&answer)[0].counter, 3);
        assert_eq!(master.try_receive(&mut [0; 60]).unwrap(), None, "own frames are not seen");
        drop(stopping);
        serving.join().unwrap().unwrap()
    });
    assert!(served.frames >= 1 && served.answers == served.frames, "{served:?}");
    // An interface that is switched off is named.
    let down = Command::new("ip").args(["link", "set", "one", "down"]).status().unwrap();
    assert!(down.success());
    let error = master.send(&wire::frame(&[Datagram::new(BRD, 0, 0, &[0])])).unwrap_err();
    assert!(matches!(&error, RawSocketError::Down { interface } if interface == "one"), "{error}");
}
