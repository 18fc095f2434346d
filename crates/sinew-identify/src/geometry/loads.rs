//! Masses and centres of mass with which gravity agrees with the torques of the cables at rest.

use super::GeometryError;
use super::prior_fit::{Row, fit};
use super::rests::Rest;
use sinew::body::{Parts, Robot};
use sinew::machine::Machine;
use sinew::muscle::MuscleDynamics;

/// What of a body may differ from the design.
#[derive(Debug, Clone, Copy, PartialEq, Eq)]
pub enum LoadPart {
    /// Its mass, kg.
    Mass(usize),
    /// A coordinate of its centre of mass, m.
    Center(usize, usize),
}

/// Loads as found.
#[derive(Debug, Clone, PartialEq)]
pub struct LoadEstimate {
    /// Of every part, kg or m.
    pub value: Vec<f64>,
    /// Its standard deviation after.
    pub sd: Vec<f64>,
}

/// Balance of the joints at rest.
///
/// ```text
/// R^T F = g(q; masses, centres of mass) - tau_p
/// ```
///
/// # Assumes
/// Tensions at the anchors as the controller estimates them; what friction holds is noise, which is found
/// with the parameters.
#[derive(Debug, Clone)]
pub struct LoadModel {
    /// With the routes by which tensions become torques.
    parts: Parts,
    loads: Vec<LoadPart>,
    tolerance: Vec<f64>,
}

/// For the derivatives, over the tolerance.
const STEP: f64 = 0.1;
/// Least scatter of a torque over the largest torque.
const FLOOR: f64 = 1e-3;

impl LoadModel {
    /// Of a machine as designed but for its routes, with its tolerances.
    #[must_use]
    pub fn new(machine: &Machine, routes: Parts) -> Self {
        let bound = |x: f64| x / 3.0_f64.sqrt();
        let (mut loads, mut tolerance) = (Vec::new(), Vec::new());
        for (body, part) in routes.bodies.iter().enumerate().skip(1).filter(|(_, body)| body.mass > 0.0) {
            let mass = (LoadPart::Mass(body), bound(machine.tolerances.mass * part.mass));
            let center = bound(machine.tolerances.center_of_mass);
            let all = [mass].into_iter().chain((0..3).map(|k| (LoadPart::Center(body, k), center)));
            for (load, bound) in all.filter(|(_, bound)| *bound > 0.0) {
                loads.push(load);
                tolerance.push(bound);
            }
        }
        Self { parts: routes, loads, tolerance }
    }

    /// What may differ.
    #[must_use]
    pub fn loads(&self) -> &[LoadPart] {
        &self.loads
    }

    /// Standard deviations of these before, kg or m.
    #[must_use]
    pub fn tolerance(&self) -> &[f64] {
        &self.tolerance
    }

    /// The robot with these loads.
    #[must_use]
    pub fn with(&self, value: &[f64]) -> Parts {
        let mut parts = self.parts.clone();
        for (load, value) in self.loads.iter().zip(value) {
            match *load {
                LoadPart::Mass(body) => {
                    let mass = &mut parts.bodies[body].mass;
                    *mass = (*mass + value).max(0.1 * *mass);
                }
                LoadPart::Center(body, k) => parts.bodies[body].center_of_mass[k] += value,
            }
        }
        parts
    }

    /// Torques of the cables minus those that hold the machine, Nm or N: `[rests][joints]`.
    ///
    /// # Errors
    /// [`GeometryError::Physics`] for loads that are none.
    pub fn errors(&self, value: &[f64], rests: &[Rest]) -> Result<Vec<Vec<f64>>, GeometryError> {
        let robot = Robot::new(self.with(value)).map_err(sinew::Error::from)?;
        let mut model = MuscleDynamics::new(&robot)?;
        let still = vec![0.0; model.joints()];
        let mut missed = |rest: &Rest| {
            model.evaluate(&rest.joint)?;
            let mut force = still.clone();
            // Its negative would accelerate the joints.
            model.accelerating_force(&still, &rest.tension_out, &mut force)?;
            Ok(force)
        };
        rests.iter().map(&mut missed).collect()
    }

    /// The most probable loads.
    ///
    /// # Errors
    /// As [`errors`](Self::errors); [`GeometryError::Observations`] where readings determine nothing.
    pub fn estimate(&self, rests: &[Rest]) -> Result<LoadEstimate, GeometryError> {
        let none = vec![0.0; self.loads.len()];
        let designed = self.errors(&none, rests)?;
        let joints = designed.first().map_or(0, Vec::len);
        let scatter = |joint: usize| {
            let squares = designed.iter().map(|row| row[joint].powi(2)).sum::<f64>();
            (squares / designed.len() as f64).sqrt()
        };
        let scale: Vec<f64> = (0..joints).map(scatter).collect();
        let floor = FLOOR * scale.iter().fold(f64::MIN_POSITIVE, |a: f64, b| a.max(*b));
        let rows = |x: &[f64]| {
            let at = self.errors(x, rests)?;
            let mut rows: Vec<Row> = Vec::new();
            for torques in &at {
                let row = |(channel, residual): (usize, &f64)| Row {
                    channel,
                    residual: *residual,
                    slopes: Vec::new(),
                };
                rows.extend(torques.iter().enumerate().map(row));
            }
            for (k, tolerance) in self.tolerance.iter().enumerate() {
                let mut moved = x.to_vec();
                moved[k] += STEP * tolerance;
                let beside = self.errors(&moved, rests)?;
                let pairs = at.iter().flatten().zip(beside.iter().flatten());
                for (row, (a, b)) in rows.iter_mut().zip(pairs) {
                    row.slopes.push((k, (a - b) / (STEP * tolerance)));
                }
            }
            Ok(rows)
        };
        let scale = scale.into_iter().map(|scale| scale.max(floor)).collect();
        let found = fit(&self.tolerance, (scale, floor), rows)?;
        Ok(LoadEstimate { value: found.x, sd: found.sd })
    }
}
