//! Many cables with their states, stepped together in SIMD lanes.

use super::dispatch::{LANES, advance_on, creep_on};
use super::ends::{EndMotion, EndTensions, LARGEST_MOTION, above_pretension, check_interval, check_motion};
use super::lane_group::{Ends, LaneGroup, Motion, Row};
use super::law::CableLaw;
use super::steady::{BothDirections, SteadyLanes};
use crate::Error;
use crate::dispatch::InstructionSet;
use crate::error::{check_length, finite, within};
use crate::transmission::Sliding;
use alloc::vec::Vec;

/// Any number of cables, eight at a time.
///
/// All have the same number of cells and step together; paths and parameters may differ. The widest
/// instruction set of the processor is chosen at construction (AVX-512, AVX2, else the baseline of the
/// build); results are bit-identical on all of them, and to those of a [`Cable`](super::Cable).
///
/// # Example
/// ```
/// use sinew::transmission::cable::{CableLaw, CableParameters, CableBatch, EndMotion, EndTensions, CablePath};
/// let law = CableLaw::new(&CablePath::bench(), &CableParameters::bench(), 12)?;
/// let mut cables = CableBatch::new(&vec![law; 15])?;
/// let mut ends = [EndTensions::default(); 15];
/// let pull = [EndMotion { motor: 1e-4, anchor: 0.0 }; 15];
/// for _ in 0..200 {
///     cables.step(1e-3, &pull, &mut ends)?;
/// }
/// assert!(ends[14].tension_in > 50.0 && ends[14].tension_out < ends[14].tension_in);
/// # Ok::<(), sinew::Error>(())
/// ```
#[derive(Debug, Clone)]
pub struct CableBatch {
    groups: Vec<LaneGroup<LANES>>,
    instructions: InstructionSet,
    count: usize,
}

impl CableBatch {
    /// Cables without slack and without tension, one per law.
    ///
    /// # Errors
    /// [`Error::WrongLength`] where there is no law, or where one has another number of cells than the first.
    pub fn new(laws: &[CableLaw]) -> Result<Self, Error> {
        let Some(first) = laws.first() else {
            return Err(Error::WrongLength { name: "laws", expected: 1, got: 0 });
        };
        for law in laws {
            check_length("cells of every law", law.cells(), first.cells())?;
        }
        let groups = laws.chunks(LANES).map(LaneGroup::new).collect();
        Ok(Self { groups, instructions: InstructionSet::detect(), count: laws.len() })
    }

    /// Number of cables.
    #[must_use]
    pub fn len(&self) -> usize {
        self.count
    }

    /// Always false: there is at least one cable.
    #[must_use]
    pub fn is_empty(&self) -> bool {
        self.count == 0
    }

    /// Number of cells of each.
    #[must_use]
    pub fn cells(&self) -> usize {
        self.groups[0].tension.len()
    }

