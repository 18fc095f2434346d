//! Equivalent routes of muscles: places of sites and radii of surfaces with which lengths agree with what the
//! winches have taken up.

use super::GeometryError;
use super::prior_fit::{Row, fit};
use super::rests::Rest;
use sinew::body::{Parts, PathElement, Robot, TendonPath};
use sinew::machine::Machine;
use sinew::muscle::MuscleDynamics;

/// What of a route may differ from the design.
#[derive(Debug, Clone, Copy, PartialEq, Eq)]
pub enum RoutePart {
    /// A coordinate of a site.
    Site(usize, usize),
    /// The radius of a surface.
    Radius(usize),
}

/// Routes as found, with what cables do beside.
#[derive(Debug, Clone, PartialEq)]
pub struct RouteEstimate {
    /// Of every part of a route, m.
    pub value: Vec<f64>,
    /// Its standard deviation after, m.
    pub sd: Vec<f64>,
    /// Of every muscle: length where its winch stands at 0, m; stretch by the tension at either end, m/N; how
    /// much larger its winch is, 1.
    cable: Vec<[f64; 4]>,
}

/// Lengths of all muscles by their routes and by their winches.
///
/// ```text
/// -p = l(q; sites, radii) (1 + w) + c - a T_in - b T_out
/// ```
///
/// # Assumes
/// Cables at rest; readings of the joints as coordinates: what zeros and frames of joints do to lengths is
/// taken by the routes, which are equivalent, not true.
#[derive(Debug, Clone)]
pub struct RouteModel {
    parts: Parts,
    muscles: usize,
    route: Vec<RoutePart>,
    /// m.
    tolerance: Vec<f64>,
    winch: f64,
}

/// Nothing is known of the length at 0, m; of the stretch, m/N, no more than that it is small.
const ANY_LENGTH: f64 = 10.0;
const STRETCH: f64 = 1e-3;
/// For the derivatives, m.
const STEP: f64 = 1e-5;
/// Least scatter of a length over the tolerance.
const FLOOR: f64 = 0.01;
/// The scatter that is expected first, over the tolerance.
const FIRST: f64 = 0.3;
const OWN: usize = 4;

impl RouteModel {
    /// Of a machine as designed, with its tolerances.
    #[must_use]
    pub fn new(machine: &Machine) -> Self {
        let parts = machine.robot.parts().clone();
        let bound = |x: f64| x / 3.0_f64.sqrt();
        let (mut route, mut tolerance) = (Vec::new(), Vec::new());
        let elements = parts.tendons.iter().flat_map(|tendon| match &tendon.path {
            TendonPath::Spatial(elements) => elements.as_slice(),
            TendonPath::Fixed(_) => &[],
        });
        // A frame that is off moves the sites behind it.
        let place = bound(machine.attachment_tolerance().hypot(machine.tolerances.link));
        for element in elements {
            let found = match element {
                PathElement::Site(site) => (0..3).map(|k| (RoutePart::Site(*site, k), place)).collect(),
                PathElement::Wrap { wrap, .. } => {
                    vec![(RoutePart::Radius(*wrap), bound(machine.tolerances.wrap_radius))]
                }
                PathElement::Pulley(_) => Vec::new(),
            };
            for (part, bound) in found {
                if bound > 0.0 && !route.contains(&part) {
                    route.push(part);
                    tolerance.push(bound);
                }
            }
        }
        let muscles = machine.muscles.len();
        Self { parts, muscles, route, tolerance, winch: bound(machine.tolerances.winch) }
    }

    /// What may differ.
    #[must_use]
    pub fn route(&self) -> &[RoutePart] {
        &self.route
    }

    /// Standard deviations of these before, m.
    #[must_use]
    pub fn tolerance(&self) -> &[f64] {
        &self.tolerance
    }

    /// The robot with these routes.
    #[must_use]
    pub fn with(&self, value: &[f64]) -> Parts {
        let mut parts = self.parts.clone();
        for (part, value) in self.route.iter().zip(value) {
            match *part {
                RoutePart::Site(site, k) => parts.sites[site].position[k] += value,
                RoutePart::Radius(wrap) => {
                    let radius = &mut parts.wraps[wrap].radius;
                    *radius = (*radius + value).max(0.5 * *radius);
                }
            }
        }
        parts
    }

