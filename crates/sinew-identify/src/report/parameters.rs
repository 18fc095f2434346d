//! Physical parameters of the chosen model with their intervals.

use crate::evaluate::unit_in;
use crate::fit::classical::{FRICTION_ANGLE, Parameter};
use sinew::predictor::{Axis, AxisForce, AxisMotion, CableModel, MemoryLaw, Model, Signal};
use sinew::transmission::{BasisTerm, ClampCell};

/// Numbers of the physics with intervals from the spread over the folds (delete-one-fold jackknife).
pub(super) fn parameters(model: &Model, folds: &[MemoryLaw]) -> Vec<Parameter> {
    let of_member = model.estimator.members.iter().map(|member| &member.estimator.law);
    let law = core::iter::once(&model.estimator.law).chain(of_member).find(|law| law.has_physics());
    let Some(law) = law else { return Vec::new() };
    if let Some(cable) = &law.cable {
        let folds: Vec<&CableModel> = folds.iter().filter_map(|f| Some(&f.cable.as_ref()?.model)).collect();
        return cable_parameters(&cable.model, &folds);
    }
    if let Some(axis) = &law.axis {
        let folds: Vec<&Axis> = folds.iter().filter_map(|f| f.axis.as_ref()).collect();
        return axis_parameters(axis, &folds, law, model);
    }
    let Some(cell) = &law.cell else { return Vec::new() };
    let folds: Vec<&ClampCell> = folds.iter().filter_map(|f| f.cell.as_ref()).collect();
    cell_parameters(model, law, cell, &folds)
}

/// What a log shows of a cable.
fn cable_parameters(model: &CableModel, folds: &[&CableModel]) -> Vec<Parameter> {
    type Number = fn(&CableModel) -> f64;
    let numbers: [(&str, &str, Number); 5] = [
        (FRICTION_ANGLE, "1", |m| m.law().map_or(f64::NAN, |law| law.friction_angle())),
        ("drag of the grease", "N s/m", |m| m.parameters.drag),
        ("pretension", "N", |m| m.parameters.pretension),
        ("compliance of the whole cable", "m/N", |m| {
            m.law().map_or(f64::NAN, |law| law.compliance().iter().sum())
        }),
        ("compliance near the drive", "m/N", |m| {
            m.law().ok().and_then(|law| law.compliance().first().copied()).unwrap_or(f64::NAN)
        }),
    ];
    let warming: (&str, &str, Number) = ("softening of the grease per heat of friction", "1/J", |m| {
        m.warming.map_or(0.0, |warming| warming.rate)
    });
    let warming = model.warming.map(|_| warming);
    let one = |(name, unit, number): (&str, &str, Number)| {
        let others: Vec<f64> = folds.iter().map(|m| number(m)).collect();
        let (value, (low, high)) = (number(model), jackknife(number(model), &others));
        let identified = low.is_finite() && low > 0.0;
        // None of these numbers can be negative.
        let low = if low.is_finite() { low.max(0.0) } else { low };
        let remark = match (low.is_finite(), identified) {
            (false, _) => no_interval(others.len()),
            (true, false) => "these logs do not determine it",
            (true, true) => "",
        };
        Parameter {
            name: name.into(),
            unit: unit.into(),
            value,
            low,
            high,
            identified,
            remark: remark.into(),
        }
    };
    numbers.into_iter().chain(warming).map(one).collect()
}

