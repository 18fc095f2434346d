//! What one thread does with one chunk of samples: residuals, and the sums the normal equations are made of.
//!
//! With `s_j = v_j (1 - h_j^2)` and `x` extended by a one, a row of the Jacobian is
//! `[x_0 s, x_1 s, .., s, h, 1]`. Its outer product has far fewer different entries than squares:
//!
//! ```text
//! d/dW_ji d/dW_ql:  sum (x_i x_l) (s_j s_q)      one sum for each unordered {i, l} and {j, q}
//! the rest:         sum (row) (h, 1, e)          a narrow product; its last column is the gradient
//! ```
//!
//! That is 0.75 of the multiplications of a triangle of `J^T J`, and `J` is never written out. The products
//! `s_j s_q` of all pairs are formed as `s` times itself rotated by `d = 0 ..= hidden / 2`, so that vectors
//! run over nodes and are always full.

use super::lanes::{WIDEST, load, padded, store, tanh};
use pulp::{Simd, WithSimd};

/// Samples whose rows lie in the first level cache together.
const BLOCK: usize = 64;

/// A network laid out for vectors over nodes; also the meaning of the parameter vector.
///
/// Parameters are `[W_00 .. W_0h, W_10 .. , b_0 .. b_h, v_0 .. v_h, c]`, input by input.
#[derive(Debug, Clone)]
pub(super) struct Net {
    pub(super) inputs: usize,
    pub(super) hidden: usize,
    wide: usize,
    first: Vec<f64>,
    second: Vec<f64>,
    bias: f64,
}

impl Net {
    pub(super) fn parameters(inputs: usize, hidden: usize) -> usize {
        (inputs + 2) * hidden + 1
    }

    pub(super) fn new(inputs: usize, hidden: usize, theta: &[f64]) -> Self {
        let wide = padded(hidden, WIDEST);
        let mut rows = theta.chunks_exact(hidden.max(1)).map(|row| {
            let mut row = row.to_vec();
            row.resize(wide, 0.0);
            row
        });
        let first = rows.by_ref().take(inputs + 1).flatten().collect();
        let second = rows.next().unwrap_or_default();
        let bias = theta.last().copied().unwrap_or_default();
        Self { inputs, hidden, wide, first, second, bias }
    }
}

/// The sums over one chunk, and how to read them.
#[derive(Debug, Clone, Default)]
pub(super) struct Sums {
    pub(super) squared_error: f64,
    /// `[hidden / 2 + 1][monomials][wide]`: rotation, pair of inputs, node.
    pairs: Vec<f64>,
    monomials: usize,
    /// `[parameters][wide]`: every column of the Jacobian against `h, 1, e`.
    narrow: Vec<f64>,
    narrow_width: usize,
}

impl Sums {
    pub(super) fn add(&mut self, other: &Self) {
        if self.pairs.is_empty() {
            self.clone_from(other);
            return;
        }
        self.squared_error += other.squared_error;
        for (a, b) in self.pairs.iter_mut().zip(&other.pairs) {
            *a += b;
        }
        for (a, b) in self.narrow.iter_mut().zip(&other.narrow) {
            *a += b;
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
        self.pairs[(rotation * self.monomials + monomial) * net.wide + node]
    }

    /// Entry of `J^T e`.
    pub(super) fn gradient(&self, net: &Net, row: usize) -> f64 {
        self.narrow[row * self.narrow_width + net.hidden + 1]
    }
}

/// Place of `x_i x_l`, `i <= l < n`, in a row of monomials.
fn monomial(n: usize, i: usize, l: usize) -> usize {
    i * n - i * i.saturating_sub(1) / 2 + l - i
}

/// Squared error of `net` over `samples`, rows of `[inputs, target]`.
pub(super) struct SquaredError<'a> {
    pub(super) net: &'a Net,
    pub(super) samples: &'a [f64],
}

impl WithSimd for SquaredError<'_> {
    type Output = f64;

    #[inline(always)]
    fn with_simd<S: Simd>(self, simd: S) -> f64 {
        let Self { net, samples } = self;
        let mut nodes = vec![0.0; BLOCK * net.wide];
        let mut residuals = [0.0; BLOCK];
        let mut sum = 0.0;
        for block in samples.chunks(BLOCK * (net.inputs + 1)) {
            let count = block.len() / (net.inputs + 1);
            forward(simd, net, block, &mut nodes, net.wide, &mut residuals);
            sum += residuals[..count].iter().map(|e| e * e).sum::<f64>();
        }
        sum
    }
}

