//! What identifies devices in a machine file: read, or refused with line, key and what was expected.

use sinew::description::machine::machine_on_bus;
use sinew::description::{DescriptionError, MachineDescription};
use sinew::machine::Machine;
use sinew_runtime::can::{CanDevice, Protocol};
use sinew_runtime::cia402::ObjectAddress;
use sinew_runtime::ethercat::{ChannelObjects, DeviceIdentity, EthercatDevice, RevisionRule};
use sinew_runtime::servos::{OperatingMode, Series, ServoDevice};
use sinew_runtime::{DeviceTables, Devices};

/// Devices of a machine with two muscles.
const DEVICES: &str = r#"
[[device]]
name = "coupler"
vendor = 2
product = 0x044c2c52
revision_rule = "any"

[[device]]
name = "drive of the flexor"
vendor = 0x51e37
product = 0x10402
revision = 0x10000
revision_rule = "exact"
alias = 1001
muscle = "flexor"
mode = "torque"
synchronization = "frame"

[[device]]
name = "drive of the extensor"
vendor = 0x51e37
product = 0x10402
muscle = "extensor"

[[device]]
name = "sensors"
vendor = 2
product = 0x0d1e3052

[[device.channel]]
name = "force"
muscle = "flexor"
value = [0x6000, 17]
status = { object = [0x6010, 1], error_mask = 0x60 }
scale = -0.01
"#;

const LEG: &str = r#"<mujoco><worldbody><body name="shank">
  <joint name="knee" axis="0 1 0" range="0 90"/><inertial pos="0 0 -0.2" mass="1" diaginertia="0.01 0.01 0.001"/>
</body></worldbody><tendon>
  <fixed name="extensor"><joint joint="knee" coef="0.03"/></fixed>
  <fixed name="flexor"><joint joint="knee" coef="-0.03"/></fixed>
</tendon></mujoco>"#;

fn read(devices: &str) -> Result<(MachineDescription, Vec<EthercatDevice>), DescriptionError> {
    let (described, devices) = read_all(devices)?;
    Ok((described, devices.of().to_vec()))
}

fn read_all(devices: &str) -> Result<(MachineDescription, Devices), DescriptionError> {
    let mut tables = DeviceTables::default();
    let text = format!("body = \"leg.xml\"\n{devices}");
    let mut described = machine_on_bus("leg.toml", &text, &mut |_| Ok(LEG.to_owned()), &mut tables)?;
    let devices = tables.devices(&mut described.machine)?;
    Ok((described, devices))
}

/// The error of the devices with one line in place of another; it stands on that line.
fn error(line: usize, by: &str) -> String {
    let mut lines: Vec<&str> = DEVICES.lines().collect();
    lines[line] = by;
    let error = read(&lines.join("\n")).err().unwrap_or_else(|| panic!("accepted: {by}"));
    // The body stands on the first line, and lines count from 1.
    assert_eq!(error.line, line + 2, "{by}: {error}");
    error.to_string()
}

#[test]
fn devices_are_read_with_their_identity_objects_and_roles() {
    let (described, devices) = read(DEVICES).unwrap();
    assert_eq!(devices.len(), 4);
    let [coupler, flexor, extensor, sensors] = &devices[..] else { panic!("{devices:?}") };
    assert!(coupler.objects.is_empty() && coupler.identity.rule == RevisionRule::Any);
    let identity =
        DeviceIdentity { vendor: 0x51e37, product: 0x10402, revision: 0x10000, rule: RevisionRule::Exact };
    assert_eq!((flexor.identity, flexor.alias, flexor.sync0), (identity, Some(1001), false));
    assert_eq!((extensor.alias, extensor.sync0), (None, true));
    assert_eq!(extensor.identity.rule, RevisionRule::AtLeast);
    let address = |index, subindex| ObjectAddress { index, subindex };
    let objects = ChannelObjects { value: address(0x6000, 17), status: Some((address(0x6010, 1), 0x60)) };
    assert_eq!(sensors.objects, [objects]);
    let of_machine: Vec<_> = devices.iter().map(|device| &device.device).collect();
    assert_eq!(of_machine, described.machine.devices.iter().collect::<Vec<_>>());
    // Every value is listed with its line, those of the bus beside those of the role.
    for key in ["vendor", "revision_rule", "synchronization", "mode", "channel"] {
        assert!(described.settings.iter().any(|setting| setting.key == key), "{key}");
    }
}

