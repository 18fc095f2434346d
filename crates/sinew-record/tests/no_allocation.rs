//! A control cycle that is recorded allocates nothing.

#![allow(clippy::unwrap_used, reason = "a failing test may panic")]
#![allow(dead_code, reason = "the machines are those of the other tests")]

#[path = "recording/common.rs"]
mod common;

use common::{Memory, Setup};
use core::alloc::{GlobalAlloc, Layout};
use core::cell::Cell;
use sinew_runtime::cycle::VirtualClock;
use std::alloc::System;

thread_local! {
    static ALLOCATIONS: Cell<usize> = const { Cell::new(0) };
}

struct Counting;

#[expect(unsafe_code, reason = "an allocator that counts has to implement the unsafe trait")]
// SAFETY: every call goes to the system's allocator unchanged.
unsafe impl GlobalAlloc for Counting {
    unsafe fn alloc(&self, layout: Layout) -> *mut u8 {
        ALLOCATIONS.set(ALLOCATIONS.get() + 1);
        // SAFETY: the caller keeps the contract of `alloc`.
        unsafe { System.alloc(layout) }
    }

    unsafe fn dealloc(&self, pointer: *mut u8, layout: Layout) {
        // SAFETY: the caller keeps the contract of `dealloc`.
        unsafe { System.dealloc(pointer, layout) }
    }
}

#[global_allocator]
static ALLOCATOR: Counting = Counting;

#[test]
fn a_recorded_cycle_allocates_nothing() {
    for name in ["lm_arm", "finger"] {
        let setup = Setup::new(name, 1);
        let memory = Memory::default();
        let mut recorder = setup.recorder(memory.clone());
        let (mut cycle, mut clock) = (setup.cycle(), VirtualClock::default());
        let before = ALLOCATIONS.get();
        let mut recorded = 0;
        for _ in 0..2000 {
            let record = cycle.step(&mut clock, 0).unwrap();
            recorded += usize::from(recorder.record(&record));
        }
        assert_eq!(ALLOCATIONS.get() - before, 0, "{name}");
        assert_eq!(recorded, 2000, "{name}: the ring had room");
        let recorded = recorder.finish().unwrap();
        assert_eq!((recorded.cycles, recorded.dropped), (2000, 0), "{name}");
        assert!(memory.bytes().len() > 20_000, "{name}");
    }
}