/// [`Sums`] of `net` over `samples`, rows of `[inputs, target]`.
pub(super) struct Normal<'a> {
    pub(super) net: &'a Net,
    pub(super) samples: &'a [f64],
}

impl WithSimd for Normal<'_> {
    type Output = Sums;

    #[inline(always)]
    fn with_simd<S: Simd>(self, simd: S) -> Sums {
        // Tiles of accumulators that fit the registers of the machine, with room for their operands.
        if S::REGISTER_COUNT >= 32 {
            normal::<S, 8, 14>(simd, self.net, self.samples)
        } else {
            normal::<S, 5, 6>(simd, self.net, self.samples)
        }
    }
}

#[inline(always)]
fn normal<S: Simd, const PAIRS: usize, const NARROW: usize>(simd: S, net: &Net, samples: &[f64]) -> Sums {
    let mut rows = Rows::new(net, PAIRS, NARROW);
    let mut sums = Sums {
        squared_error: 0.0,
        pairs: vec![0.0; (net.hidden / 2 + 1) * rows.monomial_width * net.wide],
        monomials: rows.monomial_width,
        narrow: vec![0.0; rows.narrow_rows * rows.node_width],
        narrow_width: rows.node_width,
    };
    for block in samples.chunks(BLOCK * (net.inputs + 1)) {
        let count = block.len() / (net.inputs + 1);
        forward(simd, net, block, &mut rows.nodes, rows.node_width, &mut rows.residuals);
        sums.squared_error += rows.residuals[..count].iter().map(|e| e * e).sum::<f64>();
        rows.fill(simd, net, block);
        for (rotation, out) in sums.pairs.chunks_exact_mut(rows.monomial_width * net.wide).enumerate() {
            products_of_pairs::<S, PAIRS>(simd, &rows, count, rotation, out, net.wide);
        }
        let jacobian = View { rows: &rows.jacobian, width: rows.jacobian_width, count };
        let nodes = View { rows: &rows.nodes, width: rows.node_width, count };
        product::<S, NARROW>(simd, jacobian, nodes, &mut sums.narrow);
    }
    sums
}

/// One block of samples as the products want it, a row a sample.
struct Rows {
    /// `h, 1, e`.
    nodes: Vec<f64>,
    node_width: usize,
    /// `s` and the first half of it again: reading from `d` on gives it rotated by `d`.
    slopes: Vec<f64>,
    slope_width: usize,
    /// `x_i x_l`, in panels of `tall`: `[monomial_width / tall][BLOCK][tall]`.
    monomials: Vec<f64>,
    monomial_width: usize,
    tall: usize,
    /// Inputs of one sample and a one.
    extended: Vec<f64>,
    /// The row of the Jacobian.
    jacobian: Vec<f64>,
    jacobian_width: usize,
    narrow_rows: usize,
    residuals: [f64; BLOCK],
}

impl Rows {
    fn new(net: &Net, pairs: usize, narrow: usize) -> Self {
        let slope_width = padded(net.wide + net.hidden / 2, WIDEST);
        let node_width = padded(net.hidden + 2, WIDEST);
        let monomial_width = padded((net.inputs + 1) * (net.inputs + 2) / 2, pairs);
        let narrow_rows = padded(Net::parameters(net.inputs, net.hidden), narrow);
        let jacobian_width = narrow_rows + WIDEST;
        Self {
            nodes: vec![0.0; BLOCK * node_width],
            node_width,
            slopes: vec![0.0; BLOCK * slope_width],
            slope_width,
            monomials: vec![0.0; BLOCK * monomial_width],
            monomial_width,
            tall: pairs,
            extended: vec![1.0; net.inputs + 1],
            jacobian: vec![0.0; BLOCK * jacobian_width],
            jacobian_width,
            narrow_rows,
            residuals: [0.0; BLOCK],
        }
    }

