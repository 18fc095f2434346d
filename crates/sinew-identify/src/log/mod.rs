//! Logs in: files to tables, tables to conditioned sequences.
//!
//! ```text
//! file --open--> columns --roles--> table (requested columns only) --cut--> sequences --> Dataset
//! ```
//!
//! | step      | module       | what it decides                                                       |
//! |-----------|--------------|-----------------------------------------------------------------------|
//! | open      | `open`       | the format, by content and then by extension                          |
//! | text      | `text`       | delimiter, decimal comma, comments, header, units row                 |
//! | binary    | `binary`     | which arrays are columns: MATLAB v5, v7.3, Parquet                    |
//! | naming    | `naming`     | one name and one unit for what several logs hold; `units` knows factors           |
//! | roles     | `roles`      | what each column means, as requested or by the names in `names`       |
//! | uses      | `uses`       | which column by name is a label instead, and the account of all columns |
//! | table     | `table`      | numbers, labels, and columns that are constant within trials          |
//! | sequences | `cut`        | trials, gaps, repeated rows, skipped seconds                          |
//! | spikes    | `spikes`     | single samples that no cable can have produced                        |
//! | dataset   | `assemble`   | conditions, duplicated logs                                           |
//! | checks    | `signal_checks` | whether samples and changing signals suffice                       |
//! | plateaus  | `plateaus`   | whether a channel is clipped at a bound or frozen for a stretch        |
//! | durations | `durations`  | whether a log is too short, or of another clock than the others       |
//! | likeness  | `likeness`   | whether an input is a copy of the far side, or a log mirrored         |
//!
//! Every repair is reported: whatever was skipped, dropped or cut is a sentence in
//! [`LogInfo::findings`], and whatever cannot be used is an [`Error`](crate::Error) that names its place.

mod assemble;
mod binary;
mod clock;
mod conditions;
mod cut;
mod duplicates;
mod durations;
mod likeness;
mod memory_limit;
mod names;
mod naming;
mod occurrences;
mod one_log;
mod open;
mod plateaus;
mod read;
mod roles;
mod signal_checks;
mod spikes;
mod table;
mod text;
mod times;
mod types;
mod units;
mod uses;

pub use memory_limit::MEMORY_LIMIT_BYTES;
pub use read::{read_bytes, read_bytes_with_roles, read_dataset, read_references, read_with_roles};
pub use signal_checks::MIN_SCORED;
pub use times::{GAP_INTERVALS, GAP_TYPICAL};
pub use types::{
    ColumnOptions, ColumnUse, Condition, Dataset, Defect, DefectKind, Input, LogInfo, ReadOptions,
    RequestedRoles, Role, Roles, Sequence,
};
pub(crate) use units::factor;
pub use units::unit_of;
