//! The page of `sinew reproduce`: the paper's tables and figures, its numbers beside ours.

use super::error::Error;
use super::format::{NONE, fixed};
use super::plot::Plot;
use super::scale::{Axis, padded};
use super::svg_path::{Pen, line};
use super::tracking::{self, TrackView};
use askama::Template;
use sinew_lab::CompensationVariant;
use sinew_lab::paper::{self, SPEEDS};
use sinew_lab::reproduce::{ArmPart, BenchPart, BenchResults, ByVariant, Indices, Point, Sides, Trace};

#[derive(Template)]
#[template(path = "reproduce.html")]
struct Page<'a> {
    version: &'static str,
    style: &'static str,
    script: &'static str,
    seed: u64,
    quick: bool,
    verdict: String,
    figures: Vec<(&'static str, String, bool)>,
    speeds: Vec<String>,
    table1: Vec<Table>,
    uncompensated: String,
    figure7: Vec<Plot>,
    figure8: Vec<Plot>,
    mechanism: String,
    tables23: Vec<Table>,
    beyond: String,
    figure9: Vec<Plot>,
    /// One cable, drawn.
    cable: &'a str,
    elongation: Vec<ElongationRow>,
    stretch_range: String,
    others: Vec<Row>,
    /// The arm's sections, rendered; empty where only the bench ran.
    arm: String,
    differences: Vec<String>,
    disagreements: Vec<&'static str>,
}

#[derive(Default)]
struct Table {
    heading: &'static str,
    note: &'static str,
    pearson: bool,
    recovery: bool,
    rows: Vec<Row>,
}

#[derive(Default)]
struct Row {
    name: String,
    muscle: &'static str,
    ours: bool,
    /// Label on a narrow screen and content.
    cells: Vec<(String, String)>,
    pearson: String,
    recovery: String,
}

struct ElongationRow {
    known: &'static str,
    cells: Vec<String>,
    ours: &'static str,
}

const MUSCLES: [&str; 2] = ["active", "passive"];
/// Bounds of this project on the observer's errors, N.
const BOUNDS_N: [f64; 2] = [1.7, 1.2];
/// Name in files and on the page.
const NAMES: [(CompensationVariant, &str); 5] = [
    (CompensationVariant::None, "none"),
    (CompensationVariant::Capstan, "capstan, static"),
    (CompensationVariant::Paper, "the paper’s network"),
    (CompensationVariant::Observer, "observer (ours)"),
    (CompensationVariant::Perfect, "perfect knowledge"),
];

/// The whole page, with the arm's sections where it was tracked.
pub(crate) fn render(
    part: &BenchPart,
    arm: Option<&ArmPart>,
    cable: &str,
    quick: bool,
) -> Result<String, Error> {
    let results = &part.results;
    let [rms, largest] = part.mechanism.differences();
    let page = Page {
        version: env!("CARGO_PKG_VERSION"),
        style: include_str!("../../assets/report.css"),
        script: include_str!("../../assets/report.js"),
        seed: results.seed,
        quick,
        verdict: verdict(results) + &arm.map_or_else(String::new, arm_verdict),
        arm: arm.map(arm_sections).transpose()?.unwrap_or_default(),
        figures: figures(results, rms),
        speeds: SPEEDS.map(|v| fixed(v, 2)).to_vec(),
        table1: table1(results),
        uncompensated: format!(
            "Nothing compensated, while the end that pulls swings 40 to 200 N: on average {} N (active) and {} N \
             (passive) lie between the two ends; the paper has 88.5 and 63.9 N.",
            fixed(results.uncompensated_mean_error_n.active, 1),
            fixed(results.uncompensated_mean_error_n.passive, 1)
        ),
        figure7: [1, 5]
            .into_iter()
            .filter_map(|speed| strokes(part, CompensationVariant::None, speed, true))
            .collect(),
        figure8: [0, 2, 5]
            .into_iter()
            .flat_map(|speed| {
                [CompensationVariant::Paper, CompensationVariant::Observer].map(|variant| (variant, speed))
            })
            .filter_map(|(variant, speed)| strokes(part, variant, speed, false))
            .collect(),
        mechanism: format!(
            "Means over the steady windows of the calibration runs. Over the 24 means the twin is {} % rms from the \
             paper, {} % at worst.",
            fixed(100.0 * rms, 1),
            fixed(100.0 * largest, 1)
        ),
        tables23: tables23(part),
        beyond: beyond(part),
        figure9: scatters(part),
        cable,
        elongation: elongation(results),
        stretch_range: fixed(results.elongation_mm.range, 0),
        others: others(results),
        differences: differences(),
        disagreements: paper::DISAGREEMENTS.to_vec(),
    };
    Ok(page.render()?)
}

