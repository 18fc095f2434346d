//! The roles of the columns: listed with their reasons before the fit, and corrected by flags.

use crate::bench::{Bench, log, samples};
use serde_json::Value;
use std::fmt::Write as _;

/// A log with a column of stroke directions and two more that no name explains.
fn labelled() -> String {
    let mut text = String::from("time_s,tension_in_n,stroke,position_in_m,temperature,tension_out_n\n");
    for (k, [t, near, far]) in samples(0.4).into_iter().enumerate() {
        let direction = [-1, 0, 1][k / 50 % 3];
        writeln!(text, "{t:.2},{near:.4},{direction},{:.6},{},{far:.4}", 1e-4 * near, 20 + k % 7).unwrap();
    }
    text
}

/// Role and reason of a column.
fn role(account: &Value, column: &str) -> (String, String) {
    let columns = account["columns"].as_array().unwrap();
    let found = columns.iter().find(|entry| entry["column"] == column).unwrap();
    let text = |key: &str| found[key].as_str().unwrap_or("none").to_owned();
    (text("role"), text("reason"))
}

#[test]
fn a_label_with_three_values_is_no_motion_unless_it_is_asked_for() {
    let bench = Bench::new();
    bench.write("l.csv", labelled());
    let account: Value =
        serde_json::from_str(&bench.succeeds("identify l.csv --dry-run --json").stdout).unwrap();
    let (found, reason) = role(&account, "stroke");
    assert_eq!(found, "none");
    assert!(reason.contains("-1, 0, 1") && reason.contains("label"), "{reason}");
    assert_eq!(role(&account, "position_in_m").0, "motion");
    let asked = bench.succeeds("identify l.csv --dry-run --json --motion stroke").stdout;
    let account: Value = serde_json::from_str(&asked).unwrap();
    assert_eq!(role(&account, "stroke"), ("motion".into(), "as requested".into()));
    assert_eq!(role(&account, "position_in_m").1, "not among the inputs requested");
}

#[test]
fn a_dry_run_lists_every_column_and_writes_nothing() {
    let bench = Bench::new();
    bench.write("l.csv", labelled());
    let before = bench.content();
    let said = bench.succeeds("identify l.csv --dry-run").stdout;
    for column in ["time_s", "tension_in_n", "stroke", "position_in_m", "temperature", "tension_out_n"] {
        assert!(said.contains(&format!("\n{column} ")), "{column}: {said}");
    }
    assert!(said.contains("--ignore") && said.contains(" N ") && said.contains("by its name"), "{said}");
    assert!(said.contains("replaces all inputs"), "{said}");
    bench.succeeds("identify l.csv --dry-run --out out");
    bench.refuses("identify l.csv --dry-run --model cel", &["cel", "cell"]);
    bench.refuses("identify l.csv --dry-run --keep k.csv", &["k.csv", "l.csv"]);
    assert!(bench.content() == before, "a dry run writes nothing");
}

#[test]
fn an_ignored_column_has_no_role_and_the_model_does_not_ask_for_it() {
    let bench = Bench::new();
    bench.write("l.csv", labelled());
    let said = bench.succeeds("identify l.csv --ignore position_in_m --model cell --out out").stdout;
    let account = said.lines().find(|line| line.starts_with("position_in_m")).unwrap();
    assert!(account.contains("not used") && account.contains("as requested"), "{account}");
    bench.succeeds("evaluate out/model.json a.csv");
    bench.refuses("identify l.csv --ignore pos --out new", &["`pos`", "position_in_m"]);
    bench.refuses(
        "identify l.csv --ignore position_in_m --motion position_in_m --out new",
        &["position_in_m", "motion", "ignored"],
    );
}

#[test]
fn the_choice_says_why_and_what_was_not_compared() {
    let bench = Bench::new();
    let said = bench.succeeds("identify a.csv b.csv --out out").stdout;
    for words in [
        "was chosen because it has the least mean error",
        "observer: not compared, because",
        "motion",
        "Sorted by",
    ] {
        assert!(said.contains(words), "{words}: {said}");
    }
    // One order: the column of the scores rises.
    let rows = said.lines().skip_while(|line| !line.contains("mean of folds")).skip(1);
    let score = |line: &str| line.trim_start_matches('*').split_whitespace().nth(1)?.parse::<f64>().ok();
    let scores: Vec<f64> = rows.map_while(score).collect();
    assert!(scores.len() > 5 && scores.is_sorted(), "{scores:?}");
}

#[test]
fn a_foreign_log_is_judged_with_figures_and_stays_where_it_is_to_be_kept() {
    let bench = Bench::new();
    let mut logs = String::new();
    for (k, frequency) in [0.31, 0.4, 0.47, 0.53].into_iter().enumerate() {
        bench.write(&format!("day{k}.csv"), log(frequency));
        logs += &format!(" day{k}.csv");
    }
    let mut foreign = String::from("time_s,tension_in_n,tension_out_n\n");
    for [t, near, far] in samples(0.37) {
        writeln!(foreign, "{t:.2},{near:.4},{:.4}", 120.0 - far).unwrap();
    }
    bench.write("foreign.csv", foreign);
    let said = bench.succeeds(&format!("identify{logs} foreign.csv --model cell --out out")).stdout;
    let row = said.lines().find(|line| line.starts_with("foreign.csv") && line.contains("excluded")).unwrap();
    assert!(row.split_whitespace().last().unwrap().parse::<f64>().unwrap() > 1.5, "{row}");
    assert!(said.contains("(limits 1.16 and 2.7): an outlier recording"), "{said}");
    for keep in ["foreign.csv", "all"] {
        let said = bench
            .succeeds(&format!("identify{logs} foreign.csv --model cell --keep {keep} --out kept"))
            .stdout;
        assert!(!said.contains("excluded") && said.contains("It was kept: as requested"), "{said}");
    }
    bench.refuses(
        &format!("identify{logs} foreign.csv --model cell --keep freign.csv --out new"),
        &["freign.csv", "--keep", "foreign.csv"],
    );
}

#[test]
fn a_planned_programme_shows_what_a_model_needs() {
    let bench = Bench::new();
    let said = bench.succeeds("twin plan --stroke 0.03 --out plan.csv").stdout;
    assert!(said.contains("reversals") && said.contains("3 speeds"), "{said}");
    bench.succeeds("twin cable plan.csv --start 60 --out day.csv");
    let said = bench.succeeds("identify day.csv --model cell --out out").stdout;
    for poor in ["never reverses", "have one length", "have one mean speed", "samples count"] {
        assert!(!said.contains(poor), "{poor}: {said}");
    }
    bench.refuses_usage("twin plan --stroke 0 --out p.csv", &["--stroke", "0.0001 to 10 m"]);
}

#[test]
fn a_reference_that_is_asked_for_becomes_a_model_that_predicts() {
    let bench = Bench::new();
    bench.write("c.csv", log(0.31));
    let [constant, linear] = ["constant", "linear"].map(|name| {
        bench.succeeds(&format!("identify a.csv b.csv --model {name} --out {name}"));
        bench.succeeds(&format!("predict {name}/model.json c.csv --out {name}.csv"));
        let answer = bench.succeeds(&format!("evaluate {name}/model.json c.csv --json")).stdout;
        serde_json::from_str::<Value>(&answer).unwrap()["overall"]["rmse"].as_f64().unwrap()
    });
    assert!(linear > 0.0 && linear < 0.5 * constant, "linear {linear}, constant {constant}");
}
