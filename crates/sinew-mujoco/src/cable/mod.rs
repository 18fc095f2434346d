//! `sinew.cable`: a winch and an elastic cable in its sheath in the place of a tendon's actuator.
//!
//! The control, or the activation where the actuator has one, is the displacement of the winch, m. The state
//! of a cable is that after the last complete time step. Every call of `compute` takes a trial step from it
//! to the present length of the tendon and position of the winch, and its tension acts without delay;
//! `advance` keeps the trial. Runge-Kutta computes four trials in a step, of which the first belongs to the
//! step's beginning and is kept.

mod law;
mod trial;

use crate::plugin::{Plugin, Setup};
use crate::text::{Config, entries, matches};
use crate::view::{Data, Model, index};
use crate::wiring::Wirings;
use law::Written;
use sinew::transmission::Sliding;
use sinew::transmission::cable::{CableBatch, EndMotion, EndTensions};
use std::cell::RefCell;
use std::ffi::CStr;
use std::thread::LocalKey;
use trial::{Moment, Trial};

/// Numbers of state beside those of the cable's law: whether it began, tendon length, winch, time.
const HEAD: usize = 4;
/// Longest time step of the law, s, and largest motion of an end in it, m.
const LONGEST: f64 = 0.02;
const FARTHEST: f64 = 0.1;
/// Most substeps of one step: beyond it a motion is cut short.
const MAX_SUBSTEPS: usize = 64;

/// One cable with its actuator.
struct Winch {
    tendon: usize,
    force: usize,
    control: usize,
    activation: Option<usize>,
    start: f64,
}

/// The cables of one plugin instance.
pub(crate) struct Cables {
    winches: Vec<Winch>,
    batch: CableBatch,
    substeps: usize,
    motions: Vec<EndMotion>,
    ends: Vec<EndTensions>,
    trial: Trial,
}

thread_local! {
    static WIRINGS: RefCell<Wirings<Cables>> = const { RefCell::new(Wirings::new()) };
}

/// A whole number of the configuration.
fn count(config: &[String], at: usize, name: &str, default: usize, most: usize) -> Result<usize, String> {
    let text = config.get(at).map_or("", |text| text.trim());
    if text.is_empty() {
        return Ok(default);
    }
    let value = text.parse().ok().filter(|value| (1..=most).contains(value));
    value.ok_or_else(|| format!("{name}: {text} must be a whole number from 1 to {most}"))
}

fn cells(config: &[String]) -> Result<usize, String> {
    count(config, 1, "cells", 12, 1024)
}

fn state_per_cable(cells: usize) -> usize {
    HEAD + 2 * cells + 1
}

/// Actuators of an instance.
fn actuators<'a>(model: &'a Model<'_>, instance: usize) -> impl Iterator<Item = usize> + 'a {
    (0..model.actuators).filter(move |&actuator| index(model.actuator_plugin.get(actuator)) == Some(instance))
}

impl Plugin for Cables {
    const NAME: &'static CStr = c"sinew.cable";
    const ATTRIBUTES: &'static [&'static CStr] = &[c"cables", c"cells", c"substeps"];

    fn state_len(model: &Model<'_>, instance: usize, config: &Config) -> usize {
        cells(config).map_or(0, |cells| actuators(model, instance).count() * state_per_cable(cells))
    }

    fn wire(setup: &Setup<'_>) -> Result<Self, String> {
        let (model, (config, _)) = (setup.model, setup.config());
        let cells = cells(config)?;
        let substeps = count(config, 2, "substeps", 1, MAX_SUBSTEPS)?;
        let text = config.first().map_or("", String::as_str);
        let entries = entries(text).map_err(|error| format!("cables: {error}"))?;
        let read = |entry: &crate::text::Entry<'_>| {
            let written =
                Written::read(&entry.pairs).map_err(|error| format!("cables: {}: {error}", entry.pattern))?;
            Ok((entry.pattern.to_owned(), written))
        };
        let entries = entries.iter().map(read).collect::<Result<Vec<_>, String>>()?;
        let (mut winches, mut laws) = (Vec::new(), Vec::new());
        for actuator in actuators(model, setup.instance) {
            let tendon = model.tendon_of(actuator);
            let tendon = tendon.ok_or_else(|| format!("actuator number {actuator} must pull on a tendon"))?;
            let name = model.tendon_name(tendon);
            let found = entries.iter().rev().find(|(pattern, _)| matches(pattern, &name));
            let (_, written) = found.ok_or_else(|| format!("cables: no pattern fits tendon {name}"))?;
            laws.push(written.law(cells).map_err(|error| format!("cables: {name}: {error}"))?);
            let address = index(model.actadr.get(actuator));
            let states = index(model.actnum.get(actuator)).filter(|states| *states > 0);
            winches.push(Winch {
                tendon,
                force: model.force_address(actuator),
                control: index(model.ctrladr.get(actuator)).unwrap_or(actuator),
                activation: address.zip(states).map(|(address, states)| address + states - 1),
                start: written.start,
            });
        }
        if winches.is_empty() {
            return Err("no actuator of the model uses this instance".into());
        }
        let batch = CableBatch::new(&laws).map_err(|error| error.to_string())?;
        let number = winches.len();
        if model.stateadr.get(setup.instance).is_none() {
            return Err("no such instance".into());
        }
        Ok(Self {
            winches,
            batch,
            substeps,
            motions: vec![EndMotion::default(); number],
            ends: vec![EndTensions::default(); number],
            trial: Trial::new(number * state_per_cable(cells)),
        })
    }

    fn compute(&mut self, model: &Model<'_>, data: &mut Data<'_>, instance: usize) {
        let Some(begin) = index(model.stateadr.get(instance)) else { return };
        let moment = Moment::new(model, data);
        if self.step(model, data, begin).is_err() {
            // Outside of the law's domain a cable does not pull.
            self.ends.fill(EndTensions::default());
        } else if self.trial.begins(&moment) {
            self.keep(data, moment);
        }
        for (winch, ends) in self.winches.iter().zip(&self.ends) {
            let gear = model.gear_of(winch.force);
            if let Some(force) = data.actuator_force.get_mut(winch.force) {
                *force = if gear == 0.0 { 0.0 } else { -ends.tension_out / gear };
            }
        }
    }

    fn advance(&mut self, model: &Model<'_>, data: &mut Data<'_>, instance: usize) {
        let Some(begin) = index(model.stateadr.get(instance)) else { return };
        if !self.trial.is_of(data.identity) {
            // Computed on another thread: once more, at the beginning of the step that ends now.
            let moment = Moment::new(model, data);
            if self.step(model, data, begin).is_err() {
                return;
            }
            self.keep(data, moment);
        }
        let kept = self.trial.take();
        if let Some(state) = data.plugin_state.get_mut(begin..begin + kept.len()) {
            state.copy_from_slice(kept);
        }
    }

    fn wirings() -> &'static LocalKey<RefCell<Wirings<Self>>> {
        &WIRINGS
    }
}

