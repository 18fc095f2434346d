//! `sinew machine tune`.

use super::design_checks::{DesignChecks, HeldWinches};
use crate::arguments::MachineTuneArguments;
use crate::error::Error;
use crate::output::{print, refuse_overwrite, write_all};
use crate::progress::Progress;
use crate::table::{number, table};
use crate::verbs::arm::model::{load_machine, print_warnings};
use serde::Serialize;
use sinew::body::JointKind;
use sinew::control::arm::{ArmGains, DampingMargins, JointGains, MuscleGains, synthesize};
use sinew::machine::{Characteristics, JointCharacteristics, Machine, MuscleCharacteristics, Tolerances};
use sinew::muscle::MuscleDynamics;
use sinew::twin::arm::ArmSpecimen;
use sinew_lab::experiment::oracle_models;

/// Poses over which the rules look.
const POSES: usize = 60;
/// Cells of a cable whose stiffness is needed.
const CELLS: usize = 12;

pub(super) fn run(arguments: &MachineTuneArguments) -> Result<(), Error> {
    refuse_overwrite([&arguments.machine], &arguments.out.iter().cloned().collect::<Vec<_>>())?;
    let loaded = load_machine(&arguments.machine, arguments.muscles.as_deref())?;
    print_warnings(&loaded.warnings);
    let machine = loaded.machine.loaded()?;
    let poses = machine.poses(POSES)?;
    let checks = DesignChecks::of(&machine, &machine.laws(CELLS)?, &poses)?;
    checks.print_warnings();
    let held_winches = checks.text(&machine);
    let tuned = Tuned::of(&machine, &poses, checks, arguments.specimens)?;
    if let Some(path) = &arguments.out {
        let text = serde_json::to_string_pretty(&tuned.gains)? + "\n";
        write_all(&[(path.clone(), text.as_bytes())])?;
    }
    if arguments.json {
        return print(&(serde_json::to_string_pretty(&tuned)? + "\n"));
    }
    let mut text = tuned.text() + "\n" + &held_winches;
    if let Some(path) = &arguments.out {
        text += &format!("Written: {}\n", path.display());
    }
    print(&text)
}

/// What is printed with `--json`.
#[derive(Debug, Serialize)]
struct Tuned {
    name: String,
    joints: Vec<Joint>,
    muscles: Vec<Muscle>,
    /// Highest natural frequency, far ends stuck.
    stuck_mode_rad_per_s: f64,
    held_winches: Vec<HeldWinches>,
    gains: ArmGains,
}

#[derive(Debug, Serialize)]
struct Joint {
    name: String,
    unit: &'static str,
    bandwidth_rad_per_s: f64,
    dead_band: f64,
    inertia: f64,
    limited_by: String,
}

#[derive(Debug, Serialize)]
struct Muscle {
    name: String,
    mode_rad_per_s: f64,
    rate_gain_s: f64,
    dead_band_m: f64,
    tension_limits_n: [f64; 2],
    max_winch_speed_m_per_s: f64,
    /// Least of the nominal machine and those drawn.
    phase_margin_deg: f64,
    gain_margin: f64,
    delay_margin_s: Option<f64>,
}

impl Tuned {
    fn of(
        machine: &Machine,
        poses: &[Vec<f64>],
        checks: DesignChecks,
        specimens: u32,
    ) -> Result<Self, Error> {
        let progress = Progress::new();
        let design = ArmSpecimen::nominal(machine)?;
        let (gains, found) = synthesize(machine, &oracle_models(&design), poses)?;
        let mut margins = DampingMargins::of(&gains, &found);
        for seed in 0..specimens {
            progress.show("margins of drawn machines", f64::from(seed) / f64::from(specimens));
            let built = ArmSpecimen::drawn_around(&design, machine, u64::from(seed))?;
            // As it is built: no further tolerance.
            let tolerances = Tolerances { attachment: Some(0.0), ..machine.tolerances };
            let of_built = Machine { robot: built.robot.clone(), tolerances, ..machine.clone() };
            let (_, found) = synthesize(&of_built, &oracle_models(&built), poses)?;
            for (least, other) in margins.iter_mut().zip(DampingMargins::of(&gains, &found)) {
                if other.crossover > least.crossover {
                    *least = other;
                }
            }
        }
        let mut start = MuscleDynamics::new(&machine.robot)?;
        start.evaluate(&machine.start)?;
        let parts = machine.robot.parts();
        let joints = machine.robot.independent_joints().into_iter().enumerate().map(|(j, index)| {
            let slide = parts.joints[index].kind == JointKind::Slide;
            Joint {
                name: parts.joints[index].name.clone(),
                unit: if slide { "m" } else { "rad" },
                bandwidth_rad_per_s: gains.joints[j].bandwidth,
                dead_band: found.joints[j].dead_band,
                inertia: found.joints[j].inertia,
                limited_by: limit(machine, &gains, &found, j, &crossing_muscles(&start, j)),
            }
        });
        let muscles = parts.tendons.iter().zip(gains.muscles.iter().zip(&found.muscles)).zip(&margins);
        let muscles = muscles.map(|((tendon, (gains, muscle)), margins)| Muscle {
            name: tendon.name.clone(),
            mode_rad_per_s: muscle.mode,
            rate_gain_s: gains.rate_gain,
            dead_band_m: muscle.dead_band,
            tension_limits_n: gains.tension,
            max_winch_speed_m_per_s: gains.max_winch_speed,
            phase_margin_deg: margins.phase.to_degrees(),
            gain_margin: margins.gain,
            delay_margin_s: margins.delay.is_finite().then_some(margins.delay),
        });
        Ok(Self {
            name: parts.name.clone(),
            joints: joints.collect(),
            muscles: muscles.collect(),
            stuck_mode_rad_per_s: found.stuck_mode,
            held_winches: checks.held_winches,
            gains,
        })
    }

