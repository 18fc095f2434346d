//! What makes a description a device that can be built.

use super::{DataType, DescriptionError, DeviceDescription, Direction, EntryDescription, SyncManagerKind};

/// Registers end and memory begins here.
const MEMORY_START: u32 = 0x1000;
/// Mailboxes hold at least a header and an expedited SDO with its command.
const SMALLEST_MAILBOX: u16 = 24;
/// A category of the EEPROM counts its words in 16 bits; half of it is more than any device needs.
const LARGEST_CATEGORY: usize = 0xffff;
/// Subindices of an assignment.
const MAX_ASSIGNED: usize = 254;
/// One Ethernet frame carries this much in a datagram.
const LARGEST_AREA: u16 = 1486;

impl DeviceDescription {
    /// Checks that a device can be built.
    ///
    /// # Errors
    ///
    /// The first field that is out of range or that contradicts another one.
    pub fn check(&self) -> Result<(), DescriptionError> {
        self.check_sync_managers()?;
        self.check_objects()?;
        self.check_pdos()?;
        for (channel, (index, subindex)) in self.channels.iter().enumerate() {
            if self.entry(*index, *subindex).is_none() {
                let problem = format!("object {index:#06x}:{subindex} is not in the dictionary");
                return Err(self.error(format!("channel.{channel}"), problem));
            }
        }
        Ok(())
    }

    /// The entry of an object that the description lists.
    #[must_use]
    pub fn entry(&self, index: u16, subindex: u8) -> Option<&EntryDescription> {
        let object = self.objects.iter().find(|object| object.index == index)?;
        object.entries.iter().find(|entry| entry.subindex == subindex)
    }

    /// Octets of the process data that are exchanged by default.
    #[must_use]
    pub fn default_length(&self, direction: Direction) -> usize {
        let assigned = self.pdos.iter().filter(|pdo| pdo.assigned && pdo.direction() == direction);
        assigned.map(super::PdoDescription::bits).sum::<usize>().div_ceil(8)
    }

    fn check_sync_managers(&self) -> Result<(), DescriptionError> {
        if self.sync_managers.len() > 16 || self.fmmus.len() > 16 {
            return Err(self.error("sync_manager", "more than 16 sync managers or FMMUs"));
        }
        let end = MEMORY_START + u32::from(self.memory);
        for (channel, manager) in self.sync_managers.iter().enumerate() {
            let field = format!("sync_manager.{channel}");
            let mailbox = matches!(manager.kind, SyncManagerKind::MailboxOut | SyncManagerKind::MailboxIn);
            if u32::from(manager.start) < MEMORY_START
                || u32::from(manager.start) + u32::from(manager.length) > end
            {
                let place = format!("{:#06x} + {}", manager.start, manager.length);
                return Err(self.error(field, format!("{place}, expected within 0x1000..{end:#06x}")));
            }
            if mailbox && !(SMALLEST_MAILBOX..=LARGEST_AREA).contains(&manager.length) {
                let problem =
                    format!("length {}, expected {SMALLEST_MAILBOX} to {LARGEST_AREA}", manager.length);
                return Err(self.error(field, problem));
            }
        }
        let has = |kind| self.sync_managers.iter().filter(|manager| manager.kind == kind).count();
        let desired = usize::from(self.mailbox.is_some());
        for kind in [SyncManagerKind::MailboxOut, SyncManagerKind::MailboxIn] {
            if has(kind) != desired {
                let problem = format!("{} of {kind:?}, expected {desired} with this mailbox", has(kind));
                return Err(self.error("sync_manager", problem));
            }
        }
        for (direction, kind) in
            [(Direction::Outputs, SyncManagerKind::Outputs), (Direction::Inputs, SyncManagerKind::Inputs)]
        {
            if has(kind) > 1 {
                return Err(
                    self.error("sync_manager", format!("{} of {kind:?}, expected at most one", has(kind)))
                );
            }
            let length = self.default_length(direction);
            if length > 0 && has(kind) == 0 {
                return Err(
                    self.error("sync_manager", format!("PDOs of {direction:?} without a sync manager"))
                );
            }
            if length > usize::from(LARGEST_AREA) {
                return Err(
                    self.error("pdo", format!("{length} octets of {direction:?}, at most {LARGEST_AREA}"))
                );
            }
        }
        Ok(())
    }

