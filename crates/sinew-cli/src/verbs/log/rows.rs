//! The cycles of a recording as rows of a table.

use crate::error::Error;
use sinew::machine::Machine;
use sinew::muscle::MuscleDynamics;
use sinew_record::{Block, Coding, ColumnSpec, Head, Recording};
use std::path::Path;

/// A column of a table.
pub(super) struct Column {
    pub(super) name: String,
    /// Digits behind the point; none for all.
    pub(super) digits: Option<usize>,
    source: Source,
}

/// Where the numbers of a column come from.
#[derive(Debug, Clone, Copy)]
enum Source {
    Time,
    Fast(usize),
    Slow(usize),
    /// Displacement of the anchor of a muscle by the joints' encoders, m, + toward the motor.
    Anchor(usize),
}

/// What the rows of a recording had.
pub(super) struct Given {
    /// How many there were.
    pub(super) count: u64,
    /// Columns without a number in any of them.
    pub(super) empty: Vec<String>,
}

/// The rows of a recording.
pub(super) struct Rows<'a> {
    pub(super) columns: Vec<Column>,
    recording: &'a Recording<'a>,
    every: u64,
    joints: usize,
    /// Kinematics for the anchors, and the lengths of the first row, m.
    model: Option<(MuscleDynamics, Vec<f64>)>,
}

impl<'a> Rows<'a> {
    /// Every so many cycles, with all columns that have a number then.
    pub(super) fn all(recording: &'a Recording<'a>, every: u64) -> Self {
        let head = &recording.head;
        let mut columns = vec![time()];
        columns.extend(head.fast.iter().enumerate().map(|(k, spec)| column(spec, Source::Fast(k))));
        if every.is_multiple_of(head.stride) {
            columns.extend(head.slow.iter().enumerate().map(|(k, spec)| column(spec, Source::Slow(k))));
        }
        Self { columns, recording, every, joints: 0, model: None }
    }

    /// The transmission of one muscle as identification reads it.
    pub(super) fn of_muscle(
        recording: &'a Recording<'a>,
        machine: &Machine,
        name: &str,
    ) -> Result<Self, Error> {
        let head = &recording.head;
        let muscle = head.muscles.iter().position(|muscle| muscle == name);
        let unknown = || Error::unknown("--muscle", name, "muscle", head.muscles.clone());
        let muscle = muscle.ok_or_else(unknown)?;
        let mut columns = vec![time()];
        for what in ["tension_in_n", "position_in_m"] {
            columns.extend(
                find(&head.fast, &format!("{what}:{name}"))
                    .map(|(k, spec)| Column { name: what.to_owned(), ..column(spec, Source::Fast(k)) }),
            );
        }
        let anchor = Column { name: "anchor_m".to_owned(), digits: Some(9), source: Source::Anchor(muscle) };
        columns.push(anchor);
        for what in ["tension_out_n", "tension_out_estimated_n"] {
            columns.extend(
                find(&head.slow, &format!("{what}:{name}"))
                    .map(|(k, spec)| Column { name: what.to_owned(), ..column(spec, Source::Slow(k)) }),
            );
        }
        let first = head.joints.first().and_then(|joint| {
            find(&head.fast, &format!("joint_{}:{}", joint.unit, joint.name)).map(|(k, _)| k)
        });
        let model = Some((MuscleDynamics::new(&machine.robot)?, Vec::new()));
        Ok(Self { columns, recording, every: head.stride, joints: first.unwrap_or(0), model })
    }

    /// Gives every row to `put`.
    pub(super) fn each(
        mut self,
        file: &Path,
        mut put: impl FnMut(&[Column], &[f64]) -> Result<(), Error>,
    ) -> Result<Given, Error> {
        let (mut count, mut row) = (0, vec![0.0; self.columns.len()]);
        let mut has_numbers = vec![false; row.len()];
        for block in self.recording.blocks() {
            let block = block.map_err(Error::recording(file))?;
            for cycle in 0..block.count {
                if (block.first + cycle as u64).is_multiple_of(self.every) {
                    self.fill(&block, cycle, &mut row)?;
                    has_numbers.iter_mut().zip(&row).for_each(|(has, value)| *has |= value.is_finite());
                    put(&self.columns, &row)?;
                    count += 1;
                }
            }
        }
        let columns = self.columns.into_iter().zip(has_numbers);
        let empty = columns.filter(|(_, has)| !has).map(|(column, _)| column.name).collect();
        Ok(Given { count, empty })
    }

    fn fill(&mut self, block: &Block, cycle: usize, row: &mut [f64]) -> Result<(), Error> {
        let head = &self.recording.head;
        let at = |columns: &[Vec<f64>], column: usize, row: usize| {
            columns.get(column).and_then(|column| column.get(row)).copied().unwrap_or(f64::NAN)
        };
        let slow = block.slow_row(cycle, head.stride);
        let (mut lengths, mut start) = (&[][..], &[][..]);
        if let Some((model, first)) = &mut self.model {
            let q: Vec<f64> =
                (0..head.joints.len()).map(|k| at(&block.fast, self.joints + k, cycle)).collect();
            if q.iter().all(|q| q.is_finite()) {
                model.evaluate(&q)?;
                if first.is_empty() {
                    first.extend_from_slice(model.lengths());
                }
                (lengths, start) = (model.lengths(), first);
            }
        }
        for (value, column) in row.iter_mut().zip(&self.columns) {
            *value = match column.source {
                Source::Time => (block.first + cycle as u64) as f64 * head.period_s(),
                Source::Fast(k) => at(&block.fast, k, cycle),
                Source::Slow(k) => slow.map_or(f64::NAN, |slow| at(&block.slow, k, slow)),
                Source::Anchor(k) => match (start.get(k), lengths.get(k)) {
                    (Some(start), Some(length)) => start - length,
                    _ => f64::NAN,
                },
            };
        }
        Ok(())
    }
}

fn time() -> Column {
    Column { name: "time_s".to_owned(), digits: Some(6), source: Source::Time }
}

/// A column by its name.
pub(super) fn find<'a>(columns: &'a [ColumnSpec], name: &str) -> Option<(usize, &'a ColumnSpec)> {
    columns.iter().enumerate().find(|(_, column)| column.name == name)
}

fn column(spec: &ColumnSpec, source: Source) -> Column {
    let digits = match spec.coding {
        Coding::Exact(_) => None,
        Coding::Rounded(resolution) => Some((-resolution.log10()).round().clamp(0.0, 15.0) as usize),
    };
    Column { name: spec.name.clone(), digits, source }
}

/// A joint's name among the columns of a kind.
pub(super) fn joint_column(head: &Head, what: &str, joint: usize) -> String {
    let joint = &head.joints[joint];
    format!("{what}_{}:{}", joint.unit, joint.name)
}
