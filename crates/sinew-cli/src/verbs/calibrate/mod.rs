//! `sinew calibrate`: poses, a flight before a camera, the estimate and its judgement.

mod observations;
mod report;
mod scenario;
mod tables;

use crate::answer::{Answer, Content, Outcome};
use crate::arguments::{
    CalibrateArguments, CalibrateFitArguments, CalibrateFlyArguments, CalibratePlanArguments, CalibrateVerb,
    General,
};
use crate::error::Error;
use crate::output::{Folder, refuse_overwrite, write_all};
use crate::progress::Progress;
use crate::verbs::verification;
use scenario::Scenario;
use serde_json::json;
use sinew::machine::{Machine, Task};
use sinew_lab::arm::{CalibratedArm, Verified, verify};
use sinew_lab::vision::{
    CableJudgement, CalibrationPoses, Judgement, fly, judge, judge_cables, motion_through,
};
use std::path::PathBuf;

/// Names of the files in the folder.
const CALIBRATION: &str = "calibration.toml";
const REPORT: &str = "report.txt";
const READINGS: &str = "readings.csv";
const OBSERVATIONS: &str = "observations.csv";
/// Every so many places judge where no plan says which.
const EVERY: usize = 5;
/// Choices of poses that are verified: what cannot be flown is left out of the next.
const MOST_CHOICES: u32 = 8;
/// Largest difference of a reading from the pose that judges, rad or m.
const SAME_POSE: f64 = 0.05;

pub(crate) fn run(arguments: &CalibrateArguments, general: &General) -> Result<Answer, Error> {
    match &arguments.verb {
        Some(CalibrateVerb::Plan(arguments)) => plan(arguments, general),
        Some(CalibrateVerb::Fit(arguments)) => fit(arguments, general),
        None => flown(&arguments.fly, general),
    }
}

fn plan(arguments: &CalibratePlanArguments, general: &General) -> Result<Answer, Error> {
    refuse_overwrite([&arguments.scenario.model], std::slice::from_ref(&arguments.out), general.no_clobber)?;
    let scenario = Scenario::new(&arguments.scenario)?;
    let poses = scenario.poses(&arguments.scenario, |_| Ok(None))?;
    let (motion, arrivals) = motion_through(&scenario.machine, &poses.poses)?;
    let table = tables::poses(&scenario.machine, &poses, &arrivals, motion.duration())?;
    let written = write_all(&[(arguments.out.clone(), table.as_bytes())])?;
    let content = if general.json {
        Content::json(&json!({"poses": poses.poses.len(), "expected_error_m": poses.expected_m}))?
    } else {
        Content::Text(report::plan(&poses, motion.duration()))
    };
    Ok(Answer::done(content, written))
}

fn flown(arguments: &CalibrateFlyArguments, general: &General) -> Result<Answer, Error> {
    let expected = "a folder for the results";
    let missing = || Error::Argument { flag: "--out", value: String::new(), expected };
    let out = arguments.out.as_deref().ok_or_else(missing)?;
    let out = Out::new(out, &[&arguments.scenario.model], true, general)?;
    let scenario = Scenario::new(&arguments.scenario)?;
    let progress = Progress::new();
    progress.show("choosing poses", 0.0);
    // Poses are of the joints: where the end point is meanwhile is unknown as yet.
    let mut machine = Machine { task: Task::Joints, ..scenario.machine.clone() };
    let mut verified = None;
    let mut choices = 1..=MOST_CHOICES;
    let poses = scenario.poses(&arguments.scenario, |motion| {
        let Some(choice) = choices.next().filter(|_| !arguments.unverified) else { return Ok(None) };
        progress.show(&format!("verifying choice {choice} of the poses"), 0.0);
        let found = verify(&machine, motion, 1)?;
        verified = Some(found.verified);
        Ok(found.failed_at)
    })?;
    let (motion, _) = motion_through(&scenario.machine, &poses.poses)?;
    match verified {
        Some(Verified::Fails(reason)) => {
            let motion = "the motion through the poses".to_owned();
            return Err(Error::Untracked { motion, reason, slowed: false });
        }
        Some(verified) => {
            verification::warn(&verified);
            if let Verified::Tracks(rules) | Verified::Inaccurate(rules, _) = verified {
                machine.rules = rules;
            }
        }
        None => (),
    }
    progress.show("calibrating the machine's cables", 0.0);
    let seed = arguments.scenario.seed;
    let arm = CalibratedArm::new(&machine, seed)?;
    progress.show("flying", 0.0);
    let camera = scenario.camera(&arguments.camera_fault, motion.duration())?;
    let flight = fly(&arm, &motion, &scenario.markers, camera, seed)?;
    drop(progress);
    if let Some(reason) = flight.stopped {
        return Err(Error::Shown(format!("the motion through the poses was stopped: {reason}")));
    }
    let checks: Vec<&Vec<f64>> =
        poses.poses.iter().zip(&poses.held).filter(|(_, held)| **held).map(|(pose, _)| pose).collect();
    let near = |reading: &[f64]| {
        let close = |pose: &Vec<f64>| pose.iter().zip(reading).all(|(a, b)| (a - b).abs() < SAME_POSE);
        checks.iter().any(|pose| close(pose))
    };
    if arguments.no_camera {
        let (readings, cables) = (&flight.readings, &flight.cables);
        let judgement = judge_cables(&scenario.machine, readings, cables, |_, reading| near(reading))?;
        let table = tables::readings(&scenario.machine, readings, Some(cables))?;
        return out.answer(&scenario, Judged::Cables(&judgement), vec![(READINGS, table)], general);
    }
    let seen = (&flight.readings, flight.frames.as_slice());
    let judgement =
        judge(&scenario.machine.loaded()?, &scenario.markers, seen, |_, _, reading| near(reading))?;
    let files = vec![
        (READINGS, tables::readings(&scenario.machine, &flight.readings, None)?),
        (OBSERVATIONS, tables::observations(&scenario.markers, &flight.frames)?),
    ];
    out.answer(&scenario, Judged::Camera(&judgement, Some(&poses)), files, general)
}

