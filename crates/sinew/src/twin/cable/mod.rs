//! The cable of the plant: the law of [`transmission::cable`](crate::transmission::cable) with unmodelled
//! effects.
//!
//! | effect                        | meaning                                             | default size                     |
//! |-------------------------------|-----------------------------------------------------|----------------------------------|
//! | [`UnevenCurvature`]           | curvature varies along the sheath                    | parts of 0.5 to 1.5 of the mean   |
//! | [`SheathCompliance`]          | the sheath's wall shortens under the cable's tension  | a tenth of the calibrated cable's compliance |
//! | [`DragHeat`]                  | friction warms the grease, which lowers its drag      | 4 % per kelvin, 0.5 K per watt    |
//! | [`BraidCreep`]                | recoverable creep of the braid                        | 4 % of the elastic stretch, time constant 30 s |
//! | [`SlowFriction`]              | friction is higher at creeping speed                  | a tenth at rest, half of that at 3 mm/s |
//! | [`Breakage`]                  | the cable breaks                                      | above 800 N                      |
//!
//! [`CablePlant::set_wrap`] sets a wrap that changes with a joint, [`CablePlants::set_sheath_bend`] such a
//! bend. A [`Specimen`] holds parameters and effects of one cable; [`Specimen::draw`] draws them from a seed.

mod batch;
mod effects;
mod single;
mod specimen;
mod wear;

pub use batch::CablePlants;
pub use effects::{BraidCreep, Breakage, DragHeat, Effects, SheathCompliance, SlowFriction, UnevenCurvature};
pub use single::{CablePlant, Resolution};
pub use specimen::Specimen;
pub use wear::{Broken, CableReading};
