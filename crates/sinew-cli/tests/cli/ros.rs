//! `sinew run --ros`: what cannot be asked for together, and the run on a node. What others see of it:
//! `python/tests/test_ros.py`.

use crate::bench::{Bench, Outcome, ended};

#[test]
fn what_cannot_be_asked_for_with_ros_is_refused_with_the_reason() {
    let bench = Bench::new();
    bench.refuses_usage("run planar_leg --ros-commands", &["--ros"]);
    bench.refuses_usage("run planar_leg --ros-domain 3", &["--ros"]);
    bench.refuses_usage("run planar_leg --ros --ros-domain 233", &["233", "0..=232"]);
    bench.refuses_usage(
        "run planar_leg --ros --ros-commands --link 127.0.0.1:0",
        &["--ros-commands", "--link", "cannot be used with"],
    );
    bench.refuses("run planar_leg --until 3", &["--until", "--link or --ros-commands"]);
    if !cfg!(feature = "ros") {
        bench.refuses("run planar_leg --ros", &["built with the feature ros"]);
        return;
    }
    bench.refuses("run planar_leg --ros --virtual-time", &["--ros", "sinew log export --to ros2"]);
    for value in ["x", "-1", "233"] {
        let mut command = bench.command("run planar_leg --ros");
        let outcome = Outcome::from(command.env("ROS_DOMAIN_ID", value).output().unwrap());
        ended(2, value, &outcome, &["ROS_DOMAIN_ID", value, "0 to 232"]);
    }
}

#[test]
#[cfg(feature = "ros")]
fn a_run_that_others_command_holds_until_its_time_and_replays() {
    let bench = Bench::new();
    let motion = "--path to-joints:hip=0.8,knee=1.6 --duration 3 --unverified --json";
    let domain = 100 + std::process::id() % 100;
    let asked = format!("--ros --ros-commands --ros-domain {domain} --until 1 --record run.mcap");
    let run = bench.run(&format!("run planar_leg {motion} {asked}"));
    if run.code == Some(1) {
        eprintln!("skipped: DDS does not start on this machine: {}", run.stderr);
        return;
    }
    assert_eq!(run.code, Some(0), "{}", run.stderr);
    assert!(run.stderr.contains("ROS 2: SIMULATED machine planar_leg on 127.0.0.1"), "{}", run.stderr);
    let report: serde_json::Value = serde_json::from_str(&run.stdout).unwrap();
    assert_eq!(report["run"]["ended"], "as_planned");
    // A busy computer may miss some of them.
    let states = ["published", "missed"].map(|key| report["ros"][key].as_u64().unwrap());
    assert_eq!(states.iter().sum::<u64>(), 500);
    assert_eq!((&report["ros"]["taken"], &report["ros"]["failed"]), (&0.into(), &false.into()));
    let replayed: serde_json::Value =
        serde_json::from_str(&bench.run("log replay run.mcap --json").stdout).unwrap();
    assert_eq!(replayed["exit_code"], 0, "{replayed}");
}
