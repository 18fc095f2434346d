use super::deviation::Deviation;
use crate::Error;
use crate::body::{JointKind, Parts, PathElement, Robot, TendonPath};
use crate::drive::{DriveParameters, JointEncoder, LoadCell};
use crate::machine::{Characteristics, Machine, parts_of};
use crate::muscle::MuscleDynamics;
use crate::random::Random;
use crate::transmission::SheathBend;
use crate::transmission::cable::CableLaw;
use crate::twin::cable::{Effects, Resolution, Specimen};
use alloc::vec::Vec;

/// Parameters of a machine as built; its controller does not have them.
#[derive(Debug, Clone, PartialEq)]
pub struct ArmSpecimen {
    /// Bodies and tendon paths.
    pub robot: Robot,
    /// Cable of every muscle, drive to anchor; its last pulley is the wrap at the joint.
    pub cables: Vec<Specimen>,
    /// Bend of every sheath by the pose: `[muscles]`.
    pub bends: Vec<SheathBend>,
    /// Drive of every muscle, with the load cell of the muscle.
    pub drives: Vec<DriveParameters>,
    /// Radius of every winch over that of the design, which its drive counts with: `[muscles]`.
    pub winches: Vec<f64>,
    /// Encoder of every independent joint, or none.
    pub encoders: Vec<Option<JointEncoder>>,
    /// Period of the commands, and time without them after which the drives stop by themselves, s: those of
    /// the machine.
    pub period: f64,
    /// As the period.
    pub watchdog: f64,
    /// Cells of the cables; substeps of cables and bodies within a [`step`](Self::step).
    pub resolution: Resolution,
}

/// Largest product of step and natural frequency of the stiffest mode, 1: 2 is the limit of stability, the
/// margin is for poses that were not sampled and for tolerances.
const MAX_STEP_ANGLE: f64 = 1.2;
/// Largest product of step and rate of the joints' dampers, 1: 2 is the limit of an explicit step.
const MAX_DAMPING_STEP: f64 = 0.5;
/// Substeps of a step beyond which a machine is refused.
const MAX_SUBSTEPS: usize = 100;
/// Longest step of the plant, s: of its drives and of its sensors.
const LONGEST_STEP: f64 = 1e-3;
/// Poses in which the modes are evaluated.
const PLACES: usize = 40;
/// Tension at which cables are compared, N; it does not enter the modes.
const ANY_TENSION: f64 = 50.0;

impl ArmSpecimen {
    /// As designed: the body as described, sensors with noise and quantisation only, every cable as the
    /// calibrated one of the bench with the effects that its model does not have.
    ///
    /// The free cable at the anchor is as long as in the machine's start. As many substeps are taken as the
    /// stiffest mode of cables and bodies needs in poses over all ranges of the joints.
    ///
    /// # Errors
    /// [`Error::Part`] with the joint, or [`Error::OutOfDomain`] for its damping, where more than 100
    /// substeps in a millisecond would be needed.
    pub fn nominal(machine: &Machine) -> Result<Self, Error> {
        Self::nominal_at(machine, Resolution::default())
    }

    /// [`nominal`](Self::nominal) with cables of this many cells, and at least this many substeps of a
    /// millisecond.
    ///
    /// # Errors
    /// As there and as [`CablePlants::new`](crate::twin::cable::CablePlants::new).
    pub fn nominal_at(machine: &Machine, least: Resolution) -> Result<Self, Error> {
        least.validate()?;
        let mut model = MuscleDynamics::new(&machine.robot)?;
        model.evaluate(&machine.start)?;
        let places = model.lengths().iter().enumerate();
        let cables = machine.muscles.iter().zip(places).map(|(design, (muscle, free))| {
            let path = design.path(free.max(SHORTEST), model.wrap_angle(muscle))?;
            Ok(Specimen { path, parameters: design.cable, effects: Effects::default() })
        });
        let mut specimen = Self {
            robot: machine.robot.clone(),
            cables: cables.collect::<Result<_, Error>>()?,
            bends: machine.sheath_bends()?,
            drives: machine.muscles.iter().map(|design| design.drive).collect(),
            winches: alloc::vec![1.0; machine.muscles.len()],
            encoders: machine.encoders.clone(),
            period: machine.period,
            watchdog: machine.watchdog(),
            resolution: least,
        };
        specimen.resolution.substeps = specimen.stable_substeps(&mut model, &machine.poses(PLACES)?)?;
        Ok(specimen)
    }

    /// Step of drives and sensors, s: the period, or one of as few equal parts of it as are at most a
    /// millisecond.
    #[must_use]
    pub fn step(&self) -> f64 {
        self.period / parts_of(self.period, LONGEST_STEP) as f64
    }

