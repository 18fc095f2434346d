//! Reads the description of a device from an ESI file: identity, sync managers, mailbox, PDOs, clock and
//! dictionary.
//!
//! Source: ETG.2000 (EtherCAT Slave Information). What only configuration tools use is passed over.

use super::esi_node::{EsiFile, child, children, is_set, number, text_of};
use super::esi_objects::{Types, plain};
use super::{
    Access, ClockDescription, DataType, DescriptionError, DeviceDescription, Direction, EntryDescription,
    FmmuUse, Identity, MailboxDescription, ObjectCode, ObjectDescription, PdoDescription, PdoEntry,
    PdoMappable, Profile, SyncManagerDescription, SyncManagerKind,
};
use roxmltree::{Document, Node};

/// Memory begins here, and there is at least this much of it.
const MEMORY_START: u32 = 0x1000;
const MIN_MEMORY: u32 = 0x2000;
/// The watchdog's bit in the control octet of a sync manager.
const WATCHDOG: u64 = 0x40;

impl DeviceDescription {
    /// Reads one device of an ESI file; `file` names it in errors. `product` and `revision` choose among
    /// several devices; without a revision the highest is taken.
    ///
    /// # Errors
    ///
    /// No XML, no ESI file, no such device, several devices without a choice, or the first element that is
    /// missing or out of range.
    pub fn from_esi(
        file: &str,
        text: &str,
        product: Option<u32>,
        revision: Option<u32>,
    ) -> Result<Self, DescriptionError> {
        let document = parse(file, text)?;
        let file = EsiFile { name: file };
        let (vendor, devices) = devices(file, &document)?;
        let node = choose(file, document.root_element(), &devices, [product, revision])?;
        let mut description = device(file, vendor, node)?;
        complete_objects(&mut description, file, node)?;
        description.check().map_err(|error| DescriptionError {
            line: document.text_pos_at(node.range().start).row as usize,
            ..error
        })?;
        Ok(description)
    }
}

/// The file as XML.
pub(super) fn parse<'input>(file: &str, text: &'input str) -> Result<Document<'input>, DescriptionError> {
    Document::parse(text).map_err(|error| DescriptionError {
        file: file.to_owned(),
        line: error.pos().row as usize,
        field: "XML".to_owned(),
        problem: error.to_string(),
    })
}

/// Vendor ID and the elements of all devices.
pub(super) fn devices<'a, 'input>(
    file: EsiFile<'_>,
    document: &'a Document<'input>,
) -> Result<(u32, Vec<Node<'a, 'input>>), DescriptionError> {
    let root = document.root_element();
    if root.tag_name().name() != "EtherCATInfo" {
        return Err(file.error(root, "expected the root element <EtherCATInfo> of an ESI file"));
    }
    let vendor = child(root, "Vendor").ok_or_else(|| file.error(root, "expected an element <Vendor>"))?;
    let devices = child(root, "Descriptions").and_then(|node| child(node, "Devices"));
    let devices = devices.into_iter().flat_map(|devices| children(devices, "Device")).collect();
    Ok((file.required(vendor, "Id")?, devices))
}

fn identity_of(file: EsiFile<'_>, node: Node<'_, '_>) -> Result<(u32, u32), DescriptionError> {
    let kind = child(node, "Type").ok_or_else(|| file.error(node, "expected an element <Type>"))?;
    let get = |name| -> Result<u32, DescriptionError> {
        file.fit(kind, name, file.attribute(kind, name)?.unwrap_or(0))
    };
    Ok((get("ProductCode")?, get("RevisionNo")?))
}

fn choose<'a, 'input>(
    file: EsiFile<'_>,
    root: Node<'a, 'input>,
    devices: &[Node<'a, 'input>],
    [product, revision]: [Option<u32>; 2],
) -> Result<Node<'a, 'input>, DescriptionError> {
    let mut fitting = Vec::new();
    let mut products = Vec::new();
    for &node in devices {
        let (code, number) = identity_of(file, node)?;
        if product.is_none_or(|product| product == code) && revision.is_none_or(|revision| revision == number)
        {
            fitting.push((number, node));
            if !products.contains(&code) {
                products.push(code);
            }
        }
    }
    if products.len() > 1 {
        let products: Vec<String> = products.iter().map(|code| format!("{code:#x}")).collect();
        return Err(
            file.error(root, format!("several devices ({}); choose a product code", products.join(", ")))
        );
    }
    let newest = fitting.into_iter().max_by_key(|(number, _)| *number);
    newest
        .map(|(_, node)| node)
        .ok_or_else(|| file.error(root, "no device with this product code and revision"))
}

