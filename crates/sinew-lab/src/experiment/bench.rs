//! Runs on the bench: the load moves the cable, the muscle follows a tension, or the other way round.

use sinew::Error;
use sinew::control::compensation::{Answer, Compensation};
use sinew::control::stretch::{FarEndReference, PREVIEW_HORIZON, StretchController};
use sinew::drive::{DriveCommand, DriveFault, DriveParameters};
use sinew::predictor::CableSample;
use sinew::transmission::cable::{CableLaw, CableParameters, CablePath};
use sinew::twin::bench::Bench;
use sinew::twin::cable::{Broken, CableReading, Resolution, Specimen};

/// Who moves the cable and who holds the tension.
#[derive(Debug, Clone, Copy, PartialEq, Eq)]
pub enum Programme {
    /// The load moves back and forth; the muscle's drive is to give the wanted far tension: compensation on trial.
    Track,
    /// The muscle's drive moves back and forth; the load swings the far tension by its own sensor: calibration, and what
    /// Tables II and III are measured on.
    Calibrate,
}

/// One run.
#[derive(Debug, Clone, PartialEq)]
pub struct BenchRun {
    /// The cable.
    pub specimen: Specimen,
    /// Cells and substeps of the plant.
    pub resolution: Resolution,
    /// Both drives.
    pub drives: DriveParameters,
    /// What is done.
    pub programme: Programme,
    /// Speed of the cable in its strokes, m/s, > 0.
    pub speed: f64,
    /// Length of a stroke, m.
    pub stroke: f64,
    /// Least and most of the far tension, N.
    pub tension: [f64; 2],
    /// Period of its swing, s.
    pub period: f64,
    /// Of the sensors' noise.
    pub seed: u64,
}

impl BenchRun {
    /// The paper's: 40 to 200 N at one of its speeds; strokes of 0.7 m, which the drum has room for beside the stretch;
    /// the steady window of a stroke holds one whole swing.
    #[must_use]
    pub fn paper(specimen: Specimen, programme: Programme, speed: f64, seed: u64) -> Self {
        Self {
            specimen,
            resolution: Resolution::default(),
            drives: DriveParameters::mc_am(),
            programme,
            speed,
            stroke: STROKE,
            tension: [40.0, 200.0],
            period: (1.0 - RUN_IN) * STROKE / speed,
            seed,
        }
    }
}

/// One millisecond of a run. Positions count toward the muscle's drive.
#[derive(Debug, Clone, Copy, PartialEq)]
pub struct BenchRow {
    /// s.
    pub time: f64,
    /// Which part of the stroke: + while the cable is to slide toward the motor at full speed, - the other way, 0 else.
    pub window: f64,
    /// Wanted far tension, N.
    pub wanted: f64,
    /// What the muscle's drive was told.
    pub command: DriveCommand,
    /// What the muscle's sensors and the joint's say.
    pub sample: CableSample,
    /// What the far sensor says, N.
    pub far: f64,
    /// What the compensation believes of the far tension, N.
    pub estimate: f64,
    /// What it believes of the elongation, m; NaN where it believes nothing.
    pub estimated_stretch: f64,
    /// True tensions, N: near, far.
    pub truth: [f64; 2],
    /// True elongation, m.
    pub stretch: f64,
    /// Speed wanted of the cable, m/s.
    pub velocity: f64,
}

/// How a run ended before its time.
#[derive(Debug, Clone, Copy, PartialEq)]
pub enum Stop {
    /// The cable broke.
    Broken(Broken),
    /// A drive stopped.
    Drive(DriveFault),
}

/// Who tells the muscle's drive what to do.
#[derive(Debug)]
pub enum MuscleControl<'a> {
    /// A compensation, by what sensors say.
    Compensation(&'a mut Compensation),
    /// Nobody has it: the plant's own law and its true stretch, without noise and delay. The yardstick.
    Oracle,
}

/// Length of the paper's strokes here, m; it does not tell it.
const STROKE: f64 = 0.7;

/// Step of all loops, s.
pub const STEP: f64 = 1e-3;

/// Acceleration at the turns of a stroke, m/s^2: a third of what the drives may.
const TURNING: f64 = 1.0;

