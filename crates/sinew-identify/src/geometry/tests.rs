//! Sampled machines in front of a sampled camera, at rest in poses: what is found, against the truth.

use super::*;
use sinew::body::{JointCorrection, JointKind, Parts, Poses, Robot};
use sinew::machine::{Machine, Workshop};
use sinew::random::Random;
use sinew::twin::camera::{Camera, CameraParameters};

fn machine(name: &str) -> Machine {
    let file = format!("{}/../../models/{name}.toml", env!("CARGO_MANIFEST_DIR"));
    let text = std::fs::read_to_string(&file).unwrap();
    sinew::description::machine_from_toml(&file, &text, &mut |_| Err("no file".to_owned())).unwrap().machine
}

/// A chain of hinges and a slide with directions drawn at random.
fn chain(seed: u64) -> Machine {
    let mut machine = machine("lm_arm");
    let mut random = Random::new(seed);
    let mut parts: Parts = machine.robot.parts().clone();
    for joint in &mut parts.joints {
        let axis: [f64; 3] = std::array::from_fn(|_| random.normal());
        let length = axis.iter().map(|x| x * x).sum::<f64>().sqrt();
        joint.axis = axis.map(|x| x / length);
    }
    for body in parts.bodies.iter_mut().skip(1) {
        body.position.iter_mut().for_each(|x| *x += 0.05 * random.normal());
    }
    machine.robot = Robot::new(parts).unwrap();
    machine
}

/// A machine as built, before its camera.
struct Built {
    robot: Robot,
    truth: Vec<JointCorrection>,
    camera: Camera,
}

fn built(machine: &Machine, camera: CameraParameters, seed: u64) -> Built {
    let mut random = Random::new(seed ^ 0x0074_7275_7468);
    let mut within = |bound: f64| bound * (2.0 * random.unit() - 1.0);
    let t = &machine.tolerances;
    let mut draw = |joint: &sinew::body::Joint| {
        let hinge = joint.kind == JointKind::Hinge;
        let mut at = JointCorrection::default();
        at.displacement.offset = std::array::from_fn(|_| within(t.link));
        at.displacement.tilt = std::array::from_fn(|_| within(t.axis));
        at.zero = within(if hinge { t.zero } else { t.zero_slide });
        at.flex = if hinge { 0.5 * (t.flex + within(t.flex)) } else { 0.0 };
        at
    };
    let parts = machine.robot.parts();
    let mut truth: Vec<JointCorrection> = parts.joints.iter().map(&mut draw).collect();
    for coupling in &parts.couplings {
        truth[coupling.follower].zero = 0.0;
    }
    let robot = Robot::new(parts.corrected(&truth)).unwrap();
    let camera = Camera::new(camera, &machine.default_markers(), seed).unwrap();
    Built { robot, truth, camera }
}

impl Built {
    fn poses(&self, machine: &Machine, reading: &[f64]) -> Poses {
        let mut q = self.robot.reference_pose();
        for (joint, value) in machine.robot.independent_joints().into_iter().zip(reading) {
            q[self.robot.coordinates_of(joint).start] = *value;
        }
        self.robot.apply_couplings(&mut q).unwrap();
        let mut poses = Poses::new(&self.robot);
        self.robot.bent_kinematics(&q, &mut poses).unwrap();
        poses
    }

    /// Rests in poses, a second each, with a motion of half a second between.
    fn tour(&mut self, machine: &Machine, stops: &[Vec<f64>]) -> (Readings, Vec<Frame>) {
        let (mut readings, mut seen) = (Readings::default(), Vec::new());
        for (k, stop) in stops.iter().enumerate() {
            let from = &stops[k.saturating_sub(1)];
            for step in 0..200 {
                let part = (f64::from(step) / 50.0).min(1.0);
                let part = part * part * (3.0 - 2.0 * part);
                let q: Vec<f64> = from.iter().zip(stop).map(|(a, b)| a + part * (b - a)).collect();
                let time = 2.0 * k as f64 + 0.01 * f64::from(step);
                if self.camera.is_due(time) {
                    let poses = self.poses(machine, &q);
                    self.camera.expose(time, &self.robot, &poses, &mut seen);
                }
                readings.time.push(time);
                // Fourteen bits.
                readings.joint.push(q.iter().map(|q| (q / 3.8e-4).round() * 3.8e-4).collect());
            }
        }
        let frame =
            |s: sinew::twin::camera::Sighting| Frame { time: s.time, marker: s.marker, position: s.position };
        (readings, seen.into_iter().map(frame).collect())
    }
}

/// The end point's body and place.
fn point(machine: &Machine) -> (usize, [f64; 3]) {
    let tip = &machine.default_markers()[0];
    (tip.body, tip.position)
}

struct Judged {
    before: f64,
    mean: f64,
    largest: f64,
    /// Expected over true error; fraction of fresh poses within 95 %; determined parameters within, of.
    ratio: f64,
    inside: (usize, usize),
    delay: f64,
    estimate: Estimate,
}

