//! The example of a bus of one's own: a machine is moved in real time, its devices in another process.

use std::net::UdpSocket;
use std::path::{Path, PathBuf};
use std::process::{Child, Command};
use std::time::Duration;

fn example() -> PathBuf {
    let program = Path::new(env!("CARGO_BIN_EXE_sinew"));
    let example = program.with_file_name("examples").join("text_bus");
    assert!(example.is_file(), "`cargo build -p sinew-cli --example text_bus` makes {}", example.display());
    example
}

/// Ends the devices whatever happens.
struct Devices(Child);

impl Drop for Devices {
    fn drop(&mut self) {
        let _ = self.0.kill();
        let _ = self.0.wait();
    }
}

/// The devices in a process of their own, once they answer, and their address.
fn devices() -> (Devices, String) {
    let socket = UdpSocket::bind("127.0.0.1:0").unwrap();
    let address = socket.local_addr().unwrap().to_string();
    drop(socket);
    let child = Command::new(example()).args(["devices", &address]).spawn().unwrap();
    let (devices, asks) = (Devices(child), UdpSocket::bind("127.0.0.1:0").unwrap());
    asks.set_read_timeout(Some(Duration::from_millis(50))).unwrap();
    asks.connect(&address).unwrap();
    for _ in 0..600 {
        let mut answer = [0; 4096];
        // A port that nobody listens on refuses at once.
        if asks.send(b"read 1").is_ok() && asks.recv(&mut answer).is_ok() {
            return (devices, address);
        }
        std::thread::sleep(Duration::from_millis(50));
    }
    panic!("the devices do not answer");
}

#[test]
fn a_machine_on_a_bus_of_text_is_moved_in_real_time_with_its_devices_in_another_process() {
    let mut told = String::new();
    // A computer with other work is late now and then, and a bus that is silent for long stops the machine.
    for _ in 0..5 {
        let (_devices, address) = devices();
        let begin = std::time::Instant::now();
        let ran = Command::new(example()).args(["run", &address]).output().unwrap();
        assert!(ran.status.success(), "{}", String::from_utf8_lossy(&ran.stderr));
        told = String::from_utf8(ran.stdout).unwrap();
        let error: f64 = told.split("up to ").nth(1).unwrap().split(' ').next().unwrap().parse().unwrap();
        let cycles: f64 = told.split("after ").nth(1).unwrap().split(' ').next().unwrap().parse().unwrap();
        if told.starts_with("Run after 3000 cycles") {
            assert!(error < 0.05, "{told}");
            assert!(begin.elapsed().as_secs_f64() > 1e-3 * cycles, "in real time");
            return;
        }
    }
    panic!("{told}");
}

#[test]
fn without_devices_the_machine_is_stopped_by_its_name() {
    let ran = Command::new(example()).args(["run", "127.0.0.1:9"]).output().unwrap();
    let told = String::from_utf8(ran.stdout).unwrap();
    assert!(!told.starts_with("Run"), "{told}");
    assert!(!Command::new(example()).arg("run").output().unwrap().status.success());
}
