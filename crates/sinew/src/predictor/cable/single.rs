//! The observer of one cable.

use super::model::{CableModel, CableSample};
use super::observer_state::{CableEstimate, InitialProfile, ObserverState, between, parts, substeps};
use crate::Error;
use crate::transmission::Sliding;
use crate::transmission::cable::{Cable, EndMotion};

/// Estimates the tension at the anchor, the profile along the cable and its elongation.
///
/// ```text
/// dp_m = change of the motor's position + g clip(T_in - T^_in, +-50 N) dt,    dp_a = change of the anchor's
/// (T^_in, T^_out, T^_j) = one step of the cable's law under dp_m, dp_a
/// ```
///
/// | symbol | argument           | unit    | domain  | meaning                                          |
/// |--------|--------------------|---------|---------|--------------------------------------------------|
/// | g      | `correction`       | m/(N s) | [0, 1]  | removes the drift between two encoders              |
/// | dt     | `interval`         | s       | any     | divided beyond 15 ms; beyond 1 s it starts again    |
/// | p_m    | `motor`            | m       | any     | missing values and jumps above 50 mm are held       |
/// | p_a    | `anchor`           | m       | any     | the same                                          |
/// | T_in   | `tension_in`       | N       | any     | where missing, nothing is corrected                 |
///
/// While the near end sticks, near-side signals carry no information on the far end; the displacement of the
/// anchor does.
///
/// # Assumes
/// The cable's law; parameters as identified.
///
/// # Example
/// ```
/// use sinew::predictor::{CableModel, CableObserver, CableSample};
/// let mut observer = CableObserver::new(&CableModel::bench())?;
/// let mut estimate = observer.step(1e-3, &CableSample { motor: 0.0, anchor: 0.0, tension_in: 100.0 });
/// assert!(!estimate.known); // the place of the cable in its dead band is not observable at rest
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
    state: ObserverState,
}

/// Where an observed cable is.
#[derive(Debug, Clone, Copy)]
pub(crate) struct CablePlace {
    /// Position of the motor, m.
    pub(crate) motor: f64,
    /// Position of the anchor, m.
    pub(crate) anchor: f64,
    /// Stretch, m.
    pub(crate) stretch: f64,
    /// Drag as a multiple of the model's.
    pub(crate) drag_factor: f64,
}

impl CableObserver {
    /// An observer before its first sample.
    ///
    /// # Errors
    /// As [`CableModel::law`].
    pub fn new(model: &CableModel) -> Result<Self, Error> {
        let law = model.law()?;
        Ok(Self { state: ObserverState::new(model, &law), cable: Cable::new(law) })
    }

    /// The next sample starts the observer.
    pub fn reset(&mut self) {
        self.state.reset();
    }

    /// One step with a sample, `interval` seconds after the one before. Every sample gives an estimate.
    pub fn step(&mut self, interval: f64, sample: &CableSample) -> CableEstimate {
        let n = parts(interval);
        let from = self.state.last_sample(sample);
        for part in 1..n as u32 {
            self.step_once(interval / n, &between(&from, sample, f64::from(part) / n));
        }
        self.step_once(interval / n, sample)
    }

    fn step_once(&mut self, interval: f64, sample: &CableSample) -> CableEstimate {
        match self.state.end_motion(interval, sample) {
            Some(motion) if interval > 0.0 => self.advance(interval, motion),
            Some(_) => {}
            None => {
                let InitialProfile { tension_in, friction_fraction, stretch } = self.state.initialize(sample);
                self.cable.set_profile(tension_in, friction_fraction, stretch);
            }
        }
        let estimate = self.state.update(sample, self.cable.ends(), self.cable.stretch());
        let slides = self.cable.slides_everywhere();
        if let Some(factor) = self.state.changed_drag(slides, self.cable.ends()) {
            // Never refused: the factor is within its bounds.
            let _ = self.cable.scale_drag(factor);
        }
        estimate
    }

    /// Last positions of motor and anchor, m, none before the first sample; stretch, m; drag as a multiple of
    /// the model's.
    pub(in crate::predictor) fn place(&self) -> Option<CablePlace> {
        let (motor, anchor) = self.state.positions()?;
        Some(CablePlace {
            motor,
            anchor,
            stretch: self.cable.stretch(),
            drag_factor: self.state.drag_factor(),
        })
    }

