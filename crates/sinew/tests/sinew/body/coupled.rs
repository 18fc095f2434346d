//! Joints that follow others.

use super::robots::{Random, difference, parts, robot};
use sinew::body::{Coupling, Poses, Reduction, Robot, Scratch};

/// The serial arm with one joint following another that follows a third, and one held fast.
fn arm() -> Robot {
    let mut parts = parts("chain7");
    let coupling =
        |follower, leader, coefficients| Coupling { follower, leader, coefficients, pieces: Vec::new() };
    parts.couplings = vec![
        coupling(4, Some(2), [0.2, 0.5, -0.3, 0.1, 0.05]),
        coupling(2, Some(1), [0.1, -0.8, 0.2, 0.0, 0.1]),
        coupling(5, None, [0.3, 0.0, 0.0, 0.0, 0.0]),
    ];
    Robot::new(parts).unwrap()
}

#[test]
fn followers_follow_through_a_chain() {
    let robot = arm();
    let mut q = Random(21).pose(&robot);
    robot.apply_couplings(&mut q).unwrap();
    let polynomial = |c: [f64; 5], x: f64| c[0] + x * (c[1] + x * (c[2] + x * (c[3] + x * c[4])));
    assert!((q[2] - polynomial([0.1, -0.8, 0.2, 0.0, 0.1], q[1])).abs() < 1e-15);
    assert!((q[4] - polynomial([0.2, 0.5, -0.3, 0.1, 0.05], q[2])).abs() < 1e-15);
    assert!((q[5] - 0.3).abs() < 1e-15);
    assert_eq!(Reduction::new(&robot).independent(), [0, 1, 3, 6]);
}

#[test]
fn velocities_and_accelerations_are_derivatives_of_the_coupled_pose() {
    let robot = arm();
    let mut reduction = Reduction::new(&robot);
    let (u, du) = (Random(22).vector(4), Random(23).vector(4));
    let start = Random(24).pose(&robot);
    let pose = |t: f64| {
        let mut q = start.clone();
        for (k, &v) in [0, 1, 3, 6].iter().enumerate() {
            q[v] += u[k] * t + 0.5 * du[k] * t * t;
        }
        robot.apply_couplings(&mut q).unwrap();
        q
    };
    let (before, now, after) = (pose(-1e-4), pose(0.0), pose(1e-4));
    let (mut v, mut a) = (vec![0.0; 7], vec![0.0; 7]);
    reduction.update(&robot, &now).unwrap();
    reduction.velocities(&u, &mut v).unwrap();
    reduction.accelerations(&u, &du, &mut a).unwrap();
    for k in 0..7 {
        assert!((v[k] - (after[k] - before[k]) / 2e-4).abs() < 1e-7);
        assert!((a[k] - (after[k] - 2.0 * now[k] + before[k]) / 1e-8).abs() < 1e-5);
    }
}

#[test]
fn coupled_dynamics_need_no_force_of_the_couplings_on_what_is_free() {
    let robot = arm();
    let (mut reduction, mut scratch) = (Reduction::new(&robot), Scratch::new(&robot));
    let mut q = Random(25).pose(&robot);
    robot.apply_couplings(&mut q).unwrap();
    let (u, tau) = (Random(26).vector(4), Random(27).vector(7));
    let (mut du, mut v, mut a) = (vec![0.0; 4], vec![0.0; 7], vec![0.0; 7]);
    reduction.forward_dynamics(&robot, &q, &u, &tau, &mut scratch, &mut du).unwrap();
    reduction.velocities(&u, &mut v).unwrap();
    reduction.accelerations(&u, &du, &mut a).unwrap();
    let mut needed = vec![0.0; 7];
    robot.inverse_dynamics(&q, &v, &a, &mut scratch, &mut needed).unwrap();
    let rest: Vec<f64> = needed.iter().zip(&tau).map(|(needed, tau)| needed - tau).collect();
    let mut felt = vec![0.0; 4];
    reduction.forces(&rest, &mut felt).unwrap();
    assert!(felt.iter().all(|force| force.abs() < 1e-12), "{felt:?}");
    assert!(rest.iter().any(|force| force.abs() > 0.1), "the couplings are at work: {rest:?}");
}

#[test]
fn without_couplings_reduced_dynamics_are_the_whole() {
    let robot = robot("lm_arm");
    let (mut reduction, mut scratch) = (Reduction::new(&robot), Scratch::new(&robot));
    let q = Random(28).pose(&robot);
    let (u, tau) = (Random(29).vector(7), Random(30).vector(7));
    let (mut ours, mut theirs) = (vec![0.0; 7], vec![0.0; 7]);
    reduction.forward_dynamics(&robot, &q, &u, &tau, &mut scratch, &mut ours).unwrap();
    robot.forward_dynamics(&q, &u, &tau, &mut scratch, &mut theirs).unwrap();
    assert!(difference(&ours, &theirs) < 1e-9);
}

#[test]
fn a_coupled_swing_keeps_its_energy() {
    let robot = arm();
    let (mut reduction, mut scratch, mut poses) =
        (Reduction::new(&robot), Scratch::new(&robot), Poses::new(&robot));
    let mut q = Random(31).pose(&robot);
    robot.apply_couplings(&mut q).unwrap();
    let (mut u, mut du, mut v) = (vec![0.0; 4], vec![0.0; 4], vec![0.0; 7]);
    let mut energies = Vec::new();
    for _ in 0..3000 {
        reduction.forward_dynamics(&robot, &q, &u, &[0.0; 7], &mut scratch, &mut du).unwrap();
        u.iter_mut().zip(&du).for_each(|(u, du)| *u += 1e-4 * du);
        reduction.velocities(&u, &mut v).unwrap();
        robot.integrate(&mut q, &v, 1e-4).unwrap();
        robot.apply_couplings(&mut q).unwrap();
        reduction.update(&robot, &q).unwrap();
        reduction.velocities(&u, &mut v).unwrap();
        robot.forward_kinematics(&q, &mut poses).unwrap();
        let kinetic = robot.kinetic_energy(&q, &v, &mut scratch).unwrap();
        energies.push((kinetic, kinetic + robot.potential_energy(&q, &poses).unwrap()));
    }
    let most = energies.iter().map(|energy| energy.0).fold(0.0, f64::max);
    let drift = energies.iter().map(|energy| (energy.1 - energies[0].1).abs()).fold(0.0, f64::max);
    assert!(most > 0.1 && drift < 0.01 * most, "{drift} of {most}");
}
