//! Attachment `setup.json`: the motion, the controller and the files of the machine.

use super::read::attachment;
use crate::arguments::PathArgument;
use crate::error::Error;
use crate::output::one_line;
use crate::verbs::calibrate::calibrated;
use crate::verbs::machine_source::{MachineSource, SourceText};
use crate::verbs::read_text;
use crate::verbs::track::{motion, setup::Setup};
use serde::{Deserialize, Serialize};
use sinew::control::arm::ArmGains;
use sinew::machine::Machine;
use sinew::predictor::CableModel;
use sinew::trajectory::Trajectory;
use sinew_identify::gear::GearFit;
use sinew_lab::arm::INITIAL_REST_S;
use sinew_link::host::SessionSettings;
use sinew_record::{File, Recording};
use std::io::Write;
use std::path::{Path, PathBuf};

/// Name of the attachment.
pub(crate) const SETUP: &str = "setup.json";

/// Name of the attachment with a calibration.
const CALIBRATION: &str = "calibration.toml";

/// Duration of a closed path in recordings of programs until 2026-11-26 that do not say it, s.
const CLOSED_PATH_ONCE_S: f64 = 115.0;

/// Everything that a run's commands follow from beside its readings.
#[derive(Debug, Clone, PartialEq, Serialize, Deserialize)]
pub(crate) struct RunSetup {
    /// Path or name of the machine as given.
    pub(crate) machine: PathBuf,
    /// Its files.
    machine_files: Vec<AttachedText>,
    pub(crate) payload_kg: f64,
    /// `--path`.
    pub(crate) path: String,
    /// Attachment with its waypoints.
    waypoints: Option<String>,
    /// Whether they are those of the joints.
    joint_waypoints: bool,
    duration_s: Option<f64>,
    pub(crate) repeats: u32,
    pub(crate) learning: bool,
    pub(crate) initial_rest_s: f64,
    pub(crate) final_rest_s: f64,
    pub(crate) compensation: String,
    pub(crate) seed: u64,
    pub(crate) faults: Vec<String>,
    pub(crate) bus: String,
    /// Whether the cables were calibrated on a simulated bench; otherwise their models are those of the
    /// machine file.
    pub(crate) calibrated: bool,
    pub(crate) gains: ArmGains,
    pub(crate) models: Vec<CableModel>,
    /// Attachment with the calibration of its geometry.
    #[serde(default, skip_serializing_if = "Option::is_none")]
    calibration: Option<String>,
    /// Losses of the gears of muscles without a load cell, as they were calibrated.
    #[serde(default, skip_serializing_if = "Vec::is_empty")]
    pub(crate) gears: Vec<Option<GearFit>>,
    /// Of a run that a client commanded, along no motion of its own.
    #[serde(default)]
    pub(crate) link: Option<LinkSetup>,
}

/// How a client commanded a run.
#[derive(Debug, Clone, Copy, PartialEq, Eq, Serialize, Deserialize)]
pub(crate) struct LinkSetup {
    lock_step: bool,
    playout_delay_ns: u64,
    timeout_ns: u64,
    /// Infinite in recordings without it.
    #[serde(default = "for_ever")]
    unattended_ns: u64,
}

fn for_ever() -> u64 {
    u64::MAX
}

impl LinkSetup {
    pub(crate) fn new(settings: &SessionSettings) -> Self {
        let SessionSettings { lock_step, playout_delay_ns, timeout_ns, unattended_ns, .. } = *settings;
        Self { lock_step, playout_delay_ns, timeout_ns, unattended_ns }
    }

    /// Of a control cycle with a period, ns.
    pub(crate) fn settings(self, period_ns: u64) -> SessionSettings {
        let Self { lock_step, playout_delay_ns, timeout_ns, unattended_ns } = self;
        let others = SessionSettings::of_period(period_ns);
        SessionSettings { lock_step, playout_delay_ns, timeout_ns, unattended_ns, ..others }
    }
}

/// A file of the machine among the attachments.
#[derive(Debug, Clone, PartialEq, Serialize, Deserialize)]
struct AttachedText {
    role: String,
    attachment: String,
}

/// What a setup does not say by itself.
pub(crate) struct Controller<'a> {
    pub(crate) gains: &'a ArmGains,
    pub(crate) models: &'a [CableModel],
    pub(crate) gears: &'a [Option<GearFit>],
    pub(crate) calibrated: bool,
    pub(crate) bus: &'a str,
    pub(crate) faults: Vec<String>,
    pub(crate) duration_s: Option<f64>,
    pub(crate) link: Option<LinkSetup>,
}

