//! The physics of a model: tables and code of the clamp cell, the cable and the axis.

use super::literal::{array, double, scalar};
use super::template::Filling;
use crate::{ExportError, Name};
use sinew::predictor::{Axis, AxisForce, AxisMotion, MemoryLaw, ModelFileError, ObservedCable};
use sinew::transmission::cable::{CableLaw, WeakeningForm};
use sinew::transmission::{BasisTerm, ClampCell};

/// Fills the part of the law that the model has.
pub(super) fn fill(filling: &mut Filling, law: &MemoryLaw, name: &Name) -> Result<(), ExportError> {
    if let Some(cell) = &law.cell {
        fill_cell(filling, cell, name.as_str());
    }
    if let Some(cable) = &law.cable {
        fill_cable(filling, cable, name.as_str())?;
    }
    match &law.axis {
        Some(Axis::Force(axis)) => fill_axis_force(filling, axis, name.as_str()),
        Some(Axis::Motion(axis)) => fill_axis_motion(filling, axis, name.as_str()),
        None => {}
    }
    filling.when("axis", law.axis.is_some());
    Ok(())
}

/// Indices of the signals that the physics reads.
pub(super) fn signals_used(law: &MemoryLaw) -> Vec<usize> {
    let mut used = Vec::new();
    if let Some(cell) = &law.cell {
        used.extend(&cell.elastic);
        for term in &cell.basis {
            match *term {
                BasisTerm::One => {}
                BasisTerm::Signal(i) => used.push(i),
                BasisTerm::Product(i, j) => used.extend([i, j]),
            }
        }
    }
    match &law.axis {
        Some(Axis::Force(axis)) => {
            used.extend(axis.position.into_iter().chain(axis.velocity));
            used.extend(axis.gains.iter().map(|(signal, _)| *signal));
        }
        Some(Axis::Motion(axis)) => used.push(axis.force),
        None => {}
    }
    used
}

fn fill_cell(filling: &mut Filling, cell: &ClampCell, n: &str) {
    filling.when("cell", true);
    filling.when("elastic", !cell.elastic.is_empty());
    filling.set("branch_count", cell.branches.len());
    let branches =
        |of: fn(&sinew::transmission::Branch) -> f64| cell.branches.iter().map(of).collect::<Vec<_>>();
    let tables = array(&format!("{n}_width"), &branches(|b| b.width))
        + &array(&format!("{n}_weight"), &branches(|b| b.fraction))
        + &scalar(&format!("{n}_start"), cell.start);
    filling.set("cell_tables", tables);
    let mut bounds = String::new();
    for ((term, low), high) in cell.basis.iter().zip(&cell.low).zip(&cell.high) {
        let value = match *term {
            BasisTerm::One => "1.0".to_owned(),
            BasisTerm::Signal(i) => format!("s->signals[{i}]"),
            BasisTerm::Product(i, j) => format!("(s->signals[{i}] * s->signals[{j}])"),
        };
        bounds +=
            &format!("    low += {} * {value};\n    high += {} * {value};\n", double(*low), double(*high));
    }
    filling.set("cell_bounds", bounds);
    let moves = cell.elastic.iter().zip(&cell.kappa).map(|(i, kappa)| {
        format!("        increment += {} * (s->signals[{i}] - s->previous[{i}]);\n", double(*kappa))
    });
    filling.set("cell_increment", moves.collect::<String>());
}

fn fill_cable(filling: &mut Filling, cable: &ObservedCable, n: &str) -> Result<(), ExportError> {
    let model = &cable.model;
    // Validation has refused a model without a law before.
    let law = model.law().map_err(|error| ModelFileError {
        name: "law.cable".to_owned(),
        expected: "valid".to_owned(),
        got: error.to_string(),
    })?;
    let cells = law.cells();
    let (adaptation, weakening) = (model.learning > 0.0, law.weakening());
    let changes = adaptation || model.warming.is_some();
    filling.when("cable", true);
    filling.when("adaptation", adaptation);
    filling.when("warming", model.warming.is_some());
    filling.when("drag_changes", changes);
    filling.when("zero_stretch", model.zero_stretch.is_some());
    filling.when("weakening", weakening.is_some());
    filling.when("gaussian", weakening.is_some_and(|w| w.form == WeakeningForm::Gaussian));
    filling.set("cells", cells);
    filling.set("tension_input", cable.columns.tension);
    filling.set("motor_input", cable.columns.motor);
    filling.set("anchor_input", cable.columns.anchor);
    let state = if weakening.is_some() { "s->".to_owned() } else { format!("{n}_") };
    filling.set("tanh_half", format!("{state}tanh_half"));
    filling.set("half_angle", format!("{state}half_angle"));
    filling
        .set("sweep_state", if weakening.is_some() { format!("const {n}_state *s,") } else { String::new() });
    filling.set("sweep_argument", if weakening.is_some() { "s," } else { "" });
    let drag = format!("{n}_drag[i]");
    filling.set("drag", if changes { format!("{drag} * s->drag_factor") } else { drag });
    filling.set("cable_tables", cable_tables(cable, &law, n));
    Ok(())
}

