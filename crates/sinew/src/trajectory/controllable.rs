use crate::Error;
use crate::body::{Robot, cholesky, symmetric};
use crate::error::{check_entries, check_length};
use crate::muscle::MuscleDynamics;
use crate::random::EvenPoints;
use alloc::vec;
use alloc::vec::Vec;

/// The motions that the motors of a machine with fewer motors than joints control, in one pose: where a cable
/// passes several joints against springs, the joints move together, each as its spring lets it.
///
/// ```text
/// K = d(g - tau_p)/dq - sum_k F_k dR_k/dq,    N = null(R)
/// S = (1 - N (N^T K N)^-1 N^T K) Q,           Q: orthonormal rows of R;  R S = R Q
/// x := S (R S)^+ R x                          what of a displacement x the cables control
/// (R S)^T F = S^T tau                         tensions for a torque
/// ```
///
/// | symbol | method                                     | shape               | unit    | meaning                  |
/// |--------|--------------------------------------------|---------------------|---------|--------------------------|
/// | R      | [`MuscleDynamics::moment_arms`]            | `[muscles x joints]`| m       | moment arms `-dl/dq`     |
/// | F      | `tension`                                  | `[muscles]`         | N       | tensions at the anchors  |
/// | g, tau_p |                                          | `[joints]`          | Nm or N | torque of gravity; of springs |
/// | K      |                                            | `[joints x joints]` | Nm/rad  | stiffness at constant tensions |
/// | S      | [`motion`](Self::motion)                   | `[count x joints]`  |         | directions in which the joints move when winches turn slowly, transposed |
///
/// The directions do not depend on the stiffness of the cables. Lengths alone say where the joints are while
/// `N^T K N > 0`; else the finger snaps from pose to pose.
///
/// # Assumes
/// One motor per muscle; joints without dry friction.
///
/// # Source
/// Statics of elastic mechanisms under constraints; the projection along `R` is ours.
#[derive(Debug, Clone)]
pub struct ControllableMotion {
    model: MuscleDynamics,
    /// Muscles whose rows of `R` span all of them: `[count]`.
    leading: Vec<usize>,
    /// Joints that are not at a stop: `[joints]`.
    free: Vec<bool>,
    /// `R` without joints at a stop: `[muscles x joints]`.
    rows: Vec<f64>,
    /// `g - tau_p` at rest: `[joints]`.
    torque: Vec<f64>,
    /// `[joints x joints]`.
    stiffness: Vec<f64>,
    /// `Q^T` and `N^T`, row by row: together at most `[joints x joints]`.
    held: Vec<f64>,
    loose: Vec<f64>,
    /// Factor of `N^T K N`.
    loose_stiffness: Vec<f64>,
    follows: bool,
    /// `S^T`: `[count x joints]`.
    motion: Vec<f64>,
    /// `R S`: `[muscles x count]`.
    arms: Vec<f64>,
    /// Factor of `(R S)^T R S`.
    normal: Vec<f64>,
    at: Vec<f64>,
    still: Vec<f64>,
    above: Vec<f64>,
    below: Vec<f64>,
    change: Vec<f64>,
    coordinates: Vec<f64>,
}

/// Part of a row or joint, relative to the largest, below which it counts as dependent on the others.
const DEPENDENT: f64 = 1e-3;
/// Poses in which a machine has to have the same lack of motors.
const POSES: usize = 8;
/// Step of the differences, rad or m.
const STEP: f64 = 1e-5;
/// Part of a row that has become dependent in another pose.
const LOST: f64 = 1e-9;

