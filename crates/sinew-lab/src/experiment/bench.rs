//! Runs on the two-drive bench: one drive moves the cable, the other one controls its tension.

use super::bench_oracle::{Oracle, TrueState};
use rayon::prelude::*;
use sinew::Error;
use sinew::control::compensation::{Compensation, CompensationOutput};
use sinew::control::stretch::{FarEndReference, PREVIEW_HORIZON};
use sinew::drive::{DriveCommand, DriveFault, DriveParameters};
use sinew::predictor::CableSample;
use sinew::transmission::cable::{CableLaw, CableParameters, CablePath};
use sinew::twin::bench::{Bench, BenchReading, Benches};
use sinew::twin::cable::{Broken, CableReading, Resolution, Specimen};

/// Roles of the two drives.
#[derive(Debug, Clone, Copy, PartialEq, Eq)]
pub enum Programme {
    /// The load strokes; the muscle's drive controls the far tension by a compensation: its test.
    Track,
    /// The muscle's drive strokes; the load controls the far tension by its own sensor: calibration, and the
    /// conditions of Tables II and III.
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
    /// Roles of the drives.
    pub programme: Programme,
    /// Speed of the cable in its strokes, m/s, > 0.
    pub speed: f64,
    /// Length of a stroke, m.
    pub stroke: f64,
    /// Smallest and largest far tension, N.
    pub tension: [f64; 2],
    /// Period of the far tension, s.
    pub period: f64,
    /// Seed of the sensors' noise.
    pub seed: u64,
    /// Where the displacement of the far end is known from.
    pub anchor: AnchorSource,
}

/// Where a compensation knows the displacement of the far end from.
#[derive(Debug, Clone, Copy, PartialEq, Eq, Default)]
pub enum AnchorSource {
    /// The encoder of the joint.
    #[default]
    JointEncoder,
    /// The reference of the motion: no sensor stands at the far end.
    Reference,
}

impl BenchRun {
    /// The conditions of `yuan2023`: 40 to 200 N at one of its speeds; strokes of 0.7 m, for which the drum
    /// has room beside the stretch; the steady window of a stroke is one period of the tension.
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
            anchor: AnchorSource::JointEncoder,
        }
    }

    /// Mean of the far tension, N, with which a run begins.
    fn mean_tension(&self) -> f64 {
        0.5 * (self.tension[0] + self.tension[1])
    }
}

/// One control cycle of a run. Positions count toward the muscle's drive.
#[derive(Debug, Clone, Copy, PartialEq)]
pub struct BenchRow {
    /// Time since the run began, s.
    pub time: f64,
    /// Steady window of the stroke: 1 while the cable slides toward the motor at full speed, -1 away from it,
    /// else 0.
    pub window: f64,
    /// Desired far tension, N.
    pub desired: f64,
    /// Command of the muscle's drive.
    pub command: DriveCommand,
    /// Measurements of the muscle's sensors and the joint's.
    pub sample: CableSample,
    /// Current of the muscle's motor, A.
    pub current: f64,
    /// Displacement of the far end as its encoder reads it, m, whether the compensation knows it or not.
    pub anchor: f64,
    /// Measured far tension, N.
    pub far: f64,
    /// Far tension estimated by the compensation, N; NaN where it has no estimate.
    pub estimate: f64,
    /// Elongation estimated by it, m; NaN where it has no estimate.
    pub estimated_stretch: f64,
    /// True tensions, N: near, far.
    pub truth: [f64; 2],
    /// True elongation, m.
    pub stretch: f64,
    /// Reference speed of the cable, m/s.
    pub velocity: f64,
}

impl BenchRow {
    /// Adds what the cable did.
    fn complete(&mut self, cable: &CableReading) {
        self.truth = [cable.tension_in, cable.tension_out];
        self.stretch = cable.stretch;
    }
}

/// Reason for which a run ended early.
#[derive(Debug, Clone, Copy, PartialEq)]
pub enum Stop {
    /// The cable broke.
    Broken(Broken),
    /// A drive reported a fault.
    Drive(DriveFault),
}

impl Stop {
    fn new(cable: &CableReading, fault: Option<DriveFault>) -> Option<Self> {
        cable.broken.map(Self::Broken).or(fault.map(Self::Drive))
    }
}