fn cable_tables(cable: &ObservedCable, law: &CableLaw, n: &str) -> String {
    let (model, mut tables) = (&cable.model, String::new());
    let mut list = |what: &str, values: Vec<f64>| tables += &array(&format!("{n}_{what}"), &values);
    list("compliance", law.compliance().to_vec());
    list("stiffness", law.compliance().iter().map(|c| 1.0 / c).collect());
    let node = |of: fn(&sinew::transmission::cable::NodeLaw) -> f64| law.nodes().iter().map(of).collect();
    list("viscous", node(|node| node.viscous));
    list("drag", node(|node| node.drag));
    if law.weakening().is_some() {
        list("friction", node(|node| node.friction));
        list("loss", node(|node| node.loss));
    } else {
        list("half_angle", node(sinew::transmission::cable::NodeLaw::half_angle));
        list("tanh_half", node(sinew::transmission::cable::NodeLaw::tanh_half));
    }
    let [_, drag_fade] = law.drag();
    let mut one = |what: &str, value: f64| tables += &scalar(&format!("{n}_{what}"), value);
    if let Some(weakening) = law.weakening() {
        one("rise", weakening.rise);
        one("inverse_speed", 1.0 / weakening.speed);
        one("lag", weakening.lag);
    }
    one("fade", 2.0 * drag_fade);
    one("pretension", law.pretension());
    one("end_ratio", law.end_ratio());
    one("far_gain", model.far_gain);
    match model.zero_stretch {
        Some(stretch) => one("zero_stretch", stretch),
        None => one("start", model.start),
    }
    one("correction", model.correction);
    if model.learning > 0.0 {
        one("learning", model.learning);
    }
    if let Some(warming) = model.warming {
        one("warming_rate", warming.rate);
        one("warming_time", warming.time);
    }
    one("tension_scale", cable.columns.tension_scale);
    one("motor_scale", cable.columns.motor_scale);
    one("anchor_scale", cable.columns.anchor_scale);
    tables
}

fn fill_axis_force(filling: &mut Filling, axis: &AxisForce, n: &str) {
    filling.when("axis_force", true);
    filling.when("slips", !axis.slips.is_empty());
    filling.set("slip_count", axis.slips.len());
    let mut tables = scalar(&format!("{n}_tau_s"), axis.tau_s);
    if !axis.slips.is_empty() {
        let slips =
            |of: fn(&sinew::predictor::AxisSlip) -> f64| axis.slips.iter().map(of).collect::<Vec<_>>();
        tables += &array(&format!("{n}_slip_distance"), &slips(|slip| slip.distance));
        tables += &array(&format!("{n}_slip_force"), &slips(|slip| slip.force));
    }
    let dry: f64 = axis.slips.iter().map(|slip| slip.force.abs()).sum();
    tables += &scalar(&format!("{n}_dry_sum"), dry);
    filling.set("axis_tables", tables);
    let mut inputs = String::new();
    if let Some(signal) = axis.position {
        inputs += &format!("    const double position = s->signals[{signal}];\n");
    }
    if let Some(signal) = axis.velocity {
        let gain = double(axis.velocity_gain);
        inputs += &format!("    const double velocity = s->signals[{signal}] * {gain};\n");
    }
    let followed = if axis.velocity.is_some() { "velocity" } else { "position" };
    inputs += &format!("    const double followed = {followed};\n");
    filling.set("axis_inputs", inputs);
    let positioned = axis.position.is_some();
    filling.set("travel", if positioned { "position - s->axis_position" } else { "velocity * dt_s" });
    filling.set("axis_position", if positioned { "position" } else { "0.0" });
    let passed =
        axis.gains.iter().map(|(i, gain)| format!("    passed += {} * s->signals[{i}];\n", double(*gain)));
    filling.set("axis_passed", passed.collect::<String>());
    let [position, velocity, acceleration] = if axis.velocity.is_some() {
        ["s->axis_position", "velocity", "s->axis_rate"]
    } else {
        ["s->axis_value", "s->axis_rate", "s->axis_second_rate"]
    };
    let spring =
        if positioned { format!("{} * {position}", double(axis.stiffness)) } else { "0.0".to_owned() };
    let sum = format!(
        "{} * {acceleration} + {} * {velocity} + {spring} + dry + passed + {}",
        double(axis.mass),
        double(axis.damping),
        double(axis.offset)
    );
    filling.set("axis_sum", sum);
}

fn fill_axis_motion(filling: &mut Filling, axis: &AxisMotion, n: &str) {
    filling.when("axis_motion", true);
    filling.when("spring", axis.stiffness > 0.0);
    filling.set("force_signal", axis.force);
    filling.set("axis_far", if axis.far_is_velocity { "s->axis_velocity" } else { "s->axis_position" });
    // With a spring the start decays at half the rate.
    let rate = if axis.stiffness > 0.0 { 0.5 * axis.damping } else { axis.damping };
    let constants = [
        ("gain", axis.gain),
        ("damping", axis.damping),
        ("stiffness", axis.stiffness),
        ("dry_friction", axis.friction),
        ("axis_bias", axis.bias),
        ("axis_offset", axis.offset),
        ("axis_rate", rate),
    ];
    let tables = constants.iter().map(|(what, value)| scalar(&format!("{n}_{what}"), *value));
    filling.set("axis_tables", tables.collect::<String>());
}
