//! Models of OpenSim: against OpenSim itself (`benches/peers/osim_golden.py`), refused content with its
//! place, and hundreds of damaged files.

use serde::Deserialize;
use sinew::body::{Parts, Poses, Reduction, Robot};
use sinew::description::{Description, DescriptionError, from_osim, from_toml, to_mjcf, to_toml};
use sinew::muscle::{Geometry, Muscles};

/// The path around a cylinder.
const CORD: usize = 2;

const LEG: &str = include_str!("../../../../../fuzz/seeds/osim/leg.osim");

#[derive(Deserialize)]
struct Golden {
    coordinates: Vec<String>,
    paths: Vec<String>,
    bodies: Vec<String>,
    poses: Vec<Pose>,
}

#[derive(Deserialize)]
struct Pose {
    x: Vec<f64>,
    lengths: Vec<f64>,
    arms: Vec<Vec<f64>>,
    origins: Vec<[f64; 3]>,
    center: [f64; 3],
}

fn leg(text: &str) -> Result<Description, DescriptionError> {
    from_osim("leg.osim", text)
}

/// Lengths and moment arms about the independent coordinates, path by path.
fn paths(robot: &Robot, x: &[f64]) -> (Vec<f64>, Vec<f64>, Vec<f64>) {
    let (muscles, mut reduction) = (Muscles::new(robot), Reduction::new(robot));
    let mut geometry = Geometry::new(robot, &muscles);
    let mut q = vec![0.0; robot.nq()];
    reduction.expand(robot, x, &mut q).unwrap();
    muscles.evaluate(&q, &mut geometry).unwrap();
    let mut dense = vec![0.0; muscles.count() * robot.nv()];
    muscles.dense(&geometry, &mut dense).unwrap();
    let mut arms = vec![0.0; muscles.count() * x.len()];
    reduction.rows(&dense, &mut arms).unwrap();
    (geometry.lengths().to_vec(), arms, q)
}

#[test]
fn a_leg_moves_and_is_pulled_as_opensim_says() {
    let golden: Golden = serde_json::from_str(include_str!("opensim.json")).unwrap();
    let robot = Robot::new(leg(LEG).unwrap().parts).unwrap();
    let parts = robot.parts();
    let named = |joint: &usize| parts.joints[*joint].name.clone();
    assert_eq!(robot.independent_joints().iter().map(named).collect::<Vec<_>>(), golden.coordinates);
    assert_eq!(parts.tendons.iter().map(|tendon| tendon.name.clone()).collect::<Vec<_>>(), golden.paths);
    let mut poses = Poses::new(&robot);
    let (mut worst, mut straight, mut round) = ([0.0_f64; 2], [0.0_f64; 2], [0.0_f64; 2]);
    let off = |worst: &mut f64, ours: &[f64], theirs: &[f64]| {
        assert_eq!(ours.len(), theirs.len());
        ours.iter().zip(theirs).for_each(|(a, b)| *worst = worst.max((a - b).abs()));
    };
    for pose in &golden.poses {
        let (lengths, arms, q) = paths(&robot, &pose.x);
        for (path, theirs) in pose.arms.iter().enumerate() {
            let (mine, n) = (&lengths[path..=path], theirs.len());
            let [length, arm] = if path == CORD { &mut round } else { &mut straight };
            off(length, mine, &pose.lengths[path..=path]);
            off(arm, &arms[path * n..(path + 1) * n], theirs);
        }
        robot.forward_kinematics(&q, &mut poses).unwrap();
        for (name, origin) in golden.bodies.iter().zip(&pose.origins) {
            off(&mut worst[0], &robot.body_pose(&poses, robot.body(name).unwrap()).origin, origin);
        }
        let (mut mass, mut center) = (0.0, [0.0; 3]);
        for (index, body) in parts.bodies.iter().enumerate() {
            mass += body.mass;
            let at = robot.body_pose(&poses, index).point(body.center_of_mass);
            (0..3).for_each(|k| center[k] += body.mass * at[k]);
        }
        off(&mut worst[1], &center.map(|x| x / mass), &pose.center);
    }
    assert!(worst[0] < 1e-9 && worst[1] < 1e-9, "{worst:?}");
    assert!(straight[0] < 1e-9 && straight[1] < 1e-7, "{straight:?}");
    // OpenSim finds the points where a line touches a cylinder by iterations that end early.
    assert!(round[0] < 1e-5 && round[1] < 2e-4, "{round:?}");
}

