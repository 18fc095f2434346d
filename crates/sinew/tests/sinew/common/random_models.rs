//! Models of every kind that an identification gives, sampled at random.

use sinew::predictor::{
    Axis, AxisForce, AxisMotion, AxisSlip, CableColumns, CableModel, Feature, Input, InputLimits, MemoryLaw,
    Model, ObservedCable, Role, Signal,
};
use sinew::random::Random;
use sinew::transmission::{BasisTerm, Branch, ClampCell, Perceptron, PerceptronWeights, Warming};

/// Kinds of [`model`], in turn.
pub(crate) const KINDS: [&str; 8] =
    ["cell", "hybrid", "pair", "observer", "observer-network", "paper", "force", "motion"];

/// Numbers between two bounds.
pub(crate) struct Draw(Random);

impl Draw {
    pub(crate) fn new(seed: u64) -> Self {
        Self(Random::new(seed))
    }

    pub(crate) fn between(&mut self, low: f64, high: f64) -> f64 {
        low + (high - low) * self.0.unit()
    }

    pub(crate) fn yes(&mut self, probability: f64) -> bool {
        self.0.unit() < probability
    }
}

fn input(column: &str, role: Role) -> Input {
    Input { column: column.into(), role }
}

/// A model of kind `seed % 8` with random parameters.
pub(crate) fn model(seed: u64) -> Model {
    let mut draw = Draw::new(seed);
    let mut model = super::capstan();
    model.guards[0].jump = draw.between(5.0, 60.0);
    model.provenance.far_range = 150.0;
    match KINDS[seed as usize % KINDS.len()] {
        "cell" => model.estimator.law = cell(&mut draw),
        "hybrid" => {
            model.estimator.law = cell(&mut draw);
            learn(&mut model, &mut draw, vec![Feature::CellState, Feature::Stop { signal: 0, radius: 8.0 }]);
        }
        "pair" => pair(&mut model, &mut draw),
        "observer" => observer(&mut model, &mut draw),
        "observer-network" => {
            observer(&mut model, &mut draw);
            model.estimator.law.signals = vec![Signal::Input(0), Signal::Input(1)];
            let features = vec![
                Feature::Innovation,
                Feature::LowPassDifference { signal: 0, tau_s: 0.05 },
                Feature::CellWidth,
            ];
            learn(&mut model, &mut draw, features);
        }
        "paper" => paper(&mut model, &mut draw),
        "force" => force(&mut model, &mut draw),
        _ => motion(&mut model, &mut draw),
    }
    model.validate().unwrap();
    model
}

/// Bounds that rise with the tension, elasticity that never moves the far side the other way.
fn cell(draw: &mut Draw) -> MemoryLaw {
    let pulled = draw.between(0.2, 0.9);
    let (offset, elastic) = (draw.between(0.0, 8.0), draw.yes(0.6));
    let narrow = Branch { width: draw.between(0.2, 0.9), fraction: draw.between(0.1, 0.6) };
    let branches = if draw.yes(0.5) {
        vec![Branch { width: 1.0, fraction: 1.0 - narrow.fraction }, narrow]
    } else {
        vec![Branch { width: 1.0, fraction: 1.0 }]
    };
    let cell = ClampCell {
        basis: vec![BasisTerm::Signal(0), BasisTerm::One],
        low: vec![pulled, -offset],
        high: vec![pulled + draw.between(0.1, 1.5), offset],
        elastic: if elastic { vec![0] } else { vec![] },
        kappa: if elastic { vec![draw.between(0.0, 0.3)] } else { vec![] },
        start: draw.between(0.0, 1.0),
        branches,
    };
    MemoryLaw { signals: vec![Signal::Input(0)], cell: Some(cell), cable: None, axis: None, features: vec![] }
}

/// A gated ensemble on these features.
fn learn(model: &mut Model, draw: &mut Draw, features: Vec<Feature>) {
    let size = draw.between(0.05, 0.5) as f32;
    let mut ensemble = super::ensemble(features.len(), 3);
    for row in ensemble.output_weights.iter_mut().chain(&mut ensemble.skip) {
        row.iter_mut().for_each(|weight| *weight *= size);
    }
    model.estimator.law.features = features;
    model.estimator.ensemble = Some(ensemble);
    model.estimator.gate_power = draw.yes(0.8).then(|| draw.between(0.01, 2.0));
}

/// Two antagonistic tensions to a torque: the first one is commanded.
fn pair(model: &mut Model, draw: &mut Draw) {
    model.inputs.push(input("tension_back_n", Role::Effort));
    model.guards.push(model.guards[0]);
    let slope = draw.between(2.0, 9.0);
    let half = draw.between(0.2, 3.0);
    model.estimator.law = MemoryLaw {
        signals: vec![Signal::LogRatio { first: 0, second: 1, offset: 1.0 }, Signal::Difference(0, 1)],
        cell: Some(ClampCell {
            basis: vec![BasisTerm::Signal(0), BasisTerm::One],
            low: vec![slope, -half],
            high: vec![slope, half],
            elastic: vec![],
            kappa: vec![],
            start: 0.5,
            branches: vec![Branch { width: 1.0, fraction: 1.0 }],
        }),
        cable: None,
        axis: None,
        features: vec![],
    };
    model.provenance.far_range = 20.0;
}

