//! Engine plugins for MuJoCo: friction of sheaths on the tendons of any model, elastic cables on winches.
//!
//! | plugin         | what it adds to a model                                                        | state |
//! |----------------|--------------------------------------------------------------------------------|-------|
//! | `sinew.sheath` | friction that grows with tension, with exact sticking, on tendons as they are    | none  |
//! | `sinew.cable`  | a winch and an elastic cable in its sheath, in the place of a tendon's actuator   | `2 cells + 5` numbers a cable |
//!
//! Neither a header nor a library of MuJoCo is needed to build this crate. A loader hands over the addresses
//! of three functions of MuJoCo and the offsets of the fields of its structures ([`fields`]), which differ
//! from version to version, and calls the function at [`connect_address`]. The loader of this project is the
//! Python module `sinew.mujoco`, which takes the offsets from MuJoCo's own description of its structures and
//! compares them with the addresses of MuJoCo's arrays.
//!
//! | file           | what it holds                                                                  |
//! |----------------|--------------------------------------------------------------------------------|
//! | `abi`          | all `unsafe` code: MuJoCo's structures as slices, callbacks, registration       |
//! | `layout`       | names and offsets of the fields                                                |
//! | `plugin`       | what both plugins are to `abi`, and errors                                     |
//! | `text`         | the plugins' configuration: patterns over tendon names with parameters          |
//! | `wiring`       | what a plugin derives from a model, kept per thread and found by its hash       |
//! | `sheath`, `cable` | `sinew.sheath`, `sinew.cable`                                               |

mod abi;
mod cable;
mod layout;
mod plugin;
mod sheath;
mod text;
mod view;
mod wiring;

pub use abi::connect_address;
pub use layout::{FieldKind, FieldName, fields};
