//! CANopen over EtherCAT: SDO transfer, SDO information, emergencies.

mod abort;
mod access;
mod information;
mod sdo;

pub use abort::Abort;
pub(crate) use information::answer as answer_information;
pub(crate) use sdo::SdoServer;

/// Services in the CoE header.
pub(crate) const EMERGENCY: u8 = 1;
pub(crate) const SDO_REQUEST: u8 = 2;
pub(crate) const SDO_RESPONSE: u8 = 3;
pub(crate) const SDO_INFORMATION: u8 = 8;
