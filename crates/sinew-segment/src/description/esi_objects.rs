//! Data types and objects of an ESI file's dictionary.
//!
//! Source: ETG.2000, clause 8 (Profile, Dictionary, DataTypes, Objects).

use super::esi_node::{EsiFile, child, children, number, octets, text_of};
use super::{
    Access, DataType, DescriptionError, EntryDescription, ObjectCode, ObjectDescription, PdoMappable,
};
use roxmltree::Node;
use std::collections::BTreeMap;

/// Types refer to types; a longer chain is a circle.
const DEEPEST: usize = 8;

/// Data types by their names.
pub(super) struct Types<'a, 'input> {
    file: EsiFile<'a>,
    named: BTreeMap<&'a str, Node<'a, 'input>>,
}

impl<'a, 'input: 'a> Types<'a, 'input> {
    pub(super) fn read(file: EsiFile<'a>, dictionary: Node<'a, 'input>) -> Self {
        let types = child(dictionary, "DataTypes");
        let nodes = types.into_iter().flat_map(|types| children(types, "DataType"));
        Self { file, named: nodes.filter_map(|node| Some((text_of(node, "Name")?, node))).collect() }
    }

    /// All objects but those that follow from PDOs and sync managers.
    pub(super) fn objects(
        &self,
        dictionary: Node<'a, 'input>,
    ) -> Result<Vec<ObjectDescription>, DescriptionError> {
        let list = child(dictionary, "Objects");
        let mut objects = Vec::new();
        for node in list.into_iter().flat_map(|list| children(list, "Object")) {
            let index: u16 = self.file.required(node, "Index")?;
            if index >= 0x1000 && !matches!(index, 0x1600..0x1800 | 0x1a00..0x1c40) {
                objects.push(self.object(index, node)?);
            }
        }
        objects.sort_by_key(|object| object.index);
        objects.dedup_by_key(|object| object.index);
        Ok(objects)
    }

    fn object(&self, index: u16, node: Node<'a, 'input>) -> Result<ObjectDescription, DescriptionError> {
        let name = text_of(node, "Name").unwrap_or_default().to_owned();
        let type_name =
            text_of(node, "Type").ok_or_else(|| self.file.error(node, "expected an element <Type>"))?;
        let info = child(node, "Info");
        let composed = self.named.get(type_name).filter(|found| child(**found, "SubItem").is_some());
        let Some(composed) = composed else {
            let (data_type, bits) = self.resolve(node, type_name)?;
            let mut entry = self.entry(0, &name, data_type, bits, node)?;
            self.set_value(&mut entry, info)?;
            return Ok(ObjectDescription { index, name, code: ObjectCode::Variable, entries: vec![entry] });
        };
        let mut entries: Vec<EntryDescription> = Vec::new();
        let mut code = ObjectCode::Record;
        let infos: Vec<_> = info.into_iter().flat_map(|info| children(info, "SubItem")).collect();
        for (at, item) in children(*composed, "SubItem").enumerate() {
            let item_type = text_of(item, "Type").unwrap_or_default();
            if let Some((base, count)) = self.array(item_type)? {
                code = ObjectCode::Array;
                let (data_type, bits) = self.resolve(item, base)?;
                for element in 1..=count {
                    let mut entry =
                        self.entry(element, &format!("Element {element}"), data_type, bits, item)?;
                    self.set_value(&mut entry, infos.get(usize::from(element)).copied().and_then(info_of))?;
                    entries.push(entry);
                }
                continue;
            }
            let number = self.file.number(item, "SubIdx")?.unwrap_or(entries.len() as u64);
            let subindex = self.file.fit(item, "SubIdx", number)?;
            let (data_type, bits) = self.resolve(item, item_type)?;
            let mut entry =
                self.entry(subindex, text_of(item, "Name").unwrap_or_default(), data_type, bits, item)?;
            self.set_value(&mut entry, infos.get(at).copied().and_then(info_of))?;
            entries.push(entry);
        }
        entries.sort_by_key(|entry| entry.subindex);
        Ok(ObjectDescription { index, name, code, entries })
    }

    /// Base type and number of elements, where the type is an array.
    fn array(&self, name: &str) -> Result<Option<(&'a str, u8)>, DescriptionError> {
        let Some(node) = self.named.get(name) else { return Ok(None) };
        let Some(info) = child(*node, "ArrayInfo") else { return Ok(None) };
        let base = text_of(*node, "BaseType").unwrap_or_default();
        let count = self.file.required(info, "Elements")?;
        // Octets that belong together are one value.
        Ok((base != "BYTE" || count <= 254).then_some((base, count)))
    }

    /// The type that a name stands for, and its bits.
    fn resolve(&self, node: Node<'a, 'input>, name: &str) -> Result<(DataType, u16), DescriptionError> {
        let mut name = name.to_owned();
        for _ in 0..DEEPEST {
            if let Some(found) = plain(&name) {
                return Ok(found);
            }
            let Some(next) = self.named.get(name.as_str()).and_then(|node| text_of(*node, "BaseType")) else {
                break;
            };
            name = next.to_owned();
        }
        // A type without a base: as many bits as it says.
        let described = self.named.get(name.as_str()).copied().unwrap_or(node);
        let bits = self.file.number(described, "BitSize")?.unwrap_or(0);
        match of_bits(bits) {
            Some(found) => Ok(found),
            None => Err(self.file.error(node, format!("unknown data type `{name}`"))),
        }
    }

    fn entry(
        &self,
        subindex: u8,
        name: &str,
        data_type: DataType,
        bits: u16,
        node: Node<'a, 'input>,
    ) -> Result<EntryDescription, DescriptionError> {
        let flags = child(node, "Flags");
        let access = flags.and_then(|flags| child(flags, "Access"));
        let restricted = access.and_then(|access| access.attribute("WriteRestrictions"));
        let access = match access.and_then(|access| access.text()).map(str::trim) {
            None | Some("ro") => Access::Read,
            Some("wo") => Access::Write,
            Some("rw") if restricted.is_some_and(|when| when.eq_ignore_ascii_case("PreOP")) => {
                Access::WriteInPreOp
            }
            Some("rw") => Access::ReadWrite,
            Some(other) => {
                return Err(self.file.error(node, format!("access `{other}`, expected ro, wo or rw")));
            }
        };
        let mapping = flags.and_then(|flags| text_of(flags, "PdoMapping")).unwrap_or_default().to_uppercase();
        let pdo = match (mapping.contains('R'), mapping.contains('T')) {
            (true, true) => PdoMappable::Both,
            (true, false) => PdoMappable::Outputs,
            (false, true) => PdoMappable::Inputs,
            (false, false) => PdoMappable::No,
        };
        let (name, value) = (name.to_owned(), Vec::new());
        Ok(EntryDescription { subindex, name, data_type, bits, access, pdo, value, limits: None })
    }

    /// Default value: octets, text or number.
    fn set_value(
        &self,
        entry: &mut EntryDescription,
        info: Option<Node<'a, 'input>>,
    ) -> Result<(), DescriptionError> {
        let Some(info) = info else { return Ok(()) };
        let length = usize::from(entry.bits).div_ceil(8);
        if let Some(text) = text_of(info, "DefaultString") {
            entry.value = text.bytes().take(length).collect();
        } else if let Some(text) = text_of(info, "DefaultData").filter(|text| !text.is_empty()) {
            entry.value =
                octets(text).ok_or_else(|| self.file.error(info, format!("`{text}`, expected octets")))?;
        } else if let Some(text) = text_of(info, "DefaultValue").filter(|text| !text.is_empty()) {
            let value = number(text).map(u64::cast_signed).or_else(|| text.parse().ok());
            let value: i64 =
                value.ok_or_else(|| self.file.error(info, format!("`{text}`, expected a number")))?;
            entry.value = value.to_le_bytes()[..length.min(8)].to_vec();
        }
        if entry.value.len() > length {
            let problem = format!("a default of {} octets in {} bits", entry.value.len(), entry.bits);
            return Err(self.file.error(info, problem));
        }
        Ok(())
    }
}

