//! Cord, limits of tension, load cell and drum of a machine by the size of its body.

use super::working_tension::{WorkingTension, working_tension};
use crate::Error;
use crate::drive::{CatalogueCord, LoadCell, Winch};
use crate::machine::Machine;
use crate::muscle::MuscleDynamics;
use crate::transmission::cable::CableParameters;
use alloc::vec;
use alloc::vec::Vec;

/// What follows from the tension that a body works with.
///
/// ```text
/// F_min = max(0.2 N, F_w/10, 0.01 sqrt(F_b N)),   F_max = 2 (F_w + F_min)
/// cord  = the thinnest with F_b >= 5 F_max e^A,   A = mu phi + 0.02
/// T_0   = 0.3 F_min,   drive: 0.1 F_min to 1.5 F_max e^A,   cell: 2.5 F_max e^A, noise 3e-4 of it
/// drum  = max(4 mm, 12 d)
/// ```
///
/// | symbol   | code               | unit | meaning                                                      |
/// |----------|--------------------|------|--------------------------------------------------------------|
/// | F_w      | `working`          | N    | [`WorkingTension`]                                           |
/// | F_b, d   | `cord`             | N, m | breaking load and diameter                                    |
/// | F_min, F_max | `tension`      | N    | limits at the anchors                                         |
/// | A        | `friction_angle`   | 1    | largest over muscles and poses                                |
///
/// No tension is above a fifth of the cord's breaking load at the drive, a third where a drive overshoots
/// to its limit: a knot halves the load. The last term of `F_min` is a cord that lies straight. No muscle
/// has a larger limit than its actuator in the body's description. Where there are no more muscles than
/// joints, no muscle can give way to another one: each is held taut by springs or weight alone, `F_w` of
/// its `F_min` is [its own](WorkingTension::own), and `T_0` and drives follow from the smallest `F_min`.
///
/// # Assumes
/// Factors of the rule: found on random machines of four sizes in simulation.
///
/// # Source
/// Own addition.
#[derive(Debug, Clone, PartialEq)]
pub struct Scaling {
    /// `F_w`.
    pub working: WorkingTension,
    /// The chosen cord.
    pub cord: CatalogueCord,
    /// Limits at every anchor, N: `[muscles]`.
    pub tension: Vec<[f64; 2]>,
    /// The same of a muscle that the body does not limit, N.
    pub common: [f64; 2],
    /// `A`.
    pub friction_angle: f64,
}

/// Tension above which cords of the catalogue and small drives are not chosen, N.
pub const MAX_WORKING_TENSION: f64 = 60.0;
/// Smallest tension of a taut cord, N; fraction of the working tension; N per root of the breaking load.
const TAUT: [f64; 3] = [0.2, 0.1, 0.01];
/// Largest tension over that which the work and the tautness need.
const RESERVE: f64 = 2.0;
/// Breaking load over the largest tension.
const SAFETY: f64 = 5.0;
/// Limit of the drive and range of the load cell over the largest tension at the drive.
const DRIVE_LIMIT: f64 = 1.5;
const CELL_RANGE: f64 = 2.5;
/// Noise and resolution of a load cell over its range.
const CELL_NOISE: f64 = 3e-4;
const CELL_RESOLUTION: f64 = 5e-5;
/// Smallest tension of the drive, parallel force at the anchor, and where drag fades, over that of the cord.
const DRIVE_TAUT: f64 = 0.1;
const PARALLEL: f64 = 0.3;
const FADE: f64 = 0.2;
/// Part of the limit of the body's weakest muscle up to which the tautness goes.
const OF_WEAKEST: f64 = 0.2;
/// Losses of a straight sheath.
const EFFICIENCY: f64 = 0.98;
/// Drum: smallest radius, m; radius over the cord's diameter; lead over it.
const DRUM: [f64; 3] = [0.004, 12.0, 1.2];
/// Turns that stay on the drum, and the fewest of a drum.
const SPARE_TURNS: f64 = 2.0;
const FEWEST_TURNS: f64 = 10.0;
/// Poses over which the largest wrap at the joints is found.
const POSES: usize = 60;

