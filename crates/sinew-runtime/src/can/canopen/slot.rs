//! A node in operation: PDOs, heartbeat, emergencies.

use super::{
    EMERGENCY, HEARTBEAT, HEARTBEAT_MS, OPERATIONAL, PRE_OPERATIONAL, START, TO_MASTER, TO_NODE, manage,
};
use crate::can::slot::{Heard, Slot};
use crate::cia402::{DriveSlot, DriveState};
use sinew::drive::DriveCommand;
use sinew_segment::CanFrame as Frame;

/// Time without a heartbeat of a node after which it is lost, ns.
const HEARTBEAT_PATIENCE: u64 = 4 * HEARTBEAT_MS as u64 * 1_000_000;

/// A drive after CiA 402 in its PDOs.
#[derive(Debug)]
pub(super) struct CanopenSlot {
    node: u8,
    drive: DriveSlot,
    inputs: [u8; 8],
    /// Whether it has answered a SYNC.
    operational: bool,
    /// Code of its emergency; 0 is none.
    emergency: u16,
    cable: f64,
    fault: Option<u16>,
}

impl CanopenSlot {
    pub(super) fn new(node: u8, drive: DriveSlot) -> Self {
        let (cable, fault) = (f64::NAN, None);
        Self { node, drive, inputs: [0; 8], operational: false, emergency: 0, cable, fault }
    }
}

impl Slot for CanopenSlot {
    fn sends(&self, frame: &Frame) -> bool {
        frame.id() & 0x7f == u16::from(self.node)
    }

    fn operate(&self, begin: bool) -> Frame {
        manage(if begin { START } else { PRE_OPERATIONAL }, self.node)
    }

    fn command(&mut self, command: DriveCommand, h: f64, _now: u64, out: &mut Vec<Frame>) {
        let mut octets = [0; 6];
        self.drive.write(&mut octets, command, h);
        out.push(Frame::new(TO_NODE + u16::from(self.node), &octets));
    }

    fn take(&mut self, frame: &Frame) -> Heard {
        match (frame.id() & !0x7f, frame.octets()) {
            (TO_MASTER, octets) => {
                let Some(inputs) = octets.first_chunk() else { return Heard::Other };
                (self.inputs, self.operational) = (*inputs, true);
                (self.cable, self.fault) = self.drive.read(inputs);
                Heard::Readings
            }
            // Code 0 says that an earlier one is over, which does not undo it in this run.
            (EMERGENCY, [low, high, ..]) => {
                let code = u16::from_le_bytes([*low, *high]);
                self.emergency = if code == 0 { self.emergency } else { code };
                Heard::Other
            }
            (HEARTBEAT, [state]) => Heard::Alive { left: self.operational && state & 0x7f != OPERATIONAL },
            _ => Heard::Other,
        }
    }

    fn patience(&self) -> u64 {
        HEARTBEAT_PATIENCE
    }

    fn is_ready(&self) -> bool {
        self.drive.state() == DriveState::SwitchOnDisabled
    }

    fn state(&self) -> String {
        format!("{:?}, emergency {:#06x}", self.drive.state(), self.emergency)
    }

    fn is_enabled(&self) -> bool {
        self.drive.state() == DriveState::OperationEnabled
    }

    fn has_torque(&self) -> bool {
        self.drive.state().has_torque()
    }

    fn fault(&self) -> Option<u16> {
        if self.emergency == 0 { self.fault } else { Some(self.emergency) }
    }

    fn forgive(&mut self) {
        self.emergency = 0;
    }

    fn forget_state(&mut self) {
        self.drive.forget_state();
    }

    fn readings(&self) -> [f64; 2] {
        [self.cable, self.drive.current(&self.inputs)]
    }

    fn braked_speed(&self, h: f64) -> f64 {
        self.drive.braked_speed(h)
    }
}
