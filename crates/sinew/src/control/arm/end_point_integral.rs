use super::gains::EndPointGains;
use crate::Error;
use crate::body::vector::{Vector, add_scaled, norm, product, scale, solve_symmetric};
use crate::body::{IndependentKinematics, Robot};
use crate::error::within;
use alloc::vec;
use alloc::vec::Vec;

/// Slow integral of the end point's error by the encoders: it moves the reference of the joints until the end
/// point follows its path in the mean.
///
/// ```text
/// u' = k J (q_r - q^),   |u| <= u_max            while the machine moves
/// dq = J^T (J J^T + m 1)^-1 u,   m = 1e-3 tr(J J^T)/3
/// ```
///
/// | symbol | meaning                                                        | unit  |
/// |--------|----------------------------------------------------------------|-------|
/// | k, u_max | [`EndPointGains`]                                            | 1/s, m |
/// | J      | Jacobian of the end point in the estimated pose                  | m     |
/// | u, dq  | correction of the end point; of the joints, the least that makes it | m, rad |
///
/// The friction of the cables makes errors that friction compensation and the winches' integrals leave: a
/// few milliradians that last as long as a joint moves one way. Joints that do not move the end point are
/// left alone: an integral of every joint error is worse than none. It serves motions of some 10 to 40 s: in
/// slower ones joints stand in their friction for so long that they overshoot when they break away.
///
/// # Source
/// Our own; damping as in `nakamura1986`.
#[derive(Debug, Clone)]
pub(super) struct EndPointIntegral {
    gains: EndPointGains,
    kinematics: IndependentKinematics,
    /// `u`, m.
    correction: Vector,
    /// `dq`, rad or m: `[joints]`.
    pub(super) shift: Vec<f64>,
}

/// `m` over the mean of the squares of the singular values.
const DAMPING: f64 = 1e-3;

impl EndPointIntegral {
    /// # Errors
    /// [`Error::OutOfDomain`] for a site that the robot does not have.
    pub(super) fn new(robot: &Robot, gains: EndPointGains) -> Result<Self, Error> {
        let sites = robot.parts().sites.len();
        within("site of the end point", "an index of a site", gains.site as f64, gains.site < sites)?;
        let kinematics = IndependentKinematics::new(robot);
        let shift = vec![0.0; kinematics.rows.len() / 3];
        Ok(Self { gains, kinematics, correction: [0.0; 3], shift })
    }

    pub(super) fn restart(&mut self) {
        self.correction = [0.0; 3];
        self.shift.fill(0.0);
    }

    /// `dq` in a pose, after the errors of its joints, rad or m, have been integrated over `h` s.
    ///
    /// # Errors
    /// As [`IndependentKinematics::evaluate`].
    pub(super) fn update(&mut self, h: f64, robot: &Robot, pose: &[f64], error: &[f64]) -> Result<(), Error> {
        let Self { gains, kinematics, correction, shift } = self;
        kinematics.evaluate(robot, pose)?;
        kinematics.site(robot, gains.site)?;
        let n = error.len();
        let row = |k: usize| &kinematics.rows[k * n..(k + 1) * n];
        let moved = core::array::from_fn(|k| product(row(k), error));
        *correction = add_scaled(*correction, h * gains.rate, moved);
        *correction = scale((gains.largest / norm(*correction)).min(1.0), *correction);
        let mut normal: [Vector; 3] =
            core::array::from_fn(|i| core::array::from_fn(|j| product(row(i), row(j))));
        let damping = DAMPING / 3.0 * (normal[0][0] + normal[1][1] + normal[2][2]) + f64::MIN_POSITIVE;
        (0..3).for_each(|k| normal[k][k] += damping);
        let pull = solve_symmetric(normal, *correction);
        for (i, shift) in shift.iter_mut().enumerate() {
            *shift = (0..3).map(|k| kinematics.rows[k * n + i] * pull[k]).sum();
        }
        Ok(())
    }
}

#[cfg(test)]
mod tests {
    use super::*;
    use crate::body::vector::sub;

    const POSE: [f64; 3] = [0.1, -0.4, 0.5];
    const GAINS: EndPointGains = EndPointGains { site: 5, rate: 0.8, largest: 2e-3 };

    /// Three hinges in the plane of x and z, and the end point's Jacobian in [`POSE`].
    fn arm() -> (Robot, EndPointIntegral, [Vec<f64>; 3]) {
        let robot = crate::muscle::tests::robots::chain(false);
        let mut kinematics = IndependentKinematics::new(&robot);
        kinematics.evaluate(&robot, &POSE).unwrap();
        kinematics.site(&robot, GAINS.site).unwrap();
        let rows = core::array::from_fn(|k| kinematics.rows[3 * k..3 * k + 3].to_vec());
        let integral = EndPointIntegral::new(&robot, GAINS).unwrap();
        (robot, integral, rows)
    }

    fn moved(rows: &[Vec<f64>; 3], by: &[f64]) -> Vector {
        core::array::from_fn(|k| product(&rows[k], by))
    }

    #[test]
    fn an_error_of_the_end_point_is_integrated_and_the_joints_move_it_back() {
        let (robot, mut integral, rows) = arm();
        let error = [1e-3, -5e-4, 2e-3];
        for _ in 0..1000 {
            integral.update(1e-3, &robot, &POSE, &error).unwrap();
        }
        let expected = scale(GAINS.rate, moved(&rows, &error));
        assert!(norm(sub(integral.correction, expected)) < 1e-12 && norm(expected) > 1e-4, "{expected:?}");
        // The damping takes a little of it; out of the plane there is nothing to take.
        let reached = moved(&rows, &integral.shift);
        assert!(norm(sub(reached, expected)) < 0.05 * norm(expected), "{reached:?} {expected:?}");
    }

    #[test]
    fn a_site_that_is_not_there_is_refused() {
        let sites = arm().0.parts().sites.len();
        let gains = EndPointGains { site: sites, ..GAINS };
        assert!(EndPointIntegral::new(&arm().0, gains).is_err());
    }

    #[test]
    fn joint_errors_that_leave_the_end_point_where_it_is_change_nothing() {
        let (robot, mut integral, rows) = arm();
        // Orthogonal to both rows of the plane.
        let (x, z) = (&rows[0], &rows[2]);
        let still = [x[1] * z[2] - x[2] * z[1], x[2] * z[0] - x[0] * z[2], x[0] * z[1] - x[1] * z[0]];
        assert!(norm(still) > 1e-4);
        (0..1000).for_each(|_| integral.update(1e-3, &robot, &POSE, &still).unwrap());
        assert!(integral.shift.iter().all(|shift| shift.abs() < 1e-15), "{:?}", integral.shift);
    }

    #[test]
    fn the_correction_is_limited_stands_while_no_time_passes_and_ends_with_a_restart() {
        let (robot, mut integral, _) = arm();
        (0..100).for_each(|_| integral.update(0.1, &robot, &POSE, &[0.01, 0.02, -0.01]).unwrap());
        assert!((norm(integral.correction) - GAINS.largest).abs() < 1e-15);
        let reached = integral.shift.clone();
        integral.update(0.0, &robot, &POSE, &[0.5, 0.5, 0.5]).unwrap();
        assert_eq!(integral.shift, reached);
        integral.restart();
        assert_eq!((integral.correction, integral.shift), ([0.0; 3], vec![0.0; 3]));
    }
}
