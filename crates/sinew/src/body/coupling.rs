use super::cholesky;
use super::parts::Coupling;
use super::robot::Robot;
use super::scratch::Scratch;
use crate::error::{Error, check_entries, check_length};
use alloc::vec;
use alloc::vec::Vec;

/// Coupled joints: the velocities of a robot as functions of the independent ones.
///
/// ```text
/// v = J u,    a = J u' + J' u,    J' u = k u^2        (each velocity follows one: J has one entry per row)
/// ```
///
/// | symbol | code                       | shape    | meaning                                      |
/// |--------|----------------------------|----------|----------------------------------------------|
/// | u      | `u`                        | `[n]`    | independent velocities                       |
/// | J      | slopes                     | `[nv]`   | `dq/dx` of each follower against what leads it |
/// | k      | curvatures                 | `[nv]`   | `d^2 q/dx^2`                                   |
///
/// A joint may follow one that follows another: slopes and curvatures follow the chain rule.
#[derive(Debug, Clone, PartialEq)]
pub struct Reduction {
    /// Independent velocities.
    independent: Vec<usize>,
    /// For each velocity the index of its leader among the independent ones.
    leader: Vec<Option<usize>>,
    slope: Vec<f64>,
    curvature: Vec<f64>,
    full: Vec<f64>,
    mass: Vec<f64>,
    reduced: Vec<f64>,
}

/// Points of a range that a polynomial is fitted to, and places where its error is looked for.
const FITTED: usize = 64;
const TRIED: usize = 400;

/// Value, slope and curvature of `c0 + c1 x + .. + c4 x^4`, or of the curve of pieces.
#[inline]
pub(crate) fn curve(c: &[f64; 5], pieces: &[[f64; 5]], x: f64) -> [f64; 3] {
    let (c, x) = match pieces {
        [] => (*c, x),
        [[start, a, b, ..], ..] if x < *start => ([*a, *b, 0.0, 0.0, 0.0], x - start),
        pieces => {
            let [start, a, b, c, d] = pieces[pieces.partition_point(|[start, ..]| *start <= x).max(1) - 1];
            ([a, b, c, d, 0.0], x - start)
        }
    };
    [
        c[0] + x * (c[1] + x * (c[2] + x * (c[3] + x * c[4]))),
        c[1] + x * (2.0 * c[2] + x * (3.0 * c[3] + x * 4.0 * c[4])),
        2.0 * c[2] + x * (6.0 * c[3] + x * 12.0 * c[4]),
    ]
}

impl Coupling {
    /// The coefficients of a polynomial of degree four that is near the curve of its pieces, for formats
    /// that know no pieces, and its largest error over that range of `x`; the coefficients and 0 where it
    /// has none.
    ///
    /// ```text
    /// f(m + h t) ~ sum_k a_k T_k(t),   a_k = (2 - [k = 0])/N sum_j f(m + h t_j) cos(k w_j)
    /// t_j = cos w_j,   w_j = (j + 1/2) pi/N
    /// ```
    #[must_use]
    pub fn polynomial(&self, range: Option<[f64; 2]>) -> ([f64; 5], f64) {
        let (Some([first, ..]), Some([last, ..])) = (self.pieces.first(), self.pieces.last()) else {
            return (self.coefficients, 0.0);
        };
        let [low, high] = range.map_or([*first, *last], |[low, high]| [low.max(*first), high.min(*last)]);
        let value = |x: f64| curve(&self.coefficients, &self.pieces, x)[0];
        let (middle, half) = ((low + high) / 2.0, ((high - low) / 2.0).max(1e-9));
        let angle = |j: usize| (j as f64 + 0.5) * core::f64::consts::PI / FITTED as f64;
        let a: [f64; 5] = core::array::from_fn(|k| {
            let part = |j: usize| value(middle + half * libm::cos(angle(j))) * libm::cos(k as f64 * angle(j));
            (0..FITTED).map(part).sum::<f64>() * if k == 0 { 1.0 } else { 2.0 } / FITTED as f64
        });
        // In powers of t, then of x = m + h t, by Horner's rule.
        let t = [a[0] - a[2] + a[4], a[1] - 3.0 * a[3], 2.0 * a[2] - 8.0 * a[4], 4.0 * a[3], 8.0 * a[4]];
        let mut powers = [0.0; 5];
        for c in t.into_iter().rev() {
            let shifted = |k: usize| (if k > 0 { powers[k - 1] } else { 0.0 } - middle * powers[k]) / half;
            powers = core::array::from_fn(shifted);
            powers[0] += c;
        }
        let off = |x: f64| (curve(&powers, &[], x)[0] - value(x)).abs();
        let error =
            (0..=TRIED).map(|k| off(low + (high - low) * k as f64 / TRIED as f64)).fold(0.0, f64::max);
        (powers, error)
    }
}

