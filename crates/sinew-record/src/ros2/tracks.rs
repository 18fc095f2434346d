//! Where things were, by a bag of any writer.

use super::placed::Placed;
use crate::error::Error;
use crate::records::{Bytes, Chunk};
use mcap::records::op;
use std::collections::BTreeMap;

/// Where one thing was, in one frame.
#[derive(Debug, Clone, PartialEq)]
pub struct Track {
    /// Its own frame, or the topic of its poses, without a first `/`.
    pub name: String,
    /// The frame in which it was seen.
    pub frame: String,
    /// By the stamps of the messages, ns since 1970 or another start of their clock, and m; those with NaN
    /// are left out.
    pub points: Vec<(i64, [f64; 3])>,
}

/// Reads the positions of `tf2_msgs/TFMessage`, named by child frame, and of `geometry_msgs/PoseStamped`,
/// named by topic, from an MCAP file with messages in CDR.
///
/// # Errors
/// [`Error::Damaged`] names the place of what cannot be read, also of a file that was cut off or has chunks
/// that are compressed otherwise than by zstd; [`Error::NoPoses`] names the topics of a file with others
/// only.
pub fn ros2_tracks(bytes: &[u8]) -> Result<Vec<Track>, Error> {
    let mut rest = Bytes { rest: bytes, at: 0 };
    if rest.take(mcap::MAGIC.len() as u64) != Some(mcap::MAGIC) {
        return Err(Bytes { rest: bytes, at: 0 }.damaged("an MCAP file"));
    }
    let (mut reading, mut complete) = (Reading::default(), false);
    while let Some((opcode, mut body)) = rest.record() {
        match opcode {
            op::CHUNK => {
                let chunk = Chunk::read(&mut body)?;
                let records = chunk.records(bytes)?;
                let mut records = Bytes { rest: &records, at: chunk.at() };
                while !records.rest.is_empty() {
                    let record = records.record();
                    let (opcode, body) = record.ok_or_else(|| records.damaged("a record of a chunk"))?;
                    reading.record(opcode, Bytes { at: chunk.at(), ..body })?;
                }
            }
            op::FOOTER => {
                complete = rest.rest == mcap::MAGIC;
                rest.rest = &[];
            }
            _ => reading.record(opcode, body)?,
        }
    }
    if !complete {
        let got = "a file that was cut off".to_owned();
        return Err(Error::Damaged { at: rest.at, expected: "the rest of an MCAP file", got });
    }
    match reading.expected {
        Some(expected) if expected != reading.messages => {
            let got = format!("{} messages, while its statistics say {expected}", reading.messages);
            Err(Error::Damaged { at: rest.at, expected: "a whole MCAP file", got })
        }
        _ => reading.tracks(),
    }
}

/// Kinds of messages that are read.
#[derive(Clone, Copy)]
enum Kind {
    Transforms,
    Pose,
}

#[derive(Default)]
struct Reading {
    /// Names of schemas.
    schemas: BTreeMap<u16, String>,
    /// Name and kind of topics.
    channels: BTreeMap<u16, (String, Option<Kind>)>,
    /// Topics with their types.
    topics: Vec<String>,
    /// By name and frame, in the order of their first points.
    places: BTreeMap<(String, String), usize>,
    found: Vec<Track>,
    /// Messages of all topics, and as many by the statistics at the end of the file.
    messages: u64,
    expected: Option<u64>,
}

impl Reading {
    fn record(&mut self, opcode: u8, mut body: Bytes<'_>) -> Result<(), Error> {
        match opcode {
            op::SCHEMA => self.schema(body).ok_or_else(|| body.damaged("a schema")),
            op::CHANNEL => self.channel(body).ok_or_else(|| body.damaged("a channel"))?,
            op::MESSAGE => {
                self.messages += 1;
                self.message(body)
            }
            op::STATISTICS => {
                self.expected = body.u64();
                Ok(())
            }
            _ => Ok(()),
        }
    }

