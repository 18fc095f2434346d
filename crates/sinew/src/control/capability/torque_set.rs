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
        Ok(self.facets_of(&self.planes()?.1))
    }

    /// All vertices, in no particular order: `[joints]` each.
    ///
    /// # Errors
    /// As [`facets`](Self::facets).
    pub fn vertices(&self) -> Result<Vec<Vec<f64>>, Error> {
        let (generators, planes) = self.planes()?;
        Ok(self.vertices_of(&generators, &planes))
    }

    /// All vertices and facets, in the time of one of them.
    ///
    /// # Errors
    /// As [`facets`](Self::facets).
    pub fn polytope(&self) -> Result<Polytope, Error> {
        let (generators, planes) = self.planes()?;
        Ok(Polytope { vertices: self.vertices_of(&generators, &planes), facets: self.facets_of(&planes) })
    }

    /// Of a set that is not flat.
    fn planes(&self) -> Result<(Generators, Planes), Error> {
        let generators = self.enumerable(self.joints - 1)?;
        let planes = generators.planes();
        within("moment arms", "of full rank: a joint is not moved", 0.0, !planes.are_of_flat_set())?;
        Ok((generators, planes))
    }

    fn facets_of(&self, planes: &Planes) -> Vec<Facet> {
        let mut facets = Vec::new();
        for (normal, _) in planes.iter() {
            let along = |vector: &[f64]| vector.iter().zip(normal).map(|(a, b)| a * b).sum::<f64>();
            let half: f64 = self.generators.chunks_exact(self.joints).map(|g| along(g).abs()).sum();
            let middle = along(&self.center);
            facets.push(Facet { offset: half + middle, normal: normal.to_vec() });
            facets.push(Facet { offset: half - middle, normal: normal.iter().map(|x| -x).collect() });
        }
        facets
    }

    fn vertices_of(&self, generators: &Generators, planes: &Planes) -> Vec<Vec<f64>> {
        let vertex = |plus: u128| {
            let mut vertex = self.center.clone();
            for (k, generator) in self.generators.chunks_exact(self.joints).enumerate() {
                let sign = if plus & (1 << k) != 0 { 1.0 } else { -1.0 };
                vertex.iter_mut().zip(generator).for_each(|(x, g)| *x += sign * g);
            }
            vertex
        };
        generators.vertices(planes).into_iter().map(vertex).collect()
    }

    /// Vertices of a set of two joints in counter-clockwise order; muscles that pull along one line leave points within a
    /// side.
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

#[cfg(test)]
mod tests {
    use super::*;
    use crate::random::Random;

    fn dot(a: &[f64], b: &[f64]) -> f64 {
        a.iter().zip(b).map(|(a, b)| a * b).sum()
    }

    /// Muscles of 1 to 3 N: their arms are the generators, twice their sum the centre.
    fn of(arms: &[f64], joints: usize) -> TorqueSet {
        TorqueSet::new(arms, joints, &vec![[1.0, 3.0]; arms.len() / joints]).unwrap()
    }

    /// Torques at all combinations of least and largest tensions.
    fn corners(arms: &[f64], joints: usize) -> Vec<Vec<f64>> {
        let tension = |code: usize, k: usize| if code >> k & 1 == 1 { 3.0 } else { 1.0 };
        let torque = |code: usize| {
            let mut torque = vec![0.0; joints];
            for (k, row) in arms.chunks_exact(joints).enumerate() {
                torque.iter_mut().zip(row).for_each(|(sum, arm)| *sum += tension(code, k) * arm);
            }
            torque
        };
        (0..1 << (arms.len() / joints)).map(torque).collect()
    }

    /// Checks a set against its corners and against how many vertices and facets it has.
    fn check(arms: &[f64], joints: usize, [vertices, facets]: [usize; 2]) {
        let (set, corners) = (of(arms, joints), corners(arms, joints));
        let found = set.polytope().unwrap();
        assert_eq!((found.vertices.len(), found.facets.len()), (vertices, facets), "{arms:?}");
        assert_eq!((&found.vertices, &found.facets), (&set.vertices().unwrap(), &set.facets().unwrap()));
        let near = |a: &[f64], b: &[f64]| a.iter().zip(b).all(|(a, b)| (a - b).abs() < 7e-15);
        for (k, vertex) in found.vertices.iter().enumerate() {
            assert!(corners.iter().any(|corner| near(corner, vertex)));
            assert!(!found.vertices[..k].iter().any(|other| near(other, vertex)));
        }
        for (k, facet) in found.facets.iter().enumerate() {
            let most = corners.iter().map(|corner| dot(corner, &facet.normal)).fold(f64::MIN, f64::max);
            assert!(
                (facet.offset - most).abs() < 7e-15
                    && (dot(&facet.normal, &facet.normal) - 1.0).abs() < 7e-16
            );
            assert!(!found.facets[..k].iter().any(|other| near(&other.normal, &facet.normal)));
            let touching = found.vertices.iter().filter(|v| facet.offset - dot(v, &facet.normal) < 7e-15);
            assert!(touching.count() >= joints);
        }
        let mut random = Random::new(21);
        for _ in 0..20 {
            let direction: Vec<f64> = (0..joints).map(|_| random.normal()).collect();
            let most =
                |points: &[Vec<f64>]| points.iter().map(|x| dot(x, &direction)).fold(f64::MIN, f64::max);
            let height = most(&corners);
            assert!((most(&found.vertices) - height).abs() < 2e-14);
            assert!((set.support(&direction).unwrap() - height).abs() < 2e-14);
        }
    }

