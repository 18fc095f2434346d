//! The header and the source: what the model needs, and nothing else.

use super::content::Content;
use super::needs::{has_networks, has_state, uses_dt};
use super::template::Filling;
use super::{inverse, laws, literal, members, networks, specimen};
use crate::{ExportError, Name};
use sinew::predictor::{Estimator, Feature, InputLimits, Model, Role, Signal};

const HEADER: &str = include_str!("templates/model.h");
const HEAD: &str = include_str!("templates/head.c");
const HELPERS: &str = include_str!("templates/helpers.c");
const LAW: &str = include_str!("templates/law.c");
const MEMBER: &str =
    "\n/* State of a member of the mean. */\ntypedef struct {\n//%include state\n} @_state;\n";
const BODY: &str = include_str!("templates/body.c");

/// Texts of `NAME.h` and `NAME.c`.
pub(super) fn generate(
    model: &Model,
    name: &Name,
    content: Content,
) -> Result<(String, String), ExportError> {
    let mut filling = Filling::default();
    filling.set("about", about(model));
    filling.set("inputs", inputs(model));
    filling.set("checksum", format!("0x{}u", checksum(model)?));
    filling.set("far", literal::comment(&model.far));
    filling.set("limits", limits(model, name));
    let estimator = &model.estimator;
    let mut members = String::new();
    estimator_parts(&mut filling, &mut members, model.inputs.len(), estimator, name)?;
    let unknown = format!("(s->determined ? 0u : {}_STATE_UNKNOWN) |", name.upper());
    filling.set("unknown", if has_state(estimator) { unknown } else { String::new() });
    let wider = format!("(outside ? {0}_band_outside : {0}_band)", name.as_str());
    filling.set("band", if model.outside.is_some() { wider } else { format!("{}_band", name.as_str()) });
    let dt = if uses_dt(estimator) { ", s->dt_s" } else { "" };
    filling.set("estimate_dt", dt);
    specimen::fill(&mut filling, model.specimen.as_ref(), name);
    inverse::fill(&mut filling, model, name, content)?;
    let body = filling.render(LAW, name) + &filling.render(BODY, name);
    helpers(&mut filling, &body, name);
    let rest = members + &filling.render(HELPERS, name) + &body;
    filling.when("stdint", rest.contains("uint64_t"));
    let source = filling.render(HEAD, name) + &rest;
    Ok((filling.render(HEADER, name), source))
}

/// Fills what one estimator needs; the C of its members is appended to `code`.
fn estimator_parts(
    filling: &mut Filling,
    code: &mut String,
    inputs: usize,
    estimator: &Estimator,
    name: &Name,
) -> Result<(), ExportError> {
    let law = &estimator.law;
    filling.set("input_count", inputs);
    filling.when("physics", law.has_physics());
    filling.set("sigma", literal::scalar(&format!("{}_sigma", name.as_str()), estimator.sigma0));
    let dt = uses_dt(estimator);
    filling.set("dt_argument", if dt { ", double dt_s" } else { "" });
    signals(filling, estimator, name);
    laws::fill(filling, law, name)?;
    features(filling, estimator, name);
    networks::fill(filling, estimator, name);
    filling.when("members", !estimator.members.is_empty());
    let (mut states, mut fields) = (String::new(), String::new());
    for (k, member) in estimator.members.iter().enumerate() {
        let of = name.of_member(k);
        let mut part = Filling::default();
        estimator_parts(&mut part, code, inputs, &member.estimator, &of)?;
        let body = part.render(LAW, &of);
        helpers(&mut part, &body, &of);
        *code += &(part.render(HELPERS, &of) + &body);
        states += &part.render("//%slot member_states", &of);
        states += &part.render(MEMBER, &of);
        fields += &format!("    {}_state m{k};\n", of.as_str());
    }
    filling.set("member_states", states);
    filling.set("member_fields", fields);
    filling.set("members_code", members::code(estimator, inputs, name));
    Ok(())
}

/// Sets the words of the functions that the body calls, and of those that these call.
fn helpers(filling: &mut Filling, body: &str, name: &Name) {
    let calls = |function: &str| body.contains(&format!("{}_{function}(", name.as_str()));
    let saturate = calls("saturate");
    filling.when("saturate", saturate);
    filling.when("larger", saturate || calls("larger"));
    filling.when("smaller", saturate || calls("smaller"));
    filling.when("magnitude", calls("magnitude"));
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
        + &literal::scalar(&format!("{n}_band"), model.band_factor)
        + &model.outside.as_ref().map_or_else(String::new, |outside| {
            literal::scalar(&format!("{n}_band_outside"), outside.band_factor)
        })
}