#[test]
fn what_is_not_read_is_listed_once_and_the_rest_is_in_the_parts() {
    let read = leg(LEG).unwrap();
    let told: Vec<_> = read.warnings.iter().map(ToString::to_string).collect();
    assert_eq!(told.len(), 3, "{told:#?}");
    // Its knee bends so far that the cord's straight line passes the cylinder on the other side.
    assert!(
        told[2].contains("OpenSim pulls `cord` to the side of `knee` in 4 % of the poses"),
        "{}",
        told[2]
    );
    assert!(
        told[0].contains("it is a cable here, without fibres") && told[1].contains("<CoordinateLimitForce>")
    );
    assert!(read.warnings.iter().all(|warning| !warning.changes_forces));
    let parts = &read.parts;
    let most: Vec<_> = parts.actuators.iter().map(|actuator| actuator.largest_tension().unwrap()).collect();
    assert_eq!(most, [700.0, 1500.0, 120.0, 80.0]);
    let robot = Robot::new(parts.clone()).unwrap();
    let key = robot.key("default").unwrap();
    let at = |name: &str| key[robot.coordinates_of(robot.joint(name).unwrap()).start];
    let shown = [at("height"), at("hip_y"), at("knee_angle")];
    assert_eq!(shown.map(f64::to_bits), [0.9, 0.1, -0.4_f64].map(f64::to_bits));
    assert_eq!(parts.joints[robot.joint("knee_angle").unwrap()].range, Some([-1.7, 0.1]));
    assert!(robot.joint("knee_twist").is_none());
}

#[test]
fn a_path_goes_past_a_site_that_is_not_active() {
    let mut parts = leg(LEG).unwrap().parts;
    // Both conditional points of the flexor are left out by hand.
    let robot = Robot::new(parts.clone()).unwrap();
    for tendon in &mut parts.tendons {
        if let sinew::body::TendonPath::Spatial(path) = &mut tendon.path {
            path.retain(|element| match element {
                sinew::body::PathElement::Site(site) => parts.sites[*site].active.is_none(),
                _ => true,
            });
        }
    }
    let straight = Robot::new(parts).unwrap();
    let off = |x: &[f64]| {
        let ((a, arms, q), (b, others, _)) = (paths(&robot, x), paths(&straight, x));
        let (muscles, others_too) = (Muscles::new(&robot), Muscles::new(&straight));
        let bend = |robot: &Robot, muscles: &Muscles| {
            let mut geometry = Geometry::new(robot, muscles);
            muscles.evaluate(&q, &mut geometry).unwrap();
            let mut bends = vec![0.0; muscles.count()];
            muscles.bends(&geometry, &mut bends).unwrap();
            bends[0]
        };
        let arms = arms.iter().zip(&others).map(|(a, b)| (a - b).abs()).fold(0.0, f64::max);
        [(a[0] - b[0]).abs(), arms, (bend(&robot, &muscles) - bend(&straight, &others_too)).abs()]
    };
    let past = off(&[0.9, 0.1, 0.2, 0.8, -0.5, 0.0, 0.0]);
    assert!(past.iter().all(|off| *off < 1e-12), "{past:?}");
    let through = off(&[0.9, 0.1, 0.2, 0.4, -0.9, 0.0, 0.0]);
    assert!(through.iter().all(|off| *off > 1e-4), "{through:?}");
}

#[test]
fn a_model_is_the_same_after_toml_and_near_after_mjcf() {
    let parts = leg(LEG).unwrap().parts;
    let again = from_toml("again", &to_toml(&parts)).unwrap().parts;
    assert_eq!(
        (&again.sites, &again.couplings, &again.joints),
        (&parts.sites, &parts.couplings, &parts.joints)
    );
    let mjcf = super::mjcf(&to_mjcf(&parts)).unwrap().parts;
    let curves = parts.couplings.iter().zip(&mjcf.couplings).filter(|(curve, _)| !curve.pieces.is_empty());
    let mut count = 0;
    for (curve, polynomial) in curves {
        let range = parts.joints[curve.leader.unwrap()].range;
        let (coefficients, error) = curve.polynomial(range);
        assert_eq!(coefficients.map(f64::to_bits), polynomial.coefficients.map(f64::to_bits));
        assert!(error < 0.02, "{error}");
        count += 1;
    }
    assert_eq!(count, 6);
    // The polynomial of a curve that is one of degree three is the curve itself.
    let cubic = |x: f64| 0.3 - 0.2 * x + 0.5 * x * x - 0.7 * x * x * x;
    let xs = [-1.0, -0.3, 0.1, 0.8, 1.5];
    let list = |values: &[f64]| values.iter().map(ToString::to_string).collect::<Vec<_>>().join(" ");
    let spline = format!("<x>{}</x><y>{}</y>", list(&xs), list(&xs.map(cubic)));
    let text = LEG.replace("<x>-2 -1.4 -0.6 0.1</x><y>-1.9 -1.2 -0.6 0.05</y>", &spline);
    let parts = leg(&text).unwrap().parts;
    let cap = parts.joints.iter().position(|joint| joint.name == "cap_angle").unwrap();
    let coupling = parts.couplings.iter().find(|coupling| coupling.follower == cap).unwrap();
    let (found, error) = coupling.polynomial(None);
    for (found, expected) in found.iter().zip([0.3, -0.2, 0.5, -0.7, 0.0]) {
        assert!((found - 1.1 * expected).abs() < 1e-12 && error < 1e-12, "{found} {expected} {error}");
    }
}

