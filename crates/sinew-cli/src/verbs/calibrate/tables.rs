//! Tables of poses, readings and observations.

use crate::csv_text::Csv;
use crate::error::Error;
use crate::table_error::TableError;
use crate::verbs::numeric_table::{data_lines, parse_header, parse_number, split_cells};
use crate::verbs::read_text;
use crate::verbs::recording::{is_recording, read_bytes, recording};
use sinew::machine::{Machine, Marker};
use sinew_identify::geometry::{Frame, Readings};
use sinew_lab::vision::CalibrationPoses;
use std::path::Path;

/// Interval of readings that are taken from a recording, s.
const INTERVAL_S: f64 = 0.01;

fn joints(machine: &Machine) -> Vec<String> {
    let joints = machine.robot.independent_joints().into_iter();
    joints.map(|joint| machine.robot.parts().joints[joint].name.clone()).collect()
}

/// Waypoints with a rest in every pose, from the start and back.
pub(super) fn poses(
    machine: &Machine,
    poses: &CalibrationPoses,
    arrivals: &[f64],
    end: f64,
) -> Result<String, Error> {
    let mut table = Csv::new();
    let mut row = |time: f64, pose: &[f64]| {
        table.row(std::iter::once(format!("{time:.3}")).chain(pose.iter().map(|x| format!("{x:.6}"))))
    };
    row(0.0, &machine.start)?;
    for (k, (pose, arrival)) in poses.poses.iter().zip(arrivals).enumerate() {
        row(*arrival, pose)?;
        // The rest is that of the motion.
        let next = arrivals.get(k + 1).copied().unwrap_or(end);
        row((arrival + 1.2).min(next - 0.1), pose)?;
    }
    row(end, &machine.start)?;
    let head = std::iter::once("time_s".to_owned()).chain(joints(machine)).collect::<Vec<_>>().join(",");
    Ok(format!("{head}\n{}", table.text()?))
}

/// Readings of the encoders.
pub(super) fn readings(machine: &Machine, readings: &Readings) -> Result<String, Error> {
    let mut table = Csv::new();
    table.row(std::iter::once("time_s".to_owned()).chain(joints(machine)))?;
    for (time, joint) in readings.time.iter().zip(&readings.joint) {
        table.row(std::iter::once(format!("{time:.4}")).chain(joint.iter().map(|x| format!("{x:.7}"))))?;
    }
    Ok(format!("# SIMULATED by sinew calibrate\n{}", table.text()?))
}

/// What a camera saw.
pub(super) fn observations(markers: &[Marker], frames: &[Frame]) -> Result<String, Error> {
    let mut table = Csv::new();
    table.row(["time_s", "marker", "x_m", "y_m", "z_m"])?;
    for frame in frames {
        let [x, y, z] = frame.position.map(|x| format!("{x:.6}"));
        table.row([format!("{:.4}", frame.time), markers[frame.marker].name.clone(), x, y, z])?;
    }
    Ok(format!("# SIMULATED by sinew calibrate\n{}", table.text()?))
}

/// Readings of a recording or of a table.
pub(super) struct Recorded {
    pub(super) readings: Readings,
    pub(super) simulated: bool,
    /// Where their clock is 0, ns since 1970; 0 where it is not known.
    pub(super) start_ns: i64,
}

pub(super) fn read_readings(machine: &Machine, file: &Path) -> Result<Recorded, Error> {
    if is_recording(file) {
        return recorded(machine, file);
    }
    let text = read_text(file)?;
    let parse = || -> Result<Readings, TableError> {
        let names = joints(machine);
        let wanted: Vec<&str> = std::iter::once("time_s").chain(names.iter().map(String::as_str)).collect();
        let mut readings = Readings::default();
        for (line, cells) in rows(&text, &wanted)? {
            let numbers = cells.iter().zip(&wanted).map(|(cell, name)| parse_number(line, name, cell));
            let numbers: Vec<f64> = numbers.collect::<Result<_, _>>()?;
            if readings.time.last().is_some_and(|last| numbers[0] <= *last) {
                return Err(TableError::in_column(
                    line,
                    "time_s",
                    "increasing times",
                    &numbers[0].to_string(),
                ));
            }
            readings.time.push(numbers[0]);
            readings.joint.push(numbers[1..].to_vec());
        }
        if readings.time.len() < 2 {
            return Err(TableError::in_line(1, "at least 2 rows", readings.time.len().to_string()));
        }
        Ok(readings)
    };
    let readings = parse().map_err(Error::table(file))?;
    Ok(Recorded { readings, simulated: text.starts_with("# SIMULATED"), start_ns: 0 })
}

fn recorded(machine: &Machine, file: &Path) -> Result<Recorded, Error> {
    let bytes = read_bytes(file)?;
    let recording = recording(file, &bytes)?;
    let head = &recording.head;
    let column = |name: &String| {
        let of = |joint: &&sinew_record::JointColumn| joint.name == *name;
        let unit = head.joints.iter().find(of).map_or("rad", |joint| joint.unit.as_str());
        head.fast.iter().position(|column| column.name == format!("joint_{unit}:{name}"))
    };
    let names = joints(machine);
    let columns: Option<Vec<usize>> = names.iter().map(column).collect();
    let columns = columns.ok_or_else(|| Error::Argument {
        flag: "RECORDING",
        value: file.display().to_string(),
        expected: "a recording of this machine, with its joints",
    })?;
    let every = (INTERVAL_S / head.period_s()).round().max(1.0) as u64;
    let mut readings = Readings::default();
    for block in recording.blocks() {
        let block = block.map_err(Error::recording(file))?;
        for cycle in 0..block.count {
            let index = block.first + cycle as u64;
            let at = |column: &usize| block.fast[*column].get(cycle).copied().unwrap_or(f64::NAN);
            let joint: Vec<f64> = columns.iter().map(at).collect();
            if index.is_multiple_of(every) && joint.iter().all(|x| x.is_finite()) {
                readings.time.push(index as f64 * head.period_s());
                readings.joint.push(joint);
            }
        }
    }
    if readings.time.len() < 2 {
        let value = file.display().to_string();
        return Err(Error::Argument {
            flag: "RECORDING",
            value,
            expected: "one with readings of all joints",
        });
    }
    Ok(Recorded { readings, simulated: head.simulated, start_ns: head.start_ns as i64 })
}

/// The cells of the named columns of every row, with its line.
pub(super) fn rows(text: &str, names: &[&str]) -> Result<Vec<(usize, Vec<String>)>, TableError> {
    let mut lines = data_lines(text);
    let expected = || format!("the columns {}", names.join(", "));
    let Some((line, header)) = lines.next() else {
        return Err(TableError::in_line(1, expected(), "an empty table"));
    };
    let (separator, header) = parse_header(line, header)?;
    let place = |name: &&str| {
        let found = header.iter().position(|column| column == name);
        found.ok_or_else(|| TableError::in_line(line, format!("a column `{name}`"), header.join(", ")))
    };
    let places: Vec<usize> = names.iter().map(place).collect::<Result<_, _>>()?;
    let row = |(line, content)| {
        let cells = split_cells(line, content, separator)?;
        let cell = |place: &usize| cells.get(*place).cloned().unwrap_or_default();
        Ok((line, places.iter().map(cell).collect()))
    };
    lines.map(row).collect()
}
