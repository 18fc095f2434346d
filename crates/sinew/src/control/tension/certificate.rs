//! Proofs, in `f64`, that a group's solution is what its status says.

use super::rows::{Block, Rows, relative_residual};
use super::settings::Settings;
use super::solution::Status;

/// The status of tensions whose residual is given, with the magnitudes of its terms.
///
/// ```text
/// reached:     |tau_j - R_j^T F| <= tol (|tau_j| + sum_i |R_ij F_i|)
/// infeasible:  tau^T d > h(d) = sum_i max(R_i d F_min,i, R_i d F_max,i)  for some direction d
/// closest:     every F within the limits leaves |tau - R^T F| >= (tau^T d - h(d)) / |d|
/// ```
///
/// With the residual as the direction `d`, the last bound equals the residual's length at the closest torque.
/// Tensions of the form `clip(F_ref + W^-1 R lambda)` cost least for the torque that they give (weak
/// duality).
///
/// # Source
/// Farkas' lemma for bounded variables: `boyd2004`, section 5.8.
pub(super) fn certify<R: Rows>(
    block: &Block<R, f64>,
    residual: &[f64],
    scale: &[f64],
    settings: &Settings,
) -> Status {
    let n = block.joints();
    let (residual, scale) = (&residual[..n], &scale[..n]);
    if relative_residual(residual, scale) <= settings.feasibility {
        return Status::Optimal;
    }
    let length = libm::sqrt(residual.iter().map(|r| r * r).sum());
    let mut bound: f64 = block.torque.iter().zip(residual).map(|(torque, r)| torque * r).sum();
    let mut terms: f64 = block.torque.iter().zip(residual).map(|(torque, r)| (torque * r).abs()).sum();
    for (i, (lower, upper)) in block.lower.iter().zip(block.upper).enumerate() {
        let pull = block.rows.dot(i, residual);
        let most = (pull * lower).max(pull * upper);
        bound -= most;
        terms += most.abs();
    }
    let rounding = settings.residual * terms;
    let closest = length * length - bound <= settings.gap * length * length + rounding;
    if bound > rounding && closest { Status::Infeasible } else { Status::NotConverged }
}
