//! The numbers of `results.json`.

use crate::CompensationVariant;
use serde::Serialize;
use std::collections::BTreeMap;

/// Active and passive muscle.
#[derive(Debug, Clone, Serialize)]
pub struct Sides<T> {
    /// The motor of the muscle pulls the cable in.
    pub active: T,
    /// The load pulls the cable out.
    pub passive: T,
}

impl<T> Sides<T> {
    pub(super) fn new(mut make: impl FnMut(usize) -> T) -> Self {
        Self { active: make(0), passive: make(1) }
    }
}

/// A part of Table I: one number per speed.
#[derive(Debug, Clone, Serialize)]
pub struct Indices {
    /// Eq. 14.
    pub mse_n2: [f64; 6],
    /// Eq. 15.
    pub rmse_n: [f64; 6],
    /// Eq. 16.
    pub pearson: [f64; 6],
    /// Mean recovery time after a reversal, until the far tension stays within 5 N, s; over whole cycles
    /// only.
    #[serde(skip_serializing_if = "Option::is_none")]
    pub recovery_s: Option<[f64; 6]>,
}

/// Table II.
#[derive(Debug, Clone, Serialize)]
pub struct Efficiency {
    /// Means of `T_out/T_in`.
    pub efficiency: [f64; 6],
    /// Their standard deviations.
    pub std: [f64; 6],
}

/// Table III, 1e-3 m/(N m).
#[derive(Debug, Clone, Serialize)]
pub struct Stretching {
    /// Means.
    pub mean: [f64; 6],
    /// Standard deviations.
    pub std: [f64; 6],
}

/// Table I of several compensation variants.
pub type ByVariant = BTreeMap<CompensationVariant, Sides<Indices>>;

/// Errors of the predicted elongation, root mean square over whole cycles, mm.
#[derive(Debug, Clone, Serialize)]
pub struct ElongationMillimetres {
    /// From signals of the motor side alone, by method.
    pub near_only: BTreeMap<&'static str, f64>,
    /// With the joint sensor.
    pub joint_sensor: BTreeMap<&'static str, f64>,
    /// Range of the true elongation, mm.
    pub range: f64,
}

/// Another specimen after its own calibration.
#[derive(Debug, Clone, Serialize)]
pub struct OtherSpecimen {
    /// Seed of the specimen.
    pub seed: u64,
    /// (a) with the observer.
    pub table1: Sides<Indices>,
    /// (b) with the observer.
    pub table1_estimate: Sides<Indices>,
    /// (c) with the observer.
    pub table1_cycles: Sides<Indices>,
    /// (c) with the true state of the cable.
    pub perfect_cycles: Sides<Indices>,
}

/// Table I of the observer where no encoder stands at the joint: the reference of the motion takes its place.
#[derive(Debug, Clone, Serialize)]
pub struct WithoutJointEncoder {
    /// (a) Achieved in steady windows.
    pub table1: Sides<Indices>,
    /// (b) Estimated over whole cycles.
    pub table1_estimate: Sides<Indices>,
    /// (c) Achieved over whole cycles.
    pub table1_cycles: Sides<Indices>,
    /// Largest difference between the far end's reference and its true displacement, m.
    pub largest_anchor_error_m: f64,
}

/// The bench in `results.json`.
#[derive(Debug, Clone, Serialize)]
pub struct BenchResults {
    /// Always true.
    pub simulated: bool,
    /// Seed of all random numbers.
    pub seed: u64,
    /// (a) Achieved in steady windows.
    pub table1: ByVariant,
    /// (b) Estimated over whole cycles.
    pub table1_estimate: ByVariant,
    /// (c) Achieved over whole cycles.
    pub table1_cycles: ByVariant,
    /// The observer without the joint's encoder.
    pub without_joint_encoder: WithoutJointEncoder,
    /// Table II.
    pub table2: Sides<Efficiency>,
    /// Table III.
    pub table3: Sides<Stretching>,
    /// Equations 10 and 18.
    pub elongation_mm: ElongationMillimetres,
    /// Mean difference between the tensions of both ends without compensation; the pulling end is held to 40
    /// to 200 N.
    pub uncompensated_mean_error_n: Sides<f64>,
    /// Other specimens, each with its own calibration; none in a quick run.
    pub other_specimens: Vec<OtherSpecimen>,
}
