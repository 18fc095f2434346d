//! One cable with its state.

use super::creep::creep;
use super::ends::{EndMotion, EndTensions, above_pretension, check_interval, check_motion};
use super::lane_group::{Ends, LaneGroup, Motion, Row};
use super::law::CableLaw;
use super::step::advance;
use crate::Error;
use crate::error::finite;
use crate::transmission::Sliding;

/// One cable in its sheath: a law and the tensions along it.
///
/// Bit-identical to a lane of [`CableBatch`](super::CableBatch). Equations, assumptions and source:
/// [`cable`](super).
///
/// # Example
/// ```
/// use sinew::transmission::Sliding;
/// use sinew::transmission::cable::{Cable, CableLaw, CableParameters, EndMotion, CablePath};
/// let law = CableLaw::new(&CablePath::bench(), &CableParameters::bench(), 12)?;
/// let mut cable = Cable::new(law);
/// cable.settle(100.0, Sliding::TowardMotor)?;
/// let pulled = cable.ends();
/// assert!(pulled.tension_in > 200.0); // 84.5 N through a friction angle of 1.054
/// // The motor pays out 5 mm: the tension falls at its end, not yet at the anchor.
/// let mut ends = pulled;
/// for _ in 0..100 {
///     ends = cable.step(1e-3, EndMotion { motor: -5e-5, anchor: 0.0 })?;
/// }
/// assert!(ends.tension_in < 0.7 * pulled.tension_in);
/// assert!((ends.tension_out - 100.0).abs() < 0.5);
/// # Ok::<(), sinew::Error>(())
/// ```
#[derive(Debug, Clone)]
pub struct Cable {
    lanes: LaneGroup<1>,
    ends: EndTensions,
}

impl Cable {
    /// A cable without tension and without slack: the first motion toward the motor tensions it.
    #[must_use]
    pub fn new(law: CableLaw) -> Self {
        let ends = EndTensions { tension_in: 0.0, tension_out: law.pretension(), dissipated: 0.0 };
        Self { lanes: LaneGroup::new(&[law]), ends }
    }

    /// The same with `count` Newton steps per time step instead of one, at least one.
    ///
    /// One suffices for steps of 1 ms at up to 0.3 m/s; after a jump of many millimetres five reach balance
    /// in one step where the cable slides on. A jump that reverses it may be off by as much as friction
    /// holds, with any number (1 mm in a step of 1 ms: up to 11 N on the bench): take shorter steps there.
    #[must_use]
    pub fn with_iterations(mut self, count: usize) -> Self {
        self.lanes.iterations = count.max(1);
        self
    }

    /// Advances the cable by `interval` seconds while its ends move.
    ///
    /// # Errors
    /// [`Error::OutOfDomain`] for a step longer than 0.02 s, an end that moves more than 0.1 m or a number
    /// that is not finite; the state is then unchanged.
    #[inline]
    pub fn step(&mut self, interval: f64, motion: EndMotion) -> Result<EndTensions, Error> {
        check_interval(interval)?;
        check_motion(&motion)?;
        let rows = Motion { motor: Row([motion.motor]), anchor: Row([motion.anchor]) };
        let mut ends = Ends { near: Row::ZERO, far: Row::ZERO, dissipated: Row::ZERO };
        advance(&mut self.lanes, interval, &rows, &mut ends);
        self.ends = ends.of(0, self.lanes.laws[0].pretension());
        Ok(self.ends)
    }

    /// Tensions at the ends after the last step.
    #[must_use]
    pub fn ends(&self) -> EndTensions {
        self.ends
    }

    /// Sets the profile of steady sliding without drag in one direction, with this tension at the anchor, N.
    ///
    /// # Errors
    /// [`Error::OutOfDomain`] where the tension is below the pretension or not finite.
    pub fn settle(&mut self, tension_out: f64, sliding: Sliding) -> Result<(), Error> {
        let far = above_pretension(&self.lanes.laws[0], tension_out)?;
        self.lanes.settle(0, far, sliding);
        self.ends = self.lanes.ends_at_rest(0);
        Ok(())
    }

    /// Sets the profile with a tension at the drive, N, and a fraction of the friction bound at every node: 1
    /// as after sliding toward the motor, -1 away from it, 0 for a constant tension. A `stretch`, m, replaces
    /// the fraction by the one that yields it.
    pub(crate) fn set_profile(&mut self, tension_in: f64, fraction: f64, stretch: Option<f64>) {
        self.lanes.set_profile(0, tension_in, fraction, stretch);
        self.ends = self.lanes.ends_at_rest(0);
    }

    /// Takes over the state of a cable of the same law that does not creep; nothing is allocated.
    pub(crate) fn copy_state(&mut self, from: &Self) {
        self.lanes.copy_state(&from.lanes);
        self.ends = from.ends;
    }

    /// Whether every node slid in the same direction in the last step.
    pub(crate) fn slides_everywhere(&self) -> bool {
        self.lanes.slides_everywhere(0)
    }

