//! Experiments on simulated cable-driven robots: the only crate in which plant and controller meet.
//!
//! | module         | content                                                                            |
//! |----------------|------------------------------------------------------------------------------------|
//! | [`experiment`] | one run: the plant under a controller, on the bench or along a trajectory            |
//! | [`calibrate`]  | compensation of one cable, identified from calibration runs on the bench             |
//! | [`arm`]        | planning, calibration of all cables, tracking, and the numbers of a run              |
//! | [`reproduce`]  | the programme of `yuan2023`: its tables and figures with simulated numbers            |
//! | [`paper`]      | the numbers that `yuan2023` reports                                                  |
//! | [`machine_file`] | machines and robots from files, and those that come with the program             |
//! | [`vision`]     | a machine that calibrates its geometry with a camera                                  |
//! | [`simulated`]  | logs of a simulated bench, labelled as such, for demonstrations                       |
//!
//! All results are simulated.

pub mod arm;
pub mod calibrate;
pub mod experiment;
pub mod machine_file;
pub mod paper;
pub mod reproduce;
pub mod simulated;
pub mod vision;

mod error;
mod variant;

pub use error::Error;
pub use sinew_session::signals;
pub use variant::CompensationVariant;
