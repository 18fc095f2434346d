//! Places at rest, each one observation, from readings of encoders and sightings of a camera with
//! another clock.

use super::place::{Place, Seen};
use super::{GeometryError, GeometryModel};

/// Readings of the encoders in time.
#[derive(Debug, Clone, PartialEq, Default)]
pub struct Readings {
    /// s, increasing: `[n]`.
    pub time: Vec<f64>,
    /// rad or m: `[n][joints]`, of the independent joints.
    pub joint: Vec<Vec<f64>>,
}

/// A marker in a frame of a camera.
#[derive(Debug, Clone, Copy, PartialEq)]
pub struct Frame {
    /// Its stamp, s.
    pub time: f64,
    /// Index of the marker.
    pub marker: usize,
    /// In the camera's frame, m.
    pub position: [f64; 3],
}

/// Largest difference of the two clocks that is searched, s, and the grid of the search.
const LARGEST_DELAY_S: f64 = 2.0;
const DELAY_STEP_S: f64 = 0.01;
/// Shortest rest, the part of it that is left out at its beginning, and the largest motion in it.
const REST_S: f64 = 0.6;
const SETTLING_S: f64 = 0.25;
const STILL_M: f64 = 5e-4;
/// The same as a fraction of the markers' way: encoders toggle by a count, and an arm sinks a little.
const STILL: f64 = 5e-3;
/// Largest gap between two frames of one motion, s.
const GAP_S: f64 = 0.2;
/// Jump of the markers of the base between two places over its median, and its least, by which a camera
/// was moved.
const JUMP: f64 = 8.0;
const LEAST_JUMP_M: f64 = 2.5e-4;

impl Readings {
    /// Interpolated at a time, s; held at the ends.
    pub(super) fn at(&self, time: f64) -> Vec<f64> {
        let after = self.time.partition_point(|t| *t <= time);
        if after == 0 || after == self.time.len() {
            return self.joint[after.saturating_sub(1)].clone();
        }
        let [from, to] = [self.time[after - 1], self.time[after]];
        let part = (time - from) / (to - from).max(1e-12);
        let ends = self.joint[after - 1].iter().zip(&self.joint[after]);
        ends.map(|(a, b)| a + part * (b - a)).collect()
    }
}

/// Time of a frame's stamp minus that of the readings, s: that with which the speeds of the markers
/// agree best,
/// whatever the place of the camera and the machine's geometry; 0 where nothing moves.
///
/// # Errors
/// As [`GeometryModel::sensitivity`].
pub fn speed_delay(
    model: &GeometryModel,
    readings: &Readings,
    frames: &[Frame],
) -> Result<f64, GeometryError> {
    let (mut travelled, mut expected) = (Vec::new(), Vec::new());
    let zero = vec![0.0; model.parameters().len()];
    for (m, marker) in model.markers.iter().enumerate() {
        let wanted = readings.joint.iter().map(|q| (q.as_slice(), vec![(marker.body, marker.position)]));
        let path = model.points(&model.corrections(&zero), wanted)?;
        // Way along the path up to every reading.
        let mut way = vec![0.0; path.len()];
        for k in 1..path.len() {
            way[k] = way[k - 1] + distance(path[k], path[k - 1]);
        }
        if way.last().is_none_or(|all| *all < 0.02) {
            continue;
        }
        let seen: Vec<&Frame> = frames.iter().filter(|frame| frame.marker == m).collect();
        for pair in seen.windows(4) {
            let [a, b] = [pair[0], pair[3]];
            if b.time - a.time < GAP_S {
                travelled.push((m, a.time, b.time, distance(a.position, b.position)));
            }
        }
        expected.push((m, way));
    }
    let cost = |delay: f64| {
        let miss = |&(m, from, to, way): &(usize, f64, f64, f64)| {
            let known = expected.iter().find(|(marker, _)| *marker == m).map_or(0.0, |(_, along)| {
                let at = |t: f64| interpolated(&readings.time, along, t - delay);
                at(to) - at(from)
            });
            (way - known).abs().min(0.02)
        };
        travelled.iter().map(miss).sum::<f64>()
    };
    if travelled.is_empty() {
        return Ok(0.0);
    }
    let steps = (LARGEST_DELAY_S / DELAY_STEP_S) as i32;
    let grid = (-steps..=steps).map(|k| f64::from(k) * DELAY_STEP_S);
    let best = grid.min_by(|a, b| cost(*a).total_cmp(&cost(*b)).then(a.abs().total_cmp(&b.abs())));
    Ok(best.unwrap_or(0.0))
}

