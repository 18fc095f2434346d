//! Fifty kinds of damage on five benches: is it named, is the model graded, does the expected error hold? And
//! are good logs left in peace?
//!
//! Minutes long: it runs only where the environment variable `SINEW_LONG` is set.

#![allow(
    clippy::unwrap_used,
    clippy::print_stderr,
    reason = "a failing test may panic, a skipped one says so"
)]

use crate::common;

use common::benches::{Bench, Table};
use common::families::{Family, Specimen};
use rand::{RngExt, SeedableRng};
use rand_chacha::ChaCha8Rng;
use sinew_identify::evaluate::{evaluate, roles_of};
use sinew_identify::identify::{Identification, Options, identify};
use sinew_identify::log::{ReadOptions, RequestedRoles, read_bytes, read_bytes_with_roles};
use sinew_identify::report::Grade;

/// Which channel.
#[derive(Debug, Clone, Copy, PartialEq, Eq)]
enum Channel {
    /// The first input.
    Near,
    /// The second, on benches that have one.
    Second,
    Far,
}

/// Which logs of a set are damaged: the second, or all.
#[derive(Debug, Clone, Copy, PartialEq, Eq)]
enum Reach {
    One,
    All,
}

#[derive(Debug, Clone, Copy, PartialEq)]
enum Damage {
    /// Limited from above, or below, at a quantile.
    ClipHigh(f64),
    ClipLow(f64),
    /// Held from one fraction of the log to another.
    Frozen(f64, f64),
    /// At a constant outside its values from one fraction of the log to another.
    Dead(f64, f64),
    Gain(f64),
    /// A fraction of its range.
    Offset(f64),
    /// Seconds by which it comes late.
    Late(f64),
    /// Time times a factor, its name unchanged.
    Clock(f64),
    /// The beginning alone, seconds.
    Short(f64),
    /// Every n-th sample, so that this many remain in a stroke.
    Coarse(f64),
    /// Friction of the k-th log times this to the k.
    Trend(f64),
    /// Another specimen.
    Foreign,
    /// Near and far side exchanged.
    Exchanged,
    /// Backwards in time.
    Reversed,
}

