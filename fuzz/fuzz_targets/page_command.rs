//! Texts as commands of the live page: each is a command within its bounds, or refused in words.
#![no_main]

use libfuzzer_sys::fuzz_target;
use sinew_live::Command;

fuzz_target!(|octets: &[u8]| {
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
});
