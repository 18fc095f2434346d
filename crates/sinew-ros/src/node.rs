use crate::commands::Commands;
use crate::dds::{Asked, Graph, Incoming};
use crate::error::Error;
use crate::outgoing::{Outgoing, since_1970};
use crate::refusal::Refusal;
use crate::tap::{Tap, TapReader, tap};
use crate::topics::{MODES, Topic};
use crate::trigger::{reply, request_header};
use sinew::machine::Machine;
use sinew_link::host::{Domain, Port, SessionSettings};
use sinew_record::ros2::CdrReader;
use std::net::IpAddr;
use std::sync::Arc;
use std::sync::atomic::{AtomicBool, Ordering};
use std::thread::JoinHandle;
use std::time::{Duration, Instant};

/// A node as it is asked for.
pub struct NodeSettings<'a> {
    /// Number of the domain, as `ROS_DOMAIN_ID`.
    pub domain_id: u16,
    /// Of the network interface that is used.
    pub address: IpAddr,
    /// With its payload.
    pub machine: &'a Machine,
    /// Whether the machine is simulated.
    pub simulated: bool,
    /// What others may ask for; none where nobody may.
    pub commands: Option<(Domain, SessionSettings)>,
}

impl std::fmt::Debug for NodeSettings<'_> {
    fn fmt(&self, formatter: &mut std::fmt::Formatter<'_>) -> std::fmt::Result {
        write!(formatter, "a node in domain {} on {}", self.domain_id, self.address)
    }
}

/// What a node has done.
#[derive(Debug, Clone, Copy, Default, PartialEq, Eq)]
pub struct Counts {
    /// States of the joints that were published.
    pub published: u64,
    /// States that the node was too slow for, or that DDS did not take.
    pub missed: u64,
    /// Trajectories, set-points and requests that were taken.
    pub taken: u64,
    /// That were refused.
    pub refused: u64,
    /// Whether the node's thread panicked, and nothing is known of it; the machine was held from then on.
    pub failed: bool,
}

/// A running node; it ends when dropped.
#[derive(Debug)]
pub struct Node {
    thread: Option<JoinHandle<Counts>>,
    shared: Arc<Shared>,
}

#[derive(Debug, Default)]
struct Shared {
    stop: AtomicBool,
    /// Whether someone reads the states of the joints.
    is_read: AtomicBool,
}

/// Between two looks at what is to be published and what has come.
const LOOK: Duration = Duration::from_millis(1);
/// Messages that are taken in one look, at most.
const TAKEN: usize = 64;
/// Looks from one for other nodes to the next.
const LOOKS: u64 = 100;
/// From the first reader until it knows this node, too.
const KNOWN: Duration = Duration::from_millis(500);
/// Time in which the same refusal is not told again.
const AGAIN: Duration = Duration::from_secs(1);

impl Node {
    /// Starts the thread: the node, the control cycle's tap, and where others may command its port.
    ///
    /// # Errors
    /// [`Error::NotBuilt`]; [`Error::Dds`]; [`Error::Thread`]; for a machine that has no kinematics or is
    /// more than a link takes.
    pub fn start(settings: NodeSettings<'_>) -> Result<(Self, Tap, Option<Port>), Error> {
        let NodeSettings { domain_id, address, machine, simulated, commands } = settings;
        let outgoing = Outgoing::new(machine, simulated)?;
        let (commands, port) = match commands {
            Some((domain, sessions)) => {
                let (commands, port) = Commands::new(domain, outgoing.joints(), sessions)?;
                (Some(commands), Some(port))
            }
            None => (None, None),
        };
        let graph = Graph::new(domain_id, address, commands.is_some())?;
        let sizes = [machine.muscles.len(), machine.robot.independent_joints().len()];
        let (tap, reader) = tap(sizes, machine.period);
        let shared = Arc::<Shared>::default();
        let mut serving = Serving {
            graph,
            outgoing,
            commands,
            reader,
            start: Instant::now(),
            shared: Arc::clone(&shared),
            counts: Counts::default(),
            last: None,
        };
        let thread = std::thread::Builder::new().name("sinew-ros".into()).spawn(move || {
            serving.serve();
            serving.counts
        });
        Ok((Self { thread: Some(thread.map_err(Error::Thread)?), shared }, tap, port))
    }

