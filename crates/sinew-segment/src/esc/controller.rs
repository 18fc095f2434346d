//! The slave controller as the master sees it: an address space with side effects.
//!
//! Source: ETG.1000.4, clause 6.

use super::clock::{Clock, SyncPulses};
use super::clock_registers;
use super::eeprom::{Eeprom, Outcome};
use super::fmmu::Fmmu;
use super::register::{self, MEMORY, READ, WRITE, touches};
use super::sync_manager::SyncManager;
use super::watchdog::Watchdog;
use crate::bytes::{put, u16_at, u32_at};
use crate::sii;
use core::ops::Range;

/// Type of the controller, revision, build.
const TYPE: [u8; 4] = [0x11, 0x00, 0x02, 0x00];
/// Ports 0 and 1 are MII, ports 2 and 3 are not there.
const PORTS: u8 = 0x0f;
/// Local clock, 64 bits, enhanced link detection, separate handling of checksum errors, enhanced SYNC
/// activation.
const CLOCK: u8 = 0x04;
const WIDE_CLOCK: u8 = 0x08;
const SEPARATE_CHECKSUM_ERRORS: u8 = 0x80;
const ENHANCED_SYNC: u8 = 0x01;
/// Interrupts in the registers of events.
const AL_CONTROL_EVENT: u32 = 0x01;
const DL_STATUS_EVENT: u16 = 0x04;
const AL_STATUS_EVENT: u16 = 0x08;

/// What a controller is equipped with.
#[derive(Debug, Clone, Copy)]
pub(crate) struct Hardware {
    pub(crate) memory: u16,
    pub(crate) fmmus: usize,
    pub(crate) sync_managers: usize,
    pub(crate) clock: Option<HardwareClock>,
    pub(crate) eeprom_ns: u64,
}

/// The clock of a controller.
#[derive(Debug, Clone, Copy)]
pub(crate) struct HardwareClock {
    pub(crate) sync: bool,
    pub(crate) wide: bool,
    pub(crate) start_ns: u64,
    pub(crate) drift_ppb: i32,
}

/// Registers, memory and the units behind them.
#[derive(Debug, Clone)]
pub(crate) struct Controller {
    pub(super) memory: Vec<u8>,
    rights: Vec<u8>,
    pub(super) managers: Vec<SyncManager>,
    pub(super) fmmus: Vec<Option<Fmmu>>,
    pub(super) used_fmmus: usize,
    /// Octets of a datagram before they are replaced by what is read.
    pub(super) scratch: Vec<u8>,
    eeprom: Eeprom,
    clock: Option<Clock>,
    watchdog: Watchdog,
    now: u64,
    /// Arrival of the present frame at ports 0 and 1, relative to `now`.
    port_delays: [u64; 2],
    requested: bool,
    events: u16,
}

impl Controller {
    pub(crate) fn new(hardware: Hardware, image: Vec<u8>) -> Self {
        let Hardware { fmmus, sync_managers, clock, .. } = hardware;
        let sync = clock.is_some_and(|clock| clock.sync);
        let mut controller = Self {
            memory: vec![0; MEMORY + usize::from(hardware.memory)],
            rights: register::rights(fmmus, sync_managers, clock.is_some(), sync),
            managers: vec![SyncManager::default(); sync_managers],
            fmmus: vec![None; fmmus],
            used_fmmus: 0,
            scratch: vec![0; 0x800],
            eeprom: Eeprom::new(image, hardware.eeprom_ns),
            clock: clock.map(|clock| Clock::new(clock.start_ns, clock.drift_ppb)),
            watchdog: Watchdog::default(),
            now: 0,
            port_delays: [0; 2],
            requested: false,
            events: 0,
        };
        controller.set(0, &TYPE);
        let features = match clock {
            Some(clock) => CLOCK | if clock.wide { WIDE_CLOCK } else { 0 },
            None => 0,
        };
        let kilobytes = (hardware.memory / 1024).min(60) as u8;
        let first = features | SEPARATE_CHECKSUM_ERRORS;
        let second = if sync { ENHANCED_SYNC } else { 0 };
        controller.set(4, &[fmmus as u8, sync_managers as u8, kilobytes, PORTS, first, second]);
        controller.set(0x0100, &[1, 0, 7, 0]);
        controller.set(register::WATCHDOG_DIVIDER, &2498_u16.to_le_bytes());
        controller.set(register::WATCHDOG_PDI, &1000_u16.to_le_bytes());
        controller.set(register::WATCHDOG_DATA, &1000_u16.to_le_bytes());
        controller.set(register::WATCHDOG_STATUS, &[1]);
        controller.set(register::AL_STATUS, &[1]);
        controller.set(register::SPEED_COUNTER, &0x1000_u16.to_le_bytes());
        controller.set(register::FILTER_DEPTH, &[4, 12]);
        controller.load_configuration();
        controller.set_links(true, false);
        controller
    }

