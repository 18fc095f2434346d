//! Addresses of the registers and who may write them.
//!
//! Source: ETG.1000.4, table 31 to 61; where it is silent, the register description of common slave
//! controllers.

use core::ops::Range;

/// Registers end and memory begins here.
pub(crate) const MEMORY: usize = 0x1000;
pub(crate) const STATION: u16 = 0x0010;
pub(crate) const ALIAS: u16 = 0x0012;
pub(crate) const LOOP_CONTROL: u16 = 0x0101;
pub(crate) const ALIAS_ENABLE: u16 = 0x0103;
pub(crate) const DL_STATUS: u16 = 0x0110;
pub(crate) const AL_CONTROL: u16 = 0x0120;
pub(crate) const AL_STATUS: u16 = 0x0130;
pub(crate) const AL_STATUS_CODE: u16 = 0x0134;
pub(crate) const PDI_CONTROL: u16 = 0x0140;
pub(crate) const PDI_CONFIGURATION: u16 = 0x0150;
pub(crate) const ECAT_EVENT_MASK: u16 = 0x0200;
pub(crate) const ECAT_EVENT: u16 = 0x0210;
pub(crate) const AL_EVENT_MASK: u16 = 0x0204;
pub(crate) const AL_EVENT: u16 = 0x0220;
pub(crate) const RX_ERRORS: u16 = 0x0300;
pub(crate) const PROCESSING_ERRORS: u16 = 0x030c;
pub(crate) const LOST_LINK: u16 = 0x0310;
pub(crate) const WATCHDOG_DIVIDER: u16 = 0x0400;
pub(crate) const WATCHDOG_PDI: u16 = 0x0410;
pub(crate) const WATCHDOG_DATA: u16 = 0x0420;
pub(crate) const WATCHDOG_STATUS: u16 = 0x0440;
pub(crate) const WATCHDOG_COUNTER: u16 = 0x0442;
pub(crate) const EEPROM_OWNER: u16 = 0x0500;
pub(crate) const EEPROM_OWNED: u16 = 0x0501;
pub(crate) const EEPROM_CONTROL: u16 = 0x0502;
pub(crate) const EEPROM_ADDRESS: u16 = 0x0504;
pub(crate) const EEPROM_DATA: u16 = 0x0508;
pub(crate) const FMMU: u16 = 0x0600;
pub(crate) const SYNC_MANAGER: u16 = 0x0800;
pub(crate) const PORT_TIMES: u16 = 0x0900;
pub(crate) const SYSTEM_TIME: u16 = 0x0910;
pub(crate) const UNIT_TIME: u16 = 0x0918;
pub(crate) const TIME_OFFSET: u16 = 0x0920;
pub(crate) const TIME_DELAY: u16 = 0x0928;
pub(crate) const TIME_DIFFERENCE: u16 = 0x092c;
pub(crate) const SPEED_COUNTER: u16 = 0x0930;
pub(crate) const SPEED_DIFFERENCE: u16 = 0x0932;
pub(crate) const FILTER_DEPTH: u16 = 0x0934;
pub(crate) const SYNC_ACTIVATION: u16 = 0x0981;
pub(crate) const SYNC_ACTIVATION_STATUS: u16 = 0x0984;
pub(crate) const SYNC0_STATUS: u16 = 0x098e;
pub(crate) const SYNC_START: u16 = 0x0990;
pub(crate) const SYNC0_CYCLE: u16 = 0x09a0;

/// Octets of one memory management unit and of one sync manager.
pub(crate) const FMMU_LENGTH: u16 = 16;
pub(crate) const SYNC_MANAGER_LENGTH: u16 = 8;

/// The master may read.
pub(super) const READ: u8 = 1;
/// The master may write.
pub(super) const WRITE: u8 = 2;
const BOTH: u8 = READ | WRITE;

/// Start, length, rights of what every controller has.
const COMMON: [(u16, u16, u8); 23] = [
    (0x0000, 10, READ),
    (STATION, 2, BOTH),
    (ALIAS, 2, READ),
    (0x0100, 4, BOTH),
    (DL_STATUS, 2, READ),
    (AL_CONTROL, 2, BOTH),
    (AL_STATUS, 2, READ),
    (AL_STATUS_CODE, 2, READ),
    (PDI_CONTROL, 2, READ),
    (PDI_CONFIGURATION, 4, READ),
    (ECAT_EVENT_MASK, 2, BOTH),
    (AL_EVENT_MASK, 4, READ),
    (ECAT_EVENT, 2, READ),
    (AL_EVENT, 4, READ),
    (RX_ERRORS, 14, BOTH),
    (LOST_LINK, 4, BOTH),
    (WATCHDOG_DIVIDER, 2, BOTH),
    (WATCHDOG_PDI, 2, BOTH),
    (WATCHDOG_DATA, 2, BOTH),
    (WATCHDOG_STATUS, 2, READ),
    (WATCHDOG_COUNTER, 2, BOTH),
    (EEPROM_OWNER, 1, BOTH),
    (EEPROM_OWNED, 1, READ),
];
const EEPROM: [(u16, u16, u8); 1] = [(EEPROM_CONTROL, 14, BOTH)];
/// User memory.
const USER: [(u16, u16, u8); 1] = [(0x0f80, 0x80, BOTH)];
const CLOCK: [(u16, u16, u8); 8] = [
    (PORT_TIMES, 16, BOTH),
    (SYSTEM_TIME, 8, BOTH),
    (UNIT_TIME, 8, READ),
    (TIME_OFFSET, 12, BOTH),
    (TIME_DIFFERENCE, 4, READ),
    (SPEED_COUNTER, 2, BOTH),
    (SPEED_DIFFERENCE, 2, READ),
    (FILTER_DEPTH, 2, BOTH),
];
const SYNC: [(u16, u16, u8); 7] = [
    (0x0980, 2, BOTH),
    (0x0982, 3, READ),
    (SYNC0_STATUS, 2, READ),
    (SYNC_START, 8, BOTH),
    (0x0998, 8, READ),
    (SYNC0_CYCLE, 10, BOTH),
    (0x09ae, 34, READ),
];

/// Rights of every register of a controller; 0 where there is none.
pub(super) fn rights(fmmus: usize, sync_managers: usize, clock: bool, sync: bool) -> Vec<u8> {
    let mut rights = vec![0; MEMORY];
    let mut enter = |ranges: &[(u16, u16, u8)]| {
        for (start, length, right) in ranges {
            rights[usize::from(*start)..usize::from(start + length)].fill(*right);
        }
    };
    enter(&COMMON);
    enter(&EEPROM);
    enter(&USER);
    for fmmu in 0..fmmus.min(16) as u16 {
        enter(&[(FMMU + FMMU_LENGTH * fmmu, FMMU_LENGTH, BOTH)]);
    }
    for manager in 0..sync_managers.min(16) as u16 {
        let start = SYNC_MANAGER + SYNC_MANAGER_LENGTH * manager;
        enter(&[(start, 5, BOTH), (start + 5, 1, READ), (start + 6, 1, BOTH), (start + 7, 1, READ)]);
    }
    if clock {
        enter(&CLOCK);
    }
    if sync {
        enter(&SYNC);
    }
    rights
}

/// Whether a range of addresses has a part of a register.
pub(super) fn touches(range: &Range<usize>, start: u16, length: u16) -> bool {
    range.start < usize::from(start + length) && range.end > usize::from(start)
}
