//! The observers of all cables of a robot, eight at a time in SIMD lanes.

use super::model::{CableModel, CableSample};
use super::observer_state::{CableEstimate, InitialProfile, ObserverState, between, parts, substeps};
use crate::Error;
use crate::transmission::Sliding;
use crate::transmission::cable::{CableBatch, CableLaw, EndMotion, EndTensions};
use alloc::vec;
use alloc::vec::Vec;

/// [`CableObserver`](super::CableObserver)s side by side: sampled together, otherwise independent.
///
/// Bit-identical to single observers while no end moves more than half a millimetre between samples:
/// beyond, all cables take as many steps as the one that moves farthest.
///
/// # Example
/// ```
/// use sinew::predictor::{CableEstimate, CableModel, CableObservers, CableSample};
/// let mut observers = CableObservers::new(&vec![CableModel::bench(); 15])?;
/// let mut estimates = [CableEstimate::default(); 15];
/// let samples = [CableSample { motor: 0.0, anchor: 0.0, tension_in: 40.0 }; 15];
/// observers.step(1e-3, &samples, &mut estimates)?;
/// assert_eq!(estimates[14].tension_in, 40.0);
/// # Ok::<(), sinew::Error>(())
/// ```
#[derive(Debug, Clone)]
pub struct CableObservers {
    cables: CableBatch,
    states: Vec<ObserverState>,
    motions: Vec<EndMotion>,
    ends: Vec<EndTensions>,
    /// The samples before, and room for those on the way.
    from: Vec<CableSample>,
    way: Vec<CableSample>,
}

impl CableObservers {
    /// Observers before their first sample, one per model; all models have the same number of cells.
    ///
    /// # Errors
    /// As [`CableModel::law`] and [`CableBatch::new`].
    pub fn new(models: &[CableModel]) -> Result<Self, Error> {
        let laws = models.iter().map(CableModel::law).collect::<Result<Vec<CableLaw>, _>>()?;
        Ok(Self {
            cables: CableBatch::new(&laws)?,
            states: models.iter().zip(&laws).map(|(model, law)| ObserverState::new(model, law)).collect(),
            motions: vec![EndMotion::default(); models.len()],
            ends: vec![EndTensions::default(); models.len()],
            from: vec![CableSample::default(); models.len()],
            way: vec![CableSample::default(); models.len()],
        })
    }

    /// The next samples start all observers.
    pub fn reset(&mut self) {
        self.states.iter_mut().for_each(ObserverState::reset);
    }

    /// One step with a sample of every cable, `interval` seconds after the one before: `samples: [cables]`
    /// in, `estimates: [cables]` out.
    ///
    /// # Errors
    /// [`Error::WrongLength`]. Every sample gives an estimate.
    pub fn step(
        &mut self,
        interval: f64,
        samples: &[CableSample],
        estimates: &mut [CableEstimate],
    ) -> Result<(), Error> {
        let expected = self.states.len();
        for (name, got) in [("samples", samples.len()), ("estimates", estimates.len())] {
            if got != expected {
                return Err(Error::WrongLength { name, expected, got });
            }
        }
        let n = parts(interval);
        if n > 1.0 {
            self.approach(interval / n, n, samples, estimates)?;
        }
        self.step_once(interval / n, samples, estimates)
    }

    /// All parts of the way to the samples but the last.
    fn approach(
        &mut self,
        interval: f64,
        n: f64,
        samples: &[CableSample],
        estimates: &mut [CableEstimate],
    ) -> Result<(), Error> {
        for ((from, state), sample) in self.from.iter_mut().zip(&self.states).zip(samples) {
            *from = state.last_sample(sample);
        }
        let mut way = core::mem::take(&mut self.way);
        let stepped = (1..n as u32).try_for_each(|part| {
            for ((at, from), sample) in way.iter_mut().zip(&self.from).zip(samples) {
                *at = between(from, sample, f64::from(part) / n);
            }
            self.step_once(interval, &way, estimates)
        });
        self.way = way;
        stepped
    }

