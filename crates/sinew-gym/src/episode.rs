//! What is sampled at the beginning of an episode.

use crate::design::EnvironmentDesign;
use crate::randomisation::Sampled;
use crate::task::Task;
use sinew::Error;
use sinew::control::arm::resting_tensions;
use sinew::random::Random;
use sinew::trajectory::Reference;
use sinew::twin::arm::{ArmTwin, Failure, InjectedFault};

/// An episode before its first step.
#[derive(Debug, Clone)]
pub(crate) struct Episode {
    /// At rest in the initial pose.
    pub(crate) twin: ArmTwin,
    /// Pose to be reached or held, rad or m: `[joints]`; of a motion, the one at its beginning.
    pub(crate) target: Vec<f64>,
    /// Time of the motion at the beginning, s.
    pub(crate) offset: f64,
    /// Seed of the noise of the sensors.
    pub(crate) seed: u64,
    /// Delay of the joints' encoders, ms; that of the drives is the twin's.
    pub(crate) delay_ms: f64,
}

/// Draws after which the machine as designed begins in its start.
const ATTEMPTS: usize = 20;
/// Deviation of the initial pose from the reference of a motion, as a fraction of that of other tasks.
const TRACKING_FRACTION: f64 = 0.1;
/// Mean time between pushes, and the smallest and the largest duration of one, s.
const PUSH_INTERVAL: f64 = 1.0;
const PUSH_DURATION: [f64; 2] = [0.1, 0.4];

impl Episode {
    /// Draws specimen, initial pose, target, pushes and the seed of the noise.
    ///
    /// Specimens and poses that the plant refuses are sampled again.
    pub(crate) fn draw(design: &EnvironmentDesign, random: &mut Random) -> Result<Self, Error> {
        let mut last = None;
        for _ in 0..ATTEMPTS {
            let sampled = design.randomisation.draw(random);
            match Self::new(design, &sampled, design.settings.spread, random) {
                Ok(episode) => return Ok(episode),
                Err(error) => last = Some(error),
            }
        }
        let plain = crate::randomisation::Randomisation::none().draw(random);
        Self::new(design, &plain, 0.0, random).map_err(|error| last.unwrap_or(error))
    }

    fn new(
        design: &EnvironmentDesign,
        sampled: &Sampled,
        spread: f64,
        random: &mut Random,
    ) -> Result<Self, Error> {
        let start = &design.machine.start;
        let (mut offset, mut initial) = (0.0, design.pose_near(start, spread, random));
        let target = match &design.task {
            Task::Reach => design.pose_near(start, spread, random),
            Task::Hold { .. } => initial.clone(),
            Task::Track(trajectory) => {
                let moment = random.unit() * trajectory.duration();
                offset = if trajectory.is_closed() { moment } else { 0.0 };
                let mut reference = Reference::new(start.len());
                trajectory.sample(offset, &mut reference)?;
                initial = design.pose_near(&reference.q, TRACKING_FRACTION * spread, random);
                reference.q
            }
        };
        let pushes = match design.task {
            Task::Hold { push } => pushes(design, push, random),
            Task::Reach | Task::Track(_) => Vec::new(),
        };
        let seed = random.bits();
        let specimen = sampled.specimen(&design.specimen, &design.machine)?;
        let mut tensions = resting_tensions(&specimen.robot, &initial, &design.tensions)?;
        for (tension, cable) in tensions.iter_mut().zip(&specimen.cables) {
            *tension = tension.max(cable.parameters.pretension);
        }
        let twin = ArmTwin::new(&specimen, &initial, &tensions, seed)?.with_faults(&pushes)?;
        Ok(Self { twin, target, offset, seed, delay_ms: sampled.delay_ms })
    }
}

impl EnvironmentDesign {
    /// A pose at random: every joint up to a fraction of the way from `middle` to the ends of its range.
    fn pose_near(&self, middle: &[f64], fraction: f64, random: &mut Random) -> Vec<f64> {
        let joints = middle.iter().zip(&self.ranges);
        let place = |(middle, [low, high]): (&f64, &[f64; 2])| {
            let way = fraction * (2.0 * random.unit() - 1.0);
            let pose = if way < 0.0 { middle + way * (middle - low) } else { middle + way * (high - middle) };
            pose.max(*low).min(*high)
        };
        joints.map(place).collect()
    }
}

/// Pushes of an episode: at random times, of random joints.
fn pushes(design: &EnvironmentDesign, largest: f64, random: &mut Random) -> Vec<InjectedFault> {
    let duration = 1e-3 * f64::from(design.settings.interval_ms) * f64::from(design.settings.steps);
    let count = libm::ceil(duration / PUSH_INTERVAL).min(MAX_PUSHES) as usize;
    let [shortest, longest] = PUSH_DURATION;
    let push = |_| {
        let start = random.unit() * duration;
        let duration = shortest + random.unit() * (longest - shortest);
        let joint = ((random.unit() * design.strength.len() as f64) as usize).min(design.strength.len() - 1);
        let torque = (2.0 * random.unit() - 1.0) * largest * design.strength[joint];
        InjectedFault { start, duration, failure: Failure::Push { joint, torque } }
    };
    (0..count).map(push).collect()
}

/// Most pushes of an episode: every one costs time in every step.
const MAX_PUSHES: f64 = 60.0;
