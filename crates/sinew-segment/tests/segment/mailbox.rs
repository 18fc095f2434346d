//! Mailbox and CoE: transfers of every kind, descriptions of objects, abort codes, repeated and broken
//! messages.

#![allow(clippy::unwrap_used, reason = "a failing test may panic")]

use crate::wire;

use sinew_segment::builtin;
use wire::Wire;

fn drive() -> Wire {
    let mut wire = Wire::new(&[builtin::drive()]);
    wire.drive_to_pre_op(0);
    wire
}

#[test]
fn values_of_one_to_four_octets_are_expedited() {
    let mut wire = drive();
    assert_eq!(wire.upload(0, 0x6061, 0), Ok(vec![0]));
    assert_eq!(wire.upload(0, 0x6041, 0).unwrap().len(), 2);
    assert_eq!(wire.upload(0, 0x1018, 1), Ok(0x51e37_u32.to_le_bytes().to_vec()));
    assert_eq!(wire.download(0, 0x6060, 0, &[0xf6]), Ok(()));
    assert_eq!(wire.upload(0, 0x6060, 0), Ok(vec![0xf6]));
    assert_eq!(wire.download(0, 0x6065, 0, &[1, 2, 3, 4]), Ok(()));
    assert_eq!(wire.upload(0, 0x6065, 0), Ok(vec![1, 2, 3, 4]));
    // Without a size the type decides.
    assert_eq!(wire.sdo(0, 0x22, 0x6060, 0, &[7, 9, 9, 9])[0], 0x60);
    assert_eq!(wire.upload(0, 0x6060, 0), Ok(vec![7]));
}

#[test]
fn texts_are_uploaded_in_one_message_where_they_fit() {
    let mut wire = drive();
    let answer = wire.sdo(0, 0x40, 0x1008, 0, &[]);
    assert_eq!(answer[0], 0x41, "normal, with its size");
    assert_eq!(answer[4..8], 8_u32.to_le_bytes());
    assert_eq!(&answer[8..], b"SIM-DRV1");
}

/// A device with small mailboxes and a long writable text.
fn narrow() -> sinew_segment::DeviceDescription {
    let text = builtin::LOAD_CELL_TOML.replace("length = 128", "length = 32").replace(
        "[[pdo]]",
        "[[object]]\nindex = 0x9000\nname = \"Note\"\ntype = \"text\"\nbits = \
            800\naccess = \"rw\"\n\n[[pdo]]",
    );
    sinew_segment::DeviceDescription::from_toml("narrow.toml", &text).unwrap()
}

/// Messages through mailboxes of 32 octets at 0x1000 and 0x1080.
fn narrow_exchange(wire: &mut Wire, counter: u8, content: &[u8]) -> Vec<u8> {
    let mut message = (content.len() as u16).to_le_bytes().to_vec();
    message.extend([0, 0, 0, 3 | counter << 4]);
    message.extend(content);
    message.resize(32, 0);
    wire.write(0, 0x1000, &message);
    wire.wait_ms(1);
    let answer = wire.read(0, 0x1080, 32);
    let length = usize::from(answer[0]);
    assert!(length <= 26);
    answer[6..6 + length].to_vec()
}

#[test]
fn long_texts_go_down_and_up_in_segments_with_a_toggle() {
    let mut wire = Wire::new(&[narrow()]);
    wire.sync_manager(0, 0, 0x1000, 32, 0x26);
    wire.sync_manager(0, 1, 0x1080, 32, 0x22);
    assert_eq!(wire.request(0, 2), (2, 0));
    let text: Vec<u8> = (b'a'..=b'z').chain(b'A'..=b'Z').chain(b'0'..=b'8').collect();
    // Initiate with the first 16 octets, then segments of 23, the last shorter.
    let mut content = vec![0, 0x20, 0x21, 0x00, 0x90, 0];
    content.extend((text.len() as u32).to_le_bytes());
    content.extend(&text[..16]);
    assert_eq!(narrow_exchange(&mut wire, 1, &content)[2], 0x60);
    let segments: Vec<&[u8]> = text[16..].chunks(23).collect();
    for (at, segment) in segments.iter().enumerate() {
        let last = at + 1 == segments.len();
        let toggle = (at as u8 & 1) << 4;
        let mut content = vec![0, 0x20, toggle | u8::from(last)];
        content.extend(*segment);
        assert_eq!(narrow_exchange(&mut wire, 2 + (at as u8 & 1), &content)[2], 0x20 | toggle);
    }
    assert_eq!(wire.segment.device(0).unwrap().object(0x9000, 0), Some(&text[..]));

    let answer = narrow_exchange(&mut wire, 4, &[0, 0x20, 0x40, 0x00, 0x90, 0, 0, 0, 0, 0]);
    assert_eq!(answer[2], 0x41);
    let mut received = answer[10..].to_vec();
    for at in 0.. {
        let toggle = (at & 1) << 4;
        let answer = narrow_exchange(&mut wire, 5 + (at & 1), &[0, 0x20, 0x60 | toggle, 0, 0, 0, 0, 0, 0, 0]);
        assert_eq!(answer[2] & 0xf0, toggle, "command and toggle");
        let unused = usize::from(answer[2] >> 1 & 7);
        received.extend(&answer[3..answer.len() - unused]);
        if answer[2] & 1 == 1 {
            break;
        }
    }
    assert_eq!(received, text);

    // A toggle that does not change aborts the transfer.
    narrow_exchange(&mut wire, 1, &[0, 0x20, 0x40, 0x00, 0x90, 0, 0, 0, 0, 0]);
    let answer = narrow_exchange(&mut wire, 2, &[0, 0x20, 0x70, 0, 0, 0, 0, 0, 0, 0]);
    assert_eq!(answer[6..10], 0x0503_0000_u32.to_le_bytes());
    let answer = narrow_exchange(&mut wire, 3, &[0, 0x20, 0x60, 0, 0, 0, 0, 0, 0, 0]);
    assert_eq!(answer[6..10], 0x0504_0001_u32.to_le_bytes(), "there is no transfer any more");
}

