//! Commands of generated C against those of the compensator, bit by bit.

use crate::compiler::{Build, builds, compile, first_difference, one_in_turn, rows_of, run};
use crate::models::{INPUTS, Kind, between, model};
use crate::samples::{Row, rows};
use rand::{RngExt, SeedableRng};
use rand_chacha::ChaCha8Rng;
use sinew::compensator::{Command, Compensator, CompensatorSettings};
use sinew::predictor::{Model, Sample};
use sinew::transmission::Sliding;
use sinew_export::{Name, c};

/// Reads rows from standard input, writes commands: 0 resets before, 1 observes, 2 commands, 3 steps. Of a
/// cable the direction that is expected stands behind the inputs.
const HARNESS: &str = r#"
#include "exported.h"
#include <stdio.h>
int main(void)
{
    static exported_compensator compensator;
    double row[5 + EXPORTED_INPUTS], out[8];
    exported_compensator_init(&compensator);
    while (fread(row, sizeof row, 1, stdin) == 1) {
        exported_command u;
        if (row[0] > 0.0) {
            exported_compensator_reset(&compensator);
        }
#ifdef CABLE
        exported_compensator_expect_sliding(&compensator, row[4 + EXPORTED_INPUTS]);
#endif
        if (row[1] < 1.5) {
            exported_compensator_observe(&compensator, row[2], row + 4);
            continue;
        }
        u = row[1] < 2.5 ? exported_compensator_command(&compensator, row[2], row + 4, row[3])
                         : exported_compensator_step(&compensator, row[2], row + 4, row[3]);
        out[0] = u.value;
        out[1] = u.low;
        out[2] = u.high;
        out[3] = u.mean;
        out[4] = u.standard_deviation;
        out[5] = u.gate;
        out[6] = (double)u.evaluations;
        out[7] = (double)u.flags;
        if (fwrite(out, sizeof out, 1, stdout) != 1) {
            return 1;
        }
    }
    return 0;
}
"#;

/// What is asked at a row.
#[derive(Debug, Clone, Copy)]
enum Ask {
    Observe = 1,
    Command = 2,
    Step = 3,
}

#[derive(Debug, Clone, Copy)]
struct Question {
    row: Row,
    ask: Ask,
    desired: f64,
    /// The direction that is expected; 0 or NaN where none is.
    direction: f64,
}

/// Rows as bad as logs get, of which some are measured and others commanded, with desired far ends that move,
/// jump and are missing.
fn questions(count: usize, model: &Model, near: usize, random: &mut ChaCha8Rng) -> Vec<Question> {
    let range = model.provenance.far_range;
    let rows = rows(count, random);
    let (mut style, mut desired, mut direction) = (0, 0.5 * range, 0.0);
    let ask = |(k, mut row): (usize, Row)| {
        if k % 100 == 0 {
            style = random.random_range(0..3);
            direction = [0.0, 1.0, -0.3, f64::NAN][k / 100 % 4];
        }
        desired += 0.01 * range * between(random, -1.0, 1.0);
        if random.random_bool(0.01) {
            desired = range * between(random, -0.3, 1.5);
        }
        let ask = match style {
            0 => [Ask::Observe, Ask::Command][k % 2],
            _ => Ask::Step,
        };
        if style == 1 {
            row.inputs[near] = f64::NAN;
        }
        if random.random_bool(0.3) {
            row.inputs[random.random_range(0..INPUTS)] = f64::NAN;
        }
        let desired = if random.random_bool(0.02) { f64::NAN } else { desired };
        Question { row, ask, desired, direction }
    };
    rows.into_iter().enumerate().map(ask).collect()
}

fn bits_of(command: &Command) -> [u64; 8] {
    let flags: u32 = command.flags.named().iter().enumerate().map(|(k, (_, set))| u32::from(*set) << k).sum();
    let Command { value, low, high, mean, standard_deviation, gate, evaluations, .. } = *command;
    [value, low, high, mean, standard_deviation, gate, f64::from(evaluations), f64::from(flags)]
        .map(f64::to_bits)
}

fn commanded(compensator: &mut Compensator, questions: &[Question]) -> Vec<[u64; 8]> {
    let answer = |question: &Question| {
        let Question { row, ask, desired, direction } = question;
        if row.reset {
            compensator.reset();
        }
        compensator.expect_sliding(Sliding::from_velocity(*direction));
        let sample = Sample { time_s: row.time_s, inputs: &row.inputs };
        let command = match ask {
            Ask::Observe => {
                compensator.observe(&sample);
                return None;
            }
            Ask::Command => compensator.command(&sample, *desired),
            Ask::Step => compensator.step(&sample, *desired),
        };
        Some(bits_of(&command))
    };
    questions.iter().filter_map(answer).collect()
}

