//! A machine as built, behind simulated devices for other masters.

use crate::error::Error;
use sinew::control::arm::{resting_tensions, synthesize};
use sinew::machine::Machine;
use sinew::twin::arm::{ArmSpecimen, ArmTwin};
use sinew_lab::experiment::oracle_models;
use std::sync::atomic::{AtomicBool, Ordering};
use std::time::Duration;

/// A machine of this seed in its start pose, with its cables at their resting tensions.
pub(super) fn simulated_arm(machine: &Machine, seed: u64) -> Result<ArmTwin, Error> {
    let design = ArmSpecimen::nominal(machine)?;
    let (gains, _) = synthesize(machine, &oracle_models(&design), std::slice::from_ref(&machine.start))?;
    let specimen = ArmSpecimen::sampled_around(&design, machine, seed)?;
    let tensions = resting_tensions(&specimen.robot, &machine.start, &gains.tension_limits())?;
    Ok(ArmTwin::new(&specimen, &machine.start, &tensions, seed)?)
}

/// Steps in which it moves on in real time, ns: what it shows is as old as one of them at most.
pub(super) fn step_ns(machine: &Machine) -> u64 {
    machine.period_ns().min(1_000_000)
}

/// Sets a flag after some seconds, where they are given.
pub(super) fn end_after(duration: Option<f64>, stop: &'static AtomicBool) {
    if let Some(seconds) = duration {
        std::thread::spawn(move || {
            std::thread::sleep(Duration::from_secs_f64(seconds));
            stop.store(true, Ordering::SeqCst);
        });
    }
}
