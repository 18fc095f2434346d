//! A chain of simulated servos on one line, in virtual time.

use super::servo::{DATA_LENGTH, INSTRUCTION_ERROR, SimulatedServo};
use crate::servos::protocol::instruction::{
    FAST_SYNC_READ, PING, READ, REBOOT, STATUS, SYNC_READ, SYNC_WRITE, WRITE,
};
use crate::servos::protocol::{BROADCAST, Decoder, Protocol, encode_fast_block, encode_fast_head};
use crate::servos::series::Series;

/// Servos on a line that all speak one protocol, whose answers come after the times that their octets take.
#[derive(Debug, Clone)]
pub struct SimulatedChain {
    decoder: Decoder,
    line: Line,
}

#[derive(Debug, Clone)]
struct Line {
    protocol: Protocol,
    servos: Vec<SimulatedServo>,
    /// Rate, bit/s; none: every servo hears everything at once, as on a pseudo-terminal.
    baud: Option<u32>,
    /// Octets that come back, where the answers in them end, and when these are complete, ns.
    answer: Vec<u8>,
    due: Vec<(usize, u64)>,
    /// When the line is free, ns.
    free: u64,
    data: Vec<u8>,
}

/// Octets under way, at most; more are lost.
const CAPACITY: usize = 1 << 14;
/// Bits of an octet on the line.
const BITS: u64 = 10;
/// Pause before an answer of its own, ns.
const GAP: u64 = 20_000;

impl SimulatedChain {
    /// A chain on a line of a rate, bit/s; none: every servo hears everything at once, as on a
    /// pseudo-terminal.
    #[must_use]
    pub fn new(servos: Vec<SimulatedServo>, baud: Option<u32>) -> Self {
        let (answer, due) = (Vec::with_capacity(2 * CAPACITY), Vec::with_capacity(CAPACITY / 8));
        let data = Vec::with_capacity(2048);
        let series = servos.first().map_or(Series::X, |servo| servo.model().series);
        let protocol = series.protocol();
        let line = Line { protocol, servos, baud, answer, due, free: 0, data };
        Self { decoder: Decoder::new(protocol, false), line }
    }

    /// Its servos.
    #[must_use]
    pub fn servos(&self) -> &[SimulatedServo] {
        &self.line.servos
    }

    /// Its servos, to let them fail.
    pub fn servos_mut(&mut self) -> &mut [SimulatedServo] {
        &mut self.line.servos
    }

    /// Time passes: servos that hear nothing stop.
    pub fn watch(&mut self, now: u64) {
        self.line.servos.iter_mut().for_each(|servo| servo.watch(now));
    }

    /// Takes over what a master sends at a time, ns.
    pub fn process(&mut self, octets: &[u8], now: u64) {
        self.watch(now);
        let Self { decoder, line } = self;
        line.free = line.free.max(now) + line.time(octets.len());
        decoder.feed(octets);
        while let Some(packet) = decoder.next(None) {
            if packet.instruction != STATUS {
                line.carry_out(packet.id, packet.instruction, packet.data, now);
            }
        }
    }

    /// When the next answer is complete, ns.
    #[must_use]
    pub fn next_due(&self) -> Option<u64> {
        self.line.due.first().map(|(_, at)| *at)
    }

    /// The octets that have come back at a time, ns: how many are now in `buffer`.
    pub fn take(&mut self, buffer: &mut [u8], now: u64) -> usize {
        let Line { answer, due, .. } = &mut self.line;
        let ready = due.iter().take_while(|(_, at)| *at <= now).last().map_or(0, |(end, _)| *end);
        let count = ready.min(buffer.len());
        buffer[..count].copy_from_slice(&answer[..count]);
        answer.drain(..count);
        due.retain_mut(|(end, _)| {
            *end = end.saturating_sub(count);
            *end > 0
        });
        count
    }
}

impl Line {
    fn time(&self, octets: usize) -> u64 {
        self.baud.map_or(0, |baud| octets as u64 * BITS * 1_000_000_000 / u64::from(baud))
    }

