//! A robot for unit tests whose torques and forces can be written down.

use crate::body::{Body, Joint, JointKind, Parts, Robot, Site, Tendon, TendonPath};
use alloc::string::ToString;

/// Direction of a slide in the world, the mass on it, kg, and its range, m.
pub(super) struct Slide {
    pub(super) axis: [f64; 3],
    pub(super) mass: f64,
    pub(super) range: [f64; 2],
}

/// Slides, each on the one before, the site `endpoint` on the last, and cables of constant moment arms:
/// `[muscles][joints]`.
pub(super) fn slides(gravity: f64, slides: &[Slide], arms: &[&[f64]]) -> Robot {
    let orientation = [1.0, 0.0, 0.0, 0.0];
    let body = |(k, mass): (usize, f64)| Body {
        name: alloc::format!("body{k}"),
        parent: k.saturating_sub(1),
        position: [0.0; 3],
        orientation,
        mass,
        center_of_mass: [0.0; 3],
        inertia: [1e-3, 1e-3, 1e-3, 0.0, 0.0, 0.0],
        gravity_compensation: 0.0,
    };
    let joint = |(k, slide): (usize, &Slide)| Joint {
        name: alloc::format!("slide{k}"),
        body: k + 1,
        kind: JointKind::Slide,
        anchor: [0.0; 3],
        axis: slide.axis,
        reference: 0.0,
        range: Some(slide.range),
        armature: 0.0,
        damping: 0.0,
        friction: 0.0,
        stiffness: 0.0,
        spring_reference: 0.0,
        flex: 0.0,
    };
    let tendon = |(k, arms): (usize, &&[f64])| Tendon {
        name: alloc::format!("cable{k}"),
        // A cable shortens where it pulls along the joint.
        path: TendonPath::Fixed(arms.iter().map(|arm| -arm).enumerate().collect()),
        sheath: None,
        range: None,
        damping: 0.0,
        stiffness: 0.0,
        spring_length: None,
    };
    let masses = core::iter::once(0.0).chain(slides.iter().map(|slide| slide.mass));
    let site = Site {
        name: "endpoint".to_string(),
        body: slides.len(),
        position: [0.0; 3],
        orientation,
        active: None,
    };
    let parts = Parts {
        name: "slides".to_string(),
        gravity: [0.0, 0.0, -gravity],
        bodies: masses.enumerate().map(body).collect(),
        joints: slides.iter().enumerate().map(joint).collect(),
        sites: [site].to_vec(),
        tendons: arms.iter().enumerate().map(tendon).collect(),
        ..Parts::default()
    };
    Robot::new(parts).unwrap()
}
