//! A drive on CANopen, CiA 301 and 402: the objects of the built-in drive, and those of CANopen: SDO server,
//! NMT, two PDOs each way, SYNC, heartbeat both ways, emergencies.

use super::CanFrame;
use crate::al::AlState;
use crate::coe::{SDO_REQUEST, SdoServer};
use crate::description::{Access, DataType, ObjectCode, PdoDescription, PdoEntry, builtin};
use crate::dictionary::{Dictionary, entry, record, variable};
use crate::drive::Drive;
use crate::pdo::ProcessData;

/// State of a node after CiA 301, as in its heartbeat.
const PRE_OPERATIONAL: u8 = 127;
const OPERATIONAL: u8 = 5;
const STOPPED: u8 = 4;
/// Error code: the heartbeat of the master is lost.
const HEARTBEAT_LOST: u16 = 0x8130;
/// PDOs each way.
const PDOS: u16 = 2;
/// Bit of a PDO's COB-ID: it does not exist.
const INVALID: u64 = 1 << 31;
/// The largest transmission type of PDOs that go with SYNC.
const LAST_SYNCHRONOUS: u64 = 240;

/// One PDO in operation.
#[derive(Debug, Clone, Default)]
struct Pdo {
    id: Option<u16>,
    synchronous: bool,
    data: ProcessData,
    /// Of outputs: what came and waits for SYNC; of inputs: what was sent last.
    last: Option<CanFrame>,
}

/// A drive with its objects.
#[derive(Debug, Clone)]
pub(super) struct Canopen {
    id: u8,
    identity: [u32; 2],
    dictionary: Dictionary,
    drive: Drive,
    sdo: SdoServer,
    state: u8,
    booted: bool,
    outputs: [Pdo; PDOS as usize],
    inputs: [Pdo; PDOS as usize],
    /// When the heartbeat of the master was heard last, once it has been.
    heard: Option<u64>,
    next_heartbeat: u64,
}

impl Canopen {
    pub(super) fn new(id: u8, identity: [Option<u32>; 2]) -> Self {
        let of = builtin::drive().identity;
        let identity = [identity[0].unwrap_or(of.vendor), identity[1].unwrap_or(of.product)];
        let dictionary = dictionary(id, identity);
        Self {
            id,
            identity,
            drive: Drive::new(&dictionary),
            dictionary,
            sdo: SdoServer::default(),
            state: PRE_OPERATIONAL,
            booted: true,
            outputs: Default::default(),
            inputs: Default::default(),
            heard: None,
            next_heartbeat: 0,
        }
    }

    pub(super) fn drive(&self) -> &Drive {
        &self.drive
    }

    pub(super) fn drive_mut(&mut self) -> &mut Drive {
        &mut self.drive
    }

    fn is_operational(&self) -> bool {
        self.state == OPERATIONAL
    }

    pub(super) fn restart(&mut self) {
        *self = Self::new(self.id, [Some(self.identity[0]), Some(self.identity[1])]);
        self.booted = false;
    }

    pub(super) fn process(&mut self, frame: &CanFrame, now: u64, out: &mut Vec<CanFrame>) {
        if frame.is_remote() {
            return;
        }
        let (node, octets) = (u16::from(self.id), frame.octets());
        match frame.id() {
            0 => {
                if let [command, of] = *octets
                    && (of == 0 || of == self.id)
                {
                    self.manage(command);
                }
            }
            0x80 => self.synchronize(out),
            id if id == 0x600 + node && octets.len() == 8 => self.serve(octets, out),
            id if id > 0x700 => {
                let consumed = self.dictionary.number(0x1016, 1);
                if u64::from(id & 0x7f) == consumed >> 16 & 0x7f && consumed & 0xffff != 0 {
                    self.heard = Some(now);
                }
            }
            id => self.receive(id, frame),
        }
    }

    /// `beats` says whether it sends its heartbeat.
    pub(super) fn advance(&mut self, now: u64, elapsed: u64, beats: bool, out: &mut Vec<CanFrame>) {
        self.drive.step(&mut self.dictionary, elapsed);
        let consumed = self.dictionary.number(0x1016, 1);
        let patience = (consumed & 0xffff) * 1_000_000;
        if patience > 0 && self.heard.is_some_and(|at| now.saturating_sub(at) > patience) {
            self.heard = None;
            self.drive.raise_fault(HEARTBEAT_LOST);
            self.state = PRE_OPERATIONAL;
        }
        if !self.booted {
            self.booted = true;
            out.push(CanFrame::new(0x700 + u16::from(self.id), &[0]));
        }
        if let Some((code, register)) = self.drive.take_emergency() {
            let [low, high] = code.to_le_bytes();
            let emergency = [low, high, register, 0, 0, 0, 0, 0];
            out.push(CanFrame::new(0x80 + u16::from(self.id), &emergency));
        }
        let interval = self.dictionary.number(0x1017, 0) * 1_000_000;
        if interval > 0 && now >= self.next_heartbeat {
            self.next_heartbeat = now + interval;
            if beats {
                out.push(CanFrame::new(0x700 + u16::from(self.id), &[self.state]));
            }
        }
        if self.is_operational() {
            for pdo in self.inputs.iter_mut().filter(|pdo| !pdo.synchronous) {
                pdo.send(&self.dictionary, true, out);
            }
        }
    }