    fn step_once(
        &mut self,
        interval: f64,
        samples: &[CableSample],
        estimates: &mut [CableEstimate],
    ) -> Result<(), Error> {
        let (mut n, mut moving) = (1.0_f64, false);
        for (k, (state, sample)) in self.states.iter_mut().zip(samples).enumerate() {
            self.motions[k] = match state.end_motion(interval, sample) {
                Some(motion) => {
                    moving = true;
                    motion
                }
                None => {
                    let InitialProfile { tension_in, friction_fraction, stretch } = state.initialize(sample);
                    self.ends[k] = self.cables.set_profile(k, tension_in, friction_fraction, stretch)?;
                    EndMotion::default()
                }
            };
            n = n.max(substeps(&self.motions[k]));
        }
        // Observers that start do not move.
        if moving && interval > 0.0 {
            self.advance(interval, n);
        }
        for (k, ((state, sample), estimate)) in self.states.iter_mut().zip(samples).zip(estimates).enumerate()
        {
            *estimate = state.update(sample, self.ends[k], self.cables.stretch(k).unwrap_or(0.0));
            if let Some(factor) = state.changed_drag(self.cables.slides_everywhere(k), self.ends[k]) {
                self.cables.scale_drag(k, factor)?;
            }
        }
        Ok(())
    }

    /// Takes over the state of one cable of observers of the same models; `profile` is room for
    /// [`CableBatch::state_len`] numbers. Nothing is allocated.
    ///
    /// # Errors
    /// As [`CableBatch::save`].
    pub(crate) fn copy_cable(&mut self, cable: usize, from: &Self, profile: &mut [f64]) -> Result<(), Error> {
        from.cables.save(cable, profile)?;
        self.cables.restore(cable, profile)?;
        self.states[cable].clone_from(&from.states[cable]);
        self.cables.scale_drag(cable, self.states[cable].drag_factor())
    }

    /// The estimated cables with their profiles.
    #[must_use]
    pub fn cables(&self) -> &CableBatch {
        &self.cables
    }

    /// As [`CableObserver::travel_to`](super::CableObserver::travel_to) for one cable.
    ///
    /// # Errors
    /// As [`CableBatch::travel_to`].
    pub fn travel_to(&self, cable: usize, tension_out: f64, sliding: Sliding) -> Result<f64, Error> {
        self.cables.travel_to(cable, tension_out, sliding)
    }

    /// As [`CableObserver::set_wrap`](super::CableObserver::set_wrap) for one cable.
    ///
    /// # Errors
    /// As [`CableBatch::set_wrap`].
    pub fn set_wrap(&mut self, cable: usize, pulley: usize, wrap: f64) -> Result<(), Error> {
        self.cables.set_wrap(cable, pulley, wrap)?;
        if let Some(law) = self.cables.law(cable) {
            self.states[cable].update_law(law);
        }
        Ok(())
    }

    /// As [`CableBatch::set_sheath_bend`].
    ///
    /// # Errors
    /// As there.
    pub fn set_sheath_bend(&mut self, cable: usize, bend: f64) -> Result<(), Error> {
        self.cables.set_sheath_bend(cable, bend)?;
        if let Some(law) = self.cables.law(cable) {
            self.states[cable].update_law(law);
        }
        Ok(())
    }

    fn advance(&mut self, interval: f64, n: f64) {
        for motion in &mut self.motions {
            *motion = EndMotion { motor: motion.motor / n, anchor: motion.anchor / n };
        }
        for _ in 0..n as usize {
            // Only an interval of nanoseconds is refused, which no sampling has.
            if self.cables.step(interval / n, &self.motions, &mut self.ends).is_err() {
                return;
            }
            for (k, state) in self.states.iter_mut().enumerate().filter(|(_, state)| !state.converged) {
                state.record_sliding(self.cables.slides_everywhere(k), interval / n);
            }
        }
    }
}

#[cfg(test)]
mod tests {
    use super::super::CableObserver;
    use super::*;

