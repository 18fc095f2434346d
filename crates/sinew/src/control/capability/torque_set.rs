use super::zonotope::{Generators, Planes};
use crate::error::{Error, check_entries, check_length, within};
use alloc::vec;
use alloc::vec::Vec;

/// Torques of the joints that tensions within their limits give: a zonotope.
///
/// ```text
/// T = { R^T F : F_min <= F <= F_max } = { c + sum_k x_k g_k : |x_k| <= 1 }
/// c = R^T (F_min + F_max)/2,   g_k = R_k^T (F_max,k - F_min,k)/2
/// h(a) = max_T a^T tau = a^T c + sum_k |a^T g_k|                                        support function
/// ```
///
/// | symbol | argument      | unit | shape               | meaning                     |
/// |--------|---------------|------|---------------------|-----------------------------|
/// | R      | `moment_arms` | m    | `[muscles x joints]` | moment arms, row by row      |
/// | F_min, F_max | `limits` | N   | `[muscles]`          | tensions at the anchors      |
///
/// # Example
/// ```
/// use sinew::control::capability::TorqueSet;
/// // A flexor and an extensor of one joint.
/// let set = TorqueSet::new(&[0.03, -0.02], 1, &[[10.0, 100.0], [10.0, 200.0]])?;
/// assert!((set.support(&[1.0])? - (3.0 - 0.2)).abs() < 1e-12);
/// assert!((set.support(&[-1.0])? - (4.0 - 0.3)).abs() < 1e-12);
/// assert_eq!(set.vertices()?.len(), 2);
/// # Ok::<(), sinew::Error>(())
/// ```
///
/// # Source
/// `gouttefarde2010` for the facets of such a set.
#[derive(Debug, Clone, PartialEq)]
pub struct TorqueSet {
    joints: usize,
    center: Vec<f64>,
    /// `[muscles x joints]`.
    generators: Vec<f64>,
}

/// A half space that touches a set: `normal^T tau <= offset`.
#[derive(Debug, Clone, PartialEq)]
pub struct Facet {
    /// Unit normal, outward: `[joints]`.
    pub normal: Vec<f64>,
    /// Nm or N.
    pub offset: f64,
}

/// A bounded set by its vertices and facets.
#[derive(Debug, Clone, PartialEq)]
pub struct Polytope {
    /// In no particular order: `[joints]` each.
    pub vertices: Vec<Vec<f64>>,
    /// In pairs of opposite ones.
    pub facets: Vec<Facet>,
}

/// Largest number of sets of generators that are enumerated.
const MOST_COMBINATIONS: f64 = 2e6;
/// Largest number of muscles of an enumeration.
const MOST_MUSCLES: usize = 128;

impl TorqueSet {
    /// Of muscles with moment arms, m, and limits of their tensions, N.
    ///
    /// # Errors
    /// [`Error::WrongLength`], and [`Error::EntryOutOfDomain`] where an entry is not finite; limits that cross
    /// are [`Error::OutOfDomain`].
    pub fn new(moment_arms: &[f64], joints: usize, limits: &[[f64; 2]]) -> Result<Self, Error> {
        within("joints", "at least one", joints as f64, joints > 0)?;
        check_entries("moment_arms", moment_arms, joints * limits.len())?;
        let (mut center, mut generators) = (vec![0.0; joints], Vec::with_capacity(moment_arms.len()));
        for (row, [least, most]) in moment_arms.chunks_exact(joints).zip(limits) {
            within("tension limits", "finite, the least at most the largest", *least, least <= most)?;
            check_entries("tension limits", &[*least, *most], 2)?;
            for (center, arm) in center.iter_mut().zip(row) {
                *center += 0.5 * arm * (least + most);
                generators.push(0.5 * arm * (most - least));
            }
        }
        Ok(Self { joints, center, generators })
    }

    /// Number of joints.
    #[must_use]
    pub fn joints(&self) -> usize {
        self.joints
    }

    /// Its centre, Nm or N.
    #[must_use]
    pub fn center(&self) -> &[f64] {
        &self.center
    }

    /// `h`, the largest torque along a direction.
    ///
    /// # Errors
    /// [`Error::WrongLength`], and [`Error::EntryOutOfDomain`] where an entry is not finite.
    pub fn support(&self, direction: &[f64]) -> Result<f64, Error> {
        check_entries("direction", direction, self.joints)?;
        Ok(self.height(direction))
    }

    fn height(&self, direction: &[f64]) -> f64 {
        let along = |vector: &[f64]| vector.iter().zip(direction).map(|(a, b)| a * b).sum::<f64>();
        along(&self.center) + self.generators.chunks_exact(self.joints).map(|g| along(g).abs()).sum::<f64>()
    }

    /// The set of some coordinates `A tau`, such as those of a few joints: its image is again such a set.
    ///
    /// # Shapes
    /// `rows: [k x joints]`, row by row.
    ///
    /// # Errors
    /// [`Error::WrongLength`], and [`Error::EntryOutOfDomain`] where an entry is not finite.
    pub fn image(&self, rows: &[f64]) -> Result<Self, Error> {
        let joints = rows.len() / self.joints;
        within("rows", "at least one", joints as f64, joints > 0)?;
        check_entries("rows", rows, joints * self.joints)?;
        let map = |vector: &[f64]| {
            let along = |row: &[f64]| row.iter().zip(vector).map(|(a, b)| a * b).sum::<f64>();
            rows.chunks_exact(self.joints).map(along).collect::<Vec<f64>>()
        };
        let generators = self.generators.chunks_exact(self.joints).flat_map(map).collect();
        Ok(Self { joints, center: map(&self.center), generators })
    }

