//! Moment arms muscle by muscle: whole rows of known length, or only the entries that are not zero.

/// The matrix `R` of one group of joints.
pub(super) trait Rows: Copy {
    /// Whether changing a sum of [`Rows::stiffen`] is cheaper than making another.
    const LARGE: bool;

    /// Number of joints.
    fn joints(self) -> usize;

    /// What a muscle feels of one number per joint: a row of `R x`.
    fn dot(self, muscle: usize, x: &[f64]) -> f64;

    /// Takes `R^T F` from `residual`.
    fn pull(self, tension: &[f64], residual: &mut [f64]);

    /// Adds the magnitudes of what [`Rows::pull`] takes to `scale`.
    fn weigh(self, tension: &[f64], scale: &mut [f64]);

    /// Both in one pass.
    #[inline(always)]
    fn pull_and_weigh(self, tension: &[f64], residual: &mut [f64], scale: &mut [f64]) {
        self.pull(tension, residual);
        self.weigh(tension, scale);
    }

    /// Adds `sum f r^T r` over muscles and their `f` to the upper triangle of `h`.
    fn stiffen(self, parts: &[(usize, f64)], h: &mut [f64]);

    /// Adds `sum f r_j^2` over muscles and their `f` to each joint's place.
    #[inline(always)]
    fn stiffen_each(self, f: &[f64], diagonal: &mut [f64]) {
        for (muscle, f) in f.iter().enumerate() {
            for (joint, arm) in self.row(muscle) {
                diagonal[joint] += f * arm * arm;
            }
        }
    }

    /// [`Rows::stiffen`] with all muscles: `h` need not be empty.
    #[inline(always)]
    fn stiffen_all(self, f: impl Iterator<Item = f64>, h: &mut [f64]) {
        for part in f.enumerate() {
            self.stiffen(&[part], h);
        }
    }

    /// Joints and arms of a muscle.
    fn row(self, muscle: usize) -> impl Iterator<Item = (usize, f64)>;
}

/// Few joints, all of whose arms are kept: the compiler unrolls what is done with them.
#[derive(Debug, Clone, Copy)]
pub(super) struct Dense<'a, const N: usize> {
    arms: &'a [[f64; N]],
}

impl<'a, const N: usize> Dense<'a, N> {
    /// `arms`: row by row.
    pub(super) fn new(arms: &'a [f64]) -> Self {
        Self { arms: arms.as_chunks().0 }
    }

    #[inline(always)]
    pub(super) fn arms(self) -> &'a [[f64; N]] {
        self.arms
    }
}

impl<const N: usize> Rows for Dense<'_, N> {
    const LARGE: bool = N >= LANES;

    #[inline(always)]
    fn joints(self) -> usize {
        N
    }

    #[inline(always)]
    fn dot(self, muscle: usize, x: &[f64]) -> f64 {
        dot_few(&self.arms[muscle], x)
    }

    #[inline(always)]
    fn pull(self, tension: &[f64], residual: &mut [f64]) {
        self.add_each(tension, residual, |arm, tension| -arm * tension);
    }

    #[inline(always)]
    fn weigh(self, tension: &[f64], scale: &mut [f64]) {
        self.add_each(tension, scale, |arm, tension| (arm * tension).abs());
    }

    #[inline(always)]
    fn pull_and_weigh(self, tension: &[f64], residual: &mut [f64], scale: &mut [f64]) {
        let (mut left, mut size) = ([0.0; N], [0.0; N]);
        left.copy_from_slice(&residual[..N]);
        size.copy_from_slice(&scale[..N]);
        for (arms, tension) in self.arms.iter().zip(tension) {
            for j in 0..N {
                let torque = arms[j] * tension;
                left[j] -= torque;
                size[j] += torque.abs();
            }
        }
        residual[..N].copy_from_slice(&left);
        scale[..N].copy_from_slice(&size);
    }

    #[inline(always)]
    fn stiffen_each(self, f: &[f64], diagonal: &mut [f64]) {
        self.add_each(f, diagonal, |arm, f| f * arm * arm);
    }

    #[inline(always)]
    fn stiffen_all(self, f: impl Iterator<Item = f64>, h: &mut [f64]) {
        let mut sums = [[0.0; N]; N];
        for (arms, f) in self.arms.iter().zip(f) {
            for i in 0..N {
                for j in i..N {
                    sums[i][j] += f * arms[i] * arms[j];
                }
            }
        }
        for (h, sums) in h.chunks_exact_mut(N).zip(&sums) {
            for (h, sum) in h.iter_mut().zip(sums) {
                *h += sum;
            }
        }
    }

    #[inline(always)]
    fn stiffen(self, parts: &[(usize, f64)], h: &mut [f64]) {
        let h = &mut h[..N * N];
        for &(muscle, f) in parts {
            let row = &self.arms[muscle];
            for i in 0..N {
                for j in i..N {
                    h[i * N + j] += f * row[i] * row[j];
                }
            }
        }
    }

    #[inline(always)]
    fn row(self, muscle: usize) -> impl Iterator<Item = (usize, f64)> {
        self.arms[muscle].iter().copied().enumerate()
    }
}

