//! What both ends of a cable do: corners in time, even motion between them.

use crate::error::Error;
use crate::verbs::numeric_table;
use std::path::Path;

/// Corners: time, s, and position of motor and anchor, m.
pub(super) struct Scenario {
    corners: Vec<[f64; 3]>,
}

const COLUMNS: [&str; 3] = ["time_s", "motor_m", "anchor_m"];
/// Longest scenario, s.
const LONGEST_S: f64 = 3600.0;
/// Fastest end, m/s: beyond it a step of the cable's law is no small one.
const FASTEST_M_PER_S: f64 = 5.0;

impl Scenario {
    /// Pull, hold, yield until slack, pull again; the anchor stands.
    pub(super) fn default_scenario() -> Self {
        let corner = |time, motor| [time, motor, 0.0];
        let corners =
            [(0.0, 0.0), (1.0, 0.06), (2.0, 0.06), (5.0, -0.06), (5.5, -0.06), (8.0, 0.05), (9.0, 0.05)];
        Self { corners: corners.map(|(time, motor)| corner(time, motor)).to_vec() }
    }

    /// Two pulls of different reach with the anchor held, slow enough to see every front; never slack.
    pub(super) fn two_pulls() -> Self {
        let corners = [(0.0, 0.0), (2.0, 0.06), (5.0, -0.03), (8.0, 0.06), (10.0, 0.0), (12.0, 0.06)];
        Self { corners: corners.map(|(time, motor)| [time, motor, 0.0]).to_vec() }
    }

    pub(super) fn read(path: &Path) -> Result<Self, Error> {
        let wrong = |problem: String| Error::File { file: path.to_owned(), problem };
        let mut corners: Vec<[f64; 3]> = Vec::new();
        for (line, corner) in numeric_table::read(path, COLUMNS)? {
            check(&corner, corners.last()).map_err(|problem| wrong(format!("line {line}, {problem}")))?;
            corners.push(corner);
        }
        if corners.len() < 2 {
            return Err(wrong(format!("has {} corners: expected at least two", corners.len())));
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
        let share = ((time - a[0]) / (b[0] - a[0])).clamp(0.0, 1.0);
        [a[1] + share * (b[1] - a[1]), a[2] + share * (b[2] - a[2])]
    }
}

fn check(corner: &[f64; 3], last: Option<&[f64; 3]>) -> Result<(), String> {
    let time = corner[0];
    let Some(last) = last else {
        return if time == 0.0 {
            Ok(())
        } else {
            Err(format!("column `time_s`: {time}: expected 0 to begin with"))
        };
    };
    if time <= last[0] || time > LONGEST_S {
        return Err(format!(
            "column `time_s`: {time}: expected more than {} and at most {LONGEST_S}",
            last[0]
        ));
    }
    for (k, name) in COLUMNS.iter().enumerate().skip(1) {
        let speed = (corner[k] - last[k]).abs() / (time - last[0]);
        if speed > FASTEST_M_PER_S {
            return Err(format!(
                "column `{name}`: a speed of {speed:.1} m/s: expected at most {FASTEST_M_PER_S}"
            ));
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
    fn ends_move_evenly_between_corners() {
        let scenario = read("# my cable\nmotor_m,time_s,anchor_m\n0,0,0\n0.1,2,-0.02\n").unwrap();
        let near = |at: [f64; 2], wanted: [f64; 2]| at.iter().zip(wanted).all(|(a, b)| (a - b).abs() < 1e-15);
        assert!(near(scenario.at(1.0), [0.05, -0.01]) && near(scenario.at(9.0), [0.1, -0.02]));
        assert!((scenario.duration() - 2.0).abs() < 1e-15);
    }

    #[test]
    fn what_is_wrong_is_named_with_its_place() {
        for (text, told) in [
            ("", "is empty"),
            ("time_s,motor_m\n0,0\n", "no column `anchor_m`"),
            ("time_s,motor_m,anchor_m\n0,0,0\n1,nan,0\n", "line 3, column `motor_m`: `nan`"),
            ("time_s,motor_m,anchor_m\n0,0,0\n1,0\n", "line 3, column `anchor_m`: ``"),
            ("time_s,motor_m,anchor_m\n0,0,0\n0,0,0\n", "line 3, column `time_s`: 0"),
            ("time_s,motor_m,anchor_m\n1,0,0\n", "expected 0 to begin with"),
            ("time_s,motor_m,anchor_m\n0,0,0\n0.001,1,0\n", "a speed of 1000.0 m/s"),
            ("time_s,motor_m,anchor_m\n0,0,0\n", "has 1 corners"),
        ] {
            let error = read(text).err().unwrap();
            assert!(error.contains(told), "{error}");
        }
    }
}
