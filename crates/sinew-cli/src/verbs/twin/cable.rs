//! `sinew twin cable`.

use super::scenario::Scenario;
use crate::answer::{Answer, Content, Outcome};
use crate::arguments::{General, TwinCableArguments};
use crate::error::Error;
use crate::output::{refuse_overwrite, write_all};
use sinew::transmission::Sliding;
use sinew::transmission::cable::EndMotion;
use sinew::twin::cable::Specimen;
use sinew::twin::cable::{CablePlant, Resolution};
use sinew_report::cable::{self, Frame};
use sinew_report::colours;
use std::fmt::Write;

/// Step of the log, s.
const STEP: f64 = 1e-3;
/// Frames of a picture.
const FRAMES: usize = 360;

pub(super) fn run(arguments: &TwinCableArguments, general: &General) -> Result<Answer, Error> {
    let outputs: Vec<_> =
        [Some(arguments.out.clone()), arguments.picture.clone()].into_iter().flatten().collect();
    refuse_overwrite(arguments.scenario.iter(), &outputs, general.no_clobber)?;
    let scenario = match &arguments.scenario {
        Some(path) => Scenario::read(path)?,
        None => Scenario::default_scenario(),
    };
    let Simulation { log, frames, most, broken } =
        simulate(&arguments.specimen.specimen, arguments.start, &scenario)?;
    let mut files = vec![(arguments.out.clone(), log.into_bytes())];
    if let Some(path) = &arguments.picture {
        files.push((
            path.clone(),
            cable::draw(&frames, "Prescribed motion of both ends", &colours::STANDALONE).into_bytes(),
        ));
    }
    let borrowed: Vec<_> = files.iter().map(|(path, bytes)| (path.clone(), bytes.as_slice())).collect();
    let written = write_all(&borrowed)?;
    let content = if general.json {
        Content::json(&serde_json::json!({
            "simulated": true, "duration_s": scenario.duration(), "max_tension_in_n": most[0], "max_tension_out_n": most[1],
            "broken": broken.map(|Break { time_s, tension_n }| serde_json::json!({"time_s": time_s, "tension_n": tension_n})),
        }))?
    } else {
        let end = broken.map_or_else(String::new, |broken| format!(" At the end {}.", broken.sentence()));
        Content::Text(format!(
            "SIMULATED cable, {:.1} s: max. near tension {:.1} N, max. far tension {:.1} N.{end}\n",
            scenario.duration(),
            most[0],
            most[1]
        ))
    };
    Ok(Answer { outcome: Outcome::new(broken.is_none()), content, written })
}

/// When and under which tension the cable broke.
#[derive(Debug, Clone, Copy)]
struct Break {
    time_s: f64,
    tension_n: f64,
}

impl Break {
    fn sentence(self) -> String {
        format!("the cable broke at {:.3} s under {:.1} N", self.time_s, self.tension_n)
    }
}

/// The picture of two strokes of the bench specimen, for the report.
pub(in crate::verbs) fn two_strokes() -> Result<String, Error> {
    let Simulation { frames, .. } = simulate(&Specimen::bench(), 60.0, &Scenario::two_strokes())?;
    Ok(cable::draw(&frames, "Two strokes, anchor fixed", &colours::PAGE))
}

/// A cable under its scenario.
struct Simulation {
    /// CSV.
    log: String,
    /// Of a picture.
    frames: Vec<Frame>,
    /// Largest near and far tension, N.
    most: [f64; 2],
    broken: Option<Break>,
}

fn simulate(specimen: &Specimen, start: f64, scenario: &Scenario) -> Result<Simulation, Error> {
    let mut cable = CablePlant::new(specimen, Resolution { cells: 32, substeps: 4 })?;
    cable.settle(start, Sliding::TowardMotor)?;
    let mut log = String::from(
        "# SIMULATED by sinew twin cable\n\
         time_s,position_in_m,anchor_m,tension_in_n,tension_out_n,elongation_m\n",
    );
    let (mut frames, mut most) = (Vec::new(), [0.0_f64; 2]);
    #[expect(
        clippy::cast_possible_truncation,
        clippy::cast_sign_loss,
        reason = "a duration of at most an hour"
    )]
    let steps = (scenario.duration() / STEP).round() as usize;
    let mut last = scenario.at(0.0);
    for k in 1..=steps {
        #[expect(clippy::cast_precision_loss, reason = "a few million steps")]
        let time = k as f64 * STEP;
        let now = scenario.at(time);
        let reading = cable.step(STEP, EndMotion { motor: now[0] - last[0], anchor: now[1] - last[1] })?;
        last = now;
        most = [most[0].max(reading.tension_in), most[1].max(reading.tension_out)];
        // Writing into a string cannot fail.
        let _ = writeln!(
            log,
            "{time:.3},{:.7},{:.7},{:.3},{:.3},{:.7}",
            now[0], now[1], reading.tension_in, reading.tension_out, reading.stretch
        );
        if k * FRAMES / steps > (k - 1) * FRAMES / steps {
            frames.push(Frame {
                time,
                motor: now[0],
                tension_in: reading.tension_in,
                tension_out: reading.tension_out,
                profile: cable.tensions().collect(),
                slips: cable.slips().collect(),
            });
        }
        if let Some(broken) = reading.broken {
            let broken = Break { time_s: time, tension_n: broken.tension };
            let _ = writeln!(log, "# {}", broken.sentence());
            return Ok(Simulation { log, frames, most, broken: Some(broken) });
        }
    }
    Ok(Simulation { log, frames, most, broken: None })
}
