use crate::Error;
use crate::error::{non_negative, within};
use serde::{Deserialize, Serialize};

/// Manufacturing tolerances: bounds of the difference between a machine as built and its design.
///
/// Every number is uniform within its bounds. Cables scatter by their own statistics, those of the bench.
#[derive(Debug, Clone, Copy, PartialEq, Serialize, Deserialize)]
#[serde(deny_unknown_fields, default)]
pub struct Tolerances {
    /// Relative, of every mass and, independently, of every inertia.
    pub mass: f64,
    /// Of every coordinate of every site of a tendon, m; none: as
    /// [`Machine::attachment_tolerance`](super::Machine::attachment_tolerance).
    #[serde(rename = "attachment_m")]
    pub attachment: Option<f64>,
    /// Relative, of the load cells' gain.
    pub gain: f64,
    /// Relative, of the losses of the gears of muscles without a load cell, whose tension the current tells;
    /// with one the gear is as designed. From a random stream of its own.
    pub gear_losses: f64,
    /// Relative, of the changes of sheaths' bends with the joints.
    #[serde(rename = "bend_by_joint")]
    pub bend: f64,
    /// Of the joint encoders' zero, rad.
    #[serde(rename = "zero_rad")]
    pub zero: f64,
    /// The same of slides, m.
    #[serde(rename = "zero_m")]
    pub zero_slide: f64,
    /// Of every coordinate of the frame of every joint, m. From here on drawn from random streams of their
    /// own: without them a specimen is what it was.
    #[serde(rename = "link_m")]
    pub link: f64,
    /// Of both tilts of the axis of every joint, rad.
    #[serde(rename = "axis_rad")]
    pub axis: f64,
    /// Of every coordinate of every centre of mass, m.
    #[serde(rename = "center_of_mass_m")]
    pub center_of_mass: f64,
    /// Of the radius of every surface that cables wrap around, m, held above half of the design's.
    #[serde(rename = "wrap_radius_m")]
    pub wrap_radius: f64,
    /// Relative, of the radius of every winch.
    #[serde(rename = "winch_radius")]
    pub winch: f64,
    /// Amplitude of the eccentricity of the encoders of hinges, rad.
    #[serde(rename = "eccentricity_rad")]
    pub eccentricity: f64,
    /// Bend of every link at its joint by the moment of gravity, from 0 to this, rad/Nm.
    #[serde(rename = "flex_rad_per_nm")]
    pub flex: f64,
    /// Unknown mass at the end point, from 0 to this, kg.
    #[serde(rename = "payload_kg")]
    pub payload: f64,
}

/// Workshops whose tolerances have a name.
#[derive(Debug, Clone, Copy, PartialEq, Eq)]
pub enum Workshop {
    /// Frames of joints within 0.5 mm and 1 mrad.
    Careful,
    /// Frames of joints within 2 mm and 8 mrad, encoders aligned within 10 mrad.
    Rough,
}

impl Workshop {
    /// All, with their names.
    pub const WORDS: [(Workshop, &'static str); 2] = [(Self::Careful, "careful"), (Self::Rough, "rough")];
}

impl Default for Tolerances {
    /// 10 %, 1 mm, 0.5 %, 20 % of gears' losses and of bends, 1 mrad, 0.1 mm: assumed for careful
    /// manufacturing.
    fn default() -> Self {
        Self {
            mass: 0.1,
            attachment: None,
            gain: 5e-3,
            gear_losses: 0.2,
            bend: 0.2,
            zero: 1e-3,
            zero_slide: 1e-4,
            link: 0.0,
            axis: 0.0,
            center_of_mass: 0.0,
            wrap_radius: 0.0,
            winch: 0.0,
            eccentricity: 0.0,
            flex: 0.0,
            payload: 0.0,
        }
    }
}

impl Tolerances {
    /// Those of a workshop for a machine whose lengths are `size` times those of an arm, masses and load
    /// cells as here. Assumed from what others report of self-made arms.
    #[must_use]
    pub fn of(self, workshop: Workshop, size: f64) -> Self {
        let careful = Self {
            zero: 1e-3,
            zero_slide: 1e-4,
            link: 5e-4 * size,
            axis: 1e-3,
            center_of_mass: 5e-3 * size,
            wrap_radius: 3e-4 * size,
            winch: 5e-3,
            eccentricity: 5e-4,
            flex: 1e-4,
            ..self
        };
        match workshop {
            Workshop::Careful => careful,
            Workshop::Rough => Self {
                zero: 1e-2,
                zero_slide: 1e-3 * size,
                link: 2e-3 * size,
                axis: 8e-3,
                center_of_mass: 1e-2 * size,
                wrap_radius: 5e-4 * size,
                winch: 1e-2,
                eccentricity: 1e-3,
                ..careful
            },
        }
    }

    /// Checks every number.
    ///
    /// # Errors
    /// [`Error::OutOfDomain`] names the number outside its domain.
    pub fn validate(&self) -> Result<(), Error> {
        let fraction = (0.0..1.0).contains(&self.mass);
        within("mass tolerance", "a number in [0, 1)", self.mass, fraction)?;
        let fraction = (0.0..1.0).contains(&self.gain);
        within("gain tolerance", "a number in [0, 1)", self.gain, fraction)?;
        let fraction = (0.0..1.0).contains(&self.gear_losses);
        within("tolerance of the gears' losses", "a number in [0, 1)", self.gear_losses, fraction)?;
        let fraction = (0.0..1.0).contains(&self.bend);
        within("bend tolerance", "a number in [0, 1)", self.bend, fraction)?;
        self.attachment.map_or(Ok(0.0), |bound| non_negative("attachment tolerance", bound))?;
        non_negative("zero tolerance", self.zero)?;
        non_negative("zero tolerance of slides", self.zero_slide)?;
        let fraction = (0.0..0.5).contains(&self.winch);
        within("tolerance of the winches' radius", "a number in [0, 0.5)", self.winch, fraction)?;
        [
            ("link tolerance", self.link),
            ("axis tolerance", self.axis),
            ("tolerance of the centres of mass", self.center_of_mass),
            ("tolerance of the wraps' radius", self.wrap_radius),
            ("eccentricity of the encoders", self.eccentricity),
            ("flex", self.flex),
            ("unknown payload", self.payload),
        ]
        .into_iter()
        .try_for_each(|(name, bound)| non_negative(name, bound).map(drop))
    }
}
