//! `sinew export`: generated C gives the numbers of `sinew predict`; what cannot be exported leaves nothing.

use crate::bench::{BAD_INPUT, Bench, log};
use std::path::Path;
use std::process::Command;

/// Whether there is a C compiler; says so where there is none.
fn compiler() -> bool {
    let found = Command::new("cc").arg("--version").output().is_ok_and(|output| output.status.success());
    if !found {
        eprintln!("skipped: no C compiler on this machine");
    }
    found
}

/// Compiles every source in the folder, as the page about exports says.
fn compile(folder: &Path) {
    let output = Command::new("sh")
        .args(["-c", "cc -std=c99 -Wall -Wextra -Wpedantic -Werror *.c -lm"])
        .current_dir(folder)
        .output()
        .unwrap();
    assert!(output.status.success(), "{}", String::from_utf8_lossy(&output.stderr));
}

#[test]
fn the_exported_example_prints_what_predict_writes() {
    let bench = Bench::with_model();
    let shown = bench.succeeds("export out/model.json --to c --out exported").stdout;
    assert!(shown.contains("cc model.c example.c -lm"), "{shown}");
    let expected = ["CMakeLists.txt", "arduino", "example.c", "model.c", "model.h", "simulink"];
    assert_eq!(bench.files("exported"), expected);
    if !compiler() {
        return;
    }
    compile(&bench.path("exported"));
    // Missing and repeated rows, a spike, a comment, quoted cells between semicolons.
    let mut lines: Vec<String> = log(0.47).lines().map(str::to_owned).collect();
    (lines[20], lines[40], lines[41]) = ("0.38,,1".into(), lines[39].clone(), "0.80,1e4,1".into());
    lines.insert(1, "# a comment".into());
    let semicolons = lines.join("\n").replace(',', ";").replace("tension_in_n", "\"tension_in_n\"");
    for text in [lines.join("\n") + "\n", semicolons.clone(), semicolons.replace('\n', "\r\n")] {
        bench.write("bad day.csv", text);
        let mut predict = bench.command("predict out/model.json --out p.csv");
        assert!(predict.arg("bad day.csv").output().unwrap().status.success());
        let output =
            Command::new(bench.path("exported/a.out")).arg(bench.path("bad day.csv")).output().unwrap();
        assert!(output.status.success());
        assert!(String::from_utf8(output.stdout).unwrap() == bench.read("p.csv"), "they differ");
    }
}

#[test]
fn the_exported_inverse_prints_what_compensate_writes() {
    let bench = Bench::with_model();
    let shown = bench.succeeds("export out/model.json --to c --out exported --inverse --max-rate 300").stdout;
    assert!(shown.contains("./a.out --inverse DESIRED.csv"), "{shown}");
    if !compiler() {
        return;
    }
    compile(&bench.path("exported"));
    let row = |k: u32| {
        let t = 0.01 * f64::from(k);
        let desired = if k % 37 == 5 { String::new() } else { (20.0 + 12.0 * (3.0 * t).sin()).to_string() };
        // Some rows hold what was measured.
        let near = if k % 50 < 20 { (45.0 + 20.0 * (3.0 * t).sin()).to_string() } else { String::new() };
        format!("{t},{near},{desired}\n")
    };
    let rows: String = (0..400).map(row).collect();
    let alone: String = rows
        .lines()
        .map(|line| {
            let mut cells = line.split(',');
            format!("{},{}\n", cells.next().unwrap(), cells.nth(1).unwrap())
        })
        .collect();
    let far = "tension_out_n";
    for text in [format!("time_s,tension_in_n,{far}\n{rows}"), format!("time_s,{far}\n{alone}")] {
        bench.write("desired.csv", text);
        bench.succeeds("compensate out/model.json desired.csv --max-rate 300 --out command.csv");
        let output = Command::new(bench.path("exported/a.out"))
            .args(["--inverse"])
            .arg(bench.path("desired.csv"))
            .output()
            .unwrap();
        assert!(output.status.success(), "{}", String::from_utf8_lossy(&output.stderr));
        let got = String::from_utf8(output.stdout).unwrap();
        for (got, expected) in got.lines().zip(bench.read("command.csv").lines()) {
            assert_eq!(got, expected);
        }
        assert_eq!(got.lines().count(), 401);
    }
}

#[test]
fn the_example_names_a_column_that_is_missing() {
    if !compiler() {
        return;
    }
    let bench = Bench::with_model();
    bench.succeeds("export out/model.json --to c --out exported --name cable_7");
    compile(&bench.path("exported"));
    bench.write("other.csv", "time_s,x\n0,1\n");
    let output = Command::new(bench.path("exported/a.out")).arg(bench.path("other.csv")).output().unwrap();
    assert_eq!(output.status.code(), Some(BAD_INPUT));
    assert!(String::from_utf8_lossy(&output.stderr).contains("no column `tension_in_n`"));
}

#[test]
fn units_of_both_versions_are_one_file_each() {
    let bench = Bench::with_model();
    for form in ["fmu", "fmu2"] {
        bench.succeeds(&format!("export out/model.json --to {form} --out {form} --name knee"));
        assert_eq!(bench.files(form), ["knee.fmu"]);
        let bytes = std::fs::read(bench.path(&format!("{form}/knee.fmu"))).unwrap();
        assert!(bytes.starts_with(b"PK\x03\x04"));
        // The same model gives the same bytes.
        bench.succeeds(&format!("export out/model.json --to {form} --out again --name knee"));
        assert!(std::fs::read(bench.path("again/knee.fmu")).unwrap() == bytes);
    }
}

#[test]
fn a_graph_is_one_file() {
    let bench = Bench::with_model();
    let shown = bench.succeeds("export out/model.json --to onnx --out onnx").stdout;
    assert!(shown.contains("next_state"), "{shown}");
    assert_eq!(bench.files("onnx"), ["model.onnx"]);
}

#[test]
fn what_cannot_be_exported_is_one_error_and_leaves_nothing() {
    let bench = Bench::with_model();
    bench.write("file", "");
    let text = bench.read("out/model.json");
    bench.write("damaged.json", text.replace("0.", "1."));
    bench.write("7up.json", &text);
    for (arguments, parts) in [
        ("export none.json --to c --out d", vec!["none.json"]),
        ("export damaged.json --to c --out d/e", vec!["damaged.json"]),
        ("export damaged.json --to fmu --out d/e --json", vec!["damaged.json"]),
        ("export 7up.json --to c --out d", vec!["`7up`", "C identifier"]),
        ("export out/model.json --to c --out d --name a-b", vec!["`a-b`", "C identifier"]),
        ("export out/model.json --to fmu2 --out d --name math", vec!["`math`", "header"]),
        ("export out/model.json --to c --out d --inverse --max-rate -1", vec!["rate", "-1"]),
    ] {
        bench.refuses(arguments, &parts);
    }
    for form in ["c", "fmu"] {
        bench.fails(&format!("export out/model.json --to {form} --out file"), &["file", "cannot be written"]);
        bench.fails(&format!("export out/model.json --to {form} --out file/below"), &["file"]);
    }
    bench.refuses("export out/model.json --to onnx --out d --inverse", &["ONNX", "an inverse"]);
    bench.refuses_usage("export out/model.json --to matlab --out d", &["matlab", "c, fmu, fmu2, onnx"]);
    bench.refuses_usage("export out/model.json --out d", &["--to"]);
}