fn info_of<'a, 'input>(item: Node<'a, 'input>) -> Option<Node<'a, 'input>> {
    child(item, "Info")
}

/// The types of ETG.1000.6, table 63, by their names.
pub(super) fn plain(name: &str) -> Option<(DataType, u16)> {
    use DataType as D;
    let data_type = match name {
        "BOOL" | "BIT" => D::Bool,
        "SINT" => D::I8,
        "INT" => D::I16,
        "DINT" => D::I32,
        "LINT" => D::I64,
        "USINT" | "BYTE" | "BITARR8" => D::U8,
        "UINT" | "WORD" | "BITARR16" => D::U16,
        "UINT24" => D::U24,
        "UDINT" | "DWORD" | "BITARR32" => D::U32,
        "ULINT" => D::U64,
        "REAL" => D::F32,
        "LREAL" => D::F64,
        _ => return sized(name),
    };
    data_type.bits().map(|bits| (data_type, bits))
}

/// `BIT3`, `STRING(8)`, `OCTET_STRING(8)`, `ARRAY [0..7] OF BYTE`.
fn sized(name: &str) -> Option<(DataType, u16)> {
    let octets = |count: u16| count.checked_mul(8).filter(|bits| *bits > 0);
    if let Some(bits) = name.strip_prefix("BIT").and_then(|bits| bits.parse().ok()) {
        return (1..=8).contains(&bits).then_some((DataType::Bits, bits));
    }
    if let Some(inside) = name.strip_prefix("ARRAY [0..").and_then(|rest| rest.strip_suffix("] OF BYTE")) {
        return Some((DataType::Octets, octets(inside.parse::<u16>().ok()?.checked_add(1)?)?));
    }
    let (kind, count) = name.strip_suffix(')')?.split_once('(')?;
    let bits = octets(count.trim().parse().ok()?)?;
    match kind {
        "STRING" => Some((DataType::Text, bits)),
        "OCTET_STRING" => Some((DataType::Octets, bits)),
        _ => None,
    }
}

fn of_bits(bits: u64) -> Option<(DataType, u16)> {
    let bits = u16::try_from(bits).ok()?;
    let data_type = match bits {
        1..=7 => DataType::Bits,
        8 => DataType::U8,
        16 => DataType::U16,
        24 => DataType::U24,
        32 => DataType::U32,
        64 => DataType::U64,
        _ if bits > 0 && bits.is_multiple_of(8) => DataType::Octets,
        _ => return None,
    };
    Some((data_type, bits))
}
