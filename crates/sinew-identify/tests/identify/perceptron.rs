//! Laws of the training of one network on all samples.

use sinew_identify::fit::perceptron::{End, TrainOptions, train};

/// Samples from which on products are summed in f32.
const F32_FROM: usize = 100_000;

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
    let node = |j: usize, x: &[f64]| (theta[j] * x[0] + theta[3 + j] * x[1] + theta[6 + j]).tanh();
    let output = |x: &[f64]| theta[12] + (0..3).map(|j| theta[9 + j] * node(j, x)).sum::<f64>();
    let t: Vec<f64> = x.chunks_exact(2).map(output).collect();
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
    let options = TrainOptions { hidden: 10, steps: 6, ..TrainOptions::default() };
    for samples in [30_000, F32_FROM] {
        let (x, t) = smooth(4, samples);
        let on = |threads: usize, options: &TrainOptions| {
            let pool = rayon::ThreadPoolBuilder::new().num_threads(threads).build().unwrap();
            format!("{:?}", pool.install(|| train(&x, &t, options).unwrap()))
        };
        let one = on(1, &options);
        assert_eq!(one, on(2, &options), "{samples}");
        assert_eq!(one, on(5, &options), "{samples}");
        assert_ne!(one, on(1, &TrainOptions { seed: 1, ..options.clone() }), "{samples}");
    }
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

#[test]
fn f32_products_train_as_well_as_f64() {
    let (x, t) = smooth(2, 20_000);
    let options = TrainOptions { hidden: 12, steps: 40, seed: 2, tolerance: 0.0, held_back: 0.0 };
    // Copies of all samples are the same problem, with enough samples for f32.
    let losses = |copies: usize| train(&x.repeat(copies), &t.repeat(copies), &options).unwrap().loss_per_step;
    let (rounded, exact) = (losses(F32_FROM / t.len()), losses(1));
    assert!((rounded[1] / exact[1] - 1.0).abs() > 1e-10, "the two must be different computations");
    for step in 0..10 {
        assert!((rounded[step] / exact[step] - 1.0).abs() < 1e-3, "step {step}: {rounded:?} {exact:?}");
    }
    assert!(exact[40] < 0.05 * exact[0]);
    assert!(rounded[40] < 1.1 * exact[40], "{} {}", rounded[40], exact[40]);
}
