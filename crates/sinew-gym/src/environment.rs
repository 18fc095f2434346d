use crate::design::{EnvironmentDesign, Place};
use crate::episode::Episode;
use crate::task::Task;
use sinew::Error;
use sinew::drive::{Delay, DriveCommand};
use sinew::machine::Task as Space;
use sinew::random::Random;
use sinew::trajectory::Reference;
use sinew::twin::arm::{ArmTwin, ArmTwins};
use std::sync::Arc;

/// One environment: a simulated machine, its sensors, and what it is asked for.
#[derive(Debug, Clone)]
pub struct Environment {
    design: Arc<EnvironmentDesign>,
    random: Random,
    twin: ArmTwin,
    place: Place,
    /// What is added to the motors' encoders so that they count from home, m: `[muscles]`.
    homing: Vec<f64>,
    sensed: Sensed,
    action: Vec<f64>,
    commands: Vec<DriveCommand>,
    target: Vec<f64>,
    target_rate: Vec<f64>,
    target_point: [f64; 3],
    /// Its coordinates along the axes that are tracked, m.
    tracked_point: Vec<f64>,
    reference: Reference,
    offset: f64,
    seed: u64,
    delay_ms: f64,
    steps: u32,
    error: f64,
    ended: bool,
}

/// What is desired at the end of an interval.
#[derive(Debug, Clone, PartialEq)]
pub struct Target {
    /// Pose, rad or m: `[joints]`.
    pub pose: Vec<f64>,
    /// Its rate, per s, 0 where it does not move: `[joints]`.
    pub rate: Vec<f64>,
    /// The end point in that pose, m; the origin without one.
    pub point: [f64; 3],
}

/// What the sensors tell.
#[derive(Debug, Clone)]
struct Sensed {
    /// Of the joints' encoders: `[encoded]`.
    delays: Vec<Delay>,
    readings: Readings,
}

impl Sensed {
    /// Reads the joints' encoders after a cycle.
    fn pass(&mut self, design: &EnvironmentDesign, twin: &ArmTwin) {
        let joints = design.encoded.iter().zip(&mut self.delays).zip(&mut self.readings.joint);
        for ((k, delay), reading) in joints {
            *reading = delay.pass(twin.reading().joint[*k]);
        }
    }
}

/// Readings now, and their rates since the last action.
#[derive(Debug, Clone)]
struct Readings {
    motor: Vec<f64>,
    motor_rate: Vec<f64>,
    joint: Vec<f64>,
    joint_rate: Vec<f64>,
}

/// What follows from an action.
#[derive(Debug, Clone, Copy, PartialEq)]
pub struct Outcome {
    /// `1/(1 + (e/e_h)^2) - w mean(a^2)`: `e` the error, `e_h` that at which the first part is a half, `w`
    /// the weight of the action `a`; 0 in a step in which the machine failed.
    pub reward: f64,
    /// Whether the machine failed: a cable broke, a drive stopped, or the plant could not go on.
    pub terminated: bool,
    /// Whether that was the last step of the episode.
    pub truncated: bool,
    /// Distance of the end point, m, or root-mean-square error of the joints as a fraction of their ranges,
    /// 1.
    pub error: f64,
}

/// s: the unit of intervals and delays.
const MILLISECOND: f64 = 1e-3;