    /// Substeps of a step in which the stiffest mode is stable.
    fn stable_substeps(&self, model: &mut MuscleDynamics, poses: &[Vec<f64>]) -> Result<usize, Error> {
        let (cells, step) = (self.resolution.cells, self.step());
        let law = |(muscle, cable): (usize, &Specimen)| {
            cable.law(cells).map_err(|error| error.of_part("muscle", muscle))
        };
        let laws = self.cables.iter().enumerate().map(law).collect::<Result<Vec<CableLaw>, _>>()?;
        let tensions = alloc::vec![ANY_TENSION; laws.len()];
        let found = Characteristics::new(model, &laws, &tensions, poses, 0.0)?;
        if found.stuck_mode * step / MAX_STEP_ANGLE > MAX_SUBSTEPS as f64 {
            let (kind, field) = ("joint", "the inertia that it moves");
            let expected = "larger for its cables, whose oscillation needs more than 100 steps per \
                millisecond: heavier links, an armature, softer cables or smaller moment arms";
            let joint = stiffest_joint(model.moment_arms(), &laws, &found);
            return Err(Error::Part { kind, index: self.robot.independent_joints()[joint], field, expected });
        }
        let needed = (found.stuck_mode * step / MAX_STEP_ANGLE)
            .max(found.damping_rate * step / MAX_DAMPING_STEP)
            .max(self.resolution.substeps as f64);
        let expected = "at most 100: less damping of the joints, or heavier links";
        crate::error::within(
            "damping of the machine, in steps per millisecond",
            expected,
            needed,
            needed <= 100.0,
        )?;
        Ok((libm::ceil(needed) as usize).min(MAX_SUBSTEPS))
    }

    /// A random specimen of a design within the machine's tolerances; the same seed gives the same specimen.
    ///
    /// # Errors
    /// As [`Robot::new`], where the drawn numbers are no valid robot, and as [`nominal`](Self::nominal).
    pub fn sampled_around(of: &Self, machine: &Machine, seed: u64) -> Result<Self, Error> {
        let tolerances = &machine.tolerances;
        let mut random = Random::new(seed);
        let mut within = |bound: f64| bound * (2.0 * random.unit() - 1.0);
        let mut drawn = of.clone();
        let mut parts = of.robot.parts().clone();
        for body in &mut parts.bodies {
            let factor = 1.0 + within(tolerances.mass);
            body.mass *= factor;
            // What holds it does not know of its own mass.
            body.gravity_compensation /= factor;
            let factor = 1.0 + within(tolerances.mass);
            body.inertia.iter_mut().for_each(|entry| *entry *= factor);
        }
        let attachment = machine.attachment_tolerance();
        for site in tendon_sites(&parts) {
            parts.sites[site].position.iter_mut().for_each(|x| *x += within(attachment));
        }
        let joints = of.robot.independent_joints();
        let slides = joints.iter().map(|joint| parts.joints[*joint].kind == JointKind::Slide);
        let slides: Vec<bool> = slides.collect();
        let deviation = Deviation::new(*tolerances, seed);
        deviation.of_parts(&mut parts);
        deviation.of_encoders(&mut drawn.encoders, joints.iter().map(|joint| parts.joints[*joint].kind));
        deviation.of_winches(&mut drawn.winches);
        deviation.of_gears(&mut drawn.drives);
        drawn.robot = deviation.loaded(Robot::new(parts)?, machine)?;
        for drive in &mut drawn.drives {
            let gain = drive.load_cell.gain * (1.0 + within(tolerances.gain));
            drive.load_cell = LoadCell { gain, ..drive.load_cell };
        }
        for (encoder, slide) in drawn.encoders.iter_mut().zip(slides) {
            let zero = within(if slide { tolerances.zero_slide } else { tolerances.zero });
            if let Some(encoder) = encoder {
                encoder.zero += zero;
            }
        }
        for cable in &mut drawn.cables {
            *cable = Specimen::sampled_around(cable, random.bits());
        }
        for bend in drawn.bends.iter_mut().filter(|bend| !bend.is_constant()) {
            *bend = bend.with_slopes(|| 1.0 + tolerances.bend * (2.0 * random.unit() - 1.0))?;
        }
        Ok(drawn)
    }

    /// [`nominal`](Self::nominal) with the machine's tolerances.
    ///
    /// # Errors
    /// As there and as [`sampled_around`](Self::sampled_around).
    pub fn draw(machine: &Machine, seed: u64) -> Result<Self, Error> {
        Self::sampled_around(&Self::nominal(machine)?, machine, seed)
    }

    /// The same machine with a point mass on a body.
    ///
    /// # Errors
    /// As [`Robot::with_payload`].
    pub fn with_payload(mut self, body: usize, position: [f64; 3], mass: f64) -> Result<Self, Error> {
        self.robot = self.robot.with_payload(body, position, mass)?;
        Ok(self)
    }
}

/// The joint with the largest stiffness of cables that stick over its inertia.
fn stiffest_joint(arms: &[f64], laws: &[CableLaw], found: &Characteristics) -> usize {
    let joints = found.joints.len();
    let stiffness = |j: usize| {
        let last = laws.iter().map(|law| law.compliance().last().copied().unwrap_or(f64::INFINITY));
        let arms = arms.iter().skip(j).step_by(joints);
        arms.zip(last).map(|(arm, compliance)| arm * arm / compliance).sum::<f64>() / found.joints[j].inertia
    };
    (0..joints).max_by(|a, b| stiffness(*a).total_cmp(&stiffness(*b))).unwrap_or(0)
}

/// Shortest free cable at an anchor, m.
const SHORTEST: f64 = 1e-3;

/// Sites of muscles and springs, each once.
fn tendon_sites(parts: &Parts) -> Vec<usize> {
    let elements = parts.tendons.iter().chain(&parts.springs).filter_map(|tendon| match &tendon.path {
        TendonPath::Spatial(elements) => Some(elements),
        TendonPath::Fixed(_) => None,
    });
    let mut sites: Vec<usize> = elements
        .flatten()
        .filter_map(|element| if let PathElement::Site(site) = element { Some(*site) } else { None })
        .collect();
    sites.sort_unstable();
    sites.dedup();
    sites
}
