//! What answers on a bus.

use super::canopen::{SdoClient, SdoError};
use super::{Link, cansimple, mit, moteus};
use sinew_segment::{CanFrame as Frame, MitFamily};
use std::io;
use std::ops::RangeInclusive;

/// A node that answers.
#[derive(Debug, Clone, PartialEq, Eq)]
pub enum FoundNode {
    /// On CANopen.
    Canopen {
        /// Its identifier.
        node: u8,
        /// Device profile: 402 is a drive.
        profile: u16,
        /// Vendor ID and product code.
        identity: [u32; 2],
        /// Its name, where it says one.
        name: Option<String>,
    },
    /// On CANSimple.
    Cansimple {
        /// Its identifier.
        node: u8,
        /// Versions of hardware and firmware.
        hardware: [u8; 3],
        /// As hardware.
        firmware: [u8; 3],
    },
    /// A moteus.
    Moteus {
        /// Its identifier.
        node: u8,
        /// Model and firmware, as they say of themselves.
        model: i32,
        /// As model.
        firmware: i32,
    },
    /// A motor in MIT mode.
    Mit {
        /// Its identifier.
        node: u8,
        /// Whose firmware it has, by the form of its answer.
        family: MitFamily,
        /// The identifier under which it answers.
        answers_as: u16,
    },
}

/// Nodes that are asked at once, and the time after which no answer of theirs comes, ns.
const AT_ONCE: u8 = 16;
const PATIENCE: u64 = 50_000_000;

/// The nodes that answer on a bus, by their identifiers; nothing is written. Those on CANSimple are asked by
/// remote frames, which mean nothing on CANopen; nodes on CANopen are asked where none of them answers: to an
/// axis with identifier 48 to 51, their requests would be commands.
///
/// # Errors
/// Of the operating system.
pub fn scan<L: Link>(link: &mut L) -> io::Result<Vec<FoundNode>> {
    let (mut axes, mut endangered) = (Vec::new(), false);
    let ask = |link: &mut L, nodes: RangeInclusive<u8>| {
        link.send(&nodes.map(cansimple::ask_version).collect::<Vec<_>>())
    };
    each(link, 0..=cansimple::MAX_NODE, ask, |frame| {
        axes.extend(cansimple::version(frame));
        endangered |= cansimple::would_obey_canopen(frame);
    })?;
    axes.sort_unstable();
    axes.dedup();
    if endangered || !axes.is_empty() {
        let found = |(node, [_, h1, h2, h3, f1, f2, f3, _]): (u8, [u8; 8])| FoundNode::Cansimple {
            node,
            hardware: [h1, h2, h3],
            firmware: [f1, f2, f3],
        };
        return Ok(axes.into_iter().map(found).collect());
    }
    let mut nodes = Vec::new();
    let ask = |link: &mut L, nodes: RangeInclusive<u8>| {
        let ask = |node| Frame::new(0x600 + u16::from(node), &[0x40, 0, 0x10, 0, 0, 0, 0, 0]);
        link.send(&nodes.map(ask).collect::<Vec<_>>())
    };
    each(link, 1..=127, ask, |frame| {
        if let (0x581..=0x5ff, [0x43, 0, 0x10, 0, low, high, ..]) = (frame.id(), frame.octets()) {
            nodes.push(((frame.id() & 0x7f) as u8, u16::from_le_bytes([*low, *high])));
        }
    })?;
    nodes.sort_unstable();
    nodes.dedup();
    let mut client = SdoClient::new(link);
    let found = nodes.into_iter().map(|(node, profile)| {
        let identity = [1, 2].map(|subindex| client.number(node, (0x1018, subindex)));
        let name = client.read(node, (0x1008, 0));
        let [vendor, product] = identity.map(|number| number.or_else(unknown));
        let name = name.map(|name| Some(String::from_utf8_lossy(&name).into_owned())).or_else(unknown)?;
        Ok(FoundNode::Canopen { node, profile, identity: [vendor?, product?], name })
    });
    found.collect()
}

/// The moteus controllers that answer on a bus with CAN FD, by their identifiers; nothing is written.
///
/// # Errors
/// Of the operating system.
pub fn scan_fd<L: Link>(link: &mut L) -> io::Result<Vec<FoundNode>> {
    let mut found = Vec::new();
    let ask = |link: &mut L, nodes: RangeInclusive<u8>| {
        link.send(&nodes.map(moteus::ask_identity).collect::<Vec<_>>())
    };
    each(link, 1..=moteus::MAX_NODE, ask, |frame| found.extend(moteus::identity(frame)))?;
    found.sort_unstable();
    found.dedup();
    let node = |(node, [model, firmware, _]): (u8, [i32; 3])| FoundNode::Moteus { node, model, firmware };
    Ok(found.into_iter().map(node).collect())
}

/// The motors in MIT mode that answer on a bus, by their identifiers. They have no question that changes
/// nothing: each is told to leave, and loses its power.
///
/// # Errors
/// Of the operating system.
pub fn scan_mit<L: Link>(link: &mut L) -> io::Result<Vec<FoundNode>> {
    let mut found = Vec::new();
    let ask = |link: &mut L, nodes: RangeInclusive<u8>| link.send(&nodes.map(mit::leave).collect::<Vec<_>>());
    // A DAMIAO that has power looks like a CubeMars of another identifier.
    each(link, 1..=mit::MAX_NODE, ask, |_| {})?;
    each(link, 1..=mit::MAX_NODE, ask, |frame| {
        let seen = mit::sender(frame).map(|(node, family)| (node, frame.id(), family));
        found.extend(seen.filter(|seen| !found.contains(seen)));
    })?;
    found.sort_unstable_by_key(|(node, id, _)| (*node, *id));
    let node = |(node, answers_as, family)| FoundNode::Mit { node, family, answers_as };
    Ok(found.into_iter().map(node).collect())
}

/// Asks some nodes after the other, and shows every frame that comes.
fn each<L: Link>(
    link: &mut L,
    nodes: RangeInclusive<u8>,
    ask: impl Fn(&mut L, RangeInclusive<u8>) -> io::Result<()>,
    mut see: impl FnMut(&Frame),
) -> io::Result<()> {
    for first in nodes.clone().step_by(usize::from(AT_ONCE)) {
        ask(link, first..=first.saturating_add(AT_ONCE - 1).min(*nodes.end()))?;
        let mut deadline = link.now() + PATIENCE;
        // Whatever else is on the bus does not keep it.
        let last = deadline + PATIENCE;
        while let Some(frame) = link.receive(deadline)? {
            see(&frame);
            deadline = deadline.max((link.now() + PATIENCE / 2).min(last));
        }
    }
    Ok(())
}

/// In place of what a node does not say.
fn unknown<T: Default>(error: SdoError) -> io::Result<T> {
    match error {
        SdoError::Port(source) => Err(source),
        _ => Ok(T::default()),
    }
}
