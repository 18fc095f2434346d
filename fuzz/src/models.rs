//! Any text as a model file: alone, and as the inside of a file whose head is in order.
//!
//! A checksum stops nearly every change of a file, so the second way computes it anew: what it guards, the
//! checks of [`Model::validate`], is reached. A model that is accepted must answer wild samples with finite
//! numbers.
use sinew::predictor::{Model, Predictor, Sample};

/// Reads `bytes` as a model file in both ways.
pub fn read_model(bytes: &[u8]) {
    let Ok(text) = std::str::from_utf8(bytes) else { return };
    for text in [text.to_owned(), enveloped(text)] {
        match Model::from_json(&text) {
            Ok(model) => check(model, bytes),
            Err(error) => assert!(!error.to_string().is_empty()),
        }
    }
}

/// `model` with the head that a writer would give it.
fn enveloped(model: &str) -> String {
    let model = model.trim();
    let checksum = crc32fast::hash(model.as_bytes());
    format!(
        r#"{{"format":"sinew transmission model","version":{},"checksum":"{checksum:08x}","model":{model}}}"#,
        sinew::predictor::VERSION
    )
}

/// The promises of a model that was accepted.
fn check(model: Model, bytes: &[u8]) {
    let text = model.to_json().expect("what was read can be written");
    let again = Model::from_json(&text).expect("what was written can be read");
    assert_eq!(again, model, "nothing is lost");
    let mut wild = Vec::from([0.0, 1.0, -1.0, f64::NAN, f64::INFINITY, f64::MAX, f64::MIN, 5e-324, 1e30]);
    wild.extend(
        bytes
            .chunks_exact(8)
            .rev()
            .take(32)
            .map(|c| f64::from_bits(u64::from_le_bytes(c.try_into().expect("8")))),
    );
    let width = model.inputs.len().min(64);
    let mut predictor = Predictor::new(model).expect("a validated model");
    for step in 0..3 * wild.len() {
        let inputs: Vec<f64> = (0..width).map(|i| wild[(step * 7 + i * 3) % wild.len()]).collect();
        // Every other time runs on by a millisecond, so that memory is carried.
        let time_s = if step % 2 == 0 { step as f64 * 1e-3 } else { wild[step % wild.len()] };
        let p = predictor.step(&Sample { time_s, inputs: &inputs });
        assert!(p.mean.is_finite() && p.standard_deviation.is_finite(), "{p:?}");
        assert!(p.standard_deviation >= 0.0 && (0.0..=1.0).contains(&p.gate), "{p:?}");
    }
}
