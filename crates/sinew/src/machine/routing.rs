use super::design::Machine;
use crate::Error;
use crate::body::{Parts, PathElement, Robot, TendonPath};
use crate::error::{finite, non_negative, positive, within};
use alloc::format;
use serde::Deserialize;

/// Another route of the cable of one muscle, relative to the design.
///
/// ```text
/// h / L = (1 - cos a) / a        an S of two equal arcs a moves the sheath's end sideways by h
/// phi   = phi_0 + 2 a            and adds both arcs to the bend
/// ```
///
/// | symbol | field    | unit | domain          | meaning                                                            |
/// |--------|----------|------|-----------------|--------------------------------------------------------------------|
/// |        | `origin` | m    | finite          | displacement of the sheath's end, in its body's frame               |
/// |        | `anchor` | m    | finite          | displacement of the anchor, in its body's frame                     |
/// |        | `wrap`   | 1    | > 0             | factor on the radii of the surfaces around which the cable wraps     |
/// | L      | `sheath` | m    | > 0, or none    | length of the sheath; none: that of the design                     |
/// | phi_0  | `bend`   | rad  | >= 0, or none   | bend before the end is displaced; none: that of the design           |
///
/// `h` is the part of `origin` across the direction in which the cable leaves the sheath, all of it where the
/// design states no direction; at most 0.63 `L`, where both arcs are quarter turns.
///
/// # Assumes
/// The drive stays where it is, and the sheath keeps its directions at both ends. Its drag grows with its
/// length.
///
/// # Source
/// Elementary geometry; our own.
#[derive(Debug, Clone, Copy, PartialEq, Deserialize)]
#[serde(deny_unknown_fields, default)]
pub struct Routing {
    /// Displacement of the sheath's end, m.
    #[serde(rename = "origin_m")]
    pub origin: [f64; 3],
    /// Displacement of the anchor, m.
    #[serde(rename = "anchor_m")]
    pub anchor: [f64; 3],
    /// Factor on the radii of its surfaces.
    #[serde(rename = "wrap_factor")]
    pub wrap: f64,
    /// Length of the sheath, m.
    #[serde(rename = "sheath_m")]
    pub sheath: Option<f64>,
    /// Bend of the sheath before its end is displaced, rad.
    #[serde(rename = "bend_rad")]
    pub bend: Option<f64>,
}

impl Default for Routing {
    /// The route of the design.
    fn default() -> Self {
        Self { origin: [0.0; 3], anchor: [0.0; 3], wrap: 1.0, sheath: None, bend: None }
    }
}

impl Machine {
    /// The same with the cable of one muscle on another route; sites and surfaces that it shares with others
    /// stay where they are for these. A model of the cable that was identified before no longer holds and is
    /// left out.
    ///
    /// # Errors
    /// [`Error::OutOfDomain`] names a number outside its domain or a muscle that does not exist;
    /// [`Error::Part`] a muscle without a path through space; as [`Robot::new`] for a body that is not valid.
    pub fn rerouted(&self, muscle: usize, routing: &Routing) -> Result<Self, Error> {
        for displacement in routing.origin.iter().chain(&routing.anchor) {
            finite("displacement", *displacement)?;
        }
        positive("wrap_factor", routing.wrap)?;
        let mut machine = self.clone();
        let known = muscle < machine.muscles.len();
        #[expect(clippy::cast_precision_loss, reason = "an index, for a message")]
        within("muscle", "the index of a muscle", muscle as f64, known)?;
        let design = &mut machine.muscles[muscle];
        let mut parts = self.robot.parts().clone();
        let sheath = positive("sheath_m", routing.sheath.unwrap_or(design.sheath))?;
        let bend = non_negative("bend_rad", routing.bend.unwrap_or(design.bend))?;
        let axis = parts.tendons[muscle].sheath.as_ref().and_then(|sheath| sheath.end_axis);
        design.cable.drag *= sheath / design.sheath;
        design.bend = bend + 2.0 * arc(across(routing.origin, axis) / sheath)?;
        design.sheath = sheath;
        design.model = None;
        if let Some(geometry) = &mut parts.tendons[muscle].sheath {
            (geometry.length, geometry.bend) = (design.sheath, design.bend);
        }
        displace(&mut parts, muscle, routing)?;
        machine.robot = Robot::new(parts)?;
        machine.validate()?;
        Ok(machine)
    }
}

