use super::anchor_motion::AnchorMotion;
use super::cable_states::{CableStateSource, CableStates};
use super::fault_detector::FaultDetector;
use super::gains::{ArmGains, MuscleGains};
use super::iterative_learning::IterativeLearning;
use super::tension_following::{CableEstimate, winch_speed};
use super::winch::{MuscleReference, WinchController};
use crate::Error;
use crate::control::compensation::Compensation;
use crate::control::stretch::{FarEndReference, VANISHING_SPEED};
use crate::drive::DriveCommand;
use crate::error::check_length;
use crate::predictor::CableSample;
use crate::transmission::cable::BothDirections;
use alloc::vec;
use alloc::vec::Vec;

/// Quantity that is commanded to the drives to obtain the desired tensions at the anchors.
#[derive(Debug, Clone)]
pub enum ActuationMode {
    /// Speeds of the winches, from the stretch of the cables at the desired tensions; the estimated stretch
    /// is from this source.
    WinchSpeed(CableStateSource),
    /// Tensions at the drives' outlets, each by its compensation of friction (8), as in `yuan2023`:
    /// `[muscles]`.
    DriveTension(Vec<Compensation>),
}

impl ActuationMode {
    /// Source of the far tensions that the observers of the joints use.
    pub(super) fn cable_state_source(&self) -> CableStateSource {
        match self {
            Self::WinchSpeed(source) => *source,
            Self::DriveTension(_) => CableStateSource::Observer,
        }
    }
}

/// From desired tensions and motions of the anchors to the commands of the drives.
#[derive(Debug, Clone)]
pub(super) struct Actuation {
    mode: ActuationMode,
    winches: Vec<WinchController>,
    learning: Option<IterativeLearning>,
    sliding: Vec<BothDirections>,
    /// `e_+` and `e_-` of every cable, m: `[muscles]`.
    steady_stretch: Vec<[f64; 2]>,
    /// Commands for the drives: `[muscles]`.
    pub(super) drives: Vec<DriveCommand>,
    /// Commanded speed of every winch, m/s; NaN where its drive was given a tension. `[muscles]`
    pub(super) winch_speed: Vec<f64>,
}

/// State of the controller from which commands are computed, `[muscles]` each.
#[derive(Debug)]
pub(super) struct ActuationInputs<'a> {
    /// `F_d`, N.
    pub(super) tension: &'a [f64],
    pub(super) anchors: &'a AnchorMotion,
    pub(super) cables: &'a CableStates,
    /// Lengths of the muscles, m.
    pub(super) lengths: &'a [f64],
    /// For the accepted measurements.
    pub(super) faults: &'a FaultDetector,
    /// See [`PreviewedReference::repeat_time`](super::PreviewedReference::repeat_time).
    pub(super) repeat_time: Option<f64>,
    /// Whether the reference is at rest and the arm near it.
    pub(super) at_rest: bool,
    /// Integral terms of tensions that are followed wherever the joints go: `[muscles]`; none where the joints are
    /// followed.
    pub(super) tension_alone: Option<&'a [f64]>,
}

impl Actuation {
    /// # Errors
    /// [`Error::WrongLength`] for compensations of another number than muscles.
    pub(super) fn new(muscles: usize, mode: ActuationMode) -> Result<Self, Error> {
        if let ActuationMode::DriveTension(list) = &mode {
            check_length("compensations", list.len(), muscles)?;
        }
        Ok(Self {
            mode,
            winches: vec![WinchController::default(); muscles],
            learning: None,
            sliding: vec![BothDirections::default(); muscles],
            steady_stretch: vec![[0.0; 2]; muscles],
            drives: vec![DriveCommand::Off; muscles],
            winch_speed: vec![0.0; muscles],
        })
    }

    /// Adds iterative learning over repeats of this duration, s.
    pub(super) fn set_learning(&mut self, duration: f64) -> Result<(), Error> {
        self.learning = Some(IterativeLearning::new(self.drives.len(), duration)?);
        Ok(())
    }

    /// Whether every anchor's position error is within the dead zone at rest of its winch.
    pub(super) fn is_within_tolerance(&self, anchors: &AnchorMotion) -> bool {
        self.winches.iter().zip(&anchors.error).all(|(winch, error)| winch.is_within_tolerance(*error))
    }

