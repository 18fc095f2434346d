//! Simulation from the command line: bench logs, one cable, tracking with the arm.

use crate::bench::Bench;

#[test]
fn a_bench_run_writes_a_log_that_says_it_is_simulated_and_the_same_seed_the_same_bytes() {
    let bench = Bench::new();
    for file in ["a.csv", "b.csv"] {
        let run = bench.run(&format!("twin bench --speeds 0.08 --duration 8 --seed 3 --out {file}"));
        assert_eq!(run.code, Some(0), "{}", run.stderr);
    }
    let log = bench.read("a.csv");
    assert!(log.starts_with("# SIMULATED") && log.contains("time_s,trial,tension_in_n"));
    assert_eq!(log.lines().count(), 2 + 8000);
    assert_eq!(log, bench.read("b.csv"));
    let run = bench
        .run("twin bench --muscle active --speeds 0.08 --duration 8 --compensation none --json --out c.csv");
    assert!(run.stdout.contains("far_rmse_n"), "{}", run.stdout);
    // Active strokes only: no stroke has the other direction.
    assert!(bench.read("c.csv").lines().skip(2).all(|line| !line.ends_with(",-1")));
}

#[test]
fn one_cable_is_moved_as_prescribed_by_a_table_and_drawn() {
    let bench = Bench::new();
    bench.write("pull.csv", "time_s,motor_m,anchor_m\n0,0,0\n0.5,0.02,0\n1,0.02,0\n");
    let run = bench.run("twin cable pull.csv --out log.csv --picture cable.svg");
    assert_eq!(run.code, Some(0), "{}", run.stderr);
    assert_eq!(bench.read("log.csv").lines().count(), 2 + 1000);
    assert!(bench.read("cable.svg").contains("simulated data"));
    bench.write("rip.csv", "time_s,motor_m,anchor_m\n0,0,0\n2,0.4,0\n");
    let run = bench.run("twin cable rip.csv --out rip_log.csv");
    assert!(run.stdout.contains("the cable broke at 0.8"), "{}", run.stdout);
    assert_eq!(run.code, Some(3), "a cable that broke is not as asked");
    assert!(bench.read("rip_log.csv").lines().last().unwrap().contains("the cable broke at 0.8"));
}

