//! State of one cable's observer between samples: inputs of the law, correction, drag adaptation.

use super::model::{CableModel, CableSample};
use crate::transmission::Warming;
use crate::transmission::cable::{CableLaw, EndMotion, EndTensions};

/// Estimate of a cable's state after a sample.
#[derive(Debug, Clone, Copy, PartialEq, Default)]
pub struct CableEstimate {
    /// Tension at the anchor, N.
    pub tension_out: f64,
    /// The same as the far sensor of the logs reads it, N.
    pub far: f64,
    /// Lower bound of [`far`](Self::far) at the estimated near tension, that of sliding toward the motor.
    pub low: f64,
    /// Upper bound of [`far`](Self::far), that of sliding away from the motor.
    pub high: f64,
    /// Tension at the drive's outlet, N.
    pub tension_in: f64,
    /// Measured minus estimated tension at the drive's outlet, N; zero where none was measured.
    pub innovation: f64,
    /// Speed of the motor, in addition to its encoder's, that the innovation `i` asks for, m/s: `g i`.
    pub unexplained_speed: f64,
    /// The part of it that corrects the motor's speed in the next interval, m/s: `g clip(i, +-50 N)`.
    pub correction: f64,
    /// Elongation of the cable from zero tension, m.
    pub stretch: f64,
    /// Whether the whole cable has slid in one direction for 0.1 s since the last reset, so that its profile
    /// no longer depends on the initial one.
    pub known: bool,
    /// Whether the whole cable has slid for 0.1 s in total since the last reset, with interruptions: what a
    /// prediction needs. Encoder noise can interrupt sliding at every sample; the initial profile does not
    /// return by that.
    pub determined: bool,
    /// Whether a position was missing or jumped and was held.
    pub held: bool,
    /// Drag, warmed and adapted, as a multiple of the model's.
    pub drag_factor: f64,
}

/// Largest innovation that corrects, N: bounds the effect of a spike.
const MAX_INNOVATION: f64 = 50.0;
/// Largest displacement between two samples, m; a larger one is a fault of the encoder.
const MAX_DISPLACEMENT: f64 = 0.05;
/// Largest displacement in one step of the law, m; a larger one is divided.
const MAX_STEP: f64 = 5e-4;
/// Sliding of the whole cable after which the initial profile has no effect, s: longer than drag takes to
/// settle.
const CONVERGENCE_TIME: f64 = 0.1;
/// Longest interval between samples, s; after a longer one the state is unknown.
const MAX_INTERVAL: f64 = 1.0;
/// Longest interval in which the correction acts at once, s. After a longer one it would overshoot: the way
/// to the sample is divided.
const LONGEST_STEP: f64 = 0.015;
/// Largest near tension at which an observer starts, N.
const MAX_INITIAL_TENSION: f64 = 1e5;

/// Time after convergence from which on drag is adapted, s: until then the correction changes the stretch.
const ADAPTATION_DELAY: f64 = 2.0;
/// Bounds of the adapted drag, as a multiple of the model's.
const DRAG_FACTOR: [f64; 2] = [0.2, 5.0];
/// Speed at which the innovation is dominated by drag, m/s: the adaptation's weight is the square of the
/// speed over it.
const DRAG_SPEED: f64 = 0.1;

/// Initial profile of a cable.
#[derive(Debug, Clone, Copy)]
pub(super) struct InitialProfile {
    /// Tension at the drive's outlet, N.
    pub(super) tension_in: f64,
    /// Mobilised fraction of friction along the cable, -1 to 1, + as after sliding toward the motor.
    pub(super) friction_fraction: f64,
    /// Stretch, m, which replaces the fraction where the encoders have fixed zeros.
    pub(super) stretch: Option<f64>,
}

/// One cable's observer between samples, beside the law itself.
#[derive(Debug, Clone)]
pub(super) struct ObserverState {
    correction: f64,
    far_gain: f64,
    friction_fraction: f64,
    pretension: f64,
    zero_stretch: Option<f64>,
    /// Tension ratio between the ends in sliding.
    ratio: f64,
    /// Last positions of motor and anchor, m; none before the first sample.
    last: Option<(f64, f64)>,
    /// Last tension at the drive's outlet, N; NaN where it was missing.
    tension_in: f64,
    /// Innovation of the last sample, N.
    innovation: f64,
    /// Time for which the whole cable has slid in one direction, s.
    sliding_time: f64,
    /// The same in all, s.
    slid_for: f64,
    pub(super) converged: bool,
    held: bool,
    adaptation: f64,
    warming: Option<Warming>,
    /// Softening of the grease since the first sample, 1.
    warmth: f64,
    /// Displacements of the ends in the last interval, m, and the interval, s.
    motor_displacement: f64,
    anchor_displacement: f64,
    interval: f64,
    /// Time since convergence, s, up to [`ADAPTATION_DELAY`].
    converged_time: f64,
    /// Adapted drag as a multiple of the model's.
    adapted: f64,
}

