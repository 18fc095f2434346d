//! Networks for the residuals of the cable observers of an arm, trained on the calibration runs: only
//! measurements of the plant are used.

use super::calibrate::{CalibrationProgramme, runs};
use crate::Error;
use crate::calibrate::cable_log;
use rayon::prelude::*;
use sinew::control::arm::{ResidualInputs, ResidualNetwork};
use sinew::predictor::CableModel;
use sinew::transmission::{Perceptron, PerceptronWeights};
use sinew::twin::arm::ArmSpecimen;
use sinew_identify::cable::{CableLog, observe_log};
use sinew_identify::fit::perceptron::{TrainOptions, train};

/// Root mean square error of the estimated far tension, N.
#[derive(Debug, Clone, Copy, PartialEq)]
pub struct FarTensionError {
    /// Of the observer alone.
    pub observer_n: f64,
    /// Of the observer with the network.
    pub network_n: f64,
}

/// A network for the residual of a cable observer, with its errors.
#[derive(Debug, Clone, PartialEq)]
pub struct ResidualFit {
    /// For [`ResidualNetwork`].
    pub network: Perceptron,
    /// On the training part, the first half of every run.
    pub training: FarTensionError,
    /// On the last part of every run, which the network was not trained on; the observer was fitted to whole
    /// runs.
    pub held_out: FarTensionError,
}

/// Ends of the training and the validation part as shares of every run; the rest is held out.
const SPLIT: [f64; 2] = [0.5, 0.7];

/// Hidden nodes: one SIMD block.
const HIDDEN: usize = 8;

/// Trains a residual network for the observer of every model, `[muscles]`, on the runs of its calibration.
///
/// The output of a network is scaled by the factor in [0, 1] that minimises the error on the validation part.
///
/// # Errors
/// [`Error::Experiment`] where the numbers of models and cables differ or a run ends early;
/// [`Error::Physics`] for an invalid specimen or model.
pub fn calibrate_residuals(
    specimen: &ArmSpecimen,
    models: &[CableModel],
    programmes: &[CalibrationProgramme],
    seed: u64,
) -> Result<Vec<ResidualFit>, Error> {
    let count = models.len();
    if [specimen.cables.len(), specimen.drives.len(), programmes.len()] != [count; 3] {
        return Err(Error::experiment("models", "as many as cables and drives", &models.len()));
    }
    let muscles: Vec<usize> = (0..count).collect();
    let logs = runs(specimen, &muscles, programmes, seed, |stroke| stroke.decimation)?;
    let fits = models.par_iter().zip(logs).enumerate().map(|(muscle, (model, logs))| {
        let logs: Vec<CableLog> = logs.iter().map(cable_log).collect();
        fit_residual(&logs, model, seed.wrapping_add(muscle as u64))
    });
    fits.collect()
}

/// Samples of one part of the runs.
#[derive(Default)]
struct Samples {
    /// Rows of [`ResidualNetwork::INPUTS`].
    inputs: Vec<f64>,
    /// Residuals of the observer, N.
    residuals: Vec<f64>,
}

fn fit_residual(logs: &[CableLog], model: &CableModel, seed: u64) -> Result<ResidualFit, Error> {
    let [mut training, mut validation, mut held_out] = [(); 3].map(|()| Samples::default());
    for log in logs {
        let (mut ends, length) = (ResidualInputs::default(), log.len() as f64);
        for (k, estimate) in observe_log(model, log)?.iter().enumerate() {
            let inputs = ends.update(log.interval_s[k], &log.samples[k], estimate);
            // The state is unknown until the whole cable has slid once.
            if estimate.known && log.weight[k] > 0.0 {
                let part = match k as f64 / length {
                    share if share < SPLIT[0] => &mut training,
                    share if share < SPLIT[1] => &mut validation,
                    _ => &mut held_out,
                };
                part.inputs.extend(inputs);
                part.residuals.push(log.far[k] - estimate.far);
            }
        }
    }
    let network = scaled(train_network(&training, &validation, seed)?, &validation)?;
    let (training, held_out) = (training.errors(&network)?, held_out.errors(&network)?);
    Ok(ResidualFit { network, training, held_out })
}

