//! From a dataset with roles to the inputs of the observer: metres, newtons, positive toward the motor.

use super::log::CableLog;
use crate::log::{Dataset, Role, Sequence, factor};
use crate::{ColumnRole, Error};
use sinew::predictor::CableColumns;

/// The sequences of a dataset as logs of a cable. Directions are found from the data: winding in raises the
/// near tension, an anchor that moves away raises the far one.
///
/// # Errors
/// [`Error::MissingRole`] without a near tension, a motor position or an anchor displacement;
/// [`Error::Samples`] where a column is an angle or a torque, or where nothing moves, so that a direction is
/// not defined.
pub fn cable_logs(data: &Dataset) -> Result<(CableColumns, Vec<CableLog>), Error> {
    let mut columns = CableColumns {
        tension: first(data, Role::Effort, ColumnRole::Effort, "a near tension, N")?,
        motor: first(data, Role::Motion, ColumnRole::Motion, "a position of the cable at the drive, m")?,
        anchor: first(data, Role::Anchor, ColumnRole::Anchor, "a displacement of the anchor, m")?,
        tension_scale: 1.0,
        motor_scale: 1.0,
        anchor_scale: 1.0,
    };
    columns.motor_scale = metres(data, columns.motor)?;
    columns.anchor_scale = metres(data, columns.anchor)?;
    let tension = &data.roles.inputs[columns.tension].column;
    let unit = data.unit(tension);
    if !unit.is_empty() && factor(&unit, "Nm").is_some() {
        return Err(Error::samples(format!("column `{tension}`"), "a tension in N", &"a torque"));
    }
    columns.tension_scale = factor(&unit, "N").unwrap_or(1.0);
    let newtons = far_scale(data);
    let logs = |columns: &CableColumns| -> Vec<CableLog> {
        data.sequences
            .iter()
            .map(|sequence| log(sequence, columns, data.roles.inputs.len(), newtons))
            .collect()
    };
    let (motor, anchor) = directions(&logs(&columns))?;
    columns.motor_scale *= motor;
    columns.anchor_scale *= anchor;
    let logs = logs(&columns);
    Ok((columns, logs))
}

fn first(data: &Dataset, of: Role, role: ColumnRole, expected: &'static str) -> Result<usize, Error> {
    let place = data.roles.inputs.iter().position(|input| input.role == of);
    place.ok_or(Error::MissingRole { role, expected })
}

/// Metres per unit of a position column, in whatever way its unit is stated; none means metres.
fn metres(data: &Dataset, input: usize) -> Result<f64, Error> {
    let column = &data.roles.inputs[input].column;
    let unit = data.unit(column);
    let expected = "a length: multiply by the radius of the winch or the moment arm of the joint";
    factor(&unit, "m").ok_or_else(|| Error::samples(format!("column `{column}`"), expected, &unit))
}

/// Newtons per unit of the far side; 1 where its unit is not stated, or none of force.
pub(crate) fn far_scale(data: &Dataset) -> f64 {
    let far = data.roles.far.as_deref().map(|far| data.unit(far));
    far.and_then(|unit| factor(&unit, "N")).unwrap_or(1.0)
}

fn log(sequence: &Sequence, columns: &CableColumns, width: usize, newtons: f64) -> CableLog {
    let mut log = CableLog::default();
    let mut before = f64::NAN;
    for (row, &time) in sequence.time_s.iter().enumerate() {
        let interval = if before.is_nan() { 0.0 } else { time - before };
        before = time;
        let sample = columns.sample(&sequence.inputs[row * width..][..width]);
        let far = if sequence.scored[row] { newtons * sequence.far_clean[row] } else { f64::NAN };
        log.push(interval, sample, far);
    }
    log
}

/// `+-1` for motor and anchor: the signs of `dT_in/dp_m` and `-dT_out/dp_a` in a regression on both
/// displacements.
fn directions(logs: &[CableLog]) -> Result<(f64, f64), Error> {
    let (mut near, mut far) = (Regression::default(), Regression::default());
    for log in logs {
        super::initial::windows(log, |change| {
            near.push(change.motor, -change.anchor, change.tension_in);
            far.push(change.motor, -change.anchor, change.far);
        });
    }
    let sign = |name: &str, slope: Option<f64>| match slope {
        Some(slope) if slope > 0.0 => Ok(1.0),
        Some(slope) if slope < 0.0 => Ok(-1.0),
        _ => Err(Error::samples(name, "a motion that changes the tension", &"none")),
    };
    Ok((
        sign("motor position", near.slopes().map(|s| s.0))?,
        sign("anchor displacement", far.slopes().map(|s| s.1))?,
    ))
}

/// `y = a u + b v` by least squares.
#[derive(Debug, Clone, Copy, Default)]
struct Regression {
    uu: f64,
    uv: f64,
    vv: f64,
    uy: f64,
    vy: f64,
}

impl Regression {
    fn push(&mut self, u: f64, v: f64, y: f64) {
        if (u + v + y).is_finite() {
            self.uu += u * u;
            self.uv += u * v;
            self.vv += v * v;
            self.uy += u * y;
            self.vy += v * y;
        }
    }

    /// `(a, b)`; `None` where one of both never moved. Where they always moved together, the sum decides for
    /// both.
    fn slopes(&self) -> Option<(f64, f64)> {
        if self.uu <= 0.0 || self.vv <= 0.0 {
            return None;
        }
        // Ridge regularisation: two drives that follow each other are nearly collinear.
        let (uu, vv) = (self.uu * 1.001, self.vv * 1.001);
        let determinant = uu * vv - self.uv * self.uv;
        Some((
            (self.uy * vv - self.vy * self.uv) / determinant,
            (self.vy * uu - self.uy * self.uv) / determinant,
        ))
    }
}
