//! Every verb with valid input.

use crate::bench::{Bench, ROWS, log, samples};
use serde_json::Value;
use sinew::predictor::{Model, Predictor, Sample};

const SCORES: [&str; 12] = [
    "n",
    "mse",
    "rmse",
    "pearson",
    "percent_of_range",
    "coverage95",
    "out_of_range",
    "expected",
    "rmse_in_range",
    "rmse_out_of_range",
    "specimen",
    "state_unknown",
];

#[test]
fn every_verb_explains_itself() {
    let bench = Bench::new();
    let help = bench.succeeds("--help").stdout;
    for verb in ["identify", "evaluate", "predict", "compensate", "adapt", "demo", "track", "run", "ethercat"]
    {
        assert!(help.contains(verb), "{help}");
        let own = bench.succeeds(&format!("{verb} --help")).stdout;
        assert!(own.contains(&format!("Usage: sinew {verb}")) && own.len() > 300, "{own}");
        assert!(bench.succeeds(&format!("help {verb}")).stdout.contains("Usage"));
    }
    assert!(bench.succeeds("--version").stdout.starts_with("sinew "));
    assert!(help.contains("Exit codes:") && help.contains("bad input"), "{help}");
}

#[test]
fn an_example_is_a_folder_whose_first_command_runs_there() {
    let bench = Bench::new();
    let listed = bench.succeeds("example").stdout;
    for (name, file) in
        [("hand", "hand.urdf"), ("bench", "simulated_day_5.csv"), ("training", "train_policy.py")]
    {
        assert!(listed.contains(name), "{listed}");
        let printed = bench.succeeds(&format!("example {name}")).stdout;
        let notes = bench.read(&format!("{name}/README.txt"));
        assert!(printed.contains(&notes) && bench.path(name).join(file).is_file(), "{printed}");
        assert_eq!(notes.lines().filter(|line| line.starts_with("  ")).count(), 3, "{notes}");
        // The tutorials run the others.
        if let Some(first) = notes.lines().find_map(|line| line.strip_prefix("  sinew ")) {
            let run = bench.command(first).current_dir(bench.path(name)).output().unwrap();
            assert!(run.status.success(), "{first}: {}", String::from_utf8_lossy(&run.stderr));
        }
    }
    let refused = bench.run("example hand --no-clobber");
    assert!(refused.code == Some(2) && refused.stderr.contains("hand.urdf"), "{}", refused.stderr);
    bench.succeeds("example bus --out legs");
    let shown = bench.succeeds("machine show legs/leg.toml").stdout;
    assert!(shown.contains("bus_leg"), "{shown}");
}

#[test]
fn help_lists_the_compensation_variants_with_what_they_do() {
    let help = Bench::new().succeeds("track --help").stdout;
    for variant in sinew_lab::CompensationVariant::ARM {
        let listed = help.lines().any(|line| line.contains(&format!("- {variant}:")));
        assert!(listed, "{variant}: {help}");
    }
}

#[test]
fn every_shell_gets_a_script_that_completes_verbs_and_flags() {
    let bench = Bench::new();
    for shell in ["bash", "elvish", "fish", "powershell", "zsh"] {
        let script = bench.succeeds(&format!("completions {shell}")).stdout;
        assert!(script.contains("identify") && script.contains("compensation"), "{shell}: {script}");
        // The generators for elvish and powershell complete no values.
        let values = !matches!(shell, "elvish" | "powershell");
        assert_eq!(script.contains("no_disturbance_observer"), values, "{shell}");
    }
}

#[test]
fn an_unknown_verb_flag_or_value_is_bad_input() {
    let bench = Bench::new();
    for arguments in
        ["identfy a.csv", "identify a.csv", "identify --out out", "identify a.csv --out out --seed x"]
    {
        let outcome = bench.run(arguments);
        assert_eq!(outcome.code, Some(2), "{arguments}");
        assert_eq!(outcome.stdout, "", "{arguments}");
    }
}

#[test]
fn the_program_alone_says_what_its_help_says() {
    let bench = Bench::new();
    assert_eq!(bench.succeeds("").stdout, bench.succeeds("--help").stdout);
}

