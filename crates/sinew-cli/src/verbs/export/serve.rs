//! `sinew export serve`: the process behind a unit of a plant.

use super::plant::{PlantFile, SimulatedPlant};
use crate::answer::{Answer, Content};
use crate::error::Error;
use std::collections::HashMap;
use std::io::{Read, Write};
use std::path::Path;
use std::rc::Rc;

/// Orders in the place of a step; the number behind them is that of a state, 0 of the beginning.
const SAVE: f64 = -2.0;
const RESTORE: f64 = -3.0;
const DROP: f64 = -4.0;
/// The answer is followed by how many messages lead from the beginning to the state, and by these.
const WRITE: f64 = -5.0;
/// The order is followed by what [`WRITE`] gave: the state is where these messages lead.
const READ: f64 = -6.0;

pub(super) fn run(file: &Path) -> Result<Answer, Error> {
    let text = crate::verbs::read_text(file)?;
    let damaged =
        |error: serde_json::Error| Error::Unreadable { file: file.to_owned(), source: error.into() };
    let described: PlantFile = serde_json::from_str(&text).map_err(damaged)?;
    let mut states = States::new(described.build()?);
    let (mut input, mut output) = (std::io::stdin().lock(), std::io::stdout().lock());
    let (mut done, mut follows) = (true, Vec::new());
    loop {
        let answer = [f64::from(u8::from(!done))].into_iter().chain(states.now.plant.outputs());
        let bytes: Vec<u8> = answer.chain(follows).flat_map(f64::to_ne_bytes).collect();
        output.write_all(&bytes).and_then(|()| output.flush()).map_err(Error::Stdout)?;
        // Whoever is gone asks nothing more.
        let Some(message) = states.receive(&mut input) else {
            return Ok(Answer::done(Content::Text(String::new()), Vec::new()));
        };
        follows = Vec::new();
        let (order, number) = (message[0], message[1].to_bits());
        done = if order.to_bits() == SAVE.to_bits() {
            states.kept.insert(number, states.now.clone());
            true
        } else if order.to_bits() == RESTORE.to_bits() {
            states.restore(number).is_some()
        } else if order.to_bits() == DROP.to_bits() {
            states.kept.remove(&number).is_some()
        } else if order.to_bits() == WRITE.to_bits() {
            let messages = states.kept.get(&number).map(|state| states.messages(state.at));
            follows = messages.clone().unwrap_or_default();
            messages.is_some()
        } else if order.to_bits() == READ.to_bits() {
            states.repeat(number, &mut input).is_some()
        } else {
            states.step(&message)
        };
    }
}

/// A plant, and the last of the messages that led to it: its place in [`States::history`].
#[derive(Clone)]
struct State {
    plant: SimulatedPlant,
    at: Option<usize>,
}

/// A message of a step, after another one.
struct Step {
    before: Option<usize>,
    seconds: f64,
    /// Shared with the step before where they are the same: most units hold most inputs over many steps.
    inputs: Rc<[f64]>,
}

/// The plant, states of it that are kept by number, and how each was reached.
///
/// A twin has queues of delays, random numbers and rows of lanes; that a state can be written as the messages
/// that lead to it needs none of them, because the same messages give the same bits.
struct States {
    now: State,
    kept: HashMap<u64, State>,
    history: Vec<Step>,
}

impl States {
    fn new(plant: SimulatedPlant) -> Self {
        let now = State { plant, at: None };
        Self { kept: HashMap::from([(0.0_f64.to_bits(), now.clone())]), now, history: Vec::new() }
    }

    /// The next message: a step's length, s, or an order, and the inputs; none at the end.
    fn receive(&self, input: &mut impl Read) -> Option<Vec<f64>> {
        (0..=self.now.plant.inputs()).map(|_| number(input)).collect()
    }

    /// Goes to a state that is kept.
    fn restore(&mut self, number: u64) -> Option<()> {
        self.now = self.kept.get(&number)?.clone();
        // Behind the beginning alone there is no history.
        if self.now.at.is_none() && self.kept.len() == 1 {
            self.history.clear();
        }
        Some(())
    }

    /// A step of the plant; whether it could.
    fn step(&mut self, message: &[f64]) -> bool {
        let (seconds, inputs) = (message[0], &message[1..]);
        let alike =
            |held: &&Rc<[f64]>| held.iter().map(|x| x.to_bits()).eq(inputs.iter().map(|x| x.to_bits()));
        let held = self.now.at.map(|at| &self.history[at].inputs).filter(alike);
        let inputs = held.map_or_else(|| inputs.into(), Rc::clone);
        // One that fails may have moved the plant, too.
        let done = self.now.plant.step(seconds, &inputs);
        self.history.push(Step { before: self.now.at, seconds, inputs });
        self.now.at = Some(self.history.len() - 1);
        done
    }

    /// How many messages lead to a place in the history, and these from the beginning on.
    fn messages(&self, at: Option<usize>) -> Vec<f64> {
        let before = |step: &&Step| step.before.map(|k| &self.history[k]);
        let steps: Vec<&Step> = std::iter::successors(at.map(|k| &self.history[k]), before).collect();
        let rows =
            steps.iter().rev().flat_map(|step| [step.seconds].into_iter().chain(step.inputs.iter().copied()));
        [steps.len() as f64].into_iter().chain(rows).collect()
    }

    /// Keeps the state to which messages lead from the beginning; none where they end early.
    fn repeat(&mut self, number: u64, input: &mut impl Read) -> Option<()> {
        let beginning = self.kept.get(&0.0_f64.to_bits())?.clone();
        let now = std::mem::replace(&mut self.now, beginning);
        let mut left = self::number(input)?;
        while left > 0.5 {
            let message = self.receive(input)?;
            self.step(&message);
            left -= 1.0;
        }
        let there = std::mem::replace(&mut self.now, now);
        self.kept.insert(number, there);
        Some(())
    }
}

/// The next number of 64 bits; none at the end.
fn number(input: &mut impl Read) -> Option<f64> {
    let mut bytes = [0; 8];
    input.read_exact(&mut bytes).ok().map(|()| f64::from_ne_bytes(bytes))
}
