//! A table in TOML as written.

use super::{
    Access, ClockDescription, DataType, FmmuUse, Identity, MailboxDescription, ObjectCode, PdoEntry,
    PdoMappable, Profile, SyncManagerDescription,
};
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
    pub(super) identity: Identity,
    #[serde(default)]
    pub(super) fmmus: Vec<FmmuUse>,
    pub(super) mailbox: Option<MailboxDescription>,
    pub(super) clock: Option<ClockDescription>,
    #[serde(default)]
    pub(super) sync_manager: Vec<SyncManagerDescription>,
    #[serde(default)]
    pub(super) object: Vec<Spanned<WrittenObject>>,
    #[serde(default)]
    pub(super) pdo: Vec<WrittenPdo>,
    #[serde(default)]
    pub(super) channels: Vec<(u16, u8)>,
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
    pub(super) entries: Vec<PdoEntry>,
}