#[test]
fn every_key_of_a_device_is_refused_where_it_is_misspelt_or_has_another_value() {
    let mut checked = 0;
    for (line, text) in DEVICES.lines().enumerate() {
        let Some((key, value)) = text.split_once(" = ") else { continue };
        let told = error(line, &format!("{key}x = {value}"));
        assert!(told.contains(&format!("expected `{key}`")), "{told}");
        if key != "name" {
            let wrong = if value.starts_with('"') { "17.25" } else { "\"much\"" };
            for wrong in [wrong, "true", "[1, 2, 3]"] {
                assert!(error(line, &format!("{key} = {wrong}")).contains(key), "{key} = {wrong}");
            }
            checked += 1;
        }
    }
    assert!(checked > 15, "{checked}");
}

#[test]
fn numbers_of_a_bus_are_whole_and_within_their_bits() {
    for (at, wrong, expected) in [
        ("vendor = 2", "vendor = -1", "0..=0xffffffff"),
        ("vendor = 2", "vendor = 0x100000000", "0..=0xffffffff"),
        ("product = 0x044c2c52", "product = 0.5", "0..=0xffffffff"),
        ("alias = 1001", "alias = 0", "1..=0xffff"),
        ("alias = 1001", "alias = 65536", "1..=0xffff"),
        ("value = [0x6000, 17]", "value = [0x6000, 256]", "0..=0xff"),
        ("value = [0x6000, 17]", "value = [0x16000, 1]", "0..=0xffff"),
        ("revision_rule = \"any\"", "revision_rule = \"at_last\"", "`at_least`"),
    ] {
        let line = DEVICES.lines().position(|text| text == at).unwrap();
        let told = error(line, wrong);
        assert!(told.contains(expected), "{told}");
    }
    for gone in ["vendor = 2", "product = 0x044c2c52", "value = [0x6000, 17]"] {
        let key = gone.split(' ').next().unwrap();
        let told = read(&DEVICES.replacen(gone, "", 1)).err().unwrap().to_string();
        assert!(told.contains(&format!("{key} is missing")), "{told}");
    }
}

#[test]
fn synchronization_is_of_drives_alone() {
    let line = DEVICES.lines().position(|text| text.starts_with("revision_rule = \"any\"")).unwrap();
    let told = error(line, "synchronization = \"frame\"");
    assert!(told.contains("the device is no drive"), "{told}");
}

/// The same two drives with these lines.
fn drives(flexor: &str, extensor: &str) -> String {
    let drive =
        |name: &str, more: &str| format!("[[device]]\nname = \"{name}\"\nmuscle = \"{name}\"\n{more}\n");
    drive("flexor", flexor) + &drive("extensor", extensor)
}

/// The same two drives as nodes on CAN, the second with `more`.
fn nodes(more: &str) -> String {
    drives("node = 3\nvendor = 0x1d\nbitrate = 500000\nport = \"/dev/ttyACM0\"", more)
}

