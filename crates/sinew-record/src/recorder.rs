//! From the control cycle to the file: a ring that never blocks the cycle, and a thread that writes.

use crate::block::BlockBuilder;
use crate::channels::{Container, File, Topic};
use crate::error::Error;
use crate::fields::Fields;
use crate::head::{BLOCK, Head};
use crate::messages::{LinkInput, Log, Timestamp};
use crate::sink::{SharedSink, Storage};
use crate::view::View;
use rtrb::{Consumer, Producer, RingBuffer};
use sinew::control::arm::ArmStatus;
use sinew::machine::Machine;
use sinew_runtime::link::{Tape, TapeReader};
use sinew_session::signals::{FrameLayout, Signal, status_of};
use sinew_session::{CycleRecord, Plant};
use std::collections::VecDeque;
use std::sync::Arc;
use std::sync::atomic::{AtomicBool, AtomicU64, Ordering};
use std::thread::JoinHandle;
use std::time::Duration;

/// Cycles that the ring holds.
const RING: usize = 4096;
/// Time after which the thread looks into an empty ring again.
const PAUSE: Duration = Duration::from_millis(20);
/// Milliseconds between two messages of the bodies' frames: 5 per second.
const FRAMES_EVERY: u64 = 200;
/// Milliseconds between two messages of the muscles: 1 per second.
const MUSCLES_EVERY: u64 = 1000;

/// The control cycle's end of the ring: puts every cycle into it.
#[derive(Debug)]
pub struct Recorder {
    ring: Producer<f64>,
    layout: Arc<FrameLayout>,
    index: u64,
    first_deadline: Option<u64>,
    shared: Arc<Shared>,
    thread: Option<JoinHandle<Result<Recorded, Error>>>,
}

#[derive(Debug, Default)]
struct Shared {
    dropped: AtomicU64,
    finished: AtomicBool,
}

/// What was recorded.
#[derive(Debug, Clone, Copy, PartialEq, Eq, Default)]
pub struct Recorded {
    /// Cycles in the file.
    pub cycles: u64,
    /// Cycles that the ring had no room for.
    pub dropped: u64,
    /// Length of the file, bytes.
    pub bytes: u64,
    /// Processor time of the writing thread, ns; 0 where the system does not tell.
    pub cpu_ns: u64,
}

impl Recorder {
    /// Writes head and files, and starts the thread that writes the rest. Where it fails later, it calls
    /// `failed` once and discards what follows; the cycle goes on.
    ///
    /// # Errors
    /// [`Error::Write`] where the storage refuses the head, [`Error::Thread`] where no thread starts,
    /// [`Error::Physics`] for a machine whose kinematics cannot be evaluated.
    pub fn start(
        storage: Box<dyn Storage>,
        head: Head,
        machine: &Machine,
        files: &[File],
        failed: impl FnOnce(&Error) + Send + 'static,
    ) -> Result<Self, Error> {
        Self::start_with(storage, (head, machine, files), None, failed)
    }

    /// As [`start`](Self::start), for a run that a client commands or that may be stopped from elsewhere:
    /// what is put on the returned tape is recorded too; see
    /// [`RunMotion::with_tape`](sinew_runtime::link::RunMotion::with_tape).
    ///
    /// # Errors
    /// As [`start`](Self::start).
    pub fn start_with_tape(
        storage: Box<dyn Storage>,
        head: Head,
        machine: &Machine,
        files: &[File],
        failed: impl FnOnce(&Error) + Send + 'static,
    ) -> Result<(Self, Tape), Error> {
        let (tape, reader) = Tape::new(head.virtual_time);
        Ok((Self::start_with(storage, (head, machine, files), Some(reader), failed)?, tape))
    }

    fn start_with(
        storage: Box<dyn Storage>,
        (head, machine, files): (Head, &Machine, &[File]),
        link: Option<TapeReader>,
        failed: impl FnOnce(&Error) + Send + 'static,
    ) -> Result<Self, Error> {
        let layout = Arc::new(FrameLayout::new([head.muscles.len(), head.joints.len()], head.simulated));
        let (ring, consumer) = RingBuffer::new(RING * words(&layout));
        let view = View::new(machine)?;
        let container = Container::new(SharedSink::new(storage), &head, files)?;
        let shared = Arc::new(Shared::default());
        let inputs = VecDeque::new();
        let fields = [Fields::new(&head.fast), Fields::new(&head.slow)];
        let of_thread = (layout.clone(), shared.clone());
        let (drained, told) = of_thread;
        let drain =
            Drain { consumer, link, inputs, layout: drained, head, fields, view, container, shared: told };
        let thread = std::thread::Builder::new()
            .name("recorder".to_owned())
            .spawn(move || drain.run(failed))
            .map_err(|error| Error::Thread(error.to_string()))?;
        Ok(Self { ring, layout, index: 0, first_deadline: None, shared, thread: Some(thread) })
    }

