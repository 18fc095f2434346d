//! The cable itself as a model: carried along by both ends' displacements, corrected by the near tension.

use crate::Error;
use crate::error::{positive, within};
use crate::transmission::Sliding;
use crate::transmission::cable::{Cable, CableLaw, CableParameters, EndMotion, Path};
use serde::{Deserialize, Serialize};

/// What an observer believes of a cable; identified from a log, never taken from a plant.
#[derive(Debug, Clone, PartialEq, Serialize, Deserialize)]
#[serde(deny_unknown_fields)]
pub struct CableModel {
    /// The way of the cable.
    pub path: Path,
    /// Friction and elasticity.
    pub parameters: CableParameters,
    /// Cells; 8 serve.
    pub cells: usize,
    /// What the far sensor reads of a newton, 1; other than 1 where a log says so.
    pub far_gain: f64,
    /// Where in its dead band the cable of a new sequence is, -1 to 1: 1 as after sliding toward the motor. Nobody
    /// knows, but logs of one rig often start from the same rest.
    #[serde(default)]
    pub start: f64,
    /// Speed of the correction, m/s per N of the near tension's error.
    #[serde(rename = "correction_m_per_n_s")]
    pub correction: f64,
}

impl CableModel {
    /// The calibrated bench in 8 cells: a start for identification.
    #[must_use]
    pub fn bench() -> Self {
        Self {
            path: Path::bench(),
            parameters: CableParameters::bench(),
            cells: 8,
            far_gain: 1.0,
            start: 0.0,
            correction: 2e-3,
        }
    }

    /// The law of these numbers.
    ///
    /// # Errors
    /// [`Error::OutOfDomain`] names the number outside its domain.
    pub fn law(&self) -> Result<CableLaw, Error> {
        positive("far_gain", self.far_gain)?;
        within("start", "a number in [-1, 1]", self.start, (-1.0..=1.0).contains(&self.start))?;
        let sane = (0.0..=1.0).contains(&self.correction);
        within("correction", "a number in [0, 1] m/(N s)", self.correction, sane)?;
        CableLaw::new(&self.path, &self.parameters, self.cells)
    }
}

/// One sample of everything that can be measured without a sensor at the anchor.
#[derive(Debug, Clone, Copy, PartialEq)]
pub struct CableSample {
    /// Position of the winch's surface, m, + toward the motor; any origin.
    pub motor: f64,
    /// Position of the anchor along the cable, m, + toward the motor; from joint sensors, any origin.
    pub anchor: f64,
    /// Tension at the drive's outlet, N; NaN where it is missing.
    pub tension_in: f64,
}

/// What the observer believes after a sample.
#[derive(Debug, Clone, Copy, PartialEq)]
pub struct CableEstimate {
    /// Tension at the anchor, N.
    pub tension_out: f64,
    /// The same as the far sensor of the logs would read it, N.
    pub far: f64,
    /// Tension at the drive's outlet, N.
    pub tension_in: f64,
    /// Measured minus believed tension at the drive's outlet, N; zero where none was measured.
    pub innovation: f64,
    /// Elongation of the cable from zero tension, m.
    pub stretch: f64,
    /// Whether the whole cable has slid one way for 0.1 s since the last reset: before, its profile is partly a guess.
    pub known: bool,
    /// A position was missing or jumped and was held.
    pub held: bool,
}

/// Largest error of the near tension that corrects, N: a spike must not move the cable.
const LARGEST_INNOVATION: f64 = 50.0;
/// Largest displacement between two samples that is believed, m.
const LARGEST_JUMP: f64 = 0.05;
/// Displacement that one step of the law may take, m; more is cut into equal parts.
const PART: f64 = 5e-4;
/// Sliding of the whole cable that wipes out what happened before, s: drag settles in a little less.
const WIPED_OUT: f64 = 0.1;
/// Pause after which nothing is known any more, s.
const LONGEST_PAUSE: f64 = 0.02;