    #[test]
    fn observers_side_by_side_equal_single_observers_to_the_bit() {
        let models: Vec<CableModel> = (0..11)
            .map(|k| {
                let mut model = CableModel::bench();
                model.parameters.friction *= 0.8 + 0.04 * f64::from(k);
                // No correction is a motion of several steps, also after a pause.
                model.correction = 2e-4;
                model
            })
            .collect();
        let mut many = CableObservers::new(&models).unwrap();
        let mut ones: Vec<CableObserver> = models.iter().map(|m| CableObserver::new(m).unwrap()).collect();
        let mut estimates = [CableEstimate::default(); 11];
        for step in 0..6000_u32 {
            let t = f64::from(step) * 1e-3;
            let samples: [CableSample; 11] = core::array::from_fn(|k| {
                let phase = k as f64;
                let lost = step % 700 == 300 && k == 3;
                CableSample {
                    motor: if lost { f64::NAN } else { 0.08 * libm::sin(1.1 * t + phase) },
                    anchor: 0.07 * libm::sin(1.1 * t + phase),
                    tension_in: 80.0 + 30.0 * libm::cos(t),
                }
            });
            // A pause every two seconds.
            let interval = [(1500, 2.0), (700, 0.04)].iter().find(|(at, _)| step % 2000 == *at);
            let interval = interval.map_or(1e-3, |(_, interval)| *interval);
            many.step(interval, &samples, &mut estimates).unwrap();
            for ((one, sample), estimate) in ones.iter_mut().zip(&samples).zip(&estimates) {
                assert_eq!(one.step(interval, sample), *estimate);
            }
        }
        assert!(estimates.iter().any(|e| e.known) && many.step(1e-3, &[], &mut estimates).is_err());
    }

    /// Three observers of different friction, together and one by one.
    fn few() -> (CableObservers, Vec<CableObserver>) {
        let model = |friction: f64| {
            let mut model = CableModel::bench();
            model.parameters.friction *= friction;
            model
        };
        let models = [0.8, 1.0, 1.1].map(model);
        let ones = models.iter().map(|model| CableObserver::new(model).unwrap()).collect();
        (CableObservers::new(&models).unwrap(), ones)
    }

    /// All ends move alike, by 1.8 mm in a sample: four steps of the law.
    fn together(k: u32) -> [CableSample; 3] {
        let slid = 1.8e-3 * f64::from(k);
        [80.0, 90.0, 60.0].map(|tension_in| CableSample { motor: slid, anchor: 0.97 * slid, tension_in })
    }

    #[test]
    fn large_motions_resets_wraps_and_travels_are_those_of_single_observers() {
        let (mut many, mut ones) = few();
        let mut estimates = [CableEstimate::default(); 3];
        let mut known = 0;
        for k in 0..80 {
            if k == 40 {
                many.reset();
                ones.iter_mut().for_each(CableObserver::reset);
            }
            if k % 7 == 3 {
                let wrap = 0.5 + 0.02 * f64::from(k);
                many.set_wrap(1, 0, wrap).unwrap();
                ones[1].set_wrap(0, wrap).unwrap();
            }
            many.step(0.01, &together(k), &mut estimates).unwrap();
            for (cable, one) in ones.iter_mut().enumerate() {
                assert_eq!(one.step(0.01, &together(k)[cable]), estimates[cable], "{k}, cable {cable}");
                let sliding = Sliding::TowardMotor;
                let travel = one.travel_to(95.0, sliding).unwrap();
                assert!((many.travel_to(cable, 95.0, sliding).unwrap() - travel).abs() < 1e-15);
                assert!(travel > 1e-4 || k < 50);
            }
            known += u32::from(estimates[0].known);
            assert!(k != 40 || !estimates[0].known);
        }
        assert!((20..70).contains(&known), "{known}");
        assert!(many.set_wrap(3, 0, 1.0).is_err() && many.travel_to(3, 95.0, Sliding::TowardMotor).is_err());
    }

    #[test]
    fn a_sheath_that_is_bent_more_widens_the_bounds_of_its_cable_alone() {
        let (mut many, _) = few();
        let mut estimates = [CableEstimate::default(); 3];
        many.step(0.01, &together(0), &mut estimates).unwrap();
        let before = estimates;
        many.set_sheath_bend(2, 7.0).unwrap();
        many.step(0.0, &together(0), &mut estimates).unwrap();
        for (cable, (now, before)) in estimates.iter().zip(&before).enumerate() {
            let law = many.cables().law(cable).unwrap();
            let ratio = libm::exp(law.friction_angle());
            assert!((now.high - now.tension_in * ratio - law.pretension()).abs() < 6e-14, "{now:?}");
            assert_eq!(now.high > before.high + 1.0, cable == 2, "{now:?} {before:?}");
        }
        assert!(many.set_sheath_bend(3, 7.0).is_err());
    }
}
