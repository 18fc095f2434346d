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
use sinew_lab::reproduce::{BenchPart, BenchResults, ByVariant, Indices, Sides, WithoutJointEncoder};

/// One table with a column per speed.
#[derive(Default)]
pub(super) struct Table {
    pub(super) heading: &'static str,
    pub(super) notes: Vec<String>,
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
    /// Simulated, hardware, or their difference.
    pub(super) source: &'static str,
    /// Whether it is this project's result, which the page emphasises.
    pub(super) ours: bool,
    pub(super) cells: Vec<String>,
    /// Least correlation over the speeds.
    pub(super) pearson: String,
    /// Smallest and largest mean recovery time over the speeds, s.
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
fn cells(row: &[f64; 6], decimals: usize) -> Vec<String> {
    row.iter().map(|x| fixed(*x, decimals)).collect()
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
                    source: SIMULATED,
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
    let without = |of: fn(&WithoutJointEncoder) -> &Sides<Indices>| {
        let sides = sides(of(&results.without_joint_encoder)).into_iter().zip(MUSCLES);
        sides.map(|(side, muscle)| Row {
            name: "observer without joint encoder".to_owned(),
            muscle,
            source: SIMULATED,
            cells: cells(&side.rmse_n, 2),
            pearson: fixed(side.pearson.iter().copied().fold(f64::NAN, f64::min), 4),
            recovery: NONE.to_owned(),
            ..Row::default()
        })
    };
    let mut achieved = rows(&results.table1);
    achieved.extend(without(|found| &found.table1));
    achieved.extend(hardware(results));
    let (mut estimated, mut cycles) = (rows(&results.table1_estimate), rows(&results.table1_cycles));
    estimated.extend(without(|found| &found.table1_estimate));
    cycles.extend(without(|found| &found.table1_cycles));
    vec![
        Table {
            heading: "(a) Tracking error, steady windows",
            notes: table1_notes(results),
            pearson: true,
            rows: achieved,
            ..Table::default()
        },
        Table {
            heading: "(b) Estimation error, whole cycles",
            notes: vec!["Estimated minus true far tension, reversals included.".to_owned()],
            rows: estimated,
            ..Table::default()
        },
        Table {
            heading: "(c) Tracking error, whole cycles",
            notes: cycle_notes(results),
            recovery: true,
            rows: cycles,
            ..Table::default()
        },
    ]
}

/// The paper's Table I, and the observer minus it.
fn hardware(results: &BenchResults) -> Vec<Row> {
    let ours = results.table1.get(&CompensationVariant::Observer).map(sides);
    let mut rows = Vec::new();
    for (side, muscle) in MUSCLES.into_iter().enumerate() {
        rows.push(Row {
            name: "the paper’s network".to_owned(),
            muscle,
            source: "hardware",
            cells: cells(&paper::RMSE_N[side], 2),
            pearson: fixed(paper::PEARSON[side].iter().copied().fold(f64::NAN, f64::min), 4),
            ..Row::default()
        });
    }
    for (side, muscle) in MUSCLES.into_iter().enumerate() {
        let Some(ours) = ours else { continue };
        let difference = std::array::from_fn(|k| ours[side].rmse_n[k] - paper::RMSE_N[side][k]);
        rows.push(Row {
            name: "observer minus paper".to_owned(),
            muscle,
            source: "difference",
            cells: cells(&difference, 2),
            pearson: NONE.to_owned(),
            ..Row::default()
        });
    }
    rows
}

/// What the rows of Table I are, with the reasons for the large ones, from the numbers of this run.
fn table1_notes(results: &BenchResults) -> Vec<String> {
    let mut notes = vec![
        "As in the paper’s Table I: strokes at full speed, after the slip front of the reversal has passed."
            .to_owned(),
    ];
    let worst = |table: &ByVariant, variant| {
        let found = table.get(&variant).map(sides)?;
        Some(found.iter().map(|side| largest(&side.rmse_n)).fold(f64::NAN, f64::max))
    };
    let network = CompensationVariant::Paper;
    let found = worst(&results.table1, network).zip(worst(&results.table1_estimate, network));
    if let Some((found, estimate)) = found {
        let reported = paper::RMSE_N.iter().flatten().copied().fold(f64::NAN, f64::max);
        notes.push(format!(
            "The paper’s network, re-implemented, has errors up to {} N here and up to {} N on the paper’s \
                hardware. It maps the present tension and speed to the friction loss. On the simulated cable \
                the loss also depends on the slip front, so that one input belongs to several losses: over \
                whole cycles its estimate of the far tension deviates by up to {} N rms. It commands a drive \
                tension, which does not act on the far end while the near end sticks. The paper states \
                neither how training and test data were separated nor the bandwidth of its tension loop; \
                what part of the difference is due to these is not known.",
            fixed(found, 1),
            fixed(reported, 2),
            fixed(estimate, 1)
        ));
    }
    notes.push(format!(
        "The observer reads the motor’s encoder, the load cell at the drive and the encoder of the joint; it \
            needs no tension sensor at the far end. In the rows without the joint’s encoder the reference of \
            the motion stands in its place; the load deviates from it by up to {} mm on this bench, a joint \
            of a robot by more.",
        fixed(1e3 * results.without_joint_encoder.largest_anchor_error_m, 2)
    ));
    notes.push(
        "True cable state: control by the plant’s own law with its true stretch, drag and far tension. It \
            knows more than any compensation; what remains is the lag of the winch. With the law and the \
            true stretch alone it would be no bound: the plant’s creep and warming are not part of its law, \
            while an identified law absorbs a part of them."
            .to_owned(),
    );
    notes
}

/// What Table I (c) measures, and where control by the true state is not the least.
fn cycle_notes(results: &BenchResults) -> Vec<String> {
    let mut notes = vec![
        "After a reversal the winch must first wind in the elongation of the cable, which no compensation \
            avoids. Recovery: time until the far tension stays within 5 N of its reference for 0.2 s."
            .to_owned(),
    ];
    let of = |variant| results.table1_cycles.get(&variant).map(sides);
    let both = of(CompensationVariant::Perfect).zip(of(CompensationVariant::Observer));
    let above = both.map_or(0.0, |(perfect, observer)| {
        let pairs = perfect.into_iter().zip(observer);
        let differences = pairs.flat_map(|(p, o)| (0..SPEEDS.len()).map(move |k| p.rmse_n[k] - o.rmse_n[k]));
        differences.fold(0.0, f64::max)
    });
    if above >= 0.005 {
        notes.push(format!(
            "Control by the true cable state begins every stroke without the correction of its law, which \
                needs the whole cable to slide: over whole cycles it exceeds the observer by up to {} N and \
                is no bound there.",
            fixed(above, 2)
        ));
    }
    notes
}

/// Sources of rows.
const SIMULATED: &str = "simulated";

/// Tables II and III, mean ± standard deviation: the paper above the simulation. The efficiency is
/// `T_out/T_in` for both sides, as in the paper: above 1 for the passive muscle.
pub(super) fn tables23(part: &BenchPart) -> Vec<Table> {
    // `ours` holds the pairs of mean and standard deviation.
    let table = |heading, ours: &[[[f64; 2]; 6]; 2], means: &[[f64; 6]; 2], spreads: &[[f64; 6]; 2]| {
        let mut rows = Vec::new();
        for (side, muscle) in MUSCLES.into_iter().enumerate() {
            for (name, numbers, ours) in [
                ("hardware", [means[side], spreads[side]], false),
                (SIMULATED, [ours[side].map(|a| a[0]), ours[side].map(|a| a[1])], true),
            ] {
                let content = numbers[0].iter().zip(&numbers[1]);
                let cells =
                    content.map(|(mean, spread)| format!("{} ± {}", fixed(*mean, 3), fixed(*spread, 3)));
                rows.push(Row { muscle, source: name, ours, cells: cells.collect(), ..Row::default() });
            }
            let percent = |k: usize| {
                let difference = 100.0 * (ours[side][k][0] / means[side][k] - 1.0);
                let sign = if difference > 0.0 { "+" } else { "" };
                format!("{sign}{}\u{202f}%", fixed(difference, 0))
            };
            let cells = (0..SPEEDS.len()).map(percent).collect();
            rows.push(Row { muscle, source: "difference", cells, ..Row::default() });
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
/// target for the largest deviation (`sinew-lab/tests/lab/cable_tables.rs` tests it on the calibrated cable).
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

/// Specimens sampled at random, with the observer: largest error over the speeds, N rms. `max. ratio` is the
/// largest ratio, over the speeds, of the errors (c) with the observer and with the true state of the cable.
pub(super) fn others(results: &BenchResults) -> Vec<Row> {
    let mut rows = Vec::new();
    for specimen in &results.other_specimens {
        for (side, muscle) in MUSCLES.into_iter().enumerate() {
            let of = |table: &Sides<Indices>| sides(table)[side].rmse_n;
            let (cycles, perfect) = (of(&specimen.table1_cycles), of(&specimen.perfect_cycles));
            let ratio = cycles.iter().zip(&perfect).map(|(a, b)| a / b).fold(f64::NAN, f64::max);
            let cell = |row: &[f64; 6]| fixed(largest(row), 2);
            rows.push(Row {
                name: format!("seed {}", specimen.seed),
                muscle,
                cells: vec![
                    cell(&of(&specimen.table1)),
                    cell(&of(&specimen.table1_estimate)),
                    cell(&cycles),
                    cell(&perfect),
                    fixed(ratio, 2),
                ],
                ..Row::default()
            });
        }
    }
    rows
}
