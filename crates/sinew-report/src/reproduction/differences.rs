//! Differences between simulation and paper in words.

use super::indices::{largest, sides};
use crate::format::fixed;
use sinew_lab::CompensationVariant;
use sinew_lab::paper::{self, SPEEDS};
use sinew_lab::reproduce::{ArmPart, BenchPart, BenchResults};

/// Differences between simulation and paper; numbers are those of this run.
pub(super) fn differences(part: &BenchPart, arm: Option<&ArmPart>) -> Vec<String> {
    let mut differences = vec![
        "The paper commands drive tensions; here the variants with an observer command winch speeds. While \
         the near end sticks, the near tension contains no information on the far end; while the cable \
         slides, its elongation determines its far tension."
            .to_owned(),
    ];
    differences.extend(paper_network(&part.results));
    differences.push(elongation_trend(part));
    differences.push(
        "The paper’s tables contain means of ratios, which depend on the wave form of the tension; the \
         paper does not report it. Here it is a sine from 40 to 200 N with a whole period in every steady \
         window."
            .to_owned(),
    );
    differences.push(
        "Errors without compensation depend on which end is controlled to 40 to 200 N: here it is the \
         pulling end."
            .to_owned(),
    );
    differences.extend(arm.and_then(uncompensated_arm));
    differences
}

/// The error of the paper's network on the simulated bench.
fn paper_network(results: &BenchResults) -> Option<String> {
    let found = sides(results.table1.get(&CompensationVariant::Paper)?).map(|side| largest(&side.rmse_n));
    let reported = [0, 1].map(|side| largest(&paper::RMSE_N[side]));
    Some(format!(
        "The paper’s network maps the present sample only. On the simulated cable, which has memory, its \
         tracking error in steady windows is at most {} N (active) and {} N (passive) rms; the paper \
         measured {} and {} N. The bandwidth of the paper’s tension loop is not reported.",
        fixed(found[0], 2),
        fixed(found[1], 2),
        fixed(reported[0], 2),
        fixed(reported[1], 2)
    ))
}

/// How the active elongation changes from the lowest to the highest speed.
fn elongation_trend(part: &BenchPart) -> String {
    let change = |means: [f64; 6]| {
        let percent = 100.0 * (means[5] / means[0] - 1.0);
        format!("{}{} %", if percent > 0.0 { "+" } else { "" }, fixed(percent, 0))
    };
    format!(
        "From {} to {} m/s the active elongation changes by {} in the paper and by {} in the simulation.",
        fixed(SPEEDS[0], 2),
        fixed(SPEEDS[5], 2),
        change(paper::ELONGATION[0]),
        change(part.mechanism.elongation[0].map(|mean| mean[0]))
    )
}

/// When commanded drive tensions without compensation end the arm's run.
fn uncompensated_arm(part: &ArmPart) -> Option<String> {
    let stopped = part.tracking.get(&CompensationVariant::None)?.stopped_s?;
    Some(format!(
        "With drive tensions and no compensation the simulated arm’s run ends after {} s: friction in the \
         sheaths reduces the tensions at the anchors below those that the torques require.",
        fixed(stopped, 1)
    ))
}
