//! A chain of simulated EtherCAT devices in virtual time.
//!
//! [`Segment::process`] takes one Ethernet frame and changes it as it would be changed on its way through
//! every device of the line and back; [`Segment::advance`] lets virtual time pass: the firmware of the
//! devices runs, mailboxes are answered, watchdogs expire, clocks drift. Nothing here reads a clock, starts a
//! thread or opens a file, so that a run is repeatable bit for bit; the feature `raw-socket` adds the one
//! exception, `serve`, which lets virtual time follow the clock. A device is data: a table in TOML or an ESI
//! file. [`CanNode`] is a drive on CAN instead: the built-in one on CANopen, one on CANSimple, a moteus, or a
//! motor in MIT mode.
//!
//! ```
//! use sinew_segment::{Device, DeviceSettings, Segment, builtin};
//!
//! let coupler = Device::new(&builtin::coupler(), DeviceSettings::default())?;
//! let drive = Device::new(&builtin::drive(), DeviceSettings::default())?;
//! let mut segment = Segment::new(vec![coupler, drive]);
//!
//! // BRD of the type register: how many devices are there?
//! let mut frame = [0_u8; 60];
//! frame[12..14].copy_from_slice(&[0x88, 0xa4]); // EtherType
//! frame[14..16].copy_from_slice(&[0x0d, 0x10]); // 13 octets of datagrams, type 1
//! frame[16] = 7; // BRD
//! frame[22] = 1; // one octet of data
//! segment.process(&mut frame);
//! assert_eq!(frame[27], 2, "the working counter");
//! # Ok::<(), sinew_segment::DescriptionError>(())
//! ```
//!
//! What is simulated follows ETG.1000.4 (data link layer), ETG.1000.6 (application layer), ETG.2010 (SII),
//! CiA 402 / IEC 61800-7-201 (drives) and, where these leave it open, the data sheets of common slave
//! controllers.

#[cfg(doctest)]
#[doc = include_str!("../README.md")]
mod readme {}

mod al;
mod answer;
mod bytes;
mod can;
mod coe;
mod description;
mod device;
mod dictionary;
mod drive;
mod esc;
mod fault;
mod firmware;
mod frame;
mod mailbox;
mod pdo;
#[cfg(all(feature = "raw-socket", target_os = "linux"))]
mod raw_socket;
mod segment;
#[cfg(all(feature = "raw-socket", target_os = "linux"))]
mod serve;
mod settings;
mod sii;

pub use al::{AlState, AlStatusCode};
pub use can::{
    CanDrive, CanFault, CanFrame, CanNode, Cansimple, Mit, MitCommand, MitFamily, MitRanges, MitReadings,
    Moteus,
};
pub use coe::Abort;
pub use description::{
    Access, ClockDescription, DataType, DescriptionError, DescriptionFile, DeviceDescription, Direction,
    EntryDescription, FmmuUse, Identity, MailboxDescription, ObjectCode, ObjectDescription, PdoDescription,
    PdoEntry, PdoMappable, Profile, SyncManagerDescription, SyncManagerKind, builtin,
};
pub use device::Device;
pub use drive::{AxisCommand, Drive, DriveState, Mode};
pub use fault::{Fault, FaultKind, NoSuchDevice};
#[cfg(all(feature = "raw-socket", target_os = "linux"))]
pub use raw_socket::{RawSocket, RawSocketError};
pub use segment::{Passed, Segment};
#[cfg(all(feature = "raw-socket", target_os = "linux"))]
pub use serve::{Served, serve};
pub use settings::DeviceSettings;