impl<const N: usize> Dense<'_, N> {
    /// Adds `term` of every arm and its muscle's number to the joint. Sums stay in registers.
    #[inline(always)]
    fn add_each(self, numbers: &[f64], to: &mut [f64], term: impl Fn(f64, f64) -> f64) {
        let mut sums = [0.0; N];
        sums.copy_from_slice(&to[..N]);
        for (arms, &number) in self.arms.iter().zip(numbers) {
            for j in 0..N {
                sums[j] += term(arms[j], number);
            }
        }
        to[..N].copy_from_slice(&sums);
    }
}

/// Numbers handled at once.
pub(super) const LANES: usize = 4;

/// Sum of products, several at a time.
#[inline(always)]
pub(super) fn dot(a: &[f64], b: &[f64]) -> f64 {
    let ((a, a_rest), (b, b_rest)) = (a.as_chunks::<LANES>(), b.as_chunks::<LANES>());
    let mut sum = [0.0; LANES];
    for (a, b) in a.iter().zip(b) {
        for k in 0..LANES {
            sum[k] += a[k] * b[k];
        }
    }
    let rest: f64 = a_rest.iter().zip(b_rest).map(|(a, b)| a * b).sum();
    (sum[0] + sum[2]) + (sum[1] + sum[3]) + rest
}

/// The same where there may be fewer than lanes.
#[inline(always)]
pub(super) fn dot_few<const N: usize>(a: &[f64; N], b: &[f64]) -> f64 {
    if N < LANES {
        return a.iter().zip(&b[..N]).map(|(a, b)| a * b).sum();
    }
    let mut products = [0.0; N];
    for k in 0..N {
        products[k] = a[k] * b[k];
    }
    let mut sum = [0.0; LANES];
    sum.copy_from_slice(&products[..LANES]);
    for lanes in products[LANES..].as_chunks::<LANES>().0 {
        for k in 0..LANES {
            sum[k] += lanes[k];
        }
    }
    (sum[0] + sum[2]) + (sum[1] + sum[3])
}

/// Many joints, all of whose arms are kept, in whole lanes.
#[derive(Debug, Clone, Copy)]
pub(super) struct Wide<'a> {
    /// Lanes per row.
    lanes: usize,
    arms: &'a [[f64; LANES]],
}

impl<'a> Wide<'a> {
    /// `arms`: row by row; `joints` is a multiple of [`LANES`].
    pub(super) fn new(joints: usize, arms: &'a [f64]) -> Self {
        Self { lanes: joints / LANES, arms: arms.as_chunks().0 }
    }

    #[inline(always)]
    fn lanes(self, muscle: usize) -> &'a [[f64; LANES]] {
        &self.arms[muscle * self.lanes..][..self.lanes]
    }
}

impl Rows for Wide<'_> {
    const LARGE: bool = true;

    #[inline(always)]
    fn joints(self) -> usize {
        self.lanes * LANES
    }

    #[inline(always)]
    fn dot(self, muscle: usize, x: &[f64]) -> f64 {
        let mut sum = [0.0; LANES];
        for (arms, x) in self.lanes(muscle).iter().zip(x.as_chunks::<LANES>().0) {
            for k in 0..LANES {
                sum[k] += arms[k] * x[k];
            }
        }
        (sum[0] + sum[2]) + (sum[1] + sum[3])
    }

    #[inline(always)]
    fn pull(self, tension: &[f64], residual: &mut [f64]) {
        self.add_each(tension, residual, |arm, tension| -arm * tension);
    }

    #[inline(always)]
    fn weigh(self, tension: &[f64], scale: &mut [f64]) {
        self.add_each(tension, scale, |arm, tension| (arm * tension).abs());
    }

    /// Four muscles at a time: what bounds it is reading and writing `h`.
    #[inline(always)]
    fn stiffen(self, parts: &[(usize, f64)], h: &mut [f64]) {
        let (fours, rest) = parts.as_chunks::<4>();
        for four in fours {
            self.stiffen_by(four, h);
        }
        for part in rest {
            self.stiffen_by(&[*part], h);
        }
    }

    #[inline(always)]
    fn row(self, muscle: usize) -> impl Iterator<Item = (usize, f64)> {
        self.lanes(muscle).as_flattened().iter().copied().enumerate()
    }
}

