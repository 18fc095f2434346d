//! What simulated devices for other masters say of the machine behind them.

use crate::bench::Bench;
use std::io::{BufRead, BufReader, Read};
use std::process::{Command, Stdio};

#[test]
fn the_truth_of_a_machine_behind_a_terminal_is_written_while_another_program_moves_it() {
    let bench = Bench::new();
    let source = sinew_models::BENCH_JOINT;
    let bare = source.replace("[every_transmission]\n", "[every_transmission]\nload_cell = \"none\"\n");
    bench.write("joint.toml", format!("{bare}\n[every_joint_encoder]\nnone = true\n"));
    let simulated = "can simulate joint.toml --pty --truth truth.csv";
    let mut simulated = bench.command(simulated).stdout(Stdio::piped()).spawn().unwrap();
    let mut said = BufReader::new(simulated.stdout.take().unwrap());
    let mut port = String::new();
    said.read_line(&mut port).unwrap();
    // How the run ends does not matter: a busy computer may stop it.
    bench.run(&format!("run joint.toml --bus can --interface {} --duration 3 --unverified", port.trim()));
    let interrupted = Command::new("kill").args(["-INT", &simulated.id().to_string()]).status();
    assert!(interrupted.unwrap().success());
    let mut text = String::new();
    said.read_to_string(&mut text).unwrap();
    assert!(simulated.wait().unwrap().success() && text.contains("truth.csv"), "{text}");
    let truth = bench.read("truth.csv");
    let mut lines = truth.lines();
    assert_eq!(lines.next(), Some("# SIMULATED"));
    let header = lines.next().unwrap();
    let names: Vec<&str> = header.split(',').collect();
    assert_eq!(&names[..2], ["time_s", "joint_true_rad:lever"]);
    assert!(header.contains("tension_out_n:") && header.contains("position_in_m:"), "{header}");
    let rows: Vec<Vec<f64>> =
        lines.map(|line| line.split(',').map(|cell| cell.parse().unwrap()).collect()).collect();
    assert!(rows.len() > 20 && rows.iter().all(|row| row.len() == names.len()), "{}", rows.len());
    assert!(rows.windows(2).all(|pair| (pair[1][0] - pair[0][0] - 0.01).abs() < 2.1e-3));
}

#[test]
fn a_truth_that_cannot_be_written_is_refused_before_anything_answers() {
    let bench = Bench::new();
    bench.fails("servos simulate finger --pty --truth missing/truth.csv", &["missing"]);
    bench.write("finger.toml", sinew_models::BENCH_JOINT);
    bench.refuses(
        "can simulate finger.toml --pty --truth finger.toml",
        &["finger.toml", "is read by this run"],
    );
}
