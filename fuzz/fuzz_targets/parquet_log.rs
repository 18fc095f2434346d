//! Any bytes that start like a Parquet file.
#![no_main]

libfuzzer_sys::fuzz_target!(
    // A panic that our reader catches from another is an error as promised; one that reaches us still aborts.
    init: std::panic::set_hook(Box::new(|_| {})),
    |bytes: &[u8]| {
        if bytes.starts_with(b"PAR1") {
            sinew_fuzz::read_log(bytes);
        }
    }
);
