//! The page of `sinew reproduce`: the paper's tables and figures beside those of the simulation.

mod differences;
mod indices;
mod page;
mod plots;
mod tables;
mod verdict;

pub(crate) use page::{arm_view, render};
pub(crate) use verdict::paper_mean_rmse;
