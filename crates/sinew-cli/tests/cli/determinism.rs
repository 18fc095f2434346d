//! The same question has the same answer, to the byte.

use crate::bench::{Bench, log};

/// The model that `identify` makes.
fn model(bench: &Bench, arguments: &str, out: &str) -> String {
    bench.succeeds(&format!("identify {arguments} --out {out}"));
    bench.read(&format!("{out}/model.json"))
}

#[test]
fn the_same_seed_gives_the_same_bytes_with_any_number_of_threads() {
    let bench = Bench::new();
    for (out, threads) in [("one", "1"), ("again", "1"), ("two", "2"), ("five", "5")] {
        let arguments = format!("identify a.csv b.csv --model cell,hybrid --out {out} --seed 7");
        let output = bench.command(&arguments).env("RAYON_NUM_THREADS", threads).output().unwrap();
        assert!(output.status.success(), "{}", String::from_utf8_lossy(&output.stderr));
        for file in ["model.json", "report.html"] {
            let (first, this) = (bench.read(&format!("one/{file}")), bench.read(&format!("{out}/{file}")));
            assert!(first == this, "{file} differs with {threads} threads");
        }
    }
}

#[test]
fn another_seed_trains_another_network() {
    // Guards the test above: it would pass if the seed and the networks were ignored.
    let bench = Bench::new();
    let first = model(&bench, "a.csv b.csv --model hybrid --seed 1", "one");
    let second = model(&bench, "a.csv b.csv --model hybrid --seed 2", "two");
    let weights =
        |text: &str| text[text.find("hidden_weights").unwrap()..text.find("band_factor").unwrap()].to_owned();
    assert_ne!(weights(&first), weights(&second));
}

#[test]
fn the_order_of_logs_changes_nothing() {
    let bench = Bench::new();
    bench.write("c.csv", log(0.31));
    let first = model(&bench, "a.csv b.csv c.csv --model cell,hybrid", "one");
    assert_eq!(model(&bench, "c.csv a.csv b.csv --model cell,hybrid", "two"), first);
}

#[test]
fn the_order_of_columns_changes_nothing() {
    let bench = Bench::new();
    let first = model(&bench, "a.csv b.csv --model cell,hybrid", "one");
    for name in ["a.csv", "b.csv"] {
        let turned: String = bench
            .read(name)
            .lines()
            .map(|line| line.rsplit(',').collect::<Vec<_>>().join(",") + "\n")
            .collect();
        assert!(turned.starts_with("tension_out_n,tension_in_n,time_s\n"));
        bench.write(name, turned);
    }
    assert_eq!(model(&bench, "a.csv b.csv --model cell,hybrid", "two"), first);
}

#[test]
fn a_duplicated_log_is_noticed() {
    let bench = Bench::new();
    bench.write("copy.csv", bench.read("a.csv"));
    let summary = bench.succeeds("identify a.csv b.csv copy.csv --model cell --out out").stdout;
    assert!(
        summary.lines().any(|line| line.starts_with("a.csv: copy.csv holds the same samples")),
        "{summary}"
    );
    // Twice the same log is no more than once: the model is as if it had been given once.
    let once = model(&bench, "a.csv b.csv --model cell", "once");
    assert_eq!(bench.read("out/model.json"), once);
}
