//! Simulated benches of an elastic cable with friction, as columns that a test can damage.

use rand::RngExt;
use rand_chacha::ChaCha8Rng;
use std::fmt::Write as _;

/// A log as columns.
#[derive(Debug, Clone)]
pub(crate) struct Table {
    /// Names and values, time first, the far side last.
    pub(crate) columns: Vec<(String, Vec<f64>)>,
}

impl Table {
    pub(crate) fn rows(&self) -> usize {
        self.columns[0].1.len()
    }

    pub(crate) fn column(&mut self, name: &str) -> &mut Vec<f64> {
        let found = self.columns.iter_mut().find(|(known, _)| known == name);
        &mut found.expect("a column of the bench").1
    }

    pub(crate) fn far(&self) -> &[f64] {
        &self.columns[self.columns.len() - 1].1
    }

    /// The rows of an index.
    pub(crate) fn keep(&mut self, rows: impl Fn(usize) -> bool) {
        for (_, values) in &mut self.columns {
            let mut row = 0;
            values.retain(|_| {
                row += 1;
                rows(row - 1)
            });
        }
    }

    pub(crate) fn csv(&self) -> String {
        let names: Vec<&str> = self.columns.iter().map(|(name, _)| name.as_str()).collect();
        let mut text = names.join(",") + "\n";
        for row in 0..self.rows() {
            for (k, (_, values)) in self.columns.iter().enumerate() {
                let comma = if k == 0 { "" } else { "," };
                write!(text, "{comma}{}", values[row]).expect("a string takes text");
            }
            text.push('\n');
        }
        text
    }
}

/// What a bench measures.
#[derive(Debug, Clone, Copy, PartialEq, Eq)]
pub(crate) enum Kind {
    /// Near tension and position of the winch; the far tension is predicted.
    Sheath,
    /// The same, stiff and at 250 Hz.
    Stiff,
    /// Near tension alone.
    Tension,
    /// Position alone, at 50 Hz.
    Stroke,
    /// Motor torque and motor angle; the angle of the far joint is predicted.
    Joint,
}

/// A bench with a specimen.
#[derive(Debug, Clone)]
pub(crate) struct Bench {
    pub(crate) kind: Kind,
    /// `mu phi`.
    pub(crate) friction: f64,
    /// Stiffness of the cable and of the load, N per mm.
    cable: f64,
    load: f64,
    pretension: f64,
}

impl Bench {
    pub(crate) const KINDS: [Kind; 5] = [Kind::Sheath, Kind::Stiff, Kind::Tension, Kind::Stroke, Kind::Joint];

    pub(crate) fn sampled(kind: Kind, random: &mut ChaCha8Rng) -> Self {
        let mut between = |low: f64, high: f64| low + (high - low) * random.random::<f64>();
        let stiff = if kind == Kind::Stiff { 3.0 } else { 1.0 };
        Self {
            kind,
            friction: between(0.15, 0.5),
            cable: stiff * between(8.0, 16.0),
            load: between(1.5, 4.0),
            pretension: between(20.0, 40.0),
        }
    }

    /// The inputs and the far side by name.
    pub(crate) fn channels(&self) -> (Vec<&'static str>, &'static str) {
        match self.kind {
            Kind::Sheath | Kind::Stiff => (vec!["tension_in_n", "position_in_m"], "tension_out_n"),
            Kind::Tension => (vec!["tension_in_n"], "tension_out_n"),
            Kind::Stroke => (vec!["position_in_m"], "tension_out_n"),
            Kind::Joint => (vec!["torque_in_nm", "angle_motor_rad"], "theta_rad"),
        }
    }

    pub(crate) fn rate_hz(&self) -> f64 {
        match self.kind {
            Kind::Stiff => 250.0,
            Kind::Stroke => 50.0,
            _ => 100.0,
        }
    }

    /// Another day: other motion, friction off by up to 3 %, noise.
    pub(crate) fn log(&self, random: &mut ChaCha8Rng) -> Table {
        let mut between = |low: f64, high: f64| low + (high - low) * random.random::<f64>();
        let (rate, seconds) = (self.rate_hz(), if self.kind == Kind::Stroke { 20.0 } else { 12.0 });
        let friction = self.friction * between(0.97, 1.03);
        let waves: Vec<[f64; 3]> =
            (0..4).map(|_| [between(1.5, 5.0), between(1.0, 6.0), between(0.0, 6.3)]).collect();
        let (up, down) = (friction.exp(), (-friction).exp());
        // Position of the far end, mm, at which the tensions of both ends have a given ratio.
        let balanced = |winch: f64, ratio: f64| {
            (self.cable * winch - ratio * self.pretension) / (self.cable + self.load * ratio)
        };
        let at = |t: f64| 22.0 + waves.iter().map(|[a, w, p]| a * (w * t + p).sin()).sum::<f64>();
        let rows = (seconds * rate) as usize;
        let mut place = balanced(at(-3.0), 1.0);
        let mut columns = [vec![], vec![], vec![], vec![], vec![]];
        for row in 0..rows + (3.0 * rate) as usize {
            let t = row as f64 / rate - 3.0;
            let winch = at(t);
            place = place.clamp(balanced(winch, up), balanced(winch, down));
            if t < 0.0 {
                continue;
            }
            let tension = self.cable * (winch - place) + between(-0.15, 0.15);
            let far = self.load * place + self.pretension + between(-0.15, 0.15);
            let (winch, place) = (winch + between(-0.002, 0.002), place + between(-0.02, 0.02));
            for (column, value) in columns.iter_mut().zip([t, tension, 1e-3 * winch, far, place]) {
                column.push(value);
            }
        }
        let [time, tension, position, far, place] = columns;
        let scaled = |values: Vec<f64>, factor: f64| values.into_iter().map(|x| x * factor).collect();
        let named = |name: &str, values: Vec<f64>| (name.to_owned(), values);
        let time = named("time_s", time);
        let columns = match self.kind {
            Kind::Sheath | Kind::Stiff => {
                vec![
                    time,
                    named("tension_in_n", tension),
                    named("position_in_m", position),
                    named("tension_out_n", far),
                ]
            }
            Kind::Tension => vec![time, named("tension_in_n", tension), named("tension_out_n", far)],
            Kind::Stroke => vec![time, named("position_in_m", position), named("tension_out_n", far)],
            Kind::Joint => vec![
                time,
                named("torque_in_nm", scaled(tension, 0.01)),
                named("angle_motor_rad", scaled(position, 100.0)),
                named("theta_rad", scaled(place, 0.05)),
            ],
        };
        Table { columns }
    }
}
