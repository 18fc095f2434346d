use crate::drive::{DriveParameters, MotorTemperatures};

/// Temperature of a muscle's winding by its thermal model, from tension and speed of its cable.
///
/// ```text
/// i = (T r/(n eta) + friction)/k  taking up,   i = (T r eta/n - friction)/k  paying out,   mean of both standing
/// C_w dT_w/dt = R i^2 - ..                     the laws of `Motor`
/// ```
///
/// The mean square of the current is collected over [`INTERVAL`], then the temperatures advance by an
/// implicit step.
#[derive(Debug, Clone, Copy)]
pub(super) struct WindingHeat {
    temperatures: MotorTemperatures,
    squares: f64,
    time: f64,
}

/// Interval at which temperatures are stepped, s.
const INTERVAL: f64 = 0.1;
/// Speed below which a winch stands, m/s.
const STANDING: f64 = 1e-4;

impl WindingHeat {
    pub(super) fn new() -> Self {
        Self { temperatures: MotorTemperatures::room(), squares: 0.0, time: 0.0 }
    }

    /// Temperature of the winding, degrees Celsius.
    pub(super) fn winding(&self) -> f64 {
        self.temperatures.winding
    }

    /// `h` s at a tension, N, and a speed of the cable, m/s, + toward the motor.
    pub(super) fn update(&mut self, h: f64, drive: &DriveParameters, tension: f64, speed: f64) {
        let tension = if tension.is_finite() { tension.max(0.0) } else { 0.0 };
        let current = if speed > STANDING {
            drive.pulling_current(tension, speed)
        } else if speed < -STANDING {
            drive.yielding_current(tension, -speed)
        } else {
            0.5 * (drive.pulling_current(tension, 0.0) + drive.yielding_current(tension, 0.0))
        };
        let most = drive.motor.peak_current;
        let current = current.clamp(-most, most);
        self.squares += h * current * current;
        self.time += h;
        if self.time >= INTERVAL {
            let current = libm::sqrt(self.squares / self.time);
            self.temperatures.advance(&drive.motor, current, self.time);
            (self.squares, self.time) = (0.0, 0.0);
        }
    }
}

#[cfg(test)]
mod tests {
    use super::*;

    #[test]
    fn a_held_tension_warms_the_winding_to_the_steady_temperature_of_its_current() {
        let drive = DriveParameters::mc_am();
        let mut heat = WindingHeat::new();
        for _ in 0..(8 * 3600 * 100) {
            heat.update(0.01, &drive, 200.0, 0.0);
        }
        let current = 0.5 * (drive.pulling_current(200.0, 0.0) + drive.yielding_current(200.0, 0.0));
        let steady = drive.motor.steady_temperature(current);
        assert!((heat.winding() - steady).abs() < 0.02 * (steady - 25.0), "{} {steady}", heat.winding());
    }

    /// Temperature of a winding long after a tension, N, and a speed of the cable, m/s, have begun.
    fn settled(tension: f64, speed: f64) -> f64 {
        let drive = DriveParameters::mc_am();
        let mut heat = WindingHeat::new();
        (0..100).for_each(|_| heat.update(1e6, &drive, tension, speed));
        heat.winding()
    }

    #[test]
    fn a_winch_that_takes_up_is_hotter_and_one_that_pays_out_colder_by_the_losses_of_its_reducer() {
        let drive = DriveParameters::mc_am();
        let steady = |current: f64| drive.motor.steady_temperature(current);
        for speed in [2e-3, 0.05] {
            let (up, out) = (drive.pulling_current(200.0, speed), drive.yielding_current(200.0, speed));
            let near =
                |found: f64, current: f64| (found - steady(current)).abs() < 1e-3 * (steady(current) - 25.0);
            assert!(near(settled(200.0, speed), up) && near(settled(200.0, -speed), out), "{up} {out}");
            assert!(steady(up) > 1.2 * steady(out));
        }
    }

    #[test]
    fn a_slack_cable_and_a_silent_load_cell_leave_a_standing_winding_cold() {
        // Both frictions of a standing reducer are equal, so that no current is left.
        for tension in [0.0, -5.0, f64::NAN] {
            assert!((settled(tension, 0.0) - 25.0).abs() < 1e-9);
        }
    }
}
