//! Mechanics and muscles equal MuJoCo's and Pinocchio's: values of `benches/peers/body_golden.py`.

use super::robots::{Golden, difference, files, read, text};
use serde::Deserialize;
use sinew::body::{Parts, PathElement, Poses, Robot, Scratch, TendonPath};
use sinew::muscle::{Geometry, Muscles};

#[derive(Deserialize)]
struct Case {
    q: Vec<f64>,
    v: Vec<f64>,
    a: Vec<f64>,
    lengths: Vec<f64>,
    arms: Vec<(usize, usize, f64)>,
    /// The lower half, row by row.
    mass: Vec<f64>,
    bias: Vec<f64>,
    gravity: Vec<f64>,
    passive: Vec<f64>,
    last_body: [f64; 3],
    last_site: [f64; 3],
}

fn each(mut check: impl FnMut(&str, &Robot, &Case)) {
    for path in files() {
        let golden: Golden<Case> = read(&path);
        let name = path.file_stem().unwrap().to_string_lossy().into_owned();
        let robot = Robot::new(golden.parts).unwrap();
        for (k, case) in golden.cases.iter().enumerate() {
            check(&format!("{name}, pose {k}"), &robot, case);
        }
    }
}

/// Whether a tendon has a side site within the surface it belongs to.
fn runs_inside(parts: &Parts, tendon: usize) -> bool {
    let TendonPath::Spatial(elements) = &parts.tendons[tendon].path else { return false };
    elements.iter().any(|element| match *element {
        PathElement::Wrap { wrap, side: Some(side) } => {
            let (wrap, site) = (&parts.wraps[wrap], &parts.sites[side]);
            let square = |k: usize| (wrap.position[k] - site.position[k]).powi(2);
            wrap.body == site.body && (0..3).map(square).sum::<f64>().sqrt() < wrap.radius
        }
        _ => false,
    })
}

#[test]
fn lengths_are_mujocos_to_a_nanometre_and_moment_arms_to_ten() {
    let mut worst = (0.0_f64, 0.0_f64);
    each(|name, robot, case| {
        let muscles = Muscles::new(robot);
        let mut geometry = Geometry::new(robot, &muscles);
        muscles.evaluate(&case.q, &mut geometry).unwrap();
        let nv = robot.nv();
        let (mut arms, mut theirs) = (vec![0.0; muscles.count() * nv], vec![0.0; muscles.count() * nv]);
        muscles.dense(&geometry, &mut arms).unwrap();
        for &(muscle, velocity, arm) in &case.arms {
            theirs[muscle * nv + velocity] = arm;
        }
        for (muscle, (ours, length)) in geometry.lengths().iter().zip(&case.lengths).enumerate() {
            let error = (ours - length).abs();
            let tendon = &robot.parts().tendons[muscle].name;
            assert!(error < 1e-9, "{name}: length of `{tendon}`: {ours} instead of {length}");
            worst.0 = worst.0.max(error);
        }
        for (k, (ours, arm)) in arms.iter().zip(&theirs).enumerate() {
            let tendon = &robot.parts().tendons[k / nv].name;
            let error = (ours - arm).abs();
            // MuJoCo stops its iteration inside a ring at 1e-6 rad.
            let bound = if runs_inside(robot.parts(), k / nv) { 1e-6 } else { 1e-8 };
            assert!(error < bound, "{name}: arm of `{tendon}` about {}: {ours} instead of {arm}", k % nv);
            if bound < 1e-7 {
                worst.1 = worst.1.max(error);
            }
        }
    });
    eprintln!("worst: lengths {:.1e} m, moment arms {:.1e} m", worst.0, worst.1);
}