#[test]
fn every_abort_has_its_code() {
    let mut wire = drive();
    assert_eq!(wire.upload(0, 0x5000, 0), Err(0x0602_0000), "no object");
    assert_eq!(wire.upload(0, 0x1018, 9), Err(0x0609_0011), "no subindex");
    assert_eq!(wire.download(0, 0x6041, 0, &[0, 0]), Err(0x0601_0002), "read-only");
    assert_eq!(wire.download(0, 0x6040, 0, &[0, 0, 0]), Err(0x0607_0012), "too long");
    assert_eq!(wire.download(0, 0x6040, 0, &[0]), Err(0x0607_0013), "too short");
    assert_eq!(wire.download(0, 0x605a, 0, &[7, 0]), Err(0x0609_0031), "too high");
    assert_eq!(wire.download(0, 0x605a, 0, &[0xff, 0xff]), Err(0x0609_0032), "too low");
    assert_eq!(wire.download(0, 0x1c12, 1, &[1, 0x16]), Err(0x0601_0003), "the number is not 0");
    assert_eq!(wire.download(0, 0x1600, 1, &[0; 4]), Err(0x0601_0003), "the number is not 0");
    assert_eq!(wire.download(0, 0x1c12, 0, &[0]), Ok(()));
    assert_eq!(wire.download(0, 0x1c12, 1, &[0, 0x50]), Err(0x0609_0030), "no such PDO");
    assert_eq!(wire.download(0, 0x1600, 0, &[0]), Ok(()));
    assert_eq!(wire.download(0, 0x1600, 1, &0x6064_0020_u32.to_le_bytes()), Err(0x0604_0041), "an input");
    assert_eq!(wire.download(0, 0x1600, 1, &0x6040_0020_u32.to_le_bytes()), Err(0x0607_0010), "16 bits");
    assert_eq!(wire.download(0, 0x1600, 1, &0x5000_0020_u32.to_le_bytes()), Err(0x0602_0000), "no object");
    assert_eq!(wire.download(0, 0x1600, 0, &[200]), Err(0x0609_0031), "more than there is room for");
    let answer = wire.sdo(0, 0xe0, 0x6040, 0, &[]);
    assert_eq!(answer[4..8], 0x0504_0001_u32.to_le_bytes(), "unknown command");
    let answer = wire.sdo(0, 0x21, 0x6040, 0, &0x0100_0000_u32.to_le_bytes());
    assert_eq!(answer[4..8], 0x0504_0005_u32.to_le_bytes(), "more than memory");
    wire.drive_to_safe_op_after_mapping();
    assert_eq!(wire.download(0, 0x1c12, 0, &[0]), Err(0x0800_0022), "not in this state");
}

impl Wire {
    /// Torque again, then SAFE-OP.
    fn drive_to_safe_op_after_mapping(&mut self) {
        assert_eq!(self.request(0, 1), (1, 0));
        for (at, mapped) in [0x6040_0010_u32, 0x6071_0010, 0x6060_0008, 0x0000_0008].into_iter().enumerate() {
            assert!(self.segment.device_mut(0).unwrap().set_object(
                0x1600,
                at as u8 + 1,
                &mapped.to_le_bytes()
            ));
        }
        let device = self.segment.device_mut(0).unwrap();
        assert!(device.set_object(0x1600, 0, &[4]) && device.set_object(0x1c12, 0, &[1]));
        assert!(device.set_object(0x1c12, 1, &[0, 0x16]));
        self.drive_to_safe_op(0, 0x100, 0x200);
    }
}

