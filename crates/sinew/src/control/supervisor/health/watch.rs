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
/// ([`SlidingFit`]), and pretension and friction once more to the torques of the disturbances ([`TorqueFit`]); the drift of
/// each number from its values in the first windows is judged ([`DriftWatch`]). One cable is sampled per control cycle.
///
/// Stiffness is judged by the travel alone. Of friction and pretension one change of one cable is named, the one that explains the torques
/// best: of a short cable they show smaller frictions than its travel does.
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

/// A change of a cable that explains the torques.
#[derive(Debug, Clone, Copy, PartialEq)]
struct Explanation {
    cable: usize,
    change: Change,
    found: bool,
    /// How far it has drifted, in standard errors.
    drift: f64,
}

#[derive(Debug, Clone, Copy, PartialEq, Eq)]
enum Change {
    Friction,
    Pretension,
}

/// s.
const WINDOW: f64 = 60.0;
/// Speed of an anchor from which on the direction of sliding is certain, m/s.
const SLIDING_SPEED: f64 = 2e-3;
/// Share of the most from which on the frictions of two cables explain the torques alike: a correlation of 0.77.
const ALIKE: f64 = 0.6;
/// A change that explains the torques is named in the place of a softer cable if its drift is this many times as many standard errors.
const DIRECT: f64 = 2.0;
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
    pub(in crate::control::supervisor) fn new(muscles: usize, joints: usize) -> Self {
        let watched = Watched {
            sliding: SlidingFit::default(),
            torque: TorqueFit::default(),
            friction: DriftWatch::new(FRICTION),
            friction_by_torque: DriftWatch::new(FRICTION),
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
            let sample = SlidingSample {
                position: -observed.lengths[k],
                speed,
                // The estimate stands for the tension: noise of the reading on both sides of the fit would look like a
                // stiffness.
                tension: observed.tension_in[k],
                unexplained: observed.unexplained[k],
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
            let joints = self.torque.len();
            for (arms, drag) in observed.moment_arms.chunks_exact(joints.max(1)).zip(&self.learned_drag) {
                self.torque.iter_mut().zip(arms).for_each(|(torque, arm)| *torque -= arm * drag);
            }
            cable.torque.add(&observed.moment_arms[k * joints..(k + 1) * joints], &self.torque, friction);
        }
        if self.time >= WINDOW {
            self.close_window(controller);
            self.time = 0.0;
        }
    }

    fn close_window(&mut self, controller: &ArmController) {
        for (k, cable) in self.cables.iter_mut().enumerate() {
            cable.close_window(self.time, controller.cable_law(k).map_or(0.0, |law| law.pretension()));
        }
        // A softer cable changes the torques, and more friction or less pretension the fitted compliance; the travel shows a
        // compliance directly, the torques do not.
        let explanation = self.best_explanation();
        let softest = self.cables.iter().map(|cable| cable.stiffness.drift()).filter(|drift| drift.found);
        let softest = softest.map(|drift| drift.deviations().abs()).fold(0.0, f64::max);
        let softer = DIRECT * softest > explanation.map_or(0.0, |explanation| explanation.drift);
        for (k, (health, cable)) in self.health.iter_mut().zip(&self.cables).enumerate() {
            let explains = |change| explanation.filter(|it| !softer && it.cable == k && it.change == change);
            let [mut friction, mut stiffness, mut pretension] =
                [&cable.friction, &cable.stiffness, &cable.pretension].map(DriftWatch::drift);
            friction.found = false;
            if let Some(Explanation { found, .. }) = explains(Change::Friction) {
                friction = Drift { found, ..friction.joined(&cable.friction_by_torque.drift()) };
            }
            pretension.found = explains(Change::Pretension).is_some_and(|it| it.found);
            stiffness.found &= softer;
            *health = CableHealth { friction, stiffness, pretension };
        }
    }

    /// The one change of one cable that explains the torques best. Of cables whose frictions explain them alike, as those of
    /// antagonists, it is the one whose travel shows most, if that is more by a standard deviation.
    fn best_explanation(&self) -> Option<Explanation> {
        let explained = |cable: &Watched| cable.explained.into_iter().fold(0.0, f64::max);
        let most = self.cables.iter().map(explained).fold(0.0, f64::max);
        let best = self.cables.iter().position(|cable| most > 0.0 && explained(cable) >= most)?;
        let [friction, pretension] = self.cables[best].explained;
        if pretension > friction {
            let drift = self.cables[best].pretension.drift();
            let (found, drift) = (drift.found, drift.deviations().abs());
            return Some(Explanation { cable: best, change: Change::Pretension, found, drift });
        }
        let alike = || self.cables.iter().enumerate().filter(|(_, cable)| cable.explained[0] > ALIKE * most);
        let shown = |(k, cable): &(usize, &Watched)| {
            cable.friction.drift().deviations() + if *k == best { 1.0 } else { 0.0 }
        };
        let (named, cable) = alike().max_by(|one, other| shown(one).total_cmp(&shown(other)))?;
        let by_torque = || alike().map(|(_, cable)| cable.friction_by_torque.drift());
        Some(Explanation {
            cable: named,
            change: Change::Friction,
            found: cable.friction.drift().found || by_torque().any(|drift| drift.found),
            drift: by_torque().map(|drift| drift.deviations()).fold(0.0, f64::max),
        })
    }
}