fn largest(row: &[f64; 6]) -> f64 {
    row.iter().copied().fold(f64::NAN, f64::max)
}

fn sides(indices: &Sides<Indices>) -> [&Indices; 2] {
    [&indices.active, &indices.passive]
}

fn verdict(results: &BenchResults) -> String {
    let Some(ours) = results.table1.get(&CompensationVariant::Observer).map(sides) else {
        return String::new();
    };
    let worst = ours.map(|side| largest(&side.rmse_n));
    let held = worst.iter().zip(BOUNDS_N).all(|(worst, bound)| *worst <= bound);
    format!(
        "With the observer the far tension, on steady strokes, stays within <strong class=\"figure{}\">{} N</strong> (active) and <strong \
         class=\"figure{}\">{} N</strong> (passive) rms of what is wanted at every speed; the paper reports 1.70 and \
         1.23 N on average over the speeds. {}",
        if worst[0] <= BOUNDS_N[0] { "" } else { " bad" },
        fixed(worst[0], 2),
        if worst[1] <= BOUNDS_N[1] { "" } else { " bad" },
        fixed(worst[1], 2),
        if held {
            "It does not need a sensor at the far end for that."
        } else {
            "That is not good enough yet."
        }
    )
}

fn arm_verdict(part: &ArmPart) -> String {
    let Some(numbers) = part.tracking.get(&CompensationVariant::Observer) else { return String::new() };
    let error = &numbers.end_point_error_m;
    format!(
        " The arm’s end point stays within <strong class=\"figure\">{} mm</strong> of its path on average, {} mm at most; \
         the paper reports 15.8 and 39 mm.",
        fixed(1e3 * error.mean, 2),
        fixed(1e3 * error.max, 1)
    )
}

/// What there is to show of the arm.
pub(crate) fn arm_view(part: &ArmPart) -> TrackView<'_> {
    let seconds = fixed(part.options.duration, 1);
    TrackView {
        heading: "The arm along its path".to_owned(),
        lead: format!(
            "Seven joints, fifteen muscles, two periods of a sine-shaped path in {seconds} s, {} with the observer, once {}. \
             The arm was built with errors of mass (10 %), attachments (1 mm), friction and sensors that the controller does not know; each cable was calibrated alone.",
            match part.options.repeats {
                1 => "once".to_owned(),
                n => format!("{n} times"),
            },
            if part.options.all { "with every other way of control" } else { "without compensation" }
        ),
        tracking: &part.tracking,
        trace: &part.trace,
        drawn: CompensationVariant::Observer,
        names: &part.muscles,
        repeats: part.options.repeats,
        paper: true,
    }
}

fn arm_sections(part: &ArmPart) -> Result<String, Error> {
    tracking::section(&arm_view(part))
}

fn figures(results: &BenchResults, rms: f64) -> Vec<(&'static str, String, bool)> {
    let worst = |table: &ByVariant, side: usize| {
        table
            .get(&CompensationVariant::Observer)
            .map_or(f64::NAN, |found| largest(&sides(found)[side].rmse_n))
    };
    let estimate = [0, 1].map(|side| worst(&results.table1_estimate, side));
    let ratio = results
        .table1_cycles
        .get(&CompensationVariant::Observer)
        .zip(results.table1_cycles.get(&CompensationVariant::Perfect))
        .map_or(f64::NAN, |(ours, perfect)| largest_ratio(ours, perfect));
    let joint = results.elongation_mm.joint_sensor.get("observer").copied().unwrap_or(f64::NAN);
    vec![
        (
            "achieved at worst, active, N",
            fixed(worst(&results.table1, 0), 2),
            worst(&results.table1, 0) <= BOUNDS_N[0],
        ),
        (
            "achieved at worst, passive, N",
            fixed(worst(&results.table1, 1), 2),
            worst(&results.table1, 1) <= BOUNDS_N[1],
        ),
        (
            "estimated at worst, whole cycles, N",
            fixed(estimate[0].max(estimate[1]), 2),
            estimate[0] <= BOUNDS_N[0] && estimate[1] <= BOUNDS_N[1],
        ),
        ("whole cycles over perfect knowledge", format!("× {}", fixed(ratio, 2)), ratio <= 1.2),
        ("Tables II and III, % rms from the paper", fixed(100.0 * rms, 1), rms <= 0.09),
        ("elongation with joint sensor, mm", fixed(joint, 2), joint <= 0.3),
    ]
}

