//! SVG paths in a box of [`WIDTH`] x [`HEIGHT`] whole units, short enough to inline by the dozen.

use super::record::Record;
use super::scale::Axis;
use std::fmt::Write as _;

/// Units across every picture.
pub(super) const WIDTH: f64 = 4000.0;
/// Distance of a point that is left out from the line drawn, units: a fifth of a pixel of a picture 400
/// pixels high.
const TOLERANCE: f64 = 1.0;
/// Units down every picture.
pub(super) const HEIGHT: f64 = 2000.0;

/// The data of one `<path>`, written with relative steps between whole units.
#[derive(Debug, Default)]
pub(super) struct Pen {
    data: String,
    at: Option<(i64, i64)>,
}

impl Pen {
    /// Lifts the pen: the next point starts a new line.
    pub(super) fn lift(&mut self) {
        self.at = None;
    }

    /// Draws a line to a point given in fractions of the box, y upwards; a non-finite point lifts the pen.
    pub(super) fn line_to(&mut self, x: f64, y: f64) {
        if !(x.is_finite() && y.is_finite()) {
            self.lift();
            return;
        }
        // Points far outside the box are clipped by the page.
        let place = |f: f64, size: f64| (f.clamp(-1.0, 2.0) * size).round() as i64;
        let (x, y) = (place(x, WIDTH), place(1.0 - y, HEIGHT));
        match self.at {
            None => {
                let _ = write!(self.data, "M{x} {y}l0 0");
            }
            Some((px, py)) if (px, py) == (x, y) => {}
            Some((px, py)) => {
                let _ = write!(self.data, " {} {}", x - px, y - py);
            }
        }
        self.at = Some((x, y));
    }

    /// Closes the line to an area.
    pub(super) fn close(&mut self) {
        if self.at.is_some() {
            self.data.push('z');
            self.lift();
        }
    }

    /// The `d` attribute.
    pub(super) fn finish(self) -> String {
        self.data
    }
}

/// A line through points, interrupted at non-finite ones; points that lie on the line between others, to a
/// unit of the box, are left out.
pub(super) fn line(points: impl Iterator<Item = (f64, f64)>, x: &Axis, y: &Axis) -> String {
    let (mut pen, mut piece) = (Pen::default(), Vec::new());
    let mut flush = |piece: &mut Vec<[f64; 2]>| {
        pen.lift();
        simplified(piece).into_iter().for_each(|[a, b]| pen.line_to(a, b));
        piece.clear();
    };
    for (a, b) in points {
        let point = [x.at(a), y.at(b)];
        match point.iter().all(|f| f.is_finite()) {
            true => piece.push(point),
            false => flush(&mut piece),
        }
    }
    flush(&mut piece);
    pen.finish()
}

/// Points without those that lie within [`TOLERANCE`] of the line between the ones kept (Douglas and
/// Peucker).
fn simplified(points: &[[f64; 2]]) -> Vec<[f64; 2]> {
    if points.len() < 3 {
        return points.to_vec();
    }
    let unit = |i: usize| [WIDTH * points[i][0], HEIGHT * points[i][1]];
    let mut kept = vec![false; points.len()];
    (kept[0], kept[points.len() - 1]) = (true, true);
    let mut open = vec![(0, points.len() - 1)];
    while let Some((first, last)) = open.pop() {
        let ([ax, ay], [bx, by]) = (unit(first), unit(last));
        let (dx, dy) = (bx - ax, by - ay);
        let length = dx.hypot(dy);
        let away = |i: usize| {
            let [x, y] = unit(i);
            let along = if length > 0.0 { ((x - ax) * dx + (y - ay) * dy) / length } else { 0.0 };
            if length > 0.0 && (0.0..=length).contains(&along) {
                ((x - ax) * dy - (y - ay) * dx).abs() / length
            } else {
                (x - ax).hypot(y - ay).min((x - bx).hypot(y - by))
            }
        };
        let farthest = (first + 1..last).map(|i| (i, away(i))).max_by(|a, b| a.1.total_cmp(&b.1));
        if let Some((middle, distance)) = farthest
            && distance > TOLERANCE
        {
            kept[middle] = true;
            open.extend([(first, middle), (middle, last)]);
        }
    }
    points.iter().zip(kept).filter(|(_, kept)| *kept).map(|(point, _)| *point).collect()
}

/// The area between two lines, interrupted at non-finite points.
pub(super) fn ribbon(points: impl Iterator<Item = (f64, f64, f64)>, x: &Axis, y: &Axis) -> String {
    let mut pen = Pen::default();
    let mut piece: Vec<(f64, f64, f64)> = Vec::new();
    let mut flush = |piece: &mut Vec<(f64, f64, f64)>| {
        piece.iter().for_each(|(a, _, high)| pen.line_to(x.at(*a), y.at(*high)));
        piece.iter().rev().for_each(|(a, low, _)| pen.line_to(x.at(*a), y.at(*low)));
        pen.close();
        piece.clear();
    };
    for point in points {
        match point.0.is_finite() && point.1.is_finite() && point.2.is_finite() {
            true => piece.push(point),
            false => flush(&mut piece),
        }
    }
    flush(&mut piece);
    pen.finish()
}

