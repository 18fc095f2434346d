use super::equilibrium::Equilibrium;
use super::joint_path::JointPath;
use super::motion::Trajectory;
use super::ranges::finite_ranges;
use super::spline::Spline;
use super::time_law::TimeLaw;
use super::violation::{Infeasibility, Violation};
use crate::body::Robot;
use crate::error::{Error, check_length};
use crate::muscle::{Geometry, Muscles};
use alloc::vec;
use alloc::vec::Vec;
use core::f64::consts::TAU;

/// A closed motion of all independent joints in which every cable reverses.
///
/// ```text
/// q_j(th) = c_j + A_j sin(n_j th + a_j),     A_j = fraction/2 (high_j - low_j),     c_j = (low_j + high_j)/2
/// ```
///
/// | symbol    | field       | unit     | domain | meaning                                     |
/// |-----------|-------------|----------|--------|---------------------------------------------|
/// | c_j, A_j  | `center`, `amplitude` | rad or m |  | middle of the joint's range, amplitude      |
/// | n_j       | `turns`     | 1        | 1, 2   | periods per turn                            |
/// | a_j       | `phase`     | rad      |        | phase of the joint                          |
///
/// Of many combinations of turns and phases those come first in which the cable that uses its stroke least
/// uses most of it: joints that move together can leave the cable of a muscle over both at rest.
///
/// # Source
/// Sines of all joints as exciting motions: `swevers1997`; the choice of phases is ours.
#[derive(Debug, Clone, PartialEq)]
pub struct Tour {
    /// Middle of every joint's range, rad or m: `[n]`.
    pub center: Vec<f64>,
    /// Amplitude of every joint, rad or m: `[n]`.
    pub amplitude: Vec<f64>,
    /// Periods of every joint per turn: `[n]`.
    pub turns: Vec<u32>,
    /// Phase of every joint, rad: `[n]`.
    pub phase: Vec<f64>,
    /// Least fraction, over the cables, of the stroke that the joints would give together, 1.
    pub stroke: f64,
}

/// Combinations of turns and phases that are compared.
const CANDIDATES: usize = 48;
/// Phases at which the lengths of the cables are compared.
const SAMPLES: usize = 48;
/// Knots of the joints' spline.
const KNOTS: usize = 720;

impl Tour {
    /// Tours over a fraction of every joint's range, best first.
    ///
    /// `start` is the pose about which unlimited joints move, by an assumed travel of 1 rad or 50 mm.
    ///
    /// # Errors
    /// [`Error::WrongLength`] for a pose of another robot; [`Error::EntryOutOfDomain`] where it is not
    /// finite.
    pub fn candidates(robot: &Robot, start: &[f64], fraction: f64) -> Result<Vec<Self>, Error> {
        let n = robot.independent_joints().len();
        check_length("start", start.len(), n)?;
        let ranges = finite_ranges(robot, start)?;
        let center: Vec<f64> = ranges.iter().map(|[low, high]| 0.5 * (low + high)).collect();
        let amplitude: Vec<f64> = ranges.iter().map(|[low, high]| 0.5 * fraction * (high - low)).collect();
        let mut strokes = Strokes::new(robot, n);
        let mut tours = Vec::new();
        for k in 0..CANDIDATES {
            // Weyl sequences with irrational ratios: deterministic, and different for every joint.
            let weyl = |j: usize, ratio: f64| {
                let x = (k * n + j + 1) as f64 * ratio;
                x - libm::floor(x)
            };
            let mut tour = Self {
                center: center.clone(),
                amplitude: amplitude.clone(),
                turns: (0..n).map(|j| if weyl(j, 0.754_877_666_246_693) < 0.5 { 1 } else { 2 }).collect(),
                phase: (0..n).map(|j| TAU * weyl(j, 0.569_840_290_998_053)).collect(),
                stroke: 0.0,
            };
            tour.stroke = strokes.least(robot, &tour)?;
            tours.push(tour);
        }
        tours.sort_by(|a, b| b.stroke.total_cmp(&a.stroke));
        Ok(tours)
    }

    /// The joints at a phase, rad.
    pub fn pose(&self, phase: f64, q: &mut [f64]) {
        for (j, q) in q.iter_mut().enumerate().take(self.center.len()) {
            let angle = f64::from(self.turns[j]) * phase + self.phase[j];
            *q = self.center[j] + self.amplitude[j] * libm::sin(angle);
        }
    }

    /// Two turns from rest to rest in `duration` seconds.
    ///
    /// # Errors
    /// [`Error::OutOfDomain`] for a duration that is not positive.
    pub fn trajectory(&self, duration: f64) -> Result<Trajectory, Error> {
        let n = self.center.len();
        let phases: Vec<f64> = (0..KNOTS).map(|k| TAU * k as f64 / KNOTS as f64).collect();
        let mut poses = vec![0.0; KNOTS * n];
        phases.iter().zip(poses.chunks_exact_mut(n)).for_each(|(phase, q)| self.pose(*phase, q));
        let joints = JointPath::along(Spline::periodic(&phases, &poses, TAU)?);
        Ok(Trajectory::AlongPath { joints, law: TimeLaw::new(2.0 * TAU, duration)? })
    }
}

