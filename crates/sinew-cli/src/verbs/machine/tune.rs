//! `sinew machine tune`.

use super::design_checks::{DesignChecks, LockedWinches, Underactuated};
use super::limit_words::Subject;
use super::names::print_warnings;
use super::view::machine_scene;
use crate::answer::{Answer, Content};
use crate::arguments::{General, MachineTuneArguments};
use crate::error::Error;
use crate::output::{one_line, refuse_overwrite, write_all};
use crate::progress::Progress;
use crate::table::{number, table};
use crate::verbs::machine_source::load_machine;
use serde::Serialize;
use sinew::control::arm::{
    DampingMargins, JointFigures, PeriodCost, PeriodLimit, SlowestPeriod, joint_limits, synthesize,
};
use sinew::description::MachineDescription;
use sinew::machine::{Machine, Tolerances};
use sinew::twin::arm::ArmSpecimen;
use sinew_lab::experiment::oracle_models;
use sinew_report::tuning::{Changed, Figures, Margins, Tuned, TunedJoint, TunedMuscle, TunedPeriod, page};
use std::path::PathBuf;

/// Poses over which the rules look.
const POSES: usize = 60;
/// Cells of a cable whose stiffness is needed.
const CELLS: usize = 12;

pub(super) fn run(arguments: &MachineTuneArguments, general: &General) -> Result<Answer, Error> {
    let outputs: Vec<PathBuf> = arguments.out.iter().chain(&arguments.report).cloned().collect();
    let inputs = [&arguments.machine].into_iter().chain(&arguments.files.muscles);
    refuse_overwrite(inputs, &outputs, general.no_clobber)?;
    let (loaded, _) = load_machine(
        &arguments.machine,
        arguments.files.muscles.as_deref(),
        arguments.files.root.dir.as_deref(),
    )?;
    print_warnings(&loaded.warnings);
    tune(&loaded, arguments, general).map_err(|error| error.at(&loaded.places))
}

fn tune(
    loaded: &MachineDescription,
    arguments: &MachineTuneArguments,
    general: &General,
) -> Result<Answer, Error> {
    let machine = loaded.machine.loaded()?;
    let poses = machine.poses(POSES)?;
    let checks = DesignChecks::new(&machine, &machine.laws(CELLS)?, &poses)?;
    checks.print_warnings();
    let cost = PeriodCost::new(&machine, &machine.laws(CELLS)?, &poses)?;
    print_unheld(&machine, &cost);
    let underactuated = checks.underactuated.as_ref();
    let tuned = tuned(&machine, &poses, (checks.text(&machine), &cost), arguments.specimens)?;
    let mut files = Vec::new();
    if let Some(path) = &arguments.out {
        files.push((path.clone(), serde_json::to_string_pretty(&tuned.gains)? + "\n"));
    }
    if let Some(path) = &arguments.report {
        let scene = machine_scene(&machine, &arguments.machine, arguments.files.root.dir.as_deref())?;
        files.push((path.clone(), page(&tuned, &machine, &scene)?));
    }
    let bytes: Vec<(PathBuf, &[u8])> =
        files.iter().map(|(path, text)| (path.clone(), text.as_bytes())).collect();
    let written = write_all(&bytes)?;
    let content = if general.json {
        Content::json(&Printed { tuned: &tuned, locked_winches: &checks.locked_winches, underactuated })?
    } else {
        Content::Text(text(&tuned) + "\n" + &tuned.locked_winches)
    };
    Ok(Answer::done(content, written))
}

/// What is printed with `--json`.
#[derive(Debug, Serialize)]
struct Printed<'a> {
    #[serde(flatten)]
    tuned: &'a Tuned,
    locked_winches: &'a [LockedWinches],
    #[serde(skip_serializing_if = "Option::is_none")]
    underactuated: Option<&'a Underactuated>,
}

