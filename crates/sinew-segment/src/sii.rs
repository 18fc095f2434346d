//! The content of a device's EEPROM: slave information interface.
//!
//! Source: ETG.1000.6, 5.4 (SII area) and ETG.2010 (categories).

use crate::description::{DeviceDescription, Direction, FmmuUse, PdoDescription, SyncManagerKind};

/// Categories, ETG.2010 table 3.
const STRINGS: u16 = 10;
const GENERAL: u16 = 30;
const FMMU: u16 = 40;
const SYNC_MANAGER: u16 = 41;
const TX_PDO: u16 = 50;
const RX_PDO: u16 = 51;
const CLOCK: u16 = 60;
const END: u16 = 0xffff;

/// First category, as an octet.
const CATEGORIES: usize = 0x80;
/// Octets per kilobit, the unit of the EEPROM's size.
const KILOBIT: usize = 128;
/// Protocols of the mailbox: CoE.
const COE: u16 = 0x0004;
/// AssignActivate of synchronised operation: cyclic operation and SYNC0.
const ACTIVATE_SYNC0: u16 = 0x0300;

/// The whole image, filled up to a power of two.
pub(crate) fn image(description: &DeviceDescription, alias: u16, serial: u32) -> Vec<u8> {
    let mut image = header(description, alias, serial);
    let mut strings = Strings::default();
    let general = general(description, &mut strings);
    let tx = pdos(description, Direction::Inputs, &mut strings);
    let rx = pdos(description, Direction::Outputs, &mut strings);
    let clock = clock(description, &mut strings);
    let categories = [
        (STRINGS, strings.content()),
        (GENERAL, general),
        (FMMU, description.fmmus.iter().map(|fmmu| fmmu_number(*fmmu)).collect()),
        (SYNC_MANAGER, sync_managers(description)),
        (TX_PDO, tx),
        (RX_PDO, rx),
        (CLOCK, clock),
    ];
    for (number, mut content) in categories {
        if content.is_empty() {
            continue;
        }
        if content.len() % 2 == 1 {
            content.push(0);
        }
        image.extend(number.to_le_bytes());
        image.extend(((content.len() / 2) as u16).to_le_bytes());
        image.extend(content);
    }
    image.extend(END.to_le_bytes());
    let size = image.len().max(16 * KILOBIT).next_power_of_two();
    image.resize(size, 0xff);
    put(&mut image, 0x3e, (size / KILOBIT - 1) as u16);
    image
}

/// CRC-8 of the first seven words, polynomial x^8 + x^2 + x + 1, start 0xff.
pub(crate) fn checksum(octets: &[u8]) -> u8 {
    octets.iter().fold(0xff, |crc, octet| {
        (0..8).fold(crc ^ octet, |crc, _| if crc & 0x80 == 0 { crc << 1 } else { crc << 1 ^ 0x07 })
    })
}

fn put(image: &mut [u8], word: usize, value: u16) {
    image[2 * word..2 * word + 2].copy_from_slice(&value.to_le_bytes());
}

fn put_double(image: &mut [u8], word: usize, value: u32) {
    image[2 * word..2 * word + 4].copy_from_slice(&value.to_le_bytes());
}

fn header(description: &DeviceDescription, alias: u16, serial: u32) -> Vec<u8> {
    let mut image = vec![0; CATEGORIES];
    // PDI: a synchronous parallel interface with SYNC and latch units where there is a clock.
    let units = if description.clock.is_some_and(|clock| clock.sync) { 0x0c00 } else { 0 };
    put(&mut image, 0, 0x0008 | units);
    // Length of the SYNC pulses in units of 10 ns.
    put(&mut image, 2, if units == 0 { 0 } else { 1000 });
    put(&mut image, 4, alias);
    let crc = checksum(&image[..14]);
    put(&mut image, 7, u16::from(crc));
    let identity = description.identity;
    put_double(&mut image, 8, identity.vendor);
    put_double(&mut image, 10, identity.product);
    put_double(&mut image, 12, identity.revision);
    put_double(&mut image, 14, serial);
    if description.mailbox.is_some() {
        for manager in &description.sync_managers {
            let word = match manager.kind {
                SyncManagerKind::MailboxOut => 0x18,
                SyncManagerKind::MailboxIn => 0x1a,
                _ => continue,
            };
            put(&mut image, word, manager.start);
            put(&mut image, word + 1, manager.length);
        }
        put(&mut image, 0x1c, COE);
    }
    put(&mut image, 0x3f, 1);
    image
}

/// Texts, numbered from 1.
#[derive(Default)]
struct Strings(Vec<String>);

impl Strings {
    /// The number of a text; 0, no text, where there are already too many.
    fn number(&mut self, text: &str) -> u8 {
        let text: String = text.chars().filter(char::is_ascii).take(255).collect();
        if text.is_empty() {
            return 0;
        }
        let at = self.0.iter().position(|known| *known == text).unwrap_or(self.0.len());
        if at >= 255 {
            return 0;
        }
        if at == self.0.len() {
            self.0.push(text);
        }
        at as u8 + 1
    }

    fn content(&self) -> Vec<u8> {
        let mut content = vec![self.0.len() as u8];
        for text in &self.0 {
            content.push(text.len() as u8);
            content.extend(text.as_bytes());
        }
        content
    }
}

