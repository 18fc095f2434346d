//! The parameters of one classical law: one number for one quantity.

use super::evidence::Evidence;
use super::parameters::{NOT_FITTED, jackknife};
use crate::fit::classical::{ClassicalFit, FRICTION_ANGLE, PRETENSION, Parameter, STIFFNESS};
use crate::select::candidates::CONSTANT;
use crate::select::cross_validation::{CrossValidation, ScoredCandidate};
use crate::select::laws::ScoredLaw;
use serde::Serialize;
use sinew::metrics::Comparison;

/// Error of a law over the least from which one with fewer numbers is not preferred to it.
const AS_GOOD: f64 = 1.05;

/// Error of a law over that of the chosen model above which the log contradicts it, where it is above
/// [`NEGLIGIBLE`] of the range.
const CONTRADICTED: f64 = 1.5;
const NEGLIGIBLE: f64 = 0.01;

/// Error of a law over that of a constant above which it explains too little for its numbers to mean
/// anything.
const DOUBTFUL: f64 = 0.33;

/// The parameters that a log determines, of the law that describes it best.
#[derive(Debug, Clone, Serialize)]
pub struct Headline {
    /// [`ClassicalFit::law`].
    pub law: String,
    /// Why this law; completes "because".
    pub reason: String,
    /// Its parameters. An interval covers that of the fit and the spread over the folds.
    pub parameters: Vec<Parameter>,
    /// Why they are not to be used; completes "because".
    pub withdrawn: Option<String>,
}

/// Root mean square error of a law on held-out data.
fn error(validation: &CrossValidation) -> f64 {
    validation.comparison.rmse().unwrap_or(f64::INFINITY)
}

/// The chosen model where it is the cable's own law. Else of the laws with a friction angle, or where there
/// is none of all, the one with the fewest parameters among those with about the least error on held-out
/// data.
pub(super) fn headline(
    evidence: &Evidence<'_>,
    fits: &[ClassicalFit],
    of_chosen: &[Parameter],
) -> Option<Headline> {
    let origin = &evidence.model.provenance;
    if evidence.model.estimator.law.cable.is_some() {
        return Some(Headline {
            law: origin.member.clone(),
            reason: format!(
                "it is the chosen model, with an error of {:.1} % of the range on unseen data",
                100.0 * origin.rmse_unseen / origin.far_range
            ),
            parameters: of_chosen.to_vec(),
            withdrawn: kept(of_chosen).or_else(|| better(evidence)),
        });
    }
    let has_angle = |fit: &ClassicalFit| fit.parameters.iter().any(|p| p.name == FRICTION_ANGLE);
    let any_angle = fits.iter().any(has_angle);
    let mut rows = Vec::new();
    for fit in fits.iter().filter(|fit| has_angle(fit) == any_angle) {
        let law = evidence.laws.iter().find(|law| law.scored.name == fit.law);
        rows.extend(law.and_then(|law| Some((fit, law, law.scored.validation()?))));
    }
    let least = rows.iter().map(|(.., validation)| error(validation)).fold(f64::INFINITY, f64::min);
    let good = rows.iter().filter(|(.., validation)| error(validation) <= AS_GOOD * least);
    let (fit, law, validation) = good.min_by_key(|(.., validation)| validation.size)?;
    let kind = if any_angle { "laws with a friction angle" } else { "classical laws" };
    let percent = |rmse: f64| 100.0 * rmse / evidence.model.provenance.far_range;
    let reason = if error(validation) <= least {
        format!("of the {kind} it has the least error on unseen data, {:.1} % of the range", percent(least))
    } else {
        let (more, size) = (100.0 * (error(validation) / least - 1.0), validation.size);
        format!(
            "with {size} numbers its error on unseen data is only {more:.0} % above the least of the {kind}"
        )
    };
    let named =
        |p: &&Parameter| !any_angle || [FRICTION_ANGLE, PRETENSION, STIFFNESS].contains(&p.name.as_str());
    let parameters: Vec<Parameter> =
        fit.parameters.iter().filter(named).map(|parameter| widened(parameter, law)).collect();
    let withdrawn = contradiction(evidence, fit, validation, &parameters);
    Some(Headline { law: fit.law.clone(), reason, parameters, withdrawn })
}

/// That no parameter was fitted.
fn kept(parameters: &[Parameter]) -> Option<String> {
    let kept = parameters.iter().all(|parameter| parameter.remark == NOT_FITTED);
    kept.then(|| "the model was kept as it was: none of them was fitted to these logs".to_owned())
}

/// That another candidate contradicts the chosen one, as a regression does where the anchor is a copy of the
/// far side.
fn better(evidence: &Evidence<'_>) -> Option<String> {
    let range = evidence.model.provenance.far_range;
    let of = |scored: &ScoredCandidate| scored.validation().map_or(f64::INFINITY, error);
    let chosen = of(&evidence.scored[evidence.chosen]);
    let best = evidence.scored.iter().min_by(|a, b| of(a).total_cmp(&of(b)))?;
    let contradicted = chosen > CONTRADICTED * of(best) && chosen > NEGLIGIBLE * range;
    contradicted.then(|| contradicted_by(chosen, &best.name, of(best), range))
}

fn contradicted_by(found: f64, name: &str, best: f64, range: f64) -> String {
    format!(
        "the log contradicts the law: on unseen data it errs by {:.1} % of the range, {name} by {:.1} %",
        100.0 * found / range,
        100.0 * best / range
    )
}

