//! The other end of a link: a session with a host.

mod blocking;
mod session;

pub use blocking::Client;
pub use session::{Arrived, ClientSession, Greeting};
