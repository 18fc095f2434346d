//! Wrapping of a cable in the plane of a circle: around it, and inside it.

use crate::lanes::{Mask, Row};
use core::f64::consts::{FRAC_PI_2, PI};

/// A point of the plane in several worlds, from the circle's centre.
pub(super) type Point<const N: usize> = [Row<N>; 2];

/// Below this, numbers count as zero: MuJoCo's bound.
pub(super) const TINY: f64 = 1e-15;

/// Contact of a cable with a circle in the worlds where it touches.
#[derive(Debug, Clone, Copy, PartialEq)]
pub(super) struct Touch<const N: usize> {
    /// Where it touches.
    pub(super) at: Mask<N>,
    /// Direction in which it arrives, unit.
    pub(super) into: Point<N>,
    /// Direction in which it leaves, unit.
    pub(super) out: Point<N>,
    /// Free lengths before and after.
    pub(super) free: [Row<N>; 2],
    /// Length on the circle, 0 inside.
    pub(super) on: Row<N>,
    /// Angle by which the cable turns, rad.
    pub(super) angle: Row<N>,
    /// To the left (+1) or to the right.
    pub(super) sense: Row<N>,
    /// Angle between the cable and the radius where it touches: a quarter turn around, less inside.
    pub(super) graze: Row<N>,
}

impl<const N: usize> Touch<N> {
    /// In no world.
    pub(super) fn none() -> Self {
        let (none, point) = (Row::default(), [Row::default(); 2]);
        let [into, out, free] = [point; 3];
        Self { at: Mask::NONE, into, out, free, on: none, angle: none, sense: none, graze: none }
    }

    /// Takes the contact of one world.
    pub(super) fn set(&mut self, k: usize, one: &Touch<1>) {
        self.at.0[k] = one.at.0[0];
        let pairs = [(&mut self.into, one.into), (&mut self.out, one.out), (&mut self.free, one.free)];
        for (mine, one) in pairs {
            (mine[0].0[k], mine[1].0[k]) = (one[0].0[0], one[1].0[0]);
        }
        for (mine, one) in [
            (&mut self.on, one.on),
            (&mut self.angle, one.angle),
            (&mut self.sense, one.sense),
            (&mut self.graze, one.graze),
        ] {
            mine.0[k] = one.0[0];
        }
    }
}

#[inline(always)]
pub(super) fn dot<const N: usize>(a: Point<N>, b: Point<N>) -> Row<N> {
    a[0] * b[0] + a[1] * b[1]
}

#[inline(always)]
pub(super) fn cross<const N: usize>(a: Point<N>, b: Point<N>) -> Row<N> {
    a[0] * b[1] - a[1] * b[0]
}

/// A quarter turn to the left.
#[inline(always)]
fn left<const N: usize>(a: Point<N>) -> Point<N> {
    [-a[1], a[0]]
}

/// `a x + b y`.
#[inline(always)]
fn mix<const N: usize>(a: Row<N>, x: Point<N>, b: Row<N>, y: Point<N>) -> Point<N> {
    [a * x[0] + b * y[0], a * x[1] + b * y[1]]
}

#[inline(always)]
fn sub<const N: usize>(a: Point<N>, b: Point<N>) -> Point<N> {
    [a[0] - b[0], a[1] - b[1]]
}

/// Point of the segment between `start` and `start + way` that is nearest to the centre; the squared
/// length of `way` is `squared`.
#[inline(always)]
fn nearest<const N: usize>(start: Point<N>, way: Point<N>, squared: Row<N>) -> Point<N> {
    let fraction = (-dot(way, start) / squared).clamp(0.0, 1.0);
    mix(Row::all(1.0), start, fraction, way)
}

