//! Laws of the training.

use super::network::Net;
use super::normal_equations::{Normal, normal_equations, squared_error};
use super::*;
use crate::fit::simd::Real;
use proptest::prelude::*;
use pulp::Simd;
use std::marker::PhantomData;

/// Numbers between -1 and 1 that repeat for no small shift.
fn noise(seed: u64) -> impl Fn(usize) -> f64 {
    move |i| {
        let mut word =
            (i as u64 + 1).wrapping_mul(0x9E37_79B9_7F4A_7C15) ^ seed.wrapping_mul(0xD1B5_4A32_D192_ED03);
        word ^= word >> 29;
        word = word.wrapping_mul(0xBF58_476D_1CE4_E5B9);
        word ^= word >> 32;
        (word >> 11) as f64 / (1_u64 << 52) as f64 - 1.0
    }
}

fn problem(inputs: usize, hidden: usize, samples: usize, seed: u64) -> (Vec<f64>, Vec<f64>) {
    let theta = (0..Net::parameters(inputs, hidden)).map(noise(seed)).collect();
    (theta, (0..samples * (inputs + 1)).map(noise(seed + 1)).map(|x| 2.0 * x).collect())
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
                for (c, b) in row.iter().enumerate() {
                    matrix[r * p + c] += a * b;
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
fn f32_products_train_as_well_as_f64() {
    let (x, t) = smooth(2, 20_000);
    let options = TrainOptions { hidden: 12, steps: 40, seed: 2, tolerance: 0.0, held_back: 0.0 };
    let losses = |many: usize| training::train_with(&x, &t, &options, many).unwrap().loss_per_step;
    let (rounded, exact) = (losses(0), losses(usize::MAX));
    assert_ne!(rounded, exact, "the two must be different computations");
    for step in 0..10 {
        assert!((rounded[step] / exact[step] - 1.0).abs() < 1e-3, "step {step}: {rounded:?} {exact:?}");
    }
    assert!(exact[40] < 0.05 * exact[0]);
    assert!(rounded[40] < 1.1 * exact[40], "{} {}", rounded[40], exact[40]);
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

/// Samples of a smooth function of `inputs` inputs.
fn smooth(inputs: usize, samples: usize) -> (Vec<f64>, Vec<f64>) {
    let x: Vec<f64> = (0..samples * inputs).map(noise(11)).map(|x| 3.0 * x + 5.0).collect();
    let target = |row: &[f64]| 40.0 + 10.0 * (row.iter().sum::<f64>()).sin() + row[0] * row[0];
    let targets = x.chunks_exact(inputs).map(target).collect();
    (x, targets)
}

#[test]
fn the_loss_never_rises_and_is_that_of_the_network() {
    let (x, t) = smooth(2, 3000);
    let options = TrainOptions { hidden: 12, steps: 60, seed: 4, tolerance: 0.0, held_back: 0.0 };
    let training = train(&x, &t, &options).unwrap();
    assert_eq!(training.loss_per_step.len(), training.steps + 1);
    assert!(training.loss_per_step.windows(2).all(|pair| pair[1] <= pair[0]));
    let mse = x.chunks_exact(2).zip(&t).map(|(x, t)| (training.network.output(x) - t).powi(2)).sum::<f64>()
        / 3000.0;
    let last = training.loss_per_step[training.steps];
    assert!((mse - last).abs() < 1e-9 * mse, "{mse} {last}");
    assert!(last < 0.01 * training.loss_per_step[0], "it must have learned something: {last}");
}

#[test]
fn a_network_is_recovered_from_its_own_output() {
    let theta = [1.1, -0.7, 0.4, 0.9, -0.8, 1.3, 0.2, -0.5, 0.6, 1.5, -1.0, 0.8, 0.3];
    let x: Vec<f64> = (0..2 * 800).map(noise(5)).map(|x| 2.0 * x).collect();
    let t: Vec<f64> = x.chunks_exact(2).map(|x| plain_row(2, 3, &theta, x).0).collect();
    let best = (0..8)
        .map(|seed| {
            let options = TrainOptions { hidden: 3, steps: 100, seed, tolerance: 0.0, held_back: 0.0 };
            let losses = train(&x, &t, &options).unwrap().loss_per_step;
            losses[losses.len() - 1]
        })
        .fold(f64::INFINITY, f64::min);
    assert!(best < 1e-24, "{best:e}");
}

#[test]
fn one_seed_gives_the_same_bytes_on_any_number_of_threads() {
    let (x, t) = smooth(4, 30_000);
    let options = TrainOptions { hidden: 10, steps: 6, ..TrainOptions::default() };
    let on = |threads: usize, options: &TrainOptions| {
        let pool = rayon::ThreadPoolBuilder::new().num_threads(threads).build().unwrap();
        // Once with f64 products, once with f32.
        pool.install(|| [usize::MAX, 0].map(|many| training::train_with(&x, &t, options, many).unwrap()))
    };
    let bytes = |trainings: &[Training; 2]| format!("{trainings:?}");
    let one = on(1, &options);
    assert_eq!(bytes(&one), bytes(&on(2, &options)));
    assert_eq!(bytes(&one), bytes(&on(5, &options)));
    assert_ne!(bytes(&one), bytes(&on(1, &TrainOptions { seed: 1, ..options.clone() })));
}

#[test]
fn samples_held_back_choose_the_weights_and_never_train_them() {
    let (x, mut t) = smooth(1, 400);
    for (i, t) in t.iter_mut().enumerate() {
        *t += 4.0 * noise(77)(i);
    }
    let options = TrainOptions { hidden: 40, steps: 300, held_back: 0.25, ..TrainOptions::default() };
    let training = train(&x, &t, &options).unwrap();
    assert_eq!(training.end, End::HeldBack);
    let held = &training.held_back_loss_per_step;
    let mse = (300..400).map(|i| (training.network.output(&x[i..=i]) - t[i]).powi(2)).sum::<f64>() / 100.0;
    let lowest = held.iter().copied().fold(f64::INFINITY, f64::min);
    assert!((mse - lowest).abs() < 1e-9 * mse, "{mse} {lowest}");
    assert!(held[held.len() - 1] > lowest);
}

#[test]
fn steady_inputs_and_wide_ranges_do_no_harm() {
    let x: Vec<f64> = (0..500).flat_map(|i| [7.0, 1e9 + 1e6 * noise(1)(i), 1e-9 * noise(2)(i)]).collect();
    let t: Vec<f64> = x.chunks_exact(3).map(|x| 1e5 * (x[2] * 1e9).tanh() + x[1] * 1e-2).collect();
    let training = train(&x, &t, &TrainOptions { hidden: 6, steps: 80, ..TrainOptions::default() }).unwrap();
    let losses = &training.loss_per_step;
    assert!(losses[losses.len() - 1] < 1e-6 * losses[0], "{losses:?}");
}

#[test]
fn what_cannot_be_fitted_is_refused_by_name() {
    let options = TrainOptions { hidden: 3, steps: 5, ..TrainOptions::default() };
    let (x, t) = smooth(2, 20);
    let refused =
        |x: &[f64], t: &[f64], options: &TrainOptions| train(x, t, options).unwrap_err().to_string();
    for bad in [f64::NAN, f64::INFINITY, f64::NEG_INFINITY] {
        let mut x_bad = x.clone();
        x_bad[7] = bad;
        let error = refused(&x_bad, &t, &options);
        assert!(error.contains("inputs, sample 4, column 2") && error.contains(&bad.to_string()), "{error}");
        let mut t_bad = t.clone();
        t_bad[19] = bad;
        let error = refused(&x, &t_bad, &options);
        assert!(error.contains("targets, sample 20"), "{error}");
    }
    assert!(refused(&x[..39], &t, &options).contains("inputs: expected as many numbers for each of the 20"));
    assert!(refused(&[], &t, &options).contains("inputs"));
    assert!(refused(&x, &[], &options).contains("targets: expected at least one sample, got 0"));
    assert!(refused(&x, &[4.5; 20], &options).contains("targets: expected values that differ"));
    assert!(refused(&[1.0, 2.0], &[4.5], &options).contains("targets: expected values that differ"));
    assert!(refused(&[1e300, -1e300], &[1.0, 2.0], &options).contains("inputs, column 1"));
    assert!(refused(&x, &t, &TrainOptions { hidden: 0, ..options.clone() }).contains("hidden"));
    assert!(refused(&x, &t, &TrainOptions { held_back: 1.0, ..options.clone() }).contains("held_back"));
    assert!(refused(&x, &t, &TrainOptions { tolerance: f64::NAN, ..options.clone() }).contains("tolerance"));
}
