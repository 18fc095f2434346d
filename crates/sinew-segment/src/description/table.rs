//! Reads the description of a device from a table in TOML.

use super::written::{WrittenDevice, WrittenEntry, WrittenObject, WrittenValue};
use super::{
    DataType, DescriptionError, DeviceDescription, EntryDescription, ObjectCode, ObjectDescription,
    PdoDescription,
};
use core::ops::Range;

/// Octets of memory where the file says nothing: enough for two mailboxes and process data of a drive.
const DEFAULT_MEMORY: u16 = 0x2000;

impl DeviceDescription {
    /// Reads a table in TOML; `file` names it in errors.
    ///
    /// # Errors
    ///
    /// The first line that is no TOML, has an unknown or missing field, or a value out of range.
    pub fn from_toml(file: &str, text: &str) -> Result<Self, DescriptionError> {
        let reader = Reader { file, text };
        let written: WrittenDevice = toml::from_str(text).map_err(|error| {
            let problem = error.message().to_owned();
            reader.error(error.span().unwrap_or_default(), "table", problem)
        })?;
        let description = reader.device(written)?;
        description.check().map_err(|error| reader.with_line(error))?;
        Ok(description)
    }
}

struct Reader<'a> {
    file: &'a str,
    text: &'a str,
}

impl Reader<'_> {
    fn error(&self, span: Range<usize>, field: &str, problem: String) -> DescriptionError {
        let before = self.text.get(..span.start).unwrap_or(self.text);
        let line = before.matches('\n').count() + 1;
        DescriptionError { file: self.file.to_owned(), line, field: field.to_owned(), problem }
    }

    /// The line of an error that the check of the whole found, from the index it names.
    fn with_line(&self, mut error: DescriptionError) -> DescriptionError {
        let name = error.field.split('.').nth(1).and_then(|name| name.split(':').next()).unwrap_or_default();
        let desired = format!("index = {name}");
        let line = self.text.lines().position(|line| line.to_lowercase().contains(&desired));
        error.line = line.map_or(1, |line| line + 1);
        error
    }

    fn device(&self, written: WrittenDevice) -> Result<DeviceDescription, DescriptionError> {
        Ok(DeviceDescription {
            origin: self.file.to_owned(),
            identity: written.identity,
            title: written.title.unwrap_or_else(|| written.name.clone()),
            group: written.group.unwrap_or_else(|| "Simulated".to_owned()),
            name: written.name,
            profile: written.profile,
            memory: written.memory.unwrap_or(DEFAULT_MEMORY),
            sync_managers: written.sync_manager,
            fmmus: written.fmmus,
            mailbox: written.mailbox,
            clock: written.clock,
            objects: written
                .object
                .into_iter()
                .map(|object| self.object(object))
                .collect::<Result<_, _>>()?,
            pdos: written
                .pdo
                .into_iter()
                .map(|pdo| PdoDescription {
                    name: pdo.name.unwrap_or_else(|| format!("PDO {:#06x}", pdo.index)),
                    index: pdo.index,
                    assigned: pdo.assigned,
                    fixed: pdo.fixed,
                    entries: pdo.entries,
                })
                .collect(),
            channels: written.channels,
        })
    }

    fn object(&self, written: toml::Spanned<WrittenObject>) -> Result<ObjectDescription, DescriptionError> {
        let span = written.span();
        let object = written.into_inner();
        let field = format!("object.{:#06x}", object.index);
        let (code, mut entries) = match (object.data_type, object.entries.is_empty()) {
            (Some(data_type), true) => {
                let entry = WrittenEntry {
                    subindex: 0,
                    name: object.name.clone(),
                    data_type,
                    bits: object.bits,
                    access: object.access,
                    pdo: object.pdo,
                    value: object.value,
                    limits: object.limits,
                };
                (ObjectCode::Variable, vec![self.entry(&field, &span, entry)?])
            }
            (None, false) => {
                let code = object.code.unwrap_or(ObjectCode::Record);
                let entries: Result<Vec<_>, _> =
                    object.entries.into_iter().map(|entry| self.entry(&field, &span, entry)).collect();
                (code, entries?)
            }
            _ => return Err(self.error(span, &field, "expected either `type` or `entries`".to_owned())),
        };
        if code != ObjectCode::Variable && entries.first().is_some_and(|entry| entry.subindex != 0) {
            let last = entries.last().map_or(0, |entry| entry.subindex);
            entries.insert(0, EntryDescription::count(last));
        }
        Ok(ObjectDescription { index: object.index, name: object.name, code, entries })
    }

    fn entry(
        &self,
        object: &str,
        span: &Range<usize>,
        written: WrittenEntry,
    ) -> Result<EntryDescription, DescriptionError> {
        let field = format!("{object}:{}", written.subindex);
        let length = match &written.value {
            Some(WrittenValue::Text(text)) => Some(8 * text.len()),
            _ => None,
        };
        let bits =
            written.data_type.bits().or(written.bits).or(length.and_then(|bits| u16::try_from(bits).ok()));
        let Some(bits) = bits else {
            return Err(self.error(span.clone(), &field, "expected `bits` with this type".to_owned()));
        };
        let value = match written.value {
            None => Vec::new(),
            Some(value) => value
                .octets(written.data_type, bits)
                .map_err(|problem| self.error(span.clone(), &format!("{field}.value"), problem))?,
        };
        Ok(EntryDescription {
            subindex: written.subindex,
            name: written.name,
            data_type: written.data_type,
            bits,
            access: written.access,
            pdo: written.pdo,
            value,
            limits: written.limits,
        })
    }
}

impl WrittenValue {
    /// As on the wire.
    fn octets(&self, data_type: DataType, bits: u16) -> Result<Vec<u8>, String> {
        let length = usize::from(bits).div_ceil(8);
        match (self, data_type) {
            (Self::Text(text), DataType::Text | DataType::Octets) => Ok(text.as_bytes().to_vec()),
            (Self::Whole(value), _) if data_type.is_whole() => {
                let (low, high) = if bits >= 64 {
                    (i64::MIN, i64::MAX)
                } else if data_type.is_signed() {
                    (-(1 << (bits - 1)), (1 << (bits - 1)) - 1)
                } else {
                    (0, (1 << bits) - 1)
                };
                if !(low..=high).contains(value) {
                    return Err(format!("{value}, expected {low} to {high}"));
                }
                Ok(value.to_le_bytes()[..length.min(8)].to_vec())
            }
            (Self::Real(value), DataType::F64) if value.is_finite() => Ok(value.to_le_bytes().to_vec()),
            (Self::Real(value), DataType::F32) if value.is_finite() && value.abs() <= f64::from(f32::MAX) => {
                Ok((*value as f32).to_le_bytes().to_vec())
            }
            (Self::Truth(value), DataType::Bool) => Ok(vec![u8::from(*value)]),
            _ => Err(format!("{self:?} is no value of the type {data_type:?}")),
        }
    }
}

impl EntryDescription {
    /// Subindex 0 of arrays and records: the highest subindex.
    pub(crate) fn count(highest: u8) -> Self {
        Self {
            subindex: 0,
            name: "Number of entries".to_owned(),
            data_type: DataType::U8,
            bits: 8,
            access: super::Access::Read,
            pdo: super::PdoMappable::No,
            value: vec![highest],
            limits: None,
        }
    }
}
