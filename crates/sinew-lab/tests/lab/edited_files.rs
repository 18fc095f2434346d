//! Files of machines with random mistakes: whatever they say, the answer is a machine that can be shown,
//! tuned and started, or one error with file and line.

use sinew::Error as Refused;
use sinew::control::arm::{ActuationMode, ArmController, CableStateSource, synthesize};
use sinew::control::supervisor::{Limits, Supervisor};
use sinew::description::{
    DescriptionError, MachineDescription, from_mjcf, from_urdf, machine_from_toml, machine_of,
};
use sinew::twin::arm::{ArmSpecimen, ArmTwin};
use sinew_lab::arm::{calibration_programmes, first_infeasibility, plan_tour};
use sinew_lab::experiment::oracle_models;
use sinew_models::MACHINES;
use std::fmt::Write as _;

/// Edits of one run.
const FEW: u64 = 240;
const MANY: u64 = 10_000;

/// SplitMix64.
struct Draws(u64);

impl Draws {
    fn next(&mut self) -> u64 {
        self.0 = self.0.wrapping_add(0x9e37_79b9_7f4a_7c15);
        let z = (self.0 ^ self.0 >> 30).wrapping_mul(0xbf58_476d_1ce4_e5b9);
        let z = (z ^ z >> 27).wrapping_mul(0x94d0_49bb_1331_11eb);
        z ^ z >> 31
    }

    fn below(&mut self, count: usize) -> usize {
        (self.next() % count.max(1) as u64) as usize
    }

    fn choice<'a>(&mut self, list: &[&'a str]) -> &'a str {
        list[self.below(list.len())]
    }
}

const MJCF: &str = r#"<mujoco model="leg"><compiler angle="radian" autolimits="true"/>
<default><joint damping="0.05" armature="0.01"/></default>
<worldbody>
  <site name="hip_f" pos="0.05 0 0.02"/>
  <site name="hip_b" pos="-0.05 0 0.02"/>
  <body name="thigh" pos="0 0 0">
    <inertial pos="0 0 -0.2" mass="3" diaginertia="0.03 0.03 0.004"/>
    <joint name="hip" type="hinge" axis="0 1 0" range="-0.5 1.1"/>
    <geom name="wheel" type="cylinder" size="0.02 0.02" quat="0.7071 0.7071 0 0" pos="0 0 -0.4" mass="0" contype="0" conaffinity="0"/>
    <site name="thigh_f" pos="0.05 0 -0.2"/>
    <site name="thigh_b" pos="-0.05 0 -0.2"/>
    <site name="wheel_f" pos="0.04 0 -0.4"/>
    <body name="shank" pos="0 0 -0.4">
      <inertial pos="0 0 -0.2" mass="2" diaginertia="0.02 0.02 0.003"/>
      <joint name="knee" type="hinge" axis="0 -1 0" range="0.05 1.9"/>
      <site name="shank_f" pos="0.03 0 -0.15"/>
      <site name="shank_b" pos="-0.03 0 -0.15"/>
      <site name="endpoint" pos="0 0 -0.4"/>
    </body>
  </body>
</worldbody>
<tendon>
  <spatial name="hip_flexor"><site site="hip_f"/><site site="thigh_f"/></spatial>
  <spatial name="hip_extensor"><site site="hip_b"/><site site="thigh_b"/></spatial>
  <spatial name="knee_extensor"><site site="thigh_f"/><geom geom="wheel" sidesite="wheel_f"/><site site="shank_f"/></spatial>
  <spatial name="knee_flexor"><site site="thigh_b"/><site site="shank_b"/></spatial>
  <fixed name="spare"><joint joint="hip" coef="0.02"/><joint joint="knee" coef="0.01"/></fixed>
</tendon>
<actuator>
  <motor name="m1" tendon="hip_flexor" ctrlrange="0 300"/>
</actuator></mujoco>
"#;

