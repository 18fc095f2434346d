//! The numbers of a drive, and what follows from them alone.

use super::motor::Motor;
use super::reducer::Reducer;
use super::sensors::{Encoder, LoadCell};
use super::velocity_loop::VelocityLoop;
use super::winch::Winch;
use crate::Error;
use crate::error::{positive, within};
use crate::lanes::abreast;
use crate::random::Random;

/// Parameters of a drive.
#[derive(Debug, Clone, Copy, PartialEq)]
pub struct DriveParameters {
    /// The motor.
    pub motor: Motor,
    /// The reducer.
    pub reducer: Reducer,
    /// The winch.
    pub winch: Winch,
    /// Encoder on the motor's shaft.
    pub encoder: Encoder,
    /// Load cell at the outlet.
    pub load_cell: LoadCell,
    /// Whether there is one: without it the tension is not measured, and its numbers are those of a cell that
    /// the machine might have.
    pub has_load_cell: bool,
    /// Delay of every reading beside its sampling, ms, >= 0.
    pub delay_ms: f64,
    /// Limit of the velocity reference at the cable, m/s^2, > 0.
    pub acceleration: f64,
    /// Tension above which the drive does not wind in, N, > 0.
    pub max_tension: f64,
    /// Tension below which the drive does not pay out, N, >= 0.
    pub min_tension: f64,
}

abreast!(DriveParameterRows of DriveParameters {
    Motor: motor;
    Reducer: reducer;
    Winch: winch;
    Encoder: encoder;
    LoadCell: load_cell;
    bool: has_load_cell;
    f64: delay_ms acceleration max_tension min_tension
});

impl DriveParameters {
    /// The paper's drive: 35 mm motor of 120 W, 53 : 1, 15 mm winch; other values are assumed, as documented
    /// with each part.
    #[must_use]
    pub fn mc_am() -> Self {
        Self {
            motor: Motor::class_35_mm(),
            reducer: Reducer::ratio_53(),
            winch: Winch::fifteen_millimetres(),
            encoder: Encoder { counts: 2048.0, zero: 0.0 },
            load_cell: LoadCell::one_kilonewton(),
            has_load_cell: true,
            delay_ms: 1.0,
            acceleration: 5.0,
            max_tension: 600.0,
            min_tension: 1.0,
        }
    }

    /// Checks every number.
    ///
    /// # Errors
    /// [`Error::OutOfDomain`] names the number outside its domain.
    pub fn validate(&self) -> Result<(), Error> {
        self.motor.validate()?;
        self.reducer.validate()?;
        self.winch.validate()?;
        self.encoder.validate()?;
        self.load_cell.validate()?;
        positive("acceleration", self.acceleration)?;
        positive("max_tension", self.max_tension)?;
        let least = self.min_tension;
        let below = least >= 0.0 && least < self.max_tension;
        within("min_tension", "a number in [0, max_tension)", least, below)?;
        Ok(())
    }

    /// Rotor inertia reflected to the cable, kg.
    #[must_use]
    pub fn mass_at_cable(&self) -> f64 {
        let turns = self.reducer.ratio / self.winch.arm(0);
        self.motor.inertia * turns * turns
    }

    /// Current that winds in cable at a tension, N, and speed, m/s, >= 0, against the losses of the reducer,
    /// A.
    #[must_use]
    pub fn pulling_current(&self, tension: f64, speed: f64) -> f64 {
        let Self { motor, reducer, winch, .. } = self;
        let turns = reducer.ratio / winch.arm(0);
        let torque =
            tension / (turns * reducer.efficiency) + reducer.friction + reducer.viscous * turns * speed;
        torque / motor.torque_constant
    }

    /// Current that pays out cable at a tension, N, and speed, m/s, >= 0, with the losses of the reducer on
    /// its side, A; negative where the motor has to push.
    #[must_use]
    pub fn yielding_current(&self, tension: f64, speed: f64) -> f64 {
        let Self { motor, reducer, winch, .. } = self;
        let turns = reducer.ratio / winch.arm(0);
        let torque =
            tension * reducer.efficiency / turns - reducer.friction - reducer.viscous * turns * speed;
        torque / motor.torque_constant
    }

    /// Commanded travel after which the speed control has taken back the friction of the reducer where the
    /// drive reverses, per tension of the cable, m/N: until then it stands.
    #[must_use]
    pub fn reversal_travel(&self) -> f64 {
        let tension = self.allowed_tension();
        self.reversal_travel_at(tension) / tension
    }

