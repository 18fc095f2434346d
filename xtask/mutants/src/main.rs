//! Judges the mutants that cargo-mutants lists, in one build.
//!
//! `cargo mutants` builds the crate once for each mutant, more than a minute each. Here all of them are compiled at once, each
//! behind a comparison with the number of the active one; every test is run once to see which mutants it reaches; then each
//! mutant is activated in turn and only the tests that reach it are run, the quick ones first, until one fails.

mod build;
mod instrument;
mod judge;
mod mutant;

use judge::{Tests, Verdict, in_parallel};
use mutant::Mutant;
use std::collections::{BTreeMap, HashMap, HashSet};
use std::io::Write;
use std::path::{Path, PathBuf};
use std::process::ExitCode;
use std::sync::Mutex;
use std::time::Duration;

const HELP: &str = "\
Judges the mutants that cargo-mutants lists for the crate sinew by the tests of that crate, in one build.

usage: cargo xtask mutants [--jobs N] [--only FILE] [--budget SECONDS] [--lib] [--constants] [--out FOLDER] [FOLDER-OF-SOURCES...]

  FOLDER-OF-SOURCES  relative to the repository; by default transmission, drive, control, predictor, body and muscle of sinew
  --jobs N           tests that run at once; default 2
  --only FILE        only the mutants named in the first column of this table of an earlier run, but not those caught there
  --budget SECONDS   of the tests that reach a mutant run the quickest that take so long together; default: all
  --constants        instead of cargo-mutants' list: constants of these folders, a hundred times as large and a hundredth
  --lib              by the unit tests alone
  --out FOLDER       default target/mutants; gets verdicts.tsv

A mutant is caught, timed out (its tests ran ten times as long), missed, not reached by any test, unviable (does not compile),
or not switched: in a constant or a `const fn`, which `cargo mutants` alone can judge.";

const ROOMS: [&str; 6] = ["transmission", "drive", "muscle", "predictor", "control", "body"];

fn main() -> ExitCode {
    let arguments: Vec<String> = std::env::args().skip(1).collect();
    if arguments.iter().any(|word| word == "--help" || word == "-h") {
        println!("{HELP}");
        return ExitCode::SUCCESS;
    }
    match options(&arguments) {
        Ok(options) => match judge_all(&options) {
            Ok(()) => ExitCode::SUCCESS,
            Err(message) => {
                eprintln!("error: {message}");
                ExitCode::FAILURE
            }
        },
        Err(message) => {
            eprintln!("error: {message}; see --help");
            ExitCode::from(2)
        }
    }
}

struct Options {
    rooms: Vec<String>,
    jobs: usize,
    only: Option<PathBuf>,
    budget: Duration,
    lib: bool,
    constants: bool,
    out: PathBuf,
}

fn options(arguments: &[String]) -> Result<Options, String> {
    let mut options = Options {
        rooms: Vec::new(),
        jobs: 2,
        only: None,
        budget: Duration::MAX,
        lib: false,
        constants: false,
        out: PathBuf::from("target/mutants"),
    };
    let mut words = arguments.iter();
    while let Some(word) = words.next() {
        let mut value = || words.next().ok_or(format!("`{word}` needs a value"));
        match word.as_str() {
            "--jobs" => {
                let text = value()?;
                options.jobs = text
                    .parse()
                    .ok()
                    .filter(|&jobs| jobs > 0)
                    .ok_or(format!("--jobs: expected a whole number from 1, found `{text}`"))?;
            }
            "--budget" => {
                let text = value()?;
                let seconds = text.parse().ok().filter(|&seconds: &u64| seconds > 0);
                options.budget = seconds
                    .map(Duration::from_secs)
                    .ok_or(format!("--budget: expected whole seconds from 1, found `{text}`"))?;
            }
            "--lib" => options.lib = true,
            "--constants" => options.constants = true,
            "--only" => options.only = Some(PathBuf::from(value()?)),
            "--out" => options.out = PathBuf::from(value()?),
            flag if flag.starts_with('-') => return Err(format!("`{flag}` is not an option")),
            room => options.rooms.push(room.to_string()),
        }
    }
    if options.rooms.is_empty() {
        options.rooms = ROOMS.iter().map(|room| format!("crates/sinew/src/{room}")).collect();
    }
    Ok(options)
}

