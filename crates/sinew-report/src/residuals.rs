//! Out-of-fold errors of the selected model, predicted minus measured, against speed, tension and time since
//! reversal, the arguments of friction laws: the errors of an ideal model depend on none of them.

use super::format::{significant, with_unit};
use super::plot::Plot;
use super::record::{Record, Signals};
use super::scale::{Axis, padded, quantile};
use super::svg_path::{Pen, line, ribbon};

/// One plot with its largest bias and spread in words.
#[derive(Debug)]
pub(super) struct Residual {
    pub(super) heading: &'static str,
    pub(super) plot: Plot,
    pub(super) remark: String,
}

/// Quantiles of the error, in the far side's unit, over samples with neighbouring values of the abscissa.
#[derive(Debug, Clone, Copy)]
struct Bin {
    /// Median of the abscissa.
    x: f64,
    /// 5 %.
    low: f64,
    /// 25 %.
    quarter: f64,
    /// 50 %.
    median: f64,
    /// 75 %.
    three_quarters: f64,
    /// 95 %.
    high: f64,
}

/// Minimum number of samples per bin: of 30, two lie below the 5 % quantile and two above the 95 % quantile.
const PER_BIN: usize = 30;
/// Maximum number of bins, the points of a line.
const BINS: usize = 32;

/// Abscissa of a residual plot.
#[derive(Debug, Clone, Copy)]
enum Abscissa {
    /// Rate of the near signal, its unit per s, causally smoothed; a speed where that signal is a position.
    Speed,
    /// Near signal.
    Near,
    /// Measured far signal.
    Far,
    /// Time since the near signal last reversed, s.
    Reversal,
}

impl Abscissa {
    fn value(self, record: &Record, i: usize) -> f64 {
        match self {
            Self::Speed => record.near_rate[i],
            Self::Near => record.near[i],
            Self::Far => record.far[i],
            Self::Reversal => record.since_reversal_s[i],
        }
    }

    fn heading(self, signals: &Signals) -> &'static str {
        match self {
            Self::Speed => "Versus speed",
            Self::Near if is_load(signals.near_unit) => "Versus near tension",
            Self::Near => "Versus near side",
            Self::Far => "Versus far tension",
            Self::Reversal => "Versus time since reversal",
        }
    }

    fn unit(self, signals: &Signals) -> String {
        match (self, signals.near_unit) {
            (Self::Speed, "") => String::new(),
            (Self::Speed, unit) => format!("{unit}/s"),
            (Self::Near, unit) => unit.to_owned(),
            (Self::Far, _) => signals.far_unit.to_owned(),
            (Self::Reversal, _) => "s".to_owned(),
        }
    }

    fn label(self, signals: &Signals) -> String {
        match self {
            Self::Speed => signals.rate_label(),
            Self::Near => signals.near_label(),
            Self::Far => signals.far_label(),
            Self::Reversal => "time since reversal (s)".to_owned(),
        }
    }
}

/// Whether a unit is that of a force or a torque.
fn is_load(unit: &str) -> bool {
    matches!(unit, "N" | "N·m" | "N·mm")
}

/// The plots, all with the same error axis.
pub(super) fn plots(records: &[Record], signals: &Signals) -> Vec<Residual> {
    // Friction depends on load: where only the far side measures it, the far side is the abscissa.
    let far = is_load(signals.far_unit) && !is_load(signals.near_unit);
    let load = if far { Abscissa::Far } else { Abscissa::Near };
    let binned = [Abscissa::Speed, load, Abscissa::Reversal].map(|a| (a, bins(collect(records, a))));
    let all = || binned.iter().flat_map(|(_, bins)| bins);
    let reach = all().fold(0.0f64, |m, b| m.max(b.low.abs()).max(b.high.abs()));
    let y = Axis::new(padded((-reach, reach), 0.08), 5);
    let useful = binned.iter().filter(|(_, bins)| !bins.is_empty());
    useful
        .map(|(abscissa, bins)| Residual {
            heading: abscissa.heading(signals),
            plot: draw(bins, &y, *abscissa, signals),
            remark: remark(bins, signals.far_unit, &abscissa.unit(signals)),
        })
        .collect()
}

