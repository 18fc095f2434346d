//! A table in TOML as written.

use super::{Access, DataType, FmmuUse, ObjectCode, PdoMappable, Profile, SyncManagerKind};
use serde::Deserialize;
use toml::Spanned;

#[derive(Deserialize)]
#[serde(deny_unknown_fields)]
pub(super) struct WrittenDevice {
    pub(super) name: String,
    pub(super) title: Option<String>,
    pub(super) group: Option<String>,
    #[serde(default)]
    pub(super) profile: Profile,
    pub(super) memory: Option<u16>,
    pub(super) identity: WrittenIdentity,
    #[serde(default)]
    pub(super) fmmus: Vec<FmmuUse>,
    pub(super) mailbox: Option<WrittenMailbox>,
    pub(super) clock: Option<WrittenClock>,
    #[serde(default)]
    pub(super) sync_manager: Vec<WrittenSyncManager>,
    #[serde(default)]
    pub(super) object: Vec<Spanned<WrittenObject>>,
    #[serde(default)]
    pub(super) pdo: Vec<WrittenPdo>,
    #[serde(default)]
    pub(super) channels: Vec<(u16, u8)>,
}

#[derive(Deserialize)]
#[serde(deny_unknown_fields)]
pub(super) struct WrittenIdentity {
    pub(super) vendor: u32,
    pub(super) product: u32,
    pub(super) revision: u32,
    #[serde(default)]
    pub(super) serial: u32,
}

#[derive(Deserialize)]
#[serde(deny_unknown_fields)]
pub(super) struct WrittenMailbox {
    #[serde(default)]
    pub(super) information: bool,
    #[serde(default)]
    pub(super) complete_access: bool,
    #[serde(default)]
    pub(super) assignment: bool,
    #[serde(default)]
    pub(super) mapping: bool,
}

#[derive(Deserialize)]
#[serde(deny_unknown_fields)]
pub(super) struct WrittenClock {
    #[serde(default)]
    pub(super) sync: bool,
    #[serde(default)]
    pub(super) wide: bool,
    #[serde(default)]
    pub(super) min_cycle_ns: u32,
}

#[derive(Deserialize)]
#[serde(deny_unknown_fields)]
pub(super) struct WrittenSyncManager {
    pub(super) kind: SyncManagerKind,
    pub(super) start: u16,
    #[serde(default)]
    pub(super) length: u16,
    #[serde(default)]
    pub(super) watchdog: bool,
}

/// Either one value (`type`) or several (`entries`).
#[derive(Deserialize)]
#[serde(deny_unknown_fields)]
pub(super) struct WrittenObject {
    pub(super) index: u16,
    pub(super) name: String,
    pub(super) code: Option<ObjectCode>,
    #[serde(rename = "type")]
    pub(super) data_type: Option<DataType>,
    pub(super) bits: Option<u16>,
    #[serde(default)]
    pub(super) access: Access,
    #[serde(default)]
    pub(super) pdo: PdoMappable,
    pub(super) value: Option<WrittenValue>,
    pub(super) limits: Option<(i64, i64)>,
    #[serde(default)]
    pub(super) entries: Vec<WrittenEntry>,
}

#[derive(Deserialize)]
#[serde(deny_unknown_fields)]
pub(super) struct WrittenEntry {
    pub(super) subindex: u8,
    pub(super) name: String,
    #[serde(rename = "type")]
    pub(super) data_type: DataType,
    pub(super) bits: Option<u16>,
    #[serde(default)]
    pub(super) access: Access,
    #[serde(default)]
    pub(super) pdo: PdoMappable,
    pub(super) value: Option<WrittenValue>,
    pub(super) limits: Option<(i64, i64)>,
}

#[derive(Debug, Deserialize)]
#[serde(untagged)]
pub(super) enum WrittenValue {
    Truth(bool),
    Whole(i64),
    Real(f64),
    Text(String),
}

#[derive(Deserialize)]
#[serde(deny_unknown_fields)]
pub(super) struct WrittenPdo {
    pub(super) index: u16,
    pub(super) name: Option<String>,
    #[serde(default)]
    pub(super) assigned: bool,
    #[serde(default)]
    pub(super) fixed: bool,
    /// Index, subindex, bits; index 0 is a gap.
    pub(super) entries: Vec<(u16, u8, u8)>,
}
