//! Serves a line of simulated devices on an interface: `serve INTERFACE [DRIVES [ENCODERS]]`. Ends at the end
//! of its input.
//!
//! Motors are ideal: they have the commanded velocity at once.

use sinew_segment::{AxisCommand, Device, DeviceSettings, RawSocket, Segment, builtin, serve};
use std::error::Error;
use std::io::Read;
use std::process::ExitCode;
use std::sync::Arc;
use std::sync::atomic::{AtomicBool, Ordering};

fn main() -> ExitCode {
    match run() {
        Ok(()) => ExitCode::SUCCESS,
        Err(error) => {
            eprintln!("error: {error}");
            ExitCode::FAILURE
        }
    }
}

fn run() -> Result<(), Box<dyn Error>> {
    let mut arguments = std::env::args().skip(1);
    let interface = arguments.next().ok_or("usage: serve INTERFACE [DRIVES [ENCODERS]]")?;
    let drives = arguments.next().map_or(Ok(3), |drives| drives.parse())?;
    let encoders = arguments.next().map_or(Ok(4), |encoders| encoders.parse())?;
    let mut segment = line(drives, encoders)?;
    let socket = RawSocket::open(&interface)?;

    let stop = Arc::new(AtomicBool::new(false));
    let asked = Arc::clone(&stop);
    std::thread::spawn(move || {
        // Whatever is read, the end of the input ends the program.
        std::io::stdin().read_to_end(&mut Vec::new()).ok();
        asked.store(true, Ordering::Relaxed);
    });
    let mut positions = vec![0.0; segment.devices().len()];
    let served = serve(&socket, &mut segment, &stop, |segment, elapsed_ns| {
        for (at, position) in positions.iter_mut().enumerate() {
            let Some(drive) = segment.device_mut(at).and_then(Device::drive_mut) else { continue };
            let velocity = match drive.command() {
                AxisCommand::Velocity(velocity) => velocity,
                _ => 0,
            };
            *position += f64::from(velocity) * elapsed_ns as f64 * 1e-9;
            drive.set_actual(*position as i32, velocity, 0);
        }
    })?;
    eprintln!("{served:?}");
    for device in segment.devices() {
        eprintln!("{}: {:?} {:?}", device.name(), device.state(), device.status_code());
    }
    Ok(())
}

/// A coupler, drives, a load cell and, where encoders are desired, their terminal.
fn line(drives: u32, encoders: usize) -> Result<Segment, Box<dyn Error>> {
    let settings = |serial| DeviceSettings { serial: Some(serial), ..DeviceSettings::default() };
    let mut devices = vec![Device::new(&builtin::coupler(), settings(0))?];
    for serial in 1..=drives {
        devices.push(Device::new(&builtin::drive(), settings(serial))?);
    }
    devices.push(Device::new(&builtin::load_cell(), settings(drives + 1))?);
    if encoders > 0 {
        devices.push(Device::new(&builtin::encoder(encoders), settings(drives + 2))?);
    }
    Ok(Segment::new(devices))
}