#[test]
fn servos_of_two_makers_are_read_and_those_without_a_watchdog_only_where_that_is_said() {
    let with = |more: &str| drives("id = 1\nmodel = \"STS3215\"\nno_watchdog = true\nport = \"a\"", more);
    let (_, devices) = read_all(&with("id = 1\nmodel = \"XM430-W210\"\nport = \"b\"")).unwrap();
    let series: Vec<_> = devices.of::<ServoDevice>().iter().map(|servo| servo.model.series).collect();
    assert_eq!(series, [Series::Sts, Series::X]);
    let commanded = |more: &str| {
        let more = format!("id = 2\nmodel = \"STS3215\"\n{more}");
        let servo = read_all(&with(&more)).unwrap().1.of::<ServoDevice>()[1].clone();
        (servo.mode, servo.position_lag)
    };
    // Without a watchdog, by default, what stands when the computer is gone.
    assert_eq!(commanded(""), (OperatingMode::ExtendedPosition, ServoDevice::POSITION_LAG));
    assert_eq!(commanded("position_lag_s = 0.03"), (OperatingMode::ExtendedPosition, 0.03));
    assert_eq!(commanded("operating_mode = \"velocity\"\nno_watchdog = true").0, OperatingMode::Velocity);
    let table = "{ name = \"STS3032\", number = 1, series = \"STS\", counts = 4096, velocity_rpm = 0.0146484375, \
        current_a = 6.5e-3, max_velocity = 4000 }";
    let own = with(&format!("id = 2\nmodel = {table}\nno_watchdog = true\nbaud = 500000"));
    assert_eq!(read_all(&own).unwrap().1.of::<ServoDevice>()[1].model.series, Series::Sts);
    for (more, parts) in [
        ("id = 2\nmodel = \"STS3250\"\noperating_mode = \"velocity\"", ["model", "no_watchdog = true"]),
        (
            "id = 2\nmodel = \"STS3250\"\noperating_mode = \"velocity\"\nno_watchdog = false",
            ["model", "no_watchdog = true"],
        ),
        ("id = 2\nmodel = \"STS3250\"\nposition_lag_s = 0.3", ["position_lag_s", "0..=0.2"]),
        ("id = 2\nmodel = \"XM430-W210\"\nposition_lag_s = 0.02", ["position_lag_s", "extended_position"]),
        ("id = 2\nmodel = \"XM430-W210\"\nno_watchdog = true", ["no_watchdog", "has a bus watchdog"]),
        ("id = 2\nmodel = \"STS3215\"\nno_watchdog = true\nbaud = 3000000", ["baud", "1 million"]),
        ("id = 2\nmodel = \"STS3215\"\nno_watchdog = true\nmode = \"torque\"", ["mode", "no current loop"]),
        ("id = 2\nmodel = \"STS3215\"\noperating_mode = \"position\"", ["operating_mode", "velocity"]),
        ("id = 1\nmodel = \"STS3215\"\nport = \"a\"", ["id", "no servo above has on the same port"]),
    ] {
        let told = read_all(&with(more)).err().unwrap_or_else(|| panic!("accepted: {more}")).to_string();
        assert!(parts.iter().all(|part| told.contains(part)), "{told}: {parts:?}");
    }
}

