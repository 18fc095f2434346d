//! A row of a run, for tests.

use sinew_lab::arm::{CycleSignals, TraceRow};

/// A row of a run of one joint and one muscle whose reference is this function of time.
pub(crate) fn row(time_s: f64, of: impl Fn(f64) -> f64) -> TraceRow {
    let value = of(time_s);
    let cycle = CycleSignals {
        status: "following".to_owned(),
        joint_reference: vec![value],
        joint_true: vec![value + 1e-3],
        joint_read: vec![value],
        joint_believed: vec![value],
        winch_read_m: vec![0.0],
        winch_command_m_per_s: vec![0.0],
        load_cell_n: vec![20.0],
        anchor_believed_n: vec![20.0],
    };
    TraceRow {
        time_s,
        repeat: (time_s >= 1.0).then_some(0),
        wanted_m: [value, 0.0, 0.1 * time_s],
        end_point_m: [value + 1e-3, 1e-4, 0.1 * time_s],
        length_m: vec![value],
        length_error_m: vec![1e-4],
        wanted_n: vec![20.0],
        anchor_n: vec![20.5],
        drive_n: vec![31.0],
        cycle,
    }
}
