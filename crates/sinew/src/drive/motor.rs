use crate::error::{Error, non_negative, positive, within};
use crate::lanes::abreast;

/// Brushed direct-current motor: winding, rotor, heat.
///
/// ```text
/// L di/dt = u - R(T_w) i - k w          over one step exactly, w held at its end:  i -> i_oo + (i - i_oo) e^(-h R/L)
/// tau     = k i,   R(T_w) = R (1 + 0.00393 (T_w - 25))
/// C_w dT_w/dt = R i^2 - (T_w - T_h)/R_wh,   C_h dT_h/dt = (T_w - T_h)/R_wh - (T_h - T_a)/R_ha
/// ```
///
/// | symbol | argument             | unit      | domain | meaning                                   |
/// |--------|----------------------|-----------|--------|-------------------------------------------|
/// | k      | `torque_constant`    | Nm/A      | > 0    | torque per current, voltage per speed       |
/// | R      | `resistance`         | ohm       | > 0    | of the winding at 25 degrees Celsius         |
/// | L      | `inductance`         | H         | >= 0   | of the winding                              |
/// | J      | `inertia`            | kg m^2    | > 0    | of the rotor                                |
/// | u      | `voltage`            | V         | > 0    | limit of the amplifier                       |
/// | i_c    | `continuous_current` | A         | > 0    | thermal limit of continuous operation       |
/// | i_p    | `peak_current`       | A         | >= i_c | limit of the amplifier                       |
/// | w_max  | `top_speed`          | rad/s     | > 0    | limit of bearings and brushes                |
/// | R_wh, R_ha | `winding_to_housing`, `housing_to_air` | K/W | >= 0, > 0 | thermal resistances       |
/// | C_w, C_h | `winding_capacity`, `housing_capacity` | J/K | > 0   | heat capacities                      |
/// | T_max  | `hottest`            | degree C  | > 25   | of the winding; above it the motor is off    |
///
/// # Assumes
/// No cogging, no saturation; magnets do not weaken with heat; the speed changes little within a step.
///
/// # Source
/// Textbook; copper's 0.00393 1/K.
#[derive(Debug, Clone, Copy, PartialEq)]
pub struct Motor {
    /// Nm/A.
    pub torque_constant: f64,
    /// Ohm at 25 degrees Celsius.
    pub resistance: f64,
    /// H.
    pub inductance: f64,
    /// kg m^2.
    pub inertia: f64,
    /// Supply voltage, V.
    pub voltage: f64,
    /// Current that it holds continuously, A.
    pub continuous_current: f64,
    /// Current that its amplifier gives for a short time, A.
    pub peak_current: f64,
    /// Highest speed of the shaft, rad/s.
    pub top_speed: f64,
    /// K/W.
    pub winding_to_housing: f64,
    /// K/W.
    pub housing_to_air: f64,
    /// J/K.
    pub winding_capacity: f64,
    /// J/K.
    pub housing_capacity: f64,
    /// Degrees Celsius.
    pub hottest: f64,
}

abreast!(MotorRows of Motor {
    f64: torque_constant resistance inductance inertia voltage continuous_current peak_current top_speed
        winding_to_housing housing_to_air winding_capacity housing_capacity hottest
});

/// Temperature of the room, degrees Celsius.
pub const ROOM: f64 = 25.0;

/// Growth of copper's resistance, 1/K.
const COPPER: f64 = 0.003_93;

/// Inductance that replaces zero, H.
const MIN_INDUCTANCE: f64 = 1e-12;

impl Motor {
    /// The class of the paper's drive, 35 mm, 24 V, 120 W.
    ///
    /// Torque constant, resistance, inductance, inertia and continuous torque are class values without a data
    /// sheet; heat is that of motors of 340 g: winding 15 s, housing 15 min.
    #[must_use]
    pub fn class_35_mm() -> Self {
        Self {
            torque_constant: 0.029,
            resistance: 0.35,
            inductance: 1e-4,
            inertia: 6.5e-6,
            voltage: 24.0,
            continuous_current: 4.14,
            peak_current: 15.0,
            top_speed: 1000.0,
            winding_to_housing: 2.0,
            housing_to_air: 6.2,
            winding_capacity: 15.0,
            housing_capacity: 150.0,
            hottest: 155.0,
        }
    }

