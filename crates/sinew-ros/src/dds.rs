//! The topics on DDS, as ROS 2 names them, by RustDDS.

use crate::commands::Sender;
use crate::error::Error;
use crate::topics::{MODES, Topic, TopicRow};
use rustdds::bytes::Bytes;
use rustdds::no_key::{self, DataWriter, Decode, DefaultDecoder, DeserializerAdapter, SerializerAdapter};
use rustdds::policy::{Durability, History, Reliability};
use rustdds::rpc::SampleIdentity;
use rustdds::{
    DataWriterStatus, DomainParticipant, DomainParticipantBuilder, Duration, QosPolicies, QosPolicyBuilder,
    RepresentationIdentifier, StatusEvented, Subscriber, TopicKind, WriteOptionsBuilder,
};
use sinew_link::Request;
use sinew_record::ros2::Cdr;
use std::convert::Infallible;
use std::net::IpAddr;

type Writer = DataWriter<Bytes, Octets>;
type Reader = no_key::SimpleDataReader<Payload, Octets>;

/// Something that another node sent.
pub(crate) struct Incoming {
    pub(crate) sender: Sender,
    pub(crate) fields: Vec<u8>,
    pub(crate) little_endian: bool,
    pub(crate) what: Asked,
    identity: SampleIdentity,
}

/// What it asks for.
#[derive(Clone, Copy)]
pub(crate) enum Asked {
    Trajectory,
    Setpoint,
    /// A service, its place among [`MODES`].
    Mode(usize, Request),
}

/// A participant with its topics.
pub(crate) struct Graph {
    /// In the order of [`OUT`].
    writers: Vec<Writer>,
    /// Those of modes first: a flood of others holds none up.
    readers: Vec<(Reader, Asked)>,
    /// Names of what is read, as DDS has them.
    read: Vec<String>,
    /// Of the services' answers.
    answers: Vec<Writer>,
    participant: DomainParticipant,
}

/// What is published, in the order of the table.
const OUT: [Topic; 4] = [Topic::JointStates, Topic::MuscleStates, Topic::Transforms, Topic::Diagnostics];
/// States that are kept for readers that miss some.
const DEPTH: i32 = 100;
/// How long the end waits for each topic's readers, at most.
const LAST: std::time::Duration = std::time::Duration::from_secs(1);
/// A reader that does not keep up makes nobody wait longer, ms.
const BLOCKING: i64 = 1;

fn quality(reliable: bool) -> QosPolicies {
    let reliability = if reliable {
        Reliability::Reliable { max_blocking_time: Duration::from_millis(BLOCKING) }
    } else {
        Reliability::BestEffort
    };
    QosPolicyBuilder::new()
        .reliability(reliability)
        .durability(Durability::Volatile)
        .history(History::KeepLast { depth: DEPTH })
        .build()
}

fn failed<E: std::fmt::Display>(what: &'static str) -> impl FnOnce(E) -> Error {
    move |error| Error::Dds { what, reason: error.to_string() }
}

/// Name of a topic on DDS, and of its type.
fn names(row: &TopicRow) -> (String, String) {
    let (package, message) = row.kind;
    (format!("rt/{}", row.name), format!("{package}::msg::dds_::{message}_"))
}

impl Graph {
    pub(crate) fn new(domain_id: u16, address: IpAddr, commanded: bool) -> Result<Self, Error> {
        let builder = DomainParticipantBuilder::new(domain_id).with_only_networks([address]);
        let participant = builder.build().map_err(failed("a participant"))?;
        let publisher = participant.create_publisher(&quality(true)).map_err(failed("a publisher"))?;
        let subscriber = participant.create_subscriber(&quality(true)).map_err(failed("a subscriber"))?;
        let writer = |(name, kind): (String, String)| {
            let topic = participant.create_topic(name, kind, &quality(true), TopicKind::NoKey);
            let topic = topic.map_err(failed("a topic"))?;
            publisher.create_datawriter_no_key::<Bytes, Octets>(&topic, None).map_err(failed("a writer"))
        };
        let writers = OUT.iter().map(|topic| writer(names(topic.row()))).collect::<Result<_, Error>>()?;
        let mut graph =
            Self { writers, readers: Vec::new(), read: Vec::new(), answers: Vec::new(), participant };
        if !commanded {
            return Ok(graph);
        }
        for (place, (mode, request)) in MODES.iter().enumerate() {
            let kind = |what| format!("std_srvs::srv::dds_::Trigger_{what}_");
            let asked = (format!("rq/sinew/{mode}Request"), kind("Request"));
            graph.subscribe(&subscriber, asked, true, Asked::Mode(place, *request))?;
            let topic = graph.participant.create_topic(
                format!("rr/sinew/{mode}Reply"),
                kind("Response"),
                &quality(true),
                TopicKind::NoKey,
            );
            let answer =
                publisher.create_datawriter_no_key::<Bytes, Octets>(&topic.map_err(failed("a topic"))?, None);
            graph.answers.push(answer.map_err(failed("a writer"))?);
        }
        graph.subscribe(&subscriber, names(Topic::Trajectory.row()), true, Asked::Trajectory)?;
        graph.subscribe(&subscriber, names(Topic::Setpoint.row()), false, Asked::Setpoint)?;
        Ok(graph)
    }

