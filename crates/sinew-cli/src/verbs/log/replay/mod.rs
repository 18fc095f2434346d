//! `sinew log replay`.

mod compare;
mod controllers;
mod show;

use crate::answer::{Answer, Content, Outcome};
use crate::arguments::{General, ReplayArguments};
use crate::error::Error;
use crate::output::{refuse_overwrite, write_all};
use crate::progress::Progress;
use crate::verbs::recording::{RunSetup, read_bytes, recording};
use compare::compare;
use controllers::{Motion, other_controller, recorded_controller};

pub(super) fn run(arguments: &ReplayArguments, general: &General) -> Result<Answer, Error> {
    let outputs: Vec<_> = arguments.report.iter().cloned().collect();
    let inputs = [&arguments.file].into_iter().chain(&arguments.machine).chain(&arguments.gains);
    refuse_overwrite(inputs, &outputs, general.no_clobber)?;
    let file = &arguments.file;
    let bytes = read_bytes(file)?;
    let recording = recording(file, &bytes)?;
    let setup = RunSetup::from_recording(file, &recording)?;
    let progress = Progress::new();
    progress.show("planning the motion and building the controller", 0.0);
    let motion = Motion::new(file, &recording, &setup)?;
    let controller = recorded_controller(&setup, &motion)?;
    let other = match (&arguments.machine, &arguments.gains) {
        (None, None) => None,
        (machine, gains) => {
            let machine = (machine.as_deref(), arguments.root.dir.as_deref());
            Some(other_controller(&setup, &motion, machine, gains.as_deref())?)
        }
    };
    progress.show("replaying", 0.0);
    let compared = compare(file, &recording, &motion, controller, other)?;
    drop(progress);
    let written = match &arguments.report {
        Some(path) => {
            let page = show::page(&compared, &recording.head)?;
            write_all(&[(path.clone(), page.as_bytes())])?
        }
        None => Vec::new(),
    };
    // Another controller is expected to differ.
    let outcome = Outcome::new(compared.reproduced() || compared.other.is_some());
    let content = if general.json {
        Content::json(&show::json(&compared, &recording.head))?
    } else {
        Content::Text(show::text(&compared, &recording.head))
    };
    Ok(Answer { outcome, content, written })
}