    /// Checks every number.
    ///
    /// # Errors
    /// [`Error::OutOfDomain`] names the number outside its domain.
    pub fn validate(&self) -> Result<(), Error> {
        positive("torque_constant", self.torque_constant)?;
        positive("resistance", self.resistance)?;
        non_negative("inductance", self.inductance)?;
        positive("inertia", self.inertia)?;
        positive("voltage", self.voltage)?;
        positive("continuous_current", self.continuous_current)?;
        let peak = self.peak_current;
        let enough = peak.is_finite() && peak >= self.continuous_current;
        within("peak_current", "a finite number >= the continuous current", peak, enough)?;
        positive("top_speed", self.top_speed)?;
        non_negative("winding_to_housing", self.winding_to_housing)?;
        positive("housing_to_air", self.housing_to_air)?;
        positive("winding_capacity", self.winding_capacity)?;
        positive("housing_capacity", self.housing_capacity)?;
        let hottest = self.hottest;
        within("hottest", "a finite number > 25 C", hottest, hottest.is_finite() && hottest > ROOM)?;
        Ok(())
    }

    /// Resistance of a winding at a temperature, ohm.
    #[inline(always)]
    #[must_use]
    pub fn resistance_at(&self, winding: f64) -> f64 {
        self.resistance * (1.0 + COPPER * (winding - ROOM)).max(0.1)
    }

    /// Current that the winding carries for as long as it likes, A: the smaller of data sheet and thermal
    /// limit.
    #[must_use]
    pub fn lasting_current(&self) -> f64 {
        let heat = (self.hottest - ROOM) / (self.winding_to_housing + self.housing_to_air);
        self.continuous_current.min(libm::sqrt(heat / self.resistance_at(self.hottest)))
    }

    /// Steady temperature of a winding that carries `current`, degrees Celsius; infinite beyond thermal
    /// runaway.
    #[must_use]
    pub fn steady_temperature(&self, current: f64) -> f64 {
        let rise = self.resistance * current * current * (self.winding_to_housing + self.housing_to_air);
        let kept = 1.0 - COPPER * rise;
        if kept > 0.0 { ROOM + rise / kept } else { f64::INFINITY }
    }
}

/// State of a motor.
#[derive(Debug, Clone, Copy, PartialEq)]
pub struct MotorState {
    /// Current, A.
    pub current: f64,
    /// Temperature of the winding, degrees Celsius.
    pub winding: f64,
    /// Temperature of the housing, degrees Celsius.
    pub housing: f64,
    resistance: f64,
    /// Of the winding, for the step and the resistance they were computed for.
    lag: Lag,
    rates: Rates,
    step: f64,
}

abreast!(MotorStateRows of MotorState {
    f64: current winding housing resistance step;
    Lag: lag;
    Rates: rates
});

/// Coefficients of a step, precomputed to avoid divisions.
#[derive(Debug, Clone, Copy, PartialEq, Default)]
pub(super) struct Rates {
    /// J per kelvin between winding and housing.
    to_housing: f64,
    /// J per kelvin between housing and room.
    to_air: f64,
    /// K/J of the winding.
    winding: f64,
    /// K/J of the housing.
    housing: f64,
    /// Of the winding, 1/ohm.
    conductance: f64,
}

abreast!(RateRows of Rates { f64: to_housing to_air winding housing conductance });

/// How a current settles within a step: `i(t) = i_oo + (i - i_oo) e^(-t R/L)`.
#[derive(Debug, Clone, Copy, PartialEq)]
pub(super) struct Lag {
    /// Fraction of the distance that is left at the end: `e^(-h R/L)`.
    pub left: f64,
    /// Mean fraction over the step.
    pub mean: f64,
    /// Mean of its square.
    pub square: f64,
}

abreast!(LagRows of Lag { f64: left mean square });

impl Lag {
    fn new(constants: f64) -> Self {
        let left = libm::exp(-constants);
        let mean = -libm::expm1(-constants) / constants;
        Self { left, mean, square: 0.5 * mean * (1.0 + left) }
    }
}

