//! Normal equations over all samples, in parallel, bit-identical for any number of threads.
//!
//! With `s_j = v_j (1 - h_j^2)` and `x` extended by a one, a row of the Jacobian is
//! `[x_0 s, x_1 s, .., s, h, 1]`. Its outer product has far fewer different entries than squares:
//!
//! ```text
//! d/dW_ji d/dW_ql:  sum (x_i x_l) (s_j s_q)      one sum for each unordered {i, l} and {j, q}
//! the rest:         sum (row) (h, 1)             a narrow product
//! gradient:         sum (e x_i) (s), sum (e) (h, 1)
//! ```
//!
//! That is 0.75 of the multiplications of a triangle of `J^T J`, and `J` is never stored. The products
//! `s_j s_q` of all pairs are formed as `s` times itself rotated by `d = 0 ..= hidden / 2`, so that vectors
//! run over nodes and are always full.
//!
//! Nodes, residuals and gradient are f64. The sums of products are f64 too, or f32 within a few hundred
//! samples and f64 beyond: the rounding errors of different samples are independent and average out.

use super::network::{Net, SquaredError};
use crate::fit::linear_algebra::Matrix;
use crate::fit::linearisation::Linearisation;
use crate::fit::simd::{Real, load, padded, store};
use crate::fit::tiles::{BLOCK, View, add_pairs, add_product};
use pulp::{Arch, Simd, WithSimd};
use rayon::prelude::*;
use std::marker::PhantomData;

/// Samples of one chunk. Chunks do not depend on the number of threads and are summed in order.
const CHUNK: usize = 8192;

/// Chunks summed up at a time: bounds memory, does not change the sum.
const WAVE: usize = 64;

/// Normal equations of the network over `samples`, rows of `[inputs, target]`; products are summed in `R`.
pub(super) fn normal_equations<R: Real>(net: &Net, samples: &[f64]) -> Linearisation {
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
    Linearisation {
        normal: Matrix::from_fn(p, entry),
        gradient: (0..p).map(|row| sums.gradient(net, row)).collect(),
        squares: sums.squared_error,
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

/// Blocks after which sums of [`Real`] are added to those in f64.
const FLUSH: usize = 8;

/// Rows of a gradient tile.
const GRADIENT: usize = 5;

/// The sums over one chunk of samples.
#[derive(Debug, Clone, Default)]
pub(super) struct Sums {
    pub(super) squared_error: f64,
    error: f64,
    /// `[hidden / 2 + 1][monomials][pair_width]`: rotation, pair of inputs, node.
    pairs: Vec<f64>,
    monomials: usize,
    pair_width: usize,
    /// `[parameters][narrow_width]`: every column of the Jacobian against `h, 1`.
    narrow: Vec<f64>,
    narrow_width: usize,
    /// `[inputs + 1][wide]`
    first_gradient: Vec<f64>,
    /// `[wide]`
    second_gradient: Vec<f64>,
}

impl Sums {
    pub(super) fn add(&mut self, other: &Self) {
        if self.pairs.is_empty() {
            self.clone_from(other);
            return;
        }
        self.squared_error += other.squared_error;
        self.error += other.error;
        for (sum, other) in [
            (&mut self.pairs, &other.pairs),
            (&mut self.narrow, &other.narrow),
            (&mut self.first_gradient, &other.first_gradient),
            (&mut self.second_gradient, &other.second_gradient),
        ] {
            for (a, b) in sum.iter_mut().zip(other) {
                *a += b;
            }
        }
    }

    /// Entry `(row, column)` of `J^T J`, `row >= column`.
    pub(super) fn normal(&self, net: &Net, row: usize, column: usize) -> f64 {
        let hidden = net.hidden;
        let first = (net.inputs + 1) * hidden;
        if row >= first {
            return self.narrow[column * self.narrow_width + row - first];
        }
        let (l, q) = (row / hidden, row % hidden);
        let (i, j) = (column / hidden, column % hidden);
        let monomial = monomial(net.inputs + 1, i.min(l), i.max(l));
        let forward = (q + hidden - j) % hidden;
        let (node, rotation) = if forward <= hidden / 2 { (j, forward) } else { (q, hidden - forward) };
        self.pairs[(rotation * self.monomials + monomial) * self.pair_width + node]
    }

    /// Entry of `J^T e`.
    pub(super) fn gradient(&self, net: &Net, row: usize) -> f64 {
        let (block, node) = (row / net.hidden, row % net.hidden);
        match block {
            _ if block <= net.inputs => self.first_gradient[block * net.wide + node],
            _ if block == net.inputs + 1 => self.second_gradient[node],
            _ => self.error,
        }
    }
}

/// Index of `x_i x_l`, `i <= l < n`, in a row of monomials.
fn monomial(n: usize, i: usize, l: usize) -> usize {
    i * n - i * i.saturating_sub(1) / 2 + l - i
}

/// [`Sums`] of `net` over `samples`, rows of `[inputs, target]`; products are summed in `R`.
pub(super) struct Normal<'a, R> {
    pub(super) net: &'a Net,
    pub(super) samples: &'a [f64],
    pub(super) products: PhantomData<R>,
}

impl<R: Real> WithSimd for Normal<'_, R> {
    type Output = Sums;

    #[inline(always)]
    fn with_simd<S: Simd>(self, simd: S) -> Sums {
        // Tiles of accumulators that fit the registers of the machine, with room for their operands.
        if S::REGISTER_COUNT >= 32 {
            normal::<S, R, 8, 14>(simd, self.net, self.samples)
        } else {
            normal::<S, R, 5, 6>(simd, self.net, self.samples)
        }
    }
}

