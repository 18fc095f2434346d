//! Cost of one step of the cable law: per cable, by number of cells, in lanes of eight and alone.

#![allow(clippy::unwrap_used, reason = "a benchmark may panic")]

use divan::{Bencher, black_box, counter::ItemsCount};
use sinew::predictor::{CableModel, CableObserver, CableSample};
use sinew::transmission::Sliding;
use sinew::transmission::cable::{
    Cable, CableBatch, CableLaw, CableParameters, CablePath, EndMotion, EndTensions, Weakening,
};
use sinew::twin::cable::{CablePlant, CablePlants, CableReading, Resolution, Specimen};

fn main() {
    divan::main();
}

/// Steps per measured call: a motion with reversals of both ends, so that nodes stick and slip as in life.
const STEPS: usize = 256;

fn motions(count: usize) -> Vec<Vec<EndMotion>> {
    let one = |step: usize, cable: usize| {
        let t = step as f64 * std::f64::consts::TAU / STEPS as f64;
        let phase = cable as f64 * 0.4;
        EndMotion { motor: 1e-4 * (t + phase).sin(), anchor: 6e-5 * (t + 1.3 * phase + 0.5).cos() }
    };
    (0..STEPS).map(|step| (0..count).map(|cable| one(step, cable)).collect()).collect()
}

fn law(cells: usize, parameters: &CableParameters) -> CableLaw {
    CableLaw::new(&CablePath::bench(), parameters, cells).unwrap()
}

fn lanes(bencher: Bencher, cells: usize, count: usize, parameters: &CableParameters) {
    let mut cables = CableBatch::new(&vec![law(cells, parameters); count]).unwrap();
    for cable in 0..count {
        cables.settle(cable, 60.0 + cable as f64, Sliding::TowardMotor).unwrap();
    }
    let motions = motions(count);
    let mut ends = vec![EndTensions::default(); count];
    bencher.counter(ItemsCount::new(STEPS * count)).bench_local(|| {
        for motion in &motions {
            cables.step(1e-3, black_box(motion), &mut ends).unwrap();
        }
        ends[0].tension_in
    });
}

/// Items are cable-steps: 1 s over the rate is the time of one.
#[divan::bench(args = [8, 12, 16])]
fn eight(bencher: Bencher, cells: usize) {
    lanes(bencher, cells, 8, &CableParameters::bench());
}

#[divan::bench(args = [8, 12, 16])]
fn fifteen(bencher: Bencher, cells: usize) {
    lanes(bencher, cells, 15, &CableParameters::bench());
}

#[divan::bench(args = [12])]
fn fifteen_with_stribeck(bencher: Bencher, cells: usize) {
    let weakening = Some(Weakening::rational(0.3, 3e-3, 0.05));
    lanes(bencher, cells, 15, &CableParameters { weakening, ..CableParameters::bench() });
}

#[divan::bench(args = [8, 12, 16])]
fn one(bencher: Bencher, cells: usize) {
    let mut cable = Cable::new(law(cells, &CableParameters::bench()));
    cable.settle(60.0, Sliding::TowardMotor).unwrap();
    let motions = motions(1);
    bencher.counter(ItemsCount::new(STEPS)).bench_local(|| {
        let mut sum = 0.0;
        for motion in &motions {
            sum += cable.step(1e-3, black_box(motion[0])).unwrap().tension_in;
        }
        sum
    });
}

/// One cable of the plant with every effect.
#[divan::bench]
fn plant(bencher: Bencher) {
    let mut plant = CablePlant::new(&Specimen::bench(), Resolution::default()).unwrap();
    plant.settle(60.0, Sliding::TowardMotor).unwrap();
    let motions = motions(1);
    bencher.counter(ItemsCount::new(STEPS)).bench_local(|| {
        let mut sum = 0.0;
        for motion in &motions {
            sum += plant.step(1e-3, black_box(motion[0])).unwrap().tension_in;
        }
        sum
    });
}

/// Fifteen cables of the plant; items are cable-steps.
#[divan::bench(args = [12, 24])]
fn plants(bencher: Bencher, cells: usize) {
    let specimens: Vec<Specimen> = (0..15).map(Specimen::draw).collect();
    let mut plants = CablePlants::new(&specimens, Resolution { cells, substeps: cells / 12 }).unwrap();
    for cable in 0..15 {
        plants.settle(cable, 60.0, Sliding::TowardMotor).unwrap();
    }
    let motions = motions(15);
    let mut readings = vec![CableReading::default(); 15];
    bencher.counter(ItemsCount::new(STEPS * 15)).bench_local(|| {
        for motion in &motions {
            plants.step(1e-3, black_box(motion), &mut readings).unwrap();
        }
        readings[0].tension_in
    });
}

#[divan::bench]
fn observer(bencher: Bencher) {
    let mut observer = CableObserver::new(&CableModel::bench()).unwrap();
    let motions = motions(1);
    bencher.counter(ItemsCount::new(STEPS)).bench_local(|| {
        let mut sample = CableSample { motor: 0.0, anchor: 0.0, tension_in: 60.0 };
        let mut sum = 0.0;
        for motion in &motions {
            sample.motor += motion[0].motor;
            sample.anchor += motion[0].anchor;
            sum += observer.step(1e-3, black_box(&sample)).tension_out;
        }
        sum
    });
}