    /// Everything but `h` and `e`, which [`forward`] has left.
    #[inline(always)]
    fn fill<S: Simd>(&mut self, simd: S, net: &Net, block: &[f64]) {
        for (n, sample) in block.chunks_exact(net.inputs + 1).enumerate() {
            self.extended[..net.inputs].copy_from_slice(&sample[..net.inputs]);
            let nodes = &mut self.nodes[n * self.node_width..][..self.node_width];
            let slopes = &mut self.slopes[n * self.slope_width..][..self.slope_width];
            slope_row(simd, net, nodes, slopes);
            let mut place = 0;
            for (i, x) in self.extended.iter().enumerate() {
                for y in &self.extended[i..] {
                    self.monomials[(place / self.tall * BLOCK + n) * self.tall + place % self.tall] = x * y;
                    place += 1;
                }
            }
            // Every part is written in whole vectors; what runs over is overwritten by the next.
            let jacobian = &mut self.jacobian[n * self.jacobian_width..][..self.jacobian_width];
            for (i, x) in self.extended.iter().enumerate() {
                let x = simd.splat_f64s(*x);
                for at in (0..net.wide).step_by(S::F64_LANES) {
                    let [s] = load::<S, 1>(simd, slopes, at);
                    store::<S, 1>(jacobian, i * net.hidden + at, [simd.mul_f64s(x, s)]);
                }
            }
            let first = (net.inputs + 1) * net.hidden;
            for at in (0..net.wide).step_by(S::F64_LANES) {
                store::<S, 1>(jacobian, first + at, load::<S, 1>(simd, nodes, at));
            }
            jacobian[first + net.hidden] = 1.0;
            nodes[net.hidden] = 1.0;
            nodes[net.hidden + 1] = self.residuals[n];
        }
    }
}

/// `s = v (1 - h^2)`, and as much of it as fits right behind itself, which is half of it at least.
#[inline(always)]
fn slope_row<S: Simd>(simd: S, net: &Net, nodes: &[f64], slopes: &mut [f64]) {
    for start in [0, net.hidden] {
        for at in (0..net.wide).step_by(S::F64_LANES) {
            let [h] = load::<S, 1>(simd, nodes, at);
            let [v] = load::<S, 1>(simd, &net.second, at);
            let one_less = simd.sub_f64s(simd.splat_f64s(1.0), simd.mul_f64s(h, h));
            store::<S, 1>(slopes, start + at, [simd.mul_f64s(v, one_less)]);
        }
    }
}

/// Hidden nodes into rows of `nodes`, outputs less targets into `residuals`.
#[inline(always)]
fn forward<S: Simd>(
    simd: S,
    net: &Net,
    block: &[f64],
    nodes: &mut [f64],
    node_width: usize,
    residuals: &mut [f64; BLOCK],
) {
    let wide_steps = net.wide / (4 * S::F64_LANES) * (4 * S::F64_LANES);
    let rows = block.chunks_exact(net.inputs + 1).zip(nodes.chunks_exact_mut(node_width)).zip(residuals);
    for ((sample, nodes), residual) in rows {
        let (inputs, target) = sample.split_at(net.inputs);
        let mut output = simd.splat_f64s(0.0);
        for at in (0..wide_steps).step_by(4 * S::F64_LANES) {
            output = activate::<S, 4>(simd, net, inputs, nodes, at, output);
        }
        for at in (wide_steps..net.wide).step_by(S::F64_LANES) {
            output = activate::<S, 1>(simd, net, inputs, nodes, at, output);
        }
        *residual = simd.reduce_sum_f64s(output) + net.bias - target.iter().sum::<f64>();
    }
}

#[inline(always)]
fn activate<S: Simd, const N: usize>(
    simd: S,
    net: &Net,
    inputs: &[f64],
    nodes: &mut [f64],
    at: usize,
    mut output: S::f64s,
) -> S::f64s {
    let mut sum = load::<S, N>(simd, &net.first, net.inputs * net.wide + at);
    for (x, weights) in inputs.iter().zip(net.first.chunks_exact(net.wide)) {
        let x = simd.splat_f64s(*x);
        let weights = load::<S, N>(simd, weights, at);
        for i in 0..N {
            sum[i] = simd.mul_add_e_f64s(x, weights[i], sum[i]);
        }
    }
    let h = tanh(simd, sum);
    store::<S, N>(nodes, at, h);
    let v = load::<S, N>(simd, &net.second, at);
    for i in 0..N {
        output = simd.mul_add_e_f64s(h[i], v[i], output);
    }
    output
}

/// `count` rows of `width`.
#[derive(Clone, Copy)]
struct View<'a> {
    rows: &'a [f64],
    width: usize,
    count: usize,
}

impl<'a> View<'a> {
    fn iter(self) -> impl Iterator<Item = &'a [f64]> {
        self.rows.chunks_exact(self.width).take(self.count)
    }
}

