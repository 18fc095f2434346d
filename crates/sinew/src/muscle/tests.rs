//! Laws of muscles on a floating body with a surface.

pub(crate) mod robots;

use super::{Geometry, Muscles};
use crate::body::vector::{cross, dot, norm, sub};
use crate::body::{JointKind, Robot, WrapKind};
use alloc::vec;
use alloc::vec::Vec;
use robots::{floating, linked};

const KINDS: [WrapKind; 2] = [WrapKind::Sphere, WrapKind::Cylinder];
const RADIUS: f64 = 0.08;
/// Muscles of [`floating`] that touch the surface in every pose of [`poses`].
const WOUND: [usize; 4] = [0, 1, 2, 3];

struct Machine {
    robot: Robot,
    muscles: Muscles,
    geometry: Geometry,
}

impl Machine {
    fn new(kind: WrapKind) -> Machine {
        let robot = floating(kind, RADIUS);
        let muscles = Muscles::new(&robot);
        let geometry = Geometry::new(&robot, &muscles);
        Machine { robot, muscles, geometry }
    }

    /// The geometry after moving from a pose along a velocity.
    fn at(&mut self, q: &[f64], v: &[f64], h: f64) -> &Geometry {
        let mut q = q.to_vec();
        self.robot.integrate(&mut q, v, h).unwrap();
        self.muscles.evaluate(&q, &mut self.geometry).unwrap();
        &self.geometry
    }

    /// All moment arms there.
    fn arms(&mut self, q: &[f64], v: &[f64], h: f64) -> Vec<f64> {
        self.at(q, v, h);
        let mut dense = vec![0.0; self.muscles.count() * self.robot.nv()];
        self.muscles.dense(&self.geometry, &mut dense).unwrap();
        dense
    }

    /// Small motions away from the pose of the description, and velocities.
    fn poses(&self) -> Vec<(Vec<f64>, Vec<f64>)> {
        let list = |seed: usize, size: f64| -> Vec<f64> {
            (0..self.robot.nv()).map(|k| size * libm::sin((5 * seed + 3 * k + seed * k) as f64)).collect()
        };
        let pose = |seed: usize| {
            let mut q = self.robot.reference_pose();
            self.robot.integrate(&mut q, &list(seed, 0.02), 1.0).unwrap();
            (q, list(seed + 10, 1.0))
        };
        (1..6).map(pose).collect()
    }
}

fn close(a: f64, b: f64, bound: f64) -> bool {
    (a - b).abs() < bound
}

#[test]
fn lengths_over_a_floating_surface_change_as_moment_arms_say() {
    for kind in KINDS {
        let mut machine = Machine::new(kind);
        let (count, nv) = (machine.muscles.count(), machine.robot.nv());
        for (q, v) in machine.poses() {
            let h = 1e-6;
            let (before, after) =
                (machine.at(&q, &v, -h).lengths().to_vec(), machine.at(&q, &v, h).lengths().to_vec());
            let dense = machine.arms(&q, &v, 0.0);
            let mut rates = vec![0.0; count];
            machine.muscles.velocities(&machine.geometry, &v, &mut rates).unwrap();
            for k in 0..count {
                let slope = (after[k] - before[k]) / (2.0 * h);
                let given: f64 = (0..nv).map(|j| dense[k * nv + j] * v[j]).sum();
                assert!(close(slope, rates[k], 6e-10), "{kind:?}, muscle {k}: {slope} {}", rates[k]);
                assert!(close(-given, rates[k], 1e-15), "{kind:?}, muscle {k}");
            }
            for k in WOUND {
                assert!(machine.geometry.strands[k].touches.any(), "{kind:?}, muscle {k}");
            }
        }
    }
}

#[test]
fn a_muscles_own_arms_are_its_row_of_the_matrix_and_those_of_no_muscle_are_none() {
    let mut machine = Machine::new(WrapKind::Cylinder);
    let (q, v) = machine.poses().remove(0);
    let (dense, nv) = (machine.arms(&q, &v, 0.0), machine.robot.nv());
    let Machine { muscles, geometry, .. } = &machine;
    for k in 0..muscles.count() {
        let (columns, arms) = (muscles.columns(k), muscles.arms(geometry, k));
        assert_eq!(columns.len(), arms.len());
        let mut row = vec![0.0; nv];
        columns.iter().zip(arms).for_each(|(&column, arm)| row[column] = *arm);
        assert_eq!(row, dense[k * nv..(k + 1) * nv]);
        // The spatial ones cross all joints, the fixed one the hinge.
        assert_eq!(columns, if k == 6 { &[6][..] } else { &[0, 1, 2, 3, 4, 5, 6] });
    }
    assert!(muscles.columns(7).is_empty() && muscles.arms(geometry, 7).is_empty());
}

