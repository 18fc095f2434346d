//! Machines of this repository under control, with the parameters of their design.

use sinew::control::arm::{
    ActuationMode, ArmController, ArmStatus, CableStateSource, resting_tensions, synthesize,
};
use sinew::control::supervisor::{Limits, Mode, Supervisor};
use sinew::description::machine_from_toml;
use sinew::machine::{Device, DeviceRole, DriveMode, Machine};
use sinew::predictor::CableModel;
use sinew::trajectory::{MinimumJerk, Reference, Schedule, Trajectory};
use sinew::twin::arm::{ArmSpecimen, ArmTwin, InjectedFault};
use sinew_runtime::cycle::{Cycle, CycleRecord, Timing, VirtualClock, run};
use sinew_runtime::ethercat::{
    EthercatBus, EthercatDevice, FrameStorage, Master, SegmentLink, SimulatedMachine,
};
use sinew_session::{Plant, Scheduled, TwinPlant};
use std::sync::atomic::AtomicBool;

pub(crate) const PERIOD: u64 = 1_000_000;
pub(crate) const STEP: f64 = 1e-3;

/// A machine with a motion of all of its joints, and its plant.
pub(crate) struct Setup {
    pub(crate) machine: Machine,
    pub(crate) devices: Vec<EthercatDevice>,
    pub(crate) trajectory: Trajectory,
    pub(crate) controller: ArmController,
    pub(crate) plant: ArmTwin,
    /// Rest before and after the motion, s.
    pub(crate) before: f64,
    pub(crate) after: f64,
}

pub(crate) fn machine(name: &str) -> Machine {
    let file = format!("{}/../../models/{name}.toml", env!("CARGO_MANIFEST_DIR"));
    let text = std::fs::read_to_string(&file).unwrap();
    machine_from_toml(name, &text, &mut |_| Err("no other file".into())).unwrap().machine
}

/// Torque commands instead of speeds.
pub(crate) fn with_mode(mut machine: Machine, mode: DriveMode) -> Machine {
    for device in &mut machine.devices {
        if let DeviceRole::Drive(drive) = &mut device.role {
            drive.mode = mode;
        }
    }
    machine
}

impl Setup {
    pub(crate) fn new(machine: Machine, seed: u64, faults: &[InjectedFault]) -> Self {
        let design = ArmSpecimen::nominal(&machine).unwrap();
        let specimen = ArmSpecimen::sampled_around(&design, &machine, seed).unwrap();
        let models: Vec<CableModel> = specimen
            .cables
            .iter()
            .map(|cable| CableModel {
                path: cable.path.clone(),
                parameters: cable.parameters,
                start: 1.0,
                ..CableModel::bench()
            })
            .collect();
        let ranges = machine.ranges().unwrap();
        let end: Vec<f64> = machine
            .start
            .iter()
            .zip(&ranges)
            .map(|(start, [low, high])| {
                let towards = if high - start > start - low { *high } else { *low };
                start + 0.3 * (towards - start)
            })
            .collect();
        let trajectory = Trajectory::PointToPoint(MinimumJerk::new(&machine.start, &end, 2.0).unwrap());
        let (gains, _) = synthesize(&machine, &models, &[machine.start.clone(), end]).unwrap();
        let limits = gains.tension_limits();
        let mode = ActuationMode::WinchSpeed(CableStateSource::Observer);
        let controller = ArmController::new(&machine.robot, &models, gains, mode).unwrap();
        let tensions = resting_tensions(&specimen.robot, &machine.start, &limits).unwrap();
        let plant =
            ArmTwin::new(&specimen, &machine.start, &tensions, seed).unwrap().with_faults(faults).unwrap();
        let devices = EthercatDevice::simulated(&machine);
        Self { machine, devices, trajectory, controller, plant, before: 0.3, after: 0.7 }
    }

    /// The same along the motion backward, which ends where the machine stands.
    pub(crate) fn into_backward(mut self) -> Self {
        let mut end = Reference::new(self.trajectory.joints());
        self.trajectory.sample(self.trajectory.duration(), &mut end).unwrap();
        let backward = MinimumJerk::new(&end.q, &self.machine.start, 2.0).unwrap();
        self.trajectory = Trajectory::PointToPoint(backward);
        self
    }

