//! The drive's command from the inverse of an identified model.

use super::stretch::FarEndReference;
use crate::compensator::{Compensator, CompensatorError, CompensatorSettings};
use crate::drive::DriveCommand;
use crate::predictor::{CableSample, Model, Role, Sample};
use crate::transmission::Sliding;
use alloc::vec;
use alloc::vec::Vec;

/// A [`Compensator`] in a control cycle: its state follows the measurements, its command is that of the time
/// by which the drive can be there, in the direction of the previewed motion.
///
/// ```text
/// v = v_r + clip((u - p - v_r t_l)/t_l, +- sqrt(2 a |u - p - v_r t_l|))     u: motor's position at t + t_l
/// ```
///
/// | symbol | meaning                                          | unit  |
/// |--------|--------------------------------------------------|-------|
/// | t_l    | 0.018, near the lag of the drive's velocity loop    | s     |
/// | p, v_r | measured position; reference speed of the anchor    | m, m/s |
/// | a      | 4, below the drive's 5                              | m/s^2 |
///
/// A model that is commanded by a tension commands the drive's tension.
#[derive(Debug, Clone)]
pub struct InverseCompensation {
    compensator: Compensator,
    /// Metres toward the motor per unit of the near column, where that is the motor's position.
    motor_scale: Option<f64>,
    anchor_scale: f64,
    /// Newtons per unit of the near tension's column.
    tension_scale: f64,
    row: Vec<f64>,
    time_s: f64,
    lead_s: f64,
    /// Desired tension of the cycle before, N.
    last: Option<f64>,
}

/// `t_l`, s.
const LEAD: f64 = 0.018;
/// Part of the model's longest interval between samples that a lead may take.
const OF_GAP: f64 = 0.9;
/// Speed that no winch has, m/s.
const UNHURRIED: f64 = 100.0;
/// `a`, m/s^2.
const WINCH_DECELERATION: f64 = 4.0;

impl InverseCompensation {
    /// From an identified model. Its efforts are near tensions, N; its motions and its anchor positions in
    /// the units of the model's logs, m without an observer.
    ///
    /// # Errors
    /// As [`Compensator::new`].
    pub fn new(model: Model) -> Result<Self, CompensatorError> {
        let cable = model.estimator.law.cable.as_ref().map(|cable| cable.columns);
        // The approach to the command has its own limit.
        let rate = cable.map(|columns| UNHURRIED / columns.motor_scale.abs());
        let settings = CompensatorSettings { rate, ..CompensatorSettings::default() };
        let (inputs, gap_s) = (model.inputs.len(), model.gap_s);
        Ok(Self {
            compensator: Compensator::new(model, &settings)?,
            motor_scale: cable.map(|columns| columns.motor_scale),
            anchor_scale: cable.map_or(1.0, |columns| columns.anchor_scale),
            tension_scale: cable.map_or(1.0, |columns| columns.tension_scale),
            row: vec![f64::NAN; inputs],
            time_s: 0.0,
            lead_s: LEAD.min(OF_GAP * gap_s),
            last: None,
        })
    }

    /// The compensator.
    #[must_use]
    pub fn compensator(&self) -> &Compensator {
        &self.compensator
    }

    /// One control cycle with a sample `interval` seconds after the one before: the drive's command, and the
    /// far tension that the model predicts, N.
    pub(super) fn step(
        &mut self,
        interval: f64,
        reference: &FarEndReference,
        sample: &CableSample,
    ) -> (DriveCommand, f64) {
        self.time_s += interval;
        self.fill(sample);
        let said = self.compensator.observe(&Sample { time_s: self.time_s, inputs: &self.row });
        let FarEndReference { tension_out, velocity, previewed_velocity } = *reference;
        let rate = self.last.replace(tension_out).map_or(0.0, |last| (tension_out - last) / interval);
        let lead = if self.motor_scale.is_some() { self.lead_s } else { interval };
        self.fill(&CableSample { anchor: sample.anchor + velocity * lead, tension_in: f64::NAN, ..*sample });
        let ahead = Sample { time_s: self.time_s + lead, inputs: &self.row };
        self.compensator.expect_sliding(Sliding::from_velocity(previewed_velocity));
        let value = self.compensator.command(&ahead, tension_out + rate * lead).value;
        let command = match self.motor_scale {
            None => DriveCommand::Tension { tension: self.tension_scale * value, feed: velocity },
            Some(scale) => {
                let ahead = scale * value - sample.motor - velocity * lead;
                let fastest = libm::sqrt(2.0 * WINCH_DECELERATION * ahead.abs());
                let approach = (ahead / lead).max(-fastest).min(fastest);
                DriveCommand::Velocity(velocity + if approach.is_finite() { approach } else { 0.0 })
            }
        };
        (command, said.mean)
    }

    /// Writes a sample in the order and the units of the model's inputs.
    fn fill(&mut self, sample: &CableSample) {
        for (value, input) in self.row.iter_mut().zip(&self.compensator.model().inputs) {
            *value = match input.role {
                Role::Effort => sample.tension_in / self.tension_scale,
                Role::Motion => sample.motor / self.motor_scale.unwrap_or(1.0),
                Role::Anchor => sample.anchor / self.anchor_scale,
                Role::Given => f64::NAN,
            };
        }
    }
}
