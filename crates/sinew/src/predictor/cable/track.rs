//! What is remembered of one cable between two samples, and what is believed of a sample.

use super::model::{CableModel, CableSample};
use crate::transmission::cable::{CableLaw, EndMotion, EndTensions};

/// What the observer believes after a sample.
#[derive(Debug, Clone, Copy, PartialEq, Default)]
pub struct CableEstimate {
    /// Tension at the anchor, N.
    pub tension_out: f64,
    /// The same as the far sensor of the logs would read it, N.
    pub far: f64,
    /// Least and most that [`far`](Self::far) can be with the near tension as believed: what sliding either way gives.
    pub low: f64,
    /// See [`low`](Self::low).
    pub high: f64,
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
    /// What the drag has been learned to be, times that of the model.
    pub drag_factor: f64,
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

/// Time for which the state must be known before drag is learned from it, s: at first the correction sets the stretch right.
const SEASONED: f64 = 2.0;
/// Least and most of a learned drag, times that of the model.
const LEARNED: [f64; 2] = [0.2, 5.0];
/// Speed at which the near tension tells drag from what else it shows, m/s; below, it soon tells nothing.
const TELLING_SPEED: f64 = 0.1;
/// Change of the drag factor that is worth telling the cable.
const WORTH_TELLING: f64 = 2e-3;

/// One cable between its samples.
#[derive(Debug, Clone)]
pub(super) struct Track {
    correction: f64,
    far_gain: f64,
    /// Share of the friction that is at work in a new sequence, + as after sliding toward the motor.
    share: f64,
    pretension: f64,
    zero_stretch: Option<f64>,
    /// Tension ratio between the ends in sliding.
    ratio: f64,
    /// Position of motor and anchor at the last sample; none before the first.
    last: Option<(f64, f64)>,
    /// Measured minus believed near tension at the last sample, N.
    innovation: f64,
    /// How long the whole cable has been sliding in one direction, s.
    sliding: f64,
    pub(super) known: bool,
    held: bool,
    learning: f64,
    /// The anchor's displacement in the last interval, m, and the interval, s.
    slid: f64,
    interval: f64,
    /// How long the state has been known, s, up to [`SEASONED`].
    age: f64,
    drag_factor: f64,
    /// The factor as the cable has been told.
    told: f64,
}

impl Track {
    pub(super) fn new(model: &CableModel, law: &CableLaw) -> Self {
        Self {
            pretension: law.pretension(),
            zero_stretch: model.zero_stretch,
            ratio: libm::exp(law.friction_angle()),
            correction: model.correction,
            far_gain: model.far_gain,
            share: model.start,
            last: None,
            innovation: 0.0,
            sliding: 0.0,
            known: false,
            held: false,
            learning: model.learning,
            slid: 0.0,
            interval: 0.0,
            age: 0.0,
            drag_factor: 1.0,
            told: 1.0,
        }
    }

    /// Takes note of a law that has changed.
    pub(super) fn renew(&mut self, law: &CableLaw) {
        self.ratio = libm::exp(law.friction_angle());
    }

    pub(super) fn reset(&mut self) {
        self.last = None;
    }

    /// Displacements since the last sample, the correction among them; `None` where everything starts afresh.
    pub(super) fn follow(&mut self, interval: f64, sample: &CableSample) -> Option<EndMotion> {
        let (motor, anchor) = self.last.filter(|_| interval <= LONGEST_PAUSE)?;
        let (motor_moved, anchor_moved) = (moved(motor, sample.motor), moved(anchor, sample.anchor));
        self.held = motor_moved.is_none() || anchor_moved.is_none();
        self.last = Some((or(sample.motor, motor), or(sample.anchor, anchor)));
        let error = self.innovation.clamp(-LARGEST_INNOVATION, LARGEST_INNOVATION);
        (self.slid, self.interval) = (anchor_moved.unwrap_or(0.0), interval);
        Some(EndMotion {
            motor: motor_moved.unwrap_or(0.0) + self.correction * error * interval.max(0.0),
            anchor: anchor_moved.unwrap_or(0.0),
        })
    }

    /// Starts with a sample: the tension to begin with at the drive, N, the share of friction along the cable, and the
    /// stretch, m, which knows better where it can be told.
    pub(super) fn start(&mut self, sample: &CableSample) -> (f64, f64, Option<f64>) {
        let known = sample.motor.is_finite() && sample.anchor.is_finite();
        self.last = known.then_some((sample.motor, sample.anchor));
        (self.known, self.sliding, self.held, self.slid) = (false, 0.0, !known, 0.0);
        self.age = 0.0;
        // Beyond any cable is beyond belief.
        let tension = or(sample.tension_in, 0.0).clamp(0.0, 1e5);
        let stretch = self.zero_stretch.filter(|_| known).map(|zero| zero + sample.motor - sample.anchor);
        (tension, self.share, stretch)
    }

    /// Takes note of whether all of the cable slid one way for `interval` seconds.
    pub(super) fn slid(&mut self, whole: bool, interval: f64) {
        self.sliding = if whole { self.sliding + interval } else { 0.0 };
        self.known |= self.sliding > WIPED_OUT;
    }

    /// Compares with the measured tension. Both are of the same instant: compared with the tension before the
    /// motion, motion itself would look like an error, and the correction would add to it.
    pub(super) fn compare(&mut self, sample: &CableSample, ends: EndTensions, stretch: f64) -> CableEstimate {
        self.innovation = or(sample.tension_in - ends.tension_in, 0.0);
        CableEstimate {
            tension_out: ends.tension_out,
            far: self.far_gain * ends.tension_out,
            low: self.far_gain * (ends.tension_in / self.ratio + self.pretension),
            high: self.far_gain * (ends.tension_in * self.ratio + self.pretension),
            tension_in: ends.tension_in,
            innovation: self.innovation,
            stretch,
            known: self.known,
            held: self.held,
            drag_factor: self.drag_factor,
        }
    }

    /// Learns the drag while all of the cable slides: what is missing shows as near tension missing one way and left over
    /// the other; the steepest descent.
    pub(super) fn learn(&mut self, slides_whole: bool) {
        if !self.known || self.interval <= 0.0 || self.learning <= 0.0 {
            return;
        }
        if self.age < SEASONED {
            self.age += self.interval;
        } else if slides_whole {
            let error = self.innovation.clamp(-LARGEST_INNOVATION, LARGEST_INNOVATION);
            let speed = self.slid / self.interval;
            let told = self.slid * (speed / TELLING_SPEED) * (speed / TELLING_SPEED);
            let factor = self.drag_factor + self.learning * error * told;
            self.drag_factor = factor.clamp(LEARNED[0], LEARNED[1]);
        }
    }

    /// The drag factor, where it has changed enough for the cable to be told.
    pub(super) fn news_of_drag(&mut self) -> Option<f64> {
        let news = (self.drag_factor - self.told).abs() > WORTH_TELLING;
        if news {
            self.told = self.drag_factor;
        }
        news.then_some(self.told)
    }
}

/// In how many equal parts a motion is taken.
pub(super) fn parts(motion: &EndMotion) -> f64 {
    libm::ceil(motion.motor.abs().max(motion.anchor.abs()) / PART).max(1.0)
}

fn or(value: f64, otherwise: f64) -> f64 {
    if value.is_finite() { value } else { otherwise }
}

/// The displacement between two positions, if it can be believed.
fn moved(from: f64, to: f64) -> Option<f64> {
    Some(to - from).filter(|distance| distance.abs() <= LARGEST_JUMP)
}
