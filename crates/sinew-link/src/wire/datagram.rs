//! Head, body and tag of one datagram.

use super::seal::Sealer;
use super::table::{Reader, Writer};
use super::{Head, Kind, MAGIC, MAX_DATAGRAM, MIN_DATAGRAM, TAG_SIZE, VERSION};
use crate::Rejection;

/// A datagram to be sent, in a buffer that is used again.
#[derive(Debug, Clone)]
pub struct Datagram {
    bytes: [u8; MAX_DATAGRAM],
    length: usize,
}

impl Default for Datagram {
    fn default() -> Self {
        Self { bytes: [0; MAX_DATAGRAM], length: 0 }
    }
}

impl Datagram {
    /// What is to be sent; empty before the first.
    #[must_use]
    pub fn bytes(&self) -> &[u8] {
        &self.bytes[..self.length]
    }

    /// Nothing is to be sent.
    pub(crate) fn clear(&mut self) {
        self.length = 0;
    }

    /// Writes a datagram: head, with its length, body and tag. Empty where the body does not fit.
    pub(crate) fn seal(
        &mut self,
        mut head: Head,
        sealer: &Sealer,
        body: impl FnOnce(&mut Writer<'_>) -> Option<()>,
    ) -> &[u8] {
        self.length = 0;
        let mut writer = Writer::new(&mut self.bytes[Head::SIZE..MAX_DATAGRAM - TAG_SIZE]);
        if body(&mut writer).is_none() {
            return &[];
        }
        let end = Head::SIZE + writer.written();
        head.length = (end + TAG_SIZE) as u16;
        if head.write(&mut Writer::new(&mut self.bytes)).is_none() {
            return &[];
        }
        let tag = sealer.tag(&self.bytes[..end]);
        self.bytes[end..end + TAG_SIZE].copy_from_slice(&tag);
        self.length = end + TAG_SIZE;
        self.bytes()
    }
}

/// A datagram whose head is sound and whose tag is not yet checked.
#[derive(Debug, Clone, Copy)]
pub struct Received<'a> {
    /// Its head.
    pub head: Head,
    /// Its kind.
    pub kind: Kind,
    sealed: &'a [u8],
    tag: &'a [u8],
}

impl<'a> Received<'a> {
    /// Whether the tag is that of a key.
    #[must_use]
    pub fn is_sealed_by(&self, sealer: &Sealer) -> bool {
        sealer.is_tag(self.sealed, self.tag)
    }

    /// The body.
    pub(crate) fn body(&self) -> Reader<'a> {
        Reader::new(&self.sealed[Head::SIZE..])
    }
}

/// Checks everything that needs no key: sizes, magic, version, kind.
///
/// # Errors
/// The first reason that applies.
pub fn open(datagram: &[u8]) -> Result<Received<'_>, Rejection> {
    if datagram.len() < MIN_DATAGRAM {
        return Err(Rejection::TooShort);
    }
    if datagram.len() > MAX_DATAGRAM {
        return Err(Rejection::TooLong);
    }
    let (sealed, tag) = datagram.split_at(datagram.len() - TAG_SIZE);
    let head = Head::read(&mut Reader::new(sealed)).ok_or(Rejection::TooShort)?;
    if head.magic != MAGIC {
        return Err(Rejection::Magic);
    }
    if head.version != VERSION {
        return Err(Rejection::Version);
    }
    if usize::from(head.length) != datagram.len() {
        return Err(Rejection::Length);
    }
    let kind = Kind::from_number(head.kind).ok_or(Rejection::Kind)?;
    Ok(Received { head, kind, sealed, tag })
}