    /// The same at a tension, N, m.
    #[must_use]
    pub fn reversal_travel_at(&self, tension: f64) -> f64 {
        let Self { motor, reducer, winch, .. } = self;
        let turns = reducer.ratio / winch.arm(0);
        let losses = (1.0 / reducer.efficiency - reducer.efficiency) * (1.0 + reducer.ripple) / turns;
        let torque = losses * tension + 2.0 * reducer.friction;
        torque / (motor.inertia * VelocityLoop::DRIVE_INTEGRAL * turns)
    }

    /// Tension that the drive may be asked for, N: 19 in 20 of the one above which it does not wind in, and
    /// what it takes up with its peak current, or with the current at which a hot winding leaves half of the
    /// no-load speed. Heat is not considered.
    #[must_use]
    pub fn working_tension(&self) -> f64 {
        let motor = &self.motor;
        let current = motor.peak_current.min(0.5 * motor.voltage / motor.resistance_at(motor.hottest));
        self.allowed_tension().min(self.tension_of(current))
    }

    /// Tension that the drive may be asked for whatever its motor gives, N.
    #[must_use]
    pub fn allowed_tension(&self) -> f64 {
        0.95 * self.max_tension
    }

    /// Tension at which a current winds in cable slowly, N: the inverse of
    /// [`pulling_current`](Self::pulling_current) at standstill, 0 where friction takes all of it.
    #[must_use]
    pub fn tension_of(&self, current: f64) -> f64 {
        let Self { motor, reducer, winch, .. } = self;
        let turns = reducer.ratio / winch.arm(0);
        let torque = motor.torque_constant * current - reducer.friction;
        (torque * reducer.efficiency * turns).max(0.0)
    }

    /// Tension at a current, A, of a drive that was commanded a speed of the cable, m/s, N: against friction
    /// where it winds in or stands after that, with friction on its side where it pays out.
    #[must_use]
    pub fn tension_by_current(&self, current: f64, speed: f64) -> f64 {
        if speed >= 0.0 {
            return self.tension_of(current);
        }
        let Self { motor, reducer, winch, .. } = self;
        let torque = motor.torque_constant * current + reducer.friction;
        (torque * reducer.ratio / winch.arm(0) / reducer.efficiency).max(0.0)
    }

    /// Speed at which the drive winds in cable at a tension, N, m/s: the limit of the voltage with a hot
    /// winding, or of the bearings.
    #[must_use]
    pub fn speed_at(&self, tension: f64) -> f64 {
        let Self { motor, reducer, winch, .. } = self;
        let current = self.pulling_current(tension, 0.0);
        let left = motor.voltage - motor.resistance_at(motor.hottest) * current;
        let shaft = (left / motor.torque_constant).clamp(0.0, motor.top_speed);
        shaft * winch.arm(0) / reducer.ratio
    }

    /// A cable speed, m/s, limited so that the tension at the outlet, N, stays between the drive's limits.
    #[inline(always)]
    #[must_use]
    pub fn limited_speed(&self, velocity: f64, tension: f64) -> f64 {
        if tension > self.max_tension {
            velocity.min(0.0)
        } else if tension < self.min_tension {
            velocity.max(0.0)
        } else {
            velocity
        }
    }

    /// What the load cell shows at a tension, N; NaN without one.
    #[inline(always)]
    pub(super) fn measured(&self, tension: f64, random: &mut Random) -> f64 {
        let mut drawn = random.clone();
        let shown = self.load_cell.read(tension, &mut drawn);
        // Where nothing is measured nothing is drawn.
        *random = if self.has_load_cell { drawn } else { random.clone() };
        if self.has_load_cell { shown } else { f64::NAN }
    }
}

#[cfg(test)]
mod tests {
    use super::*;
    use crate::drive::Shaft;
    use std::string::ToString;

    /// Without ripple: currents and tensions are for the mean of the losses.
    fn drive() -> DriveParameters {
        let losses = Reducer { efficiency: 0.6, friction: 3e-3, viscous: 2e-5, ..Reducer::ratio_53() };
        let reducer = Reducer { ratio: 30.0, ripple: 0.0, ..losses };
        DriveParameters { reducer, ..DriveParameters::mc_am() }
    }

    /// Speed of the motor's shaft at a cable speed.
    fn shaft_speed(drive: &DriveParameters, velocity: f64) -> f64 {
        velocity * drive.reducer.ratio / drive.winch.arm(0)
    }

    #[test]
    fn the_currents_for_taking_up_and_paying_out_keep_the_simulated_shaft_at_its_speed() {
        let drive = drive();
        for (tension, speed) in [(80.0, 0.05), (200.0, 0.12), (20.0, 0.2)] {
            let up = (drive.pulling_current(tension, speed), speed);
            let out = (drive.yielding_current(tension, speed), -speed);
            for (current, velocity) in [up, out] {
                let speed = shaft_speed(&drive, velocity);
                let shaft = Shaft { inertia: drive.motor.inertia, speed, angle: 0.0 };
                let torque = drive.motor.torque_constant * current;
                let turned = drive.reducer.turn(shaft, torque, 0.0, tension * drive.winch.arm(0), 1e-3);
                assert!((turned.speed / speed - 1.0).abs() < 1e-14, "{tension} {velocity}: {}", turned.speed);
            }
        }
    }

