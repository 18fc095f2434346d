use crate::Error;
use crate::body::{Parts, PathElement, Robot, TendonPath};
use crate::drive::{DriveParameters, Encoder, LoadCell};
use crate::muscle::{Geometry, Muscles};
use crate::random::Random;
use crate::transmission::cable::{CableParameters, CablePath, Segment};
use crate::twin::cable::{Resolution, Specimen};
use alloc::vec;
use alloc::vec::Vec;

/// Parameters of an arm as built; the controller does not have them.
#[derive(Debug, Clone, PartialEq)]
pub struct ArmSpecimen {
    /// Bodies and tendon paths.
    pub robot: Robot,
    /// Cable of every muscle, drive to anchor; its last pulley is the wrap at the joint.
    pub cables: Vec<Specimen>,
    /// Drive of every muscle, with the load cell of the muscle.
    pub drives: Vec<DriveParameters>,
    /// Encoder of every joint.
    pub encoders: Vec<Encoder>,
    /// Cells of the cables; substeps of cables and bodies.
    pub resolution: Resolution,
}

/// Manufacturing tolerances: bounds of the difference between an arm as built and its design.
///
/// Every number is uniform within its bounds; cables scatter as in [`Specimen::drawn_around`].
#[derive(Debug, Clone, Copy, PartialEq)]
pub struct Scatter {
    /// Relative, of every mass and, independently, of every inertia.
    pub mass: f64,
    /// Of every coordinate of every site of a tendon, m.
    pub attachment: f64,
    /// Relative, of the load cells' gain.
    pub gain: f64,
    /// Of the joint encoders' zero, rad.
    pub zero: f64,
}

impl Default for Scatter {
    /// 10 %, 1 mm, 0.5 %, 1 mrad: assumed for careful manufacturing.
    fn default() -> Self {
        Self { mass: 0.1, attachment: 1e-3, gain: 5e-3, zero: 1e-3 }
    }
}

/// Cable between winch and sheath, m; assumed.
const NEAR: f64 = 0.05;

/// Counts of a joint's encoder: 14 bits.
const JOINT_COUNTS: f64 = 16_384.0;

/// Length of the bench's sheath, to which its drag belongs, m.
const BENCH_SHEATH: f64 = 0.806;

impl ArmSpecimen {
    /// As designed: the robot as described, the bench's cable in the sheath of every muscle, sensors with
    /// noise and quantisation only.
    ///
    /// Friction and compliance are the bench's; the drag is proportional to the length of the sheath. The
    /// free cable at the anchor is as long as in `pose`, the one at the winch 50 mm (assumed).
    ///
    /// The drive is [`DriveParameters::mc_am`]: 81 kg reflected to the cable, 287 N continuous; at 250 N its
    /// peak current accelerates by 9.7 m/s^2, and its reference is limited to 5. Sensors are sampled at the
    /// start of a step and available at its end: that is their delay.
    ///
    /// # Errors
    /// [`Error::Part`] names a muscle without a sheath; [`Error::WrongLength`] where `pose` is another
    /// robot's.
    pub fn nominal(robot: &Robot, pose: &[f64]) -> Result<Self, Error> {
        let muscles = Muscles::new(robot);
        let mut geometry = Geometry::new(robot, &muscles);
        let mut bends = vec![0.0; muscles.count()];
        muscles.evaluate(pose, &mut geometry)?;
        muscles.bends(&geometry, &mut bends)?;
        let each = geometry.lengths().iter().zip(&bends).enumerate();
        let cables = each.map(|(k, (&free, &wrap))| cable(robot.parts(), k, free, wrap));
        let drive = DriveParameters { delay_steps: 0.0, ..DriveParameters::mc_am() };
        Ok(Self {
            robot: robot.clone(),
            cables: cables.collect::<Result<_, _>>()?,
            drives: vec![drive; muscles.count()],
            encoders: vec![Encoder { counts: JOINT_COUNTS, zero: 0.0 }; robot.nv()],
            resolution: Resolution::default(),
        })
    }

    /// A random specimen of a design; the same seed gives the same specimen.
    ///
    /// # Errors
    /// As [`Robot::new`], where the drawn numbers are no valid robot.
    pub fn drawn_around(of: &Self, scatter: &Scatter, seed: u64) -> Result<Self, Error> {
        let mut random = Random::new(seed);
        let mut within = |bound: f64| bound * (2.0 * random.unit() - 1.0);
        let mut drawn = of.clone();
        let mut parts = of.robot.parts().clone();
        for body in &mut parts.bodies {
            body.mass *= 1.0 + within(scatter.mass);
            let factor = 1.0 + within(scatter.mass);
            body.inertia.iter_mut().for_each(|entry| *entry *= factor);
        }
        for site in tendon_sites(&parts) {
            parts.sites[site].position.iter_mut().for_each(|x| *x += within(scatter.attachment));
        }
        drawn.robot = Robot::new(parts)?;
        for drive in &mut drawn.drives {
            drive.load_cell =
                LoadCell { gain: drive.load_cell.gain * (1.0 + within(scatter.gain)), ..drive.load_cell };
        }
        for encoder in &mut drawn.encoders {
            encoder.zero += within(scatter.zero);
        }
        for cable in &mut drawn.cables {
            *cable = Specimen::drawn_around(cable, random.bits());
        }
        Ok(drawn)
    }

    /// [`nominal`](Self::nominal) with the default scatter.
    ///
    /// # Errors
    /// As there and as [`drawn_around`](Self::drawn_around).
    pub fn draw(robot: &Robot, pose: &[f64], seed: u64) -> Result<Self, Error> {
        Self::drawn_around(&Self::nominal(robot, pose)?, &Scatter::default(), seed)
    }

    /// The same arm with a point mass on a body.
    ///
    /// # Errors
    /// As [`Robot::with_payload`].
    pub fn with_payload(mut self, body: usize, position: [f64; 3], mass: f64) -> Result<Self, Error> {
        self.robot = self.robot.with_payload(body, position, mass)?;
        Ok(self)
    }
}

/// The bench's cable in the sheath of a muscle.
fn cable(parts: &Parts, muscle: usize, free: f64, wrap: f64) -> Result<Specimen, Error> {
    let tendon = &parts.tendons[muscle];
    let Some(sheath) = &tendon.sheath else {
        let expected = "given by its length and bend";
        return Err(Error::Part { kind: "muscle", index: muscle, field: "its sheath", expected });
    };
    let path = CablePath::new(vec![
        Segment::Free { length: NEAR },
        Segment::Sheath { length: sheath.length, bend: sheath.bend, curvature: vec![] },
        Segment::Pulley { wrap },
        Segment::Free { length: free },
    ])?;
    let bench = CableParameters::bench();
    let parameters = CableParameters { drag: bench.drag * sheath.length / BENCH_SHEATH, ..bench };
    Ok(Specimen { path, parameters, ..Specimen::bench() })
}

/// Sites of tendons, each once.
fn tendon_sites(parts: &Parts) -> Vec<usize> {
    let elements = parts.tendons.iter().filter_map(|tendon| match &tendon.path {
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