/// Controller of the muscle's drive.
#[derive(Debug)]
pub enum MuscleControl<'a> {
    /// A compensation, from measurements.
    Compensation(&'a mut Compensation),
    /// The plant's own law with its true stretch, drag and far tension, without noise and delay.
    Oracle,
}

/// Length of the strokes, m; `yuan2023` does not state it.
const STROKE: f64 = 0.7;

/// Control cycle, s.
pub const STEP: f64 = 1e-3;

/// Acceleration at the ends of a stroke, m/s^2: a third of the drives' limit.
const REVERSAL_ACCELERATION: f64 = 1.0;

/// Runs for `seconds`, calls `see` with every row, and returns the reason for an early end.
///
/// # Errors
/// As [`Bench::new`], [`Bench::step`] and [`Compensation::step`].
pub fn run(
    run: &BenchRun,
    mut control: MuscleControl<'_>,
    seconds: f64,
    mut see: impl FnMut(&BenchRow),
) -> Result<Option<Stop>, Error> {
    let mut bench = Bench::new(&run.specimen, run.resolution, run.drives, run.seed)?;
    bench.settle(run.mean_tension())?;
    let mut oracle = Oracle::new(bench.cable().law().clone());
    let mut cycle = Cycle::new(run, &bench.reading())?;
    for _ in 0..(seconds / STEP) as u64 {
        let (mut row, load) =
            cycle.row(&bench.reading(), |reference, sample, sliding| match &mut control {
                MuscleControl::Compensation(compensation) => compensation.step(STEP, reference, sample),
                MuscleControl::Oracle => {
                    let CableReading { tension_out, stretch, .. } = bench.truth();
                    let drag_factor = bench.cable().drag_factor();
                    let state = TrueState { stretch, tension_out, drag_factor, sliding };
                    let speed = oracle.winch_speed(STEP, reference, state)?;
                    Ok(CompensationOutput { command: DriveCommand::Velocity(speed), tension_out, stretch })
                }
            })?;
        let truth = bench.step(row.command, load, STEP)?;
        row.complete(&truth);
        see(&row);
        if let Some(stop) = Stop::new(&truth, bench.fault()) {
            return Ok(Some(stop));
        }
    }
    Ok(None)
}

/// A run without compensation.
#[derive(Debug, Clone, PartialEq)]
pub struct CalibrationRun {
    /// Its conditions.
    pub run: BenchRun,
    /// Its duration, s.
    pub seconds: f64,
    /// Every n-th row is kept, beginning with the first; 0 acts as 1.
    pub decimation: usize,
}

/// What is kept of a run: rows, or the reason for an early end.
pub type KeptRows = Result<Vec<BenchRow>, Stop>;

/// Runs without compensation. Their cables are computed in SIMD lanes of eight, and their rows are those of
/// [`run`] bit for bit.
///
/// # Errors
/// As [`run`].
pub fn run_all(runs: &[CalibrationRun]) -> Result<Vec<KeptRows>, Error> {
    // Lanes share cells and substeps, and end one after the other.
    let resolution = |k: usize| (runs[k].run.resolution.cells, runs[k].run.resolution.substeps);
    let mut order: Vec<usize> = (0..runs.len()).collect();
    order.sort_by(|&a, &b| {
        resolution(a).cmp(&resolution(b)).then(runs[b].seconds.total_cmp(&runs[a].seconds))
    });
    let alike = order.chunk_by(|&a, &b| resolution(a) == resolution(b));
    let batches: Vec<&[usize]> = alike.flat_map(|alike| alike.chunks(LANES)).collect();
    let kept = batches.par_iter().map(|batch| {
        let of_batch: Vec<_> = batch.iter().map(|k| &runs[*k]).collect();
        Ok(batch.iter().copied().zip(run_batch(&of_batch)?).collect())
    });
    let kept = kept.collect::<Result<Vec<Vec<(usize, KeptRows)>>, Error>>()?;
    let mut kept: Vec<_> = kept.into_iter().flatten().collect();
    kept.sort_by_key(|(k, _)| *k);
    Ok(kept.into_iter().map(|(_, rows)| rows).collect())
}

/// Cables that are computed together.
const LANES: usize = 8;

