use super::{Machine, Task};
use crate::body::JointKind;
use alloc::format;
use alloc::string::{String, ToString};
use alloc::vec::Vec;

/// A point that a camera sees.
#[derive(Debug, Clone, PartialEq)]
pub struct Marker {
    /// Its name in observations.
    pub name: String,
    /// The body that carries it; 0, the world, for one on the base.
    pub body: usize,
    /// Where, in the body's frame, m.
    pub position: [f64; 3],
    /// Standard deviation of every coordinate of its place, m.
    pub position_sd: f64,
}

/// How well a point of a plate on the base is known, m.
pub const BASE_MARKER_SD_M: f64 = 5e-5;
/// The same of a marker on a link, in a hole for it: of one that is put on by hand the end point is
/// known no better
/// than its place.
pub const LINK_MARKER_SD_M: f64 = 3e-4;
/// Names and places of the points of the base in units of a tenth of a metre: three points of a plate
/// 0.3 m wide.
const BASE: [[f64; 3]; 3] = [[1.5, 1.0, 0.0], [-1.5, 1.0, 0.0], [0.0, -1.5, 0.5]];

impl Machine {
    /// Markers where none are described: one at the end point, or at the centre of mass of the last
    /// body, and
    /// three of a plate on the base.
    #[must_use]
    pub fn default_markers(&self) -> Vec<Marker> {
        let parts = self.robot.parts();
        let last = || {
            let moved = |body: usize| parts.joints.iter().any(|joint| joint.body == body);
            let body = (1..parts.bodies.len()).rev().find(|body| moved(*body)).unwrap_or(0);
            (body, parts.bodies[body].center_of_mass)
        };
        let (body, position) = match self.task {
            Task::EndPoint { site, .. } => (parts.sites[site].body, parts.sites[site].position),
            Task::Joints => self
                .payload_site()
                .map_or_else(last, |site| (parts.sites[site].body, parts.sites[site].position)),
        };
        let size = (self.size()).min(1.0);
        let tip = Marker { name: "tip".to_string(), body, position, position_sd: LINK_MARKER_SD_M * size };
        let base = BASE.iter().enumerate().map(|(k, place)| Marker {
            name: format!("base_{}", k + 1),
            body: 0,
            position: place.map(|x| 0.1 * size.max(0.3) * x),
            position_sd: BASE_MARKER_SD_M,
        });
        core::iter::once(tip).chain(base).collect()
    }

    /// Size over that of an arm of 0.5 m: the sum of the distances between the bodies.
    #[must_use]
    pub fn size(&self) -> f64 {
        let length = |x: &[f64; 3]| libm::sqrt(x.iter().map(|x| x * x).sum());
        let parts = self.robot.parts();
        let bodies: f64 = parts.bodies.iter().map(|body| length(&body.position)).sum();
        let tip = self.payload_site().map_or(0.0, |site| length(&parts.sites[site].position));
        let reach = parts.sites.iter().map(|site| length(&site.position)).fold(bodies + tip, f64::max);
        2.0 * reach
    }

    /// Whether a body moves with a joint.
    #[must_use]
    pub fn moves(&self, body: usize) -> bool {
        let parts = self.robot.parts();
        let mut at = body;
        while at != 0 && at < parts.bodies.len() {
            if parts.joints.iter().any(|joint| joint.body == at && joint.kind != JointKind::Free) {
                return true;
            }
            at = parts.bodies[at].parent;
        }
        false
    }
}