    /// Travel of the winch, m, that brings the anchor to a tension, N, while the anchor stands still.
    ///
    /// ```text
    /// E_0 = e^(s H),   E_j = E_(j-1) e^(-2 s h_j)
    /// X_s(T*) = sum_j c_j (T* E_j - T_j)   over cells with s (T* E_j - T_j) > 0
    /// ```
    ///
    /// | symbol | argument      | unit | domain | meaning                                               |
    /// |--------|---------------|------|--------|-------------------------------------------------------|
    /// | T* + T_0 | `tension_out` | N  | finite | target at the anchor; below `T_0` it is taken as `T_0`  |
    /// | s      | `sliding`     |      |        | direction in which the cable slides at the end of the travel |
    ///
    /// With `s` toward a higher (lower) target than the present tension, the anchor reaches the target after
    /// that travel. With the opposite `s` it is the backlash compensation of a reversal: it brings the drive
    /// end to the edge of sliding in that direction and leaves the far tension unchanged.
    ///
    /// # Assumes
    /// Friction without drag, which vanishes when the winch stands.
    ///
    /// # Errors
    /// [`Error::OutOfDomain`] where the tension is not finite.
    pub fn travel_to(&self, tension_out: f64, sliding: Sliding) -> Result<f64, Error> {
        let far = (finite("tension_out", tension_out)? - self.lanes.laws[0].pretension()).max(0.0);
        Ok(self.lanes.travel_to(0, far, sliding))
    }

    /// The law as built, with its current wraps and bend, without changes of drag and compliance.
    #[must_use]
    pub fn law(&self) -> &CableLaw {
        &self.lanes.laws[0]
    }

    /// Tension of every cell, N, drive end first; at the anchor acts the last one plus `T_0`.
    pub fn tensions(&self) -> impl ExactSizeIterator<Item = f64> + Clone {
        self.lanes.tension.iter().map(|row| row.0[0])
    }

    /// Slip of every node in the last step, m, positive toward the motor; zero where the cable sticks.
    pub fn slips(&self) -> impl ExactSizeIterator<Item = f64> + Clone {
        self.lanes.slip[1..self.lanes.tension.len()].iter().map(|row| row.0[0])
    }

    /// Total stretch, m; negative by the slack of a slack cable.
    #[must_use]
    pub fn stretch(&self) -> f64 {
        self.lanes.stretch.0[0]
    }

    /// Elastic energy, J, without that of `T_0`.
    #[must_use]
    pub fn energy(&self) -> f64 {
        0.5 * self.lanes.energy.0[0]
    }

    /// Sets the wrap of a pulley, counted from the drive, rad.
    ///
    /// # Errors
    /// [`Error::OutOfDomain`] for a negative wrap, a pulley the path does not have, or a friction angle
    /// too large for one node.
    pub fn set_wrap(&mut self, pulley: usize, wrap: f64) -> Result<(), Error> {
        self.lanes.set_wrap(0, pulley, wrap)
    }

    /// Sets the bend of all sheaths together, rad, distributed along them as it was.
    ///
    /// # Errors
    /// As [`CableLaw::with_sheath_bend`].
    pub fn set_sheath_bend(&mut self, bend: f64) -> Result<(), Error> {
        self.lanes.set_sheath_bend(0, bend)
    }

    /// Sets the drag to a multiple of the law's, as for grease that warms or ages.
    ///
    /// # Errors
    /// [`Error::OutOfDomain`] where the factor is negative or not finite.
    pub fn scale_drag(&mut self, factor: f64) -> Result<(), Error> {
        self.lanes.scale_drag(0, factor)
    }

    /// Sets the compliance of every cell to a multiple of the law's, as where strands have broken. The
    /// lengths of the cells are kept: tensions and energy fall as the compliance grows.
    ///
    /// # Errors
    /// [`Error::OutOfDomain`] where the factor is not positive and finite.
    pub fn scale_compliance(&mut self, factor: f64) -> Result<(), Error> {
        self.lanes.scale_compliance(0, factor)?;
        self.ends = self.lanes.ends_at_rest(0);
        Ok(())
    }

    /// Lets the cable creep from now on, and recover: a Kelvin-Voigt element in every cell, whose strain
    /// approaches `fraction` of the elastic one with the time constant `time`, s.
    ///
    /// # Errors
    /// [`Error::OutOfDomain`] for a negative fraction or a time that is not above 0.
    pub fn set_creep(&mut self, fraction: f64, time: f64) -> Result<(), Error> {
        self.lanes.set_creep(0, fraction, time)
    }

    /// Creep over an interval, s, after a step; tensions are clipped at zero. Without
    /// [`set_creep`](Self::set_creep), or where the interval is not above zero and finite, nothing changes.
    pub fn creep(&mut self, interval: f64) {
        creep(&mut self.lanes, interval);
    }
}
