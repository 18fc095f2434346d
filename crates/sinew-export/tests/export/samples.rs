//! Rows as bad as logs get: gaps, repeated and backward times, missing values, spikes, jumps, slack.

use crate::models::{INPUTS, between};
use rand::RngExt;
use rand_chacha::ChaCha8Rng;

/// One row: a reset before it or not, time, inputs.
#[derive(Debug, Clone, Copy)]
pub(crate) struct Row {
    pub(crate) reset: bool,
    pub(crate) time_s: f64,
    pub(crate) inputs: [f64; INPUTS],
}

/// Rows whose motion changes its character every few hundred samples.
pub(crate) fn rows(count: usize, random: &mut ChaCha8Rng) -> Vec<Row> {
    let (mut time_s, mut list) = (0.0, Vec::with_capacity(count));
    let (mut motor, mut anchor, mut tension) = (0.0, 0.0, 80.0);
    let mut character = 0;
    for k in 0..count {
        if k % 200 == 0 {
            character = random.random_range(0..6);
        }
        let dt = match random.random_range(0..400) {
            0 => 0.0,
            1 => 2.0,
            2 => -0.3,
            3 => 0.05,
            4 => 1e-9,
            _ if character == 3 => 0.01,
            _ => 1e-3,
        };
        time_s += dt;
        let t = k as f64 * 1e-3;
        match character {
            // Slow travel, fast travel, slack and back, a 100 Hz log, random jumps, rest.
            0 => (motor, anchor) = (motor + 2e-5 * (3.0 * t).sin(), anchor + 1.8e-5 * (3.0 * t).sin()),
            1 => (motor, anchor) = (motor + 4e-4 * (2.0 * t).sin(), anchor + 4e-4 * (2.0 * t).sin()),
            2 => motor += 2e-3 * (20.0 * t).sin(),
            3 => (motor, anchor) = (motor + 1e-3 * (5.0 * t).cos(), anchor + 1e-3 * (5.0 * t + 0.2).cos()),
            4 => (motor, anchor) = (between(random, -0.04, 0.04), between(random, -0.02, 0.02)),
            _ => {}
        }
        if character == 2 && k % 50 == 0 {
            motor = between(random, -0.02, 0.02);
            anchor = 0.0;
        }
        tension = f64::max(tension + between(random, -3.0, 3.0), -5.0);
        let mut inputs = [tension, 0.6 * tension + between(random, -1.0, 1.0), motor, anchor];
        if random.random_bool(0.03) {
            let bad = [f64::NAN, f64::INFINITY, 0.0, -0.0, 1e31, 999.0, -1e30][random.random_range(0..7)];
            inputs[random.random_range(0..INPUTS)] = bad;
        }
        if character == 4 && random.random_bool(0.1) {
            tension = between(random, -20.0, 300.0);
        }
        let reset = random.random_bool(0.002);
        let missing = random.random_bool(0.003);
        list.push(Row { reset, time_s: if missing { f64::NAN } else { time_s }, inputs });
    }
    list
}