/// Runs with one resolution side by side, the longest first.
fn run_batch(runs: &[&CalibrationRun]) -> Result<Vec<KeptRows>, Error> {
    let entries: Vec<_> = runs.iter().map(|of| (&of.run.specimen, of.run.drives, of.run.seed)).collect();
    let resolution = runs.first().map_or_else(Resolution::default, |of| of.run.resolution);
    let mut benches = Benches::new(&entries, resolution)?;
    benches.settle(&runs.iter().map(|of| of.run.mean_tension()).collect::<Vec<_>>())?;
    let cycles = runs.iter().zip(benches.readings());
    let mut cycles =
        cycles.map(|(of, reading)| Cycle::new(&of.run, &reading)).collect::<Result<Vec<_>, _>>()?;
    let mut kept: Vec<KeptRows> = vec![Ok(Vec::new()); runs.len()];
    let (mut rows, mut commands) = (Vec::new(), Vec::new());
    for step in 0..u64::MAX {
        let active = runs.iter().take_while(|of| step < (of.seconds / STEP) as u64).count();
        if active == 0 {
            break;
        }
        rows.clear();
        commands.clear();
        for (cycle, reading) in cycles.iter_mut().zip(benches.readings()).take(active) {
            let (row, load) = cycle
                .row(&reading, |reference, sample, _| Compensation::None.step(STEP, reference, sample))?;
            commands.push([row.command, load]);
            rows.push(row);
        }
        benches.step(&commands, STEP)?;
        let ends = rows.iter_mut().zip(benches.truth()).zip(benches.faults());
        for (((row, truth), fault), (kept, of)) in ends.zip(kept.iter_mut().zip(runs)) {
            let Ok(list) = kept else { continue };
            row.complete(truth);
            if step % of.decimation.max(1) as u64 == 0 {
                list.push(*row);
            }
            if let Some(stop) = Stop::new(truth, fault) {
                *kept = Err(stop);
            }
        }
    }
    Ok(kept)
}

/// What a run does in every control cycle, apart from the bench and the compensation.
struct Cycle<'a> {
    run: &'a BenchRun,
    stroke: Stroke,
    previewed_stroke: Stroke,
    load: LoadFeedforward,
    reference_anchor: f64,
    cycles: u64,
}

impl<'a> Cycle<'a> {
    fn new(run: &'a BenchRun, reading: &BenchReading) -> Result<Self, Error> {
        let stroke = Stroke::new(run.speed, run.stroke);
        let mut previewed_stroke = stroke.clone();
        for _ in 0..(PREVIEW_HORIZON / STEP) as u64 {
            previewed_stroke.next();
        }
        let (load, reference_anchor) = (LoadFeedforward::new()?, reading.anchor());
        Ok(Self { run, stroke, previewed_stroke, load, reference_anchor, cycles: 0 })
    }

    /// The row of one cycle, without what follows it, and the command of the load's drive. `control` is the
    /// muscle's: from the reference, the measurements, and whether the cable slides at full speed.
    fn row(
        &mut self,
        reading: &BenchReading,
        control: impl FnOnce(&FarEndReference, &CableSample, bool) -> Result<CompensationOutput, Error>,
    ) -> Result<(BenchRow, DriveCommand), Error> {
        let run = self.run;
        let time = self.cycles as f64 * STEP;
        self.cycles += 1;
        let (velocity, previewed_velocity) = (self.stroke.next(), self.previewed_stroke.next());
        let desired = desired_tension(run, time);
        let anchor = match run.anchor {
            AnchorSource::JointEncoder => reading.anchor(),
            AnchorSource::Reference => self.reference_anchor,
        };
        self.reference_anchor += velocity * STEP;
        let sample =
            CableSample { motor: reading.muscle.position, anchor, tension_in: reading.muscle.tension };
        let reference = FarEndReference { tension_out: desired, velocity, previewed_velocity };
        let window = self.stroke.window();
        let output = control(&reference, &sample, window != 0.0)?;
        let (command, load) = match run.programme {
            Programme::Track => (output.command, DriveCommand::Velocity(-velocity)),
            Programme::Calibrate => {
                let feed = self.load.speed(desired, velocity)?;
                (DriveCommand::Velocity(velocity), DriveCommand::Tension { tension: desired, feed })
            }
        };
        let row = BenchRow {
            time,
            window,
            desired,
            command,
            sample,
            current: reading.muscle.current,
            anchor: reading.anchor(),
            far: reading.load.tension,
            estimate: output.tension_out,
            estimated_stretch: output.stretch,
            truth: [f64::NAN; 2],
            stretch: f64::NAN,
            velocity,
        };
        Ok((row, load))
    }
}

