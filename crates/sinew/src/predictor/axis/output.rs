//! What an axis predicts.

/// What an axis predicts at one sample, far unit.
#[derive(Debug, Clone, Copy, PartialEq, Default)]
pub(in super::super) struct AxisOutput {
    pub(in super::super) value: f64,
    /// Half the width of the band in which the far side lies while `known` is false.
    pub(in super::super) half_width: f64,
    /// Whether the state no longer depends on its start.
    pub(in super::super) known: bool,
}
