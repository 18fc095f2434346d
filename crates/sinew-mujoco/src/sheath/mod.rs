//! `sinew.sheath`: friction of sheaths on tendons.
//!
//! MuJoCo calls the plugin when the actuators' forces are known and the friction constraints stand, not yet
//! solved. Each tendon with a sheath has the pull `T` of its actuators; the plugin multiplies their forces by
//! `cosh theta` and writes `T sinh theta` as the bound of the tendon's friction constraint, whose solver
//! decides between sticking and both directions of sliding. So the tension at the far end is within
//! `T e^-theta` and `T e^theta` exactly.

mod law;
mod turning;

use crate::plugin::{Plugin, Setup};
use crate::text::{Config, entries, matches};
use crate::view::{Data, Model, TENDON_FRICTION, index};
use crate::wiring::Wirings;
use law::Sheath;
use std::cell::RefCell;
use std::ffi::CStr;
use std::ops::Range;
use std::thread::LocalKey;

/// One tendon with its sheath.
struct Wire {
    tendon: usize,
    law: Sheath,
    /// Its actuators in the list of all.
    actuators: Range<usize>,
    /// Its friction constraint in this step.
    row: Option<usize>,
}

/// An actuator of a tendon with a sheath.
struct Pull {
    actuator: usize,
    /// Of its force.
    address: usize,
}

/// The sheaths of one plugin instance.
pub(crate) struct Sheaths {
    wires: Vec<Wire>,
    pulls: Vec<Pull>,
    /// Place in `wires` of every tendon.
    wire_of: Vec<Option<usize>>,
}

thread_local! {
    static WIRINGS: RefCell<Wirings<Sheaths>> = const { RefCell::new(Wirings::new()) };
}

/// The sheath of every tendon; the last pattern that a name fits counts.
fn sheaths_of(model: &Model<'_>, config: &[String]) -> Result<Vec<Option<Sheath>>, String> {
    let text = config.first().map_or("", String::as_str);
    let entries = entries(text).map_err(|error| format!("sheaths: {error}"))?;
    let mut found = vec![None; model.tendons];
    let names: Vec<_> = (0..model.tendons).map(|tendon| model.tendon_name(tendon)).collect();
    for entry in entries {
        let law =
            Sheath::read(&entry.pairs).map_err(|error| format!("sheaths: {}: {error}", entry.pattern))?;
        let mut hits = 0;
        for (sheath, _) in found.iter_mut().zip(&names).filter(|(_, name)| matches(entry.pattern, name)) {
            *sheath = Some(law);
            hits += 1;
        }
        if hits == 0 {
            let known = if names.is_empty() { "it has none".into() } else { names.join(", ") };
            return Err(format!("sheaths: {} fits no tendon of the model: {known}", entry.pattern));
        }
    }
    Ok(found)
}

