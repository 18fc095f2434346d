//! Another specimen is noticed on the near side, and the same one under other loads and speeds is not.

use rand::{RngExt, SeedableRng};
use rand_chacha::ChaCha8Rng;
use sinew::predictor::LoopQuantity;
use sinew_identify::evaluate::{SpecimenScore, evaluate, roles_of};
use sinew_identify::identify::{Identification, Options, identify};
use sinew_identify::log::{ReadOptions, RequestedRoles, read_bytes, read_bytes_with_roles};
use std::fmt::Write as _;

/// A simulated cable between a drive and a spring with a load.
#[derive(Debug, Clone, Copy)]
struct Cable {
    /// Friction angle, `mu phi`.
    friction: f64,
    /// N/mm.
    stiffness: f64,
    /// N.
    pretension: f64,
    /// Of the far end, N/mm.
    spring: f64,
    /// mm.
    stroke: f64,
}

/// How a trial is run.
#[derive(Debug, Clone, Copy)]
struct Trial {
    load: f64,
    hertz: f64,
}

const LARGEST_LOAD: f64 = 28.0;

impl Cable {
    fn sampled(random: &mut ChaCha8Rng) -> Self {
        let mut between = |low: f64, high: f64| low + (high - low) * random.random::<f64>();
        let (friction, stiffness) = (between(0.15, 0.8), between(2.0, 8.0));
        let (pretension, spring) = (between(4.0, 10.0), between(0.5, 2.0));
        // The cable slides in every trial, for 40 % of the stroke and more.
        let stuck = 2.0 * friction.sinh() * (pretension + LARGEST_LOAD) / stiffness;
        Self { friction, stiffness, pretension, spring, stroke: (stuck / 0.6).max(12.0) }
    }

    /// Ten seconds at 50 Hz: the far end slides where the ratio of the tensions reaches that of the friction.
    /// From trial to trial friction, stiffness and pretension differ by a few per cent, as temperature and
    /// fit do.
    fn rows(&self, name: usize, trial: Trial, random: &mut ChaCha8Rng, text: &mut String) {
        let mut near = |size: f64| 1.0 + size * (2.0 * random.random::<f64>() - 1.0);
        let (friction, stiffness) = (self.friction * near(0.03), self.stiffness * near(0.02));
        let tension = self.pretension * near(0.02) + trial.load;
        let mut far = 0.0_f64;
        for i in 0..500 {
            let t = f64::from(i) * 0.02;
            let phase = std::f64::consts::TAU * trial.hertz * t;
            let drive = 0.5 * self.stroke * (1.0 - phase.cos());
            let slides = |ratio: f64| {
                (tension * (1.0 - ratio) + stiffness * drive) / (stiffness + self.spring * ratio)
            };
            far = far.max(slides(friction.exp())).min(slides((-friction).exp()));
            let drag = 0.02 * self.stroke * trial.hertz * phase.sin();
            let motor = (tension + stiffness * (drive - far) + drag) * near(0.004);
            let end = tension + self.spring * far;
            writeln!(text, "{name},{},{t},{drive},{motor},{end}", trial.load).unwrap();
        }
    }

    fn log(&self, trials: &[Trial], random: &mut ChaCha8Rng) -> String {
        let mut text = String::from("trial,load_n,t_s,position_in_mm,tension_in_n,tension_out_n\n");
        trials.iter().enumerate().for_each(|(name, trial)| self.rows(name, *trial, random, &mut text));
        text
    }
}

const ROLES: [&str; 3] = ["tension_out_n", "tension_in_n", "position_in_mm"];

fn identified(log: &str) -> Identification {
    let [far, effort, motion] = ROLES.map(str::to_owned);
    let roles = RequestedRoles {
        far: Some(far),
        effort: vec![effort],
        motion: vec![motion],
        trial: Some("trial".to_owned()),
        ..RequestedRoles::default()
    };
    let options = ReadOptions { far_required: true, ..ReadOptions::default() };
    let data = read_bytes(&[("train.csv", log.as_bytes())], &roles, &options).unwrap();
    identify(&data, &Options { models: vec!["linear".into()], ..Options::default() }, &|_, _| {}).unwrap()
}

fn judged(found: &Identification, log: &str) -> Option<SpecimenScore> {
    let options = ReadOptions { far_required: true, ..ReadOptions::default() };
    let data =
        read_bytes_with_roles(&[("test.csv", log.as_bytes())], &roles_of(&found.model), &options).unwrap();
    evaluate(&found.model, &data, None).unwrap().overall.specimen
}

/// Every load at every frequency.
fn trials(loads: &[f64], frequencies: &[f64]) -> Vec<Trial> {
    let at = |&load: &f64| frequencies.iter().map(move |&hertz| Trial { load, hertz });
    loads.iter().flat_map(at).collect()
}

