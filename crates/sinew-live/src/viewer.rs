//! A viewer: the states that it is sent, and its commands.

use crate::access::Access;
use crate::beside::Picture;
use crate::command::Command;
use crate::layout::{MessageKind, message};
use crate::show::Order;
use axum::extract::ws::{Message, WebSocket};
use serde_json::{Value, json};
use std::collections::VecDeque;
use std::sync::Arc;
use std::sync::atomic::{AtomicUsize, Ordering};
use std::sync::mpsc;
use std::time::Duration;
use tokio::sync::{oneshot, watch};

/// Commands that wait at most.
pub(crate) const WAITING: usize = 64;
/// Viewers at most.
const VIEWERS: usize = 32;
/// Time in which a viewer takes a message; one that does not is gone.
const PATIENCE: Duration = Duration::from_secs(10);
/// Silence after which a viewer gets the last state again, while another motion is prepared or many cycles
/// are stepped.
const SILENCE: Duration = Duration::from_millis(400);

/// What requests share.
pub(crate) struct Shared {
    pub(crate) access: Access,
    pub(crate) pictures: watch::Receiver<Picture>,
    pub(crate) orders: mpsc::SyncSender<Order>,
    pub(crate) viewers: AtomicUsize,
}

/// One of the places for viewers, given back where it is dropped, also by a connection that never came about.
pub(crate) struct ViewerPlace(pub(crate) Arc<Shared>);

impl ViewerPlace {
    pub(crate) fn take(shared: &Arc<Shared>) -> Option<Self> {
        let place = Self(Arc::clone(shared));
        (shared.viewers.fetch_add(1, Ordering::Relaxed) < VIEWERS).then_some(place)
    }
}

impl Drop for ViewerPlace {
    fn drop(&mut self) {
        self.0.viewers.fetch_sub(1, Ordering::Relaxed);
    }
}

/// Sends every new picture that the viewer is ready for, and takes its commands.
pub(crate) async fn watch_source(mut socket: WebSocket, shared: &Shared) -> Option<()> {
    let mut pictures = shared.pictures.clone();
    pictures.mark_changed();
    let mut revision = pictures.borrow().revision;
    // Commands are executed in the order in which they came.
    let mut asked = VecDeque::new();
    loop {
        tokio::select! {
            changed = pictures.changed() => {
                changed.ok()?;
                let picture = pictures.borrow_and_update().clone();
                if picture.revision != revision {
                    revision = picture.revision;
                    send(&mut socket, message(MessageKind::Scene, revision, &[])).await?;
                }
                send(&mut socket, picture.state.to_vec()).await?;
            }
            answer = outcome(asked.front_mut()) => {
                asked.pop_front();
                send(&mut socket, message(MessageKind::Answer, revision, answer.to_string().as_bytes())).await?;
            }
            () = tokio::time::sleep(SILENCE) => {
                let state = pictures.borrow().state.to_vec();
                send(&mut socket, state).await?;
            }
            received = socket.recv(), if asked.len() < WAITING => match received?.ok()? {
                Message::Text(text) => {
                    match order(text.as_str(), shared) {
                        Ok(waiting) => asked.push_back(waiting),
                        Err(answer) => {
                            send(&mut socket, message(MessageKind::Answer, revision, answer.to_string().as_bytes())).await?;
                        }
                    }
                }
                Message::Binary(_) => {
                    let answer = json!({"id": null, "ok": false, "error": "a command is a text, not binary data"});
                    send(&mut socket, message(MessageKind::Answer, revision, answer.to_string().as_bytes())).await?;
                }
                Message::Close(_) => return Some(()),
                Message::Ping(_) | Message::Pong(_) => {}
            },
        }
    }
}

async fn send(socket: &mut WebSocket, bytes: Vec<u8>) -> Option<()> {
    tokio::time::timeout(PATIENCE, socket.send(Message::Binary(bytes.into()))).await.ok()?.ok()
}

/// A command that waits for the source: its number and its outcome.
type Waiting = (Value, oneshot::Receiver<Result<(), String>>);

/// Hands a command to the source, or the answer that refuses it.
fn order(text: &str, shared: &Shared) -> Result<Waiting, Value> {
    let (id, command) = Command::parse(text).map_err(|(id, reason)| reply(&id, Err(reason)))?;
    let (sender, receiver) = oneshot::channel();
    match shared.orders.try_send(Order::Command(command, sender)) {
        Ok(()) => Ok((id, receiver)),
        Err(_) => Err(reply(&id, Err("too many commands wait; try again".to_owned()))),
    }
}

/// The answer to the first command that waits; never without one.
async fn outcome(first: Option<&mut Waiting>) -> Value {
    match first {
        None => std::future::pending().await,
        Some((id, receiver)) => {
            let outcome = receiver.await.unwrap_or_else(|_| Err("what is shown has ended".to_owned()));
            reply(id, outcome)
        }
    }
}

fn reply(id: &Value, outcome: Result<(), String>) -> Value {
    json!({"id": id, "ok": outcome.is_ok(), "error": outcome.err()})
}
