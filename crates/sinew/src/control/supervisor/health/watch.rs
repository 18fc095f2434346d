use super::drift::{Drift, DriftRule, DriftWatch, Estimate, Wear};
use super::explanation::{self, Change, Evidence, Shown};
use super::sliding::{SlidingFit, SlidingModel, SlidingSample};
use super::torque::TorqueFit;
use crate::control::arm::{ArmController, Observed};
use crate::control::supervisor::fault_kind::FaultKind;
use crate::transmission::cable::CableLaw;
use alloc::vec;
use alloc::vec::Vec;

/// Slow changes of a cable since the first minutes of operation, as fractions of its model's values.
#[derive(Debug, Clone, Copy, PartialEq, Default)]
pub struct CableHealth {
    /// Of its friction angle.
    pub friction: Drift,
    /// Of its pretension `T_0`.
    pub pretension: Drift,
    /// Of its stiffness.
    pub stiffness: Drift,
}

impl CableHealth {
    /// What has been found, most urgent first.
    #[must_use]
    pub fn found(&self) -> Option<FaultKind> {
        if self.friction.found {
            Some(FaultKind::FrictionDrift)
        } else if self.stiffness.found {
            Some(FaultKind::StiffnessDrift)
        } else if self.pretension.found {
            Some(FaultKind::PretensionDrift)
        } else {
            None
        }
    }
}

/// Estimates the slow changes of all cables while a machine follows its references.
///
/// Once a window of [`WINDOW`] s of motion, friction and compliance are fitted to the travel that the
/// observers do not explain ([`SlidingFit`]), and pretension and friction once more to the torques of the
/// disturbances ([`TorqueFit`]); the drift of each number from its values in the first windows is judged
/// ([`DriftWatch`]). One cable is sampled per control cycle.
///
/// One change of one cable is named at a time, the one that explains most ([`explanation::best`]).
///
/// # Assumes
/// The same motions recur: of another motion the errors of the model are others.
///
/// # Source
/// Our own.
#[derive(Debug, Clone)]
pub(in crate::control::supervisor) struct HealthMonitor {
    cables: Vec<Watched>,
    health: Vec<CableHealth>,
    /// Drag that the cables' observers have learned, N: `[muscles]`.
    learned_drag: Vec<f64>,
    /// Torques that the cables' models do not explain, Nm or N: `[joints]`.
    torque: Vec<f64>,
    next: usize,
    time: f64,
    /// Whether the first window after a start, in which the observers settle, is over.
    settled: bool,
}

/// State of one cable.
#[derive(Debug, Clone, Copy)]
struct Watched {
    sliding: SlidingFit,
    torque: TorqueFit,
    /// By the travel that its observer does not explain.
    friction: DriftWatch,
    /// By the torques, if nothing else changes.
    friction_by_torque: DriftWatch,
    stiffness: DriftWatch,
    pretension: DriftWatch,
    /// Mean squares of the torques that a growth of its friction explains and a loss of its pretension, Nm^2.
    explained: [f64; 2],
}

/// Motion over which one number is fitted, s.
const WINDOW: f64 = 60.0;
/// Speed of an anchor from which on the direction of sliding is certain, m/s.
const SLIDING_SPEED: f64 = 2e-3;
/// Friction that falls, of a cable that runs in or of grease that warms, does no harm.
const FRICTION: DriftRule =
    DriftRule { min_deviation: 0.003, min_drift: 0.015, cusum: [2.0, 12.0], limit: 0.2, wear: Wear::Growth };
/// The torques show masses and loads, too.
const FRICTION_BY_TORQUE: DriftRule =
    DriftRule { min_deviation: 0.01, min_drift: 0.04, cusum: [1.0, 8.0], ..FRICTION };
/// No cable becomes stiffer by wear.
const STIFFNESS: DriftRule = DriftRule { min_drift: 0.03, wear: Wear::Fall, ..FRICTION };
const PRETENSION: DriftRule =
    DriftRule { min_deviation: 0.02, min_drift: 0.1, cusum: [1.0, 8.0], limit: 0.5, wear: Wear::Either };

impl HealthMonitor {
    pub(in crate::control::supervisor) fn new(muscles: usize, joints: usize) -> Self {
        let watched = Watched {
            sliding: SlidingFit::default(),
            torque: TorqueFit::default(),
            friction: DriftWatch::new(FRICTION),
            friction_by_torque: DriftWatch::new(FRICTION_BY_TORQUE),
            stiffness: DriftWatch::new(STIFFNESS),
            pretension: DriftWatch::new(PRETENSION),
            explained: [0.0; 2],
        };
        Self {
            cables: vec![watched; muscles],
            health: vec![CableHealth::default(); muscles],
            learned_drag: vec![0.0; muscles],
            torque: vec![0.0; joints],
            next: 0,
            time: 0.0,
            settled: false,
        }
    }