impl Environment {
    /// At the beginning of its first episode.
    ///
    /// # Errors
    /// Where even the machine as designed cannot begin in its start.
    pub fn new(design: Arc<EnvironmentDesign>, seed: u64) -> Result<Self, Error> {
        let mut random = Random::new(mixed(seed));
        let episode = Episode::draw(&design, &mut random)?;
        let (muscles, joints) = (design.actions(), design.ranges.len());
        let encoded = design.encoded.len();
        let mut environment = Self {
            place: Place::new(&design.machine),
            random,
            homing: vec![0.0; muscles],
            sensed: Sensed {
                delays: Vec::with_capacity(encoded),
                readings: Readings {
                    motor: vec![0.0; muscles],
                    motor_rate: vec![0.0; muscles],
                    joint: vec![0.0; encoded],
                    joint_rate: vec![0.0; encoded],
                },
            },
            action: vec![0.0; muscles],
            commands: vec![DriveCommand::Off; muscles],
            target: vec![0.0; joints],
            target_rate: vec![0.0; joints],
            target_point: [0.0; 3],
            tracked_point: Vec::with_capacity(3),
            reference: Reference::new(joints),
            offset: 0.0,
            seed: 0,
            delay_ms: 0.0,
            steps: 0,
            error: 0.0,
            ended: false,
            twin: episode.twin.clone(),
            design,
        };
        environment.begin(episode)?;
        Ok(environment)
    }

    /// What it has in common with others.
    #[must_use]
    pub fn design(&self) -> &EnvironmentDesign {
        &self.design
    }

    /// Whether its episode has ended: it has to be reset before the next step.
    #[must_use]
    pub fn ended(&self) -> bool {
        self.ended
    }

    /// The simulated machine, for what no sensor tells.
    #[must_use]
    pub fn twin(&self) -> &ArmTwin {
        &self.twin
    }

    /// Error at the present time; see [`Outcome::error`].
    #[must_use]
    pub fn error(&self) -> f64 {
        self.error
    }

    /// Seed of the noise of this episode's sensors, as of [`ArmTwin::new`].
    #[must_use]
    pub fn seed(&self) -> u64 {
        self.seed
    }

    /// Delay of the joints' encoders in this episode, ms.
    #[must_use]
    pub fn delay_ms(&self) -> f64 {
        self.delay_ms
    }

    /// What is desired from the present step of the episode to its last; one where it does not move.
    ///
    /// # Errors
    /// None after a successful [`reset`](Self::reset).
    pub fn targets(&self) -> Result<Vec<Target>, Error> {
        let mut ahead = self.clone();
        let last = if self.design.task.moves() { self.design.settings.steps } else { self.steps };
        let target = |step| {
            ahead.steps = step;
            ahead.update_target()?;
            let (pose, rate) = (ahead.target.clone(), ahead.target_rate.clone());
            Ok(Target { pose, rate, point: ahead.target_point })
        };
        (self.steps..=last).map(target).collect()
    }

    /// Begins another episode; with a seed, the first one of that seed.
    ///
    /// # Errors
    /// As [`new`](Self::new).
    pub fn reset(&mut self, seed: Option<u64>) -> Result<(), Error> {
        if let Some(seed) = seed {
            self.random = Random::new(mixed(seed));
        }
        let episode = Episode::draw(&self.design, &mut self.random)?;
        self.begin(episode)
    }

    /// Applies an action for an interval.
    ///
    /// # Shapes
    /// `action: [actions]`; entries beyond -1 and 1 count as those.
    ///
    /// # Errors
    /// [`Error::WrongLength`], [`Error::EntryOutOfDomain`] for an entry that is not a number,
    /// [`Error::OutOfDomain`] after the end of the episode; nothing has then changed.
    pub fn step(&mut self, action: &[f32]) -> Result<Outcome, Error> {
        check_actions(action, self.action.len())?;
        if self.ended {
            let (name, expected) = ("episode of the environment", "reset after its end before the next step");
            return Err(Error::OutOfDomain { name, expected, got: f64::from(self.steps) });
        }
        Ok(self.advance(action))
    }

    /// Applies an action that was checked.
    fn advance(&mut self, action: &[f32]) -> Outcome {
        self.command(action);
        let Self { design, twin, sensed, commands, .. } = self;
        let failed = (0..design.cycles).any(|_| {
            let failed = twin.step(commands, design.machine.period).is_err();
            if !failed {
                sensed.pass(design, twin);
            }
            failed
        });
        self.conclude(failed)
    }

