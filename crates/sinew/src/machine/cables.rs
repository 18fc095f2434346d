use super::design::Machine;
use crate::Error;
use crate::muscle::MuscleDynamics;
use crate::predictor::CableModel;
use crate::transmission::SheathBend;
use crate::transmission::cable::{CableLaw, CableParameters};
use alloc::vec::Vec;

/// Free length of a cable whose muscle has none of its own, m.
const SHORTEST: f64 = 1e-3;
/// Friction of a machine as built over that of its design, at most: two standard deviations, and what
/// friction weakens with speed.
const AS_BUILT: f64 = 1.25;

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
        let bends = self.muscles.iter().enumerate();
        bends.map(|(muscle, design)| bend(design).map_err(|error| error.of_part("muscle", muscle))).collect()
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
        let bends = self.sheath_bends()?.into_iter().enumerate();
        laws.iter()
            .zip(bends)
            .map(|(law, (muscle, bend))| {
                at_largest((law, bend)).map_err(|error| error.of_part("muscle", muscle))
            })
            .collect()
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
        let law = |(muscle, bend): (usize, SheathBend)| {
            let design = &self.muscles[muscle];
            let path = design.path(model.lengths()[muscle].max(SHORTEST), model.wrap_angle(muscle))?;
            let law = CableLaw::new(&path, &design.cable, cells)?;
            if bend.is_constant() { Ok(law) } else { law.with_sheath_bend(bend.at(pose)) }
        };
        let bends = self.sheath_bends()?.into_iter().enumerate();
        bends
            .map(|(muscle, bend)| law((muscle, bend)).map_err(|error| error.of_part("muscle", muscle)))
            .collect()
    }

    /// Refuses a cable that the coarsest law, the observer's, cannot describe where its sheath bends most,
    /// with as much more friction as a machine as built may have; in the start, in which the `model` was
    /// evaluated.
    pub(super) fn check_laws(&self, model: &MuscleDynamics) -> Result<(), Error> {
        let ranges = self.ranges()?;
        for (muscle, bend) in self.sheath_bends()?.into_iter().enumerate() {
            let design = &self.muscles[muscle];
            let friction = AS_BUILT * design.cable.friction;
            let parameters = CableParameters { friction, ..design.cable };
            let check = || {
                let path = design.path(model.lengths()[muscle].max(SHORTEST), model.wrap_angle(muscle))?;
                let law = CableLaw::new(&path, &parameters, CableModel::bench().cells)?;
                let largest = if bend.is_constant() { law.sheath_bend() } else { bend.largest(&ranges) };
                let largest = largest.max(law.sheath_bend());
                law.with_sheath_bend(largest).map(drop)
            };
            check().map_err(|error| error.of_part("muscle", muscle))?;
        }
        Ok(())
    }
}
