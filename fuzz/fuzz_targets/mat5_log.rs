//! Any bytes after the header of a MATLAB v5 file, in both byte orders.
#![no_main]

libfuzzer_sys::fuzz_target!(|bytes: &[u8]| {
    let Some((order, body)) = bytes.split_first() else { return };
    let mut file = vec![b' '; 124];
    file.extend(if order & 1 == 0 { *b"\x00\x01IM" } else { *b"\x01\x00MI" });
    file.extend(body);
    sinew_fuzz::read_log(&file);
});
