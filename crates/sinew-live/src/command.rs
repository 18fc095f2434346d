//! Commands of a page, from the text of a message to validated values.

use serde_json::Value;
use sinew::control::supervisor::Request;

/// What a page asks for.
#[derive(Debug, Clone, PartialEq)]
pub enum Command {
    /// A mode of the supervisor.
    Mode(Request),
    /// Another path, by its name; the simulation begins anew.
    Path(String),
    /// Where the end point is to go, m.
    Drag([f64; 3]),
    /// The end point stays where it is.
    DragEnd,
    /// A force, N, on a point of a body in its own frame, m, for a time, s.
    Push {
        /// Index of the body.
        body: usize,
        /// m, in the frame of the body.
        point: [f64; 3],
        /// N, in the world.
        force: [f64; 3],
        /// How long it lasts, s.
        duration: f64,
    },
    /// A mass at the end point, kg; the simulation begins anew.
    Payload(f64),
    /// A failure, as `--fault` writes it without its time.
    Fault(String),
    /// How fast the time of the source goes, over real time, and whether it stands; none leaves it as it is.
    Speed {
        /// 1, > 0.
        factor: Option<f64>,
        /// It stands.
        paused: Option<bool>,
    },
    /// So many control cycles while time stands.
    Step(u32),
    /// A second machine with another compensation beside the first; none ends it. Both begin anew.
    Compare(Option<String>),
    /// Time of a recording, s.
    Seek(f64),
    /// Another recording over the one that is shown; none takes it away.
    Overlay(Option<String>),
}

/// Longest text of a command, bytes.
pub const MAX_COMMAND: usize = 4096;
/// Largest force of a push, N, and its longest duration, s.
const MAX_FORCE: f64 = 1e4;
const MAX_PUSH: f64 = 60.0;
/// Largest payload, kg.
const MAX_PAYLOAD: f64 = 100.0;
/// Slowest and fastest time.
const SPEEDS: [f64; 2] = [1e-3, 20.0];
/// Most cycles of one step command.
const MAX_CYCLES: u64 = 10_000;
/// Latest time of a recording, s.
const LATEST: f64 = 1e9;
/// Farthest place, m.
const FAR: f64 = 1e3;

impl Command {
    /// The command of a message, with its number, which is that of the answer; the error names the field, its
    /// value and what was expected.
    ///
    /// # Errors
    /// The number, if there was one, and the reason in words.
    pub fn parse(text: &str) -> Result<(Value, Self), (Value, String)> {
        if text.len() > MAX_COMMAND {
            return Err((Value::Null, format!("a command of {} bytes; at most {MAX_COMMAND}", text.len())));
        }
        let message: Value = serde_json::from_str(text)
            .map_err(|error| (Value::Null, format!("the command is no JSON: {error}")))?;
        let id = Some(&message["id"]).filter(|id| id.is_u64()).cloned().unwrap_or(Value::Null);
        match Self::from_message(&message) {
            Ok(command) => Ok((id, command)),
            Err(reason) => Err((id, reason)),
        }
    }

    fn from_message(message: &Value) -> Result<Self, String> {
        let name = text(message, "command")?;
        Ok(match name {
            "mode" => {
                let requested = text(message, "request")?;
                let request = Request::ALL[1..].iter().copied().find(|request| request.name() == requested);
                let known =
                    || Request::ALL[1..].iter().map(|request| request.name()).collect::<Vec<_>>().join(", ");
                Self::Mode(
                    request
                        .ok_or_else(|| format!("request is `{requested}`; expected one of {}", known()))?,
                )
            }
            "path" => Self::Path(text(message, "name")?.to_owned()),
            "drag" => Self::Drag(vector(message, "position", FAR)?),
            "drag_end" => Self::DragEnd,
            "push" => Self::Push {
                body: message["body"]
                    .as_u64()
                    .and_then(|body| usize::try_from(body).ok())
                    .ok_or_else(|| wrong(message, "body", "the index of a body"))?,
                point: vector(message, "point", FAR)?,
                force: vector(message, "force_n", MAX_FORCE)?,
                duration: number(message, "duration_s", [1e-3, MAX_PUSH])?,
            },
            "payload" => Self::Payload(number(message, "mass_kg", [0.0, MAX_PAYLOAD])?),
            "fault" => Self::Fault(text(message, "fault")?.to_owned()),
            "speed" => Self::Speed {
                factor: match &message["factor"] {
                    Value::Null => None,
                    _ => Some(number(message, "factor", SPEEDS)?),
                },
                paused: match &message["paused"] {
                    Value::Null => None,
                    value => Some(value.as_bool().ok_or_else(|| wrong(message, "paused", "true or false"))?),
                },
            },
            "step" => {
                let cycles = match &message["cycles"] {
                    Value::Null => Some(1),
                    value => value.as_u64(),
                };
                let cycles = cycles.filter(|cycles| (1..=MAX_CYCLES).contains(cycles));
                let cycles = cycles.and_then(|cycles| u32::try_from(cycles).ok());
                Self::Step(cycles.ok_or_else(|| wrong(message, "cycles", "a whole number of 1 to 10000"))?)
            }
            "compare" => Self::Compare(text_or_none(message, "variant")?),
            "seek" => Self::Seek(number(message, "time_s", [0.0, LATEST])?),
            "overlay" => Self::Overlay(text_or_none(message, "name")?),
            other => return Err(format!("there is no command `{other}`")),
        })
    }
}

