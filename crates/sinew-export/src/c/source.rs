//! The header and the source: what the model needs, and nothing else.

use super::content::Content;
use super::template::Filling;
use super::{inverse, laws, literal, networks};
use crate::{ExportError, Name};
use sinew::predictor::{Feature, InputLimits, Model, Role, Signal};

const HEADER: &str = include_str!("templates/model.h");
const HEAD: &str = include_str!("templates/head.c");
const BODY: &str = include_str!("templates/body.c");

/// Texts of `NAME.h` and `NAME.c`.
pub(super) fn generate(
    model: &Model,
    name: &Name,
    content: Content,
) -> Result<(String, String), ExportError> {
    let mut filling = Filling::default();
    let law = &model.estimator.law;
    filling.set("about", about(model));
    filling.set("inputs", inputs(model));
    filling.set("input_count", model.inputs.len());
    filling.set("checksum", format!("0x{}u", checksum(model)?));
    filling.set("far", literal::comment(&model.far));
    filling.set("limits", limits(model, name));
    filling.when("physics", law.has_physics());
    let unknown = format!("(s->known ? 0u : {}_STATE_UNKNOWN) |", name.upper());
    filling.set("unknown", if law.has_physics() { unknown } else { String::new() });
    signals(&mut filling, model, name);
    laws::fill(&mut filling, law, name)?;
    features(&mut filling, model, name);
    networks::fill(&mut filling, &model.estimator, name);
    inverse::fill(&mut filling, model, name, content)?;
    let body = filling.render(BODY, name);
    helpers(&mut filling, &body, name);
    Ok((filling.render(HEADER, name), filling.render(HEAD, name) + &body))
}

/// Sets the words of the functions that the body calls, and of those that these call.
fn helpers(filling: &mut Filling, body: &str, name: &Name) {
    let calls = |function: &str| body.contains(&format!("{}_{function}(", name.as_str()));
    let saturate = calls("saturate");
    filling.when("saturate", saturate);
    filling.when("larger", saturate || calls("larger"));
    filling.when("smaller", saturate || calls("smaller"));
    filling.when("sign", calls("with_sign_of"));
    filling.when("log", calls("log"));
    filling
        .when("bits", calls("log") || body.contains(&format!("{}_double ", name.as_str())) || calls("exp"));
}

/// Where the model comes from, as lines of a comment.
fn about(model: &Model) -> String {
    let p = &model.provenance;
    let logs = p.logs.join(", ");
    let lines = [
        format!("Predicts {} with `{}`: {}", model.far, p.member, p.description),
        format!("Fitted by {} to {} samples of {logs}", p.program, p.samples),
        format!("Error on data that were not fitted: {} rms, of a range of {}", p.rmse_unseen, p.far_range),
    ];
    lines.iter().map(|line| format!(" * {}\n", literal::comment(line))).collect()
}

fn inputs(model: &Model) -> String {
    let row = |(k, (input, limits)): (usize, (&sinew::predictor::Input, &InputLimits))| {
        let role = match input.role {
            Role::Effort => "tension or torque",
            Role::Motion => "position",
            Role::Anchor => "displacement of the far end",
            Role::Given => "slow quantity",
        };
        let InputLimits { low, high, .. } = limits;
        format!(" *   [{k}] {}: {role}, {low} to {high} in training\n", literal::comment(&input.column))
    };
    model.inputs.iter().zip(&model.guards).enumerate().map(row).collect()
}

/// The checksum in the model's file, eight hexadecimal digits.
pub(crate) fn checksum(model: &Model) -> Result<String, ExportError> {
    let text = model.to_json()?;
    let digits = text.split_once("\"checksum\":\"").map_or("", |(_, rest)| rest);
    Ok(digits.chars().take(8).filter(char::is_ascii_hexdigit).collect())
}

fn limits(model: &Model, name: &Name) -> String {
    let (n, upper) = (name.as_str(), name.upper());
    let column = |what: &str, of: fn(&InputLimits) -> f64| {
        let list: Vec<f64> = model.guards.iter().map(of).collect();
        literal::array(&format!("{n}_{what}"), &list)
            .replace(&format!("{n}_{what}[{}]", list.len()), &format!("{n}_{what}[{upper}_INPUTS]"))
    };
    column("jump", |l| l.jump)
        + &column("lowest", |l| l.low)
        + &column("highest", |l| l.high)
        + &column("typical", |l| l.typical)
        + &literal::scalar(&format!("{n}_gap_s"), model.gap_s)
        + &literal::scalar(&format!("{n}_sigma"), model.estimator.sigma0)
        + &literal::scalar(&format!("{n}_band"), model.band_factor)
}