/// Length of the part of a displacement across a unit axis, m.
fn across(displacement: [f64; 3], axis: Option<[f64; 3]>) -> f64 {
    let square = |v: [f64; 3]| v.iter().map(|x| x * x).sum::<f64>();
    let along = axis.map_or(0.0, |axis| axis.iter().zip(displacement).map(|(a, x)| a * x).sum::<f64>());
    libm::sqrt((square(displacement) - along * along).max(0.0))
}

/// The arc `a`, rad, of an S of two equal arcs that moves its end sideways by this fraction of its length.
fn arc(fraction: f64) -> Result<f64, Error> {
    const QUARTER: f64 = core::f64::consts::FRAC_PI_2;
    within(
        "displacement of the sheath's end over its length",
        "at most 0.63",
        fraction,
        fraction <= 1.0 / QUARTER,
    )?;
    let (mut low, mut high) = (0.0, QUARTER);
    // 50 halvings leave 2e-15 rad; the fraction grows with the arc all the way.
    for _ in 0..50 {
        let middle = 0.5 * (low + high);
        if 1.0 - libm::cos(middle) < fraction * middle { low = middle } else { high = middle }
    }
    Ok(if fraction > 0.0 { high } else { 0.0 })
}

/// Gives the muscle sites and surfaces of its own where they change.
fn displace(parts: &mut Parts, muscle: usize, routing: &Routing) -> Result<(), Error> {
    let name = parts.tendons[muscle].name.clone();
    let not_spatial =
        Error::Part { kind: "muscle", index: muscle, field: "path", expected: "a path through space" };
    let TendonPath::Spatial(mut path) = parts.tendons[muscle].path.clone() else { return Err(not_spatial) };
    let last = path.len().saturating_sub(1);
    for (element, displacement) in [(0, routing.origin), (last, routing.anchor)] {
        let Some(PathElement::Site(site)) = path.get_mut(element) else { return Err(not_spatial) };
        if displacement.iter().any(|x| x.abs() > 0.0) {
            *site = own_site(parts, *site, &name, |position| {
                position.iter_mut().zip(displacement).for_each(|(x, d)| *x += d);
            });
        }
    }
    let surfaces = path.iter_mut().filter(|_| (routing.wrap - 1.0).abs() > 0.0);
    for element in surfaces {
        let PathElement::Wrap { wrap, side } = element else { continue };
        let mut surface = parts.wraps[*wrap].clone();
        surface.name = format!("{} of {name}", surface.name);
        surface.radius *= routing.wrap;
        // The site that selects the side stays as far outside, in parts of the radius.
        if let Some(side) = side.as_mut().filter(|side| parts.sites[**side].body == surface.body) {
            *side = own_site(parts, *side, &name, |position| {
                let center = surface.position.iter();
                position.iter_mut().zip(center).for_each(|(x, c)| *x = c + routing.wrap * (*x - c));
            });
        }
        *wrap = parts.wraps.len();
        parts.wraps.push(surface);
    }
    parts.tendons[muscle].path = TendonPath::Spatial(path);
    Ok(())
}

/// A copy of a site for one muscle, changed; its index.
fn own_site(parts: &mut Parts, site: usize, muscle: &str, change: impl FnOnce(&mut [f64; 3])) -> usize {
    let mut copy = parts.sites[site].clone();
    copy.name = format!("{} of {muscle}", copy.name);
    change(&mut copy.position);
    parts.sites.push(copy);
    parts.sites.len() - 1
}
