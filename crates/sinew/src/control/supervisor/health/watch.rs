use super::drift::{Drift, DriftRule, DriftWatch, Estimate, Wear};
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
/// ([`SlidingFit`]) and the force that each anchor lacks to the torques of the disturbances ([`TorqueFit`]); the drift of
/// each number from its values in the first windows is judged ([`DriftWatch`]). One cable is sampled per control cycle.
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
    next: usize,
    time: f64,
}

/// State of one cable.
#[derive(Debug, Clone, Copy)]
struct Watched {
    sliding: SlidingFit,
    torque: TorqueFit,
    friction: DriftWatch,
    stiffness: DriftWatch,
    pretension: DriftWatch,
    /// Mean square of the torques that its change explains, Nm^2, where it lacks force.
    explained: f64,
}

/// s.
const WINDOW: f64 = 60.0;
/// Speed of an anchor from which on the direction of sliding is certain, m/s.
const SLIDING_SPEED: f64 = 2e-3;
/// Friction that falls, of a cable that runs in or of grease that warms, does no harm.
const FRICTION: DriftRule =
    DriftRule { least_deviation: 0.01, least_drift: 0.04, limit: 0.2, wear: Wear::Growth };
/// No cable becomes stiffer by wear: where its sheath is so short that friction and stretch act alike, friction that grows
/// looks like it.
const STIFFNESS: DriftRule =
    DriftRule { least_deviation: 0.01, least_drift: 0.04, limit: 0.2, wear: Wear::Fall };
const PRETENSION: DriftRule =
    DriftRule { least_deviation: 0.02, least_drift: 0.1, limit: 0.5, wear: Wear::Either };

impl HealthMonitor {
    pub(in crate::control::supervisor) fn new(muscles: usize) -> Self {
        let watched = Watched {
            sliding: SlidingFit::default(),
            torque: TorqueFit::default(),
            friction: DriftWatch::new(FRICTION),
            stiffness: DriftWatch::new(STIFFNESS),
            pretension: DriftWatch::new(PRETENSION),
            explained: 0.0,
        };
        Self {
            cables: vec![watched; muscles],
            health: vec![CableHealth::default(); muscles],
            next: 0,
            time: 0.0,
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
        let joints = observed.disturbance_torque.len().max(1);
        let k = self.next;
        self.next = (self.next + 1) % self.cables.len().max(1);
        if let (Some(cable), Ok(law)) = (self.cables.get_mut(k), controller.cable_law(k)) {
            let (tension, speed) = (observed.tension[k], observed.anchor_speed[k]);
            if speed.abs() > SLIDING_SPEED && tension.is_finite() && controller.slides(k) {
                let [drag, drag_fade] = law.drag();
                let (angle, compliance) = (law.friction_angle(), law.compliance().iter().sum());
                let position = -observed.lengths[k];
                let (unexplained, drag_factor) = (observed.unexplained[k], observed.drag_factor[k]);
                // The estimate stands for the tension: noise of the reading on both sides of the fit would look like a
                // stiffness.
                let (innovation, tension) = (tension - observed.tension_in[k], observed.tension_in[k]);
                let sample = SlidingSample { position, speed, tension, unexplained, innovation, drag_factor };
                cable.sliding.add(&sample, &SlidingModel { angle, compliance, drag, drag_fade });
            }
            let arms = observed.moment_arms.get(k * joints..(k + 1) * joints).unwrap_or_default();
            cable.torque.add(arms, observed.disturbance_torque);
        }
        if self.time >= WINDOW {
            self.close_window(controller);
            self.time = 0.0;
        }
    }

    fn close_window(&mut self, controller: &ArmController) {
        for (k, cable) in self.cables.iter_mut().enumerate() {
            if let Some([compliance, friction]) = cable.sliding.solve() {
                cable.friction.update(friction, self.time);
                let stiffness = Estimate { value: -compliance.value, ..compliance };
                cable.stiffness.update(stiffness, self.time);
            }
            let pretension = controller.cable_law(k).map_or(0.0, |law| law.pretension());
            if let (Some([force, arms]), true) = (cable.torque.solve(), pretension > 0.0) {
                let lacking = Estimate { value: force / pretension, deviation: 0.0 };
                cable.pretension.update(lacking, self.time);
                let lost = (-cable.pretension.drift().share).max(0.0) * pretension;
                cable.explained = lost * lost * arms;
            }
            (cable.sliding, cable.torque) = (SlidingFit::default(), TorqueFit::default());
        }
        let worn =
            self.cables.iter().any(|cable| cable.friction.drift().found || cable.stiffness.drift().found);
        let most = self.cables.iter().fold(0.0_f64, |most, cable| most.max(cable.explained));
        for (health, cable) in self.health.iter_mut().zip(&self.cables) {
            let mut pretension = cable.pretension.drift();
            // One cable explains the torques best; where friction or stiffness has changed, that does.
            pretension.found &= !worn && cable.explained > 0.0 && cable.explained >= most;
            *health = CableHealth {
                friction: cable.friction.drift(),
                stiffness: cable.stiffness.drift(),
                pretension,
            };
        }
    }
}
