//! The page's files, `/scene` and `/stream` over HTTP.

use crate::access::{Access, PROTOCOL};
use crate::beside::{Beside, Picture};
use crate::command::{Command, MAX_COMMAND};
use crate::error::LiveError;
use crate::layout::{MessageKind, message};
use crate::source::Source;
use axum::Router;
use axum::extract::ws::{Message, WebSocket, WebSocketUpgrade};
use axum::extract::{Path, Request, State};
use axum::http::header::{CACHE_CONTROL, CONTENT_SECURITY_POLICY, CONTENT_TYPE};
use axum::http::{HeaderMap, StatusCode};
use axum::middleware::{Next, from_fn_with_state};
use axum::response::{IntoResponse, Response};
use axum::routing::get;
use serde_json::{Value, json};
use std::collections::VecDeque;
use std::net::{IpAddr, Ipv4Addr, Ipv6Addr, SocketAddr, TcpListener};
use std::sync::Arc;
use std::sync::atomic::{AtomicBool, AtomicUsize, Ordering};
use std::sync::mpsc;
use std::thread::JoinHandle;
use std::time::{Duration, Instant};
use tokio::sync::{oneshot, watch};

/// Between two states.
const PICTURE: Duration = Duration::from_micros(16_667);
/// Share of a picture's time in which the simulation may run.
const BUDGET: f64 = 0.85;
/// Commands that wait at most.
const WAITING: usize = 64;
/// Viewers at most.
const VIEWERS: usize = 32;
/// Time in which a viewer takes a message; one that does not is gone.
const PATIENCE: Duration = Duration::from_secs(10);
/// Silence after which a viewer gets the last state again, while another motion is prepared or many cycles are stepped.
const SILENCE: Duration = Duration::from_millis(400);

/// Where and what a server serves.
pub struct ServerSettings {
    /// Where it listens; port 0 for any that is free.
    pub address: SocketAddr,
    /// What is shown.
    pub source: Box<dyn Source>,
    /// Where Foxglove's protocol is served as well, on loopback; needs the feature `foxglove`.
    pub foxglove: Option<SocketAddr>,
}

/// A page in service; its threads end when it is dropped.
pub struct Server {
    address: SocketAddr,
    foxglove: Option<SocketAddr>,
    token: Option<String>,
    ended: Arc<AtomicBool>,
    stop: Option<oneshot::Sender<()>>,
    threads: Vec<JoinHandle<()>>,
}

/// What is asked of the source, and where the answer goes.
enum Order {
    Command(Command, oneshot::Sender<Result<(), String>>),
    History(oneshot::Sender<Option<Vec<u8>>>),
}

/// What requests share.
struct Shared {
    access: Access,
    pictures: watch::Receiver<Picture>,
    orders: mpsc::SyncSender<Order>,
    viewers: AtomicUsize,
}

impl Server {
    /// Begins to listen and to show.
    ///
    /// # Errors
    /// [`LiveError::Address`] for an address that cannot be listened on; those of the source's first picture.
    pub fn start(settings: ServerSettings) -> Result<Self, LiveError> {
        let ServerSettings { address, mut source, foxglove } = settings;
        let mut beside = Beside::start(foxglove)?;
        let foxglove = beside.address(foxglove);
        let refused = |error| LiveError::Address { address, source: error };
        let system = |error: &dyn std::fmt::Display| LiveError::System(error.to_string());
        let listener = TcpListener::bind(address).map_err(refused)?;
        let address = listener.local_addr().map_err(refused)?;
        listener.set_nonblocking(true).map_err(refused)?;
        let access = Access::new(address).map_err(|error| system(&error))?;
        let token = access.token().map(str::to_owned);
        let (sender, pictures) = watch::channel(picture(source.as_mut())?);
        let (orders, waiting) = mpsc::sync_channel(WAITING);
        let viewers = AtomicUsize::new(0);
        let shared = Arc::new(Shared { access, pictures, orders, viewers });
        let ended = Arc::new(AtomicBool::new(false));
        let (stop, stopped) = oneshot::channel();
        let runtime = tokio::runtime::Builder::new_current_thread().enable_io().enable_time().build();
        let runtime = runtime.map_err(|error| system(&error))?;
        let flag = Arc::clone(&ended);
        let named = |name: &str| std::thread::Builder::new().name(name.to_owned());
        let showing =
            named("source").spawn(move || show(source.as_mut(), &waiting, &sender, (&mut beside, &flag)));
        let showing = showing.map_err(|error| system(&error))?;
        let serving = named("page").spawn(move || {
            runtime.block_on(async {
                let Ok(listener) = tokio::net::TcpListener::from_std(listener) else { return };
                let serving = axum::serve(listener, router(shared)).into_future();
                tokio::select! { _ = serving => {}, _ = stopped => {} }
            });
        });
        let serving = serving.map_err(|error| system(&error))?;
        Ok(Self { address, foxglove, token, ended, stop: Some(stop), threads: vec![showing, serving] })
    }

    /// Where it listens.
    #[must_use]
    pub fn address(&self) -> SocketAddr {
        self.address
    }

    /// Where Foxglove's protocol is served, if it is.
    #[must_use]
    pub fn foxglove(&self) -> Option<SocketAddr> {
        self.foxglove
    }

