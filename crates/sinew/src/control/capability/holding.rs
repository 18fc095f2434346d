use super::limits::CableMotion;
use super::load::Binding;
use super::model::CapabilityModel;
use crate::error::Error;
use alloc::vec::Vec;

/// Which limit of a muscle's tension determines a payload.
#[derive(Debug, Clone, Copy, PartialEq, Eq, PartialOrd, Ord)]
pub enum TensionLimit {
    /// Heat of the motor within the time.
    Heat,
    /// Current or voltage of the amplifier.
    Amplifier,
    /// Tension above which the drive does not wind in.
    Drive,
    /// Largest tension that the machine's description allows at the anchor.
    Prescribed,
    /// Minimum tension of a muscle that acts against the load.
    Least,
}

/// A largest payload.
#[derive(Debug, Clone, Copy, PartialEq)]
pub struct HeldPayload {
    /// kg; infinite where its weight needs no torque.
    pub mass: f64,
    /// The muscle whose limit, changed by one per cent, changes it most, and which limit that is; none where
    /// no muscle limits it.
    pub limited_by: Option<(usize, TensionLimit)>,
}

impl TensionLimit {
    /// For tables and sentences.
    #[must_use]
    pub fn name(self) -> &'static str {
        match self {
            Self::Heat => "heat of its motor",
            Self::Amplifier => "current of its amplifier",
            Self::Drive => "tension that its drive may give",
            Self::Prescribed => "prescribed tension",
            Self::Least => "its minimum tension",
        }
    }
}

impl CapabilityModel {
    /// The same with drives that hold their tension for a time from room temperature on, s; infinite for
    /// ever.
    ///
    /// A motion of a plan may use a fraction of this heat alone
    /// ([`ControlRules::margin`](crate::machine::ControlRules::margin)).
    #[must_use]
    pub fn holding_for(mut self, seconds: f64) -> Self {
        for k in 0..self.max_tension.len() {
            let drive = &self.machine.muscles[k].drive;
            // Machines often have equal drives.
            self.max_tension[k] = match k.checked_sub(1) {
                Some(last) if self.machine.muscles[last].drive == *drive => self.max_tension[last],
                _ => drive.holding_tension(seconds),
            };
        }
        self
    }

    /// Largest mass at the end point that is held in each pose, whichever way the cables slid before: none
    /// where the muscles do not hold the machine itself; empty without gravity and without an end point
    /// ([`Machine::payload_site`](crate::machine::Machine::payload_site)).
    ///
    /// # Shapes
    /// `poses: [places][joints]`; the result is `[places]`.
    ///
    /// # Errors
    /// As [`evaluate`](Self::evaluate) and [`largest_load`](Self::largest_load).
    pub fn held_payloads(&mut self, poses: &[Vec<f64>]) -> Result<Vec<Option<HeldPayload>>, Error> {
        let mut held = Vec::new();
        for pose in poses {
            self.evaluate(pose)?;
            let Some(weight) = self.weight()? else { return Ok(Vec::new()) };
            let found = self.largest_load(CableMotion::Either, &weight)?;
            let limits = self.tension_limits(CableMotion::Either).unwrap_or_default();
            // What a change of the limit by one per cent, not by one newton, would change.
            let effect = |one: &Binding| {
                one.gain * limits.get(one.muscle).map_or(0.0, |ends| ends[usize::from(one.largest)])
            };
            held.push(found.map(|found| {
                let most = found.binding.iter().rev().max_by(|a, b| effect(a).total_cmp(&effect(b)));
                HeldPayload {
                    mass: found.factor,
                    limited_by: most.map(|one| (one.muscle, self.limit_of(one))),
                }
            }));
        }
        Ok(held)
    }

    fn limit_of(&self, binding: &Binding) -> TensionLimit {
        let (design, most) = (&self.machine.muscles[binding.muscle], self.max_tension[binding.muscle]);
        let at_anchor = most * libm::exp(-self.friction_angle(binding.muscle)) + design.cable.pretension;
        if !binding.largest {
            TensionLimit::Least
        } else if design.tension[1].is_some_and(|limit| limit < at_anchor) {
            TensionLimit::Prescribed
        } else if most < design.drive.working_tension() {
            TensionLimit::Heat
        } else if most < design.drive.allowed_tension() {
            TensionLimit::Amplifier
        } else {
            TensionLimit::Drive
        }
    }
}