    /// All facets: sets of `joints - 1` generators span them.
    ///
    /// # Errors
    /// [`Error::OutOfDomain`] for a set that is flat, and beyond 128 muscles or two million sets of generators.
    pub fn facets(&self) -> Result<Vec<Facet>, Error> {
        self.facets_of(&self.enumerable(self.joints - 1)?.planes())
    }

    /// All vertices, in no particular order: `[joints]` each.
    ///
    /// # Errors
    /// As [`facets`](Self::facets).
    pub fn vertices(&self) -> Result<Vec<Vec<f64>>, Error> {
        let generators = self.enumerable(self.joints - 1)?;
        self.vertices_of(&generators, &generators.planes())
    }

    /// All vertices and facets, in the time of one of them.
    ///
    /// # Errors
    /// As [`facets`](Self::facets).
    pub fn polytope(&self) -> Result<Polytope, Error> {
        let generators = self.enumerable(self.joints - 1)?;
        let planes = generators.planes();
        Ok(Polytope { vertices: self.vertices_of(&generators, &planes)?, facets: self.facets_of(&planes)? })
    }

    fn facets_of(&self, planes: &Planes) -> Result<Vec<Facet>, Error> {
        let mut facets = Vec::new();
        for (normal, sides) in planes.iter() {
            let flat = sides.plus == 0 && sides.minus == 0;
            within("moment arms", "of full rank: a joint is not moved", 0.0, !flat)?;
            let along = |vector: &[f64]| vector.iter().zip(normal).map(|(a, b)| a * b).sum::<f64>();
            let half: f64 = self.generators.chunks_exact(self.joints).map(|g| along(g).abs()).sum();
            let middle = along(&self.center);
            facets.push(Facet { offset: half + middle, normal: normal.to_vec() });
            facets.push(Facet { offset: half - middle, normal: normal.iter().map(|x| -x).collect() });
        }
        within("moment arms", "of full rank: a joint is not moved", 0.0, !facets.is_empty())?;
        Ok(facets)
    }

    fn vertices_of(&self, generators: &Generators, planes: &Planes) -> Result<Vec<Vec<f64>>, Error> {
        let found = generators.vertices(planes);
        within("moment arms", "of full rank: a joint is not moved", 0.0, !found.is_empty())?;
        let vertex = |plus: u128| {
            let mut vertex = self.center.clone();
            for (k, generator) in self.generators.chunks_exact(self.joints).enumerate() {
                let sign = if plus & (1 << k) != 0 { 1.0 } else { -1.0 };
                vertex.iter_mut().zip(generator).for_each(|(x, g)| *x += sign * g);
            }
            vertex
        };
        Ok(found.into_iter().map(vertex).collect())
    }

    /// Vertices of a set of two joints in counter-clockwise order.
    ///
    /// # Errors
    /// [`Error::OutOfDomain`] for another number of joints.
    pub fn outline(&self) -> Result<Vec<[f64; 2]>, Error> {
        within("joints of an outline", "2", self.joints as f64, self.joints == 2)?;
        // All generators turned to the upper half plane, by angle: their polygon is half of the outline.
        let mut sides: Vec<[f64; 2]> = self
            .generators
            .chunks_exact(2)
            .map(|g| if g[1] < 0.0 || (g[1] == 0.0 && g[0] < 0.0) { [-g[0], -g[1]] } else { [g[0], g[1]] })
            .filter(|g| g[0] != 0.0 || g[1] != 0.0)
            .collect();
        sides.sort_by(|a, b| libm::atan2(a[1], a[0]).total_cmp(&libm::atan2(b[1], b[0])));
        let mut at = [self.center[0], self.center[1]];
        sides.iter().for_each(|g| at = [at[0] - g[0], at[1] - g[1]]);
        let mut outline = Vec::with_capacity(2 * sides.len());
        for sign in [2.0, -2.0] {
            for g in &sides {
                outline.push(at);
                at = [at[0] + sign * g[0], at[1] + sign * g[1]];
            }
        }
        Ok(outline)
    }

    /// `2^n sum |det|` over all sets of `n` generators, `n` joints: zero for a flat set.
    ///
    /// # Errors
    /// [`Error::OutOfDomain`] beyond two million sets of generators.
    pub fn volume(&self) -> Result<f64, Error> {
        let scale = libm::pow(2.0, self.joints as f64);
        Ok(scale * self.enumerable(self.joints)?.determinants())
    }

    /// The generators, where all sets of `choose` of them can be enumerated.
    fn enumerable(&self, choose: usize) -> Result<Generators, Error> {
        let muscles = self.generators.len() / self.joints;
        check_length("muscles of an enumeration", muscles.max(MOST_MUSCLES), MOST_MUSCLES)?;
        let sets = (0..choose).fold(1.0, |sets, i| sets * (muscles as f64 - i as f64) / (i as f64 + 1.0));
        within("sets of generators", "at most two million", sets, sets <= MOST_COMBINATIONS)?;
        Ok(Generators::new(&self.generators, self.joints))
    }
}
