//! Random models of every kind that an identification can give.

use rand::RngExt;
use rand_chacha::ChaCha8Rng;
use sinew::predictor::{
    Axis, AxisForce, AxisMotion, AxisSlip, CableColumns, CableModel, Ensemble, Estimator, Feature, Input,
    InputLimits, LinearLaw, LoopCheck, LoopQuantity, LoopTerm, MEMBERS, Member, MemoryLaw, Model,
    ObservedCable, Outside, PerNetwork, Provenance, Role, Signal, SpecimenMonitor,
};
use sinew::transmission::cable::{CableParameters, CablePath, Segment, Weakening, WeakeningForm};
use sinew::transmission::{BasisTerm, Branch, ClampCell, Perceptron, PerceptronWeights, Warming};

/// Inputs of every random model: two tensions, motor and anchor.
pub(crate) const INPUTS: usize = 4;

/// Everything a model is made of that changes the code.
#[derive(Debug, Clone, Copy, PartialEq, Eq)]
pub(crate) enum Kind {
    Cell,
    HybridCell,
    Network,
    Constant,
    Perceptron,
    Observer,
    HybridObserver,
    AxisForce,
    AxisMotion,
    Mean,
}

impl Kind {
    pub(crate) const ALL: [Self; 10] = [
        Self::Cell,
        Self::HybridCell,
        Self::Network,
        Self::Constant,
        Self::Perceptron,
        Self::Observer,
        Self::HybridObserver,
        Self::AxisForce,
        Self::AxisMotion,
        Self::Mean,
    ];
}

pub(crate) fn between(random: &mut ChaCha8Rng, low: f64, high: f64) -> f64 {
    low + (high - low) * random.random::<f64>()
}

fn some(random: &mut ChaCha8Rng, most: usize) -> usize {
    random.random_range(0..=most)
}

fn often(random: &mut ChaCha8Rng) -> bool {
    random.random_bool(0.5)
}

pub(crate) fn model(kind: Kind, random: &mut ChaCha8Rng) -> Model {
    let mut law =
        MemoryLaw { signals: signals(random), cell: None, cable: None, axis: None, features: vec![] };
    let (mut ensemble, mut perceptron) = (None, None);
    match kind {
        Kind::Cell | Kind::HybridCell => law.cell = Some(cell(random, law.signals.len())),
        Kind::Observer | Kind::HybridObserver => law.cable = Some(cable(random)),
        Kind::AxisForce => law.axis = Some(Axis::Force(axis_force(random, law.signals.len()))),
        Kind::AxisMotion => law.axis = Some(Axis::Motion(axis_motion(random))),
        Kind::Network | Kind::Constant | Kind::Perceptron | Kind::Mean => {}
    }
    match kind {
        Kind::HybridCell | Kind::Network | Kind::HybridObserver => {
            law.features = features(random, law.signals.len());
            ensemble = Some(networks(random, law.features.len(), 9));
        }
        Kind::AxisForce | Kind::AxisMotion if often(random) => {
            law.features = features(random, law.signals.len());
            ensemble = Some(networks(random, law.features.len(), 3));
        }
        Kind::Constant => ensemble = Some(networks(random, 0, 0)),
        Kind::Perceptron => {
            law.features = features(random, law.signals.len());
            perceptron = Some(plain_network(random, law.features.len()));
            if often(random) {
                law.cell = Some(cell(random, law.signals.len()));
            }
        }
        _ => {}
    }
    let gate_power = often(random).then(|| between(random, 0.0, 5.0));
    let sigma0 = between(random, 0.0, 2.0);
    let mut estimator = Estimator { ensemble, gate_power, perceptron, sigma0, ..Estimator::of(law) };
    if kind == Kind::Mean {
        add_members(&mut estimator, random, 2);
    }
    let model = Model {
        far: "tension_out_n".into(),
        inputs: [
            ("tension_in_n", Role::Effort),
            ("second \"?\u{3f}/\" [N] */", Role::Effort),
            ("motor_m", Role::Motion),
            ("anchor_m", Role::Anchor),
        ]
        .map(|(column, role)| Input { column: column.into(), role })
        .into(),
        units: std::collections::BTreeMap::new(),
        time: Some("time_s".into()),
        trial: Some("trial".into()),
        guards: guards(),
        gap_s: 0.5,
        estimator,
        specimen: often(random).then(|| monitor(random)),
        offset: None,
        outside: often(random).then(|| Outside { band_factor: between(random, 0.5, 9.0), sides: vec![] }),
        band_factor: between(random, 0.5, 4.0),
        provenance: Provenance {
            member: format!("{kind:?}"),
            description: "sampled at random /* */ \u{e4}".into(),
            program: "a test".into(),
            seed: 1,
            logs: vec![],
            samples: 0,
            rmse_unseen: 1.0,
            far_range: 200.0,
        },
    };
    model.validate().unwrap();
    model
}

