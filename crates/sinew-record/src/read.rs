//! A recording as it stands in a file, whole, cut off or damaged.

use crate::block::Block;
use crate::channels::{CYCLES, File, HEAD};
use crate::error::Error;
use crate::head::{FORMAT, Head};
use crate::messages::Cycles;
use mcap::records::op;
use prost::Message;

/// Bytes of a file that are read one after the other; no access is out of bounds.
#[derive(Debug, Clone, Copy)]
struct Bytes<'a> {
    rest: &'a [u8],
    /// Place of the rest in the file.
    at: u64,
}

impl<'a> Bytes<'a> {
    fn take(&mut self, count: u64) -> Option<&'a [u8]> {
        let count = usize::try_from(count).ok()?;
        let (taken, rest) = self.rest.split_at_checked(count)?;
        self.rest = rest;
        self.at += count as u64;
        Some(taken)
    }

    fn array<const N: usize>(&mut self) -> Option<[u8; N]> {
        self.take(N as u64)?.try_into().ok()
    }

    fn u16(&mut self) -> Option<u16> {
        self.array().map(u16::from_le_bytes)
    }

    fn u32(&mut self) -> Option<u32> {
        self.array().map(u32::from_le_bytes)
    }

    fn u64(&mut self) -> Option<u64> {
        self.array().map(u64::from_le_bytes)
    }

    fn text(&mut self) -> Option<&'a str> {
        let length = self.u32()?;
        std::str::from_utf8(self.take(u64::from(length))?).ok()
    }

    /// Opcode and body of the next record; none at the end and where it is cut off.
    fn record(&mut self) -> Option<(u8, Bytes<'a>)> {
        let mut ahead = *self;
        let [opcode] = ahead.array()?;
        let length = ahead.u64()?;
        let at = ahead.at;
        let body = ahead.take(length)?;
        *self = ahead;
        Some((opcode, Bytes { rest: body, at }))
    }

    fn damaged(&self, expected: &'static str) -> Error {
        Error::Damaged { at: self.at, expected, got: "other bytes".to_owned() }
    }
}

/// A recording in memory.
#[derive(Debug)]
pub struct Recording<'a> {
    /// What it says about itself.
    pub head: Head,
    /// Its attachments but the head.
    pub files: Vec<File>,
    /// Whether it was ended by its writer.
    pub complete: bool,
    /// Bytes after the last whole record, of a file that was cut off.
    pub cut_off: u64,
    /// The whole file.
    bytes: &'a [u8],
    /// Uncompressed chunks.
    chunks: Vec<Bytes<'a>>,
}

impl<'a> Recording<'a> {
    /// Reads the head and finds the chunks.
    ///
    /// # Errors
    /// [`Error::Damaged`] and [`Error::CutShort`] name the place of what is no recording; [`Error::Missing`], [`Error::Attachment`] and
    /// [`Error::Version`] for files of others and for newer ones.
    pub fn read(bytes: &'a [u8]) -> Result<Self, Error> {
        let mut rest = Bytes { rest: bytes, at: 0 };
        if rest.take(mcap::MAGIC.len() as u64) != Some(mcap::MAGIC) {
            return Err(Bytes { rest: bytes, at: 0 }.damaged("an MCAP file"));
        }
        let (mut head, mut files, mut chunks, mut complete) = (None, Vec::new(), Vec::new(), false);
        while let Some((opcode, mut body)) = rest.record() {
            match opcode {
                op::ATTACHMENT => {
                    let file = attachment(body)?;
                    if file.name == HEAD {
                        head = Some(read_head(&file)?);
                    } else {
                        files.push(file);
                    }
                }
                op::CHUNK => chunks.push(chunk(&mut body)?),
                op::FOOTER => {
                    complete = rest.rest == mcap::MAGIC;
                    rest.rest = &[];
                }
                _ => {}
            }
        }
        let head = head.ok_or_else(|| missing(HEAD, complete, rest.at))?;
        let cut_off = rest.rest.len() as u64;
        Ok(Self { head, files, complete, cut_off, bytes, chunks })
    }

    /// An attachment by its name.
    #[must_use]
    pub fn file(&self, name: &str) -> Option<&[u8]> {
        self.files.iter().find(|file| file.name == name).map(|file| &file.bytes[..])
    }

    /// Text of an attachment.
    ///
    /// # Errors
    /// [`Error::Missing`] or [`Error::CutShort`] without it, [`Error::Attachment`] where it is no text.
    pub fn text(&self, name: &'static str) -> Result<&str, Error> {
        let end = self.bytes.len() as u64 - self.cut_off;
        let bytes = self.file(name).ok_or_else(|| missing(name, self.complete, end))?;
        std::str::from_utf8(bytes)
            .map_err(|error| Error::Attachment { name: name.to_owned(), reason: error.to_string() })
    }

    /// Chunks that are whole.
    #[must_use]
    pub fn chunks(&self) -> usize {
        self.chunks.len()
    }

    /// The blocks in the order of the file.
    #[must_use]
    pub fn blocks(&self) -> Blocks<'_> {
        Blocks { recording: self, chunk: 0, rest: None, channel: None }
    }
}

