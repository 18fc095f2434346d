//! From a silent wire to configured devices in OP.

use super::device::EthercatDevice;
use super::error::EthercatError;
use super::found::FoundDevice;
use super::sii;
use crate::cia402::{MODE, Mapping, desired_mapping, mode_of_operation};
use ethercrab::error::Error;
use ethercrab::subdevice_group::{Op, PreOp, PreOpPdi};
use ethercrab::{Command, DefaultLock, MainDevice, SubDevice, SubDeviceGroup, SubDeviceRef};
use sinew::machine::DeviceRole;

/// Devices of one master, at most; a power of 2.
pub(super) const MAX_DEVICES: usize = 128;
/// Octets of process data, at most.
pub(super) const MAX_OCTETS: usize = 4096;

pub(super) type PreOpGroup = SubDeviceGroup<MAX_DEVICES, MAX_OCTETS, DefaultLock, PreOp>;
pub(super) type PreOpPdiGroup = SubDeviceGroup<MAX_DEVICES, MAX_OCTETS, DefaultLock, PreOpPdi>;
pub(super) type OpGroup = SubDeviceGroup<MAX_DEVICES, MAX_OCTETS, DefaultLock, Op>;

/// Station address of the first device, as ethercrab gives it.
pub(super) const FIRST_STATION: u16 = 0x1000;
/// Registers of the EtherCAT slave controller, ETG.1000.4.
pub(super) const AL_CONTROL: u16 = 0x0120;
pub(super) const AL_STATUS: u16 = 0x0130;
pub(super) const AL_STATUS_CODE: u16 = 0x0134;
const WATCHDOG_DIVIDER: u16 = 0x0400;
const PROCESS_DATA_WATCHDOG: u16 = 0x0420;
/// Divider for 100 us.
const DIVIDER_100_US: u16 = 2498;

/// Assignment of outputs and inputs, and the PDOs that are mapped anew.
const ASSIGNMENTS: [u16; 2] = [0x1c12, 0x1c13];
const PDOS: [u16; 2] = [0x1600, 0x1a00];
/// Synchronisation parameters of outputs and inputs, and the value of their type (subindex 1) for SYNC0,
/// ETG.1020.
const SYNCHRONIZATION: [u16; 2] = [0x1c32, 0x1c33];
const WITH_SYNC0: u16 = 2;
/// Interpolation time, object 0x60C2.
const INTERPOLATION_TIME: u16 = 0x60c2;

pub(super) fn protocol(during: impl Into<String>) -> impl FnOnce(Error) -> EthercatError {
    move |error| EthercatError::Protocol { during: during.into(), reason: format!("{error}") }
}

/// All devices in PRE-OP.
pub(super) async fn pre_op(main: &MainDevice<'_>) -> Result<(PreOpGroup, Vec<FoundDevice>), EthercatError> {
    // The clocks' own time serves: only differences count.
    let group = main
        .init_single_group::<MAX_DEVICES, MAX_OCTETS>(|| 0)
        .await
        .map_err(protocol("bringing the devices to PRE-OP"))?;
    let found = group.iter(main).enumerate().map(|(position, device)| {
        let identity = device.identity();
        FoundDevice {
            position,
            name: device.name().to_owned(),
            identity: [identity.vendor_id, identity.product_id, identity.revision],
            serial: identity.serial,
            alias: device.alias_address(),
        }
    });
    let found = found.collect();
    Ok((group, found))
}

/// Outputs and inputs of one device after its configuration.
pub(super) type Mappings = [Mapping; 2];

