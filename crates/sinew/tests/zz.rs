use sinew::control::tension::{Distribution, Problem};
use sinew::random::Random;
#[test]
fn zz() {
    let mut random = Random::new(2);
    for _ in 0..300 {
        let mut arms = vec![0.0; 63 * 20];
        for (i, row) in arms.chunks_exact_mut(20).enumerate() {
            for k in 0..3 {
                row[(i + 7 * k + (random.unit() * 3.0) as usize) % 20] = 0.03 * random.normal();
            }
        }
        let f: Vec<f64> = (0..63).map(|_| 20.0 + 380.0 * random.unit()).collect();
        let mut t = vec![0.0; 20];
        for (row, f) in arms.chunks_exact(20).zip(&f) {
            t.iter_mut().zip(row).for_each(|(t, a)| *t += a * f);
        }
        let more: Vec<f64> = (0..20).map(|_| 5.0 * random.normal()).collect();
        for _ in 0..10 {
            t.iter_mut().zip(&more).for_each(|(t, m)| *t += m);
            let mut d = Distribution::new(63, 20);
            let s = d
                .solve(&Problem {
                    moment_arms: &arms,
                    torque: &t,
                    minimum: &[20.0; 63],
                    maximum: &[400.0; 63],
                    reference: &[0.0; 63],
                    weight: &[1.0; 63],
                })
                .unwrap();
            eprintln!("ITER {:?} {}", s.status, s.iterations);
            if s.status != sinew::control::tension::Status::Optimal {
                break;
            }
        }
    }
}