/// Name and unit of a number of an axis, and the number.
type AxisRow = (&'static str, String, fn(&Axis) -> f64);

/// Inertia, friction and spring of an axis, in units of far and near side.
fn axis_parameters(axis: &Axis, folds: &[&Axis], law: &MemoryLaw, model: &Model) -> Vec<Parameter> {
    let unit_of_signal = |signal: usize| match law.signals.get(signal) {
        Some(Signal::Input(input)) => unit_in(model, &model.inputs[*input].column),
        _ => String::new(),
    };
    let far = unit_in(model, &model.far);
    let rows: Vec<AxisRow> = match axis {
        Axis::Force(law) => {
            let near = law.position.map_or_else(String::new, unit_of_signal);
            let over =
                |suffix: &str| format!("{far}{suffix} per {}", if near.is_empty() { "unit" } else { &near });
            vec![
                ("inertia", over(" s^2"), |a| force_of(a, |law| law.mass)),
                ("viscous friction", over(" s"), |a| force_of(a, |law| law.damping)),
                ("dry friction", far.clone(), |a| {
                    force_of(a, |law| law.slips.iter().map(|slip| slip.force).sum())
                }),
                ("spring", over(""), |a| force_of(a, |law| law.stiffness)),
                ("constant force", far.clone(), |a| force_of(a, |law| law.offset)),
            ]
        }
        Axis::Motion(law) => {
            let force = unit_of_signal(law.force);
            vec![
                ("inertia", format!("{force} per far side and s"), |a| motion_of(a, |law| 1.0 / law.gain)),
                ("viscous friction over inertia", "1/s".to_owned(), |a| motion_of(a, |law| law.damping)),
                ("dry friction", force.clone(), |a| motion_of(a, |law| law.friction / law.gain.abs())),
                ("spring over inertia", "1/s^2".to_owned(), |a| motion_of(a, |law| law.stiffness)),
                ("constant force", force, |a| motion_of(a, |law| law.bias / law.gain)),
            ]
        }
    };
    let one = |(name, unit, number): (&str, String, fn(&Axis) -> f64)| {
        let others: Vec<f64> = folds.iter().map(|axis| number(axis)).collect();
        let value = number(axis);
        let (low, high) = jackknife(value, &others);
        let identified = low.is_finite() && low * high > 0.0;
        let remark = match (low.is_finite(), identified) {
            (false, _) => no_interval(others.len()),
            (true, false) => "these logs do not determine it",
            (true, true) => "",
        };
        Parameter { name: name.into(), unit, value, low, high, identified, remark: remark.into() }
    };
    rows.into_iter().map(one).collect()
}

fn force_of(axis: &Axis, of: impl Fn(&AxisForce) -> f64) -> f64 {
    if let Axis::Force(law) = axis { of(law) } else { f64::NAN }
}

fn motion_of(axis: &Axis, of: impl Fn(&AxisMotion) -> f64) -> f64 {
    if let Axis::Motion(law) = axis { of(law) } else { f64::NAN }
}

fn cell_parameters(model: &Model, law: &MemoryLaw, cell: &ClampCell, folds: &[&ClampCell]) -> Vec<Parameter> {
    let name_of = |signal: usize| signal_name(&law.signals[signal], model);
    let term_name = |term: &BasisTerm| match *term {
        BasisTerm::One => "constant".to_owned(),
        BasisTerm::Signal(i) => name_of(i),
        BasisTerm::Product(i, j) => format!("{} x {}", name_of(i), name_of(j)),
    };
    let units = Units::new(law, model);
    let parameter = |name: String, unit: String, value: f64, others: Vec<f64>| {
        let (low, high) = jackknife(value, &others);
        let crosses = low <= 0.0 && high >= 0.0;
        let known = low.is_finite();
        Parameter {
            name,
            unit,
            value,
            low,
            high,
            identified: known && !crosses,
            remark: if !known {
                no_interval(others.len()).to_owned()
            } else if crosses {
                "the folds do not agree on its sign: these logs do not determine it".to_owned()
            } else {
                String::new()
            },
        }
    };
    let mut parameters = Vec::new();
    for (k, term) in cell.basis.iter().enumerate() {
        let name = format!("lower bound, {}", term_name(term));
        let unit = units.of_bound(term);
        parameters.push(parameter(name, unit.clone(), cell.low[k], folds.iter().map(|c| c.low[k]).collect()));
        let name = format!("upper bound, {}", term_name(term));
        parameters.push(parameter(name, unit, cell.high[k], folds.iter().map(|c| c.high[k]).collect()));
    }
    for (k, &signal) in cell.elastic.iter().enumerate() {
        let name = format!("stiffness inside the band, {}", name_of(signal));
        let unit = units.of_stiffness(signal);
        parameters.push(parameter(name, unit, cell.kappa[k], folds.iter().map(|c| c.kappa[k]).collect()));
    }
    parameters
}

/// Units of the far side and of the signals of a law; empty where the name of a column states none.
struct Units {
    far: String,
    signals: Vec<String>,
}

impl Units {
    fn new(law: &MemoryLaw, model: &Model) -> Self {
        let of_input = |input: usize| unit_in(model, &model.inputs[input].column);
        let of_signal = |signal: &Signal| match *signal {
            Signal::Input(input) | Signal::Difference(input, _) => of_input(input),
            Signal::LogTension { .. } | Signal::LogRatio { .. } => "1".to_owned(),
        };
        Self { far: unit_in(model, &model.far), signals: law.signals.iter().map(of_signal).collect() }
    }

    /// Of the factor of a term in a bound.
    fn of_bound(&self, term: &BasisTerm) -> String {
        match *term {
            BasisTerm::One => self.ratio(&[]),
            BasisTerm::Signal(i) => self.ratio(&[i]),
            BasisTerm::Product(i, j) => self.ratio(&[i, j]),
        }
    }

    /// Of the far side's change per change of a signal.
    fn of_stiffness(&self, signal: usize) -> String {
        self.ratio(&[signal])
    }

    /// The far side's unit over those of the signals; words where one of them is unknown.
    fn ratio(&self, over: &[usize]) -> String {
        let mut below: Vec<&str> =
            over.iter().map(|&k| self.signals[k].as_str()).filter(|u| *u != "1").collect();
        if self.far.is_empty() || below.iter().any(|unit| unit.is_empty()) {
            return if over.is_empty() { "unit of the far side" } else { "far side per signal" }.to_owned();
        }
        let cancelled = below.iter().position(|unit| *unit == self.far);
        if let Some(place) = cancelled {
            below.remove(place);
        }
        let above = if cancelled.is_some() { "1" } else { &self.far };
        match below[..] {
            [] => above.to_owned(),
            [one] => format!("{above}/{one}"),
            _ => format!("{above}/({})", below.join(" ")),
        }
    }
}

/// Of a number that no fold changes.
pub(super) const NOT_FITTED: &str = "not fitted to these logs";

/// Fewest folds with an interval.
const FEWEST_FOLDS: usize = 3;

/// Why a number of so many folds has no interval.
fn no_interval(folds: usize) -> &'static str {
    if folds < FEWEST_FOLDS { "too few folds for an interval" } else { NOT_FITTED }
}

