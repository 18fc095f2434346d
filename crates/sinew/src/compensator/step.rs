//! The compensator: one command per sample.

use super::cable::{CableGoal, CableStretch};
use super::command::{Command, CommandFlags};
use super::direction::direction;
use super::error::CompensatorError;
use super::reach::Reach;
use super::response::Response;
use super::search::{Goal, search};
use super::settings::{CompensatorSettings, Limits};
use crate::error::within;
use crate::predictor::{Model, ModelFileError, Prediction, Predictor, Role, Sample, SampleKind};
use crate::transmission::Sliding;
use alloc::string::ToString;
use alloc::vec;
use alloc::vec::Vec;

/// Maximum of halvings in the search for the command, and for either end of its band.
const HALVINGS: u32 = 50;
const BAND_HALVINGS: u32 = 12;

/// Maximum of evaluations of the model in one command: the start, the search, the command, and both ends
/// of the band.
pub const MAX_EVALUATIONS: u32 = 1 + (1 + HALVINGS) + 1 + 2 * (1 + BAND_HALVINGS) + 1;

/// Tolerance of the band's ends as a fraction of its half width.
const BAND_TOLERANCE: f64 = 0.02;

/// Fraction of the far side's range in training that a far end may be off and be attained.
const ATTAINED: f64 = 1e-6;

/// Gate below which the learned correction counts as withdrawn.
const WITHDRAWN: f64 = 0.5;

/// Largest displacement of a cable's motor in one sample, m, below that which its observer takes for a fault
/// of the encoder.
const MAX_DISPLACEMENT: f64 = 0.049;

/// Time in which the exact command of a cable's motor corrects an error of its far end, s: in one sample, the
/// motor would have to move at its limits to and fro.
const CORRECTION_TIME: f64 = 0.003;

/// Stretch that encoders with fixed zeros may have at the first sample, m.
const MAX_STRETCH: f64 = 1.0;

/// The near-side command for a desired far end, sample by sample.
///
/// Two ways to use it. A controller tells what it [measured](Self::observe) and asks for the
/// [command](Self::command) of the time by which its drive can be there; a file is worked through by
/// [`step`](Self::step), where what was measured stands beside what is desired, or the drive is taken to
/// follow. None allocates, locks or calls the system, and none can fail.
///
/// A cable's observer follows its motor: the command is the motor's position, and a near tension that is
/// missing is what the model expects. Every other model is commanded by its first effort, or else its first
/// motion; its other inputs are given.
///
/// # Example
/// ```
/// # fn main() -> Result<(), Box<dyn std::error::Error>> {
/// # use sinew::predictor::{Estimator, InputLimits, Input, MemoryLaw, Model, Provenance, Role, Signal};
/// # use sinew::transmission::{Branch, ClampCell, BasisTerm};
/// # let cell = ClampCell {
/// #     basis: vec![BasisTerm::Signal(0)], low: vec![0.5], high: vec![2.0], elastic: vec![], kappa: vec![],
/// #     start: 0.5,
/// #     branches: vec![Branch { width: 1.0, fraction: 1.0 }],
/// # };
/// # let law = MemoryLaw { signals: vec![Signal::Input(0)], cell: Some(cell), cable: None, axis: None, features: vec![] };
/// # let model = Model {
/// #     far: "tension_out_n".into(), time: None, trial: None, gap_s: 0.1, band_factor: 2.0, specimen: None, offset: None, outside: None, units: Default::default(),
/// #     inputs: vec![Input { column: "tension_in_n".into(), role: Role::Effort }],
/// #     guards: vec![InputLimits { jump: 1e3, low: 0.0, high: 300.0, typical: 100.0 }],
/// #     estimator: Estimator { sigma0: 1.0, ..Estimator::of(law) },
/// #     provenance: Provenance {
/// #         member: "cell".into(), description: "by hand".into(), program: "none".into(), seed: 1,
/// #         logs: vec![], samples: 0, rmse_unseen: 1.0, far_range: 200.0,
/// #     },
/// # };
/// use sinew::compensator::{Compensator, CompensatorSettings};
/// use sinew::predictor::Sample;
///
/// // Half of a pull arrives; a drive that yields leaves twice its tension at the far end.
/// let mut compensator = Compensator::new(model, &CompensatorSettings::default())?;
/// compensator.observe(&Sample { time_s: 0.0, inputs: &[10.0] });
/// let pulled = compensator.step(&Sample { time_s: 0.001, inputs: &[f64::NAN] }, 40.0);
/// assert!((pulled.value - 80.0).abs() < 1e-3 && !pulled.flags.not_attainable);
/// let eased = compensator.step(&Sample { time_s: 0.002, inputs: &[f64::NAN] }, 39.0);
/// assert!((eased.value - 19.5).abs() < 1e-3); // across the dead band
/// # Ok(())
/// # }
/// ```
#[derive(Debug, Clone)]
pub struct Compensator {
    predictor: Predictor,
    trial: Predictor,
    limits: Limits,
    /// Far end over near side: rising, falling, or 0 where they have nothing to do with each other.
    direction: f64,
    /// Error of the far end that counts as attained.
    attained: f64,
    cable: Option<CableCommand>,
    given: Vec<f64>,
    row: Vec<f64>,
    desired: Option<f64>,
    last: Command,
}

