//! Brings devices back that left OP by themselves.

use super::bring_up::{AL_CONTROL, AL_ERROR, AL_STATUS, FIRST_STATION, OP, SAFE_OP};
use ethercrab::error::Error;
use ethercrab::{Command, MainDevice};

/// Acknowledges the error of a device in SAFE-OP, or requests OP of one that is there without an error: one
/// step of ETG.1000.6 in one or two frames. A device below SAFE-OP has lost its configuration: it needs a new
/// start of the bus.
pub(super) async fn step(main: &MainDevice<'_>, position: usize) -> Result<(), Error> {
    let station = FIRST_STATION + position as u16;
    let status = Command::fprd(station, AL_STATUS).receive::<u16>(main).await? as u8;
    let request = match (status & 0x0f, status & AL_ERROR != 0) {
        (SAFE_OP, true) => SAFE_OP | AL_ERROR,
        (SAFE_OP, false) => OP,
        _ => return Ok(()),
    };
    Command::fpwr(station, AL_CONTROL).ignore_wkc().send(main, u16::from(request)).await
}
