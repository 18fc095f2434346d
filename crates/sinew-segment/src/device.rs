//! One device: controller, state machine, mailbox, objects and what it does with them.

use crate::al::{AlState, AlStatusCode, Machine, Surroundings, Transition};
use crate::description::{
    ClockDescription, DescriptionError, DeviceDescription, Identity, Profile, SyncManagerDescription,
    SyncManagerKind,
};
use crate::dictionary::{Dictionary, Slot};
use crate::drive::Drive;
use crate::esc::{Controller, Hardware, HardwareClock, SyncPulses, register};
use crate::frame::{Command, Datagram, Transfer};
use crate::mailbox::Mailbox;
use crate::pdo::{ProcessData, channel};
use crate::settings::DeviceSettings;
use crate::sii;

/// Memory management units and sync managers of common controllers; a device uses those that it describes.
const UNITS: usize = 8;
/// Bits of the activation of SYNC0.
const CYCLIC: u8 = 1;
const SYNC0: u8 = 1 << 1;
/// Synchronisation types in objects 0x1C32 and 0x1C33.
const FREE_RUN: u64 = 0;
const WITH_EVENT: u64 = 1;
const WITH_SYNC0: u64 = 2;
const WITH_SYNC1: u64 = 3;
/// Limits of the settings.
const MOST_DRIFT_PPB: i32 = 1_000_000;
/// Working counter: a read counts one, a write one, both in one datagram three.
const READ: u16 = 1;
const WRITTEN: u16 = 1;
const WRITTEN_IN_EXCHANGE: u16 = 2;

/// A simulated EtherCAT device.
#[derive(Debug, Clone)]
pub struct Device {
    name: String,
    identity: Identity,
    machine: Machine,
    firmware: Firmware,
    pulses: SyncPulses,
    origin: Box<(DeviceDescription, DeviceSettings)>,
    pub(crate) forward_delay_ns: u64,
}

/// All that the state machine does not own.
#[derive(Debug, Clone)]
struct Firmware {
    controller: Controller,
    dictionary: Dictionary,
    mailbox: Option<Mailbox>,
    managers: Vec<SyncManagerDescription>,
    clock: Option<ClockDescription>,
    outputs: ProcessData,
    inputs: ProcessData,
    drive: Option<Drive>,
    channels: Vec<Option<Slot>>,
    seen_outputs: bool,
    /// OP was entered with SYNC0.
    synchronized: bool,
}

impl Device {
    /// A device in INIT.
    ///
    /// # Errors
    ///
    /// The first field of the description that contradicts itself, or a setting out of range.
    pub fn new(description: &DeviceDescription, settings: DeviceSettings) -> Result<Self, DescriptionError> {
        description.check()?;
        if settings.drift_ppb.abs() > MOST_DRIFT_PPB {
            let problem = format!("{} ppb, expected within +-{MOST_DRIFT_PPB}", settings.drift_ppb);
            return Err(description.error("settings.drift_ppb", problem));
        }
        let serial = settings.serial.unwrap_or(description.identity.serial);
        let hardware = Hardware {
            memory: description.memory,
            fmmus: description.fmmus.len().max(UNITS),
            sync_managers: description.sync_managers.len().max(UNITS),
            clock: description.clock.map(|clock| HardwareClock {
                sync: clock.sync,
                wide: clock.wide,
                start_ns: settings.clock_at_start_ns,
                drift_ppb: settings.drift_ppb,
            }),
            eeprom_ns: settings.eeprom_ns,
        };
        let image = sii::image(description, settings.alias, serial);
        let dictionary = Dictionary::new(description, serial);
        let at = |kind| channel(&description.sync_managers, kind);
        let mailbox =
            match (description.mailbox, at(SyncManagerKind::MailboxOut), at(SyncManagerKind::MailboxIn)) {
                (Some(mailbox), Some(out), Some(back)) => {
                    Some(Mailbox::new(out, back, mailbox, settings.mailbox_ns))
                }
                _ => None,
            };
        let channels =
            description.channels.iter().map(|(index, subindex)| dictionary.slot(*index, *subindex));
        let channels = channels.collect();
        let drive = (description.profile == Profile::Drive).then(|| Drive::new(&dictionary));
        Ok(Self {
            name: description.name.clone(),
            identity: Identity { serial, ..description.identity },
            pulses: SyncPulses::default(),
            origin: Box::new((description.clone(), settings)),
            machine: Machine::new(settings.transition_ns, settings.identification),
            forward_delay_ns: u64::from(settings.forward_delay_ns),
            firmware: Firmware {
                controller: Controller::new(hardware, image),
                dictionary,
                mailbox,
                managers: description.sync_managers.clone(),
                clock: description.clock,
                outputs: ProcessData::default(),
                inputs: ProcessData::default(),
                drive,
                channels,
                seen_outputs: false,
                synchronized: false,
            },
        })
    }

