//! The plain way to train, timed: 500 000 samples, 4 inputs, 30 nodes, full-batch Levenberg-Marquardt.
//!
//! `train_paper write DIRECTORY` makes the samples and the initial weights as raw little-endian f64, so that
//! other programs solve the very same problem; `train_paper time DIRECTORY STEPS` trains on them.

use sinew_identify::fit::perceptron::{TrainOptions, train};
use std::error::Error;
use std::path::Path;
use std::time::Instant;

const SAMPLES: usize = 500_000;
const INPUTS: usize = 4;
const HIDDEN: usize = 30;

fn main() -> Result<(), Box<dyn Error>> {
    let arguments: Vec<String> = std::env::args().skip(1).collect();
    let arguments: Vec<&str> = arguments.iter().map(String::as_str).collect();
    match arguments[..] {
        ["write", directory] => write_problem(Path::new(directory)),
        ["time", directory, steps] => time(Path::new(directory), steps.parse()?),
        _ => Err("usage: train_paper write DIRECTORY | train_paper time DIRECTORY STEPS".into()),
    }
}

/// A cable in its sheath, pulled to and fro: tension behind friction and stretch, with the noise of a sensor.
fn problem() -> (Vec<f64>, Vec<f64>) {
    let mut noise_state = 1_u64;
    let mut noise = move || {
        noise_state =
            noise_state.wrapping_mul(6_364_136_223_846_793_005).wrapping_add(1_442_695_040_888_963_407);
        (noise_state >> 33) as f64 / f64::from(1_u32 << 30) - 1.0
    };
    let (mut inputs, mut targets) = (Vec::with_capacity(SAMPLES * INPUTS), Vec::with_capacity(SAMPLES));
    for i in 0..SAMPLES {
        let t = i as f64 * 1e-3;
        let tension = 120.0 + 60.0 * (1.9 * t).sin() + 20.0 * (0.73 * t).sin();
        let velocity = 0.15 * (1.9 * t + 0.4).cos() * (1.0 + 0.5 * (0.11 * t).sin());
        let bend = 2.0 + 0.8 * (0.07 * t).sin();
        let length = 1.2 + 0.1 * (0.19 * t).cos();
        let slide = (velocity / 0.01).tanh();
        let far = tension * (-(0.2 + 0.3 * (-velocity.abs() / 0.05).exp()) * bend * slide).exp()
            - 8.0 * velocity * length;
        inputs.extend([tension, velocity, bend, length]);
        targets.push(far + 0.5 * noise());
    }
    (inputs, targets)
}

fn write_problem(directory: &Path) -> Result<(), Box<dyn Error>> {
    let (inputs, targets) = problem();
    let none = TrainOptions { hidden: HIDDEN, steps: 0, ..TrainOptions::default() };
    let network = train(&inputs, &targets, &none)?.network;
    let start =
        [network.hidden_weights, network.hidden_bias, network.output_weights, vec![network.output_bias]];
    for (name, numbers) in [("inputs", inputs), ("targets", targets), ("start", start.concat())] {
        let bytes: Vec<u8> = numbers.iter().flat_map(|x| x.to_le_bytes()).collect();
        std::fs::write(directory.join(name).with_extension("f64"), bytes)?;
    }
    Ok(())
}

fn read(directory: &Path, name: &str) -> Result<Vec<f64>, Box<dyn Error>> {
    let bytes = std::fs::read(directory.join(name).with_extension("f64"))?;
    Ok(bytes.as_chunks::<8>().0.iter().map(|bytes| f64::from_le_bytes(*bytes)).collect())
}

#[expect(clippy::print_stdout, reason = "a program whose product is one line of numbers")]
fn time(directory: &Path, steps: usize) -> Result<(), Box<dyn Error>> {
    let (inputs, targets) = (read(directory, "inputs")?, read(directory, "targets")?);
    let options = TrainOptions { hidden: HIDDEN, steps, tolerance: 0.0, ..TrainOptions::default() };
    let start = Instant::now();
    let training = train(&inputs, &targets, &options)?;
    let seconds = start.elapsed().as_secs_f64();
    let loss = training.loss_per_step.last().copied().unwrap_or(f64::NAN);
    println!(
        "{seconds:.3} {} {} {loss:.9e} {:.1}",
        training.steps,
        training.rejected_steps,
        peak_memory_mb()
    );
    Ok(())
}

/// Most memory this process ever held, MB; NaN where the system does not say.
fn peak_memory_mb() -> f64 {
    let status = std::fs::read_to_string("/proc/self/status").unwrap_or_default();
    let line = status.lines().find_map(|line| line.strip_prefix("VmHWM:"));
    line.and_then(|line| line.split_whitespace().next()?.parse::<f64>().ok())
        .map_or(f64::NAN, |kb| kb / 1024.0)
}