    /// Address of the page, with the token in its fragment, which browsers send to nobody. A server that listens on all addresses
    /// of this computer is named by its loopback: from elsewhere it is opened by whichever address leads here.
    #[must_use]
    pub fn url(&self) -> String {
        let fragment = self.token.as_ref().map_or(String::new(), |token| format!("#token={token}"));
        let mut named = self.address;
        if named.ip().is_unspecified() {
            named.set_ip(match named.ip() {
                IpAddr::V4(_) => Ipv4Addr::LOCALHOST.into(),
                IpAddr::V6(_) => Ipv6Addr::LOCALHOST.into(),
            });
        }
        format!("http://{named}/{fragment}")
    }

    /// Whether the source has ended by itself, because it failed.
    #[must_use]
    pub fn has_failed(&self) -> bool {
        self.threads.first().is_none_or(JoinHandle::is_finished)
    }
}

impl Drop for Server {
    fn drop(&mut self) {
        self.ended.store(true, Ordering::Relaxed);
        if let Some(stop) = self.stop.take() {
            // A server that has ended already needs no word.
            let _ = stop.send(());
        }
        for thread in self.threads.drain(..) {
            let _ = thread.join();
        }
    }
}

fn picture(source: &mut dyn Source) -> Result<Picture, LiveError> {
    let scene = Arc::new(source.scene()?.to_string());
    Ok(Picture { revision: source.revision(), state: Arc::new(source.state()?), scene })
}

/// Lets time pass on the source until the server ends: what is asked of it, its time, a picture.
fn show(
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

fn router(shared: Arc<Shared>) -> Router {
    Router::new()
        .route("/", get(|| async { file("index.html") }))
        .route("/assets/{*path}", get(|Path(path): Path<String>| async move { file(&path) }))
        .route("/scene", get(scene))
        .route("/history", get(history))
        .route("/stream", get(stream))
        .layer(from_fn_with_state(Arc::clone(&shared), guard))
        .with_state(shared)
}

/// Requests by another name or from another page are refused.
async fn guard(State(shared): State<Arc<Shared>>, request: Request, next: Next) -> Response {
    if !shared.access.is_own(request.headers()) {
        let words = "This server answers requests for its own address from its own page only.";
        return (StatusCode::FORBIDDEN, words).into_response();
    }
    next.run(request).await
}

fn file(path: &str) -> Response {
    let Some(asset) = sinew_view::asset(path) else { return StatusCode::NOT_FOUND.into_response() };
    let headers = [
        (CONTENT_TYPE, asset.content_type),
        (CONTENT_SECURITY_POLICY, "default-src 'self'; frame-ancestors 'none'"),
        (CACHE_CONTROL, "no-cache"),
    ];
    (headers, asset.bytes).into_response()
}

async fn scene(State(shared): State<Arc<Shared>>, headers: HeaderMap) -> Response {
    if !shared.access.is_authorized(&headers) {
        return unauthorized();
    }
    let scene = Arc::clone(&shared.pictures.borrow().scene);
    ([(CONTENT_TYPE, "application/json"), (CACHE_CONTROL, "no-store")], scene.as_str().to_owned())
        .into_response()
}

/// The signals before now, where the source has them.
async fn history(State(shared): State<Arc<Shared>>, headers: HeaderMap) -> Response {
    if !shared.access.is_authorized(&headers) {
        return unauthorized();
    }
    let (sender, receiver) = oneshot::channel();
    if shared.orders.try_send(Order::History(sender)).is_err() {
        return StatusCode::SERVICE_UNAVAILABLE.into_response();
    }
    match receiver.await {
        Ok(Some(rows)) => {
            ([(CONTENT_TYPE, "application/octet-stream"), (CACHE_CONTROL, "no-store")], rows).into_response()
        }
        Ok(None) => StatusCode::NO_CONTENT.into_response(),
        Err(_) => StatusCode::SERVICE_UNAVAILABLE.into_response(),
    }
}

fn unauthorized() -> Response {
    let words = "The token is missing or wrong: open the address that the program printed, with what stands behind the #.";
    (StatusCode::UNAUTHORIZED, words).into_response()
}

async fn stream(
    State(shared): State<Arc<Shared>>,
    headers: HeaderMap,
    upgrade: WebSocketUpgrade,
) -> Response {
    if !shared.access.is_authorized(&headers) {
        return unauthorized();
    }
    let Some(place) = ViewerPlace::take(&shared) else {
        return (StatusCode::SERVICE_UNAVAILABLE, "Too many pages are open.").into_response();
    };
    let upgrade = upgrade.protocols([PROTOCOL]).max_message_size(MAX_COMMAND).max_frame_size(MAX_COMMAND);
    upgrade.on_upgrade(move |socket| async move {
        // A connection that ends needs no answer.
        let _ = watch_source(socket, &place.0).await;
    })
}

/// One of the places for viewers, given back where it is dropped, also by a connection that never came about.
struct ViewerPlace(Arc<Shared>);

impl ViewerPlace {
    fn take(shared: &Arc<Shared>) -> Option<Self> {
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
async fn watch_source(mut socket: WebSocket, shared: &Shared) -> Option<()> {
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
