//! Products summed over the samples of a block, in tiles of accumulators that fit the registers.

use super::simd::{Real, load, padded, store};
use pulp::Simd;
use std::ops::Range;

/// Samples per block: their rows fit the first-level cache.
pub(super) const BLOCK: usize = 64;

/// `count` rows of `width`.
#[derive(Clone, Copy)]
pub(super) struct View<'a, R> {
    pub(super) rows: &'a [R],
    pub(super) width: usize,
    pub(super) count: usize,
}

impl<'a, R: Real> View<'a, R> {
    #[inline(always)]
    fn iter(self) -> impl Iterator<Item = &'a [R]> {
        self.rows.chunks_exact(self.width).take(self.count)
    }
}

/// `out[m][lane] += sum over samples of left[m] s[lane] s[lane + rotation]`
///
/// `left` in panels `[panel][BLOCK][TALL]`; `out: [panels TALL x width]`.
#[inline(always)]
pub(super) fn add_pairs<S: Simd, R: Real, const TALL: usize>(
    simd: S,
    left: &[R],
    slopes: View<'_, R>,
    rotation: usize,
    out: &mut [R],
    width: usize,
) {
    let doubles = width / (2 * R::width::<S>()) * (2 * R::width::<S>());
    for at in (0..doubles).step_by(2 * R::width::<S>()) {
        add_pairs_at::<S, R, TALL, 2>(simd, left, slopes, [at, at + rotation], out, width);
    }
    for at in (doubles..width).step_by(R::width::<S>()) {
        add_pairs_at::<S, R, TALL, 1>(simd, left, slopes, [at, at + rotation], out, width);
    }
}

#[inline(always)]
fn add_pairs_at<S: Simd, R: Real, const TALL: usize, const WIDE: usize>(
    simd: S,
    left: &[R],
    slopes: View<'_, R>,
    [at, rotated]: [usize; 2],
    out: &mut [R],
    width: usize,
) {
    // Products of slopes, computed once for all rows of `left`.
    let mut panel = [[R::splat(simd, R::ZERO); WIDE]; BLOCK];
    for (lanes, slopes) in panel.iter_mut().zip(slopes.iter()) {
        let mut products = load::<S, R, WIDE>(simd, slopes, at);
        let rotated = load::<S, R, WIDE>(simd, slopes, rotated);
        for i in 0..WIDE {
            products[i] = R::mul(simd, products[i], rotated[i]);
        }
        *lanes = products;
    }
    for (left, out) in left.chunks_exact(BLOCK * TALL).zip(out.chunks_exact_mut(TALL * width)) {
        let mut sums = [[R::splat(simd, R::ZERO); WIDE]; TALL];
        for (left, lanes) in left.as_chunks::<TALL>().0.iter().zip(&panel[..slopes.count.min(BLOCK)]) {
            multiply_add(simd, &mut sums, left, lanes);
        }
        add_tile(simd, &sums, out, width, at);
    }
}

/// `out[c][lane] += sum over rows of left[c] right[lane]`; `out: [multiple of TALL x right.width]`.
#[inline(always)]
pub(super) fn add_product<S: Simd, R: Real, const TALL: usize>(
    simd: S,
    left: View<'_, R>,
    right: View<'_, R>,
    out: &mut [R],
) {
    for (tile, out) in out.chunks_exact_mut(TALL * right.width).enumerate() {
        add_row_of_tiles::<S, R, TALL>(simd, left, tile * TALL, right, 0..right.width, out);
    }
}

/// `out[c][lane] += sum over rows of left[top + c] right[lane]` for the `lanes`, and for those before and
/// behind them that share a vector with them; `out: [TALL x right.width]`, or less.
#[inline(always)]
pub(super) fn add_row_of_tiles<S: Simd, R: Real, const TALL: usize>(
    simd: S,
    left: View<'_, R>,
    top: usize,
    right: View<'_, R>,
    lanes: Range<usize>,
    out: &mut [R],
) {
    let (vector, width) = (R::width::<S>(), right.width);
    let end = padded(lanes.end, vector);
    let first = lanes.start / (2 * vector) * (2 * vector);
    let doubles = end / (2 * vector) * (2 * vector);
    for at in (first..doubles).step_by(2 * vector) {
        let sums = tile_sums::<S, R, TALL, 2>(simd, left, top, right, at);
        add_tile(simd, &sums, out, width, at);
    }
    for at in (doubles.max(first)..end).step_by(vector) {
        let sums = tile_sums::<S, R, TALL, 1>(simd, left, top, right, at);
        add_tile(simd, &sums, out, width, at);
    }
}

#[inline(always)]
fn tile_sums<S: Simd, R: Real, const TALL: usize, const WIDE: usize>(
    simd: S,
    left: View<'_, R>,
    top: usize,
    right: View<'_, R>,
    at: usize,
) -> [[R::Vector<S>; WIDE]; TALL] {
    let mut sums = [[R::splat(simd, R::ZERO); WIDE]; TALL];
    for (left, right) in left.iter().zip(right.iter()) {
        if let Some(left) = left.get(top..).and_then(|rest| rest.first_chunk::<TALL>()) {
            multiply_add(simd, &mut sums, left, &load::<S, R, WIDE>(simd, right, at));
        }
    }
    sums
}

#[inline(always)]
fn multiply_add<S: Simd, R: Real, const TALL: usize, const WIDE: usize>(
    simd: S,
    sums: &mut [[R::Vector<S>; WIDE]; TALL],
    left: &[R; TALL],
    lanes: &[R::Vector<S>; WIDE],
) {
    for (sums, left) in sums.iter_mut().zip(left) {
        let left = R::splat(simd, *left);
        for i in 0..WIDE {
            sums[i] = R::mul_add(simd, left, lanes[i], sums[i]);
        }
    }
}

#[inline(always)]
fn add_tile<S: Simd, R: Real, const TALL: usize, const WIDE: usize>(
    simd: S,
    sums: &[[R::Vector<S>; WIDE]; TALL],
    out: &mut [R],
    width: usize,
    at: usize,
) {
    for (out, sums) in out.chunks_exact_mut(width).zip(sums) {
        let mut total = load::<S, R, WIDE>(simd, out, at);
        for i in 0..WIDE {
            total[i] = R::add(simd, total[i], sums[i]);
        }
        store::<S, R, WIDE>(out, at, total);
    }
}
