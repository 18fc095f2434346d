//! The simulated cable: elastic segments in series, a bend with friction between any two.

use super::motion::Sampler;
use sinew::math::tanh;

/// Nodes of friction.
const NODES: usize = 8;
/// Fraction of the total bend at each node, with two tight bends; the sum is 1.
const BENDS: [f64; NODES] = [0.06, 0.22, 0.10, 0.07, 0.08, 0.09, 0.28, 0.10];
/// Speed at which friction is halfway between breakaway and sliding, m/s.
const FALL_SPEED: f64 = 2e-3;
/// Time constant of the friction coefficient, s.
const AGING_S: f64 = 0.15;
/// Tolerance of the force balance at a node, N.
const BALANCE_TOLERANCE_N: f64 = 1e-7;
/// Limit of the Gauss-Seidel sweeps of a step; tens are typical.
const MAX_SWEEPS: usize = 2000;

/// Tensions at both ends, N.
#[derive(Debug, Clone, Copy)]
pub(super) struct Ends {
    pub(super) tension_in: f64,
    pub(super) tension_out: f64,
}

/// A cable of eight friction points and nine springs between winch and anchor.
///
/// ```text
/// T_j = max(0, k (x_(j-1) - x_j - c_j))                           spring j; x_0 winch, x_9 anchor
/// |T_j - T_(j+1) - d dx_j/dt| <= b_j (T_j + T_(j+1)),   b_j = tanh(mu_j phi_j / 2)
/// dc_j/dt  = (a T_j/k - c_j) / tau_c                              creep
/// dmu_j/dt = (mu_c + (mu_s - mu_c)/(1 + (v_j/v_s)^2) - mu_j) / tau_mu
/// ```
///
/// A node sticks while the second line holds, and otherwise slides until it holds again; `b_j` is the
/// capstan's ratio of tensions, written as difference over sum. Displacements are positive toward the motor.
#[derive(Debug, Clone)]
pub(super) struct Cable {
    /// `k`, N/m.
    stiffness: f64,
    /// `phi_j`, rad.
    bends: [f64; NODES],
    /// `mu_c` and `mu_s`.
    sliding: f64,
    breakaway: f64,
    /// `d`, N s/m.
    drag: f64,
    /// `a` and `tau_c`, s.
    creep_fraction: f64,
    creep_s: f64,
    /// `x_j`, m: `None` before the first step.
    nodes: Option<[f64; NODES]>,
    /// `mu_j`.
    coefficients: [f64; NODES],
    /// `c_j`, m.
    creep: [f64; NODES + 1],
}

impl Cable {
    /// The specimen of a seed, on a day of the given friction and stiffness.
    pub(super) fn specimen(seed: u64, friction_factor: f64, stiffness_factor: f64) -> Self {
        let mut sampler = Sampler::new(seed, 0);
        let mut about = |value: f64, fraction: f64| value * (1.0 + fraction * sampler.uniform(-1.0, 1.0));
        let sliding = friction_factor * about(0.11, 0.1);
        let breakaway = sliding * about(1.18, 0.04);
        let whole_bend = about(4.2, 0.1);
        Self {
            stiffness: stiffness_factor * about(2000.0, 0.1) * (NODES + 1) as f64,
            bends: BENDS.map(|fraction| fraction * whole_bend),
            sliding,
            breakaway,
            drag: about(40.0, 0.1) / NODES as f64,
            creep_fraction: about(0.05, 0.2),
            creep_s: about(6.0, 0.2),
            nodes: None,
            coefficients: [breakaway; NODES],
            creep: [0.0; NODES + 1],
        }
    }

    /// `mu_c phi` of all nodes, rad: friction while it slides.
    pub(super) fn friction_angle(&self) -> f64 {
        self.sliding * self.bends.iter().sum::<f64>()
    }

    /// Drag of all nodes, N s/m.
    pub(super) fn whole_drag(&self) -> f64 {
        self.drag * NODES as f64
    }

    /// Of all springs in series, m/N.
    pub(super) fn compliance(&self) -> f64 {
        (NODES + 1) as f64 / self.stiffness
    }