    /// Power comes back: the EEPROM has kept its content and virtual time has gone on.
    pub(crate) fn restart(&mut self, eeprom: &[u8], now: u64) {
        self.now = now;
        let image = self.eeprom.image_mut();
        let kept = image.len().min(eeprom.len());
        image[..kept].copy_from_slice(&eeprom[..kept]);
        self.load_configuration();
    }

    /// What the EEPROM configures: interface, pulse length, alias.
    fn load_configuration(&mut self) {
        let head: [u8; 16] = core::array::from_fn(|at| self.eeprom.image().get(at).copied().unwrap_or(0xff));
        let wrong = sii::checksum(&head[..14]) != head[14];
        self.eeprom.set_checksum_error(wrong);
        if !wrong {
            self.set(register::PDI_CONTROL, &head[..2]);
            self.set(register::PDI_CONFIGURATION, &[head[2], head[3], head[6], head[7]]);
            self.set(0x0982, &head[4..6]);
            self.set(register::ALIAS, &head[8..10]);
        }
    }

    // What the firmware and the line do.

    /// Sets registers or memory without side effects.
    pub(crate) fn set(&mut self, address: u16, value: &[u8]) {
        put(&mut self.memory, usize::from(address), value);
    }

    pub(crate) fn word(&self, address: u16) -> u16 {
        u16_at(&self.memory, usize::from(address))
    }

    pub(crate) fn double(&self, address: u16) -> u32 {
        u32_at(&self.memory, usize::from(address))
    }

    pub(crate) fn now(&self) -> u64 {
        self.now
    }

    pub(crate) fn clock(&self) -> Option<&Clock> {
        self.clock.as_ref()
    }

    pub(crate) fn eeprom(&mut self) -> &mut Eeprom {
        &mut self.eeprom
    }

    pub(crate) fn managers(&self) -> &[SyncManager] {
        &self.managers
    }

    pub(crate) fn manager(&mut self, channel: usize) -> Option<&mut SyncManager> {
        self.managers.get_mut(channel)
    }

    pub(crate) fn watchdog_expired(&self) -> bool {
        self.watchdog.expired
    }

    /// Time of the process-data watchdog; 0 is none.
    pub(crate) fn watchdog_ns(&self) -> u64 {
        Watchdog::limit_ns(self.word(register::WATCHDOG_DIVIDER), self.word(register::WATCHDOG_DATA))
    }

    /// Forgets earlier outputs.
    pub(crate) fn reset_watchdog(&mut self) {
        self.watchdog = Watchdog::default();
        self.set(register::WATCHDOG_STATUS, &[1]);
    }

    /// A state that the master has requested since the last call.
    pub(crate) fn take_request(&mut self) -> Option<u16> {
        core::mem::take(&mut self.requested).then(|| self.word(register::AL_CONTROL))
    }

    /// Shows state, error flag and code to the master.
    pub(crate) fn set_al_status(&mut self, status: u16, code: u16) {
        self.set(register::AL_STATUS, &status.to_le_bytes());
        self.set(register::AL_STATUS_CODE, &code.to_le_bytes());
        self.events |= AL_STATUS_EVENT;
    }

    /// Whether there is a neighbour at ports 0 and 1.
    pub(crate) fn set_links(&mut self, before: bool, behind: bool) {
        // Interface and its watchdog run; ports 2 and 3 are closed.
        let mut status: u16 = 0x5003;
        for (port, linked) in [before, behind].into_iter().enumerate() {
            status |= if linked { 1 << (4 + port) | 2 << (8 + 2 * port) } else { 1 << (8 + 2 * port) };
        }
        let old = self.word(register::DL_STATUS);
        for port in 0..2 {
            if old & !status & 1 << (4 + port) != 0 {
                self.count_error(register::LOST_LINK + port);
            }
        }
        if old != status {
            self.set(register::DL_STATUS, &status.to_le_bytes());
            self.events |= DL_STATUS_EVENT;
        }
    }

    /// The master has closed port 1.
    pub(crate) fn closes_line(&self) -> bool {
        self.memory[usize::from(register::LOOP_CONTROL)] >> 2 & 3 == 3
    }

    /// Counts an error in an eight-bit counter that stops at its end.
    pub(crate) fn count_error(&mut self, counter: u16) {
        let at = usize::from(counter);
        self.memory[at] = self.memory[at].saturating_add(1);
    }

    pub(crate) fn advance(&mut self, nanoseconds: u64) -> SyncPulses {
        self.now += nanoseconds;
        let limit = self.watchdog_ns();
        if self.watchdog.check(self.now, limit) {
            self.set(register::WATCHDOG_STATUS, &[0]);
            self.count_error(register::WATCHDOG_COUNTER);
        }
        self.clock.as_mut().map(|clock| clock.advance(nanoseconds)).unwrap_or_default()
    }