#[test]
fn the_version_names_commit_and_features() {
    let version = Bench::new().succeeds("--version").stdout;
    assert!(version.starts_with(concat!("sinew ", env!("CARGO_PKG_VERSION"), " (")), "{version}");
    for (feature, built) in [("parquet", cfg!(feature = "parquet")), ("mat73", cfg!(feature = "mat73"))] {
        assert_eq!(version.contains(feature), built, "{version}");
    }
}

#[test]
fn every_verb_has_a_manual_page() {
    let bench = Bench::new();
    bench.succeeds("man --out man");
    let pages = bench.files("man");
    for page in ["sinew.1", "sinew-identify.1", "sinew-machine-convert.1", "sinew-machine-tune.1"] {
        assert!(pages.iter().any(|name| name == page), "{page}: {pages:?}");
    }
    let page = bench.read("man/sinew-identify.1");
    assert!(page.contains(".TH sinew-identify 1") && page.contains("\\-\\-ignore"), "{page}");
    assert_eq!(bench.succeeds("man").stdout, bench.read("man/sinew.1"));
}

#[test]
fn identify_writes_the_model_and_the_report_and_nothing_else() {
    let bench = Bench::new();
    let summary = bench.succeeds("identify a.csv b.csv --model cell --out new/out").stdout;
    assert_eq!(bench.files("new/out"), ["model.json", "report.html"]);
    assert_eq!(bench.files("."), ["a.csv", "b.csv", "new"]);
    assert!(summary.contains("tension_out_n") && summary.contains("new/out/model.json"), "{summary}");
    let report = bench.read("new/out/report.html");
    assert!(report.contains("tension_out_n") && report.len() < 3 << 20);
    for outside in ["src=\"http", "href=\"http", "@import", "url(http"] {
        assert!(!report.contains(outside), "the report is one file, but has {outside}");
    }
}

#[test]
fn identify_draws_a_picture_where_it_is_asked_to() {
    let bench = Bench::new();
    bench.succeeds("identify a.csv b.csv --model cell --out out --picture loop.svg");
    assert!(bench.read("loop.svg").contains("<svg"));
    assert_eq!(bench.files("out"), ["model.json", "report.html"]);
}

#[test]
fn json_is_all_that_json_prints() {
    let bench = Bench::new();
    let identified = bench.succeeds("identify a.csv b.csv --model cell --out out --json").stdout;
    let account: Value = serde_json::from_str(&identified).unwrap();
    assert_eq!(account["chosen"]["name"], "cell");
    assert_eq!(account["seed"], 1);
    let adapted = bench.succeeds("adapt out/model.json b.csv --out adapted --json").stdout;
    let account: Value = serde_json::from_str(&adapted).unwrap();
    assert!(account["candidates"].as_array().is_some_and(|list| !list.is_empty()));
    assert_eq!(bench.files("adapted"), ["model.json", "report.html"]);
}

#[test]
fn evaluate_has_exactly_the_promised_shape() {
    let bench = Bench::with_model();
    let text = bench.succeeds("evaluate out/model.json a.csv b.csv --json").stdout;
    let all: Value = serde_json::from_str(&text).unwrap();
    let keys = |value: &Value| -> Vec<String> {
        let mut keys: Vec<String> = value.as_object().unwrap().keys().cloned().collect();
        keys.sort();
        keys
    };
    let sorted = |names: &[&str]| {
        let mut names = names.to_vec();
        names.sort_unstable();
        names.into_iter().map(str::to_owned).collect::<Vec<_>>()
    };
    let head = ["exit_code", "outcome", "program", "schema_version", "verb", "written"];
    assert_eq!(
        keys(&all),
        sorted(&[&head[..], &["far", "far_unit", "findings", "logs", "overall"]].concat())
    );
    assert_eq!(keys(&all["overall"]), sorted(&SCORES));
    let logs = all["logs"].as_array().unwrap();
    assert_eq!(logs.len(), 2);
    for (log, name) in logs.iter().zip(["a.csv", "b.csv"]) {
        assert_eq!(keys(log), sorted(&[&SCORES[..], &["log", "in_training"]].concat()));
        assert_eq!(log["log"], name);
        assert_eq!(log["n"], ROWS);
    }
    assert_eq!(all["overall"]["n"], 2 * ROWS);
    let coverage = all["overall"]["coverage95"].as_f64().unwrap();
    assert!((0.85..=1.0).contains(&coverage), "a fraction: {coverage}");
    let order: Vec<usize> = SCORES.iter().map(|key| text.find(&format!("\"{key}\"")).unwrap()).collect();
    assert!(order.is_sorted(), "{text}");
}