impl ControllableMotion {
    /// Of a robot whose cables leave joints to its springs in every pose; none where they hold all joints.
    ///
    /// # Errors
    /// As [`MuscleDynamics::new`].
    pub fn new(robot: &Robot) -> Result<Option<Self>, Error> {
        let mut model = MuscleDynamics::new(robot)?;
        let (m, n) = (model.muscles(), model.joints());
        let parts = robot.parts();
        let joints = robot.independent_joints();
        let range = |joint: &usize| parts.joints[*joint].range.unwrap_or([-0.5, 0.5]);
        let ranges: Vec<[f64; 2]> = joints.iter().map(range).collect();
        let mut leading: Vec<usize> = Vec::new();
        for point in EvenPoints::new(n).take(POSES) {
            let within = ranges.iter().zip(point).map(|([low, high], x)| low + x * (high - low));
            model.evaluate(&within.collect::<Vec<_>>())?;
            let found = independent_rows(model.moment_arms(), n);
            if found.len() > leading.len() {
                leading = found;
            }
        }
        let r = leading.len();
        Ok((r < n && r > 0).then(|| Self {
            free: vec![true; n],
            rows: vec![0.0; m * n],
            torque: vec![0.0; n],
            stiffness: vec![0.0; n * n],
            held: vec![0.0; n * n],
            loose: Vec::with_capacity(n * n),
            loose_stiffness: vec![0.0; n * n],
            follows: false,
            motion: vec![0.0; r * n],
            arms: vec![0.0; m * r],
            normal: vec![0.0; r * r],
            at: vec![0.0; n],
            still: vec![0.0; n],
            above: vec![0.0; n],
            below: vec![0.0; n],
            change: vec![0.0; n],
            coordinates: vec![0.0; n],
            leading,
            model,
        }))
    }

    /// Number of controllable coordinates: the rank of `S`, below that of the joints.
    #[must_use]
    pub fn count(&self) -> usize {
        self.leading.len()
    }

    /// Muscles that control them, independent of each other: `[count]`.
    #[must_use]
    pub fn leading(&self) -> &[usize] {
        &self.leading
    }

    /// Holds these joints at their stops from the next evaluation on; they move no more: `[joints]`.
    pub fn set_stopped(&mut self, stopped: impl Iterator<Item = bool>) {
        self.free.iter_mut().zip(stopped).for_each(|(free, stopped)| *free = !stopped);
    }

    /// Sets the pose, rad or m, `[joints]`, and the tensions, N, `[muscles]`. Nothing is allocated.
    ///
    /// # Errors
    /// [`Error::WrongLength`], and [`Error::EntryOutOfDomain`] where an entry is not finite.
    pub fn evaluate(&mut self, q: &[f64], tension: &[f64]) -> Result<(), Error> {
        let n = self.free.len();
        check_length("pose", q.len(), n)?;
        check_entries("tensions", tension, self.model.muscles())?;
        self.at.copy_from_slice(q);
        for (i, &place) in q.iter().enumerate() {
            self.at[i] = place + STEP;
            unbalanced(&mut self.model, &self.at, tension, &self.still, &mut self.above)?;
            self.at[i] = place - STEP;
            unbalanced(&mut self.model, &self.at, tension, &self.still, &mut self.below)?;
            self.at[i] = place;
            for (j, (above, below)) in self.above.iter().zip(&self.below).enumerate() {
                self.stiffness[i * n + j] = (above - below) / (2.0 * STEP);
            }
        }
        for i in 0..n {
            for j in 0..i {
                let mean = 0.5 * (self.stiffness[i * n + j] + self.stiffness[j * n + i]);
                (self.stiffness[i * n + j], self.stiffness[j * n + i]) = (mean, mean);
            }
        }
        unbalanced(&mut self.model, q, &[], &self.still, &mut self.torque)?;
        self.rows.copy_from_slice(self.model.moment_arms());
        for row in self.rows.chunks_exact_mut(n) {
            row.iter_mut().zip(&self.free).for_each(|(arm, free)| *arm *= f64::from(u8::from(*free)));
        }
        self.split();
        self.couple();
        Ok(())
    }

