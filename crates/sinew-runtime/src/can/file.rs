//! What a machine file says of nodes on CAN: `node`, `protocol`, `port`, `bitrate`, and keys of one protocol.

use super::device::{BITRATE, CanDevice, MASTER, Protocol, middle};
use super::mit::{MAX_DAMIAO, MitMotor};
use super::slcan::RATES;
use crate::bus::{AnyDevices, DeviceReader, Tables};
use crate::whole::is_whole;
use sinew::description::DescriptionError;
use sinew::description::machine::{BusKeys, BusReader, Domain, Entry, Listing, Table, ValueSource};
use sinew::machine::{DeviceRole, Machine};
use sinew_segment::{MitFamily, MitRanges};
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

const DAMIAO_NODE: Domain =
    Domain::new("a whole number in 1..=15, since a DAMIAO shows no more of it", |x| {
        x >= 1.0 && is_whole(x, f64::from(MAX_DAMIAO))
    });
const POSITIVE: Domain = Domain::new("a number > 0", |x| x > 0.0 && x.is_finite());

const PROTOCOLS: [Protocol; 4] = [Protocol::Canopen, Protocol::Cansimple, Protocol::Moteus, Protocol::Mit];
const NAMES: &[&str] = &["canopen", "cansimple", "moteus", "mit"];
const FAMILIES: [MitFamily; 3] = [MitFamily::MiniCheetah, MitFamily::Cubemars, MitFamily::Damiao];
/// Keys that not every protocol has.
const OF_SOME: [&str; 8] = [
    "vendor",
    "product",
    "rated_torque_nm",
    "endpoints",
    "bitrate",
    "model",
    "stiffness_nm_per_rad",
    "damping_nm_s_per_rad",
];
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
    /// But on CANopen, turns that are shown in a turn of the motor, where they are said.
    turn: Option<f64>,
    /// Of a motor in MIT mode its model, stiffness and damping; whether its zero is said.
    mit: Option<(String, MitRanges, [Option<f64>; 2])>,
    zeroed: bool,
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
            let Identified { protocol, node, turn, mit, zeroed, identity, endpoints, port, bitrate } =
                identified.clone();
            let parameters = &machine.muscles[drive.muscle].drive;
            match protocol {
                Protocol::Canopen => {}
                Protocol::Cansimple | Protocol::Moteus => drive.counts_per_turn = turn.unwrap_or(1.0),
                Protocol::Mit => {
                    drive.counts_per_turn = turn.unwrap_or(1.0 / parameters.reducer.ratio);
                    drive.offset = if zeroed { drive.offset } else { middle(parameters) };
                }
            }
            let mit = mit.map(|(model, ranges, [stiffness, damping])| {
                let [usual_stiffness, usual_damping] = MitMotor::gains(parameters, drive.counts_per_turn);
                let stiffness = stiffness.unwrap_or(usual_stiffness);
                MitMotor { model, ranges, stiffness, damping: damping.unwrap_or(usual_damping) }
            });
            let name = of.name.clone();
            Some(CanDevice { device, name, drive, protocol, node, identity, endpoints, mit, port, bitrate })
        };
        Ok(Arc::new(devices.filter_map(node).collect::<Vec<_>>()))
    }
}