/// Numbers by which a [`Compensator`] works.
#[derive(Debug, Clone, Copy, PartialEq)]
pub struct CompensatorConstants {
    /// Index of the input that is commanded.
    pub near: usize,
    /// Positive where the far end rises with it, negative where it falls, 0 where it does not depend on it.
    pub direction: f64,
    /// Smallest and largest command, near unit.
    pub command: [f64; 2],
    /// Largest rate of the command, near unit per s.
    pub rate: f64,
    /// Error of the far end that is no reason to move, far unit, and that counts as attained.
    pub tolerance: f64,
    /// See [`tolerance`](Self::tolerance).
    pub attained: f64,
    /// Of a cable's motor.
    pub cable: Option<CableConstants>,
}

/// Numbers by which the motor of a cable is commanded.
#[derive(Debug, Clone, Copy, PartialEq)]
pub struct CableConstants {
    /// Whether the far end rises with the near tension.
    pub rising: bool,
    /// Smallest and largest near tension of a first sample, in the unit of its column.
    pub tension: [f64; 2],
    /// Largest change of the command from one sample to the next, near unit, and at the first one.
    pub change: f64,
    /// See [`change`](Self::change).
    pub first_change: f64,
}

/// What is special about the command of a cable's motor.
#[derive(Debug, Clone)]
struct CableCommand {
    /// Column of the near tension.
    tension: usize,
    /// Limits of a near tension that is sought.
    tension_limits: Limits,
    /// Column of the anchor, and metres per unit of it and of the motor's column.
    anchor: usize,
    anchor_scale: f64,
    motor_scale: f64,
    stretch: CableStretch,
    /// Whether the far column rises with the tension.
    rising: bool,
    /// Largest change in a sample, and at the first one, motor unit.
    step: f64,
    first: f64,
}

