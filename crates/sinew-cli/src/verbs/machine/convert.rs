//! `sinew machine convert`.

use super::names::print_warnings;
use crate::answer::{Answer, Content};
use crate::arguments::{General, MachineConvertArguments};
use crate::error::Error;
use crate::output::{refuse_overwrite, write_all};
use sinew::body::{Joint as JointPart, Parts};
use sinew::description::{to_mjcf, to_toml};
use sinew_lab::machine_file::{Format, LoadedRobot, Source, load_robot, source_of};

/// What a machine file says and a robot file has no place for.
const MACHINE_ALONE: [&str; 5] = ["transmissions", "drives", "encoders", "task", "tolerances"];

pub(crate) fn run(arguments: &MachineConvertArguments, general: &General) -> Result<Answer, Error> {
    let output = &arguments.output;
    let inputs = [&arguments.input].into_iter().chain(&arguments.files.muscles);
    refuse_overwrite(inputs, std::slice::from_ref(output), general.no_clobber)?;
    let Some(kind) =
        Format::from_path(output).ok().filter(|kind| matches!(kind, Format::Toml | Format::Mjcf))
    else {
        let expected = ".toml or .xml; URDF has no cables, OpenSim's format is read alone";
        return Err(Error::RobotFormat { file: output.clone(), expected });
    };
    let LoadedRobot { robot, warnings } = load_robot(
        &arguments.input,
        arguments.files.muscles.as_deref(),
        arguments.files.root.dir.as_deref(),
    )?;
    print_warnings(&warnings);
    let machine = matches!(
        source_of(&arguments.input, arguments.files.muscles.as_deref(), arguments.files.root.dir.as_deref())?,
        Source::Machine
    );
    let left_out = if machine { &MACHINE_ALONE[..] } else { &[] };
    let parts = robot.parts();
    match parts.meshes.len() {
        0 => {}
        1 => tell!("warning: a shape of a body in a mesh file is left out"),
        many => tell!("warning: {many} shapes of bodies in mesh files are left out"),
    }
    let bypassed = parts.sites.iter().filter(|site| site.active.is_some()).count();
    if kind == Format::Mjcf && bypassed > 0 {
        tell!(
            "warning: paths always pass through sites in MJCF: {bypassed} have an active range here, which is left out"
        );
    }
    if kind == Format::Mjcf
        && let Some((error, follower)) = nearest(parts)
    {
        let JointPart { name, kind, .. } = &parts.joints[follower];
        let unit = kind.unit();
        tell!(
            "warning: MJCF knows polynomials of degree four alone: they stand for curves, the largest error is \
             {error:.2e} {unit}, of `{name}`"
        );
    }
    let text = if kind == Format::Toml { to_toml(parts) } else { to_mjcf(parts) };
    let written = write_all(&[(output.clone(), text.as_bytes())])?;
    let (bodies, joints, muscles) = (parts.bodies.len() - 1, parts.joints.len(), parts.tendons.len());
    let content = if general.json {
        Content::json(
            &serde_json::json!({"bodies": bodies, "joints": joints, "muscles": muscles, "left_out": left_out}),
        )?
    } else {
        let rest = if machine {
            format!("; left out: {} of the machine", left_out.join(", "))
        } else {
            String::new()
        };
        Content::Text(format!("{bodies} bodies, {joints} joints and {muscles} muscles{rest}\n"))
    };
    Ok(Answer::done(content, written))
}

/// The largest error of a polynomial that stands for a curve in MJCF, and the joint that follows it.
fn nearest(parts: &Parts) -> Option<(f64, usize)> {
    let errors = parts.couplings.iter().map(|coupling| {
        let range = coupling.leader.and_then(|leader| parts.joints[leader].range);
        (coupling.polynomial(range).1, coupling.follower)
    });
    errors.filter(|(error, _)| *error > 0.0).max_by(|a, b| a.0.total_cmp(&b.0))
}