#[test]
fn dynamics_are_mujocos() {
    let mut worst = 0.0_f64;
    each(|name, robot, case| {
        let (nv, mut scratch) = (robot.nv(), Scratch::new(robot));
        let (mut mass, mut tau, mut other) = (vec![0.0; nv * nv], vec![0.0; nv], vec![0.0; nv]);
        let mut check = |what: &str, ours: &[f64], theirs: &[f64]| {
            let error = difference(ours, theirs);
            assert!(error < 1e-9, "{name}: {what} differs by {error:e}: {ours:?} {theirs:?}");
            worst = worst.max(error);
        };
        robot.mass_matrix(&case.q, &mut scratch, &mut mass).unwrap();
        let lower: Vec<f64> = (0..nv).flat_map(|i| mass[i * nv..=i * nv + i].to_vec()).collect();
        check("mass matrix", &lower, &case.mass);
        robot.inverse_dynamics(&case.q, &case.v, &vec![0.0; nv], &mut scratch, &mut tau).unwrap();
        check("bias", &tau, &case.bias);
        robot.gravity_force(&case.q, &mut scratch, &mut tau).unwrap();
        check("gravity", &tau, &case.gravity);
        robot.passive_force(&case.q, &case.v, &mut tau).unwrap();
        check("passive force", &tau, &case.passive);
        // M a + c + g, and back.
        robot.inverse_dynamics(&case.q, &case.v, &case.a, &mut scratch, &mut tau).unwrap();
        let theirs: Vec<f64> = (0..nv)
            .map(|i| case.bias[i] + (0..nv).map(|j| mass[i * nv + j] * case.a[j]).sum::<f64>())
            .collect();
        check("inverse dynamics", &tau, &theirs);
        robot.forward_dynamics(&case.q, &case.v, &tau, &mut scratch, &mut other).unwrap();
        let error = difference(&other, &case.a);
        assert!(error < 1e-7, "{name}: forward after inverse dynamics differs by {error:e}");
    });
    eprintln!("worst: {worst:.1e} relative");
}

#[test]
fn bodies_and_sites_stand_where_mujoco_puts_them() {
    each(|name, robot, case| {
        let mut poses = Poses::new(robot);
        robot.forward_kinematics(&case.q, &mut poses).unwrap();
        let body = robot.body_pose(&poses, robot.parts().bodies.len() - 1).origin;
        assert!(difference(&body, &case.last_body) < 1e-13, "{name}: {body:?} {:?}", case.last_body);
        if let Some(site) = robot.parts().sites.len().checked_sub(1) {
            let site = robot.site_pose(&poses, site).origin;
            assert!(difference(&site, &case.last_site) < 1e-13, "{name}: {site:?} {:?}", case.last_site);
        }
    });
}

#[derive(Deserialize)]
struct ArmCase {
    q: Vec<f64>,
    v: Vec<f64>,
    a: Vec<f64>,
    mass: Vec<f64>,
    inverse: Vec<f64>,
    tau: Vec<f64>,
    forward: Vec<f64>,
}

#[test]
fn dynamics_of_a_serial_arm_are_pinocchios() {
    let golden: Golden<ArmCase> = serde_json::from_str(&text("chain7.json")).unwrap();
    let robot = Robot::new(golden.parts).unwrap();
    let (nv, mut scratch) = (robot.nv(), Scratch::new(&robot));
    let (mut mass, mut found) = (vec![0.0; nv * nv], vec![0.0; nv]);
    for case in &golden.cases {
        robot.mass_matrix(&case.q, &mut scratch, &mut mass).unwrap();
        let lower: Vec<f64> = (0..nv).flat_map(|i| mass[i * nv..=i * nv + i].to_vec()).collect();
        assert!(difference(&lower, &case.mass) < 1e-10);
        robot.inverse_dynamics(&case.q, &case.v, &case.a, &mut scratch, &mut found).unwrap();
        assert!(difference(&found, &case.inverse) < 1e-10);
        robot.forward_dynamics(&case.q, &case.v, &case.tau, &mut scratch, &mut found).unwrap();
        assert!(difference(&found, &case.forward) < 1e-10);
    }
    assert!(golden.cases.len() >= 5);
}
