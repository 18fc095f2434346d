//! Octets as a play of frames, time and faults on a line, and what must hold of every answer. Used by the
//! tests and by the fuzz target.

use sinew_segment::{
    AlState, AlStatusCode, Device, DeviceSettings, Fault, FaultKind, Passed, Segment, builtin,
};

/// Octets that decide; zeros behind the end.
struct Choices<'a>(&'a [u8]);

impl Choices<'_> {
    fn octet(&mut self) -> u8 {
        let Some((first, rest)) = self.0.split_first() else { return 0 };
        self.0 = rest;
        *first
    }

    fn word(&mut self) -> u16 {
        u16::from_le_bytes([self.octet(), self.octet()])
    }

    fn octets(&mut self, count: usize) -> Vec<u8> {
        (0..count).map(|_| self.octet()).collect()
    }

    fn one_of<T: Copy>(&mut self, values: &[T]) -> T {
        values[usize::from(self.octet()) % values.len()]
    }
}

/// A line with every kind of device.
fn line() -> Segment {
    let settings = DeviceSettings { transition_ns: 0, mailbox_ns: 0, alias: 7, ..DeviceSettings::default() };
    let devices = [builtin::coupler(), builtin::drive(), builtin::load_cell(), builtin::encoder(2)];
    let device = |description| Device::new(description, settings).expect("a built-in device");
    Segment::new(devices.iter().map(device).collect())
}

/// Registers at which something happens, and memory.
const OFFSETS: [u16; 26] = [
    0x0000, 0x0010, 0x0100, 0x0103, 0x0110, 0x0120, 0x0130, 0x0200, 0x0210, 0x0300, 0x0400, 0x0420, 0x0440,
    0x0500, 0x0502, 0x0600, 0x0610, 0x0800, 0x0806, 0x080e, 0x0810, 0x0900, 0x0910, 0x0980, 0x1000, 0x1200,
];
const STATION: u16 = 0x1000;
const MAILBOX: usize = 256;

/// How far a play came.
#[derive(Debug, Clone, Copy, Default)]
pub(crate) struct Played {
    /// Frames, of some kinds of action the first of several only.
    pub(crate) frames: usize,
    /// Actions that began with the drive in OP.
    pub(crate) in_op: usize,
    /// Mailbox messages of the drive that were read and checked.
    pub(crate) messages: usize,
}

/// Plays the octets.
pub(crate) fn play(octets: &[u8]) -> Played {
    let mut choices = Choices(octets);
    let mut segment = line();
    let mut played = Played::default();
    for position in 0..4_u16 {
        let datagram = datagram(2, 0_u16.wrapping_sub(position), 0x0010, &(STATION + position).to_le_bytes());
        pass(&mut segment, &frame(&[datagram]));
    }
    while !choices.0.is_empty() {
        let action = choices.octet() % 16;
        match action {
            0..=7 => {
                let count = 1 + usize::from(choices.octet() % 4);
                let datagrams: Vec<_> = (0..count).map(|_| structured(&mut choices)).collect();
                let mut frame = frame(&datagrams);
                distort(&mut frame, &mut choices);
                pass(&mut segment, &frame);
            }
            8 | 9 => pass(&mut segment, &frame(&[message(&mut choices)])),
            10 => {
                let registers = datagram(4, STATION + 1, 0x0808, &[0; 8]);
                let content = datagram(4, STATION + 1, 0x1100, &[0; MAILBOX]);
                played.messages +=
                    usize::from(check_mailbox(&pass_back(&mut segment, &frame(&[registers, content]))));
            }
            11 => configure(&mut segment, &mut choices),
            12 => {
                let length = usize::from(choices.octet());
                pass(&mut segment, &choices.octets(length));
            }
            13 => disturb(&mut segment, &mut choices),
            _ => segment.advance(choices.one_of(&[
                0,
                1,
                1000,
                50_000,
                1_000_000,
                200_000_000,
                u64::from(u32::MAX),
            ])),
        }
        played.frames += usize::from(action < 13);
        played.in_op += usize::from(segment.device(1).is_some_and(|drive| drive.state() == AlState::Op));
    }
    played
}

fn datagram(command: u8, device: u16, offset: u16, data: &[u8]) -> Vec<u8> {
    let mut datagram = vec![command, 0];
    datagram.extend(device.to_le_bytes());
    datagram.extend(offset.to_le_bytes());
    datagram.extend((data.len() as u16).to_le_bytes());
    datagram.extend([0, 0]);
    datagram.extend(data);
    datagram.extend([0, 0]);
    datagram
}

