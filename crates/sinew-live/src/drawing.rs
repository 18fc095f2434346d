//! Where bodies and cables are: poses, and every cable from its winch through the sheath's curve to the
//! anchor.

use sinew::Error;
use sinew::body::Poses;
use sinew::machine::Machine;
use sinew::muscle::{Geometry, MuscleDynamics, Muscles};

/// Points of a cable in its sheath, and from there to the anchor.
pub(crate) const SHEATH_POINTS: usize = 18;
pub(crate) const FREE_POINTS: usize = 26;
/// All points of a cable.
pub(crate) const POINTS: usize = SHEATH_POINTS + FREE_POINTS;
/// Angle between two points of an arc, rad.
const ARC_STEP: f64 = 0.15;

/// Kinematics of a machine for pictures.
#[derive(Debug)]
pub(crate) struct Drawing {
    machine: Machine,
    model: MuscleDynamics,
    poses: Poses,
    muscles: Muscles,
    geometry: Geometry,
    /// Of every muscle, m.
    winches: Vec<[f64; 3]>,
    up: [f64; 3],
}

impl Drawing {
    /// The winches are assumed in a row behind the machine: a machine file does not say where they are.
    pub(crate) fn new(machine: &Machine) -> Result<Self, Error> {
        let robot = &machine.robot;
        let muscles = Muscles::new(robot);
        let gravity = robot.parts().gravity;
        let weight = norm(gravity);
        let up = if weight > 0.0 { gravity.map(|g| -g / weight) } else { [0.0, 0.0, 1.0] };
        let mut drawing = Self {
            model: MuscleDynamics::new(robot)?,
            poses: Poses::new(robot),
            geometry: Geometry::new(robot, &muscles),
            muscles,
            winches: Vec::new(),
            up,
            machine: machine.clone(),
        };
        drawing.place_winches()?;
        Ok(drawing)
    }

    fn place_winches(&mut self) -> Result<(), Error> {
        self.evaluate_start()?;
        let count = self.muscles.count();
        let entries: Vec<[f64; 3]> =
            (0..count).map(|k| self.free_path(k).map(|path| path[0])).collect::<Result<_, _>>()?;
        let all = (0..self.machine.robot.parts().bodies.len())
            .map(|body| self.machine.robot.body_pose(&self.poses, body).origin)
            .chain(entries);
        let (mut low, mut high) = ([0.0_f64; 3], [0.0_f64; 3]);
        for point in all {
            for k in 0..3 {
                (low[k], high[k]) = (low[k].min(point[k]), high[k].max(point[k]));
            }
        }
        let size = norm([0, 1, 2].map(|k| high[k] - low[k])).max(1e-3);
        // Along the horizontal axis over which the machine reaches least, behind it along the other.
        let upright = (0..3).max_by(|a, b| self.up[*a].abs().total_cmp(&self.up[*b].abs())).unwrap_or(2);
        let [a, b] = [(upright + 1) % 3, (upright + 2) % 3];
        let (along, away) = if high[a] - low[a] < high[b] - low[b] { (a, b) } else { (b, a) };
        let bottom = if self.up[upright] > 0.0 { low[upright] } else { high[upright] };
        self.winches = (0..count)
            .map(|k| {
                let fraction = if count > 1 { k as f64 / (count - 1) as f64 - 0.5 } else { 0.0 };
                let mut at = [0.0; 3];
                at[along] = 0.5 * (low[along] + high[along]) + 0.6 * size * fraction;
                at[away] = low[away] - 0.35 * size;
                at[upright] = bottom + 0.12 * size * self.up[upright].signum();
                at
            })
            .collect();
        Ok(())
    }

    pub(crate) fn winch(&self, muscle: usize) -> [f64; 3] {
        self.winches.get(muscle).copied().unwrap_or_default()
    }

    /// Sets the pose, rad or m: `[joints]`.
    pub(crate) fn evaluate(&mut self, q: &[f64]) -> Result<(), Error> {
        self.model.evaluate(q)?;
        self.machine.robot.forward_kinematics(self.model.coordinates(), &mut self.poses)?;
        self.muscles.evaluate(self.model.coordinates(), &mut self.geometry)
    }

    /// Sets the pose in which the machine starts.
    pub(crate) fn evaluate_start(&mut self) -> Result<(), Error> {
        let start = self.machine.start.clone();
        self.evaluate(&start)
    }

    /// Poses of all bodies: position, m, and quaternion `[w, x, y, z]`.
    pub(crate) fn bodies(&self, out: &mut Vec<f64>) {
        for body in 0..self.machine.robot.parts().bodies.len() {
            let pose = self.machine.robot.body_pose(&self.poses, body);
            out.extend(pose.origin);
            out.extend(pose.quaternion());
        }
    }