    /// Short name.
    #[must_use]
    pub fn name(&self) -> &str {
        &self.name
    }

    /// Identity, with the serial number of the settings.
    #[must_use]
    pub fn identity(&self) -> Identity {
        self.identity
    }

    /// State of the application layer.
    #[must_use]
    pub fn state(&self) -> AlState {
        self.machine.state()
    }

    /// Why the device refused or left a state.
    #[must_use]
    pub fn status_code(&self) -> AlStatusCode {
        self.machine.code()
    }

    /// The drive in the device, where it is one.
    #[must_use]
    pub fn drive(&self) -> Option<&Drive> {
        self.firmware.drive.as_ref()
    }

    /// The drive in the device, where it is one.
    pub fn drive_mut(&mut self) -> Option<&mut Drive> {
        self.firmware.drive.as_mut()
    }

    /// Sets the raw value of a channel, limited to its type; false where there is no such channel. The master sees it
    /// after the next [`Segment::advance`](crate::Segment::advance).
    pub fn set_input(&mut self, channel: usize, raw: i64) -> bool {
        let Some(slot) = self.firmware.channels.get(channel).copied().flatten() else { return false };
        self.firmware.dictionary.set(Some(slot), raw);
        true
    }

    /// The present value of an object as on the wire.
    #[must_use]
    pub fn object(&self, index: u16, subindex: u8) -> Option<&[u8]> {
        let entry = self.firmware.dictionary.entry(index, subindex)?;
        Some(self.firmware.dictionary.value(entry))
    }

    /// Sets an object from inside of the device, whoever may write it on the wire; false where there is none.
    pub fn set_object(&mut self, index: u16, subindex: u8, value: &[u8]) -> bool {
        let known = self.firmware.dictionary.entry(index, subindex).is_some();
        self.firmware.dictionary.set_value(index, subindex, value);
        known
    }

    /// Content of the EEPROM.
    pub fn eeprom_mut(&mut self) -> &mut [u8] {
        self.firmware.controller.eeprom().image_mut()
    }

    /// Local and system time of the device's clock, ns.
    #[must_use]
    pub fn clock(&self) -> Option<(u64, u64)> {
        self.firmware.controller.clock().map(|clock| (clock.local(), clock.system()))
    }

    /// Sends an emergency: error code, error register, five octets of the manufacturer. Lost without a mailbox.
    pub fn send_emergency(&mut self, code: u16, error_register: u8, data: [u8; 5]) {
        if self.machine.state() != AlState::Init
            && let Some(mailbox) = &mut self.firmware.mailbox
        {
            mailbox.emergency(code, error_register, data);
        }
    }

    /// The device drops to SAFE-OP, or stays below, with an error.
    pub fn drop_to_safe_op(&mut self, code: AlStatusCode) {
        let transition = self.machine.fall(AlState::SafeOp, code, &mut self.firmware);
        self.firmware.show(transition);
    }

    /// The master has closed the port towards the next device.
    pub(crate) fn closes_line(&self) -> bool {
        self.firmware.controller.closes_line()
    }

    pub(crate) fn controller(&mut self) -> &mut Controller {
        &mut self.firmware.controller
    }

    /// Starts anew, in INIT; the EEPROM keeps its content.
    pub fn power_cycle(&mut self) {
        let eeprom = self.eeprom_mut().to_vec();
        let now = self.firmware.controller.now();
        // What made this device makes it again.
        if let Ok(anew) = Self::new(&self.origin.0, self.origin.1) {
            *self = anew;
        }
        self.firmware.controller.restart(&eeprom, now);
    }

    /// Clock and watchdog.
    pub(crate) fn pass_time(&mut self, nanoseconds: u64) {
        self.pulses = self.firmware.controller.advance(nanoseconds);
    }

    /// State machine, mailbox and application, after `pass_time`.
    pub(crate) fn run(&mut self, nanoseconds: u64) {
        let firmware = &mut self.firmware;
        let now = firmware.controller.now();
        if let Some(control) = firmware.controller.take_request() {
            self.machine.request(control, now);
        }
        if let Some(transition) = self.machine.advance(now, firmware) {
            firmware.show(transition);
        }
        if self.pulses.sync0 > 0 {
            firmware.take_outputs(self.machine.state());
        }
        if !self.machine.is_busy()
            && let Some((to, code)) = firmware.failure(self.machine.state())
        {
            let transition = self.machine.fall(to, code, firmware);
            firmware.show(transition);
        }
        firmware.run(self.machine.state(), nanoseconds);
    }

