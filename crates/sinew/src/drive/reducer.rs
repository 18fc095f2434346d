use crate::error::{Error, non_negative, positive, within};
use crate::lanes::abreast;

/// Reducer: ratio, losses that grow with the load, backlash, ripple.
///
/// ```text
/// J w' = tau_m - tau_L/n - b w - tau_f sign(w),    J the rotor's, all at the motor's shaft
/// tau_f = tau_c + |tau_L|/n (1/eta - 1) (1 + a cos(p theta))     while the motor drives the load   (tau_L w > 0)
/// tau_f = tau_c + |tau_L|/n (1 - eta)   (1 + a cos(p theta))     while the load drives the motor   (tau_L w < 0)
/// ```
///
/// | symbol | argument      | unit    | domain    | meaning                                             |
/// |--------|---------------|---------|-----------|-----------------------------------------------------|
/// | n      | `ratio`       | 1       | >= 1      | turns of the motor per turn of the winch               |
/// | eta    | `efficiency`  | 1       | (0, 1]    | efficiency under a high load                            |
/// | tau_c  | `friction`    | Nm      | >= 0      | dry friction without load, at the motor                |
/// | b      | `viscous`     | Nm s/rad | >= 0     | grease, at the motor                                   |
/// | g      | `backlash`    | rad     | >= 0      | at the winch, between the flanks                        |
/// | a, p   | `ripple`, `ripple_per_turn` | 1 | [0, 1), > 0 | of the losses over the motor's turn           |
///
/// Losses are Coulomb friction in either direction of power, integrated implicitly: they can stop the motion
/// but not drive it, so that an unpowered reducer gains no energy in any quadrant.
///
/// # Assumes
/// Rigid; its inertia is part of the rotor's; a cable under tension keeps the gear on one flank, so that
/// backlash acts only without tension.
///
/// # Source
/// Textbook; `ratio` 53 of `yuan2023`, the rest assumed for reducers of this size.
#[derive(Debug, Clone, Copy, PartialEq)]
pub struct Reducer {
    /// Turns of the motor per turn of the winch, 1.
    pub ratio: f64,
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

abreast!(ReducerRows of Reducer {
    f64: ratio efficiency friction viscous backlash ripple ripple_per_turn
});

impl Reducer {
    /// The paper's 53 : 1 with an assumed efficiency of 0.7 and six minutes of arc of backlash.
    #[must_use]
    pub fn ratio_53() -> Self {
        Self {
            ratio: 53.0,
            efficiency: 0.7,
            friction: 4e-3,
            viscous: 2e-6,
            backlash: 1.7e-3,
            ripple: 0.1,
            ripple_per_turn: 2.0,
        }
    }

    /// Checks every number.
    ///
    /// # Errors
    /// [`Error::OutOfDomain`] names the number outside its domain.
    pub fn validate(&self) -> Result<(), Error> {
        let (ratio, eta) = (self.ratio, self.efficiency);
        within("ratio", "a finite number >= 1", ratio, ratio.is_finite() && ratio >= 1.0)?;
        within("efficiency", "a number in (0, 1]", eta, eta > 0.0 && eta <= 1.0)?;
        non_negative("friction", self.friction)?;
        non_negative("viscous", self.viscous)?;
        non_negative("backlash", self.backlash)?;
        within("ripple", "a number in [0, 1)", self.ripple, (0.0..1.0).contains(&self.ripple))?;
        positive("ripple_per_turn", self.ripple_per_turn)?;
        Ok(())
    }

    /// Dry friction at the motor, Nm, under a load torque at the winch while turning in the direction of
    /// `sign`.
    #[inline(always)]
    #[must_use]
    pub fn loss(&self, load: f64, sign: f64, angle: f64) -> f64 {
        let fraction = if load * sign > 0.0 { 1.0 / self.efficiency - 1.0 } else { 1.0 - self.efficiency };
        let ripple = 1.0 + self.ripple * wave(self.ripple_per_turn * angle);
        self.friction + load.abs() / self.ratio * fraction * ripple
    }

