//! Machine files: a body, and what its description does not say about cables, drives, sensors and task.
//!
//! A machine file is TOML in SI units. The body is that of another file (`body = "leg.xml"`: MJCF, URDF,
//! OpenSim or the robot format of this project; with URDF `muscles = "leg.muscles.toml"`), or the tables
//! of a robot file stand in the machine file itself. Everything else has a default, and a body alone is a
//! machine.
//!
//! | table | keys | default |
//! |---|---|---|
//! | `start` | name of a pose, or `{ joint = value }`, rad or m | key pose `start`, else the reference pose |
//! | `[[pose]]` | `name`, `joints = { joint = value }` | none; joints that are not named are at their reference |
//! | `period_s` | of the control cycle, 0.0005 to 0.02 | 0.001 |
//! | `[task]` | `endpoint` (site), `axes` (some of x, y, z), or `space = "joints"` | site `endpoint`, all axes |
//! | `[redundancy]` | `rest`, `swing`, `weight`, each `{ joint = value }` | start, 0, 1 |
//! | `[[path]]` | `name`, `shape` (sine, saddle), `center_m`, `amplitude_m` | none |
//! | `[every_transmission]` | all but `muscle` of the next | |
//! | `[[transmission]]` | `muscle`; `near_length_m`, `sheath_length_m`, `sheath_bend_rad`, `bend_by_joint = { .. }`, `cable = { .. }`, `model`, `drive`, `tension_limits_n`, `load_cell = { .. }` or `"none"`, `motor_encoder_counts`, `delay_s` | [`MuscleDesign::in_sheath`](crate::machine::MuscleDesign::in_sheath) |
//! | `[[spring]]` | `name`; `path` or `joints` as a muscle's, or the name is that of a tendon of the body; `stiffness_n_per_m`, `slack_lengths_m` (two), `damping_n_s_per_m`, `one_sided` | those of the tendon; 0, the length where the joints' springs are at rest, false |
//! | `[[drive]]` | `name`; `motor`, `reducer`, `winch` by name in the catalogue or as numbers, `ratio`, `acceleration_m_per_s2`, `max_tension_n`, `min_tension_n` | [`DriveParameters::mc_am`](crate::drive::DriveParameters::mc_am) |
//! | `[every_joint_encoder]`, `[[joint_encoder]]` | `joint`; `counts_per_turn`, `resolution_rad` or `resolution_m`, or `none = true` | 14 bits, 10 um |
//! | `[[travel]]` | `joint`, `range_rad` or `range_m`: narrower than that of the body | range of the body |
//! | `[payload]` | `mass_kg` at the end point, else at the site `endpoint` | 0 |
//! | `[[device]]` | `name`; of a drive `muscle`, `mode`, `counts_per_turn`, `offset_rad`, `rated_torque_nm`; of sensors `[[device.channel]]` with `name`, `muscle` or `joint`, `scale`, `offset`; what identifies them on their bus, a [`BusReader`] reads | [`Device::defaults`](crate::machine::Device::defaults) |
//! | `[tolerances]` | [`Tolerances`](crate::machine::Tolerances) | |
//! | `[control]` | [`ControlRules`](crate::machine::ControlRules) | |
//! | `[safety]` | [`SafetyLimits`](crate::machine::SafetyLimits) | those of drives and motors |
//!
//! A muscle's own table precedes its body's description, which precedes `[every_transmission]`. Numbers of a
//! motor, a reducer or a winch are complete, or change those of the part that is named `like`.

mod catalogue;
mod devices;
mod drives;
mod fields;
mod files;
mod import;
mod joints;
mod listing;
mod places;
mod safety;
mod springs;
mod task;
mod transmissions;

pub use super::document::{Entry, Table};
pub use super::domain::Domain;
pub use devices::{BusKeys, BusReader};
pub use files::{FileReference, ReadFile};
pub use import::{
    MachineDescription, has_machine_keys, machine_from_toml, machine_of, machine_on_bus, robot_from_toml,
};
pub use listing::{Listing, Setting, Value, ValueSource, source_of};
pub use places::Places;