/// The signals that a law or a feature reads.
fn signals(filling: &mut Filling, model: &Model, name: &Name) {
    let law = &model.estimator.law;
    let mut used = laws::signals_used(law);
    if has_networks(model) {
        used.extend(law.features.iter().filter_map(|feature| match *feature {
            Feature::Signal(signal)
            | Feature::Stop { signal, .. }
            | Feature::LowPassDifference { signal, .. } => Some(signal),
            _ => None,
        }));
    }
    let code = |(k, signal): (usize, &Signal)| {
        let value = match *signal {
            Signal::Input(i) => format!("s->values[{i}]"),
            Signal::Difference(i, j) => format!("s->values[{i}] - s->values[{j}]"),
            Signal::LogTension { input, offset } => format!("@_log({})", taut(input, offset)),
            Signal::LogRatio { first, second, offset } => {
                format!("@_log(({}) / ({}))", taut(first, offset), taut(second, offset))
            }
        };
        format!("    s->signals[{k}] = {value};\n")
    };
    let read = law.signals.iter().enumerate().filter(|(k, _)| used.contains(k));
    filling.set("signals_code", named(&read.map(code).collect::<String>(), name));
    filling.set("signal_count", law.signals.len());
    filling.when("signals", !used.is_empty());
}

/// Code in which `@` stands for the model's name; it holds numbers and words of this generator alone.
fn named(code: &str, name: &Name) -> String {
    code.replace('@', name.as_str())
}

fn taut(input: usize, offset: f64) -> String {
    format!("@_larger(s->values[{input}], 0.0) + {}", literal::double(offset))
}

fn has_networks(model: &Model) -> bool {
    model.estimator.ensemble.is_some() || model.estimator.perceptron.is_some()
}

/// The inputs of the networks.
fn features(filling: &mut Filling, model: &Model, name: &Name) {
    let law = &model.estimator.law;
    let (count, used) = (law.features.len(), has_networks(model));
    let stateful =
        |feature: &Feature| matches!(feature, Feature::Stop { .. } | Feature::LowPassDifference { .. });
    let filtered = |feature: &Feature| matches!(feature, Feature::LowPassDifference { .. });
    filling.set("feature_count", count);
    filling.set("feature_argument", if count > 0 { "const double *features," } else { "" });
    filling.set("feature_value", if count > 0 { "s->features," } else { "" });
    filling.when("features", used && count > 0);
    filling.when("stateful_features", used && law.features.iter().any(stateful));
    let dt = law.cable.is_some() || law.axis.is_some() || (used && law.features.iter().any(filtered));
    filling.when("dt", dt);
    filling.when("constant", !used);
    if !used {
        return;
    }
    let with_state = |k: usize, signal: usize, update: String, value: &str| {
        format!(
            "    {{\n        const double u = s->signals[{signal}];\n        \
             const double before = s->memory_started ? s->states[{k}] : u;\n        \
             s->states[{k}] = {update};\n        s->features[{k}] = {value};\n    }}\n"
        )
    };
    let code = |(k, feature): (usize, &Feature)| {
        let plain = |value: &str| format!("    s->features[{k}] = {value};\n");
        match *feature {
            Feature::Signal(signal) => plain(&format!("s->signals[{signal}]")),
            Feature::Stop { signal, radius } => {
                let r = literal::double(radius);
                let update = format!("@_saturate(before, u - {r}, u + {r})");
                with_state(k, signal, update, &format!("(u - s->states[{k}]) / {r}"))
            }
            Feature::LowPassDifference { signal, tau_s } => {
                let update = format!("before + (u - before) * dt_s / (dt_s + {})", literal::double(tau_s));
                with_state(k, signal, update, &format!("u - s->states[{k}]"))
            }
            Feature::CellState => plain("s->cell"),
            Feature::CellWidth => plain("width"),
            Feature::CellPosition => plain("(s->cell - s->low) / @_larger(width, 1e-12)"),
            Feature::Innovation if law.cable.is_some() => plain("s->innovation"),
            Feature::Innovation => plain("0.0"),
        }
    };
    filling.set("features_code", named(&law.features.iter().enumerate().map(code).collect::<String>(), name));
}
