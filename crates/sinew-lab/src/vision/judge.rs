use super::calibration::{CalibratedJoint, CalibratedParameter, Calibration, ErrorRange, HeldOut, Reported};
use crate::Error;
use sinew::machine::{Machine, Marker};
use sinew_identify::geometry::{
    Estimate, Frame, GeometryModel, Place, PointError, Readings, estimate, places, speed_delay, travel_ratio,
};

/// An estimate with its errors in poses that it has not seen.
#[derive(Debug, Clone)]
pub struct Judgement {
    /// The parameters as found.
    pub estimate: Estimate,
    /// All places, and whether each only judged.
    pub places: Vec<Place>,
    /// See `places`.
    pub held: Vec<bool>,
    /// Errors in the poses that only judged.
    pub held_out: HeldOut,
    /// Stamps of the camera minus the clock of the readings, s, and its standard deviation.
    pub delay: (f64, f64),
    /// What is wrong with the observations, in sentences.
    pub findings: Vec<String>,
    joints: Vec<CalibratedJoint>,
    /// Whether places scatter about the estimate as those of a camera do.
    agrees: bool,
}

/// Scatter of the places about the estimate above which no camera explains it: this, and a fraction of the
/// machine's reach, m.
const LARGEST_SCATTER_M: f64 = 1e-3;
const LARGEST_SCATTER: f64 = 0.01;
/// Fraction of a marker's points that may be far off before it is named.
const MANY_OUTLIERS: f64 = 0.3;
/// Fraction of the error before above which an estimate has found little.
const LITTLE_GAIN: f64 = 0.8;
/// Ratio of what the markers travel to what the machine says above which lengths are in another unit.
const OTHER_UNIT: f64 = 5.0;
/// What is known of the two clocks, s.
const DELAY_TOLERANCE_S: f64 = 2.0;

/// Estimates the geometry of a machine, as designed with its payload, from places that do not judge, and
/// judges it by the others; `judges` tells which they are by number of the place, of how many, and its
/// readings.
///
/// # Errors
/// [`Error::Geometry`] for observations that cannot be those of the machine; [`Error::Experiment`] where no
/// place judges.
pub fn judge(
    machine: &Machine,
    markers: &[Marker],
    (readings, frames): (&Readings, &[Frame]),
    judges: impl Fn(usize, usize, &[f64]) -> bool,
) -> Result<Judgement, Error> {
    let first = GeometryModel::new(machine, markers, 1)?;
    let delay = speed_delay(&first, readings, frames)?;
    check_unit(&first, readings, frames)?;
    let all = places(&first, readings, frames, delay)?;
    let epochs = 1 + all.iter().map(|place| place.epoch).max().unwrap_or(0);
    let model = GeometryModel::new(machine, markers, epochs)?;
    let held: Vec<bool> =
        all.iter().enumerate().map(|(k, place)| judges(k, all.len(), &place.reading)).collect();
    let of = |wanted: bool| -> Vec<Place> {
        all.iter().zip(&held).filter(|(_, held)| **held == wanted).map(|(place, _)| place.clone()).collect()
    };
    let (fitted, judged) = (of(false), of(true));
    if judged.is_empty() || fitted.len() < 4 {
        let got = format!("{} and {}", fitted.len(), judged.len());
        return Err(Error::experiment("places", "at least 4 to estimate from and 1 to judge by", &got));
    }
    let found = estimate(&model, &fitted)?;
    let moving = |errors: Vec<PointError>| -> Vec<PointError> {
        errors.into_iter().filter(|point| machine.moves(markers[point.marker].body)).collect()
    };
    let before = moving(found.errors(&model, &judged, true)?);
    let after = moving(found.errors(&model, &judged, false)?);
    if after.is_empty() {
        return Err(Error::experiment("places that judge", "a marker of the machine seen in one", &"none"));
    }
    let range = |points: &[PointError]| ErrorRange {
        mean: points.iter().map(|point| point.error).sum::<f64>() / points.len() as f64,
        max: points.iter().map(|point| point.error).fold(0.0, f64::max),
    };
    let reported =
        Reported { mean: after.iter().map(|point| point.expected).sum::<f64>() / after.len() as f64 };
    let held_out = HeldOut { before: range(&before), after: range(&after), reported };
    let delay = found.delay(&model, readings, frames, (delay, &all))?;
    let names = machine.robot.parts().joints.iter().map(|joint| joint.name.clone());
    let joints = names.zip(model.corrections(&found.theta)).map(|(name, at)| CalibratedJoint {
        name,
        offset_m: at.displacement.offset,
        tilt_rad: at.displacement.tilt,
        zero: at.zero,
        flex_rad_per_nm: at.flex,
    });
    let joints = joints.collect();
    let mut findings = findings(&found, markers, &all, &fitted);
    let scatter = found.noise.into_iter().fold(0.0, f64::max);
    let agrees = scatter <= LARGEST_SCATTER_M + LARGEST_SCATTER * 0.5 * machine.size();
    if !agrees {
        findings.push(format!(
            "places scatter by {:.1} mm about the estimate, which no camera does: look at the places of the \
             markers on the bodies and on the base, at their names in the files, and at the unit",
            1e3 * scatter
        ));
    }
    let HeldOut { before, after, .. } = held_out;
    if after.mean < before.mean && after.mean > LITTLE_GAIN * before.mean {
        findings.push(format!(
            "poses that the estimate has not seen became better by {:.0} % only: where the machine is built less \
             accurately than its tolerances say, wider ones find more",
            100.0 * (1.0 - after.mean / before.mean)
        ));
    }
    Ok(Judgement { estimate: found, places: all, held, held_out, delay, findings, joints, agrees })
}