/// Wraps a cable around a circle if the circle is in the way, or if it has to pass the other side.
///
/// ```text
/// T_0 ~ r e_0 + s f_0 J e_0,   T_1 ~ r e_1 - s f_1 J e_1,   f_i^2 = |e_i|^2 - r^2
/// J: rotation by a quarter turn to the left
/// ```
///
/// | symbol | argument | unit | domain | meaning                                                     |
/// |--------|----------|------|--------|-------------------------------------------------------------|
/// | e_i    | `ends`   | m    |        | ends of the cable; inside the circle nothing is wrapped      |
/// |        | `side`   | m    |        | point on the prescribed side; only its direction counts       |
/// | r      | `radius` | m    | > 0    | radius                                                      |
/// | s      |          |      | +1, -1 | sense: to the left or to the right                           |
///
/// The cable takes the shorter arc, and wraps if the straight line crosses the circle. It takes the longer
/// arc, and always wraps, if the rotations from `e_0` to the side and from the side to `e_1` have the same
/// sense, opposite to that of the shorter arc.
///
/// # Source
/// `mujoco2012`; the rule of the side is the one that version 4.0 is observed to follow.
#[inline(always)]
pub(super) fn around<const N: usize>(
    ends: [Point<N>; 2],
    side: Option<Point<N>>,
    radius: Row<N>,
) -> Option<Touch<N>> {
    let [e0, e1] = ends;
    let tiny = Row::all(TINY);
    let (square0, square1, square) = (dot(e0, e0), dot(e1, e1), radius * radius);
    let way = sub(e1, e0);
    let squared = dot(way, way);
    let (c, k) = (dot(e0, e1), cross(e0, e1));
    let none = Row::default();
    let mut long = Mask::NONE;
    // No closure: in a kernel it would be compiled for the baseline.
    if let Some(side) = side {
        long = (cross(e0, side) * k).less(none) & (cross(side, e1) * k).less(none);
    }
    let near = nearest(e0, way, squared);
    let within = square0.less(square) | square1.less(square) | radius.less(tiny);
    let clear = within | squared.less(tiny) | (!long & square.less(dot(near, near)));
    if clear.all() {
        return None;
    }
    let short = Row::all(1.0).copysign(k);
    let sense = long.select(-short, short);
    let free = [(square0 - square).sqrt(), (square1 - square).sqrt()];
    // Cosine and sine of the angle wrapped, times the squares of both distances.
    let (same, mixed) = (square - free[0] * free[1], sense * radius * (free[0] + free[1]));
    let angle = (sense * (same * k - mixed * c)).atan2(same * c + mixed * k);
    let back = angle.less(none);
    let angle = (back & long).select(angle + Row::all(2.0 * PI), angle);
    let lean = sense * radius;
    Some(Touch {
        // Without those that only touch, by rounding.
        at: !clear & (long | !back),
        into: mix(-free[0] / square0, e0, lean / square0, left(e0)),
        out: mix(free[1] / square1, e1, lean / square1, left(e1)),
        free,
        on: radius * angle,
        angle,
        sense,
        graze: Row::all(FRAC_PI_2),
    })
}

/// Contact of a cable with the inner side of a circle, as with a ring that it passes through.
///
/// ```text
/// asin(A sin t) + asin(B sin t) - 2 t + G = 0,    A = r/|e_0|,  B = r/|e_1|
/// G: angle between e_0 and e_1
/// ```
///
/// `t` is the angle between the cable and the radius where it touches: the same on both sides, as the ring
/// has no friction. Arguments as for [`around`].
///
/// # Departs
/// MuJoCo solves for `sin t` to 1e-6 and falls back on the middle of the ends within 1e-3 rad of the pose
/// where the cable leaves the ring, where its length jumps; here the root is found to rounding everywhere.
///
/// # Source
/// `mujoco2012`: rules and equation of `wrap_inside`.
pub(super) fn inside(ends: [Point<1>; 2], radius: Row<1>) -> Option<Touch<1>> {
    let [e0, e1] = ends;
    let (Row([length0]), Row([length1])) = (dot(e0, e0).sqrt(), dot(e1, e1).sqrt());
    let Row([r]) = radius;
    if length0 <= r || length1 <= r || r < TINY {
        return None;
    }
    let way = sub(e1, e0);
    let squared = dot(way, way);
    if squared.0[0] > TINY {
        let near = nearest(e0, way, squared);
        if dot(near, near).0[0] <= r * r {
            return None;
        }
    }
    let around = cross(e0, e1);
    let Row([gap]) = around.abs().atan2(dot(e0, e1));
    let t = grazing_angle(r / length0, r / length1, gap);
    // From e_0 towards e_1.
    let turn = Row([t - libm::asin(r / length0 * libm::sin(t))]).copysign(around);
    let (sine, cosine) = turn.sincos();
    let scale = Row([r / length0]);
    let point = mix(scale * cosine, e0, scale * sine, left(e0));
    let (before, after) = (sub(point, e0), sub(e1, point));
    let free = [dot(before, before).sqrt(), dot(after, after).sqrt()];
    if free[0].0[0] < TINY || free[1].0[0] < TINY {
        return None;
    }
    let (into, out) = (before.map(|x| x / free[0]), after.map(|x| x / free[1]));
    let angle = cross(into, out).abs().atan2(dot(into, out));
    let sense = Row::all(1.0).copysign(around);
    Some(Touch { at: !Mask::NONE, into, out, free, on: Row::default(), angle, sense, graze: Row([t]) })
}

