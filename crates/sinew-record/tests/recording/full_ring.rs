//! A writer that does not keep up.

use crate::common::{Memory, Setup};
use sinew_record::{Recorder, Recording, Replay, Storage};
use sinew_runtime::cycle::VirtualClock;
use std::io::{self, Write};
use std::sync::{Arc, Mutex};

/// A storage that waits while a lock is held.
struct Slow(Memory, Arc<Mutex<()>>);

impl Write for Slow {
    fn write(&mut self, bytes: &[u8]) -> io::Result<usize> {
        let _waited = self.1.lock().unwrap();
        self.0.write(bytes)
    }

    fn flush(&mut self) -> io::Result<()> {
        Ok(())
    }
}

impl Storage for Slow {
    fn truncate(&mut self, length: u64) -> io::Result<()> {
        self.0.truncate(length)
    }
}

#[test]
fn cycles_without_room_are_counted_and_end_the_replay() {
    let setup = Setup::new("bench_joint", 1);
    let (memory, gate) = (Memory::default(), Arc::new(Mutex::new(())));
    let storage = Box::new(Slow(memory.clone(), gate.clone()));
    let mut recorder = Recorder::start(storage, setup.head(), &setup.machine, &[], |_| {}).unwrap();
    let held = gate.lock().unwrap();
    let mut refused = 0;
    // The ring holds 4096 cycles; the thread takes at most one block out of it before it waits.
    for _ in 0..4 {
        let (mut cycle, mut clock) = (setup.cycle(), VirtualClock::default());
        while !cycle.is_finished() {
            let record = cycle.step(&mut clock, 0).unwrap();
            refused += u64::from(!recorder.record(&record));
        }
    }
    drop(held);
    assert!(refused > 4000, "{refused}");
    assert_eq!(recorder.dropped(), refused);
    // Once it keeps up again, recording goes on behind the gap.
    std::thread::sleep(std::time::Duration::from_millis(300));
    let (mut cycle, mut clock) = (setup.cycle(), VirtualClock::default());
    for _ in 0..600 {
        let record = cycle.step(&mut clock, 0).unwrap();
        recorder.record_all(&record);
    }
    let recorded = recorder.finish().unwrap();
    assert_eq!(recorded.dropped, refused);
    assert_eq!(recorded.cycles + refused, 10_600);

    let bytes = memory.bytes();
    let recording = Recording::read(&bytes).unwrap();
    let blocks: Vec<_> = recording.blocks().map(|block| block.unwrap()).collect();
    let kept: usize = blocks.iter().map(|block| block.count).sum();
    assert_eq!(kept as u64, recorded.cycles);
    assert_eq!(blocks.last().unwrap().dropped, refused);
    let gap = blocks.windows(2).find(|pair| pair[0].first + pair[0].count as u64 != pair[1].first);
    let gap = gap.map(|pair| pair[0].first + pair[0].count as u64).unwrap();
    let mut replay = Replay::new(&recording, setup.supervisor(), setup.schedule()).unwrap();
    let mut cycles = 0;
    while replay.step().unwrap().is_some() {
        cycles += 1;
    }
    assert_eq!((replay.gap(), cycles), (Some(gap), gap));
}
