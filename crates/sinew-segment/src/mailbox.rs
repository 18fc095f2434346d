//! The mailbox of a device: headers, counters, repeated messages, errors; CoE behind it.
//!
//! Source: ETG.1000.4, 6.7.3 and ETG.1000.6, 5.5.

use crate::al::AlState;
use crate::bytes::u16_at;
use crate::coe::{self, SdoServer};
use crate::dictionary::Dictionary;
use crate::esc::{Controller, register};
use std::collections::VecDeque;

const HEADER: usize = 6;
/// Types in the header.
const ERROR: u8 = 0;
const COE: u8 = 3;
/// Octets of a CoE header and of the smallest SDO.
const COE_HEADER: usize = 2;
const SMALLEST_SDO: usize = 3;
const SMALLEST_INITIATING: usize = 10;
const SMALLEST_INFORMATION: usize = 6;
/// Emergencies that wait for the master; more are lost, as in a device.
const MAX_WAITING: usize = 16;

/// Why a message was not understood, ETG.1000.4 table 30.
#[derive(Debug, Clone, Copy)]
enum Refusal {
    UnsupportedProtocol = 2,
    UnsupportedService = 4,
    TooShort = 6,
    InvalidSize = 8,
}

/// Mailbox of one device.
#[derive(Debug, Clone)]
pub(crate) struct Mailbox {
    from_master: usize,
    to_master: usize,
    complete_access: bool,
    information: bool,
    answer_ns: u64,
    sdo: SdoServer,
    due: Option<u64>,
    last_counter: u8,
    own_counter: u8,
    /// Messages with header, the counter still open.
    waiting: VecDeque<Vec<u8>>,
    /// In the sync manager now, and the one that the master read last.
    present: Option<Vec<u8>>,
    read: Option<Vec<u8>>,
}

impl Mailbox {
    /// `from_master` and `to_master` are channels of sync managers.
    pub(crate) fn new(
        from_master: usize,
        to_master: usize,
        description: crate::description::MailboxDescription,
        answer_ns: u64,
    ) -> Self {
        Self {
            from_master,
            to_master,
            complete_access: description.complete_access,
            information: description.information,
            answer_ns,
            sdo: SdoServer::default(),
            due: None,
            last_counter: 0,
            own_counter: 0,
            waiting: VecDeque::new(),
            present: None,
            read: None,
        }
    }

    /// The master has left or enters the states with a mailbox.
    pub(crate) fn reset(&mut self) {
        self.sdo = SdoServer::default();
        (self.due, self.last_counter, self.own_counter) = (None, 0, 0);
        self.waiting.clear();
        (self.present, self.read) = (None, None);
    }

    /// An emergency for the master: error code, error register, five octets of the manufacturer.
    pub(crate) fn emergency(&mut self, code: u16, register: u8, data: [u8; 5]) {
        if self.waiting.len() < MAX_WAITING {
            let mut content = vec![0, coe::EMERGENCY << 4];
            content.extend(code.to_le_bytes());
            content.push(register);
            content.extend(data);
            self.waiting.push_back(message(COE, &content));
        }
    }

    /// Takes a message that has waited long enough, and passes answers on.
    pub(crate) fn advance(
        &mut self,
        controller: &mut Controller,
        dictionary: &mut Dictionary,
        state: AlState,
    ) {
        let now = controller.now();
        self.repeat(controller);
        let full = controller.managers().get(self.from_master).is_some_and(|manager| manager.is_full());
        if full {
            let due = *self.due.get_or_insert(now + self.answer_ns);
            if now >= due && self.waiting.is_empty() {
                self.due = None;
                let room = controller.managers().get(self.to_master).map_or(0, |manager| manager.length);
                let room = usize::from(room).saturating_sub(HEADER);
                let request = controller.manager(self.from_master).map(|manager| manager.take().to_vec());
                self.handle(&request.unwrap_or_default(), room, dictionary, state);
            }
        }
        self.pass_on(controller);
    }