const URDF: &str = r#"<?xml version="1.0"?>
<robot name="two">
  <link name="base"/>
  <link name="upper">
    <inertial><origin xyz="0 0 -0.1"/><mass value="1.2"/><inertia ixx="0.01" iyy="0.01" izz="0.002" ixy="0" ixz="0" iyz="0"/></inertial>
  </link>
  <link name="lower">
    <inertial><origin xyz="0 0 -0.1"/><mass value="0.8"/><inertia ixx="0.006" iyy="0.006" izz="0.001" ixy="0" ixz="0" iyz="0"/></inertial>
  </link>
  <joint name="shoulder" type="revolute">
    <parent link="base"/><child link="upper"/><axis xyz="0 1 0"/><limit lower="-1" upper="1" effort="50" velocity="5"/>
    <dynamics damping="0.1" friction="0.05"/>
  </joint>
  <joint name="elbow" type="revolute">
    <parent link="upper"/><child link="lower"/><origin xyz="0 0 -0.25" rpy="0 0 0"/><axis xyz="0 1 0"/>
    <limit lower="0" upper="1.8" effort="30" velocity="5"/>
  </joint>
</robot>
"#;

const MUSCLES: &str = r#"
[[muscle]]
name = "shoulder_up"
joints = [{ joint = "shoulder", coefficient = 0.03 }]
[[muscle]]
name = "shoulder_down"
joints = [{ joint = "shoulder", coefficient = -0.03 }]
[[muscle]]
name = "elbow_up"
joints = [{ joint = "elbow", coefficient = 0.02 }]
[[muscle]]
name = "elbow_down"
joints = [{ joint = "elbow", coefficient = -0.02 }]
"#;

/// A machine file around the body in [`MJCF`], with a value for most keys.
const MACHINE: &str = r#"
body = "leg.xml"
start = { hip = 0.2, knee = 0.6 }
[task]
endpoint = "endpoint"
axes = ["x", "z"]
[[pose]]
name = "bent"
joints = { hip = 0.4, knee = 1.2 }
[redundancy]
weight = { hip = 1.0 }
[every_transmission]
near_length_m = 0.05
sheath_length_m = 0.5
sheath_bend_rad = 3.0
cable = { friction = 0.12, pretension_n = 12.0, compliance_per_n = 2.5e-4 }
load_cell = { noise_n = 0.1 }
delay_s = 0.0
[[transmission]]
muscle = "hip_flexor"
sheath_length_m = 0.7
bend_by_joint = { hip = 0.2 }
drive = "large"
tension_limits_n = [5.0, 250.0]
[[transmission]]
muscle = "knee_flexor"
cable = { friction = 0.1, weakening = { rise = 0.1, speed_m_per_s = 0.003, lag_s = 0.05 } }
motor_encoder_counts = 4096.0
[[drive]]
name = "large"
motor = "maxon_re30_48v"
reducer = "maxon_gp32c_3"
ratio = 86.0
winch = "drum_10mm"
[[joint_encoder]]
joint = "knee"
counts_per_turn = 16384.0
[[travel]]
joint = "knee"
range_rad = [0.1, 1.7]
[payload]
mass_kg = 0.5
[tolerances]
mass = 0.05
[control]
margin = 0.8
[safety]
"#;

/// A machine with every key.
const EVERY_KEY: &str = include_str!("../../../../fuzz/seeds/machine/every_key.toml");