/// Root in `[0, pi/2]` of the concave function above, by Newton's iteration from where it is negative.
fn grazing_angle(a: f64, b: f64, gap: f64) -> f64 {
    let mut t = FRAC_PI_2;
    for _ in 0..60 {
        let (sine, cosine) = libm::sincos(t);
        let value = libm::asin(a * sine) + libm::asin(b * sine) - 2.0 * t + gap;
        let leg = |a: f64| a * cosine / libm::sqrt(1.0 - a * a * sine * sine);
        let step = value / (leg(a) + leg(b) - 2.0);
        // Beyond the root the step changes sign by rounding alone.
        if step.is_nan() || step <= 1e-16 {
            break;
        }
        t = (t - step).max(0.0);
    }
    t
}

#[cfg(test)]
mod tests {
    use super::{FRAC_PI_2, PI, grazing_angle};
    use crate::lanes::Row;

    type Point = [f64; 2];

    /// Contact in one world.
    #[derive(Debug, PartialEq)]
    struct Touch {
        into: Point,
        out: Point,
        free: [f64; 2],
        on: f64,
        angle: f64,
        sense: f64,
    }

    fn row(point: Point) -> super::Point<1> {
        point.map(Row::all)
    }

    fn number([x, y]: super::Point<1>) -> Point {
        [x.0[0], y.0[0]]
    }

    fn of(touch: super::Touch<1>) -> Option<Touch> {
        let (into, out, free) = (number(touch.into), number(touch.out), number(touch.free));
        let (on, angle, sense) = (touch.on.0[0], touch.angle.0[0], touch.sense.0[0]);
        touch.at.any().then_some(Touch { into, out, free, on, angle, sense })
    }

    fn around(ends: [Point; 2], side: Option<Point>, radius: f64) -> Option<Touch> {
        super::around(ends.map(row), side.map(row), Row([radius])).and_then(of)
    }

    fn inside(ends: [Point; 2], radius: f64) -> Option<Touch> {
        super::inside(ends.map(row), Row([radius])).and_then(of)
    }

    fn dot(a: Point, b: Point) -> f64 {
        super::dot(row(a), row(b)).0[0]
    }

    fn cross(a: Point, b: Point) -> f64 {
        super::cross(row(a), row(b)).0[0]
    }

    fn left(a: Point) -> Point {
        number(super::left(row(a)))
    }

    fn mix(a: f64, x: Point, b: f64, y: Point) -> Point {
        number(super::mix(Row([a]), row(x), Row([b]), row(y)))
    }

    /// Length by two tangents and an arc in one sense: to the left (+1) or to the right.
    fn length(ends: [Point; 2], sense: f64, radius: f64) -> f64 {
        let distance = |a: Point, b: Point| libm::hypot(a[0] - b[0], a[1] - b[1]);
        let on = |angle: f64| [radius * libm::cos(angle), radius * libm::sin(angle)];
        let tangent = |end: Point, sense: f64| {
            let lean = libm::acos((radius / libm::hypot(end[0], end[1])).min(1.0));
            libm::atan2(end[1], end[0]) + sense * lean
        };
        let (from, to) = (tangent(ends[0], sense), tangent(ends[1], -sense));
        let arc = libm::fmod(sense * (to - from) + 4.0 * PI, 2.0 * PI);
        distance(ends[0], on(from)) + radius * arc + distance(on(to), ends[1])
    }

    /// Shortest length over both senses.
    fn shortest(ends: [Point; 2], radius: f64) -> f64 {
        length(ends, 1.0, radius).min(length(ends, -1.0, radius))
    }

    fn polar(distance: f64, angle: f64) -> Point {
        [distance * libm::cos(angle), distance * libm::sin(angle)]
    }

