//! Descriptions of EtherCAT devices, as a table and as an ESI file. What is accepted makes a device.
#![no_main]

use libfuzzer_sys::fuzz_target;
use sinew_segment::{Device, DeviceDescription, DeviceSettings};

fuzz_target!(|octets: &[u8]| {
    let Ok(text) = std::str::from_utf8(octets) else { return };
    for read in [DeviceDescription::from_toml("a", text), DeviceDescription::from_esi("a", text, None, None)]
    {
        match read {
            Ok(description) => {
                Device::new(&description, DeviceSettings::default()).expect("what is read is valid");
            }
            Err(error) => assert!(error.line <= text.lines().count() + 1, "{error}"),
        }
    }
});
