//! Cables and drives for the muscles of a body: by the dead bands of its joints and the demands of a motion.

use crate::error::Error;
use sinew::control::arm::characterize;
use sinew::control::demand::{DriveDemand, DriveDemands, SizingMotion, drive_demands};
use sinew::drive::sizing::{Requirement, choose};
use sinew::drive::{Catalogue, CatalogueWinch, LoadCell, Winch};
use sinew::machine::{Machine, MuscleDesign};
use sinew::transmission::cable::CableParameters;

/// Largest dead band of a joint, rad or m, with which the default cable is kept.
const MAX_DEAD_BAND: f64 = 0.2;
/// Fraction of tension and speed of a drive that the motion may use.
const USED: f64 = 0.8;
/// Time in which a winch crosses the dead band of its cable, s.
const CROSSING: f64 = 0.4;

/// Rope, sensors and winch of a machine whose joints are too small for cables of 3 mm; all assumed. The rope
/// is of steel, 7 x 7 wires, 0.5 mm: 58 % of its section is metal of 66 GPa as a rope.
pub(super) struct ThinRope;

impl ThinRope {
    pub(super) fn cable() -> CableParameters {
        CableParameters {
            friction: 0.1,
            viscous: 0.0,
            efficiency: 0.98,
            drag: 4.0,
            drag_fade: 0.5,
            pretension: 1.0,
            compliance: 1.33e-4,
            sheath_compliance: 0.0,
            weakening: None,
        }
    }

    pub(super) fn load_cell() -> LoadCell {
        LoadCell { noise: 0.03, resolution: 0.005, range: 100.0, ..LoadCell::one_kilonewton() }
    }

    pub(super) fn winch() -> Winch {
        Winch { radius: 0.006, lead: 6e-4, cable_diameter: 5e-4, turns_per_layer: 10.0, layers: 1 }
    }

    /// Limits at the anchor, and those of the drive, N.
    pub(super) const TENSION: [f64; 2] = [2.5, 40.0];
    pub(super) const DRIVE: [f64; 2] = [0.3, 60.0];
}

/// A drive of the catalogue for one or more muscles.
#[derive(Debug, Clone, PartialEq)]
pub(super) struct ChosenDrive {
    pub(super) name: String,
    pub(super) motor: String,
    pub(super) reducer: String,
    pub(super) ratio: f64,
    /// In the catalogue; none for that of the thin rope.
    pub(super) winch: Option<String>,
}

/// What is chosen for a body.
#[derive(Debug)]
pub(super) struct Choice {
    /// The body with the chosen cable.
    pub(super) machine: Machine,
    /// Largest dead band with the default cable, where it is too large and the thin rope replaces it.
    pub(super) thin: Option<f64>,
    pub(super) drives: Vec<ChosenDrive>,
    /// Index of every muscle's drive.
    pub(super) drive_of: Vec<usize>,
    pub(super) demands: DriveDemands,
    /// The requirement on every muscle's drive.
    pub(super) required: Vec<Requirement>,
    /// The fraction of its nearest limit that every muscle's drive uses; above 1 it is too weak.
    pub(super) used: Vec<f64>,
}

/// Chooses cables and drives.
pub(super) fn drives(machine: &Machine, motion: &SizingMotion) -> Result<Choice, Error> {
    let band = dead_bands(machine)?.0;
    let mut machine = machine.clone();
    let mut demands = drive_demands(&machine, motion)?;
    let mut thin = None;
    if band > MAX_DEAD_BAND {
        let mut light = machine.clone();
        light.muscles.iter_mut().for_each(make_thin);
        let of_light = drive_demands(&light, motion)?;
        // The rope must be strong enough.
        if of_light.muscles.iter().all(|demand| demand.tension <= USED * ThinRope::TENSION[1]) {
            (machine, demands, thin) = (light, of_light, Some(band));
        }
    }
    let bands = dead_bands(&machine)?.1;
    let built_in = Catalogue::built_in()?;
    let catalogue = if thin.is_some() { with_thin_winch(built_in) } else { built_in };
    let (mut drives, mut drive_of, mut used) = (Vec::<ChosenDrive>::new(), Vec::new(), Vec::new());
    let required: Vec<Requirement> =
        demands.muscles.iter().zip(bands).map(|(demand, band)| requirement(demand, band)).collect();
    for required in &required {
        let choices = choose(&catalogue, required)?;
        let best = &choices[0];
        used.push(best.demand.worst().1);
        let mut drive = ChosenDrive {
            name: String::new(),
            motor: best.motor.name.clone(),
            reducer: best.reducer.name.clone(),
            ratio: best.design.reducer.ratio,
            winch: thin.is_none().then(|| best.winch.name.clone()),
        };
        let same = |other: &ChosenDrive| ChosenDrive { name: String::new(), ..other.clone() } == drive;
        let index = drives.iter().position(same).unwrap_or(drives.len());
        if index == drives.len() {
            drive.name = format!("drive_{}", index + 1);
            drives.push(drive);
        }
        drive_of.push(index);
    }
    Ok(Choice { machine, thin, drives, drive_of, demands, required, used })
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

fn make_thin(design: &mut MuscleDesign) {
    design.cable = ThinRope::cable();
    design.drive.load_cell = ThinRope::load_cell();
    [design.drive.min_tension, design.drive.max_tension] = ThinRope::DRIVE;
    design.tension = ThinRope::TENSION.map(Some);
}

/// The winch of the thin rope alone: the others are for cables of 3 mm.
fn with_thin_winch(catalogue: Catalogue) -> Catalogue {
    let winch = CatalogueWinch {
        name: "thin rope".to_owned(),
        source: "ours".to_owned(),
        assumed: vec!["all".to_owned()],
        parameters: ThinRope::winch(),
    };
    Catalogue { winches: vec![winch], ..catalogue }
}

/// The largest dead band of all joints, rad or m, and the dead band of every cable, m.
fn dead_bands(machine: &Machine) -> Result<(f64, Vec<f64>), Error> {
    let laws = machine.laws(CELLS)?;
    let (_, found) = characterize(machine, &laws, &machine.poses(POSES)?)?;
    let largest = found.joints.iter().map(|joint| joint.dead_band).fold(0.0, f64::max);
    Ok((largest, found.muscles.iter().map(|muscle| muscle.dead_band).collect()))
}

const CELLS: usize = 12;
const POSES: usize = 60;
