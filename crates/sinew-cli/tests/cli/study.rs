//! A study's file becomes a program, or is refused with line and key.

use crate::bench::Bench;

const PAGE: &str = include_str!("../../../../docs/study.md");

/// The blocks of docs/study.md in a language.
fn blocks(language: &str) -> Vec<&'static str> {
    let fence = format!("```{language}\n");
    PAGE.split(&fence[..]).skip(1).filter_map(|rest| rest.split("```").next()).collect()
}

#[test]
fn the_page_shows_what_is_printed() {
    let bench = Bench::new();
    let (files, programs) = (blocks("toml"), blocks("python"));
    assert_eq!(files.len(), 2);
    for file in files {
        bench.write("study.toml", file);
        let run = bench.run("design study study.toml");
        assert_eq!(run.code, Some(0), "{}", run.stderr);
        assert!(programs.contains(&run.stdout.as_str()), "{}", run.stdout);
        let json: serde_json::Value =
            serde_json::from_str(&bench.run("design study study.toml --json").stdout).unwrap();
        assert_eq!(json["python"], run.stdout);
    }
}

#[test]
fn a_function_of_ones_own_is_imported_and_texts_are_literals() {
    let bench = Bench::new();
    let text = "folder = 'a\"b\\n'\ntrials = 3\nbackend = \"slurm\"\nsampler = \"nsga2\"\nstorage = \"sqlite:///s.db\"\nminimize = [\"loss\"]\n\
                [objective.python]\nmodule = \"mine.work\"\nfunction = \"loss\"\n[parameters.gain]\nlow = \
                0.1\nhigh = 10\nlog = true\n";
    bench.write("study.toml", text);
    let printed = bench.run("design study study.toml").stdout;
    for part in [
        "from mine.work import loss\n",
        "Study(\"a\\\"b\\\\n\", objective,",
        "Range(0.1, 10.0, log=True)",
        "backend=\"slurm\"",
        "NSGAIISampler(seed=1), storage=\"sqlite:///s.db\")",
    ] {
        assert!(printed.contains(part), "{part}: {printed}");
    }
}

#[test]
fn a_wrong_file_is_refused_with_line_and_key() {
    let bench = Bench::new();
    let good = "folder = \"s\"\ntrials = 3\n[objective.routing]\nmachine = \"finger\"\nmuscle = \"extensor\"\n[parameters.bend_rad]\nlow = 1.0\nhigh = 2.0\n";
    let wrong = [
        ("trials = 3", "trials = 0", 2, "trials must be an integer of at least 1"),
        ("trials = 3", "trials = -1", 2, "-1"),
        ("trials = 3", "trials = 3\nspeed = 1", 3, "speed"),
        ("trials = 3", "trials = 3\nsampler = \"tpe\"", 3, "minimize or maximize"),
        ("trials = 3", "trials = 3\nstorage = \"sqlite:///s.db\"", 3, "storage needs a sampler"),
        ("trials = 3", "trials = 3\nbackend = \"cloud\"", 3, "cloud"),
        ("trials = 3", "trials = 3\nminimize = [\"a\", \"a\"]", 3, "named twice"),
        ("low = 1.0", "low = 3.0", 6, "from low to high"),
        ("low = 1.0", "low = nan", 6, "bend_rad"),
        ("high = 2.0", "high = 2.0\nlow = 3.0", 9, "low"),
        ("muscle = \"extensor\"", "", 3, "muscle"),
        ("objective.routing", "objective.magic", 3, "magic"),
    ];
    for (before, after, line, part) in wrong {
        bench.write("study.toml", good.replace(before, after));
        let run = bench.run("design study study.toml");
        assert_eq!(run.code, Some(2), "{after}: {}", run.stdout);
        for expected in ["study.toml", &format!("line {line}"), part] {
            assert!(run.stderr.contains(expected), "{after}: {expected}: {}", run.stderr);
        }
    }
    bench.write("study.toml", good);
    assert_eq!(bench.run("design study study.toml").code, Some(0));
    assert!(bench.run("design study missing.toml").stderr.contains("missing.toml"));
}