impl Cables {
    /// Length of the tendon and displacement of the winch, m.
    fn place(winch: &Winch, data: &Data<'_>) -> Option<(f64, f64)> {
        let length = *data.ten_length.get(winch.tendon)?;
        let moved = match winch.activation {
            Some(address) => *data.act.get(address)?,
            None => *data.ctrl.get(winch.control)?,
        };
        (length.is_finite() && moved.is_finite()).then_some((length, moved))
    }

    /// One trial step of all cables from the state of the last complete step.
    fn step(&mut self, model: &Model<'_>, data: &Data<'_>, begin: usize) -> Result<(), NotPossible> {
        let stride = HEAD + self.batch.state_len();
        let mut interval = model.timestep;
        let mut farthest: f64 = 0.0;
        let mut begun = 0;
        for (k, winch) in self.winches.iter().enumerate() {
            let state =
                data.plugin_state.get(begin + k * stride..begin + (k + 1) * stride).ok_or(NotPossible)?;
            let (head, cable) = state.split_at(HEAD);
            let (length, moved) = Self::place(winch, data).ok_or(NotPossible)?;
            self.motions[k] = EndMotion::default();
            if head[0] != 0.0 {
                self.batch.restore(k, cable).map_err(|_| NotPossible)?;
                // The anchor moves away from the motor where the tendon grows longer.
                self.motions[k] = EndMotion { motor: moved - head[2], anchor: head[1] - length };
                farthest = farthest.max(self.motions[k].motor.abs()).max(self.motions[k].anchor.abs());
                let passed = data.time - head[3];
                // One and a half and two steps are later stages of Runge-Kutta; the sum of time steps rounds,
                // and a time that was set by hand is no interval.
                let rounding = 1e-9 * model.timestep;
                let other = (passed - model.timestep).abs() > rounding;
                if other && passed > rounding && passed < 2.0 * model.timestep + rounding {
                    interval = passed;
                }
                begun += 1;
            }
        }
        if begun > 0 {
            let desired = (farthest / FARTHEST).max(interval / LONGEST).ceil();
            let substeps = self.substeps.max((desired.min(MAX_SUBSTEPS as f64)) as usize);
            let fraction = 1.0 / substeps as f64;
            for motion in &mut self.motions {
                let cut = |slide: f64| (slide * fraction).clamp(-FARTHEST, FARTHEST);
                *motion = EndMotion { motor: cut(motion.motor), anchor: cut(motion.anchor) };
            }
            let interval = (interval * fraction).clamp(1e-7, LONGEST);
            for _ in 0..substeps {
                self.batch.step(interval, &self.motions, &mut self.ends).map_err(|_| NotPossible)?;
            }
        }
        for (k, winch) in self.winches.iter().enumerate() {
            if data.plugin_state.get(begin + k * stride).is_some_and(|begun| *begun == 0.0) {
                self.batch.settle(k, winch.start, Sliding::TowardMotor).map_err(|_| NotPossible)?;
                let pretension = self.batch.law(k).map_or(0.0, |law| law.pretension());
                let last = self.batch.tensions(k).last().unwrap_or(0.0);
                self.ends[k] = EndTensions { tension_out: last + pretension, ..EndTensions::default() };
            }
        }
        Ok(())
    }

    /// Keeps what the cables are after a trial, for `advance`.
    fn keep(&mut self, data: &Data<'_>, moment: Moment) {
        let stride = HEAD + self.batch.state_len();
        let time = moment.time;
        let state = self.trial.fill(moment);
        for ((k, winch), state) in self.winches.iter().enumerate().zip(state.chunks_exact_mut(stride)) {
            let Some((length, moved)) = Self::place(winch, data) else { continue };
            let (head, cable) = state.split_at_mut(HEAD);
            head.copy_from_slice(&[1.0, length, moved, time]);
            // The lengths agree by construction.
            let _ = self.batch.save(k, cable);
        }
    }
}

/// A step outside of the law's domain.
struct NotPossible;
