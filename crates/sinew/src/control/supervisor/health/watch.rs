use super::drift::{Drift, DriftRule, DriftWatch, Estimate, Wear};
use super::explanation::{self, Change, Evidence, Shown};
use super::sliding::{SlidingFit, SlidingModel, SlidingSample};
use super::torque::TorqueFit;
use crate::control::arm::ArmController;
use crate::control::supervisor::fault_kind::FaultKind;
use alloc::vec;
use alloc::vec::Vec;

/// Slow changes of a cable since the first minutes of operation, as shares of its model's values.
#[derive(Debug, Clone, Copy, PartialEq, Default)]
pub struct CableHealth {
    /// Of its friction angle `mu phi`.
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
/// Once a window of [`WINDOW`] s of motion, friction and compliance are fitted to the travel that the observers do not explain
/// ([`SlidingFit`]), and pretension and friction once more to the torques of the disturbances ([`TorqueFit`]); the drift of
/// each number from its values in the first windows is judged ([`DriftWatch`]). One cable is sampled per control cycle.
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

/// s.
const WINDOW: f64 = 60.0;
/// Speed of an anchor from which on the direction of sliding is certain, m/s.
const SLIDING_SPEED: f64 = 2e-3;
/// Friction that falls, of a cable that runs in or of grease that warms, does no harm.
const FRICTION: DriftRule = DriftRule {
    least_deviation: 0.003,
    least_drift: 0.015,
    cusum: [2.0, 12.0],
    limit: 0.2,
    wear: Wear::Growth,
};
/// The torques show masses and loads, too.
const FRICTION_BY_TORQUE: DriftRule =
    DriftRule { least_deviation: 0.01, least_drift: 0.04, cusum: [1.0, 8.0], ..FRICTION };
/// No cable becomes stiffer by wear.
const STIFFNESS: DriftRule = DriftRule { least_drift: 0.03, wear: Wear::Fall, ..FRICTION };
const PRETENSION: DriftRule =
    DriftRule { least_deviation: 0.02, least_drift: 0.1, cusum: [1.0, 8.0], limit: 0.5, wear: Wear::Either };

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
        self.time += h;
        let observed = controller.observed();
        let k = self.next;
        self.next = (self.next + 1) % self.cables.len().max(1);
        if let (Some(cable), Ok(law)) = (self.cables.get_mut(k), controller.cable_law(k)) {
            let [drag, drag_fade] = law.drag();
            let model = SlidingModel {
                angle: law.friction_angle(),
                compliance: law.compliance().iter().sum(),
                drag,
                drag_fade,
            };
            let (speed, tension) = (observed.anchor_speed[k], observed.tension[k]);
            let joints = self.torque.len();
            let arms = &observed.moment_arms[k * joints..(k + 1) * joints];
            let errors = arms.iter().zip(observed.joint_innovation);
            let sample = SlidingSample {
                position: -observed.lengths[k],
                speed,
                // The estimate stands for the tension: noise of the reading on both sides of the fit would look like a
                // stiffness.
                tension: observed.tension_in[k],
                unexplained: observed.unexplained[k],
                anchor_error: errors.map(|(arm, error)| arm * error).sum(),
                innovation: tension - observed.tension_in[k],
                drag_factor: observed.drag_factor[k],
            };
            let slides = speed.abs() > SLIDING_SPEED && controller.slides(k);
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
        if self.time >= WINDOW {
            self.close_window(controller);
            self.time = 0.0;
        }
    }

    /// The observers begin anew: the window that was begun and the next one, in which they settle, do not count. What the
    /// windows before showed is kept.
    pub(in crate::control::supervisor) fn restart(&mut self) {
        self.cables.iter_mut().for_each(Watched::discard);
        (self.time, self.settled) = (0.0, false);
    }

    fn close_window(&mut self, controller: &ArmController) {
        if !core::mem::replace(&mut self.settled, true) {
            self.cables.iter_mut().for_each(Watched::discard);
            return;
        }
        for (k, cable) in self.cables.iter_mut().enumerate() {
            cable.close_window(self.time, controller.cable_law(k).map_or(0.0, |law| law.pretension()));
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
            let grown = self.friction_by_torque.drift().share.max(0.0);
            self.explained[0] = grown * grown * change.power;
        }
        if let (Some(change), true) = (self.torque.force(), pretension > 0.0) {
            self.pretension.update(exact(change.value / pretension), time);
            let lost = (-self.pretension.drift().share).max(0.0) * pretension;
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
}