    /// Of every cable: `[muscles]`.
    pub(in crate::control::supervisor) fn health(&self) -> &[CableHealth] {
        &self.health
    }

    /// One control cycle of `h` s in which a reference was followed without a fault.
    pub(in crate::control::supervisor) fn update(&mut self, h: f64, controller: &ArmController) {
        let k = self.next;
        self.next = (self.next + 1) % self.cables.len().max(1);
        if let Ok(law) = controller.cable_law(k) {
            self.sample(k, &controller.observed(), law, controller.slides(k));
        }
        self.pass(h, |k| controller.cable_law(k).map_or(0.0, CableLaw::pretension));
    }

    /// Takes what is observed of cable `k`, which `slides` everywhere or not.
    fn sample(&mut self, k: usize, observed: &Observed, law: &CableLaw, slides: bool) {
        let Some(cable) = self.cables.get_mut(k) else { return };
        let [drag, drag_fade] = law.drag();
        let compliance = law.compliance().iter().sum();
        let model = SlidingModel { angle: law.friction_angle(), compliance, drag, drag_fade };
        let (speed, tension) = (observed.anchor_speed[k], observed.tension[k]);
        let joints = self.torque.len();
        let arms = &observed.moment_arms[k * joints..(k + 1) * joints];
        let errors = arms.iter().zip(observed.joint_innovation);
        let sample = SlidingSample {
            position: -observed.lengths[k],
            speed,
            // The estimate stands for the tension: noise of the reading on both sides of the fit would look
            // like a stiffness.
            tension: observed.tension_in[k],
            unexplained: observed.unexplained[k],
            anchor_error: errors.map(|(arm, error)| arm * error).sum(),
            innovation: tension - observed.tension_in[k],
            drag_factor: observed.drag_factor[k],
        };
        let slides = speed.abs() > SLIDING_SPEED && slides;
        if slides && tension.is_finite() {
            cable.sliding.add(&sample, &model);
        }
        self.learned_drag[k] = model.learned_drag(&sample);
        let sliding_tension = (observed.tension_out[k] - law.pretension()).max(0.0);
        let friction = if slides { speed.signum() * model.angle * sliding_tension } else { 0.0 };
        self.torque.copy_from_slice(observed.disturbance_torque);
        for (others, drag) in observed.moment_arms.chunks_exact(joints.max(1)).zip(&self.learned_drag) {
            self.torque.iter_mut().zip(others).for_each(|(torque, arm)| *torque -= arm * drag);
        }
        cable.torque.add(arms, &self.torque, friction);
    }

    /// `h` s pass; `pretension` of each cable's model, N.
    fn pass(&mut self, h: f64, pretension: impl Fn(usize) -> f64) {
        self.time += h;
        if self.time >= WINDOW {
            self.close_window(pretension);
            self.time = 0.0;
        }
    }

    /// The observers begin anew: the window that was begun and the next one, in which they settle, do not
    /// count. What the windows before showed is kept.
    pub(in crate::control::supervisor) fn restart(&mut self) {
        self.cables.iter_mut().for_each(Watched::discard);
        (self.time, self.settled) = (0.0, false);
    }

    fn close_window(&mut self, pretension: impl Fn(usize) -> f64) {
        if !core::mem::replace(&mut self.settled, true) {
            self.cables.iter_mut().for_each(Watched::discard);
            return;
        }
        for (k, cable) in self.cables.iter_mut().enumerate() {
            cable.close_window(self.time, pretension(k));
        }
        let explanation = explanation::best(self.cables.iter().map(Watched::evidence));
        for (k, (health, cable)) in self.health.iter_mut().zip(&self.cables).enumerate() {
            let named = |change| explanation.is_some_and(|it| it.cable == k && it.change == change);
            let found = |change| named(change) && explanation.is_some_and(|it| it.found);
            let mut friction = cable.friction.drift();
            if named(Change::Friction) {
                friction = friction.joined(&cable.friction_by_torque.drift());
            }
            *health = CableHealth {
                friction: Drift { found: found(Change::Friction), ..friction },
                pretension: Drift { found: found(Change::Pretension), ..cable.pretension.drift() },
                stiffness: Drift { found: found(Change::Stiffness), ..cable.stiffness.drift() },
            };
        }
    }
}

