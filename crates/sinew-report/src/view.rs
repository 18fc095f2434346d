//! Initial vertical ranges of a trace, before the reader zooms.

use super::record::Record;
use super::scale::{padded, robust_range, robust_reach};

/// Range of the far signal where it is scored: the signal itself, widened by the band up to 30 % of the
/// signal's range.
pub(super) fn far_view(record: &Record) -> (f64, f64) {
    let scaling = record.scaling();
    let signal = robust_range(scaling.iter().flat_map(|&i| [record.far[i], record.predicted[i]]));
    let band =
        scaling.iter().flat_map(|&i| [-1.0, 1.0].map(|s| record.predicted[i] + s * record.half_width[i]));
    let (low, high) = robust_range(band);
    let most = padded(signal, 0.3);
    padded((signal.0.min(low.max(most.0)), signal.1.max(high.min(most.1))), 0.04)
}

/// Range of the prediction error, symmetric around zero.
pub(super) fn error_view(record: &Record) -> (f64, f64) {
    let reach = 1.05 * robust_reach((0..record.len()).map(|i| record.scored_error(i)));
    (-reach, reach)
}
