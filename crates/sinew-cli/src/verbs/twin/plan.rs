//! `sinew twin plan`: a programme of motions that shows the hysteresis of a transmission.

use crate::answer::{Answer, Content};
use crate::arguments::{General, TwinPlanArguments};
use crate::error::Error;
use crate::output::{refuse_overwrite, write_all};
use crate::table::number;
use std::fmt::Write;

/// Turning points at each speed, as fractions of the stroke, from 0: a whole loop; a second one with minor
/// loops of a half, a quarter and a tenth of the stroke at its top; minor loops of the same sizes at the
/// bottom; in the middle shrinking half-loops of 0.5, 0.35, 0.25 and 0.2.
const TURNS: [f64; 22] = [
    1.0, 0.0, 1.0, 0.5, 1.0, 0.75, 1.0, 0.9, 1.0, 0.0, 0.5, 0.0, 0.25, 0.0, 0.1, 0.0, 0.75, 0.25, 0.6, 0.35,
    0.55, 0.0,
];

pub(super) fn run(arguments: &TwinPlanArguments, general: &General) -> Result<Answer, Error> {
    refuse_overwrite([], std::slice::from_ref(&arguments.out), general.no_clobber)?;
    let corners = programme(arguments.stroke, &arguments.speeds, arguments.rest);
    let written = write_all(&[(arguments.out.clone(), table(&corners).as_bytes())])?;
    let reversals = TURNS.len() * arguments.speeds.len() - 1;
    let duration_s = corners.last().map_or(0.0, |corner| corner[0]);
    let content = if general.json {
        Content::json(&serde_json::json!({
            "duration_s": duration_s, "stroke_m": arguments.stroke, "speeds_m_per_s": arguments.speeds,
            "reversals": reversals,
        }))?
    } else {
        Content::Text(format!(
            "{duration_s:.1} s, {reversals} reversals, strokes of {} to {} m at {} speeds; the anchor is \
                held. Record it on two days and more, with both ends measured.\n",
            number(Some(0.1 * arguments.stroke)),
            number(Some(arguments.stroke)),
            arguments.speeds.len()
        ))
    };
    Ok(Answer::done(content, written))
}

/// Time, s, and position of the motor, m, at the ends of straight lines; it rests at each turning point.
fn programme(stroke: f64, speeds: &[f64], rest_s: f64) -> Vec<[f64; 2]> {
    let mut corners = vec![[0.0, 0.0]];
    let (mut time, mut position) = (0.0, 0.0);
    for speed in speeds {
        for turn in TURNS {
            let target = turn * stroke;
            time += (target - position).abs() / speed;
            position = target;
            corners.push([time, position]);
            if rest_s > 0.0 {
                time += rest_s;
                corners.push([time, position]);
            }
        }
    }
    corners
}

fn table(corners: &[[f64; 2]]) -> String {
    let mut text = String::from(
        "# Corners of a programme for identification, straight lines between them; the anchor is held\n\
         time_s,motor_m,anchor_m\n",
    );
    for [time, motor] in corners {
        // Writing into a string cannot fail.
        let _ = writeln!(text, "{time:.6},{motor:.6},0");
    }
    text
}

#[cfg(test)]
mod tests {
    use super::*;

    #[test]
    fn every_turning_point_is_a_reversal_or_the_start_of_a_speed() {
        let corners = programme(0.1, &[0.05], 0.0);
        let steps: Vec<f64> = corners.windows(2).map(|pair| pair[1][1] - pair[0][1]).collect();
        assert_eq!(steps.len(), TURNS.len());
        assert!(steps.windows(2).all(|pair| pair[0] * pair[1] < 0.0), "{steps:?}");
        let speed = |pair: &[[f64; 2]]| (pair[1][1] - pair[0][1]).abs() / (pair[1][0] - pair[0][0]);
        assert!(corners.windows(2).all(|pair| (speed(pair) - 0.05).abs() < 1e-9));
    }

    #[test]
    fn it_rests_at_each_turning_point() {
        let corners = programme(0.1, &[0.05, 0.01], 0.5);
        let rests = corners.windows(2).filter(|pair| (pair[1][1] - pair[0][1]).abs() < 1e-12).count();
        assert_eq!(rests, 2 * TURNS.len());
    }

    #[test]
    fn rounding_keeps_the_times_of_the_shortest_strokes_apart() {
        let text = table(&programme(1e-4, &[4.9], 0.0));
        let time = |row: &str| row.split(',').next().unwrap().parse::<f64>().unwrap();
        let times: Vec<f64> = text.lines().skip(2).map(time).collect();
        assert_eq!(times.len(), TURNS.len() + 1);
        assert!(times.windows(2).all(|pair| pair[0] < pair[1]), "{text}");
    }
}
