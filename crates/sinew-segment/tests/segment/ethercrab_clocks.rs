//! ethercrab synchronises drifting clocks and runs the drives with SYNC0, in virtual time.

use crate::master::{Line, timeouts};
use core::time::Duration;
use ethercrab::subdevice_group::DcConfiguration;
use ethercrab::{DcSync, MainDevice, MainDeviceConfig, PduStorage, SubDeviceGroup, Timeouts};
use sinew_segment::{AlState, Device, DeviceSettings, Segment, builtin};

const FRAME: usize = PduStorage::element_size(1100);
const MILLISECOND: u64 = 1_000_000;

#[test]
fn drives_run_with_sync0_on_synchronised_clocks() {
    static STORAGE: PduStorage<4, FRAME> = PduStorage::new();
    let (tx, rx, pdu_loop) = STORAGE.try_split().unwrap();
    let config = MainDeviceConfig { dc_static_sync_iterations: 3000, ..MainDeviceConfig::default() };
    let main_device = MainDevice::new(pdu_loop, timeouts(Timeouts::default()), config);
    let drive = |drift_ppb, clock_at_start_ns| {
        let settings = DeviceSettings { drift_ppb, clock_at_start_ns, ..DeviceSettings::default() };
        Device::new(&builtin::drive(), settings).unwrap()
    };
    let segment = Segment::new(vec![drive(0, 0), drive(60_000, 12_345_678), drive(-90_000, 987_654_321)]);
    let mut line = Line::new(segment, tx, rx);

    let mut group: SubDeviceGroup<4, 128> =
        line.run(main_device.init_single_group::<4, 128>(crate::master::now)).expect("PRE-OP");
    for mut device in group.iter_mut(&main_device) {
        device.set_dc_sync(DcSync::Sync0);
    }
    let group = line.run(group.into_pre_op_pdi(&main_device)).expect("PDI");
    let configuration = DcConfiguration {
        start_delay: Duration::from_millis(50),
        sync0_period: Duration::from_millis(1),
        sync0_shift: Duration::ZERO,
    };
    let group = line.run(group.configure_dc_sync(&main_device, configuration)).expect("SYNC0");
    let group = line.run(group.into_safe_op(&main_device)).expect("SAFE-OP");
    let group = line.run(group.request_into_op(&main_device)).expect("request");
    let mut all_op = false;
    for _ in 0..200 {
        let response = line.run(group.tx_rx_dc(&main_device)).unwrap();
        all_op = response.all_op();
        line.wait(MILLISECOND);
    }
    assert!(all_op && line.segment().devices().iter().all(|device| device.state() == AlState::Op));
    let times: Vec<u64> = line.segment().devices().iter().map(|device| device.clock().unwrap().1).collect();
    let spread = times.iter().max().unwrap() - times.iter().min().unwrap();
    // Delays of the line, 500 ns from device to device, are made up for.
    assert!(spread < 100, "{times:?}: {spread} ns apart");
}