    /// Takes over the state of an observer of the same model; nothing is allocated.
    pub(super) fn copy_state(&mut self, from: &Self) {
        self.cable.copy_state(&from.cable);
        self.state.clone_from(&from.state);
    }

    /// The estimated cable with its profile.
    #[must_use]
    pub fn cable(&self) -> &Cable {
        &self.cable
    }

    /// Travel of the winch, m, after which the anchor has the desired tension: [`Cable::travel_to`] on the
    /// estimated profile.
    ///
    /// # Errors
    /// [`Error::OutOfDomain`] where the tension is not finite.
    pub fn travel_to(&self, tension_out: f64, sliding: Sliding) -> Result<f64, Error> {
        self.cable.travel_to(tension_out, sliding)
    }

    /// Sets the wrap angle of a pulley, rad, which depends on a joint: [`Cable::set_wrap`].
    ///
    /// # Errors
    /// As there.
    pub fn set_wrap(&mut self, pulley: usize, wrap: f64) -> Result<(), Error> {
        self.cable.set_wrap(pulley, wrap)?;
        self.state.update_law(self.cable.law());
        Ok(())
    }

    fn advance(&mut self, interval: f64, motion: EndMotion) {
        let n = substeps(&motion);
        let step = EndMotion { motor: motion.motor / n, anchor: motion.anchor / n };
        for _ in 0..n as usize {
            // Only an interval of nanoseconds is refused, which no sampling has.
            if self.cable.step(interval / n, step).is_err() {
                return;
            }
            if !self.state.converged {
                self.state.record_sliding(self.cable.slides_everywhere(), interval / n);
            }
        }
    }
}

#[cfg(test)]
mod tests {
    use super::super::model::{CableColumns, ObservedCable};
    use super::*;
    use crate::transmission::cable::{CableLaw, CableParameters, CablePath};

