use super::Stribeck;
use crate::error::{Error, positive, within};
use alloc::vec;
use alloc::vec::Vec;

/// Generalised Maxwell slip: springs in parallel, each of which sticks or slips independently.
///
/// ```text
/// F = sum_i F_i + D(v),   limit_i = alpha_i N mu(v)
/// stick:  dF_i = k_i dx                            until F_i sign(v) reaches limit_i
/// slip:   dF_i/dt = sign(v) C (alpha_i - F_i sign(v)/(N mu(v)))      until the motion reverses
/// ```
///
/// | symbol | argument     | unit | domain      | meaning                                        |
/// |--------|--------------|------|-------------|------------------------------------------------|
/// | k_i    | `stiffness`  | N/m  | > 0         | spring of element `i`                           |
/// | alpha_i| `share`      | 1    | > 0, sum 1  | its share of the sliding force                  |
/// | mu(v), D(v) | `friction` |   |             | steady-state curve and drag, [`Stribeck`]       |
/// | C      | `attraction` | N/s  | > 0 or none | how fast a slipping force follows the curve; `None` at once |
/// | N      | `load`       | N    | >= 0        | what friction is proportional to                |
/// | dx     | `slide`      | m    | finite      | displacement of this step, `v = dx/dt`          |
/// | dt     | `interval`   | s    | > 0         | length of this step                             |
///
/// # Shapes
/// `elements: [n]`, `SlipState::forces: [n]`.
///
/// # Assumes
/// Constant velocity within a step; implicit in the slip phase, hence stable for every `C dt`.
///
/// # Departs
/// A slipping element may gain force no faster than its spring would give it: as published, a large `C`
/// creates energy where friction rises again. An element whose limit has fallen drops to the limit at once.
/// With both, `F dx >= sum_i (F_i1^2 - F_i0^2)/(2 k_i)` in every step.
///
/// # Example
/// ```
/// use sinew::transmission::{MaxwellSlip, SlipElement, Stribeck};
/// let elements = [SlipElement { stiffness: 1e4, share: 0.5 }, SlipElement { stiffness: 1e3, share: 0.5 }];
/// let law = MaxwellSlip::new(&elements, Stribeck::coulomb(0.1)?, None)?;
/// let mut state = law.state();
/// assert!((law.step(&mut state, 1e-5, 100.0, 1e-3) - 0.11).abs() < 1e-12);  // both stick
/// assert!((law.step(&mut state, 1.0, 100.0, 1e-3) - 10.0).abs() < 1e-12);   // both slip
/// # Ok::<(), sinew::Error>(())
/// ```
///
/// # Source
/// `albender2005`; without speed dependence it is the Prandtl-Ishlinskii stop model of `brokate1996`.
#[derive(Debug, Clone, PartialEq)]
#[doc(alias = "gms")]
pub struct MaxwellSlip {
    elements: Vec<SlipElement>,
    friction: Stribeck,
    attraction: Option<f64>,
}

/// One spring of [`MaxwellSlip`].
#[derive(Debug, Clone, Copy, PartialEq)]
pub struct SlipElement {
    /// Its stiffness, N/m, above zero.
    pub stiffness: f64,
    /// Its share of the sliding force, above zero; all shares sum to 1.
    pub share: f64,
}

/// State of [`MaxwellSlip`]: made by [`MaxwellSlip::state`], zero at first.
#[derive(Debug, Clone, PartialEq)]
pub struct SlipState {
    forces: Vec<f64>,
    slipping: Vec<bool>,
    forward: bool,
}

impl SlipState {
    /// Force of every element, N.
    #[must_use]
    pub fn forces(&self) -> &[f64] {
        &self.forces
    }
}

impl MaxwellSlip {
    /// A law of checked parameters.
    ///
    /// # Errors
    /// [`Error::WrongLength`] without elements, [`Error::OutOfDomain`] names the parameter outside its
    /// domain.
    pub fn new(elements: &[SlipElement], friction: Stribeck, attraction: Option<f64>) -> Result<Self, Error> {
        if elements.is_empty() {
            return Err(Error::WrongLength { name: "elements", expected: 1, got: 0 });
        }
        for element in elements {
            positive("stiffness", element.stiffness)?;
            positive("share", element.share)?;
        }
        let total: f64 = elements.iter().map(|element| element.share).sum();
        within("sum of shares", "1", total, (total - 1.0).abs() <= 1e-9)?;
        if let Some(rate) = attraction {
            positive("attraction", rate)?;
        }
        Ok(Self { elements: elements.to_vec(), friction, attraction })
    }