/// Maps the objects of the cycle, sets modes, watchdogs and interpolation times: `[devices]` in the order of
/// the machine.
pub(super) async fn configure(
    main: &MainDevice<'_>,
    group: &PreOpGroup,
    (devices, positions): (&[EthercatDevice], &[usize]),
    period: u64,
    watchdog: u64,
) -> Result<Vec<Mappings>, EthercatError> {
    let mut mappings = Vec::new();
    for (device, position) in devices.iter().zip(positions) {
        let during = || format!("configuring {}", device.name());
        let subdevice = group.subdevice(main, *position).map_err(protocol(during()))?;
        if let DeviceRole::Drive(drive) = &device.device.role {
            for ((assignment, pdo), entries) in ASSIGNMENTS.iter().zip(PDOS).zip(desired_mapping(drive.mode))
            {
                // A drive whose mapping is fixed may have the objects all the same: what it has is read
                // below.
                let _ = remap(&subdevice, *assignment, pdo, &entries).await;
            }
            let mode = mode_of_operation(drive.mode);
            subdevice.sdo_write(MODE, 0, mode).await.map_err(protocol(during()))?;
            // Optional in velocity and torque modes.
            let (count, exponent) = interpolation_time(period);
            let _ = subdevice.sdo_write(INTERPOLATION_TIME, 1, count).await;
            let _ = subdevice.sdo_write(INTERPOLATION_TIME, 2, exponent).await;
            if device.sync0 && subdevice.dc_support().enhanced() {
                // A drive that is synchronised by SYNC0 alone has nothing to choose here.
                for parameters in SYNCHRONIZATION {
                    let _ = subdevice.sdo_write(parameters, 1, WITH_SYNC0).await;
                }
            }
        }
        let mapping = read_mappings(main, &subdevice).await.map_err(protocol(during()))?;
        if mapping[0].length() > 0 {
            set_watchdog(&subdevice, watchdog, device.name()).await?;
        }
        mappings.push(mapping);
    }
    Ok(mappings)
}

/// A period, ns, as a number and a power of ten, s: exactly in milliseconds or tenths of them, else rounded
/// to those.
fn interpolation_time(period: u64) -> (u8, i8) {
    let (count, exponent) = if period.is_multiple_of(1_000_000) {
        (period / 1_000_000, -3)
    } else {
        ((period + 50_000) / 100_000, -4)
    };
    (u8::try_from(count).unwrap_or(u8::MAX), exponent)
}

async fn remap(
    subdevice: &SubDeviceRef<'_, &SubDevice>,
    assignment: u16,
    pdo: u16,
    entries: &[u32],
) -> Result<(), Error> {
    subdevice.sdo_write(assignment, 0, 0_u8).await?;
    subdevice.sdo_write(pdo, 0, 0_u8).await?;
    for (k, entry) in entries.iter().enumerate() {
        subdevice.sdo_write(pdo, k as u8 + 1, *entry).await?;
    }
    subdevice.sdo_write(pdo, 0, entries.len() as u8).await?;
    subdevice.sdo_write(assignment, 1, pdo).await?;
    subdevice.sdo_write(assignment, 0, 1_u8).await
}

/// What is mapped: from the objects of the assignment, or from the EEPROM of a device without a mailbox.
async fn read_mappings(
    main: &MainDevice<'_>,
    subdevice: &SubDeviceRef<'_, &SubDevice>,
) -> Result<Mappings, Error> {
    let mut mappings = Mappings::default();
    for (mapping, assignment) in mappings.iter_mut().zip(ASSIGNMENTS) {
        match read_assigned(subdevice, assignment, mapping).await {
            Ok(()) => {}
            // Without a mailbox, or without such an object: it is a device of fixed process data.
            Err(Error::Mailbox(_)) => {
                let read = async |word: u16, buffer: &mut [u8]| {
                    subdevice.eeprom_read_raw(main, word, buffer).await.map(drop)
                };
                return sii::mappings(read).await;
            }
            Err(error) => return Err(error),
        }
    }
    Ok(mappings)
}

