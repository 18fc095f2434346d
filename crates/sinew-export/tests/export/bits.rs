//! Mean, deviation, gate and flags of generated C against the predictor's, bit by bit.

use crate::compiler::{
    Build, builds, compile, compilers, covered, first_difference, one_in_turn, rows_of, run,
};
use crate::models::{INPUTS, Kind, model};
use crate::samples::{Row, rows};
use rand::SeedableRng;
use rand_chacha::ChaCha8Rng;
use sinew::predictor::{Flags, Model, Prediction, Predictor, Sample};
use sinew_export::{Name, c};
use std::path::Path;

/// Reads rows of numbers from standard input, writes predictions as numbers.
pub(crate) const HARNESS: &str = r#"
#include "exported.h"
#include <stdio.h>
int main(void)
{
    static exported_state state;
    double row[2 + EXPORTED_INPUTS], out[4];
    exported_init(&state);
    while (fread(row, sizeof row, 1, stdin) == 1) {
        exported_prediction p;
        if (row[0] > 0.0) {
            exported_reset(&state);
        }
        p = exported_step(&state, row[1], row + 2);
        out[0] = p.mean;
        out[1] = p.standard_deviation;
        out[2] = p.gate;
        out[3] = (double)p.flags;
        if (fwrite(out, sizeof out, 1, stdout) != 1) {
            return 1;
        }
    }
    return 0;
}
"#;

fn bits_of(p: &Prediction) -> [u64; 4] {
    let Flags { state_unknown, out_of_range, input_held, reset, repeated, other_specimen } = p.flags;
    let set = [state_unknown, out_of_range, input_held, reset, other_specimen, repeated];
    let flags: u32 = set.iter().enumerate().map(|(k, set)| u32::from(*set) << k).sum();
    [p.mean, p.standard_deviation, p.gate, f64::from(flags)].map(f64::to_bits)
}

pub(crate) fn predicted(model: &Model, rows: &[Row]) -> Vec<[u64; 4]> {
    let mut predictor = Predictor::new(model.clone()).unwrap();
    let step = |row: &Row| {
        if row.reset {
            predictor.reset();
        }
        bits_of(&predictor.step(&Sample { time_s: row.time_s, inputs: &row.inputs }))
    };
    rows.iter().map(step).collect()
}

pub(crate) fn bytes(rows: &[Row]) -> Vec<u8> {
    let numbers = rows.iter().flat_map(|row| {
        let head = [f64::from(u8::from(row.reset)), row.time_s];
        head.into_iter().chain(row.inputs)
    });
    numbers.flat_map(f64::to_ne_bytes).collect()
}

fn write_sources(folder: &Path, model: &Model) {
    for file in c::library(model, &Name::new("exported").unwrap(), c::Content::Predictor).unwrap() {
        std::fs::write(folder.join(&file.path), &file.bytes).unwrap();
    }
    std::fs::write(folder.join("harness.c"), HARNESS).unwrap();
}

/// Rows that differ in any bit, over builds.
#[track_caller]
fn compare(model: &Model, rows: &[Row], builds: Vec<Build>, label: &str) {
    let folder = tempfile::tempdir().unwrap();
    write_sources(folder.path(), model);
    let expected = predicted(model, rows);
    for (compiler, flags) in builds {
        compile(compiler, folder.path(), &["exported.c", "harness.c"], flags);
        let got = rows_of(&run(folder.path(), &bytes(rows), &[]));
        if let Some((row, got, expected)) = first_difference(&got, &expected) {
            let read = rows[row];
            panic!(
                "{label} {compiler} {flags:?}: row {row} {read:?}: {got:?} in C, {expected:?} in \
                 Rust\n{model:?}"
            );
        }
    }
}

/// Models of a kind over rows, in a build each. The long test has all builds for all models.
#[track_caller]
fn same_bits(kind: Kind, models: u64, count: usize) {
    for seed in 0..models {
        let mut random = ChaCha8Rng::seed_from_u64(1000 * kind as u64 + seed);
        let model = model(kind, &mut random);
        let rows = rows(count, &mut random);
        let build = one_in_turn(builds(), 3 * kind as usize + seed as usize);
        compare(&model, &rows, build, &format!("{kind:?} {seed}"));
    }
}

