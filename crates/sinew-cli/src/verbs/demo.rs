//! `sinew demo`.

use crate::arguments::DemoArguments;
use crate::error::Error;

pub(crate) fn run(_arguments: &DemoArguments) -> Result<(), Error> {
    Err(Error::Nothing("not there yet".into()))
}
