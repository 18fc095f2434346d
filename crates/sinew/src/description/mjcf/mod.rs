//! MJCF, the robot format of MuJoCo: import and export of the content that matters for cables.

mod attach;
mod body;
mod compiler;
mod defaults;
mod export;
mod geom;
mod hull;
mod import;
mod import_state;
mod inertia;
mod lists;
mod mesh;
mod mesh_asset;
mod mesh_mass;
mod place;
mod ranges;
mod replicate;
mod replicate_references;
mod schema;
mod sheath;
mod shell;
mod solid;
mod spring_damper;
mod tendon;
mod text;

pub use export::to_mjcf;
pub use import::from_mjcf;
pub(super) use inertia::possible;
pub(super) use lists::finite;
pub(super) use place::{HERE, Place};
pub(super) use schema::law;
