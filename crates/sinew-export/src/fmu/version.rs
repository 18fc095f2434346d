//! Versions of the interface.

/// Version of the interface.
#[derive(Debug, Clone, Copy, PartialEq, Eq)]
pub enum Version {
    /// FMI 2.0.
    Two,
    /// FMI 3.0.
    Three,
}

impl Version {
    /// Stem of the source that implements it.
    pub(super) fn stem(self) -> &'static str {
        match self {
            Self::Two => "fmi2",
            Self::Three => "fmi3",
        }
    }

    /// The source, with the calls that differ from version to version by names alone.
    pub(super) fn template(self) -> String {
        let calls = include_str!("templates/calls.c");
        let (own, calls) = match self {
            Self::Two => (include_str!("templates/fmi2.c"), in_words_of_two(calls)),
            Self::Three => (include_str!("templates/fmi3.c"), calls.to_owned()),
        };
        own.replace("//%include calls\n", &calls)
    }
}

/// Calls of FMI 3.0 by the names that FMI 2.0 has for the same.
fn in_words_of_two(calls: &str) -> String {
    let names = [
        ("fmi3Instance i", "fmi2Component i"),
        ("FMUState", "FMUstate"),
        ("Deserialize", "DeSerialize"),
        ("uint8_t bytes", "char bytes"),
        ("fmi3", "fmi2"),
    ];
    names.into_iter().fold(calls.to_owned(), |text, (three, two)| text.replace(three, two))
}
