//! The report of an identification as plain data: what was fitted, with which error, how far it can be
//! trusted.

mod assessment;
pub(crate) mod build;
mod evidence;
mod excitation;
mod headline;
mod parameters;
mod recommendations;
mod traces;
mod types;

pub use crate::fit::classical::{ClassicalFit, Parameter};
pub use crate::select::influence::InfluenceRow;
pub(crate) use evidence::Evidence;
pub use headline::Headline;
pub use types::{
    Candidate, ChosenSummary, ExpectedError, Grade, IdentificationReport, InputTrace, Noticed, Trace,
};
