//! Prescribed motion of both ends of a cable: piecewise linear in time.

use crate::error::Error;
use crate::table_error::TableError;
use crate::verbs::numeric_table;
use std::path::Path;

/// Corners: time, s, and position of motor and anchor, m.
pub(super) struct Scenario {
    corners: Vec<[f64; 3]>,
}

const COLUMNS: [&str; 3] = ["time_s", "motor_m", "anchor_m"];
/// Longest scenario, s.
const MAX_DURATION_S: f64 = 3600.0;
/// Largest speed of an end, m/s: beyond it the cable's law is not integrated accurately with the step of the
/// log.
const MAX_SPEED_M_PER_S: f64 = 5.0;

impl Scenario {
    /// The motor winds in, rests, pays out until the cable is slack and winds in again; the anchor is fixed.
    pub(super) fn default_scenario() -> Self {
        let corner = |time, motor| [time, motor, 0.0];
        let corners =
            [(0.0, 0.0), (1.0, 0.06), (2.0, 0.06), (5.0, -0.06), (5.5, -0.06), (8.0, 0.05), (9.0, 0.05)];
        Self { corners: corners.map(|(time, motor)| corner(time, motor)).to_vec() }
    }

    /// Two strokes of different amplitude, the anchor fixed; slow enough that each slip front is resolved,
    /// never slack.
    pub(super) fn two_strokes() -> Self {
        let corners = [(0.0, 0.0), (2.0, 0.06), (5.0, -0.03), (8.0, 0.06), (10.0, 0.0), (12.0, 0.06)];
        Self { corners: corners.map(|(time, motor)| [time, motor, 0.0]).to_vec() }
    }

    pub(super) fn read(path: &Path) -> Result<Self, Error> {
        let mut corners: Vec<[f64; 3]> = Vec::new();
        for (line, corner) in numeric_table::read(path, COLUMNS)? {
            check(line, &corner, corners.last()).map_err(Error::table(path))?;
            corners.push(corner);
        }
        if corners.len() < 2 {
            return Err(Error::TooFewRows { file: path.to_owned(), what: "corners", got: corners.len() });
        }
        Ok(Self { corners })
    }

    pub(super) fn duration(&self) -> f64 {
        self.corners.last().map_or(0.0, |corner| corner[0])
    }

    /// Position of motor and anchor, m.
    pub(super) fn at(&self, time: f64) -> [f64; 2] {
        let after = self.corners.partition_point(|corner| corner[0] < time).clamp(1, self.corners.len() - 1);
        let (a, b) = (self.corners[after - 1], self.corners[after]);
        let fraction = ((time - a[0]) / (b[0] - a[0])).clamp(0.0, 1.0);
        [a[1] + fraction * (b[1] - a[1]), a[2] + fraction * (b[2] - a[2])]
    }
}

/// A corner after the one before: time ascends from 0, and no end exceeds the largest speed.
fn check(line: usize, corner: &[f64; 3], last: Option<&[f64; 3]>) -> Result<(), TableError> {
    let refuse = |column: usize, expected: String, got: f64| {
        Err(TableError::in_column(line, COLUMNS[column], expected, &got.to_string()))
    };
    let time = corner[0];
    let Some(last) = last else {
        return if time == 0.0 { Ok(()) } else { refuse(0, "0 in the first row".to_owned(), time) };
    };
    if time <= last[0] || time > MAX_DURATION_S {
        return refuse(0, format!("more than {} and at most {MAX_DURATION_S}", last[0]), time);
    }
    for column in 1..COLUMNS.len() {
        let speed = (corner[column] - last[column]).abs() / (time - last[0]);
        if speed > MAX_SPEED_M_PER_S {
            return refuse(column, format!("a speed of at most {MAX_SPEED_M_PER_S} m/s"), speed);
        }
    }
    Ok(())
}

#[cfg(test)]
mod tests {
    use super::*;

    fn read(text: &str) -> Result<Scenario, String> {
        let file = tempfile::NamedTempFile::new().unwrap();
        std::fs::write(file.path(), text).unwrap();
        Scenario::read(file.path()).map_err(|e| e.to_string())
    }

    #[test]
    fn positions_are_linear_between_corners() {
        let scenario = read("# my cable\nmotor_m,time_s,anchor_m\n0,0,0\n0.1,2,-0.02\n").unwrap();
        let near =
            |at: [f64; 2], expected: [f64; 2]| at.iter().zip(expected).all(|(a, b)| (a - b).abs() < 1e-15);
        assert!(near(scenario.at(1.0), [0.05, -0.01]) && near(scenario.at(9.0), [0.1, -0.02]));
        assert!((scenario.duration() - 2.0).abs() < 1e-15);
    }

    #[test]
    fn a_refused_row_is_named_with_its_place() {
        for (text, part) in [
            ("", "got an empty table"),
            ("time_s,motor_m\n0,0\n", "expected a column `anchor_m`"),
            (
                "time_s,motor_m,anchor_m\n0,0,0\n1,nan,0\n",
                "line 3, column `motor_m`: expected a finite number, got `nan`",
            ),
            (
                "time_s,motor_m,anchor_m\n0,0,0\n1,0\n",
                "line 3, column `anchor_m`: expected a finite number, got an empty cell",
            ),
            ("time_s,motor_m,anchor_m\n0,0,0\n0,0,0\n", "line 3, column `time_s`: expected more than 0"),
            ("time_s,motor_m,anchor_m\n1,0,0\n", "expected 0 in the first row, got 1"),
            ("time_s,motor_m,anchor_m\n0,0,0\n0.001,1,0\n", "expected a speed of at most 5 m/s, got 1000"),
            ("time_s,motor_m,anchor_m\n0,0,0\n", "expected at least 2 corners, got 1"),
        ] {
            let error = read(text).err().unwrap();
            assert!(error.contains(part), "{error}");
        }
    }
}