fn numbers(random: &mut ChaCha8Rng, count: usize, low: f64, high: f64) -> Vec<f64> {
    (0..count).map(|_| between(random, low, high)).collect()
}

/// Its limits are such that loops are found to be those of another specimen now and then.
fn monitor(random: &mut ChaCha8Rng) -> SpecimenMonitor {
    let mut check = |quantity| {
        let all = [
            LoopTerm::Level,
            LoopTerm::LevelSquared,
            LoopTerm::Speed,
            LoopTerm::Stroke,
            LoopTerm::Given(some(random, INPUTS - 1)),
        ];
        let terms: Vec<LoopTerm> = all.into_iter().filter(|_| often(random)).collect();
        let n = terms.len();
        LoopCheck {
            quantity,
            terms,
            mean: numbers(random, n, -50.0, 100.0),
            inverse_scale: numbers(random, n, 0.001, 0.1),
            offset: between(random, 0.0, 80.0),
            weights: numbers(random, n, -5.0, 5.0),
            // Now and then no variance.
            covariance: numbers(random, n * n, -0.01, 0.1),
            trials: 1 + some(random, 20),
            deviation: between(random, 1.0, 30.0),
            scatter: between(random, 0.0, 50.0),
            limit: between(random, 0.5, 8.0),
        }
    };
    let checks = [LoopQuantity::Height, LoopQuantity::Slope, LoopQuantity::Level].map(&mut check).into();
    let (effort, motion) = (some(random, 1), 2 + some(random, 1));
    SpecimenMonitor { effort, motion, reversal: f64::powf(10.0, between(random, -5.0, -2.0)), checks }
}

fn guards() -> Vec<InputLimits> {
    let of = |jump, low, high, typical| InputLimits { jump, low, high, typical };
    vec![
        of(60.0, 0.0, 250.0, 80.0),
        of(60.0, -5.0, 200.0, 40.0),
        of(0.02, -0.3, 0.3, 0.0),
        of(0.06, -0.3, 0.3, 0.0),
    ]
}

/// The first is the first input, the last two are motor and anchor.
fn signals(random: &mut ChaCha8Rng) -> Vec<Signal> {
    let mut list = vec![Signal::Input(0)];
    if often(random) {
        list.push(Signal::Difference(0, 1));
    }
    if often(random) {
        list.push(Signal::LogTension { input: 0, offset: between(random, 0.1, 5.0) });
        list.push(Signal::LogRatio { first: 0, second: 1, offset: between(random, 0.1, 5.0) });
    }
    list.extend([Signal::Input(2), Signal::Input(3)]);
    list
}

fn cell(random: &mut ChaCha8Rng, signals: usize) -> ClampCell {
    let mut basis = vec![BasisTerm::Signal(0), BasisTerm::One];
    if often(random) {
        basis.push(BasisTerm::Product(0, signals - 1));
        basis.push(BasisTerm::Product(signals - 2, signals - 1));
    }
    let elastic: Vec<usize> = if often(random) { vec![0, signals - 2] } else { vec![] };
    let branches = 1 + some(random, 3);
    ClampCell {
        low: basis.iter().map(|_| between(random, -0.2, 0.8)).collect(),
        high: basis.iter().map(|_| between(random, 0.3, 1.4)).collect(),
        kappa: elastic.iter().map(|_| between(random, -0.5, 1.0)).collect(),
        branches: (0..branches)
            .map(|k| Branch {
                width: if k == 0 { 1.0 } else { between(random, 0.1, 1.0) },
                fraction: 1.0 / branches as f64,
            })
            .collect(),
        basis,
        elastic,
        start: between(random, 0.0, 1.0),
    }
}

