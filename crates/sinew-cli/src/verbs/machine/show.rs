//! `sinew machine show`.

use super::design_checks::{DesignChecks, LockedWinches, Underactuated};
use super::names::print_warnings;
use crate::answer::{Answer, Content};
use crate::arguments::{General, MachineShowArguments};
use crate::error::Error;
use crate::output::{one_line, refuse_overwrite, write_all};
use crate::table::{number, table};
use crate::verbs::machine_source::load_machine;
use serde::Serialize;
use sinew::body::JointKind;
use sinew::control::arm::characterize;
use sinew::description::MachineDescription;
use sinew::description::machine::{Setting, Value, ValueSource};
use sinew::machine::Machine;
use sinew_report::colours::STANDALONE;
use sinew_report::machine_picture::draw;

/// Poses over which dead bands are averaged and moment arms are compared.
const POSES: usize = 60;
/// Cells of a cable.
const CELLS: usize = 12;

pub(super) fn run(arguments: &MachineShowArguments, general: &General) -> Result<Answer, Error> {
    let inputs = [&arguments.machine].into_iter().chain(&arguments.files.muscles);
    refuse_overwrite(inputs, arguments.picture.as_slice(), general.no_clobber)?;
    let (loaded, _) = load_machine(
        &arguments.machine,
        arguments.files.muscles.as_deref(),
        arguments.files.root.dir.as_deref(),
    )?;
    print_warnings(&loaded.warnings);
    show(&loaded, arguments, general).map_err(|error| error.at(&loaded.places))
}

fn show(
    loaded: &MachineDescription,
    arguments: &MachineShowArguments,
    general: &General,
) -> Result<Answer, Error> {
    let machine = loaded.machine.loaded()?;
    let checks = DesignChecks::new(&machine, &machine.laws(CELLS)?, &machine.poses(POSES)?)?;
    checks.print_warnings();
    let locked_winches = checks.text(&machine);
    let shown = Shown::new(loaded, checks)?;
    let written = match &arguments.picture {
        Some(path) => write_all(&[(path.clone(), draw(&loaded.machine, &STANDALONE)?.as_bytes())])?,
        None => Vec::new(),
    };
    let content = if general.json {
        Content::json(&shown)?
    } else {
        Content::Text(text(&shown, &locked_winches, &loaded.machine) + "\n")
    };
    Ok(Answer::done(content, written))
}

/// What is printed with `--json`.
#[derive(Debug, Serialize)]
struct Shown {
    name: String,
    moving_mass_kg: f64,
    joints: Vec<Joint>,
    muscles: Vec<Muscle>,
    locked_winches: Vec<LockedWinches>,
    #[serde(skip_serializing_if = "Option::is_none")]
    underactuated: Option<Underactuated>,
    settings: Vec<Row>,
    warnings: Vec<String>,
}

#[derive(Debug, Serialize)]
struct Joint {
    name: String,
    kind: &'static str,
    unit: &'static str,
    range: Option<[f64; 2]>,
    start: f64,
    encoder_resolution: Option<f64>,
    dead_band: f64,
}

#[derive(Debug, Serialize)]
struct Muscle {
    name: String,
    largest_moment_arm_m: f64,
    friction_angle: f64,
    dead_band_m: f64,
    tension_limits_n: [f64; 2],
    drive_mass_at_cable_kg: f64,
    drive_speed_m_per_s: f64,
}

#[derive(Debug, Serialize)]
struct Row {
    table: String,
    key: String,
    value: serde_json::Value,
    unit: &'static str,
    source: &'static str,
    line: Option<usize>,
}