/// One kind: name, channel, damage, which logs, how many of them, and words one of which must be said.
struct Kind(&'static str, Channel, Damage, Reach, usize, &'static [&'static str]);

const CLIPPED: &[&str] = &["is clipped at"];
const FROZEN: &[&str] = &["is frozen at", "is clipped at"];
const GAIN: &[&str] = &["reads "];
const SHIFTED: &[&str] = &["ms too", "ms later", "ms earlier"];
const CLOCK: &[&str] = &["advances by"];
/// For logs that nothing but their contradiction gives away.
const ODD: &[&str] = &["outlier recording", "odd one of three", "contradicts"];
const PAIR: &[&str] = &["contradicts", "too short", "reads "];

fn kinds() -> Vec<Kind> {
    use Channel::{Far, Near, Second};
    use Damage::{
        ClipHigh, ClipLow, Clock, Coarse, Dead, Exchanged, Foreign, Frozen, Gain, Late, Offset, Reversed,
        Short, Trend,
    };
    use Reach::{All, One};
    vec![
        Kind("near clipped above, all", Near, ClipHigh(0.7), All, 3, CLIPPED),
        Kind("near clipped above", Near, ClipHigh(0.9), One, 3, CLIPPED),
        Kind("near clipped below", Near, ClipLow(0.1), One, 3, CLIPPED),
        Kind("near clipped hard", Near, ClipHigh(0.4), One, 3, CLIPPED),
        Kind("second clipped above", Second, ClipHigh(0.85), One, 3, CLIPPED),
        Kind("second clipped below, all", Second, ClipLow(0.2), All, 3, CLIPPED),
        Kind("far clipped above, all", Far, ClipHigh(0.8), All, 3, CLIPPED),
        Kind("far clipped above", Far, ClipHigh(0.9), One, 3, CLIPPED),
        Kind("far clipped below", Far, ClipLow(0.15), One, 3, CLIPPED),
        Kind("near frozen", Near, Frozen(0.4, 0.55), One, 3, FROZEN),
        Kind("near frozen to the end", Near, Frozen(0.7, 1.0), One, 3, FROZEN),
        Kind("second frozen", Second, Frozen(0.3, 0.4), One, 3, FROZEN),
        Kind("far frozen", Far, Frozen(0.5, 0.6), One, 3, FROZEN),
        Kind("far frozen in all", Far, Frozen(0.2, 0.4), All, 3, FROZEN),
        Kind("near dead", Near, Dead(0.5, 0.6), One, 3, FROZEN),
        Kind("far dead", Far, Dead(0.5, 0.6), One, 3, FROZEN),
        Kind("near gain 2", Near, Gain(2.0), One, 3, GAIN),
        Kind("near gain 0.5", Near, Gain(0.5), One, 3, GAIN),
        Kind("near in lbf", Near, Gain(0.224_809), One, 3, GAIN),
        Kind("near in kg", Near, Gain(0.101_972), One, 4, GAIN),
        Kind("near in thousandths", Near, Gain(1e3), One, 3, GAIN),
        Kind("second in mm", Second, Gain(1e3), One, 3, GAIN),
        Kind("second gain 1.5", Second, Gain(1.5), One, 3, GAIN),
        Kind("far gain 2", Far, Gain(2.0), One, 3, GAIN),
        Kind("far gain 0.5", Far, Gain(0.5), One, 3, GAIN),
        Kind("far gain 1.4", Far, Gain(1.4), One, 5, GAIN),
        Kind("far in kg", Far, Gain(0.101_972), One, 3, GAIN),
        Kind("far in lbf of four", Far, Gain(0.224_809), One, 4, GAIN),
        Kind("near reversed in sign", Near, Gain(-1.0), One, 3, &["reads -", "is the sign of one reversed"]),
        Kind("far reversed in sign", Far, Gain(-1.0), One, 3, &["reads -", "is the sign of one reversed"]),
        Kind("near offset", Near, Offset(0.4), One, 3, GAIN),
        Kind("far offset", Far, Offset(0.4), One, 3, GAIN),
        Kind("time in ms, all", Near, Clock(1e3), All, 3, CLOCK),
        Kind("time in ms", Near, Clock(1e3), One, 3, CLOCK),
        Kind("time in us", Near, Clock(1e6), One, 3, CLOCK),
        Kind("time in days, all", Near, Clock(1.0 / 86_400.0), All, 3, CLOCK),
        Kind("clock 1.37 fast", Near, Clock(1.37), One, 3, CLOCK),
        Kind("near late by 0.3 s", Near, Late(0.3), One, 3, SHIFTED),
        Kind("near early by 0.3 s, all", Near, Late(-0.3), All, 3, SHIFTED),
        Kind("far early by 0.25 s, all", Far, Late(-0.25), All, 3, SHIFTED),
        Kind("far late by 0.4 s", Far, Late(0.4), One, 3, SHIFTED),
        Kind("second late by 0.3 s", Second, Late(0.3), One, 3, SHIFTED),
        Kind("0.3 s, all", Near, Short(0.3), All, 3, &["too short", "samples"]),
        Kind("0.3 s", Near, Short(0.3), One, 3, &["too short"]),
        Kind("sampled too rarely, all", Near, Coarse(5.0), All, 3, &["the rate is too low"]),
        Kind("friction rises by 8 % a log", Near, Trend(1.08), All, 4, &["rises by"]),
        Kind("friction falls by 10 % a log", Near, Trend(0.9), All, 4, &["falls by"]),
        Kind("another specimen of three", Near, Foreign, One, 3, ODD),
        Kind("far gain 2, one of two", Far, Gain(2.0), One, 2, PAIR),
        Kind(
            "near and far exchanged",
            Near,
            Exchanged,
            One,
            3,
            &["odd one of three", "contradicts", "reads "],
        ),
        Kind("backwards in time, one of four", Far, Reversed, One, 4, ODD),
    ]
}

fn quantile(values: &[f64], fraction: f64) -> f64 {
    let mut sorted = values.to_vec();
    sorted.sort_by(f64::total_cmp);
    sorted[(fraction * (sorted.len() - 1) as f64).round() as usize]
}

/// The name of a channel of a bench; `None` where it has none.
fn name(bench: &Bench, channel: Channel) -> Option<&'static str> {
    let (inputs, far) = bench.channels();
    match channel {
        Channel::Near => inputs.first().copied(),
        Channel::Second => inputs.get(1).copied(),
        Channel::Far => Some(far),
    }
}

/// Damages one log.
fn damage(table: &mut Table, bench: &Bench, channel: &str, damage: Damage, random: &mut ChaCha8Rng) {
    let n = table.rows();
    let rate = bench.rate_hz();
    let at = |fraction: f64| (fraction * n as f64) as usize;
    let (inputs, far) = bench.channels();
    // A sensor has one bound on all days.
    let bound =
        |fraction: f64| quantile(bench.log(&mut ChaCha8Rng::seed_from_u64(1)).column(channel), fraction);
    match damage {
        Damage::ClipHigh(fraction) => {
            let bound = bound(fraction);
            table.column(channel).iter_mut().for_each(|x| *x = x.min(bound));
        }
        Damage::ClipLow(fraction) => {
            let bound = bound(fraction);
            table.column(channel).iter_mut().for_each(|x| *x = x.max(bound));
        }
        Damage::Frozen(from, to) => {
            let value = table.column(channel)[at(from)];
            table.column(channel)[at(from)..at(to)].fill(value);
        }
        Damage::Dead(from, to) => {
            let values = table.column(channel);
            let beyond = quantile(values, 0.0) - 0.3 * (quantile(values, 1.0) - quantile(values, 0.0));
            values[at(from)..at(to)].fill(beyond);
        }
        Damage::Gain(gain) => table.column(channel).iter_mut().for_each(|x| *x *= gain),
        Damage::Offset(fraction) => {
            let values = table.column(channel);
            let offset = fraction * (quantile(values, 1.0) - quantile(values, 0.0));
            values.iter_mut().for_each(|x| *x += offset);
        }
        Damage::Late(seconds) => {
            let late = (seconds * rate).round() as isize;
            let before = table.column(channel).clone();
            for (i, x) in table.column(channel).iter_mut().enumerate() {
                *x = before[i.saturating_add_signed(-late).min(n - 1)];
            }
            let lost = late.unsigned_abs();
            table.keep(|row| row >= lost && row + lost < n);
        }
        Damage::Clock(factor) => table.column("time_s").iter_mut().for_each(|t| *t *= factor),
        Damage::Short(seconds) => table.keep(|row| (row as f64) < seconds * rate),
        Damage::Coarse(samples) => {
            // A stroke of these motions takes about a second.
            let every = (rate / samples).round() as usize;
            table.keep(|row| row % every == 0);
        }
        Damage::Exchanged => {
            let near = table.column(inputs[0]).clone();
            let other = table.column(far).clone();
            *table.column(inputs[0]) = other;
            *table.column(far) = near;
        }
        Damage::Reversed => table.column(far).reverse(),
        Damage::Foreign => {
            let mut other = Bench::sampled(bench.kind, random);
            other.friction = bench.friction * 2.5;
            *table = other.log(random);
        }
        // Of the specimen, before the log is made.
        Damage::Trend(_) => {}
    }
}

/// What one identification said.
struct Said {
    named: bool,
    graded: bool,
    /// Expected over real error; `None` where nothing was fitted.
    ratio: Option<f64>,
}

fn read(logs: &[(String, String)]) -> Vec<(&str, &[u8])> {
    logs.iter().map(|(name, text)| (name.as_str(), text.as_bytes())).collect()
}

fn options() -> ReadOptions {
    ReadOptions { far_required: true, ..ReadOptions::default() }
}

fn roles(bench: &Bench) -> RequestedRoles {
    RequestedRoles { far: Some(bench.channels().1.to_owned()), ..RequestedRoles::default() }
}

fn identified(logs: &[(String, String)], flags: &RequestedRoles) -> Result<Identification, String> {
    let data = read_bytes(&read(logs), flags, &options()).map_err(|e| e.to_string())?;
    let models = vec!["cell".to_owned()];
    identify(&data, &Options { seed: 1, models, ..Options::default() }, &|_, _| {}).map_err(|e| e.to_string())
}

/// Everything a user reads, and whether what was read names a channel.
fn words(found: &Identification) -> String {
    let findings =
        found.report.logs.iter().flat_map(|log| log.findings.iter().map(|f| format!("{}: {f}", log.name)));
    let lines = found.report.warnings.iter().cloned().chain(findings);
    lines.chain(found.report.recommendations.clone()).collect::<Vec<_>>().join("\n")
}

fn tried(kind: &Kind, bench_kind: common::benches::Kind, seed: u64) -> Option<Said> {
    let Kind(_, channel, what, reach, count, expected) = *kind;
    let mut random = ChaCha8Rng::seed_from_u64(seed);
    let bench = Bench::sampled(bench_kind, &mut random);
    let channel = name(&bench, channel)?;
    let bad = random.random_range(0..count);
    let logs: Vec<(String, String)> = (0..count)
        .map(|k| {
            let mut day = bench.clone();
            if let Damage::Trend(factor) = what {
                day.friction *= factor.powi(i32::try_from(k).unwrap());
            }
            let mut table = day.log(&mut random);
            if reach == Reach::All || k == bad {
                damage(&mut table, &bench, channel, what, &mut random);
            }
            (format!("day{k}.csv"), table.csv())
        })
        .collect();
    let far = bench.channels().1;
    let fresh: Vec<(String, String)> = (0..3)
        .map(|k| {
            let mut day = bench.clone();
            if let Damage::Trend(factor) = what {
                day.friction *= factor.powi(i32::try_from(count).unwrap());
            }
            let mut table = day.log(&mut random);
            // What is wrong with every log is wrong in use, but the far side is what it is.
            let lasts = matches!(what, Damage::Late(_) | Damage::Coarse(_) | Damage::Clock(_));
            if reach == Reach::All && (channel != far || lasts) && !matches!(what, Damage::Short(_)) {
                damage(&mut table, &bench, channel, what, &mut random);
            }
            (format!("fresh{k}.csv"), table.csv())
        })
        .collect();
    let found = match identified(&logs, &roles(&bench)) {
        Ok(found) => found,
        Err(message) => {
            let named = expected.iter().any(|word| message.contains(word));
            return Some(Said { named, graded: true, ratio: None });
        }
    };
    let text = words(&found);
    let of_log = |line: &str| reach == Reach::All || count == 2 || line.contains(&format!("day{bad}.csv"));
    let speaks = |line: &str| expected.iter().any(|word| line.contains(word));
    let whole = [CLOCK, ODD, PAIR].iter().any(|words| std::ptr::eq(*words, expected));
    let about = |line: &str| {
        whole
            || line.contains(&format!("`{channel}`"))
            || !expected[0].contains("is ") && !expected[0].contains("reads") && !expected[0].contains("ms")
    };
    let named = text.lines().any(|line| of_log(line) && speaks(line) && about(line));
    let data = read_bytes_with_roles(&read(&fresh), &roles_of(&found.model), &options()).ok()?;
    let real = evaluate(&found.model, &data, None).ok()?.overall.rmse?;
    if !named && std::env::var_os("SINEW_SHOW").is_some() {
        eprintln!("{} on {bench_kind:?}, seed {seed}, day{bad}.csv, {channel}:\n{text}\n", kind.0);
    }
    Some(Said {
        named,
        graded: found.report.grade != Grade::Use || found.report.influence.iter().any(|row| row.dropped),
        ratio: Some(found.report.expected.rmse / real),
    })
}

fn is_skipped() -> bool {
    let skipped = std::env::var_os("SINEW_LONG").is_none();
    if skipped {
        eprintln!("skipped: SINEW_LONG is not set");
    }
    skipped
}

/// First seed; another one by `SINEW_SEED`.
fn first_seed() -> u64 {
    std::env::var("SINEW_SEED").ok().and_then(|text| text.parse().ok()).unwrap_or(7000)
}

#[test]
fn long_fifty_kinds_of_damage_are_named_and_graded() {
    if is_skipped() {
        return;
    }
    let (mut named, mut graded, mut all) = (0, 0, 0);
    let mut ratios = Vec::new();
    eprintln!("| damage | named | at most with care, or left out | expected over real error |");
    // Only the kinds whose name has this text.
    let chosen = std::env::var("SINEW_KIND").unwrap_or_default();
    for (k, kind) in kinds().iter().enumerate().filter(|(_, kind)| kind.0.contains(&chosen)) {
        let benches = Bench::KINDS.into_iter().enumerate();
        let said: Vec<Said> =
            benches.filter_map(|(b, bench)| tried(kind, bench, first_seed() + (10 * k + b) as u64)).collect();
        let count = |pick: fn(&Said) -> bool| said.iter().filter(|said| pick(said)).count();
        let errors: Vec<f64> = said.iter().filter_map(|said| said.ratio).collect();
        let median =
            if errors.is_empty() { "refused".to_owned() } else { format!("{:.2}", quantile(&errors, 0.5)) };
        let (n, g) = (count(|s| s.named), count(|s| s.graded));
        eprintln!("| {} | {n} of {} | {g} of {} | {median} |", kind.0, said.len(), said.len());
        named += n;
        graded += g;
        all += said.len();
        ratios.extend(errors);
    }
    let [low, middle, high] = [0.1, 0.5, 0.9].map(|fraction| quantile(&ratios, fraction));
    eprintln!("| all | {named} of {all} | {graded} of {all} | {middle:.2} ({low:.2}, {high:.2}) |");
    assert!(10 * named >= 9 * all, "named {named} of {all}");
    assert!(100 * graded >= 95 * all, "graded {graded} of {all}");
}

#[test]
fn long_good_logs_are_not_accused() {
    if is_skipped() {
        return;
    }
    let (mut sets, mut accused) = (0, Vec::new());
    for seed in 0..6 {
        for count in [1, 2, 3, 5] {
            for kind in Bench::KINDS {
                let mut random = ChaCha8Rng::seed_from_u64(first_seed() + 100_000 + 10 * seed + count as u64);
                let bench = Bench::sampled(kind, &mut random);
                let logs: Vec<(String, String)> =
                    (0..count).map(|k| (format!("day{k}.csv"), bench.log(&mut random).csv())).collect();
                judge_good(
                    &format!("{kind:?}, {count} logs, seed {seed}"),
                    &logs,
                    &roles(&bench),
                    &mut accused,
                );
                sets += 1;
            }
            for family in Family::ALL {
                let mut random = ChaCha8Rng::seed_from_u64(first_seed() + 200_000 + 10 * seed + count as u64);
                let specimen = Specimen::sampled(family, &mut random);
                let logs: Vec<(String, String)> =
                    (0..count).map(|k| (format!("day{k}.csv"), specimen.log(&mut random))).collect();
                let flags = RequestedRoles::default();
                judge_good(&format!("{family:?}, {count} logs, seed {seed}"), &logs, &flags, &mut accused);
                sets += 1;
            }
        }
    }
    eprintln!("{} of {sets} sets of good logs accused: {accused:#?}", accused.len());
    assert!(accused.is_empty());
}

fn judge_good(name: &str, logs: &[(String, String)], flags: &RequestedRoles, accused: &mut Vec<String>) {
    let data = read_bytes(&read(logs), flags, &options()).unwrap();
    let options = Options { seed: 1, models: vec!["cell".to_owned()], ..Options::default() };
    let found = identify(&data, &options, &|_, _| {}).unwrap();
    let before = accused.len();
    let defects = found.report.logs.iter().flat_map(|log| log.defects.iter().map(|d| d.sentence.clone()));
    let dropped = found.report.influence.iter().filter(|row| row.dropped).map(|row| row.remark.clone());
    accused.extend(defects.chain(dropped).map(|said| format!("{name}: {said}")));
    if let Some(said) = accused.get(before) {
        eprintln!("{said}");
    }
    let poor = found.report.warnings.iter().filter(|warning| warning.contains("rate is too low"));
    accused.extend(poor.map(|said| format!("{name}: {said}")));
}
