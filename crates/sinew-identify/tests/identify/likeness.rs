//! Inputs that repeat the far side, and logs with a mirrored far side.
#![allow(clippy::unwrap_used, reason = "a failing test may panic")]

use sinew_identify::log::{ReadOptions, RequestedRoles, read_bytes};
use std::fmt::Write as _;

/// Near and far side of a sheath with dry friction; `far` is what is logged of it, and a filtered copy.
fn log(logged: impl Fn(f64) -> f64, delay: f64) -> String {
    let mut text = String::from("time_s,tension_in_n,tension_smooth_n,tension_out_n\n");
    let (mut far, mut smooth) = (56.0_f64, 56.0_f64);
    for i in 0..800 {
        let t = 0.02 * f64::from(i);
        let near = 60.0 + 30.0 * (2.5 * t).sin() + 12.0 * (5.8 * t).sin();
        far = far.clamp(0.75 * near, 1.125 * near);
        smooth += (far - smooth) / (1.0 + delay);
        writeln!(text, "{t:.2},{near:.4},{smooth:.4},{:.4}", logged(far)).unwrap();
    }
    text
}

fn findings(logs: &[String], effort: &[&str]) -> Vec<Vec<String>> {
    let names: Vec<String> = (0..logs.len()).map(|k| format!("{k}.csv")).collect();
    let bytes: Vec<(&str, &[u8])> =
        names.iter().zip(logs).map(|(name, text)| (name.as_str(), text.as_bytes())).collect();
    let effort = effort.iter().map(|name| (*name).to_owned()).collect();
    let roles = RequestedRoles { effort, far: Some("tension_out_n".to_owned()), ..RequestedRoles::default() };
    let options = ReadOptions { far_required: true, ..ReadOptions::default() };
    let dataset = read_bytes(&bytes, &roles, &options).unwrap();
    dataset.logs.into_iter().map(|log| log.findings).collect()
}

#[test]
fn a_smoothed_far_side_among_the_inputs_is_named_and_a_near_side_is_not() {
    for delay in [0.0, 1.0, 3.0] {
        let found = findings(&[log(|far| far, delay)], &["tension_in_n", "tension_smooth_n"]);
        assert!(
            found[0].len() == 1 && found[0][0].contains("`tension_smooth_n` is nearly a copy"),
            "{found:?}"
        );
    }
    assert_eq!(findings(&[log(|far| far, 0.0)], &["tension_in_n"]), [Vec::<String>::new()]);
}

#[test]
fn the_log_with_a_mirrored_far_side_is_named() {
    let good = || log(|far| far, 0.0);
    let found =
        findings(&[good(), log(|far| 120.0 - far, 0.0), log(|far| far + 1.0, 0.0)], &["tension_in_n"]);
    assert!(found[0].is_empty() && found[2].is_empty(), "{found:?}");
    assert!(
        found[1].len() == 1 && found[1][0].contains("oppositely here, unlike in 2 other logs"),
        "{found:?}"
    );
    // Mirrored in all logs is a convention of signs.
    let found = findings(&[log(|far| -far, 0.0), log(|far| -far - 1.0, 0.0)], &["tension_in_n"]);
    assert!(found.iter().all(Vec::is_empty), "{found:?}");
}
