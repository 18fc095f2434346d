//! Friction forces with memory: `far = a near + b - F(drive)`.

use super::capstan::speed_quantiles;
use super::law::{Law, Predict, Scale, Spec, linear_fit};
use super::samples::{Samples, Signals};
use sinew::transmission::{BoucWen, Dahl, LuGre, Play, Stribeck};
use std::sync::Arc;

/// Slip distances of the Maxwell-slip elements, as fractions of the drive's range.
const SLIP_DISTANCES: [f64; 4] = [0.02, 0.08, 0.25, 0.6];

/// Writes a law's friction at unit strength for every row, each run started at a given fraction of it.
type Unit = Arc<dyn Fn(&Samples, &[f64], &dyn Fn(usize) -> f64, &mut [f64]) -> bool + Send + Sync>;

/// A friction law of unit strength, before strength, `a` and `b` are fitted.
struct Friction {
    name: &'static str,
    equation: &'static str,
    /// One per force that enters linearly.
    strengths: Vec<Spec>,
    units: Vec<Unit>,
    /// Parameters that shape it, with a grid to start from.
    shape: Vec<Spec>,
    grid: Vec<Vec<f64>>,
    note: String,
    reason: fn(usize) -> &'static str,
}

/// The force laws with memory, or the one of the name `only`, ready to be fitted: to find where to start
/// takes most of the time.
pub(super) fn laws(samples: &Samples, signals: &Signals, only: Option<&str>) -> Vec<Law> {
    [dahl(signals), bouc_wen(signals), lugre(samples, signals), maxwell_slip(signals)]
        .into_iter()
        .filter(|friction| only.is_none_or(|only| friction.name == only))
        .map(|friction| friction.into_law(samples, signals))
        .collect()
}

fn distances(signals: &Signals) -> [f64; 5] {
    [0.003, 0.02, 0.06, 0.15, 0.4].map(|fraction| fraction * signals.drive_range)
}

fn dahl(signals: &Signals) -> Friction {
    Friction {
        name: "Dahl",
        equation: "far = a near + b - F, dF/dx = (F_c - sign(dx) F)/d",
        strengths: vec![Spec::friction("Coulomb force (F_c)", &signals.far_unit, Scale::POSITIVE)],
        units: vec![Arc::new(|samples, p, start, out| {
            let Ok(law) = Dahl::new(1.0 / p[0], 1.0) else { return false };
            simulate(samples, out, start, |force, slide, _| law.step(force, slide))
        })],
        shape: vec![Spec::friction("presliding distance (d)", &signals.drive_unit, Scale::POSITIVE)],
        grid: distances(signals).iter().map(|&d| vec![d]).collect(),
        note: String::new(),
        reason: |i| if i == 1 { "reversals are too sharp or too few for it" } else { "" },
    }
}

fn bouc_wen(signals: &Signals) -> Friction {
    let mut grid = vec![];
    for d in distances(signals) {
        for (n, beta) in [(1.3, 0.9), (2.0, 0.6), (2.0, 0.9), (4.0, 0.6)] {
            grid.push(vec![d, n, beta]);
        }
    }
    Friction {
        name: "Bouc-Wen",
        equation: "far = a near + b - F_c z, dz/dx = (1 - |z|^n (beta sign(z dx) + 1 - beta))/d",
        strengths: vec![Spec::friction("limit force (F_c)", &signals.far_unit, Scale::POSITIVE)],
        units: vec![Arc::new(|samples, p, start, out| {
            let Ok(law) = BoucWen::new(1.0, p[0], p[1], p[2]) else { return false };
            simulate(samples, out, start, |z, slide, _| law.step(z, slide))
        })],
        shape: vec![
            Spec::friction("yield distance (d)", &signals.drive_unit, Scale::POSITIVE),
            Spec::friction("sharpness (n)", "1", Scale::Above(1.0)),
            Spec::friction("shape (beta)", "1", Scale::Between(0.5, 1.0)),
        ],
        grid,
        note: String::new(),
        reason: |i| {
            if i > 1 {
                "only the roundness of the loop determines it, and it is not resolved here"
            } else {
                ""
            }
        },
    }
}

