//! A run of a real machine: only what its sensors measure is known.

use super::bus;
use super::stopping::{By, Stopped, Stopping};
use crate::arguments::RunArguments;
use crate::error::Error;
use crate::progress::Progress;
use crate::table::{number, table, thousandths};
use crate::verbs::page::RunPage;
use crate::verbs::recording::{Ended, Recording, Request};
use crate::verbs::track::setup::Setup;
use serde::Serialize;
use sinew::control::arm::ArmStatus;
use sinew::control::supervisor::{Limits, Mode, Supervisor};
use sinew::machine::Machine;
use sinew::trajectory::Schedule;
use sinew_lab::arm::{INITIAL_REST_S, IdentifiedMachine, TrackHealth, TrackMode, stop_reason};
use sinew_lab::experiment::arm::STEP;
use sinew_lab::experiment::{ModeChange, Statistics};
use sinew_runtime::cycle::{Cycle, MonotonicClock, RealTime, Timing, run};
use sinew_runtime::ethercat::{EthercatBus, EthercatError, FrameStorage, Master, RawSocketLink};
use sinew_runtime::link::RunMotion;
use sinew_session::{BusStatistics, ClockReport, CycleRecord, Plant};
use std::sync::atomic::Ordering;

/// Result of a run on a real bus.
pub(super) struct Measured {
    pub(super) numbers: MeasuredNumbers,
    pub(super) timing: Timing,
    pub(super) real_time: RealTime,
    pub(super) statistics: BusStatistics,
    pub(super) clocks: Option<ClockReport>,
    pub(super) recording: Option<Ended>,
}

/// Errors by the joint encoders, and how the run ended.
#[derive(Debug, Clone, Serialize)]
pub(super) struct MeasuredNumbers {
    pub(super) ended: &'static str,
    pub(super) reason: Option<String>,
    /// During motion, by the joint encoders: `[joints]`.
    pub(super) joint_error: Vec<MeanMax>,
    pub(super) degraded_cycles: u64,
    /// Modes of the supervisor in their order.
    pub(super) modes: Vec<TrackMode>,
    /// Slow changes of the cables that were found.
    pub(super) health: Vec<TrackHealth>,
}

/// Magnitude of an error, rad or m.
#[derive(Debug, Clone, Copy, Serialize)]
pub(super) struct MeanMax {
    pub(super) mean: f64,
    pub(super) max: f64,
}

/// Table of the joints, and how the run ended.
pub(super) fn text(measured: &Measured, machine: &Machine) -> String {
    let numbers = &measured.numbers;
    let joints = &machine.robot.parts().joints;
    let independent = machine.robot.independent_joints();
    let rows: Vec<Vec<String>> = independent
        .iter()
        .zip(&numbers.joint_error)
        .map(|(joint, error)| {
            let errors = [error.mean, error.max].map(|error| number(Some(1e3 * error)));
            [joints[*joint].name.clone()].into_iter().chain(errors).collect()
        })
        .collect();
    let unit = thousandths(independent.iter().map(|joint| joints[*joint].kind.unit()));
    let mean = format!("error, {unit}: mean");
    let mut text = table(&["joint, by its encoder", &mean, "max"], &rows, 1);
    let ended = match (numbers.ended, &numbers.reason) {
        (_, Some(reason)) => format!("stopped: {reason}"),
        ("interrupted", None) => "interrupted; the machine was stopped".to_owned(),
        _ => "as planned".to_owned(),
    };
    text += &format!("Ended {ended}\n");
    text + &bus::text(&measured.statistics, machine) + &bus::clocks_text(measured.clocks)
}

/// Control cycle, ns.
const PERIOD: u64 = 1_000_000;

