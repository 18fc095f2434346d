//! A recording whose program is killed.

use crate::common::Setup;
use sinew_record::Recording;
use sinew_runtime::cycle::{CycleRecord, MonotonicClock, Timing, run};
use std::io::{BufRead, BufReader};
use std::path::Path;
use std::process::{Command, Stdio};
use std::sync::atomic::AtomicBool;
use std::time::Duration;

/// Names the file for the test that is the program to be killed.
const FILE: &str = "SINEW_RECORDING_TO_KILL";

#[test]
fn a_program_that_records_until_it_is_killed() {
    let Ok(path) = std::env::var(FILE) else { return };
    let setup = Setup::new("bench_joint", 1);
    let mut recorder = setup.recorder(std::fs::File::create(path).unwrap());
    let (stop, mut timing, mut count) = (AtomicBool::new(false), Timing::new(), 0_u64);
    loop {
        let see = |record: &CycleRecord<'_, _>| {
            recorder.record(record);
            count += 1;
            if count.is_multiple_of(10) {
                // What the killer counts.
                println!("cycle {count}");
            }
            Ok(())
        };
        run(&mut setup.cycle(), &mut MonotonicClock, crate::common::PERIOD, &stop, &mut timing, see).unwrap();
    }
}

#[test]
fn all_but_the_last_second_is_there_whenever_the_program_is_killed() {
    let folder = tempfile::tempdir().unwrap();
    // At once: they mostly wait.
    std::thread::scope(|scope| {
        for k in 0..20_u32 {
            let path = folder.path().join(format!("{k}.mcap"));
            scope.spawn(move || kill(&path, k));
        }
    });
}

/// Kills a recording program at a time that `k` spreads over the phases of a block, and reads what it left.
fn kill(path: &Path, k: u32) {
    let mut child = Command::new(std::env::current_exe().unwrap())
        .args(["--exact", "killed::a_program_that_records_until_it_is_killed", "--nocapture"])
        .env(FILE, path)
        .stdout(Stdio::piped())
        .stderr(Stdio::null())
        .spawn()
        .unwrap();
    let output = BufReader::new(child.stdout.take().unwrap());
    let until = 300 + 137 * u64::from(k);
    let counts = output
        .lines()
        .map_while(Result::ok)
        .filter_map(|line| line.rsplit_once("cycle ").and_then(|(_, count)| count.parse::<u64>().ok()));
    let done = counts.into_iter().find(|count| *count >= until).unwrap();
    std::thread::sleep(Duration::from_millis(u64::from(k % 7)));
    child.kill().unwrap();
    child.wait().unwrap();
    let bytes = std::fs::read(path).unwrap();
    let recording = Recording::read(&bytes).unwrap();
    assert!(!recording.complete);
    let kept: u64 = recording.blocks().map(|block| block.unwrap().count as u64).sum();
    assert!(kept + 1000 > done, "killed after {done} cycles: {kept} are there");
}