/// Trains with early stopping on the validation part.
fn train_network(training: &Samples, validation: &Samples, seed: u64) -> Result<Perceptron, Error> {
    let inputs = [&training.inputs[..], &validation.inputs].concat();
    let residuals = [&training.residuals[..], &validation.residuals].concat();
    let held_back = validation.residuals.len() as f64 / residuals.len().max(1) as f64;
    let options = TrainOptions { hidden: HIDDEN, steps: 40, seed, tolerance: 1e-4, held_back };
    train(&inputs, &residuals, &options)?
        .network
        .to_perceptron()
        .ok_or_else(|| Error::experiment("network", "finite weights", &"NaN or infinity"))
}

/// Scales the output of a network by the least-squares factor in [0, 1] on the validation part.
fn scaled(network: Perceptron, validation: &Samples) -> Result<Perceptron, Error> {
    let (mut cross, mut square) = (0.0, 0.0);
    for (inputs, residual) in validation.rows() {
        let output = network.evaluate(inputs)?;
        cross += output * residual;
        square += output * output;
    }
    let factor = if square > 0.0 { (cross / square).clamp(0.0, 1.0) } else { 0.0 };
    let mut weights = PerceptronWeights::from(network);
    weights.output_weights.iter_mut().chain(&mut weights.skip).for_each(|weight| *weight *= factor);
    weights.output_bias *= factor;
    Ok(Perceptron::new(weights)?)
}

impl Samples {
    fn rows(&self) -> impl Iterator<Item = (&[f64], &f64)> {
        self.inputs.chunks_exact(ResidualNetwork::INPUTS).zip(&self.residuals)
    }

    fn errors(&self, network: &Perceptron) -> Result<FarTensionError, Error> {
        let (mut before, mut after) = (0.0, 0.0);
        for (inputs, residual) in self.rows() {
            let output = network.evaluate(inputs)?.clamp(-ResidualNetwork::LIMIT_N, ResidualNetwork::LIMIT_N);
            before += residual * residual;
            after += (residual - output) * (residual - output);
        }
        let rms = |sum: f64| (sum / self.residuals.len().max(1) as f64).sqrt();
        Ok(FarTensionError { observer_n: rms(before), network_n: rms(after) })
    }
}

#[cfg(test)]
mod tests {
    use super::*;
    use crate::arm::{calibration_programmes, testing::lm_arm};

    #[test]
    fn a_network_lowers_the_residual_of_an_observer_with_wrong_friction() {
        let machine = lm_arm();
        let specimen = ArmSpecimen::draw(&machine, 1).unwrap();
        let design = ArmSpecimen::nominal(&machine).unwrap();
        let programme = calibration_programmes(&machine, &design).unwrap()[0];
        let cable = &specimen.cables[0];
        let mut parameters = cable.parameters;
        parameters.friction *= 1.05;
        let model = CableModel { path: cable.path.clone(), parameters, start: 1.0, ..CableModel::bench() };
        let rows = runs(&specimen, &[0], &[programme], 1, |stroke| stroke.decimation).unwrap();
        let logs: Vec<CableLog> = rows[0].iter().map(cable_log).collect();
        let fit = fit_residual(&logs, &model, 1).unwrap();
        assert!(fit.training.network_n < 0.7 * fit.training.observer_n, "{fit:?}");
        assert!(fit.held_out.observer_n > 0.1 && fit.held_out.network_n.is_finite(), "{fit:?}");
        assert_eq!(fit, fit_residual(&logs, &model, 1).unwrap());
        assert!(calibrate_residuals(&specimen, &[model], &[programme], 1).is_err());
    }
}
