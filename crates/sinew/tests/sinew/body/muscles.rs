//! Laws of muscles' lengths and moment arms.

use super::robots::{Random, robot, text};
use sinew::body::{Robot, SheathGeometry};
use sinew::muscle::{Geometry, Muscles};

const MUSCULAR: [&str; 7] = ["lm_arm", "finger", "random_0", "random_1", "random_2", "random_3", "random_4"];

struct Body {
    robot: Robot,
    muscles: Muscles,
    geometry: Geometry,
}

impl Body {
    fn new(robot: Robot) -> Body {
        let muscles = Muscles::new(&robot);
        let geometry = Geometry::new(&robot, &muscles);
        Body { robot, muscles, geometry }
    }

    /// The geometry after moving along a velocity.
    fn moved(&mut self, q: &[f64], v: &[f64], h: f64) -> &Geometry {
        let mut q = q.to_vec();
        self.robot.integrate(&mut q, v, h).unwrap();
        self.muscles.evaluate(&q, &mut self.geometry).unwrap();
        &self.geometry
    }
}

#[test]
fn lengths_change_as_moment_arms_say() {
    let mut random = Random(11);
    for name in MUSCULAR {
        let mut body = Body::new(robot(name));
        let (count, nv) = (body.muscles.count(), body.robot.nv());
        let mut checked = 0;
        for _ in 0..200 {
            let (q, v) = (random.pose(&body.robot), random.vector(nv));
            let h = 1e-6;
            let before = body.moved(&q, &v, -h).lengths().to_vec();
            let after = body.moved(&q, &v, h).lengths().to_vec();
            let now = body.moved(&q, &v, 0.0).lengths().to_vec();
            let mut rates = vec![0.0; count];
            body.muscles.velocities(&body.geometry, &v, &mut rates).unwrap();
            for k in 0..count {
                let (left, right) = ((now[k] - before[k]) / h, (after[k] - now[k]) / h);
                // Where the cable comes to a surface or leaves it the slope has a kink, or the length a step.
                if (left - right).abs() > 1e-3 {
                    continue;
                }
                checked += 1;
                let slope = (after[k] - before[k]) / (2.0 * h);
                assert!((slope - rates[k]).abs() < 2e-8, "{name}, muscle {k}: {slope} {}", rates[k]);
            }
        }
        assert!(checked > 195 * count, "{name}: {checked}");
    }
}

#[test]
fn power_of_tensions_is_power_of_torques() {
    let mut random = Random(13);
    for name in MUSCULAR {
        let mut body = Body::new(robot(name));
        let (count, nv) = (body.muscles.count(), body.robot.nv());
        let (q, v, tensions) = (random.pose(&body.robot), random.vector(nv), random.vector(count));
        body.moved(&q, &v, 0.0);
        let (mut rates, mut tau) = (vec![0.0; count], vec![0.0; nv]);
        body.muscles.velocities(&body.geometry, &v, &mut rates).unwrap();
        body.muscles.torque(&body.geometry, &tensions, &mut tau).unwrap();
        let cables: f64 = rates.iter().zip(&tensions).map(|(l, f)| l * f).sum();
        let joints: f64 = tau.iter().zip(&v).map(|(tau, v)| tau * v).sum();
        assert!((cables + joints).abs() < 1e-13, "{name}: {cables} {joints}");
    }
}

#[test]
fn no_muscle_of_the_arm_jumps_along_lines_through_its_joint_space() {
    let mut random = Random(14);
    let mut body = Body::new(robot("lm_arm"));
    let (count, nv, steps) = (body.muscles.count(), body.robot.nv(), 400);
    let mut travel = 0.0_f64;
    for _ in 0..100 {
        let (from, to) = (random.pose(&body.robot), random.pose(&body.robot));
        let mut v = vec![0.0; nv];
        body.robot.difference(&from, &to, &mut v).unwrap();
        let (mut last, mut slopes) = (body.moved(&from, &v, 0.0).lengths().to_vec(), vec![0.0; count]);
        body.muscles.velocities(&body.geometry, &v, &mut slopes).unwrap();
        for step in 1..=steps {
            let now = body.moved(&from, &v, f64::from(step) / f64::from(steps)).lengths().to_vec();
            let mut ahead = vec![0.0; count];
            body.muscles.velocities(&body.geometry, &v, &mut ahead).unwrap();
            for k in 0..count {
                // The way between two points follows from the slopes at both, kinks of the slope included.
                let most = slopes[k].abs().max(ahead[k].abs()) * 1.2 / f64::from(steps) + 2e-5;
                assert!((now[k] - last[k]).abs() < most, "muscle {k}: {} {}", now[k], last[k]);
                travel = travel.max((now[k] - last[k]).abs());
            }
            (last, slopes) = (now, ahead);
        }
    }
    assert!(travel > 1e-4, "{travel}");
}

#[test]
fn bends_are_those_of_the_arms_design() {
    let mut parts = robot("lm_arm").parts().clone();
    for tendon in &mut parts.tendons {
        let end = parts.sites.iter().find(|site| site.name == format!("{}_o", tendon.name)).unwrap();
        let [w, x, y, z] = end.orientation;
        let axis = [2.0 * (x * z + w * y), 2.0 * (y * z - w * x), w * w - x * x - y * y + z * z];
        tendon.sheath = Some(SheathGeometry { length: 1.0, bend: 1.0, end_axis: Some(axis) });
    }
    let mut body = Body::new(Robot::new(parts).unwrap());
    let (mut bends, mut wraps) = (vec![0.0; 15], vec![0.0; 15]);
    let table = text("lm_arm_bends.csv");
    for line in table.lines().skip(1) {
        let numbers: Vec<f64> = line.split(',').map(|x| x.parse().unwrap()).collect();
        body.moved(&numbers[..7], &[0.0; 7], 0.0);
        body.muscles.bends(&body.geometry, &mut bends).unwrap();
        body.muscles.wrap_angles(&body.geometry, &mut wraps).unwrap();
        for k in 0..15 {
            assert!((bends[k] - numbers[7 + k]).abs() < 2e-7, "muscle {k}: {} {}", bends[k], numbers[7 + k]);
            assert!(wraps[k] <= bends[k] + 1e-12);
        }
    }
}

#[test]
fn the_way_that_is_drawn_has_the_length_that_is_computed() {
    let mut random = Random(15);
    for name in MUSCULAR {
        let mut body = Body::new(robot(name));
        let q = random.pose(&body.robot);
        body.moved(&q, &vec![0.0; body.robot.nv()], 0.0);
        for muscle in 0..body.muscles.count() {
            let branches = body.muscles.path(&body.geometry, muscle, 0.002).unwrap();
            // The fraction of each branch of a tackle is not drawn.
            if branches.len() != 1 {
                continue;
            }
            let way: f64 = branches[0]
                .windows(2)
                .map(|pair| (0..3).map(|k| (pair[1][k] - pair[0][k]).powi(2)).sum::<f64>().sqrt())
                .sum();
            let length = body.geometry.lengths()[muscle];
            assert!((way - length).abs() < 1e-6 * length, "{name}, muscle {muscle}: {way} {length}");
        }
    }
}
