//! `sinew machine map`.

use super::map_json::json;
use super::names::print_warnings;
use super::payload::{payload, text as payload_text};
use super::view::machine_scene;
use crate::answer::{Answer, Content};
use crate::arguments::{General, MachineMapArguments};
use crate::error::Error;
use crate::output::{refuse_overwrite, write_all};
use crate::progress::Progress;
use crate::table::{number, table};
use crate::verbs::machine_source::load_machine;
use sinew::control::capability::{CableMotion, CapabilityModel, EndPointJacobian, PoseCapability};
use sinew::machine::Machine;
use sinew_report::capability::{MapView, Quantity, page, quantities};
use sinew_report::capability_plots::Outlines;
use sinew_report::payload::Payload;

/// Directions of an outline of forces.
const DIRECTIONS: usize = 90;

pub(super) fn run(arguments: &MachineMapArguments, general: &General) -> Result<Answer, Error> {
    let inputs = [&arguments.machine].into_iter().chain(&arguments.files.muscles);
    refuse_overwrite(inputs, arguments.report.as_slice(), general.no_clobber)?;
    let (loaded, _) = load_machine(
        &arguments.machine,
        arguments.files.muscles.as_deref(),
        arguments.files.root.dir.as_deref(),
    )?;
    print_warnings(&loaded.warnings);
    let machine = &loaded.machine;
    let mut model = CapabilityModel::new(machine)?;
    let progress = Progress::new();
    let mut poses = Vec::new();
    let places = machine.poses(arguments.poses as usize)?;
    for (k, pose) in places.iter().enumerate() {
        if k % 16 == 0 {
            progress.show("mapping poses", k as f64 / places.len() as f64);
        }
        poses.push(model.at(pose)?);
    }
    let mut view = view(machine, &mut model, &poses)?;
    view.payload = payload(machine, &places, &progress)?;
    drop(progress);
    let written = match &arguments.report {
        Some(path) => write_all(&[(
            path.clone(),
            page(&view, &machine_scene(machine, &arguments.machine, arguments.files.root.dir.as_deref())?)?
                .as_bytes(),
        )])?,
        None => Vec::new(),
    };
    let content =
        if general.json { Content::json(&json(&view))? } else { Content::Text(text(&view, machine)) };
    Ok(Answer::done(content, written))
}

/// The map with the names of joints and muscles, and the sets of the start pose.
fn view<'a>(
    machine: &Machine,
    model: &mut CapabilityModel,
    poses: &'a [PoseCapability],
) -> Result<MapView<'a>, Error> {
    let parts = machine.robot.parts();
    let joints = machine.robot.independent_joints().into_iter().map(|joint| {
        let joint = &parts.joints[joint];
        (joint.name.clone(), joint.kind.unit())
    });
    let mut view = MapView {
        name: parts.name.clone(),
        joints: joints.collect(),
        muscles: parts.tendons.iter().map(|tendon| tendon.name.clone()).collect(),
        poses,
        torques: Vec::new(),
        forces: Vec::new(),
        payload: Payload::default(),
    };
    model.evaluate(&machine.start)?;
    let up = model.upward()?;
    let down: Option<Vec<f64>> = up.as_ref().map(|up| up.iter().map(|x| -x).collect());
    let mut motions = vec![CableMotion::Frictionless, CableMotion::Either];
    motions.extend([&up, &down].into_iter().flatten().map(|velocity| CableMotion::Along(velocity)));
    let needed = model.needed_torque()?;
    for first in 0..needed.len().saturating_sub(1) {
        let (x, y) = (&view.joints[first], &view.joints[first + 1]);
        let mut outlines = Outlines {
            x_label: torque_label(x),
            y_label: torque_label(y),
            lines: Vec::new(),
            needed: Some([needed[first], needed[first + 1]]),
        };
        let mut rows = vec![0.0; 2 * needed.len()];
        (rows[first], rows[needed.len() + first + 1]) = (1.0, 1.0);
        for motion in &motions {
            let set = model.torque_set(*motion)?;
            outlines.lines.push(set.map_or(Ok(Vec::new()), |set| set.image(&rows)?.outline())?);
        }
        view.torques.push(outlines);
    }
    let axes = moving_axes(model)?;
    for (k, &first) in axes.iter().enumerate() {
        for &second in &axes[k + 1..] {
            let mut outlines = Outlines {
                x_label: format!("force along {} (N)", ["x", "y", "z"][first]),
                y_label: format!("force along {} (N)", ["x", "y", "z"][second]),
                lines: Vec::new(),
                needed: None,
            };
            for motion in &motions {
                outlines.lines.push(model.force_outline(*motion, [first, second], DIRECTIONS)?);
            }
            view.forces.push(outlines);
        }
    }
    Ok(view)
}

fn torque_label((name, unit): &(String, &str)) -> String {
    format!("{name} ({})", if *unit == "m" { "N" } else { "Nm" })
}

/// The axes of the task along which the end point can move in the evaluated pose.
fn moving_axes(model: &CapabilityModel) -> Result<Vec<usize>, Error> {
    let Some(EndPointJacobian { rows, .. }) = model.end_point()? else { return Ok(Vec::new()) };
    let joints = rows.len() / 3;
    let lever =
        |axis: usize| rows[axis * joints..(axis + 1) * joints].iter().fold(0.0_f64, |m, x| m.max(x.abs()));
    let most = (0..3).map(lever).fold(0.0, f64::max);
    Ok((0..3).filter(|&axis| lever(axis) > 1e-6 * most && most > 0.0).collect())
}

fn text(view: &MapView<'_>, machine: &Machine) -> String {
    let mut text = format!(
        "{}: {} poses over the joints' ranges; minimum, median and maximum, and the muscle that limits most \
         often\n\n",
        crate::output::one_line(&view.name),
        view.poses.len()
    );
    let rows: Vec<Vec<String>> = quantities(view).iter().map(row).collect();
    text += &table(&["", "unit", "poses", "min", "median", "max", "limited by", "in poses"], &rows, 2);
    text += "\nPayload: what is lifted slowly, held whichever way the cables slid before, and lowered \
        slowly. Poses: in which there is such a number; elsewhere the muscles do not hold the machine \
        itself. Force and speed: in the direction in which they are least. Stiffness: while the winches \
        stand. Heat: not in this table.\n";
    text += &payload_text(&view.payload, machine.payload_site().is_some());
    text
}

fn row(quantity: &Quantity) -> Vec<String> {
    let [least, median, most] = quantity.spread.map(|value| number(Some(value)));
    let (muscle, count) = quantity
        .limited_by
        .as_ref()
        .map_or((String::new(), String::new()), |(muscle, count)| (muscle.clone(), count.to_string()));
    vec![
        quantity.name.clone(),
        quantity.unit.to_owned(),
        quantity.count.to_string(),
        least,
        median,
        most,
        muscle,
        count,
    ]
}
