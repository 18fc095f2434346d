use super::sequence::causal_squares;
use super::*;
use sinew::predictor::{Axis, Signal};

/// Two runs of an axis of 80 kg, 150 N s/m, 25 N of dry friction and -3 N at 1 kHz, moved by sines: inputs
/// are position, velocity and force, one of which is the far side; the position has the noise of an encoder.
fn runs(far: usize) -> Vec<Run> {
    let run = |phase: f64| {
        let n = 8000;
        let mut run = Run {
            log: 0,
            dt_s: (0..n).map(|i| if i == 0 { 0.0 } else { 1e-3 }).collect(),
            inputs: vec![],
            far: vec![],
            weight: vec![1.0; n],
            width: 3,
        };
        for i in 0..n {
            let t = i as f64 * 1e-3;
            let waves = [(0.06, 2.1, phase), (0.02, 5.3, 2.0 * phase)];
            let sum =
                |of: fn(f64, f64, f64) -> f64| waves.iter().map(|(a, w, p)| of(*a, *w, w * t + p)).sum();
            let x: f64 = sum(|a, _, s| a * s.sin());
            let v: f64 = sum(|a, w, s| a * w * s.cos());
            let acceleration: f64 = sum(|a, w, s| -a * w * w * s.sin());
            let force = 80.0 * acceleration + 150.0 * v + 25.0 * (v / 1e-4).tanh() - 3.0;
            let encoder = 1e-6 * (x / 1e-6).round();
            let row = [encoder, v, force];
            run.far.push(row[far]);
            run.inputs.extend(row);
        }
        run
    };
    vec![run(0.3), run(1.9)]
}

fn fitted(far: usize, kind: AxisKind, motions: &[usize], efforts: &[usize]) -> (FittedAxis, f64) {
    let runs = runs(far);
    let runs: Vec<&Run> = runs.iter().collect();
    let signals = [0, 1, 2].map(Signal::Input).to_vec();
    let law = MemoryLaw { signals, cell: None, cable: None, axis: None, features: vec![] };
    let plan = AxisPlan { kind, motions: motions.to_vec(), efforts: efforts.to_vec() };
    let fit = fit_axis(&law, &runs, &plan).unwrap();
    // The friction's state is unknown until the first reversals have passed.
    let settled = |run: &&Run| -> Run {
        let mut run = (*run).clone();
        run.weight[..2500].fill(0.0);
        run
    };
    let settled: Vec<Run> = runs.iter().map(settled).collect();
    let settled: Vec<&Run> = settled.iter().collect();
    let rmse = (causal_squares(&law, &settled, &fit.axis) / 11_000.0).sqrt();
    (fit, rmse)
}

#[test]
fn mass_and_friction_come_back_from_a_position_or_a_velocity_and_the_force_within_four_percent_of_its_range()
{
    for motions in [&[0_usize][..], &[1], &[0, 1]] {
        let (fit, rmse) = fitted(2, AxisKind::Force, motions, &[]);
        let Axis::Force(law) = &fit.axis else { panic!("{fit:?}") };
        let dry: f64 = law.slips.iter().map(|slip| slip.force).sum();
        assert!(fit.inertia_shows);
        // Two slow sines tell the mass from a spring only so far.
        assert!((law.mass / 80.0 - 1.0).abs() < 0.04, "{law:?}");
        assert!((law.damping / 150.0 - 1.0).abs() < 0.08 && (dry / 25.0 - 1.0).abs() < 0.1, "{law:?}");
        // Of some 220 N, 6.9 at most: this friction reverses at once, that of the law over 0.16 mm.
        assert!(rmse < 9.0, "{rmse} N, {law:?}");
    }
}

#[test]
fn mass_and_friction_come_back_from_the_motion_that_a_force_makes() {
    let (fit, rmse) = fitted(1, AxisKind::Motion, &[], &[2]);
    let Axis::Motion(law) = &fit.axis else { panic!("{fit:?}") };
    assert!(fit.inertia_shows && law.far_is_velocity);
    assert!((law.gain * 80.0 - 1.0).abs() < 0.03, "{law:?}");
    assert!((law.damping / law.gain / 150.0 - 1.0).abs() < 0.1, "{law:?}");
    assert!((law.friction / law.gain / 25.0 - 1.0).abs() < 0.1, "{law:?}");
    assert!(rmse < 0.005, "{rmse} m/s of 0.4");
}

#[test]
fn a_spring_with_friction_shows_no_inertia() {
    let mut runs = runs(2);
    for run in &mut runs {
        let mut play = 0.0;
        for i in 0..run.far.len() {
            let x = run.inputs[3 * i];
            play = f64::clamp(play, x - 0.01, x + 0.01);
            run.far[i] = 900.0 * play;
        }
    }
    let runs: Vec<&Run> = runs.iter().collect();
    let signals = [0, 1, 2].map(Signal::Input).to_vec();
    let law = MemoryLaw { signals, cell: None, cable: None, axis: None, features: vec![] };
    let plan = AxisPlan { kind: AxisKind::Force, motions: vec![0], efforts: vec![] };
    assert!(!fit_axis(&law, &runs, &plan).unwrap().inertia_shows);
}
