//! Bags of ROS 2, MCAP with messages in CDR and their definitions: a recording as one, and positions from
//! one.

mod cdr;
mod definitions;
mod messages;
mod placed;
mod tracks;

pub use cdr::{Cdr, CdrReader};
pub use messages::{Level, Messages, pose};
pub use tracks::{Track, ros2_tracks};

use crate::block::Block;
use crate::channels::metadata;
use crate::error::Error;
use crate::head::Head;
use crate::read::Recording;
use mcap::records::MessageHeader;
use mcap::write::Metadata;
use mcap::{Compression, WriteOptions, Writer};
use sinew::machine::Machine;
use sinew_session::signals::{Axis, Signal};
use std::collections::BTreeMap;
use std::io::Cursor;
use std::ops::Range;

/// A bag: two files of a folder.
#[derive(Debug)]
pub struct Bag {
    /// `metadata.yaml`.
    pub metadata: String,
    /// The messages.
    pub mcap: Vec<u8>,
    /// Topics with their numbers of messages.
    pub topics: Vec<(&'static str, u64)>,
}

/// Topics and types; in the order of [`Topic`].
const TOPICS: [(&str, &str); 6] = [
    ("/joint_states", "sensor_msgs/msg/JointState"),
    ("/tf", "tf2_msgs/msg/TFMessage"),
    ("/diagnostics", "diagnostic_msgs/msg/DiagnosticArray"),
    ("/sinew/cycle", "sinew_msgs/msg/Cycle"),
    ("/sinew/joints", "sinew_msgs/msg/Joints"),
    ("/sinew/muscles", "sinew_msgs/msg/Muscles"),
];

#[derive(Clone, Copy)]
enum Topic {
    JointStates,
    Transforms,
    Diagnostics,
    Cycle,
    Joints,
    Muscles,
}

/// What a change of is told by `/diagnostics` at once.
const STATE: [Signal; 4] = [Signal::Status, Signal::Fault, Signal::Mode, Signal::ModeFault];
/// Without a change it is told so often, ms.
const DIAGNOSTICS_EVERY: u64 = 1000;

/// The bag of a recording of a machine, one message of every topic every so many cycles; `file` is the name
/// of the file with the messages.
///
/// # Errors
/// Those of the recording's blocks; [`Error::Physics`] for a machine that is not the recording's.
pub fn ros2_bag(recording: &Recording<'_>, machine: &Machine, every: u64, file: &str) -> Result<Bag, Error> {
    let head = &recording.head;
    let columns = |signal: &Signal| head.place(*signal).map(|first| first..first + head.names(*signal).len());
    let place = |signal: &Signal| (head.is_slow(*signal), columns(signal).unwrap_or_default());
    let places: Vec<(bool, Range<usize>)> = Signal::ALL.iter().map(place).collect();
    let mut bag = Writing::new(head, machine)?;
    for block in recording.blocks() {
        let block = block?;
        for cycle in 0..block.count {
            bag.add(&Row { places: &places, stride: head.stride, block: &block, cycle }, every.max(1))?;
        }
    }
    bag.finish(file)
}

/// One cycle of a recording.
struct Row<'a> {
    /// Columns of every signal, in the order of the table, and whether they are slow; none where the
    /// recording lacks it.
    places: &'a [(bool, Range<usize>)],
    stride: u64,
    block: &'a Block,
    cycle: usize,
}

impl Row<'_> {
    fn index(&self) -> u64 {
        self.block.first + self.cycle as u64
    }

    /// The numbers of a signal; NaN where it is not kept in this cycle, none where the recording lacks it.
    fn of(&self, signal: Signal) -> Vec<f64> {
        let (slow, places) = &self.places[signal as usize];
        let (columns, row) = if *slow {
            (&self.block.slow, self.block.slow_row(self.cycle, self.stride))
        } else {
            (&self.block.fast, Some(self.cycle))
        };
        let columns = columns.get(places.clone()).unwrap_or_default().iter();
        let at = |column: &Vec<f64>| row.and_then(|row| column.get(row)).copied().unwrap_or(f64::NAN);
        columns.map(at).collect()
    }

    fn one(&self, signal: Signal) -> f64 {
        self.of(signal).first().copied().unwrap_or(f64::NAN)
    }

    /// Time of the cycle, ns since the start.
    fn since(&self) -> u64 {
        (self.one(Signal::Deadline).max(0.0) * 1e3).round() as u64
    }
}

/// A bag that is being written.
struct Writing {
    messages: Messages,
    writer: Writer<Cursor<Vec<u8>>>,
    /// Channel and number of messages of every topic.
    channels: [(u16, u64); TOPICS.len()],
    /// Times of the first and the last message, ns since 1970.
    times: Option<[u64; 2]>,
    /// Bits of the state that was told last.
    state: Option<[u64; STATE.len()]>,
}