/// `[change]`: trials judged and called another specimen, summed over specimens and their changed copies.
fn tally(specimens: u64, loads: [&[f64]; 2]) -> [[u64; 2]; CHANGES.len()] {
    let mut sums = [[0; 2]; CHANGES.len()];
    for seed in 0..specimens {
        let mut random = ChaCha8Rng::seed_from_u64(seed);
        let cable = Cable::sampled(&mut random);
        let found = identified(&cable.log(&trials(loads[0], &[0.3, 0.4, 0.6, 0.8, 1.0]), &mut random));
        for ((_, change), [trials_judged, other]) in CHANGES.iter().zip(&mut sums) {
            let unseen = change(cable).log(&trials(loads[1], &[0.5, 0.7, 0.9]), &mut random);
            let score = judged(&found, &unseen).unwrap();
            (*trials_judged, *other) = (*trials_judged + score.judged, *other + score.other);
        }
    }
    sums
}

const LOADS: [&[f64]; 2] = [&[0.0, 5.0, 10.0, 20.0, 25.0], &[2.0, 15.0, 22.0, LARGEST_LOAD]];
const ONE_LOAD: [&[f64]; 2] = [&[5.0, 5.0, 5.0], &[5.0]];

/// Another specimen in the place of one.
type Change = fn(Cable) -> Cable;

/// Changes of a specimen by which it becomes another.
const CHANGES: [(&str, Change); 5] = [
    ("none", |cable| cable),
    ("friction +30 %", |cable| Cable { friction: 1.3 * cable.friction, ..cable }),
    ("stiffness -30 %", |cable| Cable { stiffness: 0.7 * cable.stiffness, ..cable }),
    ("pretension +30 %", |cable| Cable { pretension: 1.3 * cable.pretension, ..cable }),
    ("path: friction +20 %, stiffness -15 %", |cable| Cable {
        friction: 1.2 * cable.friction,
        stiffness: 0.85 * cable.stiffness,
        ..cable
    }),
];

#[test]
fn more_friction_is_another_specimen_and_unseen_loads_and_speeds_are_not() {
    let [[judged, none], [_, friction], ..] = tally(4, LOADS);
    assert!(judged == 48 && none <= 1, "{none} of {judged} at unseen loads and speeds");
    assert!(friction * 100 >= 95 * judged, "{friction} of {judged} with more friction");
}

#[test]
fn where_the_load_is_not_varied_its_level_is_the_pretension() {
    let mut random = ChaCha8Rng::seed_from_u64(1);
    let cable = Cable::sampled(&mut random);
    let found = identified(&cable.log(&trials(ONE_LOAD[0], &[0.3, 0.4, 0.6, 0.8, 1.0]), &mut random));
    assert!(found.report.specimen.iter().any(|noticed| noticed.quantity == LoopQuantity::Level));
    assert!(found.report.warnings.iter().any(|warning| warning.contains("Another specimen is noticed")));
    let other = CHANGES[3].1(cable).log(&trials(ONE_LOAD[1], &[0.4, 0.8]), &mut random);
    let score = judged(&found, &other).unwrap();
    assert_eq!((score.judged, score.other), (2, 2), "{score:?}");
}

#[test]
fn few_trials_do_not_show_what_a_specimen_looks_like() {
    let mut random = ChaCha8Rng::seed_from_u64(1);
    let cable = Cable::sampled(&mut random);
    let found = identified(&cable.log(&trials(&[0.0, 5.0], &[0.4, 0.6]), &mut random));
    assert!(found.model.specimen.is_none() && found.report.specimen.is_empty());
    let reason = "A change of specimen is not noticed, because that takes 11 trials";
    assert!(
        found.report.warnings.iter().any(|warning| warning.starts_with(reason)),
        "{:?}",
        found.report.warnings
    );
}

/// The table of docs/specimen.md; with `SINEW_LONG` set.
#[test]
#[allow(clippy::print_stderr, reason = "a table of what was found")]
fn changes_of_fifty_specimens() {
    if std::env::var_os("SINEW_LONG").is_none() {
        eprintln!("skipped: SINEW_LONG is not set");
        return;
    }
    let [varied, held] = [LOADS, ONE_LOAD].map(|loads| tally(50, loads));
    for ((name, _), sums) in CHANGES.iter().zip(varied.iter().zip(&held)) {
        let [varied, held] = [sums.0, sums.1].map(|[judged, other]| 100.0 * *other as f64 / *judged as f64);
        eprintln!("{name}: {varied:.1} % of trials with varied loads, {held:.1} % with one load");
    }
    for [judged, other] in [varied[0], held[0]] {
        assert!(other * 50 <= judged, "{other} of {judged} trials of the same specimen");
    }
}
