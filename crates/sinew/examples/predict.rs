//! Runs a predictor in a loop: the far tension of a cable from its near tension, sample by sample, with the
//! 95 % band. The argument is a `model.json` of `sinew identify`; without one a clamp cell is built here.

#![allow(clippy::print_stdout, reason = "an example prints")]

use sinew::predictor::{Estimator, Input, InputLimits, MemoryLaw, Model, Predictor};
use sinew::predictor::{Provenance, Role, Sample, Signal};
use sinew::transmission::{BasisTerm, Branch, ClampCell};

fn main() -> Result<(), Box<dyn std::error::Error>> {
    let model = match std::env::args().nth(1) {
        Some(file) => Model::from_json(&std::fs::read_to_string(file)?)?,
        None => clamp_model(),
    };
    let inputs = model.inputs.len();
    let mut predictor = Predictor::new(model)?;
    println!("time s | near N | far N | 95 % band N | state known");
    for k in 0..60 {
        let time_s = f64::from(k) * 0.01;
        let near = 100.0 - 50.0 * libm::cos(12.0 * time_s);
        let far = predictor.step(&Sample { time_s, inputs: &vec![near; inputs] });
        if k % 5 == 0 {
            let (mean, band) = (far.mean, far.half_width());
            println!("{time_s:6.2} | {near:6.1} | {mean:5.1} | +-{band:9.1} | {}", !far.flags.state_unknown);
        }
    }
    Ok(())
}

/// Coulomb friction alone: the far tension lies between 0.8 and 1.25 times the near tension.
fn clamp_model() -> Model {
    let branches = vec![Branch { width: 1.0, fraction: 1.0 }];
    let (basis, low, high) = (vec![BasisTerm::Signal(0)], vec![0.8], vec![1.25]);
    let cell = ClampCell { basis, low, high, elastic: vec![], kappa: vec![], start: 0.5, branches };
    let law = MemoryLaw {
        signals: vec![Signal::Input(0)],
        cell: Some(cell),
        cable: None,
        axis: None,
        features: vec![],
    };
    let (far, member, program) = ("tension_out_n".into(), "cell".into(), "examples/predict".into());
    let description = "clamp cell with given bounds".into();
    let (seed, logs, samples, rmse_unseen, far_range) = (0, vec![], 0, 1.0, 200.0);
    let inputs = vec![Input { column: "tension_in_n".into(), role: Role::Effort }];
    let guards = vec![InputLimits { jump: 1e3, low: 0.0, high: 300.0, typical: 100.0 }];
    let estimator = Estimator { sigma0: 1.0, ..Estimator::of(law) };
    let provenance = Provenance { member, description, program, seed, logs, samples, rmse_unseen, far_range };
    let (time, trial, specimen, offset, outside) = (None, None, None, None, None);
    let (gap_s, band_factor) = (0.1, 2.0);
    Model {
        far,
        time,
        trial,
        specimen,
        offset,
        outside,
        units: std::collections::BTreeMap::new(),
        gap_s,
        band_factor,
        inputs,
        guards,
        estimator,
        provenance,
    }
}
