//! A predictor as an ONNX graph of one sample, with its state as an input and an output.
//!
//! ```text
//! time_s, inputs, state ──> prediction, standard_deviation, gate, flags, next_state
//! ```
//!
//! Every sum is written out in the library's order and precision, so that a runtime that computes single
//! operators as IEEE 754 asks gives the library's numbers; logarithms alone are the runtime's.

mod conditioner;
mod estimator;
mod graph;
mod protobuf;

use crate::c::{Content, checksum};
use crate::{ExportError, ExportedFile, Name};
use graph::{End, Graph, Kind, Slot, Value};
use protobuf::Message;
use sinew::predictor::{Estimator, Model};

/// Version of the operators, of December 2022: older runtimes lack `ReduceMax` and `Split` as written here.
const OPERATORS: usize = 18;
/// Version of the file format that belongs to them.
const FORMAT: usize = 8;

/// `NAME.onnx`.
///
/// # Errors
/// [`ExportError::Onnx`] names what is not offered, a compensator for one; [`Model::validate`].
pub fn file(model: &Model, name: &Name, content: Content) -> Result<ExportedFile, ExportError> {
    model.validate()?;
    if content != Content::Predictor {
        return Err(ExportError::Onnx { what: "an inverse" });
    }
    offered(&model.estimator)?;
    let mut g = Graph::default();
    let [time, inputs, state] = ["time_s", "inputs", "state"].map(|name| g.input(name));
    let last = g.remember(4);
    let sample = conditioner::condition(&mut g, model, time, inputs);
    let estimate = estimator::estimate(&mut g, &model.estimator, &sample);
    let outputs = outputs(&mut g, model, &sample, &estimate, last);
    let (width, after) = (g.width(), g.state_after());
    // A sample with the time of the one before leaves the state alone.
    let next_state = g.select(sample.repeated, state, after);

    let columns: Vec<&str> = model.inputs.iter().map(|input| input.column.as_str()).collect();
    let (columns, far) = (columns.join(", "), model.far.as_str());
    let end = |name, value, kind, width, description| End { name, value, kind, width, description };
    let ends: [&[End<'_>]; 2] = [
        &[
            end("time_s", time, Kind::Double, 1, "time of the sample, s, any origin; NaN: one interval on"),
            end("inputs", inputs, Kind::Double, model.inputs.len(), &columns),
            end("state", state, Kind::Double, width, "zeros before the first sample, then next_state"),
        ],
        &[
            end("prediction", outputs[0], Kind::Double, 1, far),
            end(
                "standard_deviation",
                outputs[1],
                Kind::Double,
                1,
                "prediction +- 1.96 of it is the 95 % band",
            ),
            end("gate", outputs[2], Kind::Double, 1, "weight of the learned correction, 0 to 1"),
            end("flags", outputs[3], Kind::Whole, 1, "bits, as in the exported C"),
            end("next_state", next_state, Kind::Double, width, "state for the next sample"),
        ],
    ];
    let graph = g.finish(name.as_str(), state, ends);
    let member = &model.provenance.member;
    let about = format!("{far} predicted by `{member}`, one sample of any number of sequences");
    let extra = [("inputs", columns.as_str()), ("far", far), ("checksum", &checksum(model)?)];
    let extra = extra.map(|(key, value)| Message::default().bytes(1, key).bytes(2, value));
    let file = Message::default()
        .number(1, FORMAT)
        .bytes(2, "Sinew")
        .bytes(3, env!("CARGO_PKG_VERSION"))
        .bytes(6, about)
        .message(7, &graph)
        .message(8, &Message::default().bytes(1, "").number(2, OPERATORS))
        .messages(14, &extra);
    Ok(ExportedFile { path: format!("{}.onnx", name.as_str()), bytes: file.finish() })
}

/// Mean, deviation, gate and flags; those of the sample before where it is repeated.
fn outputs(
    g: &mut Graph,
    model: &Model,
    sample: &conditioner::Sample,
    estimate: &estimator::Estimate,
    last: Slot,
) -> [Value; 4] {
    let outside = estimate.clipped.map_or(sample.outside, |clipped| g.op("Or", &[sample.outside, clipped]));
    let (root, inside) = (g.op("Sqrt", &[estimate.variance]), g.double(model.band_factor));
    let band = model.outside.as_ref().map_or(inside, |beyond| {
        let factor = g.double(beyond.band_factor);
        g.select(outside, factor, inside)
    });
    let (wide, two_sided) = (g.op("Mul", &[band, root]), g.double(1.96));
    let deviation = g.op("Div", &[wide, two_sided]);
    // Unknown state, out of range, held input.
    let mut lasting = sample.zero;
    let unknown = estimate.known.map(|known| g.op("Not", &[known]));
    for (bit, flag) in [(1.0, unknown), (2.0, Some(outside)), (4.0, Some(sample.any_held))] {
        if let Some(flag) = flag {
            let (flag, bit) = (g.cast(flag, Kind::Double), g.double(bit));
            let flag = g.op("Mul", &[flag, bit]);
            lasting = g.op("Add", &[lasting, flag]);
        }
    }
    let now = [estimate.mean, deviation, estimate.gate, lasting].map(|x| g.op("Add", &[sample.zero, x]));
    let now = g.join(&now);
    g.keep(last, now);
    let said = g.select(sample.repeated, last.before, now);
    let said = g.split(said, &[1, 1, 1, 1]);
    let (repeated, reset, none) = (g.double(32.0), g.double(8.0), g.double(0.0));
    let first = g.select(sample.next, none, reset);
    let first = g.select(sample.repeated, repeated, first);
    let flags = g.op("Add", &[said[3], first]);
    [said[0], said[1], said[2], g.cast(flags, Kind::Whole)]
}

/// Refuses what has no graph.
fn offered(estimator: &Estimator) -> Result<(), ExportError> {
    let refuse = |what| Err(ExportError::Onnx { what });
    if estimator.law.cable.is_some() {
        return refuse("a cable observer");
    }
    if estimator.law.axis.is_some() {
        return refuse("an axis");
    }
    if estimator.perceptron.is_some() {
        return refuse("the network of the paper");
    }
    estimator.members.iter().try_for_each(|member| offered(&member.estimator))
}
