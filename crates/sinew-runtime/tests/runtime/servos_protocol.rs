//! Packets of Dynamixel protocol 2.0 and of Feetech servos: octets of the manuals, any data both ways, any
//! octets without a panic.

use proptest::prelude::*;
use sinew_runtime::servos::protocol::instruction::{FAST_SYNC_READ, PING, READ, STATUS, WRITE};
use sinew_runtime::servos::protocol::{
    BROADCAST, Decoder, Protocol, encode, encode_fast_block, encode_fast_head,
};

/// Instruction, parameters and octets.
type Golden<'a> = (u8, &'a [&'a [u8]], &'a [u8]);

#[test]
fn packets_are_those_of_the_manual() {
    let golden: [Golden<'_>; 3] = [
        (PING, &[], &[0xff, 0xff, 0xfd, 0, 1, 3, 0, 1, 0x19, 0x4e]),
        (READ, &[&[132, 0, 4, 0]], &[0xff, 0xff, 0xfd, 0, 1, 7, 0, 2, 0x84, 0, 4, 0, 0x1d, 0x15]),
        (
            WRITE,
            &[&[116, 0], &[0, 2, 0, 0]],
            &[0xff, 0xff, 0xfd, 0, 1, 9, 0, 3, 0x74, 0, 0, 2, 0, 0, 0xca, 0x89],
        ),
    ];
    for (instruction, parts, octets) in golden {
        let mut out = Vec::new();
        encode(&mut out, 1, instruction, parts);
        assert_eq!(out, octets);
    }
}

#[test]
fn packets_of_feetech_are_those_of_its_handbook() {
    let golden: [Golden<'_>; 3] = [
        (PING, &[], &[0xff, 0xff, 1, 2, 1, 0xfb]),
        (READ, &[&[0x38, 2]], &[0xff, 0xff, 1, 4, 2, 0x38, 2, 0xbe]),
        (WRITE, &[&[0x2a], &[0, 8, 0, 0, 0xe8, 3]], &[0xff, 0xff, 1, 9, 3, 0x2a, 0, 8, 0, 0, 0xe8, 3, 0xd5]),
    ];
    for (instruction, parts, octets) in golden {
        let mut out = Vec::new();
        Protocol::Feetech.instruct(&mut out, 1, instruction, parts);
        assert_eq!(out, octets);
    }
}

/// Octets in which headers and stuffed sequences are frequent.
fn octet() -> impl Strategy<Value = u8> {
    prop_oneof![4 => Just(0xff), 2 => Just(0xfd), 1 => Just(0), 4 => any::<u8>()]
}

/// Feeds a stream in pieces and collects identifier, error and data of all packets.
fn decoded(stream: &[u8], piece: usize, fast: Option<usize>) -> Vec<(u8, u8, Vec<u8>)> {
    answers(Protocol::Dynamixel, stream, piece, fast)
}

fn answers(protocol: Protocol, stream: &[u8], piece: usize, fast: Option<usize>) -> Vec<(u8, u8, Vec<u8>)> {
    let (mut decoder, mut found) = (Decoder::new(protocol, true), Vec::new());
    for octets in stream.chunks(piece) {
        decoder.feed(octets);
        while let Some(packet) = decoder.next(fast) {
            found.push((packet.id, packet.error, packet.data.to_vec()));
        }
    }
    found
}