    /// Advances all cables: `motions: [cables]` in, `ends: [cables]` out.
    ///
    /// # Errors
    /// As [`Cable::step`](super::Cable::step), and [`Error::WrongLength`]; all states are then unchanged.
    pub fn step(
        &mut self,
        interval: f64,
        motions: &[EndMotion],
        ends: &mut [EndTensions],
    ) -> Result<(), Error> {
        check_length("motions", motions.len(), self.count)?;
        check_length("ends", ends.len(), self.count)?;
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
            let mut stepped = Ends { near: Row::ZERO, far: Row::ZERO, dissipated: Row::ZERO };
            advance_on(self.instructions, group, interval, &rows, &mut stepped);
            for (k, end) in ends.iter_mut().enumerate() {
                *end = stepped.of(k, group.laws[k].pretension());
            }
        }
        Ok(())
    }

    /// Stretch, m, of every cable that slides steadily toward the motor, and away from it:
    /// `sliding: [cables]` in, `stretch: [cables]` out. The states take no part.
    ///
    /// # Errors
    /// As [`CableLaw::sliding`], and [`Error::WrongLength`].
    pub(crate) fn stretch_in_both_directions(
        &self,
        sliding: &[BothDirections],
        stretch: &mut [[f64; 2]],
    ) -> Result<(), Error> {
        check_length("sliding", sliding.len(), self.count)?;
        check_length("stretch", stretch.len(), self.count)?;
        let parts = sliding.chunks(LANES).zip(stretch.chunks_mut(LANES));
        for (lanes, (sliding, stretch)) in self.groups.iter().zip(parts) {
            let work = SteadyLanes { lanes, sliding, stretch };
            work.check()?;
            self.instructions.run(work);
        }
        Ok(())
    }

    /// As [`Cable::settle`](super::Cable::settle) for one cable.
    ///
    /// # Errors
    /// As there, and [`Error::OutOfDomain`] for an index out of range.
    pub fn settle(&mut self, cable: usize, tension_out: f64, sliding: Sliding) -> Result<(), Error> {
        let (group, k) = self.place(cable)?;
        let lanes = &mut self.groups[group];
        let far = above_pretension(&lanes.laws[k], tension_out)?;
        lanes.settle(k, far, sliding);
        Ok(())
    }

    /// As [`Cable::set_profile`](super::Cable::set_profile) for one cable; returns the tensions at its ends.
    pub(crate) fn set_profile(
        &mut self,
        cable: usize,
        tension_in: f64,
        fraction: f64,
        stretch: Option<f64>,
    ) -> Result<EndTensions, Error> {
        let (group, k) = self.place(cable)?;
        self.groups[group].set_profile(k, tension_in, fraction, stretch);
        Ok(self.groups[group].ends_at_rest(k))
    }

    /// Whether every node of one cable slid in the same direction in the last step.
    pub(crate) fn slides_everywhere(&self, cable: usize) -> bool {
        self.place(cable).is_ok_and(|(group, k)| self.groups[group].slides_everywhere(k))
    }

    /// As [`Cable::travel_to`](super::Cable::travel_to) for one cable.
    ///
    /// # Errors
    /// As there, and [`Error::OutOfDomain`] for an index out of range.
    pub fn travel_to(&self, cable: usize, tension_out: f64, sliding: Sliding) -> Result<f64, Error> {
        let (group, k) = self.place(cable)?;
        let lanes = &self.groups[group];
        let far = (finite("tension_out", tension_out)? - lanes.laws[k].pretension()).max(0.0);
        Ok(lanes.travel_to(k, far, sliding))
    }

    /// As [`Cable::set_wrap`](super::Cable::set_wrap) for one cable.
    ///
    /// # Errors
    /// As there, and [`Error::OutOfDomain`] for an index out of range.
    pub fn set_wrap(&mut self, cable: usize, pulley: usize, wrap: f64) -> Result<(), Error> {
        let (group, k) = self.place(cable)?;
        self.groups[group].set_wrap(k, pulley, wrap)
    }

    /// As [`Cable::set_sheath_bend`](super::Cable::set_sheath_bend) for one cable.
    ///
    /// # Errors
    /// As there, and [`Error::OutOfDomain`] for an index out of range.
    pub fn set_sheath_bend(&mut self, cable: usize, bend: f64) -> Result<(), Error> {
        let (group, k) = self.place(cable)?;
        self.groups[group].set_sheath_bend(k, bend)
    }

    /// As [`Cable::scale_drag`](super::Cable::scale_drag) for one cable.
    ///
    /// # Errors
    /// As there, and [`Error::OutOfDomain`] for an index out of range.
    pub fn scale_drag(&mut self, cable: usize, factor: f64) -> Result<(), Error> {
        let (group, k) = self.place(cable)?;
        self.groups[group].scale_drag(k, factor)
    }

    /// As [`Cable::scale_compliance`](super::Cable::scale_compliance) for one cable.
    ///
    /// # Errors
    /// As there, and [`Error::OutOfDomain`] for an index out of range.
    pub fn scale_compliance(&mut self, cable: usize, factor: f64) -> Result<(), Error> {
        let (group, k) = self.place(cable)?;
        self.groups[group].scale_compliance(k, factor)
    }

    /// As [`Cable::set_creep`](super::Cable::set_creep) for one cable.
    ///
    /// # Errors
    /// As there, and [`Error::OutOfDomain`] for an index out of range.
    pub fn set_creep(&mut self, cable: usize, fraction: f64, time: f64) -> Result<(), Error> {
        let (group, k) = self.place(cable)?;
        self.groups[group].set_creep(k, fraction, time)
    }

    /// As [`Cable::creep`](super::Cable::creep) for all cables.
    pub fn creep(&mut self, interval: f64) {
        for group in &mut self.groups {
            creep_on(self.instructions, group, interval);
        }
    }

    /// Tension of every cell of one cable, N, drive end first; empty for an index out of range.
    pub fn tensions(&self, cable: usize) -> impl Iterator<Item = f64> {
        let lanes = self.groups.get(cable / LANES).filter(|_| cable < self.count);
        lanes.into_iter().flat_map(move |lanes| lanes.tension.iter().map(move |row| row.0[cable % LANES]))
    }

    /// The law of one cable as built, with its current wraps and bend, without changes of drag and
    /// compliance.
    #[must_use]
    pub fn law(&self, cable: usize) -> Option<&CableLaw> {
        let (group, k) = self.place(cable).ok()?;
        Some(&self.groups[group].laws[k])
    }

    /// Total stretch of one cable, m; negative by the slack of a slack cable.
    #[must_use]
    pub fn stretch(&self, cable: usize) -> Option<f64> {
        let lanes = self.groups.get(cable / LANES).filter(|_| cable < self.count)?;
        Some(lanes.stretch.0[cable % LANES])
    }

    /// As [`Cable::energy`](super::Cable::energy) of one cable.
    ///
    /// # Errors
    /// [`Error::OutOfDomain`] for an index out of range.
    pub fn energy(&self, cable: usize) -> Result<f64, Error> {
        let (group, k) = self.place(cable)?;
        Ok(0.5 * self.groups[group].energy.0[k])
    }

    /// Numbers that [`save`](Self::save) writes for one cable: `2 cells + 1`, and `cells - 1` more where
    /// friction of a cable of the batch weakens with speed.
    #[must_use]
    pub fn state_len(&self) -> usize {
        let weakens = self.groups.iter().any(|group| !group.memory.is_empty());
        2 * self.cells() + 1 + if weakens { self.cells() - 1 } else { 0 }
    }

    /// Writes the state of one cable: from it the cable continues bit for bit as from its last step.
    ///
    /// Wraps, bends, drag and compliance that were changed, and creep, are not part of it.
    ///
    /// # Shapes
    /// `state: [state_len]`: stretch, m; twice the energy, J; tensions, N; slips of the last step, m; lagged
    /// speeds, m/s.
    ///
    /// # Errors
    /// [`Error::OutOfDomain`] for an index out of range, [`Error::WrongLength`].
    pub fn save(&self, cable: usize, state: &mut [f64]) -> Result<(), Error> {
        check_length("state", state.len(), self.state_len())?;
        let (group, k) = self.place(cable)?;
        self.groups[group].save(k, state);
        Ok(())
    }

    /// Takes over a state that [`save`](Self::save) wrote for a cable of the same law.
    ///
    /// # Errors
    /// As [`save`](Self::save), and [`Error::OutOfDomain`] for a number that is not finite or a negative
    /// tension; the cable is then unchanged.
    pub fn restore(&mut self, cable: usize, state: &[f64]) -> Result<(), Error> {
        check_length("state", state.len(), self.state_len())?;
        let (group, k) = self.place(cable)?;
        let tensions = 2..2 + self.cells();
        let finite = state.iter().find(|value| !value.is_finite());
        if let Some(wrong) = finite.or(state[tensions].iter().find(|tension| **tension < 0.0)) {
            within("state", "finite numbers, tensions >= 0", *wrong, false)?;
        }
        self.groups[group].restore(k, state);
        Ok(())
    }

    fn place(&self, cable: usize) -> Result<(usize, usize), Error> {
        within("cable", "below the number of cables", cable as f64, cable < self.count)?;
        Ok((cable / LANES, cable % LANES))
    }
}