/// A parameter whose interval also covers the spread over the folds.
fn widened(parameter: &Parameter, law: &ScoredLaw) -> Parameter {
    let of_fold = |fit: &ClassicalFit| Some(fit.parameters.iter().find(|p| p.name == parameter.name)?.value);
    let folds: Vec<f64> = law.fits.iter().filter_map(of_fold).collect();
    let (low, high) = jackknife(parameter.value, &folds);
    // Both are not a number where they are not known.
    Parameter { low: parameter.low.min(low), high: parameter.high.max(high), ..parameter.clone() }
}

/// Why the log does not determine the law; nothing where it does.
fn contradiction(
    evidence: &Evidence<'_>,
    fit: &ClassicalFit,
    validation: &CrossValidation,
    parameters: &[Parameter],
) -> Option<String> {
    let range = evidence.model.provenance.far_range;
    let chosen = &evidence.scored[evidence.chosen];
    let best = chosen.validation().and_then(|v| Comparison::rmse(&v.comparison)).unwrap_or(f64::NAN);
    let found = error(validation);
    if found > CONTRADICTED * best && found > NEGLIGIBLE * range {
        return Some(contradicted_by(found, &chosen.name, best, range));
    }
    let constant = evidence.scored.iter().find(|scored| scored.name == CONSTANT);
    let constant = constant.and_then(ScoredCandidate::validation).map_or(f64::INFINITY, error);
    if found > DOUBTFUL * constant {
        let percent = 100.0 * found / constant;
        return Some(format!("its error on unseen data is {percent:.0} % of that of a constant"));
    }
    let open = parameters.iter().find(|p| p.name == FRICTION_ANGLE && !p.identified);
    if let Some(angle) = open {
        return Some(format!("the friction angle is not determined: {}", angle.remark));
    }
    parameters.is_empty().then(|| format!("{} has no parameters here", fit.law))
}

/// Takes the friction angle of every law that is worse than the headline's for not determined: it is not a
/// second number for the same quantity.
pub(super) fn withdraw_others(headline: &Headline, evidence: &Evidence<'_>, fits: &mut [ClassicalFit]) {
    let error_of = |name: &str| {
        let law = evidence.laws.iter().find(|law| law.scored.name == name)?;
        law.scored.validation().map(error)
    };
    let chosen = evidence.scored[evidence.chosen].validation().map(error);
    let Some(least) = error_of(&headline.law).or(chosen) else { return };
    for fit in fits.iter_mut().filter(|fit| fit.law != headline.law) {
        let ratio = error_of(&fit.law).map_or(f64::INFINITY, |error| error / least);
        for parameter in fit.parameters.iter_mut().filter(|p| ratio > AS_GOOD && p.name == FRICTION_ANGLE) {
            parameter.identified = false;
            parameter.remark = if ratio.is_finite() {
                let times = if ratio < 100.0 { format!("{ratio:.1}") } else { "more than 100".to_owned() };
                format!("the law errs {times} times as much as {}, whose angle counts", headline.law)
            } else {
                format!("the angle of {} counts", headline.law)
            };
        }
    }
}

impl Headline {
    /// In one sentence, as in "friction angle = 0.545 (0.520 to 0.570), ...".
    #[must_use]
    pub fn in_words(&self) -> String {
        let number = |p: &Parameter| {
            let unit = if p.unit == "1" { String::new() } else { format!(" {}", p.unit) };
            let digits = |value: f64| significant(value, p.high - p.low);
            if !p.identified {
                return format!("{} not determined", p.name);
            }
            let (value, low, high) = (digits(p.value), digits(p.low), digits(p.high));
            format!("{} = {value} ({low} to {high}){unit}", p.name)
        };
        let numbers: Vec<String> = self.parameters.iter().map(number).collect();
        let (law, reason) = (&self.law, &self.reason);
        match &self.withdrawn {
            Some(withdrawn) => {
                format!(
                    "No law's parameters are reported, because {withdrawn}. It would be {law}, because {reason}."
                )
            }
            None => format!("{}. The law is {law}, because {reason}.", numbers.join(", ")),
        }
    }
}

/// A number with the digits that its interval supports; without one with three.
fn significant(value: f64, interval: f64) -> String {
    let size = if interval > 0.0 { interval } else { value.abs() };
    let digits = if size > 0.0 { (2.0 - size.log10()).floor().clamp(0.0, 9.0) as usize } else { 0 };
    format!("{value:.digits$}")
}

#[cfg(test)]
mod tests {
    use super::*;

    #[test]
    fn a_headline_has_the_digits_of_its_intervals_and_is_silent_where_it_is_withdrawn() {
        let parameter = |name: &str, value: f64, half: f64| Parameter {
            name: name.into(),
            unit: "1".into(),
            value,
            low: value - half,
            high: value + half,
            identified: true,
            remark: String::new(),
        };
        let mut headline = Headline {
            law: "capstan play".into(),
            reason: "it is best".into(),
            parameters: vec![parameter("mu", 0.5449, 0.025), parameter("T", 3.0, 20.0)],
            withdrawn: None,
        };
        let words = headline.in_words();
        assert_eq!(
            words,
            "mu = 0.545 (0.520 to 0.570), T = 3 (-17 to 23). The law is capstan play, because it is best."
        );
        headline.withdrawn = Some("the log contradicts it".into());
        let words = headline.in_words();
        assert!(
            !words.contains("0.545")
                && words.starts_with("No law's parameters are reported, because the log")
        );
    }
}
