//! The learned correction: weights of the eight networks, or of the one.

use super::literal::{array, double, rows, scalar, single, tables};
use super::template::Filling;
use crate::Name;
use sinew::predictor::{Ensemble, Estimator, PerNetwork};
use sinew::transmission::Perceptron;

/// Nodes that are evaluated together, as in the library: the order of its sums.
const BLOCK: usize = 8;
/// Where the quick hyperbolic tangent becomes constant.
const QUICK_EDGE: f32 = 4.97;

pub(super) fn fill(filling: &mut Filling, estimator: &Estimator, name: &Name) {
    let n = name.as_str();
    if let Some(ensemble) = &estimator.ensemble {
        filling.when("ensemble", true);
        filling.when("gate", estimator.gate_power.is_some());
        filling.when("nodes", !ensemble.hidden_bias.is_empty());
        filling.set("node_count", ensemble.hidden_bias.len());
        filling.set("quick_edge", single(QUICK_EDGE));
        let gate = estimator.gate_power.map_or_else(String::new, |p| scalar(&format!("{n}_gate_power"), p));
        filling.set("ensemble_tables", ensemble_tables(ensemble, n) + &gate);
    }
    if let Some(linear) = &estimator.linear {
        filling.when("linear", true);
        let tables = scalar(&format!("{n}_linear_offset"), linear.offset)
            + &array(&format!("{n}_linear_weights"), &linear.weights);
        filling.set("linear_tables", tables);
    }
    if let Some(perceptron) = &estimator.perceptron {
        filling.when("perceptron", true);
        filling.when("skip", !perceptron.weights().skip.is_empty());
        filling.set("node_count", perceptron.hidden());
        filling.set("block_count", perceptron.hidden().div_ceil(BLOCK));
        filling.set("perceptron_tables", perceptron_tables(perceptron, n));
    }
}

fn ensemble_tables(ensemble: &Ensemble, n: &str) -> String {
    let row = |row: &PerNetwork| row.iter().map(|x| single(*x)).collect::<Vec<_>>();
    let all = |list: &[PerNetwork]| list.iter().map(row).collect::<Vec<_>>();
    let mut out = format!("static const float {n}_bias[8] = {{{}}};\n", row(&ensemble.bias).join(", "));
    let features = ensemble.mean.len();
    if features > 0 {
        for (what, list) in [
            ("clip_low", &ensemble.clip_low),
            ("clip_high", &ensemble.clip_high),
            ("mean", &ensemble.mean),
            ("inverse_scale", &ensemble.inverse_scale),
        ] {
            out += &array(&format!("{n}_{what}"), list);
        }
        out += &rows("float", &format!("{n}_skip"), &all(&ensemble.skip));
    }
    if !ensemble.hidden_bias.is_empty() {
        out += &rows("float", &format!("{n}_hidden_bias"), &all(&ensemble.hidden_bias));
        out += &rows("float", &format!("{n}_output"), &all(&ensemble.output_weights));
        out += &tables("float", &format!("{n}_hidden"), features, &all(&ensemble.hidden_weights));
    }
    out
}

fn perceptron_tables(perceptron: &Perceptron, n: &str) -> String {
    let w = perceptron.weights();
    let blocks: Vec<usize> = (0..w.hidden).step_by(BLOCK).collect();
    let gather = |first: usize, of: &dyn Fn(usize) -> f64| -> Vec<String> {
        let node = |lane| if first + lane < w.hidden { of(first + lane) } else { 0.0 };
        (0..BLOCK).map(|lane| double(node(lane))).collect()
    };
    let bias: Vec<_> = blocks.iter().map(|first| gather(*first, &|node| w.hidden_bias[node])).collect();
    let output: Vec<_> = blocks.iter().map(|first| gather(*first, &|node| w.output_weights[node])).collect();
    let hidden: Vec<_> = blocks
        .iter()
        .flat_map(|first| (0..w.inputs).map(|i| gather(*first, &|node| w.input_weights[node * w.inputs + i])))
        .collect();
    let mut out = rows("double", &format!("{n}_hidden_bias"), &bias)
        + &rows("double", &format!("{n}_output"), &output)
        + &tables("double", &format!("{n}_hidden"), w.inputs, &hidden)
        + &scalar(&format!("{n}_output_bias"), w.output_bias);
    if !w.skip.is_empty() {
        out += &array(&format!("{n}_skip"), &w.skip);
    }
    out
}
