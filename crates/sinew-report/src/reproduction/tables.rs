//! Tables of the page that compares the simulation with the paper `yuan2023`: its Tables I to III, the errors
//! of the predicted elongation, and other specimens.
//!
//! Arrays are `[side][speed]`: first the active muscle, whose motor pulls the cable in, then the passive one,
//! whose cable the load pulls out; at the cable speeds of [`SPEEDS`], m/s.

use super::indices::{MUSCLES, largest, sides};
use crate::format::{NONE, fixed};
use crate::variants::label;
use sinew_lab::CompensationVariant;
use sinew_lab::paper::{self, SPEEDS};
use sinew_lab::reproduce::{BenchPart, BenchResults, ByVariant, Indices, Sides};

/// One table with a column per speed.
#[derive(Default)]
pub(super) struct Table {
    pub(super) heading: &'static str,
    pub(super) note: &'static str,
    /// Whether it has a column of [`Row::pearson`].
    pub(super) pearson: bool,
    /// Whether it has a column of [`Row::recovery`].
    pub(super) recovery: bool,
    pub(super) rows: Vec<Row>,
}

/// Results of a compensation, of the paper, of the simulation or of a specimen for one muscle.
#[derive(Default)]
pub(super) struct Row {
    pub(super) name: String,
    /// Active or passive.
    pub(super) muscle: &'static str,
    /// Whether it is this project's result, which the page emphasises.
    pub(super) ours: bool,
    /// Label on a narrow screen, and text.
    pub(super) cells: Vec<(String, String)>,
    /// Least correlation over the speeds.
    pub(super) pearson: String,
    /// Least and largest mean recovery time over the speeds, s.
    pub(super) recovery: String,
}

/// Errors of the elongation that methods predict from the same signals.
pub(super) struct ElongationRow {
    /// The signals.
    pub(super) known: &'static str,
    /// mm rms: equation 10, the paper's network, this project's model.
    pub(super) cells: Vec<String>,
    /// This project's model.
    pub(super) ours: &'static str,
}

/// A cell per speed.
fn cells(row: &[f64; 6], decimals: usize) -> Vec<(String, String)> {
    SPEEDS.iter().zip(row).map(|(v, x)| (format!("{} m/s", fixed(*v, 2)), fixed(*x, decimals))).collect()
}

/// Errors of the far tension, N rms: (a) as in Table I, with the paper's numbers; (b) and (c) are added.
pub(super) fn table1(results: &BenchResults) -> Vec<Table> {
    let rows = |table: &ByVariant| {
        let mut rows = Vec::new();
        for variant in CompensationVariant::ALL {
            let Some(found) = table.get(&variant) else { continue };
            for (side, muscle) in sides(found).into_iter().zip(MUSCLES) {
                rows.push(Row {
                    name: label(variant).to_owned(),
                    muscle,
                    ours: variant == CompensationVariant::Observer,
                    cells: cells(&side.rmse_n, 2),
                    pearson: fixed(side.pearson.iter().copied().fold(f64::NAN, f64::min), 4),
                    recovery: side.recovery_s.map_or(NONE.to_owned(), |seconds| {
                        let least = seconds.iter().copied().fold(f64::NAN, f64::min);
                        format!("{} to {}", fixed(least, 2), fixed(largest(&seconds), 2))
                    }),
                });
            }
        }
        rows
    };
    let mut achieved = rows(&results.table1);
    for (side, muscle) in MUSCLES.into_iter().enumerate() {
        achieved.push(Row {
            name: "the paper, measured".to_owned(),
            muscle,
            cells: cells(&paper::RMSE_N[side], 2),
            pearson: fixed(paper::PEARSON[side].iter().copied().fold(f64::NAN, f64::min), 4),
            ..Row::default()
        });
    }
    vec![
        Table {
            heading: "(a) Tracking error, steady windows",
            note: "As in the paper’s Table I: strokes at full speed, after the slip front of the reversal \
             has passed.",
            pearson: true,
            rows: achieved,
            ..Table::default()
        },
        Table {
            heading: "(b) Estimation error, whole cycles",
            note: "Estimated minus true far tension, reversals included.",
            rows: rows(&results.table1_estimate),
            ..Table::default()
        },
        Table {
            heading: "(c) Tracking error, whole cycles",
            note: "After a reversal the winch must first take up the elongation of the cable, which no \
             compensation avoids. Recovery: time until the far tension stays within 5 N of its reference for \
             0.2 s.",
            recovery: true,
            rows: rows(&results.table1_cycles),
            ..Table::default()
        },
    ]
}