fn tuned(
    machine: &Machine,
    poses: &[Vec<f64>],
    (locked_winches, cost): (String, &PeriodCost),
    specimens: u32,
) -> Result<Tuned, Error> {
    let progress = Progress::new();
    progress.show("limits of the joints", 0.0);
    let design = ArmSpecimen::nominal(machine)?;
    let models = oracle_models(&design);
    let (gains, found) = synthesize(machine, &models, poses)?;
    let limits = joint_limits(machine, &models, poses)?;
    let designed = DampingMargins::from_gains(&gains, &found, machine.dead_time());
    let mut least = designed.clone();
    for seed in 0..specimens {
        progress.show("margins of sampled machines", f64::from(seed + 1) / f64::from(specimens + 1));
        let built = ArmSpecimen::sampled_around(&design, machine, u64::from(seed))?;
        // As it is built: no further tolerance.
        let tolerances = Tolerances { attachment: Some(0.0), ..machine.tolerances };
        let of_built = Machine { robot: built.robot.clone(), tolerances, ..machine.clone() };
        let (_, found) = synthesize(&of_built, &oracle_models(&built), poses)?;
        for (least, other) in
            least.iter_mut().zip(DampingMargins::from_gains(&gains, &found, machine.dead_time()))
        {
            if other.crossover > least.crossover {
                *least = other;
            }
        }
    }
    let parts = machine.robot.parts();
    let names: Vec<String> = parts.tendons.iter().map(|tendon| tendon.name.clone()).collect();
    let joints = machine.robot.independent_joints().into_iter().zip(&limits).enumerate();
    let joints = joints.map(|(j, (index, limit))| {
        let joint = &parts.joints[index];
        let unit = joint.kind.unit();
        let subject = Subject { unit, names: &names, gains: &gains, found: &found };
        let changed = limit.changed.iter().map(|(change, after)| Changed {
            change: change.name(),
            helps: limit.is_helped_by(after),
            figures: figures(after),
        });
        TunedJoint {
            name: joint.name.clone(),
            unit,
            bandwidth_rad_per_s: gains.joints[j].bandwidth,
            dead_band: found.joints[j].dead_band,
            inertia: found.joints[j].inertia,
            limited_by: subject.sentence(j, limit),
            slowest_period_s: cost.slowest[j].period,
            period_limited_by: period_limit(cost.slowest[j]),
            figures: limit.figures.as_ref().map(figures),
            changes: changed.collect(),
        }
    });
    let of_muscles = gains.muscles.iter().zip(&found.muscles).zip(designed.iter().zip(&least));
    let muscles =
        names.iter().zip(of_muscles).map(|(name, ((gains, muscle), (designed, least)))| TunedMuscle {
            name: name.clone(),
            mode_rad_per_s: muscle.mode,
            rate_gain_s: gains.rate_gain,
            dead_band_m: muscle.dead_band,
            tension_limits_n: gains.tension,
            max_winch_speed_m_per_s: gains.max_winch_speed,
            least: margins(least),
            as_designed: margins(designed),
        });
    Ok(Tuned {
        name: parts.name.clone(),
        joints: joints.collect(),
        muscles: muscles.collect(),
        stuck_mode_rad_per_s: found.stuck_mode,
        period: TunedPeriod {
            period_s: machine.period,
            dead_time_s: cost.dead_time,
            winch_time_constant_s: cost.winch_time,
            damping_crossover_rad_per_s: cost.damping_crossover,
            observer_bandwidth_rad_per_s: cost.observer_bandwidth,
            fastest_observer_rad_per_s: cost.fastest_observer,
            bandwidth_rad_per_s: cost.bandwidth,
        },
        locked_winches,
        amount: [poses.len(), specimens as usize],
        gains,
    })
}

/// Warns of joints that cannot be held at the machine's period.
fn print_unheld(machine: &Machine, cost: &PeriodCost) {
    let joints = machine.robot.independent_joints();
    for (joint, slowest) in cost.unheld(machine.period) {
        tell!(
            "warning: `{}` is not held at a period of {} ms: {}",
            one_line(&machine.robot.parts().joints[joints[joint]].name),
            number(Some(1e3 * machine.period)),
            period_limit(slowest)
        );
    }
}