    fn schema(&mut self, mut body: Bytes<'_>) -> Option<()> {
        let id = body.u16()?;
        self.schemas.insert(id, body.text()?.replace("/msg/", "/"));
        Some(())
    }

    fn channel(&mut self, mut body: Bytes<'_>) -> Option<Result<(), Error>> {
        let (id, schema, at) = (body.u16()?, body.u16()?, body.at);
        let (topic, encoding) = (body.text()?, body.text()?);
        let schema = self.schemas.get(&schema).map_or("", String::as_str);
        let kind = match schema {
            "tf2_msgs/TFMessage" => Some(Kind::Transforms),
            "geometry_msgs/PoseStamped" => Some(Kind::Pose),
            _ => None,
        };
        if kind.is_some() && encoding != "cdr" {
            let got = format!("{encoding} of topic {topic}");
            return Some(Err(Error::Damaged { at, expected: "messages in cdr", got }));
        }
        let listed = format!("{topic} ({schema})");
        if !self.topics.contains(&listed) {
            self.topics.push(listed);
        }
        self.channels.insert(id, (topic.to_owned(), kind));
        Some(Ok(()))
    }

    fn message(&mut self, mut body: Bytes<'_>) -> Result<(), Error> {
        let at = body.at;
        let damaged = |expected, got| Err(Error::Damaged { at, expected, got });
        let head = (body.u16(), body.u32(), body.u64(), body.u64());
        let (Some(channel), Some(_), Some(_), Some(_)) = head else {
            return damaged("a message", "one that is too short".to_owned());
        };
        let Some((topic, kind)) = self.channels.get(&channel) else {
            return damaged("a message of a channel before it", format!("channel {channel}"));
        };
        let (placed, expected) = match kind {
            Some(Kind::Transforms) => (Placed::of_transforms(body.rest), "tf2_msgs/TFMessage in CDR"),
            Some(Kind::Pose) => (Placed::of_pose(body.rest), "geometry_msgs/PoseStamped in CDR"),
            None => return Ok(()),
        };
        let Some(placed) = placed else {
            return damaged(expected, format!("other bytes in topic {topic}"));
        };
        for Placed { ns, frame, child, position, .. } in placed {
            if position.iter().any(|x| x.is_nan()) {
                continue;
            }
            let name = if child.is_empty() { topic.as_str() } else { child };
            let name = name.trim_start_matches('/');
            if !position.iter().all(|x| x.is_finite()) {
                return damaged("finite numbers", format!("{position:?} of {name}"));
            }
            let place = *self.places.entry((name.to_owned(), frame.to_owned())).or_insert_with(|| {
                self.found.push(Track { name: name.to_owned(), frame: frame.to_owned(), points: Vec::new() });
                self.found.len() - 1
            });
            if let Some(track) = self.found.get_mut(place) {
                track.points.push((ns, position));
            }
        }
        Ok(())
    }

    fn tracks(self) -> Result<Vec<Track>, Error> {
        if self.channels.values().all(|(_, kind)| kind.is_none()) {
            return Err(Error::NoPoses { topics: self.topics.join(", ") });
        }
        Ok(self.found)
    }
}

#[cfg(test)]
mod tests {
    use super::*;
    use crate::ros2::cdr::Cdr;
    use crate::ros2::definitions;
    use mcap::records::MessageHeader;
    use mcap::{Compression, WriteOptions, Writer};
    use proptest::prelude::*;
    use std::collections::BTreeMap as Map;
    use std::io::Cursor;

    const STILL: [f64; 4] = [0.0, 0.0, 0.0, 1.0];