#[test]
fn invalid_content_is_refused_with_its_line() {
    for (from, to, line, words) in [
        (
            "Version=\"40000\"",
            "Version=\"30000\"",
            2,
            &["Version", "30000", "open the model in OpenSim 4"][..],
        ),
        ("<OpenSimDocument Version=\"40000\">", "<OpenSimDocument>", 2, &["Version", "missing"]),
        (
            "<mass>5</mass>",
            "<mass>heavy</mass>",
            9,
            &["<Body name=\"pelvis\"> `mass`", "`heavy`", "finite number"],
        ),
        ("<mass>5</mass>", "<mass>-5</mass>", 9, &["`mass`", "-5", ">= 0"]),
        ("<socket_parent_frame>rail<", "<socket_parent_frame>trail<", 62, &["`trail`", "no one frame"]),
        ("<socket_parent>/ground<", "<socket_parent>rail<", 72, &["circle"]),
        ("<socket_parent_frame>rail</socket_parent_frame>", "", 61, &["socket_parent_frame", "missing"]),
        ("SliderJoint", "EllipsoidJoint", 61, &["<EllipsoidJoint>", "which is not read"]),
        ("UniversalJoint", "GimbalJoint", 190, &["has 2 coordinates: expected 3"]),
        ("<range>0.5 1.2</range>", "<range>1.5 1.2</range>", 67, &["range", "1.5", "low end"]),
        (
            "<LinearFunction name=\"function\"><coefficients>-1 0.05</coefficients></LinearFunction>",
            "<SineFunction/>",
            117,
            &["<SineFunction>", "SimmSpline"],
        ),
        ("<axis>0.1 0.2 1</axis>", "<axis>0 0 0</axis>", 116, &["axis", "no direction"]),
        ("<x>-2 -1.2 -0.5 0 0.1</x>", "<x>-2 -1.2 -1.5 0 0.1</x>", 129, &["`x`", "-1.5", "rising"]),
        ("<x>-2 -1.2 -0.5 0 0.1</x>", "<x>-2 -1.2 0.1</x>", 129, &["`y`", "5 numbers", "3"]),
        ("<coordinates>knee_twist<", "<coordinates>knee_twists<", 120, &["`knee_twists`", "no coordinate"]),
        (">knee_angle</independent", ">cap_angle</independent", 173, &["cap_angle"]),
        ("/bodyset/pelvis</socket_child_frame>", "/ground</socket_child_frame>", 63, &["ground"]),
        ("<quadrant>-x<", "<quadrant>up<", 27, &["`up`", "x, y, z"]),
        ("<wrap_object>head<", "<wrap_object>foot<", 338, &["`foot`", "no wrap object"]),
        ("<max_isometric_force>700<", "<max_isometric_force>-7<", 253, &["-7", ">= 0"]),
    ] {
        assert!(LEG.contains(from), "{from}");
        let text = if from.ends_with("Joint") { LEG.replace(from, to) } else { LEG.replacen(from, to, 1) };
        let error = leg(&text).and_then(Description::robot).map(|_| ()).expect_err(to);
        let told = error.to_string();
        assert_eq!((error.file.as_str(), error.line), ("leg.osim", line), "{told}");
        words.iter().for_each(|word| assert!(told.contains(word), "`{word}` is not in: {told}"));
    }
}

#[test]
fn an_impossible_inertia_is_that_of_opensim_and_said_so() {
    let text = LEG.replace("<inertia>0.001 0.004 0.004 0 0 0<", "<inertia>0 0 0.009 0 0 0<");
    let read = leg(&text).unwrap();
    let foot = read.parts.bodies.iter().find(|body| body.name == "foot").unwrap();
    let same = 0.009 / 3.0_f64.sqrt();
    assert!(foot.inertia[..3].iter().all(|x| (x - same).abs() < 1e-15) && foot.inertia[3..] == [0.0; 3]);
    assert!(read.warnings.iter().any(|warning| warning.what.contains("as in OpenSim")));
}