/// One file of a machine, and those beside it.
struct Files {
    name: String,
    text: String,
    beside: Vec<(&'static str, String)>,
}

fn files(draws: &mut Draws) -> Files {
    let none = Vec::new();
    match draws.below(MACHINES.len() + 4) {
        0 => Files { name: "leg.xml".into(), text: MJCF.into(), beside: none },
        1 => Files { name: "two.urdf".into(), text: URDF.into(), beside: vec![("muscles", MUSCLES.into())] },
        2 => Files { name: "leg.toml".into(), text: MACHINE.into(), beside: vec![("leg.xml", MJCF.into())] },
        3 => Files { name: "every_key".into(), text: EVERY_KEY.into(), beside: none },
        k => {
            let (name, text) = MACHINES[k - 4];
            Files { name: name.into(), text: text.into(), beside: none }
        }
    }
}

const NUMBERS: [&str; 22] = [
    "0", "-1", "1", "0.0", "1e308", "-1e308", "1e-308", "1e12", "1e9", "-1e6", "1e6", "1e-9", "1e-6", "nan",
    "inf", "-inf", "1e400", "3.0", "100.0", "25.6", "", "\"x\"",
];

/// Makes one mistake in a text.
fn edit(text: &str, draws: &mut Draws) -> String {
    let lines: Vec<&str> = text.lines().collect();
    let line = draws.below(lines.len());
    let mut lines: Vec<String> = lines.into_iter().map(String::from).collect();
    match draws.below(12) {
        0..=6 => {
            // A number, in the line or in one after it.
            let numbers = |line: &str| -> Vec<(usize, usize)> {
                let mut found = Vec::new();
                let mut start = None;
                let bytes = line.as_bytes();
                for (k, byte) in bytes.iter().chain(b" ").enumerate() {
                    let part = byte.is_ascii_digit() || b".eE+-".contains(byte);
                    let follows = k > 0 && (bytes[k - 1].is_ascii_alphabetic() || bytes[k - 1] == b'_');
                    match start {
                        None if part && !follows && byte.is_ascii_digit() => start = Some(k),
                        Some(begin) if !part => {
                            found.push((begin, k));
                            start = None;
                        }
                        _ => {}
                    }
                }
                found
            };
            let count = lines.len();
            let with = (0..count).map(|k| (line + k) % count).find(|&k| !numbers(&lines[k]).is_empty());
            if let Some(k) = with {
                let places = numbers(&lines[k]);
                let (begin, end) = places[draws.below(places.len())];
                let old: f64 = lines[k][begin..end].parse().unwrap_or(1.0);
                let new = match draws.below(3) {
                    0 => format!("{:e}", old * 10_f64.powi(draws.below(13) as i32 - 6)),
                    _ => draws.choice(&NUMBERS).to_owned(),
                };
                lines[k].replace_range(begin..end, &new);
            }
        }
        7 => {
            lines.remove(line);
        }
        8 => {
            let copy = lines[line].clone();
            lines.insert(draws.below(lines.len()), copy);
        }
        9 => {
            let other = draws.below(lines.len());
            lines.swap(line, other);
        }
        10 => {
            let at = draws.below(lines[line].len() + 1);
            if lines[line].is_char_boundary(at) {
                lines[line]
                    .insert_str(at, draws.choice(&["x", "\"", "]", "[", "<", "=", "_m", "\u{e9}", " ", "'"]));
            }
        }
        _ => {
            // Another name.
            let words: Vec<String> =
                text.split(|c: char| !(c.is_alphanumeric() || c == '_')).map(String::from).collect();
            let [from, to] = [(); 2].map(|()| words[draws.below(words.len())].clone());
            if !from.is_empty() {
                lines[line] = lines[line].replacen(&from, &to, 1);
            }
        }
    }
    lines.join("\n") + "\n"
}

fn read(files: &Files) -> Result<MachineDescription, DescriptionError> {
    let beside = |name: &str| {
        let found = files.beside.iter().find(|(other, _)| *other == name);
        found.map(|(_, text)| text.clone()).ok_or_else(|| "is not there".to_owned())
    };
    if files.name.ends_with(".xml") {
        machine_of(from_mjcf(&files.name, &files.text, &mut |_| Err("is not there".to_owned()))?)
    } else if files.name.ends_with(".urdf") {
        let muscles = beside("muscles").ok();
        let muscles = muscles.as_deref().map(|text| ("two.muscles.toml", text));
        machine_of(from_urdf(&files.name, &files.text, muscles)?)
    } else {
        machine_from_toml(&files.name, &files.text, &mut |file| beside(file.path))
    }
}

/// What `machine show`, `machine tune` and the start of `track` compute.
fn use_it(described: &MachineDescription) -> Result<(), Refused> {
    let machine = described.machine.loaded()?;
    let poses = machine.poses(20)?;
    let laws = machine.laws(12)?;
    machine.laws_at_largest_bend(&laws, &poses)?;
    sinew::control::arm::characterize(&machine, &laws, &poses)?;
    let design = ArmSpecimen::nominal(&machine)?;
    let models = oracle_models(&design);
    synthesize(&machine, &models, &poses)?;
    let physics = |error: sinew_lab::Error| match error {
        sinew_lab::Error::Physics(refused) => Ok(refused),
        other => Err(other),
    };
    // A motion that the machine cannot do is refused in words of its own.
    let trajectory =
        match plan_tour(&machine, None, |trajectory| first_infeasibility(&machine, trajectory, 1)) {
            Ok(trajectory) => trajectory,
            Err(error) => return physics(error).map_or(Ok(()), Err),
        };
    if let Err(Ok(refused)) = calibration_programmes(&machine, &design).map_err(physics) {
        return Err(refused);
    }
    let built = ArmSpecimen::sampled_around(&design, &machine, 7)?;
    let (gains, _) = synthesize(&machine, &oracle_models(&built), &poses)?;
    let mode = ActuationMode::WinchSpeed(CableStateSource::Observer);
    let limits = Limits::from_machine(&machine, &gains)?;
    let tensions: Vec<f64> = gains.tension_limits().iter().map(|[least, _]| *least).collect();
    let controller = ArmController::new(&machine.robot, &oracle_models(&built), gains, mode)?;
    Supervisor::new(controller.with_sheath_bends(&built.bends)?, limits)?;
    let mut start = sinew::trajectory::Reference::new(trajectory.joints());
    trajectory.sample(0.0, &mut start)?;
    ArmTwin::new(&built, &start.q, &tensions, 1).map(drop)
}

/// Why an error is none that a user could act on; none where it is one.
fn flaw(error: &DescriptionError, files: &Files, in_machine: bool) -> Option<String> {
    let known = files.beside.iter().map(|(name, text)| (*name, text));
    let texts: Vec<(&str, &String)> = known.chain([(files.name.as_str(), &files.text)]).collect();
    let named = error.file.trim_start_matches("./");
    let lines = texts
        .iter()
        .filter(|(name, _)| named.ends_with(name) || named == "two.muscles.toml" && *name == "muscles")
        .map(|(_, text)| text.lines().count() + 1)
        .max();
    let Some(lines) = lines else { return Some(format!("names the file `{}`", error.file)) };
    if error.line == 0 || error.line > lines {
        return Some(format!("names line {} of {lines}", error.line));
    }
    if error.place.is_empty() || error.problem.is_empty() {
        return Some("says nothing".to_owned());
    }
    // Parts are named, not numbered, and numbers are not those of the inside.
    let inside =
        ["lengths[", "moment_arms[", "muscle number", "joint number", "of a node must be at most 0.8: use"];
    let found = inside.iter().find(|words| error.to_string().contains(**words));
    let unnamed = in_machine && error.place == "machine" && error.problem.contains("NaN");
    found.map(|words| format!("says `{words}`")).or_else(|| unnamed.then(|| "names no part".to_owned()))
}

#[test]
fn a_file_with_mistakes_is_a_machine_or_one_error_with_file_line_and_part() {
    let edits = if std::env::var_os("SINEW_LONG").is_some() { MANY } else { FEW };
    let edits = std::env::var("SINEW_EDITS").ok().and_then(|text| text.parse().ok()).unwrap_or(edits);
    let first: u64 = std::env::var("SINEW_SEED").ok().and_then(|text| text.parse().ok()).unwrap_or(1);
    let (mut flaws, mut counts) = (String::new(), [0_u64; 3]);
    for seed in first..first + edits {
        let mut draws = Draws(seed);
        let mut files = files(&mut draws);
        for _ in 0..=draws.below(3) {
            match draws.below(1 + files.beside.len()) {
                0 => files.text = edit(&files.text, &mut draws),
                k => files.beside[k - 1].1 = edit(&files.beside[k - 1].1, &mut draws),
            }
        }
        let found = std::panic::catch_unwind(|| match read(&files) {
            Err(error) => (1, Some(error)),
            Ok(described) => match use_it(&described) {
                Ok(()) => (0, None),
                Err(refused) => (2, Some(described.places.error(refused))),
            },
        });
        match found {
            Err(_) => _ = writeln!(flaws, "seed {seed}, {}: panicked", files.name),
            Ok((kind, error)) => {
                counts[kind] += 1;
                if let Some(error) = error
                    && let Some(flaw) = flaw(&error, &files, kind == 2)
                {
                    _ = writeln!(flaws, "seed {seed}, {}: {flaw}: {error}", files.name);
                }
            }
        }
    }
    eprintln!(
        "{edits} edits: {} machines, {} refused when read, {} when used",
        counts[0], counts[1], counts[2]
    );
    assert!(flaws.is_empty(), "{flaws}");
    assert!(counts[0] > edits / 20 && counts[1] > edits / 5, "{counts:?}");
}