impl Plugin for Sheaths {
    const NAME: &'static CStr = c"sinew.sheath";
    const ATTRIBUTES: &'static [&'static CStr] = &[c"sheaths"];

    fn state_len(_: &Model<'_>, _: usize, _: &Config) -> usize {
        0
    }

    fn wire(setup: &Setup<'_>) -> Result<Self, String> {
        let model = setup.model;
        let (config, others) = setup.config();
        let laws = sheaths_of(model, config)?;
        let mut wiring = Self { wires: Vec::new(), pulls: Vec::new(), wire_of: vec![None; model.tendons] };
        for earlier in others {
            let twice =
                sheaths_of(model, earlier)?.iter().zip(&laws).position(|(a, b)| a.is_some() && b.is_some());
            if let Some(tendon) = twice {
                return Err(format!(
                    "tendon {} has sheaths of two plugin instances",
                    model.tendon_name(tendon)
                ));
            }
        }
        for (tendon, law) in laws.iter().enumerate() {
            let Some(law) = *law else { continue };
            let name = || model.tendon_name(tendon);
            if model.tendon_frictionloss.get(tendon).is_none_or(|loss| *loss <= 0.0) {
                return Err(format!(
                    "tendon {}: frictionloss must be above zero, 1e-9 for example, so that its friction \
                        constraint exists",
                    name()
                ));
            }
            let from = wiring.pulls.len();
            for actuator in (0..model.actuators).filter(|&actuator| model.tendon_of(actuator) == Some(tendon))
            {
                if model.is_cable(actuator) {
                    return Err(format!(
                        "tendon {}: its actuator number {actuator} is a cable, which has the friction of \
                            its own sheath; expected a sheath or a cable, not both",
                        name()
                    ));
                }
                if model.forcelimited.get(actuator).is_some_and(|limited| *limited != 0) {
                    return Err(format!(
                        "tendon {}: its actuator number {actuator} must have forcelimited=\"false\"; the \
                            plugin applies its forcerange before friction",
                        name()
                    ));
                }
                wiring.pulls.push(Pull { actuator, address: model.force_address(actuator) });
            }
            wiring.wire_of[tendon] = Some(wiring.wires.len());
            wiring.wires.push(Wire { tendon, law, actuators: from..wiring.pulls.len(), row: None });
        }
        Ok(wiring)
    }

    fn compute(&mut self, model: &Model<'_>, data: &mut Data<'_>, _: usize) {
        self.find_rows(data);
        for wire in &self.wires {
            let pulls = &self.pulls[wire.actuators.clone()];
            let mut tension = 0.0;
            for pull in pulls {
                let Some(force) = data.actuator_force.get_mut(pull.address) else { continue };
                if let Some([low, high]) = model.range_of(pull.actuator) {
                    *force = force.max(low).min(high);
                }
                tension -= *force * model.gear_of(pull.address);
            }
            // Without its constraint, where friction is disabled or the tendon sleeps, there is no friction.
            if let Some(row) = wire.row {
                let bound = if tension > 0.0 { slide(wire, pulls, tension, data) } else { 0.0 };
                // What the tendon has of its own is friction of the far side.
                let whole = bound + model.tendon_frictionloss.get(wire.tendon).copied().unwrap_or(0.0);
                if let Some(loss) = data.efc_frictionloss.get_mut(row) {
                    *loss = whole;
                }
                let row = index(data.map_efc2iefc.get(row));
                if let Some(loss) = row.and_then(|row| data.iefc_frictionloss.get_mut(row)) {
                    *loss = whole;
                }
            }
            if wire.law.pretension > 0.0 {
                add_tension(model, data, pulls, wire.law.pretension);
            }
        }
    }

    fn advance(&mut self, _: &Model<'_>, _: &mut Data<'_>, _: usize) {}

    fn wirings() -> &'static LocalKey<RefCell<Wirings<Self>>> {
        &WIRINGS
    }
}

impl Sheaths {
    /// Finds the friction constraints of all tendons.
    fn find_rows(&mut self, data: &Data<'_>) {
        for wire in &mut self.wires {
            wire.row = None;
        }
        for row in data.friction_rows.clone() {
            if data.efc_type.get(row) != Some(&TENDON_FRICTION) {
                continue;
            }
            let tendon = index(data.efc_id.get(row));
            if let Some(wire) = tendon.and_then(|tendon| *self.wire_of.get(tendon)?) {
                self.wires[wire].row = Some(row);
            }
        }
    }
}

/// Multiplies the forces on a tendon by `cosh theta`; returns the bound of its friction, N.
fn slide(wire: &Wire, pulls: &[Pull], tension: f64, data: &mut Data<'_>) -> f64 {
    let turning = if wire.law.turning > 0.0 { turning_of(data, wire.tendon) } else { 0.0 };
    let velocity = data.ten_velocity.get(wire.tendon).copied().unwrap_or(0.0);
    let grown = wire.law.angle(turning, velocity).exp();
    let mean = 0.5 * (grown + 1.0 / grown);
    for pull in pulls {
        if let Some(force) = data.actuator_force.get_mut(pull.address) {
            *force *= mean;
        }
    }
    0.5 * (grown - 1.0 / grown) * tension
}

/// Adds a constant tension through the first actuator that can pull.
fn add_tension(model: &Model<'_>, data: &mut Data<'_>, pulls: &[Pull], tension: f64) {
    let strongest = pulls.iter().find(|pull| model.gear_of(pull.address) != 0.0);
    let Some(address) = strongest.map(|pull| pull.address) else { return };
    if let Some(force) = data.actuator_force.get_mut(address) {
        *force -= tension / model.gear_of(address);
    }
}

/// Turning of a tendon's path, rad.
fn turning_of(data: &Data<'_>, tendon: usize) -> f64 {
    let place = index(data.ten_wrapadr.get(tendon)).zip(index(data.ten_wrapnum.get(tendon)));
    let found = place.and_then(|(from, count)| {
        let to = from.checked_add(count)?;
        Some((data.wrap_xpos.get(3 * from..3 * to)?, data.wrap_obj.get(from..to)?))
    });
    found.map_or(0.0, |(points, objects)| turning::turning(points, objects))
}