    fn pass_on(&mut self, controller: &mut Controller) {
        let Some(manager) = controller.manager(self.to_master) else { return };
        if manager.is_full() || !manager.enabled {
            return;
        }
        if let Some(read) = self.present.take() {
            self.read = Some(read);
        }
        let Some(mut message) = self.waiting.pop_front() else { return };
        if message[5] >> 4 == 0 {
            self.own_counter = self.own_counter % 7 + 1;
            message[5] |= self.own_counter << 4;
        }
        put(manager, &message);
        self.present = Some(message);
    }

    /// The master asks for the last message once more by toggling a bit; the device confirms by toggling its
    /// own.
    fn repeat(&mut self, controller: &mut Controller) {
        let activation = register::SYNC_MANAGER + register::SYNC_MANAGER_LENGTH * self.to_master as u16 + 6;
        let [asked, confirmed] = controller.word(activation).to_le_bytes();
        if (asked ^ confirmed) & 0x02 == 0 {
            return;
        }
        controller.set(activation + 1, &[confirmed ^ 0x02]);
        let Some(manager) = controller.manager(self.to_master) else { return };
        let unread = manager.is_full();
        let last = if unread { self.read.take() } else { self.present.take().or_else(|| self.read.take()) };
        let Some(last) = last else { return };
        if unread && let Some(present) = self.present.take() {
            self.waiting.push_front(present);
        }
        put(manager, &last);
        self.present = Some(last);
    }

    fn handle(&mut self, request: &[u8], room: usize, dictionary: &mut Dictionary, state: AlState) {
        let length = usize::from(u16_at(request, 0));
        let kind = request.get(5).copied().unwrap_or(0);
        let counter = kind >> 4 & 7;
        if counter != 0 && counter == self.last_counter {
            // A repetition of what was already answered.
            return;
        }
        self.last_counter = counter;
        let Some(content) = request.get(HEADER..HEADER + length) else {
            return self.refuse(Refusal::InvalidSize);
        };
        match kind & 0x0f {
            ERROR => {}
            COE if content.len() < COE_HEADER => self.refuse(Refusal::TooShort),
            COE => self.handle_coe(content, room, dictionary, state),
            _ => self.refuse(Refusal::UnsupportedProtocol),
        }
    }

    fn handle_coe(&mut self, content: &[u8], room: usize, dictionary: &mut Dictionary, state: AlState) {
        let service = content[1] >> 4;
        let smallest = match service {
            coe::SDO_REQUEST => SMALLEST_SDO,
            coe::SDO_INFORMATION if self.information => SMALLEST_INFORMATION,
            _ => return self.refuse(Refusal::UnsupportedService),
        };
        // All SDO requests but segments name an object.
        let segment = content.get(2).is_some_and(|command| matches!(command >> 5, 0 | 3));
        let smallest = if service == coe::SDO_REQUEST && !segment { SMALLEST_INITIATING } else { smallest };
        if content.len() < smallest {
            return self.refuse(Refusal::TooShort);
        }
        if service == coe::SDO_REQUEST {
            let answer = self.sdo.answer(dictionary, state, self.complete_access, content, room);
            self.waiting.extend(answer.map(|answer| message(COE, &answer)));
        } else {
            let answers = coe::answer_information(dictionary, content, room);
            self.waiting.extend(answers.iter().map(|answer| message(COE, answer)));
        }
    }

    fn refuse(&mut self, refusal: Refusal) {
        let [low, high] = (refusal as u16).to_le_bytes();
        self.waiting.push_back(message(ERROR, &[1, 0, low, high]));
    }
}

fn message(kind: u8, content: &[u8]) -> Vec<u8> {
    let mut message = (content.len() as u16).to_le_bytes().to_vec();
    message.extend([0, 0, 0, kind]);
    message.extend(content);
    message
}

fn put(manager: &mut crate::esc::SyncManager, message: &[u8]) {
    let buffer = manager.buffer();
    let used = message.len().min(buffer.len());
    buffer[..used].copy_from_slice(&message[..used]);
    buffer[used..].fill(0);
    manager.offer();
}