impl Watched {
    fn evidence(&self) -> Evidence {
        let shown = |watch: &DriftWatch| Shown { drift: watch.drift(), significance: watch.significance() };
        Evidence {
            friction: shown(&self.friction),
            stiffness: shown(&self.stiffness),
            friction_by_torque: self.friction_by_torque.drift(),
            pretension: self.pretension.drift(),
            explained: self.explained,
        }
    }

    /// Fits what was sampled in a window of `time` s; `pretension` of the model, N.
    fn close_window(&mut self, time: f64, pretension: f64) {
        if let Some([compliance, friction]) = self.sliding.solve(self.torque.samples()) {
            self.friction.update(friction, time);
            self.stiffness.update(Estimate { value: -compliance.value, ..compliance }, time);
        }
        let exact = |value: f64| Estimate { value, deviation: 0.0 };
        self.explained = [0.0; 2];
        if let Some(change) = self.torque.friction() {
            self.friction_by_torque.update(exact(change.value), time);
            let grown = self.friction_by_torque.drift().fraction.max(0.0);
            self.explained[0] = grown * grown * change.power;
        }
        if let (Some(change), true) = (self.torque.force(), pretension > 0.0) {
            self.pretension.update(exact(change.value / pretension), time);
            let lost = (-self.pretension.drift().fraction).max(0.0) * pretension;
            self.explained[1] = lost * lost * change.power;
        }
        self.discard();
    }

    /// Forgets what was sampled.
    fn discard(&mut self) {
        (self.sliding, self.torque) = (SlidingFit::default(), TorqueFit::default());
    }
}

#[cfg(test)]
mod tests {
    use super::*;
    use crate::random::Random;
    use crate::transmission::cable::{CableParameters, CablePath};

    #[test]
    fn after_a_start_the_observers_settle_again_and_what_was_found_before_is_kept() {
        let mut monitor = HealthMonitor::new(1, 1);
        let value = |value| Estimate { value, deviation: 0.0 };
        (0..8).for_each(|_| monitor.cables[0].friction.update(value(0.0), WINDOW));
        (monitor.time, monitor.settled) = (0.9 * WINDOW, true);
        monitor.cables[0].torque.add(&[0.1], &[1.0], 1.0);
        let before = monitor.cables[0].friction.drift();
        monitor.restart();
        assert!(!monitor.settled && monitor.time < 1e-9);
        assert!(monitor.cables[0].torque.samples() < 0.5);
        assert_eq!(monitor.cables[0].friction.drift(), before);
    }

    /// What changes of the first of two antagonists, as fractions.
    #[derive(Debug, Clone, Copy, Default)]
    struct Change {
        friction: f64,
        compliance: f64,
        pretension: f64,
    }

    const ARMS: [f64; 2] = [0.03, -0.025];

    /// What is observed of both cables `t` s after the start: they slide to and fro, and what the first one's
    /// change adds is left unexplained.
    fn observe(monitor: &mut HealthMonitor, t: f64, law: &CableLaw, change: Change, noise: &mut Random) {
        let angle = law.friction_angle();
        let compliance: f64 = law.compliance().iter().sum();
        let rate = 0.8 * libm::cos(0.9 * t);
        let mean = |z: f64| (1.0 - libm::exp(-z)) / z;
        let speeds = ARMS.map(|arm| -arm * rate);
        let tension_in = [0, 1].map(|k| 60.0 + 15.0 * libm::sin(0.37 * t + f64::from(k)));
        let sliding = [0, 1].map(|k| tension_in[k] * libm::exp(-speeds[k].signum() * angle));
        let stretch = |k: usize, c: f64, a: f64| c * tension_in[k] * mean(speeds[k].signum() * a);
        let worn = stretch(0, compliance * (1.0 + change.compliance), angle * (1.0 + change.friction));
        let unexplained = [stretch(0, compliance, angle) - worn, 0.0].map(|x| x + 1e-5 * noise.normal());
        let lost =
            change.pretension * law.pretension() - change.friction * speeds[0].signum() * angle * sliding[0];
        monitor.sample(
            monitor.next,
            &Observed {
                moment_arms: &ARMS,
                lengths: &ARMS.map(|arm| 0.5 - arm * libm::sin(0.9 * t) / 0.9 * 0.8),
                motor: &[0.0; 2],
                joint: &[0.0],
                tension: &tension_in,
                tension_in: &tension_in,
                tension_out: &sliding.map(|tension| tension + law.pretension()),
                unexplained: &unexplained,
                drag_factor: &[1.0; 2],
                joint_innovation: &[0.0],
                disturbance_torque: &[ARMS[0] * lost + 0.002 * noise.normal()],
                anchor_speed: &speeds,
                symptom: crate::control::arm::Symptom::Unknown,
            },
            law,
            true,
        );
        monitor.next = 1 - monitor.next;
    }