/// Where lines leave the box, a bar on its edge: for every stretch of a path of [`line`] above or below it.
pub(super) fn beyond(paths: &[&str]) -> String {
    let mut bars = String::new();
    for piece in paths.iter().flat_map(|path| path.split('M')).filter(|piece| !piece.is_empty()) {
        let numbers = piece.split([' ', 'l']).filter_map(|number| number.parse::<i64>().ok());
        let numbers: Vec<i64> = numbers.collect();
        let (mut at, mut open): ([i64; 2], Option<(i64, [i64; 2])>) = ([0; 2], None);
        let mut end = |open: &mut Option<(i64, [i64; 2])>| {
            if let Some((edge, [from, to])) = open.take() {
                let from = from.min(to - SHORTEST_BAR).clamp(0, WIDTH as i64 - SHORTEST_BAR);
                let _ = write!(bars, "M{from} {edge}h{}", (to - from).max(SHORTEST_BAR));
            }
        };
        for step in numbers.chunks_exact(2) {
            at = [at[0] + step[0], at[1] + step[1]];
            let edge = if at[1] < 0 { Some(0) } else { (at[1] > HEIGHT as i64).then_some(HEIGHT as i64) };
            match (edge, &mut open) {
                (Some(edge), Some((same, [_, to]))) if *same == edge => *to = at[0],
                (Some(edge), _) => {
                    end(&mut open);
                    open = Some((edge, [at[0]; 2]));
                }
                (None, _) => end(&mut open),
            }
        }
        end(&mut open);
    }
    bars
}

/// Length of a bar that a single point beyond the box gets, units.
const SHORTEST_BAR: i64 = 40;

/// Horizontal lines at the given fractions of the height.
pub(super) fn horizontal_lines(at: impl Iterator<Item = f64>) -> String {
    at.filter(|f| f.is_finite()).fold(String::new(), |mut d, f| {
        let _ = write!(d, "M0 {}h{WIDTH}", ((1.0 - f) * HEIGHT).round());
        d
    })
}

/// Vertical lines at the given fractions of the width.
pub(super) fn vertical_lines(at: impl Iterator<Item = f64>) -> String {
    at.filter(|f| f.is_finite()).fold(String::new(), |mut d, f| {
        let _ = write!(d, "M{} 0v{HEIGHT}", (f * WIDTH).round());
        d
    })
}

/// About `budget` samples of a record, in order: per bucket the first, minimum and maximum far value, the
/// largest error and a gap, so that neither an extremum nor a gap is lost.
pub(super) fn decimate(record: &Record, budget: usize) -> Vec<usize> {
    let n = record.len();
    if n <= budget {
        return (0..n).collect();
    }
    let buckets = (budget / 4).max(1);
    let mut kept = Vec::with_capacity(budget + buckets);
    for bucket in 0..buckets {
        let range = bucket * n / buckets..(bucket + 1) * n / buckets;
        let most = |key: &dyn Fn(usize) -> f64| {
            range.clone().filter(|&i| key(i).is_finite()).max_by(|&a, &b| key(a).total_cmp(&key(b)))
        };
        let mut chosen = [
            range.clone().next(),
            most(&|i| record.far[i]),
            most(&|i| -record.far[i]),
            most(&|i| record.error(i).abs()),
            range.clone().find(|&i| !record.predicted[i].is_finite()),
        ];
        chosen.sort_unstable();
        kept.extend(chosen.into_iter().flatten());
    }
    kept.push(n - 1);
    kept.dedup();
    kept
}

#[cfg(test)]
mod tests {
    use super::super::record::records;
    use super::super::tests::fixture::simulated;
    use super::*;

    #[test]
    fn decimation_keeps_minima_maxima_largest_errors_and_gaps() {
        let mut report = simulated(5000);
        report.traces[1].far[777] = 99.0;
        report.traces[1].far[1234] = -99.0;
        report.traces[1].predicted[2000] = 50.0;
        let record = &records(&report)[1];
        let kept = decimate(record, 200);
        assert!(kept.len() < 300 && record.len() > 4900, "{}", kept.len());
        assert!(kept.windows(2).all(|w| w[0] < w[1]), "in order, none twice");
        let has = |holds: &dyn Fn(usize) -> bool| kept.iter().any(|&i| holds(i));
        assert!(has(&|i| record.far[i] > 98.0) && has(&|i| record.far[i] < -98.0));
        assert!(has(&|i| record.predicted[i] > 49.0));
        assert!(has(&|i| record.predicted[i].is_nan()), "the gap");
    }

    #[test]
    fn what_leaves_the_box_has_a_bar_on_its_edge_for_every_stretch() {
        let axis = Axis::new((0.0, 10.0), 5);
        let drawn = |points: &[(f64, f64)]| beyond(&[&line(points.iter().copied(), &axis, &axis)]);
        assert_eq!(drawn(&[(0.0, 0.0), (5.0, 10.0), (10.0, 0.0)]), "");
        assert_eq!(drawn(&[(0.0, 0.0), (5.0, 14.0), (10.0, 0.0)]), "M1960 0h40");
        assert_eq!(drawn(&[(0.0, 1.0), (2.5, 12.0), (5.0, 12.0), (7.5, -3.0)]), "M1000 0h1000M2960 2000h40");
        assert_eq!(drawn(&[(0.0, 11.0), (1.0, f64::NAN), (10.0, 11.0)]), "M0 0h40M3960 0h40");
    }

    #[test]
    fn a_non_finite_point_interrupts_the_line() {
        let axis = Axis::new((0.0, 10.0), 5);
        let points = [(0.0, 0.0), (5.0, 5.0), (6.0, f64::NAN), (7.0, 7.0), (10.0, 10.0)];
        assert_eq!(line(points.into_iter(), &axis, &axis), "M0 2000l0 0 2000 -1000M2800 600l0 0 1200 -600");
    }
}
