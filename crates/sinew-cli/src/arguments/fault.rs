//! The value of `--fault`: `COMPONENT:NAME[:MODE]@START[+DURATION]`.

use sinew::twin::arm::{ExchangeFailure, SensorFailure, Worn};
use std::str::FromStr;

/// A fault to inject, not yet resolved to a muscle or joint of a robot.
#[derive(Debug, Clone, PartialEq)]
pub(crate) struct FaultArgument {
    /// What was written, for errors.
    pub(crate) text: String,
    pub(crate) component: Component,
    /// Name of the muscle or joint; of the failure for `cycles`.
    pub(crate) name: String,
    /// Start, s from the start of the run.
    pub(crate) start_s: f64,
    /// Duration, s; infinite for a permanent fault.
    pub(crate) duration_s: f64,
}

/// What a page offers of it for a muscle, without its time: as written here, `{}` being the muscle's name,
/// and in words.
pub(crate) const OFFERED: [(&str, &str); 10] = [
    ("load-cell:{}:lost", "load cell gives no value"),
    ("load-cell:{}:stuck", "load cell is stuck"),
    ("motor-encoder:{}:lost", "motor encoder gives no value"),
    ("motor-encoder:{}:stuck", "motor encoder is stuck"),
    ("drive:{}", "drive has no power"),
    ("winch:{}", "winch is jammed"),
    ("cable:{}", "cable breaks"),
    ("friction:{}:100", "friction doubles"),
    ("pretension:{}:50", "half of the pretension is lost"),
    ("stiffness:{}:17", "a strand of seven breaks"),
];

/// The component that fails; sensors with their failure mode.
#[derive(Debug, Clone, Copy, PartialEq)]
pub(crate) enum Component {
    Cable,
    Drive,
    Winch,
    MotorEncoder(SensorFailure),
    LoadCell(SensorFailure),
    JointEncoder(SensorFailure),
    /// An external torque, Nm, or force, N, on a joint.
    Push(f64),
    /// Wear of a cable: relative change at the end of the duration, 1, in [0, 1].
    Wear(Worn, f64),
    Exchange(ExchangeFailure),
}