fn lugre(samples: &Samples, signals: &Signals) -> Friction {
    let speeds = speed_quantiles(samples);
    let loaded = signals.has_effort;
    let load = move |samples: &Samples, row: usize| if loaded { samples.effort[row].abs() } else { 1.0 };
    let fitted = samples.fitted.len().max(1) as f64;
    let usual = (samples.fitted.iter().map(|&row| load(samples, row)).sum::<f64>() / fitted).max(1e-12);
    let mut grid = vec![];
    for d in distances(signals) {
        for (rise, speed) in [(0.05, speeds[1]), (0.5, speeds[0]), (0.5, speeds[1])] {
            grid.push(vec![d, rise, speed]);
        }
    }
    Friction {
        name: if loaded { "LuGre under the near load" } else { "LuGre" },
        equation: "far = a near + b - F, F steady = mu N (1 + c exp(-(v/v_s)^2)), presliding over d at the mean load",
        strengths: vec![Spec::friction(
            if loaded { "friction per load (mu)" } else { "Coulomb force (F_c)" },
            if loaded { "1" } else { &signals.far_unit },
            Scale::POSITIVE,
        )],
        units: vec![Arc::new(move |samples, p, start, out| {
            let Ok(curve) = Stribeck::new(1.0, 1.0 + p[1], p[2], 0.0, 0.0) else { return false };
            let stiffness = usual / p[0];
            let Ok(law) = LuGre::new(stiffness, 0.0, curve) else { return false };
            let first = |row: usize| start(row) * load(samples, row) / stiffness;
            let bends = simulate(samples, out, first, |z, slide, row| {
                law.step(z, slide, load(samples, row), samples.interval[row]).deflection
            });
            out.iter_mut().for_each(|z| *z *= stiffness);
            bends
        })],
        shape: vec![
            Spec::friction("presliding distance (d)", &signals.drive_unit, Scale::POSITIVE),
            Spec::friction("relative Stribeck rise (c)", "1", Scale::POSITIVE),
            Spec::friction("Stribeck speed (v_s)", &format!("{}/s", signals.drive_unit), Scale::POSITIVE),
        ],
        grid,
        note: "bristle damping is omitted: it acts only within milliseconds of a reversal".to_owned(),
        reason: |i| match i {
            1 => "reversals are too sharp or too few for it",
            2 | 3 => "no sliding slow enough, or no rise at low speed",
            _ => "",
        },
    }
}

fn maxwell_slip(signals: &Signals) -> Friction {
    // An element without speed dependence is a stop operator: linear in its force, so it needs no grid.
    let unit = |fraction: f64| -> Unit {
        let radius = fraction * signals.drive_range;
        Arc::new(move |samples: &Samples, _: &[f64], start: &dyn Fn(usize) -> f64, out: &mut [f64]| {
            let Ok(law) = Play::new(radius) else { return false };
            for run in &samples.runs {
                let mut play = samples.drive[run.start] - radius * start(run.start);
                for row in run.clone() {
                    play = law.step(play, samples.drive[row]);
                    out[row] = law.stop(play, samples.drive[row]) / radius;
                }
            }
            true
        })
    };
    let strength = |fraction: &f64| {
        let name = format!("force slipping after {} % of the travel", 100.0 * fraction);
        Spec::friction(&name, &signals.far_unit, Scale::POSITIVE)
    };
    Friction {
        name: "generalised Maxwell slip",
        equation: "far = a near + b - sum_i F_i stop(x, r_i)/r_i, four elements, no speed dependence",
        strengths: SLIP_DISTANCES.iter().map(strength).collect(),
        units: SLIP_DISTANCES.iter().map(|&fraction| unit(fraction)).collect(),
        shape: vec![],
        grid: vec![vec![]],
        note: "slip distances are fixed fractions of the travel".to_owned(),
        reason: |i| {
            if i < SLIP_DISTANCES.len() {
                "this element is not needed, or there are no loops of its size"
            } else {
                ""
            }
        },
    }
}

/// Steps a scalar state along every run; `step` gets the state, the slide and the row.
fn simulate(
    samples: &Samples,
    out: &mut [f64],
    start: impl Fn(usize) -> f64,
    step: impl Fn(f64, f64, usize) -> f64,
) -> bool {
    for run in &samples.runs {
        let mut state = start(run.start);
        out[run.start] = state;
        let slides = samples.drive[run.clone()].windows(2).map(|pair| pair[1] - pair[0]);
        for (row, slide) in (run.start + 1..).zip(slides) {
            state = step(state, slide, row);
            out[row] = state;
        }
    }
    out.iter().all(|f| f.is_finite())
}

impl Friction {
    /// Starts from the best points of the grid, where strength, `a` and `b` follow by linear least squares.
    fn into_law(self, samples: &Samples, signals: &Signals) -> Law {
        let (towards, starts) = self.starts(samples, signals);
        let slope_unit = format!("{}/{}", signals.far_unit, signals.near_unit);
        let slope_unit = if signals.near_is_like_far() || signals.far_unit == signals.near_unit {
            "1"
        } else {
            &slope_unit
        };
        let slope = Scale::Linear { typical: signals.far_range / signals.near_range.max(1e-300) };
        let mut specs = self.strengths;
        let forces = specs.len();
        specs.extend(self.shape);
        specs.push(Spec::new("slope (a)", slope_unit, slope));
        specs.push(Spec::new("offset (b)", &signals.far_unit, Scale::Linear { typical: signals.far_range }));
        let mut note = format!("near is {}, x is {}", signals.near_name, signals.drive_name);
        if !signals.has_motion {
            note += ", as no motion is measured: a distance is then a tension";
        }
        if !self.note.is_empty() {
            note = format!("{note}. {}", self.note);
        }
        Law {
            name: self.name.to_owned(),
            equation: self.equation.to_owned(),
            specs,
            starts,
            predict: predict(self.units, forces, towards),
            derived: vec![],
            undetermined: vec![],
            note,
            sliding_only: false,
            reason: self.reason,
        }
    }

