//! The key file of a link.

use crate::error::Error;
use sinew_link::Key;
use std::path::Path;

/// The key of a file, if one is given.
pub(crate) fn read_key(file: Option<&Path>) -> Result<Option<Key>, Error> {
    Ok(file.map(Key::read).transpose().map_err(sinew_link::Error::from)?)
}
