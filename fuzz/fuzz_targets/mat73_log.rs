//! Any bytes that start like an HDF5 file.
#![no_main]

libfuzzer_sys::fuzz_target!(
    // A panic that our reader catches from another is an error as promised; one that reaches us still aborts.
    init: std::panic::set_hook(Box::new(|_| {})),
    |bytes: &[u8]| {
        if bytes.starts_with(b"\x89HDF\r\n\x1a\n") {
            sinew_fuzz::read_log(bytes);
        }
    }
);