/// Abscissa and error of every scored sample.
fn collect(records: &[Record], abscissa: Abscissa) -> Vec<(f64, f64)> {
    let row = |r: &Record, i| (abscissa.value(r, i), r.scored_error(i));
    let pairs = records.iter().flat_map(|r| (0..r.len()).map(move |i| row(r, i)));
    pairs.filter(|(x, e)| x.is_finite() && e.is_finite()).collect()
}

/// Bins of `pairs`, abscissa and error, with about equally many samples over the inner 99 % of the abscissa.
/// A bin of fewer than [`PER_BIN`] samples becomes part of the next one; at the end it is left out.
fn bins(mut pairs: Vec<(f64, f64)>) -> Vec<Bin> {
    pairs.sort_by(|a, b| a.0.total_cmp(&b.0).then(a.1.total_cmp(&b.1)));
    let cut = pairs.len() / 200;
    let pairs = &pairs[cut..pairs.len() - cut];
    let count = (pairs.len() / PER_BIN).clamp(1, BINS);
    let mut bins: Vec<Bin> = Vec::new();
    let mut errors: Vec<f64> = Vec::new();
    let mut start = 0;
    for k in 1..=count {
        let mut end = (k * pairs.len() / count).max(start);
        // Equal values stay in one bin: a signal at rest would otherwise fill several bins with one value.
        while end > 0 && end < pairs.len() && pairs[end].0 <= pairs[end - 1].0 {
            end += 1;
        }
        if end == start || end - start < PER_BIN.min(pairs.len()) {
            continue;
        }
        errors.clear();
        errors.extend(pairs[start..end].iter().map(|p| p.1));
        errors.sort_by(f64::total_cmp);
        let q = |fraction| quantile(&errors, fraction);
        bins.push(Bin {
            x: pairs[start + (end - start) / 2].0,
            low: q(0.05),
            quarter: q(0.25),
            median: q(0.5),
            three_quarters: q(0.75),
            high: q(0.95),
        });
        start = end;
    }
    bins
}

fn draw(bins: &[Bin], y: &Axis, abscissa: Abscissa, signals: &Signals) -> Plot {
    let ends = bins.iter().fold((f64::INFINITY, f64::NEG_INFINITY), |(l, h), b| (l.min(b.x), h.max(b.x)));
    let x = Axis::new(padded(ends, 0.02), 5);
    let title =
        format!("Error {}: median, quartiles and 5 to 95 % range", abscissa.heading(signals).to_lowercase());
    let mut plot = Plot::new(
        "residual",
        title,
        (&x, abscissa.label(signals)),
        (y, signals.in_far_unit("predicted − measured")),
    )
    .without_names();
    plot.draw("wide", "90 % of the samples", ribbon(bins.iter().map(|b| (b.x, b.low, b.high)), &x, y));
    plot.draw(
        "quartiles",
        "50 % of the samples",
        ribbon(bins.iter().map(|b| (b.x, b.quarter, b.three_quarters)), &x, y),
    );
    plot.draw("zero", "", line([(x.low, 0.0), (x.high, 0.0)].into_iter(), &x, y));
    plot.draw("median", "median", line(bins.iter().map(|b| (b.x, b.median)), &x, y));
    let mut dots = Pen::default();
    for bin in bins {
        dots.line_to(x.at(bin.x), y.at(bin.median));
        dots.lift();
    }
    plot.draw("dots", "", dots.finish());
    plot
}

/// Largest bias (median error) and largest spread (5 to 95 %), and where they are, in words.
fn remark(bins: &[Bin], unit: &str, x_unit: &str) -> String {
    let error = |v: f64| with_unit(&significant(v, 2), unit);
    let place = |v: f64| with_unit(&significant(v, 2), x_unit);
    let by = |key: &dyn Fn(&Bin) -> f64| bins.iter().max_by(|a, b| key(a).total_cmp(&key(b)));
    let (Some(biased), Some(wide)) = (by(&|b| b.median.abs()), by(&|b| b.high - b.low)) else {
        return String::new();
    };
    format!(
        "Largest median error: {} at {}. Largest 90\u{202f}% spread: {} at {}.",
        error(biased.median),
        place(biased.x),
        error(wide.high - wide.low),
        place(wide.x)
    )
}
