//! What runs in a device behind its controller: objects, mailbox, process data, the drive, and the checks of
//! its settings.
//!
//! Source of the checks: ETG.1000.6, 6.4.1; ETG.1020.

use crate::al::{AlState, AlStatusCode, Surroundings, Transition};
use crate::description::{
    ClockDescription, DeviceDescription, Profile, SyncManagerDescription, SyncManagerKind,
};
use crate::dictionary::{Dictionary, Slot};
use crate::drive::Drive;
use crate::esc::{Controller, Hardware, HardwareClock, register};
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

/// All of a device but its state machine.
#[derive(Debug, Clone)]
pub(crate) struct Firmware {
    pub(crate) controller: Controller,
    pub(crate) dictionary: Dictionary,
    pub(crate) mailbox: Option<Mailbox>,
    managers: Vec<SyncManagerDescription>,
    clock: Option<ClockDescription>,
    outputs: ProcessData,
    inputs: ProcessData,
    pub(crate) drive: Option<Drive>,
    pub(crate) channels: Vec<Option<Slot>>,
    seen_outputs: bool,
    /// OP was entered with SYNC0.
    synchronized: bool,
}

impl Firmware {
    /// The firmware of a description that was checked.
    pub(crate) fn new(description: &DeviceDescription, settings: &DeviceSettings, serial: u32) -> Self {
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
        Self {
            controller: Controller::new(hardware, image),
            mailbox,
            managers: description.sync_managers.clone(),
            clock: description.clock,
            outputs: ProcessData::default(),
            inputs: ProcessData::default(),
            drive: (description.profile == Profile::Drive).then(|| Drive::new(&dictionary)),
            channels: channels.collect(),
            seen_outputs: false,
            synchronized: false,
            dictionary,
        }
    }

    pub(crate) fn show(&mut self, transition: Transition) {
        self.controller.set_al_status(transition.status, transition.code);
    }

    pub(crate) fn outputs_arrived(&self) -> bool {
        let managers = self.controller.managers();
        channel(&self.managers, SyncManagerKind::Outputs).is_some_and(|at| managers[at].arrived)
    }

    /// Outputs wait for SYNC0.
    pub(crate) fn is_synchronized(&self) -> bool {
        self.controller.clock().is_some_and(|clock| clock.next_sync0().is_some())
    }

    /// From the sync manager to the objects; in SAFE-OP outputs are seen and not used.
    pub(crate) fn take_outputs(&mut self, state: AlState) {
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
    pub(crate) fn run(&mut self, state: AlState, nanoseconds: u64) {
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
    pub(crate) fn failure(&self, state: AlState) -> Option<(AlState, AlStatusCode)> {
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
