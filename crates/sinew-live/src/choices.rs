//! What a page can choose from.

/// Names of paths and compensations, and the limits that are drawn.
#[derive(Debug, Clone, Default)]
pub struct Choices {
    /// Names of paths.
    pub paths: Vec<String>,
    /// Names of compensations.
    pub variants: Vec<String>,
    /// Smallest and largest tension at every anchor, N: `[muscles]`.
    pub tension_limits: Vec<[f64; 2]>,
    /// Failures that a muscle can be given, as
    /// [`SimulationSource::failure`](crate::SimulationSource::failure) reads them, with what they are; `{}`
    /// is its name.
    pub failures: Vec<(&'static str, &'static str)>,
}