    #[test]
    fn known_solids_have_their_numbers_of_vertices_and_facets() {
        // Two muscles along each axis, some of them opposed: a box whose facets hold four generators each.
        let boxed =
            [1.0, 0.0, 0.0, 0.5, 0.0, 0.0, 0.0, 2.0, 0.0, 0.0, -0.25, 0.0, 0.0, 0.0, 0.7, 0.0, 0.0, 3.0];
        check(&boxed, 3, [8, 6]);
        let volume = 8.0 * 1.5 * 2.25 * 3.7;
        assert!((of(&boxed, 3).volume().unwrap() - volume).abs() < 3e-16 * volume);
        check(&[1.0, 0.2, -0.5, 0.0, 0.0, 0.0, 0.3, -0.8], 2, [6, 6]);
        check(&[0.4, -0.3, 0.0, 2.0], 1, [2, 2]);
        // Hexagonal prism, rhombic dodecahedron, truncated octahedron, truncated cuboctahedron.
        check(&[1.0, 0.0, 0.0, 0.5, 0.9, 0.0, -0.6, 0.8, 0.0, 0.0, 0.0, 2.0], 3, [12, 8]);
        check(&[1.0, 1.0, 1.0, 1.0, -1.0, -1.0, -1.0, 1.0, -1.0, -1.0, -1.0, 1.0], 3, [14, 12]);
        let sums =
            [1.0, 1.0, 0.0, 1.0, -1.0, 0.0, 1.0, 0.0, 1.0, 1.0, 0.0, -1.0, 0.0, 1.0, 1.0, 0.0, 1.0, -1.0];
        check(&sums, 3, [24, 14]);
        let axes = [1.0, 0.0, 0.0, 0.0, 1.0, 0.0, 0.0, 0.0, 1.0];
        check(&[&sums[..], &axes[..]].concat(), 3, [48, 26]);
        // All orders of five things: the axes of four dimensions and their differences.
        let mut permutations = Vec::new();
        for i in 0..4 {
            for j in i..4 {
                let mut row = [0.0; 4];
                row[i] = 1.0;
                if j > i {
                    row[j] = -1.0;
                }
                permutations.extend(row);
            }
        }
        check(&permutations, 4, [120, 30]);
    }

    #[test]
    fn muscles_in_general_position_give_as_many_vertices_as_their_planes_have_regions() {
        let binomial = |n: usize, k: usize| (0..k).fold(1, |product, i| product * (n - i) / (i + 1));
        let mut random = Random::new(22);
        for joints in 1..5 {
            for muscles in joints..joints + 4 {
                let arms: Vec<f64> = (0..muscles * joints).map(|_| random.normal()).collect();
                let vertices = 2 * (0..joints).map(|k| binomial(muscles - 1, k)).sum::<usize>();
                let facets = 2 * if joints == 1 { 1 } else { binomial(muscles, joints - 1) };
                check(&arms, joints, [vertices, facets]);
            }
        }
    }

    #[test]
    fn a_set_has_the_same_shape_for_instruments_and_for_cranes() {
        let prism = [1.0, 0.0, 0.0, 0.5, 0.9, 0.0, -0.6, 0.8, 0.0, 0.0, 0.0, 2.0];
        for size in [1e-9, 1e-6, 1e6] {
            let found = of(&prism.map(|arm| size * arm), 3).polytope().unwrap();
            assert_eq!((found.vertices.len(), found.facets.len()), (12, 8), "{size}");
        }
    }

    #[test]
    fn fewer_muscles_than_joints_give_a_flat_set() {
        for (muscles, joints) in [(0, 1), (1, 2), (1, 3), (2, 3), (1, 4)] {
            let arms: Vec<f64> = (0..muscles * joints).map(|k| 1.0 + k as f64 * k as f64).collect();
            let set = of(&arms, joints);
            assert!(set.volume().unwrap().abs() < 1e-300);
            assert!(set.facets().is_err() && set.vertices().is_err() && set.polytope().is_err());
        }
    }

