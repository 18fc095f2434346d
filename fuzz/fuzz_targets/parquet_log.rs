//! Any bytes that start like a Parquet file.
#![no_main]

libfuzzer_sys::fuzz_target!(|bytes: &[u8]| {
    if bytes.starts_with(b"PAR1") {
        sinew_fuzz::read_log(bytes);
    }
});
