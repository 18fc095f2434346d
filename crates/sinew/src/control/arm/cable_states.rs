use super::residual_network::ResidualNetwork;
use crate::Error;
use crate::error::check_length;
use crate::muscle::MuscleDynamics;
use crate::predictor::{CableEstimate, CableModel, CableObservers, CableSample};
use crate::transmission::cable::{BothDirections, CableLaw};
use crate::transmission::{Perceptron, SheathBend};
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
    samples: Vec<CableSample>,
    estimates: Vec<CableEstimate>,
    /// Corrections of the observers: `[muscles]`, or none.
    residuals: Vec<ResidualNetwork>,
    wraps: Vec<JointWrap>,
    /// Bends of the sheaths that pass joints: `[muscles]`, or none.
    bends: Vec<SheathBend>,
    next_wrap: usize,
    /// Stretch minus relative displacement of a cable's ends at the start, m.
    stretch_offset: Vec<f64>,
    started: bool,
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
    pub(super) fn new(models: &[CableModel], source: CableStateSource) -> Result<Self, Error> {
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
            samples: vec![CableSample::default(); n],
            estimates: vec![CableEstimate::default(); n],
            residuals: Vec::new(),
            wraps: models.iter().map(wrap).collect(),
            bends: Vec::new(),
            next_wrap: 0,
            stretch_offset: vec![0.0; n],
            started: false,
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
        self.started = false;
        self.wraps.iter_mut().for_each(|wrap| wrap.angle = f64::NAN);
        self.unexplained_speed.fill(0.0);
        self.unexplained.fill(0.0);
    }

    /// Adds a correction to every observer: `[muscles]`.
    pub(super) fn set_residuals(&mut self, networks: Vec<Perceptron>) -> Result<(), Error> {
        check_length("residuals", networks.len(), self.samples.len())?;
        self.residuals = networks.into_iter().map(ResidualNetwork::new).collect::<Result<_, _>>()?;
        Ok(())
    }

    /// Lets the bends of the sheaths follow the pose: `[muscles]`, each scaled to the bend for which its friction was
    /// identified.
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

    /// One step of `h` s with measured motor positions, m, and tensions, N, in a pose of the independent joints in
    /// which the body was evaluated, and the tensions desired before, N.
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
        let estimates = self.estimates.iter_mut().zip(&self.samples);
        for (residual, (estimate, sample)) in self.residuals.iter_mut().zip(estimates) {
            estimate.tension_out += residual.step(h, sample, estimate)?;
        }
        for (k, (estimate, sample)) in self.estimates.iter().zip(&self.samples).enumerate() {
            self.tension_in[k] = estimate.tension_in;
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

    /// Sets the wrap angles and bends of the pose: of all cables at first, then of one cable per cycle, because poses
    /// change slowly.
    fn update_angles(&mut self, body: &MuscleDynamics, pose: &[f64]) -> Result<(), Error> {
        let n = self.wraps.len();
        let first = self.wraps.iter().any(|wrap| wrap.angle.is_nan());
        for k in if first { 0..n } else { self.next_wrap..self.next_wrap + 1 } {
            let wrap = &mut self.wraps[k];
            let angle = body.wrap_angle(k).clamp(0.0, MAX_WRAP);
            if wrap.angle.is_nan() || (angle - wrap.angle).abs() >= WRAP_RESOLUTION {
                self.observers.set_wrap(k, wrap.pulley, angle)?;
                wrap.angle = angle;
            }
            if let Some(bend) = self.bends.get(k).filter(|bend| !bend.is_constant()) {
                self.observers.set_sheath_bend(k, bend.at(pose))?;
            }
        }
        self.next_wrap = (self.next_wrap + 1) % n;
        Ok(())
    }
}
