//! `sinew machine new`.

use super::choice::{self, Choice};
use super::draft::{self, Body};
use super::names::print_warnings;
use crate::answer::{Answer, Content, Outcome};
use crate::arguments::{General, MachineNewArguments, Routing};
use crate::error::Error;
use crate::output::{Written, one_line, refuse_overwrite, write_all};
use crate::progress::Progress;
use crate::table::{number, percent, table};
use crate::verbs::machine_source::load_machine;
use serde::Serialize;
use sinew::body::Poses;
use sinew::control::demand::{MissingTorque, SizingMotion};
use sinew::description::{Description, machine_of, to_toml};
use sinew::machine::{Machine, Task};
use sinew::muscle::{MuscleDynamics, PulleyRouting, with_pulleys};
use sinew::twin::arm::ArmSpecimen;
use sinew_lab::machine_file::{Source, load_robot, machine_in, source_of};
use std::path::{Component, Path, PathBuf};

pub(super) fn run(arguments: &MachineNewArguments, general: &General) -> Result<Answer, Error> {
    let (body, out) = (&arguments.body, &arguments.out);
    let inputs = [body].into_iter().chain(&arguments.files.muscles);
    refuse_overwrite(inputs, std::slice::from_ref(out), general.no_clobber)?;
    if out.exists() && !arguments.force {
        return Err(Error::Exists { file: out.clone(), remedy: "--force" });
    }
    if out.extension().is_none_or(|extension| !extension.eq_ignore_ascii_case("toml")) {
        return Err(Error::MachineFormat { file: out.clone() });
    }
    let progress = Progress::new();
    progress.show("reading the body", 0.0);
    let source = source_of(body, arguments.files.muscles.as_deref(), arguments.files.root.dir.as_deref())?;
    let mut machine = of_body(body, &source, arguments)?;
    machine.task = movable(&machine)?;
    if source == Source::Machine {
        keep_task(&mut machine, body, arguments)?;
    }
    let motion = SizingMotion { period: arguments.period, fraction: arguments.fraction };
    progress.show("choosing cables and drives", 0.1);
    let choice = choice::drives(&machine, &motion, arguments.tip_force, arguments.drives.as_deref())?;
    let body = match source {
        Source::Robot { .. } if arguments.pulleys.is_some() => Body::Tables(to_toml(machine.robot.parts())),
        Source::Robot { muscles } => Body::File {
            body: relative(body, out)?,
            muscles: muscles.map(|muscles| relative(&muscles, out)).transpose()?,
        },
        Source::Machine => Body::Tables(to_toml(machine.robot.parts())),
    };
    let text = draft::text(&choice, &body, &motion);
    progress.show("checking the machine", 0.8);
    // What is written runs: it is read as any machine file.
    let written = machine_in(out, &text, arguments.files.root.dir.as_deref())?;
    ArmSpecimen::nominal(&written.machine).map_err(|error| written.places.error(error))?;
    drop(progress);
    let written = write_all(&[(out.clone(), text.as_bytes())])?;
    report(&choice, out, general.json, written)
}

/// The machine of defaults around a body; of a machine file the body alone.
fn of_body(body: &Path, source: &Source, arguments: &MachineNewArguments) -> Result<Machine, Error> {
    let (muscles, root) = (arguments.files.muscles.as_deref(), arguments.files.root.dir.as_deref());
    let described = match (source, arguments.pulleys) {
        (Source::Robot { .. }, None) => load_machine(body, muscles, root)?.0,
        (_, pulleys) => {
            let loaded = load_robot(body, muscles, root)?;
            print_warnings(&loaded.warnings);
            let routing = match arguments.routing {
                Routing::OneMore => PulleyRouting::OneMore,
                Routing::Two => PulleyRouting::Two,
            };
            let routed = pulleys.map(|radius| with_pulleys(&loaded.robot, radius, routing)).transpose()?;
            machine_of(Description::from_robot(
                routed.as_ref().unwrap_or(&loaded.robot),
                &body.display().to_string(),
            ))?
        }
    };
    print_warnings(&described.warnings);
    Ok(described.machine)
}

/// Task and pose at the start of the machine file whose body is copied.
fn keep_task(machine: &mut Machine, file: &Path, arguments: &MachineNewArguments) -> Result<(), Error> {
    let (given, _) = load_machine(file, None, arguments.files.root.dir.as_deref())?;
    let given = given.machine;
    machine.start = given.start;
    let place = |site: usize| {
        let name = &given.robot.parts().sites[site].name;
        machine.robot.parts().sites.iter().position(|site| site.name == *name)
    };
    machine.task = match given.task {
        Task::EndPoint { site, axes } => {
            place(site).map_or(machine.task, |site| Task::EndPoint { site, axes })
        }
        Task::Joints => Task::Joints,
    };
    Ok(())
}

