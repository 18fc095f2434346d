use super::path::EndPointPath;
use super::redundancy::{Redundancy, Solver};
use super::spline::Spline;
use crate::body::Robot;
use crate::error::{Error, within};
use alloc::vec;
use alloc::vec::Vec;

/// The joints along a path: a spline through poses whose end points lie on the path.
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

/// A point of the path outside the workspace of the end point.
#[derive(Debug, Clone, Copy, PartialEq)]
pub struct UnreachedPoint {
    /// Phase of the path: rad on a closed path, s between waypoints.
    pub phase: f64,
    /// Remaining position error, m; 0 where the path closes and the joints do not.
    pub distance: f64,
}

/// Largest position error of a reached point, m.
const POSITION_TOLERANCE: f64 = 1e-9;

impl JointPath {
    /// Resolves the joints at `knots` equidistant phases, each starting from its neighbour's solution.
    ///
    /// Beyond the first point that is not reached the joints stay constant;
    /// [`first_unreached`](Self::first_unreached) returns that point.
    ///
    /// # Errors
    /// As [`EndPointPath::validate`] and [`Redundancy::validate`]; [`Error::OutOfDomain`] for a `site` index
    /// out of range or a number of knots outside 4 to 100 000.
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
        let phase = |k: usize| length * k as f64 / pieces as f64;
        let mut q: Vec<f64> = rule.rest.clone();
        let mut poses = Vec::with_capacity(knots * q.len());
        let mut first_unreached = None;
        for k in 0..knots {
            if first_unreached.is_none() {
                let distance = solver.solve(phase(k), path.point(phase(k)), &mut q)?;
                first_unreached =
                    (distance > POSITION_TOLERANCE).then_some(UnreachedPoint { phase: phase(k), distance });
            }
            poses.extend_from_slice(&q);
        }
        if closes && first_unreached.is_none() {
            solver.solve(length, path.point(length), &mut q)?;
            let gap = q.iter().zip(&poses).fold(0.0_f64, |gap, (a, b)| gap.max((a - b).abs()));
            first_unreached = (gap > 1e-6).then_some(UnreachedPoint { phase: length, distance: 0.0 });
        }
        let phases: Vec<f64> = (0..knots).map(phase).collect();
        let spline = if closes {
            Spline::periodic(&phases, &poses, length)?
        } else {
            Spline::natural(&phases, &poses)?
        };
        Ok(Self { spline, first_unreached })
    }

    /// The first point that the end point does not reach.
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
