//! The slave controller of a device: registers, memory, sync managers, memory management, EEPROM, watchdogs,
//! clock.

mod clock;
mod clock_registers;
mod controller;
mod eeprom;
mod fmmu;
mod logical;
pub(crate) mod register;
mod sync_manager;
mod watchdog;

pub(crate) use clock::SyncPulses;
pub(crate) use controller::{Controller, Hardware, HardwareClock};
pub(crate) use sync_manager::SyncManager;