/// `out[m][lane] += sum over samples of monomial[m] s[lane] s[lane + rotation]`
#[inline(always)]
fn products_of_pairs<S: Simd, const TALL: usize>(
    simd: S,
    rows: &Rows,
    count: usize,
    rotation: usize,
    out: &mut [f64],
    width: usize,
) {
    let doubles = width / (2 * S::F64_LANES) * (2 * S::F64_LANES);
    for at in (0..doubles).step_by(2 * S::F64_LANES) {
        pairs_panel::<S, TALL, 2>(simd, rows, count, rotation, out, width, at);
    }
    for at in (doubles..width).step_by(S::F64_LANES) {
        pairs_panel::<S, TALL, 1>(simd, rows, count, rotation, out, width, at);
    }
}

/// The lanes from `at` on: their products once for all monomials.
#[inline(always)]
#[expect(clippy::too_many_arguments, reason = "one loop nest, cut where the width of a vector is known")]
fn pairs_panel<S: Simd, const TALL: usize, const WIDE: usize>(
    simd: S,
    rows: &Rows,
    count: usize,
    rotation: usize,
    out: &mut [f64],
    width: usize,
    at: usize,
) {
    let mut panel = [[simd.splat_f64s(0.0); WIDE]; BLOCK];
    for (lanes, slopes) in panel.iter_mut().zip(rows.slopes.chunks_exact(rows.slope_width)).take(count) {
        let mut products = load::<S, WIDE>(simd, slopes, at);
        let rotated = load::<S, WIDE>(simd, slopes, at + rotation);
        for i in 0..WIDE {
            products[i] = simd.mul_f64s(products[i], rotated[i]);
        }
        *lanes = products;
    }
    let panels = rows.monomials.chunks_exact(BLOCK * TALL);
    for (monomials, out) in panels.zip(out.chunks_exact_mut(TALL * width)) {
        let mut sums = [[simd.splat_f64s(0.0); WIDE]; TALL];
        for (left, lanes) in monomials.as_chunks::<TALL>().0.iter().zip(&panel[..count]) {
            multiply_add(simd, &mut sums, left, lanes);
        }
        add_tile(simd, &sums, out, width, at);
    }
}

/// `out[c][lane] += sum over rows of left[c] right[lane]`
#[inline(always)]
fn product<S: Simd, const TALL: usize>(simd: S, left: View<'_>, right: View<'_>, out: &mut [f64]) {
    let width = right.width;
    let doubles = width / (2 * S::F64_LANES) * (2 * S::F64_LANES);
    for (tile, out) in out.chunks_exact_mut(TALL * width).enumerate() {
        for at in (0..doubles).step_by(2 * S::F64_LANES) {
            let sums = tile_sums::<S, TALL, 2>(simd, left, tile * TALL, right, at);
            add_tile(simd, &sums, out, width, at);
        }
        for at in (doubles..width).step_by(S::F64_LANES) {
            let sums = tile_sums::<S, TALL, 1>(simd, left, tile * TALL, right, at);
            add_tile(simd, &sums, out, width, at);
        }
    }
}

#[inline(always)]
fn tile_sums<S: Simd, const TALL: usize, const WIDE: usize>(
    simd: S,
    left: View<'_>,
    top: usize,
    right: View<'_>,
    at: usize,
) -> [[S::f64s; WIDE]; TALL] {
    let mut sums = [[simd.splat_f64s(0.0); WIDE]; TALL];
    for (left, right) in left.iter().zip(right.iter()) {
        if let Some(left) = left.get(top..).and_then(|rest| rest.first_chunk::<TALL>()) {
            multiply_add(simd, &mut sums, left, &load::<S, WIDE>(simd, right, at));
        }
    }
    sums
}

#[inline(always)]
fn multiply_add<S: Simd, const TALL: usize, const WIDE: usize>(
    simd: S,
    sums: &mut [[S::f64s; WIDE]; TALL],
    left: &[f64; TALL],
    lanes: &[S::f64s; WIDE],
) {
    for (sums, left) in sums.iter_mut().zip(left) {
        let left = simd.splat_f64s(*left);
        for i in 0..WIDE {
            sums[i] = simd.mul_add_e_f64s(left, lanes[i], sums[i]);
        }
    }
}

#[inline(always)]
fn add_tile<S: Simd, const TALL: usize, const WIDE: usize>(
    simd: S,
    sums: &[[S::f64s; WIDE]; TALL],
    out: &mut [f64],
    out_width: usize,
    at: usize,
) {
    for (out, sums) in out.chunks_exact_mut(out_width).zip(sums) {
        let mut total = load::<S, WIDE>(simd, out, at);
        for i in 0..WIDE {
            total[i] = simd.add_f64s(total[i], sums[i]);
        }
        store::<S, WIDE>(out, at, total);
    }
}
