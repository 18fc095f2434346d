use alloc::vec;
use alloc::vec::Vec;

/// Reference of the joints at a time: `[joints]` each.
#[derive(Debug, Clone, PartialEq)]
pub struct Reference {
    /// Pose, rad or m.
    pub q: Vec<f64>,
    /// Velocity, per s.
    pub v: Vec<f64>,
    /// Acceleration, per s^2.
    pub a: Vec<f64>,
}

impl Reference {
    /// At rest at zero.
    #[must_use]
    pub fn new(joints: usize) -> Self {
        Self { q: vec![0.0; joints], v: vec![0.0; joints], a: vec![0.0; joints] }
    }
}
