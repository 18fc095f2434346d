//! A machine as built, behind simulated devices for other masters.

use crate::error::Error;
use crate::output::{Written, write_streamed};
use sinew::control::arm::{resting_tensions, synthesize};
use sinew::machine::Machine;
use sinew::twin::arm::{ArmSpecimen, ArmTwin};
use sinew_lab::experiment::oracle_models;
use sinew_lab::signals::Signal;
use std::fs::File;
use std::io::{BufWriter, Write as _};
use std::path::Path;
use std::sync::atomic::{AtomicBool, Ordering};
use std::sync::mpsc::{self, Receiver, Sender};
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

/// Serves another master with a machine and writes what is true of it meanwhile into a file, where one is
/// given: CSV, a row every 10 ms, columns as in a recording (`docs/recording.md`). A thread of its own
/// writes, so that no master waits for a disk.
pub(super) fn serve_with_truth<R>(
    path: Option<&Path>,
    machine: &Machine,
    serve: impl FnOnce(&mut dyn FnMut(&ArmTwin)) -> Result<R, Error>,
) -> Result<(R, Vec<Written>), Error> {
    let Some(path) = path else { return Ok((serve(&mut |_| {})?, Vec::new())) };
    let (served, written) = write_streamed(path, |file| {
        let (sender, rows) = mpsc::channel();
        std::thread::scope(|scope| {
            let writer = scope.spawn(move || write_truth(file, machine, &rows));
            let mut truth = Truth { rows: sender, next: 0.0 };
            let served = serve(&mut |arm| truth.take(arm));
            drop(truth);
            let wrote = writer.join().unwrap_or_else(|panic| std::panic::resume_unwind(panic));
            served.and_then(|served| wrote.map(|()| served))
        })
    })?;
    Ok((served, vec![written]))
}

/// Time between two rows of the truth, s.
const TRUTH_INTERVAL: f64 = 0.01;
/// Its signals of every muscle.
const TRUE_OF_MUSCLES: [Signal; 3] = [Signal::PositionIn, Signal::TensionInTrue, Signal::TensionOut];

/// What is true of a simulated machine, a row at a time.
struct Truth {
    rows: Sender<Vec<String>>,
    /// Time of the next row, s.
    next: f64,
}

impl Truth {
    /// A row, where it is time for one.
    fn take(&mut self, arm: &ArmTwin) {
        let truth = arm.truth();
        if truth.time < self.next {
            return;
        }
        // Times are sums of steps, and rounded.
        self.next = truth.time + TRUTH_INTERVAL - 1e-6;
        let cables = || truth.cables.iter();
        let [joint, motor, tension_in, tension_out] =
            [Signal::JointTrue, Signal::PositionIn, Signal::TensionInTrue, Signal::TensionOut]
                .map(|signal| signal.row().digits().unwrap_or(7));
        let mut row = vec![format!("{:.3}", truth.time)];
        row.extend(truth.q.iter().map(|q| format!("{q:.joint$}")));
        row.extend(arm.reading().motor.iter().map(|x| format!("{x:.motor$}")));
        row.extend(cables().map(|cable| format!("{:.tension_in$}", cable.tension_in)));
        row.extend(cables().map(|cable| format!("{:.tension_out$}", cable.tension_out)));
        // Where the file failed there is nobody to take it, and its error is told at the end.
        let _ = self.rows.send(row);
    }
}

/// Writes the table until nobody sends rows any more.
fn write_truth(file: &mut File, machine: &Machine, rows: &Receiver<Vec<String>>) -> Result<(), Error> {
    let mut file = BufWriter::new(file);
    writeln!(file, "# SIMULATED").map_err(csv::Error::from)?;
    let parts = machine.robot.parts();
    let joints = machine.robot.independent_joints().into_iter().map(|joint| &parts.joints[joint]);
    let mut header = vec!["time_s".to_owned()];
    header.extend(joints.map(|joint| Signal::JointTrue.column(&joint.name, joint.kind.unit())));
    for signal in TRUE_OF_MUSCLES {
        header.extend(parts.tendons.iter().map(|tendon| signal.column(&tendon.name, "")));
    }
    let mut table = csv::Writer::from_writer(file);
    table.write_record(header)?;
    rows.iter().try_for_each(|row| table.write_record(row))?;
    Ok(table.flush().map_err(csv::Error::from)?)
}
