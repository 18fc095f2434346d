//! The table of all candidate models with their cross-validated errors.

use super::format::{count, percent, percent_of_range, significant};
use super::plot::css_percent;
use sinew_identify::report::{Candidate, IdentificationReport};

/// The table.
#[derive(Debug)]
pub(super) struct Models {
    pub(super) rows: Vec<ModelRow>,
    /// End of the axis of the dots, % of range.
    pub(super) axis_end: String,
    pub(super) folds: usize,
}

/// One model.
#[derive(Debug)]
pub(super) struct ModelRow {
    pub(super) name: String,
    pub(super) description: String,
    pub(super) chosen: bool,
    pub(super) rmse: String,
    pub(super) percent: String,
    pub(super) pearson: String,
    pub(super) coverage: String,
    pub(super) too_narrow: bool,
    pub(super) in_sample: String,
    pub(super) size: String,
    /// Position of the error over all folds, unless beyond the axis.
    pub(super) overall: Option<String>,
    pub(super) dots: Vec<Dot>,
    pub(super) spoken: String,
    pub(super) failed: Option<String>,
}

/// One fold of one model.
#[derive(Debug)]
pub(super) struct Dot {
    pub(super) at: String,
    pub(super) beyond: bool,
}

/// Best first, failed ones last.
pub(super) fn table(report: &IdentificationReport) -> Models {
    let mut sorted: Vec<&Candidate> = report.candidates.iter().collect();
    let place =
        |c: &Candidate| if c.failed.is_none() && c.score.is_finite() { c.score } else { f64::INFINITY };
    sorted.sort_by(|a, b| place(a).total_cmp(&place(b)));
    let scale = 100.0 / report.far_range;
    let end = axis_end(&sorted, scale);
    Models {
        axis_end: format!("{}\u{202f}%", significant(end, 1 + usize::from(end.fract() > 0.0))),
        folds: report.folds,
        rows: sorted.iter().map(|c| row(c, scale, end)).collect(),
    }
}

/// The axis covers four times the best error and every fold of the best model.
fn axis_end(sorted: &[&Candidate], scale: f64) -> f64 {
    let worst =
        |c: &Candidate| c.fold_rmse.iter().map(|f| f * scale).filter(|f| f.is_finite()).fold(0.0, f64::max);
    let most = sorted.iter().map(|c| worst(c)).fold(0.0, f64::max);
    let best = sorted.iter().find(|c| worst(c) > 0.0);
    let covered = best.map_or(0.0, |c| (4.0 * c.rmse * scale).max(worst(c)).min(most));
    if !(covered.is_finite() && covered > 0.0) {
        return 1.0;
    }
    let end = 1.05 * covered;
    let power = 10f64.powf(end.log10().floor());
    let round = [1.0, 1.5, 2.0, 3.0, 4.0, 5.0, 6.0, 8.0, 10.0].map(|m| m * power);
    round.into_iter().find(|r| *r >= end).unwrap_or(end)
}

fn row(c: &Candidate, scale: f64, end: f64) -> ModelRow {
    let folds: Vec<f64> = c.fold_rmse.iter().map(|f| f * scale).collect();
    let dots = folds.iter().filter(|f| f.is_finite());
    let (least, most) =
        dots.clone().fold((f64::INFINITY, f64::NEG_INFINITY), |(l, m), f| (l.min(*f), m.max(*f)));
    ModelRow {
        name: c.name.clone(),
        description: c.description.clone(),
        chosen: c.chosen,
        rmse: significant(c.rmse, 3),
        percent: percent_of_range(c.percent_of_range),
        pearson: significant(c.pearson, 4),
        coverage: percent(c.coverage95),
        too_narrow: c.coverage95 < 0.85,
        in_sample: significant(c.rmse_in_sample, 3),
        size: count(c.size),
        overall: (c.percent_of_range <= end).then(|| css_percent(c.percent_of_range / end)),
        dots: dots.map(|f| Dot { at: css_percent(f / end), beyond: *f > end }).collect(),
        spoken: format!("folds from {} to {}", percent_of_range(least), percent_of_range(most)),
        failed: c.failed.clone(),
    }
}
