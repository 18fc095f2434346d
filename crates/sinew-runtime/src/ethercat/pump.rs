//! Runs ethercrab's futures to their end in the calling thread.

use super::emergency;
use super::link::Link;
use super::time;
use core::future::Future;
use core::pin::pin;
use core::task::{Context, Poll, Waker};
use ethercrab::{PduLoop, PduRx, PduStorage, PduTx, ReceiveAction};

/// Frames in flight, at most: a power of 2.
const FRAMES: usize = 16;
/// Storage of a frame, octets: 1486 of process data, which with EtherCAT header (2), datagram header (10) and
/// working counter (2) fill an Ethernet payload of 1500, and the Ethernet header (14).
const DATA: usize = PduStorage::element_size(1486);
/// Largest Ethernet frame, without checksum.
pub(super) const MAX_FRAME: usize = 1514;

/// Frame buffers of one EtherCAT master (MainDevice).
pub struct FrameStorage(PduStorage<FRAMES, DATA>);

impl Default for FrameStorage {
    fn default() -> Self {
        Self::new()
    }
}

impl FrameStorage {
    /// Empty storage for one master.
    #[must_use]
    pub const fn new() -> Self {
        Self(PduStorage::new())
    }

    /// Its transmit, receive and frame-allocation handles; none from the second call on: a storage serves one
    /// master once.
    pub(super) fn split(&self) -> Option<(PduTx<'_>, PduRx<'_>, PduLoop<'_>)> {
        self.0.try_split().ok()
    }
}

/// Exchanges frames between ethercrab's futures and a link.
pub(super) struct Pump<'a, L> {
    tx: PduTx<'a>,
    rx: PduRx<'a>,
    link: L,
    buffer: [u8; MAX_FRAME],
    /// The last error of the link.
    error: Option<std::io::Error>,
    /// Whether any frame has come back.
    answered: bool,
}

impl<'a, L: Link> Pump<'a, L> {
    pub(super) fn new(tx: PduTx<'a>, rx: PduRx<'a>, link: L) -> Self {
        Self { tx, rx, link, buffer: [0; MAX_FRAME], error: None, answered: false }
    }

    pub(super) fn link(&self) -> &L {
        &self.link
    }

    pub(super) fn link_mut(&mut self) -> &mut L {
        &mut self.link
    }

    /// The last error of the link; it is cleared.
    pub(super) fn take_error(&mut self) -> Option<std::io::Error> {
        self.error.take()
    }

    /// Whether any frame has come back since the start.
    pub(super) fn answered(&self) -> bool {
        self.answered
    }

    /// Runs a future to its end: its own time-outs end it where no answer comes.
    pub(super) fn complete<F: Future>(&mut self, future: F) -> F::Output {
        let mut future = pin!(future);
        loop {
            if let Some(output) = self.poll_once(future.as_mut()) {
                return output;
            }
        }
    }

    /// Runs a future until a time, ns; none where it has not ended by then. What it sent may come back later
    /// and is then ignored.
    pub(super) fn complete_by<F: Future>(&mut self, deadline: u64, future: F) -> Option<F::Output> {
        let mut future = pin!(future);
        loop {
            if let Some(output) = self.poll_once(future.as_mut()) {
                return Some(output);
            }
            if self.link.now() >= deadline {
                return None;
            }
        }
    }

    fn poll_once<F: Future>(&mut self, future: core::pin::Pin<&mut F>) -> Option<F::Output> {
        time::set(self.link.now());
        if let Poll::Ready(output) = future.poll(&mut Context::from_waker(Waker::noop())) {
            return Some(output);
        }
        let Self { tx, rx, link, buffer, error, answered } = self;
        while let Some(frame) = tx.next_sendable_frame() {
            // Where the link fails, the frame counts as sent and lost: the future's time-out ends it.
            let sent = frame.send_blocking(|bytes| {
                if let Err(reason) = link.send(bytes) {
                    *error = Some(reason);
                }
                Ok(bytes.len())
            });
            debug_assert!(sent.is_ok());
        }
        let mut received = false;
        loop {
            match link.receive(buffer) {
                Ok(Some(length)) => {
                    received = true;
                    let frame = &buffer[..length.min(MAX_FRAME)];
                    if !emergency::is_in(frame) {
                        // A frame that came too late belongs to no future any more: ethercrab calls that an
                        // error. It ignores frames of this computer, which some interfaces give back
                        // unchanged.
                        let taken = rx.receive_frame(frame);
                        *answered |= matches!(taken, Ok(ReceiveAction::Processed));
                    }
                }
                Ok(None) => break,
                Err(reason) => {
                    *error = Some(reason);
                    break;
                }
            }
        }
        if !received {
            link.idle();
        }
        None
    }
}