impl ObserverState {
    pub(super) fn new(model: &CableModel, law: &CableLaw) -> Self {
        Self {
            pretension: law.pretension(),
            zero_stretch: model.zero_stretch,
            ratio: law.end_ratio(),
            correction: model.correction,
            far_gain: model.far_gain,
            friction_fraction: model.start,
            last: None,
            tension_in: f64::NAN,
            innovation: 0.0,
            sliding_time: 0.0,
            slid_for: 0.0,
            converged: false,
            held: false,
            adaptation: model.learning,
            warming: model.warming,
            warmth: 0.0,
            motor_displacement: 0.0,
            anchor_displacement: 0.0,
            interval: 0.0,
            converged_time: 0.0,
            adapted: 1.0,
        }
    }

    /// Adopts the friction angle of a law that has changed.
    pub(super) fn update_law(&mut self, law: &CableLaw) {
        self.ratio = law.end_ratio();
    }

    pub(super) fn reset(&mut self) {
        self.last = None;
        self.warmth = 0.0;
    }

    /// The last sample; the next one itself where there was none.
    pub(super) fn last_sample(&self, next: &CableSample) -> CableSample {
        let at = |(motor, anchor)| CableSample { motor, anchor, tension_in: self.tension_in };
        self.last.map_or(*next, at)
    }

    /// Displacements of the ends since the last sample, with the correction; `None` where the observer has to
    /// start.
    pub(super) fn end_motion(&mut self, interval: f64, sample: &CableSample) -> Option<EndMotion> {
        let Some((motor, anchor)) = self.last.filter(|_| interval <= MAX_INTERVAL) else {
            self.warm(0.0, interval);
            return None;
        };
        let displacements = (displacement(motor, sample.motor), displacement(anchor, sample.anchor));
        let (motor_displacement, anchor_displacement) = displacements;
        self.held = motor_displacement.is_none() || anchor_displacement.is_none();
        self.last = Some((finite_or(sample.motor, motor), finite_or(sample.anchor, anchor)));
        self.motor_displacement = motor_displacement.unwrap_or(0.0);
        self.anchor_displacement = anchor_displacement.unwrap_or(0.0);
        self.interval = interval;
        Some(EndMotion {
            motor: self.motor_displacement + self.correction_speed() * interval.max(0.0),
            anchor: self.anchor_displacement,
        })
    }

    /// Of the motor, m/s, from the last innovation.
    fn correction_speed(&self) -> f64 {
        self.correction * self.bounded_innovation()
    }

    fn bounded_innovation(&self) -> f64 {
        self.innovation.clamp(-MAX_INNOVATION, MAX_INNOVATION)
    }

    /// Starts with a sample.
    pub(super) fn initialize(&mut self, sample: &CableSample) -> InitialProfile {
        let measured = sample.motor.is_finite() && sample.anchor.is_finite();
        self.last = measured.then_some((sample.motor, sample.anchor));
        (self.converged, self.sliding_time, self.slid_for, self.held) = (false, 0.0, 0.0, !measured);
        (self.motor_displacement, self.anchor_displacement, self.interval) = (0.0, 0.0, 0.0);
        self.converged_time = 0.0;
        let zero = self.zero_stretch.filter(|_| measured);
        InitialProfile {
            tension_in: finite_or(sample.tension_in, 0.0).clamp(0.0, MAX_INITIAL_TENSION),
            friction_fraction: self.friction_fraction,
            stretch: zero.map(|zero| zero + sample.motor - sample.anchor),
        }
    }

    /// Records whether the whole cable slid in one direction for `interval` seconds.
    pub(super) fn record_sliding(&mut self, everywhere: bool, interval: f64) {
        self.slid_for += if everywhere { interval } else { 0.0 };
        self.sliding_time = if everywhere { self.sliding_time + interval } else { 0.0 };
        self.converged |= self.sliding_time > CONVERGENCE_TIME;
    }

