//! A fault to inject as people write it: `COMPONENT:NAME[:MODE]@START[+DURATION]`.

use sinew::machine::Machine;
use sinew::twin::arm::{ExchangeFailure, Failure, InjectedFault, Sensor, SensorFailure, Worn};
use std::str::FromStr;

/// A fault to inject, written as `COMPONENT:NAME[:MODE]@START[+DURATION]`, times in s.
///
/// It names a muscle or joint of any machine; [`of`](Self::of) finds it in one. For command lines, pages and
/// scripts; code that knows its muscle's index makes an [`InjectedFault`].
///
/// # Example
/// ```
/// use sinew_lab::arm::WrittenFault;
/// let fault: WrittenFault = "load-cell:triceps:lost@4.5+0.25".parse()?;
/// assert_eq!(fault.start_s(), 4.5);
/// assert!("load-cell:triceps@4.5".parse::<WrittenFault>().is_err());
/// # Ok::<(), sinew_lab::arm::FaultSyntaxError>(())
/// ```
#[derive(Debug, Clone, PartialEq)]
pub struct WrittenFault {
    text: String,
    component: Component,
    /// Name of the muscle or joint; of the failure for `cycles`.
    name: String,
    start_s: f64,
    duration_s: f64,
}

/// The component that fails; sensors with their failure mode.
#[derive(Debug, Clone, Copy, PartialEq)]
enum Component {
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

/// What was expected in place of the part of a fault that cannot be parsed.
#[derive(Debug, Clone, Copy, PartialEq, Eq, thiserror::Error)]
#[error("expected {0}")]
pub struct FaultSyntaxError(&'static str);

/// A name that no part of the machine has, or none of that kind.
#[derive(Debug, Clone, PartialEq, Eq, thiserror::Error)]
#[error("{given}: expected the name of a {kind}: {}", listed(known))]
pub struct UnknownPart {
    /// The name, or what holds it, as it was written.
    pub given: String,
    /// Muscle or joint.
    pub kind: &'static str,
    /// The names of that kind.
    pub known: Vec<String>,
}

/// A fault that begins when the run is over.
#[derive(Debug, Clone, PartialEq, thiserror::Error)]
#[error("{fault}: expected a start before the end of the run, which is at {end_s:.3} s")]
pub struct LateFault {
    /// The fault as it was written.
    pub fault: String,
    /// End of the run with its rests, s.
    pub end_s: f64,
}

fn listed(names: &[String]) -> String {
    if names.is_empty() { "there is none".to_owned() } else { names.join(", ") }
}

impl WrittenFault {
    /// As it was written.
    #[must_use]
    pub fn text(&self) -> &str {
        &self.text
    }

    /// Refuses a fault that would begin when the run is over: nothing would come of it, without a word.
    ///
    /// # Errors
    /// For a start at `end_s` or later, s from the start of the run.
    pub fn begins_before(&self, end_s: f64) -> Result<(), LateFault> {
        if self.start_s < end_s { Ok(()) } else { Err(LateFault { fault: self.text.clone(), end_s }) }
    }

    /// What failed, as a clause in the past tense: `the cable of brachialis broke`; amounts are in the unit
    /// of the sensor.
    #[must_use]
    pub fn words(&self) -> String {
        let name = &self.name;
        let sensor = |what: &str, mode: SensorFailure| format!("the {what} of {name} {}", mode_words(mode));
        let clause = match self.component {
            Component::Cable => format!("the cable of {name} broke"),
            Component::Drive => format!("the drive of {name} had no power"),
            Component::Winch => format!("the winch of {name} jammed"),
            Component::MotorEncoder(mode) => sensor("motor encoder", mode),
            Component::LoadCell(mode) => sensor("load cell", mode),
            Component::JointEncoder(mode) => sensor("encoder", mode),
            Component::Push(torque) => format!("something pushed {name} with {torque} Nm or N"),
            Component::Wear(what, fraction) => {
                let what = match what {
                    Worn::Friction => "the friction grew",
                    Worn::Pretension => "the pretension fell",
                    Worn::Stiffness => "the compliance grew",
                };
                format!("{what} in the cable of {name} by {:.0}\u{202f}%", 100.0 * fraction)
            }
            Component::Exchange(ExchangeFailure::Lost) => "readings and commands were lost".to_owned(),
            Component::Exchange(ExchangeFailure::Late) => "control cycles began too late".to_owned(),
            Component::Exchange(ExchangeFailure::Stale) => "no commands came".to_owned(),
        };
        if self.duration_s.is_finite() { format!("{clause} for {} s", self.duration_s) } else { clause }
    }

    /// Start, s from the start of the run.
    #[must_use]
    pub const fn start_s(&self) -> f64 {
        self.start_s
    }

    /// The fault of the machine's muscle or joint of that name; it lasts indefinitely where no duration is
    /// written.
    ///
    /// # Errors
    /// For a name that no muscle or joint has, or of one without such a sensor.
    pub fn of(&self, machine: &Machine) -> Result<InjectedFault, UnknownPart> {
        let robot = &machine.robot;
        let muscles = || robot.parts().tendons.iter().map(|tendon| tendon.name.clone()).collect();
        let joint =
            |velocity| robot.joint_of_velocity(velocity).map(|k| robot.parts().joints[k].name.clone());
        let joints = || (0..robot.nv()).map(|k| joint(k).unwrap_or_default()).collect();
        let muscle = || self.place("muscle", muscles(), |_| true);
        let failure = match self.component {
            Component::Cable => Failure::Cable(muscle()?),
            Component::Drive => Failure::Amplifier(muscle()?),
            Component::Winch => Failure::Winch(muscle()?),
            Component::MotorEncoder(mode) => Failure::Sensor(Sensor::Motor(muscle()?), mode),
            Component::LoadCell(mode) => {
                let has_cell = |k: usize| machine.muscles[k].drive.has_load_cell;
                let muscle = self.place("muscle with a load cell", muscles(), has_cell)?;
                Failure::Sensor(Sensor::Tension(muscle), mode)
            }
            Component::JointEncoder(mode) => {
                let has_encoder = |k: usize| machine.encoders.get(k).is_some_and(Option::is_some);
                let joint = self.place("joint with an encoder", joints(), has_encoder)?;
                Failure::Sensor(Sensor::Joint(joint), mode)
            }
            Component::Push(torque) => {
                Failure::Push { joint: self.place("joint", joints(), |_| true)?, torque }
            }
            Component::Wear(what, fraction) => Failure::Wear { muscle: muscle()?, what, fraction },
            Component::Exchange(failure) => Failure::Exchange(failure),
        };
        Ok(InjectedFault { start: self.start_s, duration: self.duration_s, failure })
    }

    /// Index of the name among `names`, of which those that `fit` are known.
    fn place(
        &self,
        kind: &'static str,
        names: Vec<String>,
        fits: impl Fn(usize) -> bool,
    ) -> Result<usize, UnknownPart> {
        let place = names.iter().position(|name| *name == self.name).filter(|k| fits(*k));
        place.ok_or_else(|| UnknownPart {
            given: self.text.clone(),
            kind,
            known: names.into_iter().enumerate().filter(|(k, _)| fits(*k)).map(|(_, name)| name).collect(),
        })
    }
}

impl FromStr for WrittenFault {
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

/// What a sensor did.
fn mode_words(mode: SensorFailure) -> String {
    match mode {
        SensorFailure::Stuck => "stuck at its last reading".to_owned(),
        SensorFailure::Lost => "lost its signal".to_owned(),
        SensorFailure::NotANumber => "read no number".to_owned(),
        SensorFailure::Offset(by) => format!("jumped by {by}"),
        SensorFailure::Gain(factor) => format!("read {factor} times the true value"),
        SensorFailure::Drift(rate) => format!("began to drift by {rate} per second"),
        SensorFailure::Saturation(most) => format!("read {most} at most"),
        SensorFailure::Noise(deviation) => format!("got noise of {deviation}"),
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
        let fault: WrittenFault = "load-cell:triceps:lost@4.5+0.25".parse().unwrap();
        assert_eq!(fault.component, Component::LoadCell(SensorFailure::Lost));
        assert_eq!((fault.name.as_str(), fault.start_s, fault.duration_s), ("triceps", 4.5, 0.25));
        let fault: WrittenFault = "cable:triceps@6".parse().unwrap();
        assert!(fault.component == Component::Cable && fault.duration_s.is_infinite());
        let fault: WrittenFault = "joint-encoder:elbow:jump=-0.2@6".parse().unwrap();
        assert_eq!(fault.component, Component::JointEncoder(SensorFailure::Offset(-0.2)));
        let fault: WrittenFault = "friction:triceps:20@0+3600".parse().unwrap();
        assert_eq!(fault.component, Component::Wear(Worn::Friction, 0.2));
        let fault: WrittenFault = "cycles:lost@3+0.01".parse().unwrap();
        assert_eq!(fault.component, Component::Exchange(ExchangeFailure::Lost));
        let fault: WrittenFault = "push:elbow:-4@3+1".parse().unwrap();
        assert_eq!(fault.component, Component::Push(-4.0));
        assert_eq!(fault.words(), "something pushed elbow with -4 Nm or N for 1 s");
        let stuck: WrittenFault = "load-cell:triceps:stuck@6".parse().unwrap();
        assert_eq!(stuck.words(), "the load cell of triceps stuck at its last reading");
        let none = UnknownPart { given: "cable:a@1".to_owned(), kind: "muscle", known: Vec::new() };
        assert_eq!(none.to_string(), "cable:a@1: expected the name of a muscle: there is none");
        for text in ["push:elbow@3", "friction:triceps:120@3", "cycles:gone@3", "cable:triceps:lost@3"] {
            assert!(text.parse::<WrittenFault>().is_err(), "{text}");
        }
    }
}
