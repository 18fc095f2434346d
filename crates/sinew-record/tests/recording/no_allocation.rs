//! A control cycle that is recorded allocates nothing.

use crate::common::{Memory, Setup};
use allocation_counter::measure;
use sinew_runtime::cycle::VirtualClock;

#[test]
fn a_recorded_cycle_allocates_nothing() {
    for name in ["lm_arm", "finger"] {
        let setup = Setup::new(name, 1);
        let memory = Memory::default();
        let mut recorder = setup.recorder(memory.clone());
        let (mut cycle, mut clock) = (setup.cycle(), VirtualClock::default());
        let mut recorded = 0;
        let counted = measure(|| {
            for _ in 0..2000 {
                let record = cycle.step(&mut clock, 0).unwrap();
                recorded += usize::from(recorder.record(&record));
            }
        });
        assert_eq!(counted.count_total, 0, "{name}");
        assert_eq!(recorded, 2000, "{name}: the ring had room");
        let recorded = recorder.finish().unwrap();
        assert_eq!((recorded.cycles, recorded.dropped), (2000, 0), "{name}");
        assert!(memory.bytes().len() > 20_000, "{name}");
    }
}
