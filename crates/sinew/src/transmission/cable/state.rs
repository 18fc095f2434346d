//! Cables with their state: one, or many side by side.

use super::dispatch::{InstructionSet, LANES};
use super::lanes::{Ends, Lanes, Motion, Row};
use super::law::CableLaw;
use super::step::advance;
use crate::Error;
use crate::error::{finite, non_negative, within};
use crate::transmission::Sliding;
use alloc::vec::Vec;

/// How far both ends of a cable move in one step, m, positive toward the motor; each at most 0.1 m.
#[derive(Debug, Clone, Copy, PartialEq, Default)]
pub struct EndMotion {
    /// Of the winch's surface.
    pub motor: f64,
    /// Of the anchor.
    pub anchor: f64,
}

/// What the ends of a cable felt in one step.
#[derive(Debug, Clone, Copy, PartialEq, Default)]
pub struct EndTensions {
    /// At the drive's outlet, N, >= 0.
    pub tension_in: f64,
    /// At the anchor, N, >= `T_0`.
    pub tension_out: f64,
    /// Work that friction took, J: never below -1e-12.
    pub dissipated: f64,
}

/// Longest step, s.
const LONGEST_STEP: f64 = 0.02;
/// Largest displacement of an end in one step, m.
const LARGEST_MOTION: f64 = 0.1;

fn check_interval(interval: f64) -> Result<(), Error> {
    let sane = (1e-7..=LONGEST_STEP).contains(&interval);
    within("interval", "a number of seconds in [1e-7, 0.02]", interval, sane)?;
    Ok(())
}

fn check_motion(motion: &EndMotion) -> Result<(), Error> {
    for (name, slide) in
        [("motion of the motor's end", motion.motor), ("motion of the anchor", motion.anchor)]
    {
        within(name, "within +-0.1 m in one step", slide, slide.abs() <= LARGEST_MOTION)?;
    }
    Ok(())
}

/// One cable in its sheath: a law and the tensions along it.
///
/// The same arithmetic as a lane of [`Cables`], to the bit. Equations, assumptions and source: [`cable`](super).
///
/// # Example
/// ```
/// use sinew::transmission::Sliding;
/// use sinew::transmission::cable::{Cable, CableLaw, CableParameters, EndMotion, Path};
/// let law = CableLaw::new(&Path::bench(), &CableParameters::bench(), 12)?;
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
    lanes: Lanes<1>,
    ends: EndTensions,
}

impl Cable {
    /// A slack cable without slack: the first pull finds tension.
    #[must_use]
    pub fn new(law: CableLaw) -> Self {
        let ends = EndTensions { tension_in: 0.0, tension_out: law.pretension(), dissipated: 0.0 };
        Self { lanes: Lanes::new(&[law]), ends }
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
        self.ends = self.lanes.standing(0);
        Ok(())
    }

