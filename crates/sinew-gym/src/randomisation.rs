use crate::settings::within;
use sinew::Error;
use sinew::body::Robot;
use sinew::machine::Machine;
use sinew::random::Random;
use sinew::transmission::cable::{CablePath, Segment};
use sinew::twin::arm::ArmSpecimen;

/// How the machine of an episode differs from the design. Each is sampled evenly between two bounds, once for
/// the whole machine.
#[derive(Debug, Clone, PartialEq)]
pub struct Randomisation {
    /// Whether every part is also sampled within the machine's own tolerances, part by part.
    pub tolerances: bool,
    /// Factor on the coefficient of friction of all cables, >= 0; 0 and 0: cables without friction, whose
    /// drag, loss at the first node and friction at creeping speed are left out as well.
    pub friction: [f64; 2],
    /// Factor on the bend of all sheaths, >= 0.
    pub bend: [f64; 2],
    /// Factor on masses and inertias of all bodies, > 0.
    pub mass: [f64; 2],
    /// Delay of all sensors beside that of the design, ms, 0 to 100.
    pub delay_ms: [f64; 2],
}

impl Default for Randomisation {
    /// The machine's tolerances; friction, bends and masses by a tenth to a fifth; up to 5 ms.
    fn default() -> Self {
        Self {
            tolerances: true,
            friction: [0.8, 1.2],
            bend: [0.9, 1.1],
            mass: [0.9, 1.1],
            delay_ms: [0.0, 5.0],
        }
    }
}

/// One draw of the factors.
#[derive(Debug, Clone, Copy, PartialEq)]
pub(crate) struct Sampled {
    pub(crate) friction: f64,
    bend: f64,
    mass: f64,
    /// Whole milliseconds and parts of them.
    pub(crate) delay_ms: f64,
    tolerances: Option<u64>,
}

impl Randomisation {
    /// The machine as designed, in every episode.
    #[must_use]
    pub fn none() -> Self {
        let one = [1.0, 1.0];
        Self { tolerances: false, friction: one, bend: one, mass: one, delay_ms: [0.0, 0.0] }
    }

    /// Checks every number.
    ///
    /// # Errors
    /// [`Error::OutOfDomain`] names the one outside its domain.
    pub fn validate(&self) -> Result<(), Error> {
        let factor = "two finite factors, 0 or more, the second not below the first, at most 10";
        let positive = "two factors from 0.01 to 10, the second not below the first";
        let delay = "two numbers of milliseconds from 0 to 100, the second not below the first";
        for (name, expected, [low, high], least, most) in [
            ("friction", factor, self.friction, 0.0, 10.0),
            ("bend", factor, self.bend, 0.0, 10.0),
            ("mass", positive, self.mass, 0.01, 10.0),
            ("delay_ms", delay, self.delay_ms, 0.0, 100.0),
        ] {
            within(name, expected, low, (least..=most).contains(&low))?;
            within(name, expected, high, (low..=most).contains(&high))?;
        }
        Ok(())
    }

    /// Draws all numbers, whether they differ or not: settling one of them changes no other.
    pub(crate) fn draw(&self, random: &mut Random) -> Sampled {
        let mut between = |[low, high]: [f64; 2]| low + random.unit() * (high - low);
        let (friction, bend) = (between(self.friction), between(self.bend));
        let (mass, delay_ms) = (between(self.mass), between(self.delay_ms));
        let seed = random.bits();
        Sampled { friction, bend, mass, delay_ms, tolerances: self.tolerances.then_some(seed) }
    }
}

impl Sampled {
    /// The specimen with these numbers.
    ///
    /// # Errors
    /// As [`ArmSpecimen::sampled_around`] and [`CablePath::new`].
    pub(crate) fn specimen(&self, design: &ArmSpecimen, machine: &Machine) -> Result<ArmSpecimen, Error> {
        let mut specimen = match self.tolerances {
            Some(seed) => ArmSpecimen::sampled_around(design, machine, seed)?,
            None => design.clone(),
        };
        if changes(self.mass) {
            let mut parts = specimen.robot.parts().clone();
            for body in &mut parts.bodies {
                body.mass *= self.mass;
                body.inertia.iter_mut().for_each(|entry| *entry *= self.mass);
            }
            specimen.robot = Robot::new(parts)?;
        }
        for cable in &mut specimen.cables {
            cable.parameters.friction *= self.friction;
            if self.friction <= 0.0 {
                cable.parameters.drag = 0.0;
                cable.parameters.efficiency = 1.0;
                cable.effects.slow = None;
                cable.effects.heat = None;
            }
            if changes(self.bend) {
                let mut segments = cable.path.segments().to_vec();
                for segment in &mut segments {
                    if let Segment::Sheath { bend, .. } = segment {
                        *bend *= self.bend;
                    }
                }
                cable.path = CablePath::new(segments)?;
            }
        }
        if changes(self.bend) {
            for bend in &mut specimen.bends {
                *bend = bend.scaled_to(self.bend * bend.at(&machine.start))?;
            }
        }
        for drive in &mut specimen.drives {
            drive.delay_ms += self.delay_ms;
        }
        Ok(specimen)
    }
}

/// Whether a factor is not exactly 1.
fn changes(factor: f64) -> bool {
    (factor - 1.0).abs() > 0.0
}
