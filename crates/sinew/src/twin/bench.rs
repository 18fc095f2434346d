//! The bench of the paper (fig. 5): two drives back to back over one cable.

use super::cable::{CablePlant, CablePlants, CableReading, Resolution, Specimen};
use crate::Error;
use crate::drive::{Drive, DriveCommand, DriveFault, DriveParameters, DriveReading, DriveStep};
use crate::transmission::Sliding;
use crate::transmission::cable::EndMotion;
use alloc::vec;
use alloc::vec::Vec;

/// Muscle's drive, cable in its sheath, load's drive.
///
/// ```text
/// muscle drive --T_in--> cable in its sheath --T_out--> load drive
/// ```
///
/// Positions count toward the muscle's drive: where the load winds in, the anchor moves away.
///
/// # Example
/// ```
/// use sinew::drive::{DriveCommand, DriveParameters};
/// use sinew::twin::bench::Bench;
/// use sinew::twin::cable::{Resolution, Specimen};
/// let mut bench = Bench::new(&Specimen::bench(), Resolution::default(), DriveParameters::mc_am(), 1)?;
/// bench.settle(60.0)?;
/// for _ in 0..500 {
///     let muscle = DriveCommand::Velocity(0.05);
///     let load = DriveCommand::Tension { tension: 60.0, feed: -0.05 };
///     bench.step(muscle, load, 1e-3)?;
/// }
/// // Pulled through the sheath: less than half arrives.
/// assert!(bench.truth().tension_out < 0.6 * bench.truth().tension_in);
/// # Ok::<(), sinew::Error>(())
/// ```
#[derive(Debug, Clone)]
pub struct Bench {
    drives: [Drive; 2],
    cable: CablePlant,
    truth: CableReading,
    steps: [Option<DriveStep>; 2],
}

/// The muscle's drive and the load's, which has a load cell whatever the muscle's has.
fn pair(drives: DriveParameters, seed: u64) -> Result<[Drive; 2], Error> {
    let seed = seed.wrapping_mul(2);
    let load = DriveParameters { has_load_cell: true, ..drives };
    Ok([Drive::new(drives, seed)?, Drive::new(load, seed.wrapping_add(1))?])
}

/// Both drives execute their commands against the tensions of the cable; what they do, and the motion of its
/// ends.
fn step_pair(
    drives: &mut [Drive; 2],
    commands: [DriveCommand; 2],
    cable: &CableReading,
    h: f64,
) -> ([DriveStep; 2], EndMotion) {
    let [muscle, load] = drives;
    let near = muscle.step(commands[0], cable.tension_in, h);
    let far = load.step(commands[1], cable.tension_out, h);
    ([near, far], EndMotion { motor: near.moved, anchor: -far.moved })
}

fn settle_pair(drives: &mut [Drive; 2], cable: &CableReading) {
    drives[0].settle(cable.tension_in);
    drives[1].settle(cable.tension_out);
}

fn read_pair([muscle, load]: &[Drive; 2]) -> BenchReading {
    BenchReading { muscle: muscle.reading(), load: load.reading() }
}

/// Measurements of the bench, with noise, quantisation and delay.
#[derive(Debug, Clone, Copy, PartialEq)]
pub struct BenchReading {
    /// The muscle's drive.
    pub muscle: DriveReading,
    /// The load's drive; its load cell is the far sensor.
    pub load: DriveReading,
}

impl BenchReading {
    /// Position of the anchor, m, + toward the muscle's drive.
    #[must_use]
    pub fn anchor(&self) -> f64 {
        -self.load.position
    }
}

impl Bench {
    /// A bench with a cable of this specimen and two equal drives, the load's always with a load cell;
    /// `seed` is that of the sensor noise.
    ///
    /// # Errors
    /// As [`CablePlant::new`] and [`Drive::new`].
    pub fn new(
        specimen: &Specimen,
        resolution: Resolution,
        drives: DriveParameters,
        seed: u64,
    ) -> Result<Self, Error> {
        let mut cable = CablePlant::new(specimen, resolution)?;
        let truth = cable.step(1e-6, EndMotion::default())?;
        Ok(Self { drives: pair(drives, seed)?, cable, truth, steps: [None; 2] })
    }

