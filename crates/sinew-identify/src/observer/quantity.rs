//! What can be fitted: each quantity, how it is found in a model and how it moves in the search.

use sinew::predictor::CableModel;
use sinew::transmission::cable::{Path, Segment};

/// A number of the model that a log can tell.
#[derive(Debug, Clone, Copy, PartialEq, Eq, Hash)]
#[non_exhaustive]
pub enum Quantity {
    /// `mu phi - ln eta` at the wraps as built, 1: friction and efficiency show only their sum. The coefficient moves.
    FrictionAngle,
    /// Grease drag over all sheaths, N s/m.
    Drag,
    /// `rho`, 1/N.
    Compliance,
    /// `T_0`, N.
    Pretension,
    /// Free length at the drive, m: what the near tension climbs on when the motor turns.
    NearLength,
    /// Free length at the anchor, m.
    FarLength,
    /// What the far sensor reads of a newton, 1.
    FarGain,
}

/// A fitted quantity with its 95 % interval.
#[derive(Debug, Clone, Copy, PartialEq)]
pub struct FittedQuantity {
    /// Which.
    pub quantity: Quantity,
    /// Its value, in the unit of its documentation.
    pub value: f64,
    /// Lower end; -infinity or 0 where the log does not tell.
    pub low: f64,
    /// Upper end; infinity where the log does not tell.
    pub high: f64,
}

impl Quantity {
    /// All that the tables of a bench can tell; not the gain of the far sensor, which a friction angle imitates.
    pub const USUAL: [Self; 6] = [
        Self::FrictionAngle,
        Self::Drag,
        Self::Compliance,
        Self::Pretension,
        Self::NearLength,
        Self::FarLength,
    ];

    /// Name with unit, for reports.
    #[must_use]
    pub fn name(self) -> &'static str {
        match self {
            Self::FrictionAngle => "friction_angle",
            Self::Drag => "drag_n_s_per_m",
            Self::Compliance => "compliance_per_n",
            Self::Pretension => "pretension_n",
            Self::NearLength => "near_length_m",
            Self::FarLength => "far_length_m",
            Self::FarGain => "far_gain",
        }
    }

    /// Its value in a model; NaN where the model has no such thing.
    #[must_use]
    pub fn of(self, model: &CableModel) -> f64 {
        match self {
            Self::FrictionAngle => model.law().map_or(f64::NAN, |law| law.friction_angle()),
            Self::Drag => model.parameters.drag,
            Self::Compliance => model.parameters.compliance,
            Self::Pretension => model.parameters.pretension,
            Self::NearLength => free_length(model.path.segments().first()),
            Self::FarLength => free_length(model.path.segments().last()),
            Self::FarGain => model.far_gain,
        }
    }

    /// Sets it; `None` where the model cannot have that value.
    pub(super) fn set(self, model: &mut CableModel, value: f64) -> Option<()> {
        match self {
            Self::FrictionAngle => {
                // The efficiency keeps its share: only the sum is told.
                let loss = -model.parameters.efficiency.ln();
                let angle = model.path.angle();
                if value < loss || angle <= 0.0 {
                    return None;
                }
                model.parameters.friction = (value - loss) / angle;
            }
            Self::Drag => model.parameters.drag = value,
            Self::Compliance => model.parameters.compliance = value,
            Self::Pretension => model.parameters.pretension = value,
            Self::NearLength => model.path = with_free_length(&model.path, 0, value)?,
            Self::FarLength => {
                let last = model.path.segments().len() - 1;
                model.path = with_free_length(&model.path, last, value)?;
            }
            Self::FarGain => model.far_gain = value,
        }
        Some(())
    }

    /// Newtons stay newtons, everything else is positive and moves by its logarithm.
    pub(super) fn inward(self, value: f64) -> f64 {
        if self == Self::Pretension { value / PRETENSION_SCALE } else { value.max(1e-300).ln() }
    }

    /// The inverse of [`inward`](Self::inward).
    pub(super) fn outward(self, theta: f64) -> f64 {
        if self == Self::Pretension { theta * PRETENSION_SCALE } else { theta.exp() }
    }
}

/// A step of 1 in the search is as bold for the pretension as for a logarithm.
const PRETENSION_SCALE: f64 = 20.0;

fn free_length(segment: Option<&Segment>) -> f64 {
    match segment {
        Some(Segment::Free { length }) => *length,
        _ => f64::NAN,
    }
}

fn with_free_length(path: &Path, place: usize, value: f64) -> Option<Path> {
    let mut segments = path.segments().to_vec();
    if let Some(Segment::Free { length }) = segments.get_mut(place) {
        *length = value;
    }
    Path::new(segments).ok()
}
