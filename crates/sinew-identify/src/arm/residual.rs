//! What the observers of an arm's cables leave, learned from the calibration runs: nothing is read from the plant.

use super::calibrate::{STROKES, runs};
use crate::Error;
use crate::calibrate::cable_log;
use crate::fit::ensemble::unscaled;
use crate::fit::perceptron::{TrainOptions, train};
use crate::observer::{CableLog, run_cable};
use rayon::prelude::*;
use sinew::control::arm::{Ends, Residual};
use sinew::predictor::CableModel;
use sinew::transmission::Perceptron;
use sinew::twin::arm::ArmSpecimen;

/// Root mean square of what is left of the far sensor's tension, N.
#[derive(Debug, Clone, Copy, PartialEq)]
pub struct Left {
    /// By the observer alone.
    pub observer_n: f64,
    /// By the observer and the network.
    pub network_n: f64,
}

/// A network for the residual of a cable's observer, and what it was worth.
#[derive(Debug, Clone, PartialEq)]
pub struct ResidualFit {
    /// For [`Residual`].
    pub network: Perceptron,
    /// Of the samples it was trained on.
    pub trained: Left,
    /// Of the end of every run, which it never saw.
    pub held_out: Left,
}

/// Share of every run that is trained on; the rest is held out.
const TRAINED: f64 = 0.7;

/// Hidden nodes: one block of the evaluation.
const HIDDEN: usize = 8;

/// Puts every transmission on the bench as its calibration did, and trains a network on what the observer of its
/// model, `[muscles]`, leaves of the far sensor.
///
/// # Errors
/// [`Error::Samples`] for models of another number than cables, or where a run ends early; [`Error::Physics`] for a
/// specimen or a model that is none.
pub fn calibrate_residuals(
    specimen: &ArmSpecimen,
    models: &[CableModel],
    seed: u64,
) -> Result<Vec<ResidualFit>, Error> {
    if models.len() != specimen.cables.len() || models.len() != specimen.drives.len() {
        return Err(Error::samples("models", "as many as cables and drives", &models.len()));
    }
    let each = models.par_iter().enumerate();
    each.map(|(muscle, model)| {
        let rows = runs(specimen, muscle, seed)?;
        let logs = rows.iter().zip(&STROKES).map(|(rows, strokes)| cable_log(rows, strokes.every));
        fit_residual(&logs.collect::<Vec<_>>(), model, seed.wrapping_add(muscle as u64))
    })
    .collect()
}

/// Samples of some runs.
#[derive(Default)]
struct Samples {
    /// Rows of [`Residual::INPUTS`].
    inputs: Vec<f64>,
    /// What the observer leaves, N.
    left: Vec<f64>,
}

fn fit_residual(logs: &[CableLog], model: &CableModel, seed: u64) -> Result<ResidualFit, Error> {
    let (mut trained, mut held_out) = (Samples::default(), Samples::default());
    for log in logs {
        let (mut ends, kept) = (Ends::default(), TRAINED * log.len() as f64);
        for (k, estimate) in run_cable(model, log)?.iter().enumerate() {
            let inputs = ends.inputs(log.interval_s[k], &log.samples[k], estimate);
            // Before it slid, an observer guesses.
            if estimate.known && log.weight[k] > 0.0 {
                let part = if (k as f64) < kept { &mut trained } else { &mut held_out };
                part.inputs.extend(inputs);
                part.left.push(log.far[k] - estimate.far);
            }
        }
    }
    let options = TrainOptions { hidden: HIDDEN, steps: 40, seed, tolerance: 1e-4, held_back: 0.0 };
    let training = train(&trained.inputs, &trained.left, &options)?;
    let network = unscaled(&training.network)
        .ok_or_else(|| Error::samples("network", "weights that are finite", &"others"))?;
    let (trained, held_out) = (trained.judge(&network)?, held_out.judge(&network)?);
    Ok(ResidualFit { network, trained, held_out })
}

impl Samples {
    fn judge(&self, network: &Perceptron) -> Result<Left, Error> {
        let (mut before, mut after) = (0.0, 0.0);
        for (inputs, left) in self.inputs.chunks_exact(Residual::INPUTS).zip(&self.left) {
            let said = network.evaluate(inputs)?.clamp(-Residual::MOST_N, Residual::MOST_N);
            before += left * left;
            after += (left - said) * (left - said);
        }
        let rms = |sum: f64| (sum / self.left.len().max(1) as f64).sqrt();
        Ok(Left { observer_n: rms(before), network_n: rms(after) })
    }
}

#[cfg(test)]
mod tests {
    use super::*;
    use sinew::body::Robot;

    #[test]
    fn training_lowers_what_a_slightly_wrong_observer_leaves_and_is_judged_on_what_it_never_saw() {
        let text = include_str!("../../../../models/lm_arm.toml");
        let robot = Robot::new(sinew::description::from_toml("lm_arm.toml", text).unwrap().parts).unwrap();
        let specimen = ArmSpecimen::draw(&robot, robot.key("start").unwrap(), 1).unwrap();
        let cable = &specimen.cables[0];
        let mut parameters = cable.parameters;
        parameters.friction *= 1.05;
        let model = CableModel { path: cable.path.clone(), parameters, start: 1.0, ..CableModel::bench() };
        let rows = runs(&specimen, 0, 1).unwrap();
        let logs: Vec<CableLog> =
            rows.iter().zip(&STROKES).map(|(rows, strokes)| cable_log(rows, strokes.every)).collect();
        let fit = fit_residual(&logs, &model, 1).unwrap();
        assert!(fit.trained.network_n < 0.7 * fit.trained.observer_n, "{fit:?}");
        assert!(fit.held_out.observer_n > 0.1 && fit.held_out.network_n.is_finite(), "{fit:?}");
        assert_eq!(fit, fit_residual(&logs, &model, 1).unwrap());
        assert!(calibrate_residuals(&specimen, &[model], 1).is_err());
    }
}
