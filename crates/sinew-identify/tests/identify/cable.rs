//! The observer identified from the twin's logs: recovered parameters and error of the far tension.
#![allow(clippy::unwrap_used, reason = "a failing test may panic")]

use rand::{RngExt, SeedableRng};
use rand_chacha::ChaCha8Rng;
use sinew::predictor::{CableModel, CableSample};
use sinew::transmission::Sliding;
use sinew::transmission::cable::EndMotion;
use sinew::twin::cable::{CablePlant, DragHeat, Effects, Resolution, Specimen};
use sinew_identify::cable::{CableLog, FitOptions, cable_logs, fit_cable, fit_warming, observe_log};
use sinew_identify::log::{ColumnOptions, Dataset, ReadOptions, RequestedRoles, read_bytes};

/// Standard deviation of both load cells, N.
const NOISE: f64 = 0.4;

/// A log of the bench, and beside it the true far tension and stretch.
///
/// Where it is `coarse`, encoders count hundredths of a millimetre and the near tension comes one millisecond
/// late. The motor runs back and forth at 0.02 to 0.12 m/s; the other drive swings the far tension between 40
/// and 200 N.
fn bench(specimen: &Specimen, seconds: f64, seed: u64, coarse: bool) -> (CableLog, Vec<[f64; 2]>) {
    let mut plant = CablePlant::new(specimen, Resolution { cells: 32, substeps: 4 }).unwrap();
    plant.settle(100.0, Sliding::TowardMotor).unwrap();
    let mut random = ChaCha8Rng::seed_from_u64(seed);
    let mut normal = move || (0..12).map(|_| random.random::<f64>()).sum::<f64>() - 6.0;
    let (mut log, mut truth) = (CableLog::default(), Vec::new());
    let mut reading = plant.step(1e-3, EndMotion::default()).unwrap();
    // The origin of the positions is unknown.
    let (mut motor, mut anchor, mut place, mut speed) = (0.7, -0.3, 0.0_f64, 0.0_f64);
    for k in 0..(1e3 * seconds) as usize {
        let t = k as f64 * 1e-3;
        let requested = 0.02 + 0.02 * ((t / 12.0).floor() % 6.0);
        let direction = if ((t * requested / 0.3).floor() as u64).is_multiple_of(2) { 1.0 } else { -1.0 };
        speed += (direction * requested - speed).clamp(-3e-3, 3e-3);
        place += 1e-3 * speed;
        let target = 120.0 + 80.0 * (2.0 * std::f64::consts::PI * t / 3.7).sin();
        let follow = (speed + 2e-3 * (reading.tension_out - target)).clamp(-0.3, 0.3);
        let motion = EndMotion { motor: 1e-3 * speed, anchor: 1e-3 * follow };
        motor += motion.motor;
        anchor += motion.anchor;
        let before = reading.tension_in;
        reading = plant.step(1e-3, motion).unwrap();
        assert!(reading.broken.is_none() && place.abs() < 10.0);
        let seen = |position: f64| if coarse { (position * 1e5).round() * 1e-5 } else { position };
        let tension_in = if coarse { before } else { reading.tension_in } + NOISE * normal();
        let sample = CableSample { motor: seen(motor), anchor: seen(anchor), tension_in };
        log.push(1e-3, sample, reading.tension_out + NOISE * normal());
        truth.push([reading.tension_out, reading.stretch]);
    }
    (log, truth)
}

fn part(log: &CableLog, range: std::ops::Range<usize>) -> CableLog {
    CableLog {
        interval_s: log.interval_s[range.clone()].to_vec(),
        samples: log.samples[range.clone()].to_vec(),
        far: log.far[range.clone()].to_vec(),
        weight: log.weight[range].to_vec(),
    }
}

/// A quarter of its samples.
fn every_fourth(log: &CableLog) -> CableLog {
    let mut thinned = CableLog::default();
    for row in (0..log.len()).step_by(4) {
        thinned.push(if row == 0 { 0.0 } else { 4e-3 }, log.samples[row], log.far[row]);
    }
    thinned
}

/// Root mean square errors of far tension, N, and stretch, m, from a row on, the observer having run from the
/// start.
fn errors(model: &CableModel, log: &CableLog, truth: &[[f64; 2]], from: usize) -> [f64; 2] {
    let estimates = observe_log(model, log).unwrap();
    let mut squares = [0.0; 2];
    for (estimate, truth) in estimates[from..].iter().zip(&truth[from..]) {
        squares[0] += (estimate.tension_out - truth[0]).powi(2);
        squares[1] += (estimate.stretch - truth[1]).powi(2);
    }
    squares.map(|sum| (sum / (truth.len() - from) as f64).sqrt())
}

fn rmse(model: &CableModel, log: &CableLog, truth: &[[f64; 2]], from: usize) -> f64 {
    errors(model, log, truth, from)[0]
}