fn bytes(questions: &[Question]) -> Vec<u8> {
    let numbers = questions.iter().flat_map(|Question { row, ask, desired, direction }| {
        let head = [f64::from(u8::from(row.reset)), f64::from(*ask as u8), row.time_s, *desired];
        head.into_iter().chain(row.inputs).chain([*direction])
    });
    numbers.flat_map(f64::to_ne_bytes).collect()
}

/// Settings of which some are left out.
fn settings(random: &mut ChaCha8Rng) -> CompensatorSettings {
    CompensatorSettings {
        rate: random.random_bool(0.5).then(|| between(random, 0.1, 500.0)),
        tolerance: random.random_bool(0.5).then(|| between(random, 0.0, 1.0)),
        ..CompensatorSettings::default()
    }
}

/// Commands over rows, in builds.
#[track_caller]
fn compare(kind: Kind, seed: u64, count: usize, builds: Vec<Build>) {
    let mut random = ChaCha8Rng::seed_from_u64(1000 * kind as u64 + seed);
    let model = model(kind, &mut random);
    let settings = settings(&mut random);
    let mut compensator = match Compensator::new(model.clone(), &settings) {
        Ok(compensator) => compensator,
        Err(error) => panic!("{kind:?} {seed}: {error}"),
    };
    let questions = questions(count, &model, compensator.near(), &mut random);
    let expected = commanded(&mut compensator, &questions);
    let folder = tempfile::tempdir().unwrap();
    let content = c::Content::Compensator(settings);
    for file in c::library(&model, &Name::new("exported").unwrap(), content).unwrap() {
        std::fs::write(folder.path().join(&file.path), &file.bytes).unwrap();
    }
    let cable = if model.estimator.law.cable.is_some() { "#define CABLE\n" } else { "" };
    std::fs::write(folder.path().join("harness.c"), format!("{cable}{HARNESS}")).unwrap();
    let asked: Vec<&Question> = questions.iter().filter(|q| !matches!(q.ask, Ask::Observe)).collect();
    for (compiler, flags) in builds {
        compile(compiler, folder.path(), &["exported.c", "harness.c"], flags);
        let got = rows_of(&run(folder.path(), &bytes(&questions), &[]));
        if let Some((row, got, expected)) = first_difference(&got, &expected) {
            let asked = asked[row];
            panic!(
                "{kind:?} {seed} {compiler} {flags:?} {settings:?}: row {row} {asked:?}: {got:?} in C, \
                 {expected:?} in Rust"
            );
        }
    }
}

/// Models of a kind, in a build each.
#[track_caller]
fn same_bits(kind: Kind, models: u64, count: usize) {
    for seed in 0..models {
        compare(kind, 500 + seed, count, one_in_turn(builds(), 3 * kind as usize + seed as usize));
    }
}

#[test]
fn c_of_clamp_cells_and_their_hybrids_commands_the_bits_of_the_library() {
    same_bits(Kind::Cell, 5, 500);
    same_bits(Kind::HybridCell, 2, 150);
}

#[test]
fn c_of_cable_observers_and_their_hybrids_commands_the_bits_of_the_library() {
    same_bits(Kind::Observer, 6, 400);
    same_bits(Kind::HybridObserver, 2, 120);
}

#[test]
fn c_of_networks_and_axes_commands_the_bits_of_the_library() {
    same_bits(Kind::Network, 2, 150);
    same_bits(Kind::Perceptron, 2, 150);
    same_bits(Kind::Constant, 1, 150);
    same_bits(Kind::Mean, 3, 150);
    same_bits(Kind::AxisForce, 3, 300);
    same_bits(Kind::AxisMotion, 3, 300);
}

#[test]
fn the_questions_of_the_tests_reach_every_flag() {
    let mut random = ChaCha8Rng::seed_from_u64(7);
    let mut all = 0;
    for kind in [Kind::Observer, Kind::HybridCell] {
        let model = model(kind, &mut random);
        let mut compensator = Compensator::new(model.clone(), &settings(&mut random)).unwrap();
        let questions = questions(1000, &model, compensator.near(), &mut random);
        let said = commanded(&mut compensator, &questions);
        all = said.iter().fold(all, |all, bits| all | f64::from_bits(bits[7]) as u32);
    }
    assert_eq!(all, 0b1111_1111);
}

#[test]
fn long_c_of_a_hundred_models_of_every_kind_commands_the_bits_of_the_library() {
    if std::env::var_os("SINEW_LONG").is_none() {
        println!("skipped: SINEW_LONG is not set");
        return;
    }
    for kind in Kind::ALL {
        for seed in 600..612 {
            compare(kind, seed, 600, builds());
        }
    }
}