impl Shown {
    fn new(loaded: &MachineDescription, checks: DesignChecks) -> Result<Self, Error> {
        let machine = &loaded.machine;
        let laws = machine.laws(CELLS)?;
        let (limits, found) = characterize(machine, &laws, &machine.poses(POSES)?)?;
        let parts = machine.robot.parts();
        let joints = machine.robot.independent_joints().into_iter().enumerate().map(|(place, index)| {
            let joint = &parts.joints[index];
            let slide = joint.kind == JointKind::Slide;
            Joint {
                name: joint.name.clone(),
                kind: if slide { "slide" } else { "hinge" },
                unit: joint.kind.unit(),
                range: joint.range,
                start: machine.start[place],
                encoder_resolution: machine.encoders[place].map(|encoder| encoder.resolution),
                dead_band: found.joints[place].dead_band,
            }
        });
        let muscles = parts.tendons.iter().enumerate().map(|(index, tendon)| {
            let (design, found) = (&machine.muscles[index], &found.muscles[index]);
            Muscle {
                name: tendon.name.clone(),
                largest_moment_arm_m: found.arm,
                friction_angle: found.friction_angle,
                dead_band_m: found.dead_band,
                tension_limits_n: limits[index],
                drive_mass_at_cable_kg: design.drive.mass_at_cable(),
                drive_speed_m_per_s: design.drive.speed_at(design.drive.working_tension()),
            }
        });
        Ok(Self {
            name: parts.name.clone(),
            moving_mass_kg: machine.robot.moving_mass(),
            joints: joints.collect(),
            muscles: muscles.collect(),
            settings: loaded.settings.iter().map(|setting| Row::new(setting, machine)).collect(),
            locked_winches: checks.locked_winches,
            underactuated: checks.underactuated,
            warnings: loaded.warnings.iter().map(ToString::to_string).chain(checks.warnings).collect(),
        })
    }
}

impl Row {
    fn new(setting: &Setting, machine: &Machine) -> Self {
        let value = match &setting.value {
            Value::Number(number) => (*number).into(),
            Value::Numbers(numbers) => numbers.clone().into(),
            Value::Text(text) => text.clone().into(),
            Value::Texts(texts) => texts.clone().into(),
            Value::None => serde_json::Value::Null,
        };
        let (source, line) = match setting.source {
            ValueSource::File { line } => ("file", Some(line)),
            ValueSource::Body => ("body", None),
            ValueSource::Model => ("model", None),
            ValueSource::Catalogue => ("catalogue", None),
            ValueSource::Default => ("default", None),
        };
        let (table, key) = (setting.table.clone(), setting.key.clone());
        Self { unit: unit(&key, machine), table, key, value, source, line }
    }

    fn shown(&self) -> String {
        let number = |value: &serde_json::Value| number(value.as_f64());
        match &self.value {
            serde_json::Value::Null => "none".to_owned(),
            serde_json::Value::String(text) => one_line(text),
            serde_json::Value::Array(values) => {
                let part = |value: &serde_json::Value| value.as_str().map_or_else(|| number(value), one_line);
                values.iter().map(part).collect::<Vec<_>>().join(", ")
            }
            value => number(value),
        }
    }

    fn origin(&self) -> String {
        self.line.map_or_else(|| self.source.to_owned(), |line| format!("line {line}"))
    }
}

/// Units by the ends of keys; longer ends first.
const UNITS: [(&str, &str); 24] = [
    ("_nm_s_per_rad", "Nm s/rad"),
    ("_nm_per_a", "Nm/A"),
    ("_rad_per_s", "rad/s"),
    ("_m_per_s2", "m/s^2"),
    ("_m_per_s", "m/s"),
    ("_k_per_w", "K/W"),
    ("_j_per_k", "J/K"),
    ("_n_per_m", "N/m"),
    ("_n_s_per_m", "N s/m"),
    ("_s_per_m", "s/m"),
    ("_kg_m2", "kg m^2"),
    ("_per_n", "1/N"),
    ("_per_s", "1/s"),
    ("_rad", "rad"),
    ("_ohm", "ohm"),
    ("_kg", "kg"),
    ("_nm", "Nm"),
    ("_v", "V"),
    ("_a", "A"),
    ("_h", "H"),
    ("_c", "C"),
    ("_m", "m"),
    ("_n", "N"),
    ("_s", "s"),
];

