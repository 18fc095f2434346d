//! One distribution of a torque, without a warm start.

use crate::Answer;
use serde::Deserialize;
use serde_json::json;
use sinew::control::tension::{Distribution, Problem};

#[derive(Deserialize)]
#[serde(deny_unknown_fields)]
pub(crate) struct Torque {
    moment_arms: Vec<f64>,
    torque: Vec<f64>,
    minimum: Vec<f64>,
    maximum: Vec<f64>,
    reference: Vec<f64>,
    weight: Vec<f64>,
}

impl Torque {
    pub(crate) fn answer(&self) -> Answer {
        let mut distribution = Distribution::new(self.minimum.len(), self.torque.len());
        let solution = distribution.solve(&Problem {
            moment_arms: &self.moment_arms,
            torque: &self.torque,
            minimum: &self.minimum,
            maximum: &self.maximum,
            reference: &self.reference,
            weight: &self.weight,
        })?;
        Ok(json!({
            "tension": solution.tension,
            "residual": solution.residual,
            "status": solution.status as u8,
            "iterations": solution.iterations,
        }))
    }
}
