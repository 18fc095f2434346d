use super::fault::{Failure, InjectedFault, Sensor, SensorFailure};
use crate::drive::{Drive, Encoder};
use alloc::vec;
use alloc::vec::Vec;

/// What the arm's sensors say: counts, noise, errors and faults included. Not a number where a sensor says so.
#[derive(Debug, Clone, PartialEq)]
pub struct ArmReading {
    /// Position of every cable by its motor's encoder, m, + toward the motor: `[muscles]`.
    pub motor: Vec<f64>,
    /// Tension at every drive's outlet, N: `[muscles]`.
    pub tension: Vec<f64>,
    /// Angle of every joint, rad: `[joints]`.
    pub joint: Vec<f64>,
}

impl ArmReading {
    pub(super) fn new(muscles: usize, joints: usize) -> Self {
        Self { motor: vec![0.0; muscles], tension: vec![0.0; muscles], joint: vec![0.0; joints] }
    }

    /// Takes what every sensor says at `time`, then what faults make of it; a stuck one keeps what it said.
    pub(super) fn update(
        &mut self,
        time: f64,
        drives: &[Drive],
        encoders: &[Encoder],
        q: &[f64],
        faults: &[InjectedFault],
    ) {
        let failing = |sensor: Sensor| {
            faults.iter().filter(|fault| fault.is_active(time)).find_map(|fault| match fault.failure {
                Failure::Sensor(which, how) if which == sensor => Some(how),
                _ => None,
            })
        };
        let say = |said: &mut f64, now: f64, sensor: Sensor| match failing(sensor) {
            None => *said = now,
            Some(SensorFailure::Stuck) => {}
            Some(SensorFailure::Lost) => *said = 0.0,
            Some(SensorFailure::NotANumber) => *said = f64::NAN,
        };
        for (k, drive) in drives.iter().enumerate() {
            let now = drive.reading();
            say(&mut self.motor[k], now.position, Sensor::Motor(k));
            say(&mut self.tension[k], now.tension, Sensor::Tension(k));
        }
        for (k, (encoder, &angle)) in encoders.iter().zip(q).enumerate() {
            say(&mut self.joint[k], encoder.read(angle), Sensor::Joint(k));
        }
    }
}
