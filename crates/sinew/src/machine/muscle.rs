use crate::Error;
use crate::drive::DriveParameters;
use crate::error::{finite, non_negative, positive, within};
use crate::predictor::CableModel;
use crate::transmission::cable::{CableParameters, CablePath, Segment};
use alloc::vec;
use alloc::vec::Vec;

/// What a body's description does not say about a muscle: its sheath, cable and drive.
#[derive(Debug, Clone, PartialEq)]
pub struct MuscleDesign {
    /// Cable between winch and sheath, m, > 0.
    pub near: f64,
    /// Length of the sheath, m, > 0.
    pub sheath: f64,
    /// Sum of the magnitudes of its bends in the machine's start, rad, >= 0.
    pub bend: f64,
    /// Change of its bend with every independent joint, rad/rad or rad/m: `[joints]`, or empty where it
    /// passes none; see [`SheathBend`](crate::transmission::SheathBend).
    pub bend_by_joint: Vec<f64>,
    /// Friction and elasticity of the cable.
    pub cable: CableParameters,
    /// Its drive, with load cell and encoder.
    pub drive: DriveParameters,
    /// Model of the cable that was identified before; none where it is identified on the bench.
    pub model: Option<CableModel>,
    /// Smallest and largest tension at the anchor, N; none where it follows from cable and drive.
    pub tension: [Option<f64>; 2],
}

/// Sheath and cable of a muscle that nothing is known of, m and rad; assumed.
const NEAR: f64 = 0.05;
const SHEATH: f64 = 0.5;
const BEND: f64 = core::f64::consts::FRAC_PI_2;

/// Largest wrap of a muscle at its joints, rad.
const MAX_WRAP: f64 = 4.0;

/// Sheath of the bench, to which its drag belongs, m.
const BENCH_SHEATH: f64 = 0.806;

impl MuscleDesign {
    /// The bench's cable in a sheath of this length, m, and bend, rad (0.5 m and a quarter turn where none is
    /// given; assumed), at the paper's drive.
    ///
    /// Friction and compliance are the bench's; the drag is proportional to the length of the sheath. The
    /// drive is [`DriveParameters::mc_am`]: 81 kg reflected to the cable, 287 N continuous; at 250 N its peak
    /// current accelerates by 9.7 m/s^2, and its reference is limited to 5. Sensors are sampled at the start
    /// of a step and available at its end: that is their delay.
    #[must_use]
    pub fn in_sheath(sheath: Option<[f64; 2]>) -> Self {
        let [sheath, bend] = sheath.unwrap_or([SHEATH, BEND]);
        let bench = CableParameters::bench();
        Self {
            near: NEAR,
            sheath,
            bend,
            bend_by_joint: vec![],
            cable: CableParameters { drag: bench.drag * sheath / BENCH_SHEATH, ..bench },
            drive: DriveParameters { delay_ms: 0.0, ..DriveParameters::mc_am() },
            model: None,
            tension: [None; 2],
        }
    }

    /// Checks every number.
    ///
    /// # Errors
    /// [`Error::OutOfDomain`] names the number outside its domain.
    pub fn validate(&self) -> Result<(), Error> {
        positive("near_length", self.near)?;
        positive("sheath_length", self.sheath)?;
        non_negative("sheath_bend", self.bend)?;
        self.bend_by_joint.iter().try_for_each(|slope| finite("bend_by_joint", *slope).map(drop))?;
        self.cable.validate()?;
        self.drive.validate()?;
        if let Some(model) = &self.model {
            model.law()?;
        }
        let [least, most] = self.tension;
        least.map_or(Ok(0.0), |least| non_negative("minimum tension", least))?;
        if let Some(most) = most {
            let above = most.is_finite() && most > least.unwrap_or(0.0);
            within("largest tension", "a finite number above the least", most, above)?;
        }
        Ok(())
    }

    /// The cable's path with this free length at the anchor, m, and this wrap at the joint, rad, its last
    /// pulley.
    ///
    /// Wraps beyond 4 rad count as 4, as in plant and controller: the friction of one node has a limit.
    ///
    /// # Errors
    /// As [`CablePath::new`].
    pub fn path(&self, free: f64, wrap: f64) -> Result<CablePath, Error> {
        CablePath::new(vec![
            Segment::Free { length: self.near },
            Segment::Sheath { length: self.sheath, bend: self.bend, curvature: vec![] },
            Segment::Pulley { wrap: wrap.min(MAX_WRAP) },
            Segment::Free { length: free },
        ])
    }
}