    pub(crate) fn supervisor(&self) -> Supervisor {
        let limits = Limits::from_machine(&self.machine, self.controller.gains()).unwrap();
        Supervisor::new(self.controller.clone(), limits).unwrap()
    }

    pub(crate) fn schedule(&self) -> Scheduled<'_> {
        let schedule = Schedule::new(&self.trajectory, 1, self.before, self.after).unwrap();
        let standing = self.machine.standing(&self.trajectory).unwrap();
        Scheduled::new(schedule, &self.machine.robot, &standing).unwrap()
    }

    pub(crate) fn twin_bus(&self) -> TwinPlant {
        TwinPlant::new(self.plant.clone())
    }

    pub(crate) fn link(&self) -> SegmentLink {
        let simulated = SimulatedMachine::new(self.plant.clone(), &self.machine, self.devices.clone());
        let segment = simulated.segment(&[]).unwrap();
        SegmentLink::new(segment, simulated)
    }

    pub(crate) fn segment_bus<'a>(&self, storage: &'a FrameStorage) -> EthercatBus<'a, SegmentLink> {
        let matched = Master::new(storage, self.link()).unwrap().match_devices(&self.devices).unwrap();
        matched.operate(&self.machine).unwrap()
    }

    /// Runs the motion and gives every cycle to `see`; returns the bus.
    pub(crate) fn run<B: Plant>(&self, bus: B, mut see: impl FnMut(&CycleRecord<'_, B>)) -> Cycle<'_, B> {
        let mut cycle = Cycle::new(bus, self.supervisor(), self.schedule(), self.machine.period);
        let (stop, mut timing) = (AtomicBool::new(false), Timing::new());
        let see = |record: &CycleRecord<'_, B>| {
            see(record);
            Ok(())
        };
        run(&mut cycle, &mut VirtualClock::default(), self.machine.period_ns(), &stop, &mut timing, see)
            .unwrap();
        cycle
    }
}

/// Mean and largest magnitude of the true errors of the joints over a run, rad or m.
#[derive(Debug, Clone, Copy, Default)]
pub(crate) struct Errors {
    pub(crate) mean: f64,
    pub(crate) max: f64,
    count: f64,
}

impl Errors {
    /// Behind drives on a bus as on the twin. Where a stiff cable lets its winch only wind in, drives begin
    /// with tensions that differ by what their speed loops do when they break away.
    pub(crate) fn as_good_as(&self, twin: &Self, name: &str) -> bool {
        let [mean, max] = if name == "finger" { [2.2, 2.5] } else { [1.5, 1.6] };
        self.mean < mean * twin.mean && self.max < max * twin.max
    }

    pub(crate) fn record(&mut self, reference: &[f64], truth: &[f64]) {
        for (reference, truth) in reference.iter().zip(truth) {
            let error = (reference - truth).abs();
            self.count += 1.0;
            self.mean += (error - self.mean) / self.count;
            self.max = self.max.max(error);
        }
    }
}

/// A machine whose only sensors are those of its drives, on a bus that reads ahead, at 4 ms.
pub(crate) fn bare_machine(name: &str) -> Machine {
    let mut machine = Machine { period: 4e-3, reading_age: 4e-3, ..machine(name) };
    machine.muscles.iter_mut().for_each(|muscle| muscle.drive.has_load_cell = false);
    machine.encoders.fill(None);
    machine.devices = Device::defaults(&machine.robot, &machine.muscles, &machine.encoders);
    machine
}

/// Errors of the joints and a digest of all estimates of a run without a fault.
pub(crate) fn tracked<B: Plant>(setup: &Setup, bus: B) -> (Errors, u64) {
    let (mut errors, mut digest) = (Errors::default(), 0xcbf2_9ce4_8422_2325_u64);
    let cycle = setup.run(bus, |record| {
        let status = record.command.arm.status;
        assert!(
            matches!(status, ArmStatus::Following | ArmStatus::Holding),
            "{:?} {status:?} {:?}",
            record.moment,
            record.exchange
        );
        if record.command.mode == Mode::Run {
            errors.record(&record.reference.q, record.plant.simulated().unwrap().truth().q);
        }
        for estimate in record.command.arm.q.iter().chain(record.command.arm.estimated_tension) {
            digest = (digest ^ estimate.to_bits()).wrapping_mul(0x0000_0100_0000_01b3);
        }
    });
    assert_eq!(cycle.statistics().first, None, "no fault of the bus");
    (errors, digest)
}
