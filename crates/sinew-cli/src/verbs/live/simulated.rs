//! A simulated machine for the page.

use crate::arguments::{LiveArguments, PathArgument};
use crate::error::Error;
use crate::verbs::machine_source;
use crate::verbs::meshes::read_meshes;
use crate::verbs::page::tension_limits;
use crate::verbs::track::motion;
use crate::verbs::verification;
use sinew::machine::Machine;
use sinew::twin::arm::Failure;
use sinew_lab::CompensationVariant;
use sinew_lab::arm::{
    CalibratedArm, PreparedRun, TrackingTask, Verified, WrittenFault, infeasible_motion, verify, verify_tour,
};
use sinew_live::{Choices, Conditions, Kinematic, SimulationParts, SimulationSource, Source, Stage};
use std::sync::Arc;

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

/// The machine of the arguments along its motion, calibrated. One that cannot make its motion is moved
/// without forces, with the reason, unless the motion was asked for.
pub(super) fn source(arguments: &LiveArguments) -> Result<Box<dyn Source>, Error> {
    let mut machine =
        machine_source::load(&arguments.model, arguments.root.dir.as_deref())?.described.machine;
    read_meshes(&mut machine.robot, &arguments.model, arguments.root.dir.as_deref());
    match stage(arguments, machine.clone()) {
        Ok(stage) => Ok(Box::new(stage)),
        Err(error @ Error::Infeasible { .. }) if arguments.path.is_none() => {
            let path = machine
                .paths
                .first()
                .map_or(PathArgument::Tour, |path| PathArgument::Named(path.name.clone()));
            let trajectory = motion::unchecked(&machine, &path, arguments.duration)?;
            let notice = format!("Shown without forces, because the machine cannot make its motion: {error}");
            tell!("warning: {notice}");
            let limits = tension_limits(&machine);
            let shown = Kinematic::new(machine, trajectory, (path.to_string(), notice), limits);
            Ok(Box::new(shown.map_err(sinew_lab::Error::from)?))
        }
        Err(error) => Err(error),
    }
}

fn stage(arguments: &LiveArguments, machine: Machine) -> Result<Stage, Error> {
    let first = machine.paths.first().map_or(TOUR, |path| path.name.as_str());
    let conditions = Conditions {
        path: arguments.path.clone().unwrap_or_else(|| first.to_owned()),
        variant: arguments.compensation.name().to_owned(),
        payload: machine.payload,
    };
    let bare = Machine { payload: 0.0, ..machine.clone() };
    let mut source =
        Bench { arm: CalibratedArm::new(&bare, arguments.seed)?, machine, duration: arguments.duration };
    let parts = source.prepared(&conditions)?;
    Ok(Stage::new(Box::new(source), conditions, parts).map_err(sinew_lab::Error::from)?)
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
        Choices {
            paths: named.chain([TOUR.to_owned()]).collect(),
            variants: VARIANTS.map(|variant| variant.name().to_owned()).to_vec(),
            tension_limits: tension_limits(&self.machine),
            failures: offered(&self.machine),
        }
    }

    fn prepare(&mut self, conditions: &Conditions) -> Result<SimulationParts, String> {
        self.prepared(conditions).map_err(|error| error.to_string())
    }

    fn failure(&self, text: &str) -> Result<(Failure, f64), String> {
        failure(text, &self.machine)
    }
}

/// Failures of a muscle that the page offers: as in `--fault`, without time, `{}` being the muscle's name;
/// and in words.
const OFFERED: [(&str, &str); 10] = [
    ("load-cell:{}:lost", "load cell gives no value"),
    ("load-cell:{}:stuck", "load cell is stuck"),
    ("motor-encoder:{}:lost", "motor encoder gives no value"),
    ("motor-encoder:{}:stuck", "motor encoder is stuck"),
    ("drive:{}", "drive has no power"),
    ("winch:{}", "winch is jammed"),
    ("cable:{}", "cable breaks"),
    ("friction:{}:100", "friction doubles"),
    ("pretension:{}:50", "half of the pretension is lost"),
    ("stiffness:{}:17", "a strand of seven breaks"),
];

/// Failures that all muscles of a machine can have.
fn offered(machine: &Machine) -> Vec<(&'static str, &'static str)> {
    let has_cells = machine.muscles.iter().all(|muscle| muscle.drive.has_load_cell);
    OFFERED.into_iter().filter(|(text, _)| has_cells || !text.starts_with("load-cell")).collect()
}

/// A failure and its duration, s, by the text of `--fault` without its time.
fn failure(text: &str, machine: &Machine) -> Result<(Failure, f64), String> {
    let (what, duration) = text.split_once('+').map_or((text, ""), |(what, duration)| (what, duration));
    let written = if duration.is_empty() { format!("{what}@0") } else { format!("{what}@0+{duration}") };
    let written: WrittenFault = written.parse().map_err(|error| format!("`{text}`: {error}"))?;
    let fault = written.of(machine).map_err(|error| error.to_string())?;
    Ok((fault.failure, fault.duration))
}

impl Bench {
    fn prepared(&mut self, conditions: &Conditions) -> Result<SimulationParts, Error> {
        let variant: CompensationVariant = conditions.variant.parse().map_err(|_| {
            let known = VARIANTS.map(|variant| variant.name().to_owned()).to_vec();
            Error::unknown("the compensation", &conditions.variant, "compensation", known)
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
            return Err(Error::Infeasible { path: path.to_string(), infeasibility, long_enough: None });
        }
        let mut arm = self.arm.loaded(conditions.payload)?;
        let (trajectory, verified) = match (variant, &path) {
            (CompensationVariant::Observer, PathArgument::Tour) => {
                let given = trajectory.duration();
                let tour = verify_tour(&machine, trajectory, u32::MAX)?;
                verification::tell_slowed(&tour, given);
                (tour.trajectory, Some(tour.verified))
            }
            (CompensationVariant::Observer, _) => {
                let verified = verify(&machine, &trajectory, u32::MAX)?.verified;
                (trajectory, Some(verified))
            }
            _ => (trajectory, None),
        };
        // What is shown may be stopped at any time: the motion starts nevertheless.
        verified.iter().for_each(verification::warn);
        if let Some(Verified::Tracks(rules) | Verified::Inaccurate(rules, _)) = verified {
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

#[cfg(test)]
mod tests {
    use super::*;
    use sinew::twin::arm::InjectedFault;
    use std::path::Path;

    #[test]
    fn every_failure_that_the_page_offers_is_accepted_for_every_muscle_of_every_built_in_machine() {
        for (name, text) in sinew_models::MACHINES {
            let machine = sinew_lab::machine_file::machine_in(Path::new(name), text, None).unwrap().machine;
            let parts = machine.robot.parts();
            let sizes = [parts.tendons.len(), machine.robot.nv()];
            for (offered, words) in offered(&machine) {
                for muscle in &parts.tendons {
                    let text = offered.replace("{}", &muscle.name);
                    let (failure, duration) = failure(&text, &machine)
                        .unwrap_or_else(|refused| panic!("{name}: {words}: {refused}"));
                    let fault = InjectedFault { start: 0.0, duration, failure };
                    assert!(fault.validate(sizes[0], sizes[1]).is_ok(), "{name}: {text}");
                }
            }
        }
    }
}