impl Writing {
    fn new(head: &Head, machine: &Machine) -> Result<Self, Error> {
        let options = WriteOptions::new()
            .profile("ros2")
            .library(format!("sinew {}", head.program))
            .compression(Some(Compression::Zstd))
            .compression_level(1)
            .compression_threads(0);
        let mut writer = Writer::with_options(Cursor::new(Vec::new()), options)?;
        writer.write_metadata(&Metadata { name: "sinew".to_owned(), metadata: metadata(head) })?;
        let definitions = [
            definitions::joint_state(),
            definitions::transforms(),
            definitions::diagnostics(),
            definitions::signals(Axis::Cycle),
            definitions::signals(Axis::Joint),
            definitions::signals(Axis::Muscle),
        ];
        let quality = BTreeMap::from([("offered_qos_profiles".to_owned(), String::new())]);
        let mut channels = [(0, 0); TOPICS.len()];
        for ((channel, (topic, kind)), definition) in channels.iter_mut().zip(TOPICS).zip(definitions) {
            let schema = writer.add_schema(kind, "ros2msg", definition.as_bytes())?;
            channel.0 = writer.add_channel(schema, topic, "cdr", &quality)?;
        }
        let messages = Messages::new(machine, head.clone())?;
        Ok(Self { messages, writer, channels, times: None, state: None })
    }

    fn add(&mut self, row: &Row<'_>, every: u64) -> Result<(), Error> {
        let state = STATE.map(|signal| row.one(signal));
        let bits = Some(state.map(f64::to_bits));
        if bits != self.state || row.index().is_multiple_of(self.messages.head().cycles_of(DIAGNOSTICS_EVERY))
        {
            let message = self.messages.supervisor(row.since(), |signal| row.one(signal));
            self.put(Topic::Diagnostics, row.since(), &message)?;
            self.state = bits;
        }
        if !row.index().is_multiple_of(every) {
            return Ok(());
        }
        self.signals(row, Topic::Cycle, Axis::Cycle)?;
        self.signals(row, Topic::Joints, Axis::Joint)?;
        self.signals(row, Topic::Muscles, Axis::Muscle)?;
        self.pose(row)
    }

    fn put(&mut self, topic: Topic, since: u64, message: &Cdr) -> Result<(), Error> {
        let log_time = self.messages.head().start_ns + since;
        let (channel_id, count) = &mut self.channels[topic as usize];
        let sequence = *count as u32;
        *count += 1;
        let header = MessageHeader { channel_id: *channel_id, sequence, log_time, publish_time: log_time };
        self.writer.write_to_known_channel(&header, message.bytes())?;
        let [first, last] = self.times.unwrap_or([log_time; 2]);
        self.times = Some([first.min(log_time), last.max(log_time)]);
        Ok(())
    }

    fn signals(&mut self, row: &Row<'_>, topic: Topic, axis: Axis) -> Result<(), Error> {
        let mut message = self.messages.begin(row.since());
        match axis {
            Axis::Cycle => {}
            Axis::Joint => self.messages.joint_names(&mut message),
            Axis::Muscle => self.messages.muscle_names(&mut message),
        }
        for signal in Signal::ALL.iter().filter(|signal| signal.row().axis == axis) {
            match axis {
                Axis::Cycle => message.f64(row.one(*signal)),
                _ => message.f64s(&row.of(*signal)),
            }
        }
        self.put(topic, row.since(), &message)
    }

    /// Joints with the torques of the cables on them, and frames of the bodies.
    fn pose(&mut self, row: &Row<'_>) -> Result<(), Error> {
        let (pose, tension) = (pose(|signal| row.of(signal)), row.of(Signal::TensionOutEstimated));
        let message = self.messages.joint_states(row.since(), [&pose, &[], &tension])?;
        self.put(Topic::JointStates, row.since(), &message)?;
        match self.messages.transforms(row.since(), &pose)? {
            Some(message) => self.put(Topic::Transforms, row.since(), &message),
            None => Ok(()),
        }
    }

    fn finish(mut self, file: &str) -> Result<Bag, Error> {
        self.writer.finish()?;
        let topics: Vec<_> =
            TOPICS.iter().zip(self.channels).map(|((name, _), (_, count))| (*name, count)).collect();
        let metadata = about(file, &topics, self.times);
        Ok(Bag { metadata, mcap: self.writer.into_inner().into_inner(), topics })
    }
}

/// `metadata.yaml` of version 5, which every release since Humble reads.
fn about(file: &str, topics: &[(&str, u64)], times: Option<[u64; 2]>) -> String {
    let [first, last] = times.unwrap_or([0; 2]);
    let count: u64 = topics.iter().map(|(_, count)| count).sum();
    // A string of JSON is one of YAML.
    let file = serde_json::Value::from(file);
    let mut text = format!(
        "rosbag2_bagfile_information:
  version: 5
  storage_identifier: mcap
  duration:
    nanoseconds: {duration}
  starting_time:
    nanoseconds_since_epoch: {first}
  message_count: {count}
  compression_format: \"\"
  compression_mode: \"\"
  relative_file_paths:
    - {file}
  files:
    - path: {file}
      starting_time:
        nanoseconds_since_epoch: {first}
      duration:
        nanoseconds: {duration}
      message_count: {count}
  topics_with_message_count:
",
        duration = last - first
    );
    for ((name, count), (_, kind)) in topics.iter().zip(TOPICS) {
        text += &format!(
            "    - topic_metadata:
        name: {name}
        type: {kind}
        serialization_format: cdr
        offered_qos_profiles: \"\"
      message_count: {count}
"
        );
    }
    text
}
