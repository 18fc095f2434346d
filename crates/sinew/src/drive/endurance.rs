//! How long a motor and its drive give a torque or a tension.

use super::motor::{Motor, ROOM};
use super::parameters::DriveParameters;

/// Temperatures of a motor, degrees Celsius, for plans of seconds to hours.
///
/// The heat of [`Motor`], integrated implicitly, so that any step is stable;
/// [`MotorState`](super::MotorState) integrates the same law with the step of the drive.
#[derive(Debug, Clone, Copy, PartialEq)]
pub struct MotorTemperatures {
    /// Of the winding.
    pub winding: f64,
    /// Of the housing.
    pub housing: f64,
}

/// Least thermal resistance between winding and housing, K/W.
const MIN_RESISTANCE: f64 = 1e-3;

impl MotorTemperatures {
    /// Of the room.
    #[must_use]
    pub fn room() -> Self {
        Self { winding: ROOM, housing: ROOM }
    }

    /// A step of `h` seconds, > 0, with a current, A.
    pub fn advance(&mut self, motor: &Motor, current: f64, h: f64) {
        let loss = motor.resistance_at(self.winding) * current * current;
        let (inner, outer) = (1.0 / motor.winding_to_housing.max(MIN_RESISTANCE), 1.0 / motor.housing_to_air);
        let (winding, housing) = (motor.winding_capacity / h, motor.housing_capacity / h);
        // (winding + inner) T_w - inner T_h = a,   (housing + inner + outer) T_h - inner T_w = b
        let a = winding * self.winding + loss;
        let b = housing * self.housing + outer * ROOM;
        let (along, across) = (winding + inner, housing + inner + outer);
        let determinant = along * across - inner * inner;
        self.winding = (a * across + inner * b) / determinant;
        self.housing = (b * along + inner * a) / determinant;
    }
}

/// Steps of an integration, and how long they are in longer ones, s.
const STEPS: f64 = 200.0;
const LONGEST_STEP: f64 = 1.0;
/// Bound of the steps of one integration.
const MAX_STEPS: f64 = 5000.0;
/// Halvings of the interval of currents.
const HALVINGS: usize = 30;

impl Motor {
    /// Largest constant current that leaves the winding below its limit for a time from room temperature on,
    /// A; for an infinite time [`lasting_current`](Self::lasting_current).
    ///
    /// # Shapes
    /// `seconds` >= 0.
    #[must_use]
    pub fn current_for(&self, seconds: f64) -> f64 {
        let lasting = self.lasting_current();
        if !seconds.is_finite() {
            return lasting;
        }
        let steps = (seconds / LONGEST_STEP).clamp(STEPS, MAX_STEPS);
        let h = seconds.max(1e-3) / steps;
        let stays_below = |current: f64| {
            let mut temperatures = MotorTemperatures::room();
            (0..steps as usize).all(|_| {
                temperatures.advance(self, current, h);
                temperatures.winding <= self.hottest
            })
        };
        let mut high = lasting;
        while stays_below(high) && high < 1e3 * lasting {
            high *= 2.0;
        }
        let mut low = lasting;
        for _ in 0..HALVINGS {
            let middle = 0.5 * (low + high);
            if stays_below(middle) { low = middle } else { high = middle }
        }
        low
    }
}

impl DriveParameters {
    /// Tension that the drive holds for a time from room temperature on, N: what it takes up with the current
    /// that its winding endures, at most its working tension.
    ///
    /// The losses of the reducer count against the motor, as after winding in cable.
    #[must_use]
    pub fn holding_tension(&self, seconds: f64) -> f64 {
        self.tension_of(self.motor.current_for(seconds)).min(self.working_tension())
    }
}

#[cfg(test)]
mod tests {
    use super::*;
    use crate::drive::{Drive, DriveCommand, DriveFault};

    #[test]
    fn a_motor_with_the_current_for_a_minute_is_too_hot_after_a_minute() {
        let parameters = DriveParameters::mc_am();
        let current = parameters.motor.current_for(60.0);
        assert!(
            current > 1.2 * parameters.motor.lasting_current() && current < parameters.motor.peak_current
        );
        let mut drive = Drive::new(parameters, 1).unwrap();
        // Blocked by a tension that the current does not overcome.
        let tension = 1.02 * parameters.tension_of(current);
        let mut time = 0.0;
        let hot = (0..100_000).find(|k| {
            time = f64::from(*k) * 1e-3;
            matches!(
                drive.step(DriveCommand::Current(current), tension, 1e-3).fault,
                Some(DriveFault::Hot { .. })
            )
        });
        assert!(hot.is_some() && (time - 60.0).abs() < 1.0, "{time}");
    }

    #[test]
    fn the_longer_a_tension_is_held_the_smaller_it_is_down_to_the_lasting_one() {
        let drive = DriveParameters::mc_am();
        let tensions = [1.0, 10.0, 60.0, 3600.0, f64::INFINITY].map(|seconds| drive.holding_tension(seconds));
        assert!(tensions.windows(2).all(|pair| pair[0] >= pair[1]), "{tensions:?}");
        assert!(tensions[0] <= drive.working_tension() && tensions[4] > 0.0);
        let day = drive.motor.current_for(86_400.0);
        let lasting =
            (drive.motor.hottest - ROOM) / (drive.motor.winding_to_housing + drive.motor.housing_to_air);
        let lasting = libm::sqrt(lasting / drive.motor.resistance_at(drive.motor.hottest));
        assert!((day - lasting).abs() < 1e-3 * lasting, "{day} {lasting}");
    }

    #[test]
    fn a_winding_without_insulation_is_integrated_stably() {
        let motor = Motor { winding_to_housing: 0.0, ..Motor::class_35_mm() };
        let mut temperatures = MotorTemperatures::room();
        for _ in 0..10_000 {
            temperatures.advance(&motor, motor.lasting_current(), 1.0);
        }
        assert!((temperatures.winding - motor.steady_temperature(motor.lasting_current())).abs() < 0.5);
    }

    #[test]
    fn in_a_millisecond_the_winding_alone_takes_the_heat() {
        let motor = Motor::class_35_mm();
        let seconds = 1e-3;
        // C dT/dt = R i^2 (1 + a (T - 25)).
        let growth = motor.resistance_at(ROOM + 1.0) / motor.resistance - 1.0;
        let logarithm = libm::log(motor.resistance_at(motor.hottest) / motor.resistance);
        let expected = libm::sqrt(motor.winding_capacity * logarithm / (growth * motor.resistance * seconds));
        let current = motor.current_for(seconds);
        assert!((current / expected - 1.0).abs() < 1e-3, "{current} {expected}");
    }

    #[test]
    fn after_the_time_that_was_asked_for_the_winding_is_at_its_limit() {
        let motor = Motor::class_35_mm();
        let (seconds, h) = (1000.0, 0.02);
        let current = motor.current_for(seconds);
        // The law of the motor with explicit and far smaller steps.
        let (mut winding, mut housing) = (ROOM, ROOM);
        for _ in 0..50_000 {
            let inner = (winding - housing) / motor.winding_to_housing;
            let outer = (housing - ROOM) / motor.housing_to_air;
            let loss = motor.resistance_at(winding) * current * current;
            winding += h * (loss - inner) / motor.winding_capacity;
            housing += h * (inner - outer) / motor.housing_capacity;
        }
        assert!((winding - motor.hottest).abs() < 0.15, "{winding}");
    }
}