/// The signals that a law or a feature reads.
fn signals(filling: &mut Filling, estimator: &Estimator, name: &Name) {
    let law = &estimator.law;
    let mut used = laws::signals_used(law);
    if has_networks(estimator) {
        used.extend(law.features.iter().filter_map(|feature| match *feature {
            Feature::Signal(signal)
            | Feature::Rate(signal)
            | Feature::BelowMaximum(signal)
            | Feature::AboveMinimum(signal)
            | Feature::Product { signal, .. }
            | Feature::Clamped { signal, .. }
            | Feature::Stop { signal, .. }
            | Feature::LowPassDifference { signal, .. } => Some(signal),
            _ => None,
        }));
    }
    let rates = has_networks(estimator) && law.features.iter().any(|f| matches!(f, Feature::Rate(_)));
    filling.when("previous", rates || law.cell.as_ref().is_some_and(|cell| !cell.elastic.is_empty()));
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

/// The inputs of the networks.
fn features(filling: &mut Filling, estimator: &Estimator, name: &Name) {
    let law = &estimator.law;
    let (count, used) = (law.features.len(), has_networks(estimator));
    let stateful = |feature: &Feature| {
        matches!(
            feature,
            Feature::Stop { .. }
                | Feature::LowPassDifference { .. }
                | Feature::Previous(_)
                | Feature::BelowMaximum(_)
                | Feature::AboveMinimum(_)
        )
    };
    let wide = |feature: &Feature| matches!(feature, Feature::CellWidth | Feature::CellPosition);
    filling.set("feature_count", count);
    filling.set("feature_argument", if count > 0 { "const double *features," } else { "" });
    filling.set("feature_value", if count > 0 { "s->features," } else { "" });
    filling.when("features", used && count > 0);
    filling.when("stateful_features", used && law.features.iter().any(stateful));
    filling.when("dt", law.cable.is_some());
    filling
        .when("width", (law.has_physics() && law.cell.is_none()) || (used && law.features.iter().any(wide)));
    filling.when("constant", estimator.ensemble.is_none() && estimator.perceptron.is_none());
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
            Feature::Clamped { signal, low, high } => {
                let (low, high) = (literal::double(low), literal::double(high));
                plain(&format!("@_saturate(s->signals[{signal}], {low}, {high})"))
            }
            Feature::Stop { signal, radius } => {
                let r = literal::double(radius);
                let update = format!("@_saturate(before, u - {r}, u + {r})");
                with_state(k, signal, update, &format!("(u - s->states[{k}]) / {r}"))
            }
            Feature::LowPassDifference { signal, tau_s } => {
                let update = format!("before + (u - before) * dt_s / (dt_s + {})", literal::double(tau_s));
                with_state(k, signal, update, &format!("u - s->states[{k}]"))
            }
            Feature::Rate(i) => plain(&format!(
                "s->memory_started && dt_s > 0.0\n        ? @_saturate((s->signals[{i}] - s->previous[{i}]) / dt_s, \
                 -1e30, 1e30)\n        : 0.0"
            )),
            Feature::Previous(i) => format!(
                "    s->features[{k}] = s->memory_started ? s->states[{k}] : 0.0;\n    \
                 s->states[{k}] = s->features[{i}];\n"
            ),
            Feature::Sign { feature, scale } => format!(
                "    {{\n        const double x = s->features[{feature}] / {};\n        \
                 s->features[{k}] = x / sqrt(1.0 + x * x);\n    }}\n",
                literal::double(scale)
            ),
            Feature::BelowMaximum(signal) => {
                with_state(k, signal, "@_larger(before, u)".to_owned(), &format!("u - s->states[{k}]"))
            }
            Feature::AboveMinimum(signal) => {
                with_state(k, signal, "@_smaller(before, u)".to_owned(), &format!("u - s->states[{k}]"))
            }
            Feature::Product { feature, signal } => {
                plain(&format!("s->features[{feature}] * s->signals[{signal}]"))
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
