//! The cable observer identified from logs of the demonstration plant, another implementation of springs and
//! friction nodes.
#![allow(clippy::unwrap_used, reason = "a failing test may panic")]

use sinew::predictor::CableColumns;
use sinew_identify::cable::{
    CableLog, FitOptions, cable_logs, fit_cable, fit_weakening, identify_cable, initial_cable, observe_log,
};
use sinew_identify::log::{ReadOptions, RequestedRoles, read_bytes};
use sinew_lab::simulated::{demo_logs, demo_truth};

/// The demonstration logs, read like a user's; `rewrite` changes every row.
fn days(rewrite: impl Fn(&str) -> String) -> (CableColumns, Vec<CableLog>) {
    specimen(1, rewrite)
}

fn specimen(seed: u64, rewrite: impl Fn(&str) -> String) -> (CableColumns, Vec<CableLog>) {
    let texts: Vec<(String, String)> = demo_logs(seed)
        .into_iter()
        .map(|(name, text)| (name, text.lines().map(&rewrite).collect()))
        .collect();
    let logs: Vec<(&str, &[u8])> = texts.iter().map(|(n, t)| (n.as_str(), t.as_bytes())).collect();
    let options = ReadOptions { far_required: true, ..ReadOptions::default() };
    cable_logs(&read_bytes(&logs, &RequestedRoles::default(), &options).unwrap()).unwrap()
}

fn same(line: &str) -> String {
    format!("{line}\n")
}

#[test]
fn an_observer_identified_from_two_days_predicts_the_third() {
    let (_, logs) = days(same);
    let start = initial_cable(&logs[..2]).unwrap();
    let fit = fit_cable(&logs[..2], &start, &FitOptions::default()).unwrap();
    let unseen = observe_log(&fit.model, &logs[2]).unwrap();
    let (mut squares, mut count) = (0.0, 0.0);
    let (mut low, mut high) = (f64::INFINITY, 0.0_f64);
    for (estimate, far) in unseen.iter().zip(&logs[2].far) {
        squares += (estimate.far - far) * (estimate.far - far);
        count += 1.0;
        (low, high) = (low.min(*far), high.max(*far));
    }
    let percent = 100.0 * f64::sqrt(squares / count) / (high - low);
    // The encoder zeros are the same on all days, so that the first estimate is already accurate.
    let first = (unseen[0].far - logs[2].far[0]).abs();
    assert!(fit.model.zero_stretch.is_some() && first < 0.1 * (high - low), "{first} N at first");
    eprintln!(
        "{} of {} samples, {percent:.2} % of {:.1} N; fit {:.3} from {:.3} N, condition {:.0}",
        count,
        unseen.len(),
        high - low,
        fit.rmse,
        fit.rmse_start,
        fit.condition
    );
    for q in &fit.quantities {
        eprintln!("{} {:.4} in {:.4} to {:.4}", q.quantity.name(), q.value, q.low, q.high);
    }
    assert!(percent < 1.5, "{percent} % of the range");
}

#[test]
fn directions_and_units_of_the_columns_do_not_matter() {
    let (columns, logs) = days(same);
    let (turned, other) = days(|line| {
        if line.starts_with('#') {
            return format!("{line}\n");
        }
        let cells: Vec<&str> = line.split(',').collect();
        if cells[0].starts_with("time") {
            return "time_s,tension_in_n,position_in_mm,tension_out_n,anchor_m\n".to_owned();
        }
        let number = |i: usize| cells[i].parse::<f64>().unwrap();
        format!("{},{},{:.3},{},{:.6}\n", cells[0], cells[1], -1e3 * number(2), cells[3], -number(4))
    });
    assert!((turned.motor_scale + 1e-3 * columns.motor_scale).abs() < 1e-12);
    assert!((turned.anchor_scale + columns.anchor_scale).abs() < 1e-12);
    for (a, b) in logs.iter().flat_map(|l| &l.samples).zip(other.iter().flat_map(|l| &l.samples)) {
        let same = |x: f64, y: f64| (x.is_nan() && y.is_nan()) || (x - y).abs() < 1e-9;
        assert!(same(a.motor, b.motor) && same(a.anchor, b.anchor), "{a:?} {b:?}");
    }
}

fn weakening_friction_is_found(seed: u64) {
    let (_, logs) = specimen(seed, same);
    let held = identify_cable(&logs[..3], &FitOptions::default()).unwrap();
    let rmse = held.rmse;
    let fit = fit_weakening(&logs[..3], held);
    let angle = fit.model.law().unwrap().friction_angle();
    let truth = demo_truth(seed)[0].value;
    assert!((angle / truth - 1.0).abs() < 0.06, "seed {seed}: {angle}, truth {truth}");
    assert!(fit.rmse < 0.9 * rmse, "seed {seed}: {} N, held {rmse} N", fit.rmse);
}

#[test]
fn friction_is_not_taken_for_drag_where_it_falls_with_speed() {
    weakening_friction_is_found(102);
}

#[test]
fn long_friction_is_not_taken_for_drag_on_other_specimens() {
    if std::env::var_os("SINEW_LONG").is_none() {
        eprintln!("skipped: SINEW_LONG is not set");
        return;
    }
    weakening_friction_is_found(103);
}
