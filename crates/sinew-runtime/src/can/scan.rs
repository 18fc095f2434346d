//! What answers on a bus.

use super::Link;
use super::sdo::{SdoClient, SdoError};
use sinew_segment::CanFrame as Frame;
use std::io;

/// A node that answers.
#[derive(Debug, Clone, PartialEq, Eq)]
pub struct FoundNode {
    /// Its identifier.
    pub node: u8,
    /// Device profile: 402 is a drive.
    pub profile: u16,
    /// Vendor ID and product code.
    pub identity: [u32; 2],
    /// Its name, where it says one.
    pub name: Option<String>,
}

/// Nodes that are asked at once, and the time after which no answer of theirs comes, ns.
const AT_ONCE: u8 = 16;
const PATIENCE: u64 = 50_000_000;

/// The nodes that answer on a bus, by their identifiers; nothing is written.
///
/// # Errors
/// Of the operating system.
pub fn scan<L: Link>(link: &mut L) -> io::Result<Vec<FoundNode>> {
    let mut nodes = Vec::new();
    for first in (1..=127_u8).step_by(usize::from(AT_ONCE)) {
        let asked = first..=first.saturating_add(AT_ONCE - 1).min(127);
        let ask = |node| Frame::new(0x600 + u16::from(node), &[0x40, 0, 0x10, 0, 0, 0, 0, 0]);
        link.send(&asked.map(ask).collect::<Vec<_>>())?;
        let mut deadline = link.now() + PATIENCE;
        while let Some(frame) = link.receive(deadline)? {
            if let (0x581..=0x5ff, [0x43, 0, 0x10, 0, low, high, ..]) = (frame.id(), frame.octets()) {
                nodes.push(((frame.id() & 0x7f) as u8, u16::from_le_bytes([*low, *high])));
            }
            deadline = deadline.max(link.now() + PATIENCE / 2);
        }
    }
    nodes.sort_unstable();
    nodes.dedup();
    let mut client = SdoClient::new(link);
    let found = nodes.into_iter().map(|(node, profile)| {
        let identity = [1, 2].map(|subindex| client.number(node, (0x1018, subindex)));
        let name = client.read(node, (0x1008, 0));
        let [vendor, product] = identity.map(|number| number.or_else(unknown));
        let name = name.map(|name| Some(String::from_utf8_lossy(&name).into_owned())).or_else(unknown)?;
        Ok(FoundNode { node, profile, identity: [vendor?, product?], name })
    });
    found.collect()
}

/// In place of what a node does not say.
fn unknown<T: Default>(error: SdoError) -> io::Result<T> {
    match error {
        SdoError::Port(source) => Err(source),
        _ => Ok(T::default()),
    }
}
