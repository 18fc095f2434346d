//! Laws of mechanics, on every robot of the golden files.

use super::robots::{ALL, Random, difference, parts, robot};
use sinew::body::{Parts, Poses, Robot, Scratch};

/// A robot with what loses energy taken out, and a rotor on every joint.
fn lossless(name: &str) -> Parts {
    let mut parts = parts(name);
    for joint in &mut parts.joints {
        (joint.damping, joint.friction) = (0.0, 0.0);
        joint.armature += 0.01;
    }
    parts
}

#[test]
fn forward_after_inverse_dynamics_is_the_identity() {
    let mut random = Random(1);
    for name in ALL {
        let robot = Robot::new(lossless(name)).unwrap();
        let (nv, mut scratch) = (robot.nv(), Scratch::new(&robot));
        let (mut tau, mut back) = (vec![0.0; nv], vec![0.0; nv]);
        for _ in 0..20 {
            let (q, v, a) = (random.pose(&robot), random.vector(nv), random.vector(nv));
            robot.inverse_dynamics(&q, &v, &a, &mut scratch, &mut tau).unwrap();
            robot.forward_dynamics(&q, &v, &tau, &mut scratch, &mut back).unwrap();
            assert!(difference(&back, &a) < 1e-9, "{name}: {}", difference(&back, &a));
        }
    }
}

#[test]
fn the_mass_matrix_is_positive_definite_and_gives_the_kinetic_energy() {
    let mut random = Random(2);
    for name in ALL {
        let robot = robot(name);
        let (nv, mut scratch) = (robot.nv(), Scratch::new(&robot));
        let mut mass = vec![0.0; nv * nv];
        for _ in 0..20 {
            let (q, v) = (random.pose(&robot), random.vector(nv));
            robot.mass_matrix(&q, &mut scratch, &mut mass).unwrap();
            for i in 0..nv {
                for j in 0..i {
                    assert_eq!(mass[i * nv + j].to_bits(), mass[j * nv + i].to_bits());
                }
            }
            let twice: f64 = (0..nv * nv).map(|k| v[k / nv] * mass[k] * v[k % nv]).sum();
            let energy = robot.kinetic_energy(&q, &v, &mut scratch).unwrap();
            assert!((energy - 0.5 * twice).abs() < 1e-12 * (1.0 + energy), "{name}");
            assert!(positive_definite(mass.clone(), nv), "{name}");
        }
    }
}

/// Gauss' pivots are all above zero.
fn positive_definite(mut a: Vec<f64>, n: usize) -> bool {
    for k in 0..n {
        if a[k * n + k] <= 0.0 {
            return false;
        }
        for i in k + 1..n {
            let factor = a[i * n + k] / a[k * n + k];
            for j in k..n {
                a[i * n + j] -= factor * a[k * n + j];
            }
        }
    }
    true
}

#[test]
fn mass_rate_less_twice_coriolis_does_no_work() {
    let mut random = Random(3);
    for name in ALL {
        let robot = robot(name);
        let (nv, mut scratch) = (robot.nv(), Scratch::new(&robot));
        let (mut tau, mut gravity) = (vec![0.0; nv], vec![0.0; nv]);
        for _ in 0..10 {
            let (q, v) = (random.pose(&robot), random.vector(nv));
            // v^T M' v / 2 by differences of the kinetic energy along the motion.
            let h = 1e-4;
            let energy_after = |h: f64, scratch: &mut Scratch| {
                let mut moved = q.clone();
                robot.integrate(&mut moved, &v, h).unwrap();
                robot.kinetic_energy(&moved, &v, scratch).unwrap()
            };
            let rate = (8.0 * (energy_after(h, &mut scratch) - energy_after(-h, &mut scratch))
                - (energy_after(2.0 * h, &mut scratch) - energy_after(-2.0 * h, &mut scratch)))
                / (12.0 * h);
            robot.inverse_dynamics(&q, &v, &vec![0.0; nv], &mut scratch, &mut tau).unwrap();
            robot.gravity_force(&q, &mut scratch, &mut gravity).unwrap();
            let coriolis = tau.iter().zip(&gravity).map(|(tau, gravity)| tau - gravity);
            let power: f64 = coriolis.zip(&v).map(|(tau, v)| tau * v).sum();
            let scale = 1.0 + tau.iter().map(|tau| tau.abs()).sum::<f64>();
            assert!((rate - power).abs() < 1e-8 * scale, "{name}: {rate} {power}");
        }
    }
}

