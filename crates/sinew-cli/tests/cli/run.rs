//! `sinew run` and `sinew ethercat`.

use crate::bench::Bench;
use serde_json::Value;

fn tracking(document: &str) -> Value {
    serde_json::from_str::<Value>(document).unwrap()["tracking"].clone()
}

#[test]
fn a_run_on_virtual_time_is_the_simulation_of_track_to_the_bit() {
    let bench = Bench::new();
    let motion = "planar_leg --path to-joints:hip=0.4,knee=1.0 --duration 3 --hold 1 --json";
    let tracked = bench.succeeds(&format!("track {motion}")).stdout;
    let run = bench.succeeds(&format!("run {motion} --bus twin --virtual-time")).stdout;
    assert_eq!(tracking(&tracked), tracking(&run));
    assert!(run.contains("\"simulated\":true"), "{run}");
}

#[test]
fn a_run_behind_simulated_devices_ends_as_planned_and_reports_its_bus() {
    let bench = Bench::new();
    let motion = "planar_leg --path to-joints:hip=0.4,knee=1.0 --duration 3 --hold 1 --json";
    let run = bench.succeeds(&format!("run {motion} --bus segment --virtual-time")).stdout;
    let document: Value = serde_json::from_str(&run).unwrap();
    let bus = &document["bus"];
    assert!(bus["exchanges"].as_u64().unwrap() > 6000, "{bus}");
    for counter in ["lost", "devices_missing", "device_not_ready", "drive_faults"] {
        assert_eq!(bus[counter], 0, "{counter}");
    }
}

#[test]
fn what_currents_have_told_of_the_gears_stands_in_text_document_report_and_record() {
    let bench = Bench::new();
    let machine = sinew_models::BENCH_JOINT;
    let without = machine.replace("[every_transmission]\n", "[every_transmission]\nload_cell = \"none\"\n");
    assert_ne!(machine, without);
    bench.write("without.toml", without);
    let motion = "--path to-joints:lever=0.3 --duration 3 --hold 0";
    // What is not there cannot fail.
    let fault = "--fault load-cell:front:lost@1";
    bench.refuses(&format!("track without.toml {motion} {fault}"), &["muscle with a load cell"]);
    let document = bench.succeeds(&format!("track without.toml {motion} --json")).stdout;
    let document: Value = serde_json::from_str(&document).unwrap();
    let gears = document["gears"].as_array().unwrap();
    assert_eq!(
        gears.iter().map(|gear| gear["muscle"].as_str().unwrap()).collect::<Vec<_>>(),
        ["front", "back"]
    );
    for of in gears.iter().flat_map(|gear| [&gear["efficiency"], &gear["friction_nm"]]) {
        let [value, low, high] = ["value", "low", "high"].map(|key| of[key].as_f64().unwrap());
        assert!(0.0 < low && low < value && value < high, "{of}");
    }
    let text = bench.succeeds(&format!("track without.toml {motion} --report a.html --record a.csv")).stdout;
    assert!(text.contains("gear, by its currents (95 %)"), "{text}");
    bench.succeeds("log plot a.csv --report b.html");
    let table = |page: &str| {
        let page = bench.read(page);
        let section = page.split("<section id=\"gears\">").nth(1).expect("a section");
        section.split("</section>").next().unwrap().to_owned()
    };
    assert!(table("a.html").contains("front") && table("a.html") == table("b.html"));
    assert!(!bench.succeeds(&format!("track bench_joint {motion}")).stdout.contains("gear"));
    let paper = format!("track without.toml {motion} --compensation paper");
    bench.refuses(&paper, &["`paper`", "a load cell at every drive", "none of `front`"]);
}

#[test]
fn devices_of_a_simulated_bus_are_those_of_their_files() {
    let bench = Bench::new();
    bench.write("drive.toml", sinew_segment::builtin::DRIVE_TOML);
    let esi = "<EtherCATInfo><Vendor><Id>#x777</Id></Vendor><Descriptions><Devices><Device><Type \
               ProductCode='#x99' \
               RevisionNo='1'>OTHER</Type></Device></Devices></Descriptions></EtherCATInfo>";
    bench.write("other.xml", esi);
    let run = "run planar_leg --path to-joints:hip=0.4 --duration 2 --hold 0.5 --virtual-time --json";
    let own = bench.succeeds(&format!("{run} --bus segment")).stdout;
    let described = bench.succeeds(&format!("{run} --bus segment --device drive.toml")).stdout;
    assert_eq!(own, described, "the built-in drive, read from its file");
    let other = format!("{run} --bus segment --device other.xml");
    bench.refuses(&other, &["other.xml", "none of its 1 devices", "0x51e37:"]);
    bench
        .refuses(&format!("{run} --bus twin --device drive.toml"), &["--device drive.toml", "--bus segment"]);
    // A drive that lacks an object is refused before anything moves.
    let lacking = sinew_segment::builtin::DRIVE_TOML.replace("0x60ff", "0x60fe");
    bench.write("lacking.toml", lacking);
    bench.refuses(&format!("{run} --bus segment --device lacking.toml"), &["lacking.toml"]);
    bench.refuses(&format!("{run} --bus segment --device missing.xml"), &["missing.xml: cannot be read"]);
}

#[test]
fn an_interface_that_does_not_exist_is_named_with_those_that_do() {
    let bench = Bench::new();
    for arguments in [
        "ethercat scan planar_leg --interface nosuch0",
        "ethercat simulate planar_leg --interface nosuch0",
        "run planar_leg --bus ethercat --interface nosuch0 --path to-joints:hip=0.4 --duration 3",
    ] {
        let outcome = bench.run(arguments);
        assert_eq!(outcome.code, Some(2), "{arguments}: {}", outcome.stderr);
        assert!(
            outcome.stderr.contains("`nosuch0`") && outcome.stderr.contains("there are:"),
            "{}",
            outcome.stderr
        );
    }
}

#[test]
fn what_only_a_simulated_machine_can_do_is_refused_on_devices() {
    let bench = Bench::new();
    let run = "run planar_leg --bus ethercat --interface lo";
    for (more, expected) in [
        (" --fault drive:hamstrings@4", "simulated bus only"),
        (" --compensation capstan", "simulated bus only"),
        (" --virtual-time", "--virtual-time"),
    ] {
        let outcome = bench.run(&format!("{run}{more}"));
        assert_eq!(outcome.code, Some(2), "{more}: {}", outcome.stderr);
        assert!(outcome.stderr.contains(expected), "{more}: {}", outcome.stderr);
    }
    let outcome = bench.run("run planar_leg --bus ethercat");
    assert_eq!(outcome.code, Some(2));
    assert!(outcome.stderr.contains("--interface"), "{}", outcome.stderr);
}
