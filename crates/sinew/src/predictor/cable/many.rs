//! The observers of all cables of a robot, eight at a time.

use super::model::{CableModel, CableSample};
use super::track::{CableEstimate, Track, parts};
use crate::Error;
use crate::transmission::Sliding;
use crate::transmission::cable::{CableBatch, CableLaw, EndMotion, EndTensions};
use alloc::vec;
use alloc::vec::Vec;

/// [`CableObserver`](super::CableObserver)s side by side: sampled together, otherwise independent.
///
/// The same to the bit as so many single ones while no cable moves more than half a millimetre between samples.
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
    tracks: Vec<Track>,
    motions: Vec<EndMotion>,
    ends: Vec<EndTensions>,
}

impl CableObservers {
    /// Observers that have seen nothing, one per model; all models have the same number of cells.
    ///
    /// # Errors
    /// As [`CableModel::law`] and [`CableBatch::new`].
    pub fn new(models: &[CableModel]) -> Result<Self, Error> {
        let laws = models.iter().map(CableModel::law).collect::<Result<Vec<CableLaw>, _>>()?;
        Ok(Self {
            cables: CableBatch::new(&laws)?,
            tracks: models.iter().zip(&laws).map(|(model, law)| Track::new(model, law)).collect(),
            motions: vec![EndMotion::default(); models.len()],
            ends: vec![EndTensions::default(); models.len()],
        })
    }

    /// Forgets everything: the next samples start anew.
    pub fn reset(&mut self) {
        self.tracks.iter_mut().for_each(Track::reset);
    }

    /// Takes a sample of every cable: `samples: [cables]` in, `estimates: [cables]` out.
    ///
    /// # Errors
    /// [`Error::WrongLength`]; any sample is answered.
    pub fn step(
        &mut self,
        interval: f64,
        samples: &[CableSample],
        estimates: &mut [CableEstimate],
    ) -> Result<(), Error> {
        let expected = self.tracks.len();
        for (name, got) in [("samples", samples.len()), ("estimates", estimates.len())] {
            if got != expected {
                return Err(Error::WrongLength { name, expected, got });
            }
        }
        let (mut n, mut moving) = (1.0_f64, false);
        for (k, (track, sample)) in self.tracks.iter_mut().zip(samples).enumerate() {
            self.motions[k] = match track.follow(interval, sample) {
                Some(motion) => {
                    moving = true;
                    motion
                }
                None => {
                    let (tension, share, stretch) = track.start(sample);
                    self.ends[k] = self.cables.set_profile(k, tension, share, stretch)?;
                    EndMotion::default()
                }
            };
            n = n.max(parts(&self.motions[k]));
        }
        // A start takes no time.
        if moving && interval > 0.0 {
            self.advance(interval, n);
        }
        for (k, ((track, sample), estimate)) in self.tracks.iter_mut().zip(samples).zip(estimates).enumerate()
        {
            *estimate = track.compare(sample, self.ends[k], self.cables.stretch(k).unwrap_or(0.0));
            track.learn(self.cables.slides_everywhere(k));
            if let Some(factor) = track.news_of_drag() {
                self.cables.scale_drag(k, factor)?;
            }
        }
        Ok(())
    }

    /// What they believe, profiles included.
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
            self.tracks[cable].renew(law);
        }
        Ok(())
    }

    fn advance(&mut self, interval: f64, n: f64) {
        for motion in &mut self.motions {
            *motion = EndMotion { motor: motion.motor / n, anchor: motion.anchor / n };
        }
        for _ in 0..n as usize {
            // Refused is what no sampling brings: an interval of nanoseconds.
            if self.cables.step(interval / n, &self.motions, &mut self.ends).is_err() {
                return;
            }
            for (k, track) in self.tracks.iter_mut().enumerate().filter(|(_, track)| !track.known) {
                track.slid(self.cables.slides_everywhere(k), interval / n);
            }
        }
    }
}

#[cfg(test)]
mod tests {
    use super::super::CableObserver;
    use super::*;

    #[test]
    fn many_observers_are_as_many_single_ones_to_the_bit() {
        let models: Vec<CableModel> = (0..11)
            .map(|k| {
                let mut model = CableModel::bench();
                model.parameters.friction *= 0.8 + 0.04 * f64::from(k);
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
            // A pause now and then.
            let interval = if step % 2000 == 1500 { 0.5 } else { 1e-3 };
            many.step(interval, &samples, &mut estimates).unwrap();
            for ((one, sample), estimate) in ones.iter_mut().zip(&samples).zip(&estimates) {
                assert_eq!(one.step(interval, sample), *estimate);
            }
        }
        assert!(estimates.iter().any(|e| e.known) && many.step(1e-3, &[], &mut estimates).is_err());
    }
}