    /// `Q` by Gram and Schmidt in the order of the leading muscles, so that it changes smoothly from pose to
    /// pose; `N` completes it among the free joints.
    fn split(&mut self) {
        let (n, r) = (self.free.len(), self.leading.len());
        let mut rank = 0;
        for (place, &muscle) in self.leading.iter().enumerate() {
            let (before, row) = self.held.split_at_mut(place * n);
            row[..n].copy_from_slice(&self.rows[muscle * n..(muscle + 1) * n]);
            let size = norm(&row[..n]);
            let left = remove(&mut row[..n], before, n);
            let kept = left > LOST * size && left > 0.0;
            row[..n].iter_mut().for_each(|x| *x = if kept { *x / left } else { 0.0 });
            rank += usize::from(kept);
        }
        let free = self.free.iter().filter(|free| **free).count();
        self.loose.clear();
        while self.loose.len() < (free - rank.min(free)) * n {
            // The joint of which most is left.
            let left = |j: &usize| {
                let taken = self.held[..r * n].chunks_exact(n).chain(self.loose.chunks_exact(n));
                f64::from(u8::from(self.free[*j])) - taken.map(|row| row[*j] * row[*j]).sum::<f64>()
            };
            let most = (0..n).max_by(|a, b| left(a).total_cmp(&left(b))).unwrap_or(0);
            self.change.fill(0.0);
            self.change[most] = 1.0;
            for _ in 0..2 {
                remove(&mut self.change, &self.held[..r * n], n);
                remove(&mut self.change, &self.loose, n);
            }
            let size = norm(&self.change);
            self.loose.extend(self.change.iter().map(|x| x / size));
        }
    }

    /// `N^T K N`, `S`, `R S` and its normal matrix.
    fn couple(&mut self) {
        let (n, r) = (self.free.len(), self.leading.len());
        let k = self.loose.len() / n;
        for (i, row) in self.loose.chunks_exact(n).enumerate() {
            times(&self.stiffness, row, &mut self.change);
            for (j, other) in self.loose.chunks_exact(n).enumerate().take(i + 1) {
                self.loose_stiffness[i * k + j] = dot(&self.change, other);
            }
        }
        self.follows = cholesky::factor(&mut self.loose_stiffness[..k * k], k).is_ok();
        for place in 0..r {
            let own = place * n..(place + 1) * n;
            self.change.copy_from_slice(&self.held[own.clone()]);
            times(&self.stiffness, &self.change, &mut self.above);
            self.relax();
            self.motion[own.clone()].copy_from_slice(&self.held[own.clone()]);
            self.motion[own].iter_mut().zip(&self.below).for_each(|(x, relaxed)| *x -= relaxed);
        }
        for (arms, row) in self.arms.chunks_exact_mut(r).zip(self.rows.chunks_exact(n)) {
            for (arm, held) in arms.iter_mut().zip(self.held.chunks_exact(n)) {
                *arm = dot(row, held);
            }
        }
        let size: f64 = self.arms.iter().map(|arm| arm * arm).sum();
        for i in 0..r {
            for j in 0..=i {
                let products = self.arms.chunks_exact(r).map(|row| row[i] * row[j]);
                // A direction that is lost moves nothing.
                self.normal[i * r + j] = products.sum::<f64>() + if i == j { 1e-12 * size } else { 0.0 };
            }
        }
        if cholesky::factor(&mut self.normal, r).is_err() {
            self.normal.fill(0.0);
            (0..r).for_each(|i| self.normal[i * r + i] = 1.0);
        }
    }

    /// `N (N^T K N)^-1 N^T` of the torques in `above`, into `below`; 0 where the joints do not follow.
    fn relax(&mut self) {
        let (n, k) = (self.free.len(), self.loose.len() / self.free.len());
        self.below.fill(0.0);
        if !self.follows {
            return;
        }
        let Self { loose, loose_stiffness, coordinates, above, below, .. } = self;
        for (x, row) in coordinates.iter_mut().zip(loose.chunks_exact(n)) {
            *x = dot(row, above);
        }
        cholesky::solve(&loose_stiffness[..k * k], &mut coordinates[..k]);
        for (x, row) in coordinates.iter().zip(loose.chunks_exact(n)) {
            below.iter_mut().zip(row).for_each(|(below, entry)| *below += x * entry);
        }
    }

    /// Whether the joints follow the lengths of the cables, `N^T K N > 0`.
    #[must_use]
    pub fn is_followable(&self) -> bool {
        self.follows
    }

