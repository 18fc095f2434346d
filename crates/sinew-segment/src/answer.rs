//! What a device does with a datagram: whom it is for, what is done, and how it is counted.
//!
//! Source: ETG.1000.4, 5.4 (commands) and table 17 (working counter).

use crate::esc::Controller;
use crate::frame::{Command, Datagram, Transfer};

/// Working counter: a read counts one, a write one, both in one datagram three.
const READ: u16 = 1;
const WRITTEN: u16 = 1;
const WRITTEN_IN_EXCHANGE: u16 = 2;

/// One datagram passes a controller.
pub(crate) fn answer(controller: &mut Controller, datagram: &mut Datagram) {
    let offset = datagram.offset;
    datagram.events |= controller.events();
    let Some(command) = datagram.command else { return };
    match command {
        Command::Nop => {}
        Command::Position(transfer) => {
            if step_position(datagram) {
                addressed(controller, datagram, transfer);
            }
        }
        Command::Station(transfer) => {
            if controller.answers_to(datagram.device) {
                addressed(controller, datagram, transfer);
            }
        }
        Command::Broadcast(transfer) => {
            step_position(datagram);
            broadcast(controller, datagram, transfer);
        }
        Command::Logical(transfer) => logical(controller, datagram, transfer),
        Command::PositionMultiple | Command::StationMultiple => {
            let reads = match command {
                Command::PositionMultiple => step_position(datagram),
                _ => controller.answers_to(datagram.device),
            };
            let success = if reads {
                controller.read(offset, datagram.data)
            } else {
                controller.write(offset, datagram.data)
            };
            datagram.count(u16::from(success));
        }
    }
}

/// Counts the position up; true for the device at position 0.
fn step_position(datagram: &mut Datagram) -> bool {
    let hit = datagram.device == 0;
    datagram.device = datagram.device.wrapping_add(1);
    hit
}

fn addressed(controller: &mut Controller, datagram: &mut Datagram, transfer: Transfer) {
    let offset = datagram.offset;
    match transfer {
        Transfer::Read => {
            let success = controller.read(offset, datagram.data);
            datagram.count(READ * u16::from(success));
        }
        Transfer::Write => {
            let success = controller.write(offset, datagram.data);
            datagram.count(WRITTEN * u16::from(success));
        }
        Transfer::Exchange => {
            let mut incoming = [0; 2048];
            let length = datagram.data.len();
            incoming[..length].copy_from_slice(datagram.data);
            let read = controller.read(offset, datagram.data);
            let written = controller.write(offset, &incoming[..length]);
            datagram.count(READ * u16::from(read) + WRITTEN_IN_EXCHANGE * u16::from(written));
        }
    }
}

/// What is read is combined by OR with what earlier devices have read.
fn broadcast(controller: &mut Controller, datagram: &mut Datagram, transfer: Transfer) {
    let (offset, length) = (datagram.offset, datagram.data.len());
    let mut own = [0; 2048];
    let own = &mut own[..length];
    let read = transfer != Transfer::Write && controller.read(offset, own);
    let written = transfer != Transfer::Read && controller.write(offset, datagram.data);
    if read {
        for (octet, own) in datagram.data.iter_mut().zip(own) {
            *octet |= *own;
        }
    }
    let by = if transfer == Transfer::Exchange { WRITTEN_IN_EXCHANGE } else { WRITTEN };
    datagram.count(READ * u16::from(read) + by * u16::from(written));
}

fn logical(controller: &mut Controller, datagram: &mut Datagram, transfer: Transfer) {
    let (reads, writes) = (transfer != Transfer::Write, transfer != Transfer::Read);
    let address = datagram.logical();
    let (read, written) = controller.logical(address, datagram.data, reads, writes);
    let by = if transfer == Transfer::Exchange { WRITTEN_IN_EXCHANGE } else { WRITTEN };
    datagram.count(READ * u16::from(read) + by * u16::from(written));
}