    /// Takes an action that was checked.
    fn command(&mut self, action: &[f32]) {
        let Self { design, sensed: Sensed { readings, .. }, commands, .. } = self;
        for (muscle, (told, kept)) in action.iter().zip(&mut self.action).enumerate() {
            *kept = f64::from(*told).clamp(-1.0, 1.0);
            commands[muscle] = design.command(muscle, *kept);
        }
        readings.motor_rate.copy_from_slice(&readings.motor);
        readings.joint_rate.copy_from_slice(&readings.joint);
    }

    /// What follows from an action after its interval, or after the cycle in which the plant failed.
    fn conclude(&mut self, failed: bool) -> Outcome {
        let Self { design, twin, sensed: Sensed { readings, .. }, .. } = self;
        let motors = readings.motor.iter_mut().zip(&twin.reading().motor).zip(&self.homing);
        motors.for_each(|((told, measured), homing)| *told = measured + homing);
        let rate = 1.0 / (MILLISECOND * f64::from(design.settings.interval_ms));
        let motors = readings.motor_rate.iter_mut().zip(&readings.motor);
        motors.for_each(|(before, now)| *before = rate * (now - *before));
        let joints = readings.joint_rate.iter_mut().zip(&readings.joint);
        joints.for_each(|(before, now)| *before = rate * (now - *before));
        self.steps += 1;
        // The pose that was desired for this time was told before the action.
        let evaluated = self.update_error();
        let truth = self.twin.truth();
        let broken = truth.cables.iter().any(|cable| cable.broken.is_some());
        let stopped = truth.drives.iter().any(|drive| drive.fault.is_some());
        let terminated = failed || broken || stopped || evaluated.is_err() || !self.error.is_finite();
        let truncated = self.steps >= self.design.settings.steps;
        self.ended = terminated || truncated || self.update_target().is_err();
        Outcome {
            reward: if terminated { 0.0 } else { self.reward() },
            terminated,
            truncated: truncated || (self.ended && !terminated),
            error: if self.error.is_finite() { self.error } else { f64::MAX },
        }
    }

    fn reward(&self) -> f64 {
        let ratio = self.error / self.design.half_error;
        let effort = self.action.iter().map(|a| a * a).sum::<f64>() / self.action.len() as f64;
        1.0 / (1.0 + ratio * ratio) - self.design.settings.effort * effort
    }

    /// Writes what the agent is told: `out: [observations]`.
    pub fn observe(&self, out: &mut [f32]) {
        let Readings { motor, motor_rate, joint, joint_rate } = &self.sensed.readings;
        let moving: &[f64] = if self.design.task.moves() { &self.target_rate } else { &[] };
        let tension = &self.twin.reading().tension;
        let parts: [&[f64]; 9] = [
            motor,
            motor_rate,
            tension,
            joint,
            joint_rate,
            &self.target,
            moving,
            &self.tracked_point,
            &self.action,
        ];
        self.design.layout.write(&parts, out);
    }

    fn begin(&mut self, episode: Episode) -> Result<(), Error> {
        self.twin = episode.twin;
        (self.offset, self.steps, self.ended) = (episode.offset, 0, false);
        (self.seed, self.delay_ms) = (episode.seed, episode.delay_ms);
        self.target.copy_from_slice(&episode.target);
        let truth = self.twin.truth();
        let Sensed { delays, readings } = &mut self.sensed;
        delays.clear();
        for (k, reading) in self.design.encoded.iter().zip(&mut readings.joint) {
            *reading = self.twin.reading().joint[*k];
            delays.push(Delay::new(episode.delay_ms * (MILLISECOND / self.design.machine.period), *reading)?);
        }
        // The encoders were set to zero in the start, with cables that hardly stretched.
        let places = truth.lengths.iter().zip(truth.cables).zip(&self.design.home);
        let motors = self.twin.reading().motor.iter().zip(&mut readings.motor);
        for ((homing, ((length, cable), home)), (reading, told)) in
            self.homing.iter_mut().zip(places).zip(motors)
        {
            *homing = home - length + cable.stretch - reading;
            *told = reading + *homing;
        }
        readings.motor_rate.fill(0.0);
        readings.joint_rate.fill(0.0);
        self.action.fill(0.0);
        self.update_target()?;
        self.update_error()
    }