fn general(description: &DeviceDescription, strings: &mut Strings) -> Vec<u8> {
    let mut content = vec![0; 32];
    // The order number comes first: simple masters take string 1 as the name.
    content[2] = strings.number(&description.name);
    content[3] = strings.number(&description.title);
    content[0] = strings.number(&description.group);
    if let Some(mailbox) = description.mailbox {
        let flags =
            [true, mailbox.information, mailbox.assignment, mailbox.mapping, false, mailbox.complete_access];
        content[5] = flags.iter().enumerate().map(|(bit, set)| u8::from(*set) << bit).sum();
    }
    content[9] = u8::from(description.profile == crate::description::Profile::Drive);
    // Physical ports 0 and 1: MII.
    content[16] = 0x11;
    content
}

fn fmmu_number(use_: FmmuUse) -> u8 {
    match use_ {
        FmmuUse::Outputs => 1,
        FmmuUse::Inputs => 2,
        FmmuUse::MailboxStatus => 3,
    }
}

/// Control octet of a sync manager by what it carries: mode, direction, events, watchdog.
pub(crate) fn control(manager: &crate::description::SyncManagerDescription) -> u8 {
    let watchdog = if manager.watchdog { 0x40 } else { 0 };
    watchdog
        | match manager.kind {
            SyncManagerKind::MailboxOut => 0x26,
            SyncManagerKind::MailboxIn => 0x22,
            SyncManagerKind::Outputs => 0x24,
            SyncManagerKind::Inputs => 0x20,
        }
}

fn sync_managers(description: &DeviceDescription) -> Vec<u8> {
    let mut content = Vec::new();
    for manager in &description.sync_managers {
        let (number, length) = match manager.kind {
            SyncManagerKind::MailboxOut => (1, manager.length),
            SyncManagerKind::MailboxIn => (2, manager.length),
            SyncManagerKind::Outputs => (3, description.default_length(Direction::Outputs) as u16),
            SyncManagerKind::Inputs => (4, description.default_length(Direction::Inputs) as u16),
        };
        content.extend(manager.start.to_le_bytes());
        content.extend(length.to_le_bytes());
        content.extend([control(manager), 0, 1, number]);
    }
    content
}

fn pdos(description: &DeviceDescription, direction: Direction, strings: &mut Strings) -> Vec<u8> {
    let desired = match direction {
        Direction::Outputs => SyncManagerKind::Outputs,
        Direction::Inputs => SyncManagerKind::Inputs,
    };
    let manager =
        crate::pdo::channel(&description.sync_managers, desired).map_or(0xff, |channel| channel as u8);
    let mut content = Vec::new();
    for pdo in description.pdos.iter().filter(|pdo| pdo.direction() == direction) {
        content.extend(pdo_content(description, pdo, if pdo.assigned { manager } else { 0xff }, strings));
    }
    content
}

fn pdo_content(
    description: &DeviceDescription,
    pdo: &PdoDescription,
    manager: u8,
    strings: &mut Strings,
) -> Vec<u8> {
    let mut content = Vec::new();
    content.extend(pdo.index.to_le_bytes());
    content.extend([pdo.entries.len() as u8, manager, 0, strings.number(&pdo.name)]);
    content.extend(if pdo.fixed { 0x0010_u16 } else { 0 }.to_le_bytes());
    for mapped in &pdo.entries {
        let entry = description.entry(mapped.index, mapped.subindex);
        let name = entry.map_or(0, |entry| strings.number(&entry.name));
        let data_type = entry.map_or(0, |entry| entry.data_type.number(entry.bits) as u8);
        content.extend(mapped.index.to_le_bytes());
        content.extend([mapped.subindex, name, data_type, mapped.bits, 0, 0]);
    }
    content
}

/// The operation mode with SYNC0.
fn clock(description: &DeviceDescription, strings: &mut Strings) -> Vec<u8> {
    let Some(_) = description.clock.filter(|clock| clock.sync) else { return Vec::new() };
    let mut content = vec![0; 24];
    content[14..16].copy_from_slice(&ACTIVATE_SYNC0.to_le_bytes());
    content[18] = strings.number("DC-Synchron");
    content
}

#[cfg(test)]
mod tests {
    use super::*;
    use crate::description::builtin;

    #[test]
    fn the_checksum_is_that_of_the_standard() {
        assert_eq!(checksum(b"123456789"), 0xfb, "check value of CRC-8 with start 0xff");
        let image = image(&builtin::drive(), 7, 1);
        assert_eq!(image[14], checksum(&image[..14]));
        assert_eq!(image[8], 7);
    }

    #[test]
    fn categories_follow_each_other_up_to_the_end_mark() {
        for device in [builtin::drive(), builtin::load_cell(), builtin::encoder(3), builtin::coupler()] {
            let image = image(&device, 0, 0);
            let (mut at, mut found) = (CATEGORIES, Vec::new());
            loop {
                let number = u16::from_le_bytes([image[at], image[at + 1]]);
                if number == END {
                    break;
                }
                found.push(number);
                at += 4 + 2 * usize::from(u16::from_le_bytes([image[at + 2], image[at + 3]]));
            }
            assert!(found.is_sorted() && found.contains(&GENERAL), "{found:?}");
            assert_eq!(image.len() % KILOBIT, 0);
        }
    }
}