fn features(random: &mut ChaCha8Rng, signals: usize) -> Vec<Feature> {
    let mut list = vec![Feature::Signal(some(random, signals - 1))];
    for _ in 0..some(random, 7) {
        let signal = some(random, signals - 1);
        list.push(match some(random, 6) {
            0 => Feature::Signal(signal),
            1 => Feature::Stop { signal, radius: between(random, 0.01, 5.0) },
            2 => Feature::LowPassDifference { signal, tau_s: between(random, 0.01, 1.0) },
            3 => Feature::CellState,
            4 => Feature::CellWidth,
            5 => Feature::CellPosition,
            _ => Feature::Innovation,
        });
    }
    list
}

/// A regression on features of the past in half of the cases, and members that are cells, networks on a
/// regression, or such sums themselves.
fn add_members(estimator: &mut Estimator, random: &mut ChaCha8Rng, depth: usize) {
    if estimator.ensemble.is_none() && often(random) {
        regress(estimator, random);
    }
    for _ in 0..=some(random, 2) {
        let kind = [Kind::HybridCell, Kind::Network, Kind::Cell][some(random, 2)];
        let mut member = model(kind, random).estimator;
        if kind == Kind::Network {
            regress(&mut member, random);
            member.ensemble = often(random).then(|| networks(random, member.law.features.len(), 5));
        }
        if depth > 1 && often(random) {
            add_members(&mut member, random, depth - 1);
        }
        let (weight, inside) = (between(random, 0.1, 1.0), often(random));
        estimator.members.push(Member { weight, inside, estimator: member });
    }
}

/// A regression on features of the past, some of them clipped.
fn regress(estimator: &mut Estimator, random: &mut ChaCha8Rng) {
    let law = &mut estimator.law;
    let signal = some(random, law.signals.len() - 1);
    law.features = vec![
        Feature::Rate(signal),
        Feature::Previous(0),
        Feature::Sign { feature: 0, scale: between(random, 0.1, 9.0) },
        Feature::BelowMaximum(signal),
        Feature::AboveMinimum(signal),
        Feature::Product { feature: 2, signal },
        Feature::Clamped { signal, low: -4.0, high: 3.0 },
    ];
    law.features.extend(features(random, law.signals.len()));
    let count = law.features.len();
    estimator.linear = Some(LinearLaw {
        offset: between(random, -2.0, 2.0),
        weights: (0..count).map(|_| between(random, -1.0, 1.0)).collect(),
    });
}

fn networks(random: &mut ChaCha8Rng, features: usize, most_nodes: usize) -> Ensemble {
    let hidden = if features == 0 { 0 } else { some(random, most_nodes) };
    let mut rows = |count: usize| -> Vec<PerNetwork> {
        let mut number = || between(random, -1.5, 1.5) as f32;
        (0..count).map(|_| std::array::from_fn(|_| number())).collect()
    };
    let (hidden_weights, hidden_bias, output_weights) = (rows(hidden * features), rows(hidden), rows(hidden));
    let (skip, bias): (_, [f32; MEMBERS]) = (rows(features), rows(1)[0]);
    Ensemble {
        clip_low: (0..features).map(|_| between(random, -60.0, 0.0)).collect(),
        clip_high: (0..features).map(|_| between(random, 0.0, 150.0)).collect(),
        mean: (0..features).map(|_| between(random, -1.0, 40.0)).collect(),
        inverse_scale: (0..features).map(|_| between(random, 0.01, 1.0)).collect(),
        hidden_weights,
        hidden_bias,
        output_weights,
        skip,
        bias,
    }
}

