//! Cost of one prediction, by part: memory, networks.

use divan::{Bencher, black_box};
use sinew::predictor::{
    Axis, AxisForce, AxisMotion, AxisSlip, Ensemble, Feature, MEMBERS, Memory, MemoryLaw, PerNetwork, Signal,
};
use sinew::transmission::{BasisTerm, Branch, ClampCell};

fn main() {
    divan::main();
}

/// Two signals with three stops and `taus` low-passes each, a cell of three branches.
fn law(taus: usize) -> MemoryLaw {
    let mut features = Vec::new();
    for signal in 0..2 {
        features.push(Feature::Signal(signal));
        features.extend([0.02, 0.08, 0.25].map(|radius| Feature::Stop { signal, radius }));
        features.extend(
            (0..taus).map(|k| Feature::LowPassDifference { signal, tau_s: 0.05 * 4_f64.powi(k as i32) }),
        );
    }
    features.extend([Feature::CellState, Feature::CellWidth, Feature::CellPosition]);
    let branch = |(width, fraction)| Branch { width, fraction };
    MemoryLaw {
        signals: vec![Signal::Input(0), Signal::Input(1)],
        cell: Some(ClampCell {
            basis: vec![BasisTerm::Signal(0), BasisTerm::Signal(1), BasisTerm::One],
            low: vec![0.5, 0.1, -0.2],
            high: vec![0.6, 0.1, 0.2],
            elastic: vec![0, 1],
            kappa: vec![0.1, 0.1],
            start: 0.5,
            branches: [(1.0, 0.5), (0.8, 0.3), (0.5, 0.2)].map(branch).to_vec(),
        }),
        cable: None,
        axis: None,
        features,
    }
}

fn ensemble(features: usize, hidden: usize) -> Ensemble {
    let mut k = 0.0_f32;
    let mut lanes = || -> PerNetwork {
        core::array::from_fn(|_| {
            k += 1.0;
            0.3 * k.sin()
        })
    };
    Ensemble {
        clip_low: vec![-2.0; features],
        clip_high: vec![2.0; features],
        mean: vec![0.1; features],
        inverse_scale: vec![1.1; features],
        hidden_weights: (0..hidden * features).map(|_| lanes()).collect(),
        hidden_bias: (0..hidden).map(|_| lanes()).collect(),
        output_weights: (0..hidden).map(|_| lanes()).collect(),
        skip: (0..features).map(|_| lanes()).collect(),
        bias: [0.0; MEMBERS],
    }
}

/// A motion that reverses now and then, as real ones do.
fn inputs() -> [[f64; 2]; 64] {
    core::array::from_fn(|i| [(i as f64 * 0.098).sin(), (i as f64 * 0.196).cos()])
}

#[divan::bench(args = [0, 1, 3])]
fn memory_step(bencher: Bencher, taus: usize) {
    let law = law(taus);
    let mut memory = Memory::new(&law);
    let inputs = inputs();
    let mut i = 0;
    bencher.bench_local(|| {
        i = (i + 1) % inputs.len();
        memory.step(&law, 0.01, black_box(&inputs[i]));
        memory.features()[0]
    });
}

/// An axis without networks, as force and as motion.
#[divan::bench(args = ["force", "motion"])]
fn axis_step(bencher: Bencher, kind: &str) {
    let slip = |distance| AxisSlip { distance, force: 10.0 };
    let force = AxisForce {
        position: Some(0),
        velocity: None,
        velocity_gain: 1.0,
        tau_s: 0.01,
        mass: 90.0,
        damping: 200.0,
        stiffness: 0.0,
        slips: [1e-4, 1e-3, 1e-2].map(slip).to_vec(),
        gains: vec![],
        offset: 0.0,
    };
    let motion = AxisMotion {
        force: 0,
        gain: 0.01,
        damping: 2.0,
        stiffness: 0.0,
        friction: 0.2,
        bias: 0.0,
        offset: 0.0,
        far_is_velocity: true,
    };
    let axis = if kind == "force" { Axis::Force(force) } else { Axis::Motion(motion) };
    let law = MemoryLaw {
        signals: vec![Signal::Input(0)],
        cell: None,
        cable: None,
        axis: Some(axis),
        features: vec![],
    };
    let mut memory = Memory::new(&law);
    let inputs = inputs();
    let mut i = 0;
    bencher.bench_local(|| {
        i = (i + 1) % inputs.len();
        memory.step(&law, 0.001, black_box(&inputs[i][..1]));
        memory.cell().state
    });
}

#[divan::bench(args = [(8, 6), (11, 6), (13, 8), (17, 6), (17, 10)])]
fn evaluate(bencher: Bencher, (features, hidden): (usize, usize)) {
    let ensemble = ensemble(features, hidden);
    let x: Vec<f64> = (0..features).map(|i| (i as f64).sin()).collect();
    let mut scratch = vec![0.0; features];
    bencher.bench_local(|| ensemble.evaluate(black_box(&x), &mut scratch));
}

/// Memory and networks: the whole of a prediction but its account.
#[divan::bench(args = [(0, 6), (1, 6), (3, 6), (3, 8), (3, 10)])]
fn prediction(bencher: Bencher, (taus, hidden): (usize, usize)) {
    let law = law(taus);
    let ensemble = ensemble(law.features.len(), hidden);
    let mut memory = Memory::new(&law);
    let mut scratch = vec![0.0; law.features.len()];
    let inputs = inputs();
    let mut i = 0;
    bencher.bench_local(|| {
        i = (i + 1) % inputs.len();
        memory.step(&law, 0.01, black_box(&inputs[i]));
        ensemble.evaluate(memory.features(), &mut scratch).median
    });
}
