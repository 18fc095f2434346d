//! The same law, written a second time without regard to speed: many cells, short steps, balance to the last
//! digit.
//!
//! Shares no code with the library: its own cells, friction by `f64::tanh`, a bracketed active-set Newton
//! iteration with a matrix that is assembled before it is solved.

/// Number of cells inside the sheath.
const SHEATH_CELLS: usize = 200;
/// Steps per millisecond.
pub(crate) const SUBSTEPS: usize = 10;

/// The bench of the paper as the library's defaults describe it, numbers repeated on purpose.
pub(crate) struct Reference {
    compliance: Vec<f64>,
    half_angle: Vec<f64>,
    drag: Vec<f64>,
    pub(crate) tension: Vec<f64>,
    slip: Vec<f64>,
    stretch: f64,
    /// Steps in which balance was not reached.
    pub(crate) failures: usize,
}

const PRETENSION: f64 = 15.5;
const FADE: f64 = 5.0;

impl Reference {
    pub(crate) fn new(drag: f64) -> Self {
        let n = SHEATH_CELLS as f64;
        let mut length = vec![0.806 / n; SHEATH_CELLS];
        length.insert(0, 0.166);
        length.push(0.695);
        let mut fraction = vec![1.0 / n; SHEATH_CELLS + 1];
        fraction[0] *= 0.5;
        fraction[SHEATH_CELLS] *= 0.5;
        let mut angle: Vec<f64> = fraction.iter().map(|s| 0.156 * s * 1.5 * std::f64::consts::PI).collect();
        angle[0] -= 0.928_f64.ln();
        angle[SHEATH_CELLS] += 0.156 * std::f64::consts::FRAC_PI_2;
        Self {
            compliance: length.iter().map(|l| 2.56e-4 * l).collect(),
            half_angle: angle.iter().map(|a| 0.5 * a).collect(),
            drag: fraction.iter().map(|s| drag * s).collect(),
            tension: vec![0.0; length.len()],
            slip: vec![0.0; length.len() - 1],
            stretch: 0.0,
            failures: 0,
        }
    }

    /// After long sliding, `sign` +1 toward the motor.
    pub(crate) fn settle(&mut self, tension_out: f64, sign: f64) {
        let mut t = tension_out - PRETENSION;
        for j in (0..self.tension.len()).rev() {
            self.tension[j] = t;
            if j > 0 {
                t *= (2.0 * sign * self.half_angle[j - 1]).exp();
            }
        }
        self.stretch = self.tension.iter().zip(&self.compliance).map(|(t, c)| t * c).sum();
        self.slip.fill(0.0);
    }

    pub(crate) fn tension_in(&self) -> f64 {
        self.tension[0]
    }

    pub(crate) fn tension_out(&self) -> f64 {
        self.tension.last().unwrap() + PRETENSION
    }

    /// One step of `dt` seconds.
    pub(crate) fn step(&mut self, dt: f64, motor: f64, anchor: f64) {
        let was = self.stretch;
        self.stretch += motor - anchor;
        if self.stretch <= 0.0 {
            self.tension.fill(0.0);
            self.slip.fill(0.0);
            return;
        }
        if was <= 0.0 {
            self.take_up(if motor + anchor >= 0.0 { 1.0 } else { -1.0 });
            return;
        }
        let start = self.slip.clone();
        if !self.balance(dt, motor, anchor) {
            if dt < 1e-6 {
                self.failures += 1;
            } else {
                // The active set goes round in circles: two shorter steps find their way.
                self.slip = start;
                self.stretch = was;
                self.step(0.5 * dt, 0.5 * motor, 0.5 * anchor);
                return self.step(0.5 * dt, 0.5 * motor, 0.5 * anchor);
            }
        }
        let all: Vec<f64> =
            std::iter::once(motor).chain(self.slip.iter().copied()).chain(std::iter::once(anchor)).collect();
        for j in 0..self.tension.len() {
            self.tension[j] = (self.tension[j] + (all[j] - all[j + 1]) / self.compliance[j]).max(0.0);
        }
    }

    fn take_up(&mut self, sign: f64) {
        let mut profile = vec![1.0];
        for h in &self.half_angle {
            profile.push(profile.last().unwrap() * (-2.0 * sign * h).exp());
        }
        let sum: f64 = profile.iter().zip(&self.compliance).map(|(p, c)| p * c).sum();
        for (t, p) in self.tension.iter_mut().zip(&profile) {
            *t = self.stretch * p / sum;
        }
    }

    /// Newton's method until no displacement changes by more than 1e-15 m.
    fn balance(&mut self, dt: f64, motor: f64, anchor: f64) -> bool {
        let n = self.slip.len();
        let (mut lower, mut middle, mut upper, mut rest) =
            (vec![0.0; n], vec![0.0; n], vec![0.0; n], vec![0.0; n]);
        for iteration in 0..80 {
            for i in 0..n {
                let before = if i == 0 { motor } else { self.slip[i - 1] };
                let after = if i + 1 == n { anchor } else { self.slip[i + 1] };
                let (cl, cr) = (self.compliance[i], self.compliance[i + 1]);
                let left = self.tension[i] + (before - self.slip[i]) / cl;
                let right = self.tension[i + 1] + (self.slip[i] - after) / cr;
                let load = (left + right).max(0.0);
                let bound = load * self.half_angle[i].tanh();
                let trial = left - right + (1.0 / cl + 1.0 / cr) * self.slip[i];
                let sign = if bound < 1e-12 {
                    if motor + anchor >= 0.0 { 1.0 } else { -1.0 }
                } else if trial.abs() <= bound {
                    0.0
                } else {
                    trial.signum()
                };
                if sign == 0.0 {
                    (lower[i], middle[i], upper[i], rest[i]) = (0.0, 1.0, 0.0, -self.slip[i]);
                    continue;
                }
                let viscous = self.drag[i] / (load + 2.0 * FADE) / dt;
                let turn = (sign * self.half_angle[i] + viscous * self.slip[i]).tanh();
                let slope = load * (1.0 - turn * turn) * viscous;
                lower[i] = -(1.0 - turn) / cl;
                upper[i] = -(1.0 + turn) / cr;
                middle[i] = slope - lower[i] - upper[i];
                rest[i] = left - right - turn * (left + right);
            }
            let change = solve(&lower, &middle, &upper, &rest);
            // Far from the start of the step, smaller steps break cycles of the active set.
            let fraction = if iteration < 30 { 1.0 } else { 0.9 / (1 + iteration % 7) as f64 };
            let mut largest: f64 = 0.0;
            for (w, x) in self.slip.iter_mut().zip(&change) {
                *w += fraction * x;
                largest = largest.max(x.abs());
            }
            if largest < 1e-15 {
                return true;
            }
        }
        // Undecided nodes flicker: harmless at a thousandth of the error that is looked for.
        rest.iter().all(|r| r.abs() < 1e-4)
    }
}

/// Thomas' algorithm.
fn solve(lower: &[f64], middle: &[f64], upper: &[f64], rest: &[f64]) -> Vec<f64> {
    let n = rest.len();
    let (mut pivot, mut value) = (middle.to_vec(), rest.to_vec());
    for i in 1..n {
        let factor = lower[i] / pivot[i - 1];
        pivot[i] -= factor * upper[i - 1];
        value[i] -= factor * value[i - 1];
    }
    for i in (0..n).rev() {
        let next = if i + 1 < n { upper[i] * value[i + 1] } else { 0.0 };
        value[i] = (value[i] - next) / pivot[i];
    }
    value
}
