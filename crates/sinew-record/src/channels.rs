//! Channels and attachments of a recording in the MCAP container.

use crate::error::Error;
use crate::fields::Fields;
use crate::head::Head;
use crate::sink::SharedSink;
use mcap::records::MessageHeader;
use mcap::write::{Metadata, NoSeek};
use mcap::{Attachment, Compression, WriteOptions, Writer};
use prost::Message;
use std::borrow::Cow;
use std::collections::BTreeMap;

/// Schemas of all messages, a `FileDescriptorSet`; `schemas/make.py` makes it.
const SCHEMAS: &[u8] = include_bytes!("../schemas/schemas.binpb");

/// Name of the attachment with [`Head`].
pub(crate) const HEAD: &str = "head.json";
/// Topics of format 2 that are read, and that of the blocks of format 1.
pub(crate) const READ: [&str; 3] = ["/sinew/block", "/sinew/cycle", "/sinew/slow"];
pub(crate) const BLOCKS_1: &str = "/sinew/cycles";

/// A channel of a recording.
#[derive(Debug, Clone, Copy)]
pub(crate) enum Topic {
    Block,
    Cycle,
    Slow,
    Frames,
    Scene,
    Log,
}

impl Topic {
    const ALL: [Self; 6] = [Self::Block, Self::Cycle, Self::Slow, Self::Frames, Self::Scene, Self::Log];

    /// Name and schema.
    fn described(self) -> (&'static str, &'static str) {
        match self {
            Self::Block => (READ[0], "sinew.Block"),
            Self::Cycle => (READ[1], "sinew.Cycle"),
            Self::Slow => (READ[2], "sinew.Slow"),
            Self::Frames => ("/tf", "foxglove.FrameTransforms"),
            Self::Scene => ("/sinew/scene", "foxglove.SceneUpdate"),
            Self::Log => ("/sinew/log", "foxglove.Log"),
        }
    }
}

/// A file next to the messages.
#[derive(Debug, Clone, PartialEq)]
pub struct File {
    /// Its name.
    pub name: String,
    /// Its content.
    pub bytes: Vec<u8>,
}

/// The container, written a commit at a time.
pub(crate) struct Container {
    writer: Writer<NoSeek<SharedSink>>,
    sink: SharedSink,
    channels: [u16; 6],
    head_time: u64,
}

impl Container {
    /// Writes what precedes the first message.
    pub(crate) fn new(sink: SharedSink, head: &Head, files: &[File]) -> Result<Self, Error> {
        let options = WriteOptions::new()
            .compression(Some(Compression::Zstd))
            // Higher levels take ten times as long and find matches in noise, which cost more than they save.
            .compression_level(1)
            .compression_threads(0)
            .chunk_size(None)
            // Without compression an index of every message would be as large as what it finds.
            .emit_message_indexes(false)
            .emit_chunk_indexes(false)
            .disable_seeking(true)
            .library(format!("sinew {}", head.program));
        let mut writer = Writer::with_options(NoSeek::new(sink.clone()), options)?;
        let text = serde_json::to_vec(head).map_err(std::io::Error::other)?;
        let all = [File { name: HEAD.to_owned(), bytes: text }].into_iter().chain(files.iter().cloned());
        for file in all {
            let media_type = if file.name.ends_with(".json") { "application/json" } else { "text/plain" };
            writer.attach(&Attachment {
                log_time: head.start_ns,
                create_time: head.start_ns,
                name: file.name,
                media_type: media_type.to_owned(),
                data: Cow::Owned(file.bytes),
            })?;
        }
        writer.write_metadata(&Metadata { name: "sinew".to_owned(), metadata: metadata(head) })?;
        let mut channels = [0; 6];
        for (channel, topic) in channels.iter_mut().zip(Topic::ALL) {
            let (name, schema) = topic.described();
            let of_signals = match topic {
                Topic::Cycle => Some(Fields::new(&head.fast).schema("Cycle")),
                Topic::Slow => Some(Fields::new(&head.slow).schema("Slow")),
                _ => None,
            };
            let schema = writer.add_schema(schema, "protobuf", of_signals.as_deref().unwrap_or(SCHEMAS))?;
            *channel = writer.add_channel(schema, name, "protobuf", &BTreeMap::new())?;
        }
        let mut container = Self { writer, sink, channels, head_time: head.start_ns };
        container.commit()?;
        Ok(container)
    }

    /// Adds a message at a time, ns since the start.
    pub(crate) fn put(&mut self, topic: Topic, since: u64, message: &impl Message) -> Result<(), Error> {
        self.put_bytes(topic, since, &message.encode_to_vec())
    }

    /// Adds an encoded message at a time, ns since the start. Messages are not numbered: their times are.
    pub(crate) fn put_bytes(&mut self, topic: Topic, since: u64, message: &[u8]) -> Result<(), Error> {
        let (channel_id, log_time) = (self.channels[topic as usize], self.head_time + since);
        let header = MessageHeader { channel_id, sequence: 0, log_time, publish_time: log_time };
        Ok(self.writer.write_to_known_channel(&header, message)?)
    }

    /// Ends the chunk and writes it.
    pub(crate) fn commit(&mut self) -> Result<(), Error> {
        self.writer.flush()?;
        Ok(self.sink.lock().commit()?)
    }

    /// Writes summary and end; the length of the file, bytes.
    pub(crate) fn finish(mut self) -> Result<u64, Error> {
        self.writer.finish()?;
        let mut sink = self.sink.lock();
        sink.commit()?;
        Ok(sink.length())
    }
}

/// The head for programs that do not read it.
pub(crate) fn metadata(head: &Head) -> BTreeMap<String, String> {
    [
        ("format", head.format.to_string()),
        ("program", head.program.clone()),
        ("commit", head.commit.clone()),
        ("machine", head.machine.clone()),
        ("simulated", head.simulated.to_string()),
        ("period_ns", head.period_ns.to_string()),
    ]
    .map(|(key, value)| (key.to_owned(), value))
    .into()
}