    /// Places the cable with the same tension, N, in every cell: the middle of its dead band.
    pub(crate) fn spread(&mut self, tension: f64) {
        self.lanes.spread(0, tension);
        self.ends = self.lanes.standing(0);
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

/// Any number of cables, eight at a time.
///
/// All have the same number of cells and step together; paths and parameters may differ. The widest
/// instructions of the processor are found when it is built (AVX-512, AVX2, else what the build was made for);
/// the bits are the same with all of them, and the same as a [`Cable`]'s.
///
/// # Example
/// ```
/// use sinew::transmission::cable::{CableLaw, CableParameters, Cables, EndMotion, EndTensions, Path};
/// let law = CableLaw::new(&Path::bench(), &CableParameters::bench(), 12)?;
/// let mut cables = Cables::new(&vec![law; 15])?;
/// let mut ends = [EndTensions::default(); 15];
/// let pull = [EndMotion { motor: 1e-4, anchor: 0.0 }; 15];
/// for _ in 0..200 {
///     cables.step(1e-3, &pull, &mut ends)?;
/// }
/// assert!(ends[14].tension_in > 50.0 && ends[14].tension_out < ends[14].tension_in);
/// # Ok::<(), sinew::Error>(())
/// ```
#[derive(Debug, Clone)]
pub struct Cables {
    groups: Vec<Lanes<LANES>>,
    instructions: InstructionSet,
    count: usize,
}

impl Cables {
    /// Cables without slack and without tension.
    ///
    /// # Errors
    /// [`Error::WrongLength`] where there is no law, or where one has another number of cells than the first.
    pub fn new(laws: &[CableLaw]) -> Result<Self, Error> {
        let Some(first) = laws.first() else {
            return Err(Error::WrongLength { name: "laws", expected: 1, got: 0 });
        };
        for law in laws {
            same_length("cells of every law", first.cells(), law.cells())?;
        }
        let groups = laws.chunks(LANES).map(Lanes::new).collect();
        Ok(Self { groups, instructions: InstructionSet::detect(), count: laws.len() })
    }

    /// Number of cables.
    #[must_use]
    pub fn len(&self) -> usize {
        self.count
    }

    /// Never: there is at least one.
    #[must_use]
    pub fn is_empty(&self) -> bool {
        self.count == 0
    }

    /// Number of cells of each.
    #[must_use]
    pub fn cells(&self) -> usize {
        self.groups[0].tension.len()
    }

    /// Moves all cables: `motions: [cables]` in, `ends: [cables]` out.
    ///
    /// # Errors
    /// As [`Cable::step`], and [`Error::WrongLength`]; no cable has then moved.
    pub fn step(
        &mut self,
        interval: f64,
        motions: &[EndMotion],
        ends: &mut [EndTensions],
    ) -> Result<(), Error> {
        same_length("motions", self.count, motions.len())?;
        same_length("ends", self.count, ends.len())?;
        check_interval(interval)?;
        let sane = |m: &EndMotion| (m.motor.abs() <= LARGEST_MOTION) & (m.anchor.abs() <= LARGEST_MOTION);
        if !motions.iter().fold(true, |all, motion| all & sane(motion)) {
            motions.iter().try_for_each(check_motion)?;
        }
        let parts = motions.chunks(LANES).zip(ends.chunks_mut(LANES));
        for (group, (motions, ends)) in self.groups.iter_mut().zip(parts) {
            let mut rows = Motion { motor: Row::ZERO, anchor: Row::ZERO };
            for (k, motion) in motions.iter().enumerate() {
                rows.motor.0[k] = motion.motor;
                rows.anchor.0[k] = motion.anchor;
            }
            let mut felt = Ends { near: Row::ZERO, far: Row::ZERO, dissipated: Row::ZERO };
            self.instructions.advance(group, interval, &rows, &mut felt);
            for (k, end) in ends.iter_mut().enumerate() {
                *end = felt.of(k, group.laws[k].pretension());
            }
        }
        Ok(())
    }

    /// As [`Cable::settle`] for one cable.
    ///
    /// # Errors
    /// As there, and [`Error::OutOfDomain`] where there is no such cable.
    pub fn settle(&mut self, cable: usize, tension_out: f64, sliding: Sliding) -> Result<(), Error> {
        let (group, k) = self.place(cable)?;
        let lanes = &mut self.groups[group];
        let far = above_pretension(&lanes.laws[k], tension_out)?;
        lanes.settle(k, far, sliding);
        Ok(())
    }

    /// As [`Cable::travel_to`] for one cable.
    ///
    /// # Errors
    /// As there, and [`Error::OutOfDomain`] where there is no such cable.
    pub fn travel_to(&self, cable: usize, tension_out: f64, sliding: Sliding) -> Result<f64, Error> {
        let (group, k) = self.place(cable)?;
        let lanes = &self.groups[group];
        let far = (finite("tension_out", tension_out)? - lanes.laws[k].pretension()).max(0.0);
        Ok(lanes.travel_to(k, far, sliding))
    }

    /// As [`Cable::set_wrap`] for one cable.
    ///
    /// # Errors
    /// As there, and [`Error::OutOfDomain`] where there is no such cable.
    pub fn set_wrap(&mut self, cable: usize, pulley: usize, wrap: f64) -> Result<(), Error> {
        let (group, k) = self.place(cable)?;
        self.groups[group].set_wrap(k, pulley, wrap)
    }

    /// As [`Cable::scale_drag`] for one cable.
    ///
    /// # Errors
    /// As there, and [`Error::OutOfDomain`] where there is no such cable.
    pub fn scale_drag(&mut self, cable: usize, factor: f64) -> Result<(), Error> {
        let (group, k) = self.place(cable)?;
        self.groups[group].scale_drag(k, factor)
    }

    /// As [`Cable::lengthen`] for one cable.
    ///
    /// # Errors
    /// [`Error::OutOfDomain`] where there is no such cable.
    pub fn lengthen(&mut self, cable: usize, growth: impl Iterator<Item = f64>) -> Result<(), Error> {
        let (group, k) = self.place(cable)?;
        self.groups[group].lengthen(k, growth.map(|g| if g.is_finite() { g } else { 0.0 }));
        Ok(())
    }

    /// Tension of every cell of one cable, N, drive end first; nothing where there is no such cable.
    pub fn tensions(&self, cable: usize) -> impl Iterator<Item = f64> {
        let lanes = self.groups.get(cable / LANES).filter(|_| cable < self.count);
        lanes.into_iter().flat_map(move |lanes| lanes.tension.iter().map(move |row| row.0[cable % LANES]))
    }

    /// Total stretch of one cable, m; negative by how much a slack cable is too long.
    #[must_use]
    pub fn stretch(&self, cable: usize) -> Option<f64> {
        let lanes = self.groups.get(cable / LANES).filter(|_| cable < self.count)?;
        Some(lanes.stretch.0[cable % LANES])
    }

    fn place(&self, cable: usize) -> Result<(usize, usize), Error> {
        within("cable", "below the number of cables", cable as f64, cable < self.count)?;
        Ok((cable / LANES, cable % LANES))
    }
}

impl<const N: usize> Ends<N> {
    fn of(&self, k: usize, pretension: f64) -> EndTensions {
        EndTensions {
            tension_in: self.near.0[k],
            tension_out: self.far.0[k] + pretension,
            dissipated: self.dissipated.0[k],
        }
    }
}

impl<const N: usize> Lanes<N> {
    /// What the ends feel while nothing moves.
    fn standing(&self, k: usize) -> EndTensions {
        let last = self.tension.len() - 1;
        let tension_out = self.tension[last].0[k] + self.laws[k].pretension();
        EndTensions { tension_in: self.tension[0].0[k], tension_out, dissipated: 0.0 }
    }
}

fn above_pretension(law: &CableLaw, tension_out: f64) -> Result<f64, Error> {
    let far = finite("tension_out", tension_out)? - law.pretension();
    non_negative("tension_out - pretension", far)
}

fn same_length(name: &'static str, expected: usize, got: usize) -> Result<(), Error> {
    if expected == got { Ok(()) } else { Err(Error::WrongLength { name, expected, got }) }
}
