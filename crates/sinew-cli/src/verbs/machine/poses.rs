//! Poses from a table with a column per coordinate.

use super::names::display_name;
use crate::error::Error;
use crate::table_error::TableError;
use crate::verbs::numeric_table::{data_lines, parse_header, parse_number, split_cells};
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
    parse_poses(robot, &read_text(path)?).map_err(Error::table(path))
}

fn parse_poses(robot: &Robot, text: &str) -> Result<Vec<Vec<f64>>, TableError> {
    let names = coordinate_names(robot);
    let mut lines = data_lines(text);
    let Some((line, header)) = lines.next() else {
        return Err(TableError::in_line(1, "a row of joint names", "an empty table"));
    };
    let (separator, columns) = parse_columns(line, header, &names)?;
    let given: Vec<usize> = columns.iter().map(|column| column.place).collect();
    let pose = |(line, row)| {
        let mut q = robot.reference_pose();
        parse_row(line, row, separator, &columns, &mut q)?;
        normalise_quaternions(line, robot, &mut q)?;
        apply_couplings(robot, &given, &mut q);
        match q.iter().position(|value| !value.is_finite()) {
            Some(place) => {
                let got = q[place].to_string();
                Err(TableError::in_column(line, &names[place], "a finite coordinate after couplings", &got))
            }
            None => Ok(q),
        }
    };
    lines.map(pose).collect()
}

/// A column: its coordinate and the factor to its SI unit.
struct Column {
    name: String,
    place: usize,
    unit: f64,
}

/// The separator of a table and its columns.
fn parse_columns(line: usize, header: &str, names: &[String]) -> Result<(char, Vec<Column>), TableError> {
    let (separator, cells) = parse_header(line, header)?;
    let mut columns: Vec<Column> = Vec::new();
    for cell in cells {
        let is_name = names.contains(&cell);
        let (name, unit) = if is_name { (cell.as_str(), 1.0) } else { parse_column_name(line, &cell)? };
        let Some(place) = names.iter().position(|known| known == name) else {
            let expected = format!("a coordinate of the robot: {}", names.join(", "));
            return Err(TableError::in_column(line, name, expected, "another name"));
        };
        if columns.iter().any(|other| other.place == place) {
            return Err(TableError::in_column(line, name, "it once", "it twice"));
        }
        columns.push(Column { name: name.to_owned(), place, unit });
    }
    Ok((separator, columns))
}

/// Writes the numbers of one row to their coordinates.
fn parse_row(
    line: usize,
    row: &str,
    separator: char,
    columns: &[Column],
    q: &mut [f64],
) -> Result<(), TableError> {
    let cells = split_cells(line, row, separator)?;
    if cells.len() != columns.len() {
        let expected = format!("{} cells, one per column", columns.len());
        return Err(TableError::in_line(line, expected, cells.len().to_string()));
    }
    for (cell, Column { name, place, unit }) in cells.iter().zip(columns) {
        q[*place] = parse_number(line, name, cell)? * unit;
    }
    Ok(())
}

/// Coordinate and unit factor of a column: `elbow`, or with its unit `elbow [deg]`.
fn parse_column_name(line: usize, cell: &str) -> Result<(&str, f64), TableError> {
    let Some((name, unit)) = cell.strip_suffix(']').and_then(|cell| cell.split_once('[')) else {
        return Ok((cell, 1.0));
    };
    let factor = match unit.trim() {
        "rad" | "m" | "1" => 1.0,
        "deg" => std::f64::consts::PI / 180.0,
        "mm" => 1e-3,
        other => {
            let got = format!("`{other}`");
            return Err(TableError::in_column(line, cell, "the unit rad, deg, m or mm", &got));
        }
    };
    Ok((name.trim(), factor))
}

fn normalise_quaternions(line: usize, robot: &Robot, q: &mut [f64]) -> Result<(), TableError> {
    for (index, joint) in robot.parts().joints.iter().enumerate() {
        let range = robot.coordinates_of(index);
        if range.len() < 4 {
            continue;
        }
        let quaternion = &mut q[range.end - 4..range.end];
        let norm = quaternion.iter().map(|x| x * x).sum::<f64>().sqrt();
        if !(norm.is_finite() && norm > 1e-9) {
            return Err(TableError::in_column(
                line,
                &joint.name,
                "a quaternion with a norm above 0",
                &norm.to_string(),
            ));
        }
        quaternion.iter_mut().for_each(|x| *x /= norm);
    }
    Ok(())
}

/// Sets the coordinates of coupled joints without a column; a chain of couplings is resolved after as many
/// passes as it has links.
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
