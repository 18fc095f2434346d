//! Experiments on the twin: runs in which a plant and a controller meet.

pub mod arm;
pub mod bench;
mod bench_oracle;
mod error_peaks;
mod evaluation;
mod oracle;
mod run;
mod statistics;
mod track_row;
mod track_summary;
mod tracking_errors;

pub use error_peaks::ErrorPeak;
pub use evaluation::Evaluation;
pub use oracle::oracle_models;
pub use statistics::Statistics;
pub use track_row::TrackRow;
pub use track_summary::{FaultInterval, ModeChange, SETTLING, Slack, TrackSummary};
