//! The robot's end of a link.
//!
//! ```text
//! Server thread                     control cycle
//!   UDP -> Sessions::receive  --queue-->  Port::next_input
//!   UDP <- Sessions::state    <-queue--   Port::publish
//! ```
//!
//! Both queues are wait-free rings of fixed size: whatever comes in, the cycle never waits for the server.
//! [`Sessions`] knows no sockets and no clock.

mod attached;
mod domain;
mod local;
mod newest;
mod offers;
mod outcome;
mod port;
mod rate;
mod server;
mod sessions;

pub use domain::Domain;
pub use local::Local;
pub use offers::RandomSource;
pub use outcome::Outcome;
pub use port::{Input, Port};
pub use rate::RateLimit;
pub use server::{Server, ServerSettings};
pub use sessions::{SessionSettings, Sessions, WATCHERS};
