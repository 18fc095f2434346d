//! Ctrl-C in long runs: they end by themselves when it is pressed, so that no machine is left without commands.

use std::sync::atomic::{AtomicBool, Ordering};

static REQUESTED: AtomicBool = AtomicBool::new(false);
static ANSWERED: AtomicBool = AtomicBool::new(false);

/// From here on the first Ctrl-C sets the returned flag instead of ending the program; the caller ends when it is set.
pub(crate) fn answer() -> &'static AtomicBool {
    ANSWERED.store(true, Ordering::SeqCst);
    &REQUESTED
}

/// Called on Ctrl-C: requests the end where a run answers it. False where none does, and from the second time on: the
/// program is then ended at once.
pub(crate) fn is_answered() -> bool {
    ANSWERED.load(Ordering::SeqCst) && !REQUESTED.swap(true, Ordering::SeqCst)
}

/// Whether the end was requested.
pub(crate) fn is_requested() -> bool {
    REQUESTED.load(Ordering::SeqCst)
}