impl Compensator {
    /// A compensator before its first sample.
    ///
    /// # Errors
    /// [`CompensatorError::Model`] as [`Model::validate`], and where no input can be commanded;
    /// [`CompensatorError::Settings`] names a setting outside its domain.
    pub fn new(model: Model, settings: &CompensatorSettings) -> Result<Self, CompensatorError> {
        model.validate()?;
        let none = || ModelFileError {
            name: "inputs".to_string(),
            expected: "a tension, torque or position of the near side to command".to_string(),
            got: "others alone".to_string(),
        };
        let near = commandable(&model, settings.near_of(&model).ok_or_else(none)?)?;
        let limits = settings.limits(&model, near)?;
        let law = model.estimator.law.cable.as_ref().filter(|cable| cable.columns.motor == near);
        let cable = match law {
            None => None,
            Some(cable) => {
                let (tension, scale) = (cable.columns.tension, cable.columns.motor_scale.abs());
                let alone = CompensatorSettings { tolerance: Some(limits.tolerance), ..Default::default() };
                Some(CableCommand {
                    tension,
                    anchor: cable.columns.anchor,
                    anchor_scale: cable.columns.anchor_scale,
                    motor_scale: cable.columns.motor_scale,
                    stretch: CableStretch::new(cable)?,
                    rising: cable.model.far_gain > 0.0,
                    tension_limits: alone.limits(&model, tension)?,
                    step: MAX_DISPLACEMENT / scale,
                    first: if cable.model.zero_stretch.is_some() { MAX_STRETCH / scale } else { 0.0 },
                })
            }
        };
        let inputs = model.inputs.len();
        Ok(Self {
            direction: direction(&model, near)?,
            attained: limits.tolerance.max(ATTAINED * model.provenance.far_range.abs()),
            trial: Predictor::new(model.clone())?,
            predictor: Predictor::new(model)?,
            limits,
            cable,
            given: vec![f64::NAN; inputs],
            row: vec![f64::NAN; inputs],
            desired: None,
            last: Command::default(),
        })
    }

    /// The numbers by which it works, for the same compensator in another language.
    #[must_use]
    pub fn constants(&self) -> CompensatorConstants {
        CompensatorConstants {
            near: self.limits.near,
            direction: self.direction,
            command: self.limits.range(),
            rate: self.limits.rate,
            tolerance: self.limits.tolerance,
            attained: self.attained,
            cable: self.cable.as_ref().map(|cable| CableConstants {
                rising: cable.rising,
                tension: cable.tension_limits.range(),
                change: cable.step,
                first_change: cable.first,
            }),
        }
    }

    /// The model.
    #[must_use]
    pub fn model(&self) -> &Model {
        self.predictor.model()
    }

    /// Index of the input that is commanded.
    #[must_use]
    pub fn near(&self) -> usize {
        self.limits.near
    }

    /// The inputs of the last command: those given, with the command in the near column and, for a cable, a
    /// near tension that was missing as the model expects it.
    #[must_use]
    pub fn inputs(&self) -> &[f64] {
        &self.row
    }

    /// Resets all states: the next sample starts a new sequence.
    pub fn reset(&mut self) {
        self.predictor.reset();
        self.desired = None;
        if let Some(cable) = &mut self.cable {
            cable.stretch.reset();
        }
        self.last = Command::default();
    }

    /// The direction in which a cable will slide at its anchor by the time its drive has crossed the dead
    /// band, for a controller that knows its motion: the commands that follow go by the stretch of that
    /// direction, before the cable turns. `None`, also after a [`reset`](Self::reset): the motion shows it,
    /// so after the cable has turned. The motor of a cable's observer alone heeds it.
    pub fn expect_sliding(&mut self, direction: Option<Sliding>) {
        if let Some(cable) = &mut self.cable {
            cable.stretch.expect(direction);
        }
    }

    /// The direction of sliding at the anchor by which the last command of a cable's motor went.
    #[must_use]
    pub fn sliding(&self) -> Option<Sliding> {
        self.cable.as_ref().and_then(|cable| cable.stretch.sliding())
    }

    /// Moves the model's state by a sample as it was measured, in the order of [`Model::inputs`]; what the
    /// model says of the far end.
    pub fn observe(&mut self, sample: &Sample<'_>) -> Prediction {
        self.predictor.step(sample)
    }