#[inline(always)]
fn normal<S: Simd, R: Real, const PAIRS: usize, const NARROW: usize>(
    simd: S,
    net: &Net,
    samples: &[f64],
) -> Sums {
    let mut rows = BlockRows::<R>::new(net, PAIRS, NARROW);
    let mut sums = rows.sums(net);
    let (mut pairs, mut narrow) = (vec![R::ZERO; sums.pairs.len()], vec![R::ZERO; sums.narrow.len()]);
    for (at, block) in samples.chunks(BLOCK * (net.inputs + 1)).enumerate() {
        let count = block.len() / (net.inputs + 1);
        net.forward(simd, block, &mut rows.nodes, &mut rows.residuals);
        rows.fill(simd, net, block);
        let slopes = View { rows: &rows.rotating, width: rows.rotating_width, count };
        for (rotation, out) in pairs.chunks_exact_mut(sums.monomials * sums.pair_width).enumerate() {
            add_pairs::<S, R, PAIRS>(simd, &rows.monomials, slopes, rotation, out, sums.pair_width);
        }
        let jacobian = View { rows: &rows.jacobian, width: rows.jacobian_width, count };
        let right = View { rows: &rows.right, width: sums.narrow_width, count };
        add_product::<S, R, NARROW>(simd, jacobian, right, &mut narrow);
        rows.gradient(simd, net, count, &mut sums);
        if (at + 1).is_multiple_of(FLUSH) {
            flush(&mut pairs, &mut sums.pairs);
            flush(&mut narrow, &mut sums.narrow);
        }
    }
    flush(&mut pairs, &mut sums.pairs);
    flush(&mut narrow, &mut sums.narrow);
    sums
}

/// Adds sums to those in f64 and clears them.
#[inline(always)]
fn flush<R: Real>(from: &mut [R], to: &mut [f64]) {
    for (from, to) in from.iter_mut().zip(to) {
        *to += from.to_f64();
        *from = R::ZERO;
    }
}

/// The factors of all products for one block of samples, one row per sample.
struct BlockRows<R> {
    /// `h` and `s`, `[BLOCK x wide]`.
    nodes: Vec<f64>,
    slopes: Vec<f64>,
    residuals: [f64; BLOCK],
    /// Inputs of one sample and a one.
    extended: Vec<f64>,
    /// `e x_i`.
    weighted: Vec<f64>,
    /// `s` and the first half of it again: reading from `d` on gives it rotated by `d`.
    rotating: Vec<R>,
    rotating_width: usize,
    /// `x_i x_l`, in panels of `tall`: `[panel][BLOCK][tall]`.
    monomials: Vec<R>,
    tall: usize,
    /// `h, 1`.
    right: Vec<R>,
    right_width: usize,
    /// The row of the Jacobian.
    jacobian: Vec<R>,
    jacobian_width: usize,
    narrow_rows: usize,
}

impl<R: Real> BlockRows<R> {
    fn new(net: &Net, tall: usize, narrow: usize) -> Self {
        let pair_width = padded(net.hidden, R::WIDEST);
        let rotating_width = padded(pair_width + net.hidden / 2, R::WIDEST);
        let right_width = padded(net.hidden + 1, R::WIDEST);
        let narrow_rows = padded(Net::parameters(net.inputs, net.hidden), narrow);
        let jacobian_width = narrow_rows + R::WIDEST;
        Self {
            nodes: vec![0.0; BLOCK * net.wide],
            slopes: vec![0.0; BLOCK * net.wide],
            residuals: [0.0; BLOCK],
            extended: vec![1.0; net.inputs + 1],
            weighted: vec![0.0; BLOCK * padded(net.inputs + 1, GRADIENT)],
            rotating: vec![R::ZERO; BLOCK * rotating_width],
            rotating_width,
            monomials: vec![R::ZERO; BLOCK * padded((net.inputs + 1) * (net.inputs + 2) / 2, tall)],
            tall,
            right: vec![R::ZERO; BLOCK * right_width],
            right_width,
            jacobian: vec![R::ZERO; BLOCK * jacobian_width],
            jacobian_width,
            narrow_rows,
        }
    }

