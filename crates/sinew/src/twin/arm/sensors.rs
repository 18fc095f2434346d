use super::fault::{Failure, InjectedFault, Sensor};
use super::specimen::ArmSpecimen;
use crate::drive::DriveBatch;
use crate::random::Random;
use alloc::vec;
use alloc::vec::Vec;

/// Measurements of the arm, with quantisation, noise, calibration errors and injected faults; may hold NaN.
///
/// The state at the start of a step is measured. The sensors of a drive may delay it further
/// (`DriveParameters::delay_ms`), the joint encoders do not.
#[derive(Debug, Clone, PartialEq)]
pub struct ArmReading {
    /// Position of every cable by its motor's encoder, m, + toward the motor: `[muscles]`.
    pub motor: Vec<f64>,
    /// Tension at every drive's outlet, N: `[muscles]`.
    pub tension: Vec<f64>,
    /// Current of every motor, A: `[muscles]`.
    pub current: Vec<f64>,
    /// Coordinate of every independent joint by its encoder, rad or m; NaN where it has none: `[joints]`.
    pub joint: Vec<f64>,
}

impl ArmReading {
    /// Zeros, until the first update.
    pub(super) fn new(muscles: usize, joints: usize) -> Self {
        Self {
            motor: vec![0.0; muscles],
            tension: vec![0.0; muscles],
            current: vec![0.0; muscles],
            joint: vec![0.0; joints],
        }
    }

    /// As many readings, all of them missing.
    #[must_use]
    pub fn missing(&self) -> Self {
        let [muscles, joints] = [self.motor.len(), self.joint.len()];
        Self {
            motor: vec![f64::NAN; muscles],
            tension: vec![f64::NAN; muscles],
            current: vec![f64::NAN; muscles],
            joint: vec![f64::NAN; joints],
        }
    }

    /// Reads every sensor and applies the faults that are active at `time`, s since the start; a stuck sensor
    /// keeps its last reading. Where a sensor has several active faults, the first of the list applies.
    ///
    /// # Shapes
    /// `q`, the true coordinates, rad or m: `[joints]`.
    pub(super) fn update(
        &mut self,
        time: f64,
        drives: &DriveBatch,
        specimen: &ArmSpecimen,
        q: &[f64],
        faults: &[InjectedFault],
    ) {
        let failure_of = |sensor: Sensor| {
            faults.iter().filter(|fault| fault.is_active(time)).find_map(|fault| match fault.failure {
                Failure::Sensor(which, how) if which == sensor => Some((how, time - fault.start)),
                _ => None,
            })
        };
        let set = |reading: &mut f64, measured: f64, sensor: Sensor| {
            *reading = match failure_of(sensor) {
                None => measured,
                Some((how, elapsed)) => how.reading(measured, *reading, elapsed, || noise(time, sensor)),
            };
        };
        for k in 0..self.motor.len() {
            let drive = drives.reading(k);
            set(&mut self.motor[k], drive.position / specimen.winches[k], Sensor::Motor(k));
            set(&mut self.tension[k], drive.tension, Sensor::Tension(k));
            self.current[k] = drive.current;
        }
        for (k, (encoder, &angle)) in specimen.encoders.iter().zip(q).enumerate() {
            let measured = encoder.map_or(f64::NAN, |encoder| encoder.read(angle));
            set(&mut self.joint[k], measured, Sensor::Joint(k));
        }
    }
}

/// Noise of unit variance that belongs to a sensor and a time, whatever else was drawn: faults leave the
/// other noise as it is.
fn noise(time: f64, sensor: Sensor) -> f64 {
    let (kind, index) = match sensor {
        Sensor::Tension(k) => (1, k),
        Sensor::Motor(k) => (2, k),
        Sensor::Joint(k) => (3, k),
    };
    Random::new(time.to_bits() ^ ((index as u64) << 2 | kind).wrapping_mul(0x9e37_79b9_7f4a_7c15)).normal()
}
