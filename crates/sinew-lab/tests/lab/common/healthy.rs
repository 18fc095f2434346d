//! Machines without a fault by seed: random chains, hands and those of `models/`, with encoders of any
//! resolution or none, and motions from fast tours to creeping and long holds.

use super::machines::machine;
use super::random_machine::{self, Draw};
use core::fmt::Write as _;
use sinew::description::machine_from_toml;
use sinew::drive::JointEncoder;
use sinew::machine::Machine;
use sinew::random::Random;
use sinew::trajectory::{JointWaypoint, Trajectory};
use sinew_lab::Error;
use sinew_lab::arm::{DesiredMotion, first_infeasibility, plan, plan_tour};

/// What a seed draws.
pub(crate) struct Sampled {
    pub(crate) machine: Machine,
    /// In words: body, encoders, motion.
    pub(crate) what: String,
    pub(crate) trajectory: Trajectory,
    /// Rest after the motion, s.
    pub(crate) hold: f64,
}

/// Machines of `models/` that small changes are made to.
const BUILT_IN: [&str; 5] = ["finger", "surgical_wrist", "bench_joint", "planar_leg", "exosuit_elbow"];

/// A machine with a motion that its muscles can carry out; the error says why there is none.
pub(crate) fn sampled(seed: u64) -> Result<Sampled, String> {
    let mut draw = Draw(Random::new(0x6865_616c_7468_7921 ^ seed.wrapping_mul(0x9e37_79b9_7f4a_7c15)));
    let (mut machine, body) = match draw.below(8) {
        0 | 1 => {
            let lighter = draw.log_between(0.3, 1.0);
            let machine = random_machine::machine(seed, lighter).map_err(|error| error.to_string())?.machine;
            let body = format!("chain of {} joints", machine.encoders.len());
            (machine, body)
        }
        2 => {
            let name = BUILT_IN[draw.below(BUILT_IN.len())];
            (machine(name), name.to_owned())
        }
        _ => hand(&mut draw),
    };
    let sensors = encoders(&mut draw, &mut machine);
    let (motion, trajectory, hold) = motion(&mut draw, &machine).map_err(|error| error.to_string())?;
    match first_infeasibility(&machine, &trajectory, 1).map_err(|error| error.to_string())? {
        Some(violated) => Err(format!("{body}: {violated}")),
        None => Ok(Sampled { machine, what: format!("{body}, {sensors}, {motion}"), trajectory, hold }),
    }
}

/// Encoders of 14 bits, of one resolution from 6 urad to 6 mrad, none, or each joint its own.
fn encoders(draw: &mut Draw, machine: &mut Machine) -> &'static str {
    let resolution = |draw: &mut Draw| draw.log_between(6e-6, 6e-3);
    match draw.below(6) {
        0 | 1 => "14 bits",
        2 => {
            let resolution = resolution(draw);
            machine.encoders.fill(Some(JointEncoder { resolution, ..JointEncoder::slide() }));
            if resolution < 2e-4 { "fine encoders" } else { "coarse encoders" }
        }
        3 => {
            machine.encoders.fill(None);
            "no joint encoder"
        }
        4 => {
            let some = machine.encoders.iter_mut();
            some.for_each(|encoder| *encoder = if draw.chance(0.5) { *encoder } else { None });
            "some joint encoders"
        }
        _ => {
            for encoder in &mut machine.encoders {
                let resolution = resolution(draw);
                *encoder = draw.chance(0.8).then_some(JointEncoder { resolution, ..JointEncoder::slide() });
            }
            "mixed encoders"
        }
    }
}

/// A tour, a slow one, or poses near the start, far apart or close by, in a short time or a long one.
fn motion(draw: &mut Draw, machine: &Machine) -> Result<(&'static str, Trajectory, f64), Error> {
    let tour = |duration: Option<f64>| {
        plan_tour(machine, duration, |trajectory| first_infeasibility(machine, trajectory, 1))
    };
    Ok(match draw.below(6) {
        0 | 1 => ("tour", tour(None)?, 1.0),
        2 => ("slow tour", tour(Some(24.0))?, 1.0),
        3 => ("poses", poses(draw, machine, 0.5, 3.0)?, 1.0),
        4 => ("creeping", poses(draw, machine, 0.03, 5.0)?, 2.0),
        _ => ("a long hold", poses(draw, machine, 0.3, 2.0)?, 12.0),
    })
}

/// Three poses within a fraction of the ranges about the start, each after so many seconds.
fn poses(draw: &mut Draw, machine: &Machine, fraction: f64, each: f64) -> Result<Trajectory, Error> {
    let ranges = machine.ranges()?;
    let mut points = vec![JointWaypoint { time: 0.0, q: machine.start.clone() }];
    for k in 1..4 {
        let places = machine.start.iter().zip(&ranges).map(|(start, [low, high])| {
            let reach = 0.5 * fraction * (high - low);
            (start + draw.between(-reach, reach)).clamp(*low, *high)
        });
        points.push(JointWaypoint { time: each * f64::from(k), q: places.collect() });
    }
    plan(machine, &DesiredMotion::JointWaypoints(points), None)
}

