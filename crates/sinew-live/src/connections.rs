//! Connections of a page: so many from one address and in all, and none for longer than a request takes.
//!
//! Where a limit is reached, the connection that has waited longest for its request gives way to the new one:
//! who sends a request at once always finds a place, however many half-open connections others hold.

use std::net::{IpAddr, Ipv6Addr};
use std::sync::{Arc, Mutex, PoisonError};
use std::time::Duration;
use tokio::sync::oneshot;

/// Time in which a connection sends the header of its next request; one that does not is closed.
pub(crate) const HEADER_TIME: Duration = Duration::from_secs(5);
/// Connections from one address, and in all: fewer than the files that any system lets a program open.
const LIMITS: Limits = Limits { per_address: 64, in_all: 192 };

#[derive(Debug, Clone, Copy)]
struct Limits {
    per_address: usize,
    in_all: usize,
}

/// What a connection has got to; earlier ones give way first.
#[derive(Debug, Clone, Copy, PartialEq, Eq, PartialOrd, Ord)]
enum Stage {
    /// No whole header of a request has come.
    HalfOpen,
    /// A request was answered; another one may come.
    Answered,
    /// The states are streamed to it; it never gives way.
    Stream,
}

#[derive(Debug)]
struct Place {
    number: u64,
    address: IpAddr,
    stage: Stage,
    /// Dropped to close the connection.
    _open: oneshot::Sender<()>,
}

/// All open connections, in the order in which they came.
#[derive(Debug)]
struct Places {
    limits: Limits,
    places: Vec<Place>,
    next: u64,
}

/// The open connections of a server.
#[derive(Debug, Clone)]
pub(crate) struct Connections(Arc<Mutex<Places>>);

/// A place among them, given back when the last of its clones is dropped.
#[derive(Debug, Clone)]
pub(crate) struct Connection(Arc<Held>);

#[derive(Debug)]
struct Held {
    number: u64,
    connections: Connections,
}

impl Default for Connections {
    fn default() -> Self {
        Self::within(LIMITS)
    }
}

impl Connections {
    fn within(limits: Limits) -> Self {
        Self(Arc::new(Mutex::new(Places { limits, places: Vec::new(), next: 0 })))
    }

    /// A place for a connection from this address, and what ends when it has to give way; none where all
    /// places stream.
    pub(crate) fn admit(&self, address: IpAddr) -> Option<(Connection, oneshot::Receiver<()>)> {
        let (open, closed) = oneshot::channel();
        let number = self.with(|places| places.admit(network_of(address), open))?;
        Some((Connection(Arc::new(Held { number, connections: self.clone() })), closed))
    }

    /// A thread that panicked leaves the list as it is: every change of it is complete.
    fn with<T>(&self, act: impl FnOnce(&mut Places) -> T) -> T {
        act(&mut self.0.lock().unwrap_or_else(PoisonError::into_inner))
    }
}

impl Connection {
    /// The header of a request has come.
    pub(crate) fn mark_asked(&self) {
        self.reach(Stage::Answered);
    }

    /// It has become a stream.
    pub(crate) fn mark_stream(&self) {
        self.reach(Stage::Stream);
    }

    fn reach(&self, stage: Stage) {
        self.0.connections.with(|places| {
            if let Some(place) = places.places.iter_mut().find(|place| place.number == self.0.number) {
                place.stage = place.stage.max(stage);
            }
        });
    }
}

impl Drop for Held {
    fn drop(&mut self) {
        self.connections.with(|places| places.places.retain(|place| place.number != self.number));
    }
}

impl Places {
    fn admit(&mut self, address: IpAddr, open: oneshot::Sender<()>) -> Option<u64> {
        let of_address = self.places.iter().filter(|place| place.address == address).count();
        if of_address >= self.limits.per_address {
            self.give_way(|place| place.address == address)?;
        } else if self.places.len() >= self.limits.in_all {
            self.give_way(|_| true)?;
        }
        self.next += 1;
        let number = self.next;
        self.places.push(Place { number, address, stage: Stage::HalfOpen, _open: open });
        Some(number)
    }

    /// Closes the oldest of the connections that have got least far.
    fn give_way(&mut self, among: impl Fn(&Place) -> bool) -> Option<()> {
        let candidates =
            self.places.iter().enumerate().filter(|(_, place)| place.stage < Stage::Stream && among(place));
        let (oldest, _) = candidates.min_by_key(|(_, place)| (place.stage, place.number))?;
        self.places.remove(oldest);
        Some(())
    }
}

/// An address as limits count it: a host may have any of the addresses of its IPv6 network of 64 bits.
fn network_of(address: IpAddr) -> IpAddr {
    match address.to_canonical() {
        IpAddr::V6(address) => Ipv6Addr::from_bits(address.to_bits() >> 64 << 64).into(),
        address => address,
    }
}

#[cfg(test)]
mod tests {
    use super::*;

    const FEW: Limits = Limits { per_address: 3, in_all: 5 };

    fn address(last: u8) -> IpAddr {
        IpAddr::from([192, 0, 2, last])
    }

    fn is_closed(closed: &mut oneshot::Receiver<()>) -> bool {
        closed.try_recv() == Err(oneshot::error::TryRecvError::Closed)
    }

    #[test]
    fn the_oldest_half_open_connection_gives_way_and_a_stream_never_does() {
        let connections = Connections::within(FEW);
        let mut held: Vec<_> = (0..3).map(|_| connections.admit(address(1)).unwrap()).collect();
        held[0].0.mark_stream();
        held[1].0.mark_asked();
        let fourth = connections.admit(address(1)).unwrap();
        let closed = held.iter_mut().map(|(_, closed)| is_closed(closed)).collect::<Vec<_>>();
        assert_eq!(closed, [false, false, true], "half open before answered");
        fourth.0.mark_stream();
        let fifth = connections.admit(address(1)).unwrap();
        assert!(is_closed(&mut held[1].1), "then what was answered");
        fifth.0.mark_stream();
        assert!(connections.admit(address(1)).is_none(), "streams stay");
        assert!(connections.admit(address(2)).is_some(), "another address has its own places");
    }

    #[test]
    fn all_addresses_together_have_no_more_than_the_places_in_all() {
        let connections = Connections::within(FEW);
        let mut held: Vec<_> = (0..5).map(|k| connections.admit(address(k)).unwrap()).collect();
        let sixth = connections.admit(address(9)).unwrap();
        assert!(is_closed(&mut held[0].1) && !is_closed(&mut held[1].1));
        drop(held);
        drop(sixth);
        assert_eq!(connections.with(|places| places.places.len()), 0, "places are given back");
    }

    #[test]
    fn a_network_of_64_bits_counts_as_one_address() {
        let of = |text: &str| network_of(text.parse().unwrap());
        assert_eq!(of("2001:db8::1"), of("2001:db8::ffff:1"));
        assert_ne!(of("2001:db8::1"), of("2001:db8:0:1::1"));
        assert_eq!(of("::ffff:192.0.2.1"), address(1), "an IPv4 address in IPv6 is that of IPv4");
    }
}
