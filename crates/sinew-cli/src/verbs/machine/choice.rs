//! Cables and drives for the muscles of a body: by its own weight and the demands of a motion.

use crate::error::Error;
use sinew::control::arm::characterize;
use sinew::control::demand::{DriveDemand, DriveDemands, SizingMotion, drive_demands};
use sinew::control::scaling::Scaling;
use sinew::drive::sizing::{Choice as Selected, Requirement, choose};
use sinew::drive::{Catalogue, CatalogueWinch, Winch};
use sinew::machine::Machine;

/// Fraction of tension and speed of a drive that the motion may use.
const USED: f64 = 0.8;
/// Time in which a winch crosses the dead band of its cable, s.
const CROSSING: f64 = 0.4;
/// Peak tension of a drive over the largest that its cable is asked for.
const PEAK: f64 = 1.3;

/// A drive of the catalogue for one or more muscles.
#[derive(Debug, Clone, PartialEq)]
pub(super) struct ChosenDrive {
    pub(super) name: String,
    pub(super) motor: String,
    pub(super) reducer: String,
    pub(super) ratio: f64,
    /// In the catalogue; none for that of the scaled machine.
    pub(super) winch: Option<String>,
}

/// What is chosen for a body.
#[derive(Debug)]
pub(super) struct Choice {
    /// The body with the chosen cable.
    pub(super) machine: Machine,
    /// Cord, limits and sensors by the size of the body, with their drum; none for the default cable.
    pub(super) scaling: Option<(Scaling, Winch)>,
    pub(super) drives: Vec<ChosenDrive>,
    /// Index of every muscle's drive.
    pub(super) drive_of: Vec<usize>,
    pub(super) demands: DriveDemands,
    /// The requirement on every muscle's drive.
    pub(super) required: Vec<Requirement>,
    /// The fraction of its nearest limit that every muscle's drive uses; above 1 it is too weak.
    pub(super) used: Vec<f64>,
}

/// Chooses cables and drives for a motion, and a force at the end point, N; of those of a name, where there
/// is one.
pub(super) fn drives(
    machine: &Machine,
    motion: &SizingMotion,
    tip_force: Option<f64>,
    names: Option<&str>,
) -> Result<Choice, Error> {
    let mut catalogue = Catalogue::built_in()?.for_drives(names);
    let scaling = Scaling::new(machine, &catalogue.cords, tip_force)?;
    let machine = scaling.as_ref().map_or_else(|| machine.clone(), |scaling| scaling.applied(machine));
    let demands = drive_demands(&machine, motion)?;
    let required: Vec<Requirement> = demands
        .muscles
        .iter()
        .zip(dead_bands(&machine)?)
        .map(|(demand, band)| requirement(demand, band))
        .collect();
    let scaling = scaling.map(|scaling| {
        let stroke = required.iter().map(|required| required.stroke).fold(0.0, f64::max);
        let winch = scaling.winch(stroke);
        (scaling, winch)
    });
    if let Some((scaling, winch)) = &scaling {
        // The others are for cables of 3 mm.
        catalogue.winches = vec![CatalogueWinch {
            name: scaling.cord.name.clone(),
            source: "ours".to_owned(),
            assumed: vec!["all".to_owned()],
            parameters: *winch,
        }];
    }
    let (mut drives, mut drive_of, mut used) = (Vec::<ChosenDrive>::new(), Vec::new(), Vec::new());
    let peak = scaling.as_ref().map_or(0.0, |(scaling, _)| PEAK * scaling.largest_at_drive());
    for required in &required {
        let choices = choose(&catalogue, required)?;
        let strong = |choice: &&Selected<'_>| {
            choice.demand.is_met() && choice.design.envelope_at(0.0, 0.0).peak.tension >= peak
        };
        let best = choices.iter().find(strong).unwrap_or(&choices[0]);
        used.push(best.demand.worst().1);
        let mut drive = ChosenDrive {
            name: String::new(),
            motor: best.motor.name.clone(),
            reducer: best.reducer.name.clone(),
            ratio: best.design.reducer.ratio,
            winch: scaling.is_none().then(|| best.winch.name.clone()),
        };
        let same = |other: &ChosenDrive| ChosenDrive { name: String::new(), ..other.clone() } == drive;
        let index = drives.iter().position(same).unwrap_or(drives.len());
        if index == drives.len() {
            drive.name = format!("drive_{}", index + 1);
            drives.push(drive);
        }
        drive_of.push(index);
    }
    Ok(Choice { machine, scaling, drives, drive_of, demands, required, used })
}

/// Demand on a drive with the margins of the choice.
fn requirement(demand: &DriveDemand, dead_band: f64) -> Requirement {
    Requirement {
        tension: (demand.tension / USED).max(1e-3),
        speed: (demand.speed / USED).max(dead_band / CROSSING),
        acceleration: demand.acceleration / USED,
        stroke: demand.stroke / USED,
    }
}

/// The dead band of every cable, m.
fn dead_bands(machine: &Machine) -> Result<Vec<f64>, Error> {
    let laws = machine.laws(CELLS)?;
    let (_, found) = characterize(machine, &laws, &machine.poses(POSES)?)?;
    Ok(found.muscles.iter().map(|muscle| muscle.dead_band).collect())
}

const CELLS: usize = 12;
const POSES: usize = 60;
