//! The server of a page: one thread advances the source, one answers requests.

use crate::access::Access;
use crate::beside::Beside;
use crate::connections::{Connections, HEADER_TIME};
use crate::error::LiveError;
use crate::routes::router;
use crate::show::{picture, show};
use crate::source::Source;
use crate::viewer::{Shared, WAITING};
use axum::{Extension, Router};
use hyper::server::conn::http1;
use hyper_util::rt::{TokioIo, TokioTimer};
use hyper_util::service::TowerToHyperService;
use std::net::{IpAddr, Ipv4Addr, Ipv6Addr, SocketAddr, TcpListener};
use std::sync::Arc;
use std::sync::atomic::{AtomicBool, AtomicUsize, Ordering};
use std::sync::mpsc;
use std::thread::JoinHandle;
use std::time::Duration;
use tokio::sync::{oneshot, watch};

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

impl Server {
    /// Begins to listen and to show.
    ///
    /// # Errors
    /// [`LiveError::Address`] for an address that cannot be listened on; [`LiveError::Foxglove`];
    /// [`LiveError::System`] where the system refuses a thread, a runtime or random numbers; those of
    /// [`Source::scene`] and [`Source::state`].
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
                tokio::select! { () = answer(listener, router(shared)) => {}, _ = stopped => {} }
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

    /// Address of the page; off loopback with the token in its fragment, which browsers do not transmit. For
    /// a server bound to all addresses it names the loopback address; other hosts use any address of this
    /// computer.
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

    /// Whether the thread of the source has ended because the source failed.
    #[must_use]
    pub fn has_failed(&self) -> bool {
        self.threads.first().is_none_or(JoinHandle::is_finished)
    }
}

/// Pause after a connection that could not be accepted.
const PAUSE: Duration = Duration::from_millis(100);

/// Answers all connections, indefinitely.
async fn answer(listener: tokio::net::TcpListener, router: Router) {
    let connections = Connections::default();
    loop {
        let Ok((stream, from)) = listener.accept().await else {
            tokio::time::sleep(PAUSE).await;
            continue;
        };
        let Some((connection, closed)) = connections.admit(from.ip()) else { continue };
        let service = TowerToHyperService::new(router.clone().layer(Extension(connection.clone())));
        let mut http = http1::Builder::new();
        http.timer(TokioTimer::new()).header_read_timeout(HEADER_TIME);
        let served = http.serve_connection(TokioIo::new(stream), service).with_upgrades();
        tokio::spawn(async move {
            let _place = connection;
            tokio::select! { _ = served => {}, _ = closed => {} }
        });
    }
}

impl Drop for Server {
    fn drop(&mut self) {
        self.ended.store(true, Ordering::Relaxed);
        if let Some(stop) = self.stop.take() {
            // The receiver is gone where the server has already ended.
            let _ = stop.send(());
        }
        for thread in self.threads.drain(..) {
            let _ = thread.join();
        }
    }
}
