//! A pose in which a machine rested before a camera.

/// Mean of what was seen of a marker at a place.
#[derive(Debug, Clone, Copy, PartialEq)]
pub struct Seen {
    /// Index of the marker.
    pub marker: usize,
    /// In the camera's frame, m.
    pub position: [f64; 3],
}

/// A pose in which the machine rested.
#[derive(Debug, Clone, PartialEq)]
pub struct Place {
    /// From when, until when, s, by the clock of the readings.
    pub time: [f64; 2],
    /// Mean readings, rad or m: `[joints]`.
    pub reading: Vec<f64>,
    /// What was seen.
    pub seen: Vec<Seen>,
    /// Place of the camera.
    pub epoch: usize,
}
