//! Model files that cannot be used, and logs that do not fit a model.

use crate::bench::{Bench, log};

/// `evaluate`, `predict` and `adapt` refuse this content as a model.
#[track_caller]
fn refuses(bench: &Bench, content: impl AsRef<[u8]>, parts: &[&str]) {
    bench.write("bad.json", content);
    let parts = [&["bad.json"], parts].concat();
    for arguments in [
        "evaluate bad.json a.csv",
        "evaluate bad.json a.csv --json",
        "predict bad.json a.csv --out p.csv",
        "adapt bad.json a.csv --out adapted",
    ] {
        bench.refuses(arguments, &parts);
    }
}

#[test]
fn a_digit_that_flipped_is_found() {
    let bench = Bench::with_model();
    let text = bench.read("out/model.json");
    let place = text.find("\"low\":[").unwrap() + "\"low\":[0.".len();
    let mut bytes = text.into_bytes();
    assert!(bytes[place].is_ascii_digit());
    bytes[place] ^= 1;
    refuses(&bench, bytes, &["checksum", "damaged or edited"]);
}

#[test]
fn a_model_that_ends_early_is_refused() {
    let bench = Bench::with_model();
    let text = bench.read("out/model.json");
    refuses(&bench, &text[..text.len() / 2], &["EOF"]);
    refuses(&bench, &text[..30], &["EOF"]);
    refuses(&bench, "", &["no JSON"]);
}

#[test]
fn another_version_is_refused_with_both_numbers() {
    let bench = Bench::with_model();
    let newer = bench.read("out/model.json").replace("\"version\":1", "\"version\":9");
    refuses(&bench, newer, &["version 1", "got 9", "update"]);
}

#[test]
fn another_kind_of_file_is_refused_as_such() {
    let bench = Bench::with_model();
    refuses(&bench, "{\"name\": \"left-pad\", \"version\": \"1.3.0\"}", &[]);
    refuses(&bench, "{\"type\": \"FeatureCollection\", \"features\": []}", &["another kind of file"]);
    refuses(&bench, "[1, 2, 3]", &["no JSON object"]);
    refuses(&bench, "time_s,tension_in_n\n0,1\n", &["no JSON"]);
    refuses(&bench, "[".repeat(100_000), &["no JSON"]);
    refuses(&bench, b"\xff\xfe{\0}\0".as_slice(), &["expected text (UTF-8)"]);
    refuses(&bench, [0_u8; 1000], &[]);
}

#[test]
fn a_model_that_is_not_there_is_named() {
    let bench = Bench::new();
    bench.refuses("evaluate missing.json a.csv", &["missing.json", "cannot be read"]);
    std::fs::create_dir(bench.path("folder")).unwrap();
    bench.refuses("evaluate folder a.csv", &["folder", "cannot be read"]);
    bench.refuses("predict folder a.csv --out p.csv", &["folder", "cannot be read"]);
    bench.refuses("adapt folder a.csv --out out", &["folder", "cannot be read"]);
}

#[test]
fn a_log_without_an_input_of_the_model_is_refused() {
    let bench = Bench::with_model();
    bench.write("other.csv", log(0.4).replace("tension_in_n", "tension_im_n"));
    for arguments in [
        "evaluate out/model.json other.csv",
        "predict out/model.json other.csv --out p.csv",
        "adapt out/model.json other.csv --out adapted",
        "evaluate out/model.json a.csv other.csv",
    ] {
        bench.refuses(arguments, &["other.csv", "`tension_in_n`", "`tension_im_n`"]);
    }
}

#[test]
fn a_log_without_the_far_side_can_be_predicted_but_not_judged() {
    let bench = Bench::with_model();
    bench.write("near.csv", log(0.4).replace("tension_out_n", "y"));
    bench.refuses("evaluate out/model.json near.csv", &["near.csv", "`tension_out_n`"]);
    bench.refuses("adapt out/model.json near.csv --out adapted", &["near.csv", "`tension_out_n`"]);
    bench.succeeds("predict out/model.json near.csv --out p.csv");
}

#[cfg(target_os = "linux")]
#[test]
fn an_endless_file_is_refused_while_it_is_read() {
    let bench = Bench::with_model();
    bench.refuses("predict /dev/zero a.csv --out p.csv", &["/dev/zero", "at most 64 MB"]);
    bench.refuses("identify /dev/zero --out new", &["zero", "a device or a pipe"]);
}