    /// The least eigenvalue of `N^T K N`, Nm/rad, and the joint that moves most in its direction; none where
    /// all joints that are left are at their stops.
    #[must_use]
    pub fn least_stiffness(&self) -> Option<(f64, usize)> {
        let n = self.free.len();
        let k = self.loose.len() / n;
        let (mut matrix, mut vectors, mut product) = (vec![0.0; k * k], vec![0.0; k * k], vec![0.0; n]);
        for (i, row) in self.loose.chunks_exact(n).enumerate() {
            times(&self.stiffness, row, &mut product);
            for (j, other) in self.loose.chunks_exact(n).enumerate() {
                matrix[i * k + j] = dot(&product, other);
            }
        }
        symmetric::eigen(&mut matrix, &mut vectors, k);
        let least = (0..k).min_by(|a, b| matrix[a * k + a].total_cmp(&matrix[b * k + b]))?;
        let moved = |j: usize| -> f64 {
            let rows = vectors[least * k..].iter().zip(self.loose.chunks_exact(n));
            rows.map(|(x, row)| x * row[j]).sum::<f64>().abs()
        };
        let joint = (0..n).max_by(|a, b| moved(*a).total_cmp(&moved(*b)))?;
        Some((matrix[least * k + least], joint))
    }

    /// `S^T`, row by row: `[count x joints]`.
    #[must_use]
    pub fn motion(&self) -> &[f64] {
        &self.motion
    }

    /// How the joints move per length by which one leading cable shortens while the others stand, 1/m or 1:
    /// `[count][joints]`.
    #[must_use]
    pub fn per_length(&self) -> Vec<Vec<f64>> {
        let (n, r) = (self.free.len(), self.leading.len());
        // R S of the leading muscles is lower triangular: Q is made of their rows in this order.
        let mut found = vec![vec![0.0; n]; r];
        for (lead, found) in found.iter_mut().enumerate() {
            let mut weights = vec![0.0; r];
            for (k, muscle) in self.leading.iter().enumerate() {
                let row = &self.arms[muscle * r..(muscle + 1) * r];
                let shortens = f64::from(u8::from(k == lead));
                weights[k] = (shortens - dot(&row[..k], &weights[..k])) / row[k];
            }
            for (weight, motion) in weights.iter().zip(self.motion.chunks_exact(n)) {
                found.iter_mut().zip(motion).for_each(|(x, entry)| *x += weight * entry);
            }
        }
        found
    }

    /// `R S`, m, row by row: `[muscles x count]`.
    #[must_use]
    pub fn arms(&self) -> &[f64] {
        &self.arms
    }

    /// Lengths of the muscles in the evaluated pose, m: `[muscles]`.
    #[must_use]
    pub fn lengths(&self) -> &[f64] {
        self.model.lengths()
    }

    /// Replaces a displacement of the joints by what the cables control of it: `[joints]`.
    pub fn project(&mut self, x: &mut [f64]) {
        let Self { coordinates, rows, arms, free, leading, .. } = self;
        let (n, r) = (free.len(), leading.len());
        coordinates.fill(0.0);
        for (row, arms) in rows.chunks_exact(n).zip(arms.chunks_exact(r)) {
            let along = dot(row, x);
            coordinates.iter_mut().zip(arms).for_each(|(sum, arm)| *sum += arm * along);
        }
        self.combine(x);
    }

    /// `S (..)^-1` of the sums `(R S)^T d` in `coordinates`.
    fn combine(&mut self, x: &mut [f64]) {
        let Self { coordinates, normal, motion, free, leading, .. } = self;
        let (n, r) = (free.len(), leading.len());
        cholesky::solve(normal, &mut coordinates[..r]);
        x.fill(0.0);
        for (weight, row) in coordinates.iter().zip(motion.chunks_exact(n)) {
            x.iter_mut().zip(row).for_each(|(x, entry)| *x += weight * entry);
        }
    }

    /// `S^T tau` of a torque of the joints, Nm or N: `[count]`.
    pub fn torque(&self, torque: &[f64], out: &mut [f64]) {
        let rows = self.motion.chunks_exact(self.free.len());
        out.iter_mut().zip(rows).for_each(|(out, row)| *out = dot(row, torque));
    }

    /// The tensions of least norm that balance springs and gravity along `S`, N: `[muscles]`.
    pub(crate) fn balance(&mut self, tension: &mut [f64]) {
        let r = self.leading.len();
        for (x, row) in self.coordinates.iter_mut().zip(self.motion.chunks_exact(self.free.len())) {
            *x = dot(row, &self.torque);
        }
        cholesky::solve(&self.normal, &mut self.coordinates[..r]);
        for (tension, arms) in tension.iter_mut().zip(self.arms.chunks_exact(r)) {
            *tension = dot(arms, &self.coordinates[..r]);
        }
    }

