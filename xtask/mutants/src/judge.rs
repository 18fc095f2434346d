//! Which tests reach a mutant, and whether one of them fails with it.

use std::collections::{HashMap, HashSet};
use std::path::{Path, PathBuf};
use std::process::{Command, Stdio};
use std::sync::Mutex;
use std::sync::atomic::{AtomicUsize, Ordering};
use std::time::{Duration, Instant};

/// A test, the time it takes, and the places of mutants that it reaches.
pub(crate) struct Test {
    program: PathBuf,
    pub name: String,
    time: Duration,
}

pub(crate) struct Tests {
    tests: Vec<Test>,
    /// Tests by the first mutant of each place, the fastest first.
    reaching: HashMap<usize, Vec<usize>>,
}

#[derive(Clone, Copy, PartialEq, Eq)]
pub(crate) enum Verdict {
    Caught,
    /// A test ran far longer than without the mutant.
    TimedOut,
    Missed,
    /// No test reaches it.
    Unreached,
    /// Does not compile.
    Unviable,
    /// In a constant, which nothing switches at run time.
    NotSwitched,
}

impl Verdict {
    pub(crate) fn name(self) -> &'static str {
        match self {
            Self::Caught => "caught",
            Self::TimedOut => "timed out",
            Self::Missed => "missed",
            Self::Unreached => "not reached",
            Self::Unviable => "unviable",
            Self::NotSwitched => "not switched",
        }
    }
}

/// Tests that run together, bounded by the sum of their times without a mutant: the quick ones come first.
const BATCHES: [f64; 4] = [0.1, 0.5, 3.0, 20.0];

/// A mutant may let a test allocate without end, KiB.
const MEMORY: usize = 6_000_000;

impl Tests {
    /// Runs every test once in a process of its own.
    pub(crate) fn measure(
        programs: &[PathBuf],
        folder: &Path,
        scratch: &Path,
        jobs: usize,
    ) -> Result<Self, String> {
        let mut names = Vec::new();
        for program in programs {
            let output =
                Command::new(program).args(["--list", "--format", "terse"]).current_dir(folder).output();
            let output = output.map_err(|error| format!("{}: {error}", program.display()))?;
            let text = String::from_utf8_lossy(&output.stdout).into_owned();
            names.extend(
                text.lines()
                    .filter_map(|line| Some((program.clone(), line.strip_suffix(": test")?.to_string()))),
            );
        }
        let results = in_parallel(names.len(), jobs, |index| {
            let (program, name) = &names[index];
            let reached = scratch.join(format!("reached-{index}"));
            let _ = std::fs::remove_file(&reached);
            let environment = [("SINEW_MUTANTS_REACHED", reached.as_os_str())];
            let mut start = Instant::now();
            let mut outcome = run(program, folder, &[name], Duration::from_secs(1200), &environment);
            if outcome != Outcome::Passed {
                // Writing the list of what is reached allocates and takes time, which some tests forbid.
                start = Instant::now();
                outcome = run(program, folder, &[name], Duration::from_secs(1200), &[]);
            }
            let time = start.elapsed();
            let sites: HashSet<usize> = std::fs::read_to_string(&reached)
                .unwrap_or_default()
                .lines()
                .filter_map(|line| line.parse().ok())
                .collect();
            let _ = std::fs::remove_file(&reached);
            (outcome, time, sites)
        });
        let mut tests = Vec::new();
        let mut reaching: HashMap<usize, Vec<usize>> = HashMap::new();
        for ((program, name), (outcome, time, sites)) in names.into_iter().zip(results) {
            if outcome != Outcome::Passed {
                println!("left out, as it does not pass without a mutant: {name}");
                continue;
            }
            for site in sites {
                reaching.entry(site).or_default().push(tests.len());
            }
            tests.push(Test { program, name, time });
        }
        for list in reaching.values_mut() {
            list.sort_by_key(|&test| tests[test].time);
        }
        Ok(Self { tests, reaching })
    }

    pub(crate) fn len(&self) -> usize {
        self.tests.len()
    }

