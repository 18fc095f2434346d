//! Motors, reducers, winches and cords to choose from, each number with its source.

use super::motor::Motor;
use super::reducer::Reducer;
use super::winch::Winch;
use alloc::string::String;
use alloc::vec::Vec;

/// Motors, reducers, winches and cords for the design of drives.
///
/// Its file is read by [`Catalogue::from_toml`].
///
/// # Example
/// ```
/// use sinew::drive::{Catalogue, Motor};
/// let catalogue = Catalogue::built_in().expect("a file of this repository");
/// let motor = catalogue.motor("class_35mm_120w").expect("the paper's");
/// assert_eq!(motor.parameters, Motor::class_35_mm());
/// ```
#[derive(Debug, Clone, PartialEq)]
pub struct Catalogue {
    /// In file order, at least one.
    pub motors: Vec<CatalogueMotor>,
    /// In file order, at least one.
    pub reducers: Vec<CatalogueReducer>,
    /// In file order, at least one.
    pub winches: Vec<CatalogueWinch>,
    /// From the thinnest to the thickest; may be empty.
    pub cords: Vec<CatalogueCord>,
}

/// A motor with its amplifier.
#[derive(Debug, Clone, PartialEq)]
pub struct CatalogueMotor {
    /// Unique among motors.
    pub name: String,
    /// Where its numbers come from.
    pub source: String,
    /// Numbers without a source.
    pub assumed: Vec<String>,
    /// Mass of the part, kg.
    pub mass: f64,
    /// No-load current, A.
    pub no_load_current: f64,
    /// The drives that it belongs to, such as `feetech`, and whose machines alone it is offered to.
    pub drives: Option<String>,
    /// Name of the reducer that it is built together with, which is offered with it alone.
    pub reducer: Option<String>,
    /// The motor itself.
    pub parameters: Motor,
}

/// A reducer that comes in several ratios.
#[derive(Debug, Clone, PartialEq)]
pub struct CatalogueReducer {
    /// Unique among reducers.
    pub name: String,
    /// Where its numbers come from.
    pub source: String,
    /// Numbers without a source.
    pub assumed: Vec<String>,
    /// Turns of the motor per turn of the winch, each >= 1.
    pub ratios: Vec<f64>,
    /// Mass of the part, kg.
    pub mass: f64,
    /// At the motor's shaft, kg m^2.
    pub inertia: f64,
    /// Continuous torque at the winch, Nm.
    pub continuous_torque: f64,
    /// Peak torque at the winch, for a second, Nm.
    pub peak_torque: f64,
    /// Of the motor's shaft, rad/s.
    pub top_speed: f64,
    /// Whether it is a part of motors that name it, and comes with no other.
    pub built_in: bool,
    /// Losses and backlash.
    pub parameters: ReducerLosses,
}

/// A [`Reducer`] without its ratio.
#[derive(Debug, Clone, Copy, PartialEq)]
pub struct ReducerLosses {
    /// Efficiency, in (0, 1].
    pub efficiency: f64,
    /// Coulomb friction, Nm at the motor.
    pub friction: f64,
    /// Viscous friction, Nm s/rad at the motor.
    pub viscous: f64,
    /// Backlash, rad at the winch.
    pub backlash: f64,
    /// Amplitude of the ripple of friction, over the loss, 1.
    pub ripple: f64,
    /// Periods of the ripple per turn of the motor, 1.
    pub ripple_per_turn: f64,
}

/// A winch.
#[derive(Debug, Clone, PartialEq)]
pub struct CatalogueWinch {
    /// Unique among winches.
    pub name: String,
    /// Where its numbers come from.
    pub source: String,
    /// Numbers without a source.
    pub assumed: Vec<String>,
    /// The winch itself.
    pub parameters: Winch,
}

/// A cord or a rope in a lined sheath.
#[derive(Debug, Clone, PartialEq)]
pub struct CatalogueCord {
    /// Unique among cords.
    pub name: String,
    /// Where its numbers come from.
    pub source: String,
    /// Numbers without a source.
    pub assumed: Vec<String>,
    /// The cord itself.
    pub parameters: Cord,
}

/// Numbers of a [`CatalogueCord`].
#[derive(Debug, Clone, Copy, PartialEq)]
pub struct Cord {
    /// m, > 0.
    pub diameter: f64,
    /// Without knots, N, > 0.
    pub breaking_load: f64,
    /// `E A`, N, > 0.
    pub stiffness: f64,
    /// `mu` in the lining of its sheath, 1, >= 0.
    pub friction: f64,
    /// Grease drag of a sheath of 0.5 m, N s/m, >= 0.
    pub drag: f64,
}

impl CatalogueReducer {
    /// The reducer of a ratio.
    #[must_use]
    pub fn reducer(&self, ratio: f64) -> Reducer {
        let ReducerLosses { efficiency, friction, viscous, backlash, ripple, ripple_per_turn } =
            self.parameters;
        Reducer { ratio, efficiency, friction, viscous, backlash, ripple, ripple_per_turn }
    }
}

impl Catalogue {
    /// The same without the motors of other drives; none leaves those that belong to no drives.
    #[must_use]
    pub fn for_drives(mut self, drives: Option<&str>) -> Self {
        self.motors.retain(|motor| motor.drives.as_deref() == drives);
        self
    }

    /// The drives that motors belong to, by name.
    #[must_use]
    pub fn drives(&self) -> Vec<&str> {
        let mut drives: Vec<&str> = self.motors.iter().filter_map(|motor| motor.drives.as_deref()).collect();
        drives.sort_unstable();
        drives.dedup();
        drives
    }

    /// Whether a motor and a reducer can be put together.
    #[must_use]
    pub fn is_pair(&self, motor: &CatalogueMotor, reducer: &CatalogueReducer) -> bool {
        let own = |motor: &CatalogueMotor| motor.reducer.as_deref() == Some(&*reducer.name);
        own(motor) || motor.reducer.is_none() && !reducer.built_in
    }

    /// A motor by its name.
    #[must_use]
    pub fn motor(&self, name: &str) -> Option<&CatalogueMotor> {
        self.motors.iter().find(|motor| motor.name == name)
    }

    /// A reducer by its name.
    #[must_use]
    pub fn reducer(&self, name: &str) -> Option<&CatalogueReducer> {
        self.reducers.iter().find(|reducer| reducer.name == name)
    }

    /// A winch by its name.
    #[must_use]
    pub fn winch(&self, name: &str) -> Option<&CatalogueWinch> {
        self.winches.iter().find(|winch| winch.name == name)
    }
}