fn structured(choices: &mut Choices) -> Vec<u8> {
    let command = choices.octet() % 17;
    let any = choices.word();
    let device = choices.one_of(&[0, 0xffff, 0xfffe, STATION, STATION + 1, STATION + 2, 7, any]);
    let any = choices.word();
    let offset = choices.one_of(&OFFSETS).wrapping_add(u16::from(choices.octet() & 7));
    let offset = if choices.octet() == 0 { any } else { offset };
    let length = choices.one_of::<usize>(&[0, 1, 2, 4, 6, 8, 16, 64, 256, 1400]);
    let data = if length <= 16 { choices.octets(length) } else { vec![choices.octet(); length] };
    // Logical addresses are small numbers.
    let offset = if (10..=12).contains(&command) { offset & 1 } else { offset };
    datagram(command, device, offset, &data)
}

fn frame(datagrams: &[Vec<u8>]) -> Vec<u8> {
    let mut frame = vec![0xff; 6];
    frame.extend([0x10, 0x10, 0x10, 0x10, 0x10, 0x10, 0x88, 0xa4]);
    let length: usize = datagrams.iter().map(Vec::len).sum();
    frame.extend((length as u16 & 0x07ff | 0x1000).to_le_bytes());
    for (at, datagram) in datagrams.iter().enumerate() {
        let start = frame.len();
        frame.extend(datagram);
        if at + 1 < datagrams.len() {
            frame[start + 7] |= 0x80;
        }
    }
    frame
}

/// Now and then a wrong octet or a wrong end.
fn distort(frame: &mut Vec<u8>, choices: &mut Choices) {
    match choices.octet() {
        0 => {
            let at = usize::from(choices.word()) % frame.len();
            frame[at] = choices.octet();
        }
        1 => frame.truncate(usize::from(choices.word()) % frame.len()),
        _ => {}
    }
}

/// A mailbox message to the drive, mostly with a header and a CoE service that are right.
fn message(choices: &mut Choices) -> Vec<u8> {
    let length = choices.one_of::<usize>(&[10, 10, 10, 12, 16, 40, 250, 0, 2, 3]);
    let counter = choices.octet() & 7;
    let kind = choices.one_of(&[3, 3, 3, 3, 3, 3, 0, 1, 15]);
    let mut message = (length as u16).to_le_bytes().to_vec();
    message.extend([0, 0, 0, kind | counter << 4]);
    message.extend([0, choices.one_of(&[0x20, 0x20, 0x20, 0x80, 0x80, 0x10, 0xf0])]);
    let any = choices.octet();
    message.push(
        choices
            .one_of(&[0x40, 0x50, 0x60, 0x70, 0x21, 0x23, 0x2f, 0x31, 0x00, 0x01, 0x10, 0x11, 1, 3, 5, any]),
    );
    let any = choices.word();
    let index =
        choices.one_of(&[0x1008, 0x1018, 0x1600, 0x1a00, 0x1c12, 0x1c13, 0x1c32, 0x6040, 0x607d, any]);
    message.extend(u16::to_le_bytes(index));
    message.extend(choices.octets(16));
    if choices.octet() == 0 {
        message[0] = choices.octet();
        message[1] = choices.octet();
    }
    message.resize(MAILBOX, 0);
    datagram(5, STATION + 1, 0x1000, &message)
}

/// Settings of the drive that are mostly right, and a state.
fn configure(segment: &mut Segment, choices: &mut Choices) {
    let length =
        |right: u16, choices: &mut Choices| if choices.octet() == 0 { choices.word() } else { right };
    for (channel, start, right, control) in
        [(0, 0x1000_u16, 256, 0x26), (1, 0x1100, 256, 0x22), (2, 0x1200, 6, 0x64), (3, 0x1800, 16, 0x20)]
    {
        let length = length(right, choices);
        let mut octets = start.to_le_bytes().to_vec();
        octets.extend(length.to_le_bytes());
        octets.extend([control, 0, 1, 0]);
        pass(segment, &frame(&[datagram(5, STATION + 1, 0x0800 + 8 * channel, &octets)]));
    }
    for (unit, logical, length, start, kind) in [(0, 0_u32, 6_u16, 0x1200_u16, 2), (1, 8, 16, 0x1800, 1)] {
        let mut octets = logical.to_le_bytes().to_vec();
        octets.extend(length.to_le_bytes());
        octets.extend(if choices.octet() == 0 { [choices.octet(), choices.octet()] } else { [0, 7] });
        octets.extend(start.to_le_bytes());
        octets.extend([0, kind, 1, 0, 0, 0]);
        pass(segment, &frame(&[datagram(5, STATION + 1, 0x0600 + 16 * unit, &octets)]));
    }
    for state in [2, 4, 8].into_iter().take(usize::from(choices.octet() % 4)) {
        pass(segment, &frame(&[datagram(12, 0, 0, &[0; 24]), datagram(5, STATION + 1, 0x0120, &[state, 0])]));
        segment.advance(100_000);
    }
}