    /// Time of all tests one after the other.
    pub(crate) fn time(&self) -> Duration {
        self.tests.iter().map(|test| test.time).sum()
    }

    /// Verdict on the mutant `number` of the place `site`, by the quickest of the tests that reach it and take `budget` together.
    pub(crate) fn judge(&self, number: usize, site: usize, folder: &Path, budget: Duration) -> Verdict {
        let Some(reaching) = self.reaching.get(&site) else { return Verdict::Unreached };
        let mut sum = Duration::ZERO;
        let within = reaching.iter().take_while(|&&test| {
            sum += self.tests[test].time;
            sum <= budget
        });
        let reaching = &reaching[..within.count().max(1)];
        let (mut first, mut bounds) = (0, BATCHES.iter());
        while first < reaching.len() {
            let bound = Duration::from_secs_f64(*bounds.next().unwrap_or(&60.0));
            let (mut last, mut time) = (first, Duration::ZERO);
            while last < reaching.len() && (last == first || time + self.tests[reaching[last]].time < bound) {
                time += self.tests[reaching[last]].time;
                last += 1;
            }
            let mut batch: HashMap<&Path, Vec<&str>> = HashMap::new();
            for &test in &reaching[first..last] {
                batch.entry(&self.tests[test].program).or_default().push(&self.tests[test].name);
            }
            for (program, names) in batch {
                let number = number.to_string();
                let limit = Duration::from_secs(10) + 10 * time;
                match run(program, folder, &names, limit, &[("SINEW_MUTANT", number.as_ref())]) {
                    Outcome::Passed => (),
                    Outcome::Failed => return Verdict::Caught,
                    Outcome::TimedOut => return Verdict::TimedOut,
                }
            }
            first = last;
        }
        Verdict::Missed
    }
}

#[derive(Clone, Copy, PartialEq, Eq)]
enum Outcome {
    Passed,
    Failed,
    TimedOut,
}

fn run(
    program: &Path,
    folder: &Path,
    names: &[impl AsRef<str>],
    limit: Duration,
    environment: &[(&str, &std::ffi::OsStr)],
) -> Outcome {
    let child = Command::new("sh")
        .args(["-c", &format!("ulimit -v {MEMORY}; exec \"$@\""), "sh"])
        .arg(program)
        .args(["--exact", "--test-threads=1", "--quiet"])
        .args(names.iter().map(AsRef::as_ref))
        .current_dir(folder)
        .env("PROPTEST_DISABLE_FAILURE_PERSISTENCE", "1")
        .env("PROPTEST_MAX_SHRINK_ITERS", "0")
        .envs(environment.iter().copied())
        .stdin(Stdio::null())
        .stdout(Stdio::null())
        .stderr(Stdio::null())
        .spawn();
    let Ok(mut child) = child else { return Outcome::Failed };
    let start = Instant::now();
    loop {
        match child.try_wait() {
            Ok(Some(status)) => return if status.success() { Outcome::Passed } else { Outcome::Failed },
            Ok(None) if start.elapsed() < limit => std::thread::sleep(Duration::from_millis(2)),
            _ => {
                let _ = child.kill();
                let _ = child.wait();
                return Outcome::TimedOut;
            }
        }
    }
}

/// `compute(0)` to `compute(count - 1)`, in this order, on `jobs` threads.
pub(crate) fn in_parallel<T: Send>(count: usize, jobs: usize, compute: impl Fn(usize) -> T + Sync) -> Vec<T> {
    let next = AtomicUsize::new(0);
    let results = Mutex::new(Vec::with_capacity(count));
    std::thread::scope(|scope| {
        for _ in 0..jobs {
            scope.spawn(|| {
                loop {
                    let index = next.fetch_add(1, Ordering::Relaxed);
                    if index >= count {
                        break;
                    }
                    let result = compute(index);
                    results.lock().expect("no worker panics").push((index, result));
                }
            });
        }
    });
    let mut results = results.into_inner().expect("no worker panics");
    results.sort_by_key(|(index, _)| *index);
    results.into_iter().map(|(_, result)| result).collect()
}