    /// A frame arrives now, after these delays at port 0 and back at port 1.
    pub(crate) fn frame(&mut self, port0: u64, port1: u64) {
        self.port_delays = [port0, port1];
    }

    // What the master does.

    pub(crate) fn station(&self) -> u16 {
        self.word(register::STATION)
    }

    /// Whether the device answers to an address: its own, or its alias where that is switched on.
    pub(crate) fn answers_to(&self, address: u16) -> bool {
        let alias = self.memory[usize::from(register::ALIAS_ENABLE)] & 1 != 0;
        address == self.station() || (alias && address == self.word(register::ALIAS))
    }

    /// Events that the master has asked to see in every datagram.
    pub(crate) fn events(&self) -> u16 {
        self.all_events() & self.word(register::ECAT_EVENT_MASK)
    }

    fn all_events(&self) -> u16 {
        let offered = self.managers.iter().take(8).enumerate();
        offered.fold(self.events, |events, (at, manager)| events | u16::from(manager.offered) << (4 + at))
    }

    /// Reads into `data`; what cannot be read is left as it is. False where nothing can be read.
    pub(crate) fn read(&mut self, address: u16, data: &mut [u8]) -> bool {
        if usize::from(address) < MEMORY {
            self.refresh(usize::from(address)..usize::from(address) + data.len());
        }
        let mut any = false;
        let mut at = 0;
        while at < data.len() {
            let (length, channel) = self.run(u32::from(address) + at as u32, data.len() - at);
            let place = usize::from(address) + at;
            let target = &mut data[at..at + length];
            any |= match channel {
                Some((channel, offset)) => self.managers[channel].master_read(offset, target),
                None => self.read_plain(place, target),
            };
            at += length;
        }
        if any && usize::from(address) < MEMORY {
            self.was_read(usize::from(address)..usize::from(address) + data.len());
        }
        any
    }

    fn read_plain(&self, place: usize, target: &mut [u8]) -> bool {
        if place >= MEMORY {
            let available = self.memory.len().saturating_sub(place).min(target.len());
            target[..available]
                .copy_from_slice(self.memory.get(place..place + available).unwrap_or_default());
            return available > 0;
        }
        let mut any = false;
        for (offset, octet) in target.iter_mut().enumerate() {
            if self.rights[place + offset] & READ != 0 {
                *octet = self.memory[place + offset];
                any = true;
            } else {
                *octet = 0;
            }
        }
        any
    }

    /// Writes; false where nothing can be written.
    pub(crate) fn write(&mut self, address: u16, data: &[u8]) -> bool {
        let mut any = false;
        let mut at = 0;
        while at < data.len() {
            let (length, channel) = self.run(u32::from(address) + at as u32, data.len() - at);
            let place = usize::from(address) + at;
            let source = &data[at..at + length];
            any |= match channel {
                Some((channel, offset)) => self.write_managed(channel, offset, source),
                None => self.write_plain(place, source),
            };
            at += length;
        }
        any
    }

    /// How many octets from `address` are treated alike, and the sync manager that covers them.
    fn run(&self, address: u32, most: usize) -> (usize, Option<(usize, usize)>) {
        if (address as usize) < MEMORY {
            return (most.min(MEMORY - address as usize), None);
        }
        let mut length = most;
        for (channel, manager) in self.managers.iter().enumerate().filter(|(_, manager)| manager.enabled) {
            if let Some(offset) = manager.covers(address) {
                return (length.min(usize::from(manager.length) - offset), Some((channel, offset)));
            }
            let start = u32::from(manager.start);
            if start > address {
                length = length.min((start - address) as usize);
            }
        }
        (length, None)
    }

    fn write_managed(&mut self, channel: usize, offset: usize, source: &[u8]) -> bool {
        let manager = &mut self.managers[channel];
        let written = manager.master_write(offset, source);
        if written
            && manager.arrived
            && manager.has_watchdog()
            && offset + source.len() == usize::from(manager.length)
        {
            self.watchdog.trigger(self.now);
            self.set(register::WATCHDOG_STATUS, &[1]);
        }
        written
    }

    fn write_plain(&mut self, place: usize, source: &[u8]) -> bool {
        if place >= MEMORY {
            let available = self.memory.len().saturating_sub(place).min(source.len());
            if let Some(target) = self.memory.get_mut(place..place + available) {
                target.copy_from_slice(&source[..available]);
            }
            return available > 0;
        }
        let mut any = false;
        for (offset, octet) in source.iter().enumerate() {
            if self.rights[place + offset] & WRITE != 0 && !self.is_locked(place + offset) {
                self.memory[place + offset] = *octet;
                any = true;
            }
        }
        if any {
            self.was_written(place..place + source.len(), source);
        }
        any
    }

