//! What makes real machines differ from their drawings beside masses, attachments and zeros: frames of
//! joints,
//! centres of mass, radii, eccentric encoders, links that bend, an unknown payload.

use crate::body::{Displacement, JointKind, Parts, Robot};
use crate::drive::{DriveParameters, JointEncoder};
use crate::machine::{Machine, Tolerances};
use crate::random::Random;
use alloc::vec::Vec;

/// Deviations of one specimen. Every kind has a random stream of its own, so that one does not change the
/// others, nor what is drawn elsewhere.
pub(super) struct Deviation {
    tolerances: Tolerances,
    seed: u64,
}

/// Of a gear as built, 1.
const LEAST_EFFICIENCY: f64 = 0.05;

/// Numbers of the streams.
#[derive(Clone, Copy)]
enum Kind {
    Link = 1,
    Axis,
    CenterOfMass,
    Wrap,
    Winch,
    Eccentricity,
    Flex,
    Payload,
    Gear,
}

impl Deviation {
    pub(super) fn new(tolerances: Tolerances, seed: u64) -> Self {
        Self { tolerances, seed }
    }

    /// Uniform numbers in [-bound, bound).
    fn within(&self, kind: Kind, bound: f64) -> impl FnMut() -> f64 + use<> {
        let mut random = Random::new(self.seed ^ (kind as u64).wrapping_mul(0xD1B5_4A32_D192_ED03));
        move || bound * (2.0 * random.unit() - 1.0)
    }

    /// Frames of joints, centres of mass, radii of wraps, flex of links.
    pub(super) fn of_parts(&self, parts: &mut Parts) {
        let Tolerances { link, axis, center_of_mass, wrap_radius, flex, .. } = self.tolerances;
        if link > 0.0 || axis > 0.0 {
            let (mut offset, mut tilt) = (self.within(Kind::Link, link), self.within(Kind::Axis, axis));
            let mut draw = || Displacement {
                offset: core::array::from_fn(|_| offset()),
                tilt: core::array::from_fn(|_| tilt()),
            };
            let drawn: Vec<Displacement> = parts.joints.iter().map(|_| draw()).collect();
            *parts = parts.displaced(&drawn);
        }
        if center_of_mass > 0.0 {
            let mut shift = self.within(Kind::CenterOfMass, center_of_mass);
            let bodies = parts.bodies.iter_mut().filter(|body| body.mass > 0.0);
            bodies.for_each(|body| body.center_of_mass.iter_mut().for_each(|x| *x += shift()));
        }
        if wrap_radius > 0.0 {
            let mut more = self.within(Kind::Wrap, wrap_radius);
            parts.wraps.iter_mut().for_each(|wrap| {
                wrap.radius = (wrap.radius + more()).max(0.5 * wrap.radius);
            });
        }
        if flex > 0.0 {
            let mut part = self.within(Kind::Flex, 0.5);
            let hinges = parts.joints.iter_mut().filter(|joint| joint.kind == JointKind::Hinge);
            hinges.for_each(|joint| joint.flex += flex * (0.5 + part()));
        }
    }

    /// Eccentric discs of the encoders of hinges; `kinds` are those of the independent joints.
    pub(super) fn of_encoders(
        &self,
        encoders: &mut [Option<JointEncoder>],
        kinds: impl Iterator<Item = JointKind>,
    ) {
        if self.tolerances.eccentricity == 0.0 {
            return;
        }
        let mut part = self.within(Kind::Eccentricity, 1.0);
        for (encoder, kind) in encoders.iter_mut().zip(kinds) {
            let amplitude = 0.5 * (1.0 + part()) * self.tolerances.eccentricity;
            let (sine, cosine) = libm::sincos(core::f64::consts::PI * part());
            if let (Some(encoder), JointKind::Hinge) = (encoder, kind) {
                encoder.eccentricity = [amplitude * cosine, amplitude * sine];
            }
        }
    }

    /// Radius over that of the design of every winch.
    pub(super) fn of_winches(&self, winches: &mut [f64]) {
        if self.tolerances.winch > 0.0 {
            let mut more = self.within(Kind::Winch, self.tolerances.winch);
            winches.iter_mut().for_each(|ratio| *ratio *= 1.0 + more());
        }
    }

    /// Losses of the gears of muscles without a load cell: friction, and what the efficiency lacks of 1.
    pub(super) fn of_gears(&self, drives: &mut [DriveParameters]) {
        let mut more = self.within(Kind::Gear, self.tolerances.gear_losses);
        for drive in drives {
            let factor = 1.0 + more();
            if !drive.has_load_cell {
                let reducer = &mut drive.reducer;
                reducer.friction *= factor;
                reducer.efficiency = (1.0 - factor * (1.0 - reducer.efficiency)).max(LEAST_EFFICIENCY);
            }
        }
    }

    /// With the unknown mass at the end point.
    pub(super) fn loaded(&self, robot: Robot, machine: &Machine) -> Result<Robot, crate::Error> {
        let Some(site) = machine.payload_site().filter(|_| self.tolerances.payload > 0.0) else {
            return Ok(robot);
        };
        let mass = self.tolerances.payload * (0.5 + self.within(Kind::Payload, 0.5)());
        let site = &robot.parts().sites[site];
        robot.with_payload(site.body, site.position, mass)
    }
}
