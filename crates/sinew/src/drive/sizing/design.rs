use crate::drive::{CatalogueMotor, CatalogueReducer, DriveParameters, Motor, Reducer, Winch};
use crate::error::{Error, non_negative, positive};

/// Requirement on a drive, at the cable.
#[derive(Debug, Clone, Copy, PartialEq)]
pub struct Requirement {
    /// Continuous tension, N, > 0.
    pub tension: f64,
    /// Winding-in speed at that tension, m/s, >= 0.
    pub speed: f64,
    /// Peak acceleration at that tension and speed, m/s^2, >= 0.
    pub acceleration: f64,
    /// Cable length on the drum, m, >= 0.
    pub stroke: f64,
}

impl Requirement {
    /// Checks every number.
    ///
    /// # Errors
    /// [`Error::OutOfDomain`] names the number outside its domain.
    pub fn validate(&self) -> Result<(), Error> {
        positive("tension", self.tension)?;
        non_negative("speed", self.speed)?;
        non_negative("acceleration", self.acceleration)?;
        non_negative("stroke", self.stroke)?;
        Ok(())
    }
}

/// Limits of a drive.
#[derive(Debug, Clone, Copy, PartialEq, Eq)]
pub enum Limit {
    /// Winding temperature in continuous operation.
    Heat,
    /// The amplifier's current.
    Current,
    /// The amplifier's voltage, with a hot winding.
    Voltage,
    /// Speed of motor and reducer.
    Speed,
    /// Torque of the reducer.
    ReducerTorque,
    /// Capacity of the drum.
    Drum,
}

impl Limit {
    /// For reports.
    #[must_use]
    pub fn name(self) -> &'static str {
        match self {
            Self::Heat => "heat",
            Self::Current => "current",
            Self::Voltage => "voltage",
            Self::Speed => "top speed",
            Self::ReducerTorque => "reducer torque",
            Self::Drum => "drum",
        }
    }
}

/// Utilisation of every limit by a requirement; above 1 it is not met.
#[derive(Debug, Clone, Copy, PartialEq)]
pub struct Demand {
    /// In the order of [`Limit`].
    pub fractions: [(Limit, f64); 6],
}

impl Demand {
    /// The limit with the largest utilisation, and its value.
    #[must_use]
    pub fn worst(&self) -> (Limit, f64) {
        self.fractions.iter().copied().fold(self.fractions[0], |a, b| if b.1 > a.1 { b } else { a })
    }

    /// Whether every fraction is at most 1.
    #[must_use]
    pub fn is_met(&self) -> bool {
        self.worst().1 <= 1.0
    }
}

/// A drive design: its parts and their limits.
///
/// ```text
/// tau(T, v, a) = T r/(n eta) + tau_c + b w + J a n/r    taking cable up,     w = v n/r
/// tau(T, v, a) = T r eta/n - tau_c + b w + J a n/r      paying it out
/// ```
///
/// | symbol | field            | unit   | meaning                                                     |
/// |--------|------------------|--------|-------------------------------------------------------------|
/// | J      | `motor.inertia`  | kg m^2 | of rotor and reducer                                          |
/// | tau_c  | `reducer.friction` | Nm   | of motor and reducer                                          |
/// | r      | `winch`          | m      | cable per radian in the outermost layer                       |
/// | n, eta, b | `reducer`     |        | as there; ripple by its mean                                  |
///
/// # Assumes
/// As [`Motor`], [`Reducer`]; the voltage limit is evaluated with the winding at its temperature limit; the
/// motor's friction follows from its no-load current.
///
/// # Source
/// Textbook.
#[derive(Debug, Clone, Copy, PartialEq)]
pub struct Design {
    /// With the reducer's inertia.
    pub motor: Motor,
    /// With the motor's friction.
    pub reducer: Reducer,
    /// The winch.
    pub winch: Winch,
    /// Continuous torque at the winch, Nm.
    pub continuous_torque: f64,
    /// Peak torque at the winch, for a second, Nm.
    pub peak_torque: f64,
    /// Of the motor's shaft, rad/s.
    pub top_speed: f64,
    /// Of motor and reducer, kg.
    pub mass: f64,
}

