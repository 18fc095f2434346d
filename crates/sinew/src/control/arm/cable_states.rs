use super::open_loop::{Copied, Corrected, OpenLoopCables};
use crate::Error;
use crate::error::check_length;
use crate::muscle::MuscleDynamics;
use crate::predictor::{CableEstimate, CableModel, CableObservers, CableSample};
use crate::transmission::SheathBend;
use crate::transmission::cable::{BothDirections, CableLaw};
use alloc::vec;
use alloc::vec::Vec;

/// Source of the far tensions and stretches that the controller feeds back.
#[derive(Debug, Clone, Copy, PartialEq, Eq)]
pub enum CableStateSource {
    /// The cables' observers: encoders, load cells and the identified law.
    Observer,
    /// The encoders alone: stretch is the relative displacement of a cable's ends since the start, far
    /// tensions are taken as the desired ones.
    Encoders,
}

/// Estimated state of all cables: `[muscles]` each.
#[derive(Debug, Clone)]
pub(super) struct CableStates {
    source: CableStateSource,
    observers: CableObservers,
    open_loop: OpenLoopCables,
    samples: Vec<CableSample>,
    estimates: Vec<CableEstimate>,
    wraps: Vec<JointWrap>,
    /// Bends of the sheaths that pass joints: `[muscles]`, or none.
    bends: Vec<SheathBend>,
    next_wrap: usize,
    /// Stretch minus relative displacement of a cable's ends at the start, m.
    stretch_offset: Vec<f64>,
    started: bool,
    /// Whether the profile of a cable no longer depends on its initial one.
    pub(super) known: Vec<bool>,
    /// `T_out^`, N.
    pub(super) tension_out: Vec<f64>,
    /// `e^`, m.
    pub(super) stretch: Vec<f64>,
    /// `T_in^`, N.
    pub(super) tension_in: Vec<f64>,
    /// `c`, of the whole cable, m/N.
    pub(super) compliance: Vec<f64>,
    /// Speed of the winch in addition to its encoder's that the tension at the drive asks for, m/s.
    pub(super) unexplained_speed: Vec<f64>,
    /// Drag as a multiple of the law's, 1.
    pub(super) drag_factor: Vec<f64>,
    /// Travel of the winch in addition to its encoder's since the start, m: the integral of the correction.
    pub(super) unexplained: Vec<f64>,
}

/// The last pulley of a cable's path, which stands for its joints.
#[derive(Debug, Clone, Copy)]
struct JointWrap {
    pulley: usize,
    /// Wrap angle set in the observer, rad; NaN before the first.
    angle: f64,
}

/// Change of a wrap angle from which on it is set in the observer, rad.
const WRAP_RESOLUTION: f64 = 1e-3;
/// Largest wrap angle that one node of a cable represents, rad.
const MAX_WRAP: f64 = 4.0;

impl CableStates {
    pub(super) fn new(models: &[CableModel], source: CableStateSource, joints: usize) -> Result<Self, Error> {
        let n = models.len();
        let wrap = |model: &CableModel| JointWrap {
            pulley: model.path.pulleys().saturating_sub(1),
            angle: f64::NAN,
        };
        let observers = CableObservers::new(models)?;
        let whole = |k| observers.cables().law(k).map_or(0.0, |law| law.compliance().iter().sum());
        Ok(Self {
            source,
            compliance: (0..n).map(whole).collect(),
            observers,
            open_loop: OpenLoopCables::new(models, joints)?,
            samples: vec![CableSample::default(); n],
            estimates: vec![CableEstimate::default(); n],
            wraps: models.iter().map(wrap).collect(),
            bends: Vec::new(),
            next_wrap: 0,
            stretch_offset: vec![0.0; n],
            started: false,
            known: vec![false; n],
            tension_out: vec![0.0; n],
            stretch: vec![0.0; n],
            tension_in: vec![0.0; n],
            unexplained_speed: vec![0.0; n],
            drag_factor: vec![1.0; n],
            unexplained: vec![0.0; n],
        })
    }

    /// The next update is the first.
    pub(super) fn restart(&mut self) {
        self.observers.reset();
        self.open_loop.restart();
        self.started = false;
        self.wraps.iter_mut().for_each(|wrap| wrap.angle = f64::NAN);
        self.unexplained_speed.fill(0.0);
        self.unexplained.fill(0.0);
    }

