//! Outputs are complete or absent, and a failed run leaves earlier files unchanged.

use crate::bench::{Bench, Outcome, SYSTEM, ended, log, with_line};

#[test]
fn a_second_run_replaces_the_first_result() {
    let bench = Bench::with_model();
    let first = bench.read("out/model.json");
    bench.succeeds("identify a.csv --model cell --out out");
    assert_ne!(bench.read("out/model.json"), first);
    assert_eq!(bench.files("out"), ["model.json", "report.html"]);
}

#[test]
fn a_replaced_file_is_said_and_refused_where_none_may_be() {
    let bench = Bench::with_model();
    let first = bench.succeeds("predict out/model.json a.csv --out p.csv").stdout;
    assert!(first.ends_with("Written: p.csv\n"), "{first}");
    let second = bench.succeeds("predict out/model.json a.csv --out p.csv").stdout;
    assert!(second.ends_with("Written: p.csv (replaced)\n"), "{second}");
    bench.succeeds("predict out/model.json a.csv --out q.csv --no-clobber");
    for arguments in [
        "predict out/model.json a.csv --out p.csv --no-clobber",
        "identify a.csv --model cell --out out --no-clobber",
        "twin cable --out p.csv --no-clobber",
        "twin bench --out p.csv --no-clobber",
        "machine show finger --picture p.csv --no-clobber",
        "demo --out out --no-clobber",
        "track --record p.csv --no-clobber",
    ] {
        bench.refuses(arguments, &["exists already", "--no-clobber"]);
    }
}

#[test]
fn a_failed_second_run_leaves_the_first_result_unharmed() {
    let bench = Bench::with_model();
    bench.write("bad.csv", with_line(40, "0.76,x,1"));
    bench.refuses("identify bad.csv --model cell --out out", &["bad.csv", "line 40"]);
    bench.refuses("adapt out/model.json bad.csv --out out", &[]);
    // The report has no place: the model must not be replaced either.
    std::fs::remove_file(bench.path("out/report.html")).unwrap();
    std::fs::create_dir(bench.path("out/report.html")).unwrap();
    bench.fails("identify a.csv --model cell --out out", &["report.html", "cannot be written", "directory"]);
}

#[test]
fn a_folder_that_cannot_be_created_is_a_failure_of_the_system() {
    let bench = Bench::with_model();
    // Permission bits do not restrict root; a file in place of a folder restricts every user.
    bench.fails(
        "identify a.csv --model cell --out a.csv/out",
        &["a.csv/out", "cannot be written", "folder, and a.csv is a file"],
    );
    bench.fails(
        "identify a.csv --model cell --out a.csv",
        &["a.csv", "cannot be written", "expected a folder"],
    );
    bench.fails("adapt out/model.json a.csv --out a.csv/out", &["a.csv/out", "cannot be written"]);
    bench.fails("predict out/model.json a.csv --out a.csv/p.csv", &["a.csv/p.csv", "cannot be written"]);
    bench.fails("predict out/model.json a.csv --out missing/p.csv", &["missing/p.csv", "cannot be written"]);
    bench.fails("predict out/model.json a.csv --out out", &["out: cannot be written", "directory"]);
    bench.fails(
        "identify a.csv --model cell --out new --picture missing/loop.svg",
        &["missing/loop.svg", "cannot be written"],
    );
}

#[cfg(unix)]
#[test]
fn a_folder_without_permission_is_named() {
    use std::os::unix::fs::PermissionsExt;
    let bench = Bench::with_model();
    let folder = bench.path("locked");
    std::fs::create_dir(&folder).unwrap();
    std::fs::set_permissions(&folder, PermissionsExt::from_mode(0o555)).unwrap();
    if std::fs::write(folder.join("probe"), "").is_ok() {
        eprintln!("skipped: permission bits do not bind this user");
        return;
    }
    bench.fails("identify a.csv --model cell --out locked", &["locked", "cannot be written"]);
    bench.fails("identify a.csv --model cell --out locked/new", &["locked/new", "cannot be written"]);
    bench.fails("predict out/model.json a.csv --out locked/p.csv", &["locked/p.csv", "cannot be written"]);
}

#[test]
fn an_input_is_never_overwritten() {
    let bench = Bench::with_model();
    bench.refuses("predict out/model.json a.csv --out a.csv", &["a.csv", "is read by this run"]);
    bench.refuses(
        "predict out/model.json a.csv --out ./out/model.json",
        &["model.json", "is read by this run"],
    );
    bench.refuses("adapt out/model.json b.csv --out out", &["model.json", "is read by this run"]);
    bench.refuses("identify a.csv --model cell --out new --picture a.csv", &["a.csv", "is read by this run"]);
    bench.refuses(
        "identify a.csv --model cell --out out --picture out/model.json",
        &["model.json", "two results"],
    );
    // The same place by another name, before the folder exists and after.
    for out in ["new", "out"] {
        std::fs::create_dir_all(bench.path("out")).unwrap();
        bench.refuses(
            &format!("identify a.csv --model cell --out {out} --picture {out}/./../{out}/report.html"),
            &["report.html"],
        );
    }
}

#[cfg(unix)]
#[test]
fn a_link_stays_a_link_and_a_device_a_device() {
    let bench = Bench::with_model();
    bench.write("old.csv", "old");
    std::os::unix::fs::symlink("old.csv", bench.path("link.csv")).unwrap();
    bench.succeeds("predict out/model.json a.csv --out link.csv");
    assert!(bench.path("link.csv").is_symlink());
    assert!(bench.read("old.csv").starts_with("log,trial,"));
    bench.succeeds("predict out/model.json a.csv --out /dev/null");
    assert!(!std::fs::metadata("/dev/null").unwrap().is_file());
}

