//! Payload with the heat of the drives, and what would raise it.

use crate::error::Error;
use crate::output::one_line;
use crate::progress::Progress;
use crate::table::{number, table};
use sinew::control::capability::{CapabilityModel, HeldPayload};
use sinew::machine::{DesignChange, Machine};
use sinew_report::payload::{HeldFor, Limit, Payload, Raised, Spread};
use std::collections::BTreeMap;

/// Times for which a payload is held, s.
const TIMES: [(f64, &str); 4] =
    [(10.0, "10 s"), (60.0, "1 min"), (3600.0, "1 h"), (f64::INFINITY, "continuous")];

/// Changes that bear on payload.
const CHANGES: [DesignChange; 6] = [
    DesignChange::CoolerMotor,
    DesignChange::StrongerAmplifier,
    DesignChange::HigherTension,
    DesignChange::SmallerWinch,
    DesignChange::LessBend,
    DesignChange::LighterBody,
];

/// Of a machine in some poses; empty without gravity or end point.
pub(super) fn payload(machine: &Machine, poses: &[Vec<f64>], progress: &Progress) -> Result<Payload, Error> {
    let model = CapabilityModel::new(machine)?;
    let mut payload = Payload::default();
    for (seconds, words) in TIMES {
        let held = model.clone().holding_for(seconds).held_payloads(poses)?;
        if !held.iter().flatten().any(|held| held.mass.is_finite()) {
            return Ok(Payload::default());
        }
        payload.held.push(held_for(machine, (seconds, words), &held));
    }
    let [short, ever] = [payload.held.first(), payload.held.last()]
        .map(|held| held.map_or(f64::NAN, |held| held.spread.median_kg));
    let as_designed = Raised { change: "as designed", amount: "", short_kg: short, continuous_kg: ever };
    payload.raised.push(as_designed);
    for (k, change) in CHANGES.into_iter().enumerate() {
        progress.show("what would raise the payload", k as f64 / CHANGES.len() as f64);
        let model = CapabilityModel::new(&machine.with(change)?)?;
        let median = |seconds: f64| {
            let held = model.clone().holding_for(seconds).held_payloads(poses)?;
            Ok::<f64, Error>(Spread::new(&masses(&held)).median_kg)
        };
        payload.raised.push(Raised {
            change: change.name(),
            amount: change.amount(),
            short_kg: median(TIMES[0].0)?,
            continuous_kg: median(f64::INFINITY)?,
        });
    }
    Ok(payload)
}

fn masses(held: &[Option<HeldPayload>]) -> Vec<Option<f64>> {
    held.iter().map(|held| held.map(|held| held.mass)).collect()
}

fn held_for(
    machine: &Machine,
    (seconds, words): (f64, &'static str),
    held: &[Option<HeldPayload>],
) -> HeldFor {
    let mut counts = BTreeMap::new();
    held.iter()
        .flatten()
        .filter_map(|held| held.limited_by)
        .for_each(|one| *counts.entry(one).or_insert(0) += 1);
    let most = counts.into_iter().max_by_key(|(one, count)| (*count, std::cmp::Reverse(*one)));
    let each = masses(held);
    HeldFor {
        words,
        seconds: seconds.is_finite().then_some(seconds),
        poses: each.iter().flatten().count(),
        spread: Spread::new(&each),
        limited_by: most.map(|((muscle, limit), poses)| Limit {
            muscle: machine.robot.parts().tendons[muscle].name.clone(),
            limit: limit.name(),
            poses,
        }),
        each,
    }
}

/// Tables for the terminal.
pub(super) fn text(payload: &Payload, has_end_point: bool) -> String {
    if payload.held.is_empty() && has_end_point {
        return "\nNo payload: no gravity acts on the machine.\n".to_owned();
    }
    if payload.held.is_empty() {
        return "\nNo payload: the machine has no end point. In [task] of its file, `endpoint = \"SITE\"` in the \
                place of `space = \"joints\"` names a site of the body, and a site `endpoint` is one by itself.\n"
            .to_owned();
    }
    let row = |held: &HeldFor| {
        let Spread { min_kg, median_kg, max_kg } = held.spread;
        let mut cells = vec![held.words.to_owned(), held.poses.to_string()];
        cells.extend([min_kg, median_kg, max_kg].map(mass));
        let limit = held.limited_by.as_ref();
        let words =
            |one: &Limit| [format!("{}: {}", one_line(&one.muscle), one.limit), one.poses.to_string()];
        cells.extend(limit.map_or_else(|| [String::new(), String::new()], words));
        cells
    };
    let rows: Vec<Vec<String>> = payload.held.iter().map(row).collect();
    let mut text =
        "\nPayload held from room temperature on, kg; 0 where the machine itself is not held\n".to_owned();
    text += &table(&["for", "poses", "min", "median", "max", "limited by", "in poses"], &rows, 1);
    let row = |one: &Raised| {
        let [short, ever] = [one.short_kg, one.continuous_kg].map(mass);
        vec![one.change.to_owned(), one.amount.to_owned(), short, ever]
    };
    let rows: Vec<Vec<String>> = payload.raised.iter().map(row).collect();
    if payload.raised.iter().all(|one| one.short_kg.max(one.continuous_kg) < NOTHING_KG) {
        return text + "\nNo change of the design raises it: with all of them the machine holds no payload\n";
    }
    text += "\nWhat would raise it: the median after one change, kg\n";
    text += &table(&["", "", "for 10 s", "continuous"], &rows, 2);
    text
}

/// Payload that is the rounding of none, kg.
const NOTHING_KG: f64 = 1e-9;

/// A mass, kg.
fn mass(kg: f64) -> String {
    number(Some(if kg < NOTHING_KG { 0.0 } else { kg }))
}