    /// Lets the bends of the sheaths follow the pose: `[muscles]`, each scaled to the bend for which its
    /// friction was identified.
    pub(super) fn set_sheath_bends(&mut self, bends: &[SheathBend]) -> Result<(), Error> {
        check_length("bends", bends.len(), self.samples.len())?;
        self.bends.clear();
        if bends.iter().any(|bend| !bend.is_constant()) {
            let identified = |(k, bend): (usize, &SheathBend)| match bend.is_constant() {
                true => Ok(bend.clone()),
                false => bend.scaled_to(self.law(k)?.sheath_bend()),
            };
            self.bends = bends.iter().enumerate().map(identified).collect::<Result<_, _>>()?;
        }
        Ok(())
    }

    /// One step of `h` s with measured motor positions, m, and tensions, N, in a pose of the independent
    /// joints in which the body was evaluated, and the tensions desired before, N.
    pub(super) fn update(
        &mut self,
        h: f64,
        (motor, tension): (&[f64], &[f64]),
        (body, pose): (&MuscleDynamics, &[f64]),
        desired_tension: &[f64],
    ) -> Result<(), Error> {
        self.update_angles(body, pose)?;
        for (k, (sample, length)) in self.samples.iter_mut().zip(body.lengths()).enumerate() {
            *sample = CableSample { motor: motor[k], anchor: -length, tension_in: tension[k] };
        }
        self.observers.step(h, &self.samples, &mut self.estimates)?;
        for (k, (estimate, sample)) in self.estimates.iter().zip(&self.samples).enumerate() {
            self.tension_in[k] = estimate.tension_in;
            self.known[k] = estimate.known;
            self.unexplained_speed[k] = estimate.unexplained_speed;
            self.unexplained[k] += h * estimate.correction;
            let displacement = sample.motor - sample.anchor;
            if !self.started {
                self.stretch_offset[k] = estimate.stretch - displacement;
            }
            (self.tension_out[k], self.stretch[k], self.drag_factor[k]) = match self.source {
                CableStateSource::Encoders if self.started => {
                    (desired_tension[k], self.stretch_offset[k] + displacement, 1.0)
                }
                _ => (estimate.tension_out, estimate.stretch, estimate.drag_factor),
            };
        }
        self.started = true;
        Ok(())
    }

    /// One cycle of the observers without load cells, after [`update`](Self::update): with the pose and the
    /// torque of the disturbances, and whether nothing is suspected, so that copies may be made. Returns
    /// whether what they say is new.
    pub(super) fn step_open_loop(
        &mut self,
        h: f64,
        pose: &[f64],
        disturbance_torque: &[f64],
        renewing: bool,
    ) -> Result<bool, Error> {
        if self.source == CableStateSource::Encoders {
            return Ok(false);
        }
        let Self { observers, open_loop, samples, unexplained, .. } = self;
        let corrected = Corrected { observers, unexplained, pose, disturbance_torque };
        open_loop.step(h, samples, &corrected, renewing)
    }

    /// The observers without load cells, once they have been copied.
    pub(super) fn open_loop(&self) -> Option<&Copied> {
        self.open_loop.used()
    }

    /// The observer of a cable forgets what its load cell has told since the copy was made.
    pub(super) fn forget_load_cell(&mut self, cable: usize) -> Result<(), Error> {
        if let Some(copy) = self.open_loop.used() {
            self.unexplained[cable] = copy.unexplained[cable];
            self.open_loop.correct(cable, &mut self.observers)?;
        }
        Ok(())
    }

    /// Whether the whole cable slid in one direction in the last step.
    pub(super) fn slides(&self, cable: usize) -> bool {
        self.observers.cables().slides_everywhere(cable)
    }

    /// Stretch of every cable, m, that slides steadily toward its motor, and away from it: `[muscles]`.
    ///
    /// # Errors
    /// As [`CableLaw::sliding`].
    pub(super) fn stretch_in_both_directions(
        &self,
        sliding: &[BothDirections],
        stretch: &mut [[f64; 2]],
    ) -> Result<(), Error> {
        self.observers.cables().stretch_in_both_directions(sliding, stretch)
    }

    /// The law of a cable at its present wrap angles and bend.
    pub(super) fn law(&self, cable: usize) -> Result<&CableLaw, Error> {
        let expected = self.samples.len();
        self.observers.cables().law(cable).ok_or(Error::WrongLength { name: "cables", expected, got: cable })
    }