#[cfg(target_os = "linux")]
#[test]
fn a_full_device_is_reported() {
    let bench = Bench::with_model();
    bench.fails("predict out/model.json a.csv --out /dev/full", &["/dev/full", "cannot be written", "space"]);
    assert!(!std::fs::metadata("/dev/full").unwrap().is_file());
    // Results on standard output are results too.
    let full = std::fs::OpenOptions::new().write(true).open("/dev/full").unwrap();
    let output = bench.command("evaluate out/model.json a.csv").stdout(full).output().unwrap();
    ended(SYSTEM, "evaluate to a full device", &output.into(), &["standard output", "space"]);
}

/// The program may write no file beyond `blocks` of 512 bytes: what a full disk does to it, without a disk.
#[cfg(target_os = "linux")]
fn run_in_little_space(bench: &Bench, arguments: &str, blocks: usize) -> Outcome {
    let script = format!("trap '' XFSZ; ulimit -f {blocks}; exec \"$0\" {arguments}");
    let mut shell = std::process::Command::new("sh");
    shell.args(["-c", &script, env!("CARGO_BIN_EXE_sinew")]).current_dir(bench.path("."));
    shell.output().unwrap().into()
}

#[cfg(target_os = "linux")]
#[test]
fn a_full_disk_loses_nothing_that_was_there() {
    let bench = Bench::with_model();
    bench.succeeds("predict out/model.json a.csv --out p.csv");
    let before = bench.content();
    // The second leaves room for the model but not for the report.
    for (arguments, blocks, file) in [
        ("identify b.csv --model cell --out out", 1, "out/model.json"),
        ("identify b.csv --model cell --out out", 64, "out/report.html"),
        ("identify b.csv --model cell --out new/out", 64, "new/out/report.html"),
        ("adapt out/model.json b.csv --out adapted", 64, "adapted/report.html"),
        ("predict out/model.json b.csv --out p.csv", 8, "p.csv"),
        ("export out/model.json --to c --out new/c", 4, "new/c/model"),
    ] {
        let outcome = run_in_little_space(&bench, arguments, blocks);
        ended(SYSTEM, arguments, &outcome, &[file, "cannot be written", "large"]);
        assert!(bench.content() == before, "{arguments} left something else");
    }
}

/// Sends a signal to `identify` while it works on a long job.
#[cfg(unix)]
fn interrupted(bench: &Bench, out: &str, signal: &str) -> Outcome {
    use std::process::Stdio;
    use std::time::{Duration, Instant};
    let slow =
        format!("identify {} --out {out}", (0..8).map(|k| format!("long{k}.csv ")).collect::<String>());
    for k in 0..8 {
        bench.write(&format!("long{k}.csv"), log(0.4 + 0.03 * f64::from(k)));
    }
    let already = bench.path(out).exists();
    let mut command = bench.command(&slow);
    let mut child = command.stdout(Stdio::piped()).stderr(Stdio::piped()).spawn().unwrap();
    // The handler is installed before the folder is created; where the folder existed before, wait a moment.
    let start = Instant::now();
    while !bench.path(out).exists() && start.elapsed() < Duration::from_secs(20) {
        std::thread::sleep(Duration::from_millis(1));
    }
    std::thread::sleep(Duration::from_millis(if already { 300 } else { 30 }));
    assert_eq!(child.try_wait().unwrap(), None, "still at work");
    let kill = format!("kill -{signal} {}", child.id());
    let kill = std::process::Command::new("sh").args(["-c", &kill]).status().unwrap();
    assert!(kill.success());
    child.wait_with_output().unwrap().into()
}

#[cfg(unix)]
#[test]
fn signals_that_end_the_program_leave_nothing_half_written() {
    for signal in ["INT", "TERM", "HUP"] {
        let bench = Bench::new();
        let outcome = interrupted(&bench, "new/out", signal);
        assert_eq!(outcome.code, Some(130), "{}", outcome.stderr);
        assert!(
            outcome.stderr.contains("interrupted") && !outcome.stdout.contains("Written"),
            "{}",
            outcome.stderr
        );
        assert!(!bench.path("new").exists(), "created folders are removed");
        assert!(bench.files(".").iter().all(|name| name.ends_with(".csv")), "{:?}", bench.files("."));
    }
}

#[cfg(unix)]
#[test]
fn ctrl_c_leaves_the_old_result_as_it_was() {
    let bench = Bench::with_model();
    let (model, report) = (bench.read("out/model.json"), bench.read("out/report.html"));
    let outcome = interrupted(&bench, "out", "INT");
    assert_eq!(outcome.code, Some(130), "{}", outcome.stderr);
    assert_eq!(bench.files("out"), ["model.json", "report.html"]);
    assert!(bench.read("out/model.json") == model && bench.read("out/report.html") == report);
}

#[cfg(unix)]
#[test]
fn a_closed_pipe_is_no_error() {
    let bench = Bench::with_model();
    let script = "\"$0\" evaluate out/model.json a.csv b.csv | true; exit 0";
    let mut shell = std::process::Command::new("sh");
    let shell = shell.args(["-c", script, env!("CARGO_BIN_EXE_sinew")]).current_dir(bench.path("."));
    let outcome: Outcome = shell.output().unwrap().into();
    assert_eq!(outcome.stderr, "");
}