impl Scaling {
    /// Chooses from cords that go from the thinnest to the thickest; none where the body works with more than
    /// [`MAX_WORKING_TENSION`], where its muscles do not hold it, or no cord is strong enough.
    ///
    /// # Errors
    /// As [`working_tension`].
    pub fn new(
        machine: &Machine,
        cords: &[CatalogueCord],
        tip_force: Option<f64>,
    ) -> Result<Option<Self>, Error> {
        let working = working_tension(machine, tip_force)?;
        let Some(working) = working.filter(|working| working.tension <= MAX_WORKING_TENSION) else {
            return Ok(None);
        };
        let bend = largest_bend(machine)?;
        let weakest = machine.muscles.iter().filter_map(|design| design.tension[1]).reduce(f64::min);
        for cord in cords {
            let numbers = &cord.parameters;
            let straight = TAUT[0].max(TAUT[2] * libm::sqrt(numbers.breaking_load));
            let taut = straight.max(TAUT[1] * working.tension);
            let low = weakest.map_or(taut, |weakest| taut.min(OF_WEAKEST * weakest));
            let alone = machine.muscles.len() <= machine.encoders.len();
            let own = |work: f64| if alone { straight.max(TAUT[1] * work).min(low) } else { low };
            let common = [low, RESERVE * (working.tension + low)];
            let friction_angle = numbers.friction * bend - libm::log(EFFICIENCY);
            if numbers.breaking_load < SAFETY * common[1] * libm::exp(friction_angle) {
                continue;
            }
            let most = |most: Option<f64>| most.map_or(common[1], |most| most.min(common[1]));
            let designs = machine.muscles.iter().zip(&working.own);
            let tension = designs.map(|(design, work)| [own(*work), most(design.tension[1])]).collect();
            return Ok(Some(Self { working, cord: cord.clone(), tension, common, friction_angle }));
        }
        Ok(None)
    }

    /// Parameters of the cable.
    #[must_use]
    pub fn cable(&self) -> CableParameters {
        let cord = &self.cord.parameters;
        CableParameters {
            friction: cord.friction,
            viscous: 0.0,
            efficiency: EFFICIENCY,
            drag: cord.drag,
            drag_fade: FADE * self.smallest(),
            pretension: PARALLEL * self.smallest(),
            compliance: 1.0 / cord.stiffness,
            sheath_compliance: 0.0,
            weakening: None,
        }
    }

    fn smallest(&self) -> f64 {
        self.tension.iter().fold(self.common[0], |least, [low, _]| least.min(*low))
    }

    /// Largest tension at a drive that the anchors ask for, N.
    #[must_use]
    pub fn largest_at_drive(&self) -> f64 {
        self.common[1] * libm::exp(self.friction_angle)
    }

    /// Limits of the drives, N.
    #[must_use]
    pub fn drive_limits(&self) -> [f64; 2] {
        [DRIVE_TAUT * self.smallest(), DRIVE_LIMIT * self.largest_at_drive()]
    }

    /// Load cells at the drives.
    #[must_use]
    pub fn load_cell(&self) -> LoadCell {
        let range = CELL_RANGE * self.largest_at_drive();
        LoadCell {
            gain: 1.0,
            offset: 0.0,
            noise: CELL_NOISE * range,
            resolution: CELL_RESOLUTION * range,
            range,
        }
    }

    /// A drum of one layer for this length of cable, m.
    #[must_use]
    pub fn winch(&self, stroke: f64) -> Winch {
        let diameter = self.cord.parameters.diameter;
        let radius = (DRUM[1] * diameter).max(DRUM[0]);
        let turns = libm::ceil(stroke / (core::f64::consts::TAU * radius)) + SPARE_TURNS;
        Winch {
            radius,
            lead: DRUM[2] * diameter,
            cable_diameter: diameter,
            turns_per_layer: turns.max(FEWEST_TURNS),
            layers: 1,
        }
    }

    /// The machine with these cables, limits and load cells.
    #[must_use]
    pub fn applied(&self, machine: &Machine) -> Machine {
        let mut machine = machine.clone();
        for (design, [low, high]) in machine.muscles.iter_mut().zip(&self.tension) {
            design.cable = self.cable();
            design.drive.load_cell = self.load_cell();
            [design.drive.min_tension, design.drive.max_tension] = self.drive_limits();
            design.tension = [Some(*low), Some(*high)];
        }
        machine
    }
}

/// Largest bend of sheath and joints over muscles and poses, rad.
fn largest_bend(machine: &Machine) -> Result<f64, Error> {
    let mut dynamics = MuscleDynamics::new(&machine.robot)?;
    let mut wrap = vec![0.0_f64; machine.muscles.len()];
    for pose in machine.poses(POSES)? {
        dynamics.evaluate(&pose)?;
        for (muscle, wrap) in wrap.iter_mut().enumerate() {
            *wrap = wrap.max(dynamics.wrap_angle(muscle));
        }
    }
    let sheaths = machine.muscles.iter().zip(wrap).map(|(design, wrap)| design.bend + wrap);
    Ok(sheaths.fold(0.0, f64::max))
}

#[cfg(test)]
mod tests {
    #![allow(clippy::float_cmp, reason = "a limit is taken over as it is")]

    use super::*;
    use crate::control::tests::{Slide, slides};
    use crate::drive::Catalogue;