    /// Commands of the next `h` s.
    pub(super) fn command(
        &mut self,
        h: f64,
        gains: &ArmGains,
        inputs: &ActuationInputs<'_>,
    ) -> Result<(), Error> {
        let ActuationInputs { anchors, cables, .. } = inputs;
        if let ActuationMode::WinchSpeed(_) = self.mode {
            self.evaluate_sliding(inputs)?;
        }
        let mut learning = self.learning.as_mut().zip(inputs.repeat_time).map(|(learning, time)| {
            learning.advance(time);
            learning
        });
        for (k, drive) in self.drives.iter_mut().enumerate() {
            match &mut self.mode {
                ActuationMode::WinchSpeed(_) => {
                    let reference = MuscleReference {
                        velocity: anchors.reference[k],
                        previewed_velocity: anchors.previewed[k],
                        estimated_velocity: anchors.estimated[k],
                        error: anchors.error[k],
                        learned: learning.as_ref().map_or(0.0, |learning| learning.output[k]),
                        tension_in: cables.tension_in[k],
                        rest_stretch: inputs.at_rest.then_some(cables.stretch[k]),
                    };
                    let (winch, muscle) = (&mut self.winches[k], &gains.muscles[k]);
                    let speed = if let Some(integral) = inputs.tension_alone {
                        let estimate = CableEstimate {
                            tension_out: cables.tension_out[k],
                            stretch: cables.stretch[k],
                            velocity: anchors.estimated[k],
                            integral: integral[k],
                        };
                        winch_speed(inputs.tension[k], self.steady_stretch[k], &estimate, muscle)
                    } else {
                        let stretch =
                            winch.desired_stretch(h, self.steady_stretch[k], &reference, gains, muscle);
                        winch.speed(&reference, stretch, cables.stretch[k], cables.compliance[k], muscle)
                    };
                    if let Some(learning) = &mut learning {
                        learning.record(k, winch.feedback);
                    }
                    let target = if inputs.at_rest && winch.stands { 0.0 } else { speed };
                    // A drive cannot follow a faster change; what it would lack is not its fault.
                    let most = h * muscle.max_winch_acceleration;
                    self.winch_speed[k] += (target - self.winch_speed[k]).clamp(-most, most);
                    *drive = DriveCommand::Velocity(self.winch_speed[k]);
                }
                ActuationMode::DriveTension(compensations) => {
                    let reference = FarEndReference {
                        tension_out: inputs.tension[k],
                        velocity: anchors.reference[k],
                        previewed_velocity: anchors.previewed[k],
                    };
                    let sample = CableSample {
                        motor: inputs.faults.motor[k],
                        anchor: -inputs.lengths[k],
                        tension_in: inputs.faults.tension[k],
                    };
                    self.winch_speed[k] = f64::NAN;
                    *drive = compensations[k].step(h, &reference, &sample)?.command;
                }
            }
        }
        Ok(())
    }

    /// `e_+` and `e_-` of every cable at its desired tension. Where the anchor moves the other way, without drag.
    fn evaluate_sliding(&mut self, inputs: &ActuationInputs<'_>) -> Result<(), Error> {
        let ActuationInputs { anchors, cables, .. } = inputs;
        let followed = inputs.tension_alone.is_some();
        let velocity = if followed { &anchors.estimated } else { &anchors.reference };
        for (k, sliding) in self.sliding.iter_mut().enumerate() {
            let velocity = velocity[k];
            *sliding = BothDirections {
                tension_out: inputs.tension[k],
                velocity: [
                    if velocity > 0.0 { velocity } else { VANISHING_SPEED },
                    if velocity < 0.0 { velocity } else { -VANISHING_SPEED },
                ],
                slip: anchors.slip[k],
                drag_factor: cables.drag_factor[k],
            };
        }
        cables.stretch_in_both_directions(&self.sliding, &mut self.steady_stretch)
    }

    /// All winches stand, and their laws begin anew.
    pub(super) fn restart(&mut self) {
        self.winches.fill(WinchController::default());
        self.winch_speed.fill(0.0);
        self.drives.fill(DriveCommand::Velocity(0.0));
    }

    /// Decelerates all winches to rest.
    pub(super) fn brake(&mut self, h: f64, gains: &[MuscleGains]) {
        let winches = self.winch_speed.iter_mut().zip(&mut self.drives);
        for ((winch_speed, drive), gains) in winches.zip(gains) {
            let speed = if winch_speed.is_finite() { *winch_speed } else { 0.0 };
            *winch_speed = speed - speed.clamp(-h * gains.stop_deceleration, h * gains.stop_deceleration);
            *drive = DriveCommand::Velocity(*winch_speed);
        }
    }
}
