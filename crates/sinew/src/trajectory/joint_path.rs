use super::path::EndPointPath;
use super::redundancy::{Redundancy, Solver};
use super::spline::Spline;
use crate::body::Robot;
use crate::error::{Error, within};
use alloc::vec;
use alloc::vec::Vec;

/// The joints along a path: a spline through poses, each with its end point on the path.
///
/// # Example
/// ```
/// use sinew::body::Robot;
/// use sinew::trajectory::{EndPointPath, JointPath, Loop, Redundancy};
/// let text = include_str!("../../../../models/lm_arm.toml");
/// let parts = sinew::description::from_toml("lm_arm.toml", text).expect("a model of this repository").parts;
/// let arm = Robot::new(parts)?;
/// let hand = arm.site("endpoint").expect("a site of the model");
/// let path = EndPointPath::lm_arm(Loop::Saddle);
/// let joints = JointPath::resolve(&arm, hand, &path, &Redundancy::lm_arm(), 720)?;
/// assert!(joints.first_unreached().is_none());
/// # Ok::<(), sinew::Error>(())
/// ```
#[derive(Debug, Clone, PartialEq)]
pub struct JointPath {
    pub(super) spline: Spline,
    first_unreached: Option<UnreachedPoint>,
}

/// A place of the path that the end point does not reach.
#[derive(Debug, Clone, Copy, PartialEq)]
pub struct UnreachedPoint {
    /// Where on the path: rad; of waypoints about the time, s.
    pub phase: f64,
    /// How far the end point stays away, m; of a path that closes while the joints do not, 0.
    pub distance: f64,
}

/// How close to the path is on it, m.
const ON_THE_PATH: f64 = 1e-9;

impl JointPath {
    /// Finds the joints at `knots` places, the same distance apart, each from its neighbour.
    ///
    /// Where the path cannot be followed further, the rest of the joints stay as they are and
    /// [`first_unreached`](Self::first_unreached) says where that was.
    ///
    /// # Errors
    /// As [`EndPointPath::validate`] and [`Redundancy::validate`]; [`Error::OutOfDomain`] for a `site` that is not there
    /// or a number of knots outside 4 to 100 000.
    pub fn resolve(
        robot: &Robot,
        site: usize,
        path: &EndPointPath,
        rule: &Redundancy,
        knots: usize,
    ) -> Result<Self, Error> {
        path.validate()?;
        within("knots", "a number in 4..=100000", knots as f64, (4..=100_000).contains(&knots))?;
        let mut solver = Solver::new(robot, rule, site)?;
        let (length, closes) = (path.length(), path.closes());
        let pieces = if closes { knots } else { knots - 1 };
        let place = |k: usize| length * k as f64 / pieces as f64;
        let mut q: Vec<f64> = rule.rest.clone();
        let mut poses = Vec::with_capacity(knots * q.len());
        let mut first_unreached = None;
        for k in 0..knots {
            if first_unreached.is_none() {
                let distance = solver.solve(place(k), path.point(place(k)), &mut q)?;
                first_unreached =
                    (distance > ON_THE_PATH).then_some(UnreachedPoint { phase: place(k), distance });
            }
            poses.extend_from_slice(&q);
        }
        if closes && first_unreached.is_none() {
            solver.solve(length, path.point(length), &mut q)?;
            let gap = q.iter().zip(&poses).fold(0.0_f64, |gap, (a, b)| gap.max((a - b).abs()));
            first_unreached = (gap > 1e-6).then_some(UnreachedPoint { phase: length, distance: 0.0 });
        }
        let places: Vec<f64> = (0..knots).map(place).collect();
        let spline = if closes {
            Spline::periodic(&places, &poses, length)?
        } else {
            Spline::natural(&places, &poses)?
        };
        Ok(Self { spline, first_unreached })
    }

    /// The first place that the end point does not reach.
    #[must_use]
    pub fn first_unreached(&self) -> Option<UnreachedPoint> {
        self.first_unreached
    }

    /// The pose at a phase.
    #[must_use]
    pub fn pose(&self, phase: f64) -> Vec<f64> {
        let width = self.spline.width();
        let (mut q, mut slope, mut bend) = (vec![0.0; width], vec![0.0; width], vec![0.0; width]);
        self.spline.at(phase, &mut q, &mut slope, &mut bend);
        q
    }
}
