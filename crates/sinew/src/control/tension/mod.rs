//! Which tension each muscle gets: more muscles than joints leave a choice.
//!
//! [`Distribution`] answers a [`Problem`] with a [`Solution`], always: where the torque cannot be reached, with the
//! closest one. It knows matrices, not robots. One thing per file: what is asked (`problem`), which joints have to
//! do with each other (`pattern`), what is tried for one group of joints (`search`): its multipliers (`newton` with its
//! `line_search` and `factor`, `few` where there are eight at most), the same for a torque out of reach (`softened`,
//! `closest`), and, where rounding stops these, in `twofold` numbers (`exact`, `anchored`).

mod anchored;
mod block;
mod closest;
mod cocontraction;
mod distribution;
mod exact;
mod factor;
mod few;
mod line_search;
mod newton;
mod pattern;
mod problem;
mod rows;
mod search;
mod softened;
mod twofold;

pub use block::Limit;
pub use cocontraction::cocontract;
pub use distribution::{Distribution, Solution, Status};
pub use problem::Problem;