/// Tables II and III, mean ± standard deviation: the paper above the simulation. The efficiency is
/// `T_out/T_in` for both sides, as in the paper: above 1 for the passive muscle.
pub(super) fn tables23(part: &BenchPart) -> Vec<Table> {
    // `ours` holds the pairs of mean and standard deviation.
    let table = |heading, ours: &[[[f64; 2]; 6]; 2], means: &[[f64; 6]; 2], spreads: &[[f64; 6]; 2]| {
        let mut rows = Vec::new();
        for (side, muscle) in MUSCLES.into_iter().enumerate() {
            for (name, numbers, ours) in [
                ("paper", [means[side], spreads[side]], false),
                ("twin", [ours[side].map(|a| a[0]), ours[side].map(|a| a[1])], true),
            ] {
                let content = numbers[0].iter().zip(&numbers[1]);
                let cells = SPEEDS.iter().zip(content).map(|(v, (mean, spread))| {
                    (format!("{} m/s", fixed(*v, 2)), format!("{} ± {}", fixed(*mean, 3), fixed(*spread, 3)))
                });
                rows.push(Row {
                    name: name.to_owned(),
                    muscle,
                    ours,
                    cells: cells.collect(),
                    ..Row::default()
                });
            }
        }
        Table { heading, rows, ..Table::default() }
    };
    let found = &part.mechanism;
    vec![
        table(
            "Table II: efficiency, far over near tension",
            &found.efficiency,
            &paper::EFFICIENCY,
            &paper::EFFICIENCY_SD,
        ),
        table(
            "Table III: elongation over near tension and length, 10⁻³ m/(N m)",
            &found.elongation,
            &paper::ELONGATION,
            &paper::ELONGATION_SD,
        ),
    ]
}

/// Names the means of Tables II and III that deviate from the paper's by more than 16 %, this project's
/// target for the largest deviation (`sinew-lab/tests/cable_tables.rs` tests it on the calibrated cable).
pub(super) fn beyond(part: &BenchPart) -> String {
    let mut names = Vec::new();
    for (name, found, reported) in [
        ("efficiency", &part.mechanism.efficiency, &paper::EFFICIENCY),
        ("elongation", &part.mechanism.elongation, &paper::ELONGATION),
    ] {
        for (side, muscle) in MUSCLES.into_iter().enumerate() {
            for (k, speed) in SPEEDS.into_iter().enumerate() {
                let difference = found[side][k][0] / reported[side][k] - 1.0;
                if difference.abs() > 0.16 {
                    names.push(format!(
                        "{muscle} {name} at {} m/s ({} %)",
                        fixed(speed, 2),
                        fixed(100.0 * difference, 0)
                    ));
                }
            }
        }
    }
    if names.is_empty() {
        "Every mean is within 16 % of the paper’s.".to_owned()
    } else {
        format!("Deviation above 16 %: {}.", names.join(", "))
    }
}

/// Errors of the predicted elongation over whole cycles, mm rms.
pub(super) fn elongation(results: &BenchResults) -> Vec<ElongationRow> {
    let found = &results.elongation_mm;
    let cells = |table: &std::collections::BTreeMap<&str, f64>, ours: &str| {
        ["equation10", "paper", ours]
            .map(|key| table.get(key).map_or(NONE.to_owned(), |mm| fixed(*mm, 2)))
            .to_vec()
    };
    vec![
        ElongationRow {
            known: "near side",
            cells: cells(&found.near_only, "memory"),
            ours: "network with memory of the near side",
        },
        ElongationRow {
            known: "near side and joint sensor",
            cells: cells(&found.joint_sensor, "observer"),
            ours: "cable observer",
        },
    ]
}

/// Specimens drawn at random, with the observer: largest error over the speeds, N rms. `max. ratio` is the
/// largest ratio, over the speeds, of the errors (c) with the observer and with the true state of the cable.
pub(super) fn others(results: &BenchResults) -> Vec<Row> {
    let mut rows = Vec::new();
    for specimen in &results.other_specimens {
        for (side, muscle) in MUSCLES.into_iter().enumerate() {
            let of = |table: &Sides<Indices>| sides(table)[side].rmse_n;
            let (cycles, perfect) = (of(&specimen.table1_cycles), of(&specimen.perfect_cycles));
            let ratio = cycles.iter().zip(&perfect).map(|(a, b)| a / b).fold(f64::NAN, f64::max);
            let cell = |label: &str, row: &[f64; 6]| (label.to_owned(), fixed(largest(row), 2));
            rows.push(Row {
                name: format!("seed {}", specimen.seed),
                muscle,
                cells: vec![
                    cell("(a) tracking, steady", &of(&specimen.table1)),
                    cell("(b) estimation", &of(&specimen.table1_estimate)),
                    cell("(c) tracking, whole cycles", &cycles),
                    cell("(c) with true cable state", &perfect),
                    ("max. ratio".to_owned(), fixed(ratio, 2)),
                ],
                ..Row::default()
            });
        }
    }
    rows
}