impl Robot {
    /// Sets the coordinate of every coupled joint to its function of the leader's.
    ///
    /// # Shapes
    /// `q: [nq]`; followers are overwritten.
    ///
    /// # Errors
    /// [`Error::WrongLength`], and [`Error::EntryOutOfDomain`] where a coordinate is not finite.
    pub fn apply_couplings(&self, q: &mut [f64]) -> Result<(), Error> {
        self.check_coordinates(q)?;
        for coupling in self.followers() {
            let follower = self.coordinates_of(coupling.follower).start;
            let [value, ..] =
                curve(&coupling.coefficients, &coupling.pieces, self.leader_offset(coupling, q));
            q[follower] = self.parts().joints[coupling.follower].reference + value;
        }
        self.check_coordinates(q)
    }

    /// The pose with the independent joints at `x`, for robots of hinges and slides.
    ///
    /// # Errors
    /// As [`Reduction::expand`].
    pub fn pose_from_independent(&self, x: &[f64]) -> Result<Vec<f64>, Error> {
        let mut q = vec![0.0; self.nq()];
        Reduction::new(self).expand(self, x, &mut q)?;
        Ok(q)
    }

    /// Couplings in an order in which leaders come before followers.
    fn followers(&self) -> impl Iterator<Item = &Coupling> {
        self.followers.iter().map(|&index| &self.parts().couplings[index])
    }

    /// Coordinate of the leader relative to its reference.
    fn leader_offset(&self, coupling: &Coupling, q: &[f64]) -> f64 {
        let offset = |leader| q[self.coordinates_of(leader).start] - self.parts().joints[leader].reference;
        coupling.leader.map_or(0.0, offset)
    }
}

impl Reduction {
    /// Reduction of one robot; valid after [`update`](Reduction::update).
    #[must_use]
    pub fn new(robot: &Robot) -> Reduction {
        let nv = robot.nv();
        let mut leader_of: Vec<Option<Option<usize>>> = vec![None; nv];
        for coupling in robot.followers() {
            let follower = robot.velocities_of(coupling.follower).start;
            let leader = coupling.leader.map(|joint| robot.velocities_of(joint).start);
            // A leader may be a follower itself; its own leader is then known already.
            leader_of[follower] = Some(leader.and_then(|leader| leader_of[leader].unwrap_or(Some(leader))));
        }
        let independent: Vec<usize> = (0..nv).filter(|&v| leader_of[v].is_none()).collect();
        let place = |velocity: usize| independent.iter().position(|&other| other == velocity);
        let leader: Vec<Option<usize>> =
            (0..nv).map(|v| leader_of[v].unwrap_or(Some(v)).and_then(place)).collect();
        let n = independent.len();
        let slope = leader.iter().map(|leader| if leader.is_some() { 1.0 } else { 0.0 }).collect();
        let (curvature, full) = (vec![0.0; nv], vec![0.0; 3 * nv]);
        Reduction {
            independent,
            leader,
            slope,
            curvature,
            full,
            mass: vec![0.0; nv * nv],
            reduced: vec![0.0; n * n],
        }
    }

    /// The independent velocities.
    #[must_use]
    pub fn independent(&self) -> &[usize] {
        &self.independent
    }

    /// Index among the independent velocities of the one that a velocity follows, or is; none where it is
    /// constant.
    pub(crate) fn leader(&self, velocity: usize) -> Option<usize> {
        self.leader[velocity]
    }

