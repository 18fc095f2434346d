//! What a machine file says of servos: `id`, `model`, `port`, `baud`, `no_watchdog`, `position_lag_s`, of
//! drives `operating_mode`.

use super::device::{OperatingMode, ServoDevice};
use super::model::Model;
use super::protocol::MAX_ID;
use super::registers::{BAUD, sts};
use super::series::Series;
use crate::bus::{AnyDevices, DeviceReader, Tables};
use crate::whole::is_whole;
use sinew::description::DescriptionError;
use sinew::description::machine::{
    BusKeys, BusReader, Domain, Entry, Listing, Table, ValueSource, source_of,
};
use sinew::machine::{DeviceRole, DriveMode, Machine};
use std::sync::Arc;

const ID: Domain = Domain::new("a whole number in 0..=252", |x| is_whole(x, f64::from(MAX_ID)));
const RATE: Domain =
    Domain::new("9600, 57600, 115200 or 1, 2, 3, 4, 4.5 million bit/s", |x| is_rate(&BAUD, x));
const STS_RATE: Domain =
    Domain::new("38400, 57600, 76800, 115200, 128, 250, 500 thousand or 1 million bit/s", |x| {
        is_rate(&sts::BAUD, x)
    });
const NUMBER: Domain = Domain::new("a whole number in 0..=0xffff", |x| is_whole(x, 65_535.0));
const VELOCITIES: Domain =
    Domain::new("a whole number in 1..=0x7fffffff", |x| x >= 1.0 && is_whole(x, f64::from(i32::MAX)));
const POSITIVE: Domain = Domain::new("a number > 0", |x| x > 0.0);
const LAG: Domain = Domain::new("a number of seconds in 0..=0.2", |x| (0.0..=0.2).contains(&x));
const NOT_NEGATIVE: Domain = Domain::new("a number >= 0", |x| x >= 0.0);

fn is_rate(rates: &[u32], x: f64) -> bool {
    rates.iter().any(|rate| f64::from(*rate).to_bits() == x.to_bits())
}

/// Difference of counts in a turn that is a rounding, as a fraction.
const ROUNDING: f64 = 1e-3;

/// How they are told.
pub(super) const TABLES: Tables = Tables { mark: "id", reader: || Box::new(DeviceTables::default()) };

/// Reads what identifies the servos of a machine file.
#[derive(Debug, Clone, Default)]
pub struct DeviceTables {
    read: Vec<Identified>,
}

#[derive(Debug, Clone)]
struct Identified {
    id: u8,
    model: Model,
    port: Option<String>,
    baud: u32,
    extended: bool,
    position_lag: f64,
    /// Counts of a turn of the motor, as they are written, and where.
    counts: Option<(f64, DescriptionError)>,
    current: Option<DescriptionError>,
}

impl DeviceTables {
    /// The servos of the machine that was read, all of whose devices are servos.
    ///
    /// # Errors
    /// Counts of a turn that are not those of the model, and a torque that it cannot be commanded.
    fn identified(&self, machine: &Machine) -> Result<Vec<ServoDevice>, DescriptionError> {
        let mut servos = Vec::new();
        for (device, (of, identified)) in machine.devices.iter().zip(&self.read).enumerate() {
            let DeviceRole::Drive(drive) = of.role else { continue };
            let Identified { id, model, port, baud, extended, position_lag, counts, current } =
                identified.clone();
            let mode = match OperatingMode::of(drive.mode) {
                OperatingMode::Velocity if extended => OperatingMode::ExtendedPosition,
                mode => mode,
            };
            if let (DriveMode::Torque, Some(error)) = (drive.mode, current) {
                return Err(error);
            }
            let name = of.name.clone();
            let servo = ServoDevice { device, name, drive, id, model, port, baud, mode, position_lag };
            let servo = servo.with_counts(machine);
            if let Some((given, error)) = counts
                && (given.abs() / servo.drive.counts_per_turn.abs() - 1.0).abs() > ROUNDING
            {
                return Err(error);
            }
            servos.push(servo);
        }
        Ok(servos)
    }
}

impl DeviceReader for DeviceTables {
    fn devices(&self, machine: &Machine) -> Result<AnyDevices, DescriptionError> {
        let none = self.read.is_empty();
        Ok(Arc::new(if none { ServoDevice::simulated(machine) } else { self.identified(machine)? }))
    }
}

impl BusReader for DeviceTables {
    fn keys(&self) -> BusKeys {
        BusKeys {
            device: vec!["id", "model", "port", "baud", "no_watchdog", "position_lag_s"],
            drive: vec!["operating_mode"],
            channel: vec![],
        }
    }