    #[test]
    fn the_torques_of_some_joints_are_what_is_left_of_the_whole_set_along_them() {
        let arms = [0.3, -0.1, 0.2, -0.2, 0.4, 0.0, 0.1, 0.1, -0.5, 0.0, -0.3, 0.1];
        let set = of(&arms, 3);
        assert_eq!(set.joints(), 3);
        for (j, center) in set.center().iter().enumerate() {
            let expected: f64 = arms.iter().skip(j).step_by(3).map(|arm| 2.0 * arm).sum();
            assert!((center - expected).abs() < 1e-15);
        }
        let rows = [2.0, 0.0, -1.0, 0.0, 0.5, 3.0];
        let image = set.image(&rows).unwrap();
        assert_eq!((image.joints(), image.center().len()), (2, 2));
        for direction in [[1.0, 0.0], [0.0, -1.0], [0.6, 0.8], [-2.0, 1.0]] {
            // h_AT(a) = h_T(A^T a).
            let back: Vec<f64> =
                (0..3).map(|j| rows[j] * direction[0] + rows[3 + j] * direction[1]).collect();
            assert!((image.support(&direction).unwrap() - set.support(&back).unwrap()).abs() < 7e-16);
        }
        assert_eq!(set.image(&[1.0, 0.0, 0.0, 0.0, 1.0, 0.0, 0.0, 0.0, 1.0]).unwrap(), set);
        assert!(
            set.image(&[]).is_err() && set.image(&rows[..5]).is_err() && set.image(&[f64::NAN; 3]).is_err()
        );
    }

    #[test]
    fn the_outline_goes_round_all_vertices_counter_clockwise() {
        // Along both axes either way, in every quadrant, and one muscle without moment arms.
        let all = [0.5, 0.0, -0.3, 0.4, 0.0, -0.7, 0.2, 0.6, -0.4, -0.3, 0.0, 0.0, 0.3, -0.1];
        // A muscle that does not cross a joint may have an arm of either zero.
        let other = [-0.5, -0.0, 0.0, 0.7, -0.1, 0.9];
        for arms in [&all[..], &other[..]] {
            let set = of(arms, 2);
            let (outline, vertices) = (set.outline().unwrap(), set.vertices().unwrap());
            assert_eq!(outline.len(), vertices.len());
            let near = |a: &[f64], b: &[f64]| a.iter().zip(b).all(|(a, b)| (a - b).abs() < 2e-15);
            assert!(vertices.iter().all(|vertex| outline.iter().any(|point| near(point, vertex))));
            let at = |k: usize| outline[k % outline.len()];
            let cross = |a: [f64; 2], b: [f64; 2]| a[0] * b[1] - a[1] * b[0];
            let side = |k: usize| [at(k + 1)[0] - at(k)[0], at(k + 1)[1] - at(k)[1]];
            assert!((0..outline.len()).all(|k| cross(side(k), side(k + 1)) > 1e-3));
            let area: f64 = (0..outline.len()).map(|k| 0.5 * cross(at(k), at(k + 1))).sum();
            assert!((area - set.volume().unwrap()).abs() < 7e-16);
        }
        assert!(of(&all, 1).outline().is_err() && of(&all[..12], 3).outline().is_err());
    }

    #[test]
    fn facets_and_volume_are_refused_beyond_two_million_sets_of_generators_and_128_muscles() {
        let of_count = |muscles: usize| {
            let mut random = Random::new(23);
            let arms: Vec<f64> = (0..4 * muscles).map(|_| random.normal()).collect();
            // Few muscles have a range of tensions: what is counted is soon enumerated.
            let limits: Vec<[f64; 2]> = (0..muscles).map(|k| [1.0, if k < 6 { 2.0 } else { 1.0 }]).collect();
            TorqueSet::new(&arms, 4, &limits).unwrap()
        };
        // 84 choose 4 is 1.93 million, 85 choose 4 is 2.02 million; 128 choose 3 is 0.34 million.
        assert!(of_count(84).volume().is_ok() && of_count(85).volume().is_err());
        let (largest, more) = (of_count(128), of_count(129));
        assert!(largest.facets().is_ok() && largest.vertices().is_ok() && largest.polytope().is_ok());
        assert!(more.facets().is_err() && more.vertices().is_err() && more.polytope().is_err());
        let two = |joints: usize| of(&vec![1.0; 2 * joints], joints);
        assert!(two(2).volume().unwrap().abs() < 1e-15);
    }
}