proptest! {
    #[test]
    fn any_packets_come_back_from_a_stream_with_noise_between_them(
        packets in proptest::collection::vec((0_u8..253, proptest::collection::vec(octet(), 0..60)), 1..8),
        // The beginning of a header before a packet would be a part of it.
        noise in proptest::collection::vec(0_u8..0xfd, 0..20),
        piece in 1_usize..40,
    ) {
        let mut stream = Vec::new();
        for (id, data) in &packets {
            stream.extend(&noise);
            encode(&mut stream, *id, WRITE, &[data]);
        }
        let expected: Vec<_> = packets.into_iter().map(|(id, data)| (id, 0, data)).collect();
        prop_assert_eq!(decoded(&stream, piece, None), expected);
    }

    #[test]
    fn any_answers_of_feetech_come_back_from_a_stream_with_noise_between_them(
        packets in proptest::collection::vec(
            (0_u8..253, any::<u8>(), proptest::collection::vec(octet(), 0..60)), 1..8,
        ),
        noise in proptest::collection::vec(0_u8..0xff, 0..20),
        piece in 1_usize..40,
    ) {
        let mut stream = Vec::new();
        for (id, error, data) in &packets {
            stream.extend(&noise);
            Protocol::Feetech.answer(&mut stream, *id, *error, data);
        }
        prop_assert_eq!(answers(Protocol::Feetech, &stream, piece, None), packets);
    }

    #[test]
    fn no_packet_holds_a_header_but_its_own(data in proptest::collection::vec(octet(), 0..60)) {
        let mut out = Vec::new();
        encode(&mut out, 3, WRITE, &[&data]);
        let header = [0xff, 0xff, 0xfd, 0];
        prop_assert!(!out[4..out.len() - 2].windows(4).any(|octets| octets == header));
    }

    #[test]
    fn a_packet_with_any_octet_changed_is_no_packet(
        data in proptest::collection::vec(octet(), 0..30), place in any::<prop::sample::Index>(), change in 1_u8..,
    ) {
        let mut out = Vec::new();
        encode(&mut out, 3, WRITE, &[&data]);
        let place = place.index(out.len());
        out[place] ^= change;
        prop_assert!(decoded(&out, 7, None).is_empty());
    }

    #[test]
    fn blocks_of_a_fast_sync_read_are_given_out_up_to_the_first_that_is_missing(
        servos in 1_usize..12, silent in 0_usize..12, data in proptest::collection::vec(octet(), 10),
        piece in 1_usize..40,
    ) {
        let mut stream = Vec::new();
        encode_fast_head(&mut stream, servos, data.len());
        for servo in 0..servos.min(silent) {
            encode_fast_block(&mut stream, 0, (servo as u8 + 1, 0x80), &data);
        }
        let found = decoded(&stream, piece, Some(data.len()));
        let expected: Vec<_> = (0..servos.min(silent)).map(|k| (k as u8 + 1, 0x80, data.clone())).collect();
        prop_assert_eq!(found, expected);
    }
}

#[test]
fn the_answer_to_a_fast_sync_read_is_one_packet_to_those_who_expect_none() {
    let mut stream = Vec::new();
    encode_fast_head(&mut stream, 2, 4);
    encode_fast_block(&mut stream, 0, (1, 0), &[1, 2, 3, 4]);
    encode_fast_block(&mut stream, 0, (2, 0), &[5, 6, 7, 8]);
    assert_eq!(stream.len(), 8 + 2 * 8);
    let found = decoded(&stream, 100, None);
    assert_eq!((found.len(), found[0].0), (1, BROADCAST));
    let mut request = Vec::new();
    encode(&mut request, BROADCAST, FAST_SYNC_READ, &[&[126, 0, 4, 0], &[1, 2]]);
    encode(&mut request, 1, STATUS, &[&[0x80, 7]]);
    assert_eq!(decoded(&request, 5, Some(4))[1], (1, 0x80, vec![7]));
}

/// Random octets, of which a third are of headers, instructions and lengths, so that packets begin often.
fn play(protocol: Protocol, count: usize, seed: u64) -> usize {
    let mut state = seed;
    let mut random = || {
        state ^= state << 13;
        state ^= state >> 7;
        state ^= state << 17;
        state
    };
    let (mut decoder, mut found, mut done) = (Decoder::new(protocol, seed.is_multiple_of(2)), 0, 0);
    let mut octets = Vec::new();
    while done < count {
        octets.clear();
        match random() % 8 {
            0 => octets.extend([0xff, 0xff, 0xfd, 0, BROADCAST, (random() % 40) as u8, 0, STATUS]),
            1 => protocol.instruct(&mut octets, random() as u8, random() as u8, &[&random().to_le_bytes()]),
            2 => octets.extend([0xff, 0xff, 0xfd, 0, random() as u8, random() as u8, random() as u8]),
            3 => {
                encode_fast_head(&mut octets, 3, 4);
                encode_fast_block(&mut octets, 0, (1, 0), &[1, 2, 3, 4]);
            }
            _ => octets.extend((0..random() % 64).map(|k| (k ^ random()) as u8)),
        }
        if random() % 16 == 0 && !octets.is_empty() {
            let place = random() as usize % octets.len();
            octets[place] ^= 1 << (random() % 8);
        }
        done += octets.len();
        decoder.feed(&octets);
        let fast = (random() % 2 == 0).then_some((random() % 20) as usize);
        while decoder.next(fast).is_some() {
            found += 1;
        }
    }
    found
}

#[test]
fn two_million_random_octets_break_no_decoder() {
    for protocol in [Protocol::Dynamixel, Protocol::Feetech] {
        assert!(play(protocol, 2_000_000, 7) > 1000, "packets are found among them");
    }
}

#[test]
fn long_twenty_million_random_octets_break_no_decoder() {
    if std::env::var_os("SINEW_LONG").is_some() {
        assert!(play(Protocol::Dynamixel, 20_000_000, 11) > 10_000);
        assert!(play(Protocol::Feetech, 20_000_000, 11) > 10_000);
    }
}
