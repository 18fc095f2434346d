//! The cables of a robot, in SIMD lanes of eight.

use super::single::Resolution;
use super::specimen::Specimen;
use super::wear::{CableReading, Wear};
use crate::Error;
use crate::error::within;
use crate::transmission::Sliding;
use crate::transmission::cable::{CableBatch, EndMotion, EndTensions};
use alloc::vec;
use alloc::vec::Vec;

/// Cables of the plant in parallel: bit for bit the same as as many [`CablePlant`](super::CablePlant)s.
#[derive(Debug, Clone)]
pub struct CablePlants {
    cables: CableBatch,
    wear: Vec<Wear>,
    substeps: usize,
    parts: Vec<EndMotion>,
    ends: Vec<EndTensions>,
    dissipated: Vec<f64>,
}

impl CablePlants {
    /// Cables without tension.
    ///
    /// # Errors
    /// [`Error::OutOfDomain`] names the number outside its domain, [`Error::WrongLength`] where there is no
    /// specimen.
    pub fn new(specimens: &[Specimen], resolution: Resolution) -> Result<Self, Error> {
        resolution.validate()?;
        let laws = specimens.iter().map(|s| s.law(resolution.cells)).collect::<Result<Vec<_>, _>>()?;
        let n = specimens.len();
        let mut cables = CableBatch::new(&laws)?;
        for (k, specimen) in specimens.iter().enumerate() {
            if let Some(creep) = &specimen.effects.creep {
                cables.set_creep(k, creep.fraction, creep.time)?;
            }
        }
        Ok(Self {
            cables,
            wear: specimens.iter().map(|s| Wear::new(&s.effects)).collect(),
            substeps: resolution.substeps,
            parts: vec![EndMotion::default(); n],
            ends: vec![EndTensions::default(); n],
            dissipated: vec![0.0; n],
        })
    }

    /// As [`CablePlant::settle`](super::CablePlant::settle) for one cable.
    ///
    /// # Errors
    /// As [`CableBatch::settle`].
    pub fn settle(&mut self, cable: usize, tension_out: f64, sliding: Sliding) -> Result<(), Error> {
        self.cables.settle(cable, tension_out, sliding)
    }

    /// As [`CablePlant::set_wrap`](super::CablePlant::set_wrap) for one cable.
    ///
    /// # Errors
    /// As [`CableBatch::set_wrap`].
    pub fn set_wrap(&mut self, cable: usize, pulley: usize, wrap: f64) -> Result<(), Error> {
        self.cables.set_wrap(cable, pulley, wrap)
    }

    /// As [`CableBatch::set_sheath_bend`].
    ///
    /// # Errors
    /// As there.
    pub fn set_sheath_bend(&mut self, cable: usize, bend: f64) -> Result<(), Error> {
        self.cables.set_sheath_bend(cable, bend)
    }

    /// As [`CableBatch::scale_compliance`].
    ///
    /// # Errors
    /// As there.
    pub fn scale_compliance(&mut self, cable: usize, factor: f64) -> Result<(), Error> {
        self.cables.scale_compliance(cable, factor)
    }

    /// Advances all cables: `motions: [cables]` in, `readings: [cables]` out.
    ///
    /// # Errors
    /// As [`CableBatch::step`]; the state is then unchanged.
    pub fn step(
        &mut self,
        interval: f64,
        motions: &[EndMotion],
        readings: &mut [CableReading],
    ) -> Result<(), Error> {
        let cables = self.wear.len();
        for (name, got) in [("motions", motions.len()), ("readings", readings.len())] {
            if got != cables {
                return Err(Error::WrongLength { name, expected: cables, got });
            }
        }
        let n = self.substeps as f64;
        for (part, motion) in self.parts.iter_mut().zip(motions) {
            *part = EndMotion { motor: motion.motor / n, anchor: motion.anchor / n };
        }
        self.dissipated.fill(0.0);
        for _ in 0..self.substeps {
            self.cables.step(interval / n, &self.parts, &mut self.ends)?;
            for (sum, ends) in self.dissipated.iter_mut().zip(&self.ends) {
                *sum += ends.dissipated;
            }
        }
        for (k, (wear, reading)) in self.wear.iter_mut().zip(readings).enumerate() {
            let ends = EndTensions { dissipated: self.dissipated[k], ..self.ends[k] };
            *reading = wear.update(interval, ends, self.cables.stretch(k).unwrap_or(0.0));
            if let Some(factor) = wear.drag_factor() {
                self.cables.scale_drag(k, factor)?;
            }
        }
        self.cables.creep(interval);
        Ok(())
    }

    /// Breaks one cable, whatever its tension; without effect on an index out of range or a broken cable.
    pub fn snap(&mut self, cable: usize) {
        if let Some(wear) = self.wear.get_mut(cable) {
            wear.snap(self.ends[cable]);
        }
    }

    /// Elastic energy of one cable, J, without that of `T_0` and of creep.
    ///
    /// # Errors
    /// [`Error::OutOfDomain`] for an index out of range.
    pub fn energy(&self, cable: usize) -> Result<f64, Error> {
        self.cables.energy(cable)
    }

    /// Tension along one cable, N, drive end first.
    ///
    /// # Errors
    /// [`Error::OutOfDomain`] for an index out of range.
    pub fn tensions(&self, cable: usize) -> Result<impl Iterator<Item = f64>, Error> {
        within("cable", "below the number of cables", cable as f64, cable < self.wear.len())?;
        Ok(self.cables.tensions(cable))
    }
}