fn poses(machine: &Machine, count: usize, seed: u64) -> Vec<Vec<f64>> {
    let mut random = Random::new(seed);
    let ranges = machine.ranges().unwrap();
    let mut draw = || {
        ranges
            .iter()
            .map(|[low, high]| low + (high - low) * (0.1 + 0.8 * random.unit()))
            .collect::<Vec<f64>>()
    };
    (0..count).map(|_| draw()).collect()
}

fn calibrated(machine: &Machine, camera: CameraParameters, stops: &[Vec<f64>], seed: u64) -> Judged {
    let mut built = built(machine, camera, seed);
    let (readings, frames) = built.tour(machine, stops);
    let markers = machine.default_markers();
    let model = GeometryModel::new(machine, &markers, 1).unwrap();
    let delay = speed_delay(&model, &readings, &frames).unwrap();
    let found = places(&model, &readings, &frames, delay).unwrap();
    let epochs = found.last().unwrap().epoch + 1;
    let model = GeometryModel::new(machine, &markers, epochs).unwrap();
    let estimate = estimate(&model, &found).unwrap();
    let fresh = poses(machine, 100, seed + 1000);
    let at = |reading: &Vec<f64>| Place {
        time: [0.0; 2],
        reading: reading.clone(),
        seen: vec![Seen { marker: 0, position: [0.0; 3] }],
        epoch: 0,
    };
    let all: Vec<Place> = fresh.iter().map(at).collect();
    // The marker as found, by the design and by the estimate.
    let mut design = estimate.theta.clone();
    for (value, parameter) in design.iter_mut().zip(model.parameters()) {
        *value *= f64::from(u8::from(matches!(parameter.kind, ParameterKind::Marker(..))));
    }
    let design = model.world(&design, &all).unwrap();
    let known = model.world(&estimate.theta, &all).unwrap();
    let columns = model.derivatives(&estimate.theta, &known, |theta| model.world(theta, &all)).unwrap();
    let (mut before, mut mean, mut largest, mut expected) = (0.0, 0.0, 0.0_f64, 0.0);
    let tip = &built.camera.markers()[0];
    for (k, q) in fresh.iter().enumerate() {
        let real = built.robot.body_pose(&built.poses(machine, q), tip.body).point(tip.position);
        let error = |a: [f64; 3]| places::distance(a, real);
        before += error(design[k]) / 100.0;
        mean += error(known[k]) / 100.0;
        largest = largest.max(error(known[k]));
        let slopes: Vec<[f64; 3]> = columns.iter().map(|c| c.as_ref().map_or([0.0; 3], |c| c[k])).collect();
        expected += 0.92 * estimate.variance(&model, &slopes).sqrt() / 100.0;
    }
    let value = |kind: ParameterKind| match kind {
        ParameterKind::Offset(j, k) => Some(built.truth[j].displacement.offset[k]),
        ParameterKind::Tilt(j, k) => Some(built.truth[j].displacement.tilt[k]),
        ParameterKind::Flex(j) => Some(built.truth[j].flex),
        ParameterKind::Zero(j) => Some(built.truth[j].zero),
        ParameterKind::Marker(m, k) => Some(built.camera.markers()[m].position[k] - markers[m].position[k]),
        _ => None,
    };
    let determined: Vec<bool> = (model.parameters().iter().zip(&estimate.findings))
        .filter(|(_, finding)| finding.determined)
        .filter_map(|(p, finding)| Some((finding.value - value(p.kind)?).abs() < 1.96 * finding.sd))
        .collect();
    let inside = (determined.iter().filter(|x| **x).count(), determined.len());
    Judged { before, mean, largest, ratio: expected / mean, inside, delay, estimate }
}

fn good(machine: &Machine) -> CameraParameters {
    CameraParameters { noise: 1e-3, distortion: 0.0, ..CameraParameters::looking_at(0.5 * machine.size()) }
}

#[test]
fn a_rough_arm_is_ten_times_better_after_twenty_random_poses() {
    let machine = machine("lm_arm").built_by(Workshop::Rough);
    let judged = calibrated(&machine, good(&machine), &poses(&machine, 20, 5), 1);
    assert!(judged.before > 5e-3 && judged.mean < 0.1 * judged.before, "{} {}", judged.before, judged.mean);
    assert!((judged.delay - 0.03).abs() < 0.015, "{}", judged.delay);
}

#[test]
fn a_fifth_of_the_points_far_off_changes_little() {
    let machine = machine("lm_arm").built_by(Workshop::Rough);
    let stops = poses(&machine, 25, 6);
    let clean = calibrated(&machine, good(&machine), &stops, 2);
    let camera =
        CameraParameters { outliers: 0.2, dropouts: 0.2, swapped: 0.1, delay: 0.8, ..good(&machine) };
    let bad = calibrated(&machine, camera, &stops, 2);
    // Half of the sightings are lost or wrong here.
    assert!(bad.mean < 2.0 * clean.mean && bad.mean < 1e-3, "{} {}", bad.mean, clean.mean);
    assert!((bad.delay - 0.8).abs() < 0.02, "{}", bad.delay);
}

