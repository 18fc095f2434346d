//! The time that ethercrab's time-outs are measured in: that of the link whose frames the calling thread
//! pumps.

use core::cell::Cell;
use core::task::Waker;
use embassy_time_driver::{Driver, TICK_HZ};

thread_local! {
    /// Time of the thread, ns.
    static NOW: Cell<u64> = const { Cell::new(0) };
}

/// Sets the time of this thread, ns.
pub(super) fn set(now: u64) {
    NOW.set(now);
}

struct LinkTime;

impl Driver for LinkTime {
    fn now(&self) -> u64 {
        (u128::from(NOW.get()) * u128::from(TICK_HZ) / 1_000_000_000) as u64
    }

    fn schedule_wake(&self, _at: u64, _waker: &Waker) {
        // The pump polls whatever it waits for.
    }
}

embassy_time_driver::time_driver_impl!(static DRIVER: LinkTime = LinkTime);
