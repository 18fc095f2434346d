//! Cost of the control cycle over EtherCAT: the controller, and the master's coding of the process data beside it.
//!
//! The time of the simulated devices and of the twin behind them is measured apart and left out.

#![allow(clippy::unwrap_used, reason = "a bench that cannot start may panic")]
#![allow(clippy::print_stdout, reason = "a bench prints")]
#![allow(dead_code, reason = "the machines are those of the tests")]

#[path = "../tests/runtime/common.rs"]
mod common;

use common::{PERIOD, Setup, machine};
use sinew_runtime::bus::{Bus, Exchange, Feedback};
use sinew_runtime::cycle::Cycle;
use sinew_runtime::ethercat::{FrameStorage, Link, Master, SegmentLink};
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
    coding: Vec<u128>,
}

impl Bus for Measured<sinew_runtime::ethercat::EthercatBus<'_, Timed>> {
    fn exchange(&mut self, commands: &[sinew::drive::DriveCommand], feedback: &mut Feedback) -> Exchange {
        self.bus.link_mut().behind = Duration::ZERO;
        let begin = Instant::now();
        let exchange = self.bus.exchange(commands, feedback);
        let all = begin.elapsed();
        self.coding.push(all.saturating_sub(self.bus.link().behind).as_nanos());
        exchange
    }
}

fn measure(name: &str) {
    let setup = Setup::new(machine(name), 1, &[]);
    let storage = FrameStorage::new();
    let link = Timed { link: setup.link(), behind: Duration::ZERO };
    let matched = Master::new(&storage, link).unwrap().match_devices(&setup.machine.devices).unwrap();
    let bus = Measured { bus: matched.operate(&setup.machine, PERIOD).unwrap(), coding: Vec::new() };
    let mut cycle = Cycle::new(bus, setup.supervisor(), setup.schedule(), common::STEP);
    let mut control = Vec::new();
    while !cycle.is_finished() {
        let exchange = cycle.exchange();
        let begin = Instant::now();
        cycle.control(exchange).unwrap();
        control.push(begin.elapsed().as_nanos());
    }
    let mut coding = cycle.into_bus().coding;
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