#[cfg(test)]
mod tests {
    use super::super::{Cable, CableParameters, CablePath, Weakening, WeakeningForm};
    use super::*;
    use core::f64::consts::PI;
    use std::vec;

    /// Ten unlike cables: two groups, the second one not full. Friction of the first eight may weaken.
    fn laws(weakening: Option<Weakening>) -> Vec<CableLaw> {
        let law = |k: usize| {
            let friction = 0.1 + 0.01 * k as f64;
            // Forms side by side in one group, where one of them is not the default.
            let weakening = weakening.filter(|_| k < 8).map(|w| {
                let form = if k.is_multiple_of(2) { w.form } else { WeakeningForm::default() };
                Weakening { form, ..w }
            });
            let parameters = CableParameters { friction, weakening, ..CableParameters::bench() };
            CableLaw::new(&CablePath::bench(), &parameters, 7).unwrap()
        };
        (0..10).map(law).collect()
    }

    fn settled(weakening: Option<Weakening>) -> (CableBatch, Vec<Cable>) {
        let laws = laws(weakening);
        let mut batch = CableBatch::new(&laws).unwrap();
        let mut alone: Vec<_> = laws.into_iter().map(Cable::new).collect();
        for (k, cable) in alone.iter_mut().enumerate() {
            let far = 30.0 + 5.0 * k as f64;
            batch.settle(k, far, Sliding::TowardMotor).unwrap();
            cable.settle(far, Sliding::TowardMotor).unwrap();
        }
        (batch, alone)
    }

