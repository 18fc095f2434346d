//! `sinew run`.

mod bus;
mod linked;
mod measured;
mod seen;
mod shortcomings;
mod simulated;
mod stopping;
mod timing;

use super::device_files;
use super::page::{RunPage, Shown};
use super::track::{setup::Setup, summary_text};
use crate::answer::{Answer, Content, Outcome};
use crate::arguments::{BusArgument, General, MotionArguments, PathArgument, RunArguments};
use crate::error::Error;
use crate::output::refuse_overwrite;
use crate::progress::Progress;
pub(crate) use linked::Follower;
use measured::Measured;
use shortcomings::warn;
use simulated::{Executed, execute};
use sinew_lab::CompensationVariant;
use sinew_lab::arm::TrackOutcome;
use std::collections::BTreeMap;
use stopping::Stopped;

pub(crate) fn run(arguments: &RunArguments, general: &General) -> Result<Answer, Error> {
    let interface = arguments.interface.as_deref().filter(|_| arguments.bus == BusArgument::Ethercat);
    if interface.is_some() {
        refuse_simulated(&arguments.motion)?;
    }
    if let Some(file) = arguments.devices.files.first().filter(|_| arguments.bus != BusArgument::Segment) {
        let value = file.display().to_string();
        return Err(Error::Argument { flag: "--device", value, expected: "it with --bus segment" });
    }
    check_outputs(arguments, general.no_clobber)?;
    if let Some(address) = arguments.link.link {
        return linked::execute(arguments, address, general);
    }
    let progress = Progress::new();
    progress.show("planning and verifying the motion", 0.0);
    let setup = Setup::new(&arguments.motion);
    drop(progress);
    let setup = setup?;
    let (simulated, timed) = (interface.is_none(), !arguments.virtual_time);
    let shown = Shown { bus: arguments.bus.name(), simulated, linked: false, timed };
    let page = RunPage::start(&arguments.page, &setup, &shown)?;
    let progress = Progress::new();
    if let Some(interface) = interface {
        let measured = measured::execute(&setup, (arguments, page), interface, &progress)?;
        drop(progress);
        return report_measured(&setup, measured, general.json);
    }
    let descriptions = device_files::read(&arguments.devices, &setup.machine.devices)?;
    progress.show("calibrating the machine's cables", 0.0);
    let arm = setup.calibrate()?;
    let executed = execute(&setup, &arm, (arguments, &descriptions, page), &progress)?;
    drop(progress);
    let whole = executed.recording.as_ref().is_none_or(|recording| recording.whole);
    let completed = executed.numbers.ended == TrackOutcome::Completed && executed.stopped.is_none();
    let outcome = Outcome::of(completed && whole);
    let content = content(arguments, &setup, &executed, general.json)?;
    let written = executed.recording.into_iter().map(|recording| recording.written).collect();
    Ok(Answer { outcome, content, written })
}

/// The recording replaces no file that is read.
fn check_outputs(arguments: &RunArguments, no_clobber: bool) -> Result<(), Error> {
    if let Some(file) = arguments.record.as_ref().filter(|file| file.extension().is_some_and(|e| e == "csv"))
    {
        let expected = "a recording that ends in .mcap; `sinew log export` writes it as a table";
        return Err(Error::Argument { flag: "--record", value: file.display().to_string(), expected });
    }
    let outputs: Vec<_> = arguments.record.iter().cloned().collect();
    let motion = &arguments.motion;
    let waypoints = motion.path.as_ref().and_then(PathArgument::file);
    let inputs =
        [&motion.model].into_iter().chain(waypoints).chain(&motion.gains).chain(&arguments.devices.files);
    refuse_overwrite(inputs, &outputs, no_clobber)
}

/// What only a simulated machine can do.
fn refuse_simulated(motion: &MotionArguments) -> Result<(), Error> {
    let refuse = |flag, value: String| {
        let expected = "it with a simulated bus only";
        Err(Error::Argument { flag, value, expected })
    };
    if let Some(fault) = motion.fault.first() {
        return refuse("--fault", fault.text.clone());
    }
    if motion.compensation != CompensationVariant::Observer {
        return refuse("--compensation", motion.compensation.to_string());
    }
    Ok(())
}

fn content(
    arguments: &RunArguments,
    setup: &Setup,
    executed: &Executed,
    json: bool,
) -> Result<Content, Error> {
    let tracking = BTreeMap::from([(setup.variant, executed.numbers.clone())]);
    let timed = !arguments.virtual_time;
    if json {
        let mut all = serde_json::json!({
            "simulated": true, "seed": setup.seed, "tracking": tracking,
            "bus": bus::json(&executed.statistics, executed.clocks),
        });
        if timed {
            all["timing_us"] = timing::json(&executed.timing);
        }
        if let Some(recording) = &executed.recording {
            all["recording"] = recording.json.clone();
        }
        if let Some(stopped) = executed.stopped {
            all[stopped.key()] = stopped.time.into();
        }
        return Content::json(&all);
    }
    let mut text = summary_text(&tracking) + &bus::text(&executed.statistics, &setup.machine);
    text += &bus::clocks_text(executed.clocks);
    if timed {
        text += &timing::text(&executed.timing);
    }
    text += executed.recording.as_ref().map_or("", |recording| &recording.text);
    text += &executed.stopped.map_or(String::new(), Stopped::text);
    warn(&executed.real_time);
    Ok(Content::Text(text))
}

fn report_measured(setup: &Setup, measured: Measured, json: bool) -> Result<Answer, Error> {
    let (numbers, recording) = (&measured.numbers, measured.recording.as_ref());
    let content = if json {
        let mut all = serde_json::json!({
            "simulated": false, "run": numbers, "bus": bus::json(&measured.statistics, measured.clocks),
            "timing_us": timing::json(&measured.timing),
        });
        if let Some(recording) = recording {
            all["recording"] = recording.json.clone();
        }
        Content::json(&all)?
    } else {
        warn(&measured.real_time);
        let text = measured::text(&measured, &setup.machine) + &timing::text(&measured.timing);
        Content::Text(text + recording.map_or("", |recording| &recording.text))
    };
    let whole = recording.is_none_or(|recording| recording.whole);
    let outcome = Outcome::of(numbers.ended == "as_planned" && whole);
    let written = measured.recording.into_iter().map(|recording| recording.written).collect();
    Ok(Answer { outcome, content, written })
}
