use super::cables::{CableStateSource, Cables};
use super::fault_detector::{ArmStatus, FaultDetector, Known};
use super::gains::ArmGains;
use super::iterative_learning::IterativeLearning;
use super::joints::JointObserver;
use super::mechanics::Mechanics;
use super::winch::{MuscleReference, Winch};
use crate::Error;
use crate::body::Robot;
use crate::control::compensation::Compensation;
use crate::control::stretch::FarEndReference;
use crate::control::tension::{Distribution, Problem, Status};
use crate::drive::DriveCommand;
use crate::predictor::{CableModel, CableSample};
use crate::trajectory::Reference;
use crate::transmission::Perceptron;
use alloc::vec;
use alloc::vec::Vec;

/// What the sensors of an arm say.
#[derive(Debug, Clone, Copy, PartialEq)]
pub struct ArmMeasurement<'a> {
    /// Position of every cable by its motor's encoder, m, + toward the motor: `[muscles]`.
    pub motor: &'a [f64],
    /// Tension at every drive's outlet, N: `[muscles]`.
    pub tension: &'a [f64],
    /// Angle of every joint, rad: `[joints]`.
    pub joint: &'a [f64],
}

/// What the joints are to do now and [`PREVIEW_HORIZON`](crate::control::stretch::PREVIEW_HORIZON) later.
#[derive(Debug, Clone, Copy, PartialEq)]
pub struct PreviewedReference<'a> {
    /// Now.
    pub current: &'a Reference,
    /// Later.
    pub previewed: &'a Reference,
    /// Since a motion that is repeated began anew, s: what a repeat showed helps the next; none where nothing is repeated.
    pub repeat_time: Option<f64>,
}

/// What somebody knows of the cables who can look into them: `[muscles]` each.
#[derive(Debug, Clone, Copy, PartialEq)]
pub struct GroundTruth<'a> {
    /// Tension at every anchor, N.
    pub tension_out: &'a [f64],
    /// Elongation of every cable, m.
    pub stretch: &'a [f64],
    /// Drag of every cable, times that of its model.
    pub drag_factor: &'a [f64],
}

/// How tensions are brought to the anchors.
#[derive(Debug, Clone)]
pub enum ActuationMode {
    /// The winches follow the stretch of the wanted tensions, which is known by this.
    WinchSpeed(CableStateSource),
    /// The drives are told tensions, each through its compensation: `[muscles]`. What the paper does.
    DriveTension(Vec<Compensation>),
}

/// What the controller answers to a sample; all of it stays until the next.
#[derive(Debug, Clone, Copy)]
pub struct ArmCommand<'a> {
    /// For the drives, `[muscles]`.
    pub drives: &'a [DriveCommand],
    /// Tension wanted at every anchor, N: `[muscles]`.
    pub desired_tension: &'a [f64],
    /// What it is believed to be, N: `[muscles]`.
    pub estimated_tension: &'a [f64],
    /// Pose as believed, `[joints]`.
    pub q: &'a [f64],
    /// Whether the tensions wanted give the torque wanted.
    pub distribution: Status,
    /// Whether it follows, rests, or was stopped, and why.
    pub status: ArmStatus,
}

/// Moves an arm on cables along a reference.
#[derive(Debug, Clone)]
pub struct ArmController {
    gains: ArmGains,
    way: ActuationMode,
    mechanics: Mechanics,
    joints: JointObserver,
    cables: Cables,
    guard: FaultDetector,
    distribution: Distribution,
    winches: Vec<Winch>,
    practice: Option<IterativeLearning>,
    started: bool,
    /// Whether no disturbance has been looked for yet.
    fresh: bool,
    /// Whether the reference is at rest and the arm nearly there, and whether it is all there.
    resting: bool,
    holding: bool,
    reached: Status,
    /// `d_u`, rad/s^2.
    disturbance: Vec<f64>,
    commands: Vec<DriveCommand>,
    /// Speed that every winch was told, m/s; not a number where it was told a tension.
    told: Vec<f64>,
    // Of every joint.
    acceleration: Vec<f64>,
    torque: Vec<f64>,
    error: Vec<f64>,
    // Of every muscle.
    velocity: Vec<f64>,
    coming: Vec<f64>,
    behind: Vec<f64>,
    slip: Vec<f64>,
    now: Vec<f64>,
    wanted: Vec<f64>,
    least: Vec<f64>,
    most: Vec<f64>,
    ones: Vec<f64>,
    zeros: Vec<f64>,
}