#[test]
fn what_is_noticed_in_a_log_is_said_by_every_verb_that_reads_it() {
    let bench = Bench::with_model();
    for verb in ["evaluate", "predict --out far.csv", "compensate --out near.csv"] {
        let asked = format!("{verb} out/model.json a.csv --rate 50");
        let (text, noticed) = (bench.succeeds(&asked).stdout, "no time column is read");
        assert!(text.contains(noticed), "{text}");
        let all: Value = serde_json::from_str(&bench.succeeds(&format!("{asked} --json")).stdout).unwrap();
        assert_eq!(all["findings"][0]["log"], "a.csv");
        assert!(all["findings"][0]["sentence"].as_str().unwrap().contains(noticed), "{all}");
    }
}

#[test]
fn evaluate_leaves_the_skipped_seconds_out() {
    let bench = Bench::with_model();
    let text = bench.succeeds("evaluate out/model.json a.csv --skip 2 --json").stdout;
    let all: Value = serde_json::from_str(&text).unwrap();
    assert_eq!(all["overall"]["n"], ROWS - 100);
}

#[test]
fn samples_outside_the_training_ranges_are_counted_and_scored_by_themselves() {
    let bench = Bench::with_model();
    let inside: Value =
        serde_json::from_str(&bench.succeeds("evaluate out/model.json a.csv --json").stdout).unwrap();
    assert!(inside["overall"]["out_of_range"].as_f64().unwrap() < 0.02);
    // A third of the rows at five times the tension.
    let text: String = log(0.4)
        .lines()
        .enumerate()
        .map(|(k, line)| {
            let cells: Vec<f64> = line.split(',').filter_map(|cell| cell.parse().ok()).collect();
            match cells[..] {
                [t, near, far] if k > 400 => format!("{t},{},{}\n", 5.0 * near, 5.0 * far),
                _ => format!("{line}\n"),
            }
        })
        .collect();
    bench.write("far.csv", text);
    let far: Value =
        serde_json::from_str(&bench.succeeds("evaluate out/model.json far.csv --json").stdout).unwrap();
    let fraction = far["overall"]["out_of_range"].as_f64().unwrap();
    assert!((0.2..0.4).contains(&fraction), "{far}");
    let rmse = |key: &str| far["overall"][key].as_f64().unwrap();
    let mean_square =
        fraction * rmse("rmse_out_of_range").powi(2) + (1.0 - fraction) * rmse("rmse_in_range").powi(2);
    assert!((mean_square - rmse("mse")).abs() < 1e-9 * rmse("mse"), "{far}");
    for command in ["evaluate out/model.json far.csv", "predict out/model.json far.csv --out p.csv"] {
        let said = bench.succeeds(command).stdout;
        assert!(said.contains("outside the ranges of the training logs"), "{said}");
    }
}

/// Rows of a predictions file: log, trial, time, prediction, deviation, gate, flags.
fn predictions(text: &str) -> Vec<Vec<String>> {
    let mut lines = text.lines();
    assert_eq!(lines.next(), Some("log,trial,time_s,prediction,standard_deviation,gate,flags"));
    lines.map(|line| line.split(',').map(str::to_owned).collect()).collect()
}

#[test]
fn predict_writes_one_row_per_sample_and_needs_no_far_side() {
    let bench = Bench::with_model();
    let near: String =
        log(0.4).lines().map(|line| line.rsplit_once(',').unwrap().0.to_owned() + "\n").collect();
    bench.write("near.csv", near);
    bench.succeeds("predict out/model.json a.csv --out with.csv");
    bench.succeeds("predict out/model.json near.csv --out without.csv");
    let rows = predictions(&bench.read("with.csv"));
    assert_eq!(rows.len(), ROWS);
    assert!(rows.iter().all(|row| row.len() == 7 && row[0] == "a.csv"));
    assert_eq!(rows[0][6], "state_unknown|reset");
    assert_eq!(bench.read("with.csv"), bench.read("without.csv").replace("near.csv", "a.csv"));
}

