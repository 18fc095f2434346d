//! What comes over a wire: frames, packets, commands of the live page, and the descriptions of devices.

#[path = "../../crates/sinew-link/tests/adversary/mod.rs"]
#[allow(dead_code, unreachable_pub, reason = "the tests of the crate use more of it")]
mod adversary;
#[path = "../../crates/sinew-segment/tests/segment/fuzzing/mod.rs"]
#[allow(unreachable_pub, reason = "shared with the tests of the crate")]
mod fuzzing;

use sinew_link::wire::open;
use sinew_live::Command;
use sinew_segment::{Device, DeviceDescription, DeviceSettings};

/// Descriptions of EtherCAT devices, as a table and as an ESI file. What is accepted makes a device.
pub fn read_device(octets: &[u8]) {
    let Ok(text) = std::str::from_utf8(octets) else { return };
    for read in [DeviceDescription::from_toml("a", text), DeviceDescription::from_esi("a", text, None, None)]
    {
        match read {
            Ok(description) => {
                Device::new(&description, DeviceSettings::default()).expect("what is read is valid");
            }
            Err(error) => assert!(error.line <= text.lines().count() + 1, "{error}"),
        }
    }
}

/// Frames, time and faults on a line of simulated EtherCAT devices, as the tests of the crate play them.
pub fn play_segment(octets: &[u8]) {
    fuzzing::play(octets);
}

/// Packets of every kind and damage at the host of a link, each rejected for the reason for which it was
/// made; the bytes themselves as a datagram at both ends, which nothing but a tag makes a command or state.
pub fn play_link(octets: &[u8]) {
    let played = adversary::play(&mut adversary::Bytes(octets));
    assert_eq!(played.counters.accepted, played.expected_accepted);
    for (reason, count) in played.expected {
        assert_eq!(played.counters.rejected(reason), count, "{reason:?}");
    }
    if let Ok(received) = open(octets) {
        assert_eq!(usize::from(received.head.length), octets.len());
    }
}

/// Texts as commands of the live page: each is a command within its bounds, or refused in words.
pub fn read_page_command(octets: &[u8]) {
    let Ok(text) = std::str::from_utf8(octets) else { return };
    match Command::parse(text) {
        Ok((id, command)) => {
            assert!(id.is_null() || id.is_u64());
            let finite = match command {
                Command::Drag(place) => place.iter().all(|x| x.is_finite()),
                Command::Push { point, force, duration, .. } => {
                    point.iter().chain(&force).all(|x| x.is_finite()) && duration > 0.0
                }
                Command::Payload(mass) => mass >= 0.0 && mass.is_finite(),
                Command::Speed { factor, .. } => {
                    factor.is_none_or(|factor| factor > 0.0 && factor.is_finite())
                }
                Command::Seek(time) => time >= 0.0 && time.is_finite(),
                Command::Step(cycles) => cycles > 0,
                _ => true,
            };
            assert!(finite, "{text}");
        }
        Err((id, reason)) => assert!((id.is_null() || id.is_u64()) && !reason.is_empty()),
    }
}
