use super::body::Limb;
use super::fault::{Failure, InjectedFault};
use super::sensors::ArmReading;
use super::specimen::ArmSpecimen;
use crate::Error;
use crate::drive::{Drive, DriveCommand, DriveStep, Quadrant};
use crate::error::within;
use crate::transmission::Sliding;
use crate::transmission::cable::EndMotion;
use crate::twin::cable::{CablePlants, CableReading, Resolution};
use alloc::vec;
use alloc::vec::Vec;

/// Most turn at a joint that a single node of a cable can stand for, rad.
const MOST_WRAP: f64 = 4.0;

/// An arm at work: true motion, true tensions, and what its sensors say of them.
///
/// # Example
/// ```
/// use sinew::body::Robot;
/// use sinew::drive::DriveCommand;
/// use sinew::twin::arm::{ArmSpecimen, ArmTwin};
/// let text = include_str!("../../../../../models/lm_arm.toml");
/// let parts = sinew::description::from_toml("lm_arm.toml", text).expect("a model of this repository").parts;
/// let robot = Robot::new(parts)?;
/// let pose = robot.key("start").unwrap_or_default();
/// let specimen = ArmSpecimen::draw(&robot, pose, 1)?;
/// let mut arm = ArmTwin::new(&specimen, pose, &[40.0; 15], 1)?;
/// for _ in 0..100 {
///     arm.step(&[DriveCommand::Velocity(0.0); 15], 1e-3)?;
/// }
/// // The winches hold still, and the cables' elasticity lets the arm sink a little.
/// assert!(arm.truth().q.iter().zip(pose).all(|(q, start)| (q - start).abs() < 0.2));
/// # Ok::<(), sinew::Error>(())
/// ```
#[derive(Debug, Clone)]
pub struct ArmTwin {
    specimen: ArmSpecimen,
    limb: Limb,
    cables: CablePlants,
    drives: Vec<Drive>,
    faults: Vec<InjectedFault>,
    time: f64,
    reading: ArmReading,
    /// Of every muscle: cable, drive, and what the step needs.
    felt: Vec<CableReading>,
    steps: Vec<DriveStep>,
    motions: Vec<EndMotion>,
    pull: Vec<f64>,
    before: Vec<f64>,
    bends: Vec<f64>,
}

/// What no controller knows.
#[derive(Debug, Clone, Copy)]
pub struct ArmTruth<'a> {
    /// Since the start, s.
    pub time: f64,
    /// `[joints]`, rad or m.
    pub q: &'a [f64],
    /// `[joints]`, per s.
    pub v: &'a [f64],
    /// From sheath end to anchor, m: `[muscles]`.
    pub lengths: &'a [f64],
    /// Tensions, stretch, work, breaks: `[muscles]`.
    pub cables: &'a [CableReading],
    /// Speed, work, faults: `[muscles]`.
    pub drives: &'a [DriveStep],
}

impl ArmTwin {
    /// An arm at rest in a pose, every cable as after a pull that left this tension at its anchor, N; `seed` is that
    /// of the sensors' noise. Where tensions and gravity do not balance, the arm starts to move.
    ///
    /// # Shapes
    /// `q: [joints]`, `tension_out: [muscles]`.
    ///
    /// # Errors
    /// [`Error::WrongLength`], and [`Error::OutOfDomain`] for a tension below a cable's pretension and whatever
    /// [`CablePlants::new`] and [`Drive::new`] refuse.
    pub fn new(specimen: &ArmSpecimen, q: &[f64], tension_out: &[f64], seed: u64) -> Result<Self, Error> {
        let limb = Limb::new(&specimen.robot, q)?;
        let (muscles, joints) = (limb.lengths().len(), q.len());
        for (name, expected, got) in [
            ("tension_out", muscles, tension_out.len()),
            ("cables", muscles, specimen.cables.len()),
            ("drives", muscles, specimen.drives.len()),
            ("encoders", joints, specimen.encoders.len()),
        ] {
            if got != expected {
                return Err(Error::WrongLength { name, expected, got });
            }
        }
        specimen.encoders.iter().try_for_each(|encoder| encoder.validate())?;
        specimen.resolution.validate()?;
        let finest = Resolution { substeps: 1, ..specimen.resolution };
        let drive = |(k, p): (usize, _)| Drive::new(p, seed.wrapping_mul(0x1_0000).wrapping_add(k as u64));
        let mut twin = Self {
            cables: CablePlants::new(&specimen.cables, finest)?,
            drives: specimen.drives.iter().copied().enumerate().map(drive).collect::<Result<_, _>>()?,
            faults: Vec::new(),
            time: 0.0,
            reading: ArmReading::new(muscles, joints),
            felt: vec![CableReading::default(); muscles],
            steps: vec![STANDING; muscles],
            motions: vec![EndMotion::default(); muscles],
            pull: tension_out.to_vec(),
            before: limb.lengths().to_vec(),
            bends: vec![0.0; muscles],
            limb,
            specimen: specimen.clone(),
        };
        twin.settle(tension_out)?;
        Ok(twin)
    }

    /// The same with what will fail.
    ///
    /// # Errors
    /// As [`InjectedFault::validate`].
    pub fn with_faults(mut self, faults: &[InjectedFault]) -> Result<Self, Error> {
        let (muscles, joints) = (self.drives.len(), self.limb.q.len());
        faults.iter().try_for_each(|fault| fault.validate(muscles, joints))?;
        self.faults = faults.to_vec();
        Ok(self)
    }

