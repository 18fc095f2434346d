use crate::error::{Error, check_entries, within};
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
/// # Ok::<(), sinew::Error>(())
/// ```
///
/// # Source
/// `gouttefarde2010` for such sets.
#[derive(Debug, Clone, PartialEq)]
pub struct TorqueSet {
    joints: usize,
    center: Vec<f64>,
    /// `[muscles x joints]`.
    generators: Vec<f64>,
}

impl TorqueSet {
    /// Of muscles with moment arms, m, and limits of their tensions, N.
    ///
    /// # Errors
    /// [`Error::WrongLength`], and [`Error::EntryOutOfDomain`] where an entry is not finite; limits that
    /// cross are [`Error::OutOfDomain`].
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

    /// Vertices of a set of two joints in counter-clockwise order; muscles that pull along one line leave
    /// points within a side.
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
}

#[cfg(test)]
mod tests {
    use super::*;

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
            let (outline, corners) = (set.outline().unwrap(), corners(arms, 2));
            let crossing = arms.chunks_exact(2).filter(|arm| arm[0] != 0.0 || arm[1] != 0.0);
            assert_eq!(outline.len(), 2 * crossing.count());
            let near = |a: &[f64], b: &[f64]| a.iter().zip(b).all(|(a, b)| (a - b).abs() < 2e-15);
            assert!(outline.iter().all(|point| corners.iter().any(|corner| near(point, corner))));
            let at = |k: usize| outline[k % outline.len()];
            let cross = |a: [f64; 2], b: [f64; 2]| a[0] * b[1] - a[1] * b[0];
            let side = |k: usize| [at(k + 1)[0] - at(k)[0], at(k + 1)[1] - at(k)[1]];
            assert!((0..outline.len()).all(|k| cross(side(k), side(k + 1)) > 1e-3));
            let area: f64 = (0..outline.len()).map(|k| 0.5 * cross(at(k), at(k + 1))).sum();
            // The area of a zonogon: four times the parallelograms of all pairs of generators.
            let generators: Vec<[f64; 2]> = arms.chunks_exact(2).map(|arm| [arm[0], arm[1]]).collect();
            let pairs = generators.iter().enumerate();
            let pairs = pairs.flat_map(|(k, a)| generators[..k].iter().map(|b| 4.0 * cross(*a, *b).abs()));
            assert!((area - pairs.sum::<f64>()).abs() < 7e-15);
        }
        assert!(of(&all, 1).outline().is_err() && of(&all[..12], 3).outline().is_err());
    }
}