#[test]
fn gravity_torque_is_the_slope_of_the_potential_energy() {
    let mut random = Random(4);
    for name in ALL {
        let mut parts = parts(name);
        parts.joints.iter_mut().for_each(|joint| joint.stiffness = 0.0);
        let robot = Robot::new(parts).unwrap();
        let (nv, mut scratch, mut poses) = (robot.nv(), Scratch::new(&robot), Poses::new(&robot));
        let (q, v, mut tau) = (random.pose(&robot), random.vector(nv), vec![0.0; nv]);
        robot.gravity_force(&q, &mut scratch, &mut tau).unwrap();
        let mut energy = |h: f64| {
            let mut moved = q.clone();
            robot.integrate(&mut moved, &v, h).unwrap();
            robot.forward_kinematics(&moved, &mut poses).unwrap();
            robot.potential_energy(&moved, &poses).unwrap()
        };
        let slope = (energy(1e-5) - energy(-1e-5)) / 2e-5;
        let power: f64 = tau.iter().zip(&v).map(|(tau, v)| tau * v).sum();
        assert!((slope - power).abs() < 1e-7 * (1.0 + power.abs()), "{name}: {slope} {power}");
    }
}

/// Largest drift of the energy in a swing of 0.4 s from rest, by the semi-implicit step of length `dt`.
fn drift(robot: &Robot, start: &[f64], dt: f64) -> (f64, f64) {
    let nv = robot.nv();
    let (mut scratch, mut poses) = (Scratch::new(robot), Poses::new(robot));
    let (mut q, mut v, mut a, mut tau) = (start.to_vec(), vec![0.0; nv], vec![0.0; nv], vec![0.0; nv]);
    let mut energy = |q: &[f64], v: &[f64], scratch: &mut Scratch| {
        robot.forward_kinematics(q, &mut poses).unwrap();
        let kinetic = robot.kinetic_energy(q, v, scratch).unwrap();
        (kinetic + robot.potential_energy(q, &poses).unwrap(), kinetic)
    };
    let (first, _) = energy(&q, &v, &mut scratch);
    let (mut worst, mut most) = (0.0_f64, 0.0_f64);
    for _ in 0..(0.4 / dt).round() as usize {
        robot.passive_force(&q, &v, &mut tau).unwrap();
        robot.forward_dynamics(&q, &v, &tau, &mut scratch, &mut a).unwrap();
        v.iter_mut().zip(&a).for_each(|(v, a)| *v += dt * a);
        robot.integrate(&mut q, &v, dt).unwrap();
        let (now, kinetic) = energy(&q, &v, &mut scratch);
        worst = worst.max((now - first).abs());
        most = most.max(kinetic);
    }
    (worst, most)
}

#[test]
fn an_undamped_swing_keeps_its_energy_to_the_order_of_the_integrator() {
    for name in ["lm_arm", "chain7", "random_0", "random_2"] {
        let robot = Robot::new(lossless(name)).unwrap();
        let start = Random(5).pose(&robot);
        let steps = [4e-4, 2e-4, 1e-4];
        let drifts = steps.map(|dt| drift(&robot, &start, dt));
        let slope = (drifts[0].0 / drifts[2].0).log2() / 2.0;
        assert!((0.85..1.25).contains(&slope), "{name}: order {slope}, {drifts:?}");
        assert!(drifts[2].0 < 0.02 * drifts[2].1, "{name}: {drifts:?}");
        assert!(drifts[2].1 > 0.01, "{name} moved: {drifts:?}");
    }
}