    fn sums(&self, net: &Net) -> Sums {
        let monomials = self.monomials.len() / BLOCK;
        let pair_width = padded(net.hidden, R::WIDEST);
        Sums {
            squared_error: 0.0,
            error: 0.0,
            pairs: vec![0.0; (net.hidden / 2 + 1) * monomials * pair_width],
            monomials,
            pair_width,
            narrow: vec![0.0; self.narrow_rows * self.right_width],
            narrow_width: self.right_width,
            first_gradient: vec![0.0; self.weighted.len() / BLOCK * net.wide],
            second_gradient: vec![0.0; net.wide],
        }
    }

    /// Computes all factors from nodes and residuals.
    #[inline(always)]
    fn fill<S: Simd>(&mut self, simd: S, net: &Net, block: &[f64]) {
        let wide = net.wide;
        let weighted_width = self.weighted.len() / BLOCK;
        for (n, sample) in block.chunks_exact(net.inputs + 1).enumerate() {
            let nodes = &self.nodes[n * wide..][..wide];
            let slopes = &mut self.slopes[n * wide..][..wide];
            let rotating = &mut self.rotating[n * self.rotating_width..][..self.rotating_width];
            let right = &mut self.right[n * self.right_width..][..self.right_width];
            for ((s, h), v) in slopes.iter_mut().zip(nodes).zip(&net.second) {
                *s = v * (1.0 - h * h);
            }
            // Whole vectors are written; what runs over is overwritten by the next.
            for (out, s) in rotating.iter_mut().zip(&*slopes) {
                *out = R::from_f64(*s);
            }
            for (out, h) in right.iter_mut().zip(nodes) {
                *out = R::from_f64(*h);
            }
            for (out, s) in rotating[net.hidden..].iter_mut().zip(&*slopes) {
                *out = R::from_f64(*s);
            }
            self.extended[..net.inputs].copy_from_slice(&sample[..net.inputs]);
            let weighted = &mut self.weighted[n * weighted_width..][..weighted_width];
            let jacobian = &mut self.jacobian[n * self.jacobian_width..][..self.jacobian_width];
            let mut place = 0;
            for (i, x) in self.extended.iter().enumerate() {
                weighted[i] = x * self.residuals[n];
                for y in &self.extended[i..] {
                    self.monomials[(place / self.tall * BLOCK + n) * self.tall + place % self.tall] =
                        R::from_f64(x * y);
                    place += 1;
                }
                let x = R::splat(simd, R::from_f64(*x));
                for at in (0..net.hidden).step_by(R::width::<S>()) {
                    let [s] = load::<S, R, 1>(simd, rotating, at);
                    store::<S, R, 1>(jacobian, i * net.hidden + at, [R::mul(simd, x, s)]);
                }
            }
            let first = (net.inputs + 1) * net.hidden;
            for at in (0..net.hidden).step_by(R::width::<S>()) {
                store::<S, R, 1>(jacobian, first + at, load::<S, R, 1>(simd, right, at));
            }
            jacobian[first + net.hidden] = R::ONE;
            right[net.hidden] = R::ONE;
        }
    }

    /// Errors and gradient, in f64.
    #[inline(always)]
    fn gradient<S: Simd>(&self, simd: S, net: &Net, count: usize, sums: &mut Sums) {
        let residuals = &self.residuals[..count];
        sums.squared_error += residuals.iter().map(|e| e * e).sum::<f64>();
        sums.error += residuals.iter().sum::<f64>();
        let weighted = View { rows: &self.weighted, width: self.weighted.len() / BLOCK, count };
        let slopes = View { rows: &self.slopes, width: net.wide, count };
        add_product::<S, f64, GRADIENT>(simd, weighted, slopes, &mut sums.first_gradient);
        let errors = View { rows: residuals, width: 1, count };
        let nodes = View { rows: &self.nodes, width: net.wide, count };
        add_product::<S, f64, 1>(simd, errors, nodes, &mut sums.second_gradient);
    }
}
