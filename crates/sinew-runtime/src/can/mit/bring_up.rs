//! Motors before they take commands: found, compared, without power; our watchdog seen at work.

use super::slot::MitSlot;
use super::{Answer, TRAVEL, answer, clear, enter, fault_name, leave};
use crate::can::device::CanDevice;
use crate::can::error::CanError;
use crate::can::sign::Sign;
use crate::can::slot::Slot;
use crate::can::talk::{SILENCE, Talk};
use crate::can::{Link, MitMotor};
use sinew::machine::Machine;
use sinew_segment::{CanFrame as Frame, MitCommand, MitFamily};

/// Registers of a DAMIAO: time without commands, in 50 us; mode, 1 for MIT; ranges.
const TIMEOUT: u8 = 9;
const MODE: u8 = 10;
const RANGES: [(u8, &str); 3] = [(21, "PMAX"), (22, "VMAX"), (23, "TMAX")];
const TIMEOUT_UNIT: f64 = 50e-6;
/// Its own watchdog acts after so many times of ours.
const LATER: f64 = 2.0;
/// Difference of a range that is a rounding, as a part of it.
const ROUNDING: f64 = 1e-3;
/// Part of its time after the last sign of life in which our watchdog has not acted yet.
const EARLY: f64 = 0.8;
/// Periods in which motors are told to follow.
const ENTERING: usize = 4;

/// Finds a motor and takes its power; of a DAMIAO mode and ranges are compared, its own watchdog is set.
pub(in crate::can) fn start<L: Link>(
    link: &mut L,
    device: &CanDevice,
    machine: &Machine,
) -> Result<Box<dyn Slot>, CanError> {
    let mut talk = Talk { link, device, period: machine.period_ns() };
    let (node, motor) = (device.node, device.motor()?);
    let MitMotor { ranges, stiffness, damping, .. } = motor;
    let steps = [stiffness / ranges.stiffness, damping / ranges.damping].map(|part| 4095.0 * part);
    if !steps.iter().all(|steps| (1.0..=4095.0).contains(steps)) {
        let most = [ranges.stiffness, ranges.damping];
        return Err(device.wrong(format!(
            "a stiffness of {stiffness:.3} N m/rad and a damping of {damping:.4} N m s/rad: expected 1 to 4095 \
            steps of {:.3} and {:.4}, which its frames have",
            most[0] / 4095.0,
            most[1] / 4095.0
        )));
    }
    let of_node = |frame: &Frame| answer(node, ranges, frame);
    talk.answer(&leave(node), of_node)?;
    talk.is_alone(of_node)?;
    if ranges.family == MitFamily::Damiao {
        registers(&mut talk, motor, LATER * machine.watchdog())?;
        talk.send(&[clear(node)])?;
        talk.pass(talk.period);
        let now = talk.link.now();
        while talk.next(now, of_node)?.is_some() {}
    }
    let Answer { readings, power, fault } = talk.answer(&leave(node), of_node)?;
    if let Some(code) = fault {
        return Err(device.wrong(format!("{}: expected a motor without errors", fault_name(code))));
    }
    if power == Some(true) {
        return Err(device.wrong("has power after it was told to leave"));
    }
    let most = TRAVEL * ranges.position;
    if readings.position.abs() > most {
        return Err(device.wrong(format!(
            "its position is {:.2} rad: expected one in {most:.2} rad around its zero, beyond which it cannot \
            be told where to go",
            readings.position
        )));
    }
    Ok(Box::new(MitSlot::new(device, motor, machine.muscles[device.drive.muscle].drive)))
}

/// Compares mode and ranges of a DAMIAO, and sets the time, s, after which it loses its power by itself.
fn registers<L: Link>(talk: &mut Talk<'_, L>, motor: &MitMotor, time: f64) -> Result<(), CanError> {
    let mode = register(talk, MODE)?;
    if mode != 1 {
        return Err(talk.device.wrong(format!("control mode {mode}: expected 1, MIT")));
    }
    let ranges = &motor.ranges;
    for ((number, name), expected) in
        RANGES.into_iter().zip([ranges.position, ranges.velocity, ranges.torque])
    {
        let range = f64::from(f32::from_bits(register(talk, number)?));
        let near = (1.0 - ROUNDING)..=(1.0 + ROUNDING);
        if !near.contains(&(range / expected)) {
            let model = &motor.model;
            return Err(talk.device.wrong(format!("{name} {range}: expected {expected}, that of {model}")));
        }
    }
    let units = (time / TIMEOUT_UNIT).round() as u32;
    let [a, b, c, d] = units.to_le_bytes();
    let node = talk.device.node;
    talk.send(&[Frame::new(0x7ff, &[node, 0, 0x55, TIMEOUT, a, b, c, d])])?;
    match register(talk, TIMEOUT)? {
        taken if taken == units => Ok(()),
        other => Err(talk.device.wrong(format!("TIMEOUT {other}: expected it to take {units}"))),
    }
}

