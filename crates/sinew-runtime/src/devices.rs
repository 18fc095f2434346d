//! The buses, and what identifies a machine's devices on whichever they are.

use crate::bus::{Bus, DeviceReader, Devices, Tables};
use crate::{can, ethercat, servos};
use sinew::description::DescriptionError;
use sinew::description::machine::{BusKeys, BusReader, Listing, Table};
use sinew::machine::Machine;

/// The buses that a real machine can be on.
pub const BUSES: &[Bus] = &[ethercat::BUS, servos::BUS, can::BUS];

/// Reads what identifies the devices of a machine file: the first one tells by its mark on which bus all are.
#[derive(Debug, Default)]
pub struct DeviceTables {
    chosen: Option<(&'static Bus, Box<dyn DeviceReader>)>,
}

/// Buses whose devices have tables.
fn tables() -> impl Iterator<Item = (&'static Bus, Tables)> {
    BUSES.iter().filter_map(|bus| Some((bus, bus.tables?)))
}

impl DeviceTables {
    /// The devices of the machine that was read, whose readings are as old as their bus makes them; simulated
    /// ones on every bus where its file names none.
    ///
    /// # Errors
    /// A value that contradicts the device's model.
    pub fn devices(&self, machine: &mut Machine) -> Result<Devices, DescriptionError> {
        let devices = match &self.chosen {
            Some((bus, reader)) => {
                machine.reading_age = bus.reading_age(machine.period);
                vec![reader.devices(machine)?]
            }
            None => tables().map(|(_, of)| (of.reader)().devices(machine)).collect::<Result<_, _>>()?,
        };
        Ok(Devices(devices))
    }
}

impl BusReader for DeviceTables {
    fn keys(&self) -> BusKeys {
        let mut all = BusKeys::default();
        for keys in tables().map(|(_, of)| (of.reader)().keys()) {
            for (all, keys) in [
                (&mut all.device, keys.device),
                (&mut all.drive, keys.drive),
                (&mut all.channel, keys.channel),
            ] {
                let new: Vec<_> = keys.into_iter().filter(|key| !all.contains(key)).collect();
                all.extend(new);
            }
        }
        all
    }

    fn read(
        &mut self,
        device: &Table<'_>,
        channels: &[Table<'_>],
        listing: &mut Listing,
    ) -> Result<(), DescriptionError> {
        let marked = tables().filter(|(_, of)| device.entry(of.mark).is_some()).last();
        let Some((bus, of)) = marked.or_else(|| tables().next()) else { return Ok(()) };
        let (first, reader) = self.chosen.get_or_insert_with(|| (bus, (of.reader)()));
        if let Some(entry) = device.entry(of.mark).filter(|_| bus.name != first.name) {
            return Err(entry.refuse(&format!("devices of one bus, {}, as the first one", first.name)));
        }
        let own = reader.keys();
        for (_, other) in tables() {
            let keys = (other.reader)().keys();
            let foreign = |key: &&&str| !own.device.contains(key) && !own.drive.contains(key);
            let entry =
                keys.device.iter().chain(&keys.drive).filter(foreign).find_map(|key| device.entry(key));
            if let Some(entry) = entry {
                return Err(entry.refuse(&format!("no such key of a device of {}", first.name)));
            }
        }
        reader.read(device, channels, listing)
    }
}