    #[test]
    fn a_tension_is_taken_up_with_the_current_that_it_was_computed_from() {
        let drive = drive();
        for current in [0.5, 4.0, 12.0] {
            let back = drive.pulling_current(drive.tension_of(current), 0.0);
            assert!((back / current - 1.0).abs() < 1e-14, "{current} {back}");
        }
        let swallowed = 0.9 * drive.reducer.friction / drive.motor.torque_constant;
        assert!(drive.tension_of(swallowed).abs() < 1e-15);
    }

    #[test]
    fn the_working_tension_leaves_half_of_the_no_load_speed_or_takes_the_peak_current_or_19_in_20() {
        let mut weak = drive();
        weak.motor.voltage = 6.0;
        let shaft = shaft_speed(&weak, weak.speed_at(weak.working_tension()));
        let no_load = weak.motor.voltage / weak.motor.torque_constant;
        assert!((shaft / no_load - 0.5).abs() < 1e-14, "{shaft} {no_load}");
        let mut short = drive();
        short.motor.peak_current = 4.5;
        let current = short.pulling_current(short.working_tension(), 0.0);
        assert!((current - short.motor.peak_current).abs() < 1e-14, "{current}");
        let gentle = DriveParameters { max_tension: 50.0, ..drive() };
        assert!((20.0 * gentle.working_tension() - 19.0 * gentle.max_tension).abs() < 1e-12);
        assert!((gentle.working_tension() - gentle.allowed_tension()).abs() < 1e-15);
    }

    #[test]
    fn at_its_fastest_a_drive_uses_all_of_its_voltage_or_all_of_its_bearings() {
        let mut drive = drive();
        let hot = drive.motor.resistance_at(drive.motor.hottest);
        for tension in [5.0, 100.0, 250.0] {
            let back = drive.motor.torque_constant * shaft_speed(&drive, drive.speed_at(tension));
            let used = hot * drive.pulling_current(tension, 0.0) + back;
            assert!((used / drive.motor.voltage - 1.0).abs() < 1e-14, "{tension}: {used} V");
        }
        assert!(drive.speed_at(1e4).abs() < 1e-15, "no voltage is left");
        drive.motor.top_speed = 300.0;
        let shaft = shaft_speed(&drive, drive.speed_at(5.0));
        assert!((shaft - drive.motor.top_speed).abs() < 1e-12, "{shaft}");
    }

    #[test]
    fn only_a_tension_beyond_a_limit_stops_the_motion_that_leads_further_beyond() {
        let drive = drive();
        let both = [-0.1, 0.1];
        let limited = |tension: f64, expected: [f64; 2]| {
            let got = both.map(|velocity| drive.limited_speed(velocity, tension));
            assert_eq!(got.map(f64::to_bits), expected.map(f64::to_bits), "{tension} N: {got:?}");
        };
        for within in [drive.min_tension, 100.0, drive.max_tension] {
            limited(within, both);
        }
        limited(drive.max_tension + 1e-9, [-0.1, 0.0]);
        limited(drive.min_tension - 1e-9, [0.0, 0.1]);
    }

    #[test]
    fn numbers_outside_their_domain_are_named_whatever_the_part() {
        let wrong = |change: fn(&mut DriveParameters)| {
            let mut drive = DriveParameters::mc_am();
            change(&mut drive);
            drive.validate().unwrap_err().to_string()
        };
        assert!(DriveParameters::mc_am().validate().is_ok());
        assert!(wrong(|d| d.motor.resistance = 0.0).starts_with("resistance"));
        assert!(wrong(|d| d.reducer.ratio = 0.5).starts_with("ratio"));
        assert!(wrong(|d| d.winch.radius = 0.0).starts_with("radius"));
        assert!(wrong(|d| d.encoder.counts = 0.0).starts_with("counts"));
        assert!(wrong(|d| d.load_cell.range = 0.0).starts_with("range"));
        assert!(wrong(|d| d.acceleration = 0.0).starts_with("acceleration"));
        assert!(wrong(|d| d.max_tension = f64::NAN).starts_with("max_tension"));
        assert!(wrong(|d| d.min_tension = -1.0).starts_with("min_tension"));
        assert!(wrong(|d| d.min_tension = d.max_tension).starts_with("min_tension"));
    }
}
