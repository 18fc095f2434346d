//! What a verb hands back, and how it is printed: as text, or as one JSON document with the same head for all
//! verbs.

use crate::error::Error;
use crate::output::{Written, print};
use serde::Serialize;
use serde_json::{Map, Value, json};
use std::process::ExitCode;

/// Version of the documents that `--json` prints; docs/json.md describes them.
const SCHEMA_VERSION: u32 = 1;

/// How a run without an error ended.
#[derive(Debug, Clone, Copy, PartialEq, Eq)]
pub(crate) enum Outcome {
    /// As it was asked for.
    AsAsked,
    /// Otherwise: a motion that was stopped or inaccurate, a torque out of reach, no drive that meets a
    /// requirement. All results are written and printed.
    Otherwise,
}

impl Outcome {
    /// As asked where `held`.
    pub(crate) fn new(held: bool) -> Self {
        if held { Self::AsAsked } else { Self::Otherwise }
    }

    fn exit_code(self) -> u8 {
        match self {
            Self::AsAsked => 0,
            Self::Otherwise => Error::NOT_AS_ASKED,
        }
    }
}

/// The result of a verb in the form that was asked for.
#[derive(Debug)]
pub(crate) enum Content {
    /// Whole lines for people.
    Text(String),
    /// The keys of a document.
    Json(Map<String, Value>),
}

impl Content {
    /// The keys of a result that is an object.
    pub(crate) fn json(result: &impl Serialize) -> Result<Self, Error> {
        Ok(match serde_json::to_value(result)? {
            Value::Object(keys) => Self::Json(keys),
            list => Self::Json(Map::from_iter([("results".to_owned(), list)])),
        })
    }
}

/// Result, outcome and files of a verb.
#[derive(Debug)]
pub(crate) struct Answer {
    pub(crate) outcome: Outcome,
    pub(crate) content: Content,
    pub(crate) written: Vec<Written>,
}

impl Answer {
    /// A result as it was asked for.
    pub(crate) fn done(content: Content, written: Vec<Written>) -> Self {
        Self { outcome: Outcome::AsAsked, content, written }
    }

    /// Prints the result and returns the exit code.
    pub(crate) fn print(self, verb: &str) -> Result<ExitCode, Error> {
        let code = self.outcome.exit_code();
        match self.content {
            Content::Text(text) => print(&(text + &self.written.iter().map(line).collect::<String>()))?,
            Content::Json(keys) => {
                let mut document = head(verb, code);
                document.insert("written".to_owned(), self.written.iter().map(entry).collect());
                document.extend(keys);
                print(&(Value::Object(document).to_string() + "\n"))?;
            }
        }
        Ok(ExitCode::from(code))
    }
}

fn line(written: &Written) -> String {
    let replaced = if written.replaced { " (replaced)" } else { "" };
    format!("Written: {}{replaced}\n", written.file.display())
}

fn entry(written: &Written) -> Value {
    json!({"file": written.file.display().to_string(), "replaced": written.replaced})
}

/// Prints the document of a run that ended with an error.
pub(crate) fn print_error(verb: &str, code: u8, message: &str) -> Result<(), Error> {
    let mut document = head(verb, code);
    document.insert("written".to_owned(), json!([]));
    document.insert("error".to_owned(), json!({"message": message}));
    print(&(Value::Object(document).to_string() + "\n"))
}

/// The keys of every document.
fn head(verb: &str, code: u8) -> Map<String, Value> {
    let outcome = match code {
        0 => "done",
        Error::SYSTEM => "system_failed",
        Error::NOT_AS_ASKED => "not_as_asked",
        _ => "bad_input",
    };
    Map::from_iter([
        ("schema_version".to_owned(), json!(SCHEMA_VERSION)),
        ("program".to_owned(), json!(format!("sinew {}", env!("CARGO_PKG_VERSION")))),
        ("verb".to_owned(), json!(verb)),
        ("outcome".to_owned(), json!(outcome)),
        ("exit_code".to_owned(), json!(code)),
    ])
}