    /// Its parameters, for the header of a log.
    pub(super) fn describe(&self) -> String {
        format!(
            "{} elastic segments of {:.0} N/m, {NODES} bends of {:.2} rad in all, friction {:.4} sliding and \
             {:.4} at breakaway, drag {:.1} N s/m, creep {:.3} of the stretch in {:.1} s",
            NODES + 1,
            self.stiffness,
            self.bends.iter().sum::<f64>(),
            self.sliding,
            self.breakaway,
            self.whole_drag(),
            self.creep_fraction,
            self.creep_s,
        )
    }

    /// Advances by `dt` seconds to these positions of both ends, m and s; all finite, `dt > 0`.
    pub(super) fn step(&mut self, winch_m: f64, anchor_m: f64, dt: f64) -> Ends {
        let spread = |j: usize| winch_m + (anchor_m - winch_m) * (j + 1) as f64 / (NODES + 1) as f64;
        let before = self.nodes.unwrap_or_else(|| std::array::from_fn(spread));
        let mut nodes = before;
        for _ in 0..MAX_SWEEPS {
            if self.sweep(winch_m, anchor_m, &before, &mut nodes, dt) <= BALANCE_TOLERANCE_N {
                break;
            }
        }
        self.nodes = Some(nodes);
        let tensions = self.tensions(winch_m, anchor_m, &nodes);
        for (creep, tension) in self.creep.iter_mut().zip(tensions) {
            let towards = self.creep_fraction * tension / self.stiffness;
            *creep += (towards - *creep) * dt / (self.creep_s + dt);
        }
        for (coefficient, (now, then)) in self.coefficients.iter_mut().zip(nodes.iter().zip(before)) {
            let ratio = (now - then) / dt / FALL_SPEED;
            let towards = self.sliding + (self.breakaway - self.sliding) / (1.0 + ratio * ratio);
            *coefficient += (towards - *coefficient) * dt / (AGING_S + dt);
        }
        Ends { tension_in: tensions[0], tension_out: tensions[NODES] }
    }

    /// One Gauss-Seidel sweep over the nodes; returns the largest imbalance of a force, N.
    fn sweep(
        &self,
        winch: f64,
        anchor: f64,
        before: &[f64; NODES],
        nodes: &mut [f64; NODES],
        dt: f64,
    ) -> f64 {
        let mut worst = 0.0_f64;
        for j in 0..NODES {
            let nearer = if j == 0 { winch } else { nodes[j - 1] };
            let farther = if j + 1 == NODES { anchor } else { nodes[j + 1] };
            let near = self.tension(j, nearer, nodes[j]);
            let far = self.tension(j + 1, nodes[j], farther);
            let drag = self.drag / dt;
            let force = near - far - drag * (nodes[j] - before[j]);
            let limit = tanh(0.5 * self.coefficients[j] * self.bends[j]) * (near + far);
            // With equal springs the friction limit does not depend on the node's position: one division
            // solves it.
            let excess = force - force.clamp(-limit, limit);
            nodes[j] += excess / (2.0 * self.stiffness + drag);
            worst = worst.max(excess.abs());
        }
        worst
    }

    fn tension(&self, segment: usize, nearer: f64, farther: f64) -> f64 {
        (self.stiffness * (nearer - farther - self.creep[segment])).max(0.0)
    }

    fn tensions(&self, winch: f64, anchor: f64, nodes: &[f64; NODES]) -> [f64; NODES + 1] {
        std::array::from_fn(|j| {
            let nearer = if j == 0 { winch } else { nodes[j - 1] };
            self.tension(j, nearer, if j == NODES { anchor } else { nodes[j] })
        })
    }
}

#[cfg(test)]
mod tests {
    use super::*;
    use sinew::transmission::{Sliding, capstan_tension_out};

    const DT: f64 = 0.005;

