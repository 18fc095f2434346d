//! Graphs of ONNX in onnxruntime against the predictor's numbers, sample by sample.

use crate::bits::{bytes, predicted};
use crate::compiler::{rows_of, run_program};
use crate::models::{Kind, model};
use crate::samples::rows;
use rand::SeedableRng;
use rand_chacha::ChaCha8Rng;
use sinew::predictor::{Model, Signal};
use sinew_export::{Name, c, onnx};
use std::path::{Path, PathBuf};
use std::process::Command;

const PREDICTOR: c::Content = c::Content::Predictor;

/// Checks the file, then steps over rows from standard input: two sequences side by side, of which the second
/// is reset at every hundredth row.
const SCRIPT: &str = r#"
import sys
import numpy as np, onnx, onnxruntime
path, width = sys.argv[1], int(sys.argv[2])
onnx.checker.check_model(onnx.load(path), full_check=True)
session = onnxruntime.InferenceSession(path, providers=["CPUExecutionProvider"])
size = session.get_inputs()[2].shape[1]
names = ["prediction", "standard_deviation", "gate", "flags", "next_state"]
assert [end.name for end in session.get_outputs()] == names
rows = np.frombuffer(sys.stdin.buffer.read()).reshape(-1, width)
state = np.zeros((2, size))
for k, row in enumerate(rows):
    state[0] *= row[0] == 0.0
    state[1] *= k % 100 != 0
    inputs = {"time_s": [[row[1]], [0.0]], "inputs": [row[2:], np.full(width - 2, np.nan)], "state": state}
    *said, state = session.run(None, {name: np.array(value, float) for name, value in inputs.items()})
    sys.stdout.buffer.write(np.array([values[0, 0] for values in said], float).tobytes())
"#;

/// A Python with onnx and onnxruntime: that of `SINEW_PYTHON`, which has to be one, or of the system.
fn python() -> Option<PathBuf> {
    let given = std::env::var_os("SINEW_PYTHON").map(PathBuf::from);
    let python = given.clone().unwrap_or_else(|| "python3".into());
    let output = Command::new(&python).args(["-c", "import onnx, onnxruntime"]).output();
    let works = output.is_ok_and(|output| output.status.success());
    assert!(works || given.is_none(), "{}: no onnx and onnxruntime", python.display());
    if !works {
        println!("skipped: no Python with onnx and onnxruntime");
    }
    works.then_some(python)
}

/// Largest difference of mean, deviation and gate, in units of the numbers' size above 1; flags are equal.
fn worst(python: &Path, model: &Model, seed: u64) -> f64 {
    // A graph does not notice another specimen.
    let model = &Model { specimen: None, ..model.clone() };
    let mut random = ChaCha8Rng::seed_from_u64(seed);
    let rows = rows(800, &mut random);
    let folder = tempfile::tempdir().unwrap();
    let file = onnx::file(model, &Name::new("exported").unwrap(), PREDICTOR).unwrap();
    let place = folder.path().join(&file.path);
    std::fs::write(&place, &file.bytes).unwrap();
    let mut command = Command::new(python);
    command.args(["-c", SCRIPT]).arg(&place).arg((2 + model.inputs.len()).to_string());
    let got: Vec<[u64; 4]> = rows_of(&run_program(command, &bytes(&rows)));
    let expected = predicted(model, &rows);
    assert_eq!(got.len(), expected.len());
    let mut worst = 0.0_f64;
    for (row, (got, expected)) in got.iter().zip(&expected).enumerate() {
        let [got, expected] = [got, expected].map(|bits| bits.map(f64::from_bits));
        assert_eq!(
            got[3].to_bits(),
            expected[3].to_bits(),
            "flags of row {row}: {got:?}, {expected:?}\n{model:?}"
        );
        for (got, expected) in got.iter().zip(expected) {
            worst = worst.max((got - expected).abs() / expected.abs().max(1.0));
        }
    }
    worst
}

fn has_logarithm(model: &Model) -> bool {
    fn of(estimator: &sinew::predictor::Estimator) -> bool {
        let log = |signal: &Signal| matches!(signal, Signal::LogTension { .. } | Signal::LogRatio { .. });
        estimator.law.signals.iter().any(log) || estimator.members.iter().any(|m| of(&m.estimator))
    }
    of(&model.estimator)
}

#[test]
fn graphs_give_the_library_s_numbers_and_flags_in_onnxruntime() {
    let Some(python) = python() else { return };
    for kind in [Kind::Cell, Kind::HybridCell, Kind::Network, Kind::Constant, Kind::Mean] {
        for seed in 0..4 {
            let mut random = ChaCha8Rng::seed_from_u64(1000 * kind as u64 + seed);
            let model = model(kind, &mut random);
            let worst = worst(&python, &model, seed);
            println!("{kind:?} {seed}: {worst:e}, logarithms {}", has_logarithm(&model));
            // The logarithm is the runtime's own.
            assert!(worst <= if has_logarithm(&model) { 2e-12 } else { 0.0 }, "{kind:?} {seed}: {worst:e}");
        }
    }
}

#[test]
fn models_without_a_graph_are_refused_by_the_part_that_has_none() {
    let name = Name::new("knee").unwrap();
    for (kind, part) in [
        (Kind::Observer, "a cable observer"),
        (Kind::AxisForce, "an axis"),
        (Kind::AxisMotion, "an axis"),
        (Kind::Perceptron, "the network of the paper"),
    ] {
        let model = model(kind, &mut ChaCha8Rng::seed_from_u64(3));
        let message = onnx::file(&model, &name, PREDICTOR).unwrap_err().to_string();
        assert!(message.ends_with(part), "{message}");
    }
}