    /// A frame has passed: outputs that came with it are taken, unless they wait for SYNC0.
    pub(crate) fn after_frame(&mut self) {
        let state = self.machine.state();
        if self.firmware.outputs_arrived() && (state < AlState::Op || !self.firmware.is_synchronized()) {
            self.firmware.take_outputs(state);
            if let (AlState::Op, Some(drive)) = (state, &mut self.firmware.drive) {
                drive.step(&mut self.firmware.dictionary, 0);
            }
        }
    }

    /// Answers one datagram.
    pub(crate) fn answer(&mut self, datagram: &mut Datagram) {
        let controller = &mut self.firmware.controller;
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

impl Firmware {
    fn show(&mut self, transition: Transition) {
        self.controller.set_al_status(transition.status, transition.code);
    }

    fn outputs_arrived(&self) -> bool {
        let managers = self.controller.managers();
        channel(&self.managers, SyncManagerKind::Outputs).is_some_and(|at| managers[at].arrived)
    }

    /// Outputs wait for SYNC0.
    fn is_synchronized(&self) -> bool {
        self.controller.clock().is_some_and(|clock| clock.next_sync0().is_some())
    }

    /// From the sync manager to the objects; in SAFE-OP outputs are seen and not used.
    fn take_outputs(&mut self, state: AlState) {
        let Some(at) = channel(&self.managers, SyncManagerKind::Outputs) else { return };
        let Some(manager) = self.controller.manager(at).filter(|manager| manager.arrived) else { return };
        if manager.is_mailbox() || state < AlState::SafeOp {
            return;
        }
        let image = manager.take();
        self.seen_outputs = true;
        if state == AlState::Op {
            self.outputs.distribute(image, &mut self.dictionary);
        }
    }

    /// The application's cycle, the mailbox, and inputs for the master.
    fn run(&mut self, state: AlState, nanoseconds: u64) {
        if let Some(drive) = &mut self.drive {
            drive.step(&mut self.dictionary, nanoseconds);
            if let Some((code, register)) = drive.take_emergency()
                && state != AlState::Init
                && let Some(mailbox) = &mut self.mailbox
            {
                mailbox.emergency(code, register, [0; 5]);
            }
        }
        if state == AlState::Init {
            return;
        }
        if let Some(mailbox) = &mut self.mailbox {
            mailbox.advance(&mut self.controller, &mut self.dictionary, state);
        }
        if state >= AlState::SafeOp {
            self.offer_inputs();
        }
    }

    fn offer_inputs(&mut self) {
        let Some(at) = channel(&self.managers, SyncManagerKind::Inputs) else { return };
        let Some(manager) =
            self.controller.manager(at).filter(|manager| manager.enabled && !manager.is_mailbox())
        else {
            return;
        };
        self.inputs.collect(&self.dictionary, manager.buffer());
        manager.offer();
    }

    /// Why the sync manager of a kind does not fit.
    fn fits(&self, kind: SyncManagerKind, length: usize) -> bool {
        let Some(at) = channel(&self.managers, kind) else { return length == 0 };
        let (manager, described) = (&self.controller.managers()[at], self.managers[at]);
        let mailbox = matches!(kind, SyncManagerKind::MailboxOut | SyncManagerKind::MailboxIn);
        let writes = matches!(kind, SyncManagerKind::MailboxOut | SyncManagerKind::Outputs);
        if length == 0 {
            return !manager.enabled;
        }
        manager.enabled
            && manager.start == described.start
            && usize::from(manager.length) == length
            && manager.is_mailbox() == mailbox
            && manager.master_writes() == writes
    }

    /// Why a state cannot be kept, and where it leads.
    fn failure(&self, state: AlState) -> Option<(AlState, AlStatusCode)> {
        if state >= AlState::PreOp && !self.mailbox_fits() {
            return Some((AlState::Init, AlStatusCode::InvalidMailbox));
        }
        if state >= AlState::SafeOp && !self.fits(SyncManagerKind::Outputs, self.outputs.length()) {
            return Some((AlState::PreOp, AlStatusCode::InvalidOutputs));
        }
        if state >= AlState::SafeOp && !self.fits(SyncManagerKind::Inputs, self.inputs.length()) {
            return Some((AlState::PreOp, AlStatusCode::InvalidInputs));
        }
        let watched = channel(&self.managers, SyncManagerKind::Outputs)
            .is_some_and(|at| self.controller.managers()[at].has_watchdog());
        if state == AlState::Op && watched && self.controller.watchdog_expired() {
            return Some((AlState::SafeOp, AlStatusCode::Watchdog));
        }
        let lost = state == AlState::Op && self.synchronized && !self.is_synchronized();
        lost.then_some((AlState::SafeOp, AlStatusCode::FatalSync))
    }

    fn mailbox_fits(&self) -> bool {
        [SyncManagerKind::MailboxOut, SyncManagerKind::MailboxIn].into_iter().all(|kind| {
            let length = channel(&self.managers, kind).map_or(0, |at| usize::from(self.managers[at].length));
            self.mailbox.is_none() || self.fits(kind, length)
        })
    }

    /// Inputs and outputs as assigned, or what is wrong with their sync managers.
    fn process_data(&mut self) -> Option<AlStatusCode> {
        let assigned = |kind| {
            channel(&self.managers, kind)
                .map(|at| ProcessData::assigned(&self.dictionary, at))
                .unwrap_or_default()
        };
        let (outputs, inputs) = (assigned(SyncManagerKind::Outputs), assigned(SyncManagerKind::Inputs));
        if !self.fits(SyncManagerKind::Outputs, outputs.length()) {
            return Some(AlStatusCode::InvalidOutputs);
        }
        if !self.fits(SyncManagerKind::Inputs, inputs.length()) {
            return Some(AlStatusCode::InvalidInputs);
        }
        (self.outputs, self.inputs) = (outputs, inputs);
        None
    }

    /// The synchronisation type that the master has written, object 0x1C3n:1, against what is switched on.
    fn synchronization_type(&self) -> Option<AlStatusCode> {
        let at = channel(&self.managers, SyncManagerKind::Outputs)?;
        let number = self.dictionary.number(0x1c30 + at as u16, 1);
        let clock = self.clock.is_some_and(|clock| clock.sync);
        match number {
            FREE_RUN | WITH_EVENT => None,
            WITH_SYNC0 | WITH_SYNC1 if clock => {
                let active = self.controller.word(register::SYNC_ACTIVATION - 1) >> 8 & 1 != 0;
                (!active).then_some(AlStatusCode::InvalidSyncConfiguration)
            }
            _ => Some(AlStatusCode::SyncModeNotSupported),
        }
    }

    fn synchronization(&self) -> Option<AlStatusCode> {
        let clock = self.clock.filter(|clock| clock.sync)?;
        let activation = (self.controller.word(register::SYNC_ACTIVATION - 1) >> 8) as u8;
        if activation & CYCLIC == 0 {
            return None;
        }
        if activation & SYNC0 == 0 {
            return Some(AlStatusCode::InvalidSyncConfiguration);
        }
        let cycle = self.controller.double(register::SYNC0_CYCLE);
        if cycle < clock.min_cycle_ns.max(1) {
            return Some(AlStatusCode::InvalidSync0CycleTime);
        }
        let limit = self.controller.watchdog_ns();
        (limit > 0 && limit < u64::from(cycle)).then_some(AlStatusCode::InvalidWatchdog)
    }
}

impl Surroundings for Firmware {
    fn obstacle(&mut self, to: AlState) -> Option<AlStatusCode> {
        match to {
            AlState::Init => None,
            AlState::PreOp => (!self.mailbox_fits()).then_some(AlStatusCode::InvalidMailbox),
            AlState::SafeOp => {
                self.process_data().or_else(|| self.synchronization_type()).or_else(|| self.synchronization())
            }
            AlState::Op => {
                let sync = self.clock.is_some_and(|clock| clock.sync)
                    && self.controller.word(register::SYNC_ACTIVATION - 1) >> 8 & 1 != 0;
                (sync && !self.is_synchronized()).then_some(AlStatusCode::NoSync)
            }
        }
    }

    fn has_outputs(&self) -> bool {
        self.outputs.length() == 0 || self.seen_outputs
    }

    fn enter(&mut self, from: AlState, to: AlState) {
        if (to == AlState::Init || from == AlState::Init)
            && let Some(mailbox) = &mut self.mailbox
        {
            mailbox.reset();
        }
        if from == AlState::PreOp && to == AlState::SafeOp {
            self.seen_outputs = false;
            self.controller.reset_watchdog();
            self.offer_inputs();
        }
        if from == AlState::Op {
            self.seen_outputs = false;
            if let Some(drive) = &mut self.drive {
                drive.outputs_lost();
            }
        }
        if from == AlState::SafeOp && to == AlState::Op {
            self.synchronized = self.is_synchronized();
            self.controller.reset_watchdog();
        }
    }
}