fn device(file: EsiFile<'_>, vendor: u32, node: Node<'_, '_>) -> Result<DeviceDescription, DescriptionError> {
    let (product, revision) = identity_of(file, node)?;
    let name = text_of(node, "Type").filter(|name| !name.is_empty()).unwrap_or("unnamed").to_owned();
    let sync_managers = sync_managers(file, node)?;
    let end = sync_managers.iter().map(|manager| u32::from(manager.start) + u32::from(manager.length)).max();
    let memory = end.unwrap_or(0).saturating_sub(MEMORY_START).max(MIN_MEMORY).next_multiple_of(1024);
    let profile = child(node, "Profile").and_then(|profile| text_of(profile, "ProfileNo"));
    let has_mailbox = sync_managers.iter().any(|manager| manager.kind == SyncManagerKind::MailboxOut);
    let coe = child(node, "Mailbox").and_then(|mailbox| child(mailbox, "CoE"));
    let clock = child(node, "Dc").map(|dc| ClockDescription {
        sync: children(dc, "OpMode").any(|mode| {
            text_of(mode, "AssignActivate").and_then(number).is_some_and(|activation| activation != 0)
        }),
        wide: true,
        min_cycle_ns: 0,
    });
    let mut pdos = Vec::new();
    for (tag, first) in [("RxPdo", 0x1600), ("TxPdo", 0x1a00)] {
        for pdo in children(node, tag) {
            pdos.push(self::pdo(file, pdo, first)?);
        }
    }
    pdos.sort_by_key(|pdo: &PdoDescription| pdo.index);
    Ok(DeviceDescription {
        origin: file.name.to_owned(),
        identity: Identity { vendor, product, revision, serial: 0 },
        title: text_of(node, "Name").unwrap_or(&name).to_owned(),
        group: text_of(node, "GroupType").unwrap_or("Simulated").to_owned(),
        name,
        profile: if profile == Some("402") { Profile::Drive } else { Profile::Plain },
        memory: u16::try_from(memory).unwrap_or(0xf000),
        sync_managers,
        fmmus: fmmus(file, node)?,
        mailbox: has_mailbox.then(|| MailboxDescription {
            information: coe.is_some_and(|coe| is_set(coe, "SdoInfo")),
            complete_access: coe.is_some_and(|coe| is_set(coe, "CompleteAccess")),
            assignment: coe.is_some_and(|coe| is_set(coe, "PdoAssign")),
            mapping: coe.is_some_and(|coe| is_set(coe, "PdoConfig")),
        }),
        clock,
        objects: Vec::new(),
        pdos,
        channels: Vec::new(),
    })
}

fn sync_managers(
    file: EsiFile<'_>,
    node: Node<'_, '_>,
) -> Result<Vec<SyncManagerDescription>, DescriptionError> {
    let mut managers = Vec::new();
    for manager in children(node, "Sm") {
        let kind = match manager.text().unwrap_or_default().trim() {
            "MBoxOut" => SyncManagerKind::MailboxOut,
            "MBoxIn" => SyncManagerKind::MailboxIn,
            "Outputs" => SyncManagerKind::Outputs,
            "Inputs" => SyncManagerKind::Inputs,
            other => {
                let problem = format!("`{other}`, expected MBoxOut, MBoxIn, Outputs or Inputs");
                return Err(file.error(manager, problem));
            }
        };
        let get = |name| file.attribute(manager, name).map(|value| value.unwrap_or(0));
        let mailbox = matches!(kind, SyncManagerKind::MailboxOut | SyncManagerKind::MailboxIn);
        let length = if mailbox { get("DefaultSize")? } else { 0 };
        managers.push(SyncManagerDescription {
            kind,
            start: file.fit(manager, "StartAddress", get("StartAddress")?)?,
            length: file.fit(manager, "DefaultSize", length)?,
            watchdog: get("ControlByte")? & WATCHDOG != 0,
        });
    }
    Ok(managers)
}

fn fmmus(file: EsiFile<'_>, node: Node<'_, '_>) -> Result<Vec<FmmuUse>, DescriptionError> {
    let uses = children(node, "Fmmu").map(|fmmu| match fmmu.text().unwrap_or_default().trim() {
        "Outputs" => Ok(FmmuUse::Outputs),
        "Inputs" => Ok(FmmuUse::Inputs),
        "MBoxState" => Ok(FmmuUse::MailboxStatus),
        other => Err(file.error(fmmu, format!("`{other}`, expected Outputs, Inputs or MBoxState"))),
    });
    uses.collect()
}

