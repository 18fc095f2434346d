//! The bench of the paper (fig. 5): two drives back to back over one cable.

use super::cable::{CablePlant, CableReading, Resolution, Specimen};
use crate::Error;
use crate::drive::{Drive, DriveCommand, DriveFault, DriveParameters, DriveReading, DriveStep};
use crate::transmission::Sliding;
use crate::transmission::cable::EndMotion;

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
    muscle: Drive,
    load: Drive,
    cable: CablePlant,
    truth: CableReading,
    steps: [Option<DriveStep>; 2],
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
    /// A bench with a cable of this specimen and two equal drives; `seed` is that of the sensor noise.
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
        Ok(Self {
            muscle: Drive::new(drives, seed.wrapping_mul(2))?,
            load: Drive::new(drives, seed.wrapping_mul(2).wrapping_add(1))?,
            cable,
            truth,
            steps: [None; 2],
        })
    }

    /// Sets the cable to its steady state after a long pull with this tension at the load, N.
    ///
    /// # Errors
    /// As [`CablePlant::settle`].
    pub fn settle(&mut self, tension_out: f64) -> Result<(), Error> {
        self.cable.settle(tension_out, Sliding::TowardMotor)?;
        self.truth = self.cable.step(1e-6, EndMotion::default())?;
        self.muscle.settle(self.truth.tension_in);
        self.load.settle(self.truth.tension_out);
        Ok(())
    }

    /// Both drives execute their commands for `h` seconds.
    ///
    /// # Errors
    /// As [`CablePlant::step`].
    pub fn step(&mut self, muscle: DriveCommand, load: DriveCommand, h: f64) -> Result<CableReading, Error> {
        let near = self.muscle.step(muscle, self.truth.tension_in, h);
        let far = self.load.step(load, self.truth.tension_out, h);
        self.truth = self.cable.step(h, EndMotion { motor: near.moved, anchor: -far.moved })?;
        self.steps = [Some(near), Some(far)];
        Ok(self.truth)
    }

    /// Measurements at the start of the last step.
    #[must_use]
    pub fn reading(&self) -> BenchReading {
        BenchReading { muscle: self.muscle.reading(), load: self.load.reading() }
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