#[test]
fn the_way_that_is_drawn_has_the_length_the_turns_and_the_ends_of_the_muscle() {
    for kind in KINDS {
        let mut machine = Machine::new(kind);
        let mut angles = vec![f64::NAN; machine.muscles.count()];
        for (q, v) in machine.poses() {
            machine.at(&q, &v, 0.0);
            let Machine { muscles, geometry, .. } = &machine;
            let mut poses = crate::body::Poses::new(&machine.robot);
            machine.robot.forward_kinematics(&q, &mut poses).unwrap();
            muscles.wrap_angles(geometry, &mut angles).unwrap();
            for k in 0..muscles.count() {
                let branches = muscles.path(geometry, k, 0.01).unwrap();
                assert_eq!(branches.len(), [1, 1, 1, 1, 1, 2, 0][k]);
                let pieces: Vec<Vec<[f64; 3]>> = branches
                    .iter()
                    .map(|points| points.windows(2).map(|pair| sub(pair[1], pair[0])).collect())
                    .collect();
                let way = |pieces: &[[f64; 3]]| pieces.iter().map(|piece| norm(*piece)).sum::<f64>();
                let length = match k {
                    5 => way(&pieces[0]) + 0.5 * way(&pieces[1]),
                    6 => 0.03 * q[7],
                    _ => way(&pieces[0]),
                };
                assert!(close(length, geometry.lengths()[k], 5e-7), "{kind:?}, muscle {k}: {length}");
                // A muscle wraps by as much as what is drawn of it turns.
                let turns = pieces.first().map_or(0.0, |pieces| {
                    let turn = |a, b| libm::atan2(norm(cross(a, b)), dot(a, b));
                    pieces.windows(2).map(|pair| turn(pair[0], pair[1])).sum::<f64>()
                });
                if WOUND.contains(&k) {
                    assert!(
                        turns > 0.1 && close(turns, angles[k], 3e-8),
                        "{kind:?}, muscle {k}: {turns} {}",
                        angles[k]
                    );
                } else {
                    assert!(close(angles[k], 0.0, f64::MIN_POSITIVE));
                }
                let (from, to) = if k == 3 || k == 4 { (5, 6) } else { (0, 1) };
                if let (Some(first), Some(last)) = (branches.first(), branches.last()) {
                    let at = |site: usize| machine.robot.site_pose(&poses, site).origin;
                    assert!(norm(sub(first[0], at(from))) < 1e-15, "{kind:?}, muscle {k}");
                    assert!(norm(sub(last[last.len() - 1], at(to))) < 1e-15, "{kind:?}, muscle {k}");
                }
            }
            assert!(muscles.path(geometry, 7, 0.01).unwrap().is_empty());
        }
    }
}

#[test]
fn a_piece_between_two_sites_at_one_place_has_no_length_and_no_arms() {
    let robot = linked(&[JointKind::Hinge, JointKind::Hinge]);
    let muscles = Muscles::new(&robot);
    let mut geometry = Geometry::new(&robot, &muscles);
    muscles.evaluate(&[0.3, -0.7], &mut geometry).unwrap();
    assert!(close(geometry.lengths()[0], libm::hypot(0.2, 0.1), 1e-16));
    assert!(geometry.moment_arms().iter().all(|arm| close(*arm, 0.0, 1e-16)));
}

#[test]
fn a_geometry_of_a_robot_with_fewer_links_is_refused_though_all_else_is_alike() {
    let (one, two) = (linked(&[JointKind::Free]), linked(&[JointKind::Ball, JointKind::Ball]));
    let mut geometry = Geometry::new(&one, &Muscles::new(&one));
    let muscles = Muscles::new(&two);
    assert_eq!(geometry.moment_arms().len(), Geometry::new(&two, &muscles).moment_arms().len());
    assert!(muscles.evaluate(&two.reference_pose(), &mut geometry).is_err());
    assert!(muscles.path(&geometry, 0, 0.1).is_err());
}