async fn read_assigned(
    subdevice: &SubDeviceRef<'_, &SubDevice>,
    assignment: u16,
    mapping: &mut Mapping,
) -> Result<(), Error> {
    let pdos: u8 = subdevice.sdo_read(assignment, 0).await?;
    for k in 1..=pdos {
        let pdo: u16 = subdevice.sdo_read(assignment, k).await?;
        let entries: u8 = subdevice.sdo_read(pdo, 0).await?;
        for j in 1..=entries {
            mapping.push(subdevice.sdo_read(pdo, j).await?);
        }
    }
    Ok(())
}

/// Drives stop by themselves where no outputs come for this long, ns; what was written is read back.
async fn set_watchdog(
    subdevice: &SubDeviceRef<'_, &SubDevice>,
    watchdog: u64,
    name: &str,
) -> Result<(), EthercatError> {
    let during = || format!("setting the watchdog of {name}");
    let periods = (watchdog / 100_000) as u16;
    for (register, value) in [(WATCHDOG_DIVIDER, DIVIDER_100_US), (PROCESS_DATA_WATCHDOG, periods)] {
        subdevice.register_write(register, value).await.map_err(protocol(during()))?;
        let got: u16 = subdevice.register_read(register).await.map_err(protocol(during()))?;
        if got != value {
            let reason = format!("register {register:#06x} is {got}: expected {value}");
            return Err(EthercatError::Protocol { during: during(), reason });
        }
    }
    Ok(())
}

/// Gives the process data of all devices their logical addresses.
pub(super) async fn map_addresses(
    main: &MainDevice<'_>,
    group: PreOpGroup,
) -> Result<PreOpPdiGroup, EthercatError> {
    group.into_pre_op_pdi(main).await.map_err(|error| match error {
        Error::PdiTooLong { max_length, desired_length } => {
            EthercatError::TooLong { octets: desired_length, most: max_length }
        }
        error => protocol("giving the process data its addresses")(error),
    })
}

/// All devices in SAFE-OP, with OP requested: they reach it while process data is exchanged.
pub(super) async fn request_op(
    main: &MainDevice<'_>,
    group: PreOpPdiGroup,
    devices: &[String],
) -> Result<OpGroup, EthercatError> {
    let requested = async { group.into_safe_op(main).await?.request_into_op(main).await };
    match requested.await {
        Ok(group) => Ok(group),
        Err(error) => Err(match not_in_state(main, devices, SAFE_OP).await {
            Some(device) => device,
            None => protocol("bringing the devices to SAFE-OP")(error),
        }),
    }
}

/// States of the register AL status.
pub(super) const SAFE_OP: u8 = 4;
pub(super) const OP: u8 = 8;
/// Bit of the register AL status: the device refused or left a state.
pub(super) const AL_ERROR: u8 = 0x10;

/// The first device, by name in the order on the wire, that is below a state or reports an error.
pub(super) async fn not_in_state(
    main: &MainDevice<'_>,
    devices: &[String],
    desired: u8,
) -> Option<EthercatError> {
    for (position, name) in devices.iter().enumerate() {
        let station = FIRST_STATION + position as u16;
        let status = Command::fprd(station, AL_STATUS).receive::<u16>(main).await;
        let Ok(status) = status else {
            let (state, reason) = ("no state", "it does not answer".to_owned());
            return Some(EthercatError::NotOperational { device: name.clone(), state, reason });
        };
        let status = status as u8;
        if status & 0x0f < desired || status & AL_ERROR != 0 {
            let code = Command::fprd(station, AL_STATUS_CODE).receive::<u16>(main).await.unwrap_or(0);
            let reason = format!("{} (AL status code {code:#06x})", ethercrab::AlStatusCode::from(code));
            return Some(EthercatError::NotOperational {
                device: name.clone(),
                state: state_name(status),
                reason,
            });
        }
    }
    None
}

/// A state of the register AL status in words.
pub(super) fn state_name(status: u8) -> &'static str {
    match status & 0x0f {
        1 => "INIT",
        2 => "PRE-OP",
        3 => "BOOT",
        4 => "SAFE-OP",
        8 => "OP",
        _ => "no state",
    }
}
