//! Starts and ends a recording beside a run.

use super::setup::{Controller, LinkSetup, RunSetup};
use crate::arguments::PathArgument;
use crate::error::Error;
use crate::output::{Written, one_line};
use crate::verbs::run::{Door, Pace};
use crate::verbs::track::setup::Setup;
use serde_json::{Value, json};
use sinew::control::arm::ArmGains;
use sinew::predictor::CableModel;
use sinew_identify::gear::GearFit;
use sinew_lab::arm::CLOSED_PATH_S;
use sinew_record::{Circumstances, Head, Recorded, Recorder};
use sinew_runtime::link::Tape;
use sinew_session::{CycleRecord, Plant};
use std::fs::OpenOptions;
use std::path::{Path, PathBuf};
use std::time::SystemTime;

/// What is to be recorded, and how.
pub(crate) struct Request<'a> {
    pub(crate) door: &'a Door<'a>,
    pub(crate) setup: &'a Setup,
    pub(crate) gains: &'a ArmGains,
    pub(crate) models: &'a [CableModel],
    /// Of models that were identified on a simulated bench.
    pub(crate) gears: Option<&'a [Option<GearFit>]>,
    /// How a client commands the run.
    pub(crate) link: Option<LinkSetup>,
}

/// A recording beside a run.
///
/// Where the run ends before its first cycle, nothing is left of it.
pub(crate) struct Recording {
    recorder: Option<Recorder>,
    started: bool,
    path: PathBuf,
    replaced: bool,
    virtual_time: bool,
    tape: Option<Tape>,
}

/// What became of it.
pub(crate) struct Ended {
    pub(crate) written: Written,
    pub(crate) json: Value,
    /// For people.
    pub(crate) text: String,
    pub(crate) whole: bool,
}

impl Recording {
    /// Creates the file and starts its thread; none where nothing is to be recorded. Before the cycle's
    /// thread has its priority, which a thread started later would inherit.
    pub(crate) fn start(request: &Request<'_>) -> Result<Option<Self>, Error> {
        let Request { door, setup, .. } = request;
        let Some(path) = door.recording() else { return Ok(None) };
        let (_, files) = RunSetup::new(setup, request.controller())?;
        let virtual_time = door.pace == Pace::Virtual;
        let since_1970 = SystemTime::now().duration_since(SystemTime::UNIX_EPOCH).unwrap_or_default();
        let head = Head::new(
            &setup.machine,
            Circumstances {
                program: env!("CARGO_PKG_VERSION").to_owned(),
                commit: env!("SINEW_COMMIT").to_owned(),
                simulated: door.is_simulated(),
                virtual_time,
                start_ns: if virtual_time { 0 } else { since_1970.as_nanos() as u64 },
                period_ns: setup.machine.period_ns(),
            },
        );
        let replaced = path.is_file();
        let unwritable = |source| Error::Unwritable { file: path.clone(), source };
        let file =
            OpenOptions::new().write(true).create(true).truncate(true).open(path).map_err(unwritable)?;
        let failed = warn_of(path);
        let (file, machine) = (Box::new(file), &setup.machine);
        let started = Recorder::start_with_tape(file, head, machine, &files, failed);
        let (recorder, tape) = started.map_err(Error::recording(path))?;
        Ok(Some(Self {
            recorder: Some(recorder),
            started: false,
            path: path.clone(),
            replaced,
            virtual_time,
            tape: Some(tape),
        }))
    }

    /// Where what the cycle takes from elsewhere goes; once.
    pub(crate) fn take_tape(&mut self) -> Option<Tape> {
        self.tape.take()
    }

    /// Records a cycle.
    pub(crate) fn record<P: Plant>(&mut self, record: &CycleRecord<'_, P>) {
        self.started = true;
        let Some(recorder) = &mut self.recorder else { return };
        if self.virtual_time {
            recorder.record_all(record);
        } else {
            recorder.record(record);
        }
    }

    /// Waits until everything is written.
    pub(crate) fn end(mut self) -> Ended {
        self.started = true;
        let recorder = self.recorder.take();
        let dropped = recorder.as_ref().map_or(0, Recorder::dropped);
        let written = Written { file: self.path.clone(), replaced: self.replaced };
        match recorder.map_or_else(|| Ok(Recorded::default()), Recorder::finish) {
            Ok(recorded) => {
                let mut text = String::new();
                if recorded.dropped > 0 {
                    text = format!(
                        "Recording: {} of {} cycles are missing, because the file could not be written \
                            fast enough\n",
                        recorded.dropped,
                        recorded.cycles + recorded.dropped
                    );
                }
                let json = json!({
                    "cycles": recorded.cycles, "dropped": recorded.dropped, "bytes": recorded.bytes,
                    "cpu_s": 1e-9 * recorded.cpu_ns as f64,
                });
                Ended { written, json, text, whole: recorded.dropped == 0 }
            }
            Err(error) => {
                let message = one_line(&error.to_string());
                let json = json!({"error": message, "dropped": dropped});
                let text = "Recording: ends early; what was written is whole\n".to_owned();
                Ended { written, json, text, whole: false }
            }
        }
    }
}

impl Drop for Recording {
    fn drop(&mut self) {
        if !self.started {
            drop(self.recorder.take());
            // The error of the run is what matters.
            let _ = std::fs::remove_file(&self.path);
        }
    }
}

impl<'a> Request<'a> {
    fn controller(&self) -> Controller<'a> {
        let motion = &self.door.arguments.motion;
        let closed = matches!(self.setup.path, PathArgument::Named(_));
        Controller {
            gains: self.gains,
            models: self.models,
            gears: self.gears.unwrap_or_default(),
            calibrated: self.gears.is_some(),
            bus: self.door.bus.name(),
            faults: motion.fault.iter().map(|fault| fault.text().to_owned()).collect(),
            duration_s: motion.duration.or(closed.then_some(CLOSED_PATH_S)),
            link: self.link,
        }
    }
}

/// Tells once that a recording has ended early; the run goes on.
fn warn_of(path: &Path) -> impl FnOnce(&sinew_record::Error) + Send + use<> {
    let file = path.display().to_string();
    move |error| tell!("warning: {}", one_line(&format!("{file}: {error}; the run goes on without it")))
}