/// Result of a step of the winding.
#[derive(Debug, Clone, Copy, PartialEq)]
pub(super) struct Winding {
    /// Mean current, A.
    pub mean: f64,
    /// Joule heat, J.
    pub heat: f64,
    /// Heat that left the housing, J.
    pub to_air: f64,
}

abreast!(WindingRows of Winding { f64: mean heat to_air });

impl MotorState {
    /// Cold and without current.
    #[must_use]
    pub fn cold(motor: &Motor) -> Self {
        Self {
            current: 0.0,
            winding: ROOM,
            housing: ROOM,
            resistance: motor.resistance,
            lag: Lag { left: 0.0, mean: 0.0, square: 0.0 },
            rates: Rates::default(),
            step: 0.0,
        }
    }

    /// Present resistance, ohm.
    #[inline(always)]
    #[must_use]
    pub fn resistance(&self) -> f64 {
        self.resistance
    }

    /// Energy in the winding's field, J.
    #[inline(always)]
    #[must_use]
    pub fn field(&self, motor: &Motor) -> f64 {
        0.5 * motor.inductance.max(MIN_INDUCTANCE) * self.current * self.current
    }

    /// Heat stored in winding and housing above room temperature, J.
    #[must_use]
    pub fn warmth(&self, motor: &Motor) -> f64 {
        motor.winding_capacity * (self.winding - ROOM) + motor.housing_capacity * (self.housing - ROOM)
    }

    /// Whether [`prepare`](Self::prepare) is due: the resistance has changed by a thousandth, which it seldom
    /// does, or the step is another.
    #[inline(always)]
    pub(super) fn is_due(&self, motor: &Motor, h: f64) -> bool {
        let now = motor.resistance_at(self.winding);
        let moved = (now - self.resistance).abs() > 1e-3 * now;
        moved | (self.step.to_bits() != h.to_bits())
    }

    /// How the current settles in a step of `h` seconds.
    pub(super) fn prepare(&mut self, motor: &Motor, h: f64) -> Lag {
        if self.is_due(motor, h) {
            let now = motor.resistance_at(self.winding);
            self.resistance = now;
            self.step = h;
            self.lag = Lag::new((h * now / motor.inductance.max(MIN_INDUCTANCE)).max(1e-12));
            self.rates = Rates {
                to_housing: h / motor.winding_to_housing.max(1e-3),
                to_air: h / motor.housing_to_air,
                winding: 1.0 / motor.winding_capacity,
                housing: 1.0 / motor.housing_capacity,
                conductance: 1.0 / now,
            };
        }
        self.lag
    }

    /// The same, which is prepared.
    #[inline(always)]
    pub(super) fn lag(&self) -> Lag {
        self.lag
    }

    /// Mean current of a step, A, with `voltage` at the winding beside the back-EMF.
    #[inline(always)]
    pub(super) fn mean(&self, voltage: f64) -> f64 {
        let end = voltage * self.rates.conductance;
        end + (self.current - end) * self.lag.mean
    }

    /// Applies a winding voltage, beside the back-EMF, for the `h` seconds that it is prepared for.
    ///
    /// Energy balance, to rounding: `voltage` times mean current times `h` is Joule heat plus the change of
    /// field energy; the heat is stored in winding and housing or leaves to the air.
    #[inline(always)]
    pub(super) fn drive(&mut self, voltage: f64, h: f64) -> Winding {
        let lag = self.lag;
        let end = voltage * self.rates.conductance;
        let off = self.current - end;
        let mean = end + off * lag.mean;
        self.current = end + off * lag.left;
        let square = end * end + 2.0 * end * off * lag.mean + off * off * lag.square;
        let heat = self.resistance * square * h;
        Winding { mean, heat, to_air: self.warm(heat) }
    }

    /// Opens the circuit: the field's energy goes back to the supply, J.
    #[inline(always)]
    pub(super) fn open(&mut self, motor: &Motor) -> f64 {
        let field = self.field(motor);
        self.current = 0.0;
        field
    }

    /// Adds heat, J, to the winding; returns what the housing gives to the air, J.
    #[inline(always)]
    fn warm(&mut self, heat: f64) -> f64 {
        let rates = &self.rates;
        let to_housing = rates.to_housing * (self.winding - self.housing);
        let to_air = rates.to_air * (self.housing - ROOM);
        self.winding += (heat - to_housing) * rates.winding;
        self.housing += (to_housing - to_air) * rates.housing;
        to_air
    }
}