    /// Whether a part belongs to a muscle's route.
    #[must_use]
    pub fn is_of(&self, part: usize, muscle: usize) -> bool {
        let Some(TendonPath::Spatial(elements)) = self.parts.tendons.get(muscle).map(|t| &t.path) else {
            return false;
        };
        elements.iter().any(|element| match (element, self.route[part]) {
            (PathElement::Site(site), RoutePart::Site(of, _)) => *site == of,
            (PathElement::Wrap { wrap, .. }, RoutePart::Radius(of)) => *wrap == of,
            _ => false,
        })
    }

    /// Lengths at places, m: `[rests][muscles]`.
    fn lengths(&self, value: &[f64], rests: &[Rest]) -> Result<Vec<Vec<f64>>, GeometryError> {
        let robot = Robot::new(self.with(value)).map_err(sinew::Error::from)?;
        let mut model = MuscleDynamics::new(&robot)?;
        let mut at = |rest: &Rest| {
            model.evaluate(&rest.joint)?;
            Ok(model.lengths().to_vec())
        };
        rests.iter().map(&mut at).collect()
    }

    /// The most probable routes; a part that is not `free` stays as designed.
    ///
    /// # Errors
    /// [`GeometryError::Physics`] for routes that are none; [`GeometryError::Observations`] where readings
    /// determine nothing.
    pub fn estimate(&self, rests: &[Rest], free: &[bool]) -> Result<RouteEstimate, GeometryError> {
        let n = self.route.len();
        let free = self.tolerance.iter().zip(free);
        let mut prior: Vec<f64> = free.map(|(bound, free)| if *free { *bound } else { 0.0 }).collect();
        for _ in 0..self.muscles {
            prior.extend([ANY_LENGTH, STRETCH, STRETCH, self.winch]);
        }
        let largest = self.tolerance.iter().fold(1e-4, |a: f64, b| a.max(*b));
        let rows = |x: &[f64]| self.rows(&prior, x, rests);
        let found = fit(&prior, (vec![FIRST * largest; self.muscles], FLOOR * largest), rows)?;
        let cable = found.x[n..].as_chunks::<OWN>().0.to_vec();
        Ok(RouteEstimate { value: found.x[..n].to_vec(), sd: found.sd[..n].to_vec(), cable })
    }

    fn rows(&self, prior: &[f64], x: &[f64], rests: &[Rest]) -> Result<Vec<Row>, GeometryError> {
        let n = self.route.len();
        let at = self.lengths(&x[..n], rests)?;
        let mut slopes = vec![Vec::new(); rests.len() * self.muscles];
        for part in (0..n).filter(|part| prior[*part] > 0.0) {
            let mut moved = x[..n].to_vec();
            moved[part] += STEP;
            let beside = self.lengths(&moved, rests)?;
            for muscle in (0..self.muscles).filter(|muscle| self.is_of(part, *muscle)) {
                for (k, (a, b)) in at.iter().zip(&beside).enumerate() {
                    slopes[k * self.muscles + muscle].push((part, (b[muscle] - a[muscle]) / STEP));
                }
            }
        }
        let cable = x[n..].as_chunks::<OWN>().0;
        let mut rows = Vec::new();
        for (place, mut slopes) in slopes.into_iter().enumerate() {
            let (rest, muscle) = (&rests[place / self.muscles], place % self.muscles);
            let length = at[place / self.muscles][muscle];
            let own = [1.0, -rest.tension_in[muscle], -rest.tension_out[muscle], length];
            slopes.extend(own.into_iter().enumerate().map(|(k, slope)| (n + OWN * muscle + k, slope)));
            rows.push(Row {
                channel: muscle,
                residual: missed(rest, muscle, length, &cable[muscle]),
                slopes,
            });
        }
        Ok(rows)
    }

    /// What routes and cables miss of the positions of the winches, m: `[rests][muscles]`.
    ///
    /// # Errors
    /// As [`estimate`](Self::estimate).
    pub fn errors(&self, found: &RouteEstimate, rests: &[Rest]) -> Result<Vec<Vec<f64>>, GeometryError> {
        let lengths = self.lengths(&found.value, rests)?;
        let of = |(rest, lengths): (&Rest, Vec<f64>)| {
            let cables = found.cable.iter().zip(lengths).enumerate();
            cables.map(|(muscle, (cable, length))| missed(rest, muscle, length, cable)).collect()
        };
        Ok(rests.iter().zip(lengths).map(of).collect())
    }
}

fn missed(rest: &Rest, muscle: usize, length: f64, [zero, near, far, winch]: &[f64; OWN]) -> f64 {
    let stretch = near * rest.tension_in[muscle] + far * rest.tension_out[muscle];
    -rest.position[muscle] - (length * (1.0 + winch) + zero - stretch)
}