#[test]
fn an_infeasible_or_malformed_motion_is_refused_with_its_place() {
    let bench = Bench::new();
    bench.write("fast.csv", "time_s,motor_m,anchor_m\n0,0,0\n0.001,1,0\n");
    bench.write("way.csv", "time_s,x_m,y_m,z_m\n0,0.66,0.23,-0.28\n5,3,0,0\n");
    bench.write("bad.csv", "time_s,x_m,y_m,z_m\n0,0.66,here,-0.28\n");
    let header = "time_s,x_m,y_m,z_m\n";
    bench.write("twice.csv", "time_s,x_m,x_m,y_m,z_m\n0,0.6,0.6,0.1,-0.1\n");
    bench.write("again.csv", format!("{header}1,0.6,0.1,-0.15\n1,0.6,0.1,-0.15\n"));
    bench.write("long.csv", format!("{header}1,0.6,0.1,-0.15\n4000,0.6,0.1,-0.15\n"));
    bench.write("open.csv", format!("{header}0,0.6,0.1,-0.15\n2,0.6,0.15,-0.15\n"));
    bench.write("jolt.csv", format!("{header}0,0.6,0.1,-0.15\n0.01,0.6,0.102,-0.15\n2,0.6,0.102,-0.15\n"));
    bench.write("unknown.csv", "time_s,elbow\n0,1.2\n2,1.3\n");
    bench.write("timeless.csv", "elbow_flexion,wrist_flexion\n1.2,0\n1.3,0\n");
    bench.write("word.csv", "time_s,elbow_flexion\n0,1.2\n2,bent\n");
    bench.write("back.csv", "time_s,elbow_flexion\n1,1.2\n0.5,1.3\n");
    bench.write("one.csv", "time_s,elbow_flexion\n1,1.2\n");
    bench.write("poses.csv", "time_s,elbow_flexion\n0,1.2\n2,1.3\n");
    for (arguments, words) in [
        ("twin cable fast.csv --out o.csv", ["line 3", "at most 5 m/s, got 1000"]),
        ("track --path bad.csv", ["line 2", "`here`"]),
        ("track --path twice.csv", ["line 1, column `x_m`", "got it twice"]),
        ("track --path again.csv", ["line 3", "expected more than 1"]),
        ("track --path long.csv", ["line 3", "at most 3600 s"]),
        ("track --path open.csv --repeats 2", ["--repeats 2", "end where it begins"]),
        ("track --path open.csv --duration 9", ["--duration 9", "their own times"]),
        ("track --path joints:none.csv", ["none.csv: cannot be read", "No such file"]),
        ("track --path none.csv", ["none.csv: cannot be read", "No such file"]),
        ("track --path sadle", ["--path sadle", "sine, saddle, tour, to:X,Y,Z"]),
        (
            "track --path to-joints:elbow=1",
            ["to-joints:elbow=1", "expected the name of a joint: shoulder_flexion"],
        ),
        (
            "track --path joints:unknown.csv",
            ["line 1, column `elbow`", "independent joint: shoulder_flexion"],
        ),
        ("track --path joints:timeless.csv", ["line 1: expected a column `time_s`", "elbow_flexion"]),
        ("track --path joints:word.csv", ["line 3, column `elbow_flexion`", "`bent`"]),
        ("track --path joints:back.csv", ["line 3, column `time_s`", "more than 1"]),
        ("track --path joints:one.csv", ["one.csv", "at least 2 poses, got 1"]),
        ("track --path joints:poses.csv --duration 9", ["--duration 9", "their own times"]),
        ("track --path to:0.6,0.2,-0.2 --repeats 2", ["--repeats 2", "end where it begins"]),
        ("track --report t.csv --record t.csv", ["t.csv", "two results"]),
        ("track models.xml", ["models.xml", "cannot be read"]),
        (
            "track way.csv",
            ["way.csv", "expected a machine or robot file ending in .toml, .xml, .urdf or .osim"],
        ),
    ] {
        bench.refuses(arguments, &words);
    }
    for (arguments, words) in [
        ("track --path way.csv", ["way.csv", "target unreachable"]),
        ("track --path to:3,0,0", ["to:3,0,0", "lies outside of the workspace"]),
        ("track --path jolt.csv", ["jolt.csv", "what its drive gives"]),
        ("track --duration 2", ["the winch of `brachialis`", "0.082 m/s"]),
        (
            "track --path to-joints:elbow_flexion=3",
            ["`elbow_flexion` must be within", "but the reference is"],
        ),
    ] {
        bench.declines(arguments, &words);
    }
    bench.fails("track --report no/where.html", &["no/where.html", "no folder no"]);
}

#[test]
fn a_value_outside_its_domain_is_refused_with_the_valid_ones() {
    let bench = Bench::new();
    for (arguments, words) in [
        ("twin cable --specimen steel --out o.csv", ["'steel' for '--specimen", "bench, ideal"]),
        ("twin bench --duration -3 --out o.csv", ["'-3' for '--duration", "expected 1 to 3600 s"]),
        ("twin bench --speeds 0.1,2 --out o.csv", ["'2' for '--speeds", "0.005 to 0.15"]),
        (
            "twin bench --compensation perfect --out o.csv",
            ["'perfect'", "none, capstan, paper, inverted, observer]"],
        ),
        ("design drive --tension -5 --speed 0.1 --acceleration 3 --stroke 0.4", ["--tension", "'-5'"]),
        ("track --path to:0.6,0.2", ["'to:0.6,0.2'", "three numbers within"]),
        ("track --path to:0.6,0.2,nan", ["'to:0.6,0.2,nan'", "three numbers within"]),
        ("track --path to-joints:elbow_flexion", ["'to-joints:elbow_flexion'", "JOINT=VALUE"]),
        ("track --compensation luck", ["'luck' for '--compensation", "no_disturbance_observer, observer,"]),
        ("track --payload 500", ["'500' for '--payload", "0 to 100 kg"]),
        ("track --repeats 0", ["'0' for '--repeats", "1..=100"]),
        ("track --hold 1e4", ["'1e4' for '--hold", "0 to 3600 s"]),
        ("track --fault gearbox:triceps@5", ["'gearbox:triceps@5' for '--fault", "joint-encoder"]),
        ("completions tcsh", ["'tcsh'", "bash, elvish, fish, powershell, zsh"]),
    ] {
        bench.refuses_usage(arguments, &words);
    }
}

