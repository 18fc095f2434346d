//! A master of another project, ethercrab, brings the segment up in virtual time: one thread, no clock.

use crate::master::{Line, timeouts};
use ethercrab::{MainDevice, MainDeviceConfig, PduStorage, SubDeviceGroup, Timeouts};
use sinew_segment::{AlState, AxisCommand, Device, DeviceSettings, DriveState, Mode, Segment, builtin};

const FRAME: usize = PduStorage::element_size(1100);
const DRIVES: usize = 3;

type Storage = PduStorage<4, FRAME>;

fn segment() -> Segment {
    let device = |description, position: u32| {
        let settings = DeviceSettings {
            serial: Some(position),
            alias: 100 + position as u16,
            drift_ppb: 3000 * position as i32 - 5000,
            clock_at_start_ns: 1_000_000 * u64::from(position),
            ..DeviceSettings::default()
        };
        Device::new(&description, settings).unwrap()
    };
    let mut devices = vec![device(builtin::coupler(), 0)];
    devices.extend((1..=DRIVES as u32).map(|position| device(builtin::drive(), position)));
    devices.push(device(builtin::load_cell(), 4));
    devices.push(device(builtin::encoder(2), 5));
    Segment::new(devices)
}

#[test]
fn a_foreign_master_reaches_op_and_exchanges_process_data() {
    static STORAGE: Storage = Storage::new();
    let (tx, rx, pdu_loop) = STORAGE.try_split().unwrap();
    let main_device = MainDevice::new(pdu_loop, timeouts(Timeouts::default()), MainDeviceConfig::default());
    let mut line = Line::new(segment(), tx, rx);

    let group: SubDeviceGroup<8, 128> =
        line.run(main_device.init_single_group::<8, 128>(crate::master::now)).expect("PRE-OP");
    let names: Vec<_> = group.iter(&main_device).map(|device| device.name().to_owned()).collect();
    assert_eq!(names, ["SIM-CPL", "SIM-DRV1", "SIM-DRV1", "SIM-DRV1", "SIM-LC1", "SIM-ENC2"]);

    // Velocity instead of torque, by the assignment.
    for drive in group.iter(&main_device).filter(|device| device.name() == "SIM-DRV1") {
        line.run(drive.sdo_write(0x1c12, 0, 0_u8)).unwrap();
        line.run(drive.sdo_write(0x1c12, 1, 0x1601_u16)).unwrap();
        line.run(drive.sdo_write(0x1c12, 0, 1_u8)).unwrap();
        let name: [u8; 8] = line.run(drive.sdo_read(0x1008, 0)).unwrap();
        assert_eq!(&name, b"SIM-DRV1");
    }
    let group = line.run(group.into_pre_op_pdi(&main_device)).expect("PRE-OP with PDI");
    let group = line.run(group.into_safe_op(&main_device)).expect("SAFE-OP");
    let group = line.run(group.request_into_op(&main_device)).expect("request");
    let mut cycles = 0;
    while !line.run(group.tx_rx(&main_device)).unwrap().all_op() {
        cycles += 1;
        assert!(cycles < 100, "no OP after {cycles} cycles");
        line.wait(1_000_000);
    }
    assert!(line.segment().devices().iter().all(|device| device.state() == AlState::Op));

    line.segment_mut().device_mut(4).unwrap().set_input(0, -123_456);
    for _ in 0..10 {
        for drive in group.iter(&main_device).filter(|device| device.name() == "SIM-DRV1") {
            // Inputs and outputs share a lock.
            let status = {
                let inputs = drive.inputs_raw();
                u16::from_le_bytes([inputs[0], inputs[1]])
            };
            let mut outputs = drive.outputs_raw_mut();
            let control: u16 = match status & 0x6f {
                0x40 => 0x06,
                0x21 => 0x07,
                _ => 0x0f,
            };
            outputs[..2].copy_from_slice(&control.to_le_bytes());
            outputs[2..6].copy_from_slice(&5000_i32.to_le_bytes());
            outputs[6] = 9;
        }
        let response = line.run(group.tx_rx(&main_device)).unwrap();
        // Three drives read and write, the load cell and the encoders are read.
        assert_eq!(response.working_counter, 3 * DRIVES as u16 + 2);
        line.wait(1_000_000);
    }
    for position in 1..=DRIVES {
        let drive = line.segment().device(position).unwrap().drive().unwrap();
        assert_eq!((drive.state(), drive.mode()), (DriveState::OperationEnabled, Mode::Velocity));
        assert_eq!(drive.command(), AxisCommand::Velocity(5000));
    }
    let cell = group.subdevice(&main_device, 4).unwrap();
    assert_eq!(cell.inputs_raw()[2..6], (-123_456_i32).to_le_bytes());
}
