//! The page of `sinew reproduce`: the paper's tables and figures beside those of the simulation.

mod differences;
mod indices;
mod page;
mod plots;
mod tables;
mod verdict;

pub use page::{arm_view, render};
pub use verdict::paper_mean_rmse;
