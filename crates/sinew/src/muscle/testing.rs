//! A robot for unit tests.

use crate::body::{Body, Coupling, Joint, JointKind, Parts, PathElement, Robot, Site, Tendon, TendonPath};
use alloc::string::ToString;
use alloc::vec::Vec;

/// Three hinges in a plane, the last of which may follow the second, with three muscles.
pub(crate) fn chain(coupled: bool) -> Robot {
    let up = [1.0, 0.0, 0.0, 0.0];
    let body = |name: &str, parent: usize, position: [f64; 3], mass: f64| Body {
        name: name.to_string(),
        parent,
        position,
        orientation: up,
        mass,
        center_of_mass: [0.1, 0.0, 0.0],
        inertia: [1e-3, 2e-3, 2e-3, 0.0, 0.0, 0.0],
    };
    let joint = |k: usize| Joint {
        name: ["a", "b", "c"][k].to_string(),
        body: k + 1,
        kind: JointKind::Hinge,
        anchor: [0.0; 3],
        axis: [0.0, 1.0, 0.0],
        reference: 0.0,
        range: Some([-1.0, 1.0]),
        armature: 0.0,
        damping: 0.01,
        friction: 0.0,
        stiffness: 0.2,
        spring_reference: 0.1,
    };
    let site = |body: usize, x: f64, z: f64| Site {
        name: alloc::format!("s{body}{x}{z}"),
        body,
        position: [x, 0.0, z],
        orientation: up,
    };
    let sites: Vec<Site> = (0..3).flat_map(|k| [site(k, 0.15, 0.02), site(k + 1, 0.05, 0.03)]).collect();
    let tendon = |k: usize| Tendon {
        name: ["m0", "m1", "m2"][k].to_string(),
        path: TendonPath::Spatial([PathElement::Site(2 * k), PathElement::Site(2 * k + 1)].to_vec()),
        sheath: None,
        range: None,
        damping: 0.0,
        stiffness: 0.0,
        spring_length: None,
    };
    let follows = Coupling { follower: 2, leader: Some(1), coefficients: [0.1, 0.7, 0.2, 0.0, 0.0] };
    let parts = Parts {
        name: "chain".to_string(),
        gravity: [0.0, 0.0, -9.81],
        bodies: [
            body("world", 0, [0.0; 3], 0.0),
            body("b1", 0, [0.0; 3], 1.0),
            body("b2", 1, [0.2, 0.0, 0.0], 0.5),
            body("b3", 2, [0.2, 0.0, 0.0], 0.3),
        ]
        .to_vec(),
        joints: (0..3).map(joint).collect(),
        sites,
        tendons: (0..3).map(tendon).collect(),
        couplings: if coupled { [follows].to_vec() } else { Vec::new() },
        ..Parts::default()
    };
    Robot::new(parts).unwrap()
}