    fn motions(step: i32) -> [EndMotion; 10] {
        core::array::from_fn(|k| {
            let phase = 0.05 * f64::from(step) + k as f64;
            EndMotion { motor: 2e-4 * libm::sin(phase), anchor: 5e-5 * libm::cos(phase) }
        })
    }

    #[test]
    fn a_batch_is_its_cables_side_by_side_with_drag_that_is_scaled_and_creep() {
        let (mut batch, mut alone) = settled(None);
        assert_eq!((batch.len(), batch.cells(), batch.is_empty()), (10, 7, false));
        for (k, cable) in alone.iter_mut().enumerate() {
            let (factor, fraction, time) = (0.3 * k as f64, 0.02 * k as f64, 0.1 + k as f64);
            batch.scale_drag(k, factor).unwrap();
            cable.scale_drag(factor).unwrap();
            if k % 3 != 0 {
                batch.set_creep(k, fraction, time).unwrap();
                cable.set_creep(fraction, time).unwrap();
            }
        }
        let mut ends = [EndTensions::default(); 10];
        for step in 0..200 {
            let motions = motions(step);
            batch.step(1e-3, &motions, &mut ends).unwrap();
            batch.creep(1e-3);
            for (k, cable) in alone.iter_mut().enumerate() {
                assert_eq!(cable.step(1e-3, motions[k]).unwrap(), ends[k], "{step} {k}");
                cable.creep(1e-3);
                assert!(batch.tensions(k).eq(cable.tensions()), "{step} {k}");
                assert_eq!(batch.stretch(k), Some(cable.stretch()));
                assert_eq!(batch.energy(k), Ok(cable.energy()));
                for sliding in [Sliding::TowardMotor, Sliding::AwayFromMotor] {
                    assert_eq!(batch.travel_to(k, 90.0, sliding), cable.travel_to(90.0, sliding));
                    // Below the pretension nothing is left for the cable.
                    assert_eq!(batch.travel_to(k, 3.0, sliding), cable.travel_to(3.0, sliding));
                }
            }
        }
    }

    #[test]
    fn what_is_changed_in_one_cable_of_a_batch_is_changed_as_in_a_cable_alone_and_in_no_other() {
        let (mut batch, mut alone) = settled(None);
        batch.set_wrap(9, 0, 0.9).unwrap();
        alone[9].set_wrap(0, 0.9).unwrap();
        batch.set_sheath_bend(8, 3.0).unwrap();
        alone[8].set_sheath_bend(3.0).unwrap();
        batch.scale_compliance(7, 1.5).unwrap();
        alone[7].scale_compliance(1.5).unwrap();
        let (_, unchanged) = settled(None);
        let angle = |cable: &Cable| cable.law().friction_angle();
        // mu times the change of the angle.
        assert!((angle(&alone[9]) - angle(&unchanged[9]) - 0.19 * (0.9 - 0.5 * PI)).abs() < 1e-15);
        assert!((angle(&alone[8]) - angle(&unchanged[8]) - 0.18 * (3.0 - 1.5 * PI)).abs() < 1e-15);
        assert!((alone[7].ends().tension_in * 1.5 / unchanged[7].ends().tension_in - 1.0).abs() < 1e-15);
        let mut ends = [EndTensions::default(); 10];
        for step in 0..100 {
            batch.step(1e-3, &motions(step), &mut ends).unwrap();
            for (k, cable) in alone.iter_mut().enumerate() {
                assert_eq!(cable.step(1e-3, motions(step)[k]).unwrap(), ends[k], "{step} {k}");
                assert_eq!(batch.slides_everywhere(k), cable.slides_everywhere(), "{step} {k}");
            }
        }
        assert!(batch.set_wrap(10, 0, 0.9).is_err() && batch.set_wrap(9, 1, 0.9).is_err());
        assert!(batch.set_sheath_bend(10, 3.0).is_err() && batch.set_sheath_bend(9, -3.0).is_err());
        assert!(batch.scale_compliance(10, 1.5).is_err() && batch.scale_compliance(9, 0.0).is_err());
    }

    #[test]
    fn a_state_with_a_negative_tension_is_refused_and_one_without_tension_is_not() {
        let (mut batch, _) = settled(None);
        let mut state = vec![0.0; batch.state_len()];
        batch.save(2, &mut state).unwrap();
        for (place, number, taken) in
            [(2, 0.0, true), (8, 0.0, true), (2, -1e-9, false), (8, f64::NAN, false)]
        {
            let mut wrong = state.clone();
            wrong[place] = number;
            let before: Vec<f64> = batch.tensions(2).collect();
            assert_eq!(batch.restore(2, &wrong).is_ok(), taken, "{place} {number}");
            assert!(taken || batch.tensions(2).eq(before));
        }
    }

