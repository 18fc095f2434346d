use super::body::Limb;
use super::fault::{ExchangeFailure, Failure, InjectedFault, Worn};
use super::sensors::ArmReading;
use super::specimen::ArmSpecimen;
use crate::Error;
use crate::drive::{Drive, DriveBatch, DriveCommand, DriveStep};
use crate::error::{check_entries, check_length, within};
use crate::machine::parts_of;
use crate::transmission::cable::EndMotion;
use crate::transmission::{SheathBend, Sliding};
use crate::twin::cable::{CablePlants, CableReading, Resolution};
use alloc::vec;
use alloc::vec::Vec;

/// Largest wrap at a joint that one node of a cable represents, rad.
const MAX_WRAP: f64 = 4.0;

/// A simulated arm: true motion, true tensions and measurements.
///
/// # Example
/// ```
/// use sinew::body::Robot;
/// use sinew::drive::DriveCommand;
/// use sinew::machine::Machine;
/// use sinew::twin::arm::{ArmSpecimen, ArmTwin};
/// let text = sinew_models::LM_ARM;
/// let parts = sinew::description::from_toml("lm_arm.toml", text).expect("a model of this repository").parts;
/// let machine = Machine::from_robot(&Robot::new(parts)?)?;
/// let specimen = ArmSpecimen::draw(&machine, 1)?;
/// let mut arm = ArmTwin::new(&specimen, &machine.start, &[40.0; 15], 1)?;
/// for _ in 0..100 {
///     arm.step(&[DriveCommand::Velocity(0.0); 15], 1e-3)?;
/// }
/// // The winches are held; the arm sinks a little by the elasticity of the cables.
/// assert!(arm.truth().q.iter().zip(&machine.start).all(|(q, start)| (q - start).abs() < 0.2));
/// # Ok::<(), sinew::Error>(())
/// ```
#[derive(Debug, Clone)]
pub struct ArmTwin {
    pub(super) specimen: ArmSpecimen,
    pub(super) limb: Limb,
    cables: CablePlants,
    /// The pulley of every cable whose wrap is that at its joint: the last.
    wraps: Vec<usize>,
    /// Sheaths whose bend depends on the pose, with their muscles.
    bends: Vec<(usize, SheathBend)>,
    drives: DriveBatch,
    faults: Vec<InjectedFault>,
    /// Longest step of drives and sensors, s.
    pub(super) step: f64,
    time: f64,
    reading: ArmReading,
    // Of every muscle.
    cable_readings: Vec<CableReading>,
    steps: Vec<DriveStep>,
    /// All steps of the last period together.
    moved: Vec<DriveStep>,
    motions: Vec<EndMotion>,
    pub(super) anchor_tension: Vec<f64>,
    lengths_before: Vec<f64>,
}

