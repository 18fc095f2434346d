//! What a camera saw, by files of several programs.

mod marker_table;
mod motive;
mod observed;
mod table;
#[cfg(test)]
mod tests;
mod trc;

use super::tables::Recorded;
use crate::error::Error;
use crate::table_error::TableError;
use crate::verbs::read_text;
use crate::verbs::recording::{is_recording, read_bytes};
use observed::{Observed, Track};
use sinew::machine::Marker;
use sinew_identify::geometry::Frame;
use std::collections::BTreeSet;
use std::path::{Path, PathBuf};

/// Largest difference of the clocks that the estimate finds by itself, s.
const LARGEST_DELAY_S: f64 = 2.0;
/// Stamps above are of a clock that began in 1970, s and ns.
const SINCE_1970_S: f64 = 1e9;
const SINCE_1970_NS: i64 = 1_000_000_000_000_000_000;

/// What is known beside the files.
pub(super) struct Beside<'a> {
    pub(super) recorded: &'a Recorded,
    /// `--unit`, m.
    pub(super) unit: Option<f64>,
    /// `--clock`, s.
    pub(super) clock: Option<f64>,
}

/// The frames of the wanted markers in all files, in m and near the clock of the readings.
///
/// Markers of the base are not wanted where they are those that a user did not name, and the files have none
/// of them.
pub(super) fn read(
    markers: &mut Vec<Marker>,
    named_base: bool,
    files: &[PathBuf],
    beside: &Beside<'_>,
) -> Result<Vec<Frame>, Error> {
    let (mut tracks, mut seen) = (Vec::new(), BTreeSet::new());
    for file in files {
        for track in in_metres(file, beside)? {
            seen.insert(track.name.clone());
            tracks.push((file, track));
        }
    }
    if !named_base && !markers.iter().any(|marker| marker.body == 0 && seen.contains(&marker.name)) {
        markers.retain(|marker| marker.body != 0);
    }
    let wanted = |name: &str| markers.iter().position(|marker| marker.name == name);
    let missing: Vec<&str> =
        markers.iter().map(|marker| marker.name.as_str()).filter(|name| !seen.contains(*name)).collect();
    if !missing.is_empty() {
        let names: Vec<String> = files.iter().map(|file| file.display().to_string()).collect();
        let found: Vec<&str> = seen.iter().map(String::as_str).collect();
        return Err(Error::Shown(format!(
            "{}: expected the markers {}, got {}; --marker and --base-tag name them",
            names.join(", "),
            missing.join(", "),
            if found.is_empty() { "none".to_owned() } else { found.join(", ") },
        )));
    }
    let (mut frames, mut once) = (Vec::new(), BTreeSet::new());
    let mut of_frame: Option<(String, String)> = None;
    for (file, track) in tracks {
        let Some(marker) = wanted(&track.name) else { continue };
        if !once.insert((file, track.name.clone())) && track.frame.is_empty() {
            let expected = format!("{}: expected marker {} once, got it twice", file.display(), track.name);
            return Err(Error::Shown(expected));
        }
        // What was seen in two frames has two places.
        let (first, frame) = of_frame.get_or_insert_with(|| (track.name.clone(), track.frame.clone()));
        if *frame != track.frame {
            return Err(Error::Shown(format!(
                "{}: expected all markers in one frame, got {first} in `{frame}` and {} in `{}`",
                file.display(),
                track.name,
                track.frame
            )));
        }
        frames.extend(track.points.into_iter().map(|(time, position)| Frame { time, marker, position }));
    }
    let ignored: Vec<&str> = seen.iter().map(String::as_str).filter(|name| wanted(name).is_none()).collect();
    if !ignored.is_empty() {
        tell!(
            "warning: markers that neither --marker nor --base-tag names are ignored: {}",
            ignored.join(", ")
        );
    }
    frames.sort_by(|a, b| a.time.total_cmp(&b.time).then(a.marker.cmp(&b.marker)));
    within_reach(&frames, beside.recorded)?;
    Ok(frames)
}

/// Stamps in other units last this many times as long as the readings, within a third.
const OTHER_CLOCKS: [(f64, &str); 3] = [(1e3, "ms"), (1e6, "us"), (1e9, "ns")];

