//! Which cable is meant.

use crate::error::Error;
use sinew::twin::cable::Specimen;

/// `bench`, `ideal` or a number to draw by.
pub(super) fn specimen(name: &str) -> Result<Specimen, Error> {
    match name {
        "bench" => Ok(Specimen::bench()),
        "ideal" => Ok(Specimen::ideal()),
        number => number.parse().map(Specimen::draw).map_err(|_| Error::Argument {
            flag: "--specimen",
            value: name.to_owned(),
            expected: "bench, ideal or a whole number",
        }),
    }
}
