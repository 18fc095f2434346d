use super::design::Machine;
use crate::Error;
use crate::muscle::MuscleDynamics;
use crate::transmission::cable::CableLaw;
use alloc::vec::Vec;

/// Free length of a cable whose muscle has none of its own, m.
const SHORTEST: f64 = 1e-3;

impl Machine {
    /// The laws of all cables as designed, at the start, each cut into `cells`: `[muscles]`.
    ///
    /// # Errors
    /// As [`CableLaw::new`] and [`MuscleDynamics::evaluate`].
    pub fn laws(&self, cells: usize) -> Result<Vec<CableLaw>, Error> {
        let mut model = MuscleDynamics::new(&self.robot)?;
        model.evaluate(&self.start)?;
        let places = model.lengths().iter().zip(model.wrap_angles());
        let law = |(design, (free, wrap)): (&super::MuscleDesign, (&f64, &f64))| {
            CableLaw::new(&design.path(free.max(SHORTEST), *wrap)?, &design.cable, cells)
        };
        self.muscles.iter().zip(places).map(law).collect()
    }
}
