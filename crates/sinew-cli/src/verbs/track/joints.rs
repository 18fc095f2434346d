//! Poses of the independent joints, from a table or from the command line.

use super::waypoints::check_time;
use crate::error::Error;
use crate::table_error::TableError;
use crate::verbs::numeric_table::{data_lines, parse_header, parse_number, split_cells};
use crate::verbs::read_text;
use sinew::machine::Machine;
use sinew::trajectory::{JointWaypoint, through_joint_waypoints};
use std::path::Path;

const TIME: &str = "time_s";

/// The start pose with some joints at other positions.
pub(super) fn pose(machine: &Machine, joints: &[(String, f64)]) -> Result<Vec<f64>, Error> {
    let names = independent_names(machine);
    let mut pose = machine.start.clone();
    for (name, value) in joints {
        let Some(place) = names.iter().position(|known| known == name) else {
            return Err(Error::unknown("--path", &format!("to-joints:{name}={value}"), "joint", names));
        };
        pose[place] = *value;
    }
    Ok(pose)
}

/// At least two poses in ascending time; joints without a column stay at the start pose.
pub(super) fn read(machine: &Machine, file: &Path) -> Result<Vec<JointWaypoint>, Error> {
    let points = parse(machine, &read_text(file)?).map_err(Error::table(file))?;
    if points.len() < 2 {
        return Err(Error::TooFewRows { file: file.to_owned(), what: "poses", got: points.len() });
    }
    through_joint_waypoints(&points)
        .map_err(|source| Error::Waypoints { file: file.to_owned(), source: source.into() })?;
    Ok(points)
}

fn parse(machine: &Machine, text: &str) -> Result<Vec<JointWaypoint>, TableError> {
    let names = independent_names(machine);
    let mut lines = data_lines(text);
    let Some((line, header)) = lines.next() else {
        return Err(TableError::in_line(1, format!("{TIME} and names of joints"), "an empty table"));
    };
    let (separator, columns) = parse_header(line, header)?;
    let places = places(line, &columns, &names)?;
    let mut points: Vec<JointWaypoint> = Vec::new();
    for (line, row) in lines {
        let cells = split_cells(line, row, separator)?;
        if cells.len() != columns.len() {
            let expected = format!("{} cells, one per column", columns.len());
            return Err(TableError::in_line(line, expected, cells.len().to_string()));
        }
        let mut point = JointWaypoint { time: 0.0, q: machine.start.clone() };
        for ((cell, column), place) in cells.iter().zip(&columns).zip(&places) {
            let number = parse_number(line, column, cell)?;
            *place.map_or(&mut point.time, |joint| &mut point.q[joint]) = number;
        }
        let ends = points.first().zip(points.last()).map(|(first, last)| [first.time, last.time]);
        check_time(point.time, ends)
            .map_err(|expected| TableError::in_column(line, TIME, expected, &point.time.to_string()))?;
        points.push(point);
    }
    Ok(points)
}

/// The joint of every column; none for the time.
fn places(line: usize, columns: &[String], names: &[String]) -> Result<Vec<Option<usize>>, TableError> {
    let mut places = Vec::new();
    for column in columns {
        let place = names.iter().position(|name| name == column);
        if place.is_none() && column != TIME {
            let expected = format!("{TIME} or an independent joint: {}", names.join(", "));
            return Err(TableError::in_column(line, column, expected, "another name"));
        }
        if places.contains(&place) {
            return Err(TableError::in_column(line, column, "it once", "it twice"));
        }
        places.push(place);
    }
    if !places.contains(&None) {
        return Err(TableError::in_line(line, format!("a column `{TIME}`"), columns.join(", ")));
    }
    if places.len() < 2 {
        return Err(TableError::in_line(line, "a column of a joint beside the time", "none"));
    }
    Ok(places)
}

fn independent_names(machine: &Machine) -> Vec<String> {
    let joints = &machine.robot.parts().joints;
    machine.robot.independent_joints().into_iter().map(|joint| joints[joint].name.clone()).collect()
}