    /// Smallest distance from the centre on the way between the ends.
    fn clearance([e0, e1]: [Point; 2]) -> f64 {
        let at = |fraction: f64| mix(1.0 - fraction, e0, fraction, e1);
        (0..=400).map(|k| at(f64::from(k) / 400.0)).map(|p| libm::hypot(p[0], p[1])).fold(9.0, f64::min)
    }

    #[test]
    fn the_shorter_path_consists_of_tangents_and_an_arc() {
        let mut wrapped = 0;
        for i in 0..400 {
            let angle = f64::from(i) * 0.7;
            let ends = [[1.3 + 0.001 * f64::from(i), 0.1], [2.0 * libm::cos(angle), 2.0 * libm::sin(angle)]];
            if let Some(touch) = around(ends, None, 1.0) {
                wrapped += 1;
                let length = touch.free[0] + touch.on + touch.free[1];
                assert!((length - shortest(ends, 1.0)).abs() < 1e-13, "{ends:?}");
                assert!((dot(touch.into, touch.into) - 1.0).abs() < 1e-14);
                assert!((dot(touch.out, touch.out) - 1.0).abs() < 1e-14);
            }
        }
        assert!(wrapped > 150, "{wrapped}");
    }

    #[test]
    fn a_ring_turns_the_cable_by_equal_angles() {
        let mut touched = 0;
        for i in 1..300 {
            let gap = f64::from(i) * 0.01;
            let ends = [[1.7, 0.0], [2.5 * libm::cos(gap), 2.5 * libm::sin(gap)]];
            if let Some(touch) = inside(ends, 1.0) {
                touched += 1;
                let point = mix(1.0, ends[0], touch.free[0], touch.into);
                assert!((libm::hypot(point[0], point[1]) - 1.0).abs() < 1e-13);
                // The force of the ring on the cable is along the radius.
                let pull = mix(1.0, touch.out, -1.0, touch.into);
                assert!(cross(pull, point).abs() < 1e-12, "{gap}");
            }
        }
        assert!(touched > 100, "{touched}");
    }

    #[test]
    fn a_side_on_the_longer_arc_sends_the_cable_around_it_and_any_other_side_changes_nothing() {
        let (radius, mut longer, mut clear) = (0.7, [0; 2], 0);
        for i in 0..1500 {
            let x = f64::from(i);
            let (begin, gap, aside) = (0.37 * x, libm::remainder(1.13 * x, 2.0 * PI), 0.71 * x + 0.2);
            let ends = [polar(0.75 + 0.001 * x, begin), polar(0.72 + 0.002 * x, begin + gap)];
            let touch = around(ends, Some(polar(0.4, begin + aside)), radius);
            let rest = libm::remainder(gap - aside, 2.0 * PI);
            let long = libm::remainder(aside, 2.0 * PI) * gap < 0.0 && rest * gap < 0.0;
            let desired = if long { length(ends, -gap.signum(), radius) } else { shortest(ends, radius) };
            let near = clearance(ends);
            if !long && (near - radius).abs() < 1e-3 {
                continue;
            }
            let Some(touch) = touch else {
                assert!(!long && near > radius, "{ends:?}");
                clear += 1;
                continue;
            };
            let got = touch.free[0] + touch.on + touch.free[1];
            assert!((got - desired).abs() < 4e-15, "{ends:?}: {got} {desired}");
            assert!((touch.on - radius * touch.angle).abs() < 1e-15 && touch.angle < 2.0 * PI);
            longer[0] += usize::from(long && touch.angle > PI);
            longer[1] += usize::from(long && touch.angle < PI);
            // It arrives and leaves along the circle, in the same sense.
            let points =
                [mix(1.0, ends[0], touch.free[0], touch.into), mix(1.0, ends[1], -touch.free[1], touch.out)];
            for (point, along) in points.into_iter().zip([touch.into, touch.out]) {
                assert!((libm::hypot(point[0], point[1]) - radius).abs() < 1e-15);
                assert!((touch.sense * cross(point, along) - radius).abs() < 1e-15);
            }
        }
        assert!(longer.iter().all(|count| *count > 40) && clear > 100, "{longer:?} {clear}");
    }

