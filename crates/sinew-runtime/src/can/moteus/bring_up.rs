//! A controller before it takes commands: found, compared, stopped, its watchdog seen at work.

use super::{
    CODES, FAULT, POSITION, REGISTER_MAP, Readings, STOPPED, TIMEOUT, ask_identity, fault_name, identity,
    mode_name, query, readings, slot::MoteusSlot, stop,
};
use crate::can::Link;
use crate::can::device::CanDevice;
use crate::can::error::CanError;
use crate::can::slot::Slot;
use crate::can::talk::{SILENCE, STATE_TIME, Talk};
use sinew::machine::Machine;
use sinew_segment::CanFrame as Frame;

/// Finds a controller, stops it and sees its watchdog end a command. Nothing moves: it has power for that
/// time, at a velocity of 0.
pub(in crate::can) fn start<L: Link>(
    link: &mut L,
    device: &CanDevice,
    machine: &Machine,
) -> Result<Box<dyn Slot>, CanError> {
    if !link.carries_fd() {
        return Err(device.wrong(
            "the bus carries no CAN FD: expected a CAN interface with `fd on`, or the serial port of an \
             fdcanusb",
        ));
    }
    let mut talk = Talk { link, device, period: machine.period_ns() };
    let node = device.node;
    let of_node = |frame: &Frame| identity(frame).filter(|(of, _)| *of == node);
    let (_, [_, _, registers]) = talk.answer(&ask_identity(node), of_node)?;
    talk.is_alone(of_node)?;
    if registers != REGISTER_MAP {
        return Err(device.wrong(format!("register map {registers}: expected {REGISTER_MAP}")));
    }
    let parameters = machine.muscles[device.drive.muscle].drive;
    let slot = MoteusSlot::new(node, device.drive, parameters, machine.watchdog());
    let stopped = takes(&mut talk, STOPPED, &stop(node))?;
    if !stopped.position.is_finite() {
        return Err(device.wrong("its encoder gives no position"));
    }
    takes(&mut talk, POSITION, &slot.stand())?;
    let most = machine.watchdog();
    talk.pass((1e9 * SILENCE * most) as u64);
    // This one feeds no watchdog.
    let after = talk.answer(&query(node), |frame| readings(node, frame));
    let end = takes(&mut talk, STOPPED, &stop(node));
    match after?.mode {
        TIMEOUT => end.map(|_| Box::new(slot) as Box<dyn Slot>),
        mode => Err(device.wrong(format!(
            "{} {:.3} s after its last command: expected it to time out after {most} s",
            mode_name(mode),
            SILENCE * most
        ))),
    }
}

/// Commands once a period until it shows a mode.
fn takes<L: Link>(talk: &mut Talk<'_, L>, mode: u8, command: &Frame) -> Result<Readings, CanError> {
    let (node, end) = (talk.device.node, talk.link.now() + STATE_TIME);
    let mut shown = "no answer".to_owned();
    while talk.link.now() < end {
        talk.send(&[*command])?;
        talk.pass(talk.period);
        let now = talk.link.now();
        while let Some(readings) = talk.next(now, |frame| readings(node, frame))? {
            if readings.mode == mode {
                return Ok(readings);
            }
            shown = mode_name(readings.mode);
            if readings.mode == FAULT {
                shown = fault_name(CODES + u16::from(readings.fault));
            }
        }
    }
    Err(talk.device.wrong(format!("{shown}: expected {} after it was asked for", mode_name(mode))))
}
