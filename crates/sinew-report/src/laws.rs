//! Classical laws and parameters with their intervals.

use super::format::{NONE, percent_of_range, significant, with_unit};
use super::plot::css_percent;
use super::record::Signals;
use sinew_identify::report::{ClassicalFit, Parameter};

/// One law, ready to show.
#[derive(Debug)]
pub(super) struct Law {
    pub(super) name: String,
    pub(super) equation: String,
    pub(super) rmse: String,
    pub(super) percent: String,
    pub(super) condition: String,
    pub(super) verdict: &'static str,
    pub(super) parameters: Vec<ParameterRow>,
    pub(super) remark: String,
}

/// One parameter, ready to show. The interval is drawn relative to the value: the track is from -100 % to
/// +100 %.
#[derive(Debug)]
pub(super) struct ParameterRow {
    pub(super) name: String,
    pub(super) unit: String,
    pub(super) value: String,
    pub(super) interval: String,
    pub(super) relative: String,
    pub(super) left: String,
    pub(super) width: String,
    pub(super) open_left: bool,
    pub(super) open_right: bool,
    pub(super) known: bool,
    pub(super) remark: String,
}

/// A law with its parameters.
pub(super) fn law(fit: &ClassicalFit, signals: &Signals) -> Law {
    Law {
        name: fit.law.clone(),
        equation: fit.equation.clone(),
        rmse: with_unit(&significant(fit.rmse, 3), signals.far_unit),
        percent: percent_of_range(fit.percent_of_range),
        condition: significant(fit.condition, 2),
        verdict: conditioning(fit.condition),
        parameters: fit.parameters.iter().map(parameter).collect(),
        remark: fit.remark.clone(),
    }
}

/// What a condition number implies for the parameters.
fn conditioning(condition: f64) -> &'static str {
    match condition {
        c if !c.is_finite() => "the parameters are not identifiable from these data",
        c if c < 1e3 => "the parameters are well conditioned",
        c if c < 1e6 => "the parameters are correlated: their intervals, not their values, are meaningful",
        _ => "some parameters are not identifiable from these data",
    }
}

/// A parameter with its interval, rounded to the digits that the interval supports.
pub(super) fn parameter(p: &Parameter) -> ParameterRow {
    let bounded = p.low.is_finite() && p.high.is_finite() && p.low <= p.high;
    let half = 0.5 * (p.high - p.low);
    let scale = p.value.abs().max(f64::MIN_POSITIVE);
    let digits = match bounded && half > 0.0 && half.is_finite() {
        true => (2.0 + (scale / half).log10().floor()).clamp(2.0, 6.0) as usize,
        false => 3,
    };
    let at = |v: f64| 0.5 + 0.5 * (v - p.value) / scale;
    let (from, to) = if bounded { (at(p.low), at(p.high)) } else { (0.0, 1.0) };
    let unit = if p.unit == "1" { String::new() } else { p.unit.clone() };
    ParameterRow {
        name: p.name.clone(),
        value: significant(p.value, digits),
        interval: match bounded {
            true => format!("{} … {}", significant(p.low, digits), significant(p.high, digits)),
            false => NONE.to_owned(),
        },
        relative: match bounded && half > 0.0 && p.value.abs() > 0.0 {
            true if half >= 10.0 * scale => "beyond ± 1000\u{202f}%".to_owned(),
            true => format!("± {}\u{202f}%", significant(100.0 * half / scale, 2)),
            false => String::new(),
        },
        left: css_percent(from),
        width: css_percent(to.min(1.0) - from.max(0.0)),
        open_left: from < 0.0 || !bounded,
        open_right: to > 1.0 || !bounded,
        known: p.identified,
        unit,
        remark: p.remark.clone(),
    }
}