    /// Sets the wrap angles and bends of the pose: of all cables at first, then of one cable per cycle,
    /// because poses change slowly.
    fn update_angles(&mut self, body: &MuscleDynamics, pose: &[f64]) -> Result<(), Error> {
        let n = self.wraps.len();
        let first = self.wraps.iter().any(|wrap| wrap.angle.is_nan());
        for k in if first { 0..n } else { self.next_wrap..self.next_wrap + 1 } {
            let wrap = &mut self.wraps[k];
            let angle = body.wrap_angle(k).clamp(0.0, MAX_WRAP);
            if wrap.angle.is_nan() || (angle - wrap.angle).abs() >= WRAP_RESOLUTION {
                self.observers.set_wrap(k, wrap.pulley, angle)?;
                self.open_loop.set_wrap(k, wrap.pulley, angle)?;
                wrap.angle = angle;
            }
            if let Some(bend) = self.bends.get(k).filter(|bend| !bend.is_constant()) {
                self.observers.set_sheath_bend(k, bend.at(pose))?;
                self.open_loop.set_sheath_bend(k, bend.at(pose))?;
            }
        }
        self.next_wrap = (self.next_wrap + 1) % n;
        Ok(())
    }
}

#[cfg(test)]
mod tests {
    use super::*;
    use crate::body::{Robot, SheathGeometry};
    use crate::predictor::CableObserver;
    use crate::transmission::cable::{CablePath, Segment};

    const H: f64 = 1e-3;
    const POSE: [f64; 3] = [0.1, 0.2, -0.3];
    const DESIRED: [f64; 3] = [41.0, 42.0, 43.0];
    const TENSION: [f64; 3] = [50.0, 60.0, 70.0];

    /// A chain whose cables leave their sheaths at an angle that depends on the pose.
    fn body() -> MuscleDynamics {
        let mut parts = crate::muscle::tests::robots::chain(false).parts().clone();
        for tendon in &mut parts.tendons {
            let end_axis = Some([libm::cos(0.5), 0.0, libm::sin(0.5)]);
            tendon.sheath = Some(SheathGeometry { length: 0.5, bend: 1.0, end_axis });
        }
        let mut body = MuscleDynamics::new(&Robot::new(parts).unwrap()).unwrap();
        body.evaluate(&POSE).unwrap();
        body
    }

    fn models() -> Vec<CableModel> {
        let of = |k: u32| {
            let mut model = CableModel { start: 0.5, ..CableModel::bench() };
            model.parameters.compliance *= 1.0 + 0.2 * f64::from(k);
            model
        };
        (0..3).map(of).collect()
    }

    fn states(source: CableStateSource) -> CableStates {
        CableStates::new(&models(), source, 3).unwrap()
    }

    fn step(states: &mut CableStates, motor: &[f64], body: &MuscleDynamics, pose: &[f64]) {
        states.update(H, (motor, &TENSION), (body, pose), &DESIRED).unwrap();
    }

    /// Friction angle of the bench's path with this wrap at its last pulley.
    fn friction_angle(wrap: f64) -> f64 {
        let model = &models()[0];
        let bent = |segment: &Segment| match segment {
            Segment::Pulley { .. } => Segment::Pulley { wrap },
            other => other.clone(),
        };
        let path = CablePath::new(model.path.segments().iter().map(bent).collect()).unwrap();
        CableLaw::new(&path, &model.parameters, model.cells).unwrap().friction_angle()
    }

    /// Number of cables whose law has the wrap angle of the body's pose.
    fn up_to_date(states: &CableStates, body: &MuscleDynamics) -> usize {
        let is_right = |k: usize| {
            let expected = friction_angle(body.wrap_angle(k));
            (states.law(k).unwrap().friction_angle() - expected).abs() < 1e-12
        };
        (0..3).filter(|k| is_right(*k)).count()
    }

    #[test]
    fn wrap_angles_follow_the_pose_of_all_cables_at_first_and_then_of_one_cable_per_cycle() {
        let (mut body, mut states) = (body(), states(CableStateSource::Observer));
        step(&mut states, &[0.0; 3], &body, &POSE);
        assert_eq!(up_to_date(&states, &body), 3);
        for turn in [0.1, -0.2] {
            let pose = POSE.map(|q| q + turn);
            body.evaluate(&pose).unwrap();
            for cables in 0..=3 {
                assert_eq!(up_to_date(&states, &body), cables, "{turn}");
                step(&mut states, &[0.0; 3], &body, &pose);
            }
        }
    }

