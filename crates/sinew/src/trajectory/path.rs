use super::spline::Spline;
use super::time_law::TimeLaw;
use crate::error::{Error, finite, positive, within};
use alloc::vec::Vec;

/// Shape of a closed path.
#[derive(Debug, Clone, Copy, PartialEq, Eq)]
pub enum Loop {
    /// Three sines a third of a turn apart: a circle of radius `A sqrt(3/2)` about the axis (1, 1, 1), at
    /// constant speed.
    Sine,
    /// `[sin th, cos th, sin 2 th]` of the phase `th`: a curve that is not planar.
    Saddle,
}

/// A position that has to be reached at a time.
#[derive(Debug, Clone, Copy, PartialEq)]
pub struct Waypoint {
    /// Time, s; only differences to the first waypoint matter.
    pub time: f64,
    /// Position in the world, m.
    pub position: [f64; 3],
}

/// Desired path of the end point.
///
/// ```text
/// sine    p(th) = c + A [sin th, sin(th + 2 pi/3), sin(th - 2 pi/3)]
/// saddle  p(th) = c + A [sin th, cos th, sin 2 th]
/// points  p(th) = cubic spline through the waypoints at th_i = th(t_i), with its own time law
/// ```
///
/// | symbol | field       | unit | domain | meaning                     |
/// |--------|-------------|------|--------|-----------------------------|
/// | c      | `center`    | m    | finite | centre, in the world         |
/// | A      | `amplitude` | m    | (0, 1000] | of every coordinate       |
/// | th     | `phase`     | rad, s |      | of a loop 2 pi per turn, rad; through waypoints approximately the time, s |
/// | t_i    |             | s    | increasing | time of a waypoint since the first |
///
/// # Source
/// `yuan2023` gives a sine shape, 0.15 m and two periods; centre and phases are ours.
#[derive(Debug, Clone, PartialEq)]
pub enum EndPointPath {
    /// A closed path.
    Loop {
        /// Shape.
        shape: Loop,
        /// `c`, m.
        center: [f64; 3],
        /// `A`, m.
        amplitude: f64,
    },
    /// Through waypoints, from rest to rest.
    Waypoints {
        /// Position over the phase.
        points: Spline,
        /// Reaches every waypoint at its time, with continuous acceleration at both ends.
        law: TimeLaw,
    },
}

impl EndPointPath {
    /// Through waypoints in the order of their times, from rest to rest without a stop; through two, straight
    /// with minimum jerk.
    ///
    /// # Errors
    /// [`Error::WrongLength`] below two points, [`Error::OutOfDomain`] for one that is not finite or times
    /// that do not increase.
    pub fn through(points: &[Waypoint]) -> Result<Self, Error> {
        let times: Vec<f64> = points.iter().map(|point| point.time).collect();
        let values: Vec<f64> = points.iter().flat_map(|point| point.position).collect();
        let (points, law) = timed_spline(&times, &values)?;
        Ok(Self::Waypoints { points, law })
    }

    /// Checks the numbers of a loop; waypoints are checked by [`through`](Self::through).
    ///
    /// # Errors
    /// [`Error::OutOfDomain`] names the one outside its domain.
    pub fn validate(&self) -> Result<(), Error> {
        if let Self::Loop { center, amplitude, .. } = self {
            for coordinate in center {
                finite("center of the path", *coordinate)?;
            }
            positive("amplitude of the path", *amplitude)?;
            within("amplitude of the path", "at most 1000 m", *amplitude, *amplitude <= 1000.0)?;
        }
        Ok(())
    }

    /// The phase at which a closed path closes, rad, or an open one ends, s.
    #[must_use]
    pub fn length(&self) -> f64 {
        match self {
            Self::Loop { .. } => 2.0 * core::f64::consts::PI,
            Self::Waypoints { points, .. } => points.end(),
        }
    }

    /// Whether it ends where it begins.
    #[must_use]
    pub fn closes(&self) -> bool {
        matches!(self, Self::Loop { .. })
    }