#[test]
fn a_wrong_scale_a_moved_camera_and_its_delay_are_found() {
    let machine = machine("lm_arm").built_by(Workshop::Careful);
    let camera = CameraParameters { scale: 0.01, moved: (25.0, [4e-3, 0.0, 2e-3]), ..good(&machine) };
    let judged = calibrated(&machine, camera, &poses(&machine, 25, 7), 3);
    let scale = judged.estimate.findings.iter().find(|f| f.name == "camera.scale").unwrap();
    assert!((scale.value - 0.01).abs() < 3.0 * scale.sd && scale.sd < 3e-3, "{scale:?}");
    assert!(judged.estimate.findings.iter().any(|f| f.name == "camera_2.x_m"));
    assert!(judged.mean < 1e-3, "{}", judged.mean);
}

#[test]
fn millimetres_and_mirrored_axes_are_refused_by_their_reason() {
    let machine = machine("lm_arm");
    let stops = poses(&machine, 8, 8);
    let markers = machine.default_markers();
    let model = GeometryModel::new(&machine, &markers, 1).unwrap();
    let refused = |camera: CameraParameters, unit: f64| {
        let mut built = built(&machine, camera, 4);
        let (readings, mut frames) = built.tour(&machine, &stops);
        frames.iter_mut().for_each(|f| f.position = f.position.map(|x| unit * x));
        let found = places(&model, &readings, &frames, 0.03).unwrap();
        estimate(&model, &found).map(drop).unwrap_err().to_string()
    };
    let text = refused(CameraParameters { mirrored: true, ..good(&machine) }, 1.0);
    assert!(text.contains("wrong sign"), "{text}");
    let text = refused(good(&machine), 1000.0);
    assert!(text.contains("metres"), "{text}");
}

#[test]
fn chosen_poses_promise_more_than_random_ones_and_each_pose_tells_something() {
    let machine = machine("lm_arm").built_by(Workshop::Rough);
    let model = GeometryModel::new(&machine, &machine.default_markers(), 1).unwrap();
    let (candidates, task) = (poses(&machine, 300, 9), poses(&machine, 40, 10));
    let chosen = plan(&model, &candidates, &task, (point(&machine), 3e-4, 20)).unwrap();
    let first = plan(&model, &candidates[..20], &task, (point(&machine), 3e-4, 20)).unwrap();
    let [best, random] = [&chosen, &first].map(|plan| *plan.expected_m.last().unwrap());
    assert!(best < 0.93 * random, "{best} {random}");
    assert!(chosen.expected_m.windows(2).all(|pair| pair[1] < pair[0] * (1.0 + 1e-9)));
}

/// `SINEW_LONG=1`: the figures of docs/campaigns.md, seeds 0 to `SINEW_SEEDS`.
#[test]
fn long_campaign_of_calibrated_machines() {
    if std::env::var_os("SINEW_LONG").is_none() {
        return;
    }
    let seeds: u64 = std::env::var("SINEW_SEEDS").ok().and_then(|n| n.parse().ok()).unwrap_or(20);
    let names = ["lm_arm", "chain10", "planar_leg", "finger", "shoulder", "random"];
    for workshop in [Workshop::Careful, Workshop::Rough] {
        for name in names {
            for chosen in [false, true] {
                let mut all = Vec::new();
                for seed in 0..seeds {
                    let design = if name == "random" { chain(seed) } else { machine(name) };
                    let machine = design.built_by(workshop);
                    let stops = if chosen {
                        let model = GeometryModel::new(&machine, &machine.default_markers(), 1).unwrap();
                        let candidates = poses(&machine, 400, seed + 77);
                        let task = poses(&machine, 40, 10);
                        let found = plan(&model, &candidates, &task, (point(&machine), 3e-4, 20)).unwrap();
                        found.chosen.iter().map(|k| candidates[*k].clone()).collect()
                    } else {
                        poses(&machine, 20, seed + 5)
                    };
                    all.push(calibrated(&machine, good(&machine), &stops, seed));
                }
                let median = |of: fn(&Judged) -> f64| places::median(all.iter().map(of));
                let worst = all.iter().map(|j| j.mean).fold(0.0, f64::max);
                let honest = all.iter().filter(|j| (0.8..1.3).contains(&j.ratio)).count();
                let inside: usize = all.iter().map(|j| j.inside.0).sum();
                let of: usize = all.iter().map(|j| j.inside.1).sum();
                println!(
                    "{workshop:?} {name} {}: before {:.2} mm, after {:.2} mm (worst machine {:.2}, largest {:.2}), \
                     expected/true median {:.2}, in 0.8..1.3 {honest} of {seeds}, inside 95 % {:.1} % of {of}",
                    if chosen { "chosen" } else { "random" },
                    1e3 * median(|j| j.before),
                    1e3 * median(|j| j.mean),
                    1e3 * worst,
                    1e3 * median(|j| j.largest),
                    median(|j| j.ratio),
                    100.0 * inside as f64 / of.max(1) as f64,
                );
            }
        }
    }
}