    /// Estimate and innovation after the law's step. Both tensions of the innovation are of the same instant:
    /// with the estimate before the motion, motion itself would act as an error and the correction as
    /// positive feedback.
    pub(super) fn update(&mut self, sample: &CableSample, ends: EndTensions, stretch: f64) -> CableEstimate {
        self.tension_in = sample.tension_in;
        self.innovation = finite_or(sample.tension_in - ends.tension_in, 0.0);
        CableEstimate {
            tension_out: ends.tension_out,
            far: self.far_gain * ends.tension_out,
            low: self.far_gain * (ends.tension_in / self.ratio + self.pretension),
            high: self.far_gain * (ends.tension_in * self.ratio + self.pretension),
            tension_in: ends.tension_in,
            innovation: self.innovation,
            unexplained_speed: self.correction * self.innovation,
            correction: self.correction_speed(),
            stretch,
            known: self.converged,
            determined: self.slid_for > CONVERGENCE_TIME,
            held: self.held,
            drag_factor: self.drag_factor(),
        }
    }

    /// Drag as a multiple of the model's after a sample, where the model says that it changes.
    pub(super) fn changed_drag(&mut self, slides_everywhere: bool, ends: EndTensions) -> Option<f64> {
        let work = ends.tension_in * self.motor_displacement - ends.tension_out * self.anchor_displacement;
        self.warm(work, self.interval);
        self.adapt_drag(slides_everywhere);
        (self.warming.is_some() || self.adaptation > 0.0).then(|| self.drag_factor())
    }

    /// Drag as a multiple of the model's.
    pub(super) fn drag_factor(&self) -> f64 {
        self.adapted * Warming::drag_factor(self.warmth)
    }

    fn warm(&mut self, work: f64, interval: f64) {
        if let Some(warming) = self.warming {
            self.warmth = warming.step(self.warmth, work, interval);
        }
    }

    /// Adapts the drag while the whole cable slides, by gradient descent on the innovation:
    ///
    /// ```text
    /// f <- clip(f + g_d i dx (v/v_d)^2, f_min, f_max)     i innovation, dx displacement of the anchor, v = dx/dt
    /// ```
    fn adapt_drag(&mut self, slides_everywhere: bool) {
        if !self.converged || self.interval <= 0.0 || self.adaptation <= 0.0 {
            return;
        }
        if self.converged_time < ADAPTATION_DELAY {
            self.converged_time += self.interval;
        } else if slides_everywhere {
            let speed = self.anchor_displacement / self.interval;
            let weight = self.anchor_displacement * (speed / DRAG_SPEED) * (speed / DRAG_SPEED);
            let factor = self.adapted + self.adaptation * self.bounded_innovation() * weight;
            self.adapted = factor.clamp(DRAG_FACTOR[0], DRAG_FACTOR[1]);
        }
    }

    /// Last positions of motor and anchor, m; none before the first sample.
    pub(super) fn positions(&self) -> Option<(f64, f64)> {
        self.last
    }
}

/// Number of equal parts of the way between two samples.
pub(super) fn parts(interval: f64) -> f64 {
    if interval > LONGEST_STEP && interval <= MAX_INTERVAL {
        libm::ceil(interval / LONGEST_STEP)
    } else {
        1.0
    }
}

/// The sample at a part of the way from one to another.
pub(super) fn between(from: &CableSample, to: &CableSample, part: f64) -> CableSample {
    let at = |from: f64, to: f64| from + part * (to - from);
    CableSample {
        motor: at(from.motor, to.motor),
        anchor: at(from.anchor, to.anchor),
        tension_in: at(from.tension_in, to.tension_in),
    }
}

/// Number of equal steps into which a motion is divided.
pub(super) fn substeps(motion: &EndMotion) -> f64 {
    libm::ceil(motion.motor.abs().max(motion.anchor.abs()) / MAX_STEP).max(1.0)
}

fn finite_or(value: f64, otherwise: f64) -> f64 {
    if value.is_finite() { value } else { otherwise }
}

/// Displacement between two positions, m; none where it is not finite or too large.
fn displacement(from: f64, to: f64) -> Option<f64> {
    Some(to - from).filter(|distance| distance.abs() <= MAX_DISPLACEMENT)
}

#[cfg(test)]
mod tests {
    use super::*;

    const ENDS: EndTensions = EndTensions { tension_in: 40.0, tension_out: 30.0, dissipated: 0.0 };

    fn sample(motor: f64, anchor: f64, tension_in: f64) -> CableSample {
        CableSample { motor, anchor, tension_in }
    }

    fn state(change: impl FnOnce(&mut CableModel)) -> ObserverState {
        let mut model = CableModel::bench();
        change(&mut model);
        ObserverState::new(&model, &model.law().unwrap())
    }

    /// An observer under a constant innovation while the anchor moves evenly, without rounding in its times.
    struct Sliding {
        state: ObserverState,
        anchor: f64,
        innovation: f64,
    }