fn largest_ratio(ours: &Sides<Indices>, perfect: &Sides<Indices>) -> f64 {
    let ratio = |k: usize| {
        let [ours, perfect] = [&sides(ours)[k].rmse_n, &sides(perfect)[k].rmse_n];
        ours.iter().zip(perfect).map(|(a, b)| a / b).fold(f64::NAN, f64::max)
    };
    ratio(0).max(ratio(1))
}

fn cells(row: &[f64; 6], decimals: usize) -> Vec<(String, String)> {
    SPEEDS.iter().zip(row).map(|(v, x)| (format!("{} m/s", fixed(*v, 2)), fixed(*x, decimals))).collect()
}

fn table1(results: &BenchResults) -> Vec<Table> {
    let rows = |table: &ByVariant| {
        let mut rows = Vec::new();
        for (key, name) in NAMES {
            let Some(found) = table.get(&key) else { continue };
            for (side, muscle) in sides(found).into_iter().zip(MUSCLES) {
                rows.push(Row {
                    name: name.to_owned(),
                    muscle,
                    ours: key == CompensationVariant::Observer,
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
            heading: "(a) Achieved against wanted, steady windows",
            note: "What the paper’s Table I compares: strokes at full speed, the front of the reversal having passed.",
            pearson: true,
            rows: achieved,
            ..Table::default()
        },
        Table {
            heading: "(b) Estimated against true, whole cycles",
            note: "What each method believes of the far end, reversals included.",
            rows: rows(&results.table1_estimate),
            ..Table::default()
        },
        Table {
            heading: "(c) Achieved against wanted, whole cycles",
            note: "After a reversal the winch must take up tens of millimetres before the far end can follow; nobody is \
                   perfect there. Recovery: until the far tension is within 5 N of what is wanted for 0.2 s.",
            recovery: true,
            rows: rows(&results.table1_cycles),
            ..Table::default()
        },
    ]
}

fn tables23(part: &BenchPart) -> Vec<Table> {
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

/// Names the cells that are more than 16 % away.
fn beyond(part: &BenchPart) -> String {
    let mut names = Vec::new();
    for (name, ours, told) in [
        ("efficiency", &part.mechanism.efficiency, &paper::EFFICIENCY),
        ("elongation", &part.mechanism.elongation, &paper::ELONGATION),
    ] {
        for (side, muscle) in MUSCLES.into_iter().enumerate() {
            for (k, speed) in SPEEDS.into_iter().enumerate() {
                let difference = ours[side][k][0] / told[side][k] - 1.0;
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
        "Every mean lies within 16 % of the paper’s.".to_owned()
    } else {
        format!("More than 16 % away: {}.", names.join(", "))
    }
}

/// One cycle of a variant at a speed.
fn strokes(part: &BenchPart, variant: CompensationVariant, speed: usize, near: bool) -> Option<Plot> {
    let trace: &Trace = part.traces.iter().find(|trace| trace.variant == variant && trace.speed == speed)?;
    let rows: Vec<_> = trace.rows.iter().filter(|row| row.time > 3.0).collect();
    let (first, last) = (rows.first()?.time, rows.last()?.time);
    let most = rows.iter().map(|row| row.far.max(row.wanted)).fold(220.0, f64::max);
    let (x, y) = (Axis::new((first, last), 5), Axis::new(padded((0.0, most.min(700.0)), 0.03), 5));
    let name = NAMES.iter().find(|(key, _)| *key == variant).map_or(variant.name(), |(_, name)| name);
    let title = format!("{name}, {} m/s", fixed(SPEEDS[speed], 2));
    let mut plot =
        Plot::new("trace", title.clone(), (&x, "time (s)".to_owned()), (&y, format!("{title}: tension (N)")));
    plot.draw("measured", line(rows.iter().map(|row| (row.time, row.wanted)), &x, &y));
    if near {
        plot.draw("near", line(rows.iter().map(|row| (row.time, row.near)), &x, &y));
    }
    plot.draw("predicted", line(rows.iter().map(|row| (row.time, row.far)), &x, &y));
    Some(plot)
}

/// Figures 9 and 10 at the lowest and the highest speed.
fn scatters(part: &BenchPart) -> Vec<Plot> {
    let mut plots = Vec::new();
    for (label, of) in [
        ("far tension (N)", (|p: &Point| p.far) as fn(&Point) -> f64),
        ("elongation (mm)", |p: &Point| p.stretch),
    ] {
        for (side, muscle) in MUSCLES.into_iter().enumerate() {
            let both = [&part.mechanism.points[side][0], &part.mechanism.points[side][5]];
            let most = |of: fn(&Point) -> f64| both.iter().flat_map(|p| p.iter()).map(of).fold(1.0, f64::max);
            let (x, y) = (
                Axis::new(padded((0.0, most(|p| p.near)), 0.03), 5),
                Axis::new(padded((0.0, most(of)), 0.03), 5),
            );
            let title = format!("{muscle}: {label}");
            let mut plot = Plot::new("loop", title.clone(), (&x, "near tension (N)".to_owned()), (&y, title));
            for (points, class) in both.into_iter().zip(["dots", "dots fast"]) {
                let mut pen = Pen::default();
                for point in points {
                    pen.lift();
                    pen.line_to(x.at(point.near), y.at(of(point)));
                }
                plot.draw(class, pen.finish());
            }
            plots.push(plot);
        }
    }
    plots
}

fn elongation(results: &BenchResults) -> Vec<ElongationRow> {
    let found = &results.elongation_mm;
    let cells = |table: &std::collections::BTreeMap<&str, f64>, ours: &str| {
        ["equation10", "paper", ours]
            .map(|key| table.get(key).map_or(NONE.to_owned(), |mm| fixed(*mm, 2)))
            .to_vec()
    };
    vec![
        ElongationRow {
            known: "the motor’s side alone",
            cells: cells(&found.near_only, "memory"),
            ours: "a network with memory of the near side",
        },
        ElongationRow {
            known: "with the joint’s sensor",
            cells: cells(&found.joint_sensor, "observer"),
            ours: "the cable observer",
        },
    ]
}

fn others(results: &BenchResults) -> Vec<Row> {
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
                    cell("(a) achieved", &of(&specimen.table1)),
                    cell("(b) estimated", &of(&specimen.table1_estimate)),
                    cell("(c) whole cycles", &cycles),
                    cell("(c) perfect knowledge", &perfect),
                    ("largest ratio".to_owned(), fixed(ratio, 2)),
                ],
                ..Row::default()
            });
        }
    }
    rows
}

fn differences() -> Vec<String> {
    [
        "The paper commands the drive’s tension. Here the observer’s variant commands the winch’s speed: while the near \
         end sticks, a tension loop cannot know what the far end does, and while the cable slides its stretch is its far \
         tension.",
        "The paper’s network sees the present sample only. On this plant, which remembers, it leaves several newtons \
         (active) to tens of newtons (passive) even in steady windows, more than the paper measured: what its tension loop \
         was like is not told, and the loop here is slow where the whole cable gives way.",
        "A network on what the observer leaves was tried on three specimens, with far and near tension, speed and place in the \
         dead band as inputs: on runs it had not seen it changed the error by -5 to +18 %. What is left is no function of what \
         can be seen, so the observer goes without.",
        "Active elongation rises by 28 % with speed in the paper and falls by a few per cent here: no law of friction that \
         was tried makes it rise. Passive efficiency at 0.10 m/s stands out of its row in the paper.",
        "The tables are means of ratios and depend on the wave form of the tension, which the paper does not tell: here a \
         sine from 40 to 200 N, a whole one in every steady window.",
        "The paper tells its arm tensions; here the default tells winches speeds. Tensions told without compensation lead the \
         simulated arm astray within seconds: its sheaths lose more than half, and nothing else holds it.",
        "Errors without compensation depend on which end is held to 40 to 200 N: here the one that pulls.",
    ]
    .map(str::to_owned)
    .to_vec()
}
