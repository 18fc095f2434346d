//! Gains by rules: a page with margins, limits of the joints, rules and their numbers.

use super::colours::PAGE;
use super::error::Error;
use super::format::{NONE, fixed, plural, significant};
use super::machine_picture::draw;
use super::plot::css_percent;
use super::scene::{SceneData, SceneFigure, machine_figure, scene_script};
use super::shell::{SHELL, Shell};
use askama::Template;
use serde::Serialize;
use sinew::control::arm::{ArmGains, RULE_SOURCES};
use sinew::machine::Machine;

/// Gains, margins and limits of a machine, as printed with `--json`.
#[derive(Debug, Serialize)]
pub struct Tuned {
    /// The machine.
    pub name: String,
    /// In the order of the independent joints.
    pub joints: Vec<TunedJoint>,
    /// In the order of the muscles.
    pub muscles: Vec<TunedMuscle>,
    /// Highest natural frequency, far ends stuck.
    pub stuck_mode_rad_per_s: f64,
    /// What the period of the control cycle costs.
    pub period: TunedPeriod,
    /// As the controller reads them.
    pub gains: ArmGains,
    /// Paragraph on the stability with locked winches.
    #[serde(skip)]
    pub locked_winches: String,
    /// Poses and sampled machines of the margins.
    #[serde(skip)]
    pub amount: [usize; 2],
}

/// The period of a machine's control cycle, and what it makes slower; pairs are at this period and at a
/// millisecond.
#[derive(Debug, Serialize)]
pub struct TunedPeriod {
    /// Control period, s.
    pub period_s: f64,
    /// From a measurement to the middle of the command that answers it, s.
    pub dead_time_s: f64,
    /// Of the travel of a winch, s.
    pub winch_time_constant_s: [f64; 2],
    /// Of the winches' damping.
    pub damping_crossover_rad_per_s: [f64; 2],
    /// Of the joints' observers, and of one that follows a joint as it breaks away.
    pub observer_bandwidth_rad_per_s: [f64; 2],
    /// The same at its fastest.
    pub fastest_observer_rad_per_s: [f64; 2],
    /// Of the joints.
    pub bandwidth_rad_per_s: [f64; 2],
}

/// A joint with its gains and what limits it.
#[derive(Debug, Serialize)]
pub struct TunedJoint {
    /// Its name.
    pub name: String,
    /// Unit of its coordinate: rad or m.
    pub unit: &'static str,
    /// Bandwidth of its controller, rad/s.
    pub bandwidth_rad_per_s: f64,
    /// Its dead band with locked winches, rad or m.
    pub dead_band: f64,
    /// Inertia that it moves, kg m^2 or kg.
    pub inertia: f64,
    /// A sentence.
    pub limited_by: String,
    /// Slowest period of the control cycle at which it is tracked, s.
    pub slowest_period_s: f64,
    /// What does not allow a slower one; a sentence.
    pub period_limited_by: String,
    /// None without a muscle.
    pub figures: Option<Figures>,
    /// The same after each change of the design.
    pub changes: Vec<Changed>,
}

/// Numbers that limit a joint, in its unit.
#[derive(Debug, Serialize)]
pub struct Figures {
    /// Time in which the winches cross its dead band, s.
    pub crossing_s: f64,
    /// Motion that is left to feedback, rad or m.
    pub left_to_feedback: f64,
    /// Error that is tolerated at rest, rad or m.
    pub tolerance_at_rest: f64,
    /// Damping ratio of its mode, 1.
    pub damping_ratio: f64,
}

/// The figures of a joint after a change of the design.
#[derive(Debug, Serialize)]
pub struct Changed {
    /// The change in words.
    pub change: &'static str,
    /// Whether a figure that limits the joint improves.
    pub helps: bool,
    /// After the change.
    #[serde(flatten)]
    pub figures: Figures,
}