/// Why an attachment is not there, of a file whose last whole record ends at `end`.
fn missing(name: &'static str, complete: bool, end: u64) -> Error {
    if complete { Error::Missing { name } } else { Error::CutShort { at: end, name } }
}

/// Checks and opens a chunk: its records.
fn chunk<'a>(body: &mut Bytes<'a>) -> Result<Bytes<'a>, Error> {
    let short = |body: &Bytes<'_>| body.damaged("a chunk");
    let head = (|| {
        let _times = (body.u64()?, body.u64()?);
        let size = body.u64()?;
        Some((size, body.u32()?, body.text()?, body.u64()?))
    })();
    let (size, check, compression, length) = head.ok_or_else(|| short(body))?;
    if !compression.is_empty() {
        let got = format!("compression {compression}");
        return Err(Error::Damaged { at: body.at, expected: "an uncompressed chunk", got });
    }
    let at = body.at;
    let records = body.take(length).filter(|_| size == length).ok_or_else(|| short(body))?;
    let found = crc32fast::hash(records);
    if check != 0 && check != found {
        let got = format!("a checksum of {found:#010x} instead of {check:#010x}");
        return Err(Error::Damaged { at, expected: "an undamaged chunk", got });
    }
    Ok(Bytes { rest: records, at })
}

fn attachment(body: Bytes<'_>) -> Result<File, Error> {
    let mut all = body;
    let parsed = (|| {
        let _times = (all.u64()?, all.u64()?);
        let name = all.text()?.to_owned();
        let _media_type = all.text()?;
        let length = all.u64()?;
        let bytes = all.take(length)?;
        let checked = body.rest.len() - all.rest.len();
        Some((File { name, bytes: bytes.to_vec() }, checked, all.u32()?))
    })();
    let (file, checked, check) = parsed.ok_or_else(|| body.damaged("an attachment"))?;
    if check != 0 && body.rest.get(..checked).map(crc32fast::hash) != Some(check) {
        return Err(body.damaged("an undamaged attachment"));
    }
    Ok(file)
}

fn read_head(file: &File) -> Result<Head, Error> {
    let refuse = |reason: String| Error::Attachment { name: HEAD.to_owned(), reason };
    // Before the rest, which may differ in a newer format.
    #[derive(serde::Deserialize)]
    struct Version {
        format: u32,
    }
    let version: Version = serde_json::from_slice(&file.bytes).map_err(|error| refuse(error.to_string()))?;
    if version.format > FORMAT {
        return Err(Error::Version { expected: FORMAT, got: version.format });
    }
    let head: Head = serde_json::from_slice(&file.bytes).map_err(|error| refuse(error.to_string()))?;
    if head.period_ns == 0 || head.stride == 0 {
        return Err(refuse("expected a period and a stride above 0".to_owned()));
    }
    Ok(head)
}

/// Where a block stands in the bytes of a file, to decode it apart from the others.
#[derive(Debug, Clone, PartialEq, Eq)]
pub struct BlockPlace {
    bytes: std::ops::Range<usize>,
}

impl BlockPlace {
    /// The block, from the bytes of the whole file.
    ///
    /// # Errors
    /// [`Error::Damaged`] where these are others than those that the place was found in.
    pub fn decode(&self, file: &[u8], head: &Head) -> Result<Block, Error> {
        decode(file.get(self.bytes.clone()).unwrap_or_default(), head, self.bytes.start as u64)
    }
}

fn decode(bytes: &[u8], head: &Head, at: u64) -> Result<Block, Error> {
    let message = Cycles::decode(bytes).map_err(|error| Error::Damaged {
        at,
        expected: "a block of cycles",
        got: error.to_string(),
    })?;
    Block::decode(&message, head, at)
}

/// The blocks of a recording, decoded one by one.
#[derive(Debug)]
pub struct Blocks<'a> {
    recording: &'a Recording<'a>,
    chunk: usize,
    rest: Option<Bytes<'a>>,
    /// That of the blocks.
    channel: Option<u16>,
}

impl Blocks<'_> {
    /// Place of the next block.
    pub fn next_place(&mut self) -> Option<Result<BlockPlace, Error>> {
        loop {
            let rest = match &mut self.rest {
                Some(rest) if !rest.rest.is_empty() => rest,
                _ => {
                    let next = *self.recording.chunks.get(self.chunk)?;
                    self.chunk += 1;
                    self.rest.insert(next)
                }
            };
            let Some((opcode, mut body)) = rest.record() else {
                let error = rest.damaged("a record of a chunk");
                *rest = Bytes { rest: &[], at: rest.at };
                return Some(Err(error));
            };
            if opcode == op::CHANNEL {
                let (id, _schema) = (body.u16(), body.u16());
                if body.text() == Some(CYCLES) {
                    self.channel = id;
                }
            }
            if opcode == op::MESSAGE && self.channel.is_some() && body.u16() == self.channel {
                let _header = (body.u32(), body.u64(), body.u64());
                let start = body.at as usize;
                return Some(Ok(BlockPlace { bytes: start..start + body.rest.len() }));
            }
        }
    }
}

impl Iterator for Blocks<'_> {
    type Item = Result<Block, Error>;

    fn next(&mut self) -> Option<Self::Item> {
        let place = self.next_place()?;
        Some(place.and_then(|place| place.decode(self.recording.bytes, &self.recording.head)))
    }
}
