//! What a machine finds out about itself without a camera: equivalent routes of its muscles, then its loads.

use super::calibration::{
    CalibratedBody, CalibratedParameter, CalibratedSite, CalibratedWrap, Calibration, ErrorRange,
    HeldOutCables, Missed,
};
use crate::Error;
use sinew::body::Parts;
use sinew::machine::Machine;
use sinew_identify::geometry::{
    CableReadings, GeometryModel, LoadModel, LoadPart, Readings, Rest, RouteModel, RoutePart, rests,
};

/// Routes and loads with what is missed at places that only judged.
#[derive(Debug, Clone)]
pub struct CableJudgement {
    /// Errors at the places that only judged.
    pub held_out: HeldOutCables,
    /// All parameters; those of muscles that were not better have the value 0 and their tolerance.
    pub parameters: Vec<CalibratedParameter>,
    /// Sentences on what was left as designed.
    pub findings: Vec<String>,
    /// Numbers of places to estimate from, and of those that judged.
    pub places: [usize; 2],
    /// As calibrated.
    parts: Parts,
}

/// Fewest places to estimate from.
const FEWEST: usize = 8;

/// Estimates the routes of the muscles from places at rest that do not judge, then the loads by these routes.
/// A muscle whose lengths in the others are not better keeps its designed route, and all bodies their loads
/// where torques are not better.
///
/// # Errors
/// [`Error::Geometry`] for readings that determine nothing; [`Error::Experiment`] for too few places, and for
/// a machine with a payload, whose mass would be part of a body.
pub fn judge_cables(
    machine: &Machine,
    readings: &Readings,
    cables: &CableReadings,
    judges: impl Fn(usize, &[f64]) -> bool,
) -> Result<CableJudgement, Error> {
    if machine.payload > 0.0 {
        return Err(Error::experiment("payload of the machine", "none without a camera", &machine.payload));
    }
    let places = rests(&GeometryModel::new(machine, &machine.default_markers(), 1)?, readings, cables)?;
    let (mut fitted, mut judged) = (Vec::new(), Vec::new());
    for (k, place) in places.into_iter().enumerate() {
        if judges(k, &place.joint) { judged.push(place) } else { fitted.push(place) }
    }
    if fitted.len() < FEWEST || judged.is_empty() {
        let got = format!("{} and {}", fitted.len(), judged.len());
        let expected = "at least 8 at rest to estimate from and 1 to judge by";
        return Err(Error::experiment("places", expected, &got));
    }
    let model = RouteModel::new(machine);
    let n = model.route().len();
    let missed = |free: &[bool]| -> Result<_, Error> {
        let found = model.estimate(&fitted, free)?;
        let errors = model.errors(&found, &judged)?;
        Ok((found, errors))
    };
    let (designed, before) = missed(&vec![false; n])?;
    let (_, all) = missed(&vec![true; n])?;
    let worse: Vec<usize> = (0..machine.muscles.len())
        .filter(|&muscle| square(&all, muscle) >= square(&before, muscle))
        .collect();
    let free: Vec<bool> = (0..n).map(|part| !worse.iter().any(|muscle| model.is_of(part, *muscle))).collect();
    let (mut routes, mut after) = missed(&free)?;
    let mut findings = Vec::new();
    if range(&after, root_mean_square).mean >= range(&before, root_mean_square).mean {
        (routes, after) = (designed, before.clone());
        findings.push("no route is better than that of the design".to_owned());
    } else if !worse.is_empty() {
        let names = &machine.robot.parts().tendons;
        let names: Vec<&str> = worse.iter().map(|muscle| names[*muscle].name.as_str()).collect();
        findings.push(format!("as designed, because its lengths are not better: {}", names.join(", ")));
    }
    let length_m =
        Missed { before: range(&before, root_mean_square), after: range(&after, root_mean_square) };

    let none = |loads: &LoadModel| vec![0.0; loads.loads().len()];
    let drawn = LoadModel::new(machine, machine.robot.parts().clone());
    let loads = LoadModel::new(machine, model.with(&routes.value));
    let found = loads.estimate(&fitted)?;
    let torques = |of: &LoadModel, value: &[f64], at: &[Rest]| -> Result<ErrorRange, Error> {
        Ok(range(&of.errors(value, at)?, norm))
    };
    let before = torques(&drawn, &none(&drawn), &judged)?;
    let routed = torques(&loads, &none(&loads), &judged)?;
    let loaded = torques(&loads, &found.value, &judged)?;
    let is_loaded = loaded.mean < routed.mean;
    if !is_loaded {
        findings.push("masses are as designed, because torques are not better".to_owned());
    }
    let torque_nm = Missed { before, after: if is_loaded { loaded } else { routed } };
    let value = if is_loaded { found.value.clone() } else { none(&loads) };

    let parts = loads.with(&value);
    let known = |name: String, (value, sd): (f64, f64), tolerance: f64| CalibratedParameter {
        name,
        value,
        sd,
        tolerance: Some(tolerance),
        determined: sd < 0.5 * tolerance,
    };
    let mut parameters = Vec::new();
    for (k, part) in model.route().iter().enumerate() {
        let name = match *part {
            RoutePart::Site(site, axis) => format!("{}.position_{}_m", parts.sites[site].name, AXES[axis]),
            RoutePart::Radius(wrap) => format!("{}.radius_m", parts.wraps[wrap].name),
        };
        let tolerance = model.tolerance()[k];
        let sd = if routes.sd[k] > 0.0 { routes.sd[k] } else { tolerance };
        parameters.push(known(name, (routes.value[k], sd), tolerance));
    }
    for (k, load) in loads.loads().iter().enumerate() {
        let name = match *load {
            LoadPart::Mass(body) => format!("{}.mass_kg", parts.bodies[body].name),
            LoadPart::Center(body, axis) => {
                format!("{}.center_of_mass_{}_m", parts.bodies[body].name, AXES[axis])
            }
        };
        let tolerance = loads.tolerance()[k];
        let sd = if is_loaded { found.sd[k] } else { tolerance };
        parameters.push(known(name, (value[k], sd), tolerance));
    }
    let held_out = HeldOutCables { length_m, torque_nm };
    Ok(CableJudgement { held_out, parameters, findings, places: [fitted.len(), judged.len()], parts })
}