/// True state of the arm.
#[derive(Debug, Clone, Copy)]
pub struct ArmTruth<'a> {
    /// Since the start, s.
    pub time: f64,
    /// Coordinates of the independent joints, rad or m: `[joints]`.
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
    /// An arm at rest in a pose, every cable in its steady state after a pull with this tension at its
    /// anchor, N; `seed` is that of the sensor noise. Where tensions and gravity are not in equilibrium, the
    /// arm starts to move.
    ///
    /// # Shapes
    /// `q: [joints]`, the independent ones; `tension_out: [muscles]`.
    ///
    /// # Errors
    /// [`Error::WrongLength`], and [`Error::OutOfDomain`] for a tension below a cable's pretension and
    /// whatever [`CablePlants::new`] and [`Drive::new`] refuse.
    pub fn new(specimen: &ArmSpecimen, q: &[f64], tension_out: &[f64], seed: u64) -> Result<Self, Error> {
        let step = specimen.step();
        let limb = Limb::new(&specimen.robot, q, step / specimen.resolution.substeps as f64)?;
        let (muscles, joints) = (limb.lengths.len(), q.len());
        for (name, expected, got) in [
            ("tension_out", muscles, tension_out.len()),
            ("cables", muscles, specimen.cables.len()),
            ("bends", muscles, specimen.bends.len()),
            ("drives", muscles, specimen.drives.len()),
            ("winches", muscles, specimen.winches.len()),
            ("encoders", joints, specimen.encoders.len()),
        ] {
            if got != expected {
                return Err(Error::WrongLength { name, expected, got });
            }
        }
        specimen.encoders.iter().flatten().try_for_each(|encoder| encoder.validate())?;
        specimen.resolution.validate()?;
        let finest = Resolution { substeps: 1, ..specimen.resolution };
        let drive =
            |(k, p): (usize, _)| Drive::in_steps(p, seed.wrapping_mul(0x1_0000).wrapping_add(k as u64), step);
        let mut drives: Vec<Drive> =
            specimen.drives.iter().copied().enumerate().map(drive).collect::<Result<_, _>>()?;
        let mut twin = Self {
            cables: CablePlants::new(&specimen.cables, finest)?,
            wraps: specimen.cables.iter().map(|cable| cable.path.pulleys().saturating_sub(1)).collect(),
            drives: DriveBatch::new(&drives),
            bends: specimen
                .bends
                .iter()
                .cloned()
                .enumerate()
                .filter(|(_, bend)| !bend.is_constant())
                .collect(),
            faults: Vec::new(),
            step,
            time: 0.0,
            reading: ArmReading::new(muscles, joints),
            cable_readings: vec![CableReading::default(); muscles],
            steps: vec![DriveStep::STANDING; muscles],
            moved: vec![DriveStep::STANDING; muscles],
            motions: vec![EndMotion::default(); muscles],
            anchor_tension: tension_out.to_vec(),
            lengths_before: limb.lengths.clone(),
            limb,
            specimen: specimen.clone(),
        };
        twin.settle(tension_out, &mut drives)?;
        Ok(twin)
    }

    /// The same with injected faults.
    ///
    /// # Errors
    /// As [`InjectedFault::validate`].
    pub fn with_faults(mut self, faults: &[InjectedFault]) -> Result<Self, Error> {
        let (muscles, joints) = (self.steps.len(), self.limb.q().len());
        faults.iter().try_for_each(|fault| fault.validate(muscles, joints))?;
        self.faults = faults.to_vec();
        Ok(self)
    }

    /// The same with these velocities of the independent joints, per s: `[joints]`.
    ///
    /// # Errors
    /// [`Error::WrongLength`], and [`Error::EntryOutOfDomain`] where a velocity is not finite.
    pub fn with_velocities(mut self, v: &[f64]) -> Result<Self, Error> {
        check_entries("velocities", v, self.limb.v().len())?;
        self.limb.set_velocities(v);
        Ok(self)
    }

    /// All drives execute their commands for `h` seconds, usually a period: in as few equal steps as are at
    /// most [`ArmSpecimen::step`]. Measurements are those at the beginning of the last one.
    ///
    /// # Shapes
    /// `commands: [muscles]`; one that is not finite counts as [`DriveCommand::Off`].
    ///
    /// # Errors
    /// [`Error::WrongLength`] and [`Error::OutOfDomain`] for `h` outside 10 us to 20 ms: the state is then
    /// unchanged. An error of the cables, whose ends moved too fast, ends the run.
    pub fn step(&mut self, commands: &[DriveCommand], h: f64) -> Result<ArmTruth<'_>, Error> {
        let (parts, step) = self.parts_of(commands, h)?;
        for part in 0..parts {
            self.begin(commands, step)?;
            let substeps = self.specimen.resolution.substeps;
            for _ in 0..substeps {
                self.limb.advance(step / substeps as f64, &self.anchor_tension)?;
                self.pull(step)?;
            }
            self.limb.update_bends();
            self.finish(part, step)?;
        }
        Ok(self.truth())
    }

    /// Whether [`step`](Self::step) takes these commands and this time.
    ///
    /// # Errors
    /// [`Error::WrongLength`] and [`Error::OutOfDomain`] as there.
    pub fn check_step(&self, commands: &[DriveCommand], h: f64) -> Result<(), Error> {
        check_length("commands", commands.len(), self.steps.len())?;
        within("h", "a number of seconds in [1e-5, 0.02]", h, (1e-5..=0.02).contains(&h)).map(drop)
    }

    /// Number and length, s, of the steps of drives and sensors in `h` s.
    pub(super) fn parts_of(&self, commands: &[DriveCommand], h: f64) -> Result<(usize, f64), Error> {
        self.check_step(commands, h)?;
        let parts = parts_of(h, self.step);
        Ok((parts, h / parts as f64))
    }

    /// One step of drives and sensors up to the motion of the limb.
    pub(super) fn begin(&mut self, commands: &[DriveCommand], h: f64) -> Result<(), Error> {
        self.step_drives(commands, h);
        self.measure();
        self.push();
        self.soften_worn_cables()
    }

    /// One substep of the cables, after that of the limb.
    pub(super) fn pull(&mut self, h: f64) -> Result<(), Error> {
        let substeps = self.specimen.resolution.substeps as f64;
        let lengths = self.lengths_before.iter().zip(&self.limb.lengths);
        for ((motion, drive), (before, now)) in self.motions.iter_mut().zip(&self.steps).zip(lengths) {
            *motion = EndMotion { motor: drive.moved / substeps, anchor: before - now };
        }
        self.lengths_before.copy_from_slice(&self.limb.lengths);
        self.cables.step(h / substeps, &self.motions, &mut self.cable_readings)?;
        self.lose_pretension();
        for (tension, cable) in self.anchor_tension.iter_mut().zip(&self.cable_readings) {
            *tension = cable.tension_out;
        }
        Ok(())
    }

    /// The end of a step of drives and sensors, the `part`th of a period.
    pub(super) fn finish(&mut self, part: usize, h: f64) -> Result<(), Error> {
        self.update_angles()?;
        self.time += h;
        for (sum, next) in self.moved.iter_mut().zip(&self.steps) {
            *sum = if part == 0 { *next } else { sum.followed_by(*next, (part + 1) as f64 * h) };
        }
        Ok(())
    }

    /// What is wrong with the exchange at the beginning of the next step.
    #[must_use]
    pub fn exchange_failure(&self) -> Option<ExchangeFailure> {
        self.faults.iter().find_map(|fault| match fault.failure {
            Failure::Exchange(failure) if fault.is_active(self.time) => Some(failure),
            _ => None,
        })
    }

    /// Measurements at the start of the last step.
    #[must_use]
    pub fn reading(&self) -> &ArmReading {
        &self.reading
    }

    /// True state of the arm.
    #[must_use]
    pub fn truth(&self) -> ArmTruth<'_> {
        ArmTruth {
            time: self.time,
            q: self.limb.q(),
            v: self.limb.v(),
            lengths: &self.limb.lengths,
            cables: &self.cable_readings,
            drives: &self.moved,
        }
    }

    /// Tension along one cable, N, drive end first.
    ///
    /// # Errors
    /// [`Error::OutOfDomain`] for an index out of range.
    pub fn cable_tensions(&self, muscle: usize) -> Result<impl Iterator<Item = f64>, Error> {
        self.cables.tensions(muscle)
    }

    /// Temperature of the winding of one drive, degrees Celsius; NaN for an index out of range.
    #[must_use]
    pub fn winding(&self, muscle: usize) -> f64 {
        self.drives.winding(muscle)
    }

    /// Its parameters.
    #[must_use]
    pub fn specimen(&self) -> &ArmSpecimen {
        &self.specimen
    }

    /// Stops of the independent joints, springs with dampers: where they begin below and above, rad or m,
    /// stiffness, Nm/rad or N/m, and damping, Nm s/rad or N s/m; infinite ends are none.
    pub fn stops(&self) -> impl Iterator<Item = [f64; 4]> {
        self.limb.stops()
    }

    /// What was injected.
    #[must_use]
    pub fn faults(&self) -> &[InjectedFault] {
        &self.faults
    }

    /// Mechanical energy of bodies and cables, J: kinetic, potential, elastic, and that of the constant force
    /// at every anchor, without the drives.
    ///
    /// # Errors
    /// None after a successful [`step`](Self::step).
    pub fn energy(&mut self) -> Result<f64, Error> {
        let mut energy = self.limb.energy()?;
        for (k, length) in self.limb.lengths.iter().enumerate() {
            if self.cable_readings[k].broken.is_none() {
                energy += self.cables.energy(k)? + self.specimen.cables[k].parameters.pretension * length;
            }
        }
        Ok(energy)
    }

    /// Sets every cable and every one of its drives to their steady state and updates the measurements.
    fn settle(&mut self, tension_out: &[f64], drives: &mut [Drive]) -> Result<(), Error> {
        self.update_angles()?;
        for (k, &tension) in tension_out.iter().enumerate() {
            self.cables.settle(k, tension, Sliding::TowardMotor)?;
        }
        self.cables.step(1e-6, &self.motions, &mut self.cable_readings)?;
        for (drive, cable) in drives.iter_mut().zip(&self.cable_readings) {
            drive.settle(cable.tension_in);
        }
        self.drives = DriveBatch::new(drives);
        self.measure();
        Ok(())
    }

    /// Advances the drives, subject to injected faults.
    fn step_drives(&mut self, commands: &[DriveCommand], h: f64) {
        let Self { drives, cables, faults, specimen, cable_readings, steps, time, .. } = self;
        let of = |k: usize| {
            let mut command = commands[k];
            for fault in faults.iter().filter(|fault| fault.is_active(*time)) {
                match fault.failure {
                    Failure::Cable(muscle) if muscle == k => cables.snap(k),
                    // A jammed winch stands whatever else has failed.
                    Failure::Amplifier(muscle) if muscle == k && command != DriveCommand::Brake => {
                        command = DriveCommand::Off;
                    }
                    Failure::Winch(muscle) if muscle == k => command = DriveCommand::Brake,
                    _ => {}
                }
            }
            // Drive and encoder count with the radius of the design.
            let ratio = specimen.winches[k];
            let command = match command {
                DriveCommand::Velocity(speed) => DriveCommand::Velocity(ratio * speed),
                DriveCommand::Tension { tension, feed } => {
                    DriveCommand::Tension { tension, feed: ratio * feed }
                }
                other => other,
            };
            (command, cable_readings[k].tension_in)
        };
        drives.step(of, h, steps);
    }

    /// Forces from outside.
    fn push(&mut self) {
        let push = self.limb.push();
        push.fill(0.0);
        for fault in self.faults.iter().filter(|fault| fault.is_active(self.time)) {
            if let Failure::Push { joint, torque } = fault.failure {
                push[joint] += torque;
            }
        }
    }

    /// Fraction by which a part of a cable is worn.
    fn wear(&self, muscle: usize, part: Worn) -> f64 {
        self.faults.iter().map(|fault| fault.wear(muscle, part, self.time)).sum()
    }

    /// Cables of which strands have broken are softer.
    fn soften_worn_cables(&mut self) -> Result<(), Error> {
        for fault in &self.faults {
            if let Failure::Wear { muscle, what: Worn::Stiffness, .. } = fault.failure {
                self.cables.scale_compliance(muscle, 1.0 + self.wear(muscle, Worn::Stiffness))?;
            }
        }
        Ok(())
    }

    /// Anchors lose a part of the constant force in parallel.
    fn lose_pretension(&mut self) {
        if self.faults.is_empty() {
            return;
        }
        for k in 0..self.cable_readings.len() {
            let lost = self.wear(k, Worn::Pretension) * self.specimen.cables[k].parameters.pretension;
            let tension = &mut self.cable_readings[k].tension_out;
            *tension = (*tension - lost).max(0.0);
        }
    }

    fn measure(&mut self) {
        let Self { time, drives, specimen, limb, faults, .. } = self;
        self.reading.update(*time, drives, specimen, limb.q(), faults);
    }

    /// Sets the wrap of every cable at its joint, and the bend of the sheaths that pass joints, from the
    /// pose.
    fn update_angles(&mut self) -> Result<(), Error> {
        for (k, (pulley, bend)) in self.wraps.iter().zip(&self.limb.bends).enumerate() {
            self.cables.set_wrap(k, *pulley, bend.min(MAX_WRAP))?;
        }
        for (k, bend) in &self.bends {
            self.cables.set_sheath_bend(*k, bend.at(self.limb.q()))?;
        }
        let worn = |fault: &InjectedFault| match fault.failure {
            Failure::Wear { muscle, what: Worn::Friction, .. } => Some(muscle),
            _ => None,
        };
        for muscle in self.faults.iter().filter_map(worn) {
            // More of the friction angle: as by a larger bend of the sheath, which counts for the pulley as
            // well.
            let fraction = self.wear(muscle, Worn::Friction);
            let own = self.bends.iter().find(|(k, _)| *k == muscle).map(|(_, bend)| bend.at(self.limb.q()));
            let sheath = own.unwrap_or(self.specimen.cables[muscle].path.sheath_bend());
            let all = sheath + self.limb.bends[muscle].min(MAX_WRAP);
            self.cables.set_sheath_bend(muscle, sheath + fraction * all)?;
        }
        Ok(())
    }
}
