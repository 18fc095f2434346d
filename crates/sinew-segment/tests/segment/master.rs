//! Runs the futures of ethercrab on a segment: every frame is answered at once, and virtual time passes where
//! nothing else happens.

use core::future::Future;
use core::pin::pin;
use core::sync::atomic::{AtomicU64, Ordering};
use core::task::{Context, Poll, Waker};
use ethercrab::{PduRx, PduTx, Timeouts};
use sinew_segment::{Passed, Segment};
use std::sync::{Mutex, MutexGuard, PoisonError};
use std::time::Duration;

static NOW_NS: AtomicU64 = AtomicU64::new(1);
/// One line at a time: all masters of a process have this time.
static TIME: Mutex<()> = Mutex::new(());

/// Virtual time, ns.
pub(crate) fn now() -> u64 {
    NOW_NS.load(Ordering::Relaxed)
}

/// Time of the master's timers.
struct VirtualTime;

impl embassy_time_driver::Driver for VirtualTime {
    fn now(&self) -> u64 {
        now() / (1_000_000_000 / embassy_time_driver::TICK_HZ)
    }
    fn schedule_wake(&self, _at: u64, _waker: &Waker) {}
}

embassy_time_driver::time_driver_impl!(static DRIVER: VirtualTime = VirtualTime);

/// Generous, as virtual time costs nothing.
pub(crate) fn timeouts(default: Timeouts) -> Timeouts {
    Timeouts { pdu: Duration::from_millis(50), wait_loop_delay: Duration::from_micros(50), ..default }
}

/// The wire between master and segment.
pub(crate) struct Line {
    segment: Segment,
    tx: PduTx<'static>,
    rx: PduRx<'static>,
    _time: MutexGuard<'static, ()>,
}

/// Virtual time that a frame takes, and a poll without a frame.
const FRAME_NS: u64 = 20_000;
const IDLE_NS: u64 = 10_000;
/// Polls without end are a hang.
const MAX_POLLS: usize = 2_000_000;

impl Line {
    pub(crate) fn new(segment: Segment, tx: PduTx<'static>, rx: PduRx<'static>) -> Self {
        Self { segment, tx, rx, _time: TIME.lock().unwrap_or_else(PoisonError::into_inner) }
    }

    pub(crate) fn segment(&self) -> &Segment {
        &self.segment
    }

    pub(crate) fn segment_mut(&mut self) -> &mut Segment {
        &mut self.segment
    }

    pub(crate) fn wait(&mut self, nanoseconds: u64) {
        NOW_NS.fetch_add(nanoseconds, Ordering::Relaxed);
        self.segment.advance(nanoseconds);
    }

    pub(crate) fn run<F: Future>(&mut self, future: F) -> F::Output {
        let mut future = pin!(future);
        let mut context = Context::from_waker(Waker::noop());
        for _ in 0..MAX_POLLS {
            if let Poll::Ready(output) = future.as_mut().poll(&mut context) {
                return output;
            }
            if !self.exchange() {
                self.wait(IDLE_NS);
            }
        }
        panic!("the master waits indefinitely");
    }

    fn exchange(&mut self) -> bool {
        let Some(frame) = self.tx.next_sendable_frame() else { return false };
        let mut answer = Vec::new();
        frame
            .send_blocking(|octets| {
                answer = octets.to_vec();
                Ok(octets.len())
            })
            .unwrap();
        self.wait(FRAME_NS);
        if matches!(self.segment.process(&mut answer), Passed::Returned { .. }) {
            self.rx.receive_frame(&answer).unwrap();
        }
        true
    }
}
