//! Time of a step of exported C and of the library, for the table of docs/export.md; with SINEW_LONG alone.

use crate::bits::bytes;
use crate::compiler::{compile, compilers, run};
use crate::models::{INPUTS, Kind, model};
use crate::samples::Row;
use rand::SeedableRng;
use rand_chacha::ChaCha8Rng;
use sinew::predictor::{Model, Predictor, Sample};
use sinew_export::{Name, c};
use std::time::Instant;

const ROWS: usize = 10_000;
const PASSES: usize = 60;

/// Reads rows, passes over them again and again; writes the shortest pass, ns a row.
const HARNESS: &str = r#"
#define _POSIX_C_SOURCE 199309L
#include "exported.h"
#include <stdio.h>
#include <time.h>
static double rows[10000][2 + EXPORTED_INPUTS];
static double now(void)
{
    struct timespec t;
    clock_gettime(CLOCK_MONOTONIC, &t);
    return 1e9 * (double)t.tv_sec + (double)t.tv_nsec;
}
int main(void)
{
    static exported_state state;
    double best = 1e300, sum = 0.0;
    int pass, k;
    if (fread(rows, sizeof rows, 1, stdin) != 1) {
        return 1;
    }
    for (pass = 0; pass < 60; pass++) {
        double time = now();
        exported_init(&state);
        for (k = 0; k < 10000; k++) {
            sum += exported_step(&state, rows[k][1], rows[k] + 2).mean;
        }
        time = (now() - time) / 10000.0;
        best = time < best ? time : best;
    }
    return fwrite(&best, sizeof best, 1, stdout) != 1 || sum - sum != 0.0;
}
"#;

/// A log of 100 Hz: travel to and fro with the tensions that belong to it.
fn log() -> Vec<Row> {
    let row = |k: usize| {
        let t = 0.01 * k as f64;
        let (tension, motor) = (80.0 + 40.0 * (0.9 * t).sin(), 0.03 * (0.9 * t).sin());
        let inputs: [f64; INPUTS] = [tension, 0.6 * tension, motor, 0.9 * motor];
        Row { reset: false, time_s: t, inputs }
    };
    (0..ROWS).map(row).collect()
}

/// ns a row, in the library as these tests are compiled.
fn library(model: &Model, rows: &[Row]) -> f64 {
    let mut best = f64::INFINITY;
    for _ in 0..PASSES {
        let mut predictor = Predictor::new(model.clone()).unwrap();
        let begin = Instant::now();
        let step = |row: &Row| predictor.step(&Sample { time_s: row.time_s, inputs: &row.inputs }).mean;
        let sum: f64 = rows.iter().map(step).sum();
        assert!(sum.is_finite());
        best = best.min(begin.elapsed().as_secs_f64() * 1e9 / ROWS as f64);
    }
    best
}

#[test]
fn long_times_of_a_step_in_c_and_in_the_library() {
    if std::env::var_os("SINEW_LONG").is_none() {
        println!("skipped: SINEW_LONG is not set");
        return;
    }
    let rows = log();
    for kind in Kind::ALL {
        let mut random = ChaCha8Rng::seed_from_u64(1000 * kind as u64);
        let model = model(kind, &mut random);
        let folder = tempfile::tempdir().unwrap();
        for file in c::library(&model, &Name::new("exported").unwrap(), c::Content::Predictor).unwrap() {
            std::fs::write(folder.path().join(&file.path), &file.bytes).unwrap();
        }
        std::fs::write(folder.path().join("harness.c"), HARNESS).unwrap();
        println!("{kind:?}: library {:.0} ns", library(&model, &rows));
        for compiler in compilers() {
            for flags in [["-std=c99", "-O2"].as_slice(), &["-std=c99", "-O3", "-march=native"]] {
                compile(compiler, folder.path(), &["exported.c", "harness.c"], flags);
                let best = run(folder.path(), &bytes(&rows), &[]);
                let best = f64::from_ne_bytes(best.try_into().unwrap());
                println!("{kind:?}: {compiler} {} {best:.0} ns", flags[1..].join(" "));
            }
        }
    }
}