    /// Desired position in the world at a phase, m.
    #[must_use]
    pub fn point(&self, phase: f64) -> [f64; 3] {
        const THIRD: f64 = 2.0 * core::f64::consts::FRAC_PI_3;
        let sin = libm::sin;
        match self {
            Self::Loop { shape, center: c, amplitude: a } => {
                let unit = match shape {
                    Loop::Sine => [sin(phase), sin(phase + THIRD), sin(phase - THIRD)],
                    Loop::Saddle => [sin(phase), libm::cos(phase), sin(2.0 * phase)],
                };
                core::array::from_fn(|k| c[k] + a * unit[k])
            }
            Self::Waypoints { points, .. } => {
                let mut at = [[0.0; 3]; 3];
                let [p, v, a] = &mut at;
                points.at(phase, p, v, a);
                at[0]
            }
        }
    }
}

/// Spline through points over the phase, and the time law from rest to rest that reaches them at their times,
/// s: minimum jerk for two points; for more, ramps as long as the shorter of the first and the last interval,
/// at most half of the duration.
///
/// # Errors
/// [`Error::WrongLength`] below two points, [`Error::OutOfDomain`] for one that is not finite or times that
/// do not increase.
pub(super) fn timed_spline(times: &[f64], values: &[f64]) -> Result<(Spline, TimeLaw), Error> {
    let [first, second, before, last] = match *times {
        [a, b] => [a, b, a, b],
        [a, b, .., c, d] => [a, b, c, d],
        [a, b, c] => [a, b, b, c],
        _ => return Err(Error::WrongLength { name: "points", expected: 2, got: times.len() }),
    };
    let duration = last - first;
    let ramp = (second - first).min(last - before).min(0.5 * duration);
    let law = match times {
        [_, _] => TimeLaw::minimum_jerk(duration, duration)?,
        _ => TimeLaw::with_ramp(duration, duration, ramp)?,
    };
    let phases: Vec<f64> = times.iter().map(|time| law.at(time - first).phase).collect();
    Ok((Spline::natural(&phases, values)?, law))
}

#[cfg(test)]
mod tests {
    use super::*;

    #[test]
    fn the_sine_is_a_circle_about_the_diagonal() {
        let path = EndPointPath::Loop { shape: Loop::Sine, center: [0.66, 0.10, -0.15], amplitude: 0.15 };
        let radius = 0.15 * libm::sqrt(1.5);
        for k in 0..100 {
            let p = path.point(0.1 * f64::from(k));
            let from: [f64; 3] = core::array::from_fn(|i| p[i] - [0.66, 0.10, -0.15][i]);
            assert!((libm::sqrt(from.iter().map(|x| x * x).sum()) - radius).abs() < 1e-12);
            assert!(from.iter().sum::<f64>().abs() < 1e-12);
        }
        assert!((path.point(0.0)[1] - 0.2299).abs() < 1e-4);
    }

    #[test]
    fn waypoints_are_reached_at_their_times_and_equal_times_are_refused() {
        let at = |time, x| Waypoint { time, position: [x, 0.0, 1.0] };
        let path = EndPointPath::through(&[at(5.0, 0.0), at(6.0, 0.3), at(8.0, 0.1)]).unwrap();
        let EndPointPath::Waypoints { law, .. } = &path else { panic!("{path:?}") };
        for (time, x) in [(0.0, 0.0), (1.0, 0.3), (3.0, 0.1)] {
            assert!((path.point(law.at(time).phase)[0] - x).abs() < 1e-12, "{time}");
        }
        assert!(EndPointPath::through(&[at(5.0, 0.0), at(5.0, 0.3)]).is_err());
        assert!(EndPointPath::through(&[at(5.0, 0.0)]).is_err());
        assert!(EndPointPath::through(&[at(5.0, 0.0), at(6.0, f64::NAN)]).is_err());
    }
}
