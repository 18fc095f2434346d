//! A control cycle over EtherCAT allocates nothing: master, drives, observers, controller, simulated devices and twin.

#![allow(clippy::unwrap_used, reason = "a failing test may panic")]
#![allow(dead_code, reason = "the machines are those of the other tests")]

#[path = "runtime/common.rs"]
mod common;

use common::{Setup, machine};
use core::alloc::{GlobalAlloc, Layout};
use core::cell::Cell;
use sinew::control::supervisor::{Mode, Request};
use sinew_runtime::cycle::{Cycle, VirtualClock};
use sinew_runtime::ethercat::FrameStorage;
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
fn a_cycle_over_ethercat_allocates_nothing() {
    for name in ["lm_arm", "finger"] {
        let setup = Setup::new(machine(name), 1, &[]);
        let storage = FrameStorage::new();
        let bus = setup.segment_bus(&storage);
        let mut cycle = Cycle::new(bus, setup.supervisor(), setup.schedule(), common::STEP);
        let mut clock = VirtualClock::default();
        let before = ALLOCATIONS.get();
        let mut moved = 0.0_f64;
        for _ in 0..1500 {
            let record = cycle.step(&mut clock, 0).unwrap();
            assert!(record.exchange.fault.is_none());
            moved = moved.max((record.command.arm.q[0] - setup.machine.start[0]).abs());
        }
        // Let down, taken up again, held.
        for (request, cycles) in [(Request::SafeStop, 20_000), (Request::Hold, 8000)] {
            cycle.set_request(request);
            for _ in 0..cycles {
                cycle.step(&mut clock, 0).unwrap();
            }
        }
        assert_eq!(ALLOCATIONS.get() - before, 0, "{name}");
        assert_eq!(cycle.supervisor().mode(), Mode::Hold, "{name}");
        assert!(moved > 1e-3, "{name}: the machine moved");
    }
}
