//! Any bytes as a text table.
#![no_main]

libfuzzer_sys::fuzz_target!(|bytes: &[u8]| sinew_fuzz::read_log(bytes));