    /// RMS error of the far tension, N, and the last estimate, on a cable of more cells that is pulled and
    /// released.
    fn observe(mut disturb: impl FnMut(u32, &mut CableSample), model: &CableModel) -> (f64, CableEstimate) {
        let law = CableLaw::new(&CablePath::bench(), &CableParameters::bench(), 24).unwrap();
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
            disturb(k, &mut sample);
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
    fn with_true_parameters_the_far_tension_is_estimated_without_a_far_sensor() {
        let (error, last) = observe(|_, _| {}, &CableModel::bench());
        assert!(error < 0.3 && last.known && !last.held, "{error} N");
    }

    #[test]
    fn the_estimate_does_not_depend_on_how_often_it_is_sampled() {
        let law = CableLaw::new(&CablePath::bench(), &CableParameters::bench(), 24).unwrap();
        for every in [1, 5, 14, 16, 20, 50, 100] {
            let (mut plant, mut sample) = (Cable::new(law.clone()), CableSample::default());
            plant.settle(80.0, Sliding::TowardMotor).unwrap();
            // A gain at the upper end of those that serve.
            let model = CableModel { correction: 6e-3, ..CableModel::bench() };
            let mut observer = CableObserver::new(&model).unwrap();
            let (mut squares, mut count) = (0.0, 0.0);
            for k in 0..12_000_u32 {
                let t = f64::from(k) * 1e-3;
                let (motor, anchor) = (6e-5 * libm::sin(1.1 * t), 6e-5 * libm::sin(1.1 * t + 0.05));
                let truth = plant.step(1e-3, EndMotion { motor, anchor }).unwrap();
                sample.motor += motor;
                sample.anchor += anchor;
                sample.tension_in = truth.tension_in;
                if k % every == 0 {
                    let error =
                        observer.step(1e-3 * f64::from(every), &sample).tension_out - truth.tension_out;
                    squares += if k > 4000 { error * error } else { 0.0 };
                    count += if k > 4000 { 1.0 } else { 0.0 };
                }
            }
            let error = libm::sqrt(squares / count);
            assert!(error < 0.4, "{error} N at {every} ms");
        }
    }

    #[test]
    fn the_far_tension_stays_between_its_bounds_and_reaches_both() {
        let mut observer = CableObserver::new(&CableModel::bench()).unwrap();
        let mut touched = [false; 2];
        for k in 0..8000_u32 {
            let motor = 0.1 * libm::sin(f64::from(k) * 2e-3);
            let sample = CableSample { motor, anchor: 0.96 * motor, tension_in: 80.0 };
            let e = observer.step(1e-3, &sample);
            // The bounds are without drag.
            assert!(e.low - 25.0 < e.far && e.far < e.high + 40.0, "{e:?}");
            touched[0] |= e.far < e.low + 2.0;
            touched[1] |= e.far > e.high - 2.0;
        }
        assert_eq!(touched, [true; 2]);
    }

    #[test]
    fn a_cable_with_missing_input_columns_is_refused() {
        let columns = CableColumns {
            tension: 0,
            motor: 1,
            anchor: 2,
            tension_scale: 1.0,
            motor_scale: 1.0,
            anchor_scale: -1e-3,
        };
        let cable = ObservedCable { columns, model: CableModel::bench() };
        assert!(cable.validate(3).is_ok() && cable.validate(2).is_err());
        for scale in [0.0, f64::NAN, f64::INFINITY] {
            let mut bad = cable.clone();
            bad.columns.anchor_scale = scale;
            assert!(bad.validate(3).is_err());
        }
        let missing = cable.columns.sample(&[5.0]);
        assert!(missing.motor.is_nan() && missing.anchor.is_nan());
    }

    #[test]
    fn encoders_with_fixed_zeros_determine_the_far_tension_from_the_first_sample() {
        for sliding in [Sliding::TowardMotor, Sliding::AwayFromMotor] {
            let mut plant = Cable::new(CableModel::bench().law().unwrap());
            plant.settle(90.0, sliding).unwrap();
            let motor = 0.3 + plant.stretch();
            let sample = CableSample { motor, anchor: 0.3, tension_in: plant.ends().tension_in };
            let first = |zero_stretch| {
                let model = CableModel { zero_stretch, ..CableModel::bench() };
                CableObserver::new(&model).unwrap().step(1e-3, &sample)
            };
            assert!((first(Some(0.0)).tension_out - 90.0).abs() < 0.01);
            assert!((first(None).tension_out - 90.0).abs() > 30.0);
            // A zero error of decimetres saturates at the edge of the dead band.
            let (far, wrong) = (first(Some(0.5)), first(Some(-0.5)));
            assert!(wrong.tension_out >= wrong.low - 1e-6 && far.tension_out <= far.high + 1e-6);
        }
    }

    #[test]
    fn an_encoder_offset_is_removed_by_the_correction() {
        let shift = |k: u32, sample: &mut CableSample| sample.motor += if k > 100 { 0.004 } else { 0.0 };
        let (error, _) = observe(shift, &CableModel::bench());
        assert!(error < 0.5, "{error} N");
    }

    #[test]
    fn missing_and_jumping_positions_are_held_and_flagged() {
        let mut held = 0;
        let lost = |k: u32, sample: &mut CableSample| match k % 1000 {
            500 => sample.motor = f64::NAN,
            600 => sample.anchor = f64::INFINITY,
            700..=720 => sample.tension_in = f64::NAN,
            800 => sample.tension_in = 1e9,
            900 => sample.motor += 5.0,
            _ => held += 1,
        };
        let (error, _) = observe(lost, &CableModel::bench());
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
    fn the_predicted_travel_reaches_the_desired_tension() {
        let mut observer = CableObserver::new(&CableModel::bench()).unwrap();
        let mut sample = CableSample { motor: 0.0, anchor: 0.0, tension_in: 60.0 };
        observer.step(1e-3, &sample);
        let travel = observer.travel_to(90.0, Sliding::TowardMotor).unwrap();
        sample.tension_in = f64::NAN;
        for _ in 0..3000 {
            sample.motor += travel / 3000.0;
            observer.step(1e-3, &sample);
        }
        // At rest there is no drag.
        for _ in 0..300 {
            observer.step(1e-3, &sample);
        }
        let got = observer.cable().ends().tension_out;
        assert!((got - 90.0).abs() < 0.5, "{got}");
    }

    #[test]
    fn parameters_outside_their_domains_are_refused() {
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
    fn a_model_is_unchanged_by_serialisation() {
        let model = CableModel::bench();
        let text = serde_json::to_string(&model).unwrap();
        assert!(text.contains("drag_n_s_per_m") && text.contains("wrap_rad"), "{text}");
        assert_eq!(serde_json::from_str::<CableModel>(&text).unwrap(), model);
        let bent = text.replace("\"length_m\":0.166", "\"length_m\":-1.0");
        assert!(serde_json::from_str::<CableModel>(&bent).is_err());
    }

    /// Ends that move by almost 2 mm in a sample, in four steps of the law.
    fn fast(k: u32) -> CableSample {
        let slid = 1.9e-3 * f64::from(k);
        CableSample { motor: 0.1 + slid, anchor: -0.3 + 0.95 * slid, tension_in: f64::NAN }
    }

    #[test]
    fn a_large_motion_is_that_of_the_law_in_smaller_steps() {
        let model = CableModel::bench();
        let mut observer = CableObserver::new(&model).unwrap();
        let start = CableSample { tension_in: 60.0, ..fast(0) };
        let mut law = Cable::new(model.law().unwrap());
        law.set_profile(60.0, 0.0, None);
        assert!((observer.step(0.01, &start).tension_in - 60.0).abs() < 2e-14);
        let (mut slid, mut known) = (0.0, 0);
        for k in 1..100 {
            let estimate = observer.step(0.01, &fast(k));
            for _ in 0..4 {
                law.step(0.0025, EndMotion { motor: 4.75e-4, anchor: 0.95 * 4.75e-4 }).unwrap();
                slid = if law.slides_everywhere() { slid + 0.0025 } else { 0.0 };
            }
            assert!((estimate.tension_out - law.ends().tension_out).abs() < 8e-13, "{k}: {estimate:?}");
            assert!((estimate.stretch - law.stretch()).abs() < 6e-16);
            // Sliding counts by its own time, whatever the number of steps.
            if (slid - 0.1_f64).abs() > 1e-6 {
                assert_eq!(estimate.known, slid > 0.1, "{k}: {slid}");
            }
            known += u32::from(estimate.known);
        }
        assert!((20..99).contains(&known), "{known}");
    }

    #[test]
    fn an_observer_that_is_reset_starts_at_its_next_sample() {
        let mut observer = CableObserver::new(&CableModel::bench()).unwrap();
        let fresh = observer.step(0.01, &CableSample { tension_in: 70.0, ..fast(0) });
        for k in 1..60 {
            observer.step(0.01, &fast(k));
        }
        assert!(observer.step(0.01, &fast(60)).known);
        observer.reset();
        assert_eq!(observer.step(0.01, &CableSample { tension_in: 70.0, ..fast(61) }), fresh);
    }

    #[test]
    fn a_larger_wrap_angle_widens_the_bounds_of_the_far_tension() {
        let mut observer = CableObserver::new(&CableModel::bench()).unwrap();
        let sample = CableSample { tension_in: 70.0, ..fast(0) };
        observer.step(0.01, &sample);
        observer.set_wrap(0, 2.5).unwrap();
        assert!(observer.set_wrap(7, 1.0).is_err());
        let estimate = observer.step(0.0, &sample);
        let law = observer.cable().law();
        assert!(law.friction_angle() > CableModel::bench().law().unwrap().friction_angle() + 0.1);
        let ratio = libm::exp(law.friction_angle());
        assert!((estimate.low - 70.0 / ratio - law.pretension()).abs() < 2e-14, "{estimate:?}");
        assert!((estimate.high - 70.0 * ratio - law.pretension()).abs() < 6e-14, "{estimate:?}");
    }

    #[test]
    fn columns_count_in_newtons_and_in_metres_toward_the_motor() {
        let columns = CableColumns {
            tension: 2,
            motor: 0,
            anchor: 1,
            tension_scale: 1e3,
            motor_scale: 0.5,
            anchor_scale: -4.0,
        };
        let desired = CableSample { motor: 1.5, anchor: -8.0, tension_in: 9e3 };
        assert_eq!(columns.sample(&[3.0, 2.0, 9.0]), desired);
    }
}
