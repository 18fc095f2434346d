//! What a device is, as data: identity, sync managers, objects, process data. Read from TOML or ESI, or built
//! in.

pub mod builtin;
mod error;
mod esi;
mod esi_node;
mod esi_objects;
mod file;
mod kinds;
mod table;
mod types;
mod validity;
mod written;

pub use error::DescriptionError;
pub use file::DescriptionFile;
pub use kinds::{Access, DataType, Direction, FmmuUse, ObjectCode, PdoMappable, Profile, SyncManagerKind};
pub use types::{
    ClockDescription, DeviceDescription, EntryDescription, Identity, MailboxDescription, ObjectDescription,
    PdoDescription, PdoEntry, SyncManagerDescription,
};
