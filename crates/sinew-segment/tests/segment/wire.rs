//! A master in a few lines, written from the standard and independent of the crate: datagrams, states,
//! mailbox, SDO.

#![allow(dead_code, reason = "each test file uses a part")]
#![allow(clippy::unwrap_used, reason = "a failing test may panic")]

use sinew_segment::{Device, DeviceDescription, DeviceSettings, Passed, Segment};

pub(crate) const NOP: u8 = 0;
pub(crate) const APRD: u8 = 1;
pub(crate) const APWR: u8 = 2;
pub(crate) const APRW: u8 = 3;
pub(crate) const FPRD: u8 = 4;
pub(crate) const FPWR: u8 = 5;
pub(crate) const FPRW: u8 = 6;
pub(crate) const BRD: u8 = 7;
pub(crate) const BWR: u8 = 8;
pub(crate) const BRW: u8 = 9;
pub(crate) const LRD: u8 = 10;
pub(crate) const LWR: u8 = 11;
pub(crate) const LRW: u8 = 12;
pub(crate) const ARMW: u8 = 13;
pub(crate) const FRMW: u8 = 14;

/// A datagram as the master sends it and as it comes back.
#[derive(Debug, Clone, PartialEq, Eq)]
pub(crate) struct Datagram {
    pub(crate) command: u8,
    pub(crate) address: u32,
    pub(crate) data: Vec<u8>,
    pub(crate) events: u16,
    pub(crate) counter: u16,
}

impl Datagram {
    pub(crate) fn new(command: u8, device: u16, offset: u16, data: &[u8]) -> Self {
        Self::logical(command, u32::from(device) | u32::from(offset) << 16, data)
    }

    pub(crate) fn logical(command: u8, address: u32, data: &[u8]) -> Self {
        Self { command, address, data: data.to_vec(), events: 0, counter: 0 }
    }
}

/// An Ethernet frame with these datagrams.
pub(crate) fn frame(datagrams: &[Datagram]) -> Vec<u8> {
    let mut frame = vec![0xff, 0xff, 0xff, 0xff, 0xff, 0xff, 0x10, 0x10, 0x10, 0x10, 0x10, 0x10, 0x88, 0xa4];
    let length: usize = datagrams.iter().map(|datagram| 12 + datagram.data.len()).sum();
    frame.extend((length as u16 | 0x1000).to_le_bytes());
    for (index, datagram) in datagrams.iter().enumerate() {
        let more = if index + 1 < datagrams.len() { 0x8000 } else { 0 };
        frame.extend([datagram.command, index as u8]);
        frame.extend(datagram.address.to_le_bytes());
        frame.extend((datagram.data.len() as u16 | more).to_le_bytes());
        frame.extend(datagram.events.to_le_bytes());
        frame.extend(&datagram.data);
        frame.extend(datagram.counter.to_le_bytes());
    }
    frame.resize(frame.len().max(60), 0);
    frame
}

/// The datagrams of a frame.
pub(crate) fn datagrams(frame: &[u8]) -> Vec<Datagram> {
    let word = |at: usize| u16::from_le_bytes([frame[at], frame[at + 1]]);
    let (mut at, mut found) = (16, Vec::new());
    loop {
        let flags = word(at + 6);
        let length = usize::from(flags & 0x7ff);
        found.push(Datagram {
            command: frame[at],
            address: u32::from(word(at + 2)) | u32::from(word(at + 4)) << 16,
            data: frame[at + 10..at + 10 + length].to_vec(),
            events: word(at + 8),
            counter: word(at + 10 + length),
        });
        at += 12 + length;
        if flags & 0x8000 == 0 {
            return found;
        }
    }
}

/// A segment with a master.
pub(crate) struct Wire {
    pub(crate) segment: Segment,
    mailbox_counter: u8,
}

/// Station address of the first device; the others follow.
pub(crate) const STATION: u16 = 0x1000;

impl Wire {
    pub(crate) fn new(descriptions: &[DeviceDescription]) -> Self {
        Self::with_settings(descriptions, |_| DeviceSettings::default())
    }

    pub(crate) fn with_settings(
        descriptions: &[DeviceDescription],
        settings: impl Fn(usize) -> DeviceSettings,
    ) -> Self {
        let device = |(at, description)| Device::new(description, settings(at)).unwrap();
        let segment = Segment::new(descriptions.iter().enumerate().map(device).collect());
        let mut wire = Self { segment, mailbox_counter: 0 };
        for position in 0..descriptions.len() as u16 {
            let station = (STATION + position).to_le_bytes();
            assert_eq!(wire.send(APWR, 0_u16.wrapping_sub(position), 0x0010, &station).counter, 1);
        }
        wire
    }

    /// Sends one datagram; it has to come back.
    pub(crate) fn send(&mut self, command: u8, device: u16, offset: u16, data: &[u8]) -> Datagram {
        self.send_all(&[Datagram::new(command, device, offset, data)]).remove(0)
    }

    pub(crate) fn send_all(&mut self, sent: &[Datagram]) -> Vec<Datagram> {
        let mut frame = frame(sent);
        let passed = self.segment.process(&mut frame);
        assert!(matches!(passed, Passed::Returned { .. }), "{passed:?}");
        assert_eq!(frame[6], 0x12, "the first device marks the source address");
        datagrams(&frame)
    }

    pub(crate) fn read(&mut self, position: u16, offset: u16, length: usize) -> Vec<u8> {
        let answer = self.send(FPRD, STATION + position, offset, &vec![0; length]);
        assert_eq!(answer.counter, 1, "read of {offset:#06x}");
        answer.data
    }

    pub(crate) fn word(&mut self, position: u16, offset: u16) -> u16 {
        let data = self.read(position, offset, 2);
        u16::from_le_bytes([data[0], data[1]])
    }

