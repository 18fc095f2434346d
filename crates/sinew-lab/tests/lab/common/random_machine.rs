//! Random machines: chains of hinges with random sizes, masses, muscles, wrapping surfaces and sheaths.

use sinew::body::{
    Body, Joint, JointKind, Parts, PathElement, Robot, SheathGeometry, Site, Tendon, TendonPath, Wrap,
    WrapKind,
};
use sinew::machine::Machine;
use sinew::random::Random;

const UPRIGHT: [f64; 4] = [1.0, 0.0, 0.0, 0.0];

/// Numbers of a seed.
pub(crate) struct Draw(pub(crate) Random);

impl Draw {
    pub(crate) fn between(&mut self, low: f64, high: f64) -> f64 {
        low + (high - low) * self.0.unit()
    }

    pub(crate) fn log_between(&mut self, low: f64, high: f64) -> f64 {
        self.between(low.ln(), high.ln()).exp()
    }

    pub(crate) fn below(&mut self, n: usize) -> usize {
        (self.0.unit() * n as f64) as usize % n
    }

    pub(crate) fn chance(&mut self, p: f64) -> bool {
        self.0.unit() < p
    }
}

/// A machine that a seed draws.
pub(crate) struct RandomMachine {
    pub(crate) machine: Machine,
    /// Length of the first link, m.
    pub(crate) first_link: f64,
}

/// One to eight joints, one more muscle than joints to twice as many and three, from a finger to an arm;
/// every mass is multiplied by `lighter`.
pub(crate) fn machine(seed: u64, lighter: f64) -> Result<RandomMachine, sinew::Error> {
    let mut draw = Draw(Random::new(0x6d61_6368 ^ seed.wrapping_mul(0x9e37_79b9_7f4a_7c15)));
    let joints = 1 + draw.below(8);
    let first_link = draw.log_between(0.035, 0.33);
    let mut links = vec![first_link];
    for _ in 1..joints {
        let next = links[links.len() - 1] * draw.between(0.75, 0.95);
        links.push(next);
    }
    let arm = draw.between(0.09, 0.16);
    let density = draw.log_between(0.5, 2.0);
    let mut parts = Parts { name: format!("random_{seed}"), gravity: [0.0, 0.0, -9.81], ..Parts::default() };
    parts.bodies.push(body("world", 0, [0.0; 3], 0.0, 0.0));
    for (k, length) in links.iter().enumerate() {
        let at = if k == 0 { 0.0 } else { links[k - 1] };
        let mass = lighter * 0.02 * density * (length / 0.04_f64).powf(2.05);
        parts.bodies.push(body(&format!("link{k}"), k, [at, 0.0, 0.0], mass, *length));
        let across = draw.below(2);
        let center = draw.between(-0.3, 0.3);
        let half = draw.between(0.5, 1.0);
        let mut axis = [0.0; 3];
        axis[1 + across] = 1.0;
        parts.joints.push(Joint {
            name: format!("joint{k}"),
            body: k + 1,
            kind: JointKind::Hinge,
            anchor: [0.0; 3],
            axis,
            reference: 0.0,
            range: Some([center - half, center + half]),
            armature: 0.0,
            damping: 0.02 * mass * length * length,
            friction: 0.0,
            stiffness: 0.0,
            spring_reference: 0.0,
            flex: 0.0,
        });
    }
    add_muscles(&mut draw, &mut parts, &links, arm);
    Ok(RandomMachine { machine: Machine::from_robot(&Robot::new(parts)?)?, first_link })
}

fn body(name: &str, parent: usize, position: [f64; 3], mass: f64, length: f64) -> Body {
    let across = mass * (length * length / 12.0 + (0.15 * length) * (0.15 * length) / 4.0);
    let along = mass * (0.15 * length) * (0.15 * length) / 2.0;
    Body {
        name: name.to_owned(),
        parent,
        position,
        orientation: UPRIGHT,
        mass,
        center_of_mass: [0.5 * length, 0.0, 0.0],
        inertia: [along, across, across, 0.0, 0.0, 0.0],
        gravity_compensation: 0.0,
    }
}