impl RunSetup {
    /// Of a run, with the attachments that it names.
    pub(crate) fn new(setup: &Setup, controller: Controller<'_>) -> Result<(Self, Vec<File>), Error> {
        let mut files = Vec::new();
        let mut machine_files = Vec::new();
        for (k, text) in setup.source.texts.iter().enumerate() {
            let given = if k == 0 { setup.source.path.as_path() } else { Path::new(&text.role) };
            let attachment = format!("machine/{k}-{}", file_name(given));
            files.push(File { name: attachment.clone(), bytes: text.text.clone().into_bytes() });
            machine_files.push(AttachedText { role: text.role.clone(), attachment });
        }
        let calibration = setup.calibration.as_ref().map(|text| {
            files.push(File { name: CALIBRATION.to_owned(), bytes: text.clone().into_bytes() });
            CALIBRATION.to_owned()
        });
        let waypoints = match setup.path.file() {
            Some(file) => {
                let name = format!("path/{}", file_name(file));
                files.push(File { name: name.clone(), bytes: read_text(file)?.into_bytes() });
                Some(name)
            }
            None => None,
        };
        let all = Self {
            machine: setup.source.path.clone(),
            machine_files,
            payload_kg: setup.machine.payload,
            path: setup.path.to_string(),
            waypoints,
            joint_waypoints: matches!(setup.path, PathArgument::JointWaypoints(_)),
            duration_s: controller.duration_s,
            repeats: setup.repeats,
            learning: setup.learning,
            initial_rest_s: INITIAL_REST_S,
            final_rest_s: setup.hold_s,
            compensation: setup.variant.to_string(),
            seed: setup.seed,
            faults: controller.faults,
            bus: controller.bus.to_owned(),
            calibrated: controller.calibrated,
            gains: controller.gains.clone(),
            models: controller.models.to_vec(),
            calibration,
            gears: controller.gears.to_vec(),
            link: controller.link,
        };
        files.push(File { name: SETUP.to_owned(), bytes: serde_json::to_vec_pretty(&all)? });
        Ok((all, files))
    }

    /// Of a recording.
    pub(crate) fn from_recording(file: &Path, recording: &Recording<'_>) -> Result<Self, Error> {
        let text = recording.text(SETUP).map_err(Error::recording(file))?;
        serde_json::from_str(text).map_err(|error| attachment(file, SETUP, one_line(&error.to_string())))
    }

    /// What moved the machine, in words.
    pub(crate) fn motion(&self) -> String {
        match self.link {
            Some(_) => "commanded by a client".to_owned(),
            None => format!("along {}", self.path),
        }
    }

    /// Where the machine's file was when it was recorded: meshes are not part of a recording.
    pub(crate) fn machine_path(&self) -> &Path {
        &self.machine
    }

    /// The machine as it was recorded, with its payload.
    pub(crate) fn machine(&self, file: &Path, recording: &Recording<'_>) -> Result<Machine, Error> {
        let texts = self.machine_files.iter().map(|each| {
            let bytes = recording.file(&each.attachment);
            let text = bytes.and_then(|bytes| String::from_utf8(bytes.to_vec()).ok());
            let text =
                text.ok_or_else(|| attachment(file, &each.attachment, "expected it as text".to_owned()))?;
            Ok(SourceText { role: each.role.clone(), text })
        });
        let texts = texts.collect::<Result<_, Error>>()?;
        let source = MachineSource { path: self.machine.clone(), texts, root: None };
        let machine = Machine { payload: self.payload_kg, ..source.machine()?.machine };
        let Some(name) = &self.calibration else { return Ok(machine) };
        let bytes = recording.file(name);
        let text = bytes.and_then(|bytes| String::from_utf8(bytes.to_vec()).ok());
        let text = text.ok_or_else(|| attachment(file, name, "expected it as text".to_owned()))?;
        calibrated(&machine, &source.hash(), &text, file)
    }

    /// The motion, planned again.
    pub(crate) fn trajectory(
        &self,
        file: &Path,
        recording: &Recording<'_>,
        machine: &Machine,
    ) -> Result<Trajectory, Error> {
        let Some(name) = &self.waypoints else {
            let path = PathArgument::without_file(&self.path);
            let path =
                path.ok_or_else(|| attachment(file, SETUP, format!("unknown path `{}`", self.path)))?;
            let unwritten = matches!(path, PathArgument::Named(_)).then_some(CLOSED_PATH_ONCE_S);
            return motion::trajectory(machine, &path, self.duration_s.or(unwritten));
        };
        let bytes = recording.file(name);
        let bytes = bytes.ok_or_else(|| attachment(file, name, "expected the waypoints".to_owned()))?;
        let unwritable = |source| Error::Unwritable { file: PathBuf::from(name), source };
        let mut copy = tempfile::Builder::new().suffix(".csv").tempfile().map_err(unwritable)?;
        copy.write_all(bytes).map_err(unwritable)?;
        let place = copy.path().to_owned();
        let path = if self.joint_waypoints {
            PathArgument::JointWaypoints(place)
        } else {
            PathArgument::Waypoints(place)
        };
        motion::trajectory(machine, &path, self.duration_s)
    }
}

fn file_name(path: &Path) -> String {
    path.file_name().map_or_else(|| "file".to_owned(), |name| name.to_string_lossy().into_owned())
}