    fn read(
        &mut self,
        device: &Table<'_>,
        _channels: &[Table<'_>],
        listing: &mut Listing,
    ) -> Result<(), DescriptionError> {
        let entry = device.required("id")?;
        let source = |entry: &Entry<'_>| ValueSource::File { line: entry.line() };
        if device.entry("muscle").is_none() {
            return Err(entry.refuse("no such key in a table without `muscle`: a servo is the drive of one"));
        }
        let id = entry.number(ID)?;
        listing.number("id", id, source(&entry));
        let port =
            device.entry("port").map(|entry| entry.text("the path of a serial port").map(str::to_owned));
        let port = port.transpose()?;
        if self.read.iter().any(|other| (other.id, &other.port) == (id as u8, &port)) {
            return Err(entry.refuse("an id that no servo above has on the same port"));
        }
        let named = device.required("model")?;
        let model = model(&named, device)?;
        listing.text("model", &model.name, source(&named));
        let feetech = model.series == Series::Sts;
        let rate = if feetech { STS_RATE } else { RATE };
        let baud = device.entry("baud").map_or(Ok(f64::from(BAUD[3])), |entry| entry.number(rate))?;
        // Without a watchdog a servo stands at its last position, but turns on at its last speed.
        let modes = (&["velocity", "extended_position"][..], usize::from(feetech));
        let extended = listing.word(device, "operating_mode", modes)? == 1;
        let position_lag = position_lag(device, extended, listing)?;
        check_watchdog(feetech, extended, device, &named)?;
        let counts = device.entry("counts_per_turn").map(|entry| -> Result<_, DescriptionError> {
            let expected = format!(
                "{:?} over the ratio of the drive's reducer, negative where it counts the other way, or nothing",
                model.counts
            );
            Ok((entry.number(Domain::new("a number", f64::is_finite))?, entry.refuse(&expected)))
        });
        let current = device.entry("mode").filter(|_| !model.has_current_loop());
        let current = current.map(|entry| entry.refuse("velocity: this model has no current loop"));
        self.read.push(Identified {
            id: id as u8,
            port,
            baud: baud as u32,
            extended,
            position_lag,
            counts: counts.transpose()?,
            current,
            model,
        });
        Ok(())
    }
}

/// Whoever commands a servo without a bus watchdog its speed says that this is known; no other servo is
/// without.
fn check_watchdog(
    without: bool,
    extended: bool,
    device: &Table<'_>,
    model: &Entry<'_>,
) -> Result<(), DescriptionError> {
    match device.entry("no_watchdog") {
        Some(entry) if !without => Err(entry.refuse("no such key: the servo has a bus watchdog")),
        Some(entry) if entry.flag()? || extended => Ok(()),
        _ if !without || extended => Ok(()),
        _ => Err(model.refuse(
            "no_watchdog = true beside it: in velocity mode this servo turns on at its last speed when the \
             computer is gone",
        )),
    }
}

/// Lag of the loop of the position, s, which has a meaning for servos that are commanded one.
fn position_lag(device: &Table<'_>, extended: bool, listing: &mut Listing) -> Result<f64, DescriptionError> {
    let entry = device.entry("position_lag_s");
    if let Some(entry) = entry.as_ref().filter(|_| !extended) {
        return Err(entry.refuse("no such key without operating_mode = \"extended_position\""));
    }
    let lag = entry.as_ref().map_or(Ok(ServoDevice::POSITION_LAG), |entry| entry.number(LAG))?;
    if extended {
        listing.number("position_lag_s", lag, source_of(entry.map(|entry| entry.line())));
    }
    Ok(lag)
}

/// A model of the table by its name, or one of a user's own:
/// `{ name, number, counts, velocity_rpm, current_a, max_velocity, series }`.
fn model(entry: &Entry<'_>, device: &Table<'_>) -> Result<Model, DescriptionError> {
    let Some(table) = entry.is_table().then(|| device.table("model")).transpose()?.flatten() else {
        let mut models: Vec<Model> = Model::all().collect();
        let names: Vec<&str> = models.iter().map(|model| model.name.as_str()).collect();
        let found = entry.name("servo's model", &names)?;
        return Ok(models.swap_remove(found));
    };
    table.check_keys(&["name", "number", "counts", "velocity_rpm", "current_a", "max_velocity", "series"])?;
    let chosen = match table.entry("series") {
        Some(series) => series.name("series of servos", &["X", "P", "STS"])?,
        None => 0,
    };
    let number = |key, domain| table.required(key)?.number(domain);
    Ok(Model {
        name: table.required("name")?.text("the name of a model")?.to_owned(),
        number: Some(number("number", NUMBER)? as u16),
        counts: number("counts", POSITIVE)?,
        velocity_rpm: number("velocity_rpm", POSITIVE)?,
        current_a: number("current_a", NOT_NEGATIVE)?,
        max_velocity: number("max_velocity", VELOCITIES)? as u32,
        series: [Series::X, Series::P, Series::Sts][chosen],
    })
}
