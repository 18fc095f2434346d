//! The value of `--fault`: `COMPONENT:NAME[:MODE]@START[+DURATION]`.

use sinew::twin::arm::SensorFailure;
use std::str::FromStr;

/// A fault to inject, not yet resolved to a muscle or joint of a robot.
#[derive(Debug, Clone, PartialEq)]
pub(crate) struct FaultArgument {
    /// As written.
    pub(crate) text: String,
    pub(crate) component: Component,
    /// Of the muscle or joint.
    pub(crate) name: String,
    /// Since the start of the run, s.
    pub(crate) start_s: f64,
    /// s; infinite for a permanent fault.
    pub(crate) duration_s: f64,
}

/// The component that fails; sensors with their failure mode.
#[derive(Debug, Clone, Copy, PartialEq, Eq)]
pub(crate) enum Component {
    Cable,
    Drive,
    Winch,
    MotorEncoder(SensorFailure),
    LoadCell(SensorFailure),
    JointEncoder(SensorFailure),
}

/// What the failing part of a `--fault` was expected to be.
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
        let component = Component::parse(component, mode)?;
        Ok(Self { text: text.to_owned(), component, name: name.to_owned(), start_s, duration_s })
    }
}

impl Component {
    fn parse(name: &str, mode: Option<&str>) -> Result<Self, FaultSyntaxError> {
        let component = match name {
            "cable" => Self::Cable,
            "drive" => Self::Drive,
            "winch" => Self::Winch,
            "motor-encoder" => Self::MotorEncoder(sensor_failure(mode)?),
            "load-cell" => Self::LoadCell(sensor_failure(mode)?),
            "joint-encoder" => Self::JointEncoder(sensor_failure(mode)?),
            _ => {
                let components =
                    "cable, drive, winch, motor-encoder, load-cell or joint-encoder before the first `:`";
                return Err(FaultSyntaxError(components));
            }
        };
        match component {
            Self::Cable | Self::Drive | Self::Winch if mode.is_some() => {
                Err(FaultSyntaxError("no MODE, which only sensors have"))
            }
            _ => Ok(component),
        }
    }
}

fn sensor_failure(mode: Option<&str>) -> Result<SensorFailure, FaultSyntaxError> {
    match mode {
        Some("stuck") => Ok(SensorFailure::Stuck),
        Some("lost") => Ok(SensorFailure::Lost),
        Some("nan") => Ok(SensorFailure::NotANumber),
        _ => Err(FaultSyntaxError("stuck, lost or nan after the name of a sensor's muscle or joint")),
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
    }
}