    /// Every drive obeys for `h` seconds, a millisecond in life.
    ///
    /// # Shapes
    /// `commands: [muscles]`; one that is not finite is none.
    ///
    /// # Errors
    /// [`Error::WrongLength`] and [`Error::OutOfDomain`] for `h` outside 10 us to 20 ms: nothing has then moved. Where the
    /// arm moves so fast that no cable could follow, the run is over.
    pub fn step(&mut self, commands: &[DriveCommand], h: f64) -> Result<ArmTruth<'_>, Error> {
        if commands.len() != self.drives.len() {
            return Err(Error::WrongLength {
                name: "commands",
                expected: self.drives.len(),
                got: commands.len(),
            });
        }
        let substeps = self.specimen.resolution.substeps as f64;
        within("h", "a number of seconds in [1e-5, 0.02]", h, (1e-5..=0.02).contains(&h))?;
        self.drive(commands, h);
        self.sense();
        for _ in 0..self.specimen.resolution.substeps {
            self.before.copy_from_slice(self.limb.lengths());
            self.limb.advance(h / substeps, &self.pull)?;
            let lengths = self.before.iter().zip(self.limb.lengths());
            for ((motion, drive), (before, now)) in self.motions.iter_mut().zip(&self.steps).zip(lengths) {
                *motion = EndMotion { motor: drive.moved / substeps, anchor: before - now };
            }
            self.cables.step(h / substeps, &self.motions, &mut self.felt)?;
            for (pull, felt) in self.pull.iter_mut().zip(&self.felt) {
                *pull = felt.tension_out;
            }
        }
        self.wrap()?;
        self.time += h;
        Ok(self.truth())
    }

    /// What the sensors said at the start of the last step: that is how old it is.
    #[must_use]
    pub fn reading(&self) -> &ArmReading {
        &self.reading
    }

    /// What no controller knows.
    #[must_use]
    pub fn truth(&self) -> ArmTruth<'_> {
        ArmTruth {
            time: self.time,
            q: &self.limb.q,
            v: &self.limb.v,
            lengths: self.limb.lengths(),
            cables: &self.felt,
            drives: &self.steps,
        }
    }

    /// What it is built of.
    #[must_use]
    pub fn specimen(&self) -> &ArmSpecimen {
        &self.specimen
    }

    /// Mechanical energy of body and cables, J: motion, height, elasticity, and what the constant force at every
    /// anchor has stored. Drives are not part of it.
    ///
    /// # Errors
    /// None that [`step`](Self::step) would not have found.
    pub fn energy(&mut self) -> Result<f64, Error> {
        let mut energy = self.limb.energy()?;
        for (k, length) in self.limb.lengths().iter().enumerate() {
            if self.felt[k].broken.is_none() {
                energy += self.cables.energy(k)? + self.specimen.cables[k].parameters.pretension * length;
            }
        }
        Ok(energy)
    }

    /// Lays every cable; what every sensor then says.
    fn settle(&mut self, tension_out: &[f64]) -> Result<(), Error> {
        self.wrap()?;
        for (k, &tension) in tension_out.iter().enumerate() {
            self.cables.settle(k, tension, Sliding::TowardMotor)?;
        }
        self.cables.step(1e-6, &self.motions, &mut self.felt)?;
        for (drive, felt) in self.drives.iter_mut().zip(&self.felt) {
            drive.settle(felt.tension_in);
        }
        self.sense();
        Ok(())
    }

    /// Drives, as far as they are not failing.
    fn drive(&mut self, commands: &[DriveCommand], h: f64) {
        for (k, (drive, &command)) in self.drives.iter_mut().zip(commands).enumerate() {
            let mut command = command;
            let mut jammed = false;
            for fault in self.faults.iter().filter(|fault| fault.is_active(self.time)) {
                match fault.failure {
                    Failure::Cable(muscle) if muscle == k => self.cables.snap(k),
                    Failure::Amplifier(muscle) if muscle == k => command = DriveCommand::Off,
                    Failure::Winch(muscle) if muscle == k => jammed = true,
                    _ => {}
                }
            }
            let tension = self.felt[k].tension_in;
            self.steps[k] = if jammed {
                drive.settle(tension);
                STANDING
            } else {
                drive.step(command, tension, h)
            };
        }
    }

    fn sense(&mut self) {
        let Self { time, drives, specimen, limb, faults, .. } = self;
        self.reading.update(*time, drives, &specimen.encoders, &limb.q, faults);
    }

    /// The posture turns every cable at its joint.
    fn wrap(&mut self) -> Result<(), Error> {
        self.limb.bends(&mut self.bends)?;
        for (k, bend) in self.bends.iter().enumerate() {
            let last = self.specimen.cables[k].path.pulleys().saturating_sub(1);
            self.cables.set_wrap(k, last, bend.min(MOST_WRAP))?;
        }
        Ok(())
    }
}

/// A drive that does nothing.
const STANDING: DriveStep = DriveStep {
    moved: 0.0,
    speed: 0.0,
    electrical: 0.0,
    heat: 0.0,
    to_air: 0.0,
    lost: 0.0,
    quadrant: Quadrant::First,
    fault: None,
};