    /// A step of `h` seconds under a torque `drive - brake w` at the motor and `load` at the winch, Nm and Nm
    /// s/rad.
    ///
    /// Friction is implicit: it stops the shaft and holds it up to its limit.
    #[inline(always)]
    #[must_use]
    pub fn turn(&self, shaft: Shaft, drive: f64, brake: f64, load: f64, h: f64) -> Turn {
        let Shaft { inertia, speed, angle } = shaft;
        let heavy = inertia + h * (self.viscous + brake);
        let free = inertia * speed + h * (drive - load / self.ratio);
        let sign = if free > 0.0 { 1.0 } else { -1.0 };
        let rubbed = (h * self.loss(load, sign, angle)).min(free.abs());
        let after = sign * (free.abs() - rubbed) / heavy;
        let change = after - speed;
        let lost = after.abs() * (rubbed + h * self.viscous * after.abs()) + 0.5 * inertia * change * change;
        Turn { speed: after, lost }
    }
}

/// A motor's shaft at the start of a step.
#[derive(Debug, Clone, Copy, PartialEq)]
pub struct Shaft {
    /// Of the rotor, kg m^2.
    pub inertia: f64,
    /// Speed of the shaft, rad/s.
    pub speed: f64,
    /// Angle of the shaft, rad.
    pub angle: f64,
}

/// A motor's shaft at the end of a step.
#[derive(Debug, Clone, Copy, PartialEq)]
pub struct Turn {
    /// rad/s; the shaft moves by this times the step.
    pub speed: f64,
    /// Energy lost in friction and in the change of speed at once (`J dw^2/2` of the implicit step), J, >= 0.
    pub lost: f64,
}

abreast!(TurnRows of Turn { f64: speed lost });

/// A cosine to a thousandth, from two parabolas with one correction: exact enough for an assumed ripple.
#[inline(always)]
fn wave(phase: f64) -> f64 {
    // 1.5 * 2^52: adding it leaves the nearest integer in the low bits of the mantissa.
    const ROUND: f64 = 6_755_399_441_055_744.0;
    const TURN: f64 = 2.0 * core::f64::consts::PI;
    let turns = phase * (1.0 / TURN) + 0.25;
    let part = turns - ((turns + ROUND) - ROUND);
    let parabola = part * (8.0 - 16.0 * part.abs());
    parabola * (0.775 + 0.225 * parabola.abs())
}

#[cfg(test)]
mod tests {
    use super::*;
    use proptest::prelude::*;

    proptest! {
        #[test]
        fn an_unpowered_reducer_gains_no_energy_in_any_quadrant(
            speed in -800.0..800.0_f64, load in -10.0..10.0_f64, angle in 0.0..6.3_f64,
            efficiency in 0.05..1.0_f64, friction in 0.0..0.01_f64,
        ) {
            let reducer = Reducer { efficiency, friction, ..Reducer::ratio_53() };
            let (inertia, h) = (6.5e-6, 1e-3);
            let Turn { speed: after, lost } = reducer.turn(Shaft { inertia, speed, angle }, 0.0, 0.0, load, h);
            // The cable moves at the final speed: work of the load, and energy gained by the rotor.
            let work = -load / reducer.ratio * h * after;
            let gained = 0.5 * inertia * (after * after - speed * speed);
            prop_assert!(lost >= 0.0);
            prop_assert!((gained + lost - work).abs() <= 1e-12 + 1e-9 * work.abs(), "{gained} {lost} {work}");
        }
    }

    #[test]
    fn the_ripple_is_nearly_a_cosine_and_never_more_than_one() {
        for k in -2000..2000 {
            let phase = f64::from(k) * 0.017;
            assert!((wave(phase) - phase.cos()).abs() < 1.1e-3 && wave(phase).abs() <= 1.0, "{phase}");
        }
    }

    #[test]
    fn the_efficiency_holds_for_a_driven_and_for_a_driving_load() {
        let quiet = Reducer { friction: 0.0, viscous: 0.0, ripple: 0.0, ..Reducer::ratio_53() };
        let load = 3.0;
        // At constant speed the motor's torque balances load and loss.
        let pull = load / quiet.ratio + quiet.loss(load, 1.0, 0.0);
        assert!((load / quiet.ratio / pull - quiet.efficiency).abs() < 1e-12);
        let hold = load / quiet.ratio - quiet.loss(load, -1.0, 0.0);
        assert!((hold / (load / quiet.ratio) - quiet.efficiency).abs() < 1e-12);
    }

    #[test]
    fn friction_holds_up_to_its_limit() {
        let reducer = Reducer { ripple: 0.0, ..Reducer::ratio_53() };
        let most = reducer.loss(0.0, 1.0, 0.0);
        let shaft = Shaft { inertia: 6.5e-6, speed: 0.0, angle: 0.0 };
        assert!(reducer.turn(shaft, 0.99 * most, 0.0, 0.0, 1e-3).speed.abs() < 1e-15);
        assert!(reducer.turn(shaft, 1.5 * most, 0.0, 0.0, 1e-3).speed > 0.0);
    }

    #[test]
    fn numbers_outside_their_domain_are_named() {
        for (wrong, name) in [
            (Reducer { ratio: 0.5, ..Reducer::ratio_53() }, "ratio"),
            (Reducer { efficiency: 0.0, ..Reducer::ratio_53() }, "efficiency"),
            (Reducer { backlash: f64::NAN, ..Reducer::ratio_53() }, "backlash"),
            (Reducer { ripple: 1.0, ..Reducer::ratio_53() }, "ripple"),
        ] {
            assert!(std::string::ToString::to_string(&wrong.validate().unwrap_err()).contains(name));
        }
    }
}
