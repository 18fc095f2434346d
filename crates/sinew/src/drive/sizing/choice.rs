use super::design::{Demand, Design, Limit, Requirement};
use crate::drive::{Catalogue, CatalogueMotor, CatalogueReducer, CatalogueWinch};
use crate::error::Error;
use alloc::vec::Vec;

/// The best design of a motor and a reducer of a catalogue.
#[derive(Debug, Clone, PartialEq)]
pub struct Choice<'a> {
    /// The motor.
    pub motor: &'a CatalogueMotor,
    /// The reducer.
    pub reducer: &'a CatalogueReducer,
    /// The winch, the best of the catalogue for these two.
    pub winch: &'a CatalogueWinch,
    /// Interval of ratios that meets the requirement with this winch, for a continuously variable ratio;
    /// `None` if empty.
    pub ratios: Option<[f64; 2]>,
    /// The assembled design with the reducer's best ratio.
    pub design: Design,
    /// Utilisation of its limits by the requirement.
    pub demand: Demand,
    /// Copper loss at the required tension and speed, W.
    pub copper_loss: f64,
}

/// Designs of every motor with every reducer that it can be put together with: first those that meet the
/// requirement, by mass and then by margin, then those that do not, by deficit.
///
/// The ratio and the winch of a pair are those with the largest margin to the nearest limit.
///
/// # Errors
/// As [`Requirement::validate`].
///
/// # Example
/// ```
/// use sinew::drive::{Catalogue, sizing::{Requirement, choose}};
/// let catalogue = Catalogue::built_in().expect("a file of this repository");
/// let desired = Requirement { tension: 250.0, speed: 0.14, acceleration: 3.0, stroke: 0.3 };
/// let best = &choose(&catalogue, &desired)?[0];
/// assert!(best.demand.is_met());
/// # Ok::<(), sinew::Error>(())
/// ```
pub fn choose<'a>(catalogue: &'a Catalogue, desired: &Requirement) -> Result<Vec<Choice<'a>>, Error> {
    desired.validate()?;
    let mut choices: Vec<Choice<'a>> = catalogue
        .motors
        .iter()
        .flat_map(|motor| catalogue.reducers.iter().map(move |reducer| (motor, reducer)))
        .filter(|(motor, reducer)| catalogue.is_pair(motor, reducer))
        .filter_map(|(motor, reducer)| best(catalogue, motor, reducer, desired))
        .collect();
    choices.sort_by(|a, b| {
        let (lack, spare) = (deficit(a).total_cmp(&deficit(b)), utilisation(a).total_cmp(&utilisation(b)));
        lack.then(a.design.mass.total_cmp(&b.design.mass)).then(spare)
    });
    Ok(choices)
}

fn best<'a>(
    catalogue: &'a Catalogue,
    motor: &'a CatalogueMotor,
    reducer: &'a CatalogueReducer,
    desired: &Requirement,
) -> Option<Choice<'a>> {
    let designs =
        catalogue.winches.iter().flat_map(|winch| reducer.ratios.iter().map(move |ratio| (winch, *ratio)));
    let choices = designs.map(|(winch, ratio)| {
        let design = Design::new(motor, reducer, ratio, winch.parameters);
        let (demand, copper_loss) = (design.demand(desired), design.copper_loss(desired));
        Choice { motor, reducer, winch, ratios: design.ratios(desired), design, demand, copper_loss }
    });
    choices.min_by(|a, b| utilisation(a).total_cmp(&utilisation(b)))
}

/// Utilisation of the nearest limit.
fn utilisation(choice: &Choice<'_>) -> f64 {
    choice.demand.worst().1
}

/// Utilisation above 1; equal for all designs that meet the requirement.
fn deficit(choice: &Choice<'_>) -> f64 {
    utilisation(choice).max(1.0)
}

impl Design {
    /// Interval of ratios in which a requirement is met, other parameters unchanged; `None` if empty.
    ///
    /// Each limit is `A n + B/n + C <= D` with `A, B >= 0`: an interval of ratios, closed form.
    #[must_use]
    pub fn ratios(&self, desired: &Requirement) -> Option<[f64; 2]> {
        let (m, r, arm) = (&self.motor, &self.reducer, self.arm());
        let fixed = [Limit::ReducerTorque, Limit::Drum];
        if self
            .demand(desired)
            .fractions
            .iter()
            .any(|(limit, fraction)| fixed.contains(limit) && *fraction > 1.0)
        {
            return None;
        }
        let load = desired.tension * arm / r.efficiency;
        let grease = r.viscous * desired.speed / arm;
        let moving = grease + m.inertia * desired.acceleration / arm;
        let hot = m.resistance_at(m.hottest) / m.torque_constant;
        let back = m.torque_constant * desired.speed / arm;
        let limits = [
            interval(grease, load, m.torque_constant * self.continuous_current() - r.friction),
            interval(moving, load, m.torque_constant * m.peak_current - r.friction),
            interval(hot * moving + back, hot * load, m.voltage - hot * r.friction),
            interval(desired.speed / arm, 0.0, self.top_speed),
        ];
        let [low, high] = limits.into_iter().try_fold([1.0, f64::INFINITY], |[low, high], limit| {
            limit.map(|[from, to]| [f64::max(low, from), f64::min(high, to)])
        })?;
        (low <= high).then_some([low, high])
    }
}

/// Where `a n + b/n <= d` for n > 0: between the roots of `a n^2 - d n + b`.
fn interval(a: f64, b: f64, d: f64) -> Option<[f64; 2]> {
    let under = d * d - 4.0 * a * b;
    if d <= 0.0 || under < 0.0 {
        return None;
    }
    let sum = d + libm::sqrt(under);
    let high = if a > 0.0 { 0.5 * sum / a } else { f64::INFINITY };
    Some([2.0 * b / sum, high])
}

#[cfg(test)]
mod tests {
    use super::*;

    #[test]
    fn an_interval_of_ratios_is_where_its_limit_holds() {
        for (a, b, d) in [
            (0.0, 0.0, 1.0),
            (0.0, 3.0, 2.0),
            (0.5, 0.0, 2.0),
            (0.5, 1.0, 2.0),
            (2.0, 3.0, 8.0),
            // Touched in one ratio, and nowhere.
            (1.0, 1.0, 2.0),
            (2.0, 3.0, 4.0),
            (0.0, 1.0, -1.0),
            (1.0, 1.0, -4.0),
        ] {
            let found = interval(a, b, d);
            // Sixteenths: exact, the ratio 1 included.
            let holds = |n: f64| a * n + b / n <= d;
            let ratios = (1..2000).map(|k| f64::from(k) / 16.0);
            assert_eq!(found.is_some(), ratios.clone().any(holds), "{a} {b} {d}");
            for n in ratios {
                let inside = found.is_some_and(|[low, high]| low <= n && n <= high);
                assert_eq!(inside, holds(n), "{a} n + {b}/n <= {d} at {n}: {found:?}");
            }
        }
    }
}