    /// What is desired at the end of the next interval.
    fn update_target(&mut self) -> Result<(), Error> {
        if let Task::Track(trajectory) = &self.design.task {
            let interval = MILLISECOND * f64::from(self.design.settings.interval_ms);
            let mut time = self.offset + f64::from(self.steps + 1) * interval;
            if trajectory.is_closed() && trajectory.duration() > 0.0 {
                time %= trajectory.duration();
            }
            trajectory.sample(time, &mut self.reference)?;
            self.target.copy_from_slice(&self.reference.q);
            self.target_rate.copy_from_slice(&self.reference.v);
        } else if self.steps > 0 {
            return Ok(());
        }
        self.target_point = self.place.point_of(&self.design.machine.robot, &self.target)?;
        self.tracked_point.clear();
        if let Space::EndPoint { axes, .. } = self.design.machine.task {
            let tracked = self.target_point.iter().zip(axes).filter(|(_, tracked)| *tracked);
            self.tracked_point.extend(tracked.map(|(x, _)| *x));
        }
        Ok(())
    }

    fn update_error(&mut self) -> Result<(), Error> {
        let q = self.twin.truth().q;
        let point = self.place.point_of(&self.design.machine.robot, q)?;
        self.error = self.design.error(q, point, &self.target, self.target_point);
        Ok(())
    }
}

/// Applies one action each, all checked, to at most [`ArmTwins::LANES`] environments of one design.
///
/// # Errors
/// As [`ArmTwins::gather`].
pub(crate) fn advance_together(
    environments: &mut [(&mut Environment, &[f32])],
    twins: &mut ArmTwins,
    mut outcome: impl FnMut(usize, Outcome),
) -> Result<(), Error> {
    let mut failed = [false; ArmTwins::LANES];
    let (mut arms, mut rest) = (Vec::new(), Vec::new());
    for (environment, action) in environments.iter_mut() {
        environment.command(action);
        let Environment { design, twin, sensed, commands, .. } = &mut **environment;
        arms.push(twin);
        rest.push((&**design, sensed, commands.as_slice()));
    }
    let Some((design, ..)) = rest.first() else { return Ok(()) };
    let (cycles, period) = (design.cycles, design.machine.period);
    let commands: Vec<_> = rest.iter().map(|(.., commands)| *commands).collect();
    let mut together = twins.gather(&mut arms)?;
    for _ in 0..cycles {
        let results = together.step(&commands, period);
        for (k, (design, sensed, _)) in rest.iter_mut().enumerate() {
            failed[k] |= results[k].is_err();
            if let (false, Some(twin)) = (failed[k], together.twin(k)) {
                sensed.pass(design, twin);
            }
        }
    }
    for (k, (environment, _)) in environments.iter_mut().enumerate() {
        outcome(k, environment.conclude(failed[k]));
    }
    Ok(())
}

/// Refuses actions of the wrong number and those that are not numbers.
pub(crate) fn check_actions(action: &[f32], expected: usize) -> Result<(), Error> {
    if action.len() != expected {
        return Err(Error::WrongLength { name: "action", expected, got: action.len() });
    }
    match action.iter().position(|entry| !entry.is_finite()) {
        None => Ok(()),
        Some(index) => {
            let (name, expected, got) = ("action", "a finite number from -1 to 1", f64::from(action[index]));
            Err(Error::EntryOutOfDomain { name, index, expected, got })
        }
    }
}

/// A seed spread over all bits: seeds that follow each other then have unrelated numbers.
fn mixed(seed: u64) -> u64 {
    Random::new(seed).bits()
}
