//! Per-link intermediate results of the dynamics algorithms, in the link's own frame.

use super::vector::{Frame, Vector};

/// Pose and velocity of one link: pose in its parent's frame, velocities in its own.
#[derive(Debug, Clone, Copy, PartialEq, Default)]
pub(super) struct LinkState {
    pub(super) axes: Frame,
    pub(super) origin: Vector,
    /// Angular velocity.
    pub(super) omega: Vector,
    /// Velocity of the origin.
    pub(super) velocity: Vector,
}

/// Motion of a link: a point at `r` has the acceleration `a + U r` relative to free fall.
#[derive(Debug, Clone, Copy, PartialEq, Default)]
pub(super) struct LinkMotion {
    /// Angular velocity.
    pub(super) omega: Vector,
    /// Angular acceleration.
    pub(super) alpha: Vector,
    /// Acceleration of the origin.
    pub(super) a: Vector,
    /// `U = [alpha] + [omega]^2`, row by row.
    pub(super) field: Frame,
}

/// Moment about the origin and force on a link, in its frame.
#[derive(Debug, Clone, Copy, PartialEq, Default)]
pub(super) struct Wrench {
    pub(super) moment: Vector,
    pub(super) force: Vector,
}

/// Articulated-body inertia and bias wrench of a link and its subtree, at its origin: with angular
/// acceleration `alpha` and linear acceleration `a`, the moment is `angular alpha + coupling a + moment`, the
/// force `coupling^T alpha + linear a + force`.
#[derive(Debug, Clone, Copy, PartialEq, Default)]
pub(super) struct ArticulatedBody {
    pub(super) angular: Frame,
    pub(super) coupling: Frame,
    pub(super) linear: Frame,
    pub(super) moment: Vector,
    pub(super) force: Vector,
    /// Velocity-product acceleration, spatial: angular and linear.
    pub(super) drift: (Vector, Vector),
    pub(super) acceleration: (Vector, Vector),
}
