//! What the observers of an arm's cables leave, learned from the calibration runs: nothing is read from the plant.

use super::calibrate::{CALIBRATION_STROKES, runs};
use crate::Error;
use crate::calibrate::cable_log;
use rayon::prelude::*;
use sinew::control::arm::{ResidualInputs, ResidualNetwork};
use sinew::predictor::CableModel;
use sinew::transmission::{Perceptron, PerceptronWeights};
use sinew::twin::arm::ArmSpecimen;
use sinew_identify::cable::{CableLog, observe_log};
use sinew_identify::fit::perceptron::{TrainOptions, train};

/// Root mean square of what is left of the far sensor's tension, N.
#[derive(Debug, Clone, Copy, PartialEq)]
pub struct FarTensionError {
    /// By the observer alone.
    pub observer_n: f64,
    /// By the observer and the network.
    pub network_n: f64,
}

/// A network for the residual of a cable's observer, and what it was worth.
#[derive(Debug, Clone, PartialEq)]
pub struct ResidualFit {
    /// For [`ResidualNetwork`].
    pub network: Perceptron,
    /// Of the first half of every run, which it was trained on.
    pub trained: FarTensionError,
    /// Of the end of every run, which had no part in the network; the observer's model was fitted to all of it.
    pub held_out: FarTensionError,
}

/// Share of every run that is trained on, and share up to which the training is judged; the rest is held out.
const PARTS: [f64; 2] = [0.5, 0.7];

/// Hidden nodes: one block of the evaluation.
const HIDDEN: usize = 8;

/// Puts every transmission on the bench as its calibration did, and trains a network on what the observer of its
/// model, `[muscles]`, leaves of the far sensor; as much of it counts as samples beside the training speak for.
///
/// # Errors
/// [`Error::Experiment`] for models of another number than cables, or where a run ends early; [`Error::Physics`] for a
/// specimen or a model that is none.
pub fn calibrate_residuals(
    specimen: &ArmSpecimen,
    models: &[CableModel],
    seed: u64,
) -> Result<Vec<ResidualFit>, Error> {
    if models.len() != specimen.cables.len() || models.len() != specimen.drives.len() {
        return Err(Error::experiment("models", "as many as cables and drives", &models.len()));
    }
    let each = models.par_iter().enumerate();
    each.map(|(muscle, model)| {
        let rows = runs(specimen, muscle, seed)?;
        let logs =
            rows.iter().zip(&CALIBRATION_STROKES).map(|(rows, strokes)| cable_log(rows, strokes.every));
        fit_residual(&logs.collect::<Vec<_>>(), model, seed.wrapping_add(muscle as u64))
    })
    .collect()
}

/// Samples of some runs.
#[derive(Default)]
struct Samples {
    /// Rows of [`ResidualNetwork::INPUTS`].
    inputs: Vec<f64>,
    /// What the observer leaves, N.
    left: Vec<f64>,
}

fn fit_residual(logs: &[CableLog], model: &CableModel, seed: u64) -> Result<ResidualFit, Error> {
    let [mut trained, mut judged, mut held_out] = [(); 3].map(|()| Samples::default());
    for log in logs {
        let (mut ends, length) = (ResidualInputs::default(), log.len() as f64);
        for (k, estimate) in observe_log(model, log)?.iter().enumerate() {
            let inputs = ends.update(log.interval_s[k], &log.samples[k], estimate);
            // Before it slid, an observer guesses.
            if estimate.known && log.weight[k] > 0.0 {
                let part = match k as f64 / length {
                    share if share < PARTS[0] => &mut trained,
                    share if share < PARTS[1] => &mut judged,
                    _ => &mut held_out,
                };
                part.inputs.extend(inputs);
                part.left.push(log.far[k] - estimate.far);
            }
        }
    }
    let network = faded(trained_network(&trained, &judged, seed)?, &judged)?;
    let (trained, held_out) = (trained.judge(&network)?, held_out.judge(&network)?);
    Ok(ResidualFit { network, trained, held_out })
}

/// Trained until it gets no better on samples that it is only judged by.
fn trained_network(trained: &Samples, judged: &Samples, seed: u64) -> Result<Perceptron, Error> {
    let inputs = [&trained.inputs[..], &judged.inputs].concat();
    let left = [&trained.left[..], &judged.left].concat();
    let held_back = judged.left.len() as f64 / left.len().max(1) as f64;
    let options = TrainOptions { hidden: HIDDEN, steps: 40, seed, tolerance: 1e-4, held_back };
    train(&inputs, &left, &options)?
        .network
        .to_perceptron()
        .ok_or_else(|| Error::experiment("network", "weights that are finite", &"others"))
}

/// As much of a network as samples that it was not trained on speak for: the share of it, 0 to 1, that leaves least.
fn faded(network: Perceptron, judged: &Samples) -> Result<Perceptron, Error> {
    let (mut together, mut square) = (0.0, 0.0);
    for (inputs, left) in judged.rows() {
        let said = network.evaluate(inputs)?;
        together += said * left;
        square += said * said;
    }
    let share = if square > 0.0 { (together / square).clamp(0.0, 1.0) } else { 0.0 };
    let mut weights = PerceptronWeights::from(network);
    weights.output_weights.iter_mut().chain(&mut weights.skip).for_each(|weight| *weight *= share);
    weights.output_bias *= share;
    Ok(Perceptron::new(weights)?)
}

impl Samples {
    fn rows(&self) -> impl Iterator<Item = (&[f64], &f64)> {
        self.inputs.chunks_exact(ResidualNetwork::INPUTS).zip(&self.left)
    }

    fn judge(&self, network: &Perceptron) -> Result<FarTensionError, Error> {
        let (mut before, mut after) = (0.0, 0.0);
        for (inputs, left) in self.rows() {
            let said = network.evaluate(inputs)?.clamp(-ResidualNetwork::LIMIT_N, ResidualNetwork::LIMIT_N);
            before += left * left;
            after += (left - said) * (left - said);
        }
        let rms = |sum: f64| (sum / self.left.len().max(1) as f64).sqrt();
        Ok(FarTensionError { observer_n: rms(before), network_n: rms(after) })
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
        let logs: Vec<CableLog> = rows
            .iter()
            .zip(&CALIBRATION_STROKES)
            .map(|(rows, strokes)| cable_log(rows, strokes.every))
            .collect();
        let fit = fit_residual(&logs, &model, 1).unwrap();
        assert!(fit.trained.network_n < 0.7 * fit.trained.observer_n, "{fit:?}");
        assert!(fit.held_out.observer_n > 0.1 && fit.held_out.network_n.is_finite(), "{fit:?}");
        assert_eq!(fit, fit_residual(&logs, &model, 1).unwrap());
        assert!(calibrate_residuals(&specimen, &[model], 1).is_err());
    }
}