    /// Puts a cycle into the ring; `false` where there is no room for it: it is counted and missing in the
    /// recording. Allocates nothing, takes no lock and makes no system call.
    pub fn record<P: Plant>(&mut self, record: &CycleRecord<'_, P>) -> bool {
        let put = self.try_record(record);
        if !put {
            self.shared.dropped.fetch_add(1, Ordering::Relaxed);
        }
        self.index += 1;
        put
    }

    /// As [`record`](Self::record), but waits for room: on virtual time, where no deadline passes meanwhile.
    /// A cycle after the thread has ended is counted as dropped.
    pub fn record_all<P: Plant>(&mut self, record: &CycleRecord<'_, P>) {
        while !self.try_record(record) {
            if self.thread.as_ref().is_none_or(JoinHandle::is_finished) {
                self.shared.dropped.fetch_add(1, Ordering::Relaxed);
                break;
            }
            std::thread::sleep(Duration::from_millis(1));
        }
        self.index += 1;
    }

    fn try_record<P: Plant>(&mut self, record: &CycleRecord<'_, P>) -> bool {
        let first = *self.first_deadline.get_or_insert(record.times.deadline);
        let deadline_us = record.times.deadline.saturating_sub(first) as f64 * 1e-3;
        // The ring holds whole samples only, so that none is split at its end.
        let Ok(mut chunk) = self.ring.write_chunk(words(&self.layout)) else { return false };
        let (sample, _) = chunk.as_mut_slices();
        let (index, rest) = sample.split_at_mut(1);
        let (frame, rates) = rest.split_at_mut(self.layout.words());
        index.fill(self.index as f64);
        self.layout.fill(frame, &record.seen());
        frame[self.layout.place(Signal::Deadline)].fill(deadline_us);
        let [velocity, acceleration] = [&record.reference.v, &record.reference.a];
        rates.iter_mut().zip(velocity.iter().chain(acceleration)).for_each(|(to, from)| *to = *from);
        chunk.commit_all();
        true
    }

    /// Cycles that the ring had no room for.
    #[must_use]
    pub fn dropped(&self) -> u64 {
        self.shared.dropped.load(Ordering::Relaxed)
    }

    /// Waits until everything is written.
    ///
    /// # Errors
    /// The first error of the writing thread; [`Error::Thread`] where it panicked.
    pub fn finish(mut self) -> Result<Recorded, Error> {
        self.shared.finished.store(true, Ordering::Release);
        let Some(thread) = self.thread.take() else { return Ok(Recorded::default()) };
        thread.join().unwrap_or_else(|_| Err(Error::Thread("the writing thread has panicked".to_owned())))
    }
}

impl Drop for Recorder {
    fn drop(&mut self) {
        self.shared.finished.store(true, Ordering::Release);
        if let Some(thread) = self.thread.take() {
            // The result belongs to `finish`; here the file is only to be complete.
            let _ = thread.join();
        }
    }
}

/// The writing thread's end of the ring: takes the cycles out and writes them.
struct Drain {
    consumer: Consumer<f64>,
    link: Option<TapeReader>,
    /// Inputs of the link whose cycles have not been written.
    inputs: VecDeque<LinkInput>,
    layout: Arc<FrameLayout>,
    head: Head,
    /// Of the messages of every cycle and of the slow ones.
    fields: [Fields; 2],
    view: View,
    container: Container,
    shared: Arc<Shared>,
}

impl Drain {
    fn run(mut self, failed: impl FnOnce(&Error)) -> Result<Recorded, Error> {
        let mut recorded = Recorded::default();
        let written = self.write(&mut recorded);
        let Self { consumer, link, container, shared, .. } = self;
        match written.and_then(|()| container.finish()) {
            Ok(bytes) => Ok(Recorded { bytes, cpu_ns: cpu_time(), ..recorded }),
            Err(error) => {
                failed(&error);
                discard(consumer, link, &shared);
                Err(error)
            }
        }
    }

    /// Writes until the recorder is finished and the ring empty.
    fn write(&mut self, recorded: &mut Recorded) -> Result<(), Error> {
        let mut block = BlockBuilder::new(self.layout.clone(), &self.head);
        let whole = self.head.cycles_of(BLOCK as u64) as usize;
        let mut sample = vec![0.0; words(&self.layout)];
        let mut status = None;
        loop {
            // Read before the ring is, so that nothing that was recorded before the end is missed.
            let finished = self.shared.finished.load(Ordering::Acquire);
            while self.consumer.pop_entire_slice(&mut sample).is_ok() {
                let index = sample[0] as u64;
                let (frame, rates) = sample[1..].split_at(self.layout.words());
                if !block.continues(index) || block.len() >= whole {
                    self.write_block(&mut block)?;
                }
                recorded.cycles += 1;
                self.show(index, frame, &mut status)?;
                block.push(index, frame, rates);
            }
            self.read_link();
            recorded.dropped = self.shared.dropped.load(Ordering::Relaxed);
            if finished {
                if block.len() > 0 {
                    self.write_block(&mut block)?;
                }
                return Ok(());
            }
            std::thread::sleep(PAUSE);
        }
    }

