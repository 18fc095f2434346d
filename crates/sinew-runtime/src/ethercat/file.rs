//! What a machine file says of devices on EtherCAT: `vendor`, `product`, `revision`, `revision_rule`,
//! `alias`, of drives `synchronization`, of channels `value` and `status`.

use super::device::{ChannelObjects, DeviceIdentity, EthercatDevice, RevisionRule};
use crate::bus::{AnyDevices, DeviceReader, Tables};
use crate::cia402::ObjectAddress;
use crate::whole::is_whole;
use sinew::description::DescriptionError;
use sinew::description::machine::{BusKeys, BusReader, Domain, Entry, Listing, Table, ValueSource};
use sinew::machine::Machine;
use std::sync::Arc;

const UNSIGNED_32: Domain = Domain::new("a whole number in 0..=0xffffffff", |x| is_whole(x, 4_294_967_295.0));
const UNSIGNED_16: Domain = Domain::new("a whole number in 0..=0xffff", |x| is_whole(x, 65_535.0));
const STATION_ALIAS: Domain =
    Domain::new("a whole number in 1..=0xffff", |x| x > 0.0 && is_whole(x, 65_535.0));

/// How they are told.
pub(super) const TABLES: Tables = Tables { mark: "vendor", reader: || Box::new(DeviceTables::default()) };

/// Reads what identifies the devices of a machine file on EtherCAT.
#[derive(Debug, Clone, Default)]
pub struct DeviceTables {
    read: Vec<Identified>,
}

#[derive(Debug, Clone)]
struct Identified {
    identity: DeviceIdentity,
    alias: Option<u16>,
    sync0: bool,
    objects: Vec<ChannelObjects>,
}

impl DeviceTables {
    /// The devices of the machine that was read; the simulated ones where its file names none.
    fn identified(&self, machine: &Machine) -> Vec<EthercatDevice> {
        if self.read.is_empty() {
            return EthercatDevice::simulated(machine);
        }
        let identified = self.read.iter().cloned().zip(machine.devices.iter().cloned());
        let device = |(identified, device)| {
            let Identified { identity, alias, sync0, objects } = identified;
            EthercatDevice { device, identity, alias, sync0, objects }
        };
        identified.map(device).collect()
    }
}

impl DeviceReader for DeviceTables {
    fn devices(&self, machine: &Machine) -> Result<AnyDevices, DescriptionError> {
        Ok(Arc::new(self.identified(machine)))
    }
}

impl BusReader for DeviceTables {
    fn keys(&self) -> BusKeys {
        BusKeys {
            device: vec!["vendor", "product", "revision", "revision_rule", "alias"],
            drive: vec!["synchronization"],
            channel: vec!["value", "status"],
        }
    }

    fn read(
        &mut self,
        device: &Table<'_>,
        channels: &[Table<'_>],
        listing: &mut Listing,
    ) -> Result<(), DescriptionError> {
        let identity = identity(device, listing)?;
        let alias = device.entry("alias").map(|entry| entry.number(STATION_ALIAS)).transpose()?;
        let is_drive = device.entry("muscle").is_some();
        let sync0 = !is_drive || listing.word(device, "synchronization", (&["sync0", "frame"], 0))? == 0;
        let objects = channels.iter().map(objects).collect::<Result<_, _>>()?;
        self.read.push(Identified { identity, alias: alias.map(|x| x as u16), sync0, objects });
        Ok(())
    }
}

fn identity(table: &Table<'_>, listing: &mut Listing) -> Result<DeviceIdentity, DescriptionError> {
    let mut number = |key: &str| -> Result<u32, DescriptionError> {
        let entry = table.required(key)?;
        let number = entry.number(UNSIGNED_32)?;
        listing.number(key, number, ValueSource::File { line: entry.line() });
        Ok(number as u32)
    };
    let (vendor, product) = (number("vendor")?, number("product")?);
    let revision = if table.entry("revision").is_some() { number("revision")? } else { 0 };
    let chosen = listing.word(table, "revision_rule", (&["exact", "at_least", "any"], 1))?;
    let rule = [RevisionRule::Exact, RevisionRule::AtLeast, RevisionRule::Any][chosen];
    Ok(DeviceIdentity { vendor, product, revision, rule })
}

fn objects(channel: &Table<'_>) -> Result<ChannelObjects, DescriptionError> {
    let value = address(&channel.required("value")?)?;
    let status = channel.table("status")?.map(|status| -> Result<_, DescriptionError> {
        status.check_keys(&["object", "error_mask"])?;
        let mask = status.entry("error_mask").map(|entry| entry.number(UNSIGNED_16)).transpose()?;
        Ok((address(&status.required("object")?)?, mask.map_or(u16::MAX, |mask| mask as u16)))
    });
    Ok(ChannelObjects { value, status: status.transpose()? })
}

/// An index and a subindex: `[0x6000, 2]`.
fn address(entry: &Entry<'_>) -> Result<ObjectAddress, DescriptionError> {
    let [index, subindex] = entry.numbers::<2>(UNSIGNED_16)?;
    if subindex > f64::from(u8::MAX) {
        return Err(entry.refuse("index and subindex of an object, the latter in 0..=0xff"));
    }
    Ok(ObjectAddress { index: index as u16, subindex: subindex as u8 })
}