    impl Sliding {
        const INTERVAL: f64 = 1.0 / 64.0;
        const STRIDE: f64 = 1.0 / 1024.0;

        fn new(learning: f64, innovation: f64) -> Sliding {
            let mut state = state(|model| model.learning = learning);
            state.initialize(&sample(0.0, 0.0, 40.0));
            Sliding { state, anchor: 0.0, innovation }
        }

        /// The drag factor after a sample.
        fn factor(&mut self, interval: f64, slides: bool) -> f64 {
            self.anchor += Self::STRIDE;
            let sample = sample(0.0, self.anchor, 40.0 + self.innovation);
            self.state.end_motion(interval, &sample).unwrap();
            self.state.adapt_drag(slides);
            self.state.update(&sample, ENDS, 0.0).drag_factor
        }

        /// The same after the profile has been known for two seconds.
        fn settled(learning: f64, innovation: f64) -> Sliding {
            let mut sliding = Sliding::new(learning, innovation);
            sliding.factor(Self::INTERVAL, true);
            sliding.state.record_sliding(true, 0.2);
            for _ in 0..128 {
                sliding.factor(Self::INTERVAL, true);
            }
            sliding
        }
    }

    fn is_one(factor: f64) -> bool {
        (factor - 1.0).abs() < f64::EPSILON
    }

    #[test]
    fn drag_is_adapted_while_all_slides_from_two_seconds_after_the_profile_is_known() {
        let mut sliding = Sliding::new(0.5, 3.0);
        for _ in 0..200 {
            assert!(is_one(sliding.factor(Sliding::INTERVAL, true)));
        }
        sliding.state.record_sliding(true, 0.2);
        // Time that stands still or runs backwards does not count.
        for _ in 0..50 {
            assert!(is_one(sliding.factor(0.0, true)) && is_one(sliding.factor(-0.01, true)));
        }
        for _ in 0..128 {
            assert!(is_one(sliding.factor(Sliding::INTERVAL, true)));
        }
        assert!(is_one(sliding.factor(Sliding::INTERVAL, false)));
        // f + g_d i dx (v/v_d)^2
        let speed = Sliding::STRIDE / Sliding::INTERVAL / 0.1;
        let change = 0.5 * 3.0 * Sliding::STRIDE * speed * speed;
        for k in 1..=30 {
            let factor = sliding.factor(Sliding::INTERVAL, true);
            assert!((factor - 1.0 - f64::from(k) * change).abs() < 1e-15, "{k}: {factor}");
        }
        let last = sliding.factor(Sliding::INTERVAL, false);
        for interval in [0.0, -0.01] {
            assert!((sliding.factor(interval, true) - last).abs() < f64::EPSILON);
        }
    }

    #[test]
    fn a_spike_adapts_drag_as_fifty_newtons_do_and_drag_stays_within_its_bounds() {
        let factor = |innovation| Sliding::settled(2.0, innovation).factor(Sliding::INTERVAL, true);
        assert!((factor(1e9) - factor(50.0)).abs() < f64::EPSILON && factor(50.0) > factor(49.0));
        for (innovation, bound) in [(50.0, 5.0), (-50.0, 0.2)] {
            let mut sliding = Sliding::settled(100.0, innovation);
            for _ in 0..50 {
                sliding.factor(Sliding::INTERVAL, true);
            }
            assert!((sliding.factor(Sliding::INTERVAL, true) - bound).abs() < f64::EPSILON);
        }
        // Without a gain nothing is adapted.
        assert!(is_one(Sliding::settled(0.0, 50.0).factor(Sliding::INTERVAL, true)));
    }

    #[test]
    fn work_of_the_ends_warms_the_grease_and_a_new_sequence_begins_cold() {
        let warming = Warming { rate: 2e-3, time: 40.0 };
        let mut state = state(|model| model.warming = Some(warming));
        state.initialize(&sample(0.0, 0.0, 40.0));
        // 40 N pull, 30 N arrive, at 0.1 m/s: a watt.
        let pull = |state: &mut ObserverState, from: u32, to: u32| {
            for k in from..to {
                let slid = 1e-3 * f64::from(k + 1);
                state.end_motion(0.01, &sample(slid, slid, 40.0)).unwrap();
                state.changed_drag(true, ENDS).unwrap();
            }
            state.drag_factor()
        };
        let warm = pull(&mut state, 0, 6000);
        let exact = 1.0 / (1.0 + 2e-3 * 40.0 * (1.0 - libm::exp(-1.5)));
        assert!((warm - exact).abs() < 1e-4, "{warm} {exact}");
        let estimate = state.update(&sample(6.0, 6.0, 40.0), ENDS, 0.0);
        assert!((estimate.drag_factor - warm).abs() < f64::EPSILON);
        // A pause cools it; the start after it is not the first of a sequence.
        assert!(state.end_motion(40.0, &sample(6.0, 6.0, 40.0)).is_none());
        assert!((1.0 / state.drag_factor() - 1.0 - (1.0 / warm - 1.0) / 2.0).abs() < 1e-12);
        state.reset();
        assert!(is_one(state.drag_factor()));
        // A model whose drag does not change sets none in its law.
        let mut plain = self::state(|_| ());
        plain.initialize(&sample(0.0, 0.0, 40.0));
        plain.end_motion(0.01, &sample(0.01, 0.01, 40.0)).unwrap();
        assert_eq!(plain.changed_drag(true, ENDS), None);
    }

