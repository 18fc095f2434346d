//! A full disk.

use crate::common::{Memory, Setup};
use sinew_record::{Recorder, Recording};
use sinew_runtime::cycle::VirtualClock;
use std::sync::Arc;
use std::sync::atomic::{AtomicUsize, Ordering};

#[test]
fn a_full_disk_leaves_whole_cycles_and_one_message() {
    let setup = Setup::new("bench_joint", 1);
    let fits = |limit: &usize| {
        let memory = Box::new(Memory::with_limit(*limit));
        Recorder::start(memory, setup.head(), &setup.machine, &[], |_| {}).is_ok()
    };
    let head = (0..1_000_000).step_by(2000).find(fits).unwrap();
    let whole = setup.recorded().0.len();
    for limit in [head, head + 5000, head + 20_000, whole - 30_000, whole - 3000, whole] {
        let (memory, told) = (Memory::with_limit(limit), Arc::new(AtomicUsize::new(0)));
        let failed = {
            let told = told.clone();
            move |_: &sinew_record::Error| {
                told.fetch_add(1, Ordering::Relaxed);
            }
        };
        let mut recorder =
            Recorder::start(Box::new(memory.clone()), setup.head(), &setup.machine, &[], failed).unwrap();
        let (mut cycle, mut clock) = (setup.cycle(), VirtualClock::default());
        let mut cycles = 0;
        while !cycle.is_finished() {
            let record = cycle.step(&mut clock, 0).unwrap();
            recorder.record_all(&record);
            cycles += 1;
        }
        assert_eq!(cycles, 2500, "the cycle goes on");
        let ended = recorder.finish();
        let bytes = memory.bytes();
        let recording = Recording::read(&bytes).unwrap();
        assert!(recording.complete, "the file has an end");
        let kept: usize = recording.blocks().map(|block| block.unwrap().count).sum();
        if bytes.len() < limit && ended.is_ok() {
            // The file without attachments fitted.
            assert_eq!(kept, 2500);
            continue;
        }
        assert!(ended.is_err(), "{limit}");
        assert_eq!(told.load(Ordering::Relaxed), 1, "told once");
        assert!(kept.is_multiple_of(500) && kept <= 2500);
    }
}

#[test]
fn a_disk_without_room_for_the_head_is_an_error_at_the_start() {
    let setup = Setup::new("bench_joint", 1);
    let memory = Memory::with_limit(100);
    let started = Recorder::start(Box::new(memory), setup.head(), &setup.machine, &[], |_| {});
    assert!(started.unwrap_err().is_of_the_system());
}