/// A muscle with its gains and margins.
#[derive(Debug, Serialize)]
pub struct TunedMuscle {
    /// Its name.
    pub name: String,
    /// Antiresonance of its motor behind the cable, rad/s.
    pub mode_rad_per_s: f64,
    /// Gain of the anchor's speed error, s.
    pub rate_gain_s: f64,
    /// Dead band of its cable, m.
    pub dead_band_m: f64,
    /// Smallest and largest desired tension at the anchor, N.
    pub tension_limits_n: [f64; 2],
    /// Largest commanded speed of its winch, m/s.
    pub max_winch_speed_m_per_s: f64,
    /// Smallest of the machine as designed and of those sampled.
    #[serde(flatten)]
    pub least: Margins,
    /// Of the machine as designed.
    pub as_designed: Margins,
}

/// Margins of stability of the loop of a winch.
#[derive(Debug, Clone, Copy, Serialize)]
pub struct Margins {
    /// Phase margin, degrees.
    pub phase_margin_deg: f64,
    /// Gain margin, 1.
    pub gain_margin: f64,
    /// Delay margin, s; none where no delay destabilises.
    pub delay_margin_s: Option<f64>,
}

#[derive(Template)]
#[template(path = "tuning.html")]
struct Page<'a> {
    shell: Shell,
    tuned: &'a Tuned,
    amount: String,
    verdict: String,
    picture: String,
    scene: SceneFigure,
    scene_script: String,
    joints: Vec<Row>,
    changes: Vec<Change>,
    margins: Vec<MarginRow>,
    scales: [[String; 2]; 3],
    muscles: Vec<Row>,
    equations: [(&'static str, String); 4],
    gains: [Matrix; 2],
}

struct Row {
    name: String,
    cells: Vec<(&'static str, String)>,
}

/// A joint as designed and after every change.
struct Change {
    joint: String,
    sentences: Vec<String>,
    rows: Vec<(String, bool, [String; 4])>,
}

struct MarginRow {
    name: String,
    tracks: [Track; 3],
}

/// A margin on a scale: where usual values begin, as designed, least.
struct Track {
    usual: Option<String>,
    designed: String,
    least: String,
    low: bool,
    text: String,
}

/// Gains of joints or muscles, in tables that a page is wide enough for.
struct Matrix {
    heading: &'static str,
    of: &'static str,
    parts: Vec<Gains>,
}

/// Some gains of all joints or muscles.
struct Gains {
    gains: Vec<String>,
    rows: Vec<(String, Vec<String>)>,
}

/// Gains that stand beside one another.
const ABREAST: usize = 6;

/// Where usual margins begin: phase in degrees, gain.
const USUAL: [Option<f64>; 3] = [Some(30.0), Some(2.0), None];

/// A page of its own.
pub fn page(tuned: &Tuned, machine: &Machine, scene: &SceneData) -> Result<String, Error> {
    let [poses, drawn] = tuned.amount;
    let (margins, scales) = margins(tuned);
    let page = Page {
        shell: SHELL,
        amount: format!(
            "{}, {}; {} over the joints’ ranges, {} sampled within the tolerances.",
            plural(tuned.joints.len(), "joint", "joints"),
            plural(tuned.muscles.len(), "muscle", "muscles"),
            plural(poses, "pose", "poses"),
            plural(drawn, "machine", "machines"),
        ),
        verdict: verdict(tuned),
        picture: draw(machine, &PAGE)?,
        scene: machine_figure(scene)?,
        scene_script: scene_script(),
        joints: tuned.joints.iter().map(joint).collect(),
        changes: tuned.joints.iter().map(change).collect(),
        margins,
        scales,
        muscles: tuned.muscles.iter().map(muscle).collect(),
        equations: RULE_SOURCES.map(|(title, source)| (title, equations(source))),
        gains: matrices(tuned)?,
        tuned,
    };
    Ok(page.render()?)
}

/// The first block of equations in the documentation of a source file, which is thus the only place where
/// they stand.
fn equations(source: &str) -> String {
    let docs = source.lines().filter_map(|line| line.strip_prefix("///"));
    let block =
        docs.skip_while(|line| line.trim() != "```text").skip(1).take_while(|line| line.trim() != "```");
    block.map(|line| line.strip_prefix(' ').unwrap_or(line)).collect::<Vec<_>>().join("\n")
}

fn verdict(tuned: &Tuned) -> String {
    let weakest =
        tuned.muscles.iter().min_by(|a, b| a.least.phase_margin_deg.total_cmp(&b.least.phase_margin_deg));
    weakest.map_or_else(String::new, |muscle| {
        format!(
            "Least margins of the damping by the winches: phase {}°, gain {}, delay {} ms, all at {}.",
            fixed(muscle.least.phase_margin_deg, 0),
            fixed(muscle.least.gain_margin, 1),
            milliseconds(muscle.least.delay_margin_s),
            muscle.name
        )
    })
}

fn milliseconds(seconds: Option<f64>) -> String {
    seconds.map_or_else(|| NONE.to_owned(), |s| fixed(1e3 * s, 1))
}

fn joint(joint: &TunedJoint) -> Row {
    let of = |value: f64| significant(value, 3);
    let cells = vec![
        ("bandwidth, rad/s", of(joint.bandwidth_rad_per_s)),
        ("dead band", format!("{} {}", of(joint.dead_band), joint.unit)),
        ("inertia", format!("{} {}", of(joint.inertia), if joint.unit == "m" { "kg" } else { "kg m²" })),
    ];
    Row { name: joint.name.clone(), cells }
}

fn muscle(muscle: &TunedMuscle) -> Row {
    let of = |value: f64| significant(value, 3);
    let [least, most] = muscle.tension_limits_n;
    let cells = vec![
        ("mode, rad/s", of(muscle.mode_rad_per_s)),
        ("rate gain, ms", of(1e3 * muscle.rate_gain_s)),
        ("dead band, mm", of(1e3 * muscle.dead_band_m)),
        ("tension, N", format!("{} to {}", fixed(least, 1), fixed(most, 1))),
        ("winch, m/s", of(muscle.max_winch_speed_m_per_s)),
    ];
    Row { name: muscle.name.clone(), cells }
}

fn change(joint: &TunedJoint) -> Change {
    let cells = |figures: &Figures| {
        let (a, b) = (significant(figures.left_to_feedback, 3), significant(figures.tolerance_at_rest, 3));
        [fixed(1e3 * figures.crossing_s, 1), a, b, significant(figures.damping_ratio, 2)]
    };
    let own = joint.figures.iter().map(|figures| ("as designed".to_owned(), false, cells(figures)));
    let changed = joint.changes.iter().map(|one| (one.change.to_owned(), one.helps, cells(&one.figures)));
    Change {
        joint: joint.name.clone(),
        sentences: joint
            .limited_by
            .split("; ")
            .chain([format!("control cycle {}", joint.period_limited_by).as_str()])
            .map(sentence)
            .collect(),
        rows: own.chain(changed).collect(),
    }
}

/// A clause as a sentence of its own; a name at its beginning stays as it is.
pub(crate) fn sentence(clause: &str) -> String {
    let name = clause.split(' ').next().is_some_and(|word| word.contains('_'));
    let mut letters = clause.chars();
    match letters.next() {
        Some(first) if !name => format!("{}{}.", first.to_uppercase(), letters.as_str()),
        _ => format!("{clause}."),
    }
}

/// Rows of tracks, and the ends of their scales.
fn margins(tuned: &Tuned) -> (Vec<MarginRow>, [[String; 2]; 3]) {
    let values = |margins: &Margins| {
        [margins.phase_margin_deg, margins.gain_margin, 1e3 * margins.delay_margin_s.unwrap_or(f64::NAN)]
    };
    let lows = [0.0, 1.0, 0.0];
    let highs: [f64; 3] = std::array::from_fn(|k| {
        let most = tuned.muscles.iter().map(|muscle| values(&muscle.as_designed)[k]);
        1.05 * most.filter(|value| value.is_finite()).fold(2.0 * USUAL[k].unwrap_or(1.0), f64::max)
    });
    let rows = tuned.muscles.iter().map(|muscle| {
        let (designed, least) = (values(&muscle.as_designed), values(&muscle.least));
        let track = |k: usize| {
            let at = |value: f64| css_percent((value - lows[k]) / (highs[k] - lows[k]));
            Track {
                usual: USUAL[k].map(at),
                designed: at(designed[k]),
                least: at(least[k]),
                low: USUAL[k].is_some_and(|usual| least[k] < usual),
                text: fixed(least[k], usize::from(k > 0)),
            }
        };
        MarginRow { name: muscle.name.clone(), tracks: [track(0), track(1), track(2)] }
    });
    let scales = std::array::from_fn(|k| [lows[k], highs[k]].map(|end| fixed(end, 0)));
    (rows.collect(), scales)
}

/// All gains by the names that they have in the file of `--out`.
fn matrices(tuned: &Tuned) -> Result<[Matrix; 2], Error> {
    let value = serde_json::to_value(&tuned.gains)?;
    let joints: Vec<String> = tuned.joints.iter().map(|joint| joint.name.clone()).collect();
    let muscles: Vec<String> = tuned.muscles.iter().map(|muscle| muscle.name.clone()).collect();
    Ok([
        matrix("Of every joint", "Joint", &joints, &value["joints"]),
        matrix("Of every muscle", "Muscle", &muscles, &value["muscles"]),
    ])
}

fn matrix(heading: &'static str, of: &'static str, owners: &[String], entries: &serde_json::Value) -> Matrix {
    let entries: Vec<&serde_json::Value> = entries.as_array().into_iter().flatten().collect();
    let names = entries.first().and_then(|first| first.as_object());
    let names: Vec<String> = names.into_iter().flat_map(|names| names.keys()).cloned().collect();
    let part = |names: &[String]| Gains {
        gains: names.to_vec(),
        rows: owners
            .iter()
            .zip(&entries)
            .map(|(owner, entry)| {
                (owner.clone(), names.iter().map(|name| shown(&entry[name.as_str()])).collect())
            })
            .collect(),
    };
    Matrix { heading, of, parts: names.chunks(ABREAST).map(part).collect() }
}

fn shown(value: &serde_json::Value) -> String {
    match value {
        serde_json::Value::Array(ends) => ends.iter().map(shown).collect::<Vec<_>>().join(" to "),
        serde_json::Value::Bool(yes) => (if *yes { "yes" } else { "no" }).to_owned(),
        _ => significant(value.as_f64().unwrap_or(f64::NAN), 3),
    }
}

#[cfg(test)]
mod tests {
    use super::*;

    #[test]
    fn gains_stand_in_tables_of_a_few_columns_with_a_muscle_or_joint_per_row() {
        let entry = |k: usize| {
            let gains = (0..14).map(|gain| (format!("g{gain:02}"), serde_json::json!(k)));
            serde_json::Value::Object(gains.collect())
        };
        let owners = ["a".to_owned(), "b".to_owned()];
        let found = matrix("", "Muscle", &owners, &serde_json::json!([entry(1), entry(2)]));
        assert!(found.parts.iter().all(|part| part.gains.len() <= ABREAST && part.rows.len() == 2));
        assert_eq!(found.parts.iter().map(|part| part.gains.len()).sum::<usize>(), 14);
        assert_eq!(found.parts[2].rows[1], ("b".to_owned(), vec!["2.00".to_owned(); 2]));
    }

    #[test]
    fn the_equations_are_those_of_the_documentation() {
        let rules = equations(RULE_SOURCES[0].1);
        assert!(rules.starts_with("F_min = ") && rules.contains("t_d,k = min(") && !rules.contains("```"));
        assert_eq!(equations("// none\n"), "");
    }
}