    fn starts(&self, samples: &Samples, signals: &Signals) -> (f64, Vec<Vec<f64>>) {
        let pick = |values: &[f64]| -> Vec<f64> { samples.fitted.iter().map(|&row| values[row]).collect() };
        let far = pick(&samples.far);
        let mut found: Vec<(f64, f64, Vec<f64>)> = vec![];
        let mut friction = vec![0.0; samples.far.len()];
        let forces = self.units.len();
        let mut fit = |shape: &[f64], start: &dyn Fn(usize) -> f64| {
            let mut columns = vec![];
            for unit in &self.units {
                if !unit(samples, shape, start, &mut friction) {
                    return None;
                }
                columns.push(pick(&friction));
            }
            let largest = columns.iter().flatten().fold(1e-12, |m: f64, f| m.max(f.abs()));
            columns.push(pick(&samples.near));
            columns.push(vec![1.0; far.len()]);
            one_way_fit(&columns, &far, forces).map(|fitted| (fitted, largest))
        };
        for shape in &self.grid {
            // From zero friction, and again from the state that the first fit gives for the start of every
            // run.
            let Some((first, _)) = fit(shape, &|_| 0.0) else { continue };
            let total: f64 = first.weights[..forces].iter().sum();
            let measured_start = |row: usize| {
                let line = first.weights[forces] * samples.near[row] + first.weights[forces + 1];
                let fraction = (samples.far[row] - line) / total;
                if fraction.is_finite() { fraction.clamp(-1.0, 1.0) } else { 0.0 }
            };
            let Some((fitted, largest)) = fit(shape, &measured_start) else { continue };
            let least = 1e-3 * signals.far_range / largest;
            let mut start: Vec<f64> = fitted.weights[..forces].iter().map(|w| w.abs().max(least)).collect();
            start.extend(shape);
            start.extend(&fitted.weights[forces..]);
            found.push((fitted.squares, fitted.towards, start));
        }
        found.sort_by(|a, b| a.0.total_cmp(&b.0));
        let towards = found.first().map_or(1.0, |best| best.1);
        found.retain(|start| start.1 * towards > 0.0);
        (towards, found.into_iter().take(2).map(|start| start.2).collect())
    }
}

/// A linear fit whose forces all have the sign `-towards`.
struct OneWay {
    weights: Vec<f64>,
    squares: f64,
    towards: f64,
}

/// Least squares with forces of one sign. The sign depends on the sense in which the drive is counted, so
/// both are tried; forces of the wrong sign are removed, the largest first.
fn one_way_fit(columns: &[Vec<f64>], target: &[f64], forces: usize) -> Option<OneWay> {
    let mut best: Option<OneWay> = None;
    for towards in [1.0, -1.0] {
        let mut kept: Vec<usize> = (0..columns.len()).collect();
        loop {
            let used: Vec<Vec<f64>> = kept.iter().map(|&i| columns[i].clone()).collect();
            let (fitted, squares) = linear_fit(&used, target)?;
            let wrong = |k: &usize| kept[*k] < forces && fitted[*k] * towards > 0.0;
            let worst =
                (0..kept.len()).filter(wrong).max_by(|a, b| fitted[*a].abs().total_cmp(&fitted[*b].abs()));
            if let Some(worst) = worst {
                kept.remove(worst);
                continue;
            }
            if best.as_ref().is_none_or(|best| squares < best.squares) {
                let mut weights = vec![0.0; columns.len()];
                for (&i, w) in kept.iter().zip(&fitted) {
                    weights[i] = *w;
                }
                best = Some(OneWay { weights, squares, towards });
            }
            break;
        }
    }
    best
}

/// `far = a near + b - towards sum_i F_i f_i`, with `a` and `b` the last two parameters.
fn predict(units: Vec<Unit>, forces: usize, towards: f64) -> Predict {
    Box::new(move |samples, p, out| {
        let (slope, offset) = (p[p.len() - 2], p[p.len() - 1]);
        let total: f64 = p[..forces].iter().sum();
        let start = |row: usize| {
            // The friction at which the law meets the first measurement, within its limits.
            let missing = slope * samples.near[row] + offset - samples.far[row];
            let fraction = towards * missing / total;
            if fraction.is_finite() { fraction.clamp(-1.0, 1.0) } else { 0.0 }
        };
        for (y, near) in out.iter_mut().zip(&samples.near) {
            *y = slope * near + offset;
        }
        let mut friction = vec![0.0; out.len()];
        for (unit, force) in units.iter().zip(p) {
            if !unit(samples, &p[forces..p.len() - 2], &start, &mut friction) {
                return false;
            }
            for (y, f) in out.iter_mut().zip(&friction) {
                *y -= towards * force * f;
            }
        }
        out.iter().all(|y| y.is_finite())
    })
}
