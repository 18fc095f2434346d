//! What the operating system refused to the control cycle.

use sinew_runtime::cycle::RealTime;

/// Warns of each, with its remedy.
pub(super) fn warn(real_time: &RealTime) {
    for shortcoming in &real_time.shortcomings {
        eprintln!("warning: {shortcoming}");
    }
}
