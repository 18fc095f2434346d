//! The parts of a model together: its checks, its memory, its estimates, its flags.

use super::cable::{CableModel, CableObserver, ObservedCable};
use super::*;
use crate::transmission::{BasisTerm, Branch, ClampCell, Perceptron, PerceptronWeights};
use alloc::collections::BTreeMap;
use alloc::string::String;
use alloc::vec;
use alloc::vec::Vec;

/// A change and the field that is then refused.
type Case = (fn(&mut Model), &'static str);

/// A law of two inputs and no physics.
fn law() -> MemoryLaw {
    MemoryLaw {
        signals: vec![Signal::Input(0), Signal::Input(1)],
        cell: None,
        cable: None,
        axis: None,
        features: vec![],
    }
}

/// The far side within 0.7 and 1.2 times the first signal, with elasticity in the second.
fn cell() -> ClampCell {
    ClampCell {
        basis: vec![BasisTerm::Signal(0)],
        low: vec![0.7],
        high: vec![1.2],
        elastic: vec![1],
        kappa: vec![3.0],
        branches: vec![Branch { width: 1.0, fraction: 1.0 }],
        start: 0.4,
    }
}

fn cable() -> ObservedCable {
    let columns = CableColumns {
        tension: 0,
        motor: 1,
        anchor: 2,
        tension_scale: 1.0,
        motor_scale: 1.0,
        anchor_scale: -1.0,
    };
    ObservedCable { columns, model: CableModel { far_gain: 2.0, ..CableModel::bench() } }
}

/// A force with dry friction that slips after 0.1.
fn axis() -> Axis {
    Axis::Force(AxisForce {
        position: Some(1),
        velocity: None,
        velocity_gain: 1.0,
        tau_s: 0.01,
        mass: 0.0,
        damping: 0.0,
        stiffness: 50.0,
        slips: vec![AxisSlip { distance: 0.1, force: 6.0 }],
        gains: vec![(0, 0.5)],
        offset: 1.0,
    })
}

/// Eight constants from 1 to 8 and a linear part.
fn ensemble(features: usize) -> Ensemble {
    Ensemble {
        clip_low: vec![-1.0; features],
        clip_high: vec![1.0; features],
        mean: vec![0.0; features],
        inverse_scale: vec![1.0; features],
        hidden_weights: vec![],
        hidden_bias: vec![],
        output_weights: vec![],
        skip: vec![[2.0; MEMBERS]; features],
        bias: core::array::from_fn(|lane| 1.0 + lane as f32),
    }
}

/// `0.5 + 3 x`.
fn perceptron() -> Perceptron {
    Perceptron::new(PerceptronWeights {
        inputs: 1,
        hidden: 1,
        input_weights: vec![1.0],
        hidden_bias: vec![0.0],
        output_weights: vec![0.0],
        output_bias: 0.5,
        skip: vec![3.0],
    })
    .unwrap()
}

fn model(law: MemoryLaw) -> Model {
    let input = |column: &str| Input { column: column.into(), role: Role::Effort };
    let limits = InputLimits { jump: 1e3, low: -10.0, high: 200.0, typical: 50.0 };
    Model {
        far: "far".into(),
        inputs: ["a", "b", "c"].map(input).into(),
        time: None,
        trial: None,
        guards: vec![limits; 3],
        gap_s: 0.5,
        estimator: Estimator { sigma0: 0.3, ..Estimator::of(law) },
        band_factor: 2.0,
        specimen: None,
        offset: None,
        outside: None,
        units: BTreeMap::new(),
        provenance: Provenance {
            member: "parts".into(),
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

fn with_cell() -> Model {
    model(MemoryLaw { cell: Some(cell()), ..law() })
}

/// The field that is refused in a changed model of a cell with features and networks.
fn refused(change: impl FnOnce(&mut Model)) -> Result<(), String> {
    let mut model = with_cell();
    model.estimator.law.features =
        vec![Feature::Signal(1), Feature::Stop { signal: 0, radius: 2.0 }, Feature::CellState];
    model.estimator.ensemble = Some(ensemble(3));
    change(&mut model);
    model.validate().map_err(|error| error.name)
}

fn close(a: f64, b: f64) -> bool {
    (a - b).abs() < 1e-14 * (1.0 + a.abs())
}

#[test]
fn the_band_is_wider_outside_the_ranges_of_the_training_logs() {
    let mut model = with_cell();
    let at = |model: &Model, tension: f64| {
        let mut predictor = Predictor::new(model.clone()).unwrap();
        predictor.step(&Sample { time_s: 0.0, inputs: &[tension, 0.0] })
    };
    let limit = model.guards[0].high;
    let plain = [0.9, 1.1].map(|part| at(&model, part * limit).standard_deviation);
    model.outside = Some(Outside { band_factor: 3.0 * model.band_factor, sides: vec![] });
    for (k, (part, wider)) in [(0.9, 1.0), (1.1, 3.0)].into_iter().enumerate() {
        let found = at(&model, part * limit);
        assert_eq!(found.flags.out_of_range, k == 1);
        assert!(close(found.standard_deviation, wider * plain[k]), "{found:?}");
    }
    let of = |band_factor| Some(Outside { band_factor, sides: vec![] });
    assert_eq!(refused(|model| model.outside = of(0.0)), Err("outside.band_factor".into()));
    let still = Beyond { column: "load".into(), outermost: 1.0, step: 0.0, rmse: 1.0 };
    let sides = vec![still];
    let standing = refused(|model| model.outside = Some(Outside { band_factor: 1.0, sides }));
    assert_eq!(standing, Err("outside.sides.step".into()));
}

#[test]
fn the_error_grows_beyond_one_step_on_either_side_and_not_before() {
    for sign in [1.0, -1.0] {
        let side = Beyond { column: "load".into(), outermost: 60.0, step: sign * 20.0, rmse: 2.0 };
        for (steps, factor) in [(-1.0, 1.0), (0.5, 1.0), (1.0, 1.0), (4.0, 8.0)] {
            let value = 60.0 + sign * 20.0 * steps;
            assert!((side.expected(value) - 2.0 * factor).abs() < 1e-12, "{sign} {steps}");
            assert_eq!(side.includes(value), steps > 0.0);
        }
    }
}

#[test]
fn a_reading_of_the_far_end_moves_later_predictions_by_its_shrunken_error() {
    let offset = Some(OffsetVariance { between: 3.0, within: 1.0 });
    let mut predictor = Predictor::new(Model { offset, ..with_cell() }).unwrap();
    let mut plain = Predictor::new(with_cell()).unwrap();
    assert_eq!(predictor.read_far_end(1.0), None, "before the first sample");
    let sample = |k: u32| [50.0 + f64::from(k), 20.0, 0.0];
    let mut both = |predictor: &mut Predictor, k: u32| {
        let (inputs, time_s) = (sample(k), 0.01 * f64::from(k));
        predictor.step(&Sample { time_s, inputs: &inputs }).mean
            - plain.step(&Sample { time_s, inputs: &inputs }).mean
    };
    assert!(both(&mut predictor, 0).abs() < 1e-12);
    let truth = predictor.last_mean() + 4.0;
    assert_eq!(predictor.read_far_end(f64::NAN), None);
    assert!((predictor.read_far_end(truth).unwrap() - 3.0).abs() < 1e-12, "4 times 3 over 4");
    assert!((both(&mut predictor, 1) - 3.0).abs() < 1e-12);
    // A second error of 1: (4 + 1) times 3 over 7.
    let truth = predictor.last_mean() - 3.0 + 1.0;
    assert!((predictor.read_far_end(truth).unwrap() - 15.0 / 7.0).abs() < 1e-12);
    predictor.reset();
    assert_eq!(predictor.read_far_end(1.0), None, "after a reset");
    let mut without = Predictor::new(with_cell()).unwrap();
    let _ = without.step(&Sample { time_s: 0.0, inputs: &sample(0) });
    assert_eq!(without.read_far_end(1.0), None, "folds say nothing of offsets");
}

#[test]
fn a_model_at_the_edges_of_its_domain_is_accepted() {
    let cases: [fn(&mut Model); 9] = [
        |_| (),
        |m| m.estimator.gate_power = Some(0.0),
        |m| m.estimator.sigma0 = 0.0,
        |m| m.estimator.law.features[1] = Feature::Stop { signal: 1, radius: 1e30 },
        |m| m.estimator.law.features[1] = Feature::LowPassDifference { signal: 1, tau_s: 1e-30 },
        |m| m.estimator.law.cell.as_mut().unwrap().start = 1.0,
        // Networks alone.
        |m| m.estimator.law.cell = None,
        |m| {
            m.estimator.law.cell = None;
            m.estimator.law.features.truncate(1);
            (m.estimator.ensemble, m.estimator.perceptron) = (None, Some(perceptron()));
        },
        // A box far from zero that is narrow beside its mean.
        |m| {
            let ensemble = m.estimator.ensemble.as_mut().unwrap();
            (ensemble.clip_low[0], ensemble.mean[0], ensemble.clip_high[0]) = (0.9e5, 0.9e5, 1.0e5);
        },
    ];
    for (k, change) in cases.into_iter().enumerate() {
        assert_eq!(refused(change), Ok(()), "case {k}");
    }
}

#[test]
fn a_model_beyond_the_edges_of_its_domain_is_refused_by_name() {
    fn cell_of(m: &mut Model) -> &mut ClampCell {
        m.estimator.law.cell.as_mut().unwrap()
    }
    let cases: [Case; 20] = [
        (|m| m.guards[2].jump = 0.0, "guards.jump"),
        (|m| m.estimator.gate_power = Some(-1.0), "estimator.gate_power"),
        (|m| m.estimator.gate_power = Some(f64::INFINITY), "estimator.gate_power"),
        (|m| m.estimator.law.features[0] = Feature::Signal(2), "law.features"),
        (|m| m.estimator.law.features[1] = Feature::Stop { signal: 0, radius: 0.0 }, "law.features"),
        (|m| m.estimator.law.features[1] = Feature::Stop { signal: 0, radius: -2.0 }, "law.features"),
        (
            |m| m.estimator.law.features[1] = Feature::LowPassDifference { signal: 0, tau_s: 2e30 },
            "law.features",
        ),
        (|m| cell_of(m).branches[0].width = 0.0, "cell.branches.width"),
        (|m| cell_of(m).branches[0].width = -1.0, "cell.branches.width"),
        (|m| cell_of(m).branches[0].width = 1.5, "cell.branches.width"),
        (|m| cell_of(m).elastic[0] = 2, "cell.elastic"),
        (|m| m.estimator.ensemble.as_mut().unwrap().clip_low[1] = -2e5, "ensemble.inverse_scale"),
        (|m| m.estimator.ensemble.as_mut().unwrap().clip_high[1] = 2e5, "ensemble.inverse_scale"),
        (|m| m.estimator.perceptron = Some(perceptron()), "perceptron.inputs"),
        (
            |m| {
                m.estimator.law.features.truncate(1);
                (m.estimator.ensemble, m.estimator.perceptron) = (Some(ensemble(1)), Some(perceptron()));
            },
            "perceptron",
        ),
        (|m| m.estimator.law.cable = Some(cable()), "law.cable"),
        (|m| m.estimator.law.axis = Some(axis()), "law.axis"),
        (
            |m| {
                (m.estimator.law.cell, m.estimator.law.cable, m.estimator.law.axis) =
                    (None, Some(cable()), Some(axis()));
            },
            "law.axis",
        ),
        (|m| (m.estimator.law.cell, m.estimator.ensemble) = (None, None), "estimator"),
        (
            |m| {
                m.estimator.law.signals.truncate(1);
                m.estimator.law.features.clear();
                m.estimator.ensemble = None;
                (m.estimator.law.cell, m.estimator.law.axis) = (None, Some(axis()));
            },
            "law.axis.force",
        ),
    ];
    for (k, (change, name)) in cases.into_iter().enumerate() {
        assert_eq!(refused(change), Err(name.into()), "case {k}");
    }
}

#[test]
fn what_is_wrong_with_a_cable_is_said_with_its_field_what_is_expected_and_what_is_there() {
    let mut wrong = cable();
    wrong.model.start = 1.25;
    let error = model(MemoryLaw { cable: Some(wrong), ..law() }).validate().unwrap_err();
    assert_eq!(error.name, "law.cable.start");
    assert!(error.expected.contains("[-1, 1]") && error.got == "1.25", "{error}");
}

#[test]
fn each_of_cell_cable_and_axis_is_physics() {
    assert!(!law().has_physics());
    assert!(MemoryLaw { cell: Some(cell()), ..law() }.has_physics());
    assert!(MemoryLaw { cable: Some(cable()), ..law() }.has_physics());
    assert!(MemoryLaw { axis: Some(axis()), ..law() }.has_physics());
}

#[test]
fn features_are_the_stop_the_low_pass_and_the_state_of_the_cell() {
    let features = vec![
        Feature::Signal(1),
        Feature::Stop { signal: 0, radius: 4.0 },
        Feature::LowPassDifference { signal: 0, tau_s: 0.03 },
        Feature::CellState,
        Feature::CellWidth,
        Feature::CellPosition,
        Feature::Innovation,
    ];
    let law = MemoryLaw { cell: Some(cell()), features, ..law() };
    let mut memory = Memory::new(&law);
    let (mut play, mut low_pass, mut inner) = (0.0, 0.0, 0);
    for k in 0..120 {
        let (t, dt) = (f64::from(k), 0.01 + 0.002 * f64::from(k % 3));
        let inputs = [60.0 + 30.0 * libm::sin(0.2 * t), 2.0 * libm::cos(0.5 * t), 0.0];
        // A sequence begins at the first sample and after a reset.
        let first = k == 0 || k == 70;
        if k == 70 {
            memory.reset();
        }
        memory.step(&law, dt, &inputs);
        let u = inputs[0];
        (play, low_pass) = if first { (u, u) } else { (play, low_pass) };
        if u - play > 4.0 {
            play = u - 4.0;
        } else if u - play < -4.0 {
            play = u + 4.0;
        }
        // Implicit Euler's step of tau w' = u - w.
        low_pass = (0.03 * low_pass + dt * u) / (0.03 + dt);
        let state = memory.cell().state;
        inner += usize::from(state > 0.7 * u + 0.1 && state < 1.2 * u - 0.1);
        let desired = [
            inputs[1],
            (u - play) / 4.0,
            if first { 0.0 } else { u - low_pass },
            state,
            0.5 * u,
            (state - 0.7 * u) / (0.5 * u),
            0.0,
        ];
        for (i, (got, desired)) in memory.features().iter().zip(desired).enumerate() {
            assert!(close(*got, desired), "sample {k}, feature {i}: {got} {desired}");
        }
        assert_eq!(memory.signals(), &inputs[..2]);
        assert!(!first || close(state, 0.9 * u), "a start at 0.4 of the band");
    }
    assert!(inner > 20, "{inner}");
}

#[test]
fn a_memory_with_a_cable_holds_what_its_observer_estimates() {
    let law = MemoryLaw { cable: Some(cable()), features: vec![Feature::Innovation], ..law() };
    let mut memory = Memory::new(&law);
    let mut observer = CableObserver::new(&cable().model).unwrap();
    let (mut unknown, mut known) = (0, 0);
    for k in 0..300 {
        if k == 250 {
            memory.reset();
            observer.reset();
        }
        let slid = 1e-3 * f64::from(k);
        let inputs = [80.0 + 5.0 * libm::sin(0.1 * f64::from(k)), slid, -slid];
        memory.step(&law, 0.005, &inputs);
        let sample = CableSample { motor: slid, anchor: slid, tension_in: inputs[0] };
        let estimate = observer.step(0.005, &sample);
        let (low, high) =
            if estimate.known { (estimate.far, estimate.far) } else { (estimate.low, estimate.high) };
        let cell = CellOutput { state: estimate.far, low, high, known: estimate.known, unknown: high - low };
        assert_eq!(memory.cell(), cell);
        assert!(close(memory.features()[0], estimate.innovation));
        (unknown, known) = (unknown + u32::from(!estimate.known), known + u32::from(estimate.known));
    }
    assert!(unknown > 20 && known > 100, "{unknown} {known}");
}

#[test]
fn a_memory_with_an_axis_knows_its_force_up_to_the_friction_that_has_not_slipped() {
    let law = MemoryLaw { axis: Some(axis()), ..law() };
    let mut memory = Memory::new(&law);
    for (k, x) in [0.2, 0.25, 0.29, 0.4, 0.35].into_iter().enumerate() {
        memory.step(&law, 0.01, &[8.0, x, 0.0]);
        // The spring at its position, the near force, the offset, and friction over the way from the start.
        let friction = [0.0, 3.0, 5.4, 6.0, 3.0][k];
        let spring = [10.0, 12.5, 14.5, 20.0, 17.5][k];
        let (state, known) = (spring + friction + 4.0 + 1.0, k >= 3);
        let cell = memory.cell();
        let half = if known { 0.0 } else { 6.0 };
        assert_eq!(cell.known, known, "{k}");
        assert!(
            (cell.low - state + half).abs() < 1.0 && (cell.high - state - half).abs() < 1.0,
            "{k}: {cell:?}"
        );
        assert!(close(cell.high - cell.low, 2.0 * half), "{k}: {cell:?}");
        assert!(close(0.5 * (cell.high + cell.low), cell.state), "{k}: {cell:?}");
    }
}

#[test]
fn the_far_side_of_an_axis_of_motion_starts_it_where_it_is_measured() {
    let motion = Axis::Motion(AxisMotion {
        force: 0,
        gain: 1.0,
        damping: 2.0,
        stiffness: 4.0,
        friction: 0.0,
        bias: 0.0,
        offset: 0.5,
        far_is_velocity: false,
    });
    let law = MemoryLaw { axis: Some(motion.rescaled(3.0, 0.0)), ..law() };
    let mut memory = Memory::new(&law);
    memory.step_from(&law, 0.0, &[8.0, 0.0, 0.0], Some(7.25));
    assert!(close(memory.cell().state, 7.25));
    memory.reset();
    memory.step_from(&law, 0.01, &[8.0, 0.0, 0.0], None);
    assert!(close(memory.cell().state, 3.0 * (2.0 + 0.5)));
    memory.step(&law, 0.01, &[8.0, 0.0, 0.0]);
    assert!(close(memory.cell().state, 7.5) && !memory.cell().known);
}

#[test]
fn an_estimate_adds_the_gated_networks_and_the_variances_of_all_that_is_unknown() {
    let mut estimator = with_cell().estimator;
    let mut memory = Memory::new(&estimator.law);
    let mut scratch = [0.0; 0];
    memory.step(&estimator.law, 0.0, &[100.0, 0.0]);
    // The cell's state at 0.4 of a band from 70 to 120, its variance that of an even distribution over it.
    let (state, physics) = (90.0, 0.3 * 0.3 + 50.0 * 50.0 / 12.0);
    let desired =
        Estimate { mean: state, variance: physics, gate: 1.0, known: false, clipped: 0, beyond: 0.0 };
    let agree = |estimator: &Estimator, memory: &Memory, scratch: &mut [f32], desired: Estimate| {
        let got = estimator.estimate(memory, scratch);
        assert!(
            close(got.mean, desired.mean) && close(got.variance, desired.variance),
            "{got:?} {desired:?}"
        );
        assert!(close(got.gate, desired.gate), "{got:?} {desired:?}");
        assert_eq!((got.known, got.clipped), (desired.known, desired.clipped));
    };
    agree(&estimator, &memory, &mut scratch, desired);
    // Constants from 1 to 8: their median is 4.5 and their variance 6.
    estimator.ensemble = Some(ensemble(0));
    let networks = Estimate { mean: state + 4.5, variance: physics + 6.0, ..desired };
    agree(&estimator, &memory, &mut scratch, networks);
    for power in [0.0, 2.0, 48.0] {
        estimator.gate_power = Some(power);
        let gate = power / (power + GATE_STRENGTH * 6.0);
        agree(&estimator, &memory, &mut scratch, Estimate { mean: state + gate * 4.5, gate, ..networks });
    }
    // At a bound the state is known.
    memory.step(&estimator.law, 0.01, &[20.0, 0.0]);
    let known = Estimate { mean: 24.0 + 0.5 * 4.5, variance: 0.09 + 6.0, gate: 0.5, known: true, ..desired };
    agree(&estimator, &memory, &mut scratch, known);
}

#[test]
fn a_plain_network_adds_to_the_physics_and_may_stand_alone() {
    let mut scratch = [0.0; 1];
    for (physics, state) in [(None, 0.0), (Some(cell()), 90.0)] {
        let law = MemoryLaw { cell: physics, features: vec![Feature::Signal(1)], ..law() };
        let mut model = model(law);
        model.estimator.perceptron = Some(perceptron());
        let mut memory = Memory::new(&model.estimator.law);
        memory.step(&model.estimator.law, 0.0, &[100.0, 2.0]);
        let estimate = model.estimator.estimate(&memory, &mut scratch);
        assert!((estimate.mean - state - 6.5).abs() < 1e-15, "{estimate:?}");
        assert_eq!(estimate.known, !model.estimator.law.has_physics());
    }
}

#[test]
fn a_band_is_calibrated_and_its_half_width_that_of_95_percent() {
    let mut predictor = Predictor::new(with_cell()).unwrap();
    let inputs = [100.0, 0.0, 0.0];
    let unknown = predictor.step(&Sample { time_s: 0.0, inputs: &inputs });
    let desired = 2.0 * libm::sqrt(0.09 + 50.0 * 50.0 / 12.0);
    assert!(close(unknown.half_width(), desired) && close(1.96 * unknown.standard_deviation, desired));
}

#[test]
fn inputs_on_the_edges_of_their_range_are_inside_and_those_beyond_are_flagged() {
    let mut predictor = Predictor::new(with_cell()).unwrap();
    let inputs = [
        ([50.0, 0.0, 0.0], false),
        ([50.0, -10.0, 200.0], false),
        ([50.0, -10.5, 0.0], true),
        ([201.0, 0.0, 0.0], true),
        ([50.0, 199.0, -9.0], false),
    ];
    for (k, (inputs, outside)) in inputs.iter().enumerate() {
        let got = predictor.step(&Sample { time_s: 0.01 * k as f64, inputs });
        assert_eq!(got.flags.out_of_range, *outside, "{inputs:?}");
    }
    // A network input outside its box, though all inputs are inside their ranges.
    let mut model = with_cell();
    model.estimator.law.features = vec![Feature::Signal(1)];
    model.estimator.ensemble = Some(ensemble(1));
    let mut predictor = Predictor::new(model).unwrap();
    let values: Vec<bool> = [0.5, 1.5, -1.0, -1.5]
        .iter()
        .enumerate()
        .map(|(k, x)| predictor.step(&Sample { time_s: 0.01 * k as f64, inputs: &[50.0, *x, 0.0] }))
        .map(|prediction| prediction.flags.out_of_range)
        .collect();
    assert_eq!(values, [false, true, false, true]);
}

#[test]
fn rates_signs_and_extremes_are_those_of_the_sequence_so_far() {
    let features = vec![
        Feature::Rate(0),
        Feature::Previous(0),
        Feature::Sign { feature: 0, scale: 30.0 },
        Feature::BelowMaximum(0),
        Feature::AboveMinimum(0),
        Feature::Product { feature: 4, signal: 1 },
    ];
    let law = MemoryLaw { cell: None, features, ..law() };
    let mut memory = Memory::new(&law);
    let steps = [
        (5.0, [0.0, 0.0, 0.0, 0.0, 0.0, 0.0]),
        (9.0, [40.0, 0.0, 0.8, 0.0, 4.0, 8.0]),
        (6.0, [-30.0, 40.0, -0.5_f64.sqrt(), -3.0, 1.0, 2.0]),
        (2.0, [-40.0, -30.0, -0.8, -7.0, 0.0, 0.0]),
    ];
    for _ in 0..2 {
        // The second time after a reset: nothing is left.
        memory.reset();
        for (u, desired) in steps {
            memory.step(&law, 0.1, &[u, 2.0, 0.0]);
            for (got, desired) in memory.features().iter().zip(desired) {
                assert!((got - desired).abs() < 1e-12, "{u}: {:?} {desired:?}", memory.features());
            }
        }
    }
    // Without a time between the samples there is no rate.
    memory.step(&law, 0.0, &[50.0, 2.0, 0.0]);
    assert_eq!(memory.features()[0].to_bits(), 0.0_f64.to_bits());
}

/// A regression `offset + slope u` on the first signal, clipped to 0..100, with a network that is constant.
fn line(offset: f64, slope: f64, box_of: Option<(f64, f64)>) -> Estimator {
    let law = MemoryLaw {
        cell: None,
        features: vec![Feature::Clamped { signal: 0, low: 0.0, high: 100.0 }],
        ..law()
    };
    let linear = LinearLaw { offset, weights: vec![slope] };
    let ensemble = box_of.map(|(low, high)| Ensemble {
        clip_low: vec![low],
        clip_high: vec![high],
        mean: vec![0.0],
        inverse_scale: vec![0.1],
        skip: vec![[0.0; 8]],
        bias: [0.0; 8],
        ..ensemble(0)
    });
    Estimator { linear: Some(linear), ensemble, sigma0: 1.0, ..Estimator::of(law) }
}

#[test]
fn a_mean_is_that_of_its_members_and_beyond_the_training_data_of_those_that_hold_there() {
    let empty = MemoryLaw { signals: vec![], cell: None, features: vec![], ..law() };
    let member = |estimator, inside| Member { weight: 0.5, inside, estimator };
    let members = vec![member(line(0.0, 1.0, None), true), member(line(10.0, 1.2, Some((0.0, 50.0))), false)];
    let mean = Estimator { members, sigma0: 0.5, ..Estimator::of(empty) };
    let mut state = EstimatorState::new(&mean);
    // Inside; a quarter of the way out, 0.125 deviations of 10, and back inside in the same sequence; far
    // beyond.
    for (u, first, second, weight) in [
        (20.0, 20.0, 34.0, 0.5),
        (51.25, 51.25, 71.5, 0.375),
        (20.0, 20.0, 34.0, 0.375),
        (150.0, 100.0, 130.0, 0.0),
    ] {
        let got = state.step(&mean, 0.01, &[u, 0.0, 0.0]);
        let total = weight + 0.5;
        let desired = (weight * first + 0.5 * second) / total;
        let spread = {
            let square = |y: f64| (y - desired) * (y - desired);
            (weight * square(first) + 0.5 * square(second)) / total
        };
        assert!(close(got.mean, desired), "{u}: {got:?} {desired}");
        assert!(close(got.variance, 0.25 + spread), "{u}: {got:?} {spread}");
        assert!(got.known && (got.clipped > 0) == (u > 50.0));
    }
}

#[test]
fn members_are_checked_as_deep_as_they_go_and_survive_a_file() {
    let nested = |depth: usize| {
        let mut estimator = line(0.0, 1.0, None);
        for _ in 0..depth {
            let members = vec![Member { weight: 1.0, inside: false, estimator }];
            estimator = Estimator { members, ..line(1.0, 0.5, None) };
        }
        let mut model = with_cell();
        model.estimator = estimator;
        model
    };
    assert!((0..4).all(|depth| nested(depth).validate().is_ok()) && nested(4).validate().is_err());
    let mut broken = nested(2);
    broken.estimator.members[0].estimator.members[0].estimator.sigma0 = f64::NAN;
    assert!(broken.validate().is_err());
    let mut weightless = nested(1);
    weightless.estimator.members[0].weight = 0.0;
    assert!(weightless.validate().unwrap_err().name.contains("members.weight"));
    let model = nested(3);
    assert_eq!(Model::from_json(&model.to_json().unwrap()).unwrap(), model);
}