impl Watched {
    /// Fits what was sampled in a window of `time` s; `pretension` of the model, N.
    fn close_window(&mut self, time: f64, pretension: f64) {
        if let Some([compliance, friction]) = self.sliding.solve() {
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
        (self.sliding, self.torque) = (SlidingFit::default(), TorqueFit::default());
    }
}

#[cfg(test)]
mod tests {
    use super::*;

    /// A machine whose cables explain so much of the torques, `[friction, pretension]`, and show so much friction by their travel.
    fn monitor(cables: &[([f64; 2], f64)]) -> HealthMonitor {
        let mut monitor = HealthMonitor::new(cables.len(), 1);
        for (cable, (explained, shown)) in monitor.cables.iter_mut().zip(cables) {
            cable.explained = *explained;
            for k in 0..40 {
                let value = if k < 8 { 0.0 } else { *shown };
                cable.friction.update(Estimate { value, deviation: 0.02 }, WINDOW);
                let torque = if explained[0] > 0.5 { 0.1 * f64::from(k) } else { 0.0 };
                cable.friction_by_torque.update(Estimate { value: torque, deviation: 0.0 }, WINDOW);
            }
        }
        monitor
    }

    #[test]
    fn the_change_that_explains_the_torques_best_is_named_and_of_alike_ones_that_which_the_travel_shows() {
        let named = |cables: &[([f64; 2], f64)]| {
            monitor(cables).best_explanation().map(|it| (it.cable, it.change, it.found))
        };
        assert_eq!(named(&[([0.0, 0.0], 0.5), ([0.0, 0.0], 0.0)]), None);
        assert_eq!(named(&[([1.0, 0.3], 0.0), ([0.2, 0.6], 0.5)]), Some((0, Change::Friction, true)));
        assert_eq!(named(&[([1.0, 0.3], 0.01), ([0.9, 0.2], 0.03)]), Some((1, Change::Friction, true)));
        assert_eq!(named(&[([1.0, 0.3], 0.01), ([0.9, 0.2], 0.012)]), Some((0, Change::Friction, true)));
        assert_eq!(named(&[([1.0, 0.3], -0.1), ([0.9, 1.2], 0.5)]), Some((1, Change::Pretension, false)));
        // What has not drifted by itself is not reported.
        assert_eq!(named(&[([0.3, 0.1], 0.0), ([0.0, 0.0], 0.5)]), Some((0, Change::Friction, false)));
    }
}