/// Lengths of the cables along a tour.
struct Strokes {
    muscles: Muscles,
    geometry: Geometry,
    arms: Vec<f64>,
    x: Vec<f64>,
}

impl Strokes {
    fn new(robot: &Robot, n: usize) -> Self {
        let muscles = Muscles::new(robot);
        Self {
            geometry: Geometry::new(robot, &muscles),
            arms: vec![0.0; muscles.count() * n],
            x: vec![0.0; n],
            muscles,
        }
    }

    /// The smallest ratio, over the cables that the joints move, of its stroke to `sum_j max |R_kj| 2 A_j`.
    fn least(&mut self, robot: &Robot, tour: &Tour) -> Result<f64, Error> {
        let (count, n, nv) = (self.muscles.count(), self.x.len(), robot.nv());
        let mut reduction = crate::body::Reduction::new(robot);
        let (mut q, mut dense) = (vec![0.0; nv], vec![0.0; count * nv]);
        let mut largest = vec![0.0_f64; count * n];
        let mut lengths = vec![[f64::INFINITY, f64::NEG_INFINITY]; count];
        for k in 0..SAMPLES {
            tour.pose(TAU * k as f64 / SAMPLES as f64, &mut self.x);
            reduction.expand(robot, &self.x, &mut q)?;
            self.muscles.evaluate(&q, &mut self.geometry)?;
            self.muscles.dense(&self.geometry, &mut dense)?;
            reduction.rows(&dense, &mut self.arms)?;
            largest.iter_mut().zip(&self.arms).for_each(|(largest, arm)| *largest = largest.max(arm.abs()));
            for ([low, high], length) in lengths.iter_mut().zip(self.geometry.lengths()) {
                (*low, *high) = (low.min(*length), high.max(*length));
            }
        }
        let stroke = |(arms, [low, high]): (&[f64], &[f64; 2])| {
            let most: f64 = arms.iter().zip(&tour.amplitude).map(|(arm, a)| 2.0 * arm * a).sum();
            (most > 1e-9).then(|| (high - low) / most)
        };
        Ok(largest.chunks_exact(n).zip(&lengths).filter_map(stroke).fold(1.0, f64::min))
    }
}

/// Duration of two turns that is tried first, s; longest one.
const FIRST_DURATION: f64 = 12.0;
const LONGEST_DURATION: f64 = 600.0;
/// Factor by which an infeasible tour is made slower.
const STRETCH: f64 = 1.35;
/// Stretches after which a lack of torque counts as static.
const TORQUE_STRETCHES: u32 = 3;
/// Fractions of the joints' ranges, and tours of each fraction, that are tried.
const FRACTIONS: [f64; 2] = [0.5, 0.4];
const TRIED: usize = 4;

/// A tour of the joints' ranges that a robot can follow.
///
/// Without a `duration`, s, it is made slower until `check` finds no infeasibility; where slower does not
/// help other tours are tried. Where cables leave joints to springs, it is the motion with the lengths that
/// the cables have on the tour, [`Equilibrium::along`]. If none is feasible the best one is returned as it
/// is: the caller's check reports why.
///
/// # Errors
/// As [`Tour::candidates`] and [`Tour::trajectory`]; whatever `check` returns.
pub fn feasible_tour<E: From<Error>>(
    robot: &Robot,
    start: &[f64],
    duration: Option<f64>,
    mut check: impl FnMut(&Trajectory) -> Result<Option<Infeasibility>, E>,
) -> Result<Trajectory, E> {
    let mut equilibrium = Equilibrium::new(robot)?;
    let mut first = None;
    for fraction in FRACTIONS {
        for tour in Tour::candidates(robot, start, fraction)?.iter().take(TRIED) {
            let (mut time, mut lacking) = (duration.unwrap_or(FIRST_DURATION), 0);
            loop {
                let mut trajectory = tour.trajectory(time)?;
                if let Some(equilibrium) = &mut equilibrium {
                    trajectory = equilibrium.along(&trajectory)?;
                }
                let Some(found) = check(&trajectory)? else { return Ok(trajectory) };
                match found.violation {
                    Violation::Torque { .. } => lacking += 1,
                    // At any speed.
                    Violation::Unstable { .. } => lacking = TORQUE_STRETCHES + 1,
                    _ => {}
                }
                if duration.is_some() || lacking > TORQUE_STRETCHES || time >= LONGEST_DURATION {
                    first = first.or(Some(trajectory));
                    break;
                }
                time = (STRETCH * time).min(LONGEST_DURATION);
            }
        }
    }
    match first {
        Some(trajectory) => Ok(trajectory),
        None => Err(Error::WrongLength { name: "tours", expected: 1, got: 0 }.into()),
    }
}