/// Estimates the tension at the anchor, the profile along the cable and its elongation.
///
/// ```text
/// dp_m = change of the motor's position + g clip(T_in - T^_in, +-50 N) dt,    dp_a = change of the anchor's
/// (T^_in, T^_out, T^_j) = one step of the cable's law under dp_m, dp_a
/// ```
///
/// | symbol | argument           | unit    | domain  | meaning                                          |
/// |--------|--------------------|---------|---------|--------------------------------------------------|
/// | g      | `correction`       | m/(N s) | [0, 1]  | keeps the sum of two encoders from drifting        |
/// | dt     | `interval`         | s       | any     | beyond 0.02 s the observer starts afresh            |
/// | p_m    | `motor`            | m       | any     | missing values and jumps above 50 mm are held       |
/// | p_a    | `anchor`           | m       | any     | the same                                          |
/// | T_in   | `tension_in`       | N       | any     | where missing, nothing is corrected                 |
///
/// While the near end sticks, near-side signals carry nothing about the far end: the anchor's displacement is what makes
/// this work. Its place among the rooms is here because both control and identification use it and the
/// plant may not know it.
///
/// # Assumes
/// The cable's law; parameters as identified.
///
/// # Example
/// ```
/// use sinew::predictor::{CableModel, CableObserver, CableSample};
/// let mut observer = CableObserver::new(&CableModel::bench())?;
/// let mut estimate = observer.step(1e-3, &CableSample { motor: 0.0, anchor: 0.0, tension_in: 100.0 });
/// assert!(!estimate.known); // nobody knows where in its dead band the cable is
/// for k in 1..=1000 {
///     let slid = 2e-4 * f64::from(k); // pulled for 0.2 m, the load following
///     estimate = observer.step(1e-3, &CableSample { motor: slid, anchor: slid, tension_in: 100.0 });
/// }
/// assert!(estimate.known && estimate.innovation.abs() < 1.0);
/// assert!(estimate.tension_out < 55.0); // 100 N less friction, plus the pretension
/// # Ok::<(), sinew::Error>(())
/// ```
///
/// # Source
/// Our own; the gain was found in simulation (2e-3 to 6e-3 serve).
#[derive(Debug, Clone)]
pub struct CableObserver {
    cable: Cable,
    correction: f64,
    far_gain: f64,
    start: f64,
    /// Position of motor and anchor at the last sample; none before the first.
    last: Option<(f64, f64)>,
    /// Measured minus believed near tension at the last sample, N.
    innovation: f64,
    /// How long the whole cable has been sliding in one direction, s.
    sliding: f64,
    known: bool,
}

impl CableObserver {
    /// An observer that has seen nothing.
    ///
    /// # Errors
    /// As [`CableModel::law`].
    pub fn new(model: &CableModel) -> Result<Self, Error> {
        Ok(Self {
            cable: Cable::new(model.law()?),
            correction: model.correction,
            far_gain: model.far_gain,
            start: model.start,
            last: None,
            innovation: 0.0,
            sliding: 0.0,
            known: false,
        })
    }

    /// Forgets everything: the next sample starts anew.
    pub fn reset(&mut self) {
        self.last = None;
    }

    /// Takes a sample, `interval` seconds after the one before. Any sample is answered.
    pub fn step(&mut self, interval: f64, sample: &CableSample) -> CableEstimate {
        let Some((motor, anchor)) = self.last.filter(|_| interval <= LONGEST_PAUSE) else {
            return self.start(sample);
        };
        let motor_moved = moved(motor, sample.motor);
        let anchor_moved = moved(anchor, sample.anchor);
        let held = motor_moved.is_none() || anchor_moved.is_none();
        self.last = Some((or(sample.motor, motor), or(sample.anchor, anchor)));
        if interval > 0.0 {
            let error = self.innovation.clamp(-LARGEST_INNOVATION, LARGEST_INNOVATION);
            let correction = self.correction * error * interval;
            self.advance(interval, motor_moved.unwrap_or(0.0) + correction, anchor_moved.unwrap_or(0.0));
        }
        // Of the same instant on both sides: compared with the tension before the motion, motion itself would
        // look like an error, and the correction would add to it.
        self.innovation = or(sample.tension_in - self.cable.ends().tension_in, 0.0);
        self.estimate(held)
    }