fn judge_all(options: &Options) -> Result<(), String> {
    let root = std::env::current_dir().map_err(|error| format!("the working directory: {error}"))?;
    let out = root.join(&options.out);
    let tree = out.join("tree");
    let mut mutants = mutant::list(&root, &options.rooms)?;
    if options.constants {
        let files = mutants.iter().map(|mutant| mutant.file.clone()).collect();
        mutants = mutant::constants(&root, &files)?;
    }
    mutants.sort_by_key(|mutant| options.rooms.iter().position(|room| mutant.file.starts_with(room)));
    if let Some(only) = &options.only {
        let text = std::fs::read_to_string(only).map_err(|error| format!("{}: {error}", only.display()))?;
        let names: HashSet<&str> = text
            .lines()
            .filter_map(|line| line.split_once('\t'))
            .filter(|(_, verdict)| {
                *verdict == Verdict::Missed.name() || *verdict == Verdict::Unreached.name()
            })
            .map(|(name, _)| name)
            .collect();
        mutants.retain(|mutant| names.contains(mutant.name.as_str()));
    }
    println!("{} mutants", mutants.len());
    let built = build::build(&root, &tree, &mutants, options.lib)?;
    println!("{} switched, {} do not compile", built.switched.len(), built.unviable.len());
    let folder = tree.join("crates").join(build::CRATE);
    let tests = Tests::measure(&built.programs, &folder, &out, options.jobs)?;
    println!("{} tests, {:.0} s one after the other", tests.len(), tests.time().as_secs_f64());

    let sites = sites(&mutants, &built);
    let path = out.join("verdicts.tsv");
    let table = std::fs::File::create(&path).map_err(|error| format!("{}: {error}", path.display()))?;
    let table = Mutex::new((table, 0));
    let results = in_parallel(mutants.len(), options.jobs, |index| {
        let number = index + 1;
        let verdict = match sites.get(&number) {
            Some(&site) => tests.judge(number, site, &folder, options.budget),
            None if built.unviable.contains(&number) => Verdict::Unviable,
            None => Verdict::NotSwitched,
        };
        let (file, done) = &mut *table.lock().expect("no worker panics");
        *done += 1;
        if *done % 100 == 0 {
            println!("{done} of {}", mutants.len());
        }
        writeln!(file, "{}\t{}", mutants[index].name, verdict.name()).map(|()| verdict)
    });
    let results: Vec<Verdict> = results
        .into_iter()
        .collect::<Result<_, _>>()
        .map_err(|error| format!("{}: {error}", path.display()))?;
    summarise(&mutants, &results);
    println!("{}", path.display());
    Ok(())
}

/// The first mutant at the place of each mutant that can be switched: the number by which tests name what they reach.
fn sites(mutants: &[Mutant], built: &build::Build) -> HashMap<usize, usize> {
    let mut first: HashMap<(&str, mutant::Place, bool), usize> = HashMap::new();
    let mut sites = HashMap::new();
    for (index, mutant) in mutants.iter().enumerate() {
        let number = index + 1;
        if built.switched.contains(&number) {
            let body = mutant.genre == mutant::Genre::FnValue;
            let site = *first.entry((&mutant.file, mutant.span.start, body)).or_insert(number);
            sites.insert(number, site);
        }
    }
    sites
}

fn summarise(mutants: &[Mutant], results: &[Verdict]) {
    let mut rooms: BTreeMap<String, BTreeMap<&str, usize>> = BTreeMap::new();
    for (mutant, verdict) in mutants.iter().zip(results) {
        let folder = Path::new(&mutant.file)
            .components()
            .nth(3)
            .map(|part| part.as_os_str().to_string_lossy().into_owned());
        for room in [folder.unwrap_or_default(), "all".to_string()] {
            *rooms.entry(room).or_default().entry(verdict.name()).or_default() += 1;
        }
    }
    const NAMES: [&str; 6] = ["caught", "timed out", "missed", "not reached", "unviable", "not switched"];
    println!("| room | {} | caught of those judged |", NAMES.join(" | "));
    println!("|---|{}---|", "---|".repeat(NAMES.len()));
    for (room, counts) in &rooms {
        let count = |name: &str| counts.get(name).copied().unwrap_or(0);
        let caught = count("caught") + count("timed out");
        let judged = caught + count("missed") + count("not reached");
        let cells: Vec<_> = NAMES.iter().map(|name| count(name).to_string()).collect();
        println!(
            "| {room} | {} | {:.1} % |",
            cells.join(" | "),
            100.0 * caught as f64 / judged.max(1) as f64
        );
    }
}