/// A hand of fingers with one to four hinges each, in all one to seventeen, on pairs of tendons with constant
/// moment arms, behind thin ropes with small drives or behind the bench's cable.
fn hand(draw: &mut Draw) -> (Machine, String) {
    let joints = draw.log_between(1.0, 17.99) as usize;
    let radius = draw.log_between(0.004, 0.012);
    let size = draw.log_between(0.6, 1.6);
    let range = draw.between(0.5, 1.6);
    let (body, fingers) = body(draw, joints, (radius, size, range));
    let thin = draw.chance(0.7);
    let text = transmission(draw, thin, radius);
    let read = machine_from_toml("hand.toml", &text, &mut |_| Ok(body.clone()));
    let rope = if thin { "thin ropes" } else { "the bench's cable" };
    let what =
        format!("hand of {joints} joints in {fingers} fingers, arms of {:.1} mm, {rope}", 1e3 * radius);
    (read.unwrap().machine, what)
}

/// The body as MJCF, and its number of fingers.
fn body(draw: &mut Draw, joints: usize, (radius, size, range): (f64, f64, f64)) -> (String, usize) {
    let (mut bodies, mut tendons, mut left, mut finger) = (String::new(), String::new(), joints, 0);
    while left > 0 {
        let count = left.min(1 + draw.below(4));
        let y = 0.02 * size * finger as f64;
        let mut length = 0.0;
        let mut place = format!("0 {y} 0");
        for k in 0..count {
            let name = format!("f{finger}_{k}");
            let axis = if k == 0 && draw.chance(0.5) { "0 0 1" } else { "0 1 0" };
            let low = -range * draw.between(0.2, 0.6);
            let high = low + range;
            length = if k == 0 { 0.045 * size } else { 0.7 * length };
            let mass = 0.015 * size.powi(3) * (length / 0.045);
            let damping = draw.log_between(1e-5, 1e-3);
            let arm = radius * draw.between(0.9, 1.1);
            let _ = write!(
                bodies,
                "<body name=\"{name}\" pos=\"{place}\"><joint name=\"{name}\" type=\"hinge\" axis=\"{axis}\" \
                 range=\"{low} {high}\" damping=\"{damping}\" armature=\"1e-6\"/>\
                 <geom type=\"capsule\" fromto=\"0 0 0 {length} 0 0\" size=\"{}\" mass=\"{mass}\"/>",
                0.007 * size
            );
            for (side, coefficient) in [("f", arm), ("e", -arm)] {
                let _ = write!(
                    tendons,
                    "<fixed name=\"{name}_{side}\"><joint joint=\"{name}\" coef=\"{coefficient}\"/></fixed>"
                );
            }
            place = format!("{length} 0 0");
        }
        bodies += &"</body>".repeat(count);
        (left, finger) = (left - count, finger + 1);
    }
    let text = format!(
        "<mujoco model=\"hand\"><compiler angle=\"radian\"/><worldbody>{bodies}</worldbody>\
         <tendon>{tendons}</tendon></mujoco>"
    );
    (text, finger)
}

/// The machine file around it.
fn transmission(draw: &mut Draw, thin: bool, radius: f64) -> String {
    let (length, bend) = (draw.between(0.2, 0.8), draw.between(0.5, 3.0));
    let every = format!(
        "body = \"hand.xml\"\n[every_transmission]\ndrive = \"small\"\nnear_length_m = 0.04\n\
         sheath_length_m = {length}\nsheath_bend_rad = {bend}\n"
    );
    if !thin {
        return every
            + "[[drive]]\nname = \"small\"\nmotor = \"class_22mm_20w\"\nreducer = \"class_22mm\"\nratio = \
                84\n\
               winch = \"drum_10mm\"\n";
    }
    let drum = f64::max(0.004, 0.6 * radius);
    let (friction, compliance) = (draw.between(0.06, 0.15), draw.log_between(6e-5, 3e-4));
    let least = draw.between(1.5, 4.0);
    every
        + &format!(
            "tension_limits_n = [{least}, 40.0]\nmotor_encoder_counts = 2048\n\
             [every_transmission.load_cell]\nnoise_n = 0.03\nresolution_n = 0.005\nrange_n = 100.0\n\
             [every_transmission.cable]\nfriction = {friction}\nefficiency = 0.98\ndrag_n_s_per_m = 4.0\n\
             drag_fade_n = 0.5\npretension_n = 1.0\ncompliance_per_n = {compliance}\n\
             [[drive]]\nname = \"small\"\nmotor = \"class_22mm_20w\"\nreducer = \"class_22mm\"\nratio = 29\n\
             winch = {{ radius_m = {drum}, lead_m = 6e-4, cable_diameter_m = 5e-4, turns_per_layer = 10.0, \
             layers = 1 }}\n\
             max_tension_n = 60.0\nmin_tension_n = 0.3\n"
        )
}
