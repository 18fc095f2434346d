//! `sinew export serve`: the process behind a unit of a plant.

use super::plant::PlantFile;
use crate::answer::{Answer, Content};
use crate::error::Error;
use std::collections::HashMap;
use std::io::{Read, Write};
use std::path::Path;

/// Orders in the place of a step; the number behind them is that of a state, 0 of the beginning.
const SAVE: f64 = -2.0;
const RESTORE: f64 = -3.0;
const DROP: f64 = -4.0;

pub(super) fn run(file: &Path) -> Result<Answer, Error> {
    let text = crate::verbs::read_text(file)?;
    let damaged =
        |error: serde_json::Error| Error::Unreadable { file: file.to_owned(), source: error.into() };
    let described: PlantFile = serde_json::from_str(&text).map_err(damaged)?;
    let mut plant = described.build()?;
    let (mut input, mut output) = (std::io::stdin().lock(), std::io::stdout().lock());
    let mut message = vec![0; 8 * (1 + plant.inputs())];
    let mut kept = HashMap::from([(0.0_f64.to_bits(), plant.clone())]);
    let mut done = true;
    loop {
        let numbers = [f64::from(u8::from(!done))].into_iter().chain(plant.outputs());
        let bytes: Vec<u8> = numbers.flat_map(f64::to_ne_bytes).collect();
        output.write_all(&bytes).and_then(|()| output.flush()).map_err(Error::Stdout)?;
        // Whoever is gone asks nothing more.
        if input.read_exact(&mut message).is_err() {
            return Ok(Answer::done(Content::Text(String::new()), Vec::new()));
        }
        let (numbers, _) = message.as_chunks::<8>();
        let numbers: Vec<f64> = numbers.iter().map(|number| f64::from_ne_bytes(*number)).collect();
        let (order, state) = (numbers[0], numbers[1].to_bits());
        done = if order.to_bits() == SAVE.to_bits() {
            kept.insert(state, plant.clone());
            true
        } else if order.to_bits() == RESTORE.to_bits() {
            kept.get(&state).map(|state| plant = state.clone()).is_some()
        } else if order.to_bits() == DROP.to_bits() {
            kept.remove(&state).is_some()
        } else {
            plant.step(order, &numbers[1..])
        };
    }
}