/// The task restricted to the coordinates that the end point can change; the joints, where these are more
/// than the joints.
fn movable(machine: &Machine) -> Result<Task, Error> {
    let Task::EndPoint { site, .. } = machine.task else { return Ok(machine.task) };
    let (mut low, mut high) = ([f64::INFINITY; 3], [f64::NEG_INFINITY; 3]);
    let mut dynamics = MuscleDynamics::new(&machine.robot)?;
    let mut poses = Poses::new(&machine.robot);
    for pose in machine.poses(POSES)? {
        dynamics.evaluate(&pose)?;
        machine.robot.forward_kinematics(dynamics.coordinates(), &mut poses)?;
        let place = machine.robot.site_pose(&poses, site).origin;
        low = std::array::from_fn(|k| low[k].min(place[k]));
        high = std::array::from_fn(|k| high[k].max(place[k]));
    }
    let span: [f64; 3] = std::array::from_fn(|k| high[k] - low[k]);
    let most = span.into_iter().fold(0.0, f64::max);
    let axes = span.map(|span| span > MIN_SPAN * most);
    let count = axes.iter().filter(|moves| **moves).count();
    Ok(if (1..=machine.encoders.len()).contains(&count) {
        Task::EndPoint { site, axes }
    } else {
        Task::Joints
    })
}

/// Poses over which the end point's coordinates are compared, and the smallest of their spans over the
/// largest.
const POSES: usize = 60;
const MIN_SPAN: f64 = 0.01;

/// What is printed with `--json`.
#[derive(Debug, Serialize)]
struct NewMachine<'a> {
    file: String,
    /// Of the catalogue; none for the default cable.
    cord: Option<&'a str>,
    /// With which the body works; none for the default cable.
    working_tension_n: Option<f64>,
    unreachable_fraction: f64,
    /// The part of it in which smaller tensions would do.
    overpowered_fraction: f64,
    /// Tendons of the body that have no drive.
    springs: Vec<&'a str>,
    muscles: Vec<Muscle<'a>>,
}

#[derive(Debug, Serialize)]
struct Muscle<'a> {
    muscle: &'a str,
    drive: &'a str,
    motor: &'a str,
    reducer: &'a str,
    ratio: f64,
    tension_n: f64,
    speed_m_per_s: f64,
    acceleration_m_per_s2: f64,
    stroke_m: f64,
    used: f64,
}

fn report(choice: &Choice, out: &Path, json: bool, written: Vec<Written>) -> Result<Answer, Error> {
    let parts = choice.machine.robot.parts();
    let muscles = parts.tendons.iter().enumerate().map(|(index, tendon)| {
        let (drive, required) = (&choice.drives[choice.drive_of[index]], &choice.required[index]);
        Muscle {
            muscle: &tendon.name,
            drive: &drive.name,
            motor: &drive.motor,
            reducer: &drive.reducer,
            ratio: drive.ratio,
            tension_n: required.tension,
            speed_m_per_s: required.speed,
            acceleration_m_per_s2: required.acceleration,
            stroke_m: required.stroke,
            used: choice.used[index],
        }
    });
    let demands = &choice.demands;
    #[expect(clippy::cast_precision_loss, reason = "a few hundred samples")]
    let [unreachable_fraction, overpowered_fraction] =
        [demands.unreachable, demands.overpowered].map(|count| count as f64 / demands.samples as f64);
    let answer = NewMachine {
        file: out.display().to_string(),
        cord: choice.scaling.as_ref().map(|(scaling, _)| scaling.cord.name.as_str()),
        working_tension_n: choice.scaling.as_ref().map(|(scaling, _)| scaling.working.tension),
        unreachable_fraction,
        overpowered_fraction,
        springs: parts.springs.iter().map(|spring| spring.name.as_str()).collect(),
        muscles: muscles.collect(),
    };
    let strong = choice.used.iter().all(|used| *used <= 1.0) && demands.unreachable == 0;
    let outcome = Outcome::new(strong);
    if json {
        return Ok(Answer { outcome, content: Content::json(&answer)?, written });
    }
    let mut text = summary(&answer);
    if !answer.springs.is_empty() {
        let springs: Vec<String> =
            answer.springs.iter().map(|name| format!("`{}`", one_line(name))).collect();
        text += &format!("\nSprings, which have no drive: {}.\n", springs.join(", "));
    }
    text += &too_weak(choice);
    if let Some(missing) = &demands.missing {
        text += &unreachable_text(choice, unreachable_fraction, missing);
    }
    text.push('\n');
    Ok(Answer { outcome, content: Content::Text(text), written })
}

