//! The text of a new machine file.

use super::choice::{Choice, ChosenDrive};
use sinew::body::JointKind;
use sinew::control::demand::SizingMotion;
use sinew::machine::{Machine, Task};
use std::fmt::Write as _;

/// How the file says what its body is.
pub(super) enum Body {
    /// Another file, and for URDF that of its muscles: paths relative to the new file.
    File { body: String, muscles: Option<String> },
    /// The tables of a robot file.
    Tables(String),
}

/// The file's text.
pub(super) fn text(choice: &Choice, body: &Body, motion: &SizingMotion) -> String {
    let mut out = head(choice);
    match body {
        Body::File { body, muscles } => {
            let _ = writeln!(out, "body = {}", quoted(body));
            if let Some(muscles) = muscles {
                let _ = writeln!(out, "muscles = {}", quoted(muscles));
            }
        }
        // Outermost keys stand before the first table.
        Body::Tables(_) => {}
    }
    start(&mut out, choice);
    if let Body::Tables(tables) = body {
        out.push('\n');
        out += tables;
    }
    task(&mut out, choice);
    joints(&mut out, choice);
    every_transmission(&mut out, choice);
    for drive in &choice.drives {
        self::drive(&mut out, choice, drive, motion);
    }
    transmissions(&mut out, choice);
    rest(&mut out, &choice.machine);
    out
}

/// Tables that are defaults as a whole.
fn rest(out: &mut String, machine: &Machine) {
    let (tolerances, rules) = (&machine.tolerances, &machine.rules);
    let _ = write!(
        out,
        "
# Mass carried at the end point.
# [payload]
# mass_kg = 0.0

# What a workshop leaves: bounds of the differences between the machine and this file.
# [tolerances]
# mass = {:?}
# attachment_m = {:?}
# gain = {:?}
# zero_rad = {:?}

# Constants of the rules by which the controller's gains follow from this file.
# [control]
# bandwidth_rad_per_s = {:?}
# margin = {:?}
",
        tolerances.mass,
        machine.attachment_tolerance(),
        tolerances.gain,
        tolerances.zero,
        rules.bandwidth,
        rules.margin
    );
}

fn head(choice: &Choice) -> String {
    let parts = choice.machine.robot.parts();
    let name: String = parts.name.chars().filter(|c| !c.is_control()).collect();
    format!(
        "# A machine on cables: {name}, {} joints, {} muscles; written by `sinew machine new`.\n\
         # SI units, in the names of keys. Everything but the body has a default; `sinew machine show \
         FILE` prints\n\
         # them all. Lines behind a `#` show defaults.\n\n",
        choice.machine.encoders.len(),
        parts.tendons.len()
    )
}

/// Names and values of the independent joints.
fn by_joint(choice: &Choice, values: &[f64]) -> String {
    let parts = choice.machine.robot.parts();
    let joints = choice.machine.robot.independent_joints();
    let each = joints.into_iter().zip(values);
    let each = each.map(|(joint, value)| format!("{} = {value:?}", key(&parts.joints[joint].name)));
    format!("{{ {} }}", each.collect::<Vec<_>>().join(", "))
}

fn start(out: &mut String, choice: &Choice) {
    *out += "\n# Where motions start, rad or m.\n";
    let _ = writeln!(out, "start = {}", by_joint(choice, &choice.machine.start));
}

fn task(out: &mut String, choice: &Choice) {
    let machine = &choice.machine;
    *out += "\n# What is tracked: coordinates of a site, or the joints.\n[task]\n";
    match machine.task {
        Task::EndPoint { site, axes } => {
            let site = quoted(&machine.robot.parts().sites[site].name);
            let axes: Vec<&str> =
                ["x", "y", "z"].into_iter().zip(axes).filter_map(|(axis, is)| is.then_some(axis)).collect();
            let _ = writeln!(out, "endpoint = {site}\naxes = {axes:?}");
        }
        Task::Joints => {
            *out += "space = \"joints\"\n";
            out.push_str(&possible_end_point(machine));
        }
    }
    *out += "\n# The pose that is preferred where the task leaves joints free.\n# [redundancy]\n";
    let _ = writeln!(out, "# rest = {}", by_joint(choice, &machine.redundancy.rest));
    let _ = writeln!(out, "# weight = {}", by_joint(choice, &machine.redundancy.weight));
}

