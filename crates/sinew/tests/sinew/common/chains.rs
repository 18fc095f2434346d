//! Random chains of joints.

use sinew::body::{Body, Coupling, Joint, JointKind, Parts, Robot, Site};
use sinew::random::Random;

/// Kind of a chain.
#[derive(Debug, Clone, Copy, PartialEq, Eq)]
pub(crate) enum Chain {
    /// Hinges about random axes.
    Hinges,
    /// The same without limits that matter.
    Free,
    /// Hinges about parallel axes.
    Planar,
    /// Hinges and slides.
    Slides,
    /// Hinges, of which every third one follows another.
    Coupled,
    /// Parallel hinges limited to -1..1 rad, the last one to 0.5..1 rad.
    Elbow,
}

/// A chain along z with the site `endpoint` at its end.
pub(crate) fn chain(random: &mut Random, joints: usize, kind: Chain) -> Robot {
    let upright = [1.0, 0.0, 0.0, 0.0];
    let length = 0.04 * 8.0_f64.powf(random.unit());
    let mut parts = Parts { name: "chain".into(), ..Parts::default() };
    let body = |name: String, parent, z: f64| Body {
        name,
        parent,
        position: [0.0, 0.0, z],
        orientation: upright,
        mass: 0.1,
        center_of_mass: [0.0; 3],
        inertia: [1e-4, 1e-4, 1e-4, 0.0, 0.0, 0.0],
        gravity_compensation: 0.0,
    };
    parts.bodies.push(Body { mass: 0.0, inertia: [0.0; 6], ..body("world".into(), 0, 0.0) });
    for k in 0..joints {
        let z = if k == 0 { 0.1 } else { length * (0.5 + random.unit()) };
        parts.bodies.push(body(format!("link_{k}"), k, z));
        parts.joints.push(joint(random, k, kind, length));
    }
    if kind == Chain::Elbow {
        parts.joints[joints - 1].range = Some([0.5, 1.0]);
    }
    if kind == Chain::Coupled {
        for follower in (2..joints).step_by(3) {
            let coefficients = [0.1 * random.unit(), 0.4 + random.unit(), 0.3 * random.unit(), 0.0, 0.0];
            parts.couplings.push(Coupling {
                follower,
                leader: Some(follower - 1),
                coefficients,
                pieces: Vec::new(),
            });
        }
    }
    let position = [0.0, 0.0, length * (0.5 + random.unit())];
    parts.sites.push(Site {
        name: "endpoint".into(),
        body: joints,
        position,
        orientation: upright,
        active: None,
    });
    Robot::new(parts).unwrap()
}

fn joint(random: &mut Random, index: usize, kind: Chain, length: f64) -> Joint {
    let slide = kind == Chain::Slides && random.unit() < 0.4;
    let planar = matches!(kind, Chain::Planar | Chain::Elbow);
    let raw: [f64; 3] = if planar { [0.0, 1.0, 0.0] } else { std::array::from_fn(|_| random.normal()) };
    let norm = raw.iter().map(|x| x * x).sum::<f64>().sqrt();
    let (middle, half) = (random.unit() - 0.5, 0.2 + 1.3 * random.unit());
    let scale = if slide { length } else { 1.0 };
    let range = match kind {
        Chain::Free => [-6.0, 6.0],
        Chain::Elbow => [-1.0, 1.0],
        // Leader and follower are within their ranges near 0.
        Chain::Coupled => [-half, half],
        _ => [scale * (middle - half), scale * (middle + half)],
    };
    Joint {
        name: format!("joint_{index}"),
        body: index + 1,
        kind: if slide { JointKind::Slide } else { JointKind::Hinge },
        anchor: [0.0; 3],
        axis: raw.map(|x| x / norm),
        reference: 0.0,
        range: Some(range),
        armature: 0.0,
        damping: 0.0,
        friction: 0.0,
        stiffness: 0.0,
        spring_reference: 0.0,
        flex: 0.0,
    }
}

/// A random pose within ranges.
pub(crate) fn pose_within(random: &mut Random, ranges: &[[f64; 2]]) -> Vec<f64> {
    ranges.iter().map(|[low, high]| low + (high - low) * random.unit()).collect()
}