impl ArmController {
    /// A controller that has seen nothing, from what is believed of the body and was identified of every cable.
    ///
    /// # Errors
    /// [`Error::WrongLength`] for models or compensations of another number than muscles; as [`ArmGains::validate`] and
    /// [`CableModel::law`].
    pub fn new(
        robot: &Robot,
        models: &[CableModel],
        gains: ArmGains,
        way: ActuationMode,
    ) -> Result<Self, Error> {
        let mechanics = Mechanics::new(robot);
        let (muscles, joints) = (mechanics.muscles(), mechanics.joints());
        gains.validate(joints)?;
        let knowledge = match &way {
            ActuationMode::WinchSpeed(knowledge) => *knowledge,
            ActuationMode::DriveTension(_) => CableStateSource::Observer,
        };
        let of = |name, got| {
            if got == muscles { Ok(()) } else { Err(Error::WrongLength { name, expected: muscles, got }) }
        };
        of("models", models.len())?;
        if let ActuationMode::DriveTension(list) = &way {
            of("compensations", list.len())?;
        }
        let cables = Cables::new(models, knowledge)?;
        let limits = models.iter().map(|model| Ok(gains.tension_limits(&model.law()?)));
        let limits = limits.collect::<Result<Vec<_>, Error>>()?;
        Ok(Self {
            joints: JointObserver::new(joints, &gains),
            cables,
            guard: FaultDetector::new(muscles, joints),
            distribution: Distribution::new(muscles, joints),
            winches: vec![Winch::default(); muscles],
            practice: None,
            started: false,
            fresh: true,
            resting: false,
            holding: false,
            reached: Status::Optimal,
            disturbance: vec![0.0; joints],
            commands: vec![DriveCommand::Off; muscles],
            told: vec![0.0; muscles],
            acceleration: vec![0.0; joints],
            torque: vec![0.0; joints],
            error: vec![0.0; joints],
            velocity: vec![0.0; muscles],
            coming: vec![0.0; muscles],
            behind: vec![0.0; muscles],
            slip: vec![0.0; muscles],
            now: vec![0.0; muscles],
            wanted: vec![0.0; muscles],
            least: limits.iter().map(|limit| limit[0]).collect(),
            most: limits.iter().map(|limit| limit[1]).collect(),
            ones: vec![1.0; muscles],
            zeros: vec![0.0; muscles],
            mechanics,
            gains,
            way,
        })
    }

    /// The same that learns from repeat to repeat of a motion of so many seconds.
    ///
    /// # Errors
    /// [`Error::OutOfDomain`] outside of (0, 3600].
    pub fn with_iterative_learning(mut self, duration: f64) -> Result<Self, Error> {
        self.practice = Some(IterativeLearning::new(self.told.len(), duration)?);
        Ok(self)
    }

    /// The same with a network for every cable that corrects what its observer believes of the tension at the anchor,
    /// by at most [`ResidualNetwork::LIMIT_N`](super::ResidualNetwork::LIMIT_N): `[muscles]`. Without observers it says nothing.
    ///
    /// # Errors
    /// [`Error::WrongLength`] for networks of another number than muscles, or of other inputs than
    /// [`ResidualNetwork`](super::ResidualNetwork)'s.
    pub fn with_residuals(mut self, networks: Vec<Perceptron>) -> Result<Self, Error> {
        self.cables.correct(networks)?;
        Ok(self)
    }

