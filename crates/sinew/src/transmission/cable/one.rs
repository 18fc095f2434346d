//! One cable with its state.

use super::ends::{EndMotion, EndTensions, above_pretension, check_interval, check_motion};
use super::lane_group::{Ends, LaneGroup, Motion, Row};
use super::law::CableLaw;
use super::step::advance;
use crate::Error;
use crate::error::finite;
use crate::transmission::Sliding;

#[cfg(doc)]
use super::CableBatch;

/// One cable in its sheath: a law and the tensions along it.
///
/// The same arithmetic as a lane of [`CableBatch`], to the bit. Equations, assumptions and source: [`cable`](super).
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
/// // The motor yields by 5 mm: its own tension falls, the anchor does not notice yet.
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
    /// A slack cable without slack: the first pull finds tension.
    #[must_use]
    pub fn new(law: CableLaw) -> Self {
        let ends = EndTensions { tension_in: 0.0, tension_out: law.pretension(), dissipated: 0.0 };
        Self { lanes: LaneGroup::new(&[law]), ends }
    }

    /// The same with `count` Newton steps per time step instead of one, at least one.
    ///
    /// One is enough for steps of 1 ms at up to 0.3 m/s; after a jump of many millimetres five reach balance at once.
    #[must_use]
    pub fn with_iterations(mut self, count: usize) -> Self {
        self.lanes.iterations = count.max(1);
        self
    }

    /// Moves both ends over `interval` seconds.
    ///
    /// # Errors
    /// [`Error::OutOfDomain`] where the step is longer than 0.02 s or an end moves more than 0.1 m or
    /// something is not a number; the state is then left as it was.
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

    /// What the ends felt last.
    #[must_use]
    pub fn ends(&self) -> EndTensions {
        self.ends
    }

    /// Places the cable as after long sliding in one direction, with this tension at the anchor, N.
    ///
    /// # Errors
    /// [`Error::OutOfDomain`] where the tension is below the pretension or not finite.
    pub fn settle(&mut self, tension_out: f64, sliding: Sliding) -> Result<(), Error> {
        let far = above_pretension(&self.lanes.laws[0], tension_out)?;
        self.lanes.settle(0, far, sliding);
        self.ends = self.lanes.ends_at_rest(0);
        Ok(())
    }

    /// Places the cable by its tension at the drive, N, with a share of the friction at work: 1 as after sliding
    /// toward the motor, -1 away from it, 0 the same tension everywhere; or with the share that gives a stretch, m.
    pub(crate) fn set_profile(&mut self, tension_in: f64, share: f64, stretch: Option<f64>) {
        self.lanes.set_profile(0, tension_in, share, stretch);
        self.ends = self.lanes.ends_at_rest(0);
    }

    /// Whether the whole cable slid one way in the last step.
    pub(crate) fn slides_everywhere(&self) -> bool {
        self.lanes.slides_everywhere(0)
    }

    /// Travel of the winch, m, that brings the anchor to a tension, N, while the anchor stands still.
    ///
    /// ```text
    /// E_0 = e^(s H), E_j = E_(j-1) e^(-2 s h_j);  X_s(T*) = sum_j c_j (T* E_j - T_j)  over cells with s (T* E_j - T_j) > 0
    /// ```
    ///
    /// | symbol | argument      | unit | domain | meaning                                               |
    /// |--------|---------------|------|--------|-------------------------------------------------------|
    /// | T* + T_0 | `tension_out` | N  | finite | wanted at the anchor; below `T_0` it is taken as `T_0`  |
    /// | s      | `sliding`     |      |        | the direction in which the cable shall slide at the end |
    ///
    /// Toward the motor where more tension is wanted than is there, away where less: after that travel the
    /// anchor has what was wanted. In the other direction it is the travel that prepares a reversal: it
    /// brings the near end to the edge of sliding that way and leaves the far end as it is.
    ///
    /// # Assumes
    /// Friction without drag: what drag adds is gone when the winch stands.
    ///
    /// # Errors
    /// [`Error::OutOfDomain`] where the tension is not finite.
    pub fn travel_to(&self, tension_out: f64, sliding: Sliding) -> Result<f64, Error> {
        let far = (finite("tension_out", tension_out)? - self.lanes.laws[0].pretension()).max(0.0);
        Ok(self.lanes.travel_to(0, far, sliding))
    }

    /// The law as built, wraps as they are now.
    #[must_use]
    pub fn law(&self) -> &CableLaw {
        &self.lanes.laws[0]
    }

    /// Tension of every cell, N, drive end first; the anchor feels the last one plus `T_0`.
    pub fn tensions(&self) -> impl ExactSizeIterator<Item = f64> + Clone {
        self.lanes.tension.iter().map(|row| row.0[0])
    }

    /// Slip of every node in the last step, m, positive toward the motor; zero where the cable sticks.
    pub fn slips(&self) -> impl ExactSizeIterator<Item = f64> + Clone {
        self.lanes.slip[1..self.lanes.tension.len()].iter().map(|row| row.0[0])
    }

    /// Total stretch, m; negative by how much a slack cable is too long.
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

    /// Sets the drag to a multiple of what the law says: grease that warms or ages.
    ///
    /// # Errors
    /// [`Error::OutOfDomain`] where the factor is negative or not finite.
    pub fn scale_drag(&mut self, factor: f64) -> Result<(), Error> {
        self.lanes.scale_drag(0, factor)
    }

    /// Lengthens the unloaded cable cell by cell, m: creep. A cell gives up no more tension than it has.
    pub fn lengthen(&mut self, growth: impl Iterator<Item = f64>) {
        self.lanes.lengthen(0, growth.map(|g| if g.is_finite() { g } else { 0.0 }));
    }
}