#[test]
fn the_jacobian_is_the_velocity_of_the_point() {
    let mut random = Random(6);
    for name in ALL {
        let robot = robot(name);
        let (nv, mut poses) = (robot.nv(), Poses::new(&robot));
        let (q, v) = (random.pose(&robot), random.vector(nv));
        let body = robot.parts().bodies.len() - 1;
        let mut place = |h: f64| {
            let mut moved = q.clone();
            robot.integrate(&mut moved, &v, h).unwrap();
            robot.forward_kinematics(&moved, &mut poses).unwrap();
            robot.body_pose(&poses, body).point([0.1, -0.2, 0.3])
        };
        let (before, after, point) = (place(-1e-6), place(1e-6), place(0.0));
        let (mut linear, mut angular) = (vec![0.0; 3 * nv], vec![0.0; 3 * nv]);
        robot.jacobian(&poses, body, point, &mut linear, &mut angular).unwrap();
        for k in 0..3 {
            let velocity: f64 = (0..nv).map(|v_| linear[k * nv + v_] * v[v_]).sum();
            assert!((velocity - (after[k] - before[k]) / 2e-6).abs() < 1e-8, "{name}");
        }
    }
}

#[test]
fn a_payload_weighs_what_its_jacobian_says() {
    let robot = robot("lm_arm");
    let hand = robot.body("hand").unwrap();
    let (at, mass, nv) = ([0.01, -0.02, -0.1], 1.3, robot.nv());
    let loaded = robot.with_payload(hand, at, mass).unwrap();
    let q = Random(7).pose(&robot);
    let (mut poses, mut scratch) = (Poses::new(&robot), Scratch::new(&robot));
    let (mut bare, mut full) = (vec![0.0; nv], vec![0.0; nv]);
    robot.gravity_force(&q, &mut scratch, &mut bare).unwrap();
    loaded.gravity_force(&q, &mut scratch, &mut full).unwrap();
    robot.forward_kinematics(&q, &mut poses).unwrap();
    let point = robot.body_pose(&poses, hand).point(at);
    let (mut linear, mut angular) = (vec![0.0; 3 * nv], vec![0.0; 3 * nv]);
    robot.jacobian(&poses, hand, point, &mut linear, &mut angular).unwrap();
    for k in 0..nv {
        assert!((full[k] - bare[k] - mass * 9.81 * linear[2 * nv + k]).abs() < 1e-12);
    }
    assert!((loaded.moving_mass() - robot.moving_mass() - mass).abs() < 1e-12);
    assert!(robot.with_payload(99, at, mass).is_err() && robot.with_payload(hand, at, -1.0).is_err());
}

#[test]
fn integrating_a_difference_arrives() {
    let mut random = Random(8);
    for name in ALL {
        let robot = robot(name);
        let (from, to) = (random.pose(&robot), random.pose(&robot));
        let mut v = vec![0.0; robot.nv()];
        robot.difference(&from, &to, &mut v).unwrap();
        let mut arrived = from.clone();
        robot.integrate(&mut arrived, &v, 1.0).unwrap();
        let mut rest = vec![0.0; robot.nv()];
        robot.difference(&arrived, &to, &mut rest).unwrap();
        assert!(rest.iter().all(|x| x.abs() < 1e-13), "{name}: {rest:?}");
    }
}

#[test]
fn a_joint_that_moves_no_mass_is_reported_by_its_index() {
    let mut parts = parts("chain7");
    let last = parts.bodies.last_mut().unwrap();
    (last.mass, last.inertia) = (0.0, [0.0; 6]);
    let robot = Robot::new(parts).unwrap();
    let nv = robot.nv();
    let (q, v, mut a) = (robot.reference_pose(), vec![0.0; nv], vec![0.0; nv]);
    let failed = robot.forward_dynamics(&q, &v, &v, &mut Scratch::new(&robot), &mut a).unwrap_err();
    assert!(failed.to_string().contains("joint number 6: the inertia it moves"), "{failed}");
}
