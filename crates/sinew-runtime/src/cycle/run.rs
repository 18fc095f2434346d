use super::timing::Timing;
use crate::Error;
use sinew_session::{Clock, CycleRecord, Motion, Plant, Session};
use std::sync::atomic::{AtomicBool, Ordering};

/// Runs cycles at absolute deadlines, a period of nanoseconds apart by the clocks of the devices, until the
/// session [is finished](Session::is_finished) or `end` is set, which ends them at once, and calls `see`
/// after every one.
///
/// A cycle that ends after the next deadline is late: the following one begins at once, and deadlines that
/// have passed are skipped, not made up for.
///
/// # Errors
/// As [`Clock::wait_until`] and [`Session::step`].
pub fn run<P: Plant>(
    session: &mut Session<P, impl Motion>,
    clock: &mut impl Clock,
    period: u64,
    end: &AtomicBool,
    timing: &mut Timing,
    mut see: impl FnMut(&CycleRecord<'_, P>) -> Result<(), Error>,
) -> Result<(), Error> {
    let mut deadline = clock.now() + period;
    while !session.is_finished() && !end.load(Ordering::Relaxed) {
        if !session.is_due() {
            continue;
        }
        clock.wait_until(deadline).map_err(Error::Clock)?;
        let record = session.step(clock, deadline)?;
        timing.record(deadline, &record.times);
        see(&record)?;
        deadline += period.saturating_add_signed(record.plant.period_correction());
        let now = clock.now();
        if now > deadline + period {
            let skipped = (now - deadline) / period;
            timing.skip(skipped);
            deadline += skipped * period;
        }
    }
    Ok(())
}