#[cfg(test)]
mod tests {
    use super::*;

    fn apply(state: &mut MotorState, motor: &Motor, voltage: f64, h: f64) {
        state.prepare(motor, h);
        state.drive(voltage, h);
    }

    #[test]
    fn a_stalled_motor_settles_at_ohms_law_and_a_free_one_at_its_speed() {
        let motor = Motor::class_35_mm();
        let mut state = MotorState::cold(&motor);
        for _ in 0..100 {
            apply(&mut state, &motor, 2.0, 1e-4);
        }
        assert!((state.current - 2.0 / state.resistance()).abs() < 0.02);
        let free = 12.0 / motor.torque_constant;
        let mut state = MotorState::cold(&motor);
        for _ in 0..100 {
            apply(&mut state, &motor, 12.0 - motor.torque_constant * free, 1e-4);
        }
        assert!(state.current.abs() < 1e-9);
    }

    #[test]
    fn the_current_rises_with_the_time_constant_of_the_winding() {
        let motor = Motor::class_35_mm();
        let mut state = MotorState::cold(&motor);
        let constant = motor.inductance / motor.resistance;
        for _ in 0..10 {
            apply(&mut state, &motor, 1.0, constant / 10.0);
        }
        let expected = (1.0 - (-1.0_f64).exp()) / motor.resistance;
        assert!((state.current - expected).abs() < 1e-3 * expected, "{} {expected}", state.current);
    }

    #[test]
    fn the_continuous_current_heats_the_winding_to_its_steady_temperature() {
        let motor = Motor::class_35_mm();
        let mut state = MotorState::cold(&motor);
        let current = motor.continuous_current;
        for _ in 0..1_000_000 {
            let voltage = current * state.resistance();
            apply(&mut state, &motor, voltage, 0.01);
        }
        let steady = motor.steady_temperature(current);
        assert!((state.winding - steady).abs() < 1.0, "{} {steady}", state.winding);
        assert!(steady < motor.hottest && motor.steady_temperature(2.0 * current) > motor.hottest);
    }

    #[test]
    fn numbers_outside_their_domain_are_named() {
        let wrong = |change: fn(&mut Motor)| {
            let mut motor = Motor::class_35_mm();
            change(&mut motor);
            std::string::ToString::to_string(&motor.validate().unwrap_err())
        };
        assert!(wrong(|m| m.resistance = 0.0).contains("resistance"));
        assert!(wrong(|m| m.inertia = f64::NAN).contains("inertia"));
        assert!(wrong(|m| m.peak_current = 1.0).contains("peak_current"));
        assert!(wrong(|m| m.hottest = 20.0).contains("hottest"));
        assert!(wrong(|m| m.hottest = ROOM).contains("hottest"));
        assert!(Motor::class_35_mm().validate().is_ok());
    }

    #[test]
    fn a_winding_that_is_opened_returns_its_field_and_carries_no_current() {
        let motor = Motor::class_35_mm();
        let mut state = MotorState { current: 8.0, ..MotorState::cold(&motor) };
        let returned = state.open(&motor);
        assert!((returned - 0.5 * motor.inductance * 64.0).abs() < 1e-15, "{returned}");
        assert!(state.current.abs() < 1e-15 && state.field(&motor).abs() < 1e-15);
    }

    #[test]
    fn the_resistance_follows_the_warmth_in_steps_of_a_thousandth() {
        let motor = Motor::class_35_mm();
        let mut state = MotorState::cold(&motor);
        let mut resistance = |rise: f64| {
            state.winding = ROOM + rise;
            state.prepare(&motor, 1e-3);
            state.resistance()
        };
        assert!((resistance(0.0) - motor.resistance).abs() < 1e-15);
        // By 0.0004, by 0.002 and, from there, by 0.0006.
        assert!((resistance(0.1) - motor.resistance).abs() < 1e-15);
        let followed = motor.resistance_at(ROOM + 0.5);
        assert!((resistance(0.5) - followed).abs() < 1e-15);
        assert!((resistance(0.65) - followed).abs() < 1e-15);
    }
}