/// The muscles for which the catalogue has no drive, and what helps; nothing where there are none.
fn too_weak(choice: &Choice) -> String {
    let parts = choice.machine.robot.parts();
    let used = || parts.tendons.iter().zip(&choice.used).filter(|(_, used)| **used > 1.0);
    if used().next().is_none() {
        return String::new();
    }
    let names: Vec<String> = used().map(|(tendon, _)| format!("`{}`", one_line(&tendon.name))).collect();
    let mut text = format!(
        "\nToo weak: no motor of the catalogue is strong enough for {}; the strongest is written. A slower or \
            smaller motion (--period, --fraction) or larger moment arms need less; docs/robot.md has a motor of your \
            own.\n",
        names.join(", ")
    );
    if used().any(|(_, used)| *used > ABSURD) {
        let mass: f64 = parts.bodies.iter().map(|body| body.mass).sum();
        text += &format!(
            "The bodies weigh {} kg together: are their masses in kg and their lengths in m?\n",
            number(Some(mass))
        );
    }
    text
}

/// Fraction of a drive beyond which a unit is likely to be wrong.
const ABSURD: f64 = 5.0;

/// Why tensions do not give the torque, and what helps.
fn unreachable_text(choice: &Choice, fraction: f64, missing: &MissingTorque) -> String {
    let (parts, demands) = (choice.machine.robot.parts(), &choice.demands);
    let joint = &parts.joints[choice.machine.robot.independent_joints()[missing.joint]];
    let unit = joint.kind.torque_unit();
    let (name, torque) = (one_line(&joint.name), number(Some(missing.torque)));
    let fraction = percent(Some(fraction));
    let against = missing.against.map(|(muscle, tension, arm)| {
        let (newtons, arm) = (number(Some(tension)), number(Some(1e3 * arm.abs())));
        let name = one_line(&parts.tendons[muscle].name);
        format!("`{name}`, which pulls with {newtons} N at {arm} mm even where it is slackest")
    });
    match against {
        Some(against) if 2 * demands.overpowered > demands.unreachable => format!(
            "\nIn {fraction} of the motion the smallest tensions of some muscles overpower the others, \
                whatever their drives: most is missing at `{name}`, {torque} {unit}, against {against}. \
                Smaller `tension_limits_n` with a thinner cable, another path of that muscle or a longer \
                moment arm of its opponents help.\n"
        ),
        _ => format!(
            "\nIn {fraction} of the motion no tensions give the torque, whatever the drives; most is missing \
                at {name}: {torque} {unit}. It needs a muscle that pulls this way, or a longer moment \
                arm.\n"
        ),
    }
}

fn summary(answer: &NewMachine<'_>) -> String {
    let row = |muscle: &Muscle<'_>| {
        let words = [muscle.muscle, muscle.drive, muscle.motor, muscle.reducer].map(one_line);
        let numbers = [
            muscle.ratio,
            muscle.tension_n,
            muscle.speed_m_per_s,
            muscle.acceleration_m_per_s2,
            muscle.stroke_m,
        ];
        let numbers = numbers.map(|value| number(Some(value)));
        words.into_iter().chain(numbers).chain([percent(Some(muscle.used))]).collect()
    };
    let head = ["muscle", "drive", "motor", "reducer", "ratio", "N", "m/s", "m/s^2", "stroke m", "used"];
    table(&head, &answer.muscles.iter().map(row).collect::<Vec<_>>(), 4)
}

/// The path of an existing file from the folder of another one.
fn relative(file: &Path, from: &Path) -> Result<String, Error> {
    let absolute = |path: &Path| {
        path.canonicalize().map_err(|source| Error::Unreadable { file: path.to_owned(), source })
    };
    let parent = from.parent().filter(|parent| !parent.as_os_str().is_empty()).unwrap_or(Path::new("."));
    let (file, folder) = (absolute(file)?, absolute(parent)?);
    let common = file.components().zip(folder.components()).take_while(|(a, b)| a == b).count();
    let mut path = PathBuf::new();
    folder.components().skip(common).for_each(|_| path.push(Component::ParentDir));
    file.components().skip(common).for_each(|part| path.push(part));
    Ok(path.display().to_string())
}