    /// The end point, m; none where the machine has none.
    pub(crate) fn end_point(&self) -> Option<[f64; 3]> {
        self.machine.task.site().map(|site| self.machine.robot.site_pose(&self.poses, site).origin)
    }

    /// A point of a body in the world, m.
    pub(crate) fn place(&self, body: usize, point: [f64; 3]) -> [f64; 3] {
        let pose = self.machine.robot.body_pose(&self.poses, body);
        pose.point(point)
    }

    /// A muscle's way from its first point to the anchor: `FREE_POINTS` of equal distance.
    fn free_path(&self, muscle: usize) -> Result<Vec<[f64; 3]>, Error> {
        let robot = &self.machine.robot;
        let branches = self.muscles.drawn(robot, &self.poses, &self.geometry, muscle, ARC_STEP)?;
        let points: Vec<[f64; 3]> = branches.into_iter().flatten().collect();
        Ok(evenly(&points, FREE_POINTS))
    }

    /// Points of all cables, m, winch first.
    pub(crate) fn cables(&self, out: &mut Vec<f64>) -> Result<(), Error> {
        for muscle in 0..self.muscles.count() {
            let free = self.free_path(muscle)?;
            let (winch, entry) = (self.winch(muscle), free[0]);
            let next = free.iter().copied().find(|p| norm(sub(*p, entry)) > 1e-6).unwrap_or(entry);
            for point in sheath(winch, entry, sub(entry, next), self.up) {
                out.extend(point);
            }
            free.into_iter().for_each(|point| out.extend(point));
        }
        Ok(())
    }
}

/// A curve from a winch, upward, to where the cable leaves the sheath in a direction.
fn sheath(winch: [f64; 3], entry: [f64; 3], back: [f64; 3], up: [f64; 3]) -> impl Iterator<Item = [f64; 3]> {
    let distance = norm(sub(entry, winch));
    let length = norm(back).max(1e-9);
    let first = add(winch, up, 0.55 * distance);
    let last = add(entry, back.map(|x| x / length), 0.35 * distance);
    (0..SHEATH_POINTS).map(move |k| {
        let t = k as f64 / SHEATH_POINTS as f64;
        let s = 1.0 - t;
        let weights = [s * s * s, 3.0 * s * s * t, 3.0 * s * t * t, t * t * t];
        [0, 1, 2].map(|i| {
            weights[0] * winch[i] + weights[1] * first[i] + weights[2] * last[i] + weights[3] * entry[i]
        })
    })
}

/// `count` points of equal distance along a polyline; corners between them are cut.
fn evenly(points: &[[f64; 3]], count: usize) -> Vec<[f64; 3]> {
    let Some(first) = points.first() else { return vec![[0.0; 3]; count] };
    let mut at = vec![0.0];
    for pair in points.windows(2) {
        at.push(at[at.len() - 1] + norm(sub(pair[1], pair[0])));
    }
    let whole = at[at.len() - 1];
    let mut piece = 0;
    (0..count)
        .map(|k| {
            let requested = whole * k as f64 / (count - 1) as f64;
            while piece + 2 < points.len() && at[piece + 1] < requested {
                piece += 1;
            }
            let Some(end) = points.get(piece + 1) else { return *first };
            let length = (at[piece + 1] - at[piece]).max(1e-12);
            add(points[piece], sub(*end, points[piece]), ((requested - at[piece]) / length).clamp(0.0, 1.0))
        })
        .collect()
}

fn sub(a: [f64; 3], b: [f64; 3]) -> [f64; 3] {
    [0, 1, 2].map(|k| a[k] - b[k])
}

fn add(a: [f64; 3], b: [f64; 3], factor: f64) -> [f64; 3] {
    [0, 1, 2].map(|k| a[k] + factor * b[k])
}

fn norm(a: [f64; 3]) -> f64 {
    a.iter().map(|x| x * x).sum::<f64>().sqrt()
}

#[cfg(test)]
mod tests {
    use super::*;

    #[test]
    fn points_along_a_line_are_evenly_spaced_and_keep_its_ends() {
        let points = evenly(&[[0.0; 3], [1.0, 0.0, 0.0], [1.0, 3.0, 0.0]], 9);
        assert_eq!(points.len(), 9);
        assert!(norm(sub(points[8], [1.0, 3.0, 0.0])) < 1e-12);
        assert!(norm(sub(points[4], [1.0, 1.0, 0.0])) < 1e-12);
        assert_eq!(evenly(&[[2.0; 3]], 3), vec![[2.0; 3]; 3]);
        assert_eq!(evenly(&[], 2), vec![[0.0; 3]; 2]);
    }
}
