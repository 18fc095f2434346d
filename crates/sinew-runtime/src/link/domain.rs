use crate::Error;
use sinew::machine::{Machine, Task};
use sinew::random::EvenPoints;
use sinew::trajectory::online::{EndPointStep, MuscleLengthStep};
use sinew_link::host::Domain;

/// Poses in which the lengths of the muscles and the end point are looked at.
const POSES: usize = 500;
/// Fraction by which what was found in them is widened at both ends.
const MARGIN: f64 = 0.1;

/// What set-points a machine accepts: joints within `ranges`, tensions within `tension`, lengths and end
/// points as in poses within the ranges, and a tenth more.
///
/// # Shapes
/// `ranges: [joints]`, rad or m, finite; `tension: [muscles]`, N.
///
/// # Errors
/// As [`EndPointStep::new`] and [`MuscleLengthStep::new`].
pub fn domain(
    name: &str,
    machine: &Machine,
    ranges: &[[f64; 2]],
    tension: &[[f64; 2]],
) -> Result<Domain, Error> {
    let mut muscles = MuscleLengthStep::new(&machine.robot, ranges)?;
    let mut end_point = match machine.task {
        Task::EndPoint { site, axes } => {
            Some(EndPointStep::new(&machine.robot, &machine.redundancy, site, axes, ranges)?)
        }
        Task::Joints => None,
    };
    let none = [f64::INFINITY, f64::NEG_INFINITY];
    let (mut lengths, mut points) = (vec![none; tension.len()], [none; 3]);
    let mut even = EvenPoints::new(ranges.len());
    for _ in 0..POSES {
        let unit = even.next().unwrap_or_default();
        let pose: Vec<f64> =
            ranges.iter().zip(&unit).map(|([low, high], fraction)| low + fraction * (high - low)).collect();
        widen(&mut lengths, muscles.lengths(&pose)?);
        if let Some(end_point) = &mut end_point {
            widen(&mut points, &end_point.position(&pose)?);
        }
    }
    let wider = |[low, high]: [f64; 2]| [low - MARGIN * (high - low), high + MARGIN * (high - low)];
    Ok(Domain {
        name: name.to_owned(),
        joint: ranges.to_vec(),
        muscle_length: lengths.into_iter().map(wider).collect(),
        tension: tension.to_vec(),
        end_point: end_point.is_some().then(|| points.map(wider)),
    })
}

fn widen(ranges: &mut [[f64; 2]], numbers: &[f64]) {
    for ([low, high], number) in ranges.iter_mut().zip(numbers) {
        (*low, *high) = (low.min(*number), high.max(*number));
    }
}