    /// After a quarter of an hour as new and half an hour with a change.
    fn watched(change: Change) -> HealthMonitor {
        let law = CableLaw::new(&CablePath::bench(), &CableParameters::bench(), 12).unwrap();
        let (mut monitor, mut noise) = (HealthMonitor::new(2, 1), Random::new(3));
        let h = 0.1;
        for k in 0..27_000 {
            let t = h * f64::from(k);
            let present = if t < 900.0 { Change::default() } else { change };
            observe(&mut monitor, t, &law, present, &mut noise);
            monitor.pass(h, |_| law.pretension());
        }
        monitor
    }

    #[test]
    fn cables_that_do_not_change_are_healthy() {
        let monitor = watched(Change::default());
        for health in monitor.health() {
            assert_eq!(health.found(), None);
            for drift in [health.friction, health.stiffness, health.pretension] {
                assert!(drift.fraction.abs() < 0.02 && drift.error.is_finite(), "{drift:?}");
                assert!(drift.remaining.is_infinite());
            }
        }
    }

    #[test]
    fn each_change_of_a_cable_is_measured_and_named_with_its_cable() {
        let friction = Change { friction: 0.1, ..Change::default() };
        let softer = Change { compliance: 0.08, ..Change::default() };
        let slack = Change { pretension: -0.3, ..Change::default() };
        for (change, kind) in [
            (friction, FaultKind::FrictionDrift),
            (softer, FaultKind::StiffnessDrift),
            (slack, FaultKind::PretensionDrift),
        ] {
            let monitor = watched(change);
            let [worn, other] = [0, 1].map(|k| monitor.health()[k]);
            assert_eq!((worn.found(), other.found()), (Some(kind), None), "{change:?}");
            assert_eq!(
                [worn.friction, worn.stiffness, worn.pretension].iter().filter(|d| d.found).count(),
                1
            );
            match kind {
                FaultKind::FrictionDrift => assert!((worn.friction.fraction - 0.1).abs() < 0.01, "{worn:?}"),
                FaultKind::StiffnessDrift => {
                    assert!((worn.stiffness.fraction + 0.08).abs() < 0.01, "{worn:?}");
                }
                _ => assert!((worn.pretension.fraction + 0.3).abs() < 0.03, "{worn:?}"),
            }
        }
    }

    #[test]
    fn the_windows_last_a_minute_and_the_first_one_does_not_count() {
        let law = CableLaw::new(&CablePath::bench(), &CableParameters::bench(), 12).unwrap();
        let (mut monitor, mut noise) = (HealthMonitor::new(2, 1), Random::new(3));
        let mut known = None;
        for k in 0..12_000 {
            let t = 0.1 * f64::from(k);
            observe(&mut monitor, t, &law, Change::default(), &mut noise);
            monitor.pass(0.1, |_| law.pretension());
            if known.is_none() && monitor.health()[0].friction.error.is_finite() {
                known = Some(t);
            }
        }
        // Eight windows after the one in which the observers settle.
        assert!((known.unwrap() - 9.0 * WINDOW).abs() < 0.3, "{known:?}");
    }

