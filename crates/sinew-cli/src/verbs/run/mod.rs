//! `sinew run`.

mod simulated;
mod timing;

use super::track::{refuse, setup::Setup, summary_text};
use crate::arguments::RunArguments;
use crate::error::Error;
use crate::output::print;
use crate::progress::Progress;
use crate::verbs::Outcome;
use simulated::{Executed, execute};
use sinew_lab::arm::TrackOutcome;
use std::collections::BTreeMap;

pub(crate) fn run(arguments: &RunArguments) -> Result<Outcome, Error> {
    let progress = Progress::new();
    progress.show("planning and verifying the motion", 0.0);
    let setup = Setup::new(&arguments.motion);
    drop(progress);
    let setup = setup.or_else(|error| refuse(arguments.motion.seed, arguments.json, error))?;
    let progress = Progress::new();
    progress.show("calibrating the machine's cables", 0.0);
    let arm = setup.calibrate()?;
    let executed = execute(&setup, &arm, (arguments.bus, arguments.virtual_time), &progress)?;
    drop(progress);
    report(arguments, &setup, &executed)?;
    Ok(Outcome::of(executed.numbers.ended == TrackOutcome::Completed))
}

fn report(arguments: &RunArguments, setup: &Setup, executed: &Executed) -> Result<(), Error> {
    let tracking = BTreeMap::from([(setup.variant, executed.numbers.clone())]);
    let timed = !arguments.virtual_time;
    if arguments.json {
        let mut all = serde_json::json!({"simulated": true, "seed": setup.seed, "tracking": tracking});
        if timed {
            all["timing_us"] = timing::json(&executed.timing);
        }
        return print(&(serde_json::to_string_pretty(&all)? + "\n"));
    }
    let mut text = summary_text(&tracking);
    if timed {
        text += &timing::text(&executed.timing);
    }
    for shortcoming in &executed.real_time.shortcomings {
        eprintln!("warning: {shortcoming}");
    }
    print(&text)
}