/// The unit that a key names, or that the joint has which it names.
fn unit(key: &str, machine: &Machine) -> &'static str {
    let of_joint = |name: &str| {
        let joint = machine.robot.joint(name)?;
        Some(machine.robot.parts().joints[joint].kind.unit())
    };
    match key.split_once('.') {
        Some(("start" | "rest" | "swing" | "joints", joint)) => of_joint(joint).unwrap_or("rad"),
        Some(("weight", _)) => "",
        Some(("bend_by_joint", joint)) => match of_joint(joint) {
            Some("m") => "rad/m",
            _ => "rad/rad",
        },
        _ => UNITS.iter().find(|(end, _)| key.ends_with(end)).map_or("", |(_, unit)| unit),
    }
}

fn text(shown: &Shown, locked_winches: &str, machine: &Machine) -> String {
    let mut text = format!(
        "{}: {} independent joints, {} muscles, {} kg moving\n\n",
        one_line(&shown.name),
        shown.joints.len(),
        shown.muscles.len(),
        number(Some(shown.moving_mass_kg))
    );
    text += &joints(&shown.joints);
    text.push('\n');
    text += &muscles(&shown.muscles);
    text.push('\n');
    text += locked_winches;
    text += "\n`default` marks what neither the machine file nor the body says.\n\n";
    text += &settings(&shown.settings, machine.muscles.len());
    text
}

fn joints(joints: &[Joint]) -> String {
    let row = |joint: &Joint| {
        let [low, high] = joint.range.map_or([None; 2], |range| range.map(Some));
        let mut cells = vec![one_line(&joint.name), joint.kind.to_owned(), joint.unit.to_owned()];
        let numbers = [low, high, Some(joint.start), joint.encoder_resolution, Some(joint.dead_band)];
        cells.extend(numbers.map(number));
        cells
    };
    let head = ["joint", "kind", "unit", "from", "to", "start", "encoder count", "dead band"];
    table(&head, &joints.iter().map(row).collect::<Vec<_>>(), 3)
}

fn muscles(muscles: &[Muscle]) -> String {
    let row = |muscle: &Muscle| {
        let [least, most] = muscle.tension_limits_n;
        let numbers = [
            1e3 * muscle.largest_moment_arm_m,
            muscle.friction_angle,
            1e3 * muscle.dead_band_m,
            least,
            most,
            muscle.drive_mass_at_cable_kg,
            muscle.drive_speed_m_per_s,
        ];
        [one_line(&muscle.name)].into_iter().chain(numbers.map(|value| number(Some(value)))).collect()
    };
    let head = [
        "muscle",
        "arm mm",
        "friction angle",
        "dead band mm",
        "anchor N from",
        "to",
        "drive kg at cable",
        "drive m/s",
    ];
    table(&head, &muscles.iter().map(row).collect::<Vec<_>>(), 1)
}

/// All values; those that all transmissions have alike stand once.
fn settings(settings: &[Row], muscles: usize) -> String {
    const TRANSMISSION: &str = "[[transmission]]";
    let is_transmission = |row: &&Row| row.table.starts_with(TRANSMISSION);
    let alike = |row: &Row| {
        let same =
            |other: &&Row| (&other.key, &other.value, other.source) == (&row.key, &row.value, row.source);
        settings.iter().filter(is_transmission).filter(same).count() == muscles && muscles > 1
    };
    let mut rows = Vec::new();
    let mut push = |table: &str, row: &Row| {
        rows.push(vec![one_line(table), one_line(&row.key), row.shown(), row.unit.to_owned(), row.origin()]);
    };
    let first = settings.iter().find(is_transmission).map(|row| &row.table);
    for row in settings {
        let of_all = is_transmission(&row) && alike(row);
        if of_all && Some(&row.table) == first {
            push(&format!("{TRANSMISSION} all {muscles}"), row);
        } else if !of_all {
            push(&row.table, row);
        }
    }
    table(&["table", "key", "value", "unit", "origin"], &rows, 5)
}