    fn machine(mass: f64, sheath: f64) -> Machine {
        let slide = Slide { axis: [0.0, 0.0, 1.0], mass, range: [-0.1, 0.1] };
        let mut machine = Machine::from_robot(&slides(9.81, &[slide], &[&[1.0], &[-1.0]])).unwrap();
        machine.muscles.iter_mut().for_each(|design| design.bend = sheath);
        machine
    }

    fn scaled(mass: f64, bend: f64) -> Option<Scaling> {
        Scaling::new(&machine(mass, bend), &Catalogue::built_in().unwrap().cords, None).unwrap()
    }

    #[test]
    fn no_tension_of_a_scaled_machine_is_above_its_weakest_part() {
        for mass in [1e-3, 0.02, 0.2, 1.0, 3.0, 4.0] {
            for bend in [0.0, 1.57, 6.0] {
                let found = scaled(mass, bend).unwrap();
                let machine = found.applied(&machine(mass, bend));
                machine.validate().unwrap();
                let ([taut, most], [idle, limit]) = (found.common, found.drive_limits());
                let work = found.working.tension;
                assert!(idle < taut && taut <= work.max(2.1) && work < most && most < limit, "{mass} {bend}");
                assert!(
                    3.3 * limit <= found.cord.parameters.breaking_load && limit < found.load_cell().range
                );
                assert!(found.cable().pretension < taut);
                assert!(found.winch(0.5).capacity() > 0.5 && found.winch(0.01).capacity() > 0.01);
                found.winch(0.5).validate().unwrap();
            }
        }
    }

    #[test]
    fn the_cord_is_the_thinnest_that_is_strong_enough_and_more_bend_needs_a_thicker_one() {
        let cords = Catalogue::built_in().unwrap().cords;
        let mut before = 0.0;
        for mass in [1e-3, 0.2, 1.0, 2.0, 3.0, 4.0] {
            let found = scaled(mass, 1.0).unwrap();
            let d = found.cord.parameters.diameter;
            assert!(d >= before, "{mass}");
            before = d;
            for thinner in cords.iter().filter(|cord| cord.parameters.diameter < d) {
                assert!(
                    thinner.parameters.breaking_load < 5.0 * found.largest_at_drive(),
                    "{mass}: {}",
                    thinner.name
                );
            }
            assert!(scaled(mass, 9.0).is_none_or(|bent| bent.cord.parameters.diameter >= d));
        }
        assert!(before > 5e-4);
    }

    #[test]
    fn a_body_that_works_with_more_than_small_drives_give_is_not_scaled() {
        // A weight and a half of it.
        let edge = MAX_WORKING_TENSION / 1.5 / 9.81;
        assert!(scaled(0.999 * edge, 0.0).is_some() && scaled(1.001 * edge, 0.0).is_none());
    }

    #[test]
    fn a_muscle_is_never_asked_for_more_than_the_body_allows() {
        let mut machine = machine(0.2, 0.0);
        machine.muscles[1].tension = [None, Some(0.6)];
        let cords = Catalogue::built_in().unwrap().cords;
        let found = Scaling::new(&machine, &cords, None).unwrap().unwrap();
        assert_eq!(found.tension[0], found.common);
        assert!((found.tension[1][1] - 0.6).abs() < 1e-15 && found.tension[1][0] <= 0.12 + 1e-15);
        found.applied(&machine).validate().unwrap();
    }

    #[test]
    fn muscles_against_springs_alone_are_held_taut_by_their_own_work_and_others_by_the_strongest() {
        let slide = |mass: f64| Slide { axis: [0.0, 0.0, 1.0], mass, range: [-0.1, 0.1] };
        let of = |arms: &[&[f64]]| {
            let robot = slides(9.81, &[slide(1.8), slide(0.2)], arms);
            let machine = Machine::from_robot(&robot).unwrap();
            let found =
                Scaling::new(&machine, &Catalogue::built_in().unwrap().cords, Some(0.0)).unwrap().unwrap();
            found.applied(&machine).validate().unwrap();
            found
        };
        let found = of(&[&[1.0, 0.0], &[0.0, 1.0]]);
        assert_eq!(found.tension[0], found.common);
        let [low, work] = [found.tension[1][0], found.working.own[1]];
        assert!(
            low < 0.5 * found.common[0] && low >= (0.1 * work).max(0.2) && found.cable().pretension < low
        );
        let found = of(&[&[1.0, 0.0], &[0.0, 1.0], &[-1.0, 0.0], &[0.0, -1.0]]);
        assert!(found.tension.iter().all(|tension| *tension == found.common));
    }

    #[test]
    fn without_cords_nothing_is_scaled() {
        assert_eq!(Scaling::new(&machine(0.2, 0.0), &[], None).unwrap(), None);
    }
}
