//! Logs made for tests: a cable that follows with play, written as text.

#![allow(dead_code, reason = "not every test file needs every helper")]
#![allow(clippy::unwrap_used, reason = "a failing test may panic")]

pub(crate) mod axes;
pub(crate) mod benches;
pub(crate) mod families;

use sinew_identify::Error;
use sinew_identify::log::{Dataset, ReadOptions, RequestedRoles, read_bytes};
use std::fmt::Write as _;

/// One sample: time, near tension, far tension.
pub(crate) type Sample = [f64; 3];

/// `n` samples at 100 Hz of a sine that the far side follows with play; `phase` tells logs apart.
pub(crate) fn samples(n: usize, phase: f64) -> Vec<Sample> {
    let mut far = 5.0_f64;
    (0..n)
        .map(|i| {
            let t = i as f64 * 0.01;
            let near = 6.0 + 3.0 * (2.0 * t + phase).sin() + 0.3 * (17.0 * t).cos();
            far = far.clamp(0.8 * near, 0.9 * near);
            [t, near, far]
        })
        .collect()
}

/// The samples as CSV with the canonical names.
pub(crate) fn csv(samples: &[Sample]) -> String {
    let mut text = String::from("t_s,tension_in_n,tension_out_n\n");
    for [t, near, far] in samples {
        writeln!(text, "{t},{near},{far}").unwrap();
    }
    text
}

/// Reads one log with options as `identify` has them.
pub(crate) fn read(text: &str, flags: &RequestedRoles) -> Result<Dataset, Error> {
    read_all(&[("log.csv", text)], flags)
}

/// Reads several logs.
pub(crate) fn read_all(logs: &[(&str, &str)], flags: &RequestedRoles) -> Result<Dataset, Error> {
    let logs: Vec<(&str, &[u8])> = logs.iter().map(|(n, t)| (*n, t.as_bytes())).collect();
    read_bytes(&logs, flags, &options())
}

/// The options of `identify`.
pub(crate) fn options() -> ReadOptions {
    ReadOptions { far_required: true, ..ReadOptions::default() }
}

/// The message of the error that reading `text` must give.
pub(crate) fn message(text: &str, flags: &RequestedRoles) -> String {
    read(text, flags).expect_err("must be refused").to_string()
}