impl Design {
    /// Assembles parts of a catalogue.
    #[must_use]
    pub fn new(motor: &CatalogueMotor, reducer: &CatalogueReducer, ratio: f64, winch: Winch) -> Self {
        let own = motor.parameters;
        let geared = reducer.reducer(ratio);
        Self {
            motor: Motor { inertia: own.inertia + reducer.inertia, ..own },
            reducer: Reducer {
                friction: geared.friction + own.torque_constant * motor.no_load_current,
                ..geared
            },
            winch,
            continuous_torque: reducer.continuous_torque,
            peak_torque: reducer.peak_torque,
            top_speed: own.top_speed.min(reducer.top_speed),
            mass: motor.mass + reducer.mass,
        }
    }

    /// The drive to simulate, with sensors, delays and loops as the paper's.
    #[must_use]
    pub fn drive(&self) -> DriveParameters {
        let motor = Motor { top_speed: self.top_speed, ..self.motor };
        DriveParameters { motor, reducer: self.reducer, winch: self.winch, ..DriveParameters::mc_am() }
    }

    /// Cable per radian of the winch in its outermost layer, m.
    #[must_use]
    pub fn arm(&self) -> f64 {
        self.winch.arm(self.winch.layers.saturating_sub(1))
    }

    /// Turns of the motor per cable, rad/m.
    #[must_use]
    pub fn turns(&self) -> f64 {
        self.reducer.ratio / self.arm()
    }

    /// Rotor inertia reflected to the cable, kg.
    #[must_use]
    pub fn mass_at_cable(&self) -> f64 {
        self.motor.inertia * self.turns() * self.turns()
    }

    /// Continuous current of the winding, A: the smaller of data sheet and thermal limit.
    #[must_use]
    pub fn continuous_current(&self) -> f64 {
        self.motor.lasting_current()
    }

    /// Torque of the motor, Nm, at a tension, speed and acceleration of the cable; zero speed counts as
    /// taking up.
    #[must_use]
    pub fn motor_torque(&self, tension: f64, speed: f64, acceleration: f64) -> f64 {
        let (r, turns) = (&self.reducer, self.turns());
        let load = tension / turns;
        let (fraction, dry) =
            if speed >= 0.0 { (1.0 / r.efficiency, r.friction) } else { (r.efficiency, -r.friction) };
        load * fraction + dry + turns * (r.viscous * speed + self.motor.inertia * acceleration)
    }

    /// Tension of the cable, N, at a torque of the motor: the inverse of [`Design::motor_torque`], not below
    /// 0.
    #[must_use]
    pub fn tension(&self, torque: f64, speed: f64, acceleration: f64) -> f64 {
        let nothing = self.motor_torque(0.0, speed, acceleration);
        let fraction = if speed >= 0.0 { self.reducer.efficiency } else { 1.0 / self.reducer.efficiency };
        ((torque - nothing) * fraction * self.turns()).max(0.0)
    }

    /// Utilisation of every limit by a requirement.
    #[must_use]
    pub fn demand(&self, desired: &Requirement) -> Demand {
        let (m, w) = (&self.motor, desired.speed * self.turns());
        let held = self.motor_torque(desired.tension, desired.speed, 0.0) / m.torque_constant;
        let most =
            self.motor_torque(desired.tension, desired.speed, desired.acceleration) / m.torque_constant;
        let voltage = m.resistance_at(m.hottest) * most + m.torque_constant * w;
        Demand {
            fractions: [
                (Limit::Heat, held / self.continuous_current()),
                (Limit::Current, most / m.peak_current),
                (Limit::Voltage, voltage / m.voltage),
                (Limit::Speed, w / self.top_speed),
                (Limit::ReducerTorque, desired.tension * self.arm() / self.continuous_torque),
                (Limit::Drum, desired.stroke / self.winch.capacity()),
            ],
        }
    }

    /// Copper loss at the required tension and speed with a hot winding, W.
    #[must_use]
    pub fn copper_loss(&self, desired: &Requirement) -> f64 {
        let m = &self.motor;
        let current = self.motor_torque(desired.tension, desired.speed, 0.0) / m.torque_constant;
        m.resistance_at(m.hottest) * current * current
    }
}