    /// Work of winch and anchor over every cycle of a path of `(winch, anchor)` positions.
    fn work(cable: &mut Cable, path: &[(f64, f64)], cycles: usize) -> Vec<f64> {
        let mut from = path[path.len() - 1];
        let mut last: Option<Ends> = None;
        let mut done = Vec::new();
        for _ in 0..cycles {
            let mut sum = 0.0;
            for &to in path {
                let ends = cable.step(to.0, to.1, DT);
                let then = last.unwrap_or(ends);
                // The anchor takes out what the cable does on it.
                sum += 0.5 * (ends.tension_in + then.tension_in) * (to.0 - from.0);
                sum -= 0.5 * (ends.tension_out + then.tension_out) * (to.1 - from.1);
                (from, last) = (to, Some(ends));
            }
            done.push(sum);
        }
        done
    }

    /// A stretch that swings and an anchor that moves to and fro, in 400 steps.
    fn cycle(swing_m: f64, anchor_m: f64) -> Vec<(f64, f64)> {
        let wave = |k: usize, turns: f64| (std::f64::consts::TAU * turns * k as f64 / 400.0).sin();
        let anchor = |k| anchor_m * wave(k, 1.0);
        (0..400).map(|k| (0.04 + swing_m * wave(k, 2.0) + anchor(k), anchor(k))).collect()
    }

    #[test]
    fn every_closed_cycle_dissipates_energy() {
        for seed in 0..5 {
            for (swing, anchor) in [(0.02, 0.0), (0.03, 0.01), (0.005, 0.02), (0.0, 0.03), (0.06, 0.0)] {
                let mut cable = Cable::specimen(seed, 1.0, 1.0);
                let done = work(&mut cable, &cycle(swing, anchor), 6);
                for (k, joule) in done.iter().enumerate().skip(1) {
                    assert!(
                        *joule > 0.02,
                        "seed {seed}, swing {swing}, anchor {anchor}, cycle {k}: {joule} J"
                    );
                }
            }
        }
    }

    #[test]
    fn a_cycle_below_the_sliding_threshold_dissipates_almost_nothing() {
        let mut cable = Cable::specimen(1, 1.0, 1.0);
        let swung = work(&mut cable.clone(), &cycle(2e-2, 0.0), 4)[3];
        // Creep takes a little; friction takes nothing before it slides.
        let rocked = work(&mut cable, &cycle(2e-5, 0.0), 40)[39];
        assert!(rocked.abs() < 1e-4 * swung, "{rocked} J against {swung} J");
    }

    #[test]
    fn sliding_everywhere_is_the_capstan() {
        let mut cable = Cable { drag: 0.0, creep_fraction: 0.0, ..Cable::specimen(3, 1.0, 1.0) };
        cable.breakaway = cable.sliding;
        cable.coefficients = [cable.sliding; NODES];
        let mut ends = cable.step(0.03, 0.0, DT);
        for k in 0..400 {
            ends = cable.step(0.03 + 1e-4 * f64::from(k), 0.0, DT);
        }
        let bend = cable.bends.iter().sum();
        let law = capstan_tension_out(ends.tension_in, cable.sliding, bend, Sliding::TowardMotor).unwrap();
        assert!((ends.tension_out - law).abs() < 1e-4, "{} {law}", ends.tension_out);
    }

    #[test]
    fn with_fixed_ends_the_tension_relaxes_by_creep() {
        let mut cable = Cable::specimen(2, 1.0, 1.0);
        let first = (0..20).map(|_| cable.step(0.05, 0.0, DT)).next_back().unwrap();
        let last = (0..2000).map(|_| cable.step(0.05, 0.0, DT)).next_back().unwrap();
        assert!(last.tension_in < first.tension_in && last.tension_in > 0.9 * first.tension_in);
    }

    #[test]
    fn a_slack_cable_has_no_tension_and_recovers() {
        let mut cable = Cable::specimen(4, 1.0, 1.0);
        for k in 0..200 {
            let ends = cable.step(0.02 - 1e-3 * f64::from(k), 0.0, DT);
            assert!(ends.tension_in >= 0.0 && ends.tension_out >= 0.0);
        }
        assert!(cable.step(-0.2, 0.0, DT).tension_in < 1e-9);
        assert!(cable.step(0.05, 0.0, DT).tension_in > 50.0);
    }
}