/// 95 % interval from delete-one-fold values; not a number with fewer than three, or where no fold changes
/// the value, because it was not fitted.
pub(super) fn jackknife(value: f64, folds: &[f64]) -> (f64, f64) {
    let n = folds.len() as f64;
    let is_fitted = folds.iter().any(|fold| fold.to_bits() != value.to_bits());
    if folds.len() < FEWEST_FOLDS || !is_fitted {
        return (f64::NAN, f64::NAN);
    }
    let mean = folds.iter().sum::<f64>() / n;
    let spread = folds.iter().map(|v| (v - mean) * (v - mean)).sum::<f64>();
    // Student's t at 97.5 % for n - 1 degrees of freedom, to 2 % from n = 3 on.
    let t = 1.96 + 2.5 / (n - 1.0) + 3.7 / ((n - 1.0) * (n - 1.0));
    let half = t * (spread * (n - 1.0) / n).sqrt();
    (value - half, value + half)
}

fn signal_name(signal: &Signal, model: &Model) -> String {
    let column = |i: usize| model.inputs[i].column.as_str();
    match *signal {
        Signal::Input(i) => column(i).to_owned(),
        Signal::Difference(i, j) => format!("{} - {}", column(i), column(j)),
        Signal::LogTension { input, .. } => format!("ln {}", column(input)),
        Signal::LogRatio { first, second, .. } => format!("ln({} / {})", column(first), column(second)),
    }
}

#[cfg(test)]
mod tests {
    use super::*;

    #[test]
    fn units_of_a_bound_are_those_that_make_it_a_far_signal() {
        let units = |far: &str, signals: &[&str]| Units {
            far: far.to_owned(),
            signals: signals.iter().map(|unit| (*unit).to_owned()).collect(),
        };
        let tension = units("N", &["m", "N", "1", "deg", ""]);
        assert_eq!(tension.of_bound(&BasisTerm::One), "N");
        assert_eq!(tension.of_bound(&BasisTerm::Signal(0)), "N/m");
        assert_eq!(tension.of_bound(&BasisTerm::Signal(1)), "1");
        assert_eq!(tension.of_bound(&BasisTerm::Signal(2)), "N");
        assert_eq!(tension.of_bound(&BasisTerm::Product(0, 3)), "N/(m deg)");
        assert_eq!(tension.of_bound(&BasisTerm::Product(1, 3)), "1/deg");
        assert_eq!(tension.of_stiffness(4), "far side per signal");
    }

    #[test]
    fn jackknife_intervals_are_those_of_a_mean() {
        // Delete-one means of 1, 2, 3, 4, 5: the standard error of their mean is sqrt(0.5).
        let values = [1.0, 2.0, 3.0, 4.0, 5.0];
        let folds: Vec<f64> = values.iter().map(|v| (15.0 - v) / 4.0).collect();
        let (low, high) = jackknife(3.0, &folds);
        let half = 2.776 * 0.5_f64.sqrt();
        assert!((high - 3.0 - half).abs() < 0.03 * half && (3.0 - low - half).abs() < 0.03 * half);
        assert!(jackknife(1.0, &[1.0, 2.0]).0.is_nan() && jackknife(1.0, &[1.0; 5]).0.is_nan());
    }
}
