//! `sinew machine body`.

use super::body_page;
use super::names::{display_name, print_warnings};
use super::survey::{Survey, survey};
use crate::answer::{Answer, Content};
use crate::arguments::{General, MachineBodyArguments};
use crate::error::Error;
use crate::output::{one_line, refuse_overwrite, write_all};
use crate::table::{number, table};
use crate::verbs::meshes::read_meshes;
use sinew::body::{JointKind, Robot};
use sinew_lab::machine_file::{LoadedRobot, load_robot};

pub(crate) fn run(arguments: &MachineBodyArguments, general: &General) -> Result<Answer, Error> {
    let inputs = [&arguments.model].into_iter().chain(&arguments.files.muscles);
    refuse_overwrite(inputs, arguments.report.as_slice(), general.no_clobber)?;
    let mut loaded = load_robot(
        &arguments.model,
        arguments.files.muscles.as_deref(),
        arguments.files.root.dir.as_deref(),
    )?;
    if arguments.report.is_some() {
        read_meshes(&mut loaded.robot, &arguments.model, arguments.files.root.dir.as_deref());
    }
    let survey = survey(&loaded.robot)?;
    let written = match &arguments.report {
        Some(path) => write_all(&[(path.clone(), body_page::page(&loaded.robot, &survey)?.as_bytes())])?,
        None => Vec::new(),
    };
    print_warnings(&loaded.warnings);
    if general.json {
        return Ok(Answer::done(Content::json(&json(&loaded, &survey))?, written));
    }
    let mut text = summary_text(&loaded.robot, &survey);
    match loaded.warnings.len() {
        0 => {}
        1 => text += "\n1 warning, see above\n",
        many => text += &format!("\n{many} warnings, see above\n"),
    }
    Ok(Answer::done(Content::Text(text + "\n"), written))
}

fn kind(kind: JointKind) -> &'static str {
    match kind {
        JointKind::Hinge => "hinge",
        JointKind::Slide => "slide",
        JointKind::Ball => "ball",
        JointKind::Free => "free",
    }
}

fn summary_text(robot: &Robot, survey: &Survey) -> String {
    let parts = robot.parts();
    let mut text = format!(
        "{}: {} bodies, {} kg ({} kg moving), {} joints, {} muscles, {} couplings, {} key poses\n\n",
        one_line(&parts.name),
        parts.bodies.len() - 1,
        number(Some(parts.bodies.iter().map(|body| body.mass).sum())),
        number(Some(robot.moving_mass())),
        parts.joints.len(),
        parts.tendons.len(),
        parts.couplings.len(),
        parts.keys.len()
    );
    let rows: Vec<Vec<String>> = parts
        .joints
        .iter()
        .enumerate()
        .map(|(i, joint)| {
            let (low, high) = joint.range.map_or((None, None), |[low, high]| (Some(low), Some(high)));
            let turns = joint.kind == JointKind::Hinge || joint.kind == JointKind::Ball;
            let follows = parts.couplings.iter().find(|c| c.follower == i);
            let leader = follows.map_or(String::new(), |c| {
                c.leader.map_or("fixed".to_owned(), |l| display_name("joint", &parts.joints[l].name, l))
            });
            vec![
                one_line(&display_name("joint", &joint.name, i)),
                kind(joint.kind).to_owned(),
                if turns { "rad" } else { "m" }.to_owned(),
                one_line(&leader),
                number(low),
                number(high),
                number(Some(joint.damping)),
            ]
        })
        .collect();
    text += &table(&["joint", "kind", "unit", "follows", "from", "to", "damping"], &rows, 4);
    text.push('\n');
    let rows: Vec<Vec<String>> = survey
        .muscles
        .iter()
        .map(|muscle| {
            vec![
                one_line(&muscle.name),
                number(Some(muscle.length_m)),
                number(Some(muscle.travel_m())),
                one_line(&muscle.strongest),
                number(Some(1e3 * muscle.arm_m[0])),
                number(Some(1e3 * muscle.arm_m[1])),
                number(Some(muscle.wrap_rad[0])),
                number(Some(muscle.wrap_rad[1])),
            ]
        })
        .collect();
    let head =
        ["muscle", "length m", "travel m", "largest arm at", "arm mm from", "to", "wrap rad from", "to"];
    // The joint of the largest arm is text between numbers: only the first columns are left-aligned.
    text += &table(&head, &rows, 1);
    text += &format!(
        "\ntravel, moment arms and wrap angles: minimum and maximum over {} poses within the joint limits\n",
        survey.poses
    );
    text
}

fn json(loaded: &LoadedRobot, survey: &Survey) -> serde_json::Value {
    let (robot, parts) = (&loaded.robot, loaded.robot.parts());
    let joints: Vec<_> = parts
        .joints
        .iter()
        .enumerate()
        .map(|(i, joint)| {
            let name = display_name("joint", &joint.name, i);
            serde_json::json!({"name": name, "kind": kind(joint.kind), "range": joint.range})
        })
        .collect();
    let muscles: Vec<_> = survey
        .muscles
        .iter()
        .map(|m| {
            serde_json::json!({"name": m.name, "length_m": m.length_m, "travel_m": m.travel_m(),
                "length_range_m": m.lengths_m, "strongest_joint": m.strongest, "moment_arm_range_m": m.arm_m, "wrap_range_rad": m.wrap_rad})
        })
        .collect();
    let warnings: Vec<String> = loaded.warnings.iter().map(ToString::to_string).collect();
    serde_json::json!({"name": parts.name, "bodies": parts.bodies.len() - 1,
        "mass_kg": parts.bodies.iter().map(|b| b.mass).sum::<f64>(), "moving_mass_kg": robot.moving_mass(),
        "joints": joints, "muscles": muscles, "poses": survey.poses, "warnings": warnings})
}