/// The calibrated bench with the errors of a mediocre identification.
fn mistaken(times: f64) -> CableModel {
    let mut model = CableModel::bench();
    model.parameters.friction *= 1.0 + 0.03 * times;
    model.parameters.drag *= 1.0 - 0.10 * times;
    model.parameters.compliance *= 1.0 + 0.04 * times;
    model.parameters.efficiency = model.parameters.efficiency.powf(1.0 - 0.10 * times);
    model
}

#[test]
fn an_observer_with_slightly_wrong_numbers_errs_by_a_few_newtons() {
    let (log, truth) = bench(&Specimen::ideal(), 60.0, 1, false);
    let right = rmse(&CableModel::bench(), &log, &truth, 5000);
    let once = rmse(&mistaken(1.0), &log, &truth, 5000);
    let four = rmse(&mistaken(4.0), &log, &truth, 5000);
    eprintln!("T_out rmse: right numbers {right:.2}, identified {once:.2}, four times worse {four:.2} N");
    assert!(right < 0.6 && once < 3.0 && four < 14.0, "{right} {once} {four}");
    assert!(right < once && once < four);
}

#[test]
fn known_numbers_come_back_from_a_noisy_log() {
    let (log, truth) = bench(&Specimen::ideal(), 70.0, 2, false);
    let training = part(&log, 0..50_000);
    // The efficiency cannot be told from friction, so it must be right; cells enough to let the numbers be
    // themselves.
    let mut start = CableModel { cells: 16, ..mistaken(4.0) };
    start.parameters.efficiency = CableModel::bench().parameters.efficiency;
    let fit = fit_cable(&[training], &start, &FitOptions::default()).unwrap();
    eprintln!(
        "rmse {:.3} from {:.2}, condition {:.0}, correlation {:.1}",
        fit.rmse, fit.rmse_start, fit.condition, fit.correlation
    );
    let known = CableModel::bench();
    for fitted in &fit.quantities {
        let exact = fitted.quantity.of(&known);
        let name = fitted.quantity.name();
        eprintln!(
            "{name}: {:.4e} in {:.4e} to {:.4e}, exact {exact:.4e}",
            fitted.value, fitted.low, fitted.high
        );
        // Tilt and rise are nought.
        let tolerance = if exact > 0.0 { 0.025 * exact } else { 0.02 };
        assert!((fitted.value - exact).abs() < tolerance, "{name}: {} not {exact}", fitted.value);
        // Two and a half times the interval (measured: 2.1, the tilt): the rise of friction is at the edge of
        // its domain here, where the linearised intervals of the others are too narrow.
        let half = (fitted.high - fitted.low) / 2.0;
        assert!((fitted.value - exact).abs() < 2.5 * half, "{name}: {} +- {half}, not {exact}", fitted.value);
    }
    assert!(fit.model.zero_stretch.is_some_and(f64::is_finite));
    let unseen = rmse(&fit.model, &log, &truth, 50_000);
    eprintln!("unseen {unseen:.3} N");
    assert!(unseen < 0.2, "{unseen} N on the held-out log");
}

#[test]
fn a_specimen_with_every_unknown_effect_is_followed_after_its_own_calibration() {
    for seed in [2, 3] {
        let (log, truth) = bench(&Specimen::draw(seed), 70.0, seed, true);
        let before = rmse(&CableModel::bench(), &log, &truth, 50_000);
        let fit = fit_cable(&[part(&log, 0..50_000)], &CableModel::bench(), &FitOptions::default()).unwrap();
        let [after, stretch] = errors(&fit.model, &log, &truth, 50_000);
        eprintln!(
            "specimen {seed}: {before:.2} N before, {after:.2} N and {:.2} mm after its calibration",
            1e3 * stretch
        );
        assert!(stretch < 1e-3, "specimen {seed}: stretch {stretch} m");
        assert!(after < 1.5 && after < before, "specimen {seed}: {before} N, then {after} N");
    }
}

#[test]
fn drag_falls_where_the_log_shows_grease_that_warms_and_nowhere_else() {
    for seed in [4, 5] {
        let cold = Specimen::ideal();
        let heat = DragHeat { softening: 0.1, resistance: 1.0, capacity: 40.0 };
        let warm = Specimen { effects: Effects { heat: Some(heat), ..Effects::none() }, ..cold.clone() };
        let fitted = |specimen: &Specimen| {
            let (log, truth) = bench(specimen, 100.0, seed, false);
            let model = fit_warming(&[every_fourth(&part(&log, 0..70_000))], CableModel::bench());
            let after = rmse(&model, &log, &truth, 70_000);
            (model.warming, rmse(&CableModel::bench(), &log, &truth, 70_000), after)
        };
        let ((none, ..), (warming, before, after)) = (fitted(&cold), fitted(&warm));
        eprintln!("seed {seed}: {warming:?}, {before:.3} N without, {after:.3} N with it");
        assert_eq!(none, None, "seed {seed}");
        // k/C; the twin's drag falls by an exponential, and what cools within the log is one of three times.
        let rate = warming.unwrap().rate;
        assert!((1.5e-3..4e-3).contains(&rate), "seed {seed}: {rate} 1/J");
        assert!(after < 0.7 * before, "seed {seed}: {before} N, then {after} N beyond the log");
    }
    assert_eq!(fit_warming(&[], CableModel::bench()), CableModel::bench());
}

