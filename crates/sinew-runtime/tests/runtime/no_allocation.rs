//! A control cycle over EtherCAT allocates nothing: master, drives, observers, controller, simulated devices
//! and twin.

use crate::common::{STEP, Setup, machine};
use allocation_counter::measure;
use sinew::control::supervisor::{Mode, Request};
use sinew::machine::Device;
use sinew::trajectory::online::JointLimits;
use sinew::twin::arm::ArmTwin;
use sinew_link::client::Client;
use sinew_link::host::{Server, ServerSettings, SessionSettings};
use sinew_link::{Command, Request as LinkRequest, SetpointKind, Setpoints};
use sinew_runtime::can::{self, CanBus, CanDevice, Protocol, SimulatedLink};
use sinew_runtime::cycle::{Cycle, VirtualClock};
use sinew_runtime::ethercat::FrameStorage;
use sinew_runtime::link::{LinkedMotion, domain};
use sinew_runtime::servos::{Model, OperatingMode, ServoBus, ServoDevice, SimulatedLines, SimulatedMachine};
use sinew_session::Plant;
use std::sync::atomic::{AtomicBool, Ordering};

#[test]
fn a_cycle_over_ethercat_allocates_nothing() {
    // The larger machine moves; the smaller one is also let down, taken up again and held.
    let then = [(Request::SafeStop, 20_000), (Request::Hold, 8000)];
    for (name, then) in [("lm_arm", &[][..]), ("finger", &then)] {
        let setup = Setup::new(machine(name), 1, &[]);
        let storage = FrameStorage::new();
        let bus = setup.segment_bus(&storage);
        let mut cycle = Cycle::new(bus, setup.supervisor(), setup.schedule(), STEP);
        let mut clock = VirtualClock::default();
        let mut moved = 0.0_f64;
        let counted = measure(|| {
            for _ in 0..1500 {
                let record = cycle.step(&mut clock, 0).unwrap();
                assert!(record.exchange.fault.is_none());
                moved = moved.max((record.command.arm.q[0] - setup.machine.start[0]).abs());
            }
            for (request, cycles) in then {
                cycle.motion_mut().ask(*request);
                for _ in 0..*cycles {
                    cycle.step(&mut clock, 0).unwrap();
                }
            }
        });
        assert_eq!(counted.count_total, 0, "{name}");
        let ends = if then.is_empty() { Mode::Run } else { Mode::Hold };
        assert_eq!(cycle.supervisor().mode(), ends, "{name}");
        assert!(moved > 1e-3, "{name}: the machine moved");
    }
}

#[test]
fn a_machine_that_its_encoders_find_elsewhere_is_led_to_its_motion_without_an_allocation() {
    for name in ["bench_joint", "planar_leg", "exosuit_elbow"] {
        for tense in [true, false] {
            let mut setup = Setup::new(machine(name), 1, &[]).into_backward();
            if !tense {
                // Its pretension lasts longer than its first rest.
                setup.machine.safety.pretension_time = 1.0;
                let specimen = setup.plant.specimen().clone();
                let slack: Vec<f64> =
                    specimen.cables.iter().map(|cable| cable.parameters.pretension + 0.5).collect();
                setup.plant = ArmTwin::new(&specimen, &setup.machine.start, &slack, 1).unwrap();
            }
            let storage = FrameStorage::new();
            let bus = setup.segment_bus(&storage);
            let mut cycle = Cycle::new(bus, setup.supervisor(), setup.schedule(), STEP);
            let (mut clock, mut before) = (VirtualClock::default(), Vec::with_capacity(8));
            let (mut ran, mut jump, mut error, mut moving) = (0_u32, 0.0_f64, 0.0_f64, 0_u32);
            let counted = measure(|| {
                while !cycle.is_finished() {
                    let record = cycle.step(&mut clock, 0).unwrap();
                    if record.command.mode != Mode::Run {
                        continue;
                    }
                    let reference = &record.reference.q;
                    ran += 1;
                    moving += u32::from(record.moment.repeat.is_some());
                    if ran > 2 {
                        for (q, before) in reference.iter().zip(&before) {
                            jump = jump.max(f64::abs(q - before));
                        }
                    }
                    before.clear();
                    before.extend_from_slice(reference);
                    for (q, reference) in record.feedback.joint.iter().zip(reference) {
                        error = if ran > 2 { error.max((q - reference).abs()) } else { error };
                    }
                }
            });
            assert_eq!(counted.count_total, 0, "{name}");
            assert_eq!(cycle.supervisor().mode(), Mode::Run, "{name}: it was never stopped");
            assert_eq!(moving, 2000, "{name}: it follows all of the motion");
            assert!(ran > 2 * 2000, "{name}: {ran}");
            assert!(jump < 5e-3 && error < 0.06, "{name} {tense}: {jump} {error}");
        }
    }
}

/// A machine whose only sensors are those of its drives.
fn bare_setup() -> Setup {
    let mut design = sinew::machine::Machine { period: 4e-3, ..machine("finger") };
    design.muscles.iter_mut().for_each(|muscle| muscle.drive.has_load_cell = false);
    design.encoders.fill(None);
    design.devices = Device::defaults(&design.robot, &design.muscles, &design.encoders);
    Setup::new(design, 1, &[])
}

