//! `sinew live`.

use super::machine_source;
use super::track::{fault, motion};
use crate::answer::{Answer, Content, Outcome};
use crate::arguments::{FaultArgument, General, LiveArguments, PathArgument};
use crate::error::Error;
use crate::interrupt;
use crate::progress::Progress;
use sinew::machine::Machine;
use sinew::twin::arm::Failure;
use sinew_lab::CompensationVariant;
use sinew_lab::arm::{CalibratedArm, PreparedRun, TrackingTask, Verified, infeasible_motion, verify};
use sinew_live::{Choices, Conditions, Server, ServerSettings, SimulationParts, SimulationSource, Stage};
use std::process::{Command, Stdio};
use std::sync::Arc;
use std::sync::atomic::Ordering;
use std::time::{Duration, Instant};

/// Name of the tour among the paths.
const TOUR: &str = "tour";
/// Compensations that need no training of networks.
const VARIANTS: [CompensationVariant; 5] = [
    CompensationVariant::Observer,
    CompensationVariant::None,
    CompensationVariant::Capstan,
    CompensationVariant::NoObserver,
    CompensationVariant::Perfect,
];

pub(crate) fn run(arguments: &LiveArguments, general: &General) -> Result<Answer, Error> {
    let progress = Progress::new();
    progress.show("planning and verifying the motion, calibrating the machine's cables", 0.0);
    let (description, _) = machine_source::load(&arguments.model)?;
    let machine = description.machine;
    let first = machine.paths.first().map_or(TOUR, |path| path.name.as_str());
    let conditions = Conditions {
        path: arguments.path.clone().unwrap_or_else(|| first.to_owned()),
        variant: arguments.compensation.name().to_owned(),
        payload: machine.payload,
    };
    let bare = Machine { payload: 0.0, ..machine.clone() };
    let source =
        Bench { arm: CalibratedArm::new(&bare, arguments.seed)?, machine, duration: arguments.duration };
    let stage = Stage::new(Box::new(source), conditions).map_err(Error::Shown)?;
    drop(progress);
    let server = Server::start(ServerSettings { address: arguments.bind, stage })?;
    let url = server.url();
    eprintln!("SIMULATED machine on {url}; Ctrl-C ends it");
    if arguments.open {
        open(&url);
    }
    let (begun, stop) = (Instant::now(), interrupt::answer());
    let until = arguments.until.map(Duration::from_secs_f64);
    while !stop.load(Ordering::Relaxed)
        && !server.has_failed()
        && until.is_none_or(|until| begun.elapsed() < until)
    {
        std::thread::sleep(Duration::from_millis(20));
    }
    let failed = server.has_failed();
    drop(server);
    let ended = if failed { "failed" } else { "as_planned" };
    let content = if general.json {
        Content::json(
            &serde_json::json!({"simulated": true, "address": url.split('#').next(), "ended": ended}),
        )?
    } else {
        Content::Text(if failed { "The simulation failed.\n".to_owned() } else { String::new() })
    };
    Ok(Answer { outcome: Outcome::of(!failed), content, written: Vec::new() })
}

/// Opens an address in the browser; a warning where there is none.
fn open(url: &str) {
    let program = if cfg!(target_os = "macos") { "open" } else { "xdg-open" };
    let started = Command::new(program)
        .arg(url)
        .stdin(Stdio::null())
        .stdout(Stdio::null())
        .stderr(Stdio::null())
        .spawn();
    if let Err(error) = started {
        eprintln!("warning: no browser was opened ({program}: {error}); open the address above in one");
    }
}

/// One specimen of a machine, calibrated once, under the conditions that a page chooses.
struct Bench {
    machine: Machine,
    arm: CalibratedArm,
    /// Of closed paths, s.
    duration: f64,
}

impl SimulationSource for Bench {
    fn choices(&self) -> Choices {
        let named = self.machine.paths.iter().map(|path| path.name.clone());
        let limits = self.machine.muscles.iter().map(|muscle| {
            let [low, high] = muscle.tension;
            [low.unwrap_or(0.0), high.unwrap_or(muscle.drive.most_tension)]
        });
        Choices {
            paths: named.chain([TOUR.to_owned()]).collect(),
            variants: VARIANTS.map(|variant| variant.name().to_owned()).to_vec(),
            tension_limits: limits.collect(),
        }
    }

    fn prepare(&mut self, conditions: &Conditions) -> Result<SimulationParts, String> {
        self.prepared(conditions).map_err(|error| error.to_string())
    }

    fn failure(&self, text: &str) -> Result<(Failure, f64), String> {
        let (what, duration) = text.split_once('+').map_or((text, ""), |(what, duration)| (what, duration));
        let written = if duration.is_empty() { format!("{what}@0") } else { format!("{what}@0+{duration}") };
        let argument: FaultArgument = written.parse().map_err(|error| format!("`{text}`: {error}"))?;
        let fault = fault::resolve(&[argument], &self.machine.robot).map_err(|error| error.to_string())?;
        let fault = fault.first().ok_or("no fault")?;
        Ok((fault.failure, fault.duration))
    }
}

impl Bench {
    fn prepared(&mut self, conditions: &Conditions) -> Result<SimulationParts, Error> {
        let variant: CompensationVariant = conditions.variant.parse().map_err(|_| Error::UnknownPart {
            flag: "the compensation",
            value: conditions.variant.clone(),
            kind: "compensation",
            known: VARIANTS.map(|variant| variant.name().to_owned()).to_vec(),
        })?;
        let path = match conditions.path.as_str() {
            TOUR => PathArgument::Tour,
            name => PathArgument::Named(name.to_owned()),
        };
        let machine = Machine { payload: conditions.payload, ..self.machine.clone() };
        let duration = Some(self.duration).filter(|_| path != PathArgument::Tour);
        let trajectory = motion::trajectory(&machine, &path, duration)?;
        if let Some(infeasible) = infeasible_motion(&machine, &trajectory, 1)? {
            let infeasibility = Box::new(infeasible.infeasibility);
            return Err(Error::Infeasible { path: path.to_string(), infeasibility });
        }
        let mut arm = self.arm.loaded(conditions.payload)?;
        if variant == CompensationVariant::Observer
            && let Verified::Tracks(rules) = verify(&machine, &trajectory, u32::MAX)?
        {
            arm.machine.rules = rules;
        }
        let task = TrackingTask {
            trajectory: &trajectory,
            repeats: 1,
            learning: false,
            final_rest: 0.0,
            faults: &[],
            gains: None,
            trace_interval: 1.0,
        };
        let prepared = PreparedRun::new(&arm, variant, &task)?;
        let (plant, supervisor) = (prepared.run().plant()?, prepared.supervisor()?);
        drop(prepared);
        Ok(SimulationParts { machine: arm.machine, plant, supervisor, trajectory: Arc::new(trajectory) })
    }
}
