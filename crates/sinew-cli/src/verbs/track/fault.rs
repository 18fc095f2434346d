//! What is to fail in a run: `WHAT:NAME[:HOW]@TIME[+SECONDS]`.

use crate::error::Error;
use sinew::body::Robot;
use sinew::twin::arm::{Failure, InjectedFault, Sensor, SensorFailure};

/// All of them, checked against the robot.
pub(super) fn wanted(given: &[String], robot: &Robot) -> Result<Vec<InjectedFault>, Error> {
    given.iter().map(|text| one(text, robot)).collect()
}

fn one(text: &str, robot: &Robot) -> Result<InjectedFault, Error> {
    let refuse = |expected| Error::Argument { flag: "--fault", value: text.to_owned(), expected };
    let (what, when) = text.split_once('@').ok_or_else(|| refuse("WHAT:NAME@TIME, as cable:brachialis@5"))?;
    let (from, lasting) = when.split_once('+').map_or((when, None), |(from, lasting)| (from, Some(lasting)));
    let from = seconds(from).ok_or_else(|| refuse("a time of at least 0 s after @"))?;
    let lasting = match lasting {
        None => f64::INFINITY,
        Some(text) => seconds(text)
            .filter(|lasting| *lasting > 0.0)
            .ok_or_else(|| refuse("a duration above 0 s after +"))?,
    };
    let mut words = what.split(':');
    let (kind, name, how) = (words.next().unwrap_or(""), words.next().unwrap_or(""), words.next());
    if words.next().is_some() {
        return Err(refuse("WHAT:NAME or WHAT:NAME:HOW before @"));
    }
    let parts = robot.parts();
    let muscle = || {
        let place = parts.tendons.iter().position(|tendon| tendon.name == name);
        place.ok_or_else(|| refuse("the name of a muscle after WHAT: (see sinew arm inspect)"))
    };
    let joint = || {
        let named =
            |k: &usize| robot.joint_of_velocity(*k).is_some_and(|joint| parts.joints[joint].name == name);
        (0..robot.nv())
            .find(named)
            .ok_or_else(|| refuse("the name of a joint after WHAT: (see sinew arm inspect)"))
    };
    let sensor = |sensor| {
        let how = match how {
            Some("stuck") => SensorFailure::Stuck,
            Some("lost") => SensorFailure::Lost,
            Some("nan") => SensorFailure::NotANumber,
            _ => return Err(refuse("stuck, lost or nan after the name of a sensor")),
        };
        Ok(Failure::Sensor(sensor, how))
    };
    let whole =
        |failure| if how.is_none() { Ok(failure) } else { Err(refuse("no HOW, which is of sensors")) };
    let what = match kind {
        "cable" => whole(Failure::Cable(muscle()?)),
        "drive" => whole(Failure::Amplifier(muscle()?)),
        "winch" => whole(Failure::Winch(muscle()?)),
        "motor-encoder" => sensor(Sensor::Motor(muscle()?)),
        "load-cell" => sensor(Sensor::Tension(muscle()?)),
        "joint-encoder" => sensor(Sensor::Joint(joint()?)),
        _ => Err(refuse("cable, drive, winch, motor-encoder, load-cell or joint-encoder")),
    }?;
    Ok(InjectedFault { start: from, duration: lasting, failure: what })
}

fn seconds(text: &str) -> Option<f64> {
    text.parse().ok().filter(|time: &f64| time.is_finite() && *time >= 0.0)
}
