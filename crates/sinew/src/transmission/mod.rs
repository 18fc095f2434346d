//! Laws of the cable in its sheath and over its pulleys: one law, one file.
//!
//! Laws without memory take tensions in N and angles in rad and return a checked number. Laws with
//! memory are an immutable, validated set of parameters (`Dahl`, `LuGre`, ...) and a state the caller
//! owns; their `step` never allocates, never panics, and keeps the state when the input is not
//! finite. Every friction force among them is passive: no closed cycle returns more work than was put in.

mod bouc_wen;
pub mod cable;
mod capstan;
mod clamp_cell;
mod dahl;
mod elongation;
mod lugre;
mod network;
mod play;
mod pulley;
mod sheath;
mod sheath_bend;
mod sliding;
mod stribeck;
mod warming;

pub use bouc_wen::BoucWen;
pub use capstan::capstan_tension_out;
pub use clamp_cell::{Band, BasisTerm, Bound, Branch, ClampCell, ClampStep, saturate};
pub use dahl::Dahl;
pub use elongation::{Elongation, transmission_length};
pub use lugre::{LuGre, LuGreStep};
pub use network::{Perceptron, PerceptronWeights};
pub use play::Play;
pub use pulley::{Pulley, total_wrap_angle};
pub use sheath::SheathLaw;
pub use sheath_bend::SheathBend;
pub use sliding::Sliding;
pub use stribeck::Stribeck;
pub use warming::Warming;