    /// Torque that springs and gravity leave at every joint under tensions, `g - tau_p - R^T F`, Nm or N, the
    /// joints at stops included: `[joints]`.
    pub(crate) fn unbalanced(&mut self, tension: &[f64], out: &mut [f64]) {
        out.copy_from_slice(&self.torque);
        for (row, tension) in self.model.moment_arms().chunks_exact(out.len()).zip(tension) {
            out.iter_mut().zip(row).for_each(|(out, arm)| *out -= arm * tension);
        }
    }

    /// Newton's step of the joints to these lengths and to the equilibrium at them: `[joints]`.
    pub(crate) fn step_to(&mut self, lengths: &[f64], out: &mut [f64]) {
        let r = self.leading.len();
        self.coordinates.fill(0.0);
        let shorten = self.model.lengths().iter().zip(lengths);
        for ((length, wanted), arms) in shorten.zip(self.arms.chunks_exact(r)) {
            self.coordinates.iter_mut().zip(arms).for_each(|(sum, arm)| *sum += arm * (length - wanted));
        }
        self.combine(out);
        self.above.copy_from_slice(&self.torque);
        self.relax();
        out.iter_mut().zip(&self.below).for_each(|(out, relaxed)| *out -= relaxed);
    }
}

/// `g - tau_p - R^T F` in a pose at rest; no tensions count as none.
fn unbalanced(
    model: &mut MuscleDynamics,
    q: &[f64],
    tension: &[f64],
    still: &[f64],
    out: &mut [f64],
) -> Result<(), Error> {
    model.evaluate(q)?;
    model.inverse_dynamics(still, still, out)?;
    for (row, tension) in model.moment_arms().chunks_exact(out.len()).zip(tension) {
        out.iter_mut().zip(row).for_each(|(out, arm)| *out -= arm * tension);
    }
    Ok(())
}

/// Rows of a matrix `[.. x n]` that span all of them, with every column scaled to its largest entry.
fn independent_rows(matrix: &[f64], n: usize) -> Vec<usize> {
    let largest = |j: usize| matrix.chunks_exact(n).fold(0.0, |most: f64, row| most.max(row[j].abs()));
    let scale: Vec<f64> = (0..n).map(|j| 1.0 / largest(j).max(1e-30)).collect();
    let scaled = |row: &[f64]| row.iter().zip(&scale).map(|(x, scale)| x * scale).collect::<Vec<f64>>();
    let rows: Vec<Vec<f64>> = matrix.chunks_exact(n).map(scaled).collect();
    let (mut found, mut basis, mut first) = (Vec::new(), Vec::new(), 0.0_f64);
    while found.len() < n.min(rows.len()) {
        let left = rows.iter().enumerate().map(|(k, row)| {
            let mut row = row.clone();
            let size = remove(&mut row, &basis, n);
            (k, row, size)
        });
        let Some((k, row, size)) = left.max_by(|a, b| a.2.total_cmp(&b.2)) else { break };
        first = first.max(size);
        if size <= DEPENDENT * first {
            break;
        }
        found.push(k);
        basis.extend(row.iter().map(|x| x / size));
    }
    found.sort_unstable();
    found
}

/// Removes from `x` what lies along orthonormal rows, and returns the norm of what is left.
fn remove(x: &mut [f64], rows: &[f64], n: usize) -> f64 {
    for row in rows.chunks_exact(n) {
        let along = dot(x, row);
        x.iter_mut().zip(row).for_each(|(x, entry)| *x -= along * entry);
    }
    norm(x)
}

fn times(matrix: &[f64], x: &[f64], out: &mut [f64]) {
    out.iter_mut().zip(matrix.chunks_exact(x.len())).for_each(|(out, row)| *out = dot(row, x));
}

fn dot(a: &[f64], b: &[f64]) -> f64 {
    a.iter().zip(b).map(|(a, b)| a * b).sum()
}

fn norm(x: &[f64]) -> f64 {
    libm::sqrt(dot(x, x))
}