    /// What it believes, the profile included.
    #[must_use]
    pub fn cable(&self) -> &Cable {
        &self.cable
    }

    /// Travel of the winch, m, after which the anchor has the wanted tension: [`Cable::travel_to`] on the
    /// believed profile.
    ///
    /// # Errors
    /// [`Error::OutOfDomain`] where the tension is not finite.
    pub fn travel_to(&self, tension_out: f64, sliding: Sliding) -> Result<f64, Error> {
        self.cable.travel_to(tension_out, sliding)
    }

    /// Sets the wrap of a pulley, which a joint has changed: [`Cable::set_wrap`].
    ///
    /// # Errors
    /// As there.
    pub fn set_wrap(&mut self, pulley: usize, wrap: f64) -> Result<(), Error> {
        self.cable.set_wrap(pulley, wrap)
    }

    /// Placed by the measured tension and what is believed of new sequences.
    fn start(&mut self, sample: &CableSample) -> CableEstimate {
        let known = [sample.motor, sample.anchor].iter().all(|position| position.is_finite());
        self.last = known.then_some((sample.motor, sample.anchor));
        (self.known, self.sliding, self.innovation) = (false, 0.0, 0.0);
        // Beyond any cable is beyond belief.
        self.cable.lay(or(sample.tension_in, 0.0).clamp(0.0, 1e5), self.start);
        self.estimate(!known)
    }

    fn advance(&mut self, interval: f64, motor: f64, anchor: f64) {
        let parts = libm::ceil(motor.abs().max(anchor.abs()) / PART).max(1.0);
        let motion = EndMotion { motor: motor / parts, anchor: anchor / parts };
        for _ in 0..parts as usize {
            // Refused is what no sampling brings: an interval of nanoseconds.
            if self.cable.step(interval / parts, motion).is_err() {
                return;
            }
            let slips = || self.cable.slips();
            let whole = slips().all(|slip| slip > 0.0) || slips().all(|slip| slip < 0.0);
            self.sliding = if whole { self.sliding + interval / parts } else { 0.0 };
            self.known |= self.sliding > WIPED_OUT;
        }
    }

    fn estimate(&self, held: bool) -> CableEstimate {
        let ends = self.cable.ends();
        CableEstimate {
            tension_out: ends.tension_out,
            far: self.far_gain * ends.tension_out,
            tension_in: ends.tension_in,
            innovation: self.innovation,
            stretch: self.cable.stretch(),
            known: self.known,
            held,
        }
    }
}

fn or(value: f64, otherwise: f64) -> f64 {
    if value.is_finite() { value } else { otherwise }
}

/// The displacement between two positions, if it can be believed.
fn moved(from: f64, to: f64) -> Option<f64> {
    Some(to - from).filter(|distance| distance.abs() <= LARGEST_JUMP)
}

#[cfg(test)]
mod tests {
    use super::*;

    /// A finer cable with other numbers, pulled and eased; what the observer sees of it, and the truth.
    fn watch(mut see: impl FnMut(u32, &mut CableSample), model: &CableModel) -> (f64, CableEstimate) {
        let law = CableLaw::new(&Path::bench(), &CableParameters::bench(), 24).unwrap();
        let mut plant = Cable::new(law);
        plant.settle(80.0, Sliding::TowardMotor).unwrap();
        let mut observer = CableObserver::new(model).unwrap();
        let (mut motor, mut anchor) = (0.3, -0.2);
        let (mut squares, mut count) = (0.0, 0.0);
        let start = CableSample { motor, anchor, tension_in: plant.ends().tension_in };
        let mut last = observer.step(1e-3, &start);
        for k in 0..12_000_u32 {
            let t = f64::from(k) * 1e-3;
            let motion = EndMotion {
                motor: 1e-3 * (0.06 * libm::sin(1.1 * t) + 0.02 * libm::cos(2.0 * t)),
                anchor: 1e-3 * 0.06 * libm::sin(1.1 * t + 0.05),
            };
            motor += motion.motor;
            anchor += motion.anchor;
            let truth = plant.step(1e-3, motion).unwrap();
            let mut sample = CableSample { motor, anchor, tension_in: truth.tension_in };
            see(k, &mut sample);
            last = observer.step(1e-3, &sample);
            assert!(last.tension_out.is_finite() && last.stretch.is_finite());
            if k > 4000 {
                squares += (last.tension_out - truth.tension_out) * (last.tension_out - truth.tension_out);
                count += 1.0;
            }
        }
        (libm::sqrt(squares / count), last)
    }

