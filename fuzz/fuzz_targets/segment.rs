//! Frames, time and faults on a line of simulated EtherCAT devices, as the tests of the crate play them.
#![no_main]

#[path = "../../crates/sinew-segment/tests/fuzzing/mod.rs"]
mod fuzzing;

use libfuzzer_sys::fuzz_target;

fuzz_target!(|octets: &[u8]| {
    fuzzing::play(octets);
});
