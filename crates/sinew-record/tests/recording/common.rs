//! A machine of this repository under control, and recordings of it.

use sinew::control::arm::{ActuationMode, ArmController, CableStateSource, resting_tensions, synthesize};
use sinew::control::supervisor::{Limits, Supervisor};
use sinew::description::machine_from_toml;
use sinew::machine::Machine;
use sinew::predictor::CableModel;
use sinew::trajectory::{MinimumJerk, Schedule, Trajectory};
use sinew::twin::arm::{ArmSpecimen, ArmTwin};
use sinew_record::{Circumstances, File, Head, Recorded, Recorder, Storage};
use sinew_runtime::cycle::{Cycle, CycleRecord, Timing, VirtualClock, run};
use sinew_session::{Scheduled, TwinPlant};
use std::io::{self, Write};
use std::sync::atomic::AtomicBool;
use std::sync::{Arc, Mutex};

pub(crate) const PERIOD: u64 = 1_000_000;

/// A machine with a motion of all of its joints.
pub(crate) struct Setup {
    pub(crate) machine: Machine,
    pub(crate) trajectory: Trajectory,
    pub(crate) controller: ArmController,
    plant: ArmTwin,
}

/// Signals of one cycle as the cycle itself had them, for comparison.
#[derive(Debug, Clone, PartialEq)]
pub(crate) struct Seen {
    pub(crate) position: Vec<u64>,
    pub(crate) tension: Vec<u64>,
    pub(crate) joint: Vec<u64>,
}

impl Setup {
    pub(crate) fn new(name: &str, seed: u64) -> Self {
        let file = format!("{}/../../models/{name}.toml", env!("CARGO_MANIFEST_DIR"));
        let text = std::fs::read_to_string(&file).unwrap();
        let machine = machine_from_toml(name, &text, &mut |_| Err("no other file".into())).unwrap().machine;
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
        let towards = |(start, [low, high]): (&f64, &[f64; 2])| {
            let end = if high - start > start - low { high } else { low };
            start + 0.2 * (end - start)
        };
        let end: Vec<f64> = machine.start.iter().zip(&ranges).map(towards).collect();
        let motion = MinimumJerk::new(&machine.start, &end, 1.5).unwrap();
        let (gains, _) = synthesize(&machine, &models, &[machine.start.clone(), end]).unwrap();
        let limits = gains.tension_limits();
        let mode = ActuationMode::WinchSpeed(CableStateSource::Observer);
        let controller = ArmController::new(&machine.robot, &models, gains, mode).unwrap();
        let tensions = resting_tensions(&specimen.robot, &machine.start, &limits).unwrap();
        let plant = ArmTwin::new(&specimen, &machine.start, &tensions, seed).unwrap();
        Self { machine, trajectory: Trajectory::PointToPoint(motion), controller, plant }
    }

    pub(crate) fn schedule(&self) -> Scheduled<'_> {
        let schedule = Schedule::new(&self.trajectory, 1, 0.2, 0.8).unwrap();
        Scheduled::new(schedule, &self.machine.robot, &self.machine.start).unwrap()
    }

    pub(crate) fn supervisor(&self) -> Supervisor {
        let limits = Limits::from_machine(&self.machine, self.controller.gains()).unwrap();
        Supervisor::new(self.controller.clone(), limits).unwrap()
    }

    pub(crate) fn cycle(&self) -> Cycle<'_, TwinPlant> {
        let bus = TwinPlant::new(self.plant.clone());
        Cycle::new(bus, self.supervisor(), self.schedule(), self.machine.period)
    }

    pub(crate) fn head(&self) -> Head {
        let of = Circumstances {
            program: "0.0.0".to_owned(),
            commit: "test".to_owned(),
            simulated: true,
            virtual_time: true,
            start_ns: 0,
            period_ns: self.machine.period_ns(),
        };
        Head::new(&self.machine, of)
    }

    pub(crate) fn recorder(&self, storage: impl Storage + 'static) -> Recorder {
        let files = [File { name: "note.txt".to_owned(), bytes: b"beside the cycles".to_vec() }];
        Recorder::start(Box::new(storage), self.head(), &self.machine, &files, |_| {}).unwrap()
    }

    /// Records a run on virtual time.
    pub(crate) fn record(
        &self,
        storage: impl Storage + 'static,
    ) -> (Result<Recorded, sinew_record::Error>, Vec<Seen>) {
        let (mut recorder, mut seen) = (self.recorder(storage), Vec::new());
        let bits = |values: &[f64]| values.iter().map(|x| x.to_bits()).collect();
        let see = |record: &CycleRecord<'_, TwinPlant>| {
            recorder.record_all(record);
            let feedback = record.feedback;
            let [position, tension, joint] =
                [&feedback.motor, &feedback.tension, &feedback.joint].map(|x| bits(x));
            seen.push(Seen { position, tension, joint });
            Ok(())
        };
        let (stop, mut timing) = (AtomicBool::new(false), Timing::new());
        run(&mut self.cycle(), &mut VirtualClock::default(), PERIOD, &stop, &mut timing, see).unwrap();
        (recorder.finish(), seen)
    }

    /// The bytes of a recording.
    pub(crate) fn recorded(&self) -> (Vec<u8>, Vec<Seen>) {
        let memory = Memory::default();
        let (recorded, seen) = self.record(memory.clone());
        recorded.unwrap();
        (memory.bytes(), seen)
    }
}

/// A storage in memory, with a limit.
#[derive(Debug, Clone)]
pub(crate) struct Memory {
    bytes: Arc<Mutex<Vec<u8>>>,
    limit: usize,
}

impl Default for Memory {
    fn default() -> Self {
        Self::with_limit(usize::MAX)
    }
}

impl Memory {
    pub(crate) fn with_limit(limit: usize) -> Self {
        Self { bytes: Arc::default(), limit }
    }

    pub(crate) fn bytes(&self) -> Vec<u8> {
        self.bytes.lock().unwrap().clone()
    }
}

impl Write for Memory {
    fn write(&mut self, bytes: &[u8]) -> io::Result<usize> {
        let mut all = self.bytes.lock().unwrap();
        let room = self.limit - all.len();
        if room == 0 {
            return Err(io::ErrorKind::StorageFull.into());
        }
        let taken = room.min(bytes.len());
        all.extend_from_slice(&bytes[..taken]);
        Ok(taken)
    }

    fn flush(&mut self) -> io::Result<()> {
        Ok(())
    }
}

impl Storage for Memory {
    fn truncate(&mut self, length: u64) -> io::Result<()> {
        self.bytes.lock().unwrap().truncate(usize::try_from(length).unwrap());
        Ok(())
    }
}