const AXES: [char; 3] = ['x', 'y', 'z'];

fn square(errors: &[Vec<f64>], muscle: usize) -> f64 {
    errors.iter().map(|row| row[muscle].powi(2)).sum()
}

/// Root mean square over the muscles of a place.
fn root_mean_square(row: &[f64]) -> f64 {
    norm(row) / (row.len() as f64).sqrt()
}

fn norm(row: &[f64]) -> f64 {
    row.iter().map(|x| x * x).sum::<f64>().sqrt()
}

fn range(errors: &[Vec<f64>], of: fn(&[f64]) -> f64) -> ErrorRange {
    let all = || errors.iter().map(|row| of(row));
    ErrorRange { mean: all().sum::<f64>() / errors.len() as f64, max: all().fold(0.0, f64::max) }
}

impl CableJudgement {
    /// Whether lengths and torques at places that the estimate has not seen have become better.
    #[must_use]
    pub fn is_better(&self) -> bool {
        let HeldOutCables { length_m, torque_nm } = self.held_out;
        [length_m, torque_nm].iter().all(|missed| missed.after.mean < missed.before.mean)
    }

    /// `use`, `use with care` or `do not use`.
    #[must_use]
    pub fn verdict(&self) -> &'static str {
        match (self.is_better(), self.findings.is_empty()) {
            (false, _) => "do not use",
            (true, false) => "use with care",
            (true, true) => "use",
        }
    }

    /// As a file.
    #[must_use]
    pub fn calibration(&self, machine: &Machine, hash: String, simulated: bool) -> Calibration {
        let designed = machine.robot.parts();
        let sites = self.parts.sites.iter().zip(&designed.sites).enumerate().filter(|(_, (a, b))| a != b);
        let wraps = self.parts.wraps.iter().zip(&designed.wraps).enumerate().filter(|(_, (a, b))| a != b);
        let bodies = self.parts.bodies.iter().zip(&designed.bodies).enumerate().filter(|(_, (a, b))| a != b);
        Calibration {
            version: Calibration::VERSION,
            machine: designed.name.clone(),
            machine_hash: hash,
            simulated,
            recommendation: Some(self.verdict().to_owned()),
            held_out_error_m: None,
            held_out: Some(self.held_out),
            joint: Vec::new(),
            site: sites
                .map(|(index, (site, _))| CalibratedSite {
                    index,
                    name: site.name.clone(),
                    position_m: site.position,
                })
                .collect(),
            wrap: wraps
                .map(|(index, (wrap, _))| CalibratedWrap {
                    index,
                    name: wrap.name.clone(),
                    radius_m: wrap.radius,
                })
                .collect(),
            body: bodies
                .map(|(index, (body, _))| CalibratedBody {
                    index,
                    name: body.name.clone(),
                    mass_kg: body.mass,
                    center_of_mass_m: body.center_of_mass,
                })
                .collect(),
            parameter: self.parameters.clone(),
        }
    }
}
