use crate::error::{Error, non_negative, positive, within};
use crate::lanes::{Row, abreast};
use crate::random::Random;
use alloc::vec;
use alloc::vec::Vec;
use serde::{Deserialize, Serialize};

/// Incremental encoder: an angle in whole counts.
///
/// ```text
/// angle^ = round((angle + zero)/c) c,    c = 2 pi / counts
/// ```
///
/// # Assumes
/// Equal counts; `zero` is the homing error, rad.
///
/// # Source
/// Textbook.
#[derive(Debug, Clone, Copy, PartialEq, Serialize, Deserialize)]
#[serde(deny_unknown_fields)]
pub struct Encoder {
    /// Counts per turn, after quadrature.
    pub counts: f64,
    /// Angle at which it reads zero, rad.
    #[serde(rename = "zero_rad")]
    pub zero: f64,
}

abreast!(EncoderRows of Encoder { f64: counts zero });

impl Encoder {
    /// Checks the numbers.
    ///
    /// # Errors
    /// [`Error::OutOfDomain`] names the one outside its domain.
    pub fn validate(&self) -> Result<(), Error> {
        positive("counts", self.counts)?;
        crate::error::finite("zero", self.zero)?;
        Ok(())
    }

    /// Measured angle, rad.
    #[inline(always)]
    #[must_use]
    pub fn read(&self, angle: f64) -> f64 {
        let count = 2.0 * core::f64::consts::PI / self.counts;
        nearest((angle + self.zero) / count) * count
    }
}

/// Encoder of a joint: a coordinate in whole counts.
///
/// ```text
/// q^ = round((q + zero + a sin q + b cos q)/c) c
/// ```
///
/// # Assumes
/// As [`Encoder`].
///
/// # Source
/// Textbook.
#[derive(Debug, Clone, Copy, PartialEq, Serialize, Deserialize)]
#[serde(deny_unknown_fields)]
pub struct JointEncoder {
    /// `c`, rad or m per count, > 0.
    pub resolution: f64,
    /// Homing error, rad or m.
    #[serde(default)]
    pub zero: f64,
    /// `a`, `b`: of a disc that is not centred on its axis, rad.
    #[serde(default, skip_serializing_if = "is_centred")]
    pub eccentricity: [f64; 2],
}

fn is_centred(eccentricity: &[f64; 2]) -> bool {
    eccentricity.iter().all(|part| part.abs() <= 0.0)
}

impl JointEncoder {
    /// Of a hinge: 14 bits per turn.
    #[must_use]
    pub fn fourteen_bits() -> Self {
        Self { resolution: 2.0 * core::f64::consts::PI / 16_384.0, zero: 0.0, eccentricity: [0.0; 2] }
    }

    /// Of a slide: 10 um.
    #[must_use]
    pub fn slide() -> Self {
        Self { resolution: 1e-5, zero: 0.0, eccentricity: [0.0; 2] }
    }

    /// Checks the numbers.
    ///
    /// # Errors
    /// [`Error::OutOfDomain`] names the one outside its domain.
    pub fn validate(&self) -> Result<(), Error> {
        positive("resolution", self.resolution)?;
        crate::error::finite("zero", self.zero)?;
        self.eccentricity.iter().try_for_each(|x| crate::error::finite("eccentricity", *x).map(drop))
    }

    /// What it reads too much at a coordinate, rad or m.
    #[inline]
    #[must_use]
    pub fn error(&self, q: f64) -> f64 {
        if is_centred(&self.eccentricity) {
            return self.zero;
        }
        let (sine, cosine) = libm::sincos(q);
        self.zero + self.eccentricity[0] * sine + self.eccentricity[1] * cosine
    }

    /// Measured coordinate, rad or m.
    #[inline]
    #[must_use]
    pub fn read(&self, q: f64) -> f64 {
        nearest((q + self.error(q)) / self.resolution) * self.resolution
    }
}

/// Load cell: gain, offset, noise, resolution, range.
///
/// ```text
/// T^ = round((gain T + offset + noise N(0, 1)) / r) r,    held within 0 - range/10 .. range
/// ```
///
/// # Assumes
/// White noise; no creep, no hysteresis.
///
/// # Source
/// Textbook; 0.4 N of noise and 0.05 N of resolution assumed for a cell of 1 kN.
#[derive(Debug, Clone, Copy, PartialEq, Serialize, Deserialize)]
#[serde(deny_unknown_fields)]
pub struct LoadCell {
    /// N measured per N applied.
    pub gain: f64,
    /// Reading without a load, N.
    #[serde(rename = "offset_n")]
    pub offset: f64,
    /// Standard deviation, N.
    #[serde(rename = "noise_n")]
    pub noise: f64,
    /// N per count; 0 for none.
    #[serde(rename = "resolution_n")]
    pub resolution: f64,
    /// Largest reading, N.
    #[serde(rename = "range_n")]
    pub range: f64,
}

abreast!(LoadCellRows of LoadCell { f64: gain offset noise resolution range });