    #[test]
    fn a_cable_that_ends_on_the_circle_wraps_as_one_that_ends_beside_it() {
        for ends in [[[1.0, 0.0], polar(2.0, 2.5)], [polar(3.0, 2.6), [1.0, 0.0]], [[0.0, 1.0], [0.0, -1.0]]]
        {
            let touch = around(ends, None, 1.0).unwrap();
            let got = touch.free[0] + touch.on + touch.free[1];
            assert!((got - shortest(ends, 1.0)).abs() < 1e-15, "{ends:?}: {got}");
        }
    }

    #[test]
    fn a_cable_that_touches_to_rounding_does_not_go_once_around() {
        let mut touching = 0;
        for i in 0..3000 {
            let foot = polar(1.0, 0.01 * f64::from(i));
            let reach = 0.3 + 0.001 * f64::from(i);
            let ends = [mix(1.0, foot, -1.3, left(foot)), mix(1.0, foot, reach, left(foot))];
            if let Some(touch) = around(ends, None, 1.0) {
                touching += 1;
                assert!(touch.angle < 2e-15, "{ends:?}: {}", touch.angle);
            }
        }
        assert!((300..2900).contains(&touching), "{touching}");
    }

    #[test]
    fn what_has_no_extent_bends_no_cable() {
        // A circle smaller than rounding.
        for radius in [0.0, 1e-16] {
            assert_eq!(around([[1.0, 0.0], [-1.0, 0.0]], None, radius), None);
            assert_eq!(inside([[1.0, 0.0], [0.0, 1.0]], radius), None);
        }
        // A cable without length, on the circle or within the ring.
        assert_eq!(around([[1.0, 0.0]; 2], None, 1.0), None);
        assert_eq!(inside([[0.3, 0.4]; 2], 1.0), None);
        assert_eq!(inside([[0.0; 2]; 2], 1.0), None);
    }

    #[test]
    fn a_ring_bends_no_cable_that_begins_or_ends_on_it_to_rounding() {
        let (beside, far) = ([1.0 + f64::EPSILON, 0.0], [2.0, 0.0]);
        assert_eq!(inside([beside, far], 1.0), None);
        assert_eq!(inside([far, beside], 1.0), None);
        // Half a nanometre within and half outside.
        assert_eq!(inside([[1.0 - 5e-10, 0.0], [1.0 + 5e-10, 0.0]], 1.0), None);
        assert_eq!(inside([[1.0 + 5e-10, 0.0], [1.0 - 5e-10, 0.0]], 1.0), None);
        // The diameter leads through it.
        assert_eq!(inside([[1.5, 0.0], [-2.0, 0.0]], 1.0), None);
    }

    #[test]
    fn no_other_point_of_a_ring_makes_the_cable_shorter() {
        for i in 1..40 {
            let gap = 0.04 * f64::from(i);
            let ends = [polar(2.0, 0.3), polar(1.1 + 0.02 * f64::from(i), 0.3 - gap)];
            let Some(touch) = inside(ends, 1.0) else {
                assert!(clearance(ends) < 1.0 + 1e-3);
                continue;
            };
            let way = |point: Point| {
                ends.map(|end| libm::hypot(end[0] - point[0], end[1] - point[1])).iter().sum::<f64>()
            };
            let got = touch.free[0] + touch.free[1];
            let least = (0..3000).map(|k| way(polar(1.0, 0.003 * f64::from(k)))).fold(9.0, f64::min);
            assert!((-1e-14..1e-5).contains(&(least - got)), "{gap}: {got} {least}");
        }
    }

    #[test]
    fn the_grazing_angle_solves_its_equation_also_where_the_cable_nearly_lies_on_the_ring() {
        for a in [0.05, 0.5, 0.9, 0.999, 0.999_999] {
            for b in [0.1, 0.6, 0.95, 0.999, 0.999_999] {
                for fraction in [0.05, 0.5, 0.9, 0.99] {
                    let gap = fraction * (libm::acos(a) + libm::acos(b));
                    let value =
                        |t: f64| libm::asin(a * libm::sin(t)) + libm::asin(b * libm::sin(t)) - 2.0 * t + gap;
                    let t = grazing_angle(a, b, gap);
                    let (mut low, mut high) = (0.0, FRAC_PI_2);
                    for _ in 0..60 {
                        let middle = 0.5 * (low + high);
                        if value(middle) > 0.0 { low = middle } else { high = middle }
                    }
                    assert!((t - low).abs() < 1e-12, "{a} {b} {fraction}: {t} {low}");
                }
            }
        }
    }
}
