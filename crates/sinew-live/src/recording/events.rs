//! Events of a recording: modes, faults, repeats.

use crate::scene::Event;
use sinew::control::arm::ArmStatus;
use sinew_record::{Block, ColumnSpec, Head, fault_of, status_of};

/// Events that are listed; a recording may hold a loss of frames in every cycle.
const MOST: usize = 400;

/// Collects the events of consecutive blocks.
pub(super) struct EventList<'a> {
    head: &'a Head,
    columns: [Option<usize>; 6],
    before: [f64; 6],
    events: Vec<Event>,
    unlisted: u64,
    dropped: u64,
    end: u64,
}

/// Columns whose changes are events.
const COLUMNS: [&str; 6] = ["repeat", "status", "fault", "mode", "mode_fault", "bus_fault"];

impl<'a> EventList<'a> {
    pub(super) fn new(head: &'a Head) -> Self {
        let place = |name: &str| head.fast.iter().position(|column: &ColumnSpec| column.name == name);
        Self {
            head,
            columns: COLUMNS.map(place),
            before: [f64::NAN, 0.0, 0.0, f64::NAN, 0.0, 0.0],
            events: Vec::new(),
            unlisted: 0,
            dropped: 0,
            end: 0,
        }
    }

    pub(super) fn add(&mut self, block: &Block) {
        if block.first > self.end {
            let text = format!("{} cycles are missing", block.first - self.end);
            self.put(self.end, "fault", text);
        }
        (self.dropped, self.end) = (block.dropped, block.first + block.count as u64);
        for row in 0..block.count {
            let now = self.columns.map(|column| {
                column.and_then(|column| block.fast.get(column)?.get(row)).copied().unwrap_or(f64::NAN)
            });
            // Bits, so that NaN equals itself.
            if now.map(f64::to_bits) != self.before.map(f64::to_bits) {
                self.compare(block.first + row as u64, now);
                self.before = now;
            }
        }
    }

    fn compare(&mut self, cycle: u64, now: [f64; 6]) {
        let changed = |k: usize| now[k].to_bits() != self.before[k].to_bits();
        let [repeat, status, fault, mode, mode_fault, bus_fault] = now;
        let before_bus = self.before[5];
        let (new_repeat, new_mode) = (changed(0) && repeat >= 0.0, changed(3) || changed(4));
        let new_status = changed(1) || changed(2);
        if new_repeat {
            self.put(cycle, "repeat", format!("repeat {}", repeat as u64 + 1));
        }
        if new_mode {
            let kind = if fault_of(mode_fault).is_some() { "fault" } else { "state" };
            let text = self.head.mode_name(mode, mode_fault, status_of(status, fault));
            self.put(cycle, kind, text);
        } else if new_status {
            let found = status_of(status, fault);
            let kind = match found {
                ArmStatus::Degraded(_) | ArmStatus::Stopped(_) => "fault",
                ArmStatus::Following | ArmStatus::Holding => "state",
            };
            self.put(cycle, kind, self.head.status_name(found));
        }
        if bus_fault > 0.0 && before_bus <= 0.0 {
            self.put(cycle, "fault", "no complete exchange on the bus".to_owned());
        }
    }

    fn put(&mut self, cycle: u64, kind: &'static str, text: String) {
        if self.events.len() < MOST {
            self.events.push(Event { time: cycle as f64 * self.head.period_s(), kind, text });
        } else {
            self.unlisted += 1;
        }
    }

    /// Cycles that the writer had no room for.
    pub(super) fn missing(&self) -> u64 {
        self.dropped
    }

    /// The events.
    pub(super) fn finish(mut self) -> Vec<Event> {
        if let Some(last) = self.events.last_mut().filter(|_| self.unlisted > 0) {
            last.text += &format!(" (and {} further events, which are not listed)", self.unlisted);
        }
        self.events
    }
}