/// How the file would name a point that carries a payload: the last site of the last body that has one.
fn possible_end_point(machine: &Machine) -> String {
    let sites = machine.robot.parts().sites.iter().rev();
    match sites.max_by_key(|site| site.body) {
        Some(site) if machine.payload_site().is_none() => {
            format!(
                "# In its place, a site of the body that carries payloads and is tracked.\n# endpoint = {}\n",
                quoted(&site.name)
            )
        }
        _ => String::new(),
    }
}

fn joints(out: &mut String, choice: &Choice) {
    let parts = choice.machine.robot.parts();
    let kinds = choice.machine.robot.independent_joints().into_iter().map(|joint| parts.joints[joint].kind);
    let kinds: Vec<JointKind> = kinds.collect();
    *out += "\n# Encoders of the joints: 14 bits, 10 um on slides; `none = true` for none.\n# \
        [every_joint_encoder]\n";
    if kinds.contains(&JointKind::Hinge) {
        *out += "# counts_per_turn = 16384\n";
    }
    if kinds.contains(&JointKind::Slide) {
        *out += "# resolution_m = 1e-5\n";
    }
}

fn every_transmission(out: &mut String, choice: &Choice) {
    let parts = choice.machine.robot.parts();
    *out += "\n# Sheath, cable and sensors of all muscles; [[transmission]] changes them for one muscle.\n";
    *out += "[every_transmission]\nnear_length_m = 0.05\n";
    let described = parts.tendons.iter().filter(|tendon| tendon.sheath.is_some()).count();
    if described < parts.tendons.len() {
        *out += "# Of the muscles whose sheath the body does not describe: assumed.\n";
        *out += "sheath_length_m = 0.5\nsheath_bend_rad = 1.57\n";
    }
    *out += "# Change of the bend with joints that a sheath passes, rad per rad or m, from the start on: \
        joint = slope.\n";
    *out += "# bend_by_joint = {}\n";
    let Some((scaling, _)) = &choice.scaling else {
        *out += "# The bench's cable; friction and compliance decide most.\n";
        *out += "# cable = { friction = 0.156, pretension_n = 15.5, compliance_per_n = 2.56e-4 }\n";
        return;
    };
    let (cable, cell, cord) = (scaling.cable(), scaling.load_cell(), &scaling.cord);
    let [taut, most] = scaling.common.map(rounded);
    let _ = write!(
        out,
        "# The body works with {:.3} N: its weight and {:.3} N at its end, in the middle of the joints' \
            ranges. Limits of the\n\
         # tension at the anchors follow from that, and the thinnest cord that breaks at five times the \
         largest at the drive.\n\
         tension_limits_n = [{taut:?}, {most:?}]\n",
        scaling.working.tension, scaling.working.tip_force
    );
    let _ = write!(
        out,
        "\n# {}: {:.3} mm, {:?} N at break; {}.\n[every_transmission.cable]\nfriction = {:?}\nefficiency = \
            {:?}\n\
         drag_n_s_per_m = {:?}\ndrag_fade_n = {:?}\npretension_n = {:?}\ncompliance_per_n = {:?}\n",
        cord.name,
        1e3 * cord.parameters.diameter,
        cord.parameters.breaking_load,
        cord.source,
        cable.friction,
        cable.efficiency,
        cable.drag,
        rounded(cable.drag_fade),
        rounded(cable.pretension),
        rounded(cable.compliance)
    );
    let _ = write!(
        out,
        "\n[every_transmission.load_cell]\nnoise_n = {:?}\nresolution_n = {:?}\nrange_n = {:?}\n",
        rounded(cell.noise),
        rounded(cell.resolution),
        rounded(cell.range)
    );
}

/// Three digits: what is chosen is not known better.
fn rounded(value: f64) -> f64 {
    format!("{value:.2e}").parse().unwrap_or(value)
}