    fn carry_out(&mut self, id: u8, instruction: u8, parameters: &[u8], now: u64) {
        let baud = self.baud;
        for servo in &mut self.servos {
            servo.hears(now, baud);
        }
        let (dynamixel, width) = (self.protocol == Protocol::Dynamixel, self.protocol.width());
        let place = |k: usize| {
            let octets = parameters.get(k * width..(k + 1) * width)?;
            Some(octets.iter().rev().fold(0_u16, |place, octet| place << 8 | u16::from(*octet)))
        };
        let (one, rest) = (id != BROADCAST, parameters.get(2 * width..).unwrap_or_default());
        match (instruction, place(0), place(1)) {
            (SYNC_READ, Some(address), Some(length)) => {
                for id in rest {
                    self.of_id(*id, now, true, |servo, data| servo.read(address, length, data));
                }
            }
            (FAST_SYNC_READ, Some(address), Some(length)) if dynamixel => {
                self.fast(rest, address, length, now);
            }
            (SYNC_WRITE, Some(address), Some(length)) => {
                for part in rest.chunks_exact(1 + usize::from(length)) {
                    self.of_id(part[0], now, false, |servo, _| servo.write(address, &part[1..]));
                }
            }
            (PING, ..) => {
                self.of_id(id, now, true, |servo, data| match dynamixel {
                    true => servo.read(0, 2, data) | servo.read(6, 1, data),
                    false => 0,
                });
            }
            (READ, Some(address), Some(length)) if one => {
                self.of_id(id, now, true, |servo, data| servo.read(address, length, data));
            }
            (WRITE, Some(address), _) => {
                self.of_id(id, now, one, |servo, _| servo.write(address, &parameters[width..]));
            }
            (REBOOT, ..) if dynamixel => self.of_id(id, now, one, |servo, _| {
                servo.reset();
                0
            }),
            (READ | WRITE, ..) => self.of_id(id, now, one, |_, _| DATA_LENGTH),
            _ => self.of_id(id, now, one, |_, _| INSTRUCTION_ERROR),
        }
    }

    /// Lets the servos of an identifier do something and answer where they are to: answers of several servos
    /// with one identifier destroy each other.
    fn of_id(
        &mut self,
        id: u8,
        now: u64,
        answered: bool,
        mut act: impl FnMut(&mut SimulatedServo, &mut Vec<u8>) -> u8,
    ) {
        let baud = self.baud;
        // All Feetechs answer a ping to all at the same time.
        let all = id == BROADCAST && self.protocol == Protocol::Feetech;
        let of_id = self.servos.iter_mut().filter(|servo| servo.id() == id || all);
        let collide = of_id.filter_map(|servo| servo.hears(now, baud).then_some(())).count() > 1;
        for k in 0..self.servos.len() {
            let servo = &mut self.servos[k];
            if (servo.id() != id && id != BROADCAST) || !servo.hears(now, baud) {
                continue;
            }
            self.data.clear();
            let number = act(servo, &mut self.data);
            if answered {
                let (start, error) = (self.answer.len(), servo.error(number));
                self.protocol.answer(&mut self.answer, servo.answers_as(), error, &self.data);
                self.finish(k, start, true, collide);
            }
        }
    }

    /// One packet with a block of each servo, which ends at the first that is silent.
    fn fast(&mut self, ids: &[u8], address: u16, length: u16, now: u64) {
        let (start, baud) = (self.answer.len(), self.baud);
        for (place, id) in ids.iter().enumerate() {
            let found = self.servos.iter_mut().position(|servo| servo.id() == *id && servo.hears(now, baud));
            let Some(k) = found else { return };
            self.data.clear();
            let (servo, from) = (&self.servos[k], self.answer.len());
            let number = servo.read(address, length, &mut self.data);
            if number != 0 {
                return;
            }
            if place == 0 {
                encode_fast_head(&mut self.answer, ids.len(), usize::from(length));
            }
            let of = (servo.answers_as(), servo.error(number));
            encode_fast_block(&mut self.answer, start, of, &self.data);
            self.finish(k, from, place == 0, false);
        }
    }

    /// The octets from `start` on are what a servo answers, `alone` with its delay.
    fn finish(&mut self, servo: usize, start: usize, alone: bool, collides: bool) {
        let servo = &mut self.servos[servo];
        if servo.damages() || collides {
            self.answer[start..].last_mut().into_iter().for_each(|octet| *octet ^= 0x10);
        }
        if self.answer.len() > CAPACITY {
            self.answer.truncate(start);
            return;
        }
        self.free += if alone { servo.return_delay() + self.baud.map_or(0, |_| GAP) } else { 0 };
        self.free += self.time(self.answer.len() - start);
        self.due.push((self.answer.len(), self.free));
    }
}
