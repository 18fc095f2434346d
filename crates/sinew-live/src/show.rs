//! The thread of what is shown: commands, the passing of time, pictures.

use crate::beside::{Beside, Picture};
use crate::command::Command;
use crate::error::LiveError;
use crate::source::Source;
use std::sync::Arc;
use std::sync::atomic::{AtomicBool, Ordering};
use std::sync::mpsc;
use std::time::{Duration, Instant};
use tokio::sync::{oneshot, watch};

/// Between two states.
const PICTURE: Duration = Duration::from_micros(16_667);
/// Fraction of a picture's time in which the simulation may run.
const BUDGET: f64 = 0.85;

/// What is asked of the source, and where the answer goes.
pub(crate) enum Order {
    Command(Command, oneshot::Sender<Result<(), String>>),
    History(oneshot::Sender<Option<Vec<u8>>>),
}

pub(crate) fn picture(source: &mut dyn Source) -> Result<Picture, LiveError> {
    let scene = Arc::new(source.scene()?.to_string());
    Ok(Picture { revision: source.revision(), state: Arc::new(source.state()?), scene })
}

/// Lets time pass on the source until the server ends: what is asked of it, its time, a picture.
pub(crate) fn show(
    source: &mut dyn Source,
    orders: &mpsc::Receiver<Order>,
    pictures: &watch::Sender<Picture>,
    (beside, ended): (&mut Beside, &AtomicBool),
) {
    let mut last = Instant::now();
    let mut next = None;
    while !ended.load(Ordering::Relaxed) {
        let begun = Instant::now();
        let passed = begun.duration_since(last).as_secs_f64();
        last = begun;
        while let Some(order) = next.take().or_else(|| orders.try_recv().ok()) {
            // The page may be gone.
            match order {
                Order::Command(command, outcome) => drop(outcome.send(source.command(&command))),
                Order::History(answer) => match source.history() {
                    Ok(rows) => drop(answer.send(rows)),
                    Err(_) => return,
                },
            }
        }
        let budget = PICTURE.mul_f64(BUDGET);
        // A command ends the advance: a stop must not wait for time that is still due.
        let mut is_spent = || {
            next = orders.try_recv().ok();
            next.is_some() || begun.elapsed() > budget
        };
        if source.advance(passed, &mut is_spent).is_err() {
            return;
        }
        let scene = Arc::clone(&pictures.borrow().scene);
        let changed = pictures.borrow().revision != source.revision();
        let picture = if changed {
            picture(source)
        } else {
            source.state().map(|state| Picture { revision: source.revision(), state: Arc::new(state), scene })
        };
        let Ok(picture) = picture else { return };
        beside.show(&picture);
        // Without viewers nobody takes it.
        pictures.send_replace(picture);
        // What is asked meanwhile is answered at once.
        next = next.or_else(|| orders.recv_timeout(PICTURE.saturating_sub(begun.elapsed())).ok());
    }
}
