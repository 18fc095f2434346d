//! Sums over samples against their definitions. What trains whole networks is in
//! `tests/identify/perceptron.rs`, which is optimised.

use super::network::Net;
use super::normal_equations::{Normal, normal_equations, squared_error};
use crate::fit::simd::Real;
use proptest::prelude::*;
use pulp::Simd;
use rand::{RngExt, SeedableRng};
use rand_chacha::ChaCha8Rng;
use std::marker::PhantomData;

/// Parameters between -1 and 1 and samples between -2 and 2.
fn problem(inputs: usize, hidden: usize, samples: usize, seed: u64) -> (Vec<f64>, Vec<f64>) {
    let mut rng = ChaCha8Rng::seed_from_u64(seed);
    let mut symmetric = |size: f64| size * (2.0 * rng.random::<f64>() - 1.0);
    let theta = (0..Net::parameters(inputs, hidden)).map(|_| symmetric(1.0)).collect();
    (theta, (0..samples * (inputs + 1)).map(|_| symmetric(2.0)).collect())
}

/// Output and its derivatives by the parameters, one sample, written from the definition.
fn plain_row(inputs: usize, hidden: usize, theta: &[f64], x: &[f64]) -> (f64, Vec<f64>) {
    let mut row = vec![0.0; theta.len()];
    let mut output = theta[(inputs + 2) * hidden];
    row[(inputs + 2) * hidden] = 1.0;
    for j in 0..hidden {
        let net: f64 = (0..inputs).map(|i| theta[i * hidden + j] * x[i]).sum();
        let h = (net + theta[inputs * hidden + j]).tanh();
        let v = theta[(inputs + 1) * hidden + j];
        output += v * h;
        row[(inputs + 1) * hidden + j] = h;
        for i in 0..=inputs {
            row[i * hidden + j] = v * (1.0 - h * h) * x.get(i).filter(|_| i < inputs).unwrap_or(&1.0);
        }
    }
    (output, row)
}

proptest! {
    #![proptest_config(ProptestConfig::with_cases(40))]
    #[test]
    fn the_normal_equations_are_the_product_of_the_plain_jacobian(
        inputs in 1_usize..7, hidden in 1_usize..42, samples in 1_usize..200, seed in 0_u64..1000
    ) {
        let (theta, rows) = problem(inputs, hidden, samples, seed);
        let net = Net::new(inputs, hidden, &theta);
        let got = normal_equations::<f64>(&net, &rows);
        let p = theta.len();
        let (mut matrix, mut gradient, mut loss) = (vec![0.0; p * p], vec![0.0; p], 0.0);
        for sample in rows.chunks_exact(inputs + 1) {
            let (output, row) = plain_row(inputs, hidden, &theta, &sample[..inputs]);
            let e = output - sample[inputs];
            loss += e * e;
            for (r, a) in row.iter().enumerate() {
                gradient[r] += a * e;
                for (sum, b) in matrix[r * p..].iter_mut().zip(&row[..=r]) {
                    *sum += a * b;
                }
            }
        }
        let near = |a: f64, b: f64, what: &str| {
            let tolerance = 1e-13 * samples as f64 * (1.0 + hidden as f64);
            if (a - b).abs() < tolerance { Ok(()) } else { Err(TestCaseError::fail(format!("{what}: {a} {b}"))) }
        };
        near(got.squares, loss, "squared error")?;
        near(squared_error(&net, &rows), loss, "squared error alone")?;
        for r in 0..p {
            near(got.gradient[r], gradient[r], "gradient")?;
            for c in 0..=r {
                near(got.normal[(r, c)], matrix[r * p + c], &format!("entry {r} {c}"))?;
            }
        }
    }
}

/// Every entry of the sums over `rows`, as one kind of machine computes them.
fn sums_on<S: Simd, R: Real>(simd: S, net: &Net, rows: &[f64]) -> Vec<f64> {
    let sums = simd.vectorize(Normal::<R> { net, samples: rows, products: PhantomData });
    let p = Net::parameters(net.inputs, net.hidden);
    let lower = (0..p).flat_map(|r| (0..=r).map(move |c| (r, c))).map(|(r, c)| sums.normal(net, r, c));
    lower.chain((0..p).map(|r| sums.gradient(net, r))).collect()
}

#[test]
fn every_width_of_vector_gives_the_same_sums() {
    for (inputs, hidden) in [(4, 30), (1, 1), (3, 17)] {
        let (theta, rows) = problem(inputs, hidden, 150, 21);
        let net = Net::new(inputs, hidden, &theta);
        let plain = sums_on::<_, f64>(pulp::Scalar, &net, &rows);
        let near = |other: &[f64], tolerance: f64| {
            let off = plain.iter().zip(other).map(|(a, b)| (a - b).abs()).fold(0.0, f64::max);
            assert!(off < tolerance, "{inputs} {hidden}: {off:e}");
        };
        near(&sums_on::<_, f32>(pulp::Scalar, &net, &rows), 1e-3);
        #[cfg(target_arch = "x86_64")]
        if let Some(simd) = pulp::x86::V3::try_new() {
            near(&sums_on::<_, f64>(simd, &net, &rows), 1e-10);
            near(&sums_on::<_, f32>(simd, &net, &rows), 1e-3);
        }
        #[cfg(target_arch = "x86_64")]
        if let Some(simd) = pulp::x86::V4::try_new() {
            near(&sums_on::<_, f64>(simd, &net, &rows), 1e-10);
            near(&sums_on::<_, f32>(simd, &net, &rows), 1e-3);
        }
    }
}

#[test]
fn f32_products_are_those_of_f64_rounded_and_leave_the_gradient_alone() {
    for (inputs, hidden) in [(1, 1), (4, 30), (3, 16), (2, 37)] {
        let (theta, rows) = problem(inputs, hidden, 3000, 9);
        let net = Net::new(inputs, hidden, &theta);
        let (exact, rounded) = (normal_equations::<f64>(&net, &rows), normal_equations::<f32>(&net, &rows));
        assert_eq!(exact.gradient, rounded.gradient);
        assert_eq!(exact.squares.to_bits(), rounded.squares.to_bits());
        for r in 0..theta.len() {
            for c in 0..=r {
                let size = (exact.normal[(r, r)] * exact.normal[(c, c)]).sqrt();
                let off = (exact.normal[(r, c)] - rounded.normal[(r, c)]).abs();
                assert!(off <= 2e-7 * size, "{inputs} {hidden}, entry {r} {c}: {off:e} of {size:e}");
            }
        }
    }
}

#[test]
fn the_gradient_is_the_slope_of_the_loss() {
    let (inputs, hidden) = (3, 7);
    let (theta, rows) = problem(inputs, hidden, 5000, 3);
    let gradient = normal_equations::<f64>(&Net::new(inputs, hidden, &theta), &rows).gradient;
    let steepest = gradient.iter().copied().fold(0.0, |a: f64, b| a.max(b.abs()));
    assert!(steepest > 100.0, "the test must be on a slope: {steepest}");
    for at in 0..theta.len() {
        let loss = |shift: f64| {
            let mut theta = theta.clone();
            theta[at] += shift;
            squared_error(&Net::new(inputs, hidden, &theta), &rows)
        };
        let slope = (loss(1e-5) - loss(-1e-5)) / 4e-5;
        assert!((slope - gradient[at]).abs() < 1e-6 * steepest, "{at}: {slope} {}", gradient[at]);
    }
}
