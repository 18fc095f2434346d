//! Coverage of the band log by log, and the influence of each log on the others.

use super::format::{fixed, percent, percent_of_range, significant, with_unit};
use super::plot::css_percent;
use super::record::{Record, Score, Signals};
use sinew_identify::report::IdentificationReport;

/// Rows shown; the others are collapsed.
const ROWS: usize = 12;
/// Coverage below which a 95 % band is called too narrow.
const TOO_FEW: f64 = 0.85;

/// The section on the band.
#[derive(Debug)]
pub(super) struct Calibration {
    pub(super) rows: Vec<CalibrationRow>,
    pub(super) of: &'static str,
    /// Collapsed rows: those with the highest coverage.
    pub(super) more: Vec<CalibrationRow>,
    pub(super) target: String,
    pub(super) floor: String,
    pub(super) lowest: String,
    /// Whether the labels 95 and 100 do not overlap.
    pub(super) roomy: bool,
    pub(super) too_narrow: usize,
}

/// One log or trial.
#[derive(Debug)]
pub(super) struct CalibrationRow {
    pub(super) name: String,
    pub(super) at: String,
    pub(super) coverage: String,
    pub(super) low: bool,
    pub(super) half_width: String,
    pub(super) percent: String,
}

/// Coverage per log; per trial where there is only one log.
pub(super) fn calibration(records: &[Record], signals: &Signals, range: f64) -> Calibration {
    let one_log = records.iter().all(|r| r.log == records[0].log);
    let mut scores: Vec<(String, Score)> = Vec::new();
    for record in records {
        let name = if one_log { &record.label } else { &record.log };
        match scores.iter_mut().find(|(n, _)| n == name) {
            Some((_, score)) => score.add(&record.score()),
            None => scores.push((name.clone(), record.score())),
        }
    }
    scores.retain(|(_, s)| s.coverage().is_finite());
    if scores.len() > ROWS {
        scores.sort_by(|a, b| a.1.coverage().total_cmp(&b.1.coverage()));
    }
    let least = scores.iter().fold(1.0f64, |m, (_, s)| m.min(s.coverage()));
    let start = if least >= 0.75 { 0.7 } else { (10.0 * (least - 0.05)).floor().max(0.0) / 10.0 };
    let at = |coverage: f64| css_percent((coverage - start) / (1.0 - start));
    let mut rows: Vec<CalibrationRow> = scores
        .iter()
        .map(|(name, score)| CalibrationRow {
            name: name.clone(),
            at: at(score.coverage()),
            coverage: percent(score.coverage()),
            low: score.coverage() < TOO_FEW,
            half_width: with_unit(&format!("± {}", significant(score.half_width(), 2)), signals.far_unit),
            percent: percent_of_range(100.0 * score.rmse() / range),
        })
        .collect();
    Calibration {
        too_narrow: rows.iter().filter(|r| r.low).count(),
        more: rows.split_off(rows.len().min(ROWS)),
        of: if one_log && records.len() > 1 { "trial" } else { "log" },
        roomy: start > 0.65,
        target: at(0.95),
        floor: at(TOO_FEW),
        lowest: format!("{}\u{202f}%", fixed(100.0 * start, 0)),
        rows,
    }
}

/// One bar of the influence check.
#[derive(Debug)]
pub(super) struct InfluenceBar {
    pub(super) name: String,
    pub(super) left: String,
    pub(super) width: String,
    pub(super) zero: String,
    pub(super) factor: String,
    pub(super) dropped: bool,
    pub(super) remark: String,
}

/// Influence as bars from zero; excluded logs first, then by influence.
pub(super) fn influence(report: &IdentificationReport) -> Vec<InfluenceBar> {
    let mut rows: Vec<_> = report.influence.iter().collect();
    rows.sort_by(|a, b| b.dropped.cmp(&a.dropped).then(b.influence.total_cmp(&a.influence)));
    let values = || rows.iter().map(|r| r.influence).filter(|v| v.is_finite());
    // The axis covers at least exp(0.5), so that noise does not appear as an effect.
    let low = values().fold(-0.05f64, f64::min);
    let high = values().fold(0.5f64, f64::max);
    let at = |v: f64| (v - low) / (high - low);
    rows.iter()
        .map(|row| {
            let value = if row.influence.is_finite() { row.influence } else { 0.0 };
            let (from, to) = (at(value.min(0.0)), at(value.max(0.0)));
            InfluenceBar {
                name: row.log.clone(),
                left: css_percent(from),
                width: css_percent(to - from),
                zero: css_percent(at(0.0)),
                factor: format!("×\u{202f}{}", significant(row.influence.exp(), 3)),
                dropped: row.dropped,
                remark: row.remark.clone(),
            }
        })
        .collect()
}
