//! A recording as it stands in a file, whole, cut off or damaged.

use crate::block::Block;
use crate::channels::{BLOCKS_1, File, HEAD, READ};
use crate::error::Error;
use crate::head::{FORMAT, Head};
use crate::messages::BlockMessage;
use crate::records::{Bytes, Chunk};
use mcap::records::op;
use prost::Message;

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
    /// Chunks with cycles.
    chunks: Vec<BlockPlace>,
}

impl<'a> Recording<'a> {
    /// Reads the head and finds the chunks.
    ///
    /// # Errors
    /// [`Error::Damaged`] and [`Error::CutShort`] name the place of what is no recording; [`Error::Missing`],
    /// [`Error::Attachment`] and [`Error::Version`] for files of others and for newer ones.
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
                op::CHUNK => chunks.push(BlockPlace { chunk: Chunk::read(&mut body)?, channels: [None; 3] }),
                op::FOOTER => {
                    complete = rest.rest == mcap::MAGIC;
                    rest.rest = &[];
                }
                _ => {}
            }
        }
        let head = head.ok_or_else(|| missing(HEAD, complete, rest.at))?;
        let cut_off = rest.rest.len() as u64;
        let chunks = with_cycles(bytes, chunks, &head)?;
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
        Blocks { recording: self, chunk: 0 }
    }
}

/// Why an attachment is not there, of a file whose last whole record ends at `end`.
fn missing(name: &'static str, complete: bool, end: u64) -> Error {
    if complete { Error::Missing { name } } else { Error::CutShort { at: end, name } }
}

/// The chunks with the channels of their cycles; those before the first cycle, which name the channels, are
/// left out.
fn with_cycles(file: &[u8], mut chunks: Vec<BlockPlace>, head: &Head) -> Result<Vec<BlockPlace>, Error> {
    let names = if head.format == 1 { [BLOCKS_1, "", ""] } else { READ };
    let (mut channels, mut before) = ([None; 3], 0);
    for place in &chunks {
        let records = place.chunk.records(file)?;
        let (mut records, mut found) = (Bytes { rest: &records, at: place.chunk.at() }, false);
        while let Some((opcode, mut body)) = records.record() {
            if opcode == op::CHANNEL {
                let (id, _schema) = (body.u16(), body.u16());
                let name = body.text();
                channels
                    .iter_mut()
                    .zip(names)
                    .filter(|(_, of)| Some(*of) == name)
                    .for_each(|(to, _)| *to = id);
            }
            found |= opcode == op::MESSAGE && channels[0].is_some() && body.u16() == channels[0];
        }
        if found {
            break;
        }
        before += 1;
    }
    chunks.drain(..before);
    chunks.iter_mut().for_each(|place| place.channels = channels);
    Ok(chunks)
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

/// Where a block stands in the bytes of a file, to decode it apart from the others: a chunk.
#[derive(Debug, Clone, PartialEq, Eq)]
pub struct BlockPlace {
    chunk: Chunk,
    /// Those of blocks, of cycles and of slow signals.
    channels: [Option<u16>; 3],
}

impl BlockPlace {
    /// The block, from the bytes of the whole file.
    ///
    /// # Errors
    /// [`Error::Damaged`] where these are others than those that the place was found in.
    pub fn decode(&self, file: &[u8], head: &Head) -> Result<Block, Error> {
        let at = self.chunk.at();
        let records = self.chunk.records(file)?;
        let mut records = Bytes { rest: &records, at };
        let (mut block, mut rows) = (None, [Vec::new(), Vec::new()]);
        while !records.rest.is_empty() {
            let (opcode, mut body) =
                records.record().ok_or_else(|| records.damaged("a record of a chunk"))?;
            let channel = body.u16().filter(|_| opcode == op::MESSAGE);
            let place = self.channels.iter().position(|known| channel.is_some() && *known == channel);
            let header = body.u32().zip(body.u64()).zip(body.u64());
            let (Some(place), Some(((_, time), _))) = (place, header) else { continue };
            match place.checked_sub(1) {
                Some(kind) => rows[kind].push((time, body.rest)),
                None => block = Some(body.rest),
            }
        }
        let expected = "a block of cycles";
        let damaged = |got| Error::Damaged { at, expected, got };
        let bytes = block.ok_or_else(|| damaged("a chunk without, perhaps of another program".to_owned()))?;
        let message = BlockMessage::decode(bytes).map_err(|error| damaged(error.to_string()))?;
        Block::decode(&message, rows.each_ref().map(|rows| &rows[..]), head, at)
    }
}

/// The blocks of a recording, decoded one by one.
#[derive(Debug)]
pub struct Blocks<'a> {
    recording: &'a Recording<'a>,
    chunk: usize,
}

impl Blocks<'_> {
    /// Place of the next block.
    pub fn next_place(&mut self) -> Option<BlockPlace> {
        let place = self.recording.chunks.get(self.chunk).cloned();
        self.chunk += 1;
        place
    }
}

impl Iterator for Blocks<'_> {
    type Item = Result<Block, Error>;

    fn next(&mut self) -> Option<Self::Item> {
        let place = self.next_place()?;
        Some(place.decode(self.recording.bytes, &self.recording.head))
    }
}