fn observer(model: &mut Model, draw: &mut Draw) {
    model.inputs.push(input("motor_mm", Role::Motion));
    model.inputs.push(input("anchor_m", Role::Anchor));
    // The motor counts either way, in millimetres.
    let motor_scale = if draw.yes(0.5) { 1e-3 } else { -1e-3 };
    model.guards.push(InputLimits { jump: draw.between(2.0, 40.0), low: -400.0, high: 400.0, typical: 0.0 });
    model.guards.push(InputLimits { jump: 0.05, low: -0.4, high: 0.4, typical: 0.0 });
    let mut cable = CableModel::bench();
    cable.parameters.friction *= draw.between(0.3, 1.3);
    cable.parameters.pretension *= draw.between(0.2, 1.2);
    cable.far_gain = draw.between(0.9, 1.1);
    cable.start = draw.between(-1.0, 1.0);
    cable.learning = if draw.yes(0.5) { 1.0 } else { 0.0 };
    cable.warming =
        draw.yes(0.5).then(|| Warming { rate: draw.between(0.0, 5e-3), time: draw.between(1.0, 100.0) });
    cable.zero_stretch = draw.yes(0.3).then(|| draw.between(-0.01, 0.01));
    let tension_scale = if cable.far_gain > 1.05 { 1.25 } else { 1.0 };
    let columns =
        CableColumns { tension: 0, motor: 1, anchor: 2, tension_scale, motor_scale, anchor_scale: 1.0 };
    model.estimator.law = MemoryLaw {
        signals: vec![],
        cell: None,
        cable: Some(ObservedCable { columns, model: cable }),
        axis: None,
        features: vec![],
    };
}

/// One network on the present tension, rising with it.
fn paper(model: &mut Model, draw: &mut Draw) {
    let mut positive = |n: usize, size: f64| (0..n).map(|_| draw.between(0.1, size)).collect::<Vec<f64>>();
    let weights = PerceptronWeights {
        inputs: 2,
        hidden: 4,
        input_weights: positive(8, 0.02),
        hidden_bias: positive(4, 0.5),
        output_weights: positive(4, 20.0),
        output_bias: 0.0,
        skip: positive(2, 0.5),
    };
    model.estimator.law = MemoryLaw {
        signals: vec![Signal::Input(0)],
        cell: None,
        cable: None,
        axis: None,
        features: vec![Feature::Signal(0), Feature::LowPassDifference { signal: 0, tau_s: 0.02 }],
    };
    model.estimator.perceptron = Some(Perceptron::new(weights).unwrap());
}

/// A force from a position, which is commanded.
fn force(model: &mut Model, draw: &mut Draw) {
    model.inputs = vec![input("position_m", Role::Motion)];
    model.guards = vec![InputLimits { jump: 0.05, low: -0.5, high: 0.5, typical: 0.0 }];
    model.estimator.law = MemoryLaw {
        signals: vec![Signal::Input(0)],
        cell: None,
        cable: None,
        axis: Some(Axis::Force(AxisForce {
            position: Some(0),
            velocity: None,
            velocity_gain: 1.0,
            tau_s: draw.between(0.005, 0.05),
            mass: draw.between(0.1, 2.0),
            damping: draw.between(0.0, 20.0),
            stiffness: draw.between(50.0, 900.0),
            slips: vec![AxisSlip { distance: draw.between(1e-4, 1e-2), force: draw.between(0.0, 20.0) }],
            gains: vec![],
            offset: draw.between(-5.0, 5.0),
        })),
        features: vec![],
    };
    model.provenance.far_range = 300.0;
}

/// A velocity or position from a force, which is commanded.
fn motion(model: &mut Model, draw: &mut Draw) {
    let far_is_velocity = draw.yes(0.5);
    model.guards = vec![InputLimits { jump: 200.0, low: -100.0, high: 100.0, typical: 0.0 }];
    model.estimator.law = MemoryLaw {
        signals: vec![Signal::Input(0)],
        cell: None,
        cable: None,
        axis: Some(Axis::Motion(AxisMotion {
            force: 0,
            gain: draw.between(0.5, 2.0),
            damping: draw.between(1.0, 10.0),
            stiffness: draw.between(0.0, 30.0),
            friction: draw.between(0.0, 3.0),
            bias: draw.between(-1.0, 1.0),
            offset: draw.between(-1.0, 1.0),
            far_is_velocity,
        })),
        features: vec![],
    };
    model.provenance.far_range = 4.0;
}