    /// Waits until someone reads the states of the joints, at most this long.
    ///
    /// # Errors
    /// [`Error::NoReader`].
    pub fn wait_for_reader(&self, most: Duration) -> Result<(), Error> {
        let start = Instant::now();
        while !self.shared.is_read.load(Ordering::Relaxed) {
            if start.elapsed() > most {
                return Err(Error::NoReader { seconds: most.as_secs_f64() });
            }
            std::thread::sleep(LOOK);
        }
        std::thread::sleep(KNOWN);
        Ok(())
    }

    /// Ends the thread, behind what the tap was given until now.
    #[must_use]
    pub fn end(mut self) -> Counts {
        self.join().unwrap_or(Counts { failed: true, ..Counts::default() })
    }

    fn join(&mut self) -> Option<Counts> {
        self.shared.stop.store(true, Ordering::Release);
        self.thread.take()?.join().ok()
    }
}

impl Drop for Node {
    fn drop(&mut self) {
        let _ = self.join();
    }
}

/// The thread.
struct Serving {
    graph: Graph,
    outgoing: Outgoing,
    commands: Option<Commands>,
    reader: TapReader,
    start: Instant,
    shared: Arc<Shared>,
    counts: Counts,
    /// What was refused last, and when.
    last: Option<(String, Instant)>,
}

impl Serving {
    fn serve(&mut self) {
        let (mut looks, mut anyone) = (0_u64, false);
        loop {
            // Read first, so that the last state is published, too.
            let ends = self.shared.stop.load(Ordering::Acquire);
            self.publish();
            if looks.is_multiple_of(LOOKS) {
                self.shared.is_read.fetch_or(self.graph.is_read(), Ordering::Relaxed);
                anyone = self.commands.is_some() && self.graph.anyone();
            }
            looks += 1;
            for _ in 0..TAKEN {
                let Some(incoming) = self.graph.next() else { break };
                self.take(&incoming);
            }
            let now = self.now();
            if let Some(commands) = &mut self.commands {
                commands.pass(now, anyone);
            }
            if ends {
                self.graph.finish();
                self.counts.missed += self.reader.missed();
                return;
            }
            std::thread::sleep(LOOK);
        }
    }

    fn now(&self) -> u64 {
        self.start.elapsed().as_nanos() as u64
    }

    fn publish(&mut self) {
        let Self { reader, outgoing, graph, counts, .. } = self;
        while let Some(frame) = reader.read() {
            let mut sent = false;
            // A frame of another machine cannot be.
            let _ = outgoing.frame(frame, |topic, message| {
                let taken = graph.publish(topic, message);
                sent |= taken && topic == Topic::JointStates;
            });
            *(if sent { &mut counts.published } else { &mut counts.missed }) += 1;
        }
    }

    fn take(&mut self, incoming: &Incoming) {
        let now = self.now();
        let Some(commands) = &mut self.commands else { return };
        let message = CdrReader::of_fields(&incoming.fields, incoming.little_endian);
        let (name, result) = match incoming.what {
            Asked::Trajectory => (Topic::Trajectory.row().name, commands.trajectory(message, since_1970())),
            Asked::Setpoint => (Topic::Setpoint.row().name, commands.setpoint(incoming.sender, message, now)),
            Asked::Mode(service, request) => {
                let asked = commands.request(request);
                let text = match &asked {
                    Ok(mode) => format!("asked for {}, in mode {}", request.name(), mode.name()),
                    Err(refusal) => refusal.to_string(),
                };
                let answer = reply(request_header(&incoming.fields), asked.is_ok(), &text);
                self.graph.answer(incoming, &answer);
                (MODES.get(service).map_or("", |(name, _)| name), asked.map(|_| ()))
            }
        };
        match result {
            Ok(()) => self.counts.taken += 1,
            Err(refusal) => self.refuse(name, &refusal),
        }
    }

    /// Tells a refusal once, however often its cause is sent.
    fn refuse(&mut self, name: &str, refusal: &Refusal) {
        self.counts.refused += 1;
        let text = format!("{name} refused: {refusal}");
        let again = |(last, at): &(String, Instant)| *last == text && at.elapsed() < AGAIN;
        if !self.last.as_ref().is_some_and(again) {
            self.graph.publish(Topic::Diagnostics, &self.outgoing.refused(&text));
            self.last = Some((text, Instant::now()));
        }
    }
}
