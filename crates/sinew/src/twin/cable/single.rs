//! One cable of the plant.

use super::specimen::Specimen;
use super::wear::{CableReading, Wear};
use crate::Error;
use crate::error::within;
use crate::transmission::Sliding;
use crate::transmission::cable::{Cable, CableLaw, EndMotion};

/// Discretisation of the plant in space and time.
#[derive(Debug, Clone, Copy, PartialEq, Eq)]
pub struct Resolution {
    /// Cells of every cable, from
    /// [`CablePath::fewest_cells`](crate::transmission::cable::CablePath::fewest_cells) to 1024; exactly the
    /// fewest for a path without a sheath.
    pub cells: usize,
    /// Steps of the law in one step of the plant, 1 to 100. With 100, the shortest step of the arm, 10 us, is
    /// divided into the shortest ones that the law accepts, 0.1 us.
    pub substeps: usize,
}

impl Default for Resolution {
    /// 24 cells and, in steps of 1 ms, substeps of 0.5 ms: three times the cells of the observer's default
    /// model and twice its rate, so that plant and observer differ in their discretisation.
    ///
    /// The end tensions differ from those with 64 cells and 8 substeps by less than 0.3 N rms (near) and
    /// 0.15 N rms (far): `tests/sinew/cable_plant.rs`.
    fn default() -> Self {
        Self { cells: 24, substeps: 2 }
    }
}

impl Resolution {
    pub(in crate::twin) fn validate(self) -> Result<(), Error> {
        let some = (1..=100).contains(&self.substeps);
        within("substeps", "a number in 1..=100", self.substeps as f64, some)?;
        Ok(())
    }
}

/// One cable of the plant: true motion of both ends in, true tensions out.
///
/// The law of [`Cable`] with the specimen's parameters; heat, creep and breakage
/// ([`Effects`](super::Effects)) are added by operator splitting, once per step.
///
/// # Example
/// ```
/// use sinew::transmission::Sliding;
/// use sinew::transmission::cable::EndMotion;
/// use sinew::twin::cable::{CablePlant, Resolution, Specimen};
/// let mut cable = CablePlant::new(&Specimen::draw(1), Resolution::default())?;
/// cable.settle(60.0, Sliding::TowardMotor)?;
/// let mut reading = cable.step(1e-3, EndMotion::default())?;
/// while reading.broken.is_none() {
///     reading = cable.step(1e-3, EndMotion { motor: 2e-4, anchor: 0.0 })?; // pulled until it breaks
/// }
/// assert!(reading.broken.is_some_and(|broken| broken.tension > 800.0));
/// assert_eq!(cable.step(1e-3, EndMotion::default())?.tension_in, 0.0);
/// # Ok::<(), sinew::Error>(())
/// ```
#[derive(Debug, Clone)]
pub struct CablePlant {
    cable: Cable,
    wear: Wear,
    substeps: usize,
}

impl CablePlant {
    /// A cable without tension.
    ///
    /// # Errors
    /// [`Error::OutOfDomain`] names the number outside its domain.
    pub fn new(specimen: &Specimen, resolution: Resolution) -> Result<Self, Error> {
        resolution.validate()?;
        let mut cable = Cable::new(specimen.law(resolution.cells)?);
        if let Some(creep) = &specimen.effects.creep {
            cable.set_creep(creep.fraction, creep.time)?;
        }
        let wear = Wear::new(&specimen.effects);
        Ok(Self { cable, wear, substeps: resolution.substeps })
    }

    /// Sets the tension profile of quasi-static sliding (without drag) in one direction, with this tension at
    /// the anchor, N, at least the pretension.
    ///
    /// # Errors
    /// As [`Cable::settle`].
    pub fn settle(&mut self, tension_out: f64, sliding: Sliding) -> Result<(), Error> {
        self.cable.settle(tension_out, sliding)
    }

    /// Sets the wrap of a pulley, counted from the drive, rad.
    ///
    /// # Errors
    /// As [`Cable::set_wrap`].
    pub fn set_wrap(&mut self, pulley: usize, wrap: f64) -> Result<(), Error> {
        self.cable.set_wrap(pulley, wrap)
    }

    /// Moves both ends at constant speed over `interval` seconds; a substep lasts 0.1 us to 20 ms. Heat,
    /// creep and breakage are updated at the end, from the tensions of the last substep and the energy
    /// dissipated in all of them.
    ///
    /// # Errors
    /// As [`Cable::step`]; the state is then unchanged.
    pub fn step(&mut self, interval: f64, motion: EndMotion) -> Result<CableReading, Error> {
        let n = self.substeps as f64;
        let part = EndMotion { motor: motion.motor / n, anchor: motion.anchor / n };
        let mut ends = self.cable.step(interval / n, part)?;
        let mut dissipated = ends.dissipated;
        for _ in 1..self.substeps {
            ends = self.cable.step(interval / n, part)?;
            dissipated += ends.dissipated;
        }
        ends.dissipated = dissipated;
        let reading = self.wear.update(interval, ends, self.cable.stretch());
        if let Some(factor) = self.wear.drag_factor() {
            self.cable.scale_drag(factor)?;
        }
        self.cable.creep(interval);
        Ok(reading)
    }

    /// Its law with the present wraps, without the changes by heat and creep: for an oracle, which knows the
    /// true cable.
    #[must_use]
    pub fn law(&self) -> &CableLaw {
        self.cable.law()
    }

    /// Factor of heat on its drag, 1 when cold: for an oracle.
    #[must_use]
    pub fn drag_factor(&self) -> f64 {
        self.wear.drag_factor().unwrap_or(1.0)
    }

    /// Tension of every cell, N, drive end first, as if the cable could not break: for figures.
    pub fn tensions(&self) -> impl ExactSizeIterator<Item = f64> + Clone {
        self.cable.tensions()
    }

    /// Slip of every node in the last substep, m, + toward the motor: for figures of the slip front.
    pub fn slips(&self) -> impl ExactSizeIterator<Item = f64> + Clone {
        self.cable.slips()
    }
}
