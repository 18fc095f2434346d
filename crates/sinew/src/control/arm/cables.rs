use super::controller::GroundTruth;
use super::gains::ArmGains;
use super::mechanics::Mechanics;
use super::residual::ResidualNetwork;
use super::winch::{MuscleReference, Winch};
use crate::Error;
use crate::predictor::{CableEstimate, CableModel, CableObservers, CableSample};
use crate::transmission::Perceptron;
use alloc::vec;
use alloc::vec::Vec;

/// Where tension at the anchors and stretch are known from.
#[derive(Debug, Clone, Copy, PartialEq, Eq)]
pub enum CableStateSource {
    /// The cables' observers.
    Observer,
    /// The encoders alone: stretch is what motors and joints have moved apart since the start; tensions are believed to be as wanted.
    Encoders,
    /// Somebody who looks into the cables: the yardstick.
    Oracle,
}

/// What is believed of all cables: `[muscles]` each.
#[derive(Debug, Clone)]
pub(super) struct Cables {
    knowledge: CableStateSource,
    observers: CableObservers,
    samples: Vec<CableSample>,
    estimates: Vec<CableEstimate>,
    /// What the observers leave: `[muscles]`, or none.
    residuals: Vec<ResidualNetwork>,
    /// Where the last pulley of every cable is told its wrap: its place and the wrap as told.
    wraps: Vec<(usize, f64)>,
    turn: usize,
    /// Stretch of every cable less what its ends were apart at the start, m.
    zero: Vec<f64>,
    started: bool,
    pub(super) tension_out: Vec<f64>,
    pub(super) stretch: Vec<f64>,
    pub(super) tension_in: Vec<f64>,
    drag: Vec<f64>,
}

/// Change of a wrap that is worth telling, rad.
const WORTH_TELLING: f64 = 1e-3;
/// Most turn at a joint that one node can stand for, rad.
const MOST_WRAP: f64 = 4.0;

impl Cables {
    pub(super) fn new(models: &[CableModel], knowledge: CableStateSource) -> Result<Self, Error> {
        let n = models.len();
        Ok(Self {
            knowledge,
            observers: CableObservers::new(models)?,
            samples: vec![CableSample::default(); n],
            estimates: vec![CableEstimate::default(); n],
            residuals: Vec::new(),
            wraps: models.iter().map(|model| (model.path.pulleys().saturating_sub(1), f64::NAN)).collect(),
            turn: 0,
            zero: vec![0.0; n],
            started: false,
            tension_out: vec![0.0; n],
            stretch: vec![0.0; n],
            tension_in: vec![0.0; n],
            drag: vec![1.0; n],
        })
    }

    /// Networks for what the observers leave: `[muscles]`.
    pub(super) fn correct(&mut self, networks: Vec<Perceptron>) -> Result<(), Error> {
        let (expected, got) = (self.samples.len(), networks.len());
        if got != expected {
            return Err(Error::WrongLength { name: "residuals", expected, got });
        }
        self.residuals = networks.into_iter().map(ResidualNetwork::new).collect::<Result<_, _>>()?;
        Ok(())
    }

    /// Takes what motors and load cells say, with the tensions that were wanted.
    pub(super) fn look(
        &mut self,
        h: f64,
        (motor, tension): (&[f64], &[f64]),
        mechanics: &Mechanics,
        wanted: &[f64],
        told: Option<&GroundTruth<'_>>,
    ) -> Result<(), Error> {
        self.wrap(&mechanics.bends)?;
        for (k, (seen, length)) in self.samples.iter_mut().zip(mechanics.lengths()).enumerate() {
            *seen = CableSample { motor: motor[k], anchor: -length, tension_in: tension[k] };
        }
        self.observers.step(h, &self.samples, &mut self.estimates)?;
        let seen = self.estimates.iter_mut().zip(&self.samples);
        for (residual, (estimate, seen)) in self.residuals.iter_mut().zip(seen) {
            estimate.tension_out += residual.step(h, seen, estimate)?;
        }
        for (k, (estimate, seen)) in self.estimates.iter().zip(&self.samples).enumerate() {
            self.tension_in[k] = estimate.tension_in;
            let apart = seen.motor - seen.anchor;
            if !self.started {
                self.zero[k] = estimate.stretch - apart;
            }
            (self.tension_out[k], self.stretch[k], self.drag[k]) = match self.knowledge {
                CableStateSource::Encoders if self.started => (wanted[k], self.zero[k] + apart, 1.0),
                _ => (estimate.tension_out, estimate.stretch, estimate.drag_factor),
            };
        }
        self.started = true;
        if let (CableStateSource::Oracle, Some(told)) = (self.knowledge, told) {
            self.tension_out.copy_from_slice(told.tension_out);
            self.stretch.copy_from_slice(told.stretch);
            self.drag.copy_from_slice(told.drag_factor);
        }
        Ok(())
    }

    /// What the winch's law wants of a cable, m.
    pub(super) fn wanted_stretch(
        &self,
        h: f64,
        k: usize,
        winch: &mut Winch,
        pull: &MuscleReference,
        gains: &ArmGains,
    ) -> f64 {
        let law = self.observers.cables().law(k);
        law.map_or(self.stretch[k], |law| winch.stretch(h, law, pull, self.drag[k], gains))
    }

    /// The posture turns the cables at their joints. All at first, then one each millisecond: postures change slowly.
    fn wrap(&mut self, bends: &[f64]) -> Result<(), Error> {
        let n = self.wraps.len();
        let first = self.wraps.iter().any(|(_, told)| told.is_nan());
        for k in if first { 0..n } else { self.turn..self.turn + 1 } {
            let (place, told) = self.wraps[k];
            let wrap = bends[k].clamp(0.0, MOST_WRAP);
            if told.is_nan() || (wrap - told).abs() >= WORTH_TELLING {
                self.observers.set_wrap(k, place, wrap)?;
                self.wraps[k].1 = wrap;
            }
        }
        self.turn = (self.turn + 1) % n;
        Ok(())
    }
}