/// How far the markers that the readings move are spread in the frames, over how far the readings spread
/// them, whatever the place of the camera; none where nothing moves.
///
/// # Errors
/// As [`GeometryModel::sensitivity`].
pub fn travel_ratio(
    model: &GeometryModel,
    readings: &Readings,
    frames: &[Frame],
) -> Result<Option<f64>, GeometryError> {
    let zero = vec![0.0; model.parameters().len()];
    let (mut seen, mut known) = (0.0, 0.0);
    for (m, marker) in model.markers.iter().enumerate() {
        let wanted = readings.joint.iter().map(|q| (q.as_slice(), vec![(marker.body, marker.position)]));
        let moves = spread(&model.points(&model.corrections(&zero), wanted)?);
        let of_marker = frames.iter().filter(|frame| frame.marker == m).map(|frame| frame.position);
        let of_marker: Vec<[f64; 3]> = of_marker.collect();
        if moves > LEAST_SPREAD_M && !of_marker.is_empty() {
            (seen, known) = (seen + spread(&of_marker), known + moves);
        }
    }
    Ok((known > 0.0).then(|| seen / known))
}

/// Spread of the points of a machine that stands, m.
const LEAST_SPREAD_M: f64 = 5e-3;

/// Median distance of points from the mean of each coordinate's middle half, m.
fn spread(points: &[[f64; 3]]) -> f64 {
    if points.is_empty() {
        return 0.0;
    }
    let middle = |k: usize| {
        let mut along: Vec<f64> = points.iter().map(|point| point[k]).collect();
        along.sort_by(f64::total_cmp);
        0.5 * (along[along.len() / 4] + along[3 * along.len() / 4])
    };
    let centre = [middle(0), middle(1), middle(2)];
    let mut away: Vec<f64> = points.iter().map(|point| distance(*point, centre)).collect();
    away.sort_by(f64::total_cmp);
    away[away.len() / 2]
}

fn interpolated(times: &[f64], values: &[f64], time: f64) -> f64 {
    let after = times.partition_point(|t| *t <= time).clamp(1, times.len() - 1);
    let part = ((time - times[after - 1]) / (times[after] - times[after - 1]).max(1e-12)).clamp(0.0, 1.0);
    values[after - 1] + part * (values[after] - values[after - 1])
}

pub(super) fn distance(a: [f64; 3], b: [f64; 3]) -> f64 {
    (0..3).map(|k| (a[k] - b[k]).powi(2)).sum::<f64>().sqrt()
}

/// The places at rest with what was seen there; `delay`, s, is taken off the stamps.
///
/// # Errors
/// As [`GeometryModel::sensitivity`]; [`GeometryError::Observations`] for fewer than four places.
pub fn places(
    model: &GeometryModel,
    readings: &Readings,
    frames: &[Frame],
    delay: f64,
) -> Result<Vec<Place>, GeometryError> {
    let mut found = Vec::new();
    for time in rest_times(model, readings)? {
        let mut place = place(frames, time, delay, model.markers.len());
        if !place.seen.is_empty() {
            place.reading = mean_reading(readings, time);
            found.push(place);
        }
    }
    if found.len() < 4 {
        let text = format!(
            "expected at least 4 places in which the machine rests for {REST_S} s and a marker is seen, found {}",
            found.len()
        );
        return Err(GeometryError::Observations(text));
    }
    mark_epochs(model, &mut found);
    Ok(found)
}

/// When the machine rests, without what is left to its settling, s.
///
/// # Errors
/// As [`GeometryModel::sensitivity`].
pub(super) fn rest_times(model: &GeometryModel, readings: &Readings) -> Result<Vec<[f64; 2]>, GeometryError> {
    let zero = vec![0.0; model.parameters().len()];
    let wanted = readings
        .joint
        .iter()
        .map(|q| (q.as_slice(), model.markers.iter().map(|marker| (marker.body, marker.position)).collect()));
    let (points, markers) = (model.points(&model.corrections(&zero), wanted)?, model.markers.len());
    let at = |k: usize| &points[k * markers..(k + 1) * markers];
    let extent = (1..readings.time.len()).flat_map(|k| at(0).iter().zip(at(k)));
    let extent = extent.map(|(a, b)| distance(*a, *b)).fold(0.0, f64::max);
    let most = STILL_M.max(STILL * extent);
    let still = |a: usize, b: usize| at(a).iter().zip(at(b)).all(|(a, b)| distance(*a, *b) < most);
    let (mut found, mut from) = (Vec::new(), 0);
    while from < readings.time.len() {
        let mut to = from;
        while to + 1 < readings.time.len() && still(from, to + 1) {
            to += 1;
        }
        let time = [readings.time[from] + SETTLING_S, readings.time[to]];
        if time[1] - readings.time[from] >= REST_S {
            found.push(time);
            from = to + 1;
        } else {
            from += 1;
        }
    }
    Ok(found)
}

