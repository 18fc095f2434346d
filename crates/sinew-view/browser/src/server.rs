//! Serves the page's files and the synthetic machine's states, on loopback.

use crate::Outcome;
use crate::machine::{Machine, framed};
use serde_json::{Value, json};
use std::collections::VecDeque;
use std::io::{Read, Write};
use std::net::{TcpListener, TcpStream};
use std::path::Path;
use std::sync::atomic::{AtomicBool, Ordering};
use std::sync::{Arc, Mutex};
use std::time::Duration;
use tungstenite::protocol::Role;
use tungstenite::{Message, WebSocket};

/// Between two states.
const PERIOD: Duration = Duration::from_millis(16);
/// States whose positions are kept for comparison.
const KEPT: usize = 4000;

/// What the connections share.
#[derive(Default)]
struct Shared {
    machine: Mutex<Machine>,
    /// Number of a state and the poses in it.
    sent: Mutex<VecDeque<(f64, Vec<f64>)>>,
    /// Nothing is sent while it is set, as if the network were cut.
    silent: AtomicBool,
}

/// The server; its threads end with the program.
pub(crate) struct Server {
    port: u16,
    shared: Arc<Shared>,
}

impl Server {
    pub(crate) fn start() -> Outcome<Self> {
        let listener = TcpListener::bind("127.0.0.1:0").map_err(|e| format!("no port: {e}"))?;
        let port = listener.local_addr().map_err(|e| format!("no port: {e}"))?.port();
        let shared = Arc::new(Shared::default());
        let all = Arc::clone(&shared);
        std::thread::spawn(move || {
            for stream in listener.incoming().flatten() {
                let own = Arc::clone(&all);
                std::thread::spawn(move || answer(stream, &own));
            }
        });
        Ok(Self { port, shared })
    }

    pub(crate) fn address(&self) -> String {
        format!("http://127.0.0.1:{}/", self.port)
    }

    /// Cuts the connection, or heals it.
    pub(crate) fn silence(&self, silent: bool) {
        self.shared.silent.store(silent, Ordering::SeqCst);
    }

    /// Poses that were sent under a number.
    pub(crate) fn sent(&self, sequence: f64) -> Option<Vec<f64>> {
        let sent = self.shared.sent.lock().ok()?;
        sent.iter().find(|(number, _)| (number - sequence).abs() < 0.5).map(|(_, poses)| poses.clone())
    }
}

/// Answers one request; a connection that ends early needs no answer.
fn answer(mut stream: TcpStream, shared: &Shared) -> Option<()> {
    let mut head = Vec::new();
    let mut byte = [0; 1];
    while !head.ends_with(b"\r\n\r\n") && head.len() < 8192 {
        stream.read_exact(&mut byte).ok()?;
        head.push(byte[0]);
    }
    let head = String::from_utf8_lossy(&head).into_owned();
    let path = head.split(' ').nth(1)?.split(['?', '#']).next()?.to_owned();
    let field = |name: &str| {
        head.lines().find_map(|line| {
            line.split_once(": ").filter(|(n, _)| n.eq_ignore_ascii_case(name)).map(|(_, v)| v)
        })
    };
    if path == "/stream" {
        let accept = tungstenite::handshake::derive_accept_key(field("sec-websocket-key")?.as_bytes());
        let protocol = field("sec-websocket-protocol").map_or(String::new(), |all| {
            format!("Sec-WebSocket-Protocol: {}\r\n", all.split(',').next().unwrap_or_default().trim())
        });
        let reply = format!(
            "HTTP/1.1 101 Switching Protocols\r\nUpgrade: websocket\r\nConnection: \
                Upgrade\r\nSec-WebSocket-Accept: {accept}\r\n{protocol}\r\n"
        );
        stream.write_all(reply.as_bytes()).ok()?;
        return watch(stream, shared);
    }
    while shared.silent.load(Ordering::SeqCst) {
        std::thread::sleep(PERIOD);
    }
    let (kind, body) = match path.as_str() {
        "/scene" => ("application/json", Machine::scene().to_string().into_bytes()),
        "/" => ("text/html; charset=utf-8", file("index.html")?),
        other => (
            content_type(other),
            file(other.strip_prefix("/assets/").unwrap_or("missing")).unwrap_or_default(),
        ),
    };
    let status = if body.is_empty() { "404 Not Found" } else { "200 OK" };
    let head = format!(
        "HTTP/1.1 {status}\r\nContent-Type: {kind}\r\nContent-Length: {}\r\nContent-Security-Policy: \
            default-src 'self'\r\nConnection: close\r\n\r\n",
        body.len()
    );
    stream.write_all(head.as_bytes()).ok()?;
    stream.write_all(&body).ok()
}

/// A file of the page.
fn file(name: &str) -> Option<Vec<u8>> {
    let assets = Path::new(env!("CARGO_MANIFEST_DIR")).join("../assets");
    std::fs::read(assets.join(name)).ok().filter(|_| !name.contains(".."))
}

fn content_type(path: &str) -> &'static str {
    match path.rsplit('.').next() {
        Some("js") => "text/javascript; charset=utf-8",
        Some("css") => "text/css; charset=utf-8",
        Some("svg") => "image/svg+xml",
        _ => "text/plain; charset=utf-8",
    }
}

/// Sends states and takes commands until the page closes the connection.
fn watch(stream: TcpStream, shared: &Shared) -> Option<()> {
    stream.set_read_timeout(Some(PERIOD)).ok()?;
    let mut socket = WebSocket::from_raw_socket(stream, Role::Server, None);
    loop {
        let taken = match socket.read() {
            Ok(Message::Text(text)) => Some(text),
            Ok(Message::Close(_)) => return None,
            Ok(_) => None,
            Err(tungstenite::Error::Io(e))
                if matches!(e.kind(), std::io::ErrorKind::WouldBlock | std::io::ErrorKind::TimedOut) =>
            {
                None
            }
            Err(_) => return None,
        };
        if shared.silent.load(Ordering::SeqCst) {
            continue;
        }
        let mut machine = shared.machine.lock().ok()?;
        if let Some(text) = taken {
            let message: Value = serde_json::from_str(&text).unwrap_or_default();
            let outcome = machine.command(&message);
            let reply = json!({"id": message["id"], "ok": outcome.is_ok(), "error": outcome.err()});
            socket.send(Message::Binary(framed(4, reply.to_string().as_bytes()).into())).ok()?;
            continue;
        }
        machine.turn(PERIOD.as_secs_f64());
        let (message, poses) = machine.message();
        let number = f64::from_le_bytes(message.get(24..32)?.try_into().ok()?);
        drop(machine);
        let mut sent = shared.sent.lock().ok()?;
        sent.push_back((number, poses));
        if sent.len() > KEPT {
            sent.pop_front();
        }
        drop(sent);
        socket.send(Message::Binary(message.into())).ok()?;
    }
}