impl Wide<'_> {
    /// Adds `term` of every arm and its muscle's tension to the joint, lane by lane.
    #[inline(always)]
    fn add_each(self, tension: &[f64], to: &mut [f64], term: impl Fn(f64, f64) -> f64) {
        for (at, to) in to.as_chunks_mut::<LANES>().0.iter_mut().take(self.lanes).enumerate() {
            let mut sum = *to;
            for (arms, &tension) in self.arms[at..].iter().step_by(self.lanes).zip(tension) {
                for k in 0..LANES {
                    sum[k] += term(arms[k], tension);
                }
            }
            *to = sum;
        }
    }

    /// Fills the lanes that the upper triangle touches.
    #[inline(always)]
    fn stiffen_by<const M: usize>(self, parts: &[(usize, f64); M], h: &mut [f64]) {
        let rows = parts.map(|(muscle, _)| self.lanes(muscle));
        for (i, h) in h.chunks_exact_mut(self.joints()).enumerate() {
            let from = i / LANES;
            let mut f = [0.0; M];
            for k in 0..M {
                f[k] = parts[k].1 * rows[k][from][i % LANES];
            }
            let h = &mut h.as_chunks_mut::<LANES>().0[from..];
            let rows = rows.map(|row| &row[from..][..h.len()]);
            for (at, h) in h.iter_mut().enumerate() {
                let mut sum = *h;
                for k in 0..M {
                    for lane in 0..LANES {
                        sum[lane] += f[k] * rows[k][at][lane];
                    }
                }
                *h = sum;
            }
        }
    }
}

/// Many joints, few of which each muscle crosses.
#[derive(Debug, Clone, Copy)]
pub(super) struct Sparse<'a> {
    pub(super) joints: usize,
    /// First entry of each muscle, and the end of the last.
    pub(super) start: &'a [usize],
    /// Joint and moment arm of each entry, for all groups.
    pub(super) column: &'a [usize],
    pub(super) value: &'a [f64],
}

impl Sparse<'_> {
    #[inline(always)]
    fn entries(&self, muscle: usize) -> (&[usize], &[f64]) {
        let entries = self.start[muscle]..self.start[muscle + 1];
        (&self.column[entries.clone()], &self.value[entries])
    }
}

impl Rows for Sparse<'_> {
    const LARGE: bool = true;

    #[inline(always)]
    fn joints(self) -> usize {
        self.joints
    }

    #[inline(always)]
    fn dot(self, muscle: usize, x: &[f64]) -> f64 {
        self.row(muscle).map(|(joint, arm)| arm * x[joint]).sum()
    }

    #[inline(always)]
    fn pull(self, tension: &[f64], residual: &mut [f64]) {
        for (muscle, tension) in tension.iter().enumerate() {
            for (joint, arm) in self.row(muscle) {
                residual[joint] -= arm * tension;
            }
        }
    }

    #[inline(always)]
    fn weigh(self, tension: &[f64], scale: &mut [f64]) {
        for (muscle, tension) in tension.iter().enumerate() {
            for (joint, arm) in self.row(muscle) {
                scale[joint] += (arm * tension).abs();
            }
        }
    }

    #[inline(always)]
    fn stiffen(self, parts: &[(usize, f64)], h: &mut [f64]) {
        for &(muscle, f) in parts {
            let (columns, arms) = self.entries(muscle);
            for (k, (&joint, &arm)) in columns.iter().zip(arms).enumerate() {
                let row = &mut h[joint * self.joints..(joint + 1) * self.joints];
                for (&other, &second) in columns[k..].iter().zip(&arms[k..]) {
                    row[other] += f * arm * second;
                }
            }
        }
    }

    #[inline(always)]
    fn row(self, muscle: usize) -> impl Iterator<Item = (usize, f64)> {
        let entries = self.start[muscle]..self.start[muscle + 1];
        let (columns, arms) = (&self.column[entries.clone()], &self.value[entries]);
        columns.iter().zip(arms).map(|(joint, arm)| (*joint, *arm))
    }
}
