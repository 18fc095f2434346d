//! What an identification says of itself, against fresh logs, over many simulated specimens: expected error,
//! band and recommendation; and which logs the influence check drops.
//!
//! Minutes long: it runs only where the environment variable `SINEW_LONG` is set.

#![allow(
    clippy::unwrap_used,
    clippy::print_stderr,
    reason = "a failing test may panic, a skipped one says so"
)]

use crate::common;

use common::families::{Family, Specimen};
use rand::{RngExt, SeedableRng};
use rand_chacha::ChaCha8Rng;
use sinew_identify::evaluate::{evaluate, predict, roles_of};
use sinew_identify::identify::{Identification, Options, identify};
use sinew_identify::log::{ReadOptions, RequestedRoles, read_bytes, read_bytes_with_roles};

/// Seeds per family.
const SEEDS: u64 = 30;

fn is_skipped() -> bool {
    let skipped = std::env::var_os("SINEW_LONG").is_none();
    if skipped {
        eprintln!("skipped: SINEW_LONG is not set");
    }
    skipped
}

fn read(logs: &[(String, String)]) -> Vec<(&str, &[u8])> {
    logs.iter().map(|(name, text)| (name.as_str(), text.as_bytes())).collect()
}

fn options() -> ReadOptions {
    ReadOptions { far_required: true, ..ReadOptions::default() }
}

/// Logs of a specimen, one per day.
fn days(specimen: &Specimen, count: usize, random: &mut ChaCha8Rng) -> Vec<(String, String)> {
    (0..count).map(|k| (format!("{k}.csv"), specimen.log(random))).collect()
}

fn identified(logs: &[(String, String)], models: &[&str], seed: u64) -> Identification {
    let data = read_bytes(&read(logs), &RequestedRoles::default(), &options()).unwrap();
    let models = models.iter().map(|name| (*name).to_owned()).collect();
    identify(&data, &Options { seed, models, ..Options::default() }, &|_, _| {}).unwrap()
}

/// Expected error over the error on four fresh logs, and the fraction of fresh samples inside the band.
fn fresh_scores(family: Family, seed: u64) -> (f64, f64) {
    let mut random = ChaCha8Rng::seed_from_u64(seed);
    let specimen = Specimen::sampled(family, &mut random);
    let found = identified(&days(&specimen, 3, &mut random), &[], seed);
    let fresh = days(&specimen, 4, &mut random);
    let fresh = read_bytes_with_roles(&read(&fresh), &roles_of(&found.model), &options()).unwrap();
    let scores = evaluate(&found.model, &fresh, None).unwrap().overall;
    (found.report.expected.rmse / scores.rmse.unwrap(), scores.coverage95.unwrap())
}

#[test]
fn long_the_expected_error_is_within_a_fifth_of_the_fresh_one_in_the_median() {
    if is_skipped() {
        return;
    }
    for family in Family::ALL {
        let scores: Vec<(f64, f64)> = (0..SEEDS).map(|seed| fresh_scores(family, seed)).collect();
        let at = |fraction: f64, pick: fn(&(f64, f64)) -> f64| {
            let mut values: Vec<f64> = scores.iter().map(pick).collect();
            values.sort_by(f64::total_cmp);
            values[(fraction * (values.len() - 1) as f64).round() as usize]
        };
        let ratio = |fraction: f64| at(fraction, |score| score.0);
        let inside = |fraction: f64| 100.0 * at(fraction, |score| score.1);
        eprintln!(
            "{family:?}: expected over fresh error, median {:.2}, 10 % {:.2}, 90 % {:.2}; inside the band, \
                median {:.1} %, 10 % {:.1} %, 90 % {:.1} %",
            ratio(0.5),
            ratio(0.1),
            ratio(0.9),
            inside(0.5),
            inside(0.1),
            inside(0.9)
        );
        assert!((ratio(0.5) - 1.0).abs() <= 0.2, "{family:?}: {}", ratio(0.5));
    }
}

/// One specimen of the campaign of choices and bands.
struct Judged {
    /// Error of the chosen model on fresh logs over that of the best candidate there, less one.
    regret: f64,
    /// Fraction of the fresh samples inside the band.
    inside: f64,
    /// Width of the band over that of the narrowest band of this form that holds 95 % of the fresh samples.
    width: f64,
}

fn judged(family: Family, seed: u64) -> Judged {
    let mut random = ChaCha8Rng::seed_from_u64(5000 + seed);
    let specimen = Specimen::sampled(family, &mut random);
    let logs = days(&specimen, 3, &mut random);
    let fresh = days(&specimen, 4, &mut random);
    let score = |found: &Identification| {
        let data = read_bytes_with_roles(&read(&fresh), &roles_of(&found.model), &options()).unwrap();
        (evaluate(&found.model, &data, None).unwrap().overall, data)
    };
    let found = identified(&logs, &[], seed);
    let (scores, data) = score(&found);
    let names =
        found.report.candidates.iter().filter(|c| c.failed.is_none() && !c.law).map(|c| c.name.as_str());
    let errors = names.map(|name| score(&identified(&logs, &[name], seed)).0.rmse.unwrap());
    let best = errors.fold(f64::INFINITY, f64::min);
    let predictions = predict(&found.model, &data, None).unwrap().rows;
    let pairs = data.sequences.iter().zip(&predictions).flat_map(|(s, p)| s.far.iter().zip(p));
    let mut needed: Vec<f64> = pairs.map(|(far, p)| (far - p.mean).abs() / p.half_width()).collect();
    needed.sort_by(f64::total_cmp);
    Judged {
        regret: scores.rmse.unwrap() / best - 1.0,
        inside: scores.coverage95.unwrap(),
        width: 1.0 / needed[needed.len() * 95 / 100],
    }
}

