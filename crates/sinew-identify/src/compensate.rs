//! The inverse of a model along a file: desired far ends in, commands for the near side out.

use crate::Error;
use crate::log::{Dataset, Input, ReadOptions, Role, Roles, read_references};
use sinew::compensator::{Command, Compensator};
use sinew::predictor::{Model, Sample};
use sinew::transmission::Sliding;

/// Desired far ends with what is known of the near side, in the order of a model's inputs.
#[derive(Debug, Clone)]
pub struct Desired {
    /// The file as read; its inputs are in the order of `columns`.
    data: Dataset,
    /// For every input of the model its place among those that were read, if it is there.
    columns: Vec<Option<usize>>,
    /// The place of the desired far end among them.
    far: usize,
}

/// One row of a file of commands.
#[derive(Debug, Clone, PartialEq)]
pub struct CommandRow {
    /// The trial's label, or an empty string.
    pub trial: String,
    /// Time, s.
    pub time_s: f64,
    /// The inputs of the model, with the command in the near column: `[inputs]`.
    pub inputs: Vec<f64>,
    /// The desired far end; NaN where the cell is empty.
    pub desired: f64,
    /// The command.
    pub command: Command,
    /// The direction of sliding by which a cable's motor went.
    pub sliding: Option<Sliding>,
}

impl Desired {
    /// Reads a table with the model's far column, which holds what is desired, its time, and its inputs; the
    /// near column may be left out, and for a cable's motor the near tension, too.
    ///
    /// # Errors
    /// As [`read_with_roles`](crate::log::read_with_roles).
    pub fn read(compensator: &Compensator, options: &ReadOptions) -> Result<Self, Error> {
        let model = compensator.model();
        let near = compensator.near();
        let tension = model.estimator.law.cable.as_ref().map(|cable| cable.columns.tension);
        let optional = |column: &str| {
            let is = |k: usize| model.inputs.get(k).is_some_and(|input| input.column == column);
            is(near) || tension.is_some_and(is)
        };
        let mut columns_read: Vec<Input> = model.inputs.clone();
        // The far side stands among the inputs: it is required, and nothing in it is repaired.
        columns_read.push(Input { column: model.far.clone(), role: Role::Given });
        let data = loop {
            let roles = Roles {
                far: None,
                inputs: columns_read.clone(),
                time: model.time.clone(),
                trial: model.trial.clone(),
                units: model.units.clone(),
                group: None,
            };
            match read_references(&roles, options) {
                Err(Error::MissingColumn { column, .. }) if optional(&column) => {
                    columns_read.retain(|input| input.column != column);
                }
                read => break read?,
            }
        };
        let place = |column: &str| columns_read.iter().position(|input| input.column == column);
        let columns = model.inputs.iter().map(|input| place(&input.column)).collect();
        Ok(Self { data, columns, far: columns_read.len() - 1 })
    }

    /// The file as read, with what was noticed in it.
    #[must_use]
    pub fn data(&self) -> &Dataset {
        &self.data
    }

    /// The time column of the file; none where time is counted.
    #[must_use]
    pub fn time(&self) -> Option<&str> {
        self.data.roles.time.as_deref()
    }

    /// The trial column of the file, if it has one.
    #[must_use]
    pub fn trial(&self) -> Option<&str> {
        self.data.roles.trial.as_deref()
    }

    /// The command of every row, one after the other; states are reset where the trial changes. The motor
    /// of a cable's observer crosses its dead band `preview_s` seconds, >= 0, before the cable turns;
    /// other models have no use for it.
    #[must_use]
    pub fn commands(&self, compensator: &mut Compensator, preview_s: f64) -> Vec<CommandRow> {
        let rows = self.follow(compensator, &[]);
        if preview_s <= 0.0 || compensator.sliding().is_none() {
            return rows;
        }
        // The first pass has shown where the cable turns.
        let mut expected = Vec::with_capacity(rows.len());
        for sequence in &self.data.sequences {
            let (times, begin) = (&sequence.time_s, expected.len());
            expected.extend(times.iter().map(|now| {
                let ahead = times.partition_point(|time| *time < now + preview_s);
                rows[begin + ahead.min(times.len() - 1)].sliding
            }));
        }
        compensator.reset();
        self.follow(compensator, &expected)
    }

    /// The command of every row, with the direction of sliding to expect at it where there is one.
    fn follow(&self, compensator: &mut Compensator, expected: &[Option<Sliding>]) -> Vec<CommandRow> {
        let width = self.far + 1;
        let mut rows = Vec::new();
        let mut trial: Option<&str> = None;
        let mut inputs = vec![f64::NAN; self.columns.len()];
        for sequence in &self.data.sequences {
            if trial != Some(&sequence.trial) {
                compensator.reset();
                trial = Some(&sequence.trial);
            }
            for (&time_s, read) in sequence.time_s.iter().zip(sequence.inputs.chunks_exact(width)) {
                for (input, column) in inputs.iter_mut().zip(&self.columns) {
                    *input = column.map_or(f64::NAN, |k| read[k]);
                }
                let desired = read[self.far];
                compensator.expect_sliding(expected.get(rows.len()).copied().flatten());
                let command = compensator.step(&Sample { time_s, inputs: &inputs }, desired);
                let mut inputs = compensator.inputs().to_vec();
                inputs[compensator.near()] = command.value;
                let (trial, sliding) = (sequence.trial.clone(), compensator.sliding());
                rows.push(CommandRow { trial, time_s, inputs, desired, command, sliding });
            }
        }
        rows
    }
}

/// The index of an input by the name of its column.
#[must_use]
pub fn input_named(model: &Model, column: &str) -> Option<usize> {
    model.inputs.iter().position(|input| input.column == column)
}