fn disturb(segment: &mut Segment, choices: &mut Choices) {
    let kind = match choices.octet() % 12 {
        0 => FaultKind::Mute,
        1 => FaultKind::OffTheWire,
        2 => FaultKind::PowerLoss,
        3 => FaultKind::Late(u64::from(choices.word())),
        4 => FaultKind::Corrupted,
        5 => FaultKind::Lost,
        6 => FaultKind::WorkingCounter(choices.word() as i16),
        7 => FaultKind::DropToSafeOp(AlStatusCode::Watchdog),
        8 => FaultKind::Emergency(choices.word(), 1, [0; 5]),
        9 => FaultKind::DriveFault(choices.word()),
        10 => {
            let other =
                Device::new(&builtin::encoder(1), DeviceSettings::default()).expect("a built-in device");
            FaultKind::Swapped(Box::new(other))
        }
        _ => return segment.clear_faults(),
    };
    let device = usize::from(choices.octet() % 5);
    let start_ns = segment.now() + u64::from(choices.word());
    let duration_ns = (choices.octet() > 8).then(|| u64::from(choices.word()));
    if segment.inject(Fault { device, kind, start_ns, duration_ns }).is_err() {
        assert_eq!(device, 4, "the only position without a device");
    }
    for (position, value) in [(1, i32::from(choices.word() as i16)), (2, i32::MIN)] {
        if let Some(device) = segment.device_mut(position) {
            device.set_input(0, i64::from(value));
            if let Some(drive) = device.drive_mut() {
                drive.set_actual(value, value, value as i16);
            }
        }
    }
}

fn pass(segment: &mut Segment, sent: &[u8]) {
    pass_back(segment, sent);
}

/// Sends a frame and checks what comes back against the lengths and fields of the standard.
fn pass_back(segment: &mut Segment, sent: &[u8]) -> Vec<u8> {
    let mut frame = sent.to_vec();
    let passed = segment.process(&mut frame);
    match passed {
        Passed::Ignored => assert_eq!(frame, sent),
        Passed::Returned { .. } => check_frame(sent, &frame),
        _ => assert_eq!(frame.len(), sent.len()),
    }
    frame
}

/// Devices change addresses, data, events and counters, and nothing else.
fn check_frame(sent: &[u8], back: &[u8]) {
    assert_eq!(sent.len(), back.len());
    let tag = if sent[12..14] == [0x81, 0] { 4 } else { 0 };
    assert_eq!(sent[..6], back[..6]);
    assert_eq!(sent[6] | 2, back[6]);
    assert_eq!(sent[7..16 + tag], back[7..16 + tag]);
    let mut at = 16 + tag;
    loop {
        let flags = u16::from_le_bytes([sent[at + 6], sent[at + 7]]);
        let length = usize::from(flags & 0x07ff);
        assert_eq!(sent[at..at + 2], back[at..at + 2], "command and index");
        assert_eq!(sent[at + 4..at + 8], back[at + 4..at + 8], "offset, length and flags");
        if sent[at] == 0 || sent[at] > 14 {
            assert_eq!(
                sent[at + 10..at + 10 + length],
                back[at + 10..at + 10 + length],
                "no data without a command"
            );
        }
        at += 12 + length;
        if flags & 0x8000 == 0 {
            break;
        }
    }
    assert_eq!(sent[at..], back[at..], "what follows the last datagram");
}

/// A message that the master could read fits into the mailbox and has a type that the drive speaks.
fn check_mailbox(frame: &[u8]) -> bool {
    // Behind the registers of the sync manager: start, length, control, status with the full flag, switched
    // on.
    let (registers, first) = (&frame[26..34], 36 + 10);
    let message = &frame[first..first + MAILBOX];
    let counter = u16::from_le_bytes([frame[first + MAILBOX], frame[first + MAILBOX + 1]]);
    let as_described = registers[..5] == [0x00, 0x11, 0x00, 0x01, 0x22] && registers[6] & 1 == 1;
    if counter != 1 || !as_described || registers[5] & 8 == 0 {
        return false;
    }
    let length = usize::from(u16::from_le_bytes([message[0], message[1]]));
    assert!(length <= MAILBOX - 6, "{length} octets in a mailbox of {MAILBOX}");
    match message[5] & 0x0f {
        0 => assert_eq!(length, 4, "a mailbox error"),
        3 => assert!(
            length >= 10 || message[7] >> 4 == 8,
            "CoE service {} of {length} octets",
            message[7] >> 4
        ),
        other => panic!("type {other}"),
    }
    assert_ne!(message[5] >> 4 & 7, 0, "messages of the device are counted");
    true
}