/// Runs for `seconds` and hands every row to `see`; what stopped it early.
///
/// # Errors
/// As [`Bench::new`]; the plant's own errors mid-run.
pub fn run(
    run: &BenchRun,
    mut steering: MuscleControl<'_>,
    seconds: f64,
    mut see: impl FnMut(&BenchRow),
) -> Result<Option<Stop>, Error> {
    let mut bench = Bench::new(&run.specimen, run.resolution, run.drives, run.seed)?;
    bench.settle(0.5 * (run.tension[0] + run.tension[1]))?;
    let mut perfect = StretchController::new(bench.cable().law().clone());
    let mut load = LoadFeed::new()?;
    let mut stroke = Stroke::new(run.speed, run.stroke);
    let mut ahead = stroke.clone();
    for _ in 0..(PREVIEW_HORIZON / STEP) as u64 {
        ahead.next();
    }
    let steps = (seconds / STEP) as u64;
    for k in 0..steps {
        let time = k as f64 * STEP;
        let (velocity, coming) = (stroke.next(), ahead.next());
        let wanted = swing(run, time);
        let reading = bench.reading();
        let sample = CableSample {
            motor: reading.muscle.position,
            anchor: reading.anchor(),
            tension_in: reading.muscle.tension,
        };
        let wish = FarEndReference { tension_out: wanted, velocity, previewed_velocity: coming };
        let answer = match &mut steering {
            MuscleControl::Compensation(compensation) => compensation.answer(STEP, &wish, &sample),
            MuscleControl::Oracle => {
                let CableReading { tension_out, stretch, .. } = bench.truth();
                let speed = perfect.speed(STEP, &wish, stretch, bench.cable().drag_factor());
                Answer { command: DriveCommand::Velocity(speed), far: tension_out, stretch }
            }
        };
        let (muscle, pulling) = match run.programme {
            Programme::Track => (answer.command, DriveCommand::Velocity(-velocity)),
            Programme::Calibrate => {
                let swing = DriveCommand::Tension { tension: wanted, feed: load.feed(wanted, velocity) };
                (DriveCommand::Velocity(velocity), swing)
            }
        };
        let truth = bench.step(muscle, pulling, STEP)?;
        see(&BenchRow {
            time,
            window: stroke.window(),
            wanted,
            command: muscle,
            sample,
            far: reading.load.tension,
            estimate: answer.far,
            estimated_stretch: answer.stretch,
            truth: [truth.tension_in, truth.tension_out],
            stretch: truth.stretch,
            velocity,
        });
        if let Some(broken) = truth.broken {
            return Ok(Some(Stop::Broken(broken)));
        }
        if let Some(fault) = bench.fault() {
            return Ok(Some(Stop::Drive(fault)));
        }
    }
    Ok(None)
}

/// The wanted far tension: a sine between its ends.
fn swing(run: &BenchRun, time: f64) -> f64 {
    let [low, high] = run.tension;
    let phase = 2.0 * core::f64::consts::PI * time / run.period;
    0.5 * (low + high) + 0.5 * (high - low) * libm::sin(phase)
}

/// What the load's drive knows beforehand: how fast a cable with the numbers of the tables stretches under its swing.
#[derive(Debug)]
struct LoadFeed {
    nominal: CableLaw,
    last: Option<(f64, f64)>,
}

impl LoadFeed {
    fn new() -> Result<Self, Error> {
        Ok(Self { nominal: CableLaw::new(&CablePath::bench(), &CableParameters::bench(), 12)?, last: None })
    }

    /// Speed of the load's winch, m/s, + where it pulls.
    fn feed(&mut self, wanted: f64, velocity: f64) -> f64 {
        let Ok(steady) = self.nominal.steady(wanted, velocity, 1.0) else { return -velocity };
        match self.last.replace((velocity, steady.stretch)) {
            // At a turn the cable changes sides, and no speed follows that.
            Some((before, last)) if before * velocity > 0.0 => (steady.stretch - last) / STEP - velocity,
            _ => -velocity,
        }
    }
}

/// Back and forth with a speed, turning with [`TURNING`].
#[derive(Debug, Clone)]
struct Stroke {
    speed: f64,
    half: f64,
    place: f64,
    velocity: f64,
    direction: f64,
    /// How long the full speed has been held, s.
    steady: f64,
}

/// Full speed after a turn before the window of a stroke begins, as a share of the stroke's time: the front has to cross.
const RUN_IN: f64 = 0.3;

impl Stroke {
    fn new(speed: f64, length: f64) -> Self {
        Self { speed, half: 0.5 * length, place: 0.0, velocity: 0.0, direction: 1.0, steady: 0.0 }
    }

    fn next(&mut self) -> f64 {
        let braking = self.velocity * self.velocity / (2.0 * TURNING);
        if self.direction * self.place + braking >= self.half {
            self.direction = -self.direction;
        }
        let wanted = self.direction * self.speed;
        let most = TURNING * STEP;
        self.velocity += (wanted - self.velocity).clamp(-most, most);
        self.place += self.velocity * STEP;
        let full = (self.velocity - wanted).abs() < 1e-12;
        self.steady = if full { self.steady + STEP } else { 0.0 };
        self.velocity
    }

    fn window(&self) -> f64 {
        let run_in = RUN_IN * 2.0 * self.half / self.speed;
        if self.steady > run_in { self.direction } else { 0.0 }
    }
}