fn mean_reading(readings: &Readings, [from, to]: [f64; 2]) -> Vec<f64> {
    let inside = |t: &f64| (from..=to).contains(t);
    let rows: Vec<_> =
        readings.time.iter().zip(&readings.joint).filter(|(t, _)| inside(t)).map(|(_, q)| q).collect();
    if rows.is_empty() {
        return readings.at(0.5 * (from + to));
    }
    (0..rows[0].len()).map(|j| rows.iter().map(|q| q[j]).sum::<f64>() / rows.len() as f64).collect()
}

fn place(frames: &[Frame], time: [f64; 2], delay: f64, markers: usize) -> Place {
    let inside = |frame: &&Frame| (time[0]..=time[1]).contains(&(frame.time - delay));
    let here: Vec<&Frame> = frames.iter().filter(inside).collect();
    let seen = (0..markers).filter_map(|marker| {
        let of: Vec<[f64; 3]> =
            here.iter().filter(|frame| frame.marker == marker).map(|frame| frame.position).collect();
        (of.len() >= 3).then(|| Seen { marker, position: robust_mean(&of) })
    });
    Place { time, reading: Vec::new(), seen: seen.collect(), epoch: 0 }
}

pub(super) fn median(values: impl Iterator<Item = f64>) -> f64 {
    let mut sorted: Vec<f64> = values.collect();
    sorted.sort_by(f64::total_cmp);
    sorted.get(sorted.len() / 2).copied().unwrap_or(f64::NAN)
}

/// Mean of the points that are within four median deviations of the median.
fn robust_mean(points: &[[f64; 3]]) -> [f64; 3] {
    let middle: [f64; 3] = std::array::from_fn(|k| median(points.iter().map(|x| x[k])));
    let spread = median(points.iter().map(|x| distance(*x, middle)));
    let near: Vec<_> = points.iter().filter(|x| distance(**x, middle) <= 4.0 * spread).collect();
    std::array::from_fn(|k| near.iter().map(|x| x[k]).sum::<f64>() / near.len() as f64)
}

/// Gives every place the number of the camera's place, which the markers of the base tell.
fn mark_epochs(model: &GeometryModel, places: &mut [Place]) {
    let base: Vec<usize> = (0..model.markers.len()).filter(|m| model.markers[*m].body == 0).collect();
    let jump = |a: &Place, b: &Place| {
        let moved = base.iter().filter_map(|m| {
            let of =
                |place: &Place| place.seen.iter().find(|seen| seen.marker == *m).map(|seen| seen.position);
            Some(distance(of(a)?, of(b)?))
        });
        // The smallest: a single marker that is hidden or exchanged moves no camera.
        moved.min_by(f64::total_cmp)
    };
    let jumps: Vec<Option<f64>> = places.windows(2).map(|pair| jump(&pair[0], &pair[1])).collect();
    let threshold = (JUMP * median(jumps.iter().flatten().copied())).max(LEAST_JUMP_M);
    let mut epoch = 0;
    for (k, step) in jumps.iter().enumerate() {
        epoch += usize::from(step.is_some_and(|step| step > threshold));
        places[k + 1].epoch = epoch;
    }
}

/// A better delay, s, with its standard deviation, from the residuals of moving markers: `residual` is
/// what the
/// model misses of a frame, and the marker's velocity in the camera's frame, m and m/s.
pub(super) fn refine_delay(delay: f64, residual: &[([f64; 3], [f64; 3])]) -> (f64, f64) {
    let dot = |a: [f64; 3], b: [f64; 3]| (0..3).map(|k| a[k] * b[k]).sum::<f64>();
    let mut change = 0.0;
    let mut sd = f64::INFINITY;
    for _ in 0..10 {
        let left =
            |(r, v): &([f64; 3], [f64; 3])| distance(*r, [-change * v[0], -change * v[1], -change * v[2]]);
        let s = (median(residual.iter().map(left)) / 1.54).max(1e-6);
        let (mut top, mut bottom) = (0.0, 0.0);
        for pair in residual {
            let weight = 1.0 / (1.0 + (left(pair) / (2.4 * s)).powi(2));
            top -= weight * dot(pair.0, pair.1);
            bottom += weight * dot(pair.1, pair.1);
        }
        if bottom <= 0.0 {
            break;
        }
        (change, sd) = (top / bottom, s / bottom.sqrt());
    }
    (delay + change, sd)
}
