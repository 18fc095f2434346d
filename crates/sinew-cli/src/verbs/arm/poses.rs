//! Poses from a table with a column per coordinate.

use super::model::display_name;
use crate::error::Error;
use crate::verbs::numeric_table::{parse_header, split_cells};
use crate::verbs::read_text;
use sinew::body::{JointKind, Robot};
use std::path::Path;

/// Names of all coordinates, in order.
pub(super) fn coordinate_names(robot: &Robot) -> Vec<String> {
    let mut names = Vec::new();
    for (index, joint) in robot.parts().joints.iter().enumerate() {
        let name = display_name("joint", &joint.name, index);
        let parts: &[&str] = match joint.kind {
            JointKind::Hinge | JointKind::Slide => &[""],
            JointKind::Ball => &[".qw", ".qx", ".qy", ".qz"],
            JointKind::Free => &[".x", ".y", ".z", ".qw", ".qx", ".qy", ".qz"],
        };
        names.extend(parts.iter().map(|part| format!("{name}{part}")));
    }
    names
}

/// Names of all velocities, in order.
pub(super) fn velocity_names(robot: &Robot) -> Vec<String> {
    let mut names = Vec::new();
    for (index, joint) in robot.parts().joints.iter().enumerate() {
        let name = display_name("joint", &joint.name, index);
        match robot.velocities_of(index).len() {
            1 => names.push(name),
            many => names.extend((0..many).map(|k| format!("{name}.{k}"))),
        }
    }
    names
}

/// All poses of a file.
pub(super) fn read_poses(robot: &Robot, path: &Path) -> Result<Vec<Vec<f64>>, Error> {
    let text = read_text(path)?;
    let refuse = |line: usize, problem: String| Error::File {
        file: path.to_owned(),
        problem: format!("line {line}: {problem}"),
    };
    let names = coordinate_names(robot);
    let is_data = |line: &&str| !line.trim().is_empty() && !line.trim_start().starts_with('#');
    let mut lines = text.lines().enumerate().map(|(i, line)| (i + 1, line)).filter(|(_, line)| is_data(line));
    let (first, head) =
        lines.next().ok_or_else(|| refuse(1, "is empty: expected a row of joint names".to_owned()))?;
    let (separator, columns) = columns(head, &names).map_err(|problem| refuse(first, problem))?;
    let given: Vec<usize> = columns.iter().map(|column| column.place).collect();
    let reference = robot.reference_pose();
    let mut poses = Vec::new();
    for (line, row) in lines {
        let mut q = reference.clone();
        numbers(row, separator, &columns, &mut q).map_err(|problem| refuse(line, problem))?;
        unit_quaternions(robot, &mut q).map_err(|problem| refuse(line, problem))?;
        apply_couplings(robot, &given, &mut q);
        if let Some(place) = q.iter().position(|value| !value.is_finite()) {
            return Err(refuse(line, format!("puts `{}` out of all bounds", names[place])));
        }
        poses.push(q);
    }
    Ok(poses)
}

/// A column: its coordinate and what its numbers are multiplied by.
struct Column {
    name: String,
    place: usize,
    unit: f64,
}

/// The separator of a table and its columns; what separates the names separates everything.
fn columns(head: &str, names: &[String]) -> Result<(char, Vec<Column>), String> {
    let (separator, cells) = parse_header(head)?;
    let mut columns: Vec<Column> = Vec::new();
    for cell in cells {
        let whole = names.iter().position(|name| *name == cell);
        let (name, unit) = if whole.is_some() { (cell.as_str(), 1.0) } else { parse_column_name(&cell)? };
        let Some(place) = names.iter().position(|known| known == name) else {
            let known = names.join(", ");
            return Err(format!("column `{name}`: the robot has no such coordinate; it has {known}"));
        };
        if columns.iter().any(|other| other.place == place) {
            return Err(format!("column `{name}` stands twice"));
        }
        columns.push(Column { name: name.to_owned(), place, unit });
    }
    Ok((separator, columns))
}

/// The numbers of one row, each put where its column says.
fn numbers(row: &str, separator: char, columns: &[Column], q: &mut [f64]) -> Result<(), String> {
    let cells = split_cells(row, separator)?;
    if cells.len() != columns.len() {
        return Err(format!("has {} cells: expected {}, as many as names", cells.len(), columns.len()));
    }
    for (cell, Column { name, place, unit }) in cells.iter().zip(columns) {
        if cell.is_empty() {
            return Err(format!("column `{name}`: is empty: expected a finite number"));
        }
        let value = cell.parse::<f64>().ok().filter(|value| value.is_finite());
        let value = value.ok_or_else(|| {
            format!("column `{name}`: `{}` is no finite number", crate::output::one_line(cell))
        })?;
        q[*place] = value * unit;
    }
    Ok(())
}

/// The coordinate of a column and what its numbers are multiplied by: `elbow`, or with its unit `elbow [deg]`.
fn parse_column_name(cell: &str) -> Result<(&str, f64), String> {
    let Some((name, unit)) = cell.strip_suffix(']').and_then(|cell| cell.split_once('[')) else {
        return Ok((cell, 1.0));
    };
    let unit = match unit.trim() {
        "rad" | "m" | "1" => 1.0,
        "deg" => std::f64::consts::PI / 180.0,
        "mm" => 1e-3,
        other => {
            return Err(format!("column `{cell}`: `{other}` is no unit here: expected rad, deg, m or mm"));
        }
    };
    Ok((name.trim(), unit))
}

fn unit_quaternions(robot: &Robot, q: &mut [f64]) -> Result<(), String> {
    for (index, joint) in robot.parts().joints.iter().enumerate() {
        let range = robot.coordinates_of(index);
        if range.len() < 4 {
            continue;
        }
        let quaternion = &mut q[range.end - 4..range.end];
        let length = quaternion.iter().map(|x| x * x).sum::<f64>().sqrt();
        if !(length.is_finite() && length > 1e-9) {
            return Err(format!("joint `{}`: its quaternion has no direction", joint.name));
        }
        quaternion.iter_mut().for_each(|x| *x /= length);
    }
    Ok(())
}

/// Joints that are not given follow their coupling; chains of couplings settle after as many rounds as links.
pub(super) fn apply_couplings(robot: &Robot, given: &[usize], q: &mut [f64]) {
    let parts = robot.parts();
    for _ in 0..parts.couplings.len() {
        let mut moved = false;
        for coupling in &parts.couplings {
            let place = robot.coordinates_of(coupling.follower).start;
            if given.contains(&place) {
                continue;
            }
            let x = coupling
                .leader
                .map_or(0.0, |leader| q[robot.coordinates_of(leader).start] - parts.joints[leader].reference);
            let value = coupling.coefficients.iter().rev().fold(0.0, |sum, c| sum * x + c);
            let value = parts.joints[coupling.follower].reference + value;
            moved |= q[place].to_bits() != value.to_bits();
            q[place] = value;
        }
        if !moved {
            break;
        }
    }
}