    /// The command for the sample at `sample.time_s`, which lies ahead, for a desired far end. The other
    /// inputs are those that are expected then; the near one is not read, and NaN holds an input, or the
    /// desired far end, at its last value. The model's state is left as it is.
    pub fn command(&mut self, sample: &Sample<'_>, desired: f64) -> Command {
        let near = self.limits.near;
        for (k, given) in self.given.iter_mut().enumerate() {
            *given = sample.inputs.get(k).copied().filter(|_| k != near).unwrap_or(f64::NAN);
        }
        self.trial.copy_state(&self.predictor);
        let (kind, dt_s, taken) = self.trial.arrival(sample.time_s, &self.given);
        let reference = taken[near];
        let anchor = self.cable.as_ref().map_or(0.0, |cable| cable.anchor_scale * taken[cable.anchor]);
        if kind == SampleKind::Repeated {
            self.last.flags.repeated = true;
            self.last.flags.reset = false;
            return self.last;
        }
        let missing = !desired.is_finite();
        let left = match (&self.cable, self.desired) {
            (Some(_), Some(before)) if kind == SampleKind::Next => before - self.predictor.last_mean(),
            _ => 0.0,
        };
        let error = -left * CORRECTION_TIME / (CORRECTION_TIME + dt_s);
        self.desired = if missing { self.desired } else { Some(desired) };
        let query = self.query(kind, dt_s, reference);
        if query.column != near {
            self.given[near] = reference;
        }
        let mut response = Response {
            from: &self.predictor,
            trial: &mut self.trial,
            time_s: sample.time_s,
            given: &self.given,
            row: &mut self.row,
            column: query.column,
            expected: query.expected,
            count: 0,
        };
        let Query { reach, rising, .. } = query;
        let at_start = response.at(reach.start).mean;
        let desired = self.desired.unwrap_or(at_start);
        let crosses = kind == SampleKind::Next;
        let goal =
            Goal { desired: desired + error, tolerance: query.limits.tolerance, halvings: HALVINGS, crosses };
        let value = search(&reach, rising, at_start, goal, &mut |u| response.at(u).mean);
        let value = match (&mut self.cable, self.predictor.cable_place()) {
            (Some(cable), Some(place)) if crosses => {
                let scale = cable.motor_scale;
                let left = if self.last.flags.rate_limited { 0.0 } else { left };
                let commanded = self.last.value * scale;
                let time_s = sample.time_s;
                let goal = CableGoal { far: desired, anchor, time_s, ahead_s: dt_s, left, commanded };
                let [low, high] = cable.stretch.motor(&goal, &place).map(|motor| motor / scale);
                let [low, high] = if scale > 0.0 { [low, high] } else { [high, low] };
                value.max(low).min(high).max(reach.low).min(reach.high)
            }
            _ => value,
        };
        let prediction = response.at(value);
        let half_width = prediction.half_width();
        let mut edge = |desired: f64| {
            let tolerance = BAND_TOLERANCE * half_width;
            let goal = Goal { desired, tolerance, halvings: BAND_HALVINGS, crosses };
            search(&reach, rising, at_start, goal, &mut |u| response.at(u).mean)
        };
        let edges = [edge(desired - half_width), edge(desired + half_width)];
        response.at(value);
        let evaluations = response.count;
        let commands = query.column == near;
        let (value, [first, second]) = if commands { (value, edges) } else { (reference, [reference; 2]) };
        let others_missing = || {
            let known = |k: usize| k == near || query.expected == Some(k);
            self.given.iter().enumerate().any(|(k, given)| !known(k) && !given.is_finite())
        };
        let held = if query.expected.is_some() { others_missing() } else { prediction.flags.input_held };
        self.last = Command {
            value,
            low: first.min(second).min(value),
            high: first.max(second).max(value),
            mean: prediction.mean,
            standard_deviation: prediction.standard_deviation,
            gate: prediction.gate,
            evaluations,
            flags: CommandFlags {
                not_attainable: !self.is_attained(prediction.mean, desired),
                rate_limited: commands && reach.is_rate_limited(&query.limits, value),
                out_of_range: prediction.flags.out_of_range,
                correction_withdrawn: self.is_withdrawn(prediction.gate),
                state_unknown: prediction.flags.state_unknown,
                input_held: held || missing,
                reset: prediction.flags.reset,
                repeated: false,
            },
        };
        self.last
    }