    #[test]
    fn a_change_of_a_wrap_angle_is_set_when_it_has_grown_to_a_milliradian() {
        let (mut body, mut states) = (body(), states(CableStateSource::Observer));
        step(&mut states, &[0.0; 3], &body, &POSE);
        let friction = models()[0].parameters.friction;
        let mut stale = 0;
        for k in 1..40 {
            let pose = POSE.map(|q| q + 2e-4 * f64::from(k));
            body.evaluate(&pose).unwrap();
            (0..3).for_each(|_| step(&mut states, &[0.0; 3], &body, &pose));
            for cable in 0..3 {
                let expected = friction_angle(body.wrap_angle(cable));
                let off = (states.law(cable).unwrap().friction_angle() - expected).abs() / friction;
                assert!(off < WRAP_RESOLUTION, "{off}");
                stale += usize::from(off > 0.1 * WRAP_RESOLUTION);
            }
        }
        // Most changes are too small, and leave the law as it is.
        assert!((100..117).contains(&stale), "{stale} of 117");
    }

    #[test]
    fn bends_of_sheaths_follow_the_pose_scaled_to_the_identified_bend_where_they_depend_on_it() {
        let identified = models()[0].path.sheath_bend();
        let varying = |slope: f64| SheathBend::new(1.2, vec![slope, 0.0, 0.1], POSE.to_vec()).unwrap();
        let constant = SheathBend::new(0.7, vec![], vec![]).unwrap();
        for bends in [
            [varying(0.5), constant.clone(), varying(-0.3)],
            [varying(0.5), varying(0.2), varying(-0.3)],
            [constant.clone(), constant.clone(), constant.clone()],
        ] {
            let (mut body, mut states) = (body(), states(CableStateSource::Observer));
            states.set_sheath_bends(&bends).unwrap();
            for turn in [0.0, 0.4, -0.3] {
                let pose = POSE.map(|q| q + turn);
                body.evaluate(&pose).unwrap();
                (0..3).for_each(|_| step(&mut states, &[0.0; 3], &body, &pose));
                for (k, bend) in bends.iter().enumerate() {
                    let fraction = if bend.is_constant() { 1.0 } else { bend.at(&pose) / 1.2 };
                    let found = states.law(k).unwrap().sheath_bend();
                    assert!((found - fraction * identified).abs() < 1e-12, "{k} {turn}: {found}");
                }
            }
        }
        let mut states = states(CableStateSource::Observer);
        let wrong = Error::WrongLength { name: "bends", expected: 3, got: 1 };
        assert_eq!(states.set_sheath_bends(&[varying(0.5)]).unwrap_err(), wrong);
    }

    /// Motor positions that pull by a tenth of a millimetre per cycle.
    fn pulled(k: u32) -> [f64; 3] {
        [1.0, 1.2, 0.8].map(|fraction| 1e-4 * fraction * f64::from(k))
    }

    #[test]
    fn the_estimates_are_those_of_every_cables_own_observer() {
        let body = body();
        let mut plain = states(CableStateSource::Observer);
        let mut observers: Vec<CableObserver> =
            models().iter().map(|model| CableObserver::new(model).unwrap()).collect();
        for (k, observer) in observers.iter_mut().enumerate() {
            observer.set_wrap(0, body.wrap_angle(k)).unwrap();
        }
        let mut travel = [0.0; 3];
        for cycle in 0..100 {
            let motor = pulled(cycle);
            step(&mut plain, &motor, &body, &POSE);
            for (k, observer) in observers.iter_mut().enumerate() {
                let sample =
                    CableSample { motor: motor[k], anchor: -body.lengths()[k], tension_in: TENSION[k] };
                let expected = observer.step(H, &sample);
                for (found, expected) in [
                    (plain.tension_out[k], expected.tension_out),
                    (plain.tension_in[k], expected.tension_in),
                    (plain.stretch[k], expected.stretch),
                    (plain.drag_factor[k], expected.drag_factor),
                ] {
                    assert!((found - expected).abs() < 1e-12, "{cycle} {k}: {found} {expected}");
                }
                // 2 mm/s per N, of 50 N at most.
                let innovation = TENSION[k] - plain.tension_in[k];
                travel[k] += H * 2e-3 * innovation.clamp(-50.0, 50.0);
                assert!((plain.unexplained_speed[k] - 2e-3 * innovation).abs() < 1e-15);
                assert!((plain.unexplained[k] - travel[k]).abs() < 1e-15, "{cycle} {k}: {travel:?}");
            }
        }
        assert!(travel.iter().all(|travel| travel.abs() > 1e-4), "{travel:?}");
    }

