//! A run on a simulated bus: the plant's truth is known, so the errors are those of `sinew track`.

use super::stopping::{Stopped, Stopping};
use crate::arguments::{BusArgument, RunArguments};
use crate::error::Error;
use crate::progress::Progress;
use crate::verbs::page::RunPage;
use crate::verbs::recording::{Ended, Recording, Request};
use crate::verbs::track::setup::Setup;
use sinew_lab::arm::{CalibratedArm, PreparedRun, TrackingNumbers};
use sinew_lab::experiment::Evaluation;
use sinew_lab::experiment::arm::STEP;
use sinew_runtime::cycle::{Cycle, MonotonicClock, RealTime, Timing, run};
use sinew_runtime::ethercat::{EthercatError, FrameStorage, Master, SegmentLink, SimulatedMachine};
use sinew_runtime::link::RunMotion;
use sinew_segment::DescriptionFile;
use sinew_session::{BusStatistics, Clock, ClockReport, CycleRecord, Plant, TwinPlant, VirtualClock};

/// Result of a run.
pub(super) struct Executed {
    pub(super) numbers: TrackingNumbers,
    pub(super) timing: Timing,
    pub(super) real_time: RealTime,
    pub(super) statistics: BusStatistics,
    pub(super) clocks: Option<ClockReport>,
    pub(super) recording: Option<Ended>,
    /// A stop from the page or the terminal; the errors are those until then.
    pub(super) stopped: Option<Stopped>,
}

/// Control cycle, ns.
const PERIOD: u64 = 1_000_000;
/// Cycles between two updates of the progress.
const PROGRESS_CYCLES: u64 = 500;

/// Runs the task of a setup on a simulated bus, at its deadlines or on virtual time; the files describe simulated devices.
pub(super) fn execute(
    setup: &Setup,
    arm: &CalibratedArm,
    (arguments, descriptions, page): (&RunArguments, &[DescriptionFile], Option<RunPage>),
    progress: &Progress,
) -> Result<Executed, Error> {
    let prepared = PreparedRun::new(arm, setup.variant, &setup.task(1.0))?;
    let (gains, models) = (&prepared.gains, &arm.models);
    let recording =
        Recording::start(&Request { arguments, setup, gains, models, calibrated: true, link: None })?;
    let how =
        How { virtual_time: arguments.virtual_time, recording, page, progress, stopping: Stopping::begin() };
    let plant = prepared.run().plant()?;
    let storage = FrameStorage::new();
    match arguments.bus {
        BusArgument::Twin => paced(TwinPlant::new(plant, STEP), &prepared, arm, how),
        // The latter has an interface and is not simulated.
        BusArgument::Segment | BusArgument::Ethercat => {
            let simulated = SimulatedMachine::new(plant, &setup.machine);
            let segment = simulated.segment(descriptions)?;
            let master = Master::new(&storage, SegmentLink::new(segment, simulated))?;
            let matched = master.match_devices(&setup.machine.devices).map_err(EthercatError::from)?;
            let bus = matched.operate(&setup.machine, PERIOD)?;
            paced(bus, &prepared, arm, how)
        }
    }
}

/// What accompanies the cycle.
struct How<'a> {
    virtual_time: bool,
    recording: Option<Recording>,
    page: Option<RunPage>,
    progress: &'a Progress,
    stopping: Stopping,
}

fn paced<B: Plant>(
    bus: B,
    prepared: &PreparedRun<'_>,
    arm: &CalibratedArm,
    how: How<'_>,
) -> Result<Executed, Error> {
    if how.virtual_time {
        return execute_on(bus, prepared, arm, &mut VirtualClock::default(), RealTime::default(), how);
    }
    let real_time = RealTime::request();
    execute_on(bus, prepared, arm, &mut MonotonicClock, real_time, how)
}

fn execute_on<B: Plant>(
    bus: B,
    prepared: &PreparedRun<'_>,
    arm: &CalibratedArm,
    clock: &mut impl Clock,
    real_time: RealTime,
    how: How<'_>,
) -> Result<Executed, Error> {
    let How { mut recording, mut page, progress, mut stopping, .. } = how;
    let conditions = prepared.run();
    let schedule = conditions.schedule()?;
    let mut evaluation = Evaluation::new(&conditions)?;
    let tape = recording.as_mut().and_then(Recording::take_tape);
    let motion = RunMotion::from(schedule).with_tape(tape);
    let mut cycle = stopping.of(Cycle::new(bus, prepared.supervisor()?, motion, STEP), page.as_ref());
    let (mut timing, mut count) = (Timing::new(), 0_u64);
    let end = stopping.at_once();
    let see = |record: &CycleRecord<'_, B>| {
        if record.plant.has_failed() {
            evaluation.plant_failed(record.moment.time);
        }
        if let Some(page) = &mut page {
            page.show(record);
        }
        stopping.see(record);
        if let Some(arm) = record.plant.simulated().filter(|_| !stopping.is_stopping()) {
            evaluation.record(&record.moment, record.reference, &record.command, arm)?;
        }
        if let Some(recording) = &mut recording {
            recording.record(record);
        }
        if count.is_multiple_of(PROGRESS_CYCLES) {
            progress.show("running", record.moment.time / schedule.duration());
        }
        count += 1;
        Ok(())
    };
    run(&mut cycle, clock, PERIOD, end, &mut timing, see)?;
    let recording = recording.map(Recording::end);
    let statistics = cycle.statistics();
    let clocks = cycle.plant().clocks();
    let summary = evaluation.finish(cycle.supervisor());
    let limits = (conditions.tension_limits, arm.joint_error_limits());
    let numbers = TrackingNumbers::new(&summary, &arm.machine, limits.0, &limits.1);
    let numbers = numbers.map_err(sinew_lab::Error::from)?;
    let stopped = stopping.stopped(page.as_ref());
    Ok(Executed { numbers, timing, real_time, statistics, clocks, recording, stopped })
}