/// What a register of a DAMIAO holds.
fn register<L: Link>(talk: &mut Talk<'_, L>, number: u8) -> Result<u32, CanError> {
    let node = talk.device.node;
    talk.answer(&Frame::new(0x7ff, &[node, 0, 0x33, number, 0, 0, 0, 0]), |frame| match *frame.octets() {
        [of, 0, 0x33, register, a, b, c, d] if (of, register) == (node, number) => {
            Some(u32::from_le_bytes([a, b, c, d]))
        }
        _ => None,
    })
}

/// Power at velocity 0 for all, then silence: our watchdog takes their power, which shows in answers that
/// nobody here has asked for, and in the state of those that show one.
pub(in crate::can) fn prove_watchdog<L: Link>(
    link: &mut L,
    devices: &[CanDevice],
    machine: &Machine,
) -> Result<(), CanError> {
    let Some(device) = devices.first() else { return Err(CanError::OtherBus) };
    let guard = |source| CanError::Port { port: "the watchdog beside this program".to_owned(), source };
    let (time, period) = (machine.watchdog(), machine.period_ns());
    let leaves: Vec<Frame> = devices.iter().map(|device| leave(device.node)).collect();
    link.guard(&leaves, (1e9 * time) as u64).map_err(guard)?;
    let mut talk = Talk { link, device, period };
    let mut powers = vec![None; devices.len()];
    for _ in 0..ENTERING {
        talk.link.sign(Sign::Trial).map_err(guard)?;
        for device in devices {
            let MitMotor { ranges, damping, .. } = device.motor()?;
            let still = MitCommand { damping: *damping, ..MitCommand::default() };
            talk.send(&[Frame::new(u16::from(device.node), &ranges.command(&still)), enter(device.node)])?;
        }
        talk.pass(period);
        hear(&mut talk, devices, &mut powers)?;
    }
    // What comes until here was asked for here, by an adapter that takes its time.
    let silence = |part: f64| (part * 1e9 * time) as u64;
    talk.pass(silence(EARLY).saturating_sub(period));
    hear(&mut talk, devices, &mut powers)?;
    let mut after = vec![None; devices.len()];
    talk.pass(silence(SILENCE - EARLY));
    hear(&mut talk, devices, &mut after)?;
    talk.link.sign(Sign::Rest).map_err(guard)?;
    talk.send(&leaves)?;
    for ((device, power), after) in devices.iter().zip(powers).zip(after) {
        let silence = SILENCE * time;
        let problem = match (power, after) {
            (None, _) => "does not answer when it is told to follow".to_owned(),
            (Some(Some(false)), _) => "has no power after it was told to follow".to_owned(),
            (_, None) => {
                format!(
                    "the watchdog beside this program has not told it to leave {silence:.3} s after the last \
                    sign of life"
                )
            }
            (_, Some(Some(true))) => {
                format!("keeps its power for {silence:.3} s though it was told to leave")
            }
            _ => continue,
        };
        return Err(device.wrong(problem));
    }
    Ok(())
}

/// What every motor that has answered shows last of its power.
fn hear<L: Link>(
    talk: &mut Talk<'_, L>,
    devices: &[CanDevice],
    powers: &mut [Option<Option<bool>>],
) -> Result<(), CanError> {
    let now = talk.link.now();
    let see = |frame: &Frame| {
        let of = |device: &CanDevice| answer(device.node, &device.mit.as_ref()?.ranges, frame);
        devices.iter().enumerate().find_map(|(k, device)| Some((k, frame.id(), of(device)?)))
    };
    while let Some((k, id, Answer { power, .. })) = talk.next(now, see)? {
        let told = |(j, other): (usize, &CanDevice)| j != k && u16::from(other.node) == id;
        if devices.iter().enumerate().any(told) {
            return Err(
                devices[k].wrong(format!("answers under id {id}, where another motor is told what to do"))
            );
        }
        powers[k] = Some(power);
    }
    Ok(())
}