    #[test]
    fn by_the_encoders_alone_stretch_is_the_travel_of_both_ends_since_the_start() {
        let mut body = body();
        let (mut observed, mut states) =
            (states(CableStateSource::Observer), states(CableStateSource::Encoders));
        step(&mut observed, &[0.02; 3], &body, &POSE);
        step(&mut states, &[0.02; 3], &body, &POSE);
        let (first, lengths) = (states.stretch.clone(), body.lengths().to_vec());
        for (k, first) in first.iter().enumerate() {
            assert!((first - observed.stretch[k]).abs() < 1e-18 && *first > 0.0);
            assert!((states.tension_out[k] - observed.tension_out[k]).abs() < 1e-12);
        }
        for cycle in 1..20 {
            let pose = POSE.map(|q| q + 1e-3 * f64::from(cycle));
            body.evaluate(&pose).unwrap();
            step(&mut states, &pulled(cycle).map(|travel| 0.02 + travel), &body, &pose);
            for k in 0..3 {
                let expected = first[k] + pulled(cycle)[k] + body.lengths()[k] - lengths[k];
                assert!((states.stretch[k] - expected).abs() < 1e-15, "{cycle} {k}");
                assert!((states.tension_out[k] - DESIRED[k]).abs() < 1e-15);
                assert!((states.drag_factor[k] - 1.0).abs() < 1e-15);
            }
        }
    }

    #[test]
    fn a_cable_slides_as_a_whole_after_a_long_pull_and_no_longer_after_a_reversal() {
        let (body, mut states) = (body(), states(CableStateSource::Observer));
        step(&mut states, &[0.0; 3], &body, &POSE);
        assert!((0..3).all(|k| !states.slides(k)), "at rest");
        let mut motor = [0.0; 3];
        for _ in 0..200 {
            motor[1] += 2e-4;
            step(&mut states, &motor, &body, &POSE);
        }
        assert!(states.slides(1) && !states.slides(0) && !states.slides(2));
        motor[1] -= 2e-4;
        step(&mut states, &motor, &body, &POSE);
        assert!(!states.slides(1));
    }

    #[test]
    fn stretch_in_both_directions_is_that_of_each_law_that_slides_steadily() {
        let (body, mut states) = (body(), states(CableStateSource::Observer));
        step(&mut states, &[0.0; 3], &body, &POSE);
        let sliding: Vec<BothDirections> = [40.0, 70.0, 110.0]
            .into_iter()
            .map(|tension_out| BothDirections {
                tension_out,
                velocity: [0.01, -0.02],
                slip: 0.015,
                drag_factor: 1.3,
            })
            .collect();
        let mut stretch = [[0.0; 2]; 3];
        states.stretch_in_both_directions(&sliding, &mut stretch).unwrap();
        for (k, (one, found)) in sliding.iter().zip(stretch).enumerate() {
            for (velocity, found) in one.velocity.into_iter().zip(found) {
                let law = states.law(k).unwrap();
                let expected = law.sliding(one.tension_out, velocity, one.slip, one.drag_factor).unwrap();
                assert!((found - expected.stretch).abs() < 1e-9, "{k}: {found} {expected:?}");
            }
            assert!(found[0] > found[1] && found[1] > 0.0);
        }
    }

    #[test]
    fn restarted_states_are_those_of_new_ones() {
        for source in [CableStateSource::Observer, CableStateSource::Encoders] {
            let mut body = body();
            let (mut used, mut new) = (states(source), states(source));
            for cycle in 0..50 {
                let pose = POSE.map(|q| q - 3e-3 * f64::from(cycle));
                body.evaluate(&pose).unwrap();
                step(&mut used, &pulled(cycle), &body, &pose);
            }
            used.restart();
            assert!(used.unexplained.iter().chain(&used.unexplained_speed).all(|x| x.abs() < 1e-18));
            body.evaluate(&POSE).unwrap();
            for cycle in 0..10 {
                step(&mut used, &pulled(cycle), &body, &POSE);
                step(&mut new, &pulled(cycle), &body, &POSE);
                assert_eq!(up_to_date(&used, &body), 3);
                for (a, b) in [
                    (&used.tension_out, &new.tension_out),
                    (&used.tension_in, &new.tension_in),
                    (&used.stretch, &new.stretch),
                    (&used.unexplained, &new.unexplained),
                ] {
                    assert!(
                        a.iter().zip(b).all(|(a, b)| (a - b).abs() < 1e-12),
                        "{source:?} {cycle} {a:?} {b:?}"
                    );
                }
            }
        }
    }
}