    /// Registers that are not to be written now: the EEPROM while it is busy or belongs to the firmware, the
    /// settings of a sync manager that is switched on.
    fn is_locked(&self, place: usize) -> bool {
        let sync_manager = usize::from(register::SYNC_MANAGER);
        if (usize::from(register::EEPROM_CONTROL)..0x0510).contains(&place) {
            return self.memory[usize::from(register::EEPROM_OWNER)] & 1 != 0
                || self.eeprom.is_busy(self.now);
        }
        if (sync_manager..sync_manager + 0x80).contains(&place) && place % 8 < 6 {
            return self.managers[(place - sync_manager) / 8].enabled;
        }
        false
    }

    // Side effects.

    /// Registers that are computed when they are read.
    fn refresh(&mut self, range: Range<usize>) {
        if touches(&range, register::ECAT_EVENT, 2) {
            self.set(register::ECAT_EVENT, &self.all_events().to_le_bytes());
        }
        if touches(&range, register::AL_EVENT, 4) {
            let arrived = self.managers.iter().take(16).enumerate();
            let events = arrived
                .fold(u32::from(self.requested) * AL_CONTROL_EVENT, |events, (at, manager)| {
                    events | u32::from(manager.arrived) << (8 + at)
                });
            self.set(register::AL_EVENT, &events.to_le_bytes());
        }
        if touches(&range, register::EEPROM_CONTROL, 2) {
            self.set(register::EEPROM_CONTROL, &self.eeprom.status(self.now).to_le_bytes());
        }
        for channel in 0..self.managers.len() {
            let status = register::SYNC_MANAGER + register::SYNC_MANAGER_LENGTH * channel as u16 + 5;
            if touches(&range, status, 1) {
                self.set(status, &[self.managers[channel].status()]);
            }
        }
        if range.start < 0x09b0
            && range.end > usize::from(register::PORT_TIMES)
            && let Some(clock) = &self.clock
        {
            clock_registers::show(clock, &mut self.memory, self.port_delays);
        }
    }

    /// What reading clears.
    fn was_read(&mut self, range: Range<usize>) {
        if touches(&range, register::AL_STATUS, 2) {
            self.events &= !AL_STATUS_EVENT;
        }
        if touches(&range, register::DL_STATUS, 2) {
            self.events &= !DL_STATUS_EVENT;
        }
    }

    fn was_written(&mut self, range: Range<usize>, source: &[u8]) {
        if touches(&range, register::AL_CONTROL, 2) {
            self.requested = true;
        }
        for (counters, length) in
            [(register::RX_ERRORS, 14), (register::LOST_LINK, 4), (register::WATCHDOG_COUNTER, 2)]
        {
            // Writing any value clears the whole group.
            if touches(&range, counters, length) {
                self.memory[usize::from(counters)..usize::from(counters + length)].fill(0);
            }
        }
        if touches(&range, register::EEPROM_CONTROL + 1, 1) {
            self.command_eeprom();
        }
        if range.start < 0x0700 && range.end > usize::from(register::FMMU) {
            self.configure_fmmus();
        }
        let managers = usize::from(register::SYNC_MANAGER);
        if range.start < 0x0880 && range.end > managers {
            for (channel, manager) in self.managers.iter_mut().enumerate() {
                let start = managers + 8 * channel;
                manager.configure(&self.memory[start..start + 8]);
            }
        }
        if range.start < 0x09b0 && range.end > usize::from(register::PORT_TIMES) {
            let sync = self.rights[usize::from(register::SYNC_ACTIVATION)] != 0;
            if let Some(clock) = &mut self.clock {
                clock_registers::written(clock, &mut self.memory, &range, source, self.port_delays, sync);
            }
        }
    }

    fn configure_fmmus(&mut self) {
        for (at, fmmu) in self.fmmus.iter_mut().enumerate() {
            let start = usize::from(register::FMMU) + 16 * at;
            *fmmu = Fmmu::parse(&self.memory[start..start + 16]);
        }
        self.used_fmmus = self.fmmus.iter().rposition(Option::is_some).map_or(0, |last| last + 1);
    }

    fn command_eeprom(&mut self) {
        let control = self.word(register::EEPROM_CONTROL);
        let (address, data) = (usize::from(register::EEPROM_ADDRESS), usize::from(register::EEPROM_DATA));
        let outcome = self.eeprom.command(
            control,
            &self.memory[address..address + 4],
            &self.memory[data..data + 2],
            self.now,
        );
        match outcome {
            Outcome::Nothing => {}
            Outcome::Data(found) => self.set(register::EEPROM_DATA, &found),
            Outcome::Reload => self.load_configuration(),
        }
    }
}