    /// Takes a sample, `h` seconds after the one before, and answers with what the drives are to do until the next.
    ///
    /// # Errors
    /// [`Error::WrongLength`] for another robot's; [`Error::OutOfDomain`] for what is not finite.
    pub fn step(
        &mut self,
        h: f64,
        sample: &ArmMeasurement<'_>,
        goal: &PreviewedReference<'_>,
        told: Option<&GroundTruth<'_>>,
    ) -> Result<ArmCommand<'_>, Error> {
        self.check(sample, goal)?;
        self.guard.expect(&goal.current.q);
        let known = Known {
            told: &self.told,
            near: &self.cables.tension_in,
            speed: &self.joints.v,
            wanted: &goal.current.v,
        };
        self.guard.take(h, sample, &known);
        if self.guard.stopped() {
            self.brake(h);
        } else {
            self.follow(h, goal, told)?;
        }
        Ok(ArmCommand {
            drives: &self.commands,
            desired_tension: &self.wanted,
            estimated_tension: &self.cables.tension_out,
            q: &self.joints.q,
            distribution: self.reached,
            status: self.status(),
        })
    }

    fn follow(
        &mut self,
        h: f64,
        goal: &PreviewedReference<'_>,
        told: Option<&GroundTruth<'_>>,
    ) -> Result<(), Error> {
        self.bridge(h, goal.current);
        self.mechanics.look(&self.joints.q)?;
        let seen = (&self.guard.motor[..], &self.guard.tension[..]);
        self.cables.look(h, seen, &self.mechanics, &self.wanted, told)?;
        self.observe(h)?;
        self.mechanics.toward_motor(&goal.current.v, &mut self.velocity);
        self.mechanics.toward_motor(&goal.previewed.v, &mut self.coming);
        self.mechanics.toward_motor(&self.joints.v, &mut self.now);
        let share = (h / self.gains.slip_filter_time).min(1.0);
        self.slip.iter_mut().zip(&self.now).for_each(|(slip, now)| *slip += share * (now - *slip));
        self.hold(goal);
        self.want_acceleration(goal.current);
        self.mechanics.torque(&self.joints.q, &self.joints.v, &self.acceleration, &mut self.torque)?;
        self.distribute()?;
        self.command(h, goal.repeat_time);
        Ok(())
    }

    /// Whether sample and goal are of this arm.
    fn check(&self, sample: &ArmMeasurement<'_>, goal: &PreviewedReference<'_>) -> Result<(), Error> {
        let (muscles, joints) = (self.told.len(), self.error.len());
        for (name, expected, got) in [
            ("motor", muscles, sample.motor.len()),
            ("tension", muscles, sample.tension.len()),
            ("joint", joints, sample.joint.len()),
            ("goal", joints, goal.current.q.len().min(goal.current.v.len()).min(goal.current.a.len())),
            ("coming goal", joints, goal.previewed.v.len()),
        ] {
            if got != expected {
                return Err(Error::WrongLength { name, expected, got });
            }
        }
        Ok(())
    }

    /// Whether the arm follows, rests, or was stopped, and why.
    #[must_use]
    pub fn status(&self) -> ArmStatus {
        match self.guard.status {
            ArmStatus::Following if self.holding => ArmStatus::Holding,
            status => status,
        }
    }

    /// A joint whose encoder says nothing is believed to follow its reference.
    fn bridge(&mut self, h: f64, goal: &Reference) {
        for (k, joint) in self.guard.joint.iter_mut().enumerate() {
            let believed = if self.started { self.joints.q[k] + h * goal.v[k] } else { goal.q[k] };
            if !joint.is_finite() {
                *joint = believed;
            }
        }
        if !self.started {
            self.started = true;
            self.joints.start(&self.guard.joint);
        }
    }

    /// What the joints do, and what moves them beside the tensions that are known.
    fn observe(&mut self, h: f64) -> Result<(), Error> {
        let Self { mechanics, joints, cables, acceleration, .. } = self;
        mechanics.acceleration(&joints.q, &joints.v, &cables.tension_out, acceleration)?;
        if core::mem::take(&mut self.fresh) {
            // At rest: what tensions do not hold is held, or hangs there, unknown.
            joints.disturbance.iter_mut().zip(&*acceleration).for_each(|(d, a)| *d = -a);
            let believed = self.gains.disturbance_bandwidth.iter().zip(&joints.disturbance);
            self.disturbance
                .iter_mut()
                .zip(believed)
                .for_each(|(used, (w, d))| *used = if *w > 0.0 { *d } else { 0.0 });
        }
        joints.step(h, &self.guard.joint, acceleration);
        if self.resting {
            return Ok(());
        }
        let blind = matches!(self.way, ActuationMode::WinchSpeed(CableStateSource::Encoders));
        for (k, used) in self.disturbance.iter_mut().enumerate() {
            let w = self.gains.bandwidth[k];
            // Who knows no tension integrates the error of the last millisecond.
            *used += if blind {
                -h * BLIND_INTEGRAL * w * w * w * self.error[k]
            } else {
                h * self.gains.disturbance_bandwidth[k] * (self.joints.disturbance[k] - *used)
            };
        }
        Ok(())
    }

    /// At rest, and where it is to be: winches stand, nothing hunts.
    fn hold(&mut self, goal: &PreviewedReference<'_>) {
        for (error, (wanted, q)) in self.error.iter_mut().zip(goal.current.q.iter().zip(&self.joints.q)) {
            *error = wanted - q;
        }
        self.mechanics.toward_motor(&self.error, &mut self.behind);
        self.guard.watch(&self.error);
        let moving = goal.current.v.iter().chain(&goal.previewed.v).any(|v| v.abs() > 1e-9);
        let worst = self.behind.iter().fold(0.0_f64, |worst, d| worst.max(d.abs()));
        let speed = self.joints.v.iter().fold(0.0_f64, |worst, v| worst.max(v.abs()));
        let [near, far] = AT_REST;
        self.resting = !moving && if self.resting { worst < far } else { worst < near && speed < CALM };
        let content = || self.winches.iter().zip(&self.behind).all(|(winch, d)| winch.is_content(*d));
        self.holding = self.resting && content();
    }

    /// `q''_r + w^2 (q_r - q^) + 2 zeta w (q'_r - q'^) - d_u`.
    fn want_acceleration(&mut self, goal: &Reference) {
        for (k, wanted) in self.acceleration.iter_mut().enumerate() {
            let w = self.gains.bandwidth[k];
            if self.resting {
                *wanted = -self.disturbance[k];
                continue;
            }
            *wanted = goal.a[k]
                + w * w * self.error[k]
                + 2.0 * self.gains.damping * w * (goal.v[k] - self.joints.v[k])
                - self.disturbance[k];
        }
    }

    /// `min |F|^2`, `R^T F = tau`, `F_min <= F <= F_max`.
    fn distribute(&mut self) -> Result<(), Error> {
        let solution = self.distribution.solve(&Problem {
            moment_arms: &self.mechanics.arms,
            torque: &self.torque,
            minimum: &self.least,
            maximum: &self.most,
            reference: &self.zeros,
            weight: &self.ones,
        })?;
        self.wanted.copy_from_slice(solution.tension);
        self.reached = solution.status;
        Ok(())
    }

    fn command(&mut self, h: f64, since: Option<f64>) {
        let mut practice = self.practice.as_mut().zip(since).map(|(practice, since)| {
            practice.go(since);
            practice
        });
        let lengths = self.mechanics.lengths();
        for (k, command) in self.commands.iter_mut().enumerate() {
            let (velocity, coming) = (self.velocity[k], self.coming[k]);
            let pull = MuscleReference {
                tension: self.wanted[k],
                velocity,
                coming,
                slip: self.slip[k],
                moving: self.now[k],
                behind: self.behind[k],
                known: practice.as_ref().map_or(0.0, |practice| practice.now[k]),
                resting: self.resting.then_some(self.cables.stretch[k]),
            };
            *command = match &mut self.way {
                ActuationMode::WinchSpeed(_) => {
                    let stretch = self.cables.wanted_stretch(h, k, &mut self.winches[k], &pull, &self.gains);
                    let speed = self.winches[k].speed(&pull, stretch, self.cables.stretch[k], &self.gains);
                    if let Some(practice) = &mut practice {
                        practice.take(k, self.winches[k].feedback);
                    }
                    self.told[k] = if self.holding { 0.0 } else { speed };
                    DriveCommand::Velocity(self.told[k])
                }
                ActuationMode::DriveTension(list) => {
                    let wish =
                        FarEndReference { tension_out: pull.tension, velocity, previewed_velocity: coming };
                    let seen = CableSample {
                        motor: self.guard.motor[k],
                        anchor: -lengths[k],
                        tension_in: self.guard.tension[k],
                    };
                    self.told[k] = f64::NAN;
                    list[k].answer(h, &wish, &seen).command
                }
            };
        }
    }

    /// All winches to rest: tensions stay about what they are.
    fn brake(&mut self, h: f64) {
        for (told, command) in self.told.iter_mut().zip(&mut self.commands) {
            let speed = if told.is_finite() { *told } else { 0.0 };
            *told = speed - speed.clamp(-h * BRAKING, h * BRAKING);
            *command = DriveCommand::Velocity(*told);
        }
    }
}

/// Largest error of a muscle's length with which an arm counts as at rest, m, and beyond which it does no more.
const AT_REST: [f64; 2] = [5e-4, 1e-3];

/// Fastest joint of an arm that comes to rest, rad/s.
const CALM: f64 = 0.05;

/// Share of `w^3` with which the error is integrated where no tension is known.
const BLIND_INTEGRAL: f64 = 0.2;

/// With which winches are brought to rest, m/s^2.
const BRAKING: f64 = 2.0;