/// Groups of one or two neighbouring joints with one muscle more than joints, and up to three more muscles.
fn add_muscles(draw: &mut Draw, parts: &mut Parts, links: &[f64], arm: f64) {
    let joints = links.len();
    let mut first = 0;
    while first < joints {
        if first + 1 < joints && draw.chance(0.4) {
            add_muscle(draw, parts, links, arm, &[(first, 1.0)]);
            add_muscle(draw, parts, links, arm, &[(first + 1, 1.0)]);
            add_muscle(draw, parts, links, arm, &[(first, -1.0), (first + 1, -1.0)]);
            first += 2;
        } else {
            add_muscle(draw, parts, links, arm, &[(first, 1.0)]);
            add_muscle(draw, parts, links, arm, &[(first, -1.0)]);
            first += 1;
        }
    }
    for _ in 0..draw.below(4) {
        let joint = draw.below(joints);
        let sign = |draw: &mut Draw| if draw.chance(0.5) { 1.0 } else { -1.0 };
        let (s, t) = (sign(draw), sign(draw));
        if joint + 1 < joints && draw.chance(0.5) {
            add_muscle(draw, parts, links, arm, &[(joint, s), (joint + 1, t)]);
        } else {
            add_muscle(draw, parts, links, arm, &[(joint, s)]);
        }
    }
}

/// A muscle over one joint or two neighbouring ones, on a side of each.
fn add_muscle(draw: &mut Draw, parts: &mut Parts, links: &[f64], arm: f64, over: &[(usize, f64)]) {
    let index = parts.tendons.len();
    let wrapped = draw.chance(0.5);
    let mut path = Vec::new();
    for (n, &(joint, side)) in over.iter().enumerate() {
        let radius = arm * links[0] * draw.between(0.9, 1.1);
        let axis = parts.joints[joint].axis;
        // A positive rotation about y moves x toward -z, about z toward y: the site on this side shortens.
        let offset = |r: f64| if axis[1] > 0.5 { [0.0, 0.0, -side * r] } else { [0.0, side * r, 0.0] };
        // Sites near the joint keep the moment arm: one that grows as the muscle pulls is a negative
        // stiffness.
        let along = if wrapped { 1.5 * radius } else { 0.7 * radius };
        let parent_x = if joint == 0 { -along } else { links[joint - 1] - along };
        let before = offset(if wrapped { 0.5 * radius } else { radius });
        let mut site = |name: String, body: usize, position: [f64; 3]| {
            parts.sites.push(Site { name, body, position, orientation: UPRIGHT, active: None });
            parts.sites.len() - 1
        };
        let from = site(format!("m{index}_{n}_a"), joint, [parent_x, before[1], before[2]]);
        let to = site(format!("m{index}_{n}_b"), joint + 1, [along, before[1], before[2]]);
        let out = offset(3.0 * radius);
        let joint_x = if joint == 0 { 0.0 } else { links[joint - 1] };
        let outside = site(format!("m{index}_{n}_s"), joint, [joint_x, out[1], out[2]]);
        path.push(PathElement::Site(from));
        if wrapped {
            // The cylinder's axis is its z.
            let half = core::f64::consts::FRAC_1_SQRT_2;
            let orientation = if axis[1] > 0.5 { [half, half, 0.0, 0.0] } else { UPRIGHT };
            parts.wraps.push(Wrap {
                name: format!("w{index}_{n}"),
                body: joint,
                kind: WrapKind::Cylinder,
                radius,
                position: [joint_x, 0.0, 0.0],
                orientation,
            });
            path.push(PathElement::Wrap { wrap: parts.wraps.len() - 1, side: Some(outside) });
        }
        path.push(PathElement::Site(to));
    }
    parts.tendons.push(Tendon {
        name: format!("muscle{index}"),
        path: TendonPath::Spatial(path),
        sheath: Some(SheathGeometry {
            length: draw.between(0.2, 1.3),
            bend: draw.between(0.5, 7.0),
            end_axis: None,
        }),
        range: None,
        damping: 0.0,
        stiffness: 0.0,
        spring_length: None,
    });
}
