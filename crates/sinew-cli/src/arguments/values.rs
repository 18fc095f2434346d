//! Value parsers: the text of a flag to a value within its domain.

use clap::builder::{PossibleValue, PossibleValuesParser, TypedValueParser};
use clap::error::{ContextKind, ContextValue, ErrorKind};
use clap::{Arg, Command};
use sinew::machine::Workshop;
use sinew::twin::cable::Specimen;
use sinew_lab::CompensationVariant;
use std::ffi::OsStr;
use std::path::PathBuf;

/// A number for which `holds`; `expected` completes the message "expected ...".
pub(super) fn number(
    expected: &'static str,
    holds: fn(f64) -> bool,
) -> impl Fn(&str) -> Result<f64, String> + Clone + Send + Sync + 'static {
    move |text| {
        let value = text.trim().parse().ok().filter(|value: &f64| value.is_finite() && holds(*value));
        value.ok_or_else(|| format!("expected {expected}"))
    }
}

/// One of `variants` by its name.
pub(super) fn compensation(variants: &'static [CompensationVariant]) -> impl TypedValueParser {
    let possible = |variant: &CompensationVariant| PossibleValue::new(variant.name()).help(variant.summary());
    PossibleValuesParser::new(variants.iter().map(possible))
        .try_map(|name| name.parse::<CompensationVariant>())
}

/// A workshop by its name.
pub(super) fn workshop() -> impl TypedValueParser {
    let of =
        |name: &str| Workshop::WORDS.iter().find(|(_, word)| *word == name).map(|(workshop, _)| *workshop);
    PossibleValuesParser::new(Workshop::WORDS.iter().map(|(_, word)| PossibleValue::new(*word)))
        .map(move |name| of(&name).unwrap_or(Workshop::Careful))
}

/// A specimen and what it was called.
#[derive(Debug, Clone)]
pub(crate) struct SpecimenText {
    pub(crate) text: String,
    pub(crate) specimen: Specimen,
}

impl SpecimenText {
    /// Of `bench`, `ideal` or the seed of a random specimen; none of other texts.
    pub(crate) fn new(text: &str) -> Option<Self> {
        let specimen = match text {
            "bench" => Specimen::bench(),
            "ideal" => Specimen::ideal(),
            seed => Specimen::draw(seed.parse().ok()?),
        };
        Some(Self { text: text.to_owned(), specimen })
    }
}

/// Parses `bench`, `ideal` or the seed of a random specimen.
#[derive(Debug, Clone)]
pub(crate) struct SpecimenParser;

impl TypedValueParser for SpecimenParser {
    type Value = SpecimenText;

    fn parse_ref(
        &self,
        command: &Command,
        arg: Option<&Arg>,
        value: &OsStr,
    ) -> Result<SpecimenText, clap::Error> {
        let valid = ["bench", "ideal", "N"];
        value.to_str().and_then(SpecimenText::new).ok_or_else(|| invalid_value(command, arg, value, &valid))
    }

    fn possible_values(&self) -> Option<Box<dyn Iterator<Item = PossibleValue> + '_>> {
        Some(Box::new(
            [
                PossibleValue::new("bench").help("parameters calibrated to the paper's tables"),
                PossibleValue::new("ideal").help("without the effects that no identified model contains"),
            ]
            .into_iter(),
        ))
    }
}

/// clap's own error for a value that is none of the valid ones.
pub(super) fn invalid_value(
    command: &Command,
    arg: Option<&Arg>,
    value: &OsStr,
    valid: &[&str],
) -> clap::Error {
    let mut error = clap::Error::new(ErrorKind::InvalidValue).with_cmd(command);
    let name = arg.map_or_else(|| "...".to_owned(), ToString::to_string);
    let valid = valid.iter().map(ToString::to_string).collect();
    error.insert(ContextKind::InvalidArg, ContextValue::String(name));
    error.insert(ContextKind::InvalidValue, ContextValue::String(value.to_string_lossy().into_owned()));
    error.insert(ContextKind::ValidValue, ContextValue::Strings(valid));
    error
}
/// Endings of pictures of other forms than SVG.
const OTHER_PICTURES: [&str; 12] =
    ["pdf", "png", "jpg", "jpeg", "gif", "webp", "eps", "ps", "tif", "tiff", "bmp", "emf"];

/// A file of a picture, which is SVG; a name that promises another form is refused.
pub(crate) fn svg(text: &str) -> Result<PathBuf, String> {
    let path = PathBuf::from(text);
    let ending = path.extension().map(|ending| ending.to_string_lossy().to_ascii_lowercase());
    match ending.filter(|ending| OTHER_PICTURES.contains(&ending.as_str())) {
        Some(_) => Err("pictures are written as SVG only; expected a name that ends in .svg".to_owned()),
        None => Ok(path),
    }
}

#[cfg(test)]
mod tests {
    use super::*;

    #[test]
    fn the_name_of_a_picture_does_not_promise_another_form() {
        for name in ["x.svg", "x.SVG", "/dev/stdout"] {
            assert_eq!(svg(name), Ok(PathBuf::from(name)));
        }
        for name in ["x.pdf", "x.PNG", "a/b.eps"] {
            assert!(svg(name).is_err_and(|error| error.contains(".svg")), "{name}");
        }
    }
}