    #[test]
    fn a_cable_without_friction_travels_by_its_compliance_to_a_tension_above_the_pretension() {
        let parameters = CableParameters { friction: 0.0, efficiency: 1.0, ..CableParameters::bench() };
        let law = CableLaw::new(&CablePath::bench(), &parameters, 7).unwrap();
        let compliance: f64 = law.compliance().iter().sum();
        let mut batch = CableBatch::new(&vec![law; 9]).unwrap();
        batch.settle(8, 40.0, Sliding::TowardMotor).unwrap();
        for (to, sliding) in [(65.0, Sliding::TowardMotor), (20.0, Sliding::AwayFromMotor)] {
            let travel = batch.travel_to(8, to, sliding).unwrap();
            assert!((travel - compliance * (to - 40.0)).abs() < 4e-18, "{travel}");
        }
        assert!((batch.stretch(8).unwrap() - compliance * (40.0 - parameters.pretension)).abs() < 4e-18);
    }

    #[test]
    fn drag_that_is_scaled_is_the_drag_of_a_law_with_as_much_more() {
        let law = |drag: f64| {
            let parameters = CableParameters { drag, ..CableParameters::bench() };
            CableLaw::new(&CablePath::bench(), &parameters, 7).unwrap()
        };
        let mut batch = CableBatch::new(&[law(60.0), law(120.0)]).unwrap();
        batch.scale_drag(0, 2.0).unwrap();
        let mut ends = [EndTensions::default(); 2];
        for _ in 0..100 {
            batch.step(1e-3, &[EndMotion { motor: 1e-4, anchor: 2e-5 }; 2], &mut ends).unwrap();
        }
        assert_eq!(ends[0], ends[1]);
        assert!(batch.scale_drag(0, -1.0).is_err());
    }

    #[test]
    fn a_cable_continues_to_the_bit_from_a_state_that_was_written() {
        let forms = WeakeningForm::ALL.map(|form| Weakening { form, ..Weakening::rational(0.4, 4e-3, 0.04) });
        for weakening in forms.map(Some).into_iter().chain([None]) {
            let (mut batch, _) = settled(weakening);
            // Two totals, seven tensions, six slips, and six speeds where friction weakens.
            assert_eq!(batch.state_len(), if weakening.is_some() { 21 } else { 15 });
            let mut ends = [EndTensions::default(); 10];
            for step in 0..50 {
                batch.step(1e-3, &motions(step), &mut ends).unwrap();
            }
            let (mut other, _) = settled(weakening);
            let mut state = vec![f64::NAN; batch.state_len()];
            for k in 0..10 {
                batch.save(k, &mut state).unwrap();
                assert!((state[0] - batch.stretch(k).unwrap()).abs() == 0.0);
                other.restore(k, &state).unwrap();
            }
            for step in 50..100 {
                let mut again = ends;
                batch.step(1e-3, &motions(step), &mut ends).unwrap();
                other.step(1e-3, &motions(step), &mut again).unwrap();
                assert_eq!(ends, again, "{step}");
            }
            assert!(batch.save(0, &mut state[1..]).is_err() && batch.save(10, &mut state).is_err());
        }
    }

    #[test]
    fn there_is_nothing_behind_the_last_cable() {
        let (mut batch, _) = settled(None);
        assert_eq!((batch.tensions(9).count(), batch.tensions(10).count()), (7, 0));
        assert!(batch.stretch(9).is_some() && batch.stretch(10).is_none() && batch.stretch(99).is_none());
        assert!(batch.law(9).is_some() && batch.law(10).is_none() && batch.energy(10).is_err());
        assert!(batch.travel_to(10, 50.0, Sliding::TowardMotor).is_err());
        assert!(batch.set_creep(10, 0.1, 1.0).is_err() && batch.scale_drag(10, 1.0).is_err());
    }

    #[test]
    fn motion_that_is_too_far_is_refused_even_where_every_cable_moves_so() {
        let (mut batch, _) = settled(None);
        let before: Vec<f64> = batch.tensions(3).collect();
        let mut ends = [EndTensions::default(); 10];
        for far in [0.11, -0.11, f64::INFINITY, f64::NAN] {
            for motion in [EndMotion { motor: far, anchor: 0.0 }, EndMotion { motor: 0.0, anchor: far }] {
                assert!(batch.step(1e-3, &[motion; 10], &mut ends).is_err(), "{motion:?}");
                let mut one = [EndMotion::default(); 10];
                one[9] = motion;
                assert!(batch.step(1e-3, &one, &mut ends).is_err(), "{motion:?}");
            }
        }
        assert!(batch.tensions(3).eq(before));
    }
}