    /// One sample of a file: the command for a desired far end, and the model's state moved by what was
    /// measured in the near column, or by the command where that is NaN.
    pub fn step(&mut self, sample: &Sample<'_>, desired: f64) -> Command {
        let command = self.command(sample, desired);
        if command.flags.repeated {
            return command;
        }
        let near = self.limits.near;
        let measured = sample.inputs.get(near).copied().filter(|value| value.is_finite());
        let tension = self.cable.as_ref().map(|cable| cable.tension);
        match (measured, tension.filter(|k| !self.given[*k].is_finite() && !command.flags.reset)) {
            (Some(measured), expected) => {
                self.given[near] = measured;
                match expected {
                    Some(tension) => {
                        self.predictor.step_expecting(sample.time_s, &mut self.given, tension);
                    }
                    None => {
                        self.predictor.step(&Sample { time_s: sample.time_s, inputs: &self.given });
                    }
                }
            }
            (None, _) => {
                // What the predictor says of the very row that is written, which may reject a tension that
                // jumps.
                let said = self.predictor.step(&Sample { time_s: sample.time_s, inputs: &self.row });
                (self.last.mean, self.last.standard_deviation) = (said.mean, said.standard_deviation);
                let desired = self.desired.unwrap_or(said.mean);
                self.last.flags.not_attainable = !self.is_attained(said.mean, desired);
            }
        }
        self.last
    }

    /// What is sought at a sample of a kind, `dt_s` after the one before, from the near side there.
    fn query(&self, kind: SampleKind, dt_s: f64, reference: f64) -> Query {
        let first = kind == SampleKind::First;
        let (near, limits) = (self.limits.near, self.limits);
        let guards = &self.model().guards;
        let plain =
            |reach| Query { column: near, expected: None, limits, reach, rising: self.direction > 0.0 };
        if self.direction == 0.0 {
            return plain(Reach::only(reference));
        }
        let Some(cable) = &self.cable else {
            let step = || Reach::from(&limits, reference, dt_s, guards[near].jump);
            return plain(if first { Reach::everywhere(&limits, reference) } else { step() });
        };
        let missing = !self.given[cable.tension].is_finite();
        if first && missing && cable.first == 0.0 {
            // The first profile follows from the near tension, not from the motor.
            let limits = cable.tension_limits;
            let reach = Reach::everywhere(&limits, guards[cable.tension].typical);
            return Query { column: cable.tension, expected: None, limits, reach, rising: cable.rising };
        }
        let reach = if first {
            Reach::from(&Limits { rate: f64::INFINITY, ..limits }, reference, 1.0, cable.first)
        } else {
            Reach::from(&limits, reference, dt_s, cable.step.min(guards[near].jump))
        };
        let expected = (missing && !first).then_some(cable.tension);
        Query { expected, ..plain(reach) }
    }

    fn is_attained(&self, mean: f64, desired: f64) -> bool {
        (mean - desired).abs() <= self.attained
    }

    fn is_withdrawn(&self, gate: f64) -> bool {
        let estimator = &self.model().estimator;
        estimator.ensemble.is_some() && estimator.gate_power.is_some() && gate < WITHDRAWN
    }
}

/// Where a command is sought.
#[derive(Debug, Clone, Copy)]
struct Query {
    /// The input that is varied: the near one, but at the start of a cable.
    column: usize,
    /// The near tension of a cable, where it is what the model expects.
    expected: Option<usize>,
    limits: Limits,
    reach: Reach,
    /// Whether the far end rises with that input.
    rising: bool,
}

/// An input that can be commanded.
fn commandable(model: &Model, near: usize) -> Result<usize, CompensatorError> {
    let role = model.inputs.get(near).map(|input| input.role);
    let observed = model.estimator.law.cable.as_ref();
    let moves = observed.is_none_or(|cable| cable.columns.motor == near);
    let expected = "the index of an effort or a motion, of a cable's observer that of its motor";
    let valid = moves && matches!(role, Some(Role::Effort | Role::Motion));
    within("near", expected, near as f64, valid)?;
    Ok(near)
}
