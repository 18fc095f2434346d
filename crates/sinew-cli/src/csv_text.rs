//! CSV as text: names are quoted where they contain a separator, a quote or a line break.

use crate::error::Error;

/// A table under construction.
pub(crate) struct Csv {
    writer: csv::Writer<Vec<u8>>,
}

impl Csv {
    pub(crate) fn new() -> Self {
        Self { writer: csv::Writer::from_writer(Vec::new()) }
    }

    /// One more row, as long as those before.
    pub(crate) fn row<I, C>(&mut self, cells: I) -> Result<(), Error>
    where
        I: IntoIterator<Item = C>,
        C: AsRef<[u8]>,
    {
        Ok(self.writer.write_record(cells)?)
    }

    /// All rows, a line each.
    pub(crate) fn text(self) -> Result<String, Error> {
        let bytes = self.writer.into_inner().map_err(|error| csv::Error::from(error.into_error()))?;
        Ok(String::from_utf8_lossy(&bytes).into_owned())
    }
}