#[test]
fn nodes_on_can_are_read_and_what_is_none_of_theirs_is_refused() {
    let (described, devices) = read_all(&nodes("node = 4")).unwrap();
    // The gains of a machine on a bus that reads ahead know of it.
    let Machine { reading_age, period, .. } = described.machine;
    assert_eq!(reading_age.to_bits(), period.to_bits());
    assert!(devices.of::<EthercatDevice>().is_empty() && devices.of::<ServoDevice>().is_empty());
    let [flexor, extensor] = devices.of::<CanDevice>() else { panic!("{devices:?}") };
    assert_eq!((flexor.node, flexor.identity, flexor.bitrate), (3, [Some(0x1d), None], 500_000));
    assert_eq!(flexor.port.as_deref(), Some("/dev/ttyACM0"));
    assert_eq!((extensor.node, extensor.identity, extensor.bitrate), (4, [None; 2], 1_000_000));
    let twice = read_all(&nodes("node = 3")).err().unwrap().to_string();
    assert!(twice.contains("a node that no device above has"), "{twice}");
    let axes = drives(
        "node = 0\nprotocol = \"cansimple\"",
        "node = 62\nprotocol = \"cansimple\"\ncounts_per_turn = -1",
    );
    let (_, devices) = read_all(&axes).unwrap();
    let [flexor, extensor] = devices.of::<CanDevice>() else { panic!("{devices:?}") };
    let of = |axis: &CanDevice| (axis.protocol, axis.node, axis.drive.counts_per_turn);
    assert_eq!(of(flexor), (Protocol::Cansimple, 0, 1.0));
    assert_eq!(of(extensor), (Protocol::Cansimple, 62, -1.0));
    let moteus = drives(
        "node = 1\nprotocol = \"moteus\"",
        "node = 126\nprotocol = \"moteus\"\ncounts_per_turn = -0.1",
    );
    let (_, devices) = read_all(&moteus).unwrap();
    let [flexor, extensor] = devices.of::<CanDevice>() else { panic!("{devices:?}") };
    assert_eq!(of(flexor), (Protocol::Moteus, 1, 1.0));
    assert_eq!(of(extensor), (Protocol::Moteus, 126, -0.1));
    let own = "{ name = \"own\", family = \"mini-cheetah\", position_rad = 95.5, velocity_rad_s = 45, torque_nm = 18, \
        current_a = 40 }";
    let mit = drives(
        "node = 15\nprotocol = \"mit\"\nmodel = \"DM-J4310\"",
        &format!(
            "node = 126\nprotocol = \"mit\"\nmodel = {own}\ncounts_per_turn = -0.1\ndamping_nm_s_per_rad = 1\noffset_rad = 3"
        ),
    );
    let (described, devices) = read_all(&mit).unwrap();
    let [flexor, extensor] = devices.of::<CanDevice>() else { panic!("{devices:?}") };
    let drive = described.machine.muscles[0].drive;
    assert_eq!(of(flexor), (Protocol::Mit, 15, 1.0 / drive.reducer.ratio));
    // Without a zero that is said it is the middle of the drum.
    assert!(
        (drive.winch.angle(0.5 * drive.winch.capacity()) * drive.reducer.ratio - flexor.drive.offset).abs()
            < 1e-9
    );
    assert_eq!((of(extensor), extensor.drive.offset), ((Protocol::Mit, 126, -0.1), 3.0));
    let motor = extensor.mit.as_ref().unwrap();
    assert_eq!((motor.ranges.position, motor.ranges.current, motor.damping), (95.5, Some(40.0), 1.0));
    assert!(motor.stiffness > 0.0 && motor.stiffness < motor.ranges.stiffness);
    for (more, parts) in [
        ("node = 127", ["node", "1..=126"]),
        ("node = 4\nbitrate = 9600", ["bitrate", "500"]),
        ("node = 4\nproduct = -1", ["product", "0..=0xffffffff"]),
        ("node = 0", ["node", "1..=126"]),
        ("node = 4\nendpoints = \"a\"", ["endpoints", "CANopen"]),
        ("node = 63\nprotocol = \"cansimple\"", ["node", "0..=62"]),
        ("node = 4\nprotocol = \"cia402\"", ["protocol", "mit"]),
        ("node = 4\nprotocol = \"mit\"", ["model", "is missing"]),
        ("node = 4\nprotocol = \"mit\"\nmodel = \"AK80\"", ["model", "AK80-6"]),
        ("node = 16\nprotocol = \"mit\"\nmodel = \"DM-J4310\"", ["node", "1..=15"]),
        ("node = 4\nprotocol = \"mit\"\nmodel = \"AK80-9\"\nvendor = 1", ["vendor", "MIT mode"]),
        ("node = 4\nprotocol = \"mit\"\nmodel = \"AK80-9\"\ndamping_nm_s_per_rad = 0", ["damping", "> 0"]),
        ("node = 4\nprotocol = \"mit\"\nmodel = { name = \"a\" }", ["family", "is missing"]),
        ("node = 4\nprotocol = \"moteus\"\nmodel = \"AK80-9\"", ["model", "moteus"]),
        ("node = 4\nstiffness_nm_per_rad = 1", ["stiffness_nm_per_rad", "CANopen"]),
        ("node = 0\nprotocol = \"moteus\"", ["node", "1..=126"]),
        ("node = 4\nprotocol = \"moteus\"\nbitrate = 500000", ["bitrate", "moteus"]),
        ("node = 4\nprotocol = \"moteus\"\nendpoints = \"a\"", ["endpoints", "moteus"]),
        ("node = 4\nprotocol = \"moteus\"\ncounts_per_turn = 0", ["counts_per_turn", "not 0"]),
        ("node = 4\nprotocol = \"cansimple\"\nvendor = 1", ["vendor", "CANSimple"]),
        ("node = 4\nprotocol = \"cansimple\"\nrated_torque_nm = 1", ["rated_torque_nm", "CANSimple"]),
        ("node = 4\nprotocol = \"cansimple\"\ncounts_per_turn = 8192", ["counts_per_turn", "1 or -1"]),
        ("node = 4\nmode = \"torque\"", ["mode", "velocity"]),
        ("node = 4\nbaud = 1000000", ["baud", "a device of can"]),
        ("node = 4\nsynchronization = \"frame\"", ["synchronization", "a device of can"]),
        ("id = 4\nmodel = \"XM430-W210\"", ["id", "devices of one bus, can"]),
        ("vendor = 2\nproduct = 3", ["vendor", "devices of one bus, can"]),
        ("port = \"/dev/ttyACM0\"", ["node", "is missing"]),
    ] {
        let told = read_all(&nodes(more)).err().unwrap_or_else(|| panic!("accepted: {more}")).to_string();
        assert!(parts.iter().all(|part| told.contains(part)), "{told}: {parts:?}");
    }
}

#[test]
fn a_machine_without_tables_has_the_simulated_devices() {
    let (described, devices) = read("").unwrap();
    assert_eq!(devices, EthercatDevice::simulated(&described.machine));
    assert_eq!(devices.len(), 5);
    let (_, devices) = read_all("").unwrap();
    assert_eq!((devices.of::<ServoDevice>().len(), devices.of::<CanDevice>().len()), (2, 2));
}