/// Refuses observations whose markers travel many times as far as the machine moves them.
fn check_unit(model: &GeometryModel, readings: &Readings, frames: &[Frame]) -> Result<(), Error> {
    let Some(ratio) = travel_ratio(model, readings, frames)? else { return Ok(()) };
    if (1.0 / OTHER_UNIT..=OTHER_UNIT).contains(&ratio) {
        return Ok(());
    }
    let expected = "markers that travel as far as the machine moves them; the unit of the observations is m where \
                    nothing states another";
    Err(Error::experiment("observations", expected, &format!("{ratio:.3} times as far")))
}

/// What is wrong with the observations.
fn findings(found: &Estimate, markers: &[Marker], all: &[Place], fitted: &[Place]) -> Vec<String> {
    let mut text = Vec::new();
    for pair in all.windows(2).filter(|pair| pair[0].epoch != pair[1].epoch) {
        text.push(format!(
            "the camera was moved between {:.1} and {:.1} s",
            pair[0].time[1], pair[1].time[0]
        ));
    }
    for (m, marker) in markers.iter().enumerate() {
        let seen = fitted.iter().flat_map(|place| &place.seen).filter(|seen| seen.marker == m).count();
        let off = found.outliers.iter().filter(|(_, marker)| *marker == m).count();
        if seen == 0 {
            text.push(format!("marker {} was never seen at rest", marker.name));
        } else if off as f64 > MANY_OUTLIERS * seen as f64 {
            text.push(format!(
                "marker {}: {off} of {seen} places do not agree: exchanged or loose",
                marker.name
            ));
        }
    }
    if !markers.iter().any(|marker| marker.body == 0) {
        text.push(
            "no marker on the base: the camera's place and the first joint's frame are one unknown"
                .to_owned(),
        );
    }
    text
}

impl Judgement {
    /// Whether poses that the estimate has not seen have become better, and the observations are those of a
    /// camera that sees this machine.
    #[must_use]
    pub fn is_better(&self) -> bool {
        self.agrees && self.held_out.after.mean < self.held_out.before.mean
    }

    /// `use`, `use with care` or `do not use`.
    #[must_use]
    pub fn verdict(&self) -> &'static str {
        let HeldOut { after, reported, .. } = self.held_out;
        if !self.is_better() {
            "do not use"
        } else if after.mean > 2.0 * reported.mean || !self.findings.is_empty() {
            "use with care"
        } else {
            "use"
        }
    }

    /// All parameters, the delay of the camera as the last.
    #[must_use]
    pub fn parameters(&self) -> Vec<CalibratedParameter> {
        let known = self.estimate.findings.iter().map(|finding| CalibratedParameter {
            name: finding.name.clone(),
            value: finding.value,
            sd: finding.sd,
            tolerance: Some(finding.tolerance).filter(|tolerance| tolerance.is_finite()),
            determined: finding.determined,
        });
        let (value, sd) = self.delay;
        let (name, tolerance) = ("camera.delay_s".to_owned(), DELAY_TOLERANCE_S);
        let (sd, determined) = (sd.min(tolerance), sd < 0.5 * tolerance);
        known
            .chain([CalibratedParameter { name, value, sd, tolerance: Some(tolerance), determined }])
            .collect()
    }

    /// As a file.
    #[must_use]
    pub fn calibration(&self, machine: &Machine, hash: String, simulated: bool) -> Calibration {
        Calibration {
            version: Calibration::VERSION,
            machine: machine.robot.parts().name.clone(),
            machine_hash: hash,
            simulated,
            recommendation: Some(self.verdict().to_owned()),
            held_out_error_m: Some(self.held_out),
            held_out: None,
            joint: self.joints.clone(),
            site: Vec::new(),
            wrap: Vec::new(),
            body: Vec::new(),
            parameter: self.parameters(),
        }
    }
}
