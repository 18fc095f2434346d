//! Tables of poses, readings and observations.

use crate::csv_text::Csv;
use crate::error::Error;
use crate::table_error::TableError;
use crate::verbs::numeric_table::{data_lines, parse_header, parse_number, split_cells};
use crate::verbs::read_text;
use crate::verbs::recording::{is_recording, read_bytes, recording};
use sinew::machine::{Machine, Marker};
use sinew_identify::geometry::{CableReadings, Frame, Readings};
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

/// Columns of the cables, as in tables of a run.
const CABLES: [&str; 3] = ["position_in_m", "tension_in_n", "tension_out_estimated_n"];

fn cable_columns(machine: &Machine) -> Vec<String> {
    let names = || machine.robot.parts().tendons.iter().map(|tendon| tendon.name.as_str());
    CABLES.iter().flat_map(|signal| names().map(move |name| format!("{signal}:{name}"))).collect()
}

/// Readings of the encoders, and those of the cables where they are asked for.
pub(super) fn readings(
    machine: &Machine,
    readings: &Readings,
    cables: Option<&CableReadings>,
) -> Result<String, Error> {
    let mut table = Csv::new();
    let beside = cables.map(|_| cable_columns(machine)).unwrap_or_default();
    table.row(std::iter::once("time_s".to_owned()).chain(joints(machine)).chain(beside))?;
    for (k, (time, joint)) in readings.time.iter().zip(&readings.joint).enumerate() {
        let beside = cables.into_iter().flat_map(|all| [&all.position, &all.tension_in, &all.tension_out]);
        let beside = beside.filter_map(|rows| rows.get(k)).flatten();
        let numbers = joint.iter().chain(beside).map(|x| format!("{x:.7}"));
        table.row(std::iter::once(format!("{time:.4}")).chain(numbers))?;
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
    /// Empty where they were not asked for.
    pub(super) cables: CableReadings,
    pub(super) simulated: bool,
    /// Where their clock is 0, ns since 1970; 0 where it is not known.
    pub(super) start_ns: i64,
}

/// Splits a row into joints and cables, which are there or not.
fn add(readings: &mut Readings, cables: &mut CableReadings, time: f64, mut row: Vec<f64>, joints: usize) {
    let beside = row.split_off(joints);
    readings.time.push(time);
    readings.joint.push(row);
    let muscles = beside.len() / CABLES.len();
    if muscles > 0 {
        let mut of = beside.chunks_exact(muscles).map(<[f64]>::to_vec);
        for rows in [&mut cables.position, &mut cables.tension_in, &mut cables.tension_out] {
            rows.extend(of.next());
        }
    }
}

pub(super) fn read_readings(machine: &Machine, file: &Path, cables: bool) -> Result<Recorded, Error> {
    let names = joints(machine);
    let count = names.len();
    let beside = if cables { cable_columns(machine) } else { Vec::new() };
    if is_recording(file) {
        return recorded(&names, &beside, file);
    }
    let text = read_text(file)?;
    let parse = || -> Result<(Readings, CableReadings), TableError> {
        let names = names.iter().chain(&beside).map(String::as_str);
        let wanted: Vec<&str> = std::iter::once("time_s").chain(names).collect();
        let (mut readings, mut cables) = (Readings::default(), CableReadings::default());
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
            add(&mut readings, &mut cables, numbers[0], numbers[1..].to_vec(), count);
        }
        if readings.time.len() < 2 {
            return Err(TableError::in_line(1, "at least 2 rows", readings.time.len().to_string()));
        }
        Ok((readings, cables))
    };
    let (readings, cables) = parse().map_err(Error::table(file))?;
    Ok(Recorded { readings, cables, simulated: text.starts_with("# SIMULATED"), start_ns: 0 })
}

/// The columns of joints and cables of a recording.
fn recorded(joints: &[String], cables: &[String], file: &Path) -> Result<Recorded, Error> {
    let bytes = read_bytes(file)?;
    let recording = recording(file, &bytes)?;
    let head = &recording.head;
    // Slow columns behind the fast ones.
    let place = |name: &str| {
        let all = head.fast.iter().chain(&head.slow);
        all.clone().position(|column| column.name == name)
    };
    let joint = |name: &String| {
        let of = |joint: &&sinew_record::JointColumn| joint.name == *name;
        let unit = head.joints.iter().find(of).map_or("rad", |joint| joint.unit.as_str());
        place(&format!("joint_{unit}:{name}"))
    };
    let columns: Option<Vec<usize>> =
        joints.iter().map(joint).chain(cables.iter().map(|name| place(name))).collect();
    let columns = columns.ok_or_else(|| Error::Argument {
        flag: "RECORDING",
        value: file.display().to_string(),
        expected: "a recording of this machine, with its joints and cables",
    })?;
    let every = (INTERVAL_S / head.period_s()).round().max(1.0) as u64;
    // What is kept less often tells when.
    let every = if cables.is_empty() { every } else { head.stride };
    let (mut readings, mut read) = (Readings::default(), CableReadings::default());
    for block in recording.blocks() {
        let block = block.map_err(Error::recording(file))?;
        for cycle in 0..block.count {
            let index = block.first + cycle as u64;
            if !index.is_multiple_of(every) {
                continue;
            }
            let slow = block.slow_row(cycle, head.stride);
            let at = |column: &usize| {
                let value = match column.checked_sub(head.fast.len()) {
                    None => block.fast[*column].get(cycle),
                    Some(column) => slow.and_then(|row| block.slow[column].get(row)),
                };
                value.copied().unwrap_or(f64::NAN)
            };
            let row: Vec<f64> = columns.iter().map(at).collect();
            if row.iter().all(|x| x.is_finite()) {
                add(&mut readings, &mut read, index as f64 * head.period_s(), row, joints.len());
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
    let start_ns = head.start_ns as i64;
    Ok(Recorded { readings, cables: read, simulated: head.simulated, start_ns })
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
