//! Tension distributions: solved, listed, and refused.

use crate::bench::Bench;

const PAIR: &str = r#"{"moment_arms":[[0.03],[-0.03]],"torque_nm":[1.5],"min_n":[20,20],"max_n":[400,400]}"#;

fn file(problems: &[&str]) -> String {
    format!("{{\"problems\":[{}]}}", problems.join(","))
}

#[test]
fn a_list_of_problems_is_solved_in_its_order() {
    let bench = Bench::new();
    let far = PAIR.replace("[1.5]", "[30]");
    let stiff = PAIR.replace("\"torque_nm\"", "\"reference_n\":[100,100],\"weight\":[1,3],\"torque_nm\"");
    bench.write("p.json", file(&[PAIR, &far, &stiff]));
    let run = bench.run("design tension p.json --json");
    assert_eq!(run.code, Some(3), "one torque is out of reach: {}", run.stderr);
    let result: serde_json::Value = serde_json::from_str(&run.stdout).unwrap();
    let solution = |k: usize| &result["solutions"][k];
    let number = |k: usize, field: &str, i: usize| solution(k)[field][i].as_f64().unwrap();
    assert_eq!(solution(0)["status"], "optimal");
    assert!(
        (number(0, "tension_n", 0) - 70.0).abs() < 1e-9 && (number(0, "tension_n", 1) - 20.0).abs() < 1e-9
    );
    assert!(number(0, "residual_nm", 0).abs() < 1e-12);
    // 380 N between the limits are 11.4 Nm.
    assert_eq!(solution(1)["status"], "infeasible");
    assert!((number(1, "residual_nm", 0) - 18.6).abs() < 1e-9);
    // The muscle of three times the weight deviates from its reference a third as much.
    assert!(
        (number(2, "tension_n", 0) - 137.5).abs() < 1e-9 && (number(2, "tension_n", 1) - 87.5).abs() < 1e-9
    );
    assert!(solution(2)["iterations"].is_u64() && solution(2)["seconds"].as_f64().unwrap() >= 0.0);
}

#[test]
fn the_terminal_shows_a_table() {
    let bench = Bench::new();
    bench.write("p.json", file(&[PAIR]));
    let run = bench.run("design tension p.json");
    assert!(run.stdout.contains("residual Nm") && run.stdout.contains("optimal"), "{}", run.stdout);
}

#[test]
fn invalid_problems_are_refused_with_their_place() {
    let bench = Bench::new();
    for (from, to, words) in [
        ("[1.5]", "[1.5,2]", ["problems[1].moment_arms[0]", "expected 2 numbers"]),
        ("[1.5]", "[\"x\"]", ["problems[1].torque_nm[0]", "\"x\""]),
        ("[-0.03]", "[null]", ["problems[1].moment_arms[1][0]", "null"]),
        ("\"torque_nm\":[1.5]", "\"torque_nm\":1.5", ["problems[1].torque_nm", "expected a sequence"]),
        ("[-0.03]", "[1e31]", ["problems[1].moment_arms[1][0]", "magnitude <= 1e30"]),
        ("[20,20]", "[20]", ["problems[1].min_n", "expected 2 numbers, one per muscle, got 1"]),
        ("[20,20]", "[20,500]", ["problems[1].min_n[1]", "max_n[1] = 400"]),
        ("\"max_n\"", "\"max\"", ["problems[1]", "unknown field `max`"]),
        (",\"max_n\":[400,400]", "", ["problems[1]", "missing field `max_n`"]),
        ("\"max_n\"", "\"weight\":[1,0],\"max_n\"", ["problems[1].weight[1]", "got 0"]),
        ("}", "", ["is no JSON", "line 1"]),
    ] {
        bench.write("bad.json", file(&[PAIR, &PAIR.replace(from, to)]));
        let words = [words[0], words[1], "bad.json"];
        bench.refuses("design tension bad.json --json", &words);
    }
    bench.refuses("design tension missing.json", &["missing.json"]);
}