fn drive(out: &mut String, choice: &Choice, drive: &ChosenDrive, motion: &SizingMotion) {
    let mine = || {
        let of = choice.drive_of.iter().enumerate();
        of.filter(|(_, index)| choice.drives[**index].name == drive.name).map(|(muscle, _)| muscle)
    };
    let most = |number: fn(&sinew::drive::sizing::Requirement) -> f64| {
        mine().map(|muscle| number(&choice.required[muscle])).fold(0.0, f64::max)
    };
    let _ = write!(
        out,
        "\n# For up to {:.3} N, {:.3} m/s and {:.2} m/s^2: {} % of every range in {:?} s, and a quarter to spare.\n",
        most(|required| required.tension),
        most(|required| required.speed),
        most(|required| required.acceleration),
        (100.0 * motion.fraction).round(),
        motion.period
    );
    let used = mine().map(|muscle| choice.used[muscle]).fold(0.0, f64::max);
    if used > 1.0 {
        let _ = writeln!(
            out,
            "# TOO WEAK by a factor of {used:.2}: the catalogue has none that is strong enough."
        );
    }
    let _ = write!(
        out,
        "[[drive]]\nname = {}\nmotor = {}\nreducer = {}\nratio = {:?}\n",
        quoted(&drive.name),
        quoted(&drive.motor),
        quoted(&drive.reducer),
        drive.ratio
    );
    match &drive.winch {
        Some(winch) => {
            let _ = writeln!(out, "winch = {}", quoted(winch));
        }
        None => {
            let Some((scaling, winch)) = &choice.scaling else { return };
            let [least, most] = scaling.drive_limits().map(rounded);
            let _ = writeln!(
                out,
                "winch = {{ radius_m = {:?}, lead_m = {:?}, cable_diameter_m = {:?}, turns_per_layer = \
                    {:?}, layers = {} }}",
                rounded(winch.radius),
                rounded(winch.lead),
                winch.cable_diameter,
                winch.turns_per_layer,
                winch.layers
            );
            let _ = writeln!(out, "max_tension_n = {most:?}\nmin_tension_n = {least:?}");
        }
    }
}

fn transmissions(out: &mut String, choice: &Choice) {
    let tendons = &choice.machine.robot.parts().tendons;
    for (index, tendon) in tendons.iter().enumerate() {
        let drive = &choice.drives[choice.drive_of[index]].name;
        let _ =
            write!(out, "\n[[transmission]]\nmuscle = {}\ndrive = {}\n", quoted(&tendon.name), quoted(drive));
        if let Some((scaling, _)) = &choice.scaling {
            let [taut, most] = scaling.tension[index];
            let [common, largest] = scaling.common;
            if most < largest {
                *out += "# What its actuator in the body's description allows.\n";
                let _ = writeln!(out, "tension_limits_n = [{:?}, {most:?}]", rounded(taut));
            } else if taut < common {
                *out +=
                    "# Taut by springs or weight alone: a tenth of the tension that it works with itself.\n";
                let _ = writeln!(out, "tension_limits_n = [{:?}, {:?}]", rounded(taut), rounded(most));
            }
        }
        if let Some(sheath) = &tendon.sheath {
            let _ = writeln!(out, "# sheath_length_m = {:?}", sheath.length);
            let _ = writeln!(out, "# sheath_bend_rad = {:?}", sheath.bend);
        }
    }
}

/// A TOML string.
fn quoted(text: &str) -> String {
    let mut out = String::from("\"");
    for c in text.chars() {
        match c {
            '"' => out.push_str("\\\""),
            '\\' => out.push_str("\\\\"),
            c if c.is_control() => {
                let _ = write!(out, "\\u{:04X}", u32::from(c));
            }
            c => out.push(c),
        }
    }
    out + "\""
}

/// A TOML key: quoted where it is no bare one.
fn key(name: &str) -> String {
    let bare = |c: char| c.is_ascii_alphanumeric() || c == '_' || c == '-';
    if !name.is_empty() && name.chars().all(bare) { name.to_owned() } else { quoted(name) }
}