    /// Sets the cable to its steady state after a long pull with this tension at the load, N.
    ///
    /// # Errors
    /// As [`CablePlant::settle`].
    pub fn settle(&mut self, tension_out: f64) -> Result<(), Error> {
        self.cable.settle(tension_out, Sliding::TowardMotor)?;
        self.truth = self.cable.step(1e-6, EndMotion::default())?;
        settle_pair(&mut self.drives, &self.truth);
        Ok(())
    }

    /// Both drives execute their commands for `h` seconds.
    ///
    /// # Errors
    /// As [`CablePlant::step`].
    pub fn step(&mut self, muscle: DriveCommand, load: DriveCommand, h: f64) -> Result<CableReading, Error> {
        let (steps, motion) = step_pair(&mut self.drives, [muscle, load], &self.truth, h);
        self.truth = self.cable.step(h, motion)?;
        self.steps = steps.map(Some);
        Ok(self.truth)
    }

    /// Measurements at the start of the last step.
    #[must_use]
    pub fn reading(&self) -> BenchReading {
        read_pair(&self.drives)
    }

    /// True state of the cable.
    #[must_use]
    pub fn truth(&self) -> CableReading {
        self.truth
    }

    /// The muscle's and the load's drive in the last step.
    #[must_use]
    pub fn steps(&self) -> [Option<DriveStep>; 2] {
        self.steps
    }

    /// The fault that stopped a drive.
    #[must_use]
    pub fn fault(&self) -> Option<DriveFault> {
        self.steps.iter().flatten().find_map(|step| step.fault)
    }

    /// The cable, for an oracle.
    #[must_use]
    pub fn cable(&self) -> &CablePlant {
        &self.cable
    }

    /// Tension along the cable, N, muscle's end first.
    pub fn tensions(&self) -> impl ExactSizeIterator<Item = f64> + Clone {
        self.cable.tensions()
    }
}

/// Benches side by side, their cables in SIMD lanes of eight: bit for bit the same as as many [`Bench`]es.
#[derive(Debug, Clone)]
pub struct Benches {
    drives: Vec<[Drive; 2]>,
    cables: CablePlants,
    motions: Vec<EndMotion>,
    truth: Vec<CableReading>,
    steps: Vec<[Option<DriveStep>; 2]>,
}

impl Benches {
    /// One bench per entry, which is a specimen of its cable, the parameters of its two drives and the seed
    /// of the sensor noise.
    ///
    /// # Errors
    /// As [`CablePlants::new`] and [`Drive::new`].
    pub fn new(benches: &[(&Specimen, DriveParameters, u64)], resolution: Resolution) -> Result<Self, Error> {
        let specimens: Vec<Specimen> = benches.iter().map(|(specimen, ..)| (*specimen).clone()).collect();
        let mut benches = Self {
            drives: benches.iter().map(|(_, drives, seed)| pair(*drives, *seed)).collect::<Result<_, _>>()?,
            cables: CablePlants::new(&specimens, resolution)?,
            motions: vec![EndMotion::default(); benches.len()],
            truth: vec![CableReading::default(); benches.len()],
            steps: vec![[None; 2]; benches.len()],
        };
        benches.cables.step(1e-6, &benches.motions, &mut benches.truth)?;
        Ok(benches)
    }

