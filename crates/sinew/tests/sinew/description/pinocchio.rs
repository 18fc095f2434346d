//! URDF robots against Pinocchio (`benches/peers/urdf_golden.py`).

use serde::Deserialize;
use sinew::body::{Robot, Scratch};
use sinew::description::from_urdf;

#[derive(Deserialize)]
struct Golden {
    robots: Vec<Reference>,
}

#[derive(Deserialize)]
struct Reference {
    urdf: String,
    joints: Vec<String>,
    cases: Vec<Case>,
}

#[derive(Deserialize)]
struct Case {
    q: Vec<f64>,
    v: Vec<f64>,
    a: Vec<f64>,
    tau: Vec<f64>,
    inverse: Vec<f64>,
    mass: Vec<f64>,
    forward: Vec<f64>,
}

/// Largest difference as a fraction of the largest value.
fn apart(ours: &[f64], theirs: &[f64]) -> f64 {
    let largest = |values: &mut dyn Iterator<Item = f64>| values.fold(0.0, |most: f64, x| most.max(x.abs()));
    largest(&mut ours.iter().zip(theirs).map(|(a, b)| a - b)) / largest(&mut theirs.iter().copied()).max(1.0)
}

#[test]
fn robots_from_urdf_move_as_pinocchio_says() {
    let golden: Golden = serde_json::from_str(include_str!("pinocchio.json")).unwrap();
    let mut worst = [0.0_f64; 3];
    for robot in golden.robots {
        let parts = from_urdf("golden.urdf", &robot.urdf, None).unwrap().parts;
        let place = |name: &String| robot.joints.iter().position(|joint| joint == name).unwrap();
        let order: Vec<usize> = parts.joints.iter().map(|joint| place(&joint.name)).collect();
        assert_eq!(order.len(), robot.joints.len());
        let ours = |theirs: &[f64]| -> Vec<f64> { order.iter().map(|&k| theirs[k]).collect() };
        let (built, n) = (Robot::new(parts).unwrap(), order.len());
        let (mut scratch, mut found, mut mass) = (Scratch::new(&built), vec![0.0; n], vec![0.0; n * n]);
        for case in &robot.cases {
            let [q, v, a, tau] = [&case.q, &case.v, &case.a, &case.tau].map(|x| ours(x));
            built.inverse_dynamics(&q, &v, &a, &mut scratch, &mut found).unwrap();
            worst[0] = worst[0].max(apart(&found, &ours(&case.inverse)));
            built.mass_matrix(&q, &mut scratch, &mut mass).unwrap();
            let theirs: Vec<f64> = order
                .iter()
                .flat_map(|&i| order.iter().map(move |&j| (i, j)))
                .map(|(i, j)| case.mass[i * n + j])
                .collect();
            worst[1] = worst[1].max(apart(&mass, &theirs));
            built.forward_dynamics(&q, &v, &tau, &mut scratch, &mut found).unwrap();
            worst[2] = worst[2].max(apart(&found, &ours(&case.forward)));
        }
    }
    eprintln!("{worst:?}");
    assert!(worst.iter().all(|worst| *worst < 1e-10), "{worst:?}");
}