#[test]
fn forces_that_are_left_out_bar_a_machine_where_they_change_its_motion() {
    let with = |force: &str| {
        let text = LEG.replace(
            "<CoordinateLimitForce name=\"stop\">",
            &format!("{force}<CoordinateLimitForce name=\"stop\">"),
        );
        leg(&text).unwrap().warnings.iter().any(|warning| warning.changes_forces)
    };
    assert!(with("<BushingForce name=\"b\"><stiffness>3</stiffness></BushingForce>"));
    // OpenSim writes such names, which are none in XML.
    assert!(!with("<HuntCrossleyForce name=\"h\"><HuntCrossleyForce::Set name=\"s\"/></HuntCrossleyForce>"));
    assert!(!with("<CoordinateActuator name=\"a\"><coordinate>height</coordinate></CoordinateActuator>"));
}

/// SplitMix64.
struct Draws(u64);

impl Draws {
    fn below(&mut self, n: usize) -> usize {
        self.0 = self.0.wrapping_add(0x9e37_79b9_7f4a_7c15);
        let mut z = self.0;
        z = (z ^ (z >> 30)).wrapping_mul(0xbf58_476d_1ce4_e5b9);
        z = (z ^ (z >> 27)).wrapping_mul(0x94d0_49bb_1331_11eb);
        ((z ^ (z >> 31)) % n.max(1) as u64) as usize
    }
}

/// One mistake: a word replaced by another, or a line lost, doubled, moved, or all from a place on.
fn damaged(text: &str, draws: &mut Draws) -> String {
    const WORDS: [&str; 16] = [
        "0",
        "-1",
        "1e308",
        "-1e-308",
        "nan",
        "inf",
        "",
        "..",
        "/ground",
        "/bodyset/femur",
        "true",
        "all",
        "x",
        "1 2",
        "<a/>",
        "SineFunction",
    ];
    let mut lines: Vec<String> = text.lines().map(String::from).collect();
    let (at, other) = (draws.below(lines.len()), draws.below(lines.len()));
    match draws.below(8) {
        0 => {
            lines.remove(at);
        }
        1 => lines.insert(other, lines[at].clone()),
        2 => lines.swap(at, other),
        3 => return text.chars().take(draws.below(text.len())).collect(),
        kind => {
            let is_part = |c: char| c.is_alphanumeric() || "._/-+".contains(c);
            let line = lines[at].clone();
            let words: Vec<&str> = line.split(|c| !is_part(c)).filter(|word| !word.is_empty()).collect();
            if !words.is_empty() {
                let word = words[draws.below(words.len())];
                let elsewhere = lines[other].clone();
                let others: Vec<&str> =
                    elsewhere.split(|c| !is_part(c)).filter(|word| !word.is_empty()).collect();
                let to = if kind < 6 || others.is_empty() {
                    WORDS[draws.below(WORDS.len())]
                } else {
                    others[draws.below(others.len())]
                };
                lines[at] = line.replacen(word, to, 1);
            }
        }
    }
    lines.join("\n") + "\n"
}

#[test]
fn a_damaged_model_is_read_or_refused_in_one_error() {
    let mut draws = Draws(11);
    let (mut read, mut refused) = (0, 0);
    for _ in 0..600 {
        let mut text = damaged(LEG, &mut draws);
        if draws.below(3) == 0 && !text.is_empty() {
            text = damaged(&text, &mut draws);
        }
        match leg(&text).and_then(Description::robot) {
            Ok((robot, _)) => {
                // Numbers of any size are lawful: what comes of them is finite or an error.
                let parts: &Parts = robot.parts();
                let middle =
                    |joint: usize| parts.joints[joint].range.map_or(0.0, |[low, high]| 0.5 * (low + high));
                let x: Vec<f64> = robot.independent_joints().into_iter().map(middle).collect();
                if let Ok(q) = robot.pose_from_independent(&x) {
                    let muscles = Muscles::new(&robot);
                    let mut geometry = Geometry::new(&robot, &muscles);
                    if muscles.evaluate(&q, &mut geometry).is_ok() {
                        assert!(geometry.lengths().iter().all(|length| length.is_finite()));
                    }
                }
                read += 1;
            }
            Err(error) => {
                assert_eq!(error.file, "leg.osim", "{error}");
                assert!((1..=text.lines().count().max(1) + 1).contains(&error.line), "{error}");
                assert!(!error.place.is_empty() && error.problem.len() > 8, "{error}");
                refused += 1;
            }
        }
    }
    assert!(read > 30 && refused > 300, "{read} read, {refused} refused");
}