    #[test]
    fn an_estimate_has_the_units_of_the_far_sensor_and_the_bounds_of_sliding() {
        let mut state = state(|model| (model.far_gain, model.correction) = (2.0, 0.004));
        let model = CableModel::bench();
        let law = model.law().unwrap();
        let (ratio, pretension) = (law.end_ratio(), law.pretension());
        assert!(pretension > 0.0 && ratio > 1.5);
        let estimate = state.update(&sample(0.0, 0.0, 120.0), ENDS, 0.01);
        let desired = [
            (estimate.far, 60.0),
            (estimate.low, 2.0 * (40.0 / ratio + pretension)),
            (estimate.high, 2.0 * (40.0 * ratio + pretension)),
            (estimate.innovation, 80.0),
            (estimate.unexplained_speed, 0.32),
            (estimate.correction, 0.2),
            (estimate.stretch, 0.01),
        ];
        for (got, desired) in desired {
            assert!((got - desired).abs() < 1e-15, "{got} {desired}: {estimate:?}");
        }
        // The correction is what the motor moves in addition in the next interval.
        state.initialize(&sample(0.3, 0.1, 50.0));
        let motion = state.end_motion(0.01, &sample(0.301, 0.102, 50.0)).unwrap();
        assert!((motion.motor - 0.001 - 0.2 * 0.01).abs() < 1e-15 && (motion.anchor - 0.002).abs() < 1e-15);
    }

    #[test]
    fn one_missing_position_holds_its_end_and_an_observer_starts_with_both() {
        let mut state = state(|_| ());
        for (motor, anchor) in [(0.1, f64::NAN), (f64::NAN, 0.1)] {
            state.initialize(&sample(motor, anchor, 50.0));
            assert!(state.held && state.end_motion(0.01, &sample(0.1, 0.1, 50.0)).is_none());
        }
        state.initialize(&sample(0.1, 0.2, 50.0));
        let motion = state.end_motion(0.01, &sample(0.11, f64::NAN, 50.0)).unwrap();
        assert!(state.held && (motion.motor - 0.01).abs() < 1e-15 && motion.anchor.abs() < 1e-15);
        let motion = state.end_motion(0.01, &sample(f64::NAN, 0.21, 50.0)).unwrap();
        assert!(state.held && motion.motor.abs() < 1e-15 && (motion.anchor - 0.01).abs() < 1e-15);
        assert!(state.end_motion(0.01, &sample(0.11, 0.21, 50.0)).is_some() && !state.held);
        state.reset();
        assert!(state.end_motion(0.01, &sample(0.11, 0.21, 50.0)).is_none());
    }

    #[test]
    fn a_profile_is_known_after_a_tenth_of_a_second_of_sliding_without_a_stop() {
        let mut state = state(|_| ());
        for everywhere in [true, true, true, false, true, true, true] {
            state.record_sliding(everywhere, 0.03);
            assert!(!state.converged);
        }
        assert!(state.slid_for > CONVERGENCE_TIME, "in all");
        state.record_sliding(true, 0.03);
        assert!(state.converged);
        state.record_sliding(false, 0.03);
        assert!(state.converged);
    }

    #[test]
    fn a_motion_is_divided_into_steps_of_at_most_half_a_millimetre() {
        for (motor, anchor, steps) in [
            (0.0, 0.0, 1.0),
            (4e-4, -4.9e-4, 1.0),
            (6e-4, 0.0, 2.0),
            (0.0, -1.2e-3, 3.0),
            (-2.3e-3, 1.2e-3, 5.0),
        ] {
            let n = substeps(&EndMotion { motor, anchor });
            assert!((n - steps).abs() < f64::EPSILON, "{motor} {anchor}: {n}");
        }
    }
}
