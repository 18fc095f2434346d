//! Traces for the page's script: decimated, quantised to 16 bits, base64 within JSON.

use super::error::Error;
use super::format::percent;
use super::record::{Record, Signals};
use super::scale::{padded, robust_range};
use super::svg_path::decimate;
use super::view::{error_view, far_view};
use base64::Engine as _;
use serde::Serialize;

/// Samples of all records together; more are decimated with their extrema kept.
pub(super) const SAMPLES: usize = 20_000;

#[derive(Serialize)]
struct Packed<'a> {
    far: String,
    far_unit: &'a str,
    /// Labels of the inputs.
    inputs: Vec<String>,
    /// Ranges of the quantised channels.
    far_range: [f64; 2],
    input_ranges: Vec<[f64; 2]>,
    half_range: [f64; 2],
    gated: bool,
    records: Vec<PackedRecord<'a>>,
}

#[derive(Serialize)]
struct PackedRecord<'a> {
    label: &'a str,
    percent: String,
    coverage: String,
    samples: usize,
    /// Time of the first sample, s.
    start_s: f64,
    /// Initial vertical ranges.
    view: [f64; 2],
    view_inputs: Vec<[f64; 2]>,
    view_error: [f64; 2],
    /// Base64, little-endian: time as f32, the others as i16 over their range; -32768 is a missing value.
    time: String,
    measured: String,
    predicted: String,
    half: String,
    inputs: Vec<String>,
    gate: String,
    scored: String,
}

/// JSON, safe within a script element; `fraction` formats a record's error.
pub(super) fn pack(
    records: &[&Record],
    signals: &Signals,
    fraction: &dyn Fn(usize) -> String,
) -> Result<String, Error> {
    let all =
        |column: fn(&Record) -> &Vec<f64>| extremes(records.iter().flat_map(|r| column(r).iter().copied()));
    let far = all(|r| &r.far);
    let predicted = all(|r| &r.predicted);
    let far_range = [far[0].min(predicted[0]), far[1].max(predicted[1])];
    let half_range = all(|r| &r.half_width);
    let input = |k: usize| {
        move |r: &'_ Record| {
            if k == 0 { r.near.clone() } else { r.others.get(k - 1).cloned().unwrap_or_default() }
        }
    };
    let count = 1 + signals.others.len();
    let input_ranges: Vec<[f64; 2]> =
        (0..count).map(|k| extremes(records.iter().flat_map(|r| input(k)(r)))).collect();
    let gated = records.iter().any(|r| r.gated());
    let total = records.iter().map(|r| r.len()).sum::<usize>().max(1);
    let packed = records.iter().enumerate().map(|(index, record)| {
        let budget = (SAMPLES * record.len() / total).max(160).min(record.len());
        let kept = decimate(record, budget);
        let start_s = record.time_s.iter().copied().find(|t| t.is_finite()).unwrap_or(0.0);
        let column =
            |values: &[f64], range: [f64; 2]| words(kept.iter().map(|&i| quantise(values[i], range)));
        let (low, high) = far_view(record);
        let scaling = record.scaling();
        let inputs: Vec<Vec<f64>> = (0..count).map(|k| input(k)(record)).collect();
        let view_of = |values: &Vec<f64>| {
            let of = scaling.iter().filter_map(|&i| values.get(i).copied());
            let (low, high) = padded(robust_range(of), 0.05);
            [low, high].map(|v| if v.is_finite() { v } else { 0.0 })
        };
        let finite = |v: f64| if v.is_finite() { v } else { 0.0 };
        let score = record.score();
        PackedRecord {
            label: &record.label,
            percent: fraction(index),
            coverage: percent(score.coverage()),
            samples: score.samples,
            start_s,
            view: [finite(low), finite(high)],
            view_inputs: inputs.iter().map(view_of).collect(),
            view_error: [finite(error_view(record).0), finite(error_view(record).1)],
            time: floats(kept.iter().map(|&i| record.time_s[i] - start_s)),
            measured: column(&record.far, far_range),
            predicted: column(&record.predicted, far_range),
            half: column(&record.half_width, half_range),
            inputs: inputs
                .iter()
                .zip(&input_ranges)
                .map(|(values, range)| if values.is_empty() { String::new() } else { column(values, *range) })
                .collect(),
            gate: if gated { column(&record.gate, [0.0, 1.0]) } else { String::new() },
            scored: runs(&kept.iter().map(|&i| record.scored[i]).collect::<Vec<bool>>()),
        }
    });
    let packed = Packed {
        far: signals.far_label(),
        far_unit: signals.far_unit,
        inputs: core::iter::once(signals.near_label()).chain(signals.other_labels()).collect(),
        far_range,
        input_ranges: input_ranges.clone(),
        half_range,
        gated,
        records: packed.collect(),
    };
    // `<` in a name could close the script element.
    Ok(serde_json::to_string(&packed)?.replace('<', "\\u003c"))
}

fn extremes(values: impl Iterator<Item = f64>) -> [f64; 2] {
    let ends = |[low, high]: [f64; 2], v: f64| [low.min(v), high.max(v)];
    let [low, high] = values.filter(|v| v.is_finite()).fold([f64::INFINITY, f64::NEG_INFINITY], ends);
    if low <= high { [low, high] } else { [0.0, 0.0] }
}

/// A value as 16 bits over a range; the least number is a missing value.
fn quantise(value: f64, [low, high]: [f64; 2]) -> i16 {
    match (value.is_finite(), high > low) {
        (false, _) => i16::MIN,
        (true, false) => 0,
        (true, true) => (65534.0 * ((value - low) / (high - low)).clamp(0.0, 1.0) - 32767.0).round() as i16,
    }
}

fn words(values: impl Iterator<Item = i16>) -> String {
    let bytes: Vec<u8> = values.flat_map(i16::to_le_bytes).collect();
    base64::engine::general_purpose::STANDARD.encode(bytes)
}

fn floats(values: impl Iterator<Item = f64>) -> String {
    let bytes: Vec<u8> = values.flat_map(|v| (v as f32).to_le_bytes()).collect();
    base64::engine::general_purpose::STANDARD.encode(bytes)
}

/// Lengths of alternating runs, the first of scored samples.
fn runs(flags: &[bool]) -> String {
    let (mut lengths, mut current, mut length) = (Vec::new(), true, 0usize);
    for flag in flags {
        if *flag != current {
            lengths.push(length.to_string());
            (current, length) = (*flag, 0);
        }
        length += 1;
    }
    lengths.push(length.to_string());
    lengths.join(" ")
}

#[cfg(test)]
mod tests {
    use super::*;

    #[test]
    fn quantised_values_come_back_within_half_a_step() {
        let range = [-3.0, 7.0];
        for value in [-3.0, -2.9999, 0.0, 1.234_567, 7.0] {
            let word = f64::from(quantise(value, range));
            let back = range[0] + (word + 32767.0) / 65534.0 * (range[1] - range[0]);
            assert!((back - value).abs() <= 0.5001 * 10.0 / 65534.0, "{value} {back}");
        }
        assert_eq!(quantise(f64::NAN, range), i16::MIN);
        assert_eq!(quantise(2.0, [2.0, 2.0]), 0, "a constant has no range");
    }

    #[test]
    fn runs_alternate_beginning_with_scored_samples() {
        assert_eq!(runs(&[false, false, true, true, true, false]), "0 2 3 1");
        assert_eq!(runs(&[]), "0");
    }
}
