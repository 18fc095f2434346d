//! Cost of a drive, of a whole muscle (drive, cable in its sheath and sensors), and of the bench with its
//! observer.

#![allow(clippy::unwrap_used, reason = "a benchmark may panic")]

use divan::{Bencher, black_box, counter::ItemsCount};
use sinew::control::compensation::{Compensation, ObserverCompensation};
use sinew::drive::{Drive, DriveCommand, DriveParameters};
use sinew::predictor::CableModel;
use sinew::transmission::Sliding;
use sinew::transmission::cable::{CableBatch, CableLaw, CableParameters, CablePath, EndMotion, EndTensions};
use sinew::twin::cable::Specimen;
use sinew_lab::experiment::bench::{BenchRun, MuscleControl, Programme, run};

fn main() {
    divan::main();
}

/// Steps per measured call: commands with reversals, so that all branches of drive and cable are executed.
const STEPS: usize = 256;

fn commands(kind: Kind) -> Vec<DriveCommand> {
    let wave = |k: usize| (k as f64 * std::f64::consts::TAU / STEPS as f64).sin();
    (0..STEPS)
        .map(|k| match kind {
            Kind::Velocity => DriveCommand::Velocity(0.05 * wave(k)),
            Kind::Tension => DriveCommand::Tension { tension: 100.0 + 40.0 * wave(k), feed: 0.01 * wave(k) },
        })
        .collect()
}

#[derive(Debug, Clone, Copy)]
enum Kind {
    Velocity,
    Tension,
}

/// Items are steps of one drive against a given tension.
#[divan::bench(args = [Kind::Velocity, Kind::Tension])]
fn drive(bencher: Bencher, kind: Kind) {
    let mut drive = Drive::new(DriveParameters::mc_am(), 1).unwrap();
    let commands = commands(kind);
    bencher.counter(ItemsCount::new(STEPS)).bench_local(|| {
        let mut sum = 0.0;
        for command in &commands {
            sum += drive.step(black_box(*command), 100.0, 1e-3).moved;
        }
        sum
    });
}

/// Items are steps of one muscle: drive with its sensors, and a cable of twelve cells, in lanes of eight.
#[divan::bench(args = [8, 15, 16])]
fn muscle(bencher: Bencher, count: usize) {
    let law = CableLaw::new(&CablePath::bench(), &CableParameters::bench(), 12).unwrap();
    let mut cables = CableBatch::new(&vec![law; count]).unwrap();
    let mut ends = vec![EndTensions::default(); count];
    let mut drives: Vec<Drive> = Vec::new();
    for (k, end) in ends.iter_mut().enumerate() {
        cables.settle(k, 60.0, Sliding::TowardMotor).unwrap();
        drives.push(Drive::new(DriveParameters::mc_am(), k as u64).unwrap());
        end.tension_in = 100.0;
    }
    let mut motions = vec![EndMotion { motor: 0.0, anchor: 0.0 }; count];
    let commands = commands(Kind::Tension);
    bencher.counter(ItemsCount::new(STEPS * count)).bench_local(|| {
        for command in &commands {
            for ((drive, end), motion) in drives.iter_mut().zip(&ends).zip(&mut motions) {
                motion.motor = drive.step(black_box(*command), end.tension_in, 1e-3).moved;
            }
            cables.step(1e-3, &motions, &mut ends).unwrap();
        }
        ends[0].tension_in
    });
}

/// Items are milliseconds of the bench: two drives, the plant with all its effects, sensors, observer.
#[divan::bench(sample_count = 10)]
fn bench_run(bencher: Bencher) {
    const SECONDS: f64 = 50.0;
    let desired = BenchRun::paper(Specimen::bench(), Programme::Track, 0.08, 1);
    let observer = ObserverCompensation::new(&CableModel::bench()).unwrap();
    bencher.counter(ItemsCount::new(1000 * SECONDS as usize)).bench_local(|| {
        let mut compensation = Compensation::Observer(Box::new(observer.clone()));
        let mut sum = 0.0;
        let stop =
            run(&desired, MuscleControl::Compensation(&mut compensation), SECONDS, |row| sum += row.far)
                .unwrap();
        assert!(stop.is_none());
        sum
    });
}