fn plain_network(random: &mut ChaCha8Rng, inputs: usize) -> Perceptron {
    let hidden = 1 + some(random, 29);
    let skip = if often(random) { inputs } else { 0 };
    let mut many = |count: usize| -> Vec<f64> { (0..count).map(|_| between(random, -0.3, 0.3)).collect() };
    Perceptron::new(PerceptronWeights {
        inputs,
        hidden,
        input_weights: many(inputs * hidden),
        hidden_bias: many(hidden),
        output_weights: many(hidden),
        output_bias: many(1)[0],
        skip: many(skip),
    })
    .unwrap()
}

fn cable(random: &mut ChaCha8Rng) -> ObservedCable {
    let mut segments = vec![
        Segment::Free { length: between(random, 0.05, 0.3) },
        Segment::Sheath {
            length: between(random, 0.3, 1.2),
            bend: between(random, 0.5, 5.0),
            curvature: vec![],
        },
    ];
    if often(random) {
        segments.push(Segment::Pulley { wrap: between(random, 0.1, 2.0) });
    }
    segments.push(Segment::Free { length: between(random, 0.1, 0.8) });
    let form = WeakeningForm::ALL[some(random, 1)];
    let weakening = Weakening { form, ..Weakening::rational(between(random, 0.05, 0.4), 4e-3, 0.02) };
    let parameters = CableParameters {
        friction: between(random, 0.02, 0.17),
        viscous: between(random, 0.0, 0.1),
        efficiency: between(random, 0.9, 1.0),
        drag: between(random, 0.0, 120.0),
        weakening: (some(random, 2) > 0).then_some(weakening),
        ..CableParameters::bench()
    };
    let warming = often(random)
        .then(|| Warming { rate: between(random, 0.0, 5e-3), time: between(random, 1.0, 100.0) });
    let model = CableModel {
        path: CablePath::new(segments).unwrap(),
        parameters,
        cells: 3 + some(random, 9),
        far_gain: between(random, 0.9, 1.1),
        start: between(random, -1.0, 1.0),
        correction: between(random, 0.0, 6e-3),
        learning: if often(random) { between(random, 0.1, 20.0) } else { 0.0 },
        warming,
        zero_stretch: (some(random, 2) == 0).then(|| between(random, -2e-3, 2e-2)),
    };
    let columns = CableColumns {
        tension: 0,
        motor: 2,
        anchor: 3,
        tension_scale: if model.far_gain > 1.05 { 1.25 } else { 1.0 },
        motor_scale: 1.0,
        anchor_scale: 1.0,
    };
    match model.law() {
        Ok(_) => ObservedCable { columns, model },
        // Too much friction for one node: another draw.
        Err(_) => cable(random),
    }
}

fn axis_force(random: &mut ChaCha8Rng, signals: usize) -> AxisForce {
    let (position, velocity) = [(true, false), (false, true), (true, true)][some(random, 2)];
    AxisForce {
        position: position.then_some(signals - 2),
        velocity: velocity.then_some(signals - 1),
        velocity_gain: between(random, 0.5, 2.0),
        tau_s: between(random, 1e-3, 0.05),
        mass: between(random, 0.0, 2.0),
        damping: between(random, -1.0, 5.0),
        stiffness: between(random, 0.0, 100.0),
        slips: (0..some(random, 4))
            .map(|_| AxisSlip { distance: between(random, 1e-4, 0.05), force: between(random, 0.0, 5.0) })
            .collect(),
        gains: (0..some(random, 2)).map(|i| (i, between(random, -1.0, 1.0))).collect(),
        offset: between(random, -1.0, 1.0),
    }
}

fn axis_motion(random: &mut ChaCha8Rng) -> AxisMotion {
    AxisMotion {
        force: 0,
        gain: between(random, 0.001, 0.1),
        damping: between(random, 0.1, 5.0),
        stiffness: if often(random) { between(random, 0.1, 50.0) } else { 0.0 },
        friction: between(random, 0.0, 1.0),
        bias: between(random, -0.5, 0.5),
        offset: between(random, -0.1, 0.1),
        far_is_velocity: often(random),
    }
}
