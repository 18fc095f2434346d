//! `--json` as docs/json.md describes it: the head, the keys of every verb, units in names.

use crate::bench::Bench;
use serde_json::Value;
use std::collections::BTreeSet;

const DOCUMENT: &str = include_str!("../../../../docs/json.md");
const HEAD: [&str; 6] = ["schema_version", "program", "verb", "outcome", "exit_code", "written"];

/// Words in backticks of a line.
fn quoted(line: &str) -> Vec<&str> {
    line.split('`').skip(1).step_by(2).collect()
}

/// Cells of the rows of tables.
fn rows() -> impl Iterator<Item = Vec<&'static str>> {
    let lines = DOCUMENT.lines().filter(|line| line.starts_with("| "));
    lines.map(|line| line.trim_matches('|').split(" | ").map(str::trim).collect())
}

/// What the document says of a verb's keys.
fn described(verb: &str) -> &'static str {
    let row = rows().find(|cells| cells[0] == format!("`{verb}`"));
    row.unwrap_or_else(|| panic!("docs/json.md has no row of {verb}"))[1]
}

/// Names of numbers that the document lists as exceptions from units in names.
fn without_unit() -> BTreeSet<&'static str> {
    rows().filter(|cells| cells.len() == 3).flat_map(|cells| quoted(cells[1])).collect()
}

const UNITS: [&str; 23] = [
    "_n", "_ns", "_nm", "_m", "_mm", "_s", "_us", "_kg", "_rad", "_deg", "_w", "_per_s", "_per_s2", "_per_m",
    "_per_n", "_hz", "_ms", "_v", "_a", "_k", "_c", "_per_rad", "_s2",
];

/// Every number below `value` with the name under which it stands and that of the quantity around it.
fn numbers(value: &Value, name: &str, around: &str, found: &mut Vec<(String, String)>) {
    match value {
        Value::Number(_) => found.push((name.to_owned(), around.to_owned())),
        Value::Array(list) => list.iter().for_each(|item| numbers(item, name, around, found)),
        Value::Object(keys) => keys.iter().for_each(|(key, item)| numbers(item, key, name, found)),
        _ => {}
    }
}

fn names_its_unit(name: &str) -> bool {
    // `length_m:MUSCLE` is named after a part.
    let quantity = name.split(':').next().unwrap_or(name);
    UNITS.iter().any(|unit| quantity.ends_with(unit))
}

#[track_caller]
fn checked(bench: &Bench, verb: &str, arguments: &str, code: i32) -> Value {
    let run = bench.run(&format!("{arguments} --json"));
    assert_eq!(run.code, Some(code), "{arguments}: {}", run.stderr);
    assert_eq!(run.stdout.lines().count(), 1, "{arguments}: one line");
    let document: Value = serde_json::from_str(&run.stdout).unwrap();
    let keys: Vec<&str> = document.as_object().unwrap().keys().map(String::as_str).collect();
    assert_eq!(keys[..HEAD.len()], HEAD, "{arguments}");
    assert_eq!(document["schema_version"], 1);
    assert_eq!(document["exit_code"], code);
    assert!(verb.starts_with(document["verb"].as_str().unwrap()), "{verb}: {}", document["verb"]);
    let own = described(verb);
    // "as `identify`": with its keys, too.
    let shared = own.split("as `").skip(1).filter_map(|rest| rest.split('`').next());
    let words: Vec<&str> = shared.map(described).chain([own]).flat_map(quoted).collect();
    for key in &keys[HEAD.len()..] {
        assert!(words.contains(key), "{verb}: `{key}` is not in docs/json.md");
    }
    let exceptions = without_unit();
    let mut found = Vec::new();
    for (key, item) in document.as_object().unwrap().iter().filter(|(key, _)| !HEAD.contains(&key.as_str())) {
        numbers(item, key, "", &mut found);
    }
    for (name, around) in found {
        let clear = names_its_unit(&name) || exceptions.contains(name.as_str()) || names_its_unit(&around);
        assert!(
            clear,
            "{verb}: the number `{name}` in `{around}` has no unit in its name and is no exception"
        );
    }
    document
}

#[test]
fn documents_about_logs_have_the_documented_keys_and_units() {
    let bench = Bench::new();
    let identified = checked(&bench, "identify", "identify a.csv b.csv --model cell --out out", 0);
    let written = identified["written"].as_array().unwrap();
    assert_eq!(written.len(), 2);
    assert_eq!(written[0]["file"], "out/model.json");
    assert_eq!(written[0]["replaced"], false);
    assert_eq!(identified["far_unit"], "N");
    checked(&bench, "identify --dry-run", "identify a.csv --dry-run", 0);
    checked(&bench, "adapt", "adapt out/model.json b.csv --out adapted", 0);
    let evaluated = checked(&bench, "evaluate", "evaluate out/model.json a.csv", 0);
    assert_eq!(evaluated["logs"][0]["in_training"], true);
    checked(&bench, "predict", "predict out/model.json a.csv --out p.csv", 0);
}

