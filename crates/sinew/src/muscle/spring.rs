use crate::lanes::Row;

/// Spring and damper along a cable.
#[derive(Debug, Clone, Copy, PartialEq)]
pub(super) struct Spring {
    pub(super) cable: usize,
    /// N/m.
    pub(super) stiffness: f64,
    /// N s/m.
    pub(super) damping: f64,
    /// Lengths between which it is slack, m.
    pub(super) slack: [f64; 2],
}

/// Spring and damper along a tendon in several worlds.
///
/// ```text
/// T = k (max(0, l - l_1) - max(0, l_0 - l)) + d l'
/// V = k/2 (max(0, l - l_1) - max(0, l_0 - l))^2
/// ```
///
/// | symbol   | unit  | domain       | meaning                                              |
/// |----------|-------|--------------|------------------------------------------------------|
/// | T, V     | N, J  |              | tension, elastic energy                              |
/// | l, l'    | m, m/s |             | length of the tendon and its rate                    |
/// | l_0, l_1 | m     | l_0 <= l_1   | lengths between which the spring is slack            |
/// | k, d     | N/m, N s/m | >= 0    | stiffness, damping                                   |
///
/// # Assumes
/// Below `l_0` the spring pushes, and the damper acts at every length, slack or not. A spring that only pulls
/// has an `l_0` that no pose reaches.
///
/// # Source
/// `mujoco2012`, whose tendons have this law.
#[derive(Debug, Clone, Copy, PartialEq, Default)]
pub(super) struct TendonSpring<const N: usize> {
    stiffness: Row<N>,
    damping: Row<N>,
    low: Row<N>,
    high: Row<N>,
}

impl<const N: usize> TendonSpring<N> {
    /// Takes that of another world as world `k`.
    pub(super) fn set(&mut self, k: usize, spring: &Spring) {
        (self.stiffness.0[k], self.damping.0[k]) = (spring.stiffness, spring.damping);
        [self.low.0[k], self.high.0[k]] = spring.slack;
    }

    /// Length beyond the slack: positive where it pulls.
    #[inline(always)]
    pub(super) fn stretch(&self, length: Row<N>) -> Row<N> {
        (length - self.high).max(0.0) - (self.low - length).max(0.0)
    }

    #[inline(always)]
    pub(super) fn tension(&self, length: Row<N>, rate: Row<N>) -> Row<N> {
        self.stiffness * self.stretch(length) + self.damping * rate
    }
}

#[cfg(test)]
mod tests {
    use super::*;

    #[test]
    fn the_tension_is_the_slope_of_the_energy_and_slack_between_its_lengths() {
        let mut spring = TendonSpring::<1>::default();
        spring.set(0, &Spring { cable: 0, stiffness: 300.0, damping: 2.0, slack: [0.1, 0.3] });
        let energy = |l: f64| 150.0 * spring.stretch(Row([l])).0[0].powi(2);
        for l in [-0.2, 0.05, 0.2, 0.35, 0.9] {
            let slope = (energy(l + 1e-6) - energy(l - 1e-6)) / 2e-6;
            let Row([tension]) = spring.tension(Row([l]), Row([0.0]));
            assert!((slope - tension).abs() < 1e-6, "{l}: {slope} {tension}");
            assert!((tension.abs() < 1e-12) == (l > 0.1 && l < 0.3));
        }
        let Row([damped]) = spring.tension(Row([0.2]), Row([0.5]));
        assert!((damped - 1.0).abs() < 1e-12);
    }
}