#[test]
fn c_of_clamp_cells_and_their_hybrids_predicts_the_bits_of_the_library() {
    same_bits(Kind::Cell, 2, 3000);
    same_bits(Kind::HybridCell, 3, 3000);
}

#[test]
fn c_of_cable_observers_and_their_hybrids_predicts_the_bits_of_the_library() {
    same_bits(Kind::Observer, 3, 5000);
    same_bits(Kind::HybridObserver, 2, 5000);
}

#[test]
fn c_of_networks_predicts_the_bits_of_the_library() {
    same_bits(Kind::Network, 2, 2000);
    same_bits(Kind::Perceptron, 2, 2000);
    same_bits(Kind::Constant, 1, 1000);
}

#[test]
fn c_of_means_and_of_means_of_means_predicts_the_bits_of_the_library() {
    same_bits(Kind::Mean, 4, 2000);
}

#[test]
fn c_of_axes_predicts_the_bits_of_the_library() {
    same_bits(Kind::AxisForce, 3, 2000);
    same_bits(Kind::AxisMotion, 3, 2000);
}

#[test]
fn statements_side_by_side_are_not_fused_by_a_vectoriser() {
    // GCC 12 did so with the two updates of this axis, at -O3 with FMA and with contraction turned off.
    let mut random = ChaCha8Rng::seed_from_u64(1000 * Kind::AxisMotion as u64 + 101);
    let model = model(Kind::AxisMotion, &mut random);
    compare(&model, &rows(5000, &mut random), builds(), "an axis with networks");
}

#[test]
fn long_c_of_a_hundred_models_of_every_kind_predicts_the_bits_of_the_library() {
    if std::env::var_os("SINEW_LONG").is_none() {
        println!("skipped: SINEW_LONG is not set");
        return;
    }
    for kind in Kind::ALL {
        for seed in 100..112 {
            let mut random = ChaCha8Rng::seed_from_u64(1000 * kind as u64 + seed);
            let model = model(kind, &mut random);
            compare(&model, &rows(10_000, &mut random), builds(), &format!("{kind:?} {seed}"));
        }
    }
}

#[test]
fn the_rows_of_the_tests_execute_95_percent_of_the_lines_or_more() {
    let (mut executed, mut all) = (0.0, 0.0);
    for kind in Kind::ALL {
        for seed in 0..2 {
            let mut random = ChaCha8Rng::seed_from_u64(1000 * kind as u64 + seed);
            let model = model(kind, &mut random);
            let folder = tempfile::tempdir().unwrap();
            write_sources(folder.path(), &model);
            if compilers().is_empty() {
                return;
            }
            compile("cc", folder.path(), &["exported.c", "harness.c"], &["-std=c99", "-O0", "--coverage"]);
            run(folder.path(), &bytes(&rows(10_000, &mut random)), &[]);
            let Some((lines, total)) = covered(folder.path(), "exported.c") else {
                println!("skipped: no gcov for this compiler");
                return;
            };
            println!("{kind:?} {seed}: {lines:.0} of {total:.0} lines");
            (executed, all) = (executed + lines, all + total);
        }
    }
    println!("{executed:.0} of {all:.0} lines");
    assert!(executed >= 0.95 * all, "{executed} of {all}");
}

#[test]
fn the_rows_of_the_tests_reach_every_flag() {
    let mut random = ChaCha8Rng::seed_from_u64(5);
    let rows = rows(5000, &mut random);
    assert_eq!(rows[0].inputs.len(), INPUTS);
    // Not every cable that is drawn is told from another specimen.
    let seen = (0..4).flat_map(|_| predicted(&model(Kind::Observer, &mut random), &rows));
    let all = seen.fold(0, |all, bits| all | f64::from_bits(bits[3]) as u32);
    assert_eq!(all, 0b11_1111);
}