#[test]
fn logs_that_cannot_be_fitted_are_refused_by_name() {
    let model = CableModel::bench();
    let refused = |logs: &[CableLog], options: &FitOptions, name: &str| {
        let error = fit_cable(logs, &model, options).unwrap_err().to_string();
        assert!(error.contains(name), "{error}");
    };
    let usual = FitOptions::default();
    refused(&[], &usual, "50 samples");
    let (log, _) = bench(&Specimen::ideal(), 2.0, 3, false);
    refused(std::slice::from_ref(&log), &FitOptions { free: vec![], ..usual.clone() }, "free quantities");
    let mut short = log.clone();
    short.far.pop();
    refused(&[log.clone(), short], &usual, "log 1, far");
    let mut holed = log;
    holed.far[7] = f64::NAN;
    refused(&[holed], &usual, "sample 7");
}

/// A log whose motor position stands under `title`, and is asked for as `name`.
fn read(title: &str, name: &str, stated: &str) -> Dataset {
    let mut text = format!("time_s;Kraft [N];{title};far_n;anchor_m\n");
    for k in 0..400 {
        let t = 0.01 * f64::from(k);
        let (motor, anchor) = (t.sin(), 0.3 * (2.7 * t).sin());
        text += &format!("{t};{};{motor};{};{anchor}\n", 60.0 + 20.0 * motor, 50.0 + 20.0 * (motor - anchor));
    }
    let flags = RequestedRoles {
        far: Some("far_n".into()),
        effort: vec!["Kraft".into()],
        motion: vec![name.into()],
        anchor: Some("anchor_m".into()),
        ..RequestedRoles::default()
    };
    let units = if stated.is_empty() { vec![] } else { vec![(name.to_owned(), stated.to_owned())] };
    let columns = ColumnOptions { units, ..ColumnOptions::default() };
    let options = ReadOptions { far_required: true, columns, ..ReadOptions::default() };
    read_bytes(&[("log.csv", text.as_bytes())], &flags, &options).unwrap()
}

#[test]
fn tensions_count_in_newtons_whatever_their_columns_are_in() {
    let mut text = String::from("t_s;Kraft [lbf];motor_m;far [kN];anchor_m\n");
    for k in 0..400 {
        let t = 0.01 * f64::from(k);
        let (motor, anchor) = (t.sin(), 0.3 * (2.7 * t).sin());
        text += &format!("{t};{};{motor};{};{anchor}\n", 60.0 + 20.0 * motor, 0.05 + 0.02 * (motor - anchor));
    }
    let flags = RequestedRoles {
        far: Some("far".into()),
        effort: vec!["Kraft".into()],
        motion: vec!["motor_m".into()],
        anchor: Some("anchor_m".into()),
        ..RequestedRoles::default()
    };
    let options = ReadOptions { far_required: true, ..ReadOptions::default() };
    let (columns, logs) =
        cable_logs(&read_bytes(&[("log.csv", text.as_bytes())], &flags, &options).unwrap()).unwrap();
    assert!((columns.tension_scale - 4.448_221_615).abs() < 1e-8, "{columns:?}");
    assert!((logs[0].samples[0].tension_in - 60.0 * 4.448_221_615).abs() < 1e-6);
    assert!((logs[0].far[0] - 50.0).abs() < 1e-9);
}

#[test]
fn a_position_counts_in_metres_wherever_its_unit_is_stated() {
    for (title, name, stated, metres) in [
        ("Weg", "Weg", "", 1.0),
        ("Weg", "Weg", "mm", 1e-3),
        ("Weg [mm]", "Weg", "", 1e-3),
        ("Weg [mm]", "Weg [mm]", "", 1e-3),
        ("weg_mm", "weg", "", 1e-3),
        ("weg_cm", "weg_cm", "", 1e-2),
        ("Weg (inch)", "Weg (inch)", "inch", 0.0254),
    ] {
        let scale = cable_logs(&read(title, name, stated)).unwrap().0.motor_scale;
        assert!((scale - metres).abs() < 1e-12 * metres, "{title}, {name}, {stated}: {scale}");
    }
    for (title, name, stated) in [("Winkel [deg]", "Winkel", ""), ("Winkel", "Winkel", "rad")] {
        let said = cable_logs(&read(title, name, stated)).unwrap_err().to_string();
        assert!(said.contains(name) && said.contains("a length"), "{said}");
    }
}