    #[test]
    fn a_cable_that_creeps_tells_no_direction_of_sliding_and_a_rejected_tension_nothing() {
        let law = CableLaw::new(&CablePath::bench(), &CableParameters::bench(), 12).unwrap();
        for (speed, tension, slides, counts) in [
            (2.1 * SLIDING_SPEED, 50.0, true, true),
            (-2.1 * SLIDING_SPEED, 50.0, true, true),
            (0.9 * SLIDING_SPEED, 50.0, true, false),
            (2.1 * SLIDING_SPEED, 50.0, false, false),
            (2.1 * SLIDING_SPEED, f64::NAN, true, false),
        ] {
            let mut monitor = HealthMonitor::new(1, 1);
            for sign in [1.0, -1.0].repeat(60) {
                let observed = Observed {
                    moment_arms: &[0.03],
                    lengths: &[0.5],
                    motor: &[0.0],
                    joint: &[0.0],
                    tension: &[tension],
                    tension_in: &[50.0],
                    tension_out: &[30.0],
                    unexplained: &[0.0],
                    drag_factor: &[1.0],
                    joint_innovation: &[0.0],
                    disturbance_torque: &[0.0],
                    anchor_speed: &[sign * speed],
                    symptom: crate::control::arm::Symptom::Unknown,
                };
                monitor.sample(0, &observed, &law, slides);
            }
            assert_eq!(
                monitor.cables[0].sliding.solve(120.0).is_some(),
                counts,
                "{speed} {tension} {slides}"
            );
            // The torques count every sample, their friction where it slides.
            assert!((monitor.cables[0].torque.samples() - 120.0).abs() < 0.5);
            let sure = speed.abs() > SLIDING_SPEED && slides;
            assert_eq!(monitor.cables[0].torque.friction().is_some(), sure);
        }
    }

    #[test]
    fn the_fits_take_travel_torque_and_learned_drag_of_their_own_cable() {
        let law = CableLaw::new(&CablePath::bench(), &CableParameters::bench(), 12).unwrap();
        let [drag, drag_fade] = law.drag();
        let model = SlidingModel {
            angle: law.friction_angle(),
            compliance: law.compliance().iter().sum(),
            drag,
            drag_fade,
        };
        let (mut monitor, mut random) = (HealthMonitor::new(2, 2), Random::new(4));
        let mut learned = [0.0; 2];
        let mut expected = [(SlidingFit::default(), TorqueFit::default()); 2];
        for cycle in 0..800 {
            let k = cycle % 2;
            let mut draw = |scale: f64| [0, 1].map(|_| scale * random.normal());
            let (arms, more_arms) = (draw(0.03), draw(0.02));
            let (lengths, errors, torque) = (draw(0.01), draw(1e-3), draw(1.0));
            let (unexplained, innovation) = (draw(1e-4), draw(0.5));
            let speeds = draw(0.05);
            let estimated = draw(5.0).map(|x| 50.0 + x);
            let tension = [0, 1].map(|k| estimated[k] + innovation[k]);
            let out = draw(2.0).map(|x| 30.0 + x);
            let factors = draw(0.2).map(|x| 1.2 + x);
            let moment_arms = [arms, more_arms].concat();
            monitor.sample(
                k,
                &Observed {
                    moment_arms: &moment_arms,
                    lengths: &lengths,
                    motor: &[0.0; 2],
                    joint: &[0.0; 2],
                    tension: &tension,
                    tension_in: &estimated,
                    tension_out: &out,
                    unexplained: &unexplained,
                    drag_factor: &factors,
                    joint_innovation: &errors,
                    disturbance_torque: &torque,
                    anchor_speed: &speeds,
                    symptom: crate::control::arm::Symptom::Unknown,
                },
                &law,
                true,
            );
            let own = [arms, more_arms][k];
            let sample = SlidingSample {
                position: -lengths[k],
                speed: speeds[k],
                tension: estimated[k],
                unexplained: unexplained[k],
                anchor_error: own[0] * errors[0] + own[1] * errors[1],
                innovation: innovation[k],
                drag_factor: factors[k],
            };
            learned[k] = model.learned_drag(&sample);
            let slides = speeds[k].abs() > 2e-3;
            if slides {
                expected[k].0.add(&sample, &model);
            }
            let left = [0, 1].map(|j| torque[j] - arms[j] * learned[0] - more_arms[j] * learned[1]);
            let friction = speeds[k].signum() * model.angle * (out[k] - law.pretension());
            expected[k].1.add(&own, &left, if slides { friction } else { 0.0 });
        }
        let near = |a: f64, b: f64| (a - b).abs() < 1e-9 * (1.0 + b.abs());
        for (cable, (sliding, torque)) in monitor.cables.iter().zip(&expected) {
            let [found, desired] = [cable.sliding, *sliding].map(|fit| fit.solve(400.0).unwrap());
            assert!(found.iter().zip(&desired).all(|(a, b)| near(a.value, b.value)), "{found:?} {desired:?}");
            let [found, desired] = [cable.torque, *torque].map(|fit| fit.friction().unwrap());
            assert!(near(found.value, desired.value) && near(found.power, desired.power));
            let [found, desired] = [cable.torque, *torque].map(|fit| fit.force().unwrap());
            assert!(near(found.value, desired.value) && near(found.power, desired.power));
        }
    }
}