fn fit(arguments: &CalibrateFitArguments, general: &General) -> Result<Answer, Error> {
    let inputs: Vec<&PathBuf> = [&arguments.scenario.model, &arguments.recording]
        .into_iter()
        .chain(&arguments.observations)
        .collect();
    let out = Out::new(&arguments.out, &inputs, false, general)?;
    let mut scenario = Scenario::new(&arguments.scenario)?;
    let recorded = tables::read_readings(&scenario.machine, &arguments.recording, arguments.no_camera)?;
    let out = Out { simulated: recorded.simulated, ..out };
    if arguments.no_camera {
        let judges = |k: usize, _: &[f64]| k % EVERY == EVERY / 2;
        let judgement = judge_cables(&scenario.machine, &recorded.readings, &recorded.cables, judges)?;
        return out.answer(&scenario, Judged::Cables(&judgement), Vec::new(), general);
    }
    let beside = observations::Beside { recorded: &recorded, unit: arguments.unit, clock: arguments.clock };
    let named_base = !arguments.scenario.base_tag.is_empty();
    let frames = observations::read(&mut scenario.markers, named_base, &arguments.observations, &beside)?;
    let seen = (&recorded.readings, frames.as_slice());
    let judges = |k: usize, _, _: &[f64]| k % EVERY == EVERY / 2;
    let judgement = judge(&scenario.machine.loaded()?, &scenario.markers, seen, judges)?;
    out.answer(&scenario, Judged::Camera(&judgement, None), Vec::new(), general)
}

/// The folder of the results.
struct Out {
    folder: Folder,
    simulated: bool,
}

impl Out {
    fn new(
        path: &std::path::Path,
        inputs: &[&PathBuf],
        flown: bool,
        general: &General,
    ) -> Result<Self, Error> {
        let folder = Folder::open(path)?;
        let names =
            if flown { &[CALIBRATION, REPORT, READINGS, OBSERVATIONS][..] } else { &[CALIBRATION, REPORT] };
        let outputs: Vec<PathBuf> = names.iter().map(|name| folder.file(name)).collect();
        refuse_overwrite(inputs.iter().copied(), &outputs, general.no_clobber)?;
        Ok(Self { folder, simulated: flown })
    }

    fn answer(
        self,
        scenario: &Scenario,
        judged: Judged<'_>,
        others: Vec<(&str, String)>,
        general: &General,
    ) -> Result<Answer, Error> {
        let (machine, hash) = (&scenario.machine, scenario.hash.clone());
        let (calibration, text, is_better, held_out, (verdict, findings, places)) = match judged {
            Judged::Camera(judgement, poses) => {
                let calibration = judgement.calibration(machine, hash, self.simulated);
                let text = report::text(&calibration, judgement, (machine, &scenario.markers), poses);
                let held_out = ("held_out_error_m", json!(calibration.held_out_error_m));
                let about = (judgement.verdict(), &judgement.findings, judgement.places.len());
                (calibration, text, judgement.is_better(), held_out, about)
            }
            Judged::Cables(judgement) => {
                let calibration = judgement.calibration(machine, hash, self.simulated);
                let text = report::of_cables(&calibration, judgement);
                let held_out = ("held_out", json!(calibration.held_out));
                let about = (judgement.verdict(), &judgement.findings, judgement.places.iter().sum());
                (calibration, text, judgement.is_better(), held_out, about)
            }
        };
        let toml = report::toml(&calibration);
        let mut files = vec![(CALIBRATION, toml), (REPORT, text.clone())];
        files.extend(others);
        let places_of: Vec<(PathBuf, &[u8])> =
            files.iter().map(|(name, text)| (self.folder.file(name), text.as_bytes())).collect();
        let written = write_all(&places_of)?;
        let content = if general.json {
            let mut document = json!({
                "parameters": calibration.parameter, "simulated": self.simulated, "verdict": verdict,
                "findings": findings, "places": places,
            });
            document[held_out.0] = held_out.1;
            Content::json(&document)?
        } else {
            Content::Text(text)
        };
        Ok(Answer { outcome: Outcome::new(is_better), content, written })
    }
}

/// With a camera and without.
#[derive(Clone, Copy)]
enum Judged<'a> {
    Camera(&'a Judgement, Option<&'a CalibrationPoses>),
    Cables(&'a CableJudgement),
}

/// A machine as a calibration knows it.
pub(crate) fn calibrated(
    machine: &Machine,
    hash: &str,
    text: &str,
    file: &std::path::Path,
) -> Result<Machine, Error> {
    let calibration: sinew_lab::vision::Calibration = toml::from_str(text).map_err(|error| {
        Error::Shown(format!("{}: {}", file.display(), crate::output::one_line(&error.to_string())))
    })?;
    if calibration.recommendation.as_deref() == Some("do not use") {
        return Err(Error::Shown(format!(
            "{}: its recommendation is \"do not use\": poses that the estimate has not seen were no better, or the \
             observations do not agree with the machine",
            file.display()
        )));
    }
    Ok(calibration.apply(machine, hash)?)
}
