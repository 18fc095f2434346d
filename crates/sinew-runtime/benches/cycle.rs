//! Cost of the control cycle over EtherCAT: the controller, and the master's coding of the process data
//! beside it.
//!
//! The time of the simulated devices and of the twin behind them is measured apart and left out.

#![allow(clippy::unwrap_used, reason = "a bench that cannot start may panic")]
#![allow(clippy::print_stdout, reason = "a bench prints")]
#![allow(dead_code, reason = "the machines are those of the tests")]

#[path = "../tests/runtime/common.rs"]
mod common;

use common::{Setup, machine};
use sinew::drive::DriveCommand;
use sinew_runtime::cycle::{Cycle, MonotonicClock};
use sinew_runtime::ethercat::{EthercatBus, FrameStorage, Link, Master, SegmentLink};
use sinew_session::{Exchange, Feedback, Plant};
use std::io;
use std::time::{Duration, Instant};

fn main() {
    println!("us  drives  coding: median   p99  control: median   p99");
    for name in ["bench_joint", "planar_leg", "finger", "surgical_wrist", "shoulder", "lm_arm", "chain10"] {
        measure(name);
    }
}

/// A link that counts the time spent behind it.
struct Timed {
    link: SegmentLink,
    behind: Duration,
}

impl Timed {
    fn timed<T>(&mut self, work: impl FnOnce(&mut SegmentLink) -> T) -> T {
        let begin = Instant::now();
        let result = work(&mut self.link);
        self.behind += begin.elapsed();
        result
    }
}

impl Link for Timed {
    fn now(&mut self) -> u64 {
        self.link.now()
    }

    fn send(&mut self, frame: &[u8]) -> io::Result<()> {
        self.timed(|link| link.send(frame))
    }

    fn receive(&mut self, buffer: &mut [u8]) -> io::Result<Option<usize>> {
        self.link.receive(buffer)
    }

    fn idle(&mut self) {
        self.timed(Link::idle);
    }

    fn rest_until(&mut self, _time: u64) {}

    fn begin_cycle(&mut self, period: u64) {
        self.timed(|link| link.begin_cycle(period));
    }
}

/// A bus that remembers how long an exchange took beside its link.
struct Measured<B> {
    bus: B,
    /// Of the cycle that is running, ns.
    last: u128,
    coding: Vec<u128>,
}

impl Measured<EthercatBus<'_, Timed>> {
    fn timed<T>(&mut self, run: impl FnOnce(&mut EthercatBus<'_, Timed>) -> T) -> T {
        self.bus.link_mut().behind = Duration::ZERO;
        let begin = Instant::now();
        let result = run(&mut self.bus);
        let all = begin.elapsed();
        self.last += all.saturating_sub(self.bus.link().behind).as_nanos();
        result
    }
}

impl Plant for Measured<EthercatBus<'_, Timed>> {
    fn read(&mut self, feedback: &mut Feedback) -> Exchange {
        self.timed(|bus| bus.read(feedback))
    }

    fn write(&mut self, commands: &[DriveCommand]) {
        self.timed(|bus| bus.write(commands));
        self.coding.push(core::mem::take(&mut self.last));
    }
}

fn measure(name: &str) {
    let setup = Setup::new(machine(name), 1, &[]);
    let storage = FrameStorage::new();
    let link = Timed { link: setup.link(), behind: Duration::ZERO };
    let matched = Master::new(&storage, link).unwrap().match_devices(&setup.devices).unwrap();
    let bus = Measured { bus: matched.operate(&setup.machine).unwrap(), last: 0, coding: Vec::new() };
    let mut cycle = Cycle::new(bus, setup.supervisor(), setup.schedule(), common::STEP);
    let (mut clock, mut control) = (MonotonicClock, Vec::new());
    while !cycle.is_finished() {
        let times = cycle.step(&mut clock, u64::MAX).unwrap().times;
        control.push(u128::from(times.controlled - times.read));
    }
    let mut coding = cycle.end().coding;
    let [coding, control] = [&mut coding, &mut control].map(|times| {
        times.sort_unstable();
        [5000, 9900].map(|part| times[times.len() * part / 10_000] as f64 / 1000.0)
    });
    let drives = setup.machine.muscles.len();
    println!(
        "{name:<16} {drives:>4} {:>10.1} {:>9.1} {:>9.1} {:>9.1}",
        coding[0], coding[1], control[0], control[1]
    );
}