impl LoadCell {
    /// A cell of 1 kN with 0.4 N of noise.
    #[must_use]
    pub fn one_kilonewton() -> Self {
        Self { gain: 1.0, offset: 0.0, noise: 0.4, resolution: 0.05, range: 1000.0 }
    }

    /// Checks the numbers.
    ///
    /// # Errors
    /// [`Error::OutOfDomain`] names the one outside its domain.
    pub fn validate(&self) -> Result<(), Error> {
        positive("gain", self.gain)?;
        crate::error::finite("offset", self.offset)?;
        non_negative("noise", self.noise)?;
        non_negative("resolution", self.resolution)?;
        positive("range", self.range)?;
        Ok(())
    }

    /// Measured tension, N.
    #[inline(always)]
    pub fn read(&self, tension: f64, random: &mut Random) -> f64 {
        let raw = self.gain * tension + self.offset + self.noise * random.normal();
        // Divided whether it counts or not: without a branch.
        let count = if self.resolution > 0.0 { self.resolution } else { 1.0 };
        let counted = nearest(raw / count) * count;
        let counted = if self.resolution > 0.0 { counted } else { raw };
        counted.max(-0.1 * self.range).min(self.range)
    }
}

/// Rounds to the nearest integer, ties to even, for magnitudes up to 2^51.
#[inline(always)]
fn nearest(x: f64) -> f64 {
    // 1.5 * 2^52: adding it leaves the nearest integer in the low bits of the mantissa.
    const ROUND: f64 = 6_755_399_441_055_744.0;
    (x + ROUND) - ROUND
}

/// Time delay of whole and fractional steps, by linear interpolation.
#[derive(Debug, Clone, PartialEq)]
pub struct Delay(Delays<1, 1>);

impl Delay {
    /// A delay of `steps` >= 0 steps, filled with `value`.
    ///
    /// # Errors
    /// [`Error::OutOfDomain`] below 0 and above 10 000 steps.
    pub fn new(steps: f64, value: f64) -> Result<Self, Error> {
        Delays::new(steps, [value]).map(Self)
    }

    /// Sets the whole history to a value.
    pub fn fill(&mut self, value: f64) {
        self.0.fill(0, 0, value);
    }

    /// Stores the present value and returns the delayed one.
    #[inline]
    pub fn pass(&mut self, value: f64) -> f64 {
        let [Row([delayed])] = self.0.pass([Row([value])]);
        delayed
    }
}

/// The same of `M` signals in `N` lanes, of which each has its own delay.
#[derive(Debug, Clone, PartialEq)]
pub(super) struct Delays<const N: usize, const M: usize> {
    past: Vec<[Row<N>; M]>,
    next: usize,
    whole: [usize; N],
    fraction: Row<N>,
}

impl<const M: usize> Delays<1, M> {
    /// Of one lane, as [`Delay::new`].
    pub(super) fn new(steps: f64, values: [f64; M]) -> Result<Self, Error> {
        within("delay", "a number in 0..=10000 steps", steps, (0.0..=10_000.0).contains(&steps))?;
        let whole = libm::floor(steps);
        let past = vec![values.map(|value| Row([value])); whole as usize + 2];
        Ok(Self { past, next: 0, whole: [whole as usize], fraction: Row([steps - whole]) })
    }

    /// These side by side.
    pub(super) fn gathered<const N: usize>(lanes: [&Self; N]) -> Delays<N, M> {
        let whole = lanes.map(|lane| lane.whole[0]);
        let count = whole.into_iter().max().unwrap_or(0) + 2;
        let mut past = vec![[Row::default(); M]; count];
        for (k, lane) in lanes.into_iter().enumerate() {
            // The youngest last.
            let (young, old) = lane.past.split_at(lane.next);
            for (to, from) in past.iter_mut().rev().zip(old.iter().chain(young).rev()) {
                to.iter_mut().zip(from).for_each(|(to, from)| to.0[k] = from.0[0]);
            }
        }
        Delays { past, next: 0, whole, fraction: Row(lanes.map(|lane| lane.fraction.0[0])) }
    }
}

impl<const N: usize, const M: usize> Delays<N, M> {
    /// Sets the whole history of one signal in one lane to a value.
    pub(super) fn fill(&mut self, k: usize, signal: usize, value: f64) {
        self.past.iter_mut().for_each(|row| row[signal].0[k] = value);
    }

    /// Stores the present values and returns the delayed ones.
    #[inline(always)]
    pub(super) fn pass(&mut self, values: [Row<N>; M]) -> [Row<N>; M] {
        let (now, count) = (self.next, self.past.len());
        self.past[now] = values;
        // No remainder: integer divisions would cost a third of a drive's step.
        self.next = if now + 1 < count { now + 1 } else { 0 };
        // The ring holds the present values and, for the longest delay, `whole + 1` earlier ones.
        let (mut oldest, mut younger) = (self.past[self.next], values);
        if self.whole == [count - 2; N] {
            younger = self.past[if self.next + 1 < count { self.next + 1 } else { 0 }];
        } else {
            for k in 0..N {
                let back = |steps: usize| if steps > now { now + count - steps } else { now - steps };
                let [old, young] = [back(self.whole[k] + 1), back(self.whole[k])];
                for signal in 0..M {
                    oldest[signal].0[k] = self.past[old][signal].0[k];
                    younger[signal].0[k] = self.past[young][signal].0[k];
                }
            }
        }
        let mut delayed = younger;
        for signal in 0..M {
            delayed[signal] = younger[signal] + self.fraction * (oldest[signal] - younger[signal]);
        }
        delayed
    }
}