/// Runs the task of a setup on the devices of an interface.
pub(super) fn execute(
    setup: &Setup,
    (arguments, mut page): (&RunArguments, Option<RunPage>),
    interface: &str,
    progress: &Progress,
) -> Result<Measured, Error> {
    let task = setup.task(1.0);
    let identified = IdentifiedMachine::designed(&setup.machine, &setup.trajectory, task.gains)?;
    let mut controller = identified.plain_controller()?;
    if task.learning && task.repeats > 1 {
        controller = controller.with_iterative_learning(setup.trajectory.duration())?;
    }
    let schedule = Schedule::new(&setup.trajectory, task.repeats, INITIAL_REST_S, task.final_rest)?;
    let storage = FrameStorage::new();
    progress.show("bringing the devices into operation", 0.0);
    let master = Master::new(&storage, RawSocketLink::open(interface)?)?;
    // Before any drive moves, and before the thread has its priority.
    let (gains, models) = (&identified.gains, &identified.models);
    let mut recording =
        Recording::start(&Request { arguments, setup, gains, models, calibrated: false, link: None })?;
    // From here on drives have power: whoever ends the run stops them.
    let mut stopping = Stopping::begin();
    let bus = master
        .match_devices(&setup.machine.devices)
        .map_err(EthercatError::from)?
        .operate(&setup.machine, PERIOD)?;
    let limits = Limits::of(&setup.machine, controller.gains())?;
    let tape = recording.as_mut().and_then(Recording::take_tape);
    let motion = RunMotion::from(schedule).with_tape(tape);
    let supervisor = Supervisor::new(controller, limits)?;
    let mut cycle = stopping.of(Cycle::new(bus, supervisor, motion, STEP), page.as_ref());
    let real_time = RealTime::request();
    let mut timing = Timing::new();
    let mut errors = vec![Statistics::default(); schedule.joints()];
    let (mut stopped, mut degraded, mut modes) = (None, 0, Vec::with_capacity(64));
    let end = stopping.at_once();
    let see = |record: &CycleRecord<'_, EthercatBus<'_, RawSocketLink>>| {
        let command = &record.command;
        if modes.last().is_none_or(|last: &ModeChange| last.mode != command.mode) {
            modes.push(ModeChange { time: record.moment.time, mode: command.mode, fault: command.fault });
        }
        match command.arm.status {
            ArmStatus::Stopped(fault) => {
                stopped.get_or_insert((record.moment.time, fault));
                // The machine has been let down.
                if command.mode == Mode::Fault {
                    end.store(true, Ordering::Relaxed);
                }
            }
            ArmStatus::Degraded(_) => degraded += 1,
            ArmStatus::Following | ArmStatus::Holding => {}
        }
        if let Some(recording) = &mut recording {
            recording.record(record);
        }
        if let Some(page) = &mut page {
            page.show(record);
        }
        stopping.see(record);
        if record.moment.repeat.is_some() && !stopping.is_stopping() {
            let measured = record.feedback.joint.iter().zip(&record.reference.q);
            for (statistics, (measured, reference)) in errors.iter_mut().zip(measured) {
                if measured.is_finite() {
                    statistics.record((measured - reference).abs());
                }
            }
        }
        Ok(())
    };
    run(&mut cycle, &mut MonotonicClock, PERIOD, end, &mut timing, see)?;
    let statistics = cycle.statistics();
    let health = TrackHealth::of(cycle.supervisor().health(), &setup.machine.robot);
    let threshold = stopped.and_then(|(_, fault)| cycle.supervisor().threshold(fault));
    let clocks = cycle.plant().clocks();
    drop(cycle);
    let recording = recording.map(Recording::end);
    let from_elsewhere = stopping.stopped(page.as_ref());
    let (ended, reason) = match stopped {
        Some((time, fault)) => {
            let reason = stop_reason(fault, threshold, &setup.machine.robot);
            ("stopped", Some(format!("{reason} at {time:.3} s")))
        }
        None => match from_elsewhere {
            Some(Stopped { by: By::Page, time }) => {
                ("stopped", Some(format!("from the page at {time:.3} s")))
            }
            Some(Stopped { by: By::Terminal, .. }) => ("interrupted", None),
            None => ("as_planned", None),
        },
    };
    let joint_error =
        errors.iter().map(|statistics| MeanMax { mean: statistics.mean, max: statistics.max }).collect();
    let modes = modes.iter().map(TrackMode::new).collect();
    let numbers = MeasuredNumbers { ended, reason, joint_error, degraded_cycles: degraded, modes, health };
    Ok(Measured { numbers, timing, real_time, statistics, clocks, recording })
}