fn pdo(file: EsiFile<'_>, node: Node<'_, '_>, first: u16) -> Result<PdoDescription, DescriptionError> {
    let index: u16 = file.required(node, "Index")?;
    if !(first..first + 0x200).contains(&index) {
        return Err(
            file.error(node, format!("expected an index from {first:#06x} to {:#06x}", first + 0x1ff))
        );
    }
    let mut entries = Vec::new();
    for entry in children(node, "Entry") {
        let subindex = file.number(entry, "SubIndex")?.unwrap_or(0);
        entries.push(PdoEntry {
            index: file.required(entry, "Index")?,
            subindex: file.fit(entry, "SubIndex", subindex)?,
            bits: file.required(entry, "BitLen")?,
        });
    }
    Ok(PdoDescription {
        index,
        name: text_of(node, "Name").unwrap_or_default().to_owned(),
        assigned: node.attribute("Sm").is_some(),
        fixed: is_set(node, "Fixed"),
        entries,
    })
}

/// Objects of the dictionary, and of PDOs that the dictionary does not have; what a PDO contains is mappable.
fn complete_objects(
    description: &mut DeviceDescription,
    file: EsiFile<'_>,
    node: Node<'_, '_>,
) -> Result<(), DescriptionError> {
    if let Some(dictionary) = child(node, "Profile").and_then(|profile| child(profile, "Dictionary")) {
        description.objects = Types::read(file, dictionary).objects(dictionary)?;
    }
    for (tag, direction) in [("RxPdo", Direction::Outputs), ("TxPdo", Direction::Inputs)] {
        for entry in children(node, tag).flat_map(|pdo| children(pdo, "Entry").collect::<Vec<_>>()) {
            let index: u16 = file.required(entry, "Index")?;
            if index != 0 {
                complete_entry(&mut description.objects, file, entry, index, direction)?;
            }
        }
    }
    Ok(())
}

fn complete_entry(
    objects: &mut Vec<ObjectDescription>,
    file: EsiFile<'_>,
    node: Node<'_, '_>,
    index: u16,
    direction: Direction,
) -> Result<(), DescriptionError> {
    let subindex: u8 = file.fit(node, "SubIndex", file.number(node, "SubIndex")?.unwrap_or(0))?;
    let name = text_of(node, "Name").unwrap_or_default();
    let at = objects.binary_search_by_key(&index, |object| object.index).unwrap_or_else(|at| {
        let code = if subindex == 0 { ObjectCode::Variable } else { ObjectCode::Record };
        let entries = if subindex == 0 { Vec::new() } else { vec![EntryDescription::count(0)] };
        objects.insert(at, ObjectDescription { index, name: name.to_owned(), code, entries });
        at
    });
    let entries = &mut objects[at].entries;
    let place = entries.binary_search_by_key(&subindex, |entry| entry.subindex);
    let place = match place {
        Ok(place) => place,
        Err(place) => {
            let bits: u16 = file.required(node, "BitLen")?;
            let named = text_of(node, "DataType").and_then(plain).filter(|(_, of_type)| *of_type == bits);
            let data_type = named.map_or_else(|| by_length(bits), |(data_type, _)| data_type);
            let access = if direction == Direction::Outputs { Access::ReadWrite } else { Access::Read };
            let (name, pdo, value) = (name.to_owned(), PdoMappable::No, Vec::new());
            entries.insert(
                place,
                EntryDescription { subindex, name, data_type, bits, access, pdo, value, limits: None },
            );
            if let Some(count) = entries.first_mut().filter(|count| count.subindex == 0 && subindex > 0) {
                count.value = vec![count.value.first().copied().unwrap_or(0).max(subindex)];
            }
            place
        }
    };
    let entry = &mut entries[place];
    if !entry.pdo.allows(direction) {
        entry.pdo = match (entry.pdo, direction) {
            (PdoMappable::No, Direction::Outputs) => PdoMappable::Outputs,
            (PdoMappable::No, Direction::Inputs) => PdoMappable::Inputs,
            _ => PdoMappable::Both,
        };
    }
    Ok(())
}

fn by_length(bits: u16) -> DataType {
    match bits {
        0..8 => DataType::Bits,
        8 => DataType::U8,
        16 => DataType::U16,
        24 => DataType::U24,
        32 => DataType::U32,
        64 => DataType::U64,
        _ => DataType::Octets,
    }
}
