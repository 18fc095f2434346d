//! Small models built by hand, and the arm.

#![allow(dead_code, reason = "not every test file needs every helper")]

pub(crate) mod chains;
pub(crate) mod random_models;

use sinew::body::Robot;
use sinew::machine::Machine;
use sinew::predictor::{
    Ensemble, Estimator, Feature, Input, InputLimits, MEMBERS, MemoryLaw, Model, PerNetwork, Provenance,
    Role, Signal,
};
use sinew::trajectory::{EndPointPath, Loop};
use sinew::transmission::{BasisTerm, Branch, ClampCell};

/// The arm of `models/`.
pub(crate) fn lm_arm() -> Robot {
    let text = sinew_models::LM_ARM;
    Robot::new(sinew::description::from_toml("lm_arm.toml", text).unwrap().parts).unwrap()
}

/// The machine of `models/`.
pub(crate) fn lm_machine() -> Machine {
    let text = sinew_models::LM_ARM;
    sinew::description::machine_from_toml("lm_arm.toml", text, &mut |_| Err("no other file".into()))
        .unwrap()
        .machine
}

/// Its closed path of this shape.
pub(crate) fn lm_path(shape: Loop) -> EndPointPath {
    EndPointPath::Loop { shape, center: [0.66, 0.10, -0.15], amplitude: 0.15 }
}

/// Far over near tension of [`capstan`] while it is pulled.
pub(crate) const PULLED: f64 = 0.7;
/// The same while it is released.
pub(crate) const EASED: f64 = 1.2;
/// Root mean square error of [`capstan`] in training.
pub(crate) const SIGMA_0: f64 = 0.5;

/// Capstan play of one tension: `clamp(s, 0.7 T, 1.2 T)`, no networks, no elasticity.
pub(crate) fn capstan() -> Model {
    Model {
        far: "tension_out_n".into(),
        inputs: vec![Input { column: "tension_in_n".into(), role: Role::Effort }],
        time: Some("time_s".into()),
        trial: None,
        guards: vec![InputLimits { jump: 1e6, low: 0.0, high: 500.0, typical: 50.0 }],
        gap_s: 0.5,
        estimator: Estimator {
            law: MemoryLaw {
                signals: vec![Signal::Input(0)],
                cell: Some(ClampCell {
                    basis: vec![BasisTerm::Signal(0)],
                    low: vec![PULLED],
                    high: vec![EASED],
                    elastic: vec![],
                    kappa: vec![],
                    start: 0.5,
                    branches: vec![Branch { width: 1.0, fraction: 1.0 }],
                }),
                cable: None,
                axis: None,
                features: vec![],
            },
            ensemble: None,
            gate_power: None,
            perceptron: None,
            linear: None,
            members: vec![],
            sigma0: SIGMA_0,
        },
        band_factor: 1.96,
        specimen: None,
        offset: None,
        outside: None,
        units: std::collections::BTreeMap::new(),
        provenance: Provenance {
            member: "cell".into(),
            description: "built by hand".into(),
            program: "0".into(),
            seed: 0,
            logs: vec![],
            samples: 1,
            rmse_unseen: 0.5,
            far_range: 100.0,
        },
    }
}

/// A model with every kind of signal, basis term and feature, with branches and a gated ensemble.
pub(crate) fn complete() -> Model {
    let features = vec![
        Feature::Signal(1),
        Feature::Stop { signal: 2, radius: 0.01 },
        Feature::LowPassDifference { signal: 0, tau_s: 0.05 },
        Feature::CellState,
        Feature::CellWidth,
        Feature::CellPosition,
    ];
    let ensemble = ensemble(features.len(), 3);
    let mut model = capstan();
    let input = |column: &str, role| Input { column: column.into(), role };
    model.inputs = vec![
        input("tension_in_n", Role::Effort),
        input("tension_back_n", Role::Effort),
        input("position_in_m", Role::Motion),
    ];
    let tension = InputLimits { jump: 60.0, low: 0.0, high: 200.0, typical: 50.0 };
    model.guards = vec![tension, tension, InputLimits { jump: 0.05, low: -0.1, high: 0.1, typical: 0.0 }];
    model.estimator = Estimator {
        law: MemoryLaw {
            signals: vec![
                Signal::Input(0),
                Signal::Difference(0, 1),
                Signal::Input(2),
                Signal::LogTension { input: 0, offset: 1.0 },
                Signal::LogRatio { first: 0, second: 1, offset: 1.0 },
            ],
            cell: Some(ClampCell {
                basis: vec![BasisTerm::One, BasisTerm::Signal(0), BasisTerm::Product(0, 2)],
                low: vec![-1.0, 0.7, 0.5],
                high: vec![1.0, 1.2, -0.5],
                elastic: vec![0, 2],
                kappa: vec![0.1, 50.0],
                start: 0.5,
                branches: vec![Branch { width: 1.0, fraction: 0.8 }, Branch { width: 0.5, fraction: 0.2 }],
            }),
            cable: None,
            axis: None,
            features,
        },
        ensemble: Some(ensemble),
        gate_power: Some(0.7),
        perceptron: None,
        linear: None,
        members: vec![],
        sigma0: 0.3,
    };
    model
}

/// Networks with small differences.
pub(crate) fn ensemble(features: usize, hidden: usize) -> Ensemble {
    let per_network = |k: usize, size: f32| -> PerNetwork {
        std::array::from_fn(|member| size * ((k * MEMBERS + member) as f32 * 0.7 + (k as f32)).sin())
    };
    let list = |first: usize, n: usize, size: f32| (first..first + n).map(|k| per_network(k, size)).collect();
    Ensemble {
        clip_low: vec![-200.0; features],
        clip_high: vec![200.0; features],
        mean: vec![0.5; features],
        inverse_scale: (1..=features).map(|i| 0.1 / i as f64).collect(),
        hidden_weights: list(1, hidden * features, 0.8),
        hidden_bias: list(50, hidden, 0.3),
        output_weights: list(80, hidden, 1.5),
        skip: list(100, features, 0.1),
        bias: per_network(200, 0.2),
    }
}
