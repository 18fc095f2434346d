//! `sinew calibrate` and what uses its calibration.

use crate::bench::Bench;
use serde_json::Value;

const FLIGHT: &str = "calibrate planar_leg --tolerances rough --poses 8 --check 3 --out out";

#[test]
fn a_rough_leg_is_better_after_a_flight_and_its_tables_are_fitted_again() {
    let bench = Bench::new();
    let run = bench.run(&format!("{FLIGHT} --json"));
    assert_eq!(run.code, Some(0), "{}", run.stderr);
    let flown: Value = serde_json::from_str(&run.stdout).unwrap();
    let mean = |document: &Value, when: &str| document["held_out_error_m"][when]["mean"].as_f64().unwrap();
    assert!(mean(&flown, "after") < 0.5 * mean(&flown, "before"), "{}", flown["held_out_error_m"]);
    let keys: Vec<&String> = flown["parameters"][0].as_object().unwrap().keys().collect();
    assert_eq!(keys, ["name", "value", "sd", "tolerance", "determined"]);
    let held: Vec<&String> = flown["held_out_error_m"].as_object().unwrap().keys().collect();
    assert_eq!(held, ["before", "after", "reported"]);

    let fit =
        "calibrate fit planar_leg out/readings.csv --observations out/observations.csv --tolerances rough";
    let run = bench.run(&format!("{fit} --out fitted --json"));
    assert_eq!(run.code, Some(0), "{}", run.stderr);
    let fitted: Value = serde_json::from_str(&run.stdout).unwrap();
    assert!(mean(&fitted, "after") < 0.5 * mean(&fitted, "before") && fitted["simulated"] == true);

    let wrong = "--marker tip=shank:0,0,-0.25 --base-tag base_1=-0.15,0,0.8 --base-tag base_2=0.15,0,0.8 \
                 --base-tag base_3=0,0.2,0.7";
    let run = bench.run(&format!("{fit} {wrong} --out misplaced"));
    assert_eq!(run.code, Some(3), "{}", run.stderr);
    assert!(run.stdout.contains("do not use") && run.stdout.contains("scatter"), "{}", run.stdout);
    assert!(run.stdout.contains("tip on shank at 0.0000, 0.0000, -0.2500 m; base_1 on "), "{}", run.stdout);

    let misplaced = "track planar_leg --tolerances rough --calibration misplaced/calibration.toml";
    bench.refuses(misplaced, &["misplaced/calibration.toml", "do not use"]);
    let track = "track planar_leg --tolerances rough --unverified --calibration out/calibration.toml";
    let run = bench.run(&format!("{track} --record run.mcap"));
    assert!(matches!(run.code, Some(0 | 3)), "{}", run.stderr);
    let run = bench.run("log replay run.mcap --json");
    assert_eq!(run.code, Some(0), "{} {}", run.stdout, run.stderr);

    let other = bench.run("track finger --calibration out/calibration.toml");
    assert_eq!(other.code, Some(2));
    assert!(other.stderr.contains("machine_hash"), "{}", other.stderr);
}

#[test]
fn what_cannot_be_calibrated_is_refused_by_its_reason() {
    let bench = Bench::new();
    for verb in ["calibrate", "calibrate plan"] {
        let joint = ["`upper_base_abduction` has no encoder"];
        bench.refuses(&format!("{verb} two_finger_hand --out out"), &joint);
    }
    let fit = "calibrate fit planar_leg readings.csv --observations seen.csv --tolerances rough --out out";
    bench.write("readings.csv", "time_s,hip,knee\n0,0.1,0.2\n1,0.1,0.2\n");
    bench.write("seen.csv", "time_s,marker,x_m,y_m,z_m\n0,nose,1,2,3\n");
    let run = bench.run(fit);
    assert_eq!(run.code, Some(2));
    assert!(run.stderr.contains("seen.csv") && run.stderr.contains("nose"), "{}", run.stderr);
    let run = bench.run("calibrate planar_leg --camera-fault fog=1 --tolerances rough --out out");
    assert!(run.code == Some(2) && run.stderr.contains("noise_m"), "{}", run.stderr);
    let run = bench.run("calibrate planar_leg --marker nose=face:0,0,0 --tolerances rough --out out");
    assert!(run.code == Some(2) && run.stderr.contains("body of the machine"), "{}", run.stderr);
}

