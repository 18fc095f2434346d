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
    /// Integral terms of tensions that are followed wherever the joints go: `[muscles]`; none where the
    /// joints are followed.
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

    /// `e_+` and `e_-` of every cable at its desired tension. Where the anchor moves the other way, without
    /// drag.
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

#[cfg(test)]
mod tests {
    use super::*;
    use crate::control::compensation::ObserverCompensation;
    use crate::predictor::CableModel;
    use alloc::boxed::Box;

    const H: f64 = 1e-3;

    /// What two muscles see in one cycle.
    struct Scene {
        gains: ArmGains,
        anchors: AnchorMotion,
        cables: CableStates,
        faults: FaultDetector,
        lengths: [f64; 2],
        at_rest: bool,
        alone: Option<[f64; 2]>,
    }

    impl Scene {
        /// Both cables in the middle of their dead band at 60 N, nothing moves.
        fn new() -> Self {
            let gains = ArmGains::for_tests(2, 1);
            let models = [CableModel::bench(), CableModel::bench()];
            let mut cables = CableStates::new(&models, CableStateSource::Observer, 2).unwrap();
            let [toward, away] = [1e-9, -1e-9].map(|v| cables.law(0).unwrap().steady(60.0, v, 1.0).unwrap());
            cables.stretch.fill(0.5 * (toward.stretch + away.stretch));
            (cables.tension_in, cables.tension_out) = (vec![60.0; 2], vec![60.0; 2]);
            let mut faults = FaultDetector::new(&[25e3; 2], &gains, 1.0);
            (faults.motor, faults.tension) = (vec![0.5; 2], vec![60.0; 2]);
            let anchors = AnchorMotion::new(2);
            Self { gains, anchors, cables, faults, lengths: [0.3; 2], at_rest: false, alone: None }
        }

        fn command(&self, actuation: &mut Actuation) {
            let inputs = ActuationInputs {
                tension: &[60.0; 2],
                anchors: &self.anchors,
                cables: &self.cables,
                lengths: &self.lengths,
                faults: &self.faults,
                repeat_time: None,
                at_rest: self.at_rest,
                tension_alone: self.alone.as_ref().map(|integral| &integral[..]),
            };
            actuation.command(H, &self.gains, &inputs).unwrap();
        }
    }

    fn winches() -> Actuation {
        Actuation::new(2, ActuationMode::WinchSpeed(CableStateSource::Observer)).unwrap()
    }

    fn commanded(actuation: &Actuation) -> Vec<f64> {
        let speed = |drive: &DriveCommand| match drive {
            DriveCommand::Velocity(speed) => *speed,
            _ => f64::NAN,
        };
        actuation.drives.iter().map(speed).collect()
    }

    #[test]
    fn a_winch_reaches_its_speed_with_no_more_than_its_acceleration_in_either_direction() {
        let (mut scene, mut actuation) = (Scene::new(), winches());
        let muscle = scene.gains.muscles[0];
        let (most, step) = (muscle.max_winch_speed, H * muscle.max_winch_acceleration);
        // A metre asks for more than the largest speed.
        let mut expected = [0.0, 0.0];
        for signs in [[1.0, -1.0], [-1.0, 1.0]] {
            scene.anchors.error = signs.to_vec();
            for _ in 0..100 {
                scene.command(&mut actuation);
                for (k, speed) in commanded(&actuation).into_iter().enumerate() {
                    expected[k] = (expected[k] + signs[k] * step).clamp(-most, most);
                    assert!((speed - expected[k]).abs() < 1e-12, "{speed} {}", expected[k]);
                    assert!((actuation.winch_speed[k] - speed).abs() < 1e-15);
                }
            }
        }
    }

    #[test]
    fn at_rest_a_winch_within_its_dead_zone_comes_to_a_stop_and_one_beyond_it_moves_toward_its_reference() {
        let (mut scene, mut actuation) = (Scene::new(), winches());
        scene.command(&mut actuation);
        actuation.winch_speed.fill(0.02);
        let zone = scene.gains.muscles[0].rest_tolerance[0];
        (scene.anchors.error, scene.at_rest) = (vec![0.5 * zone, 3.0 * zone], true);
        assert!(!actuation.is_within_tolerance(&scene.anchors));
        for k in 1..=200 {
            scene.command(&mut actuation);
            let [stands, moves] = commanded(&actuation)[..] else { panic!() };
            assert!((stands - (0.02 - 5e-3 * f64::from(k)).max(0.0)).abs() < 1e-12, "{k}: {stands}");
            assert!(k < 50 || moves > 1e-4, "{k}: {moves}");
        }
        scene.anchors.error[1] = -0.5 * zone;
        assert!(actuation.is_within_tolerance(&scene.anchors));
    }