    /// A state for this law, without force.
    #[must_use]
    pub fn state(&self) -> SlipState {
        let n = self.elements.len();
        SlipState { forces: vec![0.0; n], slipping: vec![false; n], forward: true }
    }

    /// The springs.
    #[must_use]
    pub fn elements(&self) -> &[SlipElement] {
        &self.elements
    }

    /// One step: the total force, N. Arguments outside their domain leave the state and report its force;
    /// of a state made by another law only the elements that both have are moved.
    pub fn step(&self, state: &mut SlipState, slide: f64, load: f64, interval: f64) -> f64 {
        let velocity = slide / interval;
        let sliding = interval > 0.0 && load >= 0.0 && velocity.is_finite() && velocity.abs() > 0.0;
        let strength = load * self.friction.coefficient_unchecked(velocity.abs());
        let drag = self.friction.drag_unchecked(velocity);
        if !(sliding && strength.is_finite() && drag.is_finite()) {
            return state.forces.iter().sum();
        }
        let forward = slide > 0.0;
        if forward != state.forward {
            state.slipping.fill(false);
            state.forward = forward;
        }
        let sign = if forward { 1.0 } else { -1.0 };
        let mut total = drag;
        let states = state.forces.iter_mut().zip(&mut state.slipping);
        for (element, (force, slipping)) in self.elements.iter().zip(states) {
            let (next, slips) =
                self.advance(element, sign * *force, *slipping, slide.abs(), strength, interval);
            *force = sign * next;
            *slipping = slips;
            total += *force;
        }
        total
    }

    /// Force and slip of one element, seen in the direction of motion.
    fn advance(
        &self,
        element: &SlipElement,
        force: f64,
        slipping: bool,
        distance: f64,
        strength: f64,
        interval: f64,
    ) -> (f64, bool) {
        let limit = element.share * strength;
        let trial = (force + element.stiffness * distance).max(-limit);
        if !slipping && trial < limit {
            return (trial, false);
        }
        let from = if slipping { force } else { force.max(limit) };
        let followed = match self.attraction {
            Some(rate) if strength > 0.0 => {
                (from + interval * rate * element.share) / (1.0 + interval * rate / strength)
            }
            _ => limit,
        };
        (followed.min(trial), true)
    }
}

#[cfg(test)]
mod tests {
    use super::*;
    use crate::transmission::Play;

    #[test]
    fn one_element_without_speed_dependence_is_a_stop() {
        let element = [SlipElement { stiffness: 1e4, share: 1.0 }];
        let law = MaxwellSlip::new(&element, Stribeck::coulomb(0.2).unwrap(), None).unwrap();
        let stop = Play::new(0.2 * 50.0 / 1e4).unwrap();
        let (mut state, mut play, mut last) = (law.state(), 0.0, 0.0);
        for i in 0..5000 {
            let t = f64::from(i) * 1e-2;
            let x = 3e-3 * libm::sin(t) + 1e-3 * libm::sin(7.3 * t);
            let force = law.step(&mut state, x - last, 50.0, 1e-3);
            play = stop.step(play, x);
            assert!((force - 1e4 * stop.stop(play, x)).abs() < 1e-8);
            last = x;
        }
    }

    #[test]
    fn steady_sliding_is_the_stribeck_curve() {
        let curve = Stribeck::new(0.1, 0.2, 1e-3, 0.0, 3.0).unwrap();
        let elements: Vec<_> =
            (1..=4).map(|i| SlipElement { stiffness: 1e4 * f64::from(i), share: 0.25 }).collect();
        for attraction in [None, Some(1e3)] {
            let law = MaxwellSlip::new(&elements, curve, attraction).unwrap();
            for velocity in [-0.05, -5e-4, 1e-3, 0.2] {
                let mut state = law.state();
                let mut force = 0.0;
                for _ in 0..5000 {
                    force = law.step(&mut state, velocity * 1e-3, 40.0, 1e-3);
                }
                let exact = (40.0 * curve.coefficient(velocity).unwrap()).copysign(velocity)
                    + curve.drag_force(velocity).unwrap();
                assert!((force - exact).abs() < 1e-6, "{force} {exact}");
            }
        }
    }

