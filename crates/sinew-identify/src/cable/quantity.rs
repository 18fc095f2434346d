//! What can be fitted: each quantity, how it is found in a model and how it moves in the search.

use sinew::predictor::CableModel;
use sinew::transmission::cable::{CablePath, Segment, Weakening};

/// A number of the model that a log can identify.
#[derive(Debug, Clone, Copy, PartialEq, Eq, Hash)]
#[non_exhaustive]
pub enum Quantity {
    /// `mu phi - ln eta` at the wraps as built, 1: friction and efficiency show only their sum. The
    /// coefficient moves.
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
    /// Gain of the far sensor, 1.
    FarGain,
    /// How much more the sheath bends at its near end than in its middle, and less at its far end: -1 to 1.
    BendTilt,
    /// `beta` of the velocity weakening, 1: how much higher friction is at rest than in sliding.
    Rise,
    /// `v_s` of the velocity weakening, m/s: the speed at which half of the rise remains.
    WeakeningSpeed,
    /// `tau` of the velocity weakening, s: its lag.
    WeakeningLag,
    /// `s` of the grease's warming, 1/J: how much drag falls per heat of friction.
    WarmingRate,
}

/// A fitted quantity with its 95 % interval.
#[derive(Debug, Clone, Copy, PartialEq)]
pub struct FittedQuantity {
    /// Which.
    pub quantity: Quantity,
    /// Its value, in the unit of its documentation.
    pub value: f64,
    /// Lower end; -infinity or 0 where the log does not determine it.
    pub low: f64,
    /// Upper end; infinity where the log does not determine it.
    pub high: f64,
}

impl Quantity {
    /// Quantities that a log of strokes with reversals identifies; not the gain of the far sensor, which
    /// pretension and friction imitate.
    pub const USUAL: [Self; 8] = [
        Self::FrictionAngle,
        Self::Drag,
        Self::Compliance,
        Self::Pretension,
        Self::NearLength,
        Self::FarLength,
        Self::BendTilt,
        Self::Rise,
    ];

    /// These, and how fast friction falls with speed: what describes a cable best. A controller is better
    /// served without, see [`INITIAL_WEAKENING`].
    pub const ALL_OF_FRICTION: [Self; 10] = [
        Self::FrictionAngle,
        Self::Drag,
        Self::Compliance,
        Self::Pretension,
        Self::NearLength,
        Self::FarLength,
        Self::BendTilt,
        Self::Rise,
        Self::WeakeningSpeed,
        Self::WeakeningLag,
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
            Self::BendTilt => "bend_tilt",
            Self::Rise => "friction_rise",
            Self::WeakeningSpeed => "weakening_speed_m_per_s",
            Self::WeakeningLag => "weakening_lag_s",
            Self::WarmingRate => "warming_rate_per_j",
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
            Self::BendTilt => tilt(&model.path),
            Self::Rise => model.parameters.weakening.map_or(0.0, |weakening| weakening.rise),
            Self::WeakeningSpeed => model.parameters.weakening.unwrap_or(INITIAL_WEAKENING).speed,
            Self::WeakeningLag => model.parameters.weakening.unwrap_or(INITIAL_WEAKENING).lag,
            Self::WarmingRate => model.warming.map_or(f64::NAN, |warming| warming.rate),
        }
    }

    /// Where a search begins: inside of the domain, because at its edge a difference has one side.
    pub(super) fn first(self, model: &CableModel) -> f64 {
        match self {
            Self::Pretension => self.of(model).max(0.1),
            Self::Rise => self.of(model).max(INITIAL_WEAKENING.rise),
            _ => self.of(model),
        }
    }

    /// Sets it; `None` where the model cannot have that value.
    pub(super) fn set(self, model: &mut CableModel, value: f64) -> Option<()> {
        match self {
            Self::FrictionAngle => {
                // The efficiency keeps its fraction: only the sum is identified.
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
            Self::BendTilt => model.path = tilted(&model.path, value)?,
            Self::Rise => weakening(model).rise = value,
            Self::WeakeningSpeed => weakening(model).speed = value,
            Self::WeakeningLag => weakening(model).lag = value,
            Self::WarmingRate => model.warming.as_mut()?.rate = value,
        }
        Some(())
    }

    /// Newtons stay newtons, everything else is positive and moves by its logarithm.
    pub(super) fn to_search(self, value: f64) -> f64 {
        self.linear().map_or_else(|| value.max(1e-300).ln(), |scale| value / scale)
    }

    /// The inverse of [`to_search`](Self::to_search).
    pub(super) fn physical_value(self, theta: f64) -> f64 {
        let value = self.linear().map_or_else(|| theta.exp(), |scale| theta * scale);
        match self {
            // A search that reaches the edge of the domain continues along it.
            Self::Pretension | Self::Rise => value.max(0.0),
            Self::BendTilt => value.clamp(-1.0, 1.0),
            // Slower than creep or faster than any stroke it is no weakening.
            Self::WeakeningSpeed => value.clamp(1e-4, 0.3),
            Self::WeakeningLag => value.clamp(0.005, 2.0),
            Self::WarmingRate => value.min(1.0),
            _ => value,
        }
    }

    /// The change that corresponds to a factor of e; `None` for what moves by its logarithm.
    fn linear(self) -> Option<f64> {
        match self {
            Self::Pretension => Some(20.0),
            Self::BendTilt | Self::Rise => Some(1.0),
            _ => None,
        }
    }
}

/// Velocity weakening from which a search starts: orders of magnitude of greased contacts, a factor of three
/// and more away from those of the twin. For a controller the rise alone is fitted: with speed and lag free
/// as well, the arm's largest tracking errors grew by a third.
pub const INITIAL_WEAKENING: Weakening = Weakening::rational(0.05, 0.01, 0.015);

/// The weakening of a model, which it is given where it has none.
fn weakening(model: &mut CableModel) -> &mut Weakening {
    model.parameters.weakening.get_or_insert(Weakening { rise: 0.0, ..INITIAL_WEAKENING })
}

/// Tilt of the first sheath, as [`tilted`] writes it.
fn tilt(path: &CablePath) -> f64 {
    let sheath = path.segments().iter().find_map(|segment| match segment {
        Segment::Sheath { curvature, .. } => Some(curvature),
        _ => None,
    });
    match sheath.map(Vec::as_slice) {
        Some([near, middle, _]) => near / middle - 1.0,
        _ => 0.0,
    }
}

/// The path with its first sheath bent by `1 + tilt`, 1 and `1 - tilt` in its thirds.
fn tilted(path: &CablePath, tilt: f64) -> Option<CablePath> {
    let mut segments = path.segments().to_vec();
    let sheath = segments.iter_mut().find_map(|segment| match segment {
        Segment::Sheath { curvature, .. } => Some(curvature),
        _ => None,
    })?;
    *sheath = vec![1.0 + tilt, 1.0, 1.0 - tilt];
    CablePath::new(segments).ok()
}

fn free_length(segment: Option<&Segment>) -> f64 {
    match segment {
        Some(Segment::Free { length }) => *length,
        _ => f64::NAN,
    }
}

fn with_free_length(path: &CablePath, place: usize, value: f64) -> Option<CablePath> {
    let mut segments = path.segments().to_vec();
    if let Some(Segment::Free { length }) = segments.get_mut(place) {
        *length = value;
    }
    CablePath::new(segments).ok()
}