    /// Entry of `J` of a velocity.
    #[inline]
    pub(crate) fn slope(&self, velocity: usize) -> f64 {
        self.slope[velocity]
    }

    /// The pose from the coordinates of the independent joints; evaluates slopes and curvatures in it.
    ///
    /// # Shapes
    /// `x: [n]`, hinges and slides that follow no other, in order; `q: [nq]`.
    ///
    /// # Errors
    /// [`Error::WrongLength`], and [`Error::EntryOutOfDomain`] where a coordinate is not finite.
    pub fn expand(&mut self, robot: &Robot, x: &[f64], q: &mut [f64]) -> Result<(), Error> {
        // With hinges and slides alone a joint's coordinate has the index of its velocity.
        check_length("coordinates of a robot of hinges and slides", robot.nq(), robot.nv())?;
        check_entries("independent coordinates", x, self.independent.len())?;
        check_length("q", q.len(), self.leader.len())?;
        q.fill(0.0);
        for (&place, x) in self.independent.iter().zip(x) {
            q[place] = *x;
        }
        robot.apply_couplings(q)?;
        self.update(robot, q)
    }

    /// Rows over all velocities, such as a Jacobian or moment arms, as rows over the independent ones: `A J`.
    ///
    /// # Shapes
    /// `rows: [k x nv]`, `reduced: [k x n]`, row by row.
    ///
    /// # Errors
    /// As [`forces`](Self::forces).
    pub fn rows(&self, rows: &[f64], reduced: &mut [f64]) -> Result<(), Error> {
        let (n, nv) = (self.independent.len().max(1), self.leader.len().max(1));
        check_length("reduced", reduced.len(), rows.len() / nv * n)?;
        rows.chunks_exact(nv)
            .zip(reduced.chunks_exact_mut(n))
            .try_for_each(|(row, out)| self.forces(row, out))
    }

    /// Evaluates slopes and curvatures in a pose.
    ///
    /// # Shapes
    /// `q: [nq]`, couplings satisfied ([`Robot::apply_couplings`]).
    ///
    /// # Errors
    /// [`Error::WrongLength`], and [`Error::EntryOutOfDomain`] where a coordinate is not finite.
    pub fn update(&mut self, robot: &Robot, q: &[f64]) -> Result<(), Error> {
        robot.check_coordinates(q)?;
        check_length("reduction", self.slope.len(), robot.nv())?;
        for coupling in robot.followers() {
            let follower = robot.velocities_of(coupling.follower).start;
            let [_, slope, curvature] =
                curve(&coupling.coefficients, &coupling.pieces, robot.leader_offset(coupling, q));
            let (first, second) = coupling.leader.map_or((0.0, 0.0), |leader| {
                let leader = robot.velocities_of(leader).start;
                (self.slope[leader], self.curvature[leader])
            });
            self.slope[follower] = slope * first;
            self.curvature[follower] = curvature * first * first + slope * second;
        }
        check_entries("slopes of couplings", &self.slope, robot.nv())
    }

    /// All velocities from the independent ones: `v = J u`.
    ///
    /// # Shapes
    /// `u: [n]`, `v: [nv]`.
    ///
    /// # Errors
    /// [`Error::WrongLength`], and [`Error::EntryOutOfDomain`] where an entry is not finite.
    pub fn velocities(&self, u: &[f64], v: &mut [f64]) -> Result<(), Error> {
        check_entries("u", u, self.independent.len())?;
        check_length("v", v.len(), self.leader.len())?;
        for (k, v) in v.iter_mut().enumerate() {
            *v = self.leader[k].map_or(0.0, |leader| self.slope[k] * u[leader]);
        }
        Ok(())
    }

    /// All accelerations from the independent ones: `a = J u' + J' u`.
    ///
    /// # Shapes
    /// `u` and `du: [n]`, `a: [nv]`.
    ///
    /// # Errors
    /// [`Error::WrongLength`], and [`Error::EntryOutOfDomain`] where an entry is not finite.
    pub fn accelerations(&self, u: &[f64], du: &[f64], a: &mut [f64]) -> Result<(), Error> {
        check_entries("u", u, self.independent.len())?;
        check_entries("du", du, self.independent.len())?;
        check_length("a", a.len(), self.leader.len())?;
        for (k, a) in a.iter_mut().enumerate() {
            *a = self.leader[k]
                .map_or(0.0, |leader| self.slope[k] * du[leader] + self.curvature[k] * u[leader] * u[leader]);
        }
        Ok(())
    }