    pub(crate) fn write(&mut self, position: u16, offset: u16, data: &[u8]) {
        assert_eq!(self.send(FPWR, STATION + position, offset, data).counter, 1, "write of {offset:#06x}");
    }

    pub(crate) fn wait_ms(&mut self, milliseconds: u64) {
        for _ in 0..10 * milliseconds {
            self.segment.advance(100_000);
        }
    }

    /// Requests a state and returns AL status and code after the device has had time.
    pub(crate) fn request(&mut self, position: u16, control: u16) -> (u16, u16) {
        self.write(position, 0x0120, &control.to_le_bytes());
        self.wait_ms(2);
        (self.word(position, 0x0130), self.word(position, 0x0134))
    }

    /// Sets a sync manager: channel, start, length, control; length 0 switches it off.
    pub(crate) fn sync_manager(&mut self, position: u16, channel: u16, start: u16, length: u16, control: u8) {
        let place = 0x0800 + 8 * channel;
        self.write(position, place + 6, &[0]);
        let mut octets = [start.to_le_bytes(), length.to_le_bytes()].concat();
        octets.extend([control, 0, u8::from(length > 0), 0]);
        self.write(position, place, &octets);
    }

    /// Maps a logical area to a device: kind 1 reads, 2 writes.
    pub(crate) fn fmmu(
        &mut self,
        position: u16,
        channel: u16,
        logical: u32,
        length: u16,
        start: u16,
        kind: u8,
    ) {
        let mut octets = logical.to_le_bytes().to_vec();
        octets.extend(length.to_le_bytes());
        octets.extend([0, 7]);
        octets.extend(start.to_le_bytes());
        octets.extend([0, kind, 1, 0, 0, 0]);
        self.write(position, 0x0600 + 16 * channel, &octets);
    }

    /// The built-in drive in PRE-OP.
    pub(crate) fn drive_to_pre_op(&mut self, position: u16) {
        self.sync_manager(position, 0, 0x1000, 256, 0x26);
        self.sync_manager(position, 1, 0x1100, 256, 0x22);
        assert_eq!(self.request(position, 2), (2, 0));
    }

    /// The built-in drive in SAFE-OP, outputs of 6 octets and inputs of 16 at the logical addresses.
    pub(crate) fn drive_to_safe_op(&mut self, position: u16, outputs: u32, inputs: u32) {
        self.drive_to_pre_op(position);
        self.sync_manager(position, 2, 0x1200, 6, 0x64);
        self.sync_manager(position, 3, 0x1800, 16, 0x20);
        self.fmmu(position, 0, outputs, 6, 0x1200, 2);
        self.fmmu(position, 1, inputs, 16, 0x1800, 1);
        assert_eq!(self.request(position, 4), (4, 0));
    }

    /// Puts a message with counter into the mailbox and waits for the answer, without header.
    pub(crate) fn exchange(&mut self, position: u16, kind: u8, content: &[u8]) -> Vec<u8> {
        self.post(position, kind, content);
        self.fetch(position).expect("an answer")
    }

    pub(crate) fn post(&mut self, position: u16, kind: u8, content: &[u8]) {
        self.mailbox_counter = self.mailbox_counter % 7 + 1;
        let mut message = (content.len() as u16).to_le_bytes().to_vec();
        message.extend([0, 0, 0, kind | self.mailbox_counter << 4]);
        message.extend(content);
        message.resize(256, 0);
        self.write(position, 0x1000, &message);
    }

    /// The message in the device's mailbox with its header cut off, after some time.
    pub(crate) fn fetch(&mut self, position: u16) -> Option<Vec<u8>> {
        self.wait_ms(1);
        if self.read(position, 0x080d, 1)[0] & 8 == 0 {
            return None;
        }
        let message = self.read(position, 0x1100, 256);
        let length = usize::from(u16::from_le_bytes([message[0], message[1]]));
        assert!(length <= 250, "{length} octets in a mailbox of 256");
        Some(message[6..6 + length].to_vec())
    }

    /// SDO request with command, index, subindex and four octets; the answer without CoE header.
    pub(crate) fn sdo(
        &mut self,
        position: u16,
        command: u8,
        index: u16,
        subindex: u8,
        data: &[u8],
    ) -> Vec<u8> {
        let mut content = vec![0, 0x20, command];
        content.extend(index.to_le_bytes());
        content.push(subindex);
        content.extend(data);
        content.resize(content.len().max(10), 0);
        let answer = self.exchange(position, 3, &content);
        answer[2..].to_vec()
    }

    /// Expedited upload, or the abort code.
    pub(crate) fn upload(&mut self, position: u16, index: u16, subindex: u8) -> Result<Vec<u8>, u32> {
        let answer = self.sdo(position, 0x40, index, subindex, &[]);
        if answer[0] == 0x80 {
            return Err(u32::from_le_bytes([answer[4], answer[5], answer[6], answer[7]]));
        }
        assert_eq!(answer[0] & 0xe3, 0x43, "expedited, with its size");
        Ok(answer[4..8 - usize::from(answer[0] >> 2 & 3)].to_vec())
    }

    /// Expedited download of one to four octets, or the abort code.
    pub(crate) fn download(
        &mut self,
        position: u16,
        index: u16,
        subindex: u8,
        value: &[u8],
    ) -> Result<(), u32> {
        let command = 0x23 | (4 - value.len() as u8) << 2;
        let mut data = value.to_vec();
        data.resize(4, 0);
        let answer = self.sdo(position, command, index, subindex, &data);
        match answer[0] {
            0x60 => Ok(()),
            _ => Err(u32::from_le_bytes([answer[4], answer[5], answer[6], answer[7]])),
        }
    }
}