/// Every cycle over such a bus allocates nothing and ends with the machine in motion.
fn allocates_nothing<B: Plant>(setup: &Setup, bus: B) {
    let mut cycle = Cycle::new(bus, setup.supervisor(), setup.schedule(), setup.machine.period);
    let mut clock = VirtualClock::default();
    let counted = measure(|| {
        for _ in 0..1000 {
            assert!(cycle.step(&mut clock, 0).unwrap().exchange.fault.is_none());
        }
    });
    assert_eq!(counted.count_total, 0);
    assert_eq!(cycle.supervisor().mode(), Mode::Run);
}

#[test]
fn a_cycle_over_can_allocates_nothing() {
    let setup = bare_setup();
    let canopen = CanDevice::simulated(&setup.machine);
    for protocol in [Protocol::Canopen, Protocol::Cansimple, Protocol::Moteus, Protocol::Mit] {
        let nodes: Vec<_> = canopen.iter().cloned().map(|node| node.on(protocol, &setup.machine)).collect();
        let simulated = can::SimulatedMachine::new(setup.plant.clone(), &setup.machine, &nodes, true);
        let bus = CanBus::start(SimulatedLink::new(simulated), &setup.machine, &nodes).unwrap();
        allocates_nothing(&setup, bus);
    }
}

#[test]
fn a_cycle_over_serial_servos_allocates_nothing() {
    let setup = bare_setup();
    let dynamixel = ServoDevice::simulated(&setup.machine);
    let model = Model::all().find(|model| model.name == "STS3215").unwrap();
    let model = Model { max_velocity: 32_767, ..model };
    let feetech = |mode| -> Vec<ServoDevice> {
        dynamixel.iter().map(|servo| ServoDevice { model: model.clone(), mode, ..servo.clone() }).collect()
    };
    let [velocity, position] = [OperatingMode::Velocity, OperatingMode::ExtendedPosition].map(feetech);
    for servos in [velocity, position, dynamixel.clone()] {
        let ports = ServoDevice::ports(&servos);
        let simulated = SimulatedMachine::new(setup.plant.clone(), &setup.machine, &servos, &ports, false);
        let bus = ServoBus::start(SimulatedLines::new(simulated), &setup.machine, &servos).unwrap();
        allocates_nothing(&setup, bus);
    }
}

#[test]
fn a_cycle_that_a_client_commands_allocates_nothing() {
    let setup = Setup::new(machine("lm_arm"), 1, &[]);
    let limits = JointLimits::of_motion(&setup.trajectory, setup.machine.ranges().unwrap()).unwrap();
    let gains = setup.supervisor().controller().gains().clone();
    let tension: Vec<[f64; 2]> = gains.muscles.iter().map(|muscle| muscle.tension).collect();
    let domain = domain("lm_arm", &setup.machine, &limits.range, &tension).unwrap();
    let (address, sessions) = ("127.0.0.1:0".parse().unwrap(), SessionSettings::default());
    let (server, port) = Server::start(ServerSettings { address, key: None, domain, sessions }).unwrap();
    let pose = setup.machine.start.clone();
    let motion = LinkedMotion::new(port, sessions, &setup.machine, limits, &pose, None).unwrap();
    let mut cycle = Cycle::new(setup.twin_bus(), setup.supervisor(), motion, STEP);
    let (mut clock, stop) = (VirtualClock::default(), AtomicBool::new(false));
    let point = sinew::trajectory::online::EndPointStep::new(
        &setup.machine.robot,
        &setup.machine.redundancy,
        setup.machine.task.site().unwrap(),
        [true; 3],
        &setup.machine.ranges().unwrap(),
    );
    let at = point.unwrap().position(&pose).unwrap();
    std::thread::scope(|scope| {
        scope.spawn(|| {
            let most = std::time::Duration::from_secs(20);
            let mut client = Client::connect(server.address(), None, most).unwrap();
            let mut count = 0_u64;
            while !stop.load(Ordering::Relaxed) {
                count += 1;
                let (kind, numbers) = match count / 200 % 2 {
                    0 => (SetpointKind::Joint, &pose[..]),
                    _ => (SetpointKind::EndPoint, &at[..]),
                };
                let mut setpoints = Setpoints::new(kind, numbers.len());
                assert!(setpoints.push(0, numbers));
                client.send(&Command { request: LinkRequest::Run, advance_to_ns: 0, setpoints }).unwrap();
                let _ = client.receive(std::time::Duration::from_millis(2));
            }
        });
        let (mut kinds, mut cycles) = ([false; 2], 0);
        let counted = measure(|| {
            while kinds != [true; 2] && cycles < 60_000 {
                let record = cycle.step(&mut clock, 0).unwrap();
                let running = record.command.mode == Mode::Run;
                let link = cycle.motion().link().unwrap();
                kinds[0] |= running && link.setpoint() == SetpointKind::Joint;
                kinds[1] |= running && link.setpoint() == SetpointKind::EndPoint;
                cycles += 1;
                std::thread::sleep(std::time::Duration::from_micros(50));
            }
        });
        assert_eq!(counted.count_total, 0);
        stop.store(true, Ordering::Relaxed);
        assert_eq!(kinds, [true; 2], "both kinds were followed within {cycles} cycles");
    });
}
