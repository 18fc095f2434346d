//! The main results in words and in figures.

use super::indices::{largest, sides};
use crate::format::fixed;

use sinew_lab::CompensationVariant;
use sinew_lab::paper::{self, SPEEDS};
use sinew_lab::reproduce::{ArmPart, BenchResults, ByVariant, Indices, Sides};

/// This project's targets for the observer's errors, N: active, passive.
const TARGETS_N: [f64; 2] = [1.7, 1.2];
/// The paper's mean tracking error over the speeds, N: active, passive.
pub fn paper_mean_rmse() -> [f64; 2] {
    paper::RMSE_N.map(|speeds| speeds.iter().sum::<f64>() / SPEEDS.len() as f64)
}

pub(super) fn verdict(results: &BenchResults) -> String {
    let Some(observer) = results.table1.get(&CompensationVariant::Observer).map(sides) else {
        return String::new();
    };
    let found = observer.map(|side| largest(&side.rmse_n));
    let [active, passive] = [0, 1].map(|side| {
        let class = if found[side] <= TARGETS_N[side] { "figure" } else { "figure bad" };
        format!("<strong class=\"{class}\">{} N</strong>", fixed(found[side], 2))
    });
    let without = sides(&results.without_joint_encoder.table1).map(|side| largest(&side.rmse_n));
    let met = found.iter().zip(TARGETS_N).all(|(error, target)| *error <= target);
    let [paper_active, paper_passive] = paper_mean_rmse().map(|error| fixed(error, 2));
    format!(
        "With the observer, which reads the joint’s encoder and no far-end tension, the tracking error of \
            the far tension in steady strokes is at most {active} (active) and {passive} (passive) rms at \
            every speed; with the reference of the motion in place of that encoder {} and {} N. The paper \
            reports {paper_active} and {paper_passive} N on average over the speeds.{}",
        fixed(without[0], 2),
        fixed(without[1], 2),
        if met { "" } else { " The target of this project is not met." }
    )
}

pub(super) fn arm_verdict(part: &ArmPart) -> String {
    let Some(numbers) = part.tracking.get(&CompensationVariant::Observer) else { return String::new() };
    let error = &numbers.end_point_error_m;
    format!(
        " The end point of the arm tracks its path with an error of <strong class=\"figure\">{} mm</strong> \
            mean and {} mm max; the paper reports {} and {} mm.",
        fixed(1e3 * error.mean, 2),
        fixed(1e3 * error.max, 1),
        fixed(paper::END_POINT_ERROR_MM[0], 1),
        fixed(paper::END_POINT_ERROR_MM[2], 0)
    )
}

pub(super) fn figures(results: &BenchResults, rms: f64) -> Vec<(&'static str, String, bool)> {
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
            "max. tracking error, active, N rms",
            fixed(worst(&results.table1, 0), 2),
            worst(&results.table1, 0) <= TARGETS_N[0],
        ),
        (
            "max. tracking error, passive, N rms",
            fixed(worst(&results.table1, 1), 2),
            worst(&results.table1, 1) <= TARGETS_N[1],
        ),
        (
            "max. estimation error, whole cycles, N rms",
            fixed(estimate[0].max(estimate[1]), 2),
            estimate[0] <= TARGETS_N[0] && estimate[1] <= TARGETS_N[1],
        ),
        ("whole cycles, relative to true cable state", format!("× {}", fixed(ratio, 2)), ratio <= 1.2),
        ("Tables II and III, deviation from the paper, % rms", fixed(100.0 * rms, 1), rms <= 0.09),
        ("elongation error with joint sensor, mm rms", fixed(joint, 2), joint <= 0.3),
    ]
}

fn largest_ratio(ours: &Sides<Indices>, perfect: &Sides<Indices>) -> f64 {
    let ratio = |k: usize| {
        let [ours, perfect] = [&sides(ours)[k].rmse_n, &sides(perfect)[k].rmse_n];
        ours.iter().zip(perfect).map(|(a, b)| a / b).fold(f64::NAN, f64::max)
    };
    ratio(0).max(ratio(1))
}