#[test]
fn predict_counts_repeated_rows_once() {
    let bench = Bench::with_model();
    let text = log(0.4);
    let line = text.lines().nth(100).unwrap();
    bench.write("stutter.csv", text.replace(line, &format!("{line}\n{line}")));
    bench.succeeds("predict out/model.json stutter.csv --out p.csv");
    assert_eq!(predictions(&bench.read("p.csv")).len(), ROWS);
}

#[test]
fn files_are_predicted_as_a_stream_is() {
    let bench = Bench::with_model();
    bench.succeeds("predict out/model.json a.csv b.csv --out p.csv");
    let rows = predictions(&bench.read("p.csv"));
    let mut predictor = Predictor::new(Model::from_json(&bench.read("out/model.json")).unwrap()).unwrap();
    let mut place = 0;
    for name in ["a.csv", "b.csv"] {
        predictor.reset();
        for line in bench.read(name).lines().skip(1) {
            let cells: Vec<f64> = line.split(',').map(|cell| cell.parse().unwrap()).collect();
            let streamed = predictor.step(&Sample { time_s: cells[0], inputs: &cells[1..2] });
            let read = |column: usize| rows[place][column].parse::<f64>().unwrap().to_bits();
            assert_eq!(rows[place][0], name);
            assert_eq!(read(3), streamed.mean.to_bits());
            assert_eq!(read(4), streamed.standard_deviation.to_bits());
            assert_eq!(read(5), streamed.gate.to_bits());
            place += 1;
        }
    }
    assert_eq!(place, rows.len());
}

#[test]
fn evaluate_scores_what_predict_writes() {
    let bench = Bench::with_model();
    bench.succeeds("predict out/model.json a.csv --out p.csv");
    let text = bench.succeeds("evaluate out/model.json a.csv --json").stdout;
    let scores = serde_json::from_str::<Value>(&text).unwrap()["overall"].clone();
    let (mut squares, mut inside) = (0.0, 0.0);
    // Far sides as written, with four digits.
    let far = bench
        .read("a.csv")
        .lines()
        .skip(1)
        .map(|l| l.rsplit_once(',').unwrap().1.parse().unwrap())
        .collect::<Vec<f64>>();
    for (row, far) in predictions(&bench.read("p.csv")).iter().zip(&far) {
        let error = row[3].parse::<f64>().unwrap() - far;
        squares += error * error;
        inside += f64::from(error.abs() <= 1.96 * row[4].parse::<f64>().unwrap());
    }
    let n = far.len() as f64;
    let near = |name: &str, value: f64| (scores[name].as_f64().unwrap() - value).abs() < 1e-9 * value;
    assert!(near("mse", squares / n) && near("rmse", (squares / n).sqrt()), "{scores}");
    assert!(near("coverage95", inside / n), "{scores}");
    assert!(far.len() == samples(0.4).len());
}

#[test]
fn a_column_has_many_names() {
    let bench = Bench::new();
    bench.write(
        "other.tsv",
        log(0.4).replace(',', "\t").replace("tension_in_n", "near").replace("tension_out_n", "end"),
    );
    bench.succeeds("identify other.tsv --far end --effort near --time time_s --model cell --out out");
    let text = bench.succeeds("evaluate out/model.json other.tsv --json").stdout;
    let scores = serde_json::from_str::<Value>(&text).unwrap();
    assert!(scores["overall"]["percent_of_range"].as_f64().unwrap() < 1.0, "{text}");
}

#[test]
fn output_to_a_file_or_pipe_has_no_colours() {
    let bench = Bench::with_model();
    let table = bench.succeeds("evaluate out/model.json a.csv").stdout;
    assert!(table.contains("RMSE") && !table.contains('\x1b'), "{table}");
    let error = bench.run("evaluate out/model.json missing.csv").stderr;
    assert!(error.starts_with("error:") && !error.contains('\x1b'), "{error}");
}

#[test]
fn an_earlier_spelling_is_answered_with_the_present_one() {
    let bench = Bench::new();
    bench.refuses("arm inspect finger", &["`sinew arm inspect` is now `sinew machine body`"]);
    bench.refuses("replay run.mcap", &["`sinew replay` is now `sinew log replay`"]);
    let told = bench.run("tension p.json --json").stdout;
    assert!(told.contains("sinew design tension") && told.contains("\"exit_code\":2"), "{told}");
}