/// Why a joint is not tracked at a slower period.
fn period_limit(slowest: SlowestPeriod) -> String {
    let period = number(Some(1e3 * slowest.period));
    match slowest.limited_by {
        PeriodLimit::Instability(rate) => format!(
            "up to {period} ms; with locked winches it leaves a pose by itself at {} 1/s",
            number(Some(rate))
        ),
        PeriodLimit::Bandwidth => {
            format!("up to {period} ms; beyond, its bandwidth is lowered with that of its observer")
        }
        PeriodLimit::Range => format!("up to {period} ms"),
    }
}

/// What the period costs, as a paragraph.
fn period_text(tuned: &Tuned) -> String {
    let TunedPeriod { period_s, dead_time_s, .. } = tuned.period;
    let ms = |s: f64| number(Some(1e3 * s));
    let mut text = format!("\nControl cycle of {} ms, dead time {} ms\n", ms(period_s), ms(dead_time_s));
    let of = &tuned.period;
    for (name, [own, usual], unit, scale) in [
        ("time constant of the winches", of.winch_time_constant_s, "ms", 1e3),
        ("crossover of their damping", of.damping_crossover_rad_per_s, "rad/s", 1.0),
        ("observers of the joints", of.observer_bandwidth_rad_per_s, "rad/s", 1.0),
        ("the same at a break-away", of.fastest_observer_rad_per_s, "rad/s", 1.0),
        ("bandwidth of the joints", of.bandwidth_rad_per_s, "rad/s", 1.0),
    ] {
        if (own - usual).abs() > 1e-9 * usual {
            let [own, usual] = [own, usual].map(|number_of| number(Some(scale * number_of)));
            text += &format!("  {name}: {own} {unit}, at a millisecond {usual} {unit}\n");
        }
    }
    text += "Slowest control cycle at which each joint is tracked\n";
    for joint in &tuned.joints {
        text += &format!("  {}: {}\n", one_line(&joint.name), joint.period_limited_by);
    }
    text
}

fn figures(of: &JointFigures) -> Figures {
    Figures {
        crossing_s: of.crossing,
        left_to_feedback: of.friction,
        tolerance_at_rest: of.rest,
        damping_ratio: of.damping,
    }
}

fn margins(of: &DampingMargins) -> Margins {
    Margins {
        phase_margin_deg: of.phase.to_degrees(),
        gain_margin: of.gain,
        delay_margin_s: of.delay.is_finite().then_some(of.delay),
    }
}

fn text(tuned: &Tuned) -> String {
    let of = |x: f64| number(Some(x));
    let joint = |joint: &TunedJoint| {
        let band = format!("{} {}", of(joint.dead_band), joint.unit);
        vec![one_line(&joint.name), of(joint.bandwidth_rad_per_s), band, of(joint.inertia)]
    };
    let muscle = |muscle: &TunedMuscle| {
        let [least, most] = muscle.tension_limits_n;
        vec![
            one_line(&muscle.name),
            of(muscle.mode_rad_per_s),
            of(1e3 * muscle.rate_gain_s),
            of(1e3 * muscle.dead_band_m),
            format!("{least:.1} to {most:.1}"),
            of(muscle.max_winch_speed_m_per_s),
            format!("{:.0}", muscle.least.phase_margin_deg),
            format!("{:.1}", muscle.least.gain_margin),
            muscle.least.delay_margin_s.map_or("-".to_owned(), |s| format!("{:.1}", 1e3 * s)),
        ]
    };
    let joints: Vec<Vec<String>> = tuned.joints.iter().map(joint).collect();
    let muscles: Vec<Vec<String>> = tuned.muscles.iter().map(muscle).collect();
    let mut text = format!("{}\n\n", one_line(&tuned.name));
    text += &table(&["joint", "bandwidth, rad/s", "dead band", "inertia"], &joints, 1);
    text += "\n";
    let header = [
        "muscle",
        "mode, rad/s",
        "rate gain, ms",
        "dead band, mm",
        "tension, N",
        "winch, m/s",
        "phase, deg",
        "gain",
        "delay, ms",
    ];
    text += &table(&header, &muscles, 1);
    text += "\nWhat limits each joint; changes: half more winch speed, half the compliance, bend or \
        encoder count\n";
    for joint in &tuned.joints {
        text += &format!("  {}: {}\n", one_line(&joint.name), one_line(&joint.limited_by));
    }
    text + &period_text(tuned)
}
