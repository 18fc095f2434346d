//! The twin from the command line: bench logs, one cable, the arm, the paper.

use crate::bench::Bench;

#[test]
fn a_bench_run_writes_a_log_that_says_it_is_simulated_and_the_same_seed_the_same_bytes() {
    let bench = Bench::new();
    for file in ["a.csv", "b.csv"] {
        let run = bench.run(&format!("bench run --speeds 0.08 --duration 8 --seed 3 --out {file}"));
        assert_eq!(run.code, Some(0), "{}", run.stderr);
    }
    let log = bench.read("a.csv");
    assert!(log.starts_with("# SIMULATED") && log.contains("time_s,trial,tension_in_n"));
    assert_eq!(log.lines().count(), 2 + 8000);
    assert_eq!(log, bench.read("b.csv"));
    let run = bench
        .run("bench run --muscle active --speeds 0.08 --duration 8 --compensation none --json --out c.csv");
    assert!(run.stdout.contains("far_rmse_n"), "{}", run.stdout);
    // Active strokes only: none of them goes the other way.
    assert!(bench.read("c.csv").lines().skip(2).all(|line| !line.ends_with(",-1")));
}

#[test]
fn one_cable_is_moved_as_a_table_says_and_drawn() {
    let bench = Bench::new();
    bench.write("pull.csv", "time_s,motor_m,anchor_m\n0,0,0\n0.5,0.02,0\n1,0.02,0\n");
    let run = bench.run("twin cable pull.csv --out log.csv --picture cable.svg");
    assert_eq!(run.code, Some(0), "{}", run.stderr);
    assert_eq!(bench.read("log.csv").lines().count(), 2 + 1000);
    assert!(bench.read("cable.svg").contains("simulated data"));
}

#[test]
fn what_the_twin_cannot_do_is_refused_with_its_place() {
    let bench = Bench::new();
    bench.write("fast.csv", "time_s,motor_m,anchor_m\n0,0,0\n0.001,1,0\n");
    bench.write("way.csv", "time_s,x_m,y_m,z_m\n0,0.66,0.23,-0.28\n5,3,0,0\n");
    bench.write("bad.csv", "time_s,x_m,y_m,z_m\n0,0.66,here,-0.28\n");
    for (arguments, words) in [
        ("twin cable fast.csv --out o.csv", ["line 3", "1000.0 m/s"]),
        ("twin cable --specimen steel --out o.csv", ["--specimen steel", "bench, ideal"]),
        ("bench run --speeds 2 --out o.csv", ["--speeds 2", "0.005 to 0.15"]),
        ("track --path way.csv", ["way.csv", "away from the path"]),
        ("track --path bad.csv", ["line 2", "`here`"]),
        ("track --compensation luck", ["--compensation luck", "observer"]),
        ("track --payload 50", ["--payload 50", "0 to 5 kg"]),
        ("track models.xml", ["models.xml", ""]),
    ] {
        bench.refuses(arguments, &words);
    }
}

#[test]
fn an_arm_follows_a_short_path_and_leaves_report_and_record() {
    let bench = Bench::new();
    let run = bench.run("track --duration 11.5 --repeats 1 --report t.html --record t.csv --json");
    assert_eq!(run.code, Some(0), "{}", run.stderr);
    let numbers: serde_json::Value = serde_json::from_str(&run.stdout).unwrap();
    let error = &numbers["tracking"]["observer"]["end_point_error_m"];
    assert!(error["mean"].as_f64().unwrap() < 6e-3, "{error}");
    assert!(error["max"].as_f64().unwrap() < 25e-3, "{error}");
    assert!(bench.read("t.html").contains("simulated data"));
    assert!(bench.read("t.csv").lines().nth(1).unwrap().contains("anchor_n:brachialis"));
}
