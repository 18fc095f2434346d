//! A robot for unit tests.

use crate::body::{
    Body, Coupling, Joint, JointKind, Parts, PathElement, Robot, Site, Tendon, TendonPath, Wrap, WrapKind,
};
use alloc::string::ToString;
use alloc::vec::Vec;

const UPRIGHT: [f64; 4] = [1.0, 0.0, 0.0, 0.0];

fn body(name: &str, parent: usize, position: [f64; 3], mass: f64) -> Body {
    Body {
        name: name.to_string(),
        parent,
        position,
        orientation: UPRIGHT,
        mass,
        center_of_mass: [0.1, 0.0, 0.0],
        inertia: [1e-3, 2e-3, 2e-3, 0.0, 0.0, 0.0],
        gravity_compensation: 0.0,
    }
}

fn joint(name: &str, body: usize, kind: JointKind, axis: [f64; 3]) -> Joint {
    Joint {
        name: name.to_string(),
        body,
        kind,
        anchor: [0.0; 3],
        axis,
        reference: 0.0,
        range: None,
        armature: 0.0,
        damping: 0.0,
        friction: 0.0,
        stiffness: 0.0,
        spring_reference: 0.0,
        flex: 0.0,
    }
}

fn site(body: usize, position: [f64; 3]) -> Site {
    let [x, y, z] = position;
    Site { name: alloc::format!("s{body} {x} {y} {z}"), body, position, orientation: UPRIGHT, active: None }
}

fn tendon(name: &str, path: TendonPath) -> Tendon {
    Tendon {
        name: name.to_string(),
        path,
        sheath: None,
        range: None,
        damping: 0.0,
        stiffness: 0.0,
        spring_length: None,
    }
}

/// A muscle from the world to the last of a chain of bodies without extent, each on a joint of a kind.
pub(crate) fn linked(kinds: &[JointKind]) -> Robot {
    let bodies = (0..=kinds.len()).map(|k| {
        body(&alloc::format!("b{k}"), k.saturating_sub(1), [0.0; 3], if k == 0 { 0.0 } else { 1.0 })
    });
    let joints = kinds
        .iter()
        .enumerate()
        .map(|(k, kind)| joint(&alloc::format!("j{k}"), k + 1, *kind, [0.0, 0.0, 1.0]));
    let parts = Parts {
        name: "linked".to_string(),
        bodies: bodies.collect(),
        joints: joints.collect(),
        sites: [site(0, [0.0; 3]), site(kinds.len(), [0.0; 3]), site(kinds.len(), [0.2, 0.0, 0.1])].to_vec(),
        tendons: [tendon("m", TendonPath::Spatial([0, 1, 2].map(PathElement::Site).to_vec()))].to_vec(),
        ..Parts::default()
    };
    Robot::new(parts).unwrap()
}

/// A surface on a floating body, a hinge behind it, and muscles from the world over both, their names:
/// `short`, `left`, `right` with a side on either side, `ring` through the surface's inside, `clear` of it, a
/// `tackle` without it, and `fixed`.
pub(crate) fn floating(kind: WrapKind, radius: f64) -> Robot {
    use PathElement::{Pulley, Site, Wrap as Over};
    let spatial = |name: &str, path: &[PathElement]| tendon(name, TendonPath::Spatial(path.to_vec()));
    let over = |side| Over { wrap: 0, side };
    let parts = Parts {
        name: "floating".to_string(),
        bodies: [
            body("world", 0, [0.0; 3], 0.0),
            body("carrier", 0, [0.0; 3], 1.0),
            body("arm", 1, [0.05, 0.0, 0.0], 0.5),
        ]
        .to_vec(),
        joints: [
            joint("free", 1, JointKind::Free, [0.0, 0.0, 1.0]),
            joint("hinge", 2, JointKind::Hinge, [0.6, 0.0, 0.8]),
        ]
        .to_vec(),
        sites: [
            site(0, [-0.3, 0.03, 0.02]),
            site(2, [0.25, 0.02, -0.03]),
            site(1, [0.0, 0.3, 0.0]),
            site(1, [0.0, -0.3, 0.0]),
            site(1, [0.01, -0.02, 0.0]),
            site(0, [-0.3, 0.25, 0.0]),
            site(2, [0.3, 0.25, 0.05]),
            site(1, [0.0, 0.1, 0.1]),
        ]
        .to_vec(),
        wraps: [Wrap {
            name: "surface".to_string(),
            body: 1,
            kind,
            radius,
            position: [0.01, -0.02, 0.0],
            orientation: [0.8, 0.4, 0.2, -0.4],
        }]
        .to_vec(),
        tendons: [
            spatial("short", &[Site(0), over(None), Site(1)]),
            spatial("left", &[Site(0), over(Some(2)), Site(1)]),
            spatial("right", &[Site(0), over(Some(3)), Site(1)]),
            spatial("ring", &[Site(5), over(Some(4)), Site(6)]),
            spatial("clear", &[Site(5), over(None), Site(6)]),
            spatial("tackle", &[Site(0), Site(7), Pulley(2.0), Site(7), Site(1)]),
            tendon("fixed", TendonPath::Fixed([(1, 0.03)].to_vec())),
        ]
        .to_vec(),
        ..Parts::default()
    };
    Robot::new(parts).unwrap()
}

/// One hinge between two muscles, one above and one below it.
pub(crate) fn lever() -> Robot {
    let mut parts = chain(false).parts().clone();
    parts.bodies.truncate(2);
    parts.joints.truncate(1);
    parts.sites.truncate(2);
    for k in 0..2 {
        let mut below = parts.sites[k].clone();
        below.name.push_str(" below");
        below.position[2] = -below.position[2];
        parts.sites.push(below);
    }
    parts.tendons.truncate(2);
    parts.tendons[1].path = TendonPath::Spatial([PathElement::Site(2), PathElement::Site(3)].to_vec());
    Robot::new(parts).unwrap()
}

/// Three hinges in a plane, the last of which may follow the second, with three muscles.
pub(crate) fn chain(coupled: bool) -> Robot {
    let joint = |k: usize| Joint {
        range: Some([-1.0, 1.0]),
        damping: 0.01,
        stiffness: 0.2,
        spring_reference: 0.1,
        flex: 0.0,
        ..joint(["a", "b", "c"][k], k + 1, JointKind::Hinge, [0.0, 1.0, 0.0])
    };
    let site = |body: usize, x: f64, z: f64| site(body, [x, 0.0, z]);
    let sites: Vec<Site> = (0..3).flat_map(|k| [site(k, 0.15, 0.02), site(k + 1, 0.05, 0.03)]).collect();
    let tendon = |k: usize| {
        let path = [PathElement::Site(2 * k), PathElement::Site(2 * k + 1)];
        tendon(["m0", "m1", "m2"][k], TendonPath::Spatial(path.to_vec()))
    };
    let follows = Coupling {
        follower: 2,
        leader: Some(1),
        coefficients: [0.1, 0.7, 0.2, 0.0, 0.0],
        pieces: Vec::new(),
    };
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