    #[test]
    fn with_the_right_numbers_the_far_end_is_known_without_a_sensor_there() {
        let (error, last) = watch(|_, _| {}, &CableModel::bench());
        assert!(error < 0.3 && last.known && !last.held, "{error} N");
    }

    #[test]
    fn an_offset_of_an_encoder_is_forgotten_through_the_near_tension() {
        let shift = |k: u32, sample: &mut CableSample| sample.motor += if k > 100 { 0.004 } else { 0.0 };
        let (error, _) = watch(shift, &CableModel::bench());
        assert!(error < 0.5, "{error} N");
    }

    #[test]
    fn what_is_missing_or_jumps_is_held_and_said_so() {
        let mut held = 0;
        let lost = |k: u32, sample: &mut CableSample| match k % 1000 {
            500 => sample.motor = f64::NAN,
            600 => sample.anchor = f64::INFINITY,
            700..=720 => sample.tension_in = f64::NAN,
            800 => sample.tension_in = 1e9,
            900 => sample.motor += 5.0,
            _ => held += 1,
        };
        let (error, _) = watch(lost, &CableModel::bench());
        assert!(error < 3.0 && held > 0, "{error} N");
        let mut observer = CableObserver::new(&CableModel::bench()).unwrap();
        let nothing = CableSample { motor: f64::NAN, anchor: f64::NAN, tension_in: f64::NAN };
        let seen = CableSample { motor: 0.0, anchor: 0.0, tension_in: 50.0 };
        assert!(observer.step(1e-3, &nothing).held && !observer.step(1e-3, &seen).held);
        assert!(observer.step(1e-3, &nothing).held);
        for interval in [0.0, -1.0, 1e-12, f64::NAN, 1e9] {
            assert!(observer.step(interval, &seen).tension_out.is_finite());
        }
    }

    #[test]
    fn a_travel_asked_of_the_observer_brings_the_tension() {
        let mut observer = CableObserver::new(&CableModel::bench()).unwrap();
        let mut sample = CableSample { motor: 0.0, anchor: 0.0, tension_in: 60.0 };
        observer.step(1e-3, &sample);
        let travel = observer.travel_to(90.0, Sliding::TowardMotor).unwrap();
        sample.tension_in = f64::NAN;
        for _ in 0..3000 {
            sample.motor += travel / 3000.0;
            observer.step(1e-3, &sample);
        }
        // Drag of the moving cable is gone when it stands.
        for _ in 0..300 {
            observer.step(1e-3, &sample);
        }
        let got = observer.cable().ends().tension_out;
        assert!((got - 90.0).abs() < 0.5, "{got}");
    }

    #[test]
    fn numbers_that_are_no_cable_are_refused() {
        for change in [
            |m: &mut CableModel| m.far_gain = 0.0,
            |m: &mut CableModel| m.correction = f64::NAN,
            |m: &mut CableModel| m.cells = 2,
            |m: &mut CableModel| m.parameters.friction = -1.0,
        ] {
            let mut model = CableModel::bench();
            change(&mut model);
            assert!(CableObserver::new(&model).is_err());
        }
    }

    #[test]
    fn a_model_written_and_read_is_the_same() {
        let model = CableModel::bench();
        let text = serde_json::to_string(&model).unwrap();
        assert!(text.contains("drag_n_s_per_m") && text.contains("wrap_rad"), "{text}");
        assert_eq!(serde_json::from_str::<CableModel>(&text).unwrap(), model);
        let bent = text.replace("\"length_m\":0.166", "\"length_m\":-1.0");
        assert!(serde_json::from_str::<CableModel>(&bent).is_err());
    }
}
