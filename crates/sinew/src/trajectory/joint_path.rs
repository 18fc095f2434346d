use super::inverse_kinematics::{POSITION_TOLERANCE, Solver};
use super::path::EndPointPath;
use super::redundancy::Redundancy;
use super::spline::Spline;
use super::unreached::{STARTS, UnreachedCause, UnreachedPoint, explain, start};
use crate::body::Robot;
use crate::error::{Error, within};
use alloc::vec;
use alloc::vec::Vec;

/// The independent joints along a path: a spline through poses whose end points lie on the path.
///
/// # Example
/// ```
/// use sinew::trajectory::JointPath;
/// let text = sinew_models::LM_ARM;
/// let read = sinew::description::machine_from_toml("lm_arm.toml", text, &mut |_| Err("no other file".into()));
/// let arm = read?.machine;
/// let hand = arm.task.site().ok_or("no end point")?;
/// let joints = JointPath::resolve(&arm.robot, hand, &arm.paths[0].path, &arm.redundancy, 720)?;
/// assert!(joints.first_unreached().is_none());
/// # Ok::<(), Box<dyn std::error::Error>>(())
/// ```
#[derive(Debug, Clone, PartialEq)]
pub struct JointPath {
    pub(super) spline: Spline,
    pub(super) first_unreached: Option<UnreachedPoint>,
}

/// Branches of solutions that are followed from the first point of a path.
const BRANCHES: usize = 12;
/// Poses that differ by less than this are of one branch, rad or m.
const SAME_POSE: f64 = 1e-6;

impl JointPath {
    /// Resolves the joints at `knots` equidistant phases, each starting from its neighbour's solution, for
    /// all three axes of the end point.
    ///
    /// As [`resolve_axes`](Self::resolve_axes).
    ///
    /// # Errors
    /// As [`resolve_axes`](Self::resolve_axes).
    pub fn resolve(
        robot: &Robot,
        site: usize,
        path: &EndPointPath,
        rule: &Redundancy,
        knots: usize,
    ) -> Result<Self, Error> {
        Self::resolve_axes(robot, site, [true; 3], path, rule, knots)
    }

    /// Resolves the independent joints at `knots` equidistant phases so that some coordinates of the end
    /// point follow a path, `axes` says which of x, y and z.
    ///
    /// From the first point every branch of solutions that is found is followed until one leads to the end of
    /// the path. Otherwise the joints stay constant beyond the first point that the farthest branch does not
    /// reach; [`first_unreached`](Self::first_unreached) returns that point.
    ///
    /// # Errors
    /// As [`EndPointPath::validate`] and [`Redundancy::validate`]; [`Error::OutOfDomain`] for a `site` index
    /// out of range, for no axis, or a number of knots outside 4 to 100 000.
    pub fn resolve_axes(
        robot: &Robot,
        site: usize,
        axes: [bool; 3],
        path: &EndPointPath,
        rule: &Redundancy,
        knots: usize,
    ) -> Result<Self, Error> {
        path.validate()?;
        within("knots", "a number in 4..=100000", knots as f64, (4..=100_000).contains(&knots))?;
        let mut solver = Solver::new(robot, rule, site, axes)?;
        let mut begun: Vec<Vec<f64>> = Vec::new();
        let mut farthest: Option<Branch> = None;
        for k in 0..STARTS {
            let mut x = start(&solver, k);
            // The first start is the rest pose, whose neighbourhood has the preferred solution.
            if k > 0 && solver.reach(path.point(0.0), &mut x)? > POSITION_TOLERANCE {
                continue;
            }
            if !solver.solve(0.0, path.point(0.0), &mut x)? || begun.iter().any(|other| same(other, &x)) {
                continue;
            }
            begun.push(x.clone());
            let branch = Branch::follow(&mut solver, path, knots, x)?;
            let complete = branch.end.is_none();
            if complete || farthest.as_ref().is_none_or(|farthest| branch.reached > farthest.reached) {
                farthest = Some(branch);
            }
            if complete || begun.len() == BRANCHES {
                break;
            }
        }
        let branch = match farthest {
            Some(branch) => branch,
            None => {
                let rest = solver.rest();
                Branch { poses: repeated(&rest, knots), reached: 0, end: Some(BranchEnd::Lost(0.0, rest)) }
            }
        };
        let first_unreached = match branch.end {
            None => None,
            Some(BranchEnd::Open(phase)) => {
                Some(UnreachedPoint { phase, distance: 0.0, cause: UnreachedCause::NotClosed })
            }
            Some(BranchEnd::Lost(phase, near)) => Some(explain(&mut solver, path, phase, &near)?),
        };
        let pieces = if path.closes() { knots } else { knots - 1 };
        let phases: Vec<f64> = (0..knots).map(|k| path.length() * k as f64 / pieces as f64).collect();
        let spline = if path.closes() {
            Spline::periodic(&phases, &branch.poses, path.length())?
        } else {
            Spline::natural(&phases, &branch.poses)?
        };
        Ok(Self { spline, first_unreached })
    }

    /// Joints that are given as functions of the phase.
    pub(super) fn along(spline: Spline) -> Self {
        Self { spline, first_unreached: None }
    }

    /// The first point that the end point does not reach.
    #[must_use]
    pub fn first_unreached(&self) -> Option<&UnreachedPoint> {
        self.first_unreached.as_ref()
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

/// Poses along a path that begin in one of several solutions.
struct Branch {
    /// `[knots x n]`.
    poses: Vec<f64>,
    /// Number of knots that are reached.
    reached: usize,
    end: Option<BranchEnd>,
}

/// Why a branch does not lead along the whole path.
enum BranchEnd {
    /// The phase that is not reached, and the pose before it.
    Lost(f64, Vec<f64>),
    /// The joints are elsewhere where the path closes, at this phase.
    Open(f64),
}

impl Branch {
    fn follow(
        solver: &mut Solver<'_>,
        path: &EndPointPath,
        knots: usize,
        mut x: Vec<f64>,
    ) -> Result<Self, Error> {
        let (length, closes) = (path.length(), path.closes());
        let pieces = if closes { knots } else { knots - 1 };
        // Between neighbouring knots the joints of a branch move little.
        let leap = f64::max(0.5, 50.0 / knots as f64);
        let mut poses = x.clone();
        let mut before = x.clone();
        for k in 1..=pieces {
            let phase = length * k as f64 / pieces as f64;
            let found = solver.solve(phase, path.point(phase), &mut x)?;
            if !found || distance(&x, &before) > leap {
                poses.extend(repeated(&before, knots - k.min(knots)));
                return Ok(Self { poses, reached: k, end: Some(BranchEnd::Lost(phase, before)) });
            }
            if k < knots {
                poses.extend_from_slice(&x);
            }
            before.copy_from_slice(&x);
        }
        let open = closes && distance(&x, &poses) > SAME_POSE;
        Ok(Self { poses, reached: pieces, end: open.then_some(BranchEnd::Open(length)) })
    }
}

/// A pose at `count` knots.
fn repeated(x: &[f64], count: usize) -> Vec<f64> {
    x.iter().copied().cycle().take(x.len() * count).collect()
}

/// Largest difference of two poses of one length.
fn distance(a: &[f64], b: &[f64]) -> f64 {
    a.iter().zip(b).fold(0.0_f64, |gap, (a, b)| gap.max((a - b).abs()))
}

fn same(a: &[f64], b: &[f64]) -> bool {
    distance(a, b) < SAME_POSE
}
