//! The registers of the clock: what they show, and what happens when they are written.
//!
//! Source: ETG.1000.4, table 60 and 61.

use super::clock::Clock;
use super::register::{self, touches};
use crate::bytes::{put, u32_at, u64_at};
use core::ops::Range;

/// Cyclic operation and SYNC0.
const CYCLIC_SYNC0: u8 = 0x03;
/// Activation status: a pulse is to come; the start lies in the past.
const PENDING: u8 = 0x01;
const NOT_PLAUSIBLE: u8 = 0x04;

/// Brings the registers up to date. `port_delays`: the present frame comes to ports 0 and 1 this much later,
/// ns.
pub(super) fn show(clock: &Clock, memory: &mut [u8], port_delays: [u64; 2]) {
    let system = clock.system().wrapping_add(port_delays[0]);
    put(memory, usize::from(register::SYSTEM_TIME), &system.to_le_bytes());
    put(memory, usize::from(register::TIME_DIFFERENCE), &clock.difference().to_le_bytes());
    if let Some(next) = clock.next_sync0() {
        put(memory, usize::from(register::SYNC_START), &next.to_le_bytes());
    }
}

/// The master has written `source` to the addresses `range`; the registers already hold it. `sync`: there is
/// a SYNC unit.
pub(super) fn written(
    clock: &mut Clock,
    memory: &mut [u8],
    range: &Range<usize>,
    source: &[u8],
    port_delays: [u64; 2],
    sync: bool,
) {
    if touches(range, register::PORT_TIMES, 4) {
        latch(clock, memory, port_delays);
    }
    if touches(range, register::TIME_OFFSET, 12) {
        clock.offset = u64_at(memory, usize::from(register::TIME_OFFSET));
        clock.delay = u32_at(memory, usize::from(register::TIME_DELAY));
    }
    if touches(range, register::SPEED_COUNTER, 2) {
        clock.reset_control();
    }
    let time = usize::from(register::SYSTEM_TIME);
    if range.start <= time && range.end >= time + 4 {
        let wide = range.end >= time + 8;
        let from = source.get(time - range.start..).unwrap_or_default();
        let received = if wide { u64_at(from, 0) } else { u64::from(u32_at(from, 0)) };
        clock.follow(received, wide, memory[usize::from(register::FILTER_DEPTH)], port_delays[0]);
    }
    if sync && touches(range, register::SYNC_ACTIVATION, 1) {
        let on = memory[usize::from(register::SYNC_ACTIVATION)] & CYCLIC_SYNC0 == CYCLIC_SYNC0;
        let start = u64_at(memory, usize::from(register::SYNC_START));
        let plausible = clock.activate(on, start, u32_at(memory, usize::from(register::SYNC0_CYCLE)));
        memory[usize::from(register::SYNC_ACTIVATION_STATUS)] = match (on, plausible) {
            (true, true) => PENDING,
            (_, true) => 0,
            (_, false) => NOT_PLAUSIBLE,
        };
    }
}

/// A write to the first receive time latches all of them.
fn latch(clock: &Clock, memory: &mut [u8], port_delays: [u64; 2]) {
    let [port0, port1] = port_delays.map(|delay| clock.local().wrapping_add(delay));
    let times = usize::from(register::PORT_TIMES);
    put(memory, times, &(port0 as u32).to_le_bytes());
    put(memory, times + 4, &(port1 as u32).to_le_bytes());
    put(memory, times + 8, &[0; 8]);
    put(memory, usize::from(register::UNIT_TIME), &port0.to_le_bytes());
}
