use super::design::Machine;
use crate::Error;
use crate::muscle::MuscleDynamics;
use crate::transmission::SheathBend;
use crate::transmission::cable::CableLaw;
use alloc::vec::Vec;

/// Free length of a cable whose muscle has none of its own, m.
const SHORTEST: f64 = 1e-3;

impl Machine {
    /// The bend of every sheath, that of the design in the start: `[muscles]`.
    ///
    /// # Errors
    /// As [`SheathBend::new`].
    pub fn sheath_bends(&self) -> Result<Vec<SheathBend>, Error> {
        let bend = |design: &super::MuscleDesign| {
            let reference = if design.bend_by_joint.is_empty() { Vec::new() } else { self.start.clone() };
            SheathBend::new(design.bend, design.bend_by_joint.clone(), reference)
        };
        self.muscles.iter().map(bend).collect()
    }

    /// The same laws where the bend of a sheath depends on the pose, at its largest over these poses:
    /// `laws: [muscles]`, `poses: [places][joints]`.
    ///
    /// # Errors
    /// As [`CableLaw::with_sheath_bend`].
    pub fn laws_at_largest_bend(
        &self,
        laws: &[CableLaw],
        poses: &[Vec<f64>],
    ) -> Result<Vec<CableLaw>, Error> {
        let at_largest = |(law, bend): (&CableLaw, SheathBend)| {
            if bend.is_constant() {
                return Ok(law.clone());
            }
            let bend = bend.scaled_to(law.sheath_bend())?;
            let largest = poses.iter().map(|pose| bend.at(pose)).fold(law.sheath_bend(), f64::max);
            law.clone().with_sheath_bend(largest)
        };
        laws.iter().zip(self.sheath_bends()?).map(at_largest).collect()
    }

    /// The laws of all cables as designed, at the start, each cut into `cells`: `[muscles]`.
    ///
    /// # Errors
    /// As [`CableLaw::new`] and [`MuscleDynamics::evaluate`].
    pub fn laws(&self, cells: usize) -> Result<Vec<CableLaw>, Error> {
        let mut model = MuscleDynamics::new(&self.robot)?;
        model.evaluate(&self.start)?;
        self.laws_in(&model, &self.start, cells)
    }

    /// The same in another pose, in which the `model` of this machine was evaluated.
    ///
    /// # Errors
    /// As [`laws`](Self::laws).
    pub fn laws_in(
        &self,
        model: &MuscleDynamics,
        pose: &[f64],
        cells: usize,
    ) -> Result<Vec<CableLaw>, Error> {
        let places = model.lengths().iter().enumerate();
        let law = |((design, bend), (muscle, free)): ((&super::MuscleDesign, SheathBend), (usize, &f64))| {
            let path = design.path(free.max(SHORTEST), model.wrap_angle(muscle))?;
            let law = CableLaw::new(&path, &design.cable, cells)?;
            if bend.is_constant() { Ok(law) } else { law.with_sheath_bend(bend.at(pose)) }
        };
        self.muscles.iter().zip(self.sheath_bends()?).zip(places).map(law).collect()
    }
}