    fn text(&self) -> String {
        let joints: Vec<Vec<String>> = self
            .joints
            .iter()
            .map(|joint| {
                let of = |x: f64| number(Some(x));
                let band = format!("{} {}", of(joint.dead_band), joint.unit);
                vec![joint.name.clone(), of(joint.bandwidth_rad_per_s), band, of(joint.inertia)]
            })
            .collect();
        let muscles: Vec<Vec<String>> = self
            .muscles
            .iter()
            .map(|muscle| {
                let of = |x: f64| number(Some(x));
                let [least, most] = muscle.tension_limits_n;
                vec![
                    muscle.name.clone(),
                    of(muscle.mode_rad_per_s),
                    of(1e3 * muscle.rate_gain_s),
                    of(1e3 * muscle.dead_band_m),
                    format!("{least:.1} to {most:.1}"),
                    of(muscle.max_winch_speed_m_per_s),
                    format!("{:.0}", muscle.phase_margin_deg),
                    format!("{:.1}", muscle.gain_margin),
                    muscle.delay_margin_s.map_or("-".to_owned(), |s| format!("{:.1}", 1e3 * s)),
                ]
            })
            .collect();
        let mut text = format!("{}\n\n", self.name);
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
        text += "\nWhat limits each joint\n";
        for joint in &self.joints {
            text += &format!("  {}: {}\n", joint.name, joint.limited_by);
        }
        text
    }
}

/// Time to cross a dead band beyond which it limits a joint, s.
const LONG_CROSSING: f64 = 0.05;
/// Rate gain below which a mode limits a joint, s: half of the largest.
const SHORT_RATE_GAIN: f64 = 0.075;

/// What limits a joint, by the muscle that takes longest to cross its dead band.
fn limit(
    machine: &Machine,
    gains: &ArmGains,
    found: &Characteristics,
    joint: usize,
    crossing_it: &[usize],
) -> String {
    let JointCharacteristics { arm, .. } = found.joints[joint];
    let crossing =
        |(muscle, gains): (&MuscleCharacteristics, &MuscleGains)| muscle.dead_band / gains.max_winch_speed;
    let muscles = || found.muscles.iter().zip(&gains.muscles);
    let slowest = muscles().enumerate().filter(|(k, _)| crossing_it.contains(k));
    let Some((k, (muscle, gain))) = slowest.max_by(|a, b| crossing(a.1).total_cmp(&crossing(b.1))) else {
        return "no muscle crosses it".to_owned();
    };
    let name = &machine.robot.parts().tendons[k].name;
    let JointGains { resolution, encoder, .. } = gains.joints[joint];
    let time = crossing((muscle, gain));
    if !encoder {
        return "it has no encoder: its position follows from the stretch of its cables".to_owned();
    }
    if time > LONG_CROSSING {
        return format!(
            "{name}: {:.1} mm of dead band at {:.3} m/s take {time:.2} s at every reversal; a faster winch, a \
             stiffer cable or less bend would help",
            1e3 * muscle.dead_band,
            gain.max_winch_speed
        );
    }
    if gain.rate_gain < SHORT_RATE_GAIN {
        return format!(
            "{name}: at a mode of {:.0} rad/s the winch damps for {:.1} ms only; a heavier link, a softer cable or a \
             faster drive would help",
            muscle.mode,
            1e3 * gain.rate_gain
        );
    }
    if resolution * arm > 0.02 * muscle.dead_band {
        return format!("its encoder: a count is {:.3} mm at its cables", 1e3 * resolution * arm);
    }
    format!("{name}: uncertain friction, some per cent of {:.2} mm of dead band", 1e3 * muscle.dead_band)
}

/// Muscles with a moment arm about an independent joint in the evaluated pose.
fn crossing_muscles(model: &MuscleDynamics, joint: usize) -> Vec<usize> {
    let rows = model.moment_arms().chunks_exact(model.joints()).enumerate();
    rows.filter(|(_, row)| row[joint] != 0.0).map(|(k, _)| k).collect()
}
