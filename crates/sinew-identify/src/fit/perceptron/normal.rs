//! The normal equations over all samples, in parallel, the same to the bit for any number of threads.

use super::chunk::{Normal, Sums};
use super::network::{Net, SquaredError};
use super::simd::Real;
use faer::Mat;
use pulp::Arch;
use rayon::prelude::*;
use std::marker::PhantomData;

/// Samples of one chunk. Chunks do not depend on the number of threads and are summed in order.
const CHUNK: usize = 8192;

/// Chunks summed up at a time: bounds memory, does not change the sum.
const WAVE: usize = 64;

/// `J^T J`, `J^T e` and `e^T e` over all samples.
#[derive(Debug)]
pub(super) struct NormalEquations {
    /// Lower triangle.
    pub(super) matrix: Mat<f64>,
    pub(super) gradient: Vec<f64>,
    pub(super) squared_error: f64,
}

/// Normal equations of the network over `samples`, rows of `[inputs, target]`; products are summed in `R`.
pub(super) fn normal_equations<R: Real>(net: &Net, samples: &[f64]) -> NormalEquations {
    let arch = Arch::new();
    let mut sums = Sums::default();
    let row = net.inputs + 1;
    for wave in samples.chunks(WAVE * CHUNK * row) {
        let parts: Vec<Sums> = wave
            .par_chunks(CHUNK * row)
            .map(|samples| arch.dispatch(Normal::<R> { net, samples, products: PhantomData }))
            .collect();
        for part in &parts {
            sums.add(part);
        }
    }
    let p = Net::parameters(net.inputs, net.hidden);
    let entry = |row: usize, column: usize| if row < column { 0.0 } else { sums.normal(net, row, column) };
    NormalEquations {
        matrix: Mat::from_fn(p, p, entry),
        gradient: (0..p).map(|row| sums.gradient(net, row)).collect(),
        squared_error: sums.squared_error,
    }
}

/// Sum of squared residuals over `samples`.
pub(super) fn squared_error(net: &Net, samples: &[f64]) -> f64 {
    let arch = Arch::new();
    let parts: Vec<f64> = samples
        .par_chunks(CHUNK * (net.inputs + 1))
        .map(|samples| arch.dispatch(SquaredError { net, samples }))
        .collect();
    parts.iter().sum()
}