fn near(value: f64, expected: f64) -> bool {
    (0.67 * expected..=1.5 * expected).contains(&value)
}

/// Refuses stamps that no delay brings to the readings.
fn within_reach(frames: &[Frame], recorded: &Recorded) -> Result<(), Error> {
    let ends = |times: [Option<f64>; 2]| times.map(|time| time.unwrap_or(f64::NAN));
    let [from, to] = ends([frames.first(), frames.last()].map(|frame| frame.map(|frame| frame.time)));
    let time = &recorded.readings.time;
    let [begin, end] = ends([time.first().copied(), time.last().copied()]);
    let times_as_long = (to - from) / (end - begin);
    if let Some((factor, unit)) = OTHER_CLOCKS.iter().find(|(factor, _)| near(times_as_long, *factor)) {
        return Err(Error::Shown(format!(
            "--observations: expected stamps in s, got stamps that last about {factor} times as long as the \
             readings: {unit}"
        )));
    }
    if to < begin - LARGEST_DELAY_S || from > end + LARGEST_DELAY_S {
        return Err(Error::Shown(format!(
            "--observations: expected stamps within {LARGEST_DELAY_S} s of the readings, {begin:.3} to {end:.3} s, got \
             {from:.3} to {to:.3} s; --clock tells what the observations' clock shows where that of the readings is 0"
        )));
    }
    Ok(())
}

/// The tracks of a file, lengths in m.
fn in_metres(file: &Path, beside: &Beside<'_>) -> Result<Vec<Track>, Error> {
    let Observed { unit, mut tracks } = if is_recording(file) {
        of_bag(file, &read_bytes(file)?, beside)?
    } else {
        let mut observed = of_text(&read_text(file)?).map_err(Error::table(file))?;
        let first = observed.tracks.iter().flat_map(|track| &track.points).map(|point| point.0);
        let since_1970 = first.fold(f64::INFINITY, f64::min) > SINCE_1970_S;
        let start = || since_1970.then(|| beside.recorded.start_ns as f64 / 1e9);
        let zero = beside.clock.or_else(start).unwrap_or(0.0);
        observed.tracks.iter_mut().flat_map(|track| &mut track.points).for_each(|point| point.0 -= zero);
        observed
    };
    let metres = match (unit, beside.unit) {
        (Some((own, name)), Some(given)) if (own - given).abs() > 1e-9 * own => {
            return Err(Error::Shown(format!(
                "--unit {given}: expected {own}, which {} has: {name}",
                file.display()
            )));
        }
        (Some((own, _)), _) => own,
        (None, given) => given.unwrap_or(1.0),
    };
    let lengths = tracks.iter_mut().flat_map(|track| &mut track.points).flat_map(|(_, position)| position);
    lengths.for_each(|x| *x *= metres);
    Ok(tracks)
}

/// A text by its first words.
fn of_text(text: &str) -> Result<Observed, TableError> {
    let text = text.trim_start_matches('\u{feff}');
    match text.trim_start() {
        begin if begin.starts_with("PathFileType") => trc::read(text),
        begin if begin.starts_with("Format Version") => motive::read(text),
        _ => table::read(text),
    }
}

fn of_bag(file: &Path, bytes: &[u8], beside: &Beside<'_>) -> Result<Observed, Error> {
    let tracks = sinew_record::ros2_tracks(bytes).map_err(Error::recording(file))?;
    let first = tracks.iter().flat_map(|track| &track.points).map(|point| point.0).min();
    let since_1970 = first.is_some_and(|first| first > SINCE_1970_NS);
    let start = if since_1970 { beside.recorded.start_ns } else { 0 };
    let zero = beside.clock.map_or(start, |clock| (clock * 1e9).round() as i64);
    // In this order: a whole number of ns and its decimal fraction are then the same time.
    let seconds = |ns: i64| ns.saturating_sub(zero) as f64 / 1e9;
    let track = |track: sinew_record::Track| Track {
        name: track.name,
        frame: track.frame,
        points: track.points.into_iter().map(|(ns, position)| (seconds(ns), position)).collect(),
    };
    let tracks = tracks.into_iter().map(track).collect();
    Ok(Observed { unit: Some((1.0, "m, as ROS has them".to_owned())), tracks })
}