/// What was expected in place of the part of `--fault` that cannot be parsed.
#[derive(Debug, Clone, Copy, PartialEq, Eq, thiserror::Error)]
#[error("expected {0}")]
pub(crate) struct FaultSyntaxError(&'static str);

impl FromStr for FaultArgument {
    type Err = FaultSyntaxError;

    fn from_str(text: &str) -> Result<Self, FaultSyntaxError> {
        let expected = FaultSyntaxError;
        let (what, when) =
            text.split_once('@').ok_or(expected("COMPONENT:NAME@START, for example cable:brachialis@5"))?;
        let (start, duration) = match when.split_once('+') {
            Some((start, duration)) => (start, Some(duration)),
            None => (when, None),
        };
        let start_s = seconds(start).ok_or(expected("a time of at least 0 s after @"))?;
        let duration_s = match duration {
            None => f64::INFINITY,
            Some(text) => {
                seconds(text).filter(|s| *s > 0.0).ok_or(expected("a duration above 0 s after +"))?
            }
        };
        let words: Vec<&str> = what.split(':').collect();
        let (component, name, mode) = match *words.as_slice() {
            [component, name] => (component, name, None),
            [component, name, mode] => (component, name, Some(mode)),
            _ => return Err(expected("COMPONENT:NAME or COMPONENT:NAME:MODE before @")),
        };
        let component = match (component, name, mode) {
            ("cycles", "lost", None) => Component::Exchange(ExchangeFailure::Lost),
            ("cycles", "late", None) => Component::Exchange(ExchangeFailure::Late),
            ("cycles", "stale", None) => Component::Exchange(ExchangeFailure::Stale),
            _ => Component::parse(component, mode)?,
        };
        Ok(Self { text: text.to_owned(), component, name: name.to_owned(), start_s, duration_s })
    }
}

impl Component {
    fn parse(name: &str, mode: Option<&str>) -> Result<Self, FaultSyntaxError> {
        match (name, mode) {
            ("cable", None) => Ok(Self::Cable),
            ("drive", None) => Ok(Self::Drive),
            ("winch", None) => Ok(Self::Winch),
            ("motor-encoder", mode) => Ok(Self::MotorEncoder(sensor_failure(mode)?)),
            ("load-cell", mode) => Ok(Self::LoadCell(sensor_failure(mode)?)),
            ("joint-encoder", mode) => Ok(Self::JointEncoder(sensor_failure(mode)?)),
            ("push", mode) => Ok(Self::Push(amount(mode, "push:JOINT:NM, a torque or force")?)),
            ("friction", mode) => Ok(Self::Wear(Worn::Friction, fraction(mode)?)),
            ("pretension", mode) => Ok(Self::Wear(Worn::Pretension, fraction(mode)?)),
            ("stiffness", mode) => Ok(Self::Wear(Worn::Stiffness, fraction(mode)?)),
            ("cycles", None) => Err(FaultSyntaxError("cycles:lost, cycles:late or cycles:stale")),
            ("cable" | "drive" | "winch" | "cycles", Some(_)) => Err(FaultSyntaxError(
                "no MODE, which only sensors, push, friction, pretension and stiffness have",
            )),
            _ => Err(FaultSyntaxError(
                "cable, drive, winch, motor-encoder, load-cell, joint-encoder, push, friction, pretension, \
                    stiffness or cycles before the first `:`",
            )),
        }
    }
}

/// A finite number.
fn amount(mode: Option<&str>, expected: &'static str) -> Result<f64, FaultSyntaxError> {
    let number = mode.and_then(|text| text.parse().ok()).filter(|number: &f64| number.is_finite());
    number.ok_or(FaultSyntaxError(expected))
}

/// A fraction of wear, in per cent.
fn fraction(mode: Option<&str>) -> Result<f64, FaultSyntaxError> {
    let expected = "a number from 0 to 100 (per cent) after the name of the muscle";
    amount(mode, expected).and_then(|percent| {
        if (0.0..=100.0).contains(&percent) { Ok(0.01 * percent) } else { Err(FaultSyntaxError(expected)) }
    })
}

const SENSOR_MODES: &str = "stuck, lost, nan, jump=X, gain=X, drift=X (per s), saturation=X or noise=X \
    after the name of a sensor's muscle or joint";

fn sensor_failure(mode: Option<&str>) -> Result<SensorFailure, FaultSyntaxError> {
    let sized = |text: &str| {
        let (what, size) = text.split_once('=').unwrap_or((text, ""));
        let failure = match what {
            "jump" => SensorFailure::Offset,
            "gain" => SensorFailure::Gain,
            "drift" => SensorFailure::Drift,
            "saturation" => SensorFailure::Saturation,
            "noise" => SensorFailure::Noise,
            _ => return Err(FaultSyntaxError(SENSOR_MODES)),
        };
        amount(Some(size), SENSOR_MODES).map(failure)
    };
    match mode {
        Some("stuck") => Ok(SensorFailure::Stuck),
        Some("lost") => Ok(SensorFailure::Lost),
        Some("nan") => Ok(SensorFailure::NotANumber),
        Some(other) => sized(other),
        None => Err(FaultSyntaxError(SENSOR_MODES)),
    }
}

fn seconds(text: &str) -> Option<f64> {
    text.parse().ok().filter(|time: &f64| time.is_finite() && *time >= 0.0)
}

#[cfg(test)]
mod tests {
    use super::*;

    #[test]
    fn a_fault_has_a_component_a_name_a_start_and_an_optional_mode_and_duration() {
        let fault: FaultArgument = "load-cell:triceps:lost@4.5+0.25".parse().unwrap();
        assert_eq!(fault.component, Component::LoadCell(SensorFailure::Lost));
        assert_eq!((fault.name.as_str(), fault.start_s, fault.duration_s), ("triceps", 4.5, 0.25));
        let fault: FaultArgument = "cable:triceps@6".parse().unwrap();
        assert!(fault.component == Component::Cable && fault.duration_s.is_infinite());
        let fault: FaultArgument = "joint-encoder:elbow:jump=-0.2@6".parse().unwrap();
        assert_eq!(fault.component, Component::JointEncoder(SensorFailure::Offset(-0.2)));
        let fault: FaultArgument = "friction:triceps:20@0+3600".parse().unwrap();
        assert_eq!(fault.component, Component::Wear(Worn::Friction, 0.2));
        let fault: FaultArgument = "cycles:lost@3+0.01".parse().unwrap();
        assert_eq!(fault.component, Component::Exchange(ExchangeFailure::Lost));
        let fault: FaultArgument = "push:elbow:-4@3+1".parse().unwrap();
        assert_eq!(fault.component, Component::Push(-4.0));
        for text in ["push:elbow@3", "friction:triceps:120@3", "cycles:gone@3", "cable:triceps:lost@3"] {
            assert!(text.parse::<FaultArgument>().is_err(), "{text}");
        }
    }
}