/// Stamp, marker and coordinates in mm of the rows of a table of observations.
fn sightings(table: &str) -> Vec<(String, String, [String; 3])> {
    let row = |line: &str| {
        let cells: Vec<&str> = line.split(',').collect();
        let millimetres = |cell: &str| format!("{:.3}", 1e3 * cell.parse::<f64>().unwrap());
        (cells[0].to_owned(), cells[1].to_owned(), [2, 3, 4].map(|k| millimetres(cells[k])))
    };
    table.lines().skip(2).map(row).collect()
}

#[test]
fn files_of_other_programs_give_the_calibration_of_the_table_with_their_numbers() {
    let bench = Bench::new();
    bench.succeeds("calibrate bench_joint --tolerances rough --poses 6 --check 2 --out out");
    let seen = sightings(&bench.read("out/observations.csv"));
    let names = ["tip", "base_1", "base_2", "base_3", "nose"];
    let mut table = "time_s,marker,x_m,y_m,z_m\n".to_owned();
    let mut rows: Vec<(&str, [String; 5])> = Vec::new();
    for (time, marker, place) in &seen {
        let place = place.join(",");
        table += &format!("{time},{marker},{place}\n");
        if rows.last().is_none_or(|row| row.0 != time.as_str()) {
            rows.push((time.as_str(), [const { String::new() }; 5]));
        }
        let column = names.iter().position(|name| name == marker).unwrap();
        rows.last_mut().unwrap().1[column] = place;
    }
    let columns = |row: &[String; 5], separator: &str| {
        let gap = ",,".to_owned();
        let cells = row.iter().map(|place| if place.is_empty() { &gap } else { place });
        cells.map(|place| place.replace(',', separator)).collect::<Vec<_>>().join(separator)
    };
    let frames = rows.len();
    let mut trc = format!(
        "PathFileType\t4\t(X/Y/Z)\tseen.trc\nNumFrames\tNumMarkers\tUnits\n{frames}\t5\tmm\nFrame#\tTime\t{}\n\t\t{}\n",
        names.join("\t\t\t"),
        (1..=5).map(|k| format!("X{k}\tY{k}\tZ{k}")).collect::<Vec<_>>().join("\t"),
    );
    let mut motive = format!(
        "Format Version,1.23,Total Exported Frames,{frames},Length Units,Millimeters,Coordinate Space,Global\n\n\
         ,Type{}\n,Name{}\n,,{}\nFrame,Time (Seconds){}\n",
        ",Marker".repeat(15),
        names.map(|name| format!(",{name}").repeat(3)).concat(),
        ["Position"; 15].join(","),
        ",X,Y,Z".repeat(5),
    );
    for (k, (time, row)) in rows.iter().enumerate() {
        trc += &format!("{}\t{time}\t{}\n", k + 1, columns(row, "\t"));
        motive += &format!("{k},{time},{}\n", columns(row, ","));
    }
    bench.write("table", table);
    // Their names tell nothing.
    bench.write("trc.csv", &trc);
    bench.write("motive.txt", motive);
    let fit = |observations: &str| {
        let outcome = bench.run(&format!(
            "calibrate fit bench_joint out/readings.csv --tolerances rough --out fitted --json --observations {observations}"
        ));
        assert_eq!(outcome.code, Some(0), "{}", outcome.stderr);
        let document: Value = serde_json::from_str(&outcome.stdout).unwrap();
        (document["held_out_error_m"].clone(), document["parameters"].clone(), outcome.stderr)
    };
    let (held, parameters, stderr) = fit("table --unit 0.001");
    assert!(stderr.is_empty(), "{stderr}");
    for file in ["trc.csv", "motive.txt", "motive.txt --unit 0.001"] {
        let (again, found, stderr) = fit(file);
        assert_eq!((&again, &found), (&held, &parameters), "{file}");
        assert!(stderr.contains("are ignored: nose"), "{stderr}");
    }

    let fit = "calibrate fit bench_joint out/readings.csv --tolerances rough --out no --observations";
    bench.refuses(&format!("{fit} trc.csv --unit 1"), &["--unit 1", "0.001", "trc.csv", "mm"]);
    bench.refuses(
        &format!("{fit} table --unit 0.001 --marker hand=lever:0,0,0"),
        &["the markers hand", "base_1", "tip"],
    );
    bench.refuses(&format!("{fit} table --unit 0.001 --clock 1000"), &["--clock", "-999.9"]);
    bench.refuses(
        &format!("{fit} table"),
        &["observations", "the unit of the observations is m", "times as far"],
    );
    let in_ms = |line: &str| {
        let (time, rest) = line.split_once(',').unwrap();
        time.parse::<f64>().map_or_else(|_| line.to_owned(), |time| format!("{},{rest}", 1e3 * time))
    };
    let table: String = bench.read("table").lines().map(|line| in_ms(line) + "\n").collect();
    bench.write("in_ms", table);
    bench.refuses(&format!("{fit} in_ms --unit 0.001"), &["stamps in s", "1000 times", "ms"]);
    bench.write("cut.trc", &trc[..trc.len() / 2]);
    bench.refuses(&format!("{fit} cut.trc"), &["cut.trc: line"]);

    let tips = |line: &&str| !line.contains("base_");
    let table: String = bench.read("table").lines().filter(tips).map(|line| format!("{line}\n")).collect();
    bench.write("tips", table);
    let outcome = bench.run(&format!("{fit} tips --unit 0.001 --json"));
    assert!(
        matches!(outcome.code, Some(0 | 3)) && outcome.stdout.contains("no marker on the base"),
        "{}",
        outcome.stderr
    );
}