// One run for all of it: the calibration of the arm's cables takes most of the time.
#[test]
fn an_arm_tracks_waypoints_with_a_payload_stops_at_a_repeated_one_and_writes_report_and_record() {
    let bench = Bench::new();
    bench.write(
        "points.csv",
        "\u{feff}\"time_s\";x_m;y_m;z_m\r\n0;0.60;0.10;-0.15\r\n1.5;0.64;0.15;-0.20\r\n3;0.64;0.15;-0.20\r\n",
    );
    let run = bench.run("track --path points.csv --payload 0.3 --record run.csv --report run.html --json");
    assert_eq!(run.code, Some(0), "{}", run.stderr);
    let numbers: serde_json::Value = serde_json::from_str(&run.stdout).unwrap();
    let tracked = &numbers["tracking"]["observer"];
    let error = &tracked["end_point_error_m"];
    assert!(tracked["stopped_s"].is_null() && error["mean"].as_f64().unwrap() < 6e-3, "{tracked}");
    assert!(error["max"].as_f64().unwrap() < 25e-3, "{error}");
    let page = bench.read("run.html");
    assert!(page.contains("simulated data"));
    assert!(page.contains("3 s, once, payload 0.3 kg, compensation observer"));
    let table = bench.read("run.csv");
    let mut rows = table.lines().filter(|line| !line.starts_with('#'));
    let header: Vec<&str> = rows.next().unwrap().split(',').collect();
    let column = |name: &str| header.iter().position(|column| *column == name).unwrap();
    let (time, x, length) =
        (column("time_s"), column("end_point_reference_x_m"), column("length_m:brachialis"));
    assert!(header.contains(&"tension_out_n:brachialis"));
    let row = |line: &str| line.split(',').map(|cell| cell.parse().unwrap_or(f64::NAN)).collect::<Vec<f64>>();
    let stop: Vec<Vec<f64>> = rows.map(row).filter(|row| (4.5..6.0).contains(&row[time])).collect();
    assert_eq!(stop.len(), 150, "a row per 10 ms");
    for name in [
        "status",
        "joint_reference_rad:elbow_flexion",
        "joint_estimated_rad:elbow_flexion",
        "command:brachialis",
        "tension_out_estimated_n:brachialis",
        "tension_in_n:brachialis",
    ] {
        assert!(header.contains(&name), "{name}");
    }
    // The report is drawn again from the record, up to its digits.
    bench.succeeds("log plot run.csv --report again.html");
    let (page, again) = (bench.read("run.html"), bench.read("again.html"));
    let plain = |page: &str| page.split("<svg").next().unwrap().to_owned();
    assert_eq!(plain(&page), plain(&again));
    assert_eq!(page.matches("<svg").count(), again.matches("<svg").count());
    bench.refuses("log plot points.csv --report x.html", &["points.csv", "line 1", "--record"]);
    for row in &stop {
        assert!((row[x] - 0.64).abs() < 1e-6, "{row:?}");
        assert!((row[length] - stop[0][length]).abs() < 1e-6, "{row:?}");
    }
}