#[cfg(test)]
mod tests {
    use super::*;

    #[test]
    fn a_delay_is_exact_for_whole_and_fractional_steps() {
        for steps in [0.0, 1.0, 2.5, 7.0] {
            let mut delay = Delay::new(steps, 0.0).unwrap();
            let mut last = 0.0;
            for k in 0..40 {
                last = delay.pass(f64::from(k));
            }
            assert!((last - (39.0 - steps)).abs() < 1e-12, "{steps}: {last}");
        }
        assert!(Delay::new(-1.0, 0.0).is_err() && Delay::new(f64::NAN, 0.0).is_err());
    }

    #[test]
    fn the_quantisation_error_is_at_most_half_a_count() {
        let encoder = Encoder { counts: 2048.0, zero: 0.0 };
        let half = core::f64::consts::PI / encoder.counts;
        for k in 0..1000 {
            let angle = f64::from(k) * 0.013 - 6.0;
            assert!((encoder.read(angle) - angle).abs() <= half * (1.0 + 1e-9));
        }
    }

    #[test]
    fn a_load_cell_saturates_at_its_range_and_its_noise_is_reproducible() {
        let cell = LoadCell::one_kilonewton();
        let read = |seed| {
            let mut random = Random::new(seed);
            [5.0, 900.0, 5000.0, -5000.0].map(|tension| cell.read(tension, &mut random))
        };
        assert_eq!(read(3).map(f64::to_bits), read(3).map(f64::to_bits));
        assert!(read(3).iter().all(|t| (-100.0..=1000.0).contains(t)));
        assert!((read(3)[1] - 900.0).abs() < 3.0);
    }

    #[test]
    fn an_encoder_counts_whole_turns_and_adds_its_homing_error() {
        let encoder = Encoder { counts: 100.0, zero: 0.2 };
        let turn = 2.0 * core::f64::consts::PI;
        for k in 0..50 {
            let angle = f64::from(k) * 0.137 - 3.0;
            let read = encoder.read(angle);
            assert!((read - angle - encoder.zero).abs() <= 0.5 * turn / encoder.counts + 1e-12, "{angle}");
            assert!((encoder.read(angle + turn) - read - turn).abs() < 1e-12, "{angle}");
        }
        assert!((JointEncoder::fourteen_bits().resolution * f64::from(1 << 14) - turn).abs() < 1e-15);
    }

    #[test]
    fn a_load_cell_without_resolution_adds_its_offset_and_its_noise_to_the_tension() {
        let cell = LoadCell { gain: 1.1, offset: 3.0, noise: 0.4, resolution: 0.0, range: 1000.0 };
        let (mut random, mut same) = (Random::new(5), Random::new(5));
        for tension in [0.0, 50.0, 400.0] {
            let expected = 1.1 * tension + 3.0 + 0.4 * same.normal();
            let read = cell.read(tension, &mut random);
            assert!((read - expected).abs() < 1e-12, "{read} {expected}");
        }
    }

    #[test]
    fn a_load_cell_reads_from_a_tenth_of_its_range_below_zero_to_its_range_in_whole_counts() {
        let cell = LoadCell { noise: 0.0, resolution: 0.25, range: 500.0, ..LoadCell::one_kilonewton() };
        let mut random = Random::new(1);
        for (tension, expected) in
            [(-5000.0, -50.0), (-40.0, -40.0), (7.1, 7.0), (7.2, 7.25), (5000.0, 500.0)]
        {
            let read = cell.read(tension, &mut random);
            assert!((read - expected).abs() < 1e-12, "{tension}: {read}");
        }
    }

    #[test]
    fn numbers_outside_their_domain_are_named() {
        let named = |result: Result<(), Error>, name: &str| {
            let text = std::string::ToString::to_string(&result.unwrap_err());
            assert!(text.starts_with(name), "{text}");
        };
        let encoder = Encoder { counts: 2048.0, zero: 0.0 };
        named(Encoder { counts: 0.0, ..encoder }.validate(), "counts");
        named(Encoder { zero: f64::NAN, ..encoder }.validate(), "zero");
        named(JointEncoder { resolution: 0.0, ..JointEncoder::slide() }.validate(), "resolution");
        named(JointEncoder { zero: f64::INFINITY, ..JointEncoder::slide() }.validate(), "zero");
        let cell = LoadCell::one_kilonewton();
        named(LoadCell { gain: 0.0, ..cell }.validate(), "gain");
        named(LoadCell { offset: f64::NAN, ..cell }.validate(), "offset");
        named(LoadCell { noise: -0.1, ..cell }.validate(), "noise");
        named(LoadCell { resolution: -0.1, ..cell }.validate(), "resolution");
        named(LoadCell { range: 0.0, ..cell }.validate(), "range");
    }
}
