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

/// A plant as a unit holds it, its inputs, and what the library says of it: every row the outputs.
struct Expected {
    file: String,
    inputs: fn(usize) -> Vec<f64>,
    rows: Vec<Vec<f64>>,
}

const STEPS: usize = 400;

fn cable() -> Expected {
    use sinew::transmission::{Sliding, cable::EndMotion};
    use sinew::twin::cable::{CablePlant, Resolution, Specimen};
    let inputs = |k: usize| vec![0.02 * (0.02 * k as f64).sin(), 0.015 * (0.02 * k as f64).sin()];
    let mut plant = CablePlant::new(&Specimen::draw(3), Resolution::default()).unwrap();
    plant.settle(40.0, Sliding::TowardMotor).unwrap();
    let said = |reading: sinew::twin::cable::CableReading| {
        vec![reading.tension_in, reading.tension_out, reading.stretch, 0.0]
    };
    let mut rows = vec![said(plant.clone().step(1e-3, EndMotion::default()).unwrap())];
    let mut before = vec![0.0; 2];
    for k in 0..STEPS {
        let now = inputs(k);
        let motion = EndMotion { motor: now[0] - before[0], anchor: now[1] - before[1] };
        rows.push(said(plant.step(1e-3, motion).unwrap()));
        before = now;
    }
    Expected { file: r#"{"cable":{"specimen":"3","start_n":40.0}}"#.to_owned(), inputs, rows }
}

fn joint() -> Expected {
    use sinew::control::arm::{resting_tensions, synthesize};
    use sinew::drive::DriveCommand;
    use sinew::twin::arm::{ArmSpecimen, ArmTwin};
    let inputs = |k: usize| vec![0.02 * (0.03 * k as f64).sin(), -0.02 * (0.03 * k as f64).sin()];
    let text = sinew_models::BENCH_JOINT;
    let machine = sinew_lab::machine_file::load_machine(Path::new("bench_joint"), None).unwrap().machine;
    let design = ArmSpecimen::nominal(&machine).unwrap();
    let models = sinew_lab::experiment::oracle_models(&design);
    let (gains, _) = synthesize(&machine, &models, std::slice::from_ref(&machine.start)).unwrap();
    let specimen = ArmSpecimen::sampled_around(&design, &machine, 5).unwrap();
    let tensions = resting_tensions(&specimen.robot, &machine.start, &gains.tension_limits()).unwrap();
    let mut arm = ArmTwin::new(&specimen, &machine.start, &tensions, 5).unwrap();
    let said = |arm: &ArmTwin, read: bool| -> Vec<f64> {
        let (reading, truth) = (arm.reading(), arm.truth());
        let of = |x: f64| if read { x } else { f64::NAN };
        let muscles =
            (0..2).flat_map(|m| [of(reading.motor[m]), of(reading.tension[m]), truth.cables[m].tension_out]);
        muscles.chain([of(reading.joint[0]), truth.q[0], truth.v[0], 0.0, 0.0]).collect()
    };
    let mut rows = vec![said(&arm, false)];
    for k in 0..STEPS {
        let commands: Vec<DriveCommand> = inputs(k).into_iter().map(DriveCommand::Velocity).collect();
        arm.step(&commands, 1e-3).unwrap();
        rows.push(said(&arm, true));
    }
    let source = serde_json::json!({"path": "bench_joint", "texts": [{"role": "main", "text": text}]});
    let file = serde_json::json!({"machine": {"source": source, "seed": 5}}).to_string();
    Expected { file, inputs, rows }
}

fn bits(rows: &[Vec<f64>]) -> Vec<u64> {
    rows.iter().flatten().map(|x| x.to_bits()).collect()
}

#[test]
fn the_process_of_a_unit_says_the_library_s_numbers_and_refuses_a_bad_step() {
    use std::io::{Read, Write};
    let bench = Bench::new();
    for Expected { file, inputs, rows } in [cable(), joint()] {
        bench.write("plant.json", &file);
        let mut command = bench.command("export serve plant.json");
        command.stdin(std::process::Stdio::piped()).stdout(std::process::Stdio::piped());
        let mut process = command.spawn().unwrap();
        let (mut to, mut from) = (process.stdin.take().unwrap(), process.stdout.take().unwrap());
        let width = rows[0].len();
        let mut listen = || {
            let mut bytes = vec![0; 8 * (1 + width)];
            from.read_exact(&mut bytes).unwrap();
            let mut numbers = bytes.as_chunks::<8>().0.iter().map(|number| f64::from_ne_bytes(*number));
            (numbers.next().unwrap(), numbers.collect::<Vec<f64>>())
        };
        let mut ask = |seconds: f64, k: usize| {
            let numbers = [seconds].into_iter().chain(inputs(k));
            to.write_all(&numbers.flat_map(f64::to_ne_bytes).collect::<Vec<u8>>()).unwrap();
        };
        let mut got = vec![listen().1];
        for k in 0..STEPS {
            for bad in [0.0, -1.0, f64::NAN, 1e9] {
                ask(bad, k);
                assert!(listen().0 > 0.0);
            }
            ask(1e-3, k);
            let (refused, row) = listen();
            assert!(refused < 0.5, "{k}");
            got.push(row);
        }
        assert!(bits(&got) == bits(&rows), "{file}");
        drop(to);
        assert!(process.wait().unwrap().success());
    }
}

/// Validates a unit, runs ten of its instances side by side, and prints the outputs of the last.
const FMPY: &str = r#"
import shutil, sys
import numpy as np
import fmpy
from fmpy.validation import validate_fmu
path, steps = sys.argv[1], int(sys.argv[2])
assert not validate_fmu(path), validate_fmu(path)
description = fmpy.read_model_description(path)
folder = fmpy.extract(path)
inputs = [v.valueReference for v in description.modelVariables if v.causality == "input"]
outputs = [v for v in description.modelVariables if v.causality == "output"]
numbers = [v.valueReference for v in outputs if v.type != "Boolean"]
rows = np.frombuffer(sys.stdin.buffer.read()).reshape(steps, len(inputs))
units = [fmpy.instantiate_fmu(folder, description, "CoSimulation") for _ in range(10)]
three = description.fmiVersion == "3.0"
get = lambda unit: unit.getFloat64(numbers) if three else unit.getReal(numbers)
put = lambda unit, row: unit.setFloat64(inputs, row) if three else unit.setReal(inputs, row)
said = []
for unit in units:
    if not three:
        unit.setupExperiment(startTime=0.0)
    unit.enterInitializationMode()
    unit.exitInitializationMode()
for k in range(steps + 1):
    said += get(units[-1])
    if k % 100 == 50:
        # The last one goes another way and comes back.
        state = units[-1].getFMUState()
        put(units[-1], np.full(len(inputs), 0.01))
        for j in range(5):
            units[-1].doStep((k + j) / 1000, 1 / 1000)
        units[-1].setFMUState(state)
        # Written, read and gone on with by the one before it, which was at another place.
        saved = units[-1].serializeFMUState(state)
        units[-1].freeFMUState(state)
        units[-2].doStep(k / 1000, 1 / 1000)
        state = units[-2].deserializeFMUState(saved)
        units[-2].setFMUState(state)
        assert units[-2].serializeFMUState(state) == saved
        units[-2].freeFMUState(state)
    if k < steps:
        for unit in units:
            put(unit, rows[k])
            unit.doStep(k / 1000, 1 / 1000)
assert all(np.array_equal(get(unit), get(units[0]), equal_nan=True) for unit in units)
for unit in units:
    unit.terminate()
    unit.freeInstance()
shutil.rmtree(folder)
sys.stdout.buffer.write(np.array(said, float).tobytes())
"#;

#[test]
fn units_of_plants_simulate_the_library_s_numbers_in_fmpy() {
    let python = std::env::var_os("SINEW_PYTHON").unwrap_or_else(|| "python3".into());
    let has = Command::new(&python).args(["-c", "import fmpy"]).output();
    if !compiler() || !has.is_ok_and(|output| output.status.success()) {
        eprintln!("skipped: no Python with fmpy");
        return;
    }
    let bench = Bench::new();
    let program = Path::new(env!("CARGO_BIN_EXE_sinew")).parent().unwrap();
    let path = std::env::join_paths(
        [program.to_owned()].into_iter().chain(std::env::split_paths(&std::env::var_os("PATH").unwrap())),
    );
    let path = path.unwrap();
    for (verb, expected) in [("twin --specimen 3", cable()), ("machine bench_joint --seed 5", joint())] {
        for form in ["fmu", "fmu2"] {
            bench.succeeds(&format!("export {verb} --to {form} --out {form} --name plant"));
            let rows: Vec<u8> = (0..STEPS).flat_map(expected.inputs).flat_map(f64::to_ne_bytes).collect();
            bench.write("rows", rows);
            let mut command = Command::new(&python);
            command.args(["-c", FMPY]).arg(bench.path(&format!("{form}/plant.fmu"))).arg(STEPS.to_string());
            command.env("PATH", &path).stdin(std::fs::File::open(bench.path("rows")).unwrap());
            let output = command.output().unwrap();
            assert!(output.status.success(), "{}", String::from_utf8_lossy(&output.stderr));
            let got = output.stdout.as_chunks::<8>().0.iter().map(|x| f64::from_ne_bytes(*x));
            // Flags are no numbers.
            let flags = if verb.starts_with("twin") { 1 } else { 2 };
            let numbers = expected.rows.iter().flat_map(|row| &row[..row.len() - flags]);
            let worst = got.zip(numbers).filter(|(a, b)| a.to_bits() != b.to_bits()).count();
            assert_eq!(worst, 0, "{verb} {form}");
            assert_eq!(output.stdout.len(), 8 * (STEPS + 1) * (expected.rows[0].len() - flags));
        }
    }
}

#[test]
fn plants_that_cannot_be_exported_are_one_error_and_leave_nothing() {
    let bench = Bench::new();
    bench.write("bad.json", r#"{"cable":{"specimen":"x","start_n":40.0}}"#);
    for (arguments, parts) in [
        ("export machine nowhere.toml --to fmu --out d", vec!["nowhere.toml"]),
        ("export twin --to fmu --out d --name 7up", vec!["`7up`", "C identifier"]),
        ("export twin --to fmu --out d --start -5", vec!["tension_out", "-20.5"]),
        ("export serve bad.json", vec!["specimen", "x"]),
        ("export serve none.json", vec!["none.json"]),
    ] {
        bench.refuses(arguments, &parts);
    }
    bench.refuses_usage("export twin --to c --out d", &["fmu, fmu2"]);
    bench.refuses_usage("export machine --to fmu --out d", &["MACHINE"]);
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
