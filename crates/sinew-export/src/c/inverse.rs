//! The compensator of a model: its constants.

use super::content::Content;
use super::literal::{comment, double, scalar};
use super::template::Filling;
use crate::{ExportError, Name};
use sinew::compensator::{Compensator, CompensatorConstants, MAX_EVALUATIONS};
use sinew::predictor::Model;

/// Fills what a compensator needs beside its model; nothing where the predictor alone is asked for.
///
/// # Errors
/// As [`Compensator::new`].
pub(super) fn fill(
    filling: &mut Filling,
    model: &Model,
    name: &Name,
    content: Content,
) -> Result<(), ExportError> {
    let Content::Compensator(settings) = content else { return Ok(()) };
    let constants = Compensator::new(model.clone(), &settings)?.constants();
    let cable = model.estimator.law.cable.as_ref();
    let everywhere = cable.is_none_or(|cable| cable.model.zero_stretch.is_none());
    filling.when("inverse", true);
    filling.when("expecting", cable.is_some());
    filling.when("moves", constants.direction != 0.0);
    filling.when("everywhere", constants.direction != 0.0 && everywhere);
    filling.set("near_column", comment(&model.inputs[constants.near].column));
    filling.set("max_evaluations", MAX_EVALUATIONS);
    let changes = cable.is_some_and(|cable| cable.model.learning > 0.0 || cable.model.warming.is_some());
    filling.set("drag_factor", if changes { "c->model.drag_factor" } else { "1.0" });
    let mut tables = tables(&constants, name.as_str(), everywhere);
    if let Some(cable) = cable {
        let initial = if cable.model.start < 0.0 { -1.0 } else { 1.0 };
        tables += &scalar(&format!("{}_stretch_initial", name.as_str()), initial);
        // Validation has refused a model without a law before.
        let speed = cable.model.law().ok().and_then(|law| law.weakening().map(|weakening| weakening.speed));
        if let Some(speed) = speed {
            tables += &scalar(&format!("{}_weakening_speed", name.as_str()), speed);
        }
    }
    filling.set("inverse_tables", tables);
    Ok(())
}

fn tables(constants: &CompensatorConstants, n: &str, everywhere: bool) -> String {
    let CompensatorConstants { near, direction, command: [min, max], rate, tolerance, attained, cable } =
        *constants;
    let mut text = format!("enum {{ {n}_near = {near}, {n}_rising = {} }};\n", u8::from(direction > 0.0));
    let mut one = |what: &str, x: f64| text += &scalar(&format!("{n}_{what}"), x);
    one("min", min);
    one("max", max);
    one("tolerance", tolerance);
    one("attained", attained);
    if direction != 0.0 {
        let rate = if rate.is_finite() { double(rate) } else { "HUGE_VAL".to_owned() };
        text += &format!("static const double {n}_rate = {rate};\n");
    }
    if let Some(cable) = cable {
        let mut one = |what: &str, x: f64| text += &scalar(&format!("{n}_{what}"), x);
        one("largest_change", cable.change);
        if everywhere {
            one("tension_min", cable.tension[0]);
            one("tension_max", cable.tension[1]);
            text += &format!("enum {{ {n}_tension_rising = {} }};\n", u8::from(cable.rising));
        } else {
            one("first_change", cable.first_change);
        }
    }
    text
}
