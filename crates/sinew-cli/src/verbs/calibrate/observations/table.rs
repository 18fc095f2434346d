//! Tables of our own: `time_s,marker,x_m,y_m,z_m`, a row for every sighting.

use super::super::tables::rows;
use super::observed::{Observed, Track};
use crate::table_error::TableError;
use crate::verbs::numeric_table::parse_number;
use std::collections::BTreeMap;

const NAMES: [&str; 5] = ["time_s", "marker", "x_m", "y_m", "z_m"];

pub(super) fn read(text: &str) -> Result<Observed, TableError> {
    let mut tracks: Vec<Track> = Vec::new();
    let mut places = BTreeMap::new();
    for (line, cells) in rows(text, &NAMES)? {
        let number = |k: usize| parse_number(line, NAMES[k], &cells[k]);
        let point = (number(0)?, [number(2)?, number(3)?, number(4)?]);
        let name = &cells[1];
        let place = *places.entry(name.clone()).or_insert_with(|| {
            tracks.push(Track { name: name.clone(), frame: String::new(), points: Vec::new() });
            tracks.len() - 1
        });
        tracks[place].points.push(point);
    }
    Ok(Observed { unit: None, tracks })
}