    fn write_block(&mut self, block: &mut BlockBuilder) -> Result<(), Error> {
        let dropped = self.shared.dropped.load(Ordering::Relaxed);
        let (first, end) = (block.first(), block.end());
        let (mut message, [fast, slow]) = block.take(&self.head, dropped);
        let since = |row: usize| fast.first().map_or(0, |us| (us[row].max(0.0) * 1e3).round() as u64);
        // What a cycle took is on the tape before its sample is in the ring.
        self.read_link();
        let until = end.saturating_mul(self.head.period_ns);
        let taken = self.inputs.iter().take_while(|input| input.at_ns < until).count();
        message.link = self.inputs.drain(..taken).collect();
        message.dropped_link = self.link.as_ref().map_or(0, TapeReader::dropped);
        self.container.put(Topic::Block, since(0), &message)?;
        let rows = (end - first) as usize;
        for row in 0..rows {
            self.container.put_bytes(Topic::Cycle, since(row), &self.fields[0].encode(&fast, row))?;
        }
        // Behind the cycles, which are found as repeats of each other.
        let slow_rows = (0..rows).filter(|row| (first + *row as u64).is_multiple_of(self.head.stride));
        for (k, row) in slow_rows.enumerate() {
            self.container.put_bytes(Topic::Slow, since(row), &self.fields[1].encode(&slow, k))?;
        }
        self.container.commit()
    }

    /// Empties the tape, so that a cycle that waits for room goes on.
    fn read_link(&mut self) {
        while let Some(input) = self.link.as_mut().and_then(TapeReader::read) {
            self.inputs.push_back(LinkInput { at_ns: input.at_ns, command: input.to_bytes() });
        }
    }

    /// Writes the messages for viewers that are due: signals, frames, scene, and changes of the status.
    fn show(&mut self, index: u64, frame: &[f64], status: &mut Option<[f64; 4]>) -> Result<(), Error> {
        let layout = Arc::clone(&self.layout);
        let one = |signal| layout.of(signal, frame).first().copied().unwrap_or(f64::NAN);
        // Where cycles were skipped, time went on.
        let since = (one(Signal::Deadline).max(0.0) * 1e3).round() as u64;
        let time = self.head.start_ns + since;
        let first = status.is_none();
        let due = |milliseconds| index.is_multiple_of(self.head.cycles_of(milliseconds));
        let [q, tension] =
            [Signal::JointEstimated, Signal::TensionOutEstimated].map(|signal| layout.of(signal, frame));
        if q.iter().all(|q| q.is_finite()) {
            if first || due(FRAMES_EVERY) {
                self.container.put(Topic::Frames, since, &self.view.transforms(q, time, first)?)?;
            }
            if first {
                self.container.put(Topic::Scene, since, &self.view.bodies(q, time)?)?;
            }
            if first || due(MUSCLES_EVERY) {
                self.container.put(Topic::Scene, since, &self.view.muscles(q, tension, time)?)?;
            }
        }
        let now = [Signal::Status, Signal::Fault, Signal::Mode, Signal::ModeFault].map(one);
        if *status != Some(now) {
            let found = status_of(now[0], now[1]);
            let log = Log {
                timestamp: Some(Timestamp::from_ns(time)),
                level: level(found),
                message: self.head.mode_name(now[2], now[3], found),
                name: "controller".to_owned(),
            };
            self.container.put(Topic::Log, since, &log)?;
            *status = Some(now);
        }
        Ok(())
    }
}

/// Numbers of a sample in the ring: index, frame, velocity and acceleration of the reference.
fn words(layout: &FrameLayout) -> usize {
    let [_, joints] = layout.sizes();
    1 + layout.words() + 2 * joints
}

/// Empties ring and tape until the recorder is finished, so that the cycle goes on after a failure.
fn discard(mut ring: Consumer<f64>, mut link: Option<TapeReader>, shared: &Shared) {
    while !(shared.finished.load(Ordering::Acquire) && ring.is_empty()) {
        let ready = ring.slots();
        if let Ok(chunk) = ring.read_chunk(ready) {
            chunk.commit_all();
        }
        while link.as_mut().and_then(TapeReader::read).is_some() {}
        std::thread::sleep(PAUSE);
    }
}

/// Level of a status in `foxglove.Log`: information, warning, error.
pub(crate) fn level(status: ArmStatus) -> i32 {
    match status {
        ArmStatus::Following | ArmStatus::Holding => 2,
        ArmStatus::Degraded(_) => 3,
        ArmStatus::Stopped(_) => 4,
    }
}

/// Processor time of this thread, ns.
fn cpu_time() -> u64 {
    let text = std::fs::read_to_string("/proc/thread-self/schedstat").unwrap_or_default();
    text.split_whitespace().next().and_then(|ns| ns.parse().ok()).unwrap_or(0)
}
