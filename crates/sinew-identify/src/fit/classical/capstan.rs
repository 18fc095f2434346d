//! Capstan laws without memory: the sign of sliding decides between two branches.

use super::law::{FRICTION_ANGLE, Law, PRETENSION, Scale, Spec};
use super::samples::{Samples, Signals};

/// `T_out = T_in exp(-s lambda) + T_0`: (7) with `lambda = mu phi - ln eta`.
pub(super) fn fixed(samples: &Samples, signals: &Signals) -> Law {
    let towards = orientation(samples);
    let source = if signals.has_motion {
        format!("s is the direction of {}", signals.drive_name)
    } else {
        format!("s is the sign of d{}/dt, as no motion is measured", signals.near_name)
    };
    Law {
        name: "static capstan".to_owned(),
        equation: format!("T_out = T_in exp(-s lambda) + T_0, lambda = mu phi - ln(eta); {source}"),
        specs: vec![
            Spec::friction(FRICTION_ANGLE, "1", Scale::POSITIVE),
            Spec::new(PRETENSION, &signals.far_unit, Scale::Linear { typical: signals.far_range }),
        ],
        starts: [0.05, 0.3, 1.0].map(|angle| vec![angle, 0.0]).to_vec(),
        predict: Box::new(move |samples, p, out| {
            let factor = [(-towards * p[0]).exp(), (towards * p[0]).exp()];
            for (row, y) in out.iter_mut().enumerate() {
                let branch = usize::from(samples.direction[row] < 0.0);
                *y = samples.effort[row] * factor[branch] + p[1];
            }
            factor[0].is_finite() && factor[1].is_finite()
        }),
        derived: vec![],
        undetermined: vec![],
        note: "two tensions determine only the sum mu phi - ln(eta), not its parts".to_owned(),
        sliding_only: true,
        reason: |_| "",
    }
}

/// Largest friction angle at a speed, rad: 2 % of the tension arrives. Where the speeds of a fold do not
/// determine the curve it would grow without limit.
const LARGEST_ANGLE: f64 = 4.0;

/// The same with a coefficient that depends on speed, and a drag that does not depend on tension: (5).
pub(super) fn speed_dependent(samples: &Samples, signals: &Signals) -> Law {
    let towards = orientation(samples);
    let speeds = speed_quantiles(samples);
    let rate = format!("{}/s", signals.drive_unit);
    let drag_unit = format!("{} s/{}", signals.far_unit, signals.drive_unit);
    let growth_unit = format!("s/{}", signals.drive_unit);
    let start = |angle: f64, rise: f64, speed: f64, drag: f64| {
        vec![angle, rise, speed, 0.05 * angle / speeds[2], drag * signals.far_range / speeds[2], 0.0]
    };
    Law {
        name: "capstan with Stribeck, viscous growth and drag".to_owned(),
        equation: "T_out = T_in exp(-s (lambda + c exp(-(v/v_s)^2) + m |v|)) - d v + T_0".to_owned(),
        specs: vec![
            Spec::friction(FRICTION_ANGLE, "1", Scale::POSITIVE),
            Spec::friction("Stribeck rise at low speed (c)", "1", Scale::POSITIVE),
            Spec::friction("Stribeck speed (v_s)", &rate, Scale::POSITIVE),
            Spec::friction("growth with speed (m)", &growth_unit, Scale::POSITIVE),
            Spec::friction("drag (d)", &drag_unit, Scale::POSITIVE),
            Spec::new(PRETENSION, &signals.far_unit, Scale::Linear { typical: signals.far_range }),
        ],
        starts: vec![
            start(0.3, 0.03, speeds[0], 0.01),
            start(0.3, 0.1, speeds[1], 0.05),
            start(1.0, 0.3, speeds[0], 0.05),
        ],
        predict: Box::new(move |samples, p, out| {
            for (row, y) in out.iter_mut().enumerate() {
                let (s, speed) = (towards * samples.direction[row], samples.rate[row].abs());
                // Its exponentials are not continued beyond the speeds that nearly all samples have.
                let seen = speed.clamp(speeds[0], speeds[2]);
                let ratio = seen / p[2];
                let angle = (p[0] + p[1] * (-ratio * ratio).exp() + p[3] * seen).min(LARGEST_ANGLE);
                *y = samples.effort[row] * (-s * angle).exp() - s * p[4] * speed + p[5];
            }
            out.iter().all(|y| y.is_finite())
        }),
        derived: vec![],
        // At one speed only one value of the curve is observed.
        undetermined: if speeds[2] < 1.5 * speeds[0] { vec![1, 2, 3] } else { vec![] },
        note: format!(
            "fitted on sliding at {:.3} to {:.3} {rate}; below and above friction stays as it is there",
            speeds[0], speeds[2]
        ),
        sliding_only: true,
        reason: |i| match i {
            1 | 2 => "no sliding slow enough, or no rise at low speed",
            3 | 4 => "speeds vary too little, or friction does not grow with them",
            _ => "",
        },
    }
}

/// +1 where rising drive means sliding toward the motor, by the sign that explains more.
fn orientation(samples: &Samples) -> f64 {
    // Toward the motor the far tension is the smaller fraction of the near one. At rest and near a reversal
    // the direction is not known.
    let mut sums = [[0.0; 2]; 2];
    for &row in samples.fitted.iter().filter(|&&row| samples.sliding[row]) {
        let branch = usize::from(samples.direction[row] < 0.0);
        sums[branch][0] += samples.effort[row] * samples.far[row];
        sums[branch][1] += samples.effort[row] * samples.effort[row];
    }
    let fraction = |branch: usize| sums[branch][0] / sums[branch][1].max(1e-300);
    if sums[0][1] > 0.0 && sums[1][1] > 0.0 && fraction(0) > fraction(1) { -1.0 } else { 1.0 }
}

/// 5 %, 50 % and 95 % of the speeds while moving, none of them zero.
pub(super) fn speed_quantiles(samples: &Samples) -> [f64; 3] {
    let mut speeds: Vec<f64> = samples
        .fitted
        .iter()
        .map(|&row| samples.rate[row].abs())
        .filter(|speed| speed.is_finite() && *speed > 0.0)
        .collect();
    if speeds.is_empty() {
        return [1e-3, 1e-2, 1e-1];
    }
    speeds.sort_by(f64::total_cmp);
    [0.05, 0.5, 0.95].map(|q| speeds[(q * (speeds.len() - 1) as f64).round() as usize])
}