#[test]
fn long_the_choice_is_near_the_best_candidate_and_its_band_covers() {
    if is_skipped() {
        return;
    }
    let mut all: Vec<Judged> = Vec::new();
    for seed in 0..SEEDS / 3 {
        for family in Family::ALL {
            let judged = judged(family, seed);
            let Judged { regret, inside, width } = judged;
            eprintln!("{family:?}, seed {seed}: regret {regret:.3}, inside {inside:.3}, width {width:.2}");
            all.push(judged);
        }
    }
    let at = |fraction: f64, pick: fn(&Judged) -> f64| {
        let mut values: Vec<f64> = all.iter().map(pick).collect();
        values.sort_by(f64::total_cmp);
        values[(fraction * (values.len() - 1) as f64).round() as usize]
    };
    for (name, pick) in
        [("regret", (|j| j.regret) as fn(&Judged) -> f64), ("inside", |j| j.inside), ("width", |j| j.width)]
    {
        eprintln!(
            "{name}: 10 % {:.3}, median {:.3}, 90 % {:.3}",
            at(0.1, pick),
            at(0.5, pick),
            at(0.9, pick)
        );
    }
    assert!(at(0.5, |j| j.regret) <= 0.1 && at(0.9, |j| j.regret) <= 0.5);
    // Three logs of different days say little about the fourth: a band can promise its fraction over
    // specimens, not for each.
    let inside = all.iter().map(|j| j.inside).sum::<f64>() / all.len() as f64;
    eprintln!("inside, mean {inside:.3}");
    assert!((0.92..=0.98).contains(&inside), "{inside}");
    assert!(at(0.5, |j| j.width) <= 1.6);
}

/// Logs dropped by the influence check.
fn dropped(logs: &[(String, String)]) -> Vec<String> {
    let rows = identified(logs, &["cell"], 1).report.influence;
    rows.into_iter().filter(|row| row.dropped).map(|row| row.log).collect()
}

#[test]
fn long_the_influence_check_keeps_good_logs() {
    if is_skipped() {
        return;
    }
    let (mut sets, mut spoiled) = (0, 0);
    for family in Family::ALL {
        for seed in 0..2 * SEEDS {
            let mut random = ChaCha8Rng::seed_from_u64(1000 + seed);
            let specimen = Specimen::sampled(family, &mut random);
            let dropped = dropped(&days(&specimen, 5, &mut random));
            sets += 1;
            spoiled += usize::from(!dropped.is_empty());
        }
    }
    eprintln!("sets of five good logs that lost one: {spoiled} of {sets}");
    assert!(100 * spoiled <= 2 * sets, "{spoiled} of {sets}");
}

/// A log of something else among five of a specimen: of a outlier kind, as far off as `kind` says.
fn outlier(specimen: &Specimen, kind: usize, random: &mut ChaCha8Rng) -> String {
    let other = match kind {
        0 => {
            let (friction, gain) = (specimen.friction * 2.5, specimen.gain * 0.7);
            Specimen { friction, gain, ..specimen.clone() }
        }
        1 => {
            let (friction, gain) = (specimen.friction * 0.2, specimen.gain * 1.4);
            Specimen { friction, gain, ..specimen.clone() }
        }
        2 => Specimen { family: Family::Lag, lag_s: 0.3, ..specimen.clone() },
        _ => specimen.clone(),
    };
    let text = other.log(random);
    let mut lines = text.lines();
    let head = lines.next().unwrap().to_owned();
    let rows: Vec<Vec<f64>> =
        lines.map(|line| line.split(',').map(|cell| cell.parse().unwrap()).collect()).collect();
    let delay = 25;
    let wrong = |i: usize| match kind {
        3 => 0.6 * rows[i][2],
        4 => rows[i][2] + 2.0,
        5 => 12.0 - rows[i][2],
        6 => rows[i.saturating_sub(delay)][2],
        7 => rows[i][2].min(6.0),
        8 => 4.4482 * rows[i][2],
        9 => rows[rows.len() - 1 - i][2],
        _ => rows[i][2],
    };
    let rows = (0..rows.len()).map(|i| format!("\n{},{},{}", rows[i][0], rows[i][1], wrong(i)));
    head + &rows.collect::<String>() + "\n"
}

#[test]
fn long_the_influence_check_finds_outlier_logs() {
    if is_skipped() {
        return;
    }
    let (mut sets, mut found, mut wrong) = (0, 0, 0);
    for family in Family::ALL {
        for kind in 0..10 {
            let mut missed = 0;
            for seed in 0..3 {
                let mut random = ChaCha8Rng::seed_from_u64(2000 + seed);
                let specimen = Specimen::sampled(family, &mut random);
                let mut logs = days(&specimen, 4, &mut random);
                let place = random.random_range(0..5);
                logs.insert(place, ("outlier.csv".to_owned(), outlier(&specimen, kind, &mut random)));
                let dropped = dropped(&logs);
                sets += 1;
                found += usize::from(dropped.iter().any(|name| name == "outlier.csv"));
                missed += usize::from(dropped.is_empty());
                wrong += usize::from(dropped.iter().any(|name| name != "outlier.csv"));
            }
            eprintln!("{family:?}, outlier kind {kind}: missed {missed} of 3");
        }
    }
    eprintln!("outlier logs found: {found} of {sets}; sets that lost a good log: {wrong}");
    assert!(10 * found >= 9 * sets, "{found} of {sets}");
}