#[test]
fn documents_about_robots_and_machines_have_the_documented_keys_and_units() {
    let bench = Bench::new();
    bench.write("poses.csv", "base_flexion\n0.1\n");
    checked(&bench, "machine body", "machine body finger", 0);
    checked(&bench, "machine evaluate", "machine evaluate finger --poses poses.csv", 0);
    let converted = checked(&bench, "machine convert", "machine convert finger body.xml", 0);
    assert!(!converted["left_out"].as_array().unwrap().is_empty());
    assert!(
        checked(&bench, "machine convert", "machine convert body.xml body.toml", 0)["left_out"]
            == serde_json::json!([])
    );
    checked(&bench, "machine show", "machine show finger", 0);
    checked(&bench, "machine tune", "machine tune finger --specimens 0", 0);
    checked(&bench, "machine map", "machine map finger --poses 10", 0);
    checked(&bench, "machine new", "machine new finger --out new.toml", 0);
    checked(&bench, "track", "track bench_joint --path tour --duration 12 --repeats 1 --record joint.csv", 0);
    checked(&bench, "log plot", "log plot joint.csv --report joint.html", 0);
    let motion = "planar_leg --path to-joints:hip=0.4,knee=1.0 --duration 3 --hold 1";
    checked(&bench, "run", &format!("run {motion} --bus segment --virtual-time"), 0);
}

#[test]
fn documents_about_benches_cables_and_drives_have_the_documented_keys_and_units() {
    let bench = Bench::new();
    checked(&bench, "twin bench", "twin bench --speeds 0.04 --duration 3 --out b.csv", 0);
    checked(&bench, "twin plan", "twin plan --out plan.csv", 0);
    checked(&bench, "twin cable", "twin cable --out c.csv", 0);
    bench.write("rip.csv", "time_s,motor_m,anchor_m\n0,0,0\n2,0.4,0\n");
    let broken = checked(&bench, "twin cable", "twin cable rip.csv --out rip_log.csv", 3);
    assert_eq!(broken["outcome"], "not_as_asked");
    assert!(broken["broken"]["tension_n"].as_f64().unwrap() > 100.0);
    bench.write(
        "t.json",
        r#"{"problems":[{"moment_arms":[[0.03],[-0.03]],"torque_nm":[1e3],"min_n":[20,20],"max_n":[400,400]}]}"#,
    );
    checked(&bench, "design tension", "design tension t.json", 3);
    let drive = "design drive --speed 0.14 --acceleration 3 --stroke 0.3 --tension";
    checked(&bench, "design drive", &format!("{drive} 250"), 0);
    checked(&bench, "design drive", &format!("{drive} 25000"), 3);
    checked(&bench, "doctor", "doctor", 0);
    checked(&bench, "example", "example", 0);
    checked(&bench, "example", "example hand", 0);
    checked(&bench, "completions", "completions bash", 0);
    checked(&bench, "man", "man", 0);
    checked(&bench, "man", "man --out man", 0);
}

#[test]
fn an_error_is_a_document_too_with_code_and_message() {
    let bench = Bench::new();
    for (arguments, code, outcome, words) in [
        ("evaluate missing.json a.csv", 2, "bad_input", "missing.json"),
        ("identify", 2, "bad_input", "LOG"),
        ("track --duration 2", 3, "not_as_asked", "brachialis"),
        ("twin plan --out no/plan.csv", 1, "system_failed", "no folder no"),
    ] {
        let run = bench.run(&format!("{arguments} --json"));
        assert_eq!(run.code, Some(code), "{arguments}: {}", run.stderr);
        let document: Value = serde_json::from_str(&run.stdout).unwrap();
        assert_eq!(document["outcome"], outcome, "{arguments}");
        assert_eq!(document["exit_code"], code);
        let message = document["error"]["message"].as_str().unwrap();
        assert!(message.contains(words), "{arguments}: {message}");
        assert!(run.stderr.starts_with("error: "), "{}", run.stderr);
    }
}

#[test]
fn long_documents_of_the_demonstration_and_the_reproduction_have_the_documented_keys_and_units() {
    if std::env::var_os("SINEW_LONG").is_none() {
        return;
    }
    let bench = Bench::new();
    let demo = checked(&bench, "demo", "demo --out demo", 0);
    assert_eq!(demo["simulated"], true);
    checked(&bench, "reproduce", "reproduce --quick --out paper", 0);
}

#[test]
fn documents_about_a_bus_that_is_not_there_are_errors() {
    let bench = Bench::new();
    for verb in
        ["ethercat scan bench_joint", "ethercat simulate bench_joint", "run bench_joint --bus ethercat"]
    {
        let run = bench.run(&format!("{verb} --interface none9 --json"));
        assert!(matches!(run.code, Some(1 | 2)), "{verb}: {:?} {}", run.code, run.stderr);
        let document: Value = serde_json::from_str(&run.stdout).unwrap();
        assert!(document["error"]["message"].as_str().unwrap().contains("none9"), "{document}");
    }
}

#[test]
fn a_command_line_that_is_refused_names_the_verb_that_it_asked_for() {
    let bench = Bench::new();
    for (arguments, verb) in
        [("track --payload -1 --json", "track"), ("--json arm inspect", "machine body"), ("nope --json", "")]
    {
        let document: Value = serde_json::from_str(&bench.run(arguments).stdout).unwrap();
        assert_eq!((&document["verb"], &document["exit_code"]), (&verb.into(), &2.into()), "{arguments}");
    }
}
