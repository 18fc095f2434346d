//! What notices another specimen: the loops of the training logs as constants.

use super::literal::{double, scalar};
use super::template::Filling;
use crate::Name;
use sinew::predictor::{LoopCheck, LoopQuantity, LoopTerm, SpecimenMonitor};
use std::fmt::Write;

/// Fills what the monitor of a model needs; nothing where it has none.
pub(super) fn fill(filling: &mut Filling, monitor: Option<&SpecimenMonitor>, name: &Name) {
    let Some(monitor) = monitor else { return };
    filling.when("specimen", true);
    filling.set("loop_motion", monitor.motion);
    filling.set("loop_effort", monitor.effort);
    filling.set("reversal", scalar(&format!("{}_reversal", name.as_str()), monitor.reversal));
    let checks: String = monitor.checks.iter().map(|check| code(check, name)).collect();
    filling.set("loop_checks", checks);
}

/// A check; the order of every sum is the library's.
fn code(check: &LoopCheck, name: &Name) -> String {
    let upper = name.upper();
    let quantity = match check.quantity {
        LoopQuantity::Height => "HEIGHT",
        LoopQuantity::Slope => "SLOPE",
        LoopQuantity::Level => "LEVEL",
    };
    let term = |term: &LoopTerm| match *term {
        LoopTerm::Level => format!("loop[{upper}_LEVEL]"),
        LoopTerm::LevelSquared => format!("loop[{upper}_LEVEL] * loop[{upper}_LEVEL]"),
        LoopTerm::Speed => format!("loop[{upper}_SPEED]"),
        LoopTerm::Stroke => format!("loop[{upper}_STROKE]"),
        LoopTerm::Given(input) => format!("s->values[{input}]"),
    };
    let mut text = "    {\n".to_owned();
    let terms = check.terms.iter().zip(&check.mean).zip(&check.inverse_scale).enumerate();
    for (i, ((kind, mean), scale)) in terms {
        let (value, mean, scale) = (term(kind), double(*mean), double(*scale));
        let _ = writeln!(text, "        const double x{i} = ({value} - {mean}) * {scale};");
    }
    let uncertain = double(1.0 + 1.0 / check.trials as f64);
    let offset = double(check.offset);
    let _ = writeln!(text, "        double expected = {offset}, uncertain = {uncertain}, excess;");
    let count = check.terms.len();
    for (i, weight) in check.weights.iter().enumerate() {
        let _ = writeln!(text, "        expected += {} * x{i};", double(*weight));
        for (j, factor) in check.covariance[i * count..(i + 1) * count].iter().enumerate() {
            let _ = writeln!(text, "        uncertain += x{i} * {} * x{j};", double(*factor));
        }
    }
    let (variance, scatter) = (double(check.deviation * check.deviation), double(check.scatter));
    let _ = writeln!(
        text,
        "        excess = @_magnitude((loop[{upper}_{quantity}] - expected) / sqrt({variance} * uncertain\n                 \
         + {scatter} / s->loops)) / {};\n        undefined |= !(excess >= 0.0);\n        \
         above |= excess > 1.0;\n    }}",
        double(check.limit)
    );
    text.replace('@', name.as_str())
}