    /// Generalised forces of the independent velocities: `J^T tau`.
    ///
    /// # Shapes
    /// `tau: [nv]`, `reduced: [n]`.
    ///
    /// # Errors
    /// [`Error::WrongLength`], and [`Error::EntryOutOfDomain`] where an entry is not finite.
    pub fn forces(&self, tau: &[f64], reduced: &mut [f64]) -> Result<(), Error> {
        check_entries("tau", tau, self.leader.len())?;
        check_length("reduced", reduced.len(), self.independent.len())?;
        reduced.fill(0.0);
        for (k, tau) in tau.iter().enumerate() {
            if let Some(leader) = self.leader[k] {
                reduced[leader] += self.slope[k] * tau;
            }
        }
        Ok(())
    }

    /// Mass matrix of the independent velocities: `J^T M J`.
    ///
    /// # Shapes
    /// `q: [nq]`, `mass: [n x n]`.
    ///
    /// # Errors
    /// As [`Robot::mass_matrix`].
    pub fn mass_matrix(
        &mut self,
        robot: &Robot,
        q: &[f64],
        scratch: &mut Scratch,
        mass: &mut [f64],
    ) -> Result<(), Error> {
        let (n, nv) = (self.independent.len(), self.leader.len());
        check_length("mass", mass.len(), n * n)?;
        self.update(robot, q)?;
        robot.mass_matrix(q, scratch, &mut self.mass)?;
        mass.fill(0.0);
        for (i, masses) in self.mass.chunks_exact(nv.max(1)).enumerate() {
            let Some(row) = self.leader[i] else { continue };
            // Links of different branches have no mass in common.
            for (j, entry) in masses[..=i].iter().enumerate().filter(|(_, entry)| **entry != 0.0) {
                let Some(column) = self.leader[j] else { continue };
                let entry = self.slope[i] * entry * self.slope[j];
                mass[row * n + column] += entry;
                if i != j {
                    mass[column * n + row] += entry;
                }
            }
        }
        Ok(())
    }

    /// Accelerations of the independent joints under forces on all, with the couplings as constraints.
    ///
    /// ```text
    /// J^T M J u' = J^T (tau - c - g - M J' u)
    /// ```
    ///
    /// # Shapes
    /// `q: [nq]` that satisfies the couplings, `u` and `du: [n]`, `tau: [nv]`.
    ///
    /// # Errors
    /// As [`Robot::forward_dynamics`]; a reduced mass matrix that is not positive definite is
    /// [`Error::OutOfDomain`] with its pivot.
    pub fn forward_dynamics(
        &mut self,
        robot: &Robot,
        q: &[f64],
        u: &[f64],
        tau: &[f64],
        scratch: &mut Scratch,
        du: &mut [f64],
    ) -> Result<(), Error> {
        let (n, nv) = (self.independent.len(), self.leader.len());
        robot.check_velocities("tau", tau)?;
        check_length("du", du.len(), n)?;
        let mut reduced = core::mem::take(&mut self.reduced);
        let mut full = core::mem::take(&mut self.full);
        let (v, rest) = full.split_at_mut(nv);
        let (a, load) = rest.split_at_mut(nv);
        let done = (|| {
            self.mass_matrix(robot, q, scratch, &mut reduced)?;
            self.velocities(u, v)?;
            du.fill(0.0);
            self.accelerations(u, du, a)?;
            robot.inverse_dynamics(q, v, a, scratch, load)?;
            for (load, tau) in load.iter_mut().zip(tau) {
                *load = tau - *load;
            }
            self.forces(load, du)?;
            cholesky::factor(&mut reduced, n)?;
            cholesky::solve(&reduced, du);
            Ok(())
        })();
        (self.reduced, self.full) = (reduced, full);
        done
    }
}