#[test]
fn a_mapping_can_be_changed_and_then_counts() {
    let mut wire = drive();
    assert_eq!(wire.download(0, 0x1600, 0, &[0]), Ok(()));
    assert_eq!(wire.download(0, 0x1600, 1, &0x60ff_0020_u32.to_le_bytes()), Ok(()));
    assert_eq!(wire.download(0, 0x1600, 2, &0x6040_0010_u32.to_le_bytes()), Ok(()));
    assert_eq!(wire.download(0, 0x1600, 0, &[2]), Ok(()));
    wire.sync_manager(0, 2, 0x1200, 6, 0x64);
    wire.sync_manager(0, 3, 0x1800, 16, 0x20);
    assert_eq!(wire.request(0, 4), (4, 0));
    wire.write(0, 0x1200, &[1, 2, 3, 4, 6, 0]);
    assert_eq!(wire.request(0, 8), (8, 0));
    wire.write(0, 0x1200, &[1, 2, 3, 4, 6, 0]);
    assert_eq!(wire.upload(0, 0x60ff, 0), Ok(vec![1, 2, 3, 4]));
    assert_eq!(wire.upload(0, 0x6040, 0), Ok(vec![6, 0]));
}

#[test]
fn an_object_goes_up_and_down_as_a_whole_or_not_at_all() {
    let mut wire = drive();
    let answer = wire.sdo(0, 0x50, 0x1018, 0, &[]);
    assert_eq!(answer[4..8], 18_u32.to_le_bytes());
    assert_eq!(answer[8..10], [4, 0]);
    assert_eq!(answer[10..14], 0x51e37_u32.to_le_bytes());
    let without_count = wire.sdo(0, 0x50, 0x1018, 1, &[]);
    assert_eq!(without_count[8..], answer[10..]);
    // Assignment of one other PDO: number with padding, index.
    assert_eq!(wire.sdo(0, 0x31, 0x1c12, 0, &[4, 0, 0, 0, 1, 0, 0x01, 0x16])[0], 0x60);
    assert_eq!(wire.upload(0, 0x1c12, 1), Ok(vec![0x01, 0x16]));
    // The second of two does not exist: nothing changes.
    let answer = wire.sdo(0, 0x31, 0x1c12, 0, &[6, 0, 0, 0, 2, 0, 0x02, 0x16, 0x00, 0x50]);
    assert_eq!(answer[4..8], 0x0609_0030_u32.to_le_bytes());
    assert_eq!((wire.upload(0, 0x1c12, 0), wire.upload(0, 0x1c12, 1)), (Ok(vec![1]), Ok(vec![0x01, 0x16])));
}

fn information(wire: &mut Wire, operation: u8, data: &[u8]) -> Vec<Vec<u8>> {
    let mut content = vec![0, 0x80, operation, 0, 0, 0];
    content.extend(data);
    let mut answers = vec![wire.exchange(0, 3, &content)];
    while answers.last().unwrap()[2] & 0x80 != 0 {
        let next = wire.fetch(0).expect("another fragment");
        answers.push(next);
    }
    answers
}

#[test]
fn lists_come_in_fragments_that_count_down() {
    let mut wire = drive();
    let lengths = information(&mut wire, 1, &[0, 0]).remove(0);
    assert_eq!((lengths[1], lengths[2]), (0x80, 2));
    let all = usize::from(u16::from_le_bytes([lengths[8], lengths[9]]));
    // Another device, whose small mailbox makes fragments.
    let answers = information(&mut wire, 1, &[1, 0]);
    let octets: Vec<u8> = answers.iter().flat_map(|answer| answer[6..].to_vec()).collect();
    let indices: Vec<u16> =
        octets[2..].chunks(2).map(|pair| u16::from_le_bytes([pair[0], pair[1]])).collect();
    assert_eq!(indices.len(), all);
    assert!(indices.is_sorted() && indices.contains(&0x1018) && indices.contains(&0x6502));
    let left: Vec<u8> = answers.iter().map(|answer| answer[4]).collect();
    assert_eq!(left, (0..answers.len() as u8).rev().collect::<Vec<_>>());
    for kind in 2..=5 {
        let list = information(&mut wire, 1, &[kind, 0]);
        assert!(list.iter().map(Vec::len).sum::<usize>() > 8, "list {kind}");
    }
    let refused = information(&mut wire, 1, &[6, 0]).remove(0);
    assert_eq!((refused[2], &refused[6..10]), (7, &0x0609_0030_u32.to_le_bytes()[..]));
}

