//! Records of an MCAP file, with their places in it, whoever wrote them.

use crate::error::Error;
use std::borrow::Cow;
use std::ops::Range;

/// Bytes of a file that are read one after the other; no access is out of bounds.
#[derive(Debug, Clone, Copy)]
pub(crate) struct Bytes<'a> {
    pub(crate) rest: &'a [u8],
    /// Place of the rest in the file.
    pub(crate) at: u64,
}

impl<'a> Bytes<'a> {
    pub(crate) fn take(&mut self, count: u64) -> Option<&'a [u8]> {
        let count = usize::try_from(count).ok()?;
        let (taken, rest) = self.rest.split_at_checked(count)?;
        self.rest = rest;
        self.at += count as u64;
        Some(taken)
    }

    fn array<const N: usize>(&mut self) -> Option<[u8; N]> {
        self.take(N as u64)?.try_into().ok()
    }

    pub(crate) fn u16(&mut self) -> Option<u16> {
        self.array().map(u16::from_le_bytes)
    }

    pub(crate) fn u32(&mut self) -> Option<u32> {
        self.array().map(u32::from_le_bytes)
    }

    pub(crate) fn u64(&mut self) -> Option<u64> {
        self.array().map(u64::from_le_bytes)
    }

    pub(crate) fn text(&mut self) -> Option<&'a str> {
        let length = self.u32()?;
        std::str::from_utf8(self.take(u64::from(length))?).ok()
    }

    /// Opcode and body of the next record; none at the end and where it is cut off.
    pub(crate) fn record(&mut self) -> Option<(u8, Bytes<'a>)> {
        let mut ahead = *self;
        let [opcode] = ahead.array()?;
        let length = ahead.u64()?;
        let at = ahead.at;
        let body = ahead.take(length)?;
        *self = ahead;
        Some((opcode, Bytes { rest: body, at }))
    }

    pub(crate) fn damaged(&self, expected: &'static str) -> Error {
        Error::Damaged { at: self.at, expected, got: "other bytes".to_owned() }
    }
}

/// Longest chunk that is read, bytes: a hundred times that of a large machine.
const MAX_CHUNK: u64 = 64 << 20;

/// Records that a file holds together, compressed or not.
#[derive(Debug, Clone, PartialEq, Eq)]
pub(crate) struct Chunk {
    bytes: Range<usize>,
    /// Uncompressed, bytes.
    size: usize,
    check: u32,
    compressed: bool,
}

impl Chunk {
    /// A chunk, as its beginning says.
    pub(crate) fn read(body: &mut Bytes<'_>) -> Result<Self, Error> {
        let short = |body: &Bytes<'_>| body.damaged("a chunk");
        let head = (|| {
            let _times = (body.u64()?, body.u64()?);
            let size = body.u64()?;
            Some((size, body.u32()?, body.text()?, body.u64()?))
        })();
        let (size, check, compression, length) = head.ok_or_else(|| short(body))?;
        let at = body.at;
        if !["", "zstd"].contains(&compression) || size > MAX_CHUNK {
            let got = format!("compression {compression}, {size} bytes");
            return Err(Error::Damaged { at, expected: "a chunk with zstd or none, 64 MB at most", got });
        }
        let compressed = !compression.is_empty();
        body.take(length).filter(|_| compressed || size == length).ok_or_else(|| short(body))?;
        let bytes = at as usize..(at + length) as usize;
        Ok(Self { bytes, size: size as usize, check, compressed })
    }

    /// Its place in the file.
    pub(crate) fn at(&self) -> u64 {
        self.bytes.start as u64
    }

    /// The checked records of the chunk.
    pub(crate) fn records<'a>(&self, file: &'a [u8]) -> Result<Cow<'a, [u8]>, Error> {
        let damaged =
            |got| Error::Damaged { at: self.bytes.start as u64, expected: "an undamaged chunk", got };
        let bytes = file.get(self.bytes.clone()).unwrap_or_default();
        let records = if self.compressed {
            let records = zstd::bulk::decompress(bytes, self.size);
            Cow::Owned(records.map_err(|error| damaged(error.to_string()))?)
        } else {
            Cow::Borrowed(bytes)
        };
        let found = crc32fast::hash(&records);
        if self.check != 0 && self.check != found {
            return Err(damaged(format!("a checksum of {found:#010x} instead of {:#010x}", self.check)));
        }
        Ok(records)
    }
}