    /// A bag with a marker by transforms, one by poses, and a topic of another kind.
    fn bag(count: usize, options: WriteOptions, encoding: &str) -> (Vec<u8>, [Track; 2]) {
        let mut writer = Writer::with_options(Cursor::new(Vec::new()), options).unwrap();
        let mut channel = |topic: &str, kind: &str, definition: &str| {
            let schema = writer.add_schema(kind, "ros2msg", definition.as_bytes()).unwrap();
            writer.add_channel(schema, topic, encoding, &Map::new()).unwrap()
        };
        let transforms = channel("/tf", "tf2_msgs/msg/TFMessage", &definitions::transforms());
        let poses = channel("/plate", "geometry_msgs/PoseStamped", "");
        let others = channel("/word", "std_msgs/msg/String", "string data");
        let track = |name: &str| Track { name: name.to_owned(), frame: "eye".to_owned(), points: Vec::new() };
        let mut tracks = [track("tip"), track("plate")];
        for k in 0..count {
            let at = |shift: f64| [0.1 * k as f64, shift, -0.5];
            let ns = 1_700_000_000_000_000_000 + 10_000_000 * k as i64;
            let placed = |child, position| Placed { ns, frame: "eye", child, position, quaternion: STILL };
            let mut message = Cdr::new();
            message.length(2);
            placed("tip", at(0.0)).write(&mut message);
            placed("lost", [f64::NAN; 3]).write(&mut message);
            // A pose is a transform without a child.
            let mut pose = Cdr::new();
            pose.header(ns as u64, "eye");
            at(1.0).iter().chain(&STILL).for_each(|x| pose.f64(*x));
            for (channel_id, message) in [(transforms, &message), (poses, &pose), (others, &pose)] {
                // The time of arrival is none of the stamp.
                let header = MessageHeader { channel_id, sequence: 0, log_time: 7, publish_time: 7 };
                writer.write_to_known_channel(&header, message.bytes()).unwrap();
            }
            tracks[0].points.push((ns, at(0.0)));
            tracks[1].points.push((ns, at(1.0)));
        }
        writer.finish().unwrap();
        (writer.into_inner().into_inner(), tracks)
    }

    fn options(kind: usize) -> WriteOptions {
        let options = WriteOptions::new().compression_threads(0).chunk_size(Some(2000));
        match kind {
            0 => options.compression(Some(Compression::Zstd)),
            1 => options.compression(None),
            _ => options.compression(None).use_chunks(false),
        }
    }

    #[test]
    fn transforms_and_poses_are_read_by_their_stamps_however_they_are_packed() {
        for kind in 0..3 {
            let (bytes, tracks) = bag(40, options(kind), "cdr");
            assert_eq!(ros2_tracks(&bytes).unwrap(), tracks);
            let cut = ros2_tracks(&bytes[..bytes.len() / 2]).unwrap_err().to_string();
            assert!(cut.starts_with("byte ") && cut.contains("cut off"), "{cut}");
        }
        let text = ros2_tracks(&bag(1, options(0), "json").0).unwrap_err().to_string();
        assert!(text.contains("messages in cdr, got json of topic /tf"), "{text}");
        let text = ros2_tracks(b"time_s,marker").unwrap_err().to_string();
        assert!(text.contains("an MCAP file"), "{text}");
    }

    proptest! {
        #![proptest_config(ProptestConfig::with_cases(2000))]

        #[test]
        fn damage_is_one_error_or_other_numbers_but_no_panic(
            kind in 0..3_usize,
            damage in prop::collection::vec((any::<prop::sample::Index>(), any::<u8>()), 1..6),
            cut in prop::option::of(any::<prop::sample::Index>()),
        ) {
            let (mut bytes, tracks) = bag(20, options(kind), "cdr");
            for (place, value) in damage {
                let place = place.index(bytes.len());
                bytes[place] = value;
            }
            if let Some(cut) = cut {
                bytes.truncate(cut.index(bytes.len()));
            }
            match ros2_tracks(&bytes) {
                // Chunks have a checksum; what is not in one has none.
                Ok(found) => prop_assert!(cut.is_none() && (kind == 2 || found == tracks)),
                Err(error) => prop_assert_eq!(error.to_string().lines().count(), 1),
            }
        }
    }
}