    /// Network management.
    fn manage(&mut self, command: u8) {
        let before = self.state;
        match command {
            1 => {
                let pdo = |base: u16, k: u16| Pdo::of(&self.dictionary, base + k);
                (self.outputs, self.inputs) =
                    ([pdo(0x1400, 0), pdo(0x1400, 1)], [pdo(0x1800, 0), pdo(0x1800, 1)]);
                self.state = OPERATIONAL;
            }
            2 => self.state = STOPPED,
            128 => self.state = PRE_OPERATIONAL,
            129 | 130 => {
                self.restart();
                return;
            }
            _ => {}
        }
        if before == OPERATIONAL && self.state != OPERATIONAL {
            self.drive.outputs_lost();
        }
    }

    fn synchronize(&mut self, out: &mut Vec<CanFrame>) {
        if !self.is_operational() {
            return;
        }
        for pdo in &mut self.outputs {
            if let Some(frame) = pdo.last.take() {
                pdo.data.distribute(frame.octets(), &mut self.dictionary);
            }
        }
        self.drive.step(&mut self.dictionary, 0);
        for pdo in self.inputs.iter_mut().filter(|pdo| pdo.synchronous) {
            pdo.send(&self.dictionary, false, out);
        }
    }

    fn receive(&mut self, id: u16, frame: &CanFrame) {
        let operational = self.is_operational();
        let Some(pdo) = self.outputs.iter_mut().find(|pdo| operational && pdo.id == Some(id)) else { return };
        if frame.octets().len() < pdo.data.length() {
            return;
        }
        if pdo.synchronous {
            pdo.last = Some(*frame);
        } else {
            pdo.data.distribute(frame.octets(), &mut self.dictionary);
            self.drive.step(&mut self.dictionary, 0);
        }
    }

    fn serve(&mut self, octets: &[u8], out: &mut Vec<CanFrame>) {
        // As over EtherCAT, in segments of seven octets and without the header of a mailbox.
        const HEADER: usize = 2;
        let state = match self.state {
            STOPPED => return,
            OPERATIONAL => AlState::Op,
            _ => AlState::PreOp,
        };
        let mut request = [0, SDO_REQUEST << 4, 0, 0, 0, 0, 0, 0, 0, 0];
        request[HEADER..].copy_from_slice(octets);
        let Self { sdo, dictionary, .. } = self;
        if let Some(answer) = sdo.answer(dictionary, state, false, &request, request.len()) {
            out.push(CanFrame::new(0x580 + u16::from(self.id), &answer[HEADER..]));
        }
    }
}

impl Pdo {
    /// Of its communication parameters; its mapping is 0x200 behind them.
    fn of(dictionary: &Dictionary, index: u16) -> Self {
        let id = dictionary.number(index, 1);
        let data = ProcessData::of(dictionary, index + 0x200);
        let exists = id & INVALID == 0 && (1..=8).contains(&data.length());
        let synchronous = dictionary.number(index, 2) <= LAST_SYNCHRONOUS;
        Self { id: exists.then_some(id as u16 & 0x7ff), synchronous, data, last: None }
    }

    /// Sends its values, or only where they have `changed`.
    fn send(&mut self, dictionary: &Dictionary, changed: bool, out: &mut Vec<CanFrame>) {
        let Some(id) = self.id else { return };
        let (mut octets, length) = ([0; 8], self.data.length());
        self.data.collect(dictionary, &mut octets);
        let frame = CanFrame::new(id, &octets[..length]);
        if !changed || self.last != Some(frame) {
            self.last = Some(frame);
            out.push(frame);
        }
    }
}

/// The objects of the built-in drive and those of CANopen.
fn dictionary(id: u8, [vendor, product]: [u32; 2]) -> Dictionary {
    let node = u32::from(id);
    let mut description = builtin::drive();
    (description.identity.vendor, description.identity.product) = (vendor, product);
    description.sync_managers.clear();
    let pdo = |index, objects: &[(u16, u8)]| PdoDescription {
        index,
        name: "PDO".to_owned(),
        assigned: true,
        fixed: false,
        entries: objects
            .iter()
            .map(|(index, bits)| PdoEntry { index: *index, subindex: 0, bits: *bits })
            .collect(),
    };
    description.pdos = vec![
        pdo(0x1600, &[(0x6040, 16), (0x60ff, 32)]),
        pdo(0x1601, &[]),
        pdo(0x1a00, &[(0x6041, 16), (0x6064, 32), (0x6077, 16)]),
        pdo(0x1a01, &[(0x606c, 32)]),
    ];
    let number = |subindex, name: &str, data_type, value: u32| {
        entry(subindex, name, data_type, Access::ReadWrite, &value.to_le_bytes())
    };
    let mut single = |index, name: &str, data_type, value: u32| {
        let mut object = variable(index, name, data_type, &value.to_le_bytes());
        object.entries[0].access = Access::ReadWrite;
        description.objects.push(object);
    };
    single(0x1005, "COB-ID SYNC", DataType::U32, 0x80);
    single(0x1006, "Communication cycle period", DataType::U32, 0);
    single(0x1014, "COB-ID EMCY", DataType::U32, 0x80 + node);
    single(0x1017, "Producer heartbeat time", DataType::U16, 0);
    let heartbeat = vec![number(1, "Consumer heartbeat time", DataType::U32, 0)];
    description.objects.push(record(0x1016, "Consumer heartbeat time", ObjectCode::Array, heartbeat));
    for (base, id) in [(0x1400, 0x200), (0x1800, 0x180)] {
        for k in 0..PDOS {
            let id = (id + node + 0x100 * u32::from(k)) | if k == 0 { 0 } else { INVALID as u32 };
            let entries = vec![number(1, "COB-ID", DataType::U32, id), number(2, "Type", DataType::U8, 0xff)];
            description.objects.push(record(base + k, "PDO parameter", ObjectCode::Record, entries));
        }
    }
    Dictionary::new(&description, node)
}
