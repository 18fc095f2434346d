use super::clock::Clock;
use super::one::{Cycle, CycleRecord};
use super::timing::Timing;
use crate::Error;
use crate::bus::Bus;
use std::sync::atomic::{AtomicBool, Ordering};

/// Runs cycles at absolute deadlines, a period of nanoseconds apart by the clocks of the devices, until the cycle [is
/// finished](Cycle::is_finished) or `end` is set, which ends them at once, and calls `see` after every one.
///
/// A cycle that ends after the next deadline is late: the following one begins at once, and deadlines that have passed
/// are skipped, not made up for.
///
/// # Errors
/// As [`Clock::wait_until`] and [`Cycle::step`].
pub fn run<B: Bus>(
    cycle: &mut Cycle<'_, B>,
    clock: &mut impl Clock,
    period: u64,
    end: &AtomicBool,
    timing: &mut Timing,
    mut see: impl FnMut(&CycleRecord<'_, B>) -> Result<(), Error>,
) -> Result<(), Error> {
    let mut deadline = clock.now() + period;
    while !cycle.is_finished() && !end.load(Ordering::Relaxed) {
        if !cycle.is_due() {
            continue;
        }
        clock.wait_until(deadline)?;
        let record = cycle.step(clock, deadline)?;
        timing.record(deadline, &record.times);
        see(&record)?;
        deadline += period.saturating_add_signed(record.bus.period_correction());
        let now = clock.now();
        if now > deadline + period {
            let skipped = (now - deadline) / period;
            timing.skip(skipped);
            deadline += skipped * period;
        }
    }
    Ok(())
}