    #[test]
    fn the_stretches_of_both_directions_are_those_of_sliding_with_drag_only_where_the_anchor_goes() {
        for followed in [false, true] {
            let (mut scene, mut actuation) = (Scene::new(), winches());
            let speeds = [0.06, -0.06];
            scene.alone = followed.then_some([0.0; 2]);
            let [moving, still] = [&mut scene.anchors.reference, &mut scene.anchors.estimated];
            (if followed { still } else { moving }).copy_from_slice(&speeds);
            scene.anchors.slip = vec![0.03; 2];
            scene.cables.drag_factor = vec![1.5; 2];
            scene.command(&mut actuation);
            // Where the anchor does not go the edge of sliding is taken at 1 nm/s.
            for (k, found) in actuation.steady_stretch.iter().enumerate() {
                let law = scene.cables.law(k).unwrap();
                let stretch = |v: f64| law.sliding(60.0, v, 0.03, 1.5).unwrap().stretch;
                let [edge_toward, edge_away] = [stretch(0.0), stretch(-1e-15)];
                let expected = match k {
                    0 => [stretch(0.06), edge_away],
                    _ => [edge_toward, stretch(-0.06)],
                };
                assert!((expected[k] - [edge_toward, edge_away][k]).abs() > 5e-4, "drag is felt");
                for (found, expected) in found.iter().zip(expected) {
                    assert!((found - expected).abs() < 5e-11, "{k}: {found} {expected}");
                }
            }
        }
    }

    #[test]
    fn braking_takes_the_speed_at_its_deceleration_and_that_of_a_drive_under_tension_at_once() {
        let (scene, mut actuation) = (Scene::new(), winches());
        // 2 m/s^2 from 5 mm/s, 5 steps of 1 ms, and from -3.
        actuation.winch_speed = vec![5e-3, -3e-3];
        for k in 1..=5 {
            actuation.brake(H, &scene.gains.muscles);
            let expected = [(5e-3 - 2e-3 * f64::from(k)).max(0.0), (-3e-3 + 2e-3 * f64::from(k)).min(0.0)];
            for (found, expected) in commanded(&actuation).iter().zip(expected) {
                assert!((found - expected).abs() < 1e-15, "{k}: {found} {expected}");
            }
        }
        actuation.winch_speed = vec![f64::NAN, 1.0];
        actuation.brake(H, &scene.gains.muscles);
        assert!(commanded(&actuation)[0].abs() < 1e-15 && (commanded(&actuation)[1] - 0.998).abs() < 1e-12);
    }

    #[test]
    fn after_a_restart_all_winches_stand_and_their_laws_begin_anew() {
        let (mut scene, mut actuation) = (Scene::new(), winches());
        let mut first = Vec::new();
        for repeat in 0..2 {
            scene.anchors.error = vec![1e-4, -1e-4];
            for k in 0..50 {
                scene.command(&mut actuation);
                if repeat == 0 {
                    first.push(commanded(&actuation));
                } else {
                    assert_eq!(commanded(&actuation), first[k]);
                }
            }
            actuation.restart();
            assert!(
                commanded(&actuation).iter().chain(&actuation.winch_speed).all(|speed| speed.abs() < 1e-15)
            );
            // No dead zone until the first motion.
            scene.anchors.error = vec![1e-6, 0.0];
            assert!(!actuation.is_within_tolerance(&scene.anchors));
        }
    }

    #[test]
    fn learning_is_refused_for_repeats_without_a_duration() {
        let mut actuation = winches();
        assert!([0.0, -1.0, f64::NAN].into_iter().all(|duration| actuation.set_learning(duration).is_err()));
        assert!(actuation.learning.is_none());
        actuation.set_learning(2.0).unwrap();
        assert!(actuation.learning.is_some());
    }

    #[test]
    fn a_drives_compensation_takes_up_less_where_a_muscle_that_lengthens_draws_its_cable_out() {
        let compensation = ObserverCompensation::new(&CableModel::bench()).unwrap();
        let list = vec![Compensation::Observer(Box::new(compensation)); 2];
        let mut actuation = Actuation::new(2, ActuationMode::DriveTension(list)).unwrap();
        let mut scene = Scene::new();
        for _ in 0..20 {
            scene.lengths[0] += 1e-4;
            scene.lengths[1] -= 1e-4;
            scene.command(&mut actuation);
        }
        assert!(actuation.winch_speed.iter().all(|speed| speed.is_nan()));
        // A cable that is drawn out has more tension than one that is let go, and its winch takes up less.
        let [lengthened, shortened] = commanded(&actuation)[..] else { panic!() };
        assert!(lengthened < shortened - 0.05, "{lengthened} {shortened}");
    }
}