    #[test]
    fn a_slipping_force_lags_behind_the_curve() {
        let curve = Stribeck::new(0.1, 0.2, 1e-3, 0.0, 0.0).unwrap();
        let element = [SlipElement { stiffness: 1e5, share: 1.0 }];
        let law = MaxwellSlip::new(&element, curve, Some(50.0)).unwrap();
        let mut state = law.state();
        for _ in 0..2000 {
            law.step(&mut state, 1e-7, 100.0, 1e-3);
        }
        let slow = state.forces()[0];
        let soon = law.step(&mut state, 1e-4, 100.0, 1e-3);
        assert!((slow - 100.0 * curve.coefficient(1e-4).unwrap()).abs() < 1e-3);
        assert!(soon < slow && soon > slow - 0.1, "friction memory: {soon} after {slow}");
    }

    #[test]
    fn shares_must_sum_to_one() {
        let curve = Stribeck::coulomb(0.1).unwrap();
        let half = SlipElement { stiffness: 1.0, share: 0.5 };
        assert!(MaxwellSlip::new(&[half], curve, None).is_err());
        assert!(MaxwellSlip::new(&[half, half], curve, Some(0.0)).is_err());
        assert!(MaxwellSlip::new(&[], curve, None).is_err());
        assert!(MaxwellSlip::new(&[half, half], curve, None).is_ok());
    }

    fn of_two(attraction: Option<f64>) -> MaxwellSlip {
        let curve = Stribeck::new(0.1, 0.2, 1e-3, 0.0, 3.0).unwrap();
        let elements =
            [SlipElement { stiffness: 1e5, share: 0.4 }, SlipElement { stiffness: 2e4, share: 0.6 }];
        let law = MaxwellSlip::new(&elements, curve, attraction).unwrap();
        assert_eq!(law.elements(), elements);
        law
    }

    #[test]
    fn outside_the_domain_the_state_is_held_and_its_force_reported() {
        let law = of_two(None);
        let mut state = law.state();
        law.step(&mut state, 1e-5, 100.0, 1e-3);
        let held = state.clone();
        let force: f64 = held.forces().iter().sum();
        assert!(force > 1.0);
        for (slide, load, interval) in [
            (1e-4, 100.0, -1e-3),
            (1e-4, 100.0, 0.0),
            (1e-4, 100.0, f64::NAN),
            (1e-4, -1.0, 1e-3),
            (1e-4, f64::NAN, 1e-3),
            (1e-4, f64::INFINITY, 1e-3),
            (f64::NAN, 100.0, 1e-3),
            (f64::INFINITY, 100.0, 1e-3),
            (1e306, 100.0, 1e-3),
        ] {
            let reported = law.step(&mut state, slide, load, interval);
            assert!((reported - force).abs() < 1e-15, "{slide} {load} {interval}");
            assert_eq!(state, held, "{slide} {load} {interval}");
        }
    }

    #[test]
    fn a_pause_does_not_end_a_slip() {
        let law = of_two(Some(50.0));
        let mut state = law.state();
        for _ in 0..50 {
            law.step(&mut state, 1e-6, 100.0, 1e-3);
        }
        let moving = state.clone();
        law.step(&mut state, 0.0, 100.0, 1e-3);
        assert_eq!(state, moving);
    }

    #[test]
    fn an_element_that_sticks_reaches_its_limit_by_its_spring_however_slow_the_attraction() {
        // One spring of 1e5 N/m with a limit of 10 N: two steps of 60 um, of which the second one breaks it away.
        let law = MaxwellSlip::new(
            &[SlipElement { stiffness: 1e5, share: 1.0 }],
            Stribeck::coulomb(0.1).unwrap(),
            Some(1e-3),
        )
        .unwrap();
        let mut state = law.state();
        assert!((law.step(&mut state, 6e-5, 100.0, 1e-3) - 6.0).abs() < 1e-12);
        assert!((law.step(&mut state, 6e-5, 100.0, 1e-3) - 10.0).abs() < 4e-15);
        // The limit doubles: the slipping force follows it at its own slow rate.
        let slipping = law.step(&mut state, 6e-5, 200.0, 1e-3);
        assert!((slipping - 10.0).abs() < 1e-6, "{slipping}");
    }

    #[test]
    fn without_load_every_element_lets_go_however_slow_the_attraction() {
        // The slowest of all, so slow that over a step it is no number.
        for attraction in [None, Some(50.0), Some(f64::from_bits(1))] {
            let law = of_two(attraction);
            let mut state = law.state();
            law.step(&mut state, 1e-5, 100.0, 1e-3);
            let drag = law.step(&mut state, 1e-5, 0.0, 1e-3);
            assert!(state.forces().iter().all(|force| *force == 0.0), "{attraction:?} {state:?}");
            assert!((drag - 3.0 * 1e-2).abs() < 1e-17, "{drag}");
        }
    }
}
