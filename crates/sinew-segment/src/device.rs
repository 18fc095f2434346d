//! One device: controller, state machine, mailbox, objects and what it does with them.

use crate::al::{AlState, AlStatusCode, Machine};
use crate::answer::answer;
use crate::description::{DescriptionError, DeviceDescription, Identity};
use crate::drive::Drive;
use crate::esc::{Controller, SyncPulses};
use crate::firmware::Firmware;
use crate::frame::Datagram;
use crate::settings::DeviceSettings;

/// Limits of the settings.
const MAX_DRIFT_PPB: i32 = 1_000_000;

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

impl Device {
    /// A device in INIT.
    ///
    /// # Errors
    ///
    /// The first field of the description that contradicts itself, or a setting out of range.
    pub fn new(description: &DeviceDescription, settings: DeviceSettings) -> Result<Self, DescriptionError> {
        description.check()?;
        if settings.drift_ppb.abs() > MAX_DRIFT_PPB {
            let problem = format!("{} ppb, expected within +-{MAX_DRIFT_PPB}", settings.drift_ppb);
            return Err(description.error("settings.drift_ppb", problem));
        }
        let serial = settings.serial.unwrap_or(description.identity.serial);
        Ok(Self {
            name: description.name.clone(),
            identity: Identity { serial, ..description.identity },
            pulses: SyncPulses::default(),
            origin: Box::new((description.clone(), settings)),
            machine: Machine::new(settings.transition_ns, settings.identification),
            forward_delay_ns: u64::from(settings.forward_delay_ns),
            firmware: Firmware::new(description, &settings, serial),
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

    /// Sets the raw value of a channel, limited to its type; false where there is no such channel. The master
    /// sees it after the next [`Segment::advance`](crate::Segment::advance).
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

    /// Sends an emergency: error code, error register, five octets of the manufacturer. Lost without a
    /// mailbox.
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
        answer(&mut self.firmware.controller, datagram);
    }
}
