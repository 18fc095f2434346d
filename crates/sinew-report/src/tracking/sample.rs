//! A row of a run, for tests.

use sinew_lab::arm::TraceRow;
use sinew_lab::signals::{Frame, FrameLayout, Signal};
use std::sync::Arc;

/// A row of a run of one joint and one muscle whose reference is this function of time.
pub(crate) fn row(time_s: f64, of: impl Fn(f64) -> f64) -> TraceRow {
    let value = of(time_s);
    let mut frame = Frame::new(Arc::new(FrameLayout::new([1, 1], true)));
    for (signal, number) in [
        (Signal::JointReference, value),
        (Signal::JointTrue, value + 1e-3),
        (Signal::JointEstimated, value),
        (Signal::TensionOutDesired, 20.0),
        (Signal::TensionOutEstimated, 20.0),
        (Signal::TensionOut, 20.5),
        (Signal::TensionInTrue, 31.0),
    ] {
        frame.of_mut(signal).fill(number);
    }
    TraceRow {
        time_s,
        repeat: (time_s >= 1.0).then_some(0),
        status: "following".to_owned(),
        end_point_reference_m: [value, 0.0, 0.1 * time_s],
        end_point_m: [value + 1e-3, 1e-4, 0.1 * time_s],
        length_m: vec![value],
        length_error_m: vec![1e-4],
        frame,
    }
}