impl BusReader for DeviceTables {
    fn keys(&self) -> BusKeys {
        BusKeys {
            device: ["node", "protocol", "port"]
                .into_iter()
                .chain(OF_SOME.into_iter().filter(|key| *key != "rated_torque_nm"))
                .collect(),
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
        let (own, kind): (&[&str], _) = match protocol {
            Protocol::Canopen => (&["vendor", "product", "rated_torque_nm", "bitrate"], "CANopen"),
            Protocol::Cansimple => (&["endpoints", "bitrate"], "CANSimple"),
            // Its bus has one rate.
            Protocol::Moteus => (&[], "moteus"),
            Protocol::Mit => {
                (&["model", "stiffness_nm_per_rad", "damping_nm_s_per_rad", "bitrate"], "MIT mode")
            }
        };
        let foreign = OF_SOME.iter().filter(|key| !own.contains(*key)).find_map(|key| device.entry(key));
        if let Some(entry) = foreign {
            return Err(entry.refuse(&format!("no such key of a node on {kind}")));
        }
        let turns = match protocol {
            Protocol::Canopen => None,
            Protocol::Cansimple => Some(TURN),
            Protocol::Moteus | Protocol::Mit => Some(TURNS),
        };
        let turns = turns.and_then(|turns| Some(device.entry("counts_per_turn")?.number(turns)));
        let turn = turns.transpose()?;
        let mit = (protocol == Protocol::Mit).then(|| motor(device, listing)).transpose()?;
        let node = entry.number(match (protocol, &mit) {
            (Protocol::Cansimple, _) => CANSIMPLE_NODE,
            (_, Some((_, MitRanges { family: MitFamily::Damiao, .. }, _))) => DAMIAO_NODE,
            _ => NODE,
        })?;
        listing.number("node", node, source(&entry));
        if self.read.iter().any(|other| other.node == node as u8) {
            return Err(entry.refuse("a node that no device above has"));
        }
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
        let (node, zeroed) = (node as u8, device.entry("offset_rad").is_some());
        self.read.push(Identified { protocol, node, turn, mit, zeroed, identity, endpoints, port, bitrate });
        Ok(())
    }
}

/// A motor in MIT mode: a model of the table by its name or one of a user's own, its stiffness and damping.
fn motor(
    device: &Table<'_>,
    listing: &mut Listing,
) -> Result<(String, MitRanges, [Option<f64>; 2]), DescriptionError> {
    let entry = device.required("model")?;
    let (name, ranges) = match entry.is_table().then(|| device.table("model")).transpose()?.flatten() {
        Some(table) => own_model(&table)?,
        None => {
            let (names, models): (Vec<_>, Vec<_>) = MitMotor::models().unzip();
            let found = entry.name("motor's model", &names)?;
            (names[found].to_owned(), models[found])
        }
    };
    listing.text("model", &name, ValueSource::File { line: entry.line() });
    let mut gain = |key: &str| -> Result<Option<f64>, DescriptionError> {
        let Some(entry) = device.entry(key) else { return Ok(None) };
        let gain = entry.number(POSITIVE)?;
        listing.number(key, gain, ValueSource::File { line: entry.line() });
        Ok(Some(gain))
    };
    Ok((name, ranges, [gain("stiffness_nm_per_rad")?, gain("damping_nm_s_per_rad")?]))
}

/// `{ name, family, position_rad, velocity_rad_s, torque_nm, stiffness_nm_per_rad, damping_nm_s_per_rad,
/// current_a }`.
fn own_model(table: &Table<'_>) -> Result<(String, MitRanges), DescriptionError> {
    table.check_keys(&[
        "name",
        "family",
        "position_rad",
        "velocity_rad_s",
        "torque_nm",
        "stiffness_nm_per_rad",
        "damping_nm_s_per_rad",
        "current_a",
    ])?;
    let required = |key| table.required(key)?.number(POSITIVE);
    let given = |key| table.entry(key).map(|entry| entry.number(POSITIVE)).transpose();
    let family =
        table.required("family")?.name("family of motors", &["mini-cheetah", "cubemars", "damiao"])?;
    let name = table.required("name")?.text("the name of a model")?.to_owned();
    let ranges = MitRanges {
        family: FAMILIES[family],
        position: required("position_rad")?,
        velocity: required("velocity_rad_s")?,
        torque: required("torque_nm")?,
        stiffness: given("stiffness_nm_per_rad")?.unwrap_or(500.0),
        damping: given("damping_nm_s_per_rad")?.unwrap_or(5.0),
        current: given("current_a")?,
    };
    Ok((name, ranges))
}