    /// As [`Bench::settle`], with one tension at the load, N, per bench.
    ///
    /// # Errors
    /// [`Error::WrongLength`] for another number of tensions; as [`CablePlants::settle`].
    pub fn settle(&mut self, tensions_out: &[f64]) -> Result<(), Error> {
        let (expected, got) = (self.drives.len(), tensions_out.len());
        if got != expected {
            return Err(Error::WrongLength { name: "tensions_out", expected, got });
        }
        for (cable, tension) in tensions_out.iter().enumerate() {
            self.cables.settle(cable, *tension, Sliding::TowardMotor)?;
        }
        self.motions.fill(EndMotion::default());
        self.cables.step(1e-6, &self.motions, &mut self.truth)?;
        self.drives.iter_mut().zip(&self.truth).for_each(|(drives, cable)| settle_pair(drives, cable));
        Ok(())
    }

    /// The first benches execute their commands, of the muscle's and the load's drive, for `h` seconds; the
    /// ends of the other cables stand still.
    ///
    /// # Errors
    /// [`Error::WrongLength`] for more commands than benches; as [`CablePlants::step`].
    pub fn step(&mut self, commands: &[[DriveCommand; 2]], h: f64) -> Result<(), Error> {
        let (expected, got) = (self.drives.len(), commands.len());
        if got > expected {
            return Err(Error::WrongLength { name: "commands", expected, got });
        }
        self.motions.fill(EndMotion::default());
        for (k, commands) in commands.iter().enumerate() {
            let (steps, motion) = step_pair(&mut self.drives[k], *commands, &self.truth[k], h);
            (self.steps[k], self.motions[k]) = (steps.map(Some), motion);
        }
        self.cables.step(h, &self.motions, &mut self.truth)
    }

    /// As [`Bench::reading`], of every bench.
    pub fn readings(&self) -> impl ExactSizeIterator<Item = BenchReading> {
        self.drives.iter().map(read_pair)
    }

    /// As [`Bench::truth`], of every bench.
    #[must_use]
    pub fn truth(&self) -> &[CableReading] {
        &self.truth
    }

    /// As [`Bench::fault`], of every bench.
    pub fn faults(&self) -> impl ExactSizeIterator<Item = Option<DriveFault>> {
        self.steps.iter().map(|steps| steps.iter().flatten().find_map(|step| step.fault))
    }
}

#[cfg(test)]
mod tests {
    use super::*;

    #[test]
    fn benches_side_by_side_are_those_alone_to_the_bit() {
        let specimens = [Specimen::bench(), Specimen::draw(1), Specimen::draw(2)];
        let (resolution, drives) = (Resolution::default(), DriveParameters::mc_am());
        let entries: Vec<_> =
            specimens.iter().zip(7..).map(|(specimen, seed)| (specimen, drives, seed)).collect();
        let mut together = Benches::new(&entries, resolution).unwrap();
        together.settle(&[60.0, 80.0, 40.0]).unwrap();
        let alone = |(specimen, drives, seed): &(&Specimen, DriveParameters, u64)| {
            Bench::new(specimen, resolution, *drives, *seed).unwrap()
        };
        let mut alone: Vec<Bench> = entries.iter().map(alone).collect();
        alone.iter_mut().zip([60.0, 80.0, 40.0]).for_each(|(bench, tension)| bench.settle(tension).unwrap());
        for k in 0..400 {
            // The last bench ends before the others.
            let active = if k < 250 { 3 } else { 2 };
            let speed = if k % 200 < 100 { 0.05 } else { -0.05 };
            let load = DriveCommand::Tension { tension: 60.0, feed: -speed };
            together.step(&[[DriveCommand::Velocity(speed), load]; 3][..active], 1e-3).unwrap();
            for (i, bench) in alone.iter_mut().enumerate().take(active) {
                assert_eq!(
                    bench.step(DriveCommand::Velocity(speed), load, 1e-3).unwrap(),
                    together.truth()[i]
                );
                assert_eq!(together.readings().nth(i), Some(bench.reading()));
                assert_eq!(together.faults().nth(i), Some(bench.fault()));
            }
        }
        assert!(
            together.step(&[[DriveCommand::Brake; 2]; 4], 1e-3).is_err() && together.settle(&[1.0]).is_err()
        );
    }
}