fn wrong(message: &Value, field: &str, expected: &str) -> String {
    format!("{field} is {}; expected {expected}", message[field])
}

fn text<'a>(message: &'a Value, field: &str) -> Result<&'a str, String> {
    message[field].as_str().ok_or_else(|| wrong(message, field, "a text"))
}

fn text_or_none(message: &Value, field: &str) -> Result<Option<String>, String> {
    match &message[field] {
        Value::Null => Ok(None),
        _ => text(message, field).map(|text| Some(text.to_owned())),
    }
}

fn number(message: &Value, field: &str, [low, high]: [f64; 2]) -> Result<f64, String> {
    let number = message[field].as_f64().filter(|number| (low..=high).contains(number));
    number.ok_or_else(|| wrong(message, field, &format!("a number of {low} to {high}")))
}

fn vector(message: &Value, field: &str, most: f64) -> Result<[f64; 3], String> {
    let list = message[field].as_array().filter(|list| list.len() == 3);
    let numbers = list.map(|list| [0, 1, 2].map(|k| list[k].as_f64().unwrap_or(f64::NAN)));
    let numbers = numbers.filter(|numbers| numbers.iter().all(|x| x.abs() <= most));
    numbers.ok_or_else(|| wrong(message, field, &format!("three numbers of at most {most}")))
}

#[cfg(test)]
mod tests {
    use super::*;

    fn command(text: &str) -> Result<Command, String> {
        Command::parse(text).map(|(_, command)| command).map_err(|(_, reason)| reason)
    }

    #[test]
    fn commands_are_read_and_wrong_fields_are_named() {
        assert_eq!(command(r#"{"command":"mode","request":"hold"}"#), Ok(Command::Mode(Request::Hold)));
        assert_eq!(command(r#"{"command":"drag","position":[1,2,3]}"#), Ok(Command::Drag([1.0, 2.0, 3.0])));
        assert_eq!(command(r#"{"command":"step"}"#), Ok(Command::Step(1)));
        assert_eq!(command(r#"{"command":"compare","variant":null}"#), Ok(Command::Compare(None)));
        assert_eq!(command(r#"{"command":"seek","time_s":2}"#), Ok(Command::Seek(2.0)));
        assert_eq!(
            command(r#"{"command":"speed","paused":true}"#),
            Ok(Command::Speed { factor: None, paused: Some(true) })
        );
        for (text, word) in [
            ("", "no JSON"),
            ("[]", "command is null"),
            (r#"{"command":"mode","request":"fly"}"#, "safe_stop"),
            (r#"{"command":"drag","position":[1,2]}"#, "position"),
            (r#"{"command":"drag","position":[1,2,1e999]}"#, "number out of range"),
            (r#"{"command":"mode","request":"none"}"#, "safe_stop"),
            (r#"{"command":"speed","factor":0}"#, "factor is 0"),
            (r#"{"command":"speed","paused":"yes"}"#, "paused is"),
            (r#"{"command":"step","cycles":-1}"#, "cycles is -1"),
            (r#"{"command":"push","body":1.5}"#, "body is 1.5"),
            (r#"{"command":"payload","mass_kg":"1"}"#, "mass_kg"),
            (r#"{"command":"seek","time_s":-1}"#, "time_s is -1"),
            (r#"{"command":"overlay","name":3}"#, "name is 3"),
            (r#"{"command":"sing"}"#, "no command `sing`"),
        ] {
            let reason = command(text).unwrap_err();
            assert!(reason.contains(word), "{text}: {reason}");
        }
        assert!(command(&" ".repeat(MAX_COMMAND + 1)).unwrap_err().contains("at most 4096"));
    }

    #[test]
    fn the_number_of_a_command_is_that_of_its_answer() {
        assert_eq!(Command::parse(r#"{"id":7,"command":"drag_end"}"#).unwrap().0, 7);
        assert_eq!(Command::parse(r#"{"id":8,"command":"?"}"#).unwrap_err().0, 8);
        assert_eq!(Command::parse(r#"{"id":"x","command":"?"}"#).unwrap_err().0, Value::Null);
    }
}
