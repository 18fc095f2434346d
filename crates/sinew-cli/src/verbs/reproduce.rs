//! `sinew reproduce`.

use crate::arguments::{Part, ReproduceArguments};
use crate::error::Error;
use crate::output::{Folder, print, write_all};
use crate::progress::Progress;
use crate::report::reproduction;
use crate::table::{number, table};
use sinew_identify::reproduce::{BenchOptions, BenchPart, Indices, reproduce_bench};

pub(crate) fn run(arguments: &ReproduceArguments) -> Result<(), Error> {
    let Part::Bench = arguments.part;
    let folder = Folder::open(&arguments.out)?;
    let progress = Progress::new();
    let options = if arguments.quick {
        BenchOptions::quick(arguments.seed)
    } else {
        BenchOptions::full(arguments.seed)
    };
    let part = reproduce_bench(&options, &|stage, done| progress.show(stage, done))?;
    drop(progress);
    let json = serde_json::to_string_pretty(&part.results)? + "\n";
    let page = reproduction::render(&part, arguments.quick)?;
    let (report, results) = (folder.file("report.html"), folder.file("results.json"));
    write_all(&[(report.clone(), page.as_bytes()), (results.clone(), json.as_bytes())])?;
    if arguments.json {
        return print(&json);
    }
    print(&format!("{}\nWritten: {}, {}\n", told(&part), report.display(), results.display()))
}

/// Table I as people read it.
fn told(part: &BenchPart) -> String {
    let results = &part.results;
    let mut rows = Vec::new();
    for (name, sides) in &results.table1 {
        let (estimate, cycles) = (results.table1_estimate.get(name), results.table1_cycles.get(name));
        let of = |side: fn(&sinew_identify::reproduce::Sides<Indices>) -> &Indices, muscle: &str| {
            let worst = |indices: Option<&Indices>| {
                number(indices.map(|i| i.rmse_n.iter().copied().fold(f64::NAN, f64::max)))
            };
            vec![
                (*name).to_owned(),
                muscle.to_owned(),
                worst(Some(side(sides))),
                worst(estimate.map(side)),
                worst(cycles.map(side)),
            ]
        };
        rows.push(of(|s| &s.active, "active"));
        rows.push(of(|s| &s.passive, "passive"));
    }
    let head = ["SIMULATED bench", "muscle", "achieved, N rms", "estimated", "whole cycles"];
    let mut text = table(&head, &rows, 2);
    text += "Each the largest of six speeds; the paper reports 1.70 (active) and 1.23 (passive) achieved on average.\n";
    text
}