/// The desired far tension, N: a sine between its bounds.
fn desired_tension(run: &BenchRun, time: f64) -> f64 {
    let [low, high] = run.tension;
    let phase = 2.0 * core::f64::consts::PI * time / run.period;
    0.5 * (low + high) + 0.5 * (high - low) * libm::sin(phase)
}

/// Feedforward of the load's drive: the rate at which a cable with the nominal parameters stretches under the
/// desired tension.
#[derive(Debug)]
struct LoadFeedforward {
    nominal: CableLaw,
    last: Option<(f64, f64)>,
}

impl LoadFeedforward {
    fn new() -> Result<Self, Error> {
        Ok(Self { nominal: CableLaw::new(&CablePath::bench(), &CableParameters::bench(), 12)?, last: None })
    }

    /// Speed of the load's winch, m/s, + while it pulls.
    fn speed(&mut self, tension: f64, velocity: f64) -> Result<f64, Error> {
        let stretch = self.nominal.steady(tension, velocity, 1.0)?.stretch;
        Ok(match self.last.replace((velocity, stretch)) {
            Some((before, last)) if before * velocity > 0.0 => (stretch - last) / STEP - velocity,
            // At a reversal the stretch jumps by the dead band: no finite speed follows.
            _ => -velocity,
        })
    }
}

/// Reference motion between two ends at constant speed, reversed with [`REVERSAL_ACCELERATION`].
#[derive(Debug, Clone)]
struct Stroke {
    speed: f64,
    half: f64,
    position: f64,
    velocity: f64,
    direction: f64,
    /// Time for which the full speed has been held, s.
    steady: f64,
}

/// Time at full speed before the steady window of a stroke begins, as a fraction of the stroke's duration:
/// the slip front travels through the sheath.
const RUN_IN: f64 = 0.3;

impl Stroke {
    fn new(speed: f64, length: f64) -> Self {
        Self { speed, half: 0.5 * length, position: 0.0, velocity: 0.0, direction: 1.0, steady: 0.0 }
    }

    fn next(&mut self) -> f64 {
        let braking = self.velocity * self.velocity / (2.0 * REVERSAL_ACCELERATION);
        if self.direction * self.position + braking >= self.half {
            self.direction = -self.direction;
        }
        let target = self.direction * self.speed;
        let most = REVERSAL_ACCELERATION * STEP;
        self.velocity += (target - self.velocity).clamp(-most, most);
        self.position += self.velocity * STEP;
        let full = (self.velocity - target).abs() < 1e-12;
        self.steady = if full { self.steady + STEP } else { 0.0 };
        self.velocity
    }

    fn window(&self) -> f64 {
        let run_in = RUN_IN * 2.0 * self.half / self.speed;
        if self.steady > run_in { self.direction } else { 0.0 }
    }
}

#[cfg(test)]
mod tests {
    use super::*;

    #[test]
    fn runs_in_lanes_are_those_alone_to_the_bit() {
        let entry = |k: u64| {
            let paper = BenchRun::paper(Specimen::draw(k), Programme::Calibrate, 0.05 + 0.05 * k as f64, k);
            let resolution = Resolution { cells: if k.is_multiple_of(3) { 16 } else { 24 }, substeps: 2 };
            CalibrationRun {
                run: BenchRun { resolution, ..paper },
                seconds: 0.3 + 0.1 * (k * 7 % 11) as f64,
                decimation: 1 + k as usize % 4,
            }
        };
        // More than one batch, of different durations and resolutions.
        let all: Vec<_> = (0..14).map(entry).collect();
        for (of, kept) in all.iter().zip(run_all(&all).unwrap()) {
            let mut rows = Vec::new();
            let uncompensated = MuscleControl::Compensation(&mut Compensation::None);
            assert_eq!(run(&of.run, uncompensated, of.seconds, |row| rows.push(*row)).unwrap(), None);
            let expected: Vec<String> =
                rows.iter().step_by(of.decimation).map(|row| format!("{row:?}")).collect();
            let kept: Vec<String> = kept.unwrap().iter().map(|row| format!("{row:?}")).collect();
            assert_eq!(kept, expected);
        }
    }
}
