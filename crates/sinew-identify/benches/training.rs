//! Cost of training a network on all samples at once.

use divan::{Bencher, black_box, counter::ItemsCount};
use sinew_identify::fit::perceptron::{TrainOptions, train};

fn main() {
    divan::main();
}

fn block(rows: usize, p: usize) -> Vec<f64> {
    (0..rows * p).map(|i| (i as f64 * 0.7).sin()).collect()
}

/// Samples, steps: the size of the paper, a session of a minute, a handful.
const TRAININGS: [(usize, usize); 3] = [(500_000, 4), (60_000, 10), (2_000, 50)];

/// 4 inputs, 30 nodes; items are samples times steps.
#[divan::bench(args = TRAININGS, sample_count = 5)]
fn training(bencher: Bencher, (samples, steps): (usize, usize)) {
    let inputs = block(samples, 4);
    let targets: Vec<f64> = inputs.chunks_exact(4).map(|x| (x[0] + 2.0 * x[1]).sin() * x[2]).collect();
    let options = TrainOptions { hidden: 30, steps, tolerance: 0.0, ..TrainOptions::default() };
    bencher
        .counter(ItemsCount::new(samples * steps))
        .bench_local(|| train(black_box(&inputs), &targets, &options));
}
