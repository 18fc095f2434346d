//! The variables of a model's unit: names, units, start values.

use super::description::{Description, Variable, VariableKind};
use super::unit_of::unit;
use crate::ExportError;
use crate::c::{Content, checksum};
use sinew::predictor::{Input, InputLimits, Model};
use std::collections::BTreeSet;

/// The side of the transmission whose unit a number has.
#[derive(Debug, Clone, Copy, PartialEq, Eq)]
pub(super) enum Side {
    Near,
    Far,
    Neither,
}

/// A number that comes out: name, description, side.
pub(super) type Number = (&'static str, &'static str, Side);

const DEVIATION: Number =
    ("standard_deviation", "prediction +- 1.96 of it is the calibrated 95 % band", Side::Far);
const GATE: Number = ("gate", "weight of the learned correction, 0 to 1", Side::Neither);
const PREDICTION: [Number; 3] = [("prediction", "the far end", Side::Far), DEVIATION, GATE];
const COMMAND: [Number; 6] = [
    ("command", "the near side for the desired far end", Side::Near),
    ("command_low", "the command at one end of the 95 % band of the far end", Side::Near),
    ("command_high", "the command at the other end", Side::Near),
    ("prediction", "the far end at this command", Side::Far),
    DEVIATION,
    GATE,
];

/// The input for the direction in which a cable will slide.
const DIRECTION: &str = "sliding_direction";

/// A flag that comes out: name, description.
pub(super) type Flag = (&'static str, &'static str);

const STATE_UNKNOWN: Flag = ("state_unknown", "the state in the dead band depends on its start");
const OUT_OF_RANGE: Flag = ("out_of_range", "an input is outside the range of the training logs");
const INPUT_HELD: Flag = ("input_held", "an input was missing or jumped: its last value stood in");
const RESET: Flag = ("reset", "all states started at this sample");
const OTHER: Flag =
    ("other_specimen", "the loops of this sequence are not those of the specimen of the training logs");
const PREDICTION_FLAGS: [Flag; 5] = [STATE_UNKNOWN, OUT_OF_RANGE, INPUT_HELD, RESET, OTHER];
const COMMAND_FLAGS: [Flag; 7] = [
    ("not_attainable", "with this command the far end is not the desired one"),
    ("rate_limited", "the command moves as fast as it may"),
    OUT_OF_RANGE,
    ("correction_withdrawn", "the networks disagree: less than half of their correction counts"),
    STATE_UNKNOWN,
    INPUT_HELD,
    RESET,
];

/// What a unit takes and gives.
pub(super) struct Interface<'a> {
    pub(super) model: &'a Model,
    /// The input that is commanded: what goes in is the measured one, and the desired far end behind all
    /// inputs. None of a predictor.
    pub(super) near: Option<usize>,
    pub(super) numbers: &'static [Number],
    pub(super) flags: &'static [Flag],
}

impl<'a> Interface<'a> {
    pub(super) fn new(model: &'a Model, content: Content) -> Self {
        match content {
            Content::Predictor => Self { model, near: None, numbers: &PREDICTION, flags: &PREDICTION_FLAGS },
            Content::Compensator(settings) => {
                let near = settings.near_of(model);
                Self { model, near, numbers: &COMMAND, flags: &COMMAND_FLAGS }
            }
        }
    }

    /// Columns of the inputs, and that of the desired far end; behind them the direction of sliding, where a
    /// cable's motor is commanded.
    fn columns(&self) -> Vec<&'a str> {
        let desired = self.near.map(|_| self.model.far.as_str());
        let direction = desired.filter(|_| self.model.estimator.law.cable.is_some()).map(|_| DIRECTION);
        let inputs = self.model.inputs.iter().map(|input: &'a Input| input.column.as_str());
        inputs.chain(desired).chain(direction).collect()
    }

    /// Names of the inputs: their columns; one that is taken already has its number behind it.
    fn input_names(&self) -> Vec<String> {
        let outputs =
            self.numbers.iter().map(|(name, ..)| *name).chain(self.flags.iter().map(|(name, _)| *name));
        let mut taken: BTreeSet<String> = outputs.chain(["time"]).map(str::to_owned).collect();
        let mut names = Vec::new();
        for (k, column) in self.columns().into_iter().enumerate() {
            let mut name = column.to_owned();
            while name.is_empty() || !taken.insert(name.clone()) {
                name += &format!("_{}", k + 1);
            }
            names.push(name);
        }
        names
    }

    /// What the unit of this model is.
    pub(super) fn description(&self) -> Result<Description, ExportError> {
        let (model, mut variables) = (self.model, vec![Variable::time()]);
        let inputs = self.columns().into_iter().zip(self.input_names()).zip(self.starts());
        for (k, ((column, name), start)) in inputs.enumerate() {
            let (description, end) = match model.guards.get(k) {
                None if k == model.inputs.len() => ("desired".to_owned(), "far"),
                None => {
                    let signs = "expected direction of sliding: > 0 toward the motor, < 0 away, 0 not known";
                    (signs.to_owned(), "near")
                }
                Some(_) if self.near == Some(k) => {
                    ("measured; NaN: the drive is taken to follow".to_owned(), "near")
                }
                Some(limits) => (format!("{} to {} in training", limits.low, limits.high), "near"),
            };
            let terminal = Some((end.to_owned(), name.clone()));
            let kind = VariableKind::Input { start };
            variables.push(Variable { name, description, unit: unit(column), terminal, kind });
        }
        for (k, &(name, description, side)) in self.numbers.iter().enumerate() {
            let column = self.column_of(side);
            let description = match column {
                Some(column) if k == 0 => format!("{description}: {column}"),
                _ => description.to_owned(),
            };
            let end = match side {
                Side::Near => Some("near"),
                Side::Far => Some("far"),
                Side::Neither => None,
            };
            let terminal = end.map(|end| (end.to_owned(), name.to_owned()));
            let (unit, kind) = (column.and_then(unit), VariableKind::Number);
            variables.push(Variable { name: name.to_owned(), description, unit, terminal, kind });
        }
        for &(name, description) in self.flags {
            let (name, description, kind) = (name.to_owned(), description.to_owned(), VariableKind::Flag);
            variables.push(Variable { name, description, unit: None, terminal: None, kind });
        }
        let (far, member) = (&model.far, &model.provenance.member);
        let description = match self.near {
            None => format!("{far} predicted by `{member}`"),
            Some(near) => format!("{} for a desired {far}, by `{member}`", model.inputs[near].column),
        };
        Ok(Description { description, token: self.token()?, variables, step_s: 0.001, needs_tool: false })
    }

    /// Start values of the inputs; nothing is measured, zero is desired of the far end, and no direction
    /// known.
    fn starts(&self) -> Vec<f64> {
        let start =
            |(k, limits): (usize, &InputLimits)| if self.near == Some(k) { f64::NAN } else { limits.typical };
        let mut starts: Vec<f64> = self.model.guards.iter().enumerate().map(start).collect();
        starts.resize(self.columns().len(), 0.0);
        starts
    }

    /// The column whose unit a number has.
    fn column_of(&self, side: Side) -> Option<&'a str> {
        match side {
            Side::Near => self.near.map(|near| self.model.inputs[near].column.as_str()),
            Side::Far => Some(self.model.far.as_str()),
            Side::Neither => None,
        }
    }

    /// The token that tells units of different models apart.
    fn token(&self) -> Result<String, ExportError> {
        let inverse = if self.near.is_some() { "-inverse" } else { "" };
        Ok(format!("{{sinew-{}{inverse}}}", checksum(self.model)?))
    }
}