#[test]
fn objects_and_entries_are_described() {
    let mut wire = drive();
    let object = information(&mut wire, 3, &[0x18, 0x10]).remove(0);
    assert_eq!((object[2], object[10], object[11]), (4, 4, 9), "five entries of a record");
    assert_eq!(&object[12..], b"Identity");
    let entry = information(&mut wire, 5, &[0x40, 0x60, 0, 0]).remove(0);
    assert_eq!(entry[2], 6);
    assert_eq!(entry[10..16], [6, 0, 16, 0, 0x7f, 0], "U16, 16 bits, read and write, outputs");
    assert_eq!(&entry[16..], b"Controlword");
    let limited = information(&mut wire, 5, &[0x5a, 0x60, 0, 0x70]).remove(0);
    assert_eq!(limited[9], 0x70);
    assert_eq!(limited[16..22], [2, 0, 0, 0, 6, 0], "value, smallest, largest");
    assert_eq!(information(&mut wire, 3, &[0, 0x50]).remove(0)[2], 7);
    assert_eq!(information(&mut wire, 5, &[0x40, 0x60, 1, 0]).remove(0)[2], 7);
    assert_eq!(information(&mut wire, 9, &[0, 0]).remove(0)[2], 7);
}

#[test]
fn messages_that_are_not_understood_are_refused_with_a_reason() {
    let mut wire = drive();
    for (kind, content, detail) in [
        (1, &[0_u8; 10][..], 2),
        (5, &[0; 10], 2),
        (3, &[0], 6),
        (3, &[0, 0x20], 6),
        (3, &[0, 0x20, 0x40, 0, 0x10], 6),
        (3, &[0, 0x40, 0, 0, 0, 0, 0, 0, 0, 0], 4),
    ] {
        assert_eq!(wire.exchange(0, kind, content), [1, 0, detail, 0], "{kind} {content:?}");
    }
    // A length that is longer than the mailbox.
    let mut message = vec![0xff, 0xff, 0, 0, 0, 0x03];
    message.resize(256, 0);
    wire.write(0, 0x1000, &message);
    assert_eq!(wire.fetch(0), Some(vec![1, 0, 8, 0]));
}

#[test]
fn a_repeated_request_is_answered_once() {
    let mut wire = drive();
    let mut message = vec![10, 0, 0, 0, 0, 0x13, 0, 0x20, 0x40, 0x18, 0x10, 1, 0, 0, 0, 0];
    message.resize(256, 0);
    wire.write(0, 0x1000, &message);
    assert!(wire.fetch(0).is_some());
    wire.write(0, 0x1000, &message);
    assert_eq!(wire.fetch(0), None);
}

#[test]
fn a_lost_answer_is_sent_once_more_on_request() {
    let mut wire = drive();
    let first = wire.exchange(0, 3, &[0, 0x20, 0x40, 0x18, 0x10, 1, 0, 0, 0, 0]);
    // The master has read the answer and lost it: it toggles its bit, the device confirms and repeats.
    wire.write(0, 0x080e, &[3]);
    assert_eq!(wire.fetch(0), Some(first.clone()));
    assert_eq!(wire.read(0, 0x080f, 1)[0] & 2, 2);
    // Also where the next answer is already there; that one follows.
    wire.post(0, 3, &[0, 0x20, 0x40, 0x18, 0x10, 2, 0, 0, 0, 0]);
    wire.wait_ms(1);
    wire.write(0, 0x080e, &[1]);
    assert_eq!(wire.fetch(0), Some(first));
    assert_eq!(wire.fetch(0).unwrap()[5], 2);
}

#[test]
fn a_full_mailbox_takes_nothing_and_an_empty_one_gives_nothing() {
    let mut wire = drive();
    let read = wire.send(wire::FPRD, wire::STATION, 0x1100, &[0; 256]);
    assert_eq!(read.counter, 0, "empty");
    wire.post(0, 3, &[0, 0x20, 0x40, 0x18, 0x10, 1, 0, 0, 0, 0]);
    assert_eq!(wire.send(wire::FPWR, wire::STATION, 0x1000, &[0; 256]).counter, 0, "full");
    assert_eq!(wire.send(wire::FPWR, wire::STATION, 0x1100, &[0; 256]).counter, 0, "wrong direction");
    assert_eq!(wire.send(wire::FPRD, wire::STATION, 0x1000, &[0; 256]).counter, 0, "wrong direction");
    assert!(wire.fetch(0).is_some());
}

#[test]
fn emergencies_come_through_the_mailbox() {
    let mut wire = drive();
    wire.segment.device_mut(0).unwrap().send_emergency(0x3210, 5, [1, 2, 3, 4, 5]);
    assert_eq!(wire.fetch(0), Some(vec![0, 0x10, 0x10, 0x32, 5, 1, 2, 3, 4, 5]));
}
