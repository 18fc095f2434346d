//! A request to end that long runs answer themselves, so that a machine is not left without commands.

use std::sync::atomic::{AtomicBool, Ordering};

static REQUESTED: AtomicBool = AtomicBool::new(false);
static ANSWERED: AtomicBool = AtomicBool::new(false);

/// The flag that Ctrl-C sets from here on instead of ending the program.
pub(crate) fn answer() -> &'static AtomicBool {
    ANSWERED.store(true, Ordering::SeqCst);
    &REQUESTED
}

/// Called on Ctrl-C: whether a run ends by itself. The second time it does not.
pub(crate) fn is_answered() -> bool {
    ANSWERED.load(Ordering::SeqCst) && !REQUESTED.swap(true, Ordering::SeqCst)
}

/// Whether the end was requested.
pub(crate) fn is_requested() -> bool {
    REQUESTED.load(Ordering::SeqCst)
}
