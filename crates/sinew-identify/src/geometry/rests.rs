//! Places at rest by what joints and cables say there.

use super::places::{Readings, rest_times};
use super::{GeometryError, GeometryModel};

/// Readings and estimates of the cables in time, in the rows of the [`Readings`] of the joints.
#[derive(Debug, Clone, PartialEq, Default)]
pub struct CableReadings {
    /// Position by the motor's encoder, m, + toward the motor: `[n][muscles]`.
    pub position: Vec<Vec<f64>>,
    /// Tension at the drive's outlet, N: `[n][muscles]`.
    pub tension_in: Vec<Vec<f64>>,
    /// Tension at the anchor as the controller estimates it, N: `[n][muscles]`.
    pub tension_out: Vec<Vec<f64>>,
}

/// Means at a place where a machine rested.
#[derive(Debug, Clone, PartialEq)]
pub struct Rest {
    /// From when, until when, s.
    pub time: [f64; 2],
    /// rad or m: `[joints]`.
    pub joint: Vec<f64>,
    /// As in [`CableReadings`]: `[muscles]`.
    pub position: Vec<f64>,
    /// See `position`.
    pub tension_in: Vec<f64>,
    /// See `position`.
    pub tension_out: Vec<f64>,
}

/// Time at the end of a rest whose readings count, s: cables creep at its beginning.
const LAST_S: f64 = 0.6;

/// All places at rest; the model's markers tell what moves.
///
/// # Errors
/// As [`GeometryModel::sensitivity`].
pub fn rests(
    model: &GeometryModel,
    readings: &Readings,
    cables: &CableReadings,
) -> Result<Vec<Rest>, GeometryError> {
    let rest = |[from, to]: [f64; 2]| {
        let time = [from.max(to - LAST_S), to];
        let inside = |t: f64| (time[0]..=time[1]).contains(&t);
        let mean = |rows: &[Vec<f64>]| {
            let here = || rows.iter().zip(&readings.time).filter(|(_, t)| inside(**t)).map(|(row, _)| row);
            let width = rows.first().map_or(0, Vec::len);
            let count = here().count() as f64;
            (0..width).map(|k| here().map(|row| row[k]).sum::<f64>() / count).collect::<Vec<f64>>()
        };
        Rest {
            time,
            joint: mean(&readings.joint),
            position: mean(&cables.position),
            tension_in: mean(&cables.tension_in),
            tension_out: mean(&cables.tension_out),
        }
    };
    let known = |rest: &Rest| {
        let all = [&rest.joint, &rest.position, &rest.tension_in, &rest.tension_out];
        all.iter().all(|values| values.iter().all(|x| x.is_finite()))
    };
    Ok(rest_times(model, readings)?.into_iter().map(rest).filter(known).collect())
}
