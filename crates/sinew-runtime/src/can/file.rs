//! What a machine file says of nodes on CAN: `node`, `protocol`, `vendor`, `product`, `endpoints`,
//! `port`, `bitrate`.

use super::device::{BITRATE, CanDevice, MASTER, Protocol};
use super::slcan::RATES;
use crate::bus::{AnyDevices, DeviceReader, Tables};
use crate::whole::is_whole;
use sinew::description::DescriptionError;
use sinew::description::machine::{BusKeys, BusReader, Domain, Entry, Listing, Table, ValueSource};
use sinew::machine::{DeviceRole, Machine};
use std::sync::Arc;

const NODE: Domain =
    Domain::new("a whole number in 1..=126", |x| x >= 1.0 && is_whole(x, f64::from(MASTER - 1)));
const CANSIMPLE_NODE: Domain = Domain::new("a whole number in 0..=62", |x| is_whole(x, 62.0));
const TURN: Domain = Domain::new("1 or -1: on CANSimple positions are turns of the motor", |x| {
    x.abs().to_bits() == 1_f64.to_bits()
});
const TURNS: Domain =
    Domain::new("a finite number, not 0: the turns that it shows in one of the motor", |x| {
        x.is_finite() && x != 0.0
    });
const UNSIGNED_32: Domain = Domain::new("a whole number in 0..=0xffffffff", |x| is_whole(x, 4_294_967_295.0));
const RATE: Domain = Domain::new("10, 20, 50, 100, 125, 250, 500, 800 thousand or 1 million bit/s", |x| {
    RATES.iter().any(|rate| f64::from(*rate).to_bits() == x.to_bits())
});

const PROTOCOLS: [Protocol; 3] = [Protocol::Canopen, Protocol::Cansimple, Protocol::Moteus];
const NAMES: &[&str] = &["canopen", "cansimple", "moteus"];
const PORT: &str = "the path of a serial port, or the name of a CAN interface";

/// How they are told.
pub(super) const TABLES: Tables = Tables { mark: "node", reader: || Box::new(DeviceTables::default()) };

/// Reads what identifies the nodes of a machine file.
#[derive(Debug, Clone, Default)]
pub struct DeviceTables {
    read: Vec<Identified>,
}

#[derive(Debug, Clone)]
struct Identified {
    protocol: Protocol,
    node: u8,
    /// But on CANopen, turns that are shown in a turn of the motor.
    turn: f64,
    identity: [Option<u32>; 2],
    endpoints: Option<String>,
    port: Option<String>,
    bitrate: u32,
}

impl DeviceReader for DeviceTables {
    fn devices(&self, machine: &Machine) -> Result<AnyDevices, DescriptionError> {
        if self.read.is_empty() {
            return Ok(Arc::new(CanDevice::simulated(machine)));
        }
        let devices = machine.devices.iter().zip(&self.read).enumerate();
        let node = |(device, (of, identified)): (usize, (&sinew::machine::Device, &Identified))| {
            let DeviceRole::Drive(mut drive) = of.role else { return None };
            let Identified { protocol, node, turn, identity, endpoints, port, bitrate } = identified.clone();
            if protocol != Protocol::Canopen {
                drive.counts_per_turn = turn;
            }
            let name = of.name.clone();
            Some(CanDevice { device, name, drive, protocol, node, identity, endpoints, port, bitrate })
        };
        Ok(Arc::new(devices.filter_map(node).collect::<Vec<_>>()))
    }
}

impl BusReader for DeviceTables {
    fn keys(&self) -> BusKeys {
        BusKeys {
            device: vec!["node", "protocol", "vendor", "product", "endpoints", "port", "bitrate"],
            ..BusKeys::default()
        }
    }

    fn read(
        &mut self,
        device: &Table<'_>,
        _channels: &[Table<'_>],
        listing: &mut Listing,
    ) -> Result<(), DescriptionError> {
        let entry = device.required("node")?;
        let source = |entry: &Entry<'_>| ValueSource::File { line: entry.line() };
        if device.entry("muscle").is_none() {
            return Err(entry.refuse("no such key in a table without `muscle`: a node is the drive of one"));
        }
        if let Some(mode) = device.entry("mode").filter(|mode| mode.text("velocity") != Ok("velocity")) {
            return Err(mode.refuse("velocity: on CAN, drives close the loop of the torque themselves"));
        }
        let protocol = PROTOCOLS[listing.word(device, "protocol", (NAMES, 0))?];
        let (foreign, kind, ids): (&[&str], _, _) = match protocol {
            Protocol::Canopen => (&["endpoints"], "CANopen", NODE),
            Protocol::Cansimple => (&["vendor", "product", "rated_torque_nm"], "CANSimple", CANSIMPLE_NODE),
            // Its bus has one rate.
            Protocol::Moteus => {
                (&["vendor", "product", "rated_torque_nm", "endpoints", "bitrate"], "moteus", NODE)
            }
        };
        if let Some(entry) = foreign.iter().find_map(|key| device.entry(key)) {
            return Err(entry.refuse(&format!("no such key of a node on {kind}")));
        }
        let turns = match protocol {
            Protocol::Canopen => None,
            Protocol::Cansimple => device.entry("counts_per_turn").map(|entry| entry.number(TURN)),
            Protocol::Moteus => device.entry("counts_per_turn").map(|entry| entry.number(TURNS)),
        };
        let turn = turns.unwrap_or(Ok(1.0))?;
        let node = entry.number(ids)?;
        listing.number("node", node, source(&entry));
        let mut number = |key: &str, domain: Domain| -> Result<Option<u32>, DescriptionError> {
            let Some(entry) = device.entry(key) else { return Ok(None) };
            let number = entry.number(domain)?;
            listing.number(key, number, source(&entry));
            Ok(Some(number as u32))
        };
        let identity = [number("vendor", UNSIGNED_32)?, number("product", UNSIGNED_32)?];
        let bitrate = number("bitrate", RATE)?.unwrap_or(BITRATE);
        let text = |key, expected| {
            device.entry(key).map(|entry| entry.text(expected).map(str::to_owned)).transpose()
        };
        let (endpoints, port) = (text("endpoints", "the path of a file")?, text("port", PORT)?);
        let node = node as u8;
        self.read.push(Identified { protocol, node, turn, identity, endpoints, port, bitrate });
        Ok(())
    }
}
