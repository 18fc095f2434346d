//! Ctrl-C in long runs, and what means the same, a request to terminate and a closed terminal: they end by
//! themselves, so that no machine is left without commands.

use std::sync::atomic::{AtomicBool, AtomicU8, Ordering};
use std::sync::{Arc, LazyLock};

/// How many are answered before one ends the program.
static ANSWERED: AtomicU8 = AtomicU8::new(0);
static COUNT: AtomicU8 = AtomicU8::new(0);
static FIRST: LazyLock<Arc<AtomicBool>> = LazyLock::new(Arc::default);
static SECOND: AtomicBool = AtomicBool::new(false);

/// From here on the first Ctrl-C sets the returned flag instead of ending the program; the caller ends when
/// it is set.
pub(crate) fn answer() -> &'static AtomicBool {
    ANSWERED.fetch_max(1, Ordering::SeqCst);
    &FIRST
}

/// From here on the first Ctrl-C sets the one flag, which asks a machine for its safe stop, and the second
/// the other, at which the run ends at once.
pub(crate) fn answer_twice() -> (Arc<AtomicBool>, &'static AtomicBool) {
    ANSWERED.fetch_max(2, Ordering::SeqCst);
    (Arc::clone(&FIRST), &SECOND)
}

/// Called on Ctrl-C: requests the end where a run answers it. False where none does, and from the first time
/// on that none does: the program is then ended at once.
pub(crate) fn is_answered() -> bool {
    let before = COUNT.load(Ordering::SeqCst);
    if before >= ANSWERED.load(Ordering::SeqCst) {
        return false;
    }
    COUNT.store(before + 1, Ordering::SeqCst);
    let flag: &AtomicBool = if before == 0 { &FIRST } else { &SECOND };
    flag.store(true, Ordering::SeqCst);
    true
}

/// Whether the end was requested.
pub(crate) fn is_requested() -> bool {
    FIRST.load(Ordering::SeqCst)
}

/// Whether it was requested at once, by a second Ctrl-C.
pub(crate) fn is_requested_at_once() -> bool {
    COUNT.load(Ordering::SeqCst) > 1
}
