//! Physics, estimation and control of robots that are driven by cables in sheaths.
//!
//! No I/O, no clock, no threads, and no allocation after construction. The crate is `no_std` with `alloc`.
//!
//! # Rooms
//!
//! | module | contents |
//! |---|---|
//! | [`transmission`] | laws of friction and elasticity of a cable, and the discretised cable in its sheath |
//! | [`predictor`] | far-end tension from drive-side samples; cable observer; model file |
//! | [`compensator`] | the inverse: the near-side command for a desired far end, from the same model file |
//! | [`drive`] | motor, reducer, winch, their control loops and sensors |
//! | [`body`] | joints, kinematic tree, inverse and forward dynamics |
//! | [`muscle`] | lengths, moment arms and bends of cables over a body |
//! | `description` | robot files (MJCF, URDF, OpenSim, TOML) to a validated robot, and back; machine files |
//! | [`machine`] | a machine as designed: body, cables, drives, sensors, task, tolerances |
//! | [`trajectory`] | end-point paths, inverse kinematics along them, time laws |
//! | [`control`] | friction compensation, tension distribution, the controller of an arm, demands on drives |
//! | [`twin`] | the plant: cables with effects that no model has, a bench, an arm |
//! | [`metrics`], [`math`], [`random`] | error metrics, vectorisable functions, random numbers |
//!
//! # Example
//!
//! A cable in its sheath: the motor winds in 60 mm at 0.1 m/s while the anchor stands still.
//!
//! ```
//! use sinew::transmission::cable::{Cable, CableLaw, CableParameters, CablePath, EndMotion};
//!
//! let law = CableLaw::new(&CablePath::bench(), &CableParameters::bench(), 12)?;
//! let mut cable = Cable::new(law);
//! let mut ends = cable.ends();
//! for _ in 0..600 {
//!     ends = cable.step(1e-3, EndMotion { motor: 1e-4, anchor: 0.0 })?;
//! }
//! assert!(ends.tension_in > ends.tension_out); // friction of the sheath
//! assert!(ends.dissipated >= 0.0);
//! # Ok::<(), sinew::Error>(())
//! ```
//!
//! # Features
//!
//! | feature | default | adds |
//! |---|---|---|
//! | `description` | yes | `description`, `drive::Catalogue`, `drive::sizing`, `model-file`; pulls `roxmltree` and `toml` |
//! | `model-file` | yes | `predictor::Model::from_json` and `to_json`; pulls `serde_json` and `crc32fast` |
//!
//! A build for a microcontroller takes `default-features = false`: simulation, estimation and control without
//! parsers. Robots and models are then built from their public types, which implement the traits of `serde`.
//!
//! # Reproducibility
//!
//! Elementary functions come from `libm` and from [`math`], not from the platform, and results do not depend
//! on the instruction set that is chosen at run time, with one exception:
//! [`Robot::inverse_dynamics`](body::Robot::inverse_dynamics) and the forces computed with it (bias, gravity,
//! velocity) use fused multiply-add where the processor has it, and differ by rounding from those of a
//! processor without it. The same holds for what is computed from these forces: the controller of an arm, and
//! the arm of the twin. On one processor every run gives the same bits.
#![no_std]

extern crate alloc;
#[cfg(test)]
extern crate std;

pub mod body;
pub mod compensator;
pub mod control;
#[cfg(feature = "description")]
pub mod description;
mod dispatch;
pub mod drive;
mod error;
mod lanes;
pub mod machine;
pub mod math;
pub mod metrics;
pub mod muscle;
pub mod predictor;
pub mod random;
pub mod trajectory;
pub mod transmission;
pub mod twin;

pub use error::Error;

// The Rust code of the README is compiled with the examples of the documentation.
#[cfg(all(doctest, feature = "model-file"))]
#[doc = include_str!("../../../README.md")]
struct Readme;