    fn subscribe(
        &mut self,
        subscriber: &Subscriber,
        (name, kind): (String, String),
        reliable: bool,
        what: Asked,
    ) -> Result<(), Error> {
        let quality = quality(reliable);
        let topic = self.participant.create_topic(name.clone(), kind, &quality, TopicKind::NoKey);
        let topic = topic.map_err(failed("a topic"))?;
        let reader = subscriber
            .create_simple_datareader_no_key::<Payload, Octets>(&topic, Some(quality))
            .map_err(failed("a reader"))?;
        self.readers.push((reader, what));
        self.read.push(name);
        Ok(())
    }

    /// Whether DDS has taken the message.
    pub(crate) fn publish(&self, topic: Topic, message: &Cdr) -> bool {
        let octets = Bytes::copy_from_slice(message.fields());
        self.writers.get(topic as usize).is_some_and(|writer| writer.write(octets, None).is_ok())
    }

    /// Waits until the readers have what was published, a little.
    pub(crate) fn finish(&self) {
        for writer in &self.writers {
            // Of readers that have gone nobody hears.
            let _ = writer.wait_for_acknowledgments(LAST);
        }
    }

    /// The next of what has come.
    pub(crate) fn next(&mut self) -> Option<Incoming> {
        self.readers.iter().find_map(|(reader, what)| {
            reader.drain_read_notifications();
            let change = reader.try_take_one().ok().flatten()?;
            let identity =
                SampleIdentity { writer_guid: change.writer_guid, sequence_number: change.sequence_number };
            let sender = change.writer_guid.to_bytes();
            let Payload { octets, little_endian } = change.into_value();
            Some(Incoming { sender, fields: octets, little_endian, what: *what, identity })
        })
    }

    /// Answers a service's request; where the answer is not taken its client asks again.
    pub(crate) fn answer(&self, incoming: &Incoming, message: &Cdr) {
        let Asked::Mode(service, _) = incoming.what else { return };
        let options = WriteOptionsBuilder::new().related_sample_identity(incoming.identity).build();
        if let Some(writer) = self.answers.get(service) {
            let _ = writer.write_with_options(Bytes::copy_from_slice(message.fields()), options);
        }
    }

    /// Whether someone has begun to read the states of the joints since this was asked last.
    pub(crate) fn is_read(&mut self) -> bool {
        let mut matched = false;
        if let Some(writer) = self.writers.first() {
            while let Some(status) = writer.try_recv_status() {
                matched |= matches!(status, DataWriterStatus::PublicationMatched { .. });
            }
        }
        matched
    }

    /// Whether another node writes to what is read.
    pub(crate) fn anyone(&self) -> bool {
        let writers = self.participant.discovered_writers();
        writers.iter().any(|writer| self.read.contains(&writer.publication_topic_data.topic_name))
    }
}

/// Fields of a message, as they came.
pub(crate) struct Payload {
    octets: Vec<u8>,
    little_endian: bool,
}

/// Messages that are octets already.
pub(crate) struct Octets;

/// What is no CDR.
#[derive(Debug, thiserror::Error)]
#[error("expected plain CDR")]
pub(crate) struct OtherEncoding;

impl SerializerAdapter<Bytes> for Octets {
    type Error = Infallible;

    fn output_encoding() -> RepresentationIdentifier {
        RepresentationIdentifier::CDR_LE
    }

    fn to_bytes(value: &Bytes) -> Result<Bytes, Infallible> {
        Ok(value.clone())
    }
}

impl DeserializerAdapter<Payload> for Octets {
    type Error = OtherEncoding;
    type Decoded = Payload;

    fn supported_encodings() -> &'static [RepresentationIdentifier] {
        &[RepresentationIdentifier::CDR_LE, RepresentationIdentifier::CDR_BE]
    }

    fn transform_decoded(decoded: Payload) -> Payload {
        decoded
    }
}

impl DefaultDecoder<Payload> for Octets {
    type Decoder = OctetDecoder;

    const DECODER: OctetDecoder = OctetDecoder;
}

/// Takes the octets as they are.
#[derive(Clone)]
pub(crate) struct OctetDecoder;

impl Decode<'_, Payload> for OctetDecoder {
    type Error = OtherEncoding;

    fn decode_bytes(
        self,
        octets: &[u8],
        encoding: RepresentationIdentifier,
    ) -> Result<Payload, OtherEncoding> {
        match encoding {
            RepresentationIdentifier::CDR_LE => Ok(Payload { octets: octets.to_vec(), little_endian: true }),
            RepresentationIdentifier::CDR_BE => Ok(Payload { octets: octets.to_vec(), little_endian: false }),
            _ => Err(OtherEncoding),
        }
    }
}