#[test]
fn without_a_camera_lengths_and_torques_judge_and_the_file_is_used() {
    let bench = Bench::new();
    let given = "shoulder --no-camera --tolerances rough";
    let run = bench.run(&format!("calibrate {given} --poses 10 --check 3 --out out --json"));
    assert_eq!(run.code, Some(0), "{} {}", run.stdout, run.stderr);
    let flown: Value = serde_json::from_str(&run.stdout).unwrap();
    assert!(flown.get("held_out_error_m").is_none());
    let mean =
        |document: &Value, of: &str, when: &str| document["held_out"][of][when]["mean"].as_f64().unwrap();
    for of in ["length_m", "torque_nm"] {
        assert!(mean(&flown, of, "after") < mean(&flown, of, "before"), "{}", flown["held_out"]);
    }
    let run = bench
        .run("calibrate fit shoulder out/readings.csv --no-camera --tolerances rough --out again --json");
    assert!(matches!(run.code, Some(0 | 3)), "{}", run.stderr);
    let fitted: Value = serde_json::from_str(&run.stdout).unwrap();
    assert!(mean(&fitted, "length_m", "after") <= mean(&fitted, "length_m", "before"));
    assert_eq!(fitted["places"], flown["places"]);

    let track =
        "track shoulder --tolerances rough --unverified --duration 10 --calibration out/calibration.toml";
    let run = bench.run(&format!("{track} --record run.mcap"));
    assert!(matches!(run.code, Some(0 | 3)), "{}", run.stderr);
    let run = bench.run("log replay run.mcap --json");
    assert_eq!(run.code, Some(0), "{} {}", run.stdout, run.stderr);
    // A motion without rests tells nothing, and is refused by that reason.
    bench.refuses(
        "calibrate fit shoulder run.mcap --no-camera --tolerances rough --out none",
        &["places", "at rest"],
    );
    bench.write("few.csv", "time_s,abduction\n0,0\n1,0\n");
    bench.refuses(
        "calibrate fit shoulder few.csv --no-camera --tolerances rough --out none",
        &["few.csv", "column"],
    );
}

#[test]
fn where_lengths_or_torques_are_not_better_the_exit_code_says_so() {
    let bench = Bench::new();
    let given = "bench_joint --no-camera --tolerances careful --poses 10 --check 3 --out out --json";
    let run = bench.run(&format!("calibrate {given}"));
    let document: Value = serde_json::from_str(&run.stdout).unwrap();
    let missed = |of: &str| {
        let mean = |when: &str| document["held_out"][of][when]["mean"].as_f64().unwrap();
        mean("after") < mean("before")
    };
    let better = missed("length_m") && missed("torque_nm");
    assert_eq!(run.code, Some(if better { 0 } else { 3 }));
    assert_eq!(document["verdict"] == "do not use", !better);
}