    fn check_objects(&self) -> Result<(), DescriptionError> {
        let mut last = None;
        for object in &self.objects {
            let field = format!("object.{:#06x}", object.index);
            if object.index < 0x1000 {
                return Err(self.error(field, "expected an index from 0x1000"));
            }
            if last.is_some_and(|last| last >= object.index) {
                return Err(self.error(field, "expected indices in ascending order, each once"));
            }
            last = Some(object.index);
            if object.entries.is_empty() {
                return Err(self.error(field, "expected at least one entry"));
            }
            let mut last = None;
            for entry in &object.entries {
                let field = format!("{field}:{}", entry.subindex);
                if last.is_some_and(|last| last >= entry.subindex) {
                    return Err(self.error(field, "expected subindices in ascending order, each once"));
                }
                last = Some(entry.subindex);
                self.check_entry(&field, entry)?;
            }
        }
        Ok(())
    }

    fn check_entry(&self, field: &str, entry: &EntryDescription) -> Result<(), DescriptionError> {
        let bits = entry.bits;
        let fits = match entry.data_type {
            DataType::Bits => (1..=8).contains(&bits),
            DataType::Text | DataType::Octets => bits.is_multiple_of(8) && bits > 0,
            other => other.bits() == Some(bits),
        };
        if !fits {
            return Err(self.error(field, format!("{bits} bits do not fit the type {:?}", entry.data_type)));
        }
        if entry.value.len() > usize::from(bits).div_ceil(8) {
            return Err(self.error(field, format!("a value of {} octets in {bits} bits", entry.value.len())));
        }
        if let Some((low, high)) = entry.limits
            && (low > high || !entry.data_type.is_whole())
        {
            return Err(
                self.error(field, format!("limits {low} to {high}, expected a range of whole numbers"))
            );
        }
        Ok(())
    }

    /// PDOs have to fit into the EEPROM's categories and into their assignment.
    fn check_pdo_number(&self) -> Result<(), DescriptionError> {
        for direction in [Direction::Outputs, Direction::Inputs] {
            let all = self.pdos.iter().filter(|pdo| pdo.direction() == direction);
            let octets: usize = all.clone().map(|pdo| 8 * (1 + pdo.entries.len())).sum();
            let assigned = all.filter(|pdo| pdo.assigned).count();
            if octets > LARGEST_CATEGORY || assigned > MAX_ASSIGNED {
                let problem = format!(
                    "{octets} octets of {direction:?} in the EEPROM and {assigned} of them assigned, \
                     at most {LARGEST_CATEGORY} and {MAX_ASSIGNED}"
                );
                return Err(self.error("pdo", problem));
            }
        }
        Ok(())
    }

    fn check_pdos(&self) -> Result<(), DescriptionError> {
        self.check_pdo_number()?;
        for (i, pdo) in self.pdos.iter().enumerate() {
            let field = format!("pdo.{:#06x}", pdo.index);
            if !(0x1600..0x1800).contains(&pdo.index) && !(0x1a00..0x1c00).contains(&pdo.index) {
                return Err(self.error(field, "expected an index in 0x1600..0x1800 or 0x1a00..0x1c00"));
            }
            if self.pdos[..i].iter().any(|other| other.index >= pdo.index) {
                return Err(self.error(field, "expected indices in ascending order, each once"));
            }
            if pdo.entries.len() > 254 {
                return Err(self.error(field, format!("{} entries, at most 254", pdo.entries.len())));
            }
            for entry in pdo.entries.iter().filter(|entry| entry.index != 0) {
                let name = format!("{:#06x}:{}", entry.index, entry.subindex);
                // Without a dictionary there is nothing to compare with: simple terminals.
                let Some(found) = self.entry(entry.index, entry.subindex) else {
                    return Err(self.error(field, format!("object {name} is not in the dictionary")));
                };
                if found.bits != u16::from(entry.bits) || !found.pdo.allows(pdo.direction()) {
                    let problem = format!(
                        "object {name} of {} bits is not mappable as {:?}",
                        found.bits,
                        pdo.direction()
                    );
                    return Err(self.error(field, problem));
                }
            }
        }
        Ok(())
    }

    pub(crate) fn error(&self, field: impl Into<String>, problem: impl Into<String>) -> DescriptionError {
        DescriptionError { file: self.origin.clone(), line: 0, field: field.into(), problem: problem.into() }
    }
}
